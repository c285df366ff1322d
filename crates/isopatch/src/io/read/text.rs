use super::{Place, ReadError};
use crate::geom::Vec3;
use std::str::FromStr;

/// The least bytes of a word in a text file: one character and a separator.
pub(super) const WORD_BYTES: usize = 2;

/// The most characters of a wrong word that a message repeats.
const QUOTED_BYTES: usize = 40;

/// A text file as a stream of words.
///
/// Blanks separate words and `#` starts a comment, up to the end of the line. A backslash just before a line
/// end joins the two lines, as in OBJ; the other formats have no use for a backslash. Lines end in LF or CR LF.
/// Bytes, not `str`, because comments and names come in any encoding.
#[derive(Clone)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
        let at = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
        Self { bytes, at, line: 1 }
    }

    /// Where the next byte is.
    pub fn place(&self) -> Place {
        Place::Line(self.line)
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.at
    }

    pub fn bytes_left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next word of the file, on this line or a later one.
    pub fn next_word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks(true);
        self.take_word()
    }

    /// The next word of this line.
    pub fn next_on_line(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks(false);
        self.take_word()
    }

    /// Goes to the start of the next line.
    pub fn skip_line(&mut self) {
        self.skip_to_line_end();
        if self.at < self.bytes.len() {
            self.at += 1;
            self.line += 1;
        }
    }

    /// Gives back the last `count` bytes of the word just taken.
    pub fn step_back(&mut self, count: usize) {
        self.at -= count;
    }

    /// The next word of the file, which must exist.
    pub fn word(&mut self, expected: &'static str) -> Result<&'a [u8], ReadError> {
        self.next_word().ok_or(ReadError::Truncated { place: self.place(), expected })
    }

    /// The next word of the file as a number.
    pub fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, ReadError> {
        let word = self.word(expected)?;
        self.parse(word, expected)
    }

    /// The next word of this line as a number.
    pub fn number_on_line<T: FromStr>(&mut self, expected: &'static str) -> Result<T, ReadError> {
        match self.next_on_line() {
            Some(word) => self.parse(word, expected),
            None => Err(self.syntax(expected, "the end of the line".into())),
        }
    }

    /// The next three words of the file as a vector.
    pub fn vector(&mut self, expected: &'static str) -> Result<Vec3, ReadError> {
        Ok(Vec3::new(self.number(expected)?, self.number(expected)?, self.number(expected)?))
    }

    /// A word just taken, as a number.
    pub fn parse<T: FromStr>(&self, word: &[u8], expected: &'static str) -> Result<T, ReadError> {
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.ok_or_else(|| self.wrong(word, expected))
    }

    /// The error about a word just taken.
    pub fn wrong(&self, word: &[u8], expected: &'static str) -> ReadError {
        let start = &word[..word.len().min(QUOTED_BYTES)];
        let dots = if start.len() < word.len() { "…" } else { "" };
        self.syntax(expected, format!("`{}{dots}`", start.escape_ascii()))
    }

    /// The error if any word follows.
    pub fn expect_end(&mut self) -> Result<(), ReadError> {
        match self.next_word() {
            Some(_) => Err(ReadError::Trailing { place: self.place() }),
            None => Ok(()),
        }
    }

    fn syntax(&self, expected: &'static str, found: String) -> ReadError {
        ReadError::Syntax { place: self.place(), expected, found }
    }

    fn skip_blanks(&mut self, across_lines: bool) {
        loop {
            match &self.bytes[self.at..] {
                [b'#', ..] => self.skip_to_line_end(),
                [b'\n', ..] if !across_lines => return,
                [b'\n', ..] => self.skip_line(),
                [b, ..] if b.is_ascii_whitespace() => self.at += 1,
                rest if joins_lines(rest) => self.skip_line(),
                _ => return,
            }
        }
    }

    fn skip_to_line_end(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }

    /// The word at the next byte; none at the end of the line or file.
    fn take_word(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let ends = |i: usize| rest[i] == b'#' || rest[i].is_ascii_whitespace() || joins_lines(&rest[i..]);
        let length = (0..rest.len()).find(|&i| ends(i)).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then(|| &rest[..length])
    }
}

fn joins_lines(rest: &[u8]) -> bool {
    rest.starts_with(b"\\\n") || rest.starts_with(b"\\\r\n")
}
