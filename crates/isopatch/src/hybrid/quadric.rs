use crate::geom::{Mat3, Point3, Vec3};

/// A quadratic function q_0 + g·x + x·Hx/2 of x = (p − center)/scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    /// q_0; g_x, g_y, g_z; H_xx, H_yy, H_zz, H_xy, H_xz, H_yz.
    pub coefficients: [f64; 10],
    /// Where x is zero.
    pub center: Point3,
    /// The length that is one.
    pub scale: f64,
}

impl Quadric {
    /// The function that vanishes everywhere.
    pub const ZERO: Self = Self { coefficients: [0.0; 10], center: Vec3::new(0.0, 0.0, 0.0), scale: 1.0 };

    fn linear(&self) -> Vec3 {
        Vec3::new(self.coefficients[1], self.coefficients[2], self.coefficients[3])
    }

    fn hessian(&self) -> Mat3 {
        let [_, _, _, _, xx, yy, zz, xy, xz, yz] = self.coefficients;
        Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    fn local(&self, p: &Point3) -> Vec3 {
        (p - self.center) / self.scale
    }

    /// Value at a point.
    pub fn value(&self, p: &Point3) -> f64 {
        self.polar(p, p)
    }

    /// Gradient at a point.
    pub fn gradient(&self, p: &Point3) -> Vec3 {
        (self.linear() + self.hessian() * self.local(p)) / self.scale
    }

    /// The symmetric function, affine in both points, that is the quadric where they agree: Q(p, q).
    pub fn polar(&self, p: &Point3, q: &Point3) -> f64 {
        let (x, y) = (self.local(p), self.local(q));
        self.coefficients[0] + 0.5 * (self.linear().dot(&(x + y)) + x.dot(&(self.hessian() * y)))
    }

    /// The same of three points, as of a cubic function: the Bernstein–Bézier coefficient of three corners of a cell.
    pub fn blossom(&self, p: &Point3, q: &Point3, r: &Point3) -> f64 {
        (self.polar(p, q) + self.polar(q, r) + self.polar(p, r)) / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_blossom_is_affine_symmetric_and_the_quadric_on_the_diagonal() {
        let q = Quadric {
            coefficients: std::array::from_fn(|i| (1.7 * i as f64 + 0.3).sin()),
            center: Vec3::new(0.2, -0.4, 1.0),
            scale: 0.7,
        };
        let p = |i: usize| Vec3::new((i as f64).cos(), (2.1 * i as f64).sin(), 0.3 * i as f64);
        let (a, b, c) = (p(0), p(1), p(2));
        assert!((q.blossom(&a, &a, &a) - q.value(&a)).abs() < 1e-15);
        assert!((q.blossom(&a, &b, &c) - q.blossom(&c, &a, &b)).abs() < 1e-15);
        let mixed = q.blossom(&(0.3 * a + 0.7 * b), &b, &c);
        assert!((mixed - 0.3 * q.blossom(&a, &b, &c) - 0.7 * q.blossom(&b, &b, &c)).abs() < 1e-14);
        // A third of the derivative joins the two ends.
        let towards = q.value(&a) + q.gradient(&a).dot(&(b - a)) / 3.0;
        assert!((q.blossom(&a, &a, &b) - towards).abs() < 1e-14);
    }
}
