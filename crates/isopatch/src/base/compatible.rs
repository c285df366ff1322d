//! Curvature tensors that the curves over the edges can have.

use super::base_mesh::BaseMesh;
use super::estimate::{TensorFit, tangent_frame};
use crate::geom::{Mat3, Vec3, angle_between};
use crate::mesh::{EdgeId, VertexId};

pub struct Weights<'a> { pub epsilon: f64, pub prior: f64, pub sweeps: usize, pub stiffness: &'a [f64] }

/// One edge: for the ends i, residual r_i = a_i k_i − c_i with k_i = t_iᵀ M_i t_i, and the metric of both.
struct Joint {
    ends: [VertexId; 2],
    /// (c², 2cs, s²) of the directions in the frames.
    rows: [nalgebra::Vector3<f64>; 2],
    /// ℓ²/12 over the length.
    scale: f64,
    wanted: [f64; 2],
    /// Inverse of the Gram matrix: diagonal and off-diagonal.
    metric: [f64; 2],
}

pub fn compatible_curvatures(base: &BaseMesh, weights: &Weights<'_>) -> Vec<Mat3> {
    let frames: Vec<[Vec3; 2]> = base.normals.iter().map(tangent_frame).collect();
    let joints: Vec<Joint> = base.mesh.edges().filter_map(|e| Joint::new(base, &frames, e, weights.epsilon, weights.stiffness[e.index()])).collect();
    let mut of_vertex: Vec<Vec<(usize, usize)>> = vec![Vec::new(); base.mesh.vertex_count()];
    for (j, joint) in joints.iter().enumerate() {
        (0..2).for_each(|i| of_vertex[joint.ends[i].index()].push((j, i)));
    }
    let priors: Vec<TensorFit> = base.mesh.vertices().map(|v| TensorFit::at(&base.mesh, &base.positions, &base.normals, v)).collect();
    let mut k: Vec<nalgebra::Vector3<f64>> = priors.iter().map(TensorFit::solve).collect();
    for _ in 0..weights.sweeps {
        for v in 0..k.len() {
            let mut a = priors[v].a * weights.prior;
            let mut b = priors[v].b * weights.prior;
            for (j, i) in &of_vertex[v] {
                let joint = &joints[*j];
                let (row, other) = (joint.rows[*i], joint.rows[1 - i].dot(&k[joint.ends[1 - i].index()]));
                let r_other = joint.scale * other - joint.wanted[1 - i];
                let [d, o] = joint.metric;
                // Least d r² + 2 o r r_other.
                a += d * joint.scale * joint.scale * row * row.transpose();
                b += joint.scale * (d * joint.wanted[*i] - o * r_other) * row;
            }
            if let Some(factor) = a.cholesky() { k[v] = factor.solve(&b); }
        }
    }
    k.iter().zip(&frames).map(|(k, [x, y])| k.x * x * x.transpose() + k.y * (x * y.transpose() + y * x.transpose()) + k.z * y * y.transpose()).collect()
}

impl Joint {
    fn new(base: &BaseMesh, frames: &[[Vec3; 2]], e: EdgeId, epsilon: f64, stiffness: f64) -> Option<Self> {
        let h = base.mesh.edge_half_edge(e);
        let ends = [base.mesh.origin(h), base.mesh.dest(h)];
        let chord = base.positions[ends[1].index()] - base.positions[ends[0].index()];
        let t0 = base.direction(e, ends[0]).try_normalize(0.0)?;
        let t1 = -base.direction(e, ends[1]).try_normalize(0.0)?;
        let angle = 0.5 * (angle_between(&t0, &chord) + angle_between(&t1, &chord));
        let arc = chord.norm() * if angle > 0.0 { angle / angle.sin() } else { 1.0 };
        let n = ends.map(|v| base.normals[v.index()]);
        let length = chord.norm();
        let q2 = 0.5 * (chord + arc / 3.0 * (t0 - t1));
        let row = |i: usize, t: Vec3| {
            let [x, y] = frames[ends[i].index()];
            let (c, s) = (t.dot(&x), t.dot(&y));
            nalgebra::Vector3::new(c * c, 2.0 * c * s, s * s)
        };
        let c = n[0].dot(&n[1]);
        let d = 1.0 + epsilon;
        let det = d * d - c * c;
        Some(Self {
            ends,
            rows: [row(0, t0), row(1, t1)],
            scale: arc * arc / 12.0 / length,
            wanted: [q2.dot(&n[0]) / length, (q2 - chord).dot(&n[1]) / length],
            metric: [stiffness * d / det, -stiffness * c / det],
        })
    }
}
