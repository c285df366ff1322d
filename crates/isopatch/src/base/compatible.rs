//! Curvature tensors that the curves over the edges can have.
//!
//! The quartic curve over an edge (Tong & Kim 2009, section 5) has one control point, q2, to bring about the normal
//! curvatures k0, k1 of both ends:
//!
//! ```text
//! q2·N0 = 4/3 λ² k0,   (q2 − chord)·N1 = 4/3 μ² k1                                       (8), q0 = 0
//! ```
//!
//! Where N0 and N1 almost agree, as they do on every fine mesh, both equations say almost the same of q2, and
//! curvatures that are estimated at each vertex alone send it far along the edge or across it: patches fold. So the
//! tensors are chosen together, for q2 to stay near the middle control point of the cubic curve over the edge: the sum
//! of the squares of its ways, which is quadratic in the tensors, is made small, with a little weight on what each
//! vertex has to say.

use super::base_mesh::BaseMesh;
use super::estimate::{TensorFit, tangent_frame, tensor};
use crate::geom::{Mat3, Point3, Vec3, angle_between};
use crate::mesh::{EdgeId, VertexId};
use nalgebra::{Matrix3, Vector3};

/// Weight of the estimate at a vertex alone.
const PRIOR: f64 = 1e-2;
/// Added to the Gram matrix of N0 and N1, which is singular where both normals agree.
const GRAM_REGULARISATION: f64 = 1e-6;
/// Most sweeps over the vertices. More change no patch visibly; flat parts with a little noise need most of them.
const SWEEPS: usize = 60;

/// One edge inside: the way of q2 is (r0, r1) in the metric of both normals, r = `scale` · k − `wanted`. Relative to the length of the edge.
struct Joint {
    ends: [VertexId; 2],
    /// (c², 2cs, s²) of the directions in the tangent frames: their products with a tensor are k0, k1.
    rows: [Vector3<f64>; 2],
    scale: f64,
    wanted: [f64; 2],
    /// Inverse of the Gram matrix of N0 and N1: diagonal and off-diagonal.
    metric: [f64; 2],
}

/// Curvature tensors for the normals of `base`, from all positions together; `stiffness` is the weight of each edge.
///
/// Gauss–Seidel sweeps, one vertex after the other: linear time, and the same result for every number of threads.
pub fn compatible_curvatures(base: &BaseMesh, stiffness: &[f64]) -> Vec<Mat3> {
    let frames: Vec<[Vec3; 2]> = base.normals.iter().map(tangent_frame).collect();
    let inner = base.mesh.edges().filter(|e| base.mesh.twin(base.mesh.edge_half_edge(*e)).is_some());
    let joints: Vec<Joint> =
        inner.filter_map(|e| Joint::new(base, &frames, e, stiffness[e.index()])).collect();
    let mut joints_of: Vec<Vec<(usize, usize)>> = vec![Vec::new(); base.mesh.vertex_count()];
    for (j, joint) in joints.iter().enumerate() {
        (0..2).for_each(|i| joints_of[joint.ends[i].index()].push((j, i)));
    }
    let mut k: Vec<Vector3<f64>> = Vec::with_capacity(joints_of.len());
    let mut alone: Vec<Vector3<f64>> = Vec::with_capacity(joints_of.len());
    // A tensor is what it would be with none at the other ends, `alone`, and the sum of their pulls; those at vertex v end
    // at `ends[v]`.
    let (mut pulls, mut ends) = (Vec::with_capacity(2 * joints.len()), Vec::with_capacity(joints_of.len()));
    for (v, around) in base.mesh.vertices().zip(&joints_of) {
        let fit = TensorFit::at(&base.mesh, &base.positions, &base.normals, v);
        k.push(fit.solve());
        let around = || around.iter().map(|(j, i)| (&joints[*j], *i));
        let matrix = around().fold(PRIOR * fit.a, |a, (joint, i)| a + joint.matrix(i));
        // The matrices do not depend on the tensors: one inverse does for all sweeps.
        let inverse = matrix.cholesky().map_or_else(Matrix3::zeros, |factors| factors.inverse());
        let wanted = around().fold(PRIOR * fit.b, |b, (joint, i)| b + joint.wanted(i));
        alone.push(inverse * wanted);
        pulls.extend(around().map(|(joint, i)| joint.pull(i, &inverse)));
        ends.push(pulls.len());
    }
    for _ in 0..SWEEPS {
        let (mut changed, mut start) = (false, 0);
        for v in 0..k.len() {
            let solved = pulls[start..ends[v]].iter().fold(alone[v], |sum, pull: &Pull| sum + pull.of(&k));
            start = ends[v];
            changed |= (solved - k[v]).amax() > f64::EPSILON * solved.amax();
            k[v] = solved;
        }
        // More sweeps would change nothing but the last bits.
        if !changed {
            break;
        }
    }
    k.iter().zip(&frames).map(|(k, frame)| tensor(k, frame)).collect()
}

impl Joint {
    fn new(base: &BaseMesh, frames: &[[Vec3; 2]], e: EdgeId, stiffness: f64) -> Option<Self> {
        let h = base.mesh.edge_half_edge(e);
        let ends = [base.mesh.origin(h), base.mesh.dest(h)];
        let [from, to]: [Point3; 2] = ends.map(|v| base.positions[v.index()]);
        let chord = to - from;
        let length = chord.norm();
        let t =
            [base.direction(e, ends[0]).try_normalize(0.0)?, -base.direction(e, ends[1]).try_normalize(0.0)?];
        let angle = 0.5 * (angle_between(&t[0], &chord) + angle_between(&t[1], &chord));
        let arc = length * if angle > 0.0 { angle / angle.sin() } else { 1.0 };
        // Of the cubic curve with these tangents and the speed `arc`, in degree 4: λ = μ = arc/4.
        let q2 = 0.5 * (chord + arc / 3.0 * (t[0] - t[1]));
        let n = ends.map(|v| base.normals[v.index()]);
        let rows = std::array::from_fn(|i| {
            let [x, y] = frames[ends[i].index()];
            let (c, s) = (t[i].dot(&x), t[i].dot(&y));
            Vector3::new(c * c, 2.0 * c * s, s * s)
        });
        let (diagonal, cosine) = (1.0 + GRAM_REGULARISATION, n[0].dot(&n[1]));
        let weight = stiffness / (diagonal * diagonal - cosine * cosine);
        Some(Self {
            ends,
            rows,
            scale: arc * arc / (12.0 * length),
            wanted: [q2.dot(&n[0]) / length, (q2 - chord).dot(&n[1]) / length],
            metric: [weight * diagonal, -weight * cosine],
        })
    }

    /// Its part of the matrix of the normal equations at its end `i`.
    fn matrix(&self, i: usize) -> Matrix3<f64> {
        self.metric[0] * self.scale * self.scale * self.rows[i] * self.rows[i].transpose()
    }

    /// Its part of their right side, with no curvature at the other end.
    fn wanted(&self, i: usize) -> Vector3<f64> {
        let [diagonal, coupling] = self.metric;
        self.scale * (diagonal * self.wanted[i] + coupling * self.wanted[1 - i]) * self.rows[i]
    }

    /// What the tensor at the other end adds to the solution at end `i`, whose matrix has this inverse.
    fn pull(&self, i: usize, inverse: &Matrix3<f64>) -> Pull {
        let other = 1 - i;
        let coupling = self.metric[1] * self.scale * self.scale;
        Pull {
            from: self.ends[other].index(),
            row: -coupling * self.rows[other],
            onto: inverse * self.rows[i],
        }
    }
}

/// The product of a vector, a row, and the tensor at a vertex.
struct Pull {
    from: usize,
    row: Vector3<f64>,
    onto: Vector3<f64>,
}

impl Pull {
    fn of(&self, k: &[Vector3<f64>]) -> Vector3<f64> {
        self.row.dot(&k[self.from]) * self.onto
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn base() -> BaseMesh {
        // A sphere with vertices of valence 4 to 8, by its exact normals.
        let sphere = crate::golden::sphere().base;
        let (mesh, positions) = (sphere.mesh, sphere.positions);
        BaseMesh::from_parts(
            mesh,
            positions.clone(),
            positions.iter().map(|p| p.normalize()).collect(),
            Vec::new(),
        )
    }

    #[test]
    fn a_sphere_keeps_its_curvature_to_the_order_of_the_curves() {
        let base = base();
        let (radius, exact) = (base.positions[0].norm(), |n: &Vec3| n * n.transpose() - Mat3::identity());
        let tensors = compatible_curvatures(&base, &vec![1.0; base.mesh.edge_count()]);
        for (m, n) in tensors.iter().zip(&base.normals) {
            // The edges of an icosahedron turn by 63°; their cubic curves are off by half a percent.
            assert!((radius * m - exact(n)).norm() < 0.05, "{m}");
            assert!((m * n).norm() < 1e-12);
        }
    }
}
