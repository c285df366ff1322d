//! Normals and curvature tensors at the vertices of a mesh, from the positions alone.

use super::base_mesh::{BaseMesh, EdgeFeature};
use crate::geom::{Mat3, Point3, Vec3};
use crate::mesh::{HalfEdgeMesh, VertexId, normals};
use nalgebra::{Matrix3, Vector3};

/// Weight of what neighbouring normals say of the curvature against what positions say: they decide only what these leave
/// open, such as the twist at a vertex of valence 4.
const NORMAL_WEIGHT: f64 = 0.05;

/// Unit vectors of a tangent plane.
pub(super) fn tangent_frame(normal: &Vec3) -> [Vec3; 2] {
    let axis = normal.iamin();
    let x = normal.cross(&Vec3::ith(axis, 1.0)).normalize();
    [x, normal.cross(&x)]
}

/// The neighbours of a vertex, counter-clockwise; at a boundary from one end to the other.
pub(super) fn neighbours(mesh: &HalfEdgeMesh, v: VertexId) -> Vec<VertexId> {
    let ring: Vec<_> = mesh.ring(v).collect();
    let mut around: Vec<VertexId> = ring.iter().map(|h| mesh.dest(*h)).collect();
    if let (true, Some(last)) = (mesh.is_boundary_vertex(v), ring.last()) {
        around.push(mesh.origin(mesh.prev(*last)));
    }
    around
}

/// Normal equations for the curvature tensor at a vertex, as (xx, xy, yy) in its tangent frame.
///
/// The circle through the vertex, along its tangent plane, and a neighbour has the curvature k = 2 d·N / |d|²; Euler's
/// theorem makes it tᵀ M t. The normal of a neighbour adds M d ≈ −ΔN, with little weight.
#[derive(Clone, Copy)]
pub(super) struct TensorFit {
    pub a: Matrix3<f64>,
    pub b: Vector3<f64>,
}

impl TensorFit {
    /// From the neighbours of a vertex, each with the square of its distance as weight.
    pub fn at(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &[Vec3], v: VertexId) -> Self {
        let n = &normals[v.index()];
        let [x, y] = tangent_frame(n);
        let (mut a, mut b) = (Matrix3::zeros(), Vector3::zeros());
        for w in neighbours(mesh, v) {
            let (d, m) = (positions[w.index()] - positions[v.index()], normals[w.index()]);
            let Some(t) = Vec3::new(d.dot(&x), d.dot(&y), 0.0).try_normalize(0.0) else { continue };
            let (c, s) = (t.x, t.y);
            let mut add = |row: Vector3<f64>, value: f64, weight: f64| {
                let weight = weight * d.norm_squared();
                a += weight * row * row.transpose();
                b += weight * value * row;
            };
            add(Vector3::new(c * c, 2.0 * c * s, s * s), 2.0 * d.dot(n) / d.norm_squared(), 1.0);
            let turn = (m - n) / -d.norm();
            add(Vector3::new(c, s, 0.0), turn.dot(&x), NORMAL_WEIGHT);
            add(Vector3::new(0.0, c, s), turn.dot(&y), NORMAL_WEIGHT);
        }
        Self { a, b }
    }

    /// The tensor; zero where it is not determined.
    pub fn solve(&self) -> Vector3<f64> {
        self.a.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&self.b))
    }
}

/// The tensor with the components (xx, xy, yy) in a tangent frame, symmetric to the bit.
pub(super) fn tensor(k: &Vector3<f64>, [x, y]: &[Vec3; 2]) -> Mat3 {
    k.x * (x * x.transpose()) + k.y * (x * y.transpose() + y * x.transpose()) + k.z * (y * y.transpose())
}

/// Curvature tensors at all vertices for given unit normals.
pub fn curvature_tensors(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &[Vec3]) -> Vec<Mat3> {
    mesh.vertices()
        .map(|v| {
            tensor(&TensorFit::at(mesh, positions, normals, v).solve(), &tangent_frame(&normals[v.index()]))
        })
        .collect()
}

impl BaseMesh {
    /// A base mesh with normals and curvature tensors estimated from the positions: [`normals::sphere_exact`], and
    /// [`curvature_tensors`] of these. Neither depends on more than the neighbours of a vertex.
    pub fn estimated(mesh: HalfEdgeMesh, positions: Vec<Point3>) -> Self {
        let normals = normals::sphere_exact(&mesh, &positions);
        let curvatures = curvature_tensors(&mesh, &positions, &normals);
        Self::from_parts(mesh, positions, normals, curvatures)
    }

    /// A base mesh with the given normals and curvature tensors, open where the mesh is.
    pub fn from_parts(
        mesh: HalfEdgeMesh,
        positions: Vec<Point3>,
        normals: Vec<Vec3>,
        curvatures: Vec<Mat3>,
    ) -> Self {
        let features = mesh
            .edges()
            .map(|e| match mesh.twin(mesh.edge_half_edge(e)) {
                Some(_) => EdgeFeature::Smooth,
                None => EdgeFeature::Boundary,
            })
            .collect();
        Self { mesh, positions, normals, curvatures, features, clip: None, frozen_diagonal: None }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A ring of `n` uneven points on the graph z = ½ xᵀ M x, with their normals, around the origin.
    fn ring(n: u32, h: f64, m: [f64; 3]) -> (HalfEdgeMesh, Vec<Point3>, Vec<Vec3>) {
        let at = |x: f64, y: f64| Point3::new(x, y, 0.5 * (m[0] * x * x + 2.0 * m[1] * x * y + m[2] * y * y));
        let normal =
            |p: &Point3| Vec3::new(-m[0] * p.x - m[1] * p.y, -m[1] * p.x - m[2] * p.y, 1.0).normalize();
        let mut positions = vec![Point3::zeros()];
        positions.extend((0..n).map(|i| {
            let angle = (f64::from(i) + 0.2 * f64::from(i).sin()) * std::f64::consts::TAU / f64::from(n);
            let r = h * (1.0 + 0.2 * f64::from(i).cos());
            at(r * angle.cos(), r * angle.sin())
        }));
        let faces: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        let normals = positions.iter().map(normal).collect();
        (HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap(), positions, normals)
    }

    #[test]
    fn tensors_converge_to_those_of_the_surface() {
        let exact = Mat3::new(0.7, -0.4, 0.0, -0.4, -1.3, 0.0, 0.0, 0.0, 0.0);
        for n in 3..9 {
            let error = |h: f64| {
                let (mesh, p, normals) = ring(n, h, [0.7, -0.4, -1.3]);
                (curvature_tensors(&mesh, &p, &normals)[0] - exact).norm()
            };
            let (coarse, fine) = (error(0.1), error(0.05));
            assert!(fine < 0.01 && fine < 0.3 * coarse, "valence {n}: {coarse:e} {fine:e}");
        }
    }

    #[test]
    fn a_sphere_is_estimated_exactly() {
        let sphere = crate::golden::sphere().base;
        let base = BaseMesh::estimated(sphere.mesh, sphere.positions);
        for ((n, m), p) in base.normals.iter().zip(&base.curvatures).zip(&base.positions) {
            assert!((n - p.normalize()).norm() < 1e-14);
            // The normals of neighbours differ by chords of the unit sphere in the tangent plane, which are shorter.
            assert!((m + (Mat3::identity() - n * n.transpose())).norm() < 0.05, "{m}");
        }
    }
}
