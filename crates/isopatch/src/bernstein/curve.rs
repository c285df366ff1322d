//! Bézier curves: Bernstein polynomials in one variable.

use crate::geom::Point3;

/// Binomial coefficient, exact for the small arguments of Bernstein polynomials.
pub const fn binomial(n: usize, k: usize) -> f64 {
    let (mut c, mut i) = (1.0, 1);
    while i <= k {
        c = c * (n + 1 - i) as f64 / i as f64;
        i += 1;
    }
    c.round()
}

/// Bernstein polynomials B_0 … B_n of degree n = N − 1 at t.
pub fn basis<const N: usize>(t: f64) -> [f64; N] {
    let mut b = [0.0; N];
    b[0] = 1.0;
    for degree in 1..N {
        for i in (0..=degree).rev() {
            let left = if i > 0 { t * b[i - 1] } else { 0.0 };
            b[i] = (1.0 - t) * b[i] + left;
        }
    }
    b
}

/// Point of a Bézier curve of degree N − 1 at t. O(N²).
pub fn point<const N: usize>(q: &[Point3; N], t: f64) -> Point3 {
    basis::<N>(t).iter().zip(q).map(|(b, q)| *b * q).sum()
}

/// Control points of the same curve in degree N − 1, from those in degree M − 1 ≤ N − 1.
///
/// c_i = Σ_j C(m, j) C(n − m, i − j) / C(n, i) q_j. The ends are copied, so they stay equal bit for bit; so is a
/// coordinate that all points share, so a curve in a plane x, y or z = constant stays in it.
pub fn elevate<const M: usize, const N: usize>(q: &[Point3; M]) -> [Point3; N] {
    let (m, n) = (M - 1, N - 1);
    let shares = const { elevation::<M, N>() };
    let mut c = [Point3::zeros(); N];
    for i in 1..n {
        for j in i.saturating_sub(n - m)..=i.min(m) {
            c[i] += shares[i][j] * q[j];
        }
    }
    for axis in (0..3).filter(|axis| q.iter().all(|p| p[*axis] == q[0][*axis])) {
        c.iter_mut().for_each(|p| p[axis] = q[0][axis]);
    }
    (c[0], c[n]) = (q[0], q[m]);
    c
}

/// What each q_j gives to each c_i inside, see [`elevate`].
const fn elevation<const M: usize, const N: usize>() -> [[f64; M]; N] {
    let (m, n) = (M - 1, N - 1);
    let mut shares = [[0.0; M]; N];
    let mut i = 1;
    while i < n {
        let mut j = i.saturating_sub(n - m);
        while j <= i && j <= m {
            shares[i][j] = binomial(m, j) * binomial(n - m, i - j) / binomial(n, i);
            j += 1;
        }
        i += 1;
    }
    shares
}

/// Control points of the two halves of a Bézier curve, split at t = 1/2.
pub fn split_half<const N: usize>(q: &[Point3; N]) -> ([Point3; N], [Point3; N]) {
    let (mut left, mut right) = (*q, *q);
    for step in 1..N {
        for i in (step..N).rev() {
            left[i] = 0.5 * (left[i - 1] + left[i]);
        }
        for i in 0..N - step {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
    }
    (left, right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quartic() -> [Point3; 5] {
        std::array::from_fn(|i| Point3::new(i as f64, (i * i) as f64 - 1.5, (2.0 + i as f64).sin()))
    }

    #[test]
    fn binomial_coefficients_of_high_degrees_do_not_overflow() {
        assert_eq!(
            [binomial(7, 0), binomial(7, 3), binomial(9, 9), binomial(40, 20)],
            [1.0, 35.0, 1.0, 137846528820.0]
        );
        // C(100, 50), which no 64-bit integer holds.
        assert!((binomial(100, 50) / 1.0089134454556419e29 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn basis_sums_to_one_and_matches_the_definition() {
        for s in 0..=10 {
            let t = s as f64 / 10.0;
            let b = basis::<8>(t);
            assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            for (i, b) in b.iter().enumerate() {
                let exact = binomial(7, i) * t.powi(i as i32) * (1.0 - t).powi(7 - i as i32);
                assert!((b - exact).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_curve_in_a_plane_stays_in_it_bit_for_bit() {
        let plane = 0.9 * std::f64::consts::PI;
        let q = quartic().map(|p| Point3::new(p.x, plane, p.z));
        let (left, right) = split_half(&q);
        assert!(elevate::<5, 8>(&q).iter().chain(&left).chain(&right).all(|p| p.y == plane));
    }

    #[test]
    fn elevation_and_splitting_keep_the_curve() {
        let q = quartic();
        let c = elevate::<5, 8>(&q);
        let (left, right) = split_half(&q);
        for s in 0..=10 {
            let t = s as f64 / 10.0;
            assert!((point(&q, t) - point(&c, t)).norm() < 1e-14);
            assert!((point(&left, t) - point(&q, 0.5 * t)).norm() < 1e-14);
            assert!((point(&right, t) - point(&q, 0.5 + 0.5 * t)).norm() < 1e-14);
        }
        assert_eq!((c[0], c[7]), (q[0], q[4]));
    }
}
