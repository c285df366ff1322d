//! Coordinates as text.

use crate::io::text::{ASCII, NINE_DIGITS, eight_digits, push_integer, push_real};

/// One in the last of 15 decimals.
const ONE: u64 = 10_u64.pow(15);

/// Coordinates below this are with 15 decimals an integer of 64 bits.
const MOST: f64 = 9e3;

/// How the coordinates of a file are written: as ISO 10303-21 wants a REAL, with a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimals {
    /// The fewest that read back as the same number.
    Shortest,
    /// At most 15, which takes two thirds of the time.
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

    /// Appends a coordinate.
    pub fn push(self, text: &mut Vec<u8>, x: f64) {
        let size = x.abs();
        if self == Self::Shortest || size >= MOST {
            return push_real(text, x);
        }
        let n = (size * ONE as f64 + 0.5) as i64 as u64;
        // In one way for both signs: no branch can be told before.
        text.push(b'-');
        text.truncate(text.len() - usize::from(n == 0 || x > 0.0));
        match n / ONE {
            digit @ 0..=9 => text.push(b'0' + digit as u8),
            whole => push_integer(text, whole),
        }
        let point = text.len();
        // One more keeps the zeros in front; its digit is where the point stands.
        let sixteen = ONE + n % ONE;
        for half in [sixteen / NINE_DIGITS, sixteen % NINE_DIGITS] {
            text.extend_from_slice(&(eight_digits(half) | ASCII).to_le_bytes());
        }
        text[point] = b'.';
        while text.ends_with(b"0") {
            text.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(largest: f64, x: f64) -> String {
        let mut text = b"0".to_vec();
        Decimals::of(largest).push(&mut text, x);
        String::from_utf8(text).unwrap().split_off(1)
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
