//! Lines and translucent faces that explain how a surface was made.

use super::{Color, Veil};
use crate::bernstein::index;
use crate::geom::{Aabb, Point3};
use crate::hull::{Hull, Side};
use crate::hybrid::HybridHull;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};
use crate::surface::{PatchForm, Surface};
use crate::tessellate::Tessellation;
use std::collections::BTreeSet;

/// The control nets of all patches: lines, and control points as lines without length; none if a patch has no net.
pub(super) fn nets(surface: &dyn Surface) -> Option<[Vec<[Point3; 2]>; 2]> {
    let (mut lines, mut points) = (Vec::new(), Vec::new());
    for patch in surface.patches() {
        let PatchForm::BezierTriangle { degree, net } = surface.form(patch) else { return None };
        let at = |ijk| net[index::position(ijk)];
        for [i, j, k] in index::indices(degree.checked_sub(1)?) {
            let [a, b, c] = [at([i + 1, j, k]), at([i, j + 1, k]), at([i, j, k + 1])];
            lines.extend([[a, b], [b, c], [c, a]]);
        }
        points.extend(net.iter().map(|p| [*p, *p]));
    }
    Some([lines, points])
}

/// How much of what is behind the side of a cell is lost.
const OPACITY: f32 = 0.17;

/// What is drawn of a hull.
type Drawn = (Vec<Veil>, Vec<[Point3; 2]>);

/// The cells of a hull: the sides that are not between two of its own, and all edges.
pub(super) fn cells(hull: &Hull, colors: [Color; 2]) -> Drawn {
    let data = hull.data();
    let has_cell = |e: EdgeId, side: Side| hull.edges()[e.index()].cells[side.index()].is_some();
    let apexes = |e: EdgeId, side: Side| hull.edge_apexes(e, side).filter(|_| has_cell(e, side));
    drawn(data.mesh(), data.positions(), &|f| hull.faces()[f.index()].apexes, &apexes, colors)
}

/// The same of a hull over polygons.
pub(super) fn polygon_cells(hull: &HybridHull, colors: [Color; 2]) -> Drawn {
    let mesh = hull.data.mesh();
    let apexes = |e: EdgeId, side: Side| {
        let [h, g] = hull.data.joint(e).filter(|_| hull.edges[e.index()].cells[side.index()])?;
        let of = |h: HalfEdgeId| hull.faces[mesh.face(h).index()].apexes[side.index()];
        Some([of(h)?, of(g)?])
    };
    drawn(mesh, hull.data.positions(), &|f| hull.faces[f.index()].apexes, &apexes, colors)
}

/// `over_face` are the apexes of a face, `over_edge` those of the cell of an edge, on the left and on the right.
fn drawn(
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
    over_face: &dyn Fn(FaceId) -> [Option<Point3>; 2],
    over_edge: &dyn Fn(EdgeId, Side) -> Option<[Point3; 2]>,
    colors: [Color; 2],
) -> Drawn {
    let (mut veils, mut lines) = (Vec::new(), Vec::new());
    let mut add = |corners: [Point3; 3], side: Side| {
        veils.push(Veil { corners, color: colors[side.index()], opacity: OPACITY });
    };
    let ends = |h: HalfEdgeId| [mesh.origin(h), mesh.dest(h)].map(|v| positions[v.index()]);
    for f in mesh.faces() {
        for side in Side::BOTH {
            let Some(apex) = over_face(f)[side.index()] else { continue };
            for h in mesh.face_half_edges(f) {
                let [p, q] = ends(h);
                lines.push([p, apex]);
                // Sides to cells of edges are inside of the hull.
                if over_edge(mesh.edge(h), side).is_none() {
                    add([p, q, apex], side);
                }
            }
        }
    }
    for e in mesh.edges() {
        let ends = ends(mesh.edge_half_edge(e));
        lines.push(ends);
        for side in Side::BOTH {
            if let Some([left, right]) = over_edge(e, side) {
                lines.push([left, right]);
                ends.into_iter().for_each(|p| add([left, right, p], side));
            }
        }
    }
    (veils, lines)
}

/// Most normals that are drawn of a mesh without patches.
const MOST_NORMALS: usize = 6000;
/// Length of the drawn normals, in diagonals, unless patches are small.
const NORMAL_LENGTH: f64 = 0.045;
/// The same in mean sides of patches.
const NORMAL_LENGTH_IN_SIDES: f64 = 0.45;

/// The normals at the corners of patches, or at the vertices of a mesh without patches.
pub(super) fn normals(mesh: &Tessellation, surface: Option<&dyn Surface>) -> Vec<[Point3; 2]> {
    let corners: Option<BTreeSet<u32>> =
        surface.map(|surface| surface.patches().flat_map(|p| surface.corners(p)).collect());
    let mut found = BTreeSet::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for (v, n) in triangle.iter().zip(mesh.normal_numbers(t)) {
            if corners.as_ref().is_none_or(|corners| corners.contains(v)) {
                found.insert((*v, n));
            }
        }
    }
    let step = if surface.is_some() { 1 } else { found.len().div_ceil(MOST_NORMALS).max(1) };
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let patches = mesh.patches.chunk_by(|a, b| a == b).count().max(1);
    let area: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum();
    let side = (2.0 * area / patches as f64).sqrt();
    let length = (NORMAL_LENGTH * diagonal).min(NORMAL_LENGTH_IN_SIDES * side * (step as f64).sqrt());
    found
        .into_iter()
        .step_by(step)
        .map(|(v, n)| {
            let p = mesh.positions[v as usize];
            [p, p + length * mesh.normals[n as usize]]
        })
        .collect()
}
