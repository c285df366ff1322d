//! Coordinates as text.

use crate::io::text::{ASCII, eight_digits};
use pulp::{Arch, NullaryFnOnce};

/// One in the last of 15 decimals.
const ONE: f64 = 1e15;
/// One in the eighth last.
const EIGHT: f64 = 1e8;

/// Coordinates below this are with 15 decimals an integer of 64 bits.
const MOST: f64 = 9e3;

/// Coordinates whose digits are found together: enough for the vector unit, few enough for the first cache.
pub const TOGETHER: usize = 48;

/// Characters of a coordinate below [`MOST`]: sign, four digits, point and 15 decimals.
pub const WIDTH: usize = 21;

/// How the coordinates of a file are written: as ISO 10303-21 wants a REAL, with a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimals {
    /// The fewest that read back as the same number.
    Shortest,
    /// At most 15, found side by side, which is faster.
    Fifteen,
}

impl Decimals {
    /// For coordinates of at most `largest`: 15 decimals are enough if half of the last one is not much more than the last bit of that.
    pub fn of(largest: f64) -> Self {
        match (1.0..MOST).contains(&largest) {
            true => Self::Fifteen,
            false => Self::Shortest,
        }
    }

    /// The digits of coordinates; none if they are to be written one by one, by `push_real`.
    pub fn digits(self, coordinates: &[f64; TOGETHER]) -> Option<Digits> {
        let largest = coordinates.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        (self == Self::Fifteen && largest < MOST).then(|| Arch::new().dispatch(Divide { coordinates }))
    }
}

/// Coordinates rounded to 15 decimals, each number in an array of its own.
pub struct Digits {
    /// One for a minus.
    minus: [u64; TOGETHER],
    /// What stands before the point.
    whole: [u64; TOGETHER],
    /// The point and seven decimals, then eight decimals, as characters; the first one in the lowest byte.
    first: [u64; TOGETHER],
    last: [u64; TOGETHER],
}

struct Divide<'a> {
    coordinates: &'a [f64; TOGETHER],
}

/// Quotient and remainder of n < 2⁶³ by d, all integers and the quotient below 2⁵²: in floating-point numbers, which machines divide
/// side by side. The quotient is off by one at most, which the remainder tells; that is exact, being small and rounded once.
#[inline(always)]
fn divide(n: f64, d: f64) -> (f64, f64) {
    let quotient = (n * (1.0 / d)).floor();
    let remainder = quotient.mul_add(-d, n);
    let less = if remainder < 0.0 { 1.0 } else { 0.0 };
    let more = if remainder >= d { 1.0 } else { 0.0 };
    (quotient - less + more, (less - more) * d + remainder)
}

/// An integer 0 ≤ x < 2⁵². Beside 2⁵², it is what stands in the mantissa.
#[inline(always)]
fn integer(x: f64) -> u64 {
    const BESIDE: f64 = (1_u64 << 52) as f64;
    (x + BESIDE).to_bits() ^ BESIDE.to_bits()
}

impl NullaryFnOnce for Divide<'_> {
    type Output = Digits;

    #[inline(always)]
    fn call(self) -> Digits {
        let zeros = [0; TOGETHER];
        let mut digits = Digits { minus: zeros, whole: zeros, first: zeros, last: zeros };
        for (k, x) in self.coordinates.iter().enumerate() {
            let n = (x.abs() * ONE + 0.5).floor();
            let (high, last) = divide(n, EIGHT);
            let (whole, first) = divide(high, ONE / EIGHT);
            digits.minus[k] = u64::from(*x < 0.0) & u64::from(n > 0.0);
            digits.whole[k] = integer(whole);
            // One more keeps the zeros in front; its digit becomes the point.
            digits.first[k] = (eight_digits(integer(first + ONE / EIGHT)) | ASCII) ^ u64::from(b'1' ^ b'.');
            digits.last[k] = eight_digits(integer(last)) | ASCII;
        }
        digits
    }
}

impl Digits {
    /// Writes coordinate `k` at `at`, without zeros at its end, and returns where it ends; [`WIDTH`] characters from `at` may change.
    #[inline(always)]
    pub fn put(&self, k: usize, line: &mut [u8], mut at: usize) -> usize {
        line[at] = b'-';
        at += self.minus[k] as usize;
        match self.whole[k] {
            digit @ 0..=9 => line[at] = b'0' + digit as u8,
            whole => {
                let digits = eight_digits(whole);
                let zeros = digits.trailing_zeros() / 8;
                let text = ((digits | ASCII) >> (8 * zeros)).to_le_bytes();
                line[at..at + 4].copy_from_slice(&text[..4]);
                at += 7 - zeros as usize;
            }
        }
        at += 1;
        let (first, last) = (self.first[k], self.last[k]);
        line[at..at + 8].copy_from_slice(&first.to_le_bytes());
        line[at + 8..at + 16].copy_from_slice(&last.to_le_bytes());
        // The point is no zero, so that the first eight never run out.
        let zeros = match last ^ ASCII {
            0 => 8 + (first ^ ASCII).leading_zeros() / 8,
            decimals => decimals.leading_zeros() / 8,
        };
        at + 16 - zeros as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::text::push_real;

    fn written(largest: f64, x: f64) -> String {
        let mut coordinates = [0.5; TOGETHER];
        coordinates[TOGETHER - 1] = x;
        let mut text = Vec::new();
        match Decimals::of(largest).digits(&coordinates) {
            Some(digits) => {
                text.resize(WIDTH, b'?');
                let end = digits.put(TOGETHER - 1, &mut text, 0);
                text.truncate(end);
            }
            None => push_real(&mut text, x),
        }
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn fifteen_decimals_say_what_numbers_of_that_size_know() {
        for i in 0..2000 {
            // From a millionth to eight thousand, of both signs.
            let size = 1e-6 * 10_f64.powf(9.9 * f64::from(i) / 2000.0);
            let x = if i % 2 == 0 { size } else { -size };
            let text = written(8999.0, x);
            let read: f64 = text.parse().unwrap();
            // Half a decimal; and the product, the sum and what is read are rounded to half a last bit each.
            let roundings = 1.5 * size * f64::EPSILON;
            assert!((read - x).abs() <= 0.5e-15 + roundings, "{x:e} {text}");
            assert!(
                text.contains('.') && !text.ends_with('0') && text.starts_with('-') == (i % 2 == 1),
                "{text}"
            );
        }
    }

    #[test]
    fn digits_are_those_of_the_rounded_integer() {
        for i in 0..20_000_u32 {
            // Beside multiples of powers of ten, where quotients are most easily off by one, and anywhere.
            let around = 10_f64.powi(i as i32 % 19 - 15) * f64::from(i % 8);
            let x = (around + f64::from(i / 8) * 1e-15).min(MOST.next_down());
            let n = (x * ONE + 0.5) as u64;
            let text = format!("{}.{:015}", n / ONE as u64, n % ONE as u64);
            assert_eq!(written(1.0, x), text.trim_end_matches('0'), "{x:e}");
        }
    }

    #[test]
    fn short_numbers_stay_short() {
        for (x, text) in [
            (0.0, "0."),
            (-0.0, "0."),
            (-4e-16, "0."),
            (1e-15, "0.000000000000001"),
            (-1.0, "-1."),
            (20.5, "20.5"),
            (0.999_999_999_999_999_9, "1."),
            (-1234.0625, "-1234.0625"),
        ] {
            assert_eq!(written(1.0, x), text);
        }
    }

    #[test]
    fn small_and_large_files_have_all_digits() {
        for largest in [0.3, MOST, 1e300] {
            assert_eq!(written(largest, 1.0 / 3.0), "0.3333333333333333");
        }
        // No coordinate of a file is larger than its largest; if one were, it would be right nevertheless.
        assert_eq!(written(1.0, 1.25e20), "1.25E+20");
        assert_eq!(written(1.0, MOST), "9000.0");
    }
}
