//! Barycentric coordinates of thin tetrahedra.

use crate::geom::{Point3, Vec3};

/// The shortest edges that join the corners of a tetrahedron, as a basis.
///
/// Cells may be ten thousand times as long as wide. Edges between far corners then hardly differ in direction, and products of
/// them lose all digits. The determinant of every three edges that join the corners is the same, so those with the least
/// product of lengths are the most independent: a minimum spanning tree.
#[derive(Clone, Copy, Debug)]
pub struct EdgeBasis {
    /// Corners at the start and the end of each edge.
    edges: [[usize; 2]; 3],
    /// The dual basis: products with the edges are one or zero.
    dual: [Vec3; 3],
}

impl EdgeBasis {
    /// Of a tetrahedron; not finite if that is flat.
    pub fn new(corners: &[Point3; 4]) -> Self {
        let along = |[a, b]: [usize; 2]| corners[b] - corners[a];
        let mut lengths = [[0.0; 4]; 4];
        for [a, b] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            lengths[a][b] = along([a, b]).norm_squared();
            lengths[b][a] = lengths[a][b];
        }
        let mut reached = [true, false, false, false];
        let mut edges = [[0, 0]; 3];
        for shortest in &mut edges {
            // A step of Prim's algorithm.
            let mut least = f64::INFINITY;
            for a in 0..4 {
                for b in 0..4 {
                    if reached[a] & !reached[b] & (lengths[a][b] < least) {
                        (*shortest, least) = ([a, b], lengths[a][b]);
                    }
                }
            }
            reached[shortest[1]] = true;
        }
        let [a, b, c] = [along(edges[0]), along(edges[1]), along(edges[2])];
        let dual = [b.cross(&c), c.cross(&a), a.cross(&b)];
        // The volume is known best from the product of the two longer edges.
        let (_, volume) =
            [a, b, c].iter().zip(&dual).fold((f64::INFINITY, f64::NAN), |shortest, (edge, n)| {
                let length = edge.norm_squared();
                if length < shortest.0 { (length, n.dot(edge)) } else { shortest }
            });
        Self { edges, dual: dual.map(|n| n / volume) }
    }

    /// Gradient of a function from its derivatives by the barycentric coordinates.
    pub fn gradient(&self, d: [f64; 4]) -> Vec3 {
        (0..3).map(|m| (d[self.edges[m][1]] - d[self.edges[m][0]]) * self.dual[m]).sum()
    }

    /// Gradients of the barycentric coordinates.
    pub fn coordinate_gradients(&self) -> [Vec3; 4] {
        let mut gradients = [Vec3::zeros(); 4];
        for ([a, b], dual) in self.edges.into_iter().zip(self.dual) {
            gradients[b] += dual;
            gradients[a] -= dual;
        }
        gradients
    }
}

/// Barycentric coordinates of a point; not finite if the tetrahedron is flat.
pub fn barycentric(corners: &[Point3; 4], x: &Point3) -> [f64; 4] {
    let basis = EdgeBasis::new(corners);
    let mut coordinates = [1.0, 0.0, 0.0, 0.0];
    for ([a, b], dual) in basis.edges.into_iter().zip(basis.dual) {
        let along = dual.dot(&(x - corners[0]));
        coordinates[b] += along;
        coordinates[a] -= along;
    }
    coordinates
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A needle: two corners close together, the others far along nearly the same line. In units of 2⁻³⁰ the coordinates
    /// and the expected values are exact.
    fn needle() -> [Point3; 4] {
        let unit = 2.0f64.powi(-30);
        [
            Point3::new(8.0, -4.0, 2.0),
            Point3::new(9.0, -4.0 + 3.0 * unit, 2.0),
            Point3::new(8.0, -4.0 + unit, 2.0),
            Point3::new(8.375, -4.0, 2.0 + unit),
        ]
    }

    #[test]
    fn coordinates_in_a_needle_keep_their_digits() {
        let corners = needle();
        let x = Point3::new(8.5, -4.0 + 2.0f64.powi(-29), 2.0 + 2.0f64.powi(-29));
        // The apex counts twice, so that 0.5 = λ_1 + 2 · 0.375, and 2 = 3 λ_1 + λ_2 across.
        let expected = [-3.5, -0.25, 2.75, 2.0];
        for (found, expected) in barycentric(&corners, &x).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn gradients_in_a_needle_keep_their_digits() {
        let (corners, g) = (needle(), Vec3::new(0.25, -2.0, 1.0));
        let basis = EdgeBasis::new(&corners);
        // A linear function that is zero where the coordinates are taken from.
        let found = basis.gradient(corners.map(|p| (p - corners[0]).dot(&g)));
        assert!((found - g).norm() < 1e-14, "{found}");
        let by = basis.coordinate_gradients();
        for (c, corner) in corners.iter().enumerate() {
            for (other, from) in corners.iter().enumerate().filter(|(other, _)| *other != c) {
                assert!((by[c].dot(&(corner - from)) - 1.0).abs() < 1e-14, "{c} {other}");
            }
        }
    }

    #[test]
    fn flat_tetrahedra_have_no_coordinates() {
        let flat = [Point3::zeros(), Point3::x(), Point3::y(), Point3::x() + Point3::y()];
        assert!(barycentric(&flat, &Point3::z()).iter().any(|x| !x.is_finite()));
        assert!(barycentric(&[Point3::zeros(); 4], &Point3::z()).iter().any(|x| !x.is_finite()));
    }
}
