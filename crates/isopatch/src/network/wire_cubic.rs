//! Cubic wires of minimum energy through a given point, and their normal functions: Bajaj & Xu 1997, sections 5.3 and 5.4.
//!
//! C(t) = A t³ + B t² + C t + D with C(½) = p₂.

use super::number::{Number, Vector, are_parallel, off, scaled, solve, whole};
use super::wire_conic::with_products;
use crate::geom::{Mat3, Vec3};

/// C(t) = A t³ + B t² + C t + D on [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct Cubic<T: Number> {
    /// Coefficient of t³.
    pub a: Vector<T>,
    /// Coefficient of t².
    pub b: Vector<T>,
    /// Coefficient of t.
    pub c: Vector<T>,
    /// The start.
    pub d: Vector<T>,
}

/// n(t) = E t² + F t + G.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicNormals<T: Number> {
    /// Coefficient of t².
    pub e: Vector<T>,
    /// Coefficient of t.
    pub f: Vector<T>,
    /// The normal at the start.
    pub g: Vector<T>,
}

impl<T: Number> Cubic<T> {
    /// The curve through p₀, p₂ at ½, and p₁ with two normals of any length; with parallel normals (sine of their angle at most
    /// `tolerance`), p₂ is first moved along them into the plane of (5.13), without which there is none.
    pub fn through(p: [&Vector<T>; 3], n: [&Vector<T>; 2], tolerance: &T) -> Self {
        let [p0, p2, p1] = p;
        let d = p1 - p0;
        let two = whole::<T>(2);
        if are_parallel(n[0], n[1], tolerance) {
            let middle = (p0 + p1).map(|x| x / two.clone());
            let p2 = &middle + off(&(p2 - &middle), n[1]);
            let m = scaled(&(&p2 - p0), &whole(4)) - &d;
            // Case A: α n₃ + β n₄ is m without its part along the normals.
            return Self::leaving([p0, &p2, p1], off(&m, n[1]));
        }
        let q = p2 - p0;
        let m = scaled(&q, &whole(4)) - &d;
        let s = whole::<T>(4) * n[1].dot(&(scaled(&q, &two) - &d)); // (5.12)
        Self::leaving(p, with_products(n, &m, s))
    }

    /// A and B from C, by (5.10).
    fn leaving([p0, p2, p1]: [&Vector<T>; 3], c: Vector<T>) -> Self {
        let d = p1 - p0;
        let b = scaled(&(p2 - p0), &whole(8)) - &d - scaled(&c, &whole(3));
        Self { a: d - &b - &c, b, c, d: p0.clone() }
    }

    /// C(t).
    pub fn point(&self, t: &T) -> Vector<T> {
        scaled(&(scaled(&(scaled(&self.a, t) + &self.b), t) + &self.c), t) + &self.d
    }

    /// C′(t).
    pub fn derivative(&self, t: &T) -> Vector<T> {
        let three_a = scaled(&self.a, &whole(3));
        let two_b = scaled(&self.b, &whole(2));
        scaled(&(scaled(&three_a, t) + two_b), t) + &self.c
    }

    /// Bézier points.
    pub fn bezier(&self) -> [Vector<T>; 4] {
        let third = T::one() / whole(3);
        let first = &self.d + scaled(&self.c, &third);
        let second = &first + scaled(&(&self.b + &self.c), &third);
        [self.d.clone(), first, second, &self.a + &self.b + &self.c + &self.d]
    }

    /// det[A, B, C]: where it vanishes, as on every plane wire, the normal function is not unique or does not exist (Theorem 5.3
    /// has a case where it does not vanish).
    pub fn determinant(&self) -> T {
        super::number::determinant(&self.a, &self.b, &self.c)
    }

    /// The quadratic normal function of (5.14); none if det[A, B, C] = 0.
    pub fn normals(&self, n: [&Vector<T>; 2]) -> Option<CubicNormals<T>> {
        let (rows, s) = self.normal_equations(n);
        Some(with_linear_term(n, solve(&rows, &s)?))
    }

    /// The three equations at ¼, ½ and ¾ for F: (t − t²) C′·F = −C′·(t² n₁ + (1 − t²) n₀).
    fn normal_equations(&self, n: [&Vector<T>; 2]) -> ([Vector<T>; 3], [T; 3]) {
        let at = |quarters: u32| whole::<T>(quarters) / whole(4);
        let equation = |t: T| {
            let tangent = self.derivative(&t);
            let square = t.clone() * t.clone();
            let known = scaled(n[1], &square) + scaled(n[0], &(T::one() - square.clone()));
            (scaled(&tangent, &(t - square)), -tangent.dot(&known))
        };
        let [(r0, s0), (r1, s1), (r2, s2)] = [1, 2, 3].map(|quarters| equation(at(quarters)));
        ([r0, r1, r2], [s0, s1, s2])
    }
}

impl Cubic<f64> {
    /// The same by least squares, with the smallest F: what the paper does in practice. Singular values below `tolerance` times the
    /// largest count as 0.
    pub fn normals_least_squares(&self, n: [&Vec3; 2], tolerance: f64) -> CubicNormals<f64> {
        let (rows, s) = self.normal_equations(n);
        let matrix = Mat3::from_columns(&rows).transpose();
        with_linear_term(n, least_squares(&matrix, &Vec3::from(s), tolerance))
    }
}

/// The shortest x with least |M x − s|; singular values up to `tolerance` times the largest count as 0.
pub(crate) fn least_squares(matrix: &Mat3, s: &Vec3, tolerance: f64) -> Vec3 {
    let svd = matrix.svd(true, true);
    let limit = tolerance * svd.singular_values.amax();
    // Only a factor that was not asked for is an error.
    svd.solve(s, limit).unwrap_or_else(|_| Vec3::zeros())
}

fn with_linear_term<T: Number>(n: [&Vector<T>; 2], f: Vector<T>) -> CubicNormals<T> {
    CubicNormals { e: n[1] - n[0] - &f, f, g: n[0].clone() }
}

impl<T: Number> CubicNormals<T> {
    /// n(t).
    pub fn at(&self, t: &T) -> Vector<T> {
        scaled(&(scaled(&self.e, t) + &self.f), t) + &self.g
    }

    /// Bernstein coefficients.
    pub fn bezier(&self) -> [Vector<T>; 3] {
        let half = T::one() / whole(2);
        [self.g.clone(), &self.g + scaled(&self.f, &half), &self.e + &self.f + &self.g]
    }
}
