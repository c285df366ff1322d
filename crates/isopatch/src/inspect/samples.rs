//! Patches at parameters that are the same for all of them: for polynomial ones, basis values are computed once.

use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points, PointsMut, Vec3};
use crate::surface::{PatchForm, PatchId, Sample, Surface};

/// Degree and control net of a patch that is a polynomial; the others are asked for their samples one by one.
pub(super) fn net(surface: &dyn Surface, patch: PatchId) -> Option<(usize, &[Point3])> {
    match surface.form(patch) {
        PatchForm::BezierTriangle { degree, net } => Some((degree, net)),
        PatchForm::RationalTriangle { .. } | PatchForm::APatch => None,
    }
}

/// Samples whose sums are formed together: as many as fit into the registers, three coordinates each.
const LANES: usize = 4;

/// Weights of the points of a net in all samples, by blocks of samples, and in a block by points of the net.
struct Weights {
    points: usize,
    blocks: Vec<[f64; LANES]>,
}

impl Weights {
    /// One row of `basis` a sample; samples that are missing in the last block have no weights.
    fn new(points: usize, parameters: &[[f64; 3]], basis: impl Fn([f64; 3]) -> Vec<f64>) -> Self {
        let mut blocks = Vec::with_capacity(parameters.len().div_ceil(LANES) * points);
        for block in parameters.chunks(LANES) {
            let rows: Vec<Vec<f64>> = block.iter().map(|p| basis(*p)).collect();
            let weight = |c: usize, lane: usize| rows.get(lane).map_or(0.0, |row| row[c]);
            blocks.extend((0..points).map(|c| std::array::from_fn(|lane| weight(c, lane))));
        }
        Self { points, blocks }
    }

    /// out_s = Σ_c weight_sc net_c.
    fn combine(&self, net: &[Point3], out: PointsMut<'_>) {
        let lanes = out.x.chunks_mut(LANES).zip(out.y.chunks_mut(LANES)).zip(out.z.chunks_mut(LANES));
        for (rows, ((x, y), z)) in self.blocks.chunks_exact(self.points).zip(lanes) {
            let mut sums = [[0.0; LANES]; 3];
            for (row, b) in rows.iter().zip(net) {
                for (axis, sum) in sums.iter_mut().enumerate() {
                    sum.iter_mut().zip(row).for_each(|(sum, weight)| *sum += weight * b[axis]);
                }
            }
            for (out, sum) in [x, y, z].into_iter().zip(&sums) {
                out.copy_from_slice(&sum[..out.len()]);
            }
        }
    }
}

/// Bernstein polynomials of one degree, and of one degree less for the derivatives.
struct Basis {
    degree: usize,
    point: Weights,
    derivative: Weights,
}

impl Basis {
    fn new(degree: usize, parameters: &[[f64; 3]]) -> Self {
        let weights = |n: usize| Weights::new(index::count(n), parameters, |p| triangle::basis(n, p));
        Self { degree, point: weights(degree), derivative: weights(degree - 1) }
    }
}

/// Net of the derivative by coordinate `axis` against the last one: n (b_{+axis} − b_{+2}), of one degree less.
fn derivative_net(degree: usize, net: &[Point3], axis: usize, out: &mut Vec<Point3>) {
    out.clear();
    out.extend(index::indices(degree - 1).map(|ijk| {
        let raised = |c: usize| {
            let mut ijk = ijk;
            ijk[c] += 1;
            net[index::position(ijk)]
        };
        degree as f64 * (raised(axis) - raised(2))
    }));
}

/// A fixed set of parameters, with tables for every degree that occurs in a surface.
pub(super) struct SampleSet {
    parameters: Vec<[f64; 2]>,
    tables: Vec<Basis>,
}

/// Positions and derivatives of the samples of some patches, patch after patch.
pub(super) struct PatchSamples {
    pub points: Points,
    pub du: Points,
    pub dv: Points,
}

impl SampleSet {
    /// Tables for the barycentric `parameters`.
    pub fn new(surface: &dyn Surface, parameters: &[[f64; 3]]) -> Self {
        let mut degrees: Vec<usize> = surface.patches().filter_map(|p| Some(net(surface, p)?.0)).collect();
        degrees.sort_unstable();
        degrees.dedup();
        let tables = degrees.into_iter().map(|n| Basis::new(n, parameters)).collect();
        Self { parameters: parameters.iter().map(|[u, v, _]| [*u, *v]).collect(), tables }
    }

    /// Number of samples of a patch.
    pub fn count(&self) -> usize {
        self.parameters.len()
    }

    /// Positions only.
    pub fn points(&self, surface: &dyn Surface, patches: &[PatchId]) -> Points {
        let count = self.count();
        let mut points = Points::zeros(patches.len() * count);
        for (i, patch) in patches.iter().enumerate() {
            match net(surface, *patch) {
                Some((degree, net)) => {
                    let Some(basis) = self.tables.iter().find(|t| t.degree == degree) else { continue };
                    basis.point.combine(net, points.slice_mut(i * count..(i + 1) * count));
                }
                None => {
                    for (s, sample) in self.sampled(surface, *patch).iter().enumerate() {
                        points.set(i * count + s, sample.point);
                    }
                }
            }
        }
        points
    }

    /// Samples of the given patches.
    pub fn sample(&self, surface: &dyn Surface, patches: &[PatchId]) -> PatchSamples {
        let count = self.count();
        let zeros = || Points::zeros(patches.len() * count);
        let mut samples = PatchSamples { points: zeros(), du: zeros(), dv: zeros() };
        let mut derivative = Vec::new();
        for (i, patch) in patches.iter().enumerate() {
            let Some((degree, net)) = net(surface, *patch) else {
                for (s, sample) in self.sampled(surface, *patch).iter().enumerate() {
                    samples.points.set(i * count + s, sample.point);
                    samples.du.set(i * count + s, sample.du);
                    samples.dv.set(i * count + s, sample.dv);
                }
                continue;
            };
            let Some(basis) = self.tables.iter().find(|t| t.degree == degree) else { continue };
            let range = i * count..(i + 1) * count;
            basis.point.combine(net, samples.points.slice_mut(range.clone()));
            for (axis, out) in [&mut samples.du, &mut samples.dv].into_iter().enumerate() {
                derivative_net(degree, net, axis, &mut derivative);
                basis.derivative.combine(&derivative, out.slice_mut(range.clone()));
            }
        }
        samples
    }

    /// The samples of a patch that is no polynomial.
    fn sampled(&self, surface: &dyn Surface, patch: PatchId) -> Vec<Sample> {
        let nan = Vec3::repeat(f64::NAN);
        let mut samples = vec![Sample { point: nan, normal: nan, du: nan, dv: nan }; self.count()];
        surface.sample_batch(patch, &self.parameters, &mut samples);
        samples
    }
}
