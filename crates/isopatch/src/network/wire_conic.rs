//! Conic wires of minimum energy and their normal functions: Bajaj & Xu 1997, sections 5.1 and 5.2.
//!
//! C(t) = A t² + B t + C. The energy that the paper minimises is ∫|C′|²; ∫|C″|² has the same minimiser in this family.

use super::number::{Number, Vector, are_orthogonal, are_parallel, off, scaled, whole};

/// C(t) = A t² + B t + C on [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct Conic<T: Number> {
    /// Coefficient of t².
    pub a: Vector<T>,
    /// Coefficient of t.
    pub b: Vector<T>,
    /// The start.
    pub c: Vector<T>,
}

/// Equation (5.7) has no solution: the normals are parallel and not orthogonal to the chord, against (5.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no conic: the normals are parallel, and the chord is not orthogonal to them")]
pub struct NoConic;

/// No normal function of degree 1 without a pole: Lemma 5.2 fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no normal function: the normals do not lean to opposite sides along the chord")]
pub struct NoNormalFunction;

/// n(t) = ((1 − t) n₀ + (1 + w) t n₁) / (1 + w t): orthogonal to C′ everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct ConicNormals<T: Number> {
    /// Bernstein coefficients of the numerator: n₀ and (1 + w) n₁.
    pub numerator: [Vector<T>; 2],
    /// 1 + w, positive.
    pub one_plus_w: T,
}

impl<T: Number> Conic<T> {
    /// The curve that leaves p₀ with derivative B and ends in p₁.
    fn leaving(p: [&Vector<T>; 2], b: Vector<T>) -> Self {
        Self { a: p[1] - p[0] - &b, b, c: p[0].clone() }
    }

    /// Problem 3(i): no normal. The chord.
    pub fn straight(p: [&Vector<T>; 2]) -> Self {
        Self::leaving(p, p[1] - p[0])
    }

    /// Problem 1(i): two normals, of any length. Normals are parallel if the sine of their angle is at most `tolerance`, and the
    /// chord orthogonal to them if the cosine is. Lemma 5.1: with independent normals there is exactly one.
    pub fn with_two_normals(p: [&Vector<T>; 2], n: [&Vector<T>; 2], tolerance: &T) -> Result<Self, NoConic> {
        let d = p[1] - p[0];
        if are_parallel(n[0], n[1], tolerance) {
            let is_across = are_orthogonal(n[1], &d, tolerance); // (5.8)
            return if is_across { Ok(Self::straight(p)) } else { Err(NoConic) };
        }
        Ok(Self::leaving(p, with_products(n, &d, whole::<T>(2) * n[1].dot(&d))))
    }

    /// Problem 2(i): one normal, at the start (0) or the end (1), of any length. The curve is in the plane of normal and chord. With
    /// a chord along the normal its derivative vanishes there.
    pub fn with_one_normal(p: [&Vector<T>; 2], n: &Vector<T>, end: usize) -> Self {
        let d = p[1] - p[0];
        let projected = off(&d, n);
        let b = if end == 0 { projected } else { scaled(&d, &whole(2)) - projected };
        Self::leaving(p, b)
    }

    /// C′ at 0 and at 1.
    pub fn end_tangents(&self) -> [Vector<T>; 2] {
        [self.b.clone(), scaled(&self.a, &whole(2)) + &self.b]
    }

    /// C(t).
    pub fn point(&self, t: &T) -> Vector<T> {
        scaled(&(scaled(&self.a, t) + &self.b), t) + &self.c
    }

    /// Bézier points.
    pub fn bezier(&self) -> [Vector<T>; 3] {
        let half = T::one() / whole(2);
        [self.c.clone(), scaled(&self.b, &half) + &self.c, &self.a + &self.b + &self.c]
    }

    /// ∫|C′|² = 4/3 A² + 2 A·B + B².
    pub fn energy(&self) -> T {
        let two = whole::<T>(2);
        let four_thirds = whole::<T>(4) / whole(3);
        four_thirds * self.a.dot(&self.a) + two * self.a.dot(&self.b) + self.b.dot(&self.b)
    }

    /// Problem 1(ii): the normal function with n₀ and n₁ at the ends (Lemma 5.2).
    ///
    /// 1 + w = −n₀·d / n₁·d has to be positive. Where both products vanish, w is free and 0 is taken; products count as 0 up to
    /// `tolerance` times the lengths. One zero alone would put a zero or a pole of n at an end.
    pub fn normals(&self, n: [&Vector<T>; 2], tolerance: &T) -> Result<ConicNormals<T>, NoNormalFunction> {
        let d = &self.a + &self.b;
        let product = |n: &Vector<T>| {
            if are_orthogonal(n, &d, tolerance) { T::zero() } else { n.dot(&d) }
        };
        let [x, y] = n.map(product);
        let one_plus_w = match (x.is_zero(), y.is_zero()) {
            (true, true) => T::one(),
            (false, false) if x.is_positive() != y.is_positive() => -(x / y),
            _ => return Err(NoNormalFunction),
        };
        Ok(ConicNormals { numerator: [n[0].clone(), scaled(n[1], &one_plus_w)], one_plus_w })
    }

    /// Problem 2(ii): a normal at the other end for the one given at `end`, in the plane of the curve and on the same side of the
    /// chord. With it, [`Self::normals`] always finds a function.
    pub fn companion_normal(&self, n: &Vector<T>, end: usize) -> Vector<T> {
        off(n, &self.end_tangents()[1 - end])
    }
}

/// The vector v with n₀·v = 0 and n₁·v = s for independent normals, and the same component as `like` along n₀ × n₁: the one that is
/// closest to `like` among those with these two products, which is where the energy is least.
///
/// The basis e, n₀ × n₁ avoids the Gram matrix of (5.9), whose condition is the square of that of the normals.
pub(super) fn with_products<T: Number>(n: [&Vector<T>; 2], like: &Vector<T>, s: T) -> Vector<T> {
    let e = off(n[1], n[0]);
    let c = n[0].cross(n[1]);
    let along = c.dot(like) / c.dot(&c);
    scaled(&e, &(s / n[1].dot(&e))) + scaled(&c, &along)
}
