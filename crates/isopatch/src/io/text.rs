//! Numbers as text, and text in parallel.

use rayon::prelude::*;
use std::io::{self, Write};

/// Bytes that a buffer is to hold: enough to keep a thread busy and to pass by the buffer of a file, few enough to stay in the
/// cache.
const BYTES_PER_BUFFER: usize = 1 << 18;
/// Items of the first buffers, before it is known how long they are.
const FIRST_ITEMS: usize = 32;
/// Buffers a thread that are filled before they are written.
const BUFFERS_PER_THREAD: usize = 2;

/// Bytes that an exponent can take at the end of a number, as in e-308.
const EXPONENT: usize = 5;

/// Appends the shortest decimal that reads back as `x`, as ISO 10303-21 wants a REAL: with a point, exponent E.
pub fn push_real(text: &mut Vec<u8>, x: f64) {
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format_finite(x);
    let end = digits.len().saturating_sub(EXPONENT);
    match digits.as_bytes()[end..].contains(&b'e').then(|| digits.split_once('e')).flatten() {
        None => text.extend_from_slice(digits.as_bytes()),
        Some((mantissa, exponent)) => {
            text.extend_from_slice(mantissa.as_bytes());
            if !mantissa.contains('.') {
                text.push(b'.');
            }
            text.push(b'E');
            text.extend_from_slice(exponent.as_bytes());
        }
    }
}

/// Appends the shortest decimal that reads back as `x`.
pub fn push_float(text: &mut Vec<u8>, x: f64) {
    text.extend_from_slice(zmij::Buffer::new().format_finite(x).as_bytes());
}

/// Appends an unsigned integer.
pub fn push_integer(text: &mut Vec<u8>, mut n: u64) {
    // The largest 64-bit number has 20 digits.
    let mut digits = [0u8; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (n % 10) as u8;
        n /= 10;
        if n == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[start..]);
}

/// Writes items 0 … `count` − 1 in order, each as `format` appends it, formatting in parallel.
pub fn write_items(
    out: &mut impl Write,
    count: usize,
    format: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    let fill = |buffer: &mut Vec<u8>, items: std::ops::Range<usize>| {
        buffer.clear();
        items.for_each(|item| format(item, buffer));
    };
    // The length of the first items says how many go into a buffer: what is compressed depends on where buffers end, and that must
    // not depend on the number of threads.
    let mut first = Vec::new();
    fill(&mut first, 0..count.min(FIRST_ITEMS));
    out.write_all(&first)?;
    let items = (FIRST_ITEMS * BYTES_PER_BUFFER).div_ceil(first.len().max(FIRST_ITEMS));
    let most = BUFFERS_PER_THREAD * rayon::current_num_threads();
    let mut buffers = vec![first; most.min(count.saturating_sub(FIRST_ITEMS).div_ceil(items))];
    for start in (FIRST_ITEMS..count).step_by(most * items) {
        let used = most.min((count - start).div_ceil(items));
        buffers[..used].par_iter_mut().enumerate().for_each(|(b, buffer)| {
            let first = start + b * items;
            fill(buffer, first..count.min(first + items));
        });
        buffers[..used].iter().try_for_each(|buffer| out.write_all(buffer))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(x: f64) -> String {
        let mut text = Vec::new();
        push_real(&mut text, x);
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn reals_have_a_point_and_read_back() {
        for x in [0.0, -0.0, 1.0, -2.5, 1e-7, 1.25e-300, 1e21, -1.7976931348623157e308, 5e-324, 0.1 + 0.2] {
            let text = real(x);
            assert!(text.contains('.') && !text.contains('e'), "{text}");
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
        }
        assert_eq!((real(1.0), real(1e-7)), ("1.0".into(), "1.E-7".into()));
    }

    #[test]
    fn integers_are_decimal() {
        for n in [0, 7, 10, 1234567890, u64::MAX] {
            let mut text = Vec::new();
            push_integer(&mut text, n);
            assert_eq!(text, n.to_string().into_bytes());
        }
    }

    #[test]
    fn items_come_in_order() {
        let round = 2 * FIRST_ITEMS;
        for count in [0, 1, FIRST_ITEMS - 1, FIRST_ITEMS, FIRST_ITEMS + 1, round + 100, 100_000] {
            let mut text = Vec::new();
            write_items(&mut text, count, |i, b| {
                push_integer(b, i as u64);
                b.push(b' ');
            })
            .unwrap();
            let expected: String = (0..count).map(|i| format!("{i} ")).collect();
            assert_eq!(text, expected.into_bytes());
        }
    }
}
