//! Constants of a formula as exact rational numbers.

use super::number::Constant;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

/// Numerators and denominators beyond this many bits are not kept exactly: each alone must fit a float, so that
/// a formula can be printed and read again.
const MAX_BITS: u64 = 1023;
/// Longest decimal that is kept exactly, in characters.
const MAX_DECIMAL: usize = 600;

/// A constant: exact where it is rational and not enormous, else only to the nearest float.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Exact {
    /// A rational number whose nearest float is finite.
    Rational(BigRational),
    /// A float next to the exact number.
    Rounded(f64),
}

impl Exact {
    /// The rational number, unless it is beyond the limits.
    pub(super) fn rational(value: BigRational) -> Option<Self> {
        let bits = value.numer().bits().max(value.denom().bits());
        (bits <= MAX_BITS && value.to_f64().is_some_and(f64::is_finite)).then_some(Self::Rational(value))
    }

    pub(super) fn as_rational(&self) -> Option<&BigRational> {
        match self {
            Self::Rational(value) => Some(value),
            Self::Rounded(_) => None,
        }
    }

    pub(super) fn value(&self) -> f64 {
        match self {
            Self::Rational(value) => value.to_f64().unwrap_or(f64::NAN),
            Self::Rounded(value) => *value,
        }
    }

    pub(super) fn negated(&self) -> Self {
        match self {
            Self::Rational(value) => Self::Rational(-value),
            Self::Rounded(value) => Self::Rounded(-value),
        }
    }

    /// As a constant of a tape.
    pub(super) fn constant(&self) -> Constant {
        let value = self.value();
        let is_float = self.as_rational().is_some_and(|r| BigRational::from_float(value).as_ref() == Some(r));
        if is_float { Constant::exact(value) } else { Constant::rounded(value) }
    }

    /// As a whole number that can be an exponent.
    pub(super) fn as_integer(&self) -> Option<i32> {
        self.as_rational().filter(|r| r.is_integer()).and_then(|r| r.to_integer().to_i32())
    }

    pub(super) fn is_negative(&self) -> bool {
        match self {
            Self::Rational(value) => value.is_negative(),
            Self::Rounded(value) => *value < 0.0,
        }
    }
}

/// An unsigned decimal number such as 12, .5, 2.5e-3; none if it is none, or too large or too small for a float.
pub(super) fn parse_decimal(text: &str) -> Option<Exact> {
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (&text[..at], text[at + 1..].parse::<i64>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = || whole.chars().chain(fraction.chars());
    if digits().next().is_none() || !digits().all(|c| c.is_ascii_digit()) {
        return None;
    }
    let value: f64 = text.parse().ok()?;
    let is_zero = digits().all(|c| c == '0');
    if !value.is_finite() || (value == 0.0 && !is_zero) {
        return None;
    }
    if is_zero {
        return Some(Exact::Rational(BigRational::zero()));
    }
    if mantissa.len() > MAX_DECIMAL {
        return Some(Exact::Rounded(value));
    }
    let digits = digits().collect::<String>().parse::<BigInt>().ok()?;
    let scale = exponent.checked_sub(fraction.len() as i64)?;
    // A finite float and a mantissa of bounded length: the power of ten is bounded as well.
    let power = BigInt::from(10).pow(u32::try_from(scale.unsigned_abs()).ok()?);
    let exact = if scale >= 0 { BigRational::from(digits * power) } else { BigRational::new(digits, power) };
    Some(Exact::rational(exact).unwrap_or(Exact::Rounded(value)))
}
