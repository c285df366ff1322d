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

/// Turns normals that do not see all faces around their vertices towards the direction that sees them best, as far as needed;
/// gives the vertices whose normals were moved.
pub fn see_faces(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &mut [Vec3]) -> Vec<VertexId> {
    let faces = normals::of_faces(mesh, positions);
    let mut moved = Vec::new();
    for v in mesh.vertices() {
        let around = normals_around(mesh, &faces, v);
        let least = |d: &Vec3| around.iter().map(|n| n.dot(d)).fold(f64::INFINITY, f64::min);
        let normal = normals[v.index()];
        if least(&normal) >= LEAST {
            continue;
        }
        let Some((best, most)) = most_visible_direction(&around) else { continue };
        let wanted = LEAST.min(SHARE * most);
        let mut between = (1..=STEPS).map(|i| towards(&normal, &best, i as f64 / STEPS as f64));
        normals[v.index()] = between.find(|d| least(d) >= wanted).unwrap_or(best);
        moved.push(v);
    }
    moved
}

/// Turns the normals of some vertices a share of the way to the direction that sees their faces best.
pub fn see_better(
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
    normals: &mut [Vec3],
    vertices: &[VertexId],
    share: f64,
) {
    let faces = normals::of_faces(mesh, positions);
    for v in vertices {
        if let Some((best, _)) = most_visible_direction(&normals_around(mesh, &faces, *v)) {
            normals[v.index()] = towards(&normals[v.index()], &best, share);
        }
    }
}

/// Normals of the faces around a vertex that have an area.
fn normals_around(mesh: &HalfEdgeMesh, faces: &[Vec3], v: VertexId) -> Vec<Vec3> {
    mesh.ring(v).map(|h| faces[mesh.face(h).index()]).filter(|n| *n != Vec3::zeros()).collect()
}

/// The direction a share of the way from one unit vector to another, which it is where there is none between.
fn towards(from: &Vec3, to: &Vec3, share: f64) -> Vec3 {
    ((1.0 - share) * from + share * to).try_normalize(0.0).unwrap_or(*to)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_is_turned_until_it_sees_all_faces() {
        // A fan of three faces like the corner of a cube, seen from (1, 1, 1).
        let p = [Point3::zeros(), -Point3::x(), -Point3::y(), -Point3::z()];
        let mesh = HalfEdgeMesh::from_faces(4, &[[0, 1, 2], [0, 2, 3], [0, 3, 1u32]]).unwrap();
        let best = Vec3::new(1.0, 1.0, 1.0).normalize();
        let flat = Vec3::new(1.0, 0.0, 0.0);
        let mut normals = vec![flat, best, best, best];
        assert_eq!(see_faces(&mesh, &p, &mut normals), [VertexId(0)]);
        let least = normals[0].amin();
        assert!((LEAST..0.3).contains(&least), "{}", normals[0]);
        assert_eq!(see_faces(&mesh, &p, &mut normals), []);
        see_better(&mesh, &p, &mut normals, &[VertexId(0)], 1.0);
        assert!((normals[0] - best).norm() < 1e-12);
    }
}
