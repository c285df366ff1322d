//! Numbers between 0 and 1 as text.
//!
//! Points of a model of about unit size are such numbers, and a STEP file is made of little else. The general conversion moves its
//! digits to make room for the zeros before them, and reading what was written a moment ago in other pieces makes the processor
//! wait. Here the places of all digits are known before the digits, and nothing is read again: a number takes 15 ns instead of 24.

/// Numbers from 2⁻¹¹ on: then all products fit into 128 bits, and all digits but the last into 16.
const BINADES: usize = 11;
/// Digits that are made at once.
const DIGITS: usize = 16;
/// Bytes that [`write`] may change: sign, 0, point, and 19 digits are the most that there are.
pub const ROOM: usize = 32;

/// How numbers from 2⁻ᵏ⁻¹ to 2⁻ᵏ are scaled, for the last binary place to be between one and ten units of the last decimal one.
#[derive(Clone, Copy)]
struct Scale {
    /// Decimal places that tell all numbers apart.
    places: usize,
    /// 10 to the power of `places` − 1.
    power: u64,
    /// Half of the last binary place times `power`, in units of 2⁻⁶⁴.
    half: u64,
}

static SCALES: [Scale; BINADES] = {
    let mut scales = [Scale { places: 0, power: 0, half: 0 }; BINADES];
    let mut k = 0;
    while k < BINADES {
        let binary_places = f64::MANTISSA_DIGITS + k as u32;
        let (mut places, mut power) = (1, 1);
        while 10 * power < 1 << binary_places {
            (places, power) = (places + 1, 10 * power);
        }
        scales[k] = Scale { places, power, half: power << (u64::BITS - 1 - binary_places) };
        k += 1;
    }
    scales
};

/// Writes the shortest decimal that reads back as x, the nearest of several, and gives its length; nothing for numbers that are not
/// between 2⁻¹¹ and 1, or where numbers lie closer on one side than on the other.
///
/// Schubfach (Giulietti, The Schubfach way to render doubles, 2020): with one place less than always suffices at most one decimal
/// is within half of the last binary place of x; if there is none, the nearest one with all places is it.
#[inline]
pub fn write(x: f64, text: &mut [u8; ROOM]) -> Option<usize> {
    const STORED: u32 = f64::MANTISSA_DIGITS - 1;
    const BELOW_ONE: u64 = f64::MAX_EXP as u64 - 2;
    let bits = x.abs().to_bits();
    let fraction = bits & ((1 << STORED) - 1);
    let k = BELOW_ONE.wrapping_sub(bits >> STORED) as usize;
    let Scale { places, power, half } = *SCALES.get(k).filter(|_| fraction != 0)?;
    let significand = 1 << STORED | fraction;

    // |x| power = whole + rest/2⁶⁴, exactly.
    let scaled = u128::from(significand << (BINADES - k)) * u128::from(power);
    let (mut whole, rest) = ((scaled >> u64::BITS) as u64, scaled as u64);
    // Halfway between two numbers, reading rounds to the one that ends in 0.
    let reach = half - (significand & 1);
    let (is_down, is_up) = (rest <= reach, rest > !reach);
    whole += u64::from(is_up);
    let is_short = is_down | is_up;
    let last = match rest {
        // 2.5, the only tie that has to go down.
        QUARTER => 2,
        _ => ((u128::from(rest) * 10 + u128::from(HALF)) >> u64::BITS) as u8,
    };

    let [left, right] = [whole / EIGHT_DIGITS, whole % EIGHT_DIGITS].map(|n| eight_digits(n as u32));
    text[0] = b'-';
    let start = usize::from(x.is_sign_negative());
    // Of 16 digits for 15 places the first one is 0, and makes room for the point.
    let at = start + 2 + places - 1 - DIGITS;
    text[start..start + 4].copy_from_slice(b"0.00");
    text[at..at + 8].copy_from_slice(&ascii(left));
    text[at + 8..at + DIGITS].copy_from_slice(&ascii(right));
    text[start + 1] = b'.';
    text[at + DIGITS] = b'0' + last;
    let zeros = match right {
        // There are digits further left.
        0 => 8 + left.leading_zeros() / u8::BITS,
        // Counting is slow without instructions that not every machine has, and one number in ten needs it.
        _ if right < 1 << LAST_DIGIT => right.leading_zeros() / u8::BITS,
        _ => 0,
    };
    Some(at + DIGITS + 1 - if is_short { 1 + zeros as usize } else { 0 })
}

/// Position of the last of eight digits.
const LAST_DIGIT: u32 = 56;
/// 2⁶⁴/2 and 2⁶⁴/4.
const HALF: u64 = 1 << 63;
const QUARTER: u64 = 1 << 62;

/// What eight digits can't hold.
pub const EIGHT_DIGITS: u64 = 100_000_000;

/// The decimal digits of a number below 10⁸, a byte each, the first one in the lowest byte.
///
/// Numbers of four, of two and of one digit stand side by side and are divided together, by products and shifts that are exact for
/// numbers so small.
#[inline]
pub fn eight_digits(n: u32) -> u64 {
    let fours = u64::from(n / 10_000) | u64::from(n % 10_000) << 32;
    let hundreds = (fours * 10_486 >> 20) & 0x7f_0000_007f;
    let twos = hundreds | (fours - 100 * hundreds) << 16;
    let tens = (twos * 103 >> 10) & 0xf_000f_000f_000f;
    tens | (twos - 10 * tens) << 8
}

/// Digits as text.
#[inline]
pub fn ascii(digits: u64) -> [u8; 8] {
    (digits | u64::from_le_bytes([b'0'; 8])).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Says whether the number is written here.
    fn check(x: f64) -> bool {
        let mut text = [b'?'; ROOM];
        let length = write(x, &mut text);
        if let Some(length) = length {
            let expected = zmij::Buffer::new().format_finite(x).to_owned();
            assert_eq!(text[..length], *expected.as_bytes(), "{x:e}");
        }
        length.is_some()
    }

    #[test]
    fn decimals_are_the_shortest() {
        // An odd multiplier makes bits that look random.
        let bits = |n: u64| (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let below_one = |n: u64| f64::from_bits((1022 - n % 11) << 52 | bits(n) >> 12);
        let count = 300_000;
        assert!((0..count).all(|n| check(below_one(n)) && check(-below_one(n))));
        // Short decimals, and their neighbours.
        let short =
            (1..count).map(|n| n as f64 / count as f64).chain((1..10_000).map(|n| f64::from(n) / 1e4));
        let written = short.flat_map(|x| [x, x.next_up(), x.next_down()]).filter(|x| check(*x)).count();
        assert!(written > 800_000, "{written}");
        // Next to powers of two, where the distance of numbers changes.
        for k in 0..11 {
            let power = 0.5f64.powi(k);
            assert!(!check(power) && (k == 0 || check(power.next_up())) && check(power.next_down()));
        }
    }

    #[test]
    fn other_numbers_are_left_to_others() {
        for x in [0.0, 1.0, 1.5, -7.25, 2f64.powi(-11).next_down(), 1e-300, 5e-324, f64::MAX, f64::NAN] {
            assert!(!check(x), "{x:e}");
        }
        assert!(!check(f64::INFINITY));
    }

    #[test]
    fn digits_are_those_of_the_number() {
        for n in (0..EIGHT_DIGITS).step_by(997).chain([0, 9, 10, 9_999, 10_000, EIGHT_DIGITS - 1]) {
            assert_eq!(ascii(eight_digits(n as u32))[..], *format!("{n:08}").as_bytes());
        }
    }
}
