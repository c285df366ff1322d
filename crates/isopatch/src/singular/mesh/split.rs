//! Finer where it is wanted: edges of a conforming mesh are divided, and the new vertices are on the surface.

use std::collections::BTreeSet;

use super::decimate::Limits;
use super::flip::flip;
use super::normals::set_normals;
use super::project::onto_curve;
use super::singular_mesh::{EdgeTag, SingularMesh, VertexKind};
use crate::base::BoxSides;
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};

/// Newton steps onto the surface.
const STEPS: usize = 40;
/// Farthest way of a new vertex to the surface, in the length of its edge.
const REACH: f64 = 0.5;
/// The same for its least distance from the corners around.
const LEAST_PART: f64 = 0.1;

/// Divides the edges with these ends (the smaller first), in this order: the triangles at each in two. Each is given with the point near which its
/// new vertex comes to lie. An edge of a triangle that has been divided already is left out, and so is one whose point finds no
/// surface nearby. Flips edges then where that makes triangles better, and sets the normals anew. How many were divided.
pub fn split_edges(
    field: &dyn Field,
    bounds: &Aabb,
    mesh: &mut SingularMesh,
    edges: &[([u32; 2], Point3)],
    limits: &SplitLimits,
) -> usize {
    let around = mesh.edges();
    let mut used: BTreeSet<u32> = BTreeSet::new();
    let mut count = 0;
    for (ends, near) in edges {
        if count == limits.edges {
            break;
        }
        let Some(triangles) = around.get(ends) else { continue };
        if triangles.iter().any(|t| used.contains(t)) {
            continue;
        }
        let Some((at, kind, sides)) = new_vertex(field, bounds, mesh, *ends, triangles, *near) else {
            continue;
        };
        used.extend(triangles);
        let m = mesh.positions.len() as u32;
        mesh.positions.push(at);
        mesh.vertices.push(kind);
        mesh.sides.push(sides);
        let [a, b] = *ends;
        for t in triangles {
            let old = mesh.triangles[*t as usize];
            mesh.triangles[*t as usize] = old.map(|v| if v == b { m } else { v });
            mesh.triangles.push(old.map(|v| if v == a { m } else { v }));
        }
        if let Ok(i) = mesh.singular_edges.binary_search(ends) {
            // Both halves come after all others that begin with their smaller end; sorted again below.
            mesh.singular_edges[i] = [a, m];
            mesh.singular_edges.push([b, m]);
            mesh.singular_edges.sort_unstable();
        }
        count += 1;
    }
    let SplitLimits { tolerance, floor, .. } = *limits;
    flip(field, mesh, Limits { tolerance, floor, enough: 0 });
    set_normals(field, mesh);
    count
}

/// How many edges are divided, and how far flat triangles may be from the surface after a flip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitLimits {
    /// Most edges that are divided.
    pub edges: usize,
    /// A length.
    pub tolerance: f64,
    /// Least |∇f| in distances.
    pub floor: f64,
}

/// The new vertex of an edge; none if it finds no place.
fn new_vertex(
    field: &dyn Field,
    bounds: &Aabb,
    mesh: &SingularMesh,
    [a, b]: [u32; 2],
    triangles: &[u32],
    near: Point3,
) -> Option<(Point3, VertexKind, BoxSides)> {
    let tag = mesh.tag([a, b], triangles.len());
    let corners: BTreeSet<u32> = triangles.iter().flat_map(|t| mesh.triangles[*t as usize]).collect();
    let [a, b] = [a as usize, b as usize];
    let length = (mesh.positions[a] - mesh.positions[b]).norm();
    let kinds = [mesh.vertices[a], mesh.vertices[b]];
    let (at, kind, sides) = match tag {
        EdgeTag::Singular => {
            let kind = kinds.into_iter().find(|k| matches!(k, VertexKind::OnCurve(_))).unwrap_or(kinds[0]);
            (onto_curve(field, near, None, bounds), kind, BoxSides::NONE)
        }
        EdgeTag::Smooth => (onto_surface(field, near, &[])?, VertexKind::Regular, BoxSides::NONE),
        EdgeTag::Boundary => {
            let sides = mesh.sides[a].common(mesh.sides[b]);
            let axes: Vec<usize> = sides.iter().map(|side| side.axis).collect();
            let mut start = near;
            axes.iter().for_each(|axis| start[*axis] = mesh.positions[a][*axis]);
            (onto_surface(field, start, &axes)?, VertexKind::Regular, sides)
        }
    };
    let is_new = corners.iter().all(|v| (at - mesh.positions[*v as usize]).norm() >= LEAST_PART * length);
    ((at - near).norm() <= REACH * length && is_new && bounds.contains(&at)).then_some((at, kind, sides))
}

/// The point of the surface near `start`, by Newton's method, with the coordinates `fixed` as they are.
pub(super) fn onto_surface(field: &dyn Field, start: Point3, fixed: &[usize]) -> Option<Point3> {
    let mut p = start;
    for _ in 0..STEPS {
        let (f, mut gradient) = field.gradient(p);
        fixed.iter().for_each(|axis| gradient[*axis] = 0.0);
        let step: Vec3 = gradient * (f / gradient.norm_squared());
        if !step.iter().all(|c| c.is_finite()) {
            return None;
        }
        p -= step;
        if step.norm() <= 4.0 * f64::EPSILON * p.norm().max(f64::MIN_POSITIVE) {
            return Some(p);
        }
    }
    None
}
