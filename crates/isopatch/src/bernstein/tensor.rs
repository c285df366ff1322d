//! Tensor-product Bernstein polynomials of three variables on a box, with a bound on what rounding has done to them.
//!
//! A net of degree (l, m, n) lists b_ijk with k fastest. The parameters run from 0 to 1 over the box.

use crate::geom::Interval;

/// A polynomial on a box, as Bernstein coefficients: Σ b_ijk B_i^l(u) B_j^m(v) B_k^n(w).
#[derive(Clone, Debug, PartialEq)]
pub struct TensorNet {
    /// Degrees in u, v, w.
    pub degrees: [usize; 3],
    /// Coefficients, w fastest.
    pub coefficients: Vec<f64>,
    /// No exact coefficient is farther than this from the one that is stored.
    pub error: f64,
}

/// Unit roundoff.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// A step (1 − t) a + t b of floats rounds three times, to at most two units of the larger operand; the rest covers the
/// rounding of the bound itself.
const STEP_ERROR: f64 = 2.5 * ROUNDOFF;

impl TensorNet {
    /// The net of the given coefficients, each within `error` of the exact one. Their number is that of the degrees.
    pub fn new(degrees: [usize; 3], coefficients: Vec<f64>, error: f64) -> Self {
        debug_assert_eq!(coefficients.len(), degrees.iter().map(|n| n + 1).product::<usize>());
        Self { degrees, coefficients, error }
    }

    /// The polynomial times a number.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c *= factor);
        self.error = factor.abs() * self.error * (1.0 + f64::EPSILON) + f64::EPSILON * self.magnitude();
        self
    }

    /// The largest absolute value of a coefficient.
    pub fn magnitude(&self) -> f64 {
        self.coefficients.iter().fold(0.0, |m: f64, c| m.max(c.abs()))
    }

    /// An enclosure of the values on the box: the convex hull of the coefficients.
    pub fn range(&self) -> Interval {
        let (lo, hi) = self
            .coefficients
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &c| (lo.min(c), hi.max(c)));
        Interval::new((lo - self.error).next_down(), (hi + self.error).next_up())
    }

    /// The same polynomial with the degree along `axis` higher by one.
    pub fn elevated(&self, axis: usize) -> Self {
        let (outer, count, inner) = self.layout(axis);
        let mut coefficients = Vec::with_capacity(outer * (count + 1) * inner);
        for block in 0..outer {
            let row = &self.coefficients[block * count * inner..(block + 1) * count * inner];
            for i in 0..=count {
                // b_i = i/(n+1) a_{i−1} + (1 − i/(n+1)) a_i
                let t = i as f64 / count as f64;
                let (before, here) = (i.saturating_sub(1) * inner, i.min(count - 1) * inner);
                let pairs = row[before..before + inner].iter().zip(&row[here..here + inner]);
                coefficients.extend(pairs.map(|(a, b)| t * a + (1.0 - t) * b));
            }
        }
        let mut degrees = self.degrees;
        degrees[axis] += 1;
        // The fraction is rounded as well.
        Self::new(degrees, coefficients, self.error + 2.0 * STEP_ERROR * self.magnitude())
    }

    /// The stride of an axis and the numbers of coefficients before and after it.
    fn layout(&self, axis: usize) -> (usize, usize, usize) {
        let counts = self.degrees.map(|n| n + 1);
        let inner: usize = counts[axis + 1..].iter().product();
        let outer: usize = counts[..axis].iter().product();
        (outer, counts[axis], inner)
    }

    /// The same polynomial on both parts of the box, divided along `axis` at parameter `t` (a float for which 1 − t is
    /// exact), by de Casteljau's algorithm.
    pub fn split(&self, axis: usize, t: f64) -> [Self; 2] {
        let (outer, count, inner) = self.layout(axis);
        let s = 1.0 - t;
        let mut right = self.coefficients.clone();
        let mut left = vec![0.0; right.len()];
        for block in 0..outer {
            let base = block * count * inner;
            let (left, right) =
                (&mut left[base..base + count * inner], &mut right[base..base + count * inner]);
            left[..inner].copy_from_slice(&right[..inner]);
            for level in 1..count {
                for at in 0..(count - level) * inner {
                    right[at] = s * right[at] + t * right[at + inner];
                }
                left[level * inner..(level + 1) * inner].copy_from_slice(&right[..inner]);
            }
        }
        let error = self.error + STEP_ERROR * (count - 1) as f64 * self.magnitude();
        [left, right].map(|coefficients| Self { degrees: self.degrees, coefficients, error })
    }

    /// The derivative by the parameter of `axis`: n (b_{i+1} − b_i), of one degree less. For a constant, zero.
    pub fn derivative(&self, axis: usize) -> Self {
        let (outer, count, inner) = self.layout(axis);
        let degree = (count - 1) as f64;
        if count == 1 {
            return Self::new(self.degrees, vec![0.0; self.coefficients.len()], 0.0);
        }
        let mut coefficients = Vec::with_capacity(outer * (count - 1) * inner);
        for block in 0..outer {
            let base = block * count * inner;
            let row = &self.coefficients[base..base + count * inner];
            coefficients.extend(row.iter().zip(&row[inner..]).map(|(a, b)| degree * (b - a)));
        }
        let mut degrees = self.degrees;
        degrees[axis] -= 1;
        let error = degree * (2.0 * self.error + 2.0 * STEP_ERROR * self.magnitude());
        Self::new(degrees, coefficients, error)
    }

    /// The value at parameters (u, v, w), rounded; its error is at most that of the net and a few roundings of its
    /// magnitude.
    pub fn value(&self, parameters: [f64; 3]) -> f64 {
        let mut values = self.coefficients.clone();
        let mut length = values.len();
        for axis in 0..3 {
            // The axes before this one are evaluated, so this one is the slowest.
            let count = self.degrees[axis] + 1;
            let inner = length / count;
            let t = parameters[axis];
            for level in 1..count {
                for at in 0..(count - level) * inner {
                    values[at] = (1.0 - t) * values[at] + t * values[at + inner];
                }
            }
            length = inner;
        }
        values[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pseudo_random(count: usize) -> Vec<f64> {
        (1..=count).map(|i| (7.3 * i as f64 * i as f64).sin()).collect()
    }

    #[test]
    fn parts_have_the_values_of_the_whole() {
        let net = TensorNet::new([3, 2, 4], pseudo_random(60), 0.0);
        for (axis, t) in [(0, 0.4873046875), (1, 0.25), (2, 0.75)] {
            let [left, right] = net.split(axis, t);
            for q in [[0.1, 0.7, 0.4], [0.9, 0.3, 0.6], [0.0, 1.0, 0.5]] {
                let (mut l, mut r) = (q, q);
                l[axis] *= t;
                r[axis] = t + (1.0 - t) * q[axis];
                assert!((left.value(q) - net.value(l)).abs() < 1e-14);
                assert!((right.value(q) - net.value(r)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_higher_degree_changes_no_value() {
        let net = TensorNet::new([3, 0, 2], pseudo_random(12), 1e-9);
        for axis in 0..3 {
            let higher = net.elevated(axis);
            assert_eq!(higher.degrees[axis], net.degrees[axis] + 1);
            assert!(higher.error >= net.error);
            for q in [[0.1, 0.7, 0.4], [0.9, 0.3, 0.6], [0.0, 1.0, 0.5]] {
                assert!((higher.value(q) - net.value(q)).abs() < 1e-14, "{axis} {q:?}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_difference_quotients() {
        let net = TensorNet::new([3, 0, 2], pseudo_random(12), 0.0);
        let (q, h) = ([0.3, 0.6, 0.7], 1e-6);
        for axis in 0..3 {
            let (mut plus, mut minus) = (q, q);
            plus[axis] += h;
            minus[axis] -= h;
            let quotient = (net.value(plus) - net.value(minus)) / (2.0 * h);
            assert!((net.derivative(axis).value(q) - quotient).abs() < 1e-8, "axis {axis}");
        }
    }

    #[test]
    fn error_bounds_hold_against_exact_arithmetic() {
        use num_rational::BigRational;
        // One variable is enough: the axes do the same steps.
        let net = TensorNet::new([5, 0, 0], pseudo_random(6), 0.0);
        let (mut part, mut exact) = (
            net.clone(),
            net.coefficients.iter().map(|c| BigRational::from_float(*c).unwrap()).collect::<Vec<_>>(),
        );
        let t = 499.0 / 1024.0;
        let (one, exact_t) = (BigRational::from_float(1.0).unwrap(), BigRational::from_float(t).unwrap());
        for step in 0..12 {
            let side = step % 2;
            part = part.split(0, t)[side].clone();
            let mut rows = vec![exact.clone()];
            while let Some(last) = rows.last().filter(|row| row.len() > 1) {
                let next = last.windows(2).map(|w| &w[0] * (&one - &exact_t) + &w[1] * &exact_t).collect();
                rows.push(next);
            }
            exact = if side == 0 {
                rows.iter().map(|row| row[0].clone()).collect()
            } else {
                rows.iter().rev().map(|row| row[row.len() - 1].clone()).collect()
            };
            let bound = BigRational::from_float(part.error).unwrap();
            for (c, e) in part.coefficients.iter().zip(&exact) {
                let off = BigRational::from_float(*c).unwrap() - e;
                assert!(off <= bound && -off <= bound, "step {step}");
            }
        }
    }
}
