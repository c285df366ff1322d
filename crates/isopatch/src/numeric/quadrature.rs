//! Gauss rules.

use std::f64::consts::PI;

/// Nodes and weights of the Gauss–Legendre rule with `n` points on [0, 1]: exact up to degree 2n − 1.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 1.0;
            // Newton from this guess reaches rounding in a handful of steps for every n in use.
            for _ in 0..10 {
                let (mut p, mut previous) = (x, 1.0);
                for k in 2..=n {
                    let k = k as f64;
                    (p, previous) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * previous) / k, p);
                }
                derivative = n as f64 * (x * p - previous) / (x * x - 1.0);
                x -= p / derivative;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

/// Barycentric nodes and weights (summing to 1) on a triangle, exact up to degree 2n − 2: Gauss points on the
/// collapsed square.
pub fn triangle_gauss(n: usize) -> Vec<([f64; 3], f64)> {
    let line = gauss_legendre(n);
    let mut rule = Vec::with_capacity(n * n);
    for (u, a) in &line {
        for (s, b) in &line {
            let v = s * (1.0 - u);
            rule.push(([*u, v, 1.0 - u - v], 2.0 * a * b * (1.0 - u)));
        }
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legendre_integrates_monomials() {
        for n in 1..12 {
            for degree in 0..2 * n {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-14, "n {n} degree {degree}");
            }
        }
    }

    #[test]
    fn triangle_rule_integrates_monomials() {
        // ∫ u^a v^b w^c = 2 a! b! c! / (a + b + c + 2)! for unit total weight.
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        for (a, b, c) in [(0, 0, 0), (3, 2, 1), (5, 5, 0), (4, 3, 3)] {
            let sum: f64 = triangle_gauss(7)
                .iter()
                .map(|(p, w)| w * p[0].powi(a as i32) * p[1].powi(b as i32) * p[2].powi(c as i32))
                .sum();
            let exact = 2.0 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 2);
            assert!((sum - exact).abs() < 1e-15);
        }
    }
}
