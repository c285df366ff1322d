//! The G1 conditions along an edge: Tong & Kim 2009, section 6.4.
//!
//! ```text
//!        r0  r1  r2  r3  r4  r5  r6       first row of the left patch, from a to b
//!      q0———q1———————q2———————q3———q4     quartic boundary curve
//!        p0  p1  p2  p3  p4  p5  p6       first row of the right patch, from a to b
//!
//!   [1 − λ(t)] p(t) + λ(t) r(t) = [1 − μ(t)] q_b(t) + μ(t) q_t(t)                                     (1)
//! ```
//!
//! λ is linear, μ quartic. The vertex systems have settled the rows k = 0, 1, 6, 7 of Table 2. Rows 2 … 5 bind the
//! six inner points. Their combination in t⁷ is (λ1 − λ0) D⁶(r − p) = D⁴(μ) D⁴(q), eq. (22): with μ2 from (23) its
//! right side is (λ1 − λ0) ν D⁴(q), so it can be divided by λ1 − λ0. The four rows used here therefore stay well
//! conditioned (≤ 2.8) however small λ1 − λ0 is, and the paper's switch of rank is not needed.

use crate::geom::{Point3, Vec3};
use nalgebra::{Matrix4, SMatrix};

/// The data of the conditions along one edge; p2 … p4 and r2 … r4 are the wanted points.
#[derive(Clone, Copy, Debug)]
pub struct EdgeSystem {
    /// Boundary curve.
    pub q: [Point3; 5],
    /// First row of the right patch.
    pub p: [Point3; 7],
    /// First row of the left patch.
    pub r: [Point3; 7],
    /// λ(0) and λ(1).
    pub lambda: [f64; 2],
    /// μ0, μ1, μ3, μ4.
    pub mu: [f64; 4],
    /// Shape parameter ν: μ2 = (−μ0 + 4μ1 + 4μ3 − μ4)/6 + (λ1 − λ0) ν/6. Zero is the best choice known.
    pub nu: f64,
}

/// Inner rows that satisfy (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeSolution {
    /// p2, p3, p4.
    pub p: [Point3; 3],
    /// r2, r3, r4.
    pub r: [Point3; 3],
}

impl EdgeSystem {
    /// All five Bernstein coefficients of μ, with μ2 from (23).
    pub fn mu_coefficients(&self) -> [f64; 5] {
        let [mu0, mu1, mu3, mu4] = self.mu;
        let mu2 = (-mu0 + 4.0 * mu1 + 4.0 * mu3 - mu4 + (self.lambda[1] - self.lambda[0]) * self.nu) / 6.0;
        [mu0, mu1, mu2, mu3, mu4]
    }

    /// The inner points nearest to the wanted ones that satisfy (1). Constant time.
    pub fn solve(&self) -> Option<EdgeSolution> {
        let origin = self.q.iter().sum::<Point3>() / 5.0;
        let (q, p, r) = (self.q.map(|x| x - origin), self.p.map(|x| x - origin), self.r.map(|x| x - origin));
        let (mut a, mut b) = self.rows(&q, &p, &r);
        for i in 0..4 {
            let scale = 1.0 / a.row(i).norm();
            a.row_mut(i).scale_mut(scale);
            b[i] *= scale;
        }
        let wanted = [p[2], r[2], p[3], r[3], p[4], r[4]];
        let residual = SMatrix::<f64, 4, 3>::from_fn(|i, c| {
            b[i][c] - (0..6).map(|j| a[(i, j)] * wanted[j][c]).sum::<f64>()
        });
        let gram: Matrix4<f64> = a * a.transpose();
        let change = a.transpose() * gram.cholesky()?.solve(&residual);
        let x: [Point3; 6] = std::array::from_fn(|j| wanted[j] + change.row(j).transpose() + origin);
        Some(EdgeSolution { p: [x[0], x[2], x[4]], r: [x[1], x[3], x[5]] })
    }

    /// The four rows for the unknowns (p2, r2, p3, r3, p4, r4): k = 2 and k = 5 of Table 2, the sum of k = 3 and
    /// k = 4, and D⁶(r − p) = ν D⁴(q).
    fn rows(&self, q: &[Vec3; 5], p: &[Vec3; 7], r: &[Vec3; 7]) -> (SMatrix<f64, 4, 6>, [Vec3; 4]) {
        let [l0, l1] = self.lambda;
        let (m0, m1) = (1.0 - l0, 1.0 - l1);
        let mu = self.mu_coefficients();
        let along = |j: usize, i: usize| (1.0 - mu[j]) * q[i] + mu[j] * q[i + 1];
        #[rustfmt::skip]
        let a = SMatrix::<f64, 4, 6>::from_row_slice(&[
            15.0 * m0, 15.0 * l0, 0.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 0.0, 0.0, 15.0 * m1, 15.0 * l1,
            15.0 * m1, 15.0 * l1, 20.0 * (m0 + m1), 20.0 * (l0 + l1), 15.0 * m0, 15.0 * l0,
            -15.0, 15.0, 20.0, -20.0, -15.0, 15.0,
        ]);
        let k2 = -6.0 * (m1 * p[1] + l1 * r[1]) + 3.0 * along(0, 2) + 12.0 * along(1, 1) + 6.0 * along(2, 0);
        let k5 = -6.0 * (m0 * p[5] + l0 * r[5]) + 6.0 * along(2, 3) + 12.0 * along(3, 2) + 3.0 * along(4, 1);
        let k3 = along(0, 3) + 12.0 * along(1, 2) + 18.0 * along(2, 1) + 4.0 * along(3, 0);
        let k4 = 4.0 * along(1, 3) + 18.0 * along(2, 2) + 12.0 * along(3, 1) + along(4, 0);
        let d = |i: usize| r[i] - p[i];
        let fourth_difference = q[0] - 4.0 * q[1] + 6.0 * q[2] - 4.0 * q[3] + q[4];
        let k7 = self.nu * fourth_difference - (d(0) - 6.0 * d(1) - 6.0 * d(5) + d(6));
        (a, [k2, k5, k3 + k4, k7])
    }
}
