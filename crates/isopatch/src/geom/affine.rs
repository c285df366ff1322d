use std::ops::{Add, Mul, Neg, Sub};

use super::{Aabb, Interval};

/// A function on a box as a linear function and a bound on the rest: center + slope·u ± error, where u ∈ [−1, 1]³ are
/// the coordinates of the box from its centre in units of its half edge lengths.
///
/// Affine arithmetic with the three coordinates as noise symbols (de Figueiredo & Stolfi, Affine arithmetic: concepts
/// and applications, 2004): the error of a sum or product shrinks with the square of the box, where that of an
/// [`Interval`] shrinks in proportion to it. Every operation encloses, as those of an interval do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Value at the centre, up to the error.
    pub center: f64,
    /// Change from the centre to the middle of the upper sides.
    pub slope: [f64; 3],
    /// Largest distance from the linear function; infinite where nothing is known.
    pub error: f64,
}

/// Bounds the relative error of the few dozen roundings of one operation.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Bounds what underflow takes from the products of one operation.
const UNDERFLOW: f64 = 16.0 * f64::MIN_POSITIVE;

/// The range of a monotonic function is never wider without a slope, but then it shares nothing with other numbers: the
/// slope is kept if the rest is this much smaller than the range.
const WORTH_A_SLOPE: f64 = 0.5;

impl Affine {
    /// Nothing is known.
    pub const WHOLE: Self = Self { center: 0.0, slope: [0.0; 3], error: f64::INFINITY };

    /// Zero everywhere.
    pub const ZERO: Self = Self { center: 0.0, slope: [0.0; 3], error: 0.0 };

    /// The coordinate `axis` over the box.
    pub fn coordinate(cell: &Aabb, axis: usize) -> Self {
        let half_range = Self::from(cell.interval(axis));
        let mut slope = [0.0; 3];
        slope[axis] = half_range.error;
        Self { slope, error: 0.0, ..half_range }.or_whole()
    }

    /// Σ |slope|: the linear function stays this close to the centre.
    #[inline]
    fn spread(&self) -> f64 {
        self.slope[0].abs() + self.slope[1].abs() + self.slope[2].abs()
    }

    /// How far from the centre values can be, rounded up.
    #[inline]
    pub fn radius(&self) -> f64 {
        (self.spread() + self.error) * (1.0 + ROUNDING)
    }

    #[inline]
    fn magnitude(&self) -> f64 {
        self.center.abs() + self.spread() + self.error
    }

    /// All values over the box.
    #[inline]
    pub fn range(&self) -> Interval {
        let radius = self.radius();
        Interval::new((self.center - radius).next_down(), (self.center + radius).next_up())
    }

    /// Is zero no value over the box?
    #[inline]
    pub fn excludes_zero(&self) -> bool {
        self.center.abs() > self.radius()
    }

    /// Infinite or undefined numbers say nothing.
    #[inline]
    fn or_whole(self) -> Self {
        if self.magnitude().is_finite() { self } else { Self::WHOLE }
    }

    /// Times a number.
    #[inline]
    pub fn scaled(self, factor: f64) -> Self {
        let error = self.error * factor.abs() + ROUNDING * self.magnitude() * factor.abs() + UNDERFLOW;
        Self { center: self.center * factor, slope: self.slope.map(|s| s * factor), error }.or_whole()
    }

    /// The square.
    #[inline]
    pub fn square(self) -> Self {
        let (l, e) = (self.spread(), self.error);
        // (slope·u)² is between 0 and l².
        let half = 0.5 * l * l;
        let size = self.magnitude();
        let error = half + (2.0 * (self.center.abs() + l) + e) * e + ROUNDING * size * size + UNDERFLOW;
        let center = self.center * self.center + half;
        Self { center, slope: self.slope.map(|s| 2.0 * self.center * s), error }.or_whole()
    }

    /// φ of it, for a function with the given enclosures of its values and of its derivative over any interval.
    ///
    /// With the mean slope α of φ over the range X, φ(x) − αx changes by at most the half width of φ'(X) times |x − m|.
    pub fn map(
        self,
        value: impl Fn(Interval) -> Interval,
        derivative: impl Fn(Interval) -> Interval,
    ) -> Self {
        let range = self.range();
        let direct = Self::from(value(range));
        let slope = Self::from(derivative(range));
        if !slope.error.is_finite() {
            return direct;
        }
        let middle = Self::from(value(Interval::point(self.center)));
        let mut linear = Self { center: 0.0, ..self }.scaled(slope.center) + middle;
        linear.error += slope.error * self.radius() * (1.0 + ROUNDING);
        if linear.error < WORTH_A_SLOPE * direct.error { linear.or_whole() } else { direct }
    }
}

impl From<Interval> for Affine {
    fn from(range: Interval) -> Self {
        let center = 0.5 * range.lo + 0.5 * range.hi;
        let error = (range.hi - center).max(center - range.lo);
        // The ends of a point are its centre, without any rounding.
        let error = if error > 0.0 { error.next_up() } else { error };
        Self { center, slope: [0.0; 3], error }.or_whole()
    }
}

impl Neg for Affine {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { center: -self.center, slope: self.slope.map(|s| -s), error: self.error }
    }
}

impl Add for Affine {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let slope = [0, 1, 2].map(|i| self.slope[i] + other.slope[i]);
        let sum = Self { center: self.center + other.center, slope, error: self.error + other.error };
        Self { error: sum.error + ROUNDING * sum.magnitude(), ..sum }.or_whole()
    }
}

impl Sub for Affine {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Affine {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self.slope, &other.slope);
        let (la, lb) = (self.spread(), other.spread());
        // Σ aᵢbᵢuᵢ² is between the sums of the negative and of the positive aᵢbᵢ; mixed products have both signs.
        let squares = [0, 1, 2].map(|i| 0.5 * a[i] * b[i]);
        let mixed = (a[0] * b[1] + a[1] * b[0]).abs()
            + (a[1] * b[2] + a[2] * b[1]).abs()
            + (a[2] * b[0] + a[0] * b[2]).abs();
        let quadratic = squares[0].abs() + squares[1].abs() + squares[2].abs() + mixed;
        let inherited = (self.center.abs() + la) * other.error
            + (other.center.abs() + lb) * self.error
            + self.error * other.error;
        let rounding = ROUNDING * self.magnitude() * other.magnitude() + UNDERFLOW;
        Self {
            center: self.center * other.center + (squares[0] + squares[1] + squares[2]),
            slope: [0, 1, 2].map(|i| self.center * b[i] + other.center * a[i]),
            error: quadratic + inherited + rounding,
        }
        .or_whole()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point3;

    fn cell(center: Point3, half: f64) -> Aabb {
        Aabb::new(center.add_scalar(-half), center.add_scalar(half))
    }

    #[test]
    fn products_and_squares_keep_what_their_factors_share() {
        let c = cell(Point3::new(1.0, 2.0, -1.0), 0.1);
        let [x, y, z] = [0, 1, 2].map(|axis| Affine::coordinate(&c, axis));
        assert!((x - x).range().width() < 1e-13);
        // x² − 2x + 1 = (x − 1)² is within 0.01; intervals alone would leave it within 0.4.
        let one = Affine::from(Interval::point(1.0));
        let square = x.square() - x.scaled(2.0) + one;
        assert!(square.range().contains(0.01) && square.radius() < 0.011);
        let f = (x * y + z) * (x * y - z);
        for (dx, dy, dz) in [(0.1, 0.1, 0.1), (-0.1, 0.1, 0.0), (0.03, -0.07, -0.1)] {
            let (x, y, z) = (1.0 + dx, 2.0 + dy, -1.0 + dz);
            let linear = f.center + 10.0 * (f.slope[0] * dx + f.slope[1] * dy + f.slope[2] * dz);
            assert!(((x * y + z) * (x * y - z) - linear).abs() <= f.error);
        }
    }

    #[test]
    fn errors_shrink_with_the_square_of_the_box() {
        let error = |half: f64| {
            let x = Affine::coordinate(&cell(Point3::new(0.7, 0.0, 0.0), half), 0);
            let sine = x.map(Interval::sin, Interval::cos);
            (sine * sine + x.map(Interval::exp, Interval::exp)).error
        };
        assert!((error(0.002) / error(0.001) - 4.0).abs() < 0.2);
    }

    #[test]
    fn nothing_known_stays_nothing_known() {
        let whole = Affine::from(Interval::WHOLE);
        assert_eq!(whole * Affine::ZERO, Affine::WHOLE);
        assert_eq!(whole - whole, Affine::WHOLE);
        assert!(!whole.excludes_zero());
        let infinite = Aabb::new(Point3::repeat(f64::NEG_INFINITY), Point3::repeat(f64::INFINITY));
        assert_eq!(Affine::coordinate(&infinite, 0), Affine::WHOLE);
    }
}
