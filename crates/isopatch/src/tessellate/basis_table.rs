use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Vec3};

/// Bernstein polynomials and their derivatives at the points of a lattice, tabulated once for all patches.
#[derive(Clone, Debug)]
pub struct BasisTable {
    coefficients: usize,
    /// Per lattice point and coefficient: weight in the point, in ∂/∂u and in ∂/∂v.
    weights: Vec<[f64; 3]>,
}

impl BasisTable {
    /// The table for nets of degree `degree` ≥ 1 at the lattice points (i, j, k)/`resolution`, both in net order.
    pub fn new(degree: usize, resolution: usize) -> Self {
        let mut weights = Vec::with_capacity(index::count(degree) * index::count(resolution));
        for uvw in triangle::lattice(resolution) {
            let value = triangle::basis(degree, uvw);
            let du = triangle::derivative_basis(degree, uvw, [1.0, 0.0, -1.0]);
            let dv = triangle::derivative_basis(degree, uvw, [0.0, 1.0, -1.0]);
            weights.extend(value.iter().zip(&du).zip(&dv).map(|((b, u), v)| [*b, *u, *v]));
        }
        Self { coefficients: index::count(degree), weights }
    }

    /// Point and derivatives of a net at lattice point number `at`.
    ///
    /// # Panics
    /// If `at` is not a point of the lattice.
    pub fn evaluate(&self, net: &[Point3], at: usize) -> triangle::Tangents {
        let (mut point, mut du, mut dv) = (Point3::zeros(), Vec3::zeros(), Vec3::zeros());
        let row = &self.weights[at * self.coefficients..(at + 1) * self.coefficients];
        for ([b, bu, bv], c) in row.iter().zip(net) {
            point += *b * c;
            du += *bu * c;
            dv += *bv * c;
        }
        triangle::Tangents { point, du, dv }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_agrees_with_de_casteljau() {
        let net: Vec<Point3> =
            (0..36).map(|i| Point3::new((i as f64).sin(), (2.0 * i as f64).cos(), 0.1 * i as f64)).collect();
        let table = BasisTable::new(7, 5);
        for (at, [u, v, _]) in triangle::lattice(5).into_iter().enumerate() {
            let (a, b) = (table.evaluate(&net, at), triangle::evaluate(7, &net, [u, v]));
            assert!((a.point - b.point).norm() < 1e-14);
            assert!((a.du - b.du).norm() + (a.dv - b.dv).norm() < 1e-12);
        }
    }

    #[test]
    fn corners_are_exact() {
        let net: Vec<Point3> = (0..36).map(|i| Point3::repeat(0.1 + i as f64 / 3.0)).collect();
        let table = BasisTable::new(7, 4);
        for (at, c) in [(0, 0), (10, 28), (14, 35)] {
            assert_eq!(table.evaluate(&net, at).point, net[c]);
        }
    }
}
