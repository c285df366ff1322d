//! Vertex normals that see all faces around the vertex.

use crate::geom::{Point3, Vec3};
use crate::hull::most_visible_direction;
use crate::mesh::{HalfEdgeMesh, VertexId, normals};

/// Least product of a vertex normal with the normal of a face beside it (80°): a corner of the face that looks more askance
/// is almost closed, or almost straight, in the tangent plane.
const LEAST: f64 = 0.17;
/// Share of the best possible product that is asked for where that is small.
const SHARE: f64 = 0.8;
/// Steps of the search between the normal and the most visible direction.
const STEPS: usize = 16;

/// What became of the normals.
pub struct Visibility {
    /// Vertices whose normals were moved.
    pub moved: Vec<VertexId>,
    /// Vertices from which no direction sees all faces.
    pub hidden: Vec<VertexId>,
}

/// Turns normals that do not see all faces around their vertices towards the direction that sees them best, as far as needed.
pub fn see_faces(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &mut [Vec3]) -> Visibility {
    let faces = normals::of_faces(mesh, positions);
    let mut found = Visibility { moved: Vec::new(), hidden: Vec::new() };
    for v in mesh.vertices() {
        let around: Vec<Vec3> =
            mesh.ring(v).map(|h| faces[mesh.face(h).index()]).filter(|n| *n != Vec3::zeros()).collect();
        let least = |d: &Vec3| around.iter().map(|n| n.dot(d)).fold(f64::INFINITY, f64::min);
        let normal = &mut normals[v.index()];
        if least(normal) >= LEAST {
            continue;
        }
        let Some((best, most)) = most_visible_direction(&around) else { continue };
        if most <= 0.0 {
            found.hidden.push(v);
        }
        let wanted = LEAST.min(SHARE * most);
        let turned = (1..=STEPS).map(|i| {
            let t = i as f64 / STEPS as f64;
            ((1.0 - t) * *normal + t * best).normalize()
        });
        let enough = turned.into_iter().find(|d| least(d) >= wanted).unwrap_or(best);
        if enough != *normal {
            *normal = enough;
            found.moved.push(v);
        }
    }
    found
}

/// Turns the normals of some vertices halfway to the direction that sees their faces best.
pub fn see_better(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &mut [Vec3], vertices: &[VertexId], share: f64) {
    let faces = normals::of_faces(mesh, positions);
    for v in vertices {
        let around: Vec<Vec3> =
            mesh.ring(*v).map(|h| faces[mesh.face(h).index()]).filter(|n| *n != Vec3::zeros()).collect();
        let Some((best, _)) = most_visible_direction(&around) else { continue };
        let n = &mut normals[v.index()];
        *n = ((1.0 - share) * *n + share * best).normalize();
    }
}
