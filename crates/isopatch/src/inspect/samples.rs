//! Bézier patches at parameters that are the same for all of them: basis values are computed once.

use crate::bernstein::triangle;
use crate::geom::{Point3, Points, PointsMut};
use crate::surface::{PatchForm, PatchId, Surface};

/// Degree and control net of a patch; for a patch without one, a net of NaN, whose figures come out as infinite.
pub(super) fn net(surface: &dyn Surface, patch: PatchId) -> (usize, &[Point3]) {
    match surface.form(patch) {
        PatchForm::BezierTriangle { degree, net } => (degree, net),
        PatchForm::APatch => (1, &NO_NET),
    }
}

/// A net of degree 1 that is nowhere.
static NO_NET: [Point3; 3] = [Point3::new(f64::NAN, f64::NAN, f64::NAN); 3];

/// Bernstein polynomials of one degree and their derivatives, one row of samples a control point.
struct Basis {
    degree: usize,
    point: Vec<f64>,
    du: Vec<f64>,
    dv: Vec<f64>,
}

impl Basis {
    fn new(degree: usize, parameters: &[[f64; 3]]) -> Self {
        let rows = |basis: &dyn Fn([f64; 3]) -> Vec<f64>| transposed(parameters.iter().map(|p| basis(*p)));
        Self {
            degree,
            point: rows(&|p| triangle::basis(degree, p)),
            du: rows(&|p| triangle::derivative_basis(degree, p, [1.0, 0.0, -1.0])),
            dv: rows(&|p| triangle::derivative_basis(degree, p, [0.0, 1.0, -1.0])),
        }
    }
}

/// The columns of a matrix that is given by its rows, one after the other.
fn transposed(rows: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let rows: Vec<_> = rows.collect();
    let width = rows.first().map_or(0, Vec::len);
    (0..width).flat_map(|c| rows.iter().map(move |row| row[c])).collect()
}

/// A fixed set of parameters, with tables for every degree that occurs in a surface.
pub(super) struct SampleSet {
    count: usize,
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
        let mut degrees: Vec<usize> = surface.patches().map(|p| net(surface, p).0).collect();
        degrees.sort_unstable();
        degrees.dedup();
        let tables = degrees.into_iter().map(|n| Basis::new(n, parameters)).collect();
        Self { count: parameters.len(), tables }
    }

    /// Number of samples of a patch.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Samples of the given patches.
    pub fn sample(&self, surface: &dyn Surface, patches: &[PatchId]) -> PatchSamples {
        let zeros = || Points::zeros(patches.len() * self.count);
        let mut samples = PatchSamples { points: zeros(), du: zeros(), dv: zeros() };
        for (i, patch) in patches.iter().enumerate() {
            let (degree, net) = net(surface, *patch);
            let Some(basis) = self.tables.iter().find(|t| t.degree == degree) else { continue };
            let range = i * self.count..(i + 1) * self.count;
            for (out, table) in [
                (&mut samples.points, &basis.point),
                (&mut samples.du, &basis.du),
                (&mut samples.dv, &basis.dv),
            ] {
                let (x, y, z) =
                    (&mut out.x[range.clone()], &mut out.y[range.clone()], &mut out.z[range.clone()]);
                combine(table, net, PointsMut { x, y, z });
            }
        }
        samples
    }
}

/// out_s = Σ_c table_cs net_c, one coordinate after the other so that each is a plain sum of rows.
fn combine(table: &[f64], net: &[Point3], out: PointsMut<'_>) {
    for (axis, out) in [out.x, out.y, out.z].into_iter().enumerate() {
        for (row, b) in table.chunks_exact(out.len()).zip(net) {
            let b = b[axis];
            out.iter_mut().zip(row).for_each(|(out, weight)| *out += weight * b);
        }
    }
}
