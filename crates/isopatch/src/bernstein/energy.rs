//! Symmetric energies of a Bézier triangle, and the control points that minimise them.

use super::{curve, index, triangle};
use nalgebra::{DMatrix, DVector};

/// Matrix E of the thin-plate energy ∫ |b_xx|² + 2 |b_xy|² + |b_yy|² of a net of degree n: energy = cᵀ E c
/// for each coordinate.
///
/// The domain is the equilateral triangle with unit area measure, so that the energy does not depend on which
/// corner comes first. Tong & Kim 2009, eq. (13), is the same integral in (u, v), which is not symmetric
/// (PAPERS.md, misprints and deviations).
pub fn thin_plate(n: usize) -> DMatrix<f64> {
    variation(n, 2)
}

/// Matrix of ∫ |∇ᵏ b|², k = `order`, of a net of degree n, over the same domain: all partial derivatives of order k count,
/// so that the energy does not depend on the direction of the axes either.
pub fn variation(n: usize, order: usize) -> DMatrix<f64> {
    // Sum-zero barycentric directions along an edge of length 1 and perpendicular to it.
    let x = [-1.0, 1.0, 0.0];
    let y = [-1.0, -1.0, 2.0].map(|c| c / 3f64.sqrt());
    let lowest = n - order;
    let products = inner_products(lowest);
    let mut energy = DMatrix::zeros(index::count(n), index::count(n));
    for by_y in 0..=order {
        // Coefficients of a derivative: (its net) × (net).
        let row = |at: usize| {
            let one: Vec<f64> = (0..index::count(lowest)).map(|i| f64::from(u8::from(i == at))).collect();
            let differentiated = |row: Vec<f64>, i| {
                triangle::differentiate_row(lowest + i + 1, &row, if i < by_y { y } else { x })
            };
            DVector::from_vec((0..order).fold(one, differentiated)).transpose()
        };
        let rows: Vec<_> = (0..index::count(lowest)).map(row).collect();
        let derivative = DMatrix::from_rows(&rows);
        energy += curve::binomial(order, by_y) * derivative.tr_mul(&(&products * &derivative));
    }
    energy
}

/// Means of the products of Bernstein polynomials of degree n over a triangle: B_a B_b is the polynomial with index a + b of
/// degree 2n times Π C(a_c + b_c, a_c) / C(2n, n), and each of these has the mean 1 / C(2n + 2, 2).
fn inner_products(n: usize) -> DMatrix<f64> {
    let indices: Vec<[usize; 3]> = index::indices(n).collect();
    let scale = curve::binomial(2 * n, n) * curve::binomial(2 * n + 2, 2);
    DMatrix::from_fn(indices.len(), indices.len(), |a, b| {
        (0..3).map(|c| curve::binomial(indices[a][c] + indices[b][c], indices[a][c])).product::<f64>() / scale
    })
}

/// The matrix that gives the interior control points of least thin-plate energy from the boundary ones:
/// (interior) × (boundary), both in net order. Its rows sum to one.
pub fn thin_plate_fill(n: usize) -> DMatrix<f64> {
    fill(n, 2, |ijk| !index::is_boundary(ijk))
}

/// The matrix that gives the control points that are `free`, with the least [`variation`] of the given order, from the
/// others: (free) × (others), both in net order. Zero if the others do not determine them.
///
/// Polynomials of a degree below the order are reproduced.
pub fn fill(n: usize, order: usize, free: impl Fn([usize; 3]) -> bool) -> DMatrix<f64> {
    least(&variation(n, order), n, free)
}

/// The same with the least of an energy, cᵀ E c for each coordinate.
pub fn least(energy: &DMatrix<f64>, n: usize, free: impl Fn([usize; 3]) -> bool) -> DMatrix<f64> {
    let (free, others): (Vec<_>, Vec<_>) = index::indices(n).partition(|ijk| free(*ijk));
    let block = |rows: &[[usize; 3]], columns: &[[usize; 3]]| {
        DMatrix::from_fn(rows.len(), columns.len(), |r, c| {
            energy[(index::position(rows[r]), index::position(columns[c]))]
        })
    };
    let solved = block(&free, &free).lu().solve(&block(&free, &others));
    -solved.unwrap_or_else(|| DMatrix::zeros(free.len(), others.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_nets_have_no_energy_and_quadratic_ones_the_exact_one() {
        let n = 7;
        let energy = thin_plate(n);
        let linear = DVector::from_iterator(36, index::indices(n).map(|[i, j, _]| i as f64 - 2.0 * j as f64));
        assert!((&energy * &linear).norm() < 1e-9);
        // u² has second derivatives 2 ∂u∂u with ∂x u = −1, ∂y u = −1/√3: (∂x² + ∂y²)² · 4 = 64/9.
        let square =
            index::indices(n).map(|[i, _, _]| (i * i.saturating_sub(1)) as f64 / (n * (n - 1)) as f64);
        let square = DVector::from_iterator(36, square);
        assert!(((square.transpose() * &energy * &square)[0] - 64.0 / 9.0).abs() < 1e-10);
    }

    #[test]
    fn the_energy_does_not_prefer_a_corner() {
        let energy = thin_plate(7);
        let turn = |[i, j, k]: [usize; 3]| index::position([j, k, i]);
        for a in index::indices(7) {
            for b in index::indices(7) {
                let here = energy[(index::position(a), index::position(b))];
                assert!((here - energy[(turn(a), turn(b))]).abs() < 1e-9 * energy.amax());
            }
        }
    }

    #[test]
    fn the_fill_is_stationary_and_reproduces_linear_functions() {
        let n = 7;
        let (fill, energy) = (thin_plate_fill(n), thin_plate(n));
        assert_eq!(fill.shape(), (15, 21));
        let linear = |[i, j, _]: [usize; 3]| i as f64 - 2.0 * j as f64;
        let wild = |[i, j, k]: [usize; 3]| (3.0 * i as f64).sin() + (j * k) as f64 + (j as f64).cos();
        let net = |value: &dyn Fn([usize; 3]) -> f64| {
            let boundary = index::indices(n).filter(|i| index::is_boundary(*i)).map(value);
            let interior = &fill * DVector::from_iterator(21, boundary);
            let mut interior = interior.iter();
            DVector::from_iterator(
                36,
                index::indices(n)
                    .map(|i| if index::is_boundary(i) { value(i) } else { *interior.next().unwrap() }),
            )
        };
        let filled = net(&linear);
        assert!(index::indices(n).zip(filled.iter()).all(|(i, got)| (got - linear(i)).abs() < 1e-11));
        let gradient = &energy * net(&wild);
        let inside = index::indices(n).filter(|i| !index::is_boundary(*i));
        assert!(inside.map(|i| gradient[index::position(i)]).all(|g| g.abs() < 1e-8 * energy.amax()));
    }
}
