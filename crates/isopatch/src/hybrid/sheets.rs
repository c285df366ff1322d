//! Where a ray meets the surface never, or more than once; and other free parameters there.

use super::face::{FaceCells, Foot};
use super::function::HybridFunction;
use super::hull::{Sheets, enforce, raised};
use crate::apatch::{Base, side_of};
use crate::bernstein::triangle;
use crate::hull::Class;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Intervals of the lattices of rays that are looked at, over a face or a sector of it, and along and across an edge.
const RAYS: usize = 8;

/// Rounds of other parameters. What they can mend is after the second.
const ROUNDS: usize = 3;

/// Layers below this part of the largest one are zero: rounding of their sums.
const ZERO: f64 = 1e-13;

/// Faces with a ray over them, or over one of their edges, that does not meet the surface once; in order.
///
/// Measured on lattices of rays: 8 intervals a patch.
pub fn broken_faces(function: &HybridFunction) -> Vec<FaceId> {
    let all: Vec<FaceId> = function.hull().data.mesh().faces().collect();
    broken_near(function, &all)
}

/// The same of rays over some faces and over their edges alone.
fn broken_near(function: &HybridFunction, near: &[FaceId]) -> Vec<FaceId> {
    let mesh = function.hull().data.mesh();
    let over = |f: &FaceId| {
        let bad = |h: &HalfEdgeId| {
            let e = mesh.edge(*h);
            function.has_edge_patch(e) && edge_breaks(function, e)
        };
        let mut found: Vec<FaceId> =
            mesh.face_half_edges(*f).filter(bad).filter_map(|h| mesh.twin(h)).map(|h| mesh.face(h)).collect();
        if !found.is_empty() || face_breaks(function, *f) {
            found.push(*f);
        }
        found
    };
    let mut faces: Vec<FaceId> = near.par_iter().evenly().flat_map_iter(over).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Edges with a ray over them that does not meet the surface once; in order.
pub fn broken_edges(function: &HybridFunction) -> Vec<EdgeId> {
    let edges = (0..function.hull().edges.len()).into_par_iter().evenly().map(EdgeId::from);
    edges.filter(|e| function.has_edge_patch(*e) && edge_breaks(function, *e)).collect()
}

/// The same function, with free parameters that are moved at [broken faces](broken_faces), then with apexes at other heights there,
/// if [`Sheets`] allows it; and the faces that stay broken.
pub fn mended(function: HybridFunction, sheets: Sheets) -> (HybridFunction, Vec<FaceId>) {
    let mut broken = broken_faces(&function);
    if sheets == Sheets::Nowhere {
        return (function, broken);
    }
    let mut best = function;
    let mut tried: Vec<FaceId> = Vec::new();
    for _ in 0..ROUNDS {
        tried.extend(&broken);
        tried.sort_unstable();
        tried.dedup();
        if broken.is_empty() {
            break;
        }
        let mut hull = best.hull().clone();
        enforce(&mut hull, &tried);
        let other = HybridFunction::new(hull);
        let left = broken_near(&other, &tried);
        if left.len() >= broken.len() && left != broken {
            break;
        }
        let is_done = left == broken;
        (best, broken) = (other, left);
        if is_done {
            break;
        }
    }
    for factor in HEIGHTS {
        if broken.is_empty() {
            break;
        }
        let mut hull = raised(best.hull(), &broken, factor);
        enforce(&mut hull, &broken);
        let other = HybridFunction::new(hull);
        let left = broken_near(&other, &broken);
        if left.len() < broken.len() {
            (best, broken) = (other, left);
        }
    }
    (best, broken)
}

/// Where other parameters do not help, apexes are tried at these multiples of their heights.
const HEIGHTS: [f64; 5] = [1.6, 2.5, 4.0, 0.7, 0.5];

fn face_breaks(function: &HybridFunction, f: FaceId) -> bool {
    let cells = &function.faces()[f.index()];
    let class = function.hull().faces[f.index()].class;
    let breaks = |foot: Foot| !cells.layers(class, foot).is_some_and(|(_, layers)| meets_once(&layers));
    let share = |i: usize| i as f64 / RAYS as f64;
    match cells {
        FaceCells::Flat(_) => false,
        FaceCells::Triangle { .. } => triangle::lattice(RAYS).into_iter().any(|x| breaks(Foot::Triangle(x))),
        FaceCells::Pyramid(_) => {
            (0..=RAYS).any(|i| (0..=RAYS).any(|j| breaks(Foot::Pyramid([share(i), share(j)]))))
        }
        FaceCells::Sectors(sectors) => (0..sectors.base.len())
            .any(|k| triangle::lattice(RAYS).into_iter().any(|x| breaks(Foot::Sector(k, x)))),
    }
}

fn edge_breaks(function: &HybridFunction, e: EdgeId) -> bool {
    let class = function.hull().edges[e.index()].class;
    let share = |i: usize| i as f64 / RAYS as f64;
    (0..=RAYS).any(|i| {
        let (x, z) = (share(RAYS - i), share(i));
        let side = side_of(class, Base::on_edge(function.on_edge(e), x, z));
        // The ends are vertices: the rays of faces begin there as well.
        let Some(cell) = function.edge_function(e, side) else {
            return class == Class::Nonconvex && 0 < i && i < RAYS;
        };
        (0..=RAYS).any(|j| !meets_once(&cell.layers(x, z, share(j))))
    })
}

/// Has the cubic with these Bernstein coefficients, not positive at 0, one simple root in [0, 1)?
fn meets_once(layers: &[f64; 4]) -> bool {
    let largest = layers.iter().fold(0.0f64, |most, b| most.max(b.abs()));
    let [b0, b1, b2, b3] = layers.map(|b| if b.abs() <= ZERO * largest { 0.0 } else { b });
    if !largest.is_finite() || b3 <= 0.0 || b0 > 0.0 {
        return false;
    }
    if b0 == 0.0 && b1 <= 0.0 {
        return false;
    }
    // Between its extrema the cubic is monotonic.
    let (d0, d1, d2) = (b1 - b0, b2 - b1, b3 - b2);
    let value = |t: f64| {
        let r = 1.0 - t;
        r * r * r * b0 + 3.0 * r * t * (r * b1 + t * b2) + t * t * t * b3
    };
    let (a, b, c) = (d0 - 2.0 * d1 + d2, d1 - d0, d0);
    let root = (b * b - a * c).max(0.0).sqrt();
    let extrema = [(-b - root) / a, (-b + root) / a, -0.5 * c / b];
    let mut stops: Vec<f64> = extrema.into_iter().filter(|t| *t > 0.0 && *t < 1.0).collect();
    stops.sort_by(f64::total_cmp);
    let signs = stops.into_iter().map(value).chain([b3]);
    let mut rises = 0;
    let mut below = true;
    for v in signs {
        if (v > ZERO * largest) == below {
            below = !below;
            rises += 1;
        }
    }
    rises == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_roots_are_told_from_none_and_three() {
        assert!(meets_once(&[-1.0, -1.0, 1.0, 1.0]));
        assert!(meets_once(&[-1.0, 2.0, -0.1, 1.0]));
        assert!(!meets_once(&[-1.0, 9.0, -9.0, 1.0]));
        assert!(!meets_once(&[-1.0, -1.0, -1.0, -1.0]));
        // A vertex: the surface goes up from there, or it does not.
        assert!(meets_once(&[0.0, 1.0, 1.0, 2.0]));
        assert!(!meets_once(&[0.0, -1.0, 1.0, 2.0]));
        assert!(!meets_once(&[0.0, 1.0, -5.0, 2.0]));
    }
}
