//! Forms on tetrahedra: index order, elevation, quadratic forms.
//!
//! The net of a tetrahedron of degree n lists its coefficients f_ijkl, i + j + k + l = n, by layers of equal l, from the
//! base l = 0 to corner 3 (the apex); layer l is the net of a triangle of degree n − l in the order of
//! [`bernstein`](super). For degree 2:
//!
//! ```text
//! layer 0        0            2000           layer 1     6            1001        layer 2
//!               / \                                     / \
//!              1   2        1100 1010                  7   8        0101 0011        9      0002
//!             / \ / \
//!            3   4   5    0200 0110 0020
//! ```

use super::index;
use nalgebra::DMatrix;

/// Number of coefficients of a tetrahedron of degree `n`.
pub const fn count(n: usize) -> usize {
    (n + 1) * (n + 2) * (n + 3) / 6
}

/// Position of f_ijkl in the net of degree n = i + j + k + l.
pub const fn position([i, j, k, l]: [usize; 4]) -> usize {
    let layer = i + j + k;
    count(layer + l) - count(layer) + index::position([i, j, k])
}

/// All (i, j, k, l) with i + j + k + l = n, in net order.
pub fn indices(n: usize) -> impl Iterator<Item = [usize; 4]> {
    (0..=n).flat_map(move |l| index::indices(n - l).map(move |[i, j, k]| [i, j, k, l]))
}

/// The first `rows` rows and `columns` columns of the matrix that elevates a net of degree n − 1 to degree n:
/// f_λ = Σ_c (λ_c / n) f_(λ − e_c).
pub fn elevation(n: usize, rows: usize, columns: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(rows, columns);
    for (row, ijkl) in indices(n).take(rows).enumerate() {
        for c in (0..4).filter(|c| ijkl[*c] > 0) {
            let mut lower = ijkl;
            lower[c] -= 1;
            let column = position(lower);
            if column < columns {
                matrix[(row, column)] += ijkl[c] as f64 / n as f64;
            }
        }
    }
    matrix
}

/// Value of the quadratic form with the given net, and its derivatives by the four barycentric coordinates.
pub fn quadratic(net: &[f64; 10], b: [f64; 4]) -> (f64, [f64; 4]) {
    let coefficient = |c: usize, d: usize| {
        let mut ijkl = [0; 4];
        ijkl[c] += 1;
        ijkl[d] += 1;
        net[position(ijkl)]
    };
    let partials: [f64; 4] =
        std::array::from_fn(|c| 2.0 * (0..4).map(|d| coefficient(c, d) * b[d]).sum::<f64>());
    let value = 0.5 * (0..4).map(|c| partials[c] * b[c]).sum::<f64>();
    (value, partials)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_number_the_indices() {
        for n in 0..5 {
            let all: Vec<_> = indices(n).collect();
            assert_eq!(all.len(), count(n));
            assert!(all.iter().enumerate().all(|(p, ijkl)| position(*ijkl) == p));
        }
    }

    #[test]
    fn elevation_keeps_constants() {
        for n in 1..4 {
            let matrix = elevation(n, count(n), count(n - 1));
            assert!(matrix.row_iter().all(|row| (row.sum() - 1.0).abs() < 1e-15));
        }
    }

    #[test]
    fn a_quadratic_form_is_the_sum_of_its_terms() {
        let net: [f64; 10] = std::array::from_fn(|i| (i as f64 * 1.7).sin());
        let b: [f64; 4] = [0.3, 0.4, -0.1, 0.4];
        let factorial = |k: usize| if k == 2 { 2.0 } else { 1.0 };
        let sum: f64 = indices(2)
            .zip(net)
            .map(|(ijkl, f)| {
                f * 2.0 * (0..4).map(|c| b[c].powi(ijkl[c] as i32) / factorial(ijkl[c])).product::<f64>()
            })
            .sum();
        let (value, partials) = quadratic(&net, b);
        assert!((value - sum).abs() < 1e-15);
        let h = 1e-6;
        for c in 0..4 {
            let at = |step: f64| {
                let mut moved = b;
                moved[c] += step;
                quadratic(&net, moved).0
            };
            assert!(((at(h) - at(-h)) / (2.0 * h) - partials[c]).abs() < 1e-9);
        }
    }
}
