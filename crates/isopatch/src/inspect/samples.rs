//! Patches at parameters that are the same for all of them: for polynomial ones, basis values are computed once.

use crate::bernstein::lanes::{TangentsMut, TriangleGrid};
use crate::bernstein::triangle::MAX_DEGREE;
use crate::geom::{Point3, Points, Vec3};
use crate::surface::{PatchForm, PatchId, Sample, Surface};

/// Degree and control net of a patch that is a polynomial of a degree up to [`MAX_DEGREE`]; the others are asked for their samples one by one.
pub(super) fn net(surface: &dyn Surface, patch: PatchId) -> Option<(usize, &[Point3])> {
    match surface.form(patch) {
        PatchForm::BezierTriangle { degree, net } if degree <= MAX_DEGREE => Some((degree, net)),
        PatchForm::BezierTriangle { .. } | PatchForm::RationalTriangle { .. } | PatchForm::APatch => None,
    }
}

/// A fixed set of parameters, with tables for every degree that occurs in a surface.
pub(super) struct SampleSet {
    parameters: Vec<[f64; 2]>,
    grids: Vec<TriangleGrid>,
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
        let grids = degrees.into_iter().map(|n| TriangleGrid::new(n, parameters)).collect();
        Self { parameters: parameters.iter().map(|[u, v, _]| [*u, *v]).collect(), grids }
    }

    /// Number of samples of a patch.
    pub fn count(&self) -> usize {
        self.parameters.len()
    }

    fn grid(&self, degree: usize) -> Option<&TriangleGrid> {
        self.grids.iter().find(|grid| grid.degree() == degree)
    }

    /// Positions only.
    pub fn points(&self, surface: &dyn Surface, patches: &[PatchId]) -> Points {
        let count = self.count();
        let mut points = Points::zeros(patches.len() * count);
        for (i, patch) in patches.iter().enumerate() {
            match net(surface, *patch) {
                Some((degree, net)) => {
                    let Some(grid) = self.grid(degree) else { continue };
                    let points = points.slice_mut(i * count..(i + 1) * count);
                    grid.evaluate(net, TangentsMut { points, derivatives: None, normals: None });
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
        for (i, patch) in patches.iter().enumerate() {
            let Some((degree, net)) = net(surface, *patch) else {
                for (s, sample) in self.sampled(surface, *patch).iter().enumerate() {
                    samples.points.set(i * count + s, sample.point);
                    samples.du.set(i * count + s, sample.du);
                    samples.dv.set(i * count + s, sample.dv);
                }
                continue;
            };
            let Some(grid) = self.grid(degree) else { continue };
            let range = i * count..(i + 1) * count;
            let PatchSamples { points, du, dv } = &mut samples;
            let points = points.slice_mut(range.clone());
            let derivatives = Some([du, dv].map(|d| d.slice_mut(range.clone())));
            grid.evaluate(net, TangentsMut { points, derivatives, normals: None });
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
