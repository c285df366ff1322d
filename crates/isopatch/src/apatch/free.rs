//! Free parameters: the values at the apexes.

use super::quadric::CellQuadric;
use crate::bernstein::tetrahedron::quadratic;
use crate::geom::{Mat3, Point3, Vec3};
use crate::hull::{Hull, Side};
use crate::mesh::{FaceId, HalfEdgeId};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Where default values come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FreeRule {
    /// From the positions and gradients at the far corners of the neighbours: exact for quadrics.
    #[default]
    Neighbour,
    /// The paper's step 8: the linear function nearest to the quadric of the face. Exact for planes only.
    Linear,
}

/// Values for the free parameters: of the function times the sign of the side, at the apexes of each face.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Free {
    /// Those of the [`FreeRule`], raised where needed to the bound that is sufficient for one simple root on every ray.
    #[default]
    Default,
    /// The same everywhere. Larger values pull the surface towards the mesh, smaller ones let it bulge; below the sufficient
    /// bound it may break.
    Global(f64),
    /// One for the outer and one for the inner side of every face of the mesh that the hull was built for; not finite where the
    /// default is wanted.
    PerFace(Vec<[f64; 2]>),
}

/// With less weight on the unknown coefficient (relative to 1 for a neighbour across a right angle) the far corners are
/// all in the plane of the face and say nothing.
const UNDETERMINED: f64 = 1e-6;

/// How far values may travel from faces that have one to faces in flat surroundings.
const SPREADING_ROUNDS: usize = 10;

/// Default values on one side; 0 where there is no cell.
pub(super) fn defaults(
    hull: &Hull,
    side: Side,
    quadrics: &[Option<CellQuadric>],
    rule: FreeRule,
) -> Vec<f64> {
    let linear = |q: &Option<CellQuadric>| q.map_or(0.0, |q| q.linear);
    if rule == FreeRule::Linear {
        return quadrics.iter().map(linear).collect();
    }
    let mut values: Vec<Option<f64>> = quadrics
        .par_iter()
        .evenly()
        .enumerate()
        .map(|(f, q)| from_neighbours(hull, side, f.into(), q.as_ref()?))
        .collect();
    for _ in 0..SPREADING_ROUNDS {
        let spread: Vec<(usize, f64)> = (0..values.len())
            .into_par_iter()
            .evenly()
            .filter(|f| values[*f].is_none() && quadrics[*f].is_some())
            .filter_map(|f| Some((f, mean_of_neighbours(hull, side, f.into(), quadrics, &values)?)))
            .collect();
        if spread.is_empty() {
            break;
        }
        spread.into_iter().for_each(|(f, value)| values[f] = Some(value));
    }
    values.into_iter().zip(quadrics).map(|(value, q)| value.unwrap_or_else(|| linear(q))).collect()
}

/// Barycentric coordinates in a cell.
struct CellFrame {
    origin: Point3,
    inverse: Mat3,
}

impl CellFrame {
    fn new(hull: &Hull, side: Side, f: FaceId) -> Option<Self> {
        let [a, b, c] = hull.data().corners(f);
        let apex = hull.faces()[f.index()].apexes[side.index()]?;
        let inverse = Mat3::from_columns(&[b - a, c - a, apex - a]).try_inverse()?;
        Some(Self { origin: a, inverse })
    }

    fn coordinates(&self, x: &Point3) -> [f64; 4] {
        let r = self.inverse * (x - self.origin);
        [1.0 - r.sum(), r.x, r.y, r.z]
    }

    /// Gradient of a function by its derivatives by the coordinates.
    fn gradient(&self, d: [f64; 4]) -> Vec3 {
        self.inverse.tr_mul(&Vec3::new(d[1] - d[0], d[2] - d[0], d[3] - d[0]))
    }
}

fn twins(hull: &Hull, f: FaceId) -> impl Iterator<Item = HalfEdgeId> + '_ {
    let mesh = hull.data().mesh();
    mesh.face_half_edges(f).filter_map(move |h| {
        let [first, second] = hull.data().joint(mesh.edge(h))?;
        Some(if first == h { second } else { first })
    })
}

/// The c for which Q + c w² comes closest to value 0 and the gradient at the far corners of the neighbours; gradients count
/// with the height of the apex as the length. Q is the quadric of the face, w the coordinate of the apex.
fn from_neighbours(hull: &Hull, side: Side, f: FaceId, q: &CellQuadric) -> Option<f64> {
    let mesh = hull.data().mesh();
    let cell = CellFrame::new(hull, side, f)?;
    let face = hull.face_frame(f);
    let apex = hull.faces()[f.index()].apexes[side.index()]?;
    let height_squared = (apex - face.c).dot(&face.normal).powi(2);
    let grad_w = cell.gradient([0.0, 0.0, 0.0, 1.0]);
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for g in twins(hull, f) {
        let corner = mesh.prev(g);
        let x = cell.coordinates(&hull.data().positions()[mesh.origin(corner).index()]);
        let (value, d) = quadratic(&q.net, x);
        let residual = cell.gradient(d) - side.sign() * hull.data().gradient(corner);
        let (w_squared, grad_w_squared) = (x[3] * x[3], 2.0 * x[3] * grad_w);
        numerator -= w_squared * value + height_squared * residual.dot(&grad_w_squared);
        denominator += w_squared * w_squared + height_squared * grad_w_squared.norm_squared();
    }
    (denominator > UNDETERMINED).then(|| numerator / denominator)
}

/// Mean over the neighbours that have a value of what their quadrics are at the apex of the face.
fn mean_of_neighbours(
    hull: &Hull,
    side: Side,
    f: FaceId,
    quadrics: &[Option<CellQuadric>],
    values: &[Option<f64>],
) -> Option<f64> {
    let apex = hull.faces()[f.index()].apexes[side.index()]?;
    let (mut sum, mut count) = (0.0, 0.0);
    for g in twins(hull, f).map(|h| hull.data().mesh().face(h)) {
        if let (Some(q), Some(b), Some(cell)) =
            (&quadrics[g.index()], values[g.index()], CellFrame::new(hull, side, g))
        {
            let mut net = q.net;
            net[9] = b;
            sum += quadratic(&net, cell.coordinates(&apex)).0;
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}
