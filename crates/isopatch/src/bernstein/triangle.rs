//! Bézier triangles: Bernstein polynomials in barycentric coordinates.

use super::index;
use crate::geom::{Point3, Vec3};
use nalgebra::DMatrix;

/// A point of a patch with its derivatives by u (towards corner 0 from corner 2) and v (towards corner 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangents {
    /// b(u, v, w).
    pub point: Point3,
    /// ∂b/∂u with w = 1 − u − v.
    pub du: Vec3,
    /// ∂b/∂v with w = 1 − u − v.
    pub dv: Vec3,
}

/// Largest degree that [`evaluate`] takes.
pub const MAX_DEGREE: usize = 9;

/// Point and derivatives of a Bézier triangle of degree `n` ≥ 1 at barycentric (u, v, 1 − u − v).
///
/// De Casteljau's algorithm has three points left before its last step; here they are computed as sums with
/// Bernstein polynomials of degree n − 1: O(n²) operations, no allocation.
///
/// # Panics
/// If the net has not [`index::count`]`(n)` points or n is 0 or larger than [`MAX_DEGREE`].
pub fn evaluate(n: usize, net: &[Point3], [u, v]: [f64; 2]) -> Tangents {
    let w = 1.0 - u - v;
    let [of_u, of_v, of_w] = [u, v, w].map(powers);
    let mut b = [Point3::zeros(); 3];
    let mut p = 0;
    for row in 0..n {
        for k in 0..=row {
            let count = BINOMIALS[n - 1][row] * BINOMIALS[row][k];
            let weight = count * of_u[n - 1 - row] * of_v[row - k] * of_w[k];
            // Raised by one in u, v and w, an index stands at p, p + row + 1 and p + row + 2 of the larger net.
            b[0] += weight * net[p];
            b[1] += weight * net[p + row + 1];
            b[2] += weight * net[p + row + 2];
            p += 1;
        }
    }
    let n = n as f64;
    Tangents { point: u * b[0] + v * b[1] + w * b[2], du: n * (b[0] - b[2]), dv: n * (b[1] - b[2]) }
}

/// x⁰, x¹, … below [`MAX_DEGREE`].
fn powers(x: f64) -> [f64; MAX_DEGREE] {
    let mut powers = [1.0; MAX_DEGREE];
    for i in 1..MAX_DEGREE {
        powers[i] = x * powers[i - 1];
    }
    powers
}

/// Binomial coefficients (n over k) below [`MAX_DEGREE`].
pub(super) const BINOMIALS: [[f64; MAX_DEGREE]; MAX_DEGREE] = {
    let mut rows = [[0.0; MAX_DEGREE]; MAX_DEGREE];
    let mut n = 0;
    while n < MAX_DEGREE {
        rows[n][0] = 1.0;
        let mut k = 1;
        while k <= n {
            rows[n][k] = rows[n - 1][k - 1] + rows[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    rows
};

/// All Bernstein polynomials of degree n at barycentric coordinates, in net order.
pub fn basis(n: usize, uvw: [f64; 3]) -> Vec<f64> {
    let factorial = |k: usize| (1..=k).product::<usize>() as f64;
    index::indices(n)
        .map(|ijk| {
            let powers: f64 = (0..3).map(|c| uvw[c].powi(ijk[c] as i32) / factorial(ijk[c])).product();
            factorial(n) * powers
        })
        .collect()
}

/// Rows of the linear map from a net of degree n to the derivative by the direction (a sum-zero barycentric
/// vector) at a point: n Σ_c e_c B^{n−1} shifted by one in coordinate c.
pub fn derivative_basis(n: usize, uvw: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
    differentiate_row(n, &basis(n - 1, uvw), direction)
}

/// The row for the derivative of a net of degree n by a direction, from the row of what is taken of the derivative's net,
/// which has degree n − 1.
pub fn differentiate_row(n: usize, lower: &[f64], direction: [f64; 3]) -> Vec<f64> {
    let mut row = vec![0.0; index::count(n)];
    for (ijk, b) in index::indices(n - 1).zip(lower) {
        for c in 0..3 {
            let mut raised = ijk;
            raised[c] += 1;
            row[index::position(raised)] += n as f64 * direction[c] * b;
        }
    }
    row
}

/// Barycentric lattice points (i, j, k)/n, in net order.
pub fn lattice(n: usize) -> Vec<[f64; 3]> {
    index::indices(n).map(|ijk| ijk.map(|c| c as f64 / n as f64)).collect()
}

/// The points of [`lattice`] that are not on the boundary.
pub fn interior_lattice(n: usize) -> Vec<[f64; 3]> {
    let inside = index::indices(n).filter(|ijk| !index::is_boundary(*ijk));
    inside.map(|ijk| ijk.map(|c| c as f64 / n as f64)).collect()
}

/// Matrix of [`basis`] rows at many points: (points) × (coefficients).
pub fn basis_matrix(n: usize, points: &[[f64; 3]]) -> DMatrix<f64> {
    let rows: Vec<f64> = points.iter().flat_map(|p| basis(n, *p)).collect();
    DMatrix::from_row_slice(points.len(), index::count(n), &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net() -> Vec<Point3> {
        let value = |s: f64| (s * 12.9898).sin() * 2.0;
        (0..36).map(|i| Point3::new(value(i as f64), value(i as f64 + 0.3), value(i as f64 + 0.7))).collect()
    }

    #[test]
    fn evaluation_agrees_with_the_bernstein_sum() {
        let net = net();
        for uvw in lattice(6) {
            let t = evaluate(7, &net, [uvw[0], uvw[1]]);
            let sum = |row: Vec<f64>| row.iter().zip(&net).map(|(b, p)| *b * p).sum::<Point3>();
            assert!((t.point - sum(basis(7, uvw))).norm() < 1e-13);
            assert!((t.du - sum(derivative_basis(7, uvw, [1.0, 0.0, -1.0]))).norm() < 1e-12);
            assert!((t.dv - sum(derivative_basis(7, uvw, [0.0, 1.0, -1.0]))).norm() < 1e-12);
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (net, h) = (net(), 1e-6);
        let at = |u, v| evaluate(7, &net, [u, v]);
        let (u, v) = (0.31, 0.22);
        let t = at(u, v);
        assert!(((at(u + h, v).point - at(u - h, v).point) / (2.0 * h) - t.du).norm() < 1e-7);
        assert!(((at(u, v + h).point - at(u, v - h).point) / (2.0 * h) - t.dv).norm() < 1e-7);
    }

    #[test]
    fn lattices_have_the_right_sizes() {
        assert_eq!(lattice(8).len(), 45);
        assert_eq!(interior_lattice(8).len(), 21);
        assert!(interior_lattice(8).iter().all(|p| (p.iter().sum::<f64>() - 1.0).abs() < 1e-15));
    }
}
