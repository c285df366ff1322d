//! All derivatives of a polynomial at a point, up to an order.

use crate::geom::{Mat3, Point3, Vec3};

/// The highest order that is needed: two steps of deflation and their derivatives.
pub(super) const ORDER: usize = 4;

const COUNT: usize = ORDER + 1;

/// The Taylor coefficients at a point: [a][b][c] is ∂^(a+b+c) f / (a! b! c!), for a + b + c up to the order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taylor([[[f64; COUNT]; COUNT]; COUNT]);

impl Taylor {
    /// Of the polynomial with these coefficients, z fastest.
    pub fn of(coefficients: &[f64], degrees: [usize; 3], p: Point3, order: usize) -> Self {
        let [l, m, n] = degrees.map(|d| d + 1);
        let mut result = [[[0.0; COUNT]; COUNT]; COUNT];
        // Along z, then y, then x: Horner's scheme on truncated series.
        let mut along_y = vec![[[0.0; COUNT]; COUNT]; l];
        for i in 0..l {
            for j in (0..m).rev() {
                let row = &coefficients[(i * m + j) * n..(i * m + j + 1) * n];
                let mut series = [0.0; COUNT];
                for &c in row.iter().rev() {
                    advance(&mut series, p.z, order, c);
                }
                for c in 0..=order {
                    let mut column: [f64; COUNT] = std::array::from_fn(|b| along_y[i][b][c]);
                    advance(&mut column, p.y, order - c, series[c]);
                    (0..=order - c).for_each(|b| along_y[i][b][c] = column[b]);
                }
            }
        }
        for i in (0..l).rev() {
            for b in 0..=order {
                for c in 0..=order - b {
                    let mut column: [f64; COUNT] = std::array::from_fn(|a| result[a][b][c]);
                    advance(&mut column, p.x, order - b - c, along_y[i][b][c]);
                    (0..=order - b - c).for_each(|a| result[a][b][c] = column[a]);
                }
            }
        }
        Self(result)
    }

    /// The partial derivative of these orders.
    pub fn derivative(&self, by: [usize; 3]) -> f64 {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        self.0[by[0]][by[1]][by[2]] * by.iter().map(|n| factorial(*n)).product::<f64>()
    }

    /// ∇f.
    pub fn gradient(&self) -> Vec3 {
        Vec3::from_fn(|a, _| self.derivative(unit(a)))
    }

    /// ∇²f.
    pub fn hessian(&self) -> Mat3 {
        Mat3::from_fn(|a, b| self.derivative(sum(unit(a), unit(b))))
    }
}

/// One step of Horner's scheme: series · (p + t) + c.
fn advance(series: &mut [f64; COUNT], p: f64, order: usize, c: f64) {
    for k in (1..=order).rev() {
        series[k] = series[k] * p + series[k - 1];
    }
    series[0] = series[0] * p + c;
}

/// The exponents of coordinate `axis`.
pub(super) fn unit(axis: usize) -> [usize; 3] {
    let mut exponents = [0; 3];
    exponents[axis] = 1;
    exponents
}

/// Exponents of a product.
pub(super) fn sum(a: [usize; 3], b: [usize; 3]) -> [usize; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
