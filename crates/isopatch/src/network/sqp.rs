//! Algorithm 5.1 of Tong & Kim (2009): the fit (9) by local sequential quadratic programming, as in the paper.
//!
//! Two signs are other than printed: μ⁰ is the negative root, since t1 points forward in (7); and with W as printed, −r
//! multiplies 8k₀ and 8k₁ in the corners λλ and μμ. SQP that has converged is not always right: from a poor start it can end
//! at λ < 0 or μ > 0, which is why it is not the default.

use super::ends::{Ends, Fit};
use super::quartic::{CurveOptions, SAMPLES, TABLE};
use crate::geom::Vec3;
use nalgebra::{Matrix5, SMatrix, SVector, Vector2, Vector5};

/// M of Algorithm 5.1.
const MAX_ITERATIONS: usize = 40;

type Kkt = SMatrix<f64, 7, 7>;

impl Ends {
    /// λ, μ and q2 of (9) by Algorithm 5.1, for projected samples relative to q0; none if it does not converge, or converges
    /// to a curve that leaves an end backwards.
    pub fn fit_sqp(&self, samples: [Vec3; SAMPLES], options: &CurveOptions) -> Option<Fit> {
        let (a, b) = self.normal_equations(&samples);
        let [k0, k1] = self.k.map(|k| k[0]);
        let mut x = self.initial_guess(a.lu().solve(&b)?);
        let mut r = Vector2::zeros();
        for steps in 1..=MAX_ITERATIONS {
            let fit = fit_of(&x, steps);
            // c and G of (10). `constraints` has (9b) with the other sign, divided by 3.
            let c = -3.0 * self.constraints(&fit);
            let g = -3.0 * self.constraint_gradients(&fit).fixed_columns::<5>(0).transpose();
            let mut w = 2.0 * a;
            w[(0, 0)] -= 8.0 * k0 * r[0];
            w[(1, 1)] -= 8.0 * k1 * r[1];
            // (11)
            let mut kkt = Kkt::zeros();
            kkt.fixed_view_mut::<5, 5>(0, 0).copy_from(&w);
            kkt.fixed_view_mut::<5, 2>(0, 5).copy_from(&-g);
            kkt.fixed_view_mut::<2, 5>(5, 0).copy_from(&g.transpose());
            let mut right = SVector::<f64, 7>::zeros();
            right.fixed_rows_mut::<5>(0).copy_from(&(-2.0 * (a * x - b)));
            right.fixed_rows_mut::<2>(5).copy_from(&-c);
            let solution = kkt.lu().solve(&right).filter(|s| s.iter().all(|v| v.is_finite()))?;
            let (u, v) = (solution.fixed_rows::<5>(0), solution.fixed_rows::<2>(5));
            let change = u.norm() + (v - r).norm();
            x += u;
            r.copy_from(&v);
            if change < options.sqp_tolerance * self.length {
                return Some(fit_of(&x, steps)).filter(|fit| fit.lambda > 0.0 && fit.mu < 0.0);
            }
        }
        None
    }

    /// A and b of the unconstrained fit, over λ, μ, q2.
    fn normal_equations(&self, samples: &[Vec3; SAMPLES]) -> (Matrix5<f64>, Vector5<f64>) {
        let (mut a, mut b) = (Matrix5::zeros(), Vector5::zeros());
        for (basis, sample) in TABLE.b.iter().zip(samples) {
            let rest = sample - (basis[3] + basis[4]) * self.chord;
            let mut rows = SMatrix::<f64, 3, 5>::zeros();
            rows.set_column(0, &(basis[1] * self.t[0]));
            rows.set_column(1, &(basis[3] * self.t[1]));
            (0..3).for_each(|i| rows[(i, 2 + i)] = basis[2]);
            a += rows.transpose() * rows;
            b += rows.transpose() * rest;
        }
        (a, b)
    }

    /// λ⁰ and μ⁰ from q2⁰ and (9b), as in the paper but for the sign of μ⁰.
    fn initial_guess(&self, mut x: Vector5<f64>) -> Vector5<f64> {
        let q2 = Vec3::new(x[2], x[3], x[4]);
        let heights = [q2.dot(&self.n[0]), (q2 - self.chord).dot(&self.n[1])];
        let root = |i: usize| {
            let square = 3.0 * heights[i] / (4.0 * self.k[i][0]);
            if square >= 0.0 && square.is_finite() { square.sqrt() } else { 0.0 }
        };
        (x[0], x[1]) = (root(0), -root(1));
        x
    }
}

fn fit_of(x: &Vector5<f64>, steps: usize) -> Fit {
    Fit { lambda: x[0], mu: x[1], q2: Vec3::new(x[2], x[3], x[4]), aside: [0.0; 2], steps, sqp_failed: false }
}
