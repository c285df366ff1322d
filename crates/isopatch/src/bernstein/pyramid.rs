//! Forms on pyramids [p_0 p_1 p_2 p_3 p_4]: index order, evaluation, elevation, and what joins them to tetrahedra.
//!
//! A point of the pyramid is (2.6)
//!
//! ```text
//! u p_0 + (1 − u) (t (s p_1 + (1 − s) p_2) + (1 − t) (s p_3 + (1 − s) p_4))       p_3 ───── p_4   t = 0
//!                                                                                  │         │
//! so that p_1 p_2 p_4 p_3 is the cyclic order of the base.                        p_1 ───── p_2   t = 1
//!                                                                                s = 1     s = 0
//! ```
//!
//! The net of degree n lists its coefficients b_ijk, i ≤ n and j, k ≤ n − i, by layers of equal i from the base i = 0 to the
//! apex; layer i is the net of a tensor product of degree n − i, by rising j, then rising k:
//!
//! ```text
//! Σ_i B_i^n(u) Σ_j Σ_k b_ijk B_j^(n−i)(s) B_k^(n−i)(t)                                                        (2.5)
//! ```
//!
//! The paper prints k ≤ n − i − j, which holds too few coefficients for a cubic function of the point.

use super::tetrahedron;
use crate::geom::{Mat3, Point3};

/// Number of coefficients of a pyramid of degree `n`: 30 for cubics.
pub const fn count(n: usize) -> usize {
    (n + 1) * (n + 2) * (2 * n + 3) / 6
}

/// Position of b_ijk in the net of degree `n`.
pub const fn position(n: usize, [i, j, k]: [usize; 3]) -> usize {
    let side = n - i + 1;
    // The layers from i on are the net of a pyramid of degree n − i.
    count(n) - count(n - i) + j * side + k
}

/// All (i, j, k) of degree `n`, in net order.
pub fn indices(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=n).flat_map(move |i| (0..=n - i).flat_map(move |j| (0..=n - i).map(move |k| [i, j, k])))
}

fn factorial(n: usize) -> f64 {
    (2..=n).map(|k| k as f64).product()
}

fn choose(n: usize, k: usize) -> f64 {
    factorial(n) / (factorial(k) * factorial(n - k))
}

/// B_i^n(t).
fn basis(n: usize, i: usize, t: f64) -> f64 {
    choose(n, i) * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32)
}

/// The derivative of B_i^n(t).
fn basis_slope(n: usize, i: usize, t: f64) -> f64 {
    let lower = |i: Option<usize>| i.filter(|i| *i < n).map_or(0.0, |i| basis(n - 1, i, t));
    n as f64 * (lower(i.checked_sub(1)) - lower(Some(i)))
}

/// The Bernstein polynomial of a tetrahedron with the index, at barycentric coordinates x.
fn basis_of_tetrahedron(ijkl: [usize; 4], x: &[f64; 4]) -> f64 {
    let n: usize = ijkl.iter().sum();
    (0..4).map(|c| x[c].powi(ijkl[c] as i32) / factorial(ijkl[c])).product::<f64>() * factorial(n)
}

/// The form at (u, s, t) (2.5).
pub fn value(n: usize, net: &[f64], [u, s, t]: [f64; 3]) -> f64 {
    let term =
        |(b, [i, j, k]): (&f64, [usize; 3])| b * basis(n, i, u) * basis(n - i, j, s) * basis(n - i, k, t);
    net.iter().zip(indices(n)).map(term).sum()
}

/// Derivatives of the form by u, s and t.
pub fn derivatives(n: usize, net: &[f64], [u, s, t]: [f64; 3]) -> [f64; 3] {
    let mut d = [0.0; 3];
    for (b, [i, j, k]) in net.iter().zip(indices(n)) {
        let [bu, bs, bt] = [basis(n, i, u), basis(n - i, j, s), basis(n - i, k, t)];
        d[0] += b * basis_slope(n, i, u) * bs * bt;
        d[1] += b * bu * basis_slope(n - i, j, s) * bt;
        d[2] += b * bu * bs * basis_slope(n - i, k, t);
    }
    d
}

/// The point at (u, s, t) (2.6).
pub fn point(p: &[Point3; 5], [u, s, t]: [f64; 3]) -> Point3 {
    let base = t * (s * p[1] + (1.0 - s) * p[2]) + (1.0 - t) * (s * p[3] + (1.0 - s) * p[4]);
    u * p[0] + (1.0 - u) * base
}

/// Derivatives of the point by u, s and t, in columns; singular at the apex.
pub fn jacobian(p: &[Point3; 5], [u, s, t]: [f64; 3]) -> Mat3 {
    let base = point(p, [0.0, s, t]);
    let by_s = t * (p[1] - p[2]) + (1.0 - t) * (p[3] - p[4]);
    let by_t = s * (p[1] - p[3]) + (1.0 - s) * (p[2] - p[4]);
    Mat3::from_columns(&[p[0] - base, (1.0 - u) * by_s, (1.0 - u) * by_t])
}

/// The same form as one of degree n (2.10), of one of degree n − 1.
pub fn elevated(n: usize, net: &[f64]) -> Vec<f64> {
    let coefficient = |[i, j, k]: [usize; 3]| {
        let inside = i < n && j < n - i && k < n - i;
        if inside { net[position(n - 1, [i, j, k])] } else { 0.0 }
    };
    indices(n)
        .map(|[i, j, k]| {
            let from_above = if i > 0 { i as f64 / n as f64 * coefficient([i - 1, j, k]) } else { 0.0 };
            let (m, mut rest) = (n - i, 0.0);
            for (dj, along_s) in [(1, j), (0, m - j)] {
                for (dk, along_t) in [(1, k), (0, m - k)] {
                    if j >= dj && k >= dk {
                        rest += (along_s * along_t) as f64 * coefficient([i, j - dj, k - dk]);
                    }
                }
            }
            from_above + if m > 0 { rest / (n * m) as f64 } else { 0.0 }
        })
        .collect()
}

/// The form of a tetrahedron [p_1 p_2 p_3 p_0] as one on the pyramid, where p_4 has barycentric coordinates `p4` in the
/// tetrahedron (4.5).
///
/// Indices belong to corners in the order p_1, p_2, p_3, p_0; the paper prints p_4 = a_1 u + …, which is not that order.
pub fn from_tetrahedron(n: usize, net: &[f64], p4: &[f64; 4]) -> Vec<f64> {
    let coefficient = |[i, j, k]: [usize; 3]| {
        let m = n - i;
        let mut sum = 0.0;
        // λ counts s t, k − λ counts (1 − s) t, j − λ counts s (1 − t), and what remains (1 − s)(1 − t).
        for both in (j + k).saturating_sub(m)..=j.min(k) {
            let (at_p2, at_p3, at_p4) = (k - both, j - both, m + both - j - k);
            let ways = factorial(m)
                / (factorial(both) * factorial(at_p2) * factorial(at_p3) * factorial(at_p4))
                / (choose(m, k) * choose(m, j));
            let restricted = tetrahedron::indices(at_p4).map(|c| {
                net[tetrahedron::position([c[0] + both, c[1] + at_p2, c[2] + at_p3, c[3] + i])]
                    * basis_of_tetrahedron(c, p4)
            });
            sum += ways * restricted.sum::<f64>();
        }
        sum
    };
    indices(n).map(coefficient).collect()
}

/// The coefficient b_ijk of a form on a pyramid that continues the form of a tetrahedron [q_1 p_2 p_4 p_0] across their common
/// face (2.7). With those for all j ≤ K it is C^K there, but for p_0 (Theorem 2.1).
///
/// `p1` and `p3` are barycentric coordinates in the tetrahedron.
pub fn continued(n: usize, net: &[f64], [p1, p3]: [&[f64; 4]; 2], [i, j, k]: [usize; 3]) -> f64 {
    let m = n - i;
    let mut sum = 0.0;
    for at_p2 in k.saturating_sub(j)..=k.min(m - j) {
        let (at_p1, at_p3, at_p4) = (k - at_p2, j + at_p2 - k, m - j - at_p2);
        let ways = choose(k, at_p2) * choose(m - k, at_p4) / choose(m, m - j);
        for a in tetrahedron::indices(at_p1) {
            for b in tetrahedron::indices(at_p3) {
                let ijkl = [a[0] + b[0], a[1] + b[1] + at_p2, a[2] + b[2] + at_p4, a[3] + b[3] + i];
                sum += ways
                    * net[tetrahedron::position(ijkl)]
                    * basis_of_tetrahedron(a, p1)
                    * basis_of_tetrahedron(b, p3);
            }
        }
    }
    sum
}

/// The coefficients b_i0k and b_i1k by Corollary 2.1 (2.9): what C1 across the face s = 0 asks for.
pub fn continued_c1(n: usize, net: &[f64], [p1, p3]: [&[f64; 4]; 2], [i, j, k]: [usize; 3]) -> f64 {
    let m = n - i;
    let at = |ijkl: [usize; 4]| net[tetrahedron::position(ijkl)];
    if j == 0 {
        return at([0, k, m - k, i]);
    }
    let towards = |x: &[f64; 4], rest: [usize; 4]| -> f64 {
        (0..4)
            .map(|l| {
                let mut ijkl = rest;
                ijkl[l] += 1;
                x[l] * at(ijkl)
            })
            .sum()
    };
    let from_p1 = if k > 0 { k as f64 * towards(p1, [0, k - 1, m - k, i]) } else { 0.0 };
    let from_p3 = if k < m { (m - k) as f64 * towards(p3, [0, k, m - k - 1, i]) } else { 0.0 };
    (from_p1 + from_p3) / m as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;

    fn noise(seed: usize) -> f64 {
        (12.9898 * seed as f64 + 0.7).sin()
    }

    fn corners() -> [Point3; 5] {
        [[0.1, 0.2, 1.1], [1.0, 0.9, 0.1], [-1.1, 1.0, 0.0], [0.9, -1.0, -0.1], [-1.0, -0.8, 0.2]]
            .map(|[x, y, z]| Vec3::new(x, y, z))
    }

    fn barycentric(corners: [Point3; 4], x: &Point3) -> [f64; 4] {
        let [a, b, c, d] = corners;
        let r =
            Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse().unwrap_or_else(Mat3::zeros) * (x - a);
        [1.0 - r.sum(), r.x, r.y, r.z]
    }

    fn of_tetrahedron(n: usize, net: &[f64], x: &[f64; 4]) -> f64 {
        tetrahedron::indices(n).zip(net).map(|(c, f)| f * basis_of_tetrahedron(c, x)).sum()
    }

    #[test]
    fn positions_number_the_indices() {
        assert_eq!([count(0), count(1), count(2), count(3)], [1, 5, 14, 30]);
        for n in 0..5 {
            assert!(indices(n).enumerate().all(|(p, ijk)| position(n, ijk) == p));
            assert_eq!(indices(n).count(), count(n));
        }
    }

    #[test]
    fn derivatives_are_those_of_the_value() {
        let net: Vec<f64> = (0..30).map(noise).collect();
        let (at, h) = ([0.3, 0.4, 0.8], 1e-6);
        let d = derivatives(3, &net, at);
        let columns = jacobian(&corners(), at);
        for c in 0..3 {
            let moved = |step: f64| {
                let mut moved = at;
                moved[c] += step;
                moved
            };
            let slope = (value(3, &net, moved(h)) - value(3, &net, moved(-h))) / (2.0 * h);
            assert!((slope - d[c]).abs() < 1e-8);
            let way = (point(&corners(), moved(h)) - point(&corners(), moved(-h))) / (2.0 * h);
            assert!((way - columns.column(c)).norm() < 1e-8);
        }
    }

    #[test]
    fn elevation_and_conversion_keep_the_function() {
        let p = corners();
        let at_p4 = barycentric([p[1], p[2], p[3], p[0]], &p[4]);
        for n in 1..5 {
            let tet: Vec<f64> = (0..tetrahedron::count(n)).map(noise).collect();
            let net = from_tetrahedron(n, &tet, &at_p4);
            let up = elevated(n + 1, &net);
            for sample in 0..9 {
                let ust = [0, 1, 2].map(|c| 0.5 + 0.6 * noise(3 * sample + c));
                let x = barycentric([p[1], p[2], p[3], p[0]], &point(&p, ust));
                let exact = of_tetrahedron(n, &tet, &x);
                assert!((value(n, &net, ust) - exact).abs() < 1e-11, "{n}");
                assert!((value(n + 1, &up, ust) - exact).abs() < 1e-11, "{n}");
            }
        }
    }

    /// Theorem 2.1: with the coefficients of the first K + 1 rows, all derivatives up to K agree on the common face; those of the
    /// other rows do not matter. Corollary 2.1 is its case K = 1.
    #[test]
    fn continued_forms_join_smoothly() {
        let p = corners();
        let q1 = Vec3::new(-2.0, 0.3, 0.4);
        let tetra = [q1, p[2], p[4], p[0]];
        let [p1, p3] = [&p[1], &p[3]].map(|x| barycentric(tetra, x));
        let n = 3;
        let net: Vec<f64> = (0..20).map(noise).collect();
        let whole: Vec<f64> = indices(n).map(|ijk| continued(n, &net, [&p1, &p3], ijk)).collect();
        let difference = |form: &[f64], ust: [f64; 3]| {
            value(n, form, ust) - of_tetrahedron(n, &net, &barycentric(tetra, &point(&p, ust)))
        };
        // All rows: the same function everywhere.
        assert!(difference(&whole, [0.2, 0.7, 0.4]).abs() < 1e-11);
        for smooth in 0..3usize {
            let form: Vec<f64> =
                indices(n).zip(&whole).map(|(ijk, b)| if ijk[1] <= smooth { *b } else { b + 1.0 }).collect();
            // The difference grows as s to the power K + 1.
            for (u, t) in [(0.1, 0.3), (0.5, 0.9), (0.3, 0.0)] {
                let [near, far] = [1e-3, 2e-3].map(|s| difference(&form, [u, s, t]));
                assert!((far / near).log2() > smooth as f64 + 0.9, "{smooth} {near:e} {far:e}");
                assert!(near.abs() > 1e-12);
            }
        }
        for ijk in indices(n).filter(|ijk| ijk[1] <= 1 && (ijk[1] == 0 || ijk[0] < n)) {
            let by_corollary = continued_c1(n, &net, [&p1, &p3], ijk);
            assert!((by_corollary - continued(n, &net, [&p1, &p3], ijk)).abs() < 1e-12);
        }
    }
}
