//! Unit normals at the vertices of a triangle mesh, from the positions alone.

use super::{FaceId, HalfEdgeMesh, VertexId};
use crate::geom::{Point3, Vec3, angle_between};
use std::f64::consts::{PI, TAU};

/// Weighted sum of face normals, each face with the weight of its corner at the vertex.
fn weighted(mesh: &HalfEdgeMesh, positions: &[Point3], weight: impl Fn(&Vec3, &Vec3) -> f64) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); mesh.vertex_count()];
    for f in mesh.faces() {
        let corners = mesh.triangle(f);
        let p = corners.map(|v| positions[v.index()]);
        for k in 0..3 {
            let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            // A face without area has no normal to give.
            if let Some(normal) = a.cross(&b).try_normalize(0.0) {
                sums[corners[k].index()] += weight(&a, &b) * normal;
            }
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
}

/// Mean of the normals of the faces around each vertex, weighted by their angles there; zero where that vanishes.
///
/// Thürmer & Wüthrich, Computing vertex normals from polygonal facets, 1998. Does not depend on how flat parts are cut
/// into triangles.
pub fn angle_weighted(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, angle_between)
}

/// Mean of the normals of the faces around each vertex, weighted by their areas; zero where that vanishes.
pub fn area_weighted(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, |a, b| a.cross(b).norm())
}

/// Mean of the area vectors of the faces around each vertex, each divided by the squares of both sides that meet there;
/// zero where it vanishes.
///
/// Max, Weights for computing vertex normals from facet normals, 1999. Exact where a closed ring lies on a sphere with
/// the vertex.
pub fn sphere_exact(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, |a, b| a.cross(b).norm() / (a.norm_squared() * b.norm_squared()))
}

/// Normals of the limit of Loop subdivision, by the tangent masks at the vertices and at the boundary.
///
/// The choice of Xu, Huang & Bajaj 2001. Where the two tangents are parallel, and where the result points against the
/// faces at a boundary, the angle-weighted normal is taken, or its side.
pub fn loop_limit(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    let outward = angle_weighted(mesh, positions);
    mesh.vertices()
        .map(|v| {
            let outward = outward[v.index()];
            let Some(normal) = loop_normal(mesh, positions, v) else { return outward };
            // The boundary masks give a direction up to its sign.
            if mesh.is_boundary_vertex(v) && normal.dot(&outward) < 0.0 { -normal } else { normal }
        })
        .collect()
}

/// Cross product of the two tangents of the Loop limit.
fn loop_normal(mesh: &HalfEdgeMesh, positions: &[Point3], v: VertexId) -> Option<Vec3> {
    let origin = positions[v.index()];
    // Masks have weights that sum to zero, so points may be taken relative to the vertex.
    let mut ring: Vec<Vec3> = mesh.ring(v).map(|h| positions[mesh.dest(h).index()] - origin).collect();
    let (mut first, mut second) = (Vec3::zeros(), Vec3::zeros());
    if mesh.is_boundary_vertex(v) {
        let last = mesh.ring(v).last()?;
        ring.push(positions[mesh.origin(mesh.prev(last)).index()] - origin);
        let n = ring.len();
        first = ring[0] - ring[n - 1];
        second = match n {
            2 => ring[0] + ring[1],
            3 => ring[1],
            _ => {
                let angle = PI / (n - 1) as f64;
                let ends = angle.sin() * (ring[0] + ring[n - 1]);
                -(1..n - 1)
                    .fold(ends, |sum, i| sum + (2.0 * angle.cos() - 2.0) * (i as f64 * angle).sin() * ring[i])
            }
        };
    } else {
        let n = ring.len() as f64;
        for (i, p) in ring.iter().enumerate() {
            let (sin, cos) = (TAU * i as f64 / n).sin_cos();
            first += cos * p;
            second += sin * p;
        }
    }
    first.cross(&second).try_normalize(0.0)
}

/// Unit normals of the faces; zero for a face without area.
pub fn of_faces(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    mesh.faces().map(|f| of_face(mesh, positions, f)).collect()
}

/// Unit normal of a face; zero if it has no area.
pub fn of_face(mesh: &HalfEdgeMesh, positions: &[Point3], f: FaceId) -> Vec3 {
    let [a, b, c] = mesh.triangle(f).map(|v| positions[v.index()]);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A fan of `n` faces around a vertex at the origin, its ring on z = slope · x + level.
    fn fan(n: u32, closed: bool, level: f64) -> (HalfEdgeMesh, Vec<Point3>) {
        let ring = if closed { n } else { n + 1 };
        let angle = |i: u32| f64::from(i) * if closed { TAU / f64::from(n) } else { PI / f64::from(n) };
        let mut positions = vec![Point3::zeros()];
        positions.extend((0..ring).map(|i| Point3::new(angle(i).cos(), angle(i).sin(), level)));
        let faces: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % ring]).collect();
        (HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap(), positions)
    }

    #[test]
    fn a_regular_cone_has_its_axis_as_normal() {
        for n in 3..9 {
            let (mesh, positions) = fan(n, true, -0.5);
            for normals in [loop_limit, angle_weighted, area_weighted] {
                assert!((normals(&mesh, &positions)[0] - Vec3::z()).norm() < 1e-14, "valence {n}");
            }
        }
    }

    #[test]
    fn normals_of_an_open_flat_fan_point_up() {
        for n in 1..6 {
            let (mesh, positions) = fan(n, false, 0.0);
            for normals in [loop_limit, angle_weighted, area_weighted] {
                assert!(
                    normals(&mesh, &positions).iter().all(|m| (m - Vec3::z()).norm() < 1e-12),
                    "{n} faces"
                );
            }
        }
    }

    #[test]
    fn angle_weights_do_not_see_how_a_side_is_cut() {
        // The corner of a cube: sides z = 0, x = 0, y = 0 seen from outside; the first is cut into two.
        let p = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]];
        let positions: Vec<Point3> = p.map(|c| Point3::from(c.map(f64::from))).to_vec();
        let whole = HalfEdgeMesh::from_faces(4, &[[0, 2, 1], [0, 3, 2], [0, 1, 3]]).unwrap();
        let cut = HalfEdgeMesh::from_faces(5, &[[0, 2, 4], [0, 4, 1], [0, 3, 2], [0, 1, 3]]).unwrap();
        let [one, two] = [(&whole, 4), (&cut, 5)].map(|(mesh, n)| angle_weighted(mesh, &positions[..n])[0]);
        assert!((one - two).norm() < 1e-15);
        assert!((one - Vec3::new(-1.0, -1.0, -1.0).normalize()).norm() < 1e-15);
    }
}
