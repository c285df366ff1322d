//! The fit (9) of a curve to projected samples, with q2 eliminated.

use super::ends::{Ends, Fit};
use super::quartic::{CurveOptions, SAMPLES, TABLE};
use crate::geom::Vec3;
use nalgebra::{Matrix2, Vector2};

/// Added to the Gram matrix of N0 and N1, which is singular where both normals agree.
const GRAM_REGULARISATION: f64 = 1e-9;
/// First damping of Levenberg–Marquardt, and the damping at which it gives up.
const DAMPING: [f64; 2] = [1e-6, 1e8];

impl Ends {
    /// Fit (9) to projected samples (relative to q0): Levenberg–Marquardt in (λ, μ), then (9b) restored exactly.
    pub fn fit(&self, samples: [Vec3; SAMPLES], options: &CurveOptions) -> Fit {
        let problem = Reduced::new(self, samples);
        let low = Vector2::new(options.shortest_tangent, -options.longest_tangent) * self.length;
        let high = Vector2::new(options.longest_tangent, -options.shortest_tangent) * self.length;
        let unconstrained =
            problem.h.try_inverse().map_or_else(Vector2::zeros, |inverse| inverse * problem.g);
        let mut x = unconstrained.sup(&low).inf(&high);
        let mut value = problem.objective(&x);
        let (mut damping, mut steps) = (DAMPING[0], 0);
        while steps < options.max_steps && damping < DAMPING[1] {
            steps += 1;
            let (gradient, mut hessian) = problem.derivatives(&x);
            (0..2).for_each(|i| hessian[(i, i)] *= 1.0 + damping);
            let Some(inverse) = hessian.try_inverse() else { break };
            let next = (x - inverse * gradient).sup(&low).inf(&high);
            let next_value = problem.objective(&next);
            let small = (next - x).norm() < options.step_tolerance * self.length;
            if next_value <= value {
                (x, value, damping) = (next, next_value, (0.1 * damping).max(1e-12));
            } else {
                damping *= 10.0;
            }
            if small {
                break;
            }
        }
        let fit =
            Fit { lambda: x[0], mu: x[1], q2: problem.q2(&x), aside: [0.0; 2], steps, sqp_failed: false };
        self.restore(fit)
    }
}

/// The fit with q2 eliminated: ½-scaled objective xᵀHx − 2 g·x + Σ B2² dᵀ G⁻¹ d over x = (λ, μ), where d is the
/// violation of (9b) by the unconstrained best q2 and G the Gram matrix of the two normals.
struct Reduced<'a> {
    ends: &'a Ends,
    h: Matrix2<f64>,
    g: Vector2<f64>,
    gram_inverse: Matrix2<f64>,
    /// The best q2 for λ = μ = 0.
    q2: Vec3,
}

impl<'a> Reduced<'a> {
    fn new(ends: &'a Ends, samples: [Vec3; SAMPLES]) -> Self {
        let table = &*TABLE;
        let rest: [Vec3; SAMPLES] =
            std::array::from_fn(|j| samples[j] - (table.b[j][3] + table.b[j][4]) * ends.chord);
        let q2 = (0..SAMPLES).map(|j| table.b[j][2] * rest[j]).sum::<Vec3>() / table.b22;
        let mut g = Vector2::zeros();
        for j in 0..SAMPLES {
            let r = rest[j] - table.b[j][2] * q2;
            g += Vector2::new(table.p1[j] * r.dot(&ends.t[0]), table.p3[j] * r.dot(&ends.t[1]));
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let cross = dot(&table.p1, &table.p3) * ends.t[0].dot(&ends.t[1]);
        let h = Matrix2::new(dot(&table.p1, &table.p1), cross, cross, dot(&table.p3, &table.p3));
        let c = ends.n[0].dot(&ends.n[1]);
        let gram = Matrix2::new(1.0 + GRAM_REGULARISATION, c, c, 1.0 + GRAM_REGULARISATION);
        let gram_inverse = gram.try_inverse().unwrap_or_else(Matrix2::identity);
        Self { ends, h, g, gram_inverse, q2 }
    }

    fn free_q2(&self, x: &Vector2<f64>) -> Vec3 {
        self.q2 - TABLE.a * (x[0] * self.ends.t[0] + x[1] * self.ends.t[1])
    }

    fn violation(&self, x: &Vector2<f64>) -> Vector2<f64> {
        self.ends.constraints(&Fit {
            lambda: x[0],
            mu: x[1],
            q2: self.free_q2(x),
            aside: [0.0; 2],
            steps: 0,
            sqp_failed: false,
        })
    }

    /// The best q2 on both planes.
    fn q2(&self, x: &Vector2<f64>) -> Vec3 {
        let y = self.gram_inverse * self.violation(x);
        self.free_q2(x) - y[0] * self.ends.n[0] - y[1] * self.ends.n[1]
    }

    fn objective(&self, x: &Vector2<f64>) -> f64 {
        let d = self.violation(x);
        (x.transpose() * self.h * x)[0] - 2.0 * self.g.dot(x)
            + TABLE.b22 * (d.transpose() * self.gram_inverse * d)[0]
    }

    /// Half the gradient, and half the Gauss–Newton Hessian.
    fn derivatives(&self, x: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let Ends { t, n, .. } = self.ends;
        let k = self.ends.k.map(|k| k[0]);
        let jacobian = Matrix2::new(
            -8.0 / 3.0 * x[0] * k[0],
            -TABLE.a * t[1].dot(&n[0]),
            -TABLE.a * t[0].dot(&n[1]),
            -8.0 / 3.0 * x[1] * k[1],
        );
        let weighted = TABLE.b22 * jacobian.transpose() * self.gram_inverse;
        (self.h * x - self.g + weighted * self.violation(x), self.h + weighted * jacobian)
    }
}
