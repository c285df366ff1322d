//! The operations of a tape, and the kinds of number that it is evaluated with.

use crate::geom::{Affine, Interval};

/// An operation of a tape. Unary ones ignore their second operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Op {
    Neg,
    Add,
    Sub,
    Mul,
    Div,
    Square,
    /// bⁿ as bⁿ⁻¹ · b: the first operand is bⁿ⁻¹, the second b.
    Power(u32),
    Sqrt,
    Abs,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    /// aᵇ for real b, undefined for a < 0.
    Pow,
    Min,
    Max,
    /// −1, 0, 1: the derivative of abs.
    Sign,
    /// 1 where a < b, else 0: the derivative of min and max.
    Less,
}

impl Op {
    pub(super) fn is_unary(self) -> bool {
        !matches!(
            self,
            Self::Add
                | Self::Sub
                | Self::Mul
                | Self::Div
                | Self::Power(_)
                | Self::Pow
                | Self::Min
                | Self::Max
                | Self::Less
        )
    }

    pub(super) fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Mul)
    }
}

/// A constant of a tape: the nearest float, and what is known of the exact number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Constant {
    pub(super) value: f64,
    pub(super) enclosure: Interval,
}

impl Constant {
    /// A number that is a float.
    pub(super) fn exact(value: f64) -> Self {
        Self { value, enclosure: Interval::point(value) }
    }

    /// A number that was rounded to the nearest float.
    pub(super) fn rounded(value: f64) -> Self {
        Self { value, enclosure: Interval::new(value.next_down(), value.next_up()) }
    }
}

/// A kind of number that a tape can be evaluated with.
pub(super) trait Number: Copy {
    /// What a fresh register holds; never read.
    const ZERO: Self;

    fn constant(constant: &Constant) -> Self;

    fn apply(op: Op, a: Self, b: Self) -> Self;
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    fn constant(constant: &Constant) -> Self {
        constant.value
    }

    #[inline(always)]
    fn apply(op: Op, a: Self, b: Self) -> Self {
        match op {
            Op::Neg => -a,
            Op::Add => a + b,
            Op::Sub => a - b,
            Op::Mul | Op::Power(_) => a * b,
            Op::Div => a / b,
            Op::Square => a * a,
            Op::Sqrt => a.sqrt(),
            Op::Abs => a.abs(),
            Op::Exp => a.exp(),
            Op::Log => a.ln(),
            Op::Sin => a.sin(),
            Op::Cos => a.cos(),
            Op::Tan => a.tan(),
            Op::Asin => a.asin(),
            Op::Acos => a.acos(),
            Op::Atan => a.atan(),
            Op::Sinh => a.sinh(),
            Op::Cosh => a.cosh(),
            Op::Tanh => a.tanh(),
            Op::Pow => {
                if a < 0.0 {
                    f64::NAN
                } else {
                    a.powf(b)
                }
            }
            // Unlike f64::min, these pass NaN on: outside the domain of one branch is outside the domain.
            Op::Min => {
                if a < b || a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Op::Max => {
                if b < a || a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Op::Sign => {
                let (positive, negative) = (f64::from(u8::from(a > 0.0)), f64::from(u8::from(a < 0.0)));
                positive - negative
            }
            Op::Less => f64::from(u8::from(a < b)),
        }
    }
}

impl Number for Interval {
    const ZERO: Self = Interval { lo: 0.0, hi: 0.0 };

    fn constant(constant: &Constant) -> Self {
        constant.enclosure
    }

    #[inline]
    fn apply(op: Op, a: Self, b: Self) -> Self {
        match op {
            Op::Neg => -a,
            Op::Add => a + b,
            Op::Sub => a - b,
            Op::Mul => a * b,
            Op::Div => a / b,
            Op::Square => a.square(),
            Op::Power(n) => b.power(n),
            Op::Sqrt => a.sqrt(),
            Op::Abs => a.abs(),
            Op::Exp => a.exp(),
            Op::Log => a.ln(),
            Op::Sin => a.sin(),
            Op::Cos => a.cos(),
            Op::Tan => a.tan(),
            Op::Asin => a.asin(),
            Op::Acos => a.acos(),
            Op::Atan => a.atan(),
            Op::Sinh => a.sinh(),
            Op::Cosh => a.cosh(),
            Op::Tanh => a.tanh(),
            Op::Pow => a.pow(b),
            Op::Min => a.min(b),
            Op::Max => a.max(b),
            Op::Sign => a.sign(),
            Op::Less => a.less(b),
        }
    }
}

impl Number for Affine {
    const ZERO: Self = Affine::ZERO;

    fn constant(constant: &Constant) -> Self {
        constant.enclosure.into()
    }

    #[inline]
    fn apply(op: Op, a: Self, b: Self) -> Self {
        let one = Interval::point(1.0);
        match op {
            Op::Neg => -a,
            Op::Add => a + b,
            Op::Sub => a - b,
            Op::Mul | Op::Power(_) => a * b,
            Op::Square => a.square(),
            Op::Div => a * b.map(|x| one / x, |x| -(one / x.square())),
            Op::Sqrt => a.map(Interval::sqrt, |x| one / (x.sqrt() + x.sqrt())),
            Op::Abs => a.map(Interval::abs, Interval::sign),
            Op::Exp => a.map(Interval::exp, Interval::exp),
            Op::Log => a.map(Interval::ln, |x| one / x),
            Op::Sin => a.map(Interval::sin, Interval::cos),
            Op::Cos => a.map(Interval::cos, |x| -x.sin()),
            Op::Tan => a.map(Interval::tan, |x| one + x.tan().square()),
            Op::Asin => a.map(Interval::asin, |x| one / (one - x.square()).sqrt()),
            Op::Acos => a.map(Interval::acos, |x| -(one / (one - x.square()).sqrt())),
            Op::Atan => a.map(Interval::atan, |x| one / (one + x.square())),
            Op::Sinh => a.map(Interval::sinh, Interval::cosh),
            Op::Cosh => a.map(Interval::cosh, Interval::sinh),
            Op::Tanh => a.map(Interval::tanh, |x| one - x.tanh().square()),
            Op::Pow if b.radius() == 0.0 => {
                let exponent = Interval::point(b.center);
                a.map(|x| x.pow(exponent), |x| exponent * x.pow(exponent - one))
            }
            Op::Pow | Op::Min | Op::Max | Op::Less => Interval::apply(op, a.range(), b.range()).into(),
            Op::Sign => a.range().sign().into(),
        }
    }
}

/// A computed number with a bound on its distance from the exact one: running error analysis
/// (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounded {
    pub(super) value: f64,
    pub(super) error: f64,
}

/// Largest relative error of one rounding.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Largest absolute error of one rounding that underflows.
const UNDERFLOW: f64 = f64::MIN_POSITIVE * f64::EPSILON;

impl Bounded {
    /// An operand without error.
    pub(super) fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    fn rounded(value: f64, inherited: f64) -> Self {
        Self { value, error: inherited + UNIT_ROUNDOFF * value.abs() }
    }

    fn enclosure(self) -> Interval {
        Interval::new((self.value - self.error).next_down(), (self.value + self.error).next_up())
    }

    /// `value`, with the exact result somewhere in `range`.
    fn within(value: f64, range: Interval) -> Self {
        Self { value, error: (range.hi - value).max(value - range.lo) }
    }
}

impl Number for Bounded {
    const ZERO: Self = Bounded { value: 0.0, error: 0.0 };

    fn constant(constant: &Constant) -> Self {
        Self::within(constant.value, constant.enclosure)
    }

    fn apply(op: Op, a: Self, b: Self) -> Self {
        let value = f64::apply(op, a.value, b.value);
        match op {
            Op::Neg | Op::Abs => Self { value, error: a.error },
            Op::Add | Op::Sub => Self::rounded(value, a.error + b.error),
            Op::Mul | Op::Power(_) => Self::rounded(
                value,
                a.value.abs() * b.error + b.value.abs() * a.error + a.error * b.error + UNDERFLOW,
            ),
            Op::Square => Self::rounded(value, (2.0 * a.value.abs() + a.error) * a.error + UNDERFLOW),
            Op::Div if b.value.abs() > b.error => {
                let inherited = (a.error + value.abs() * b.error) / (b.value.abs() - b.error);
                Self::rounded(value, inherited + UNDERFLOW)
            }
            Op::Div => Self { value, error: f64::INFINITY },
            Op::Min | Op::Max => Self { value, error: a.error.max(b.error) },
            _ => Self::within(value, Interval::apply(op, a.enclosure(), b.enclosure())),
        }
    }
}
