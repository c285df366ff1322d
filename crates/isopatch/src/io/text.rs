//! Numbers as text, and text in parallel.

use rayon::prelude::*;
use std::io::{self, Write};

/// Bytes that a buffer is to hold: enough to keep a thread busy and to pass by the buffer of a file, few enough to stay in the
/// cache.
const BYTES_PER_BUFFER: usize = 3 << 15;
/// Memory of a buffer: the last item reaches beyond, and items differ in length.
const ROOM: usize = BYTES_PER_BUFFER / 4 * 5;
/// Items of the first buffers, before it is known how long they are.
const FIRST_ITEMS: usize = 32;
/// Buffers a thread that are filled before they are written.
const BUFFERS_PER_THREAD: usize = 2;

/// Sizes of numbers that are written without an exponent in any case.
const PLAIN: std::ops::Range<f64> = 1e-4..1e15;

/// Appends the shortest decimal that reads back as `x`, as ISO 10303-21 wants a REAL: with a point, exponent E.
pub fn push_real(text: &mut Vec<u8>, x: f64) {
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format_finite(x);
    let is_plain = PLAIN.contains(&x.abs());
    match (!is_plain).then(|| digits.split_once('e')).flatten() {
        None => push_word(text, digits.as_bytes()),
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
    push_word(text, zmij::Buffer::new().format_finite(x).as_bytes());
}

/// Appends a word. Words of most lengths are two pieces of fixed length that overlap, which takes no call.
fn push_word(text: &mut Vec<u8>, word: &[u8]) {
    if !(push_pieces::<4>(text, word) || push_pieces::<8>(text, word) || push_pieces::<16>(text, word)) {
        text.extend_from_slice(word);
    }
}

/// Appends a word of N to 2N bytes; false if it has another length.
#[inline(always)]
fn push_pieces<const N: usize>(text: &mut Vec<u8>, word: &[u8]) -> bool {
    match (word.first_chunk::<N>(), word.last_chunk::<N>()) {
        (Some(first), Some(last)) if word.len() <= 2 * N => {
            let end = text.len() + word.len();
            text.extend_from_slice(first);
            text.extend_from_slice(last);
            text[end - N..end].copy_from_slice(last);
            text.truncate(end);
            true
        }
        _ => false,
    }
}

/// Numbers from here on have more than eight digits.
pub const NINE_DIGITS: u64 = 100_000_000;

/// Appends an unsigned integer.
pub fn push_integer(text: &mut Vec<u8>, n: u64) {
    if n >= NINE_DIGITS {
        return push_word(text, itoa::Buffer::new().format(n).as_bytes());
    }
    // Nearly half of the numbers in a STEP file are those of entities: always eight bytes, without a branch or a call.
    let digits = eight_digits(n);
    let zeros = (digits.trailing_zeros() / 8).min(7);
    text.extend_from_slice(&((digits | ASCII) >> (8 * zeros)).to_le_bytes());
    text.truncate(text.len() - zeros as usize);
}

/// What makes eight digits characters.
pub const ASCII: u64 = 0x3030_3030_3030_3030;

/// The digits of a number below 10⁸, a byte each, the first one in the lowest byte: halves, quarters and eighths of it side by
/// side in one register. Quotients are products with 2⁴⁰/10⁴, 2²⁰/100 and 2¹⁰/10,
/// rounded up, and exact for numbers that small; unlike a division, they can be taken of several numbers at once.
#[inline(always)]
pub fn eight_digits(n: u64) -> u64 {
    let high = (n * 109_951_163) >> 40;
    let halves = high | (n - 10_000 * high) << 32;
    let hundreds = ((halves * 10_486) >> 20) & 0x7f_0000_007f;
    let quarters = hundreds | (halves - 100 * hundreds) << 16;
    let tens = ((quarters * 103) >> 10) & 0xf_000f_000f_000f;
    tens | (quarters - 10 * tens) << 8
}

/// Writes items 0 … `count` − 1 in order, each as `format` appends it, formatting in parallel.
pub fn write_items(
    out: &mut impl Write,
    count: usize,
    format: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    Buffers::default().write_items(out, count, format)
}

/// Memory for what is written, kept for what is written next: new memory is slower than the text that goes into it.
#[derive(Debug, Default)]
pub struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// As [`write_items`].
    pub fn write_items(
        &mut self,
        out: &mut impl Write,
        count: usize,
        format: impl Fn(usize, &mut Vec<u8>) + Sync,
    ) -> io::Result<()> {
        self.write_items_with(out, count, || (), |(), item, text| format(item, text))
    }

    /// So many of them at least.
    fn at_least(&mut self, count: usize) -> &mut [Vec<u8>] {
        let more = count.saturating_sub(self.0.len());
        self.0.extend((0..more).map(|_| Vec::with_capacity(ROOM)));
        &mut self.0
    }

    /// The same with something that `format` works in, which is made once a buffer.
    pub fn write_items_with<R>(
        &mut self,
        out: &mut impl Write,
        count: usize,
        room: impl Fn() -> R + Sync,
        format: impl Fn(&mut R, usize, &mut Vec<u8>) + Sync,
    ) -> io::Result<()> {
        let fill = |buffer: &mut Vec<u8>, items: std::ops::Range<usize>| {
            buffer.clear();
            let mut room = room();
            items.for_each(|item| format(&mut room, item, buffer));
        };
        // The length of the first items says how many go into a buffer: what is compressed depends on where buffers end, and that must
        // not depend on the number of threads.
        let (buffer, mut first) = (&mut self.at_least(1)[0], 0);
        buffer.clear();
        let mut room_of_first = room();
        while first < count.min(FIRST_ITEMS) && buffer.len() < BYTES_PER_BUFFER {
            format(&mut room_of_first, first, buffer);
            first += 1;
        }
        out.write_all(buffer)?;
        let items = (first * BYTES_PER_BUFFER).div_ceil(buffer.len().max(FIRST_ITEMS)).max(1);
        // One thread alone writes a buffer while it is in the cache.
        let most = match rayon::current_num_threads() {
            1 => 1,
            threads => BUFFERS_PER_THREAD * threads,
        };
        let wanted = most.min(count.saturating_sub(first).div_ceil(items));
        let buffers = self.at_least(wanted);
        for start in (first..count).step_by(most * items) {
            let used = most.min((count - start).div_ceil(items));
            buffers[..used].par_iter_mut().enumerate().for_each(|(b, buffer)| {
                let first = start + b * items;
                fill(buffer, first..count.min(first + items));
            });
            buffers[..used].iter().try_for_each(|buffer| out.write_all(buffer))?;
        }
        Ok(())
    }
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
        for x in [PLAIN.start, 1.23e-4, PLAIN.end.next_down(), 9.0e14] {
            assert!(!zmij::Buffer::new().format_finite(x).contains('e'), "{x:e}");
        }
    }

    #[test]
    fn integers_are_decimal() {
        let written = |n: u64| {
            let mut text = b"#".to_vec();
            push_integer(&mut text, n);
            String::from_utf8(text).unwrap()
        };
        // Every pair and every four digits there are, at both ends of the eight.
        let quarters = (0..10_000).flat_map(|n| [n, 10_000 * n, 10_000 * n + 9_999 - n]);
        let others = [NINE_DIGITS - 1, NINE_DIGITS, 1_234_567_890, u64::MAX];
        for n in quarters.chain(others) {
            assert_eq!(written(n), format!("#{n}"));
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
