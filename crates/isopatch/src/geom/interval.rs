use std::ops::{Add, Div, Mul, Neg, Sub};

/// A closed interval of real numbers, `lo` ≤ `hi`; an infinite end means unbounded on that side.
///
/// Every operation encloses: the result holds f(x) for each x of the argument where f is defined, because its
/// ends are moved outward by at least the rounding error. Where f is defined nowhere, or nothing is known, the
/// result is the [whole line](Self::WHOLE). No operation gives NaN ends; 0·∞ counts as 0, since an infinite end
/// stands for arbitrarily large finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

/// How many floating-point numbers the system's sin, exp, … may be off; current mathematical libraries promise
/// less than one for these functions, and at most two for powers and hyperbolic functions.
const LIBRARY_ERROR_STEPS: u32 = 4;
/// Arguments of sin, cos and tan beyond this size are not reduced: all values are assumed.
const LARGEST_ANGLE: f64 = 1e9;
/// Relative uncertainty of a number of half turns; far above the few roundings in computing it.
const TURN_SLACK: f64 = 1e-14;

impl Interval {
    /// All real numbers.
    pub const WHOLE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    const ZERO: Self = Self { lo: 0.0, hi: 0.0 };

    #[inline]
    fn is_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }

    /// The numbers from `lo` to `hi`; the whole line if an end is NaN.
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::WHOLE } else { Self { lo, hi } }
    }

    /// A single number.
    pub fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    /// Is the number in the interval?
    pub fn contains(&self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// hi − lo.
    pub fn width(&self) -> f64 {
        self.hi - self.lo
    }

    /// The smallest interval that holds both.
    pub fn union(&self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// |x|.
    pub fn abs(self) -> Self {
        if self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            -self
        } else {
            Self { lo: 0.0, hi: self.hi.max(-self.lo) }
        }
    }

    /// x².
    #[inline]
    pub fn square(self) -> Self {
        let Self { lo, hi } = self.abs();
        Self { lo: down(lo * lo).max(0.0), hi: up_from_zero(hi * hi, hi == 0.0) }
    }

    /// xⁿ for n ≥ 1, as tight as rounding allows.
    pub fn power(self, n: u32) -> Self {
        if n.is_multiple_of(2) {
            let Self { lo, hi } = self.abs();
            Self { lo: power_down(lo, n), hi: power_up(hi, n) }
        } else {
            let lo = if self.lo >= 0.0 { power_down(self.lo, n) } else { -power_up(-self.lo, n) };
            let hi = if self.hi >= 0.0 { power_up(self.hi, n) } else { -power_down(-self.hi, n) };
            Self { lo, hi }
        }
    }

    /// x^y for real y, defined for x ≥ 0 only.
    pub fn pow(self, exponent: Self) -> Self {
        if self.hi < 0.0 {
            return Self::WHOLE;
        }
        // Monotone in x for fixed y and in y for fixed x, so the extremes are at corners.
        let base = [self.lo.max(0.0), self.hi];
        let corners = [exponent.lo, exponent.hi].into_iter().flat_map(|y| base.map(|x| x.powf(y)));
        let (lo, hi) = corners.fold((f64::INFINITY, 0.0_f64), |(lo, hi), v| (lo.min(v), hi.max(v)));
        // Next to x = 0 the limit depends on the direction when y may be 0, and both 0 and 1 are among the limits.
        let lo = if base[0] == 0.0 && exponent.hi >= 0.0 && exponent.lo <= 0.0 && exponent.width() > 0.0 {
            0.0
        } else {
            lo
        };
        Self { lo: library_down(lo).max(0.0), hi: library_up(hi) }
    }

    /// √x, of the part that is not negative.
    pub fn sqrt(self) -> Self {
        if self.hi < 0.0 {
            return Self::WHOLE;
        }
        Self { lo: down(self.lo.max(0.0).sqrt()).max(0.0), hi: up_from_zero(self.hi.sqrt(), self.hi == 0.0) }
    }

    /// eˣ.
    pub fn exp(self) -> Self {
        Self { lo: library_down(self.lo.exp()).max(0.0), hi: library_up(self.hi.exp()) }
    }

    /// The natural logarithm, of the part that is positive.
    pub fn ln(self) -> Self {
        if self.hi <= 0.0 {
            return Self::WHOLE;
        }
        Self { lo: library_down(self.lo.max(0.0).ln()), hi: library_up(self.hi.ln()) }
    }

    /// sin x.
    pub fn sin(self) -> Self {
        self.wave(f64::sin, 0.5)
    }

    /// cos x.
    pub fn cos(self) -> Self {
        self.wave(f64::cos, 0.0)
    }

    /// A wave with crests at (`crest` + 2k)π and troughs half a period later.
    fn wave(self, f: impl Fn(f64) -> f64, crest: f64) -> Self {
        const ALL: Interval = Interval { lo: -1.0, hi: 1.0 };
        if !self.is_moderate_angle() {
            return ALL;
        }
        let (a, b) = (f(self.lo), f(self.hi));
        let hi = if self.meets(crest, 2.0) { 1.0 } else { library_up(a.max(b)).min(1.0) };
        let lo = if self.meets(crest + 1.0, 2.0) { -1.0 } else { library_down(a.min(b)).max(-1.0) };
        Self { lo, hi }
    }

    /// tan x; the whole line where a pole may be inside.
    pub fn tan(self) -> Self {
        if !self.is_moderate_angle() || self.meets(0.5, 1.0) {
            return Self::WHOLE;
        }
        self.rising(f64::tan)
    }

    fn is_moderate_angle(&self) -> bool {
        self.lo.abs() <= LARGEST_ANGLE && self.hi.abs() <= LARGEST_ANGLE
    }

    /// Might the interval hold (`offset` + k·`period`)π for a whole k? Never wrongly "no".
    fn meets(&self, offset: f64, period: f64) -> bool {
        let turns = |x: f64| (x / std::f64::consts::PI - offset) / period;
        let slack = TURN_SLACK * (1.0 + self.lo.abs().max(self.hi.abs()));
        (turns(self.hi) + slack).floor() >= (turns(self.lo) - slack).ceil()
    }

    /// Arc sine, of the part within [−1, 1].
    pub fn asin(self) -> Self {
        if self.lo > 1.0 || self.hi < -1.0 {
            return Self::WHOLE;
        }
        Self { lo: self.lo.max(-1.0), hi: self.hi.min(1.0) }.rising(f64::asin)
    }

    /// Arc cosine, of the part within [−1, 1].
    pub fn acos(self) -> Self {
        if self.lo > 1.0 || self.hi < -1.0 {
            return Self::WHOLE;
        }
        let (lo, hi) = (self.hi.min(1.0).acos(), self.lo.max(-1.0).acos());
        Self { lo: library_down(lo).max(0.0), hi: library_up(hi) }
    }

    /// Arc tangent.
    pub fn atan(self) -> Self {
        self.rising(f64::atan)
    }

    /// Hyperbolic sine.
    pub fn sinh(self) -> Self {
        self.rising(f64::sinh)
    }

    /// Hyperbolic cosine.
    pub fn cosh(self) -> Self {
        let Self { lo, hi } = self.abs();
        Self { lo: library_down(lo.cosh()).max(1.0), hi: library_up(hi.cosh()) }
    }

    /// Hyperbolic tangent.
    pub fn tanh(self) -> Self {
        let Self { lo, hi } = self.rising(f64::tanh);
        Self { lo: lo.max(-1.0), hi: hi.min(1.0) }
    }

    fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        Self { lo: library_down(f(self.lo)), hi: library_up(f(self.hi)) }
    }

    /// min(x, y).
    pub fn min(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.min(other.hi) }
    }

    /// max(x, y).
    pub fn max(self, other: Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.max(other.hi) }
    }

    /// −1, 0 or 1 by the sign of x.
    pub fn sign(self) -> Self {
        let sign = |x: f64| {
            if x > 0.0 {
                1.0
            } else if x < 0.0 {
                -1.0
            } else {
                0.0
            }
        };
        Self { lo: sign(self.lo), hi: sign(self.hi) }
    }

    /// 1 where x < y, else 0.
    pub fn less(self, other: Self) -> Self {
        let indicator = |yes: bool| if yes { 1.0 } else { 0.0 };
        Self { lo: indicator(self.hi < other.lo), hi: indicator(self.lo < other.hi) }
    }
}

/// A lower bound of the exact result that was rounded to `value`.
#[inline]
fn down(value: f64) -> f64 {
    value.next_down()
}

/// An upper bound of the exact result that was rounded to `value`, which is 0 exactly if so said.
#[inline]
fn up_from_zero(value: f64, exactly_zero: bool) -> f64 {
    if exactly_zero { 0.0 } else { value.next_up() }
}

/// `value` moved down by the error of a library function.
fn library_down(value: f64) -> f64 {
    (0..LIBRARY_ERROR_STEPS).fold(value, |v, _| v.next_down())
}

/// `value` moved up by the error of a library function.
fn library_up(value: f64) -> f64 {
    (0..LIBRARY_ERROR_STEPS).fold(value, |v, _| v.next_up())
}

/// A lower bound of xⁿ for x ≥ 0.
fn power_down(x: f64, n: u32) -> f64 {
    repeated_product(x, n, |a, b| down(a * b).max(0.0))
}

/// An upper bound of xⁿ for x ≥ 0.
fn power_up(x: f64, n: u32) -> f64 {
    repeated_product(x, n, |a, b| up_from_zero(a * b, a == 0.0 || b == 0.0))
}

/// xⁿ, n ≥ 1, by binary powering from the leading digit down.
fn repeated_product(x: f64, n: u32, product: impl Fn(f64, f64) -> f64) -> f64 {
    let digits = u32::BITS - n.leading_zeros();
    (0..digits.saturating_sub(1)).rev().fold(x, |power, digit| {
        let square = product(power, power);
        if n >> digit & 1 == 1 { product(square, x) } else { square }
    })
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let (lo, hi) = (self.lo + other.lo, self.hi + other.hi);
        // A floating-point sum that is zero is exact.
        Self::new(if lo == 0.0 { 0.0 } else { lo.next_down() }, if hi == 0.0 { 0.0 } else { hi.next_up() })
    }
}

impl Sub for Interval {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        corners(self, other, |a, b| if a == 0.0 || b == 0.0 { 0.0 } else { a * b })
    }
}

impl Div for Interval {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let Self { lo, hi } = other;
        if (lo < 0.0 && hi > 0.0) || (lo == 0.0 && hi == 0.0) {
            return Self::WHOLE;
        }
        if self.is_zero() {
            return Self::ZERO;
        }
        // A zero end of the divisor is approached from inside; ∞/∞ counts as 0 like 0·∞, the other corners
        // cover the rest.
        let other = Self { lo: if lo == 0.0 { 0.0 } else { lo }, hi: if hi == 0.0 { -0.0 } else { hi } };
        corners(self, other, |a, b| if a == 0.0 || b.is_infinite() { 0.0 } else { a / b })
    }
}

/// The hull of f at the four pairs of ends, for f a product or quotient: rounded outward, with the sign that the
/// signs of the operands imply.
#[inline]
fn corners(a: Interval, b: Interval, f: impl Fn(f64, f64) -> f64) -> Interval {
    let (p, q, r, s) = (f(a.lo, b.lo), f(a.lo, b.hi), f(a.hi, b.lo), f(a.hi, b.hi));
    let mut lo = p.min(q).min(r.min(s)).next_down();
    let mut hi = p.max(q).max(r.max(s)).next_up();
    if (a.lo >= 0.0 && b.lo >= 0.0) || (a.hi <= 0.0 && b.hi <= 0.0) {
        lo = lo.max(0.0);
    }
    if (a.lo >= 0.0 && b.hi <= 0.0) || (a.hi <= 0.0 && b.lo >= 0.0) {
        hi = hi.min(0.0);
    }
    Interval::new(lo, hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends that exercise signs, zero, tiny, huge and infinite.
    const ENDS: [f64; 13] = [
        f64::NEG_INFINITY,
        -1e200,
        -7.0,
        -1.0,
        -0.3,
        -1e-300,
        0.0,
        1e-300,
        0.5,
        1.0,
        3.0,
        1e200,
        f64::INFINITY,
    ];

    fn intervals() -> impl Iterator<Item = Interval> + Clone {
        ENDS.iter()
            .enumerate()
            .flat_map(|(i, &lo)| ENDS[i..].iter().map(move |&hi| Interval { lo, hi }))
            .filter(|x| x.lo < f64::INFINITY && x.hi > f64::NEG_INFINITY)
    }

    fn samples(x: Interval) -> impl Iterator<Item = f64> + Clone {
        let (lo, hi) = (x.lo.max(-1e250), x.hi.min(1e250));
        let between = [0.1, 0.3, 0.5, 0.77].map(|t| (lo * (1.0 - t) + hi * t).clamp(lo, hi));
        let known = ENDS.into_iter().filter(move |v| v.is_finite() && x.contains(*v));
        between.into_iter().chain(known)
    }

    #[test]
    fn operations_of_two_intervals_enclose_all_samples_and_are_never_nan() {
        type Pair = (&'static str, fn(Interval, Interval) -> Interval, fn(f64, f64) -> f64);
        let operations: [Pair; 7] = [
            ("add", |a, b| a + b, |a, b| a + b),
            ("sub", |a, b| a - b, |a, b| a - b),
            ("mul", |a, b| a * b, |a, b| a * b),
            ("div", |a, b| a / b, |a, b| a / b),
            ("min", Interval::min, f64::min),
            ("max", Interval::max, f64::max),
            ("pow", Interval::pow, |a, b| if a < 0.0 { f64::NAN } else { a.powf(b) }),
        ];
        for (name, enclose, f) in operations {
            for a in intervals() {
                for b in intervals() {
                    let range = enclose(a, b);
                    assert!(range.lo <= range.hi, "{name} {a:?} {b:?} gives {range:?}");
                    for (x, y) in samples(a).flat_map(|x| samples(b).map(move |y| (x, y))) {
                        let v = f(x, y);
                        assert!(
                            !v.is_finite() || range.contains(v),
                            "{name}({x}, {y}) = {v} outside {range:?} for {a:?} {b:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn functions_enclose_all_samples_and_are_never_nan() {
        type Function = (&'static str, fn(Interval) -> Interval, fn(f64) -> f64);
        let functions: [Function; 17] = [
            ("abs", Interval::abs, f64::abs),
            ("square", Interval::square, |x| x * x),
            ("cube", |x| x.power(3), |x| x * x * x),
            ("sixth", |x| x.power(6), |x| x.powi(6)),
            ("sqrt", Interval::sqrt, f64::sqrt),
            ("exp", Interval::exp, f64::exp),
            ("ln", Interval::ln, f64::ln),
            ("sin", Interval::sin, f64::sin),
            ("cos", Interval::cos, f64::cos),
            ("tan", Interval::tan, f64::tan),
            ("asin", Interval::asin, f64::asin),
            ("acos", Interval::acos, f64::acos),
            ("atan", Interval::atan, f64::atan),
            ("sinh", Interval::sinh, f64::sinh),
            ("cosh", Interval::cosh, f64::cosh),
            ("tanh", Interval::tanh, f64::tanh),
            ("sign", Interval::sign, |x| if x == 0.0 { 0.0 } else { x.signum() }),
        ];
        for (name, enclose, f) in functions {
            for a in intervals() {
                let range = enclose(a);
                assert!(range.lo <= range.hi, "{name} {a:?} gives {range:?}");
                for x in samples(a) {
                    let v = f(x);
                    assert!(!v.is_finite() || range.contains(v), "{name}({x}) = {v} outside {range:?}");
                }
            }
        }
    }

    #[test]
    fn waves_know_their_crests_and_troughs() {
        for k in -20..20 {
            let start = 0.37 * f64::from(k);
            for width in [0.1, 1.0, 2.5, 4.0, 7.0] {
                let x = Interval::new(start, start + width);
                let fine = (0..=2000).map(|i| start + width * f64::from(i) / 2000.0);
                for (range, f) in [(x.sin(), f64::sin as fn(f64) -> f64), (x.cos(), f64::cos)] {
                    let (lo, hi) =
                        fine.clone().map(f).fold((1.0_f64, -1.0_f64), |(l, h), v| (l.min(v), h.max(v)));
                    assert!(range.lo <= lo && range.hi >= hi);
                    assert!(
                        lo - range.lo < 1e-5 && range.hi - hi < 1e-5,
                        "{x:?}: {range:?} against {lo} {hi}"
                    );
                }
            }
        }
    }

    #[test]
    fn powers_are_tight() {
        let x = Interval::new(-1.0, 2.0);
        let cube = x.power(3);
        assert!(cube.lo > -1.0 - 1e-14 && cube.hi < 8.0 + 1e-13);
        let fourth = x.power(4);
        assert!(fourth.lo == 0.0 && fourth.hi < 16.0 + 1e-13);
        assert!(x.square().lo == 0.0 && x.square().hi < 4.0 + 1e-14);
    }

    #[test]
    fn unbounded_operands_follow_the_conventions() {
        let zero = Interval::point(0.0);
        assert_eq!(zero * Interval::WHOLE, zero);
        assert_eq!(Interval::WHOLE - Interval::WHOLE, Interval::WHOLE);
        let half_line = Interval::new(1.0, f64::INFINITY);
        assert_eq!(half_line - half_line, Interval::WHOLE);
        let reciprocal = Interval::point(1.0) / half_line;
        assert!(reciprocal.lo == 0.0 && reciprocal.hi >= 1.0 && reciprocal.hi < 1.0 + 1e-15);
        assert_eq!(
            Interval::point(1.0) / Interval::new(0.0, 2.0),
            Interval::new(0.5_f64.next_down(), f64::INFINITY)
        );
        assert_eq!(Interval::new(-2.0, -1.0).sqrt(), Interval::WHOLE);
    }
}
