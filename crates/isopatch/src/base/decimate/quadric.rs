//! Sums of squared distances as quadratic functions.

use crate::geom::{Point3, Vec3};

/// The quadratic function xᵀ A x − 2 bᵀ x + c: weighted sum of squared distances to planes and points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadric {
    /// A₀₀, A₁₁, A₂₂.
    diagonal: Vec3,
    /// A₁₂, A₂₀, A₀₁: the entry at axis i has the other two as indices.
    mixed: Vec3,
    b: Vec3,
    c: f64,
}

impl Quadric {
    pub const ZERO: Self = Self {
        diagonal: Vec3::new(0.0, 0.0, 0.0),
        mixed: Vec3::new(0.0, 0.0, 0.0),
        b: Vec3::new(0.0, 0.0, 0.0),
        c: 0.0,
    };

    /// weight · ((x − p)·n)² + weight · pull · |x − p|².
    pub fn plane(p: &Point3, n: &Vec3, weight: f64, pull: f64) -> Self {
        let diagonal = weight * n.component_mul(n).add_scalar(pull);
        let mixed = weight * Vec3::new(n.y * n.z, n.z * n.x, n.x * n.y);
        let quadric = Self { diagonal, mixed, ..Self::ZERO };
        let b = quadric.times(p);
        Self { b, c: p.dot(&b), ..quadric }
    }

    pub fn plus(&self, other: &Self) -> Self {
        Self {
            diagonal: self.diagonal + other.diagonal,
            mixed: self.mixed + other.mixed,
            b: self.b + other.b,
            c: self.c + other.c,
        }
    }

    fn columns(&self) -> [Vec3; 3] {
        let (d, m) = (&self.diagonal, &self.mixed);
        [Vec3::new(d.x, m.z, m.y), Vec3::new(m.z, d.y, m.x), Vec3::new(m.y, m.x, d.z)]
    }

    /// A x.
    fn times(&self, x: &Vec3) -> Vec3 {
        let [p, q, r] = self.columns();
        x.x * p + x.y * q + x.z * r
    }

    pub fn at(&self, x: &Point3) -> f64 {
        x.dot(&(self.times(x) - 2.0 * self.b)) + self.c
    }

    /// A⁻¹ b, by the columns' cross products.
    pub fn minimum(&self) -> Option<Point3> {
        let [p, q, r] = self.columns();
        let qr = q.cross(&r);
        let x = Vec3::new(qr.dot(&self.b), r.cross(&p).dot(&self.b), p.cross(&q).dot(&self.b)) / p.dot(&qr);
        x.iter().all(|c| c.is_finite()).then_some(x)
    }

    /// The minimum with one coordinate given.
    pub fn minimum_within(&self, axis: usize, value: f64) -> Option<Point3> {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let (p, q, r) = (self.diagonal[i], self.diagonal[j], self.mixed[axis]);
        let b = [self.b[i] - self.mixed[j] * value, self.b[j] - self.mixed[i] * value];
        let determinant = p * q - r * r;
        let mut x = Point3::repeat(value);
        x[i] = (b[0] * q - b[1] * r) / determinant;
        x[j] = (b[1] * p - b[0] * r) / determinant;
        x.iter().all(|c| c.is_finite()).then_some(x)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_in_the_minimum() {
        let corner = Vec3::new(0.3, -0.2, 0.5);
        let normals = [Vec3::new(1.0, 0.2, 0.1), Vec3::new(-0.3, 1.0, 0.4), Vec3::new(0.2, -0.1, 1.0)];
        let planes = normals.map(|n| Quadric::plane(&corner, &n.normalize(), 2.0, 0.0));
        let sum = planes.iter().fold(Quadric::ZERO, |sum, q| sum.plus(q));
        assert!((sum.minimum().unwrap() - corner).norm() < 1e-14 && sum.at(&corner).abs() < 1e-15);
        assert_eq!(Quadric::plane(&corner, &Vec3::z(), 1.0, 0.0).minimum(), None);
    }

    #[test]
    fn distances_are_those_to_plane_and_point() {
        let (p, n, weight, pull) = (Vec3::new(1.0, 2.0, -0.5), Vec3::new(0.6, 0.0, 0.8), 3.0, 0.25);
        let quadric = Quadric::plane(&p, &n, weight, pull);
        let x = Vec3::new(-0.7, 0.4, 0.9);
        let expected = weight * ((x - p).dot(&n).powi(2) + pull * (x - p).norm_squared());
        assert!((quadric.at(&x) - expected).abs() < 1e-13);
        for axis in 0..3 {
            let least = quadric.minimum_within(axis, 0.1).unwrap();
            assert_eq!(least[axis], 0.1);
            for other in (0..3).filter(|other| *other != axis) {
                let mut step = Vec3::zeros();
                step[other] = 1e-3;
                let beside = [1.0, -1.0].map(|sign| quadric.at(&(least + sign * step)));
                assert!((beside[0] - beside[1]).abs() < 1e-14, "the slope vanishes");
            }
        }
    }
}
