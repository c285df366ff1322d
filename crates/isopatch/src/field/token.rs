//! A formula as tokens, each with its place in the text.

use super::constants::Constants;
use super::error::{FormulaErrorKind, Problem};
use super::exact::{Exact, parse_decimal};

/// A run of characters of a formula.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Its first character, counted from 1.
    pub column: usize,
    /// Number of characters.
    pub length: usize,
}

/// A function of the formula language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Function {
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
    Min,
    Max,
}

/// All names of functions. The first name of a function is the one that is printed.
const FUNCTIONS: [(&str, Function); 16] = [
    ("sqrt", Function::Sqrt),
    ("abs", Function::Abs),
    ("exp", Function::Exp),
    ("log", Function::Log),
    ("ln", Function::Log),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("min", Function::Min),
    ("max", Function::Max),
];

impl Function {
    pub(super) fn named(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    pub(super) fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, function)| *function == self).map_or("", |(name, _)| name)
    }

    /// Does it take two or more arguments, not one?
    pub(super) fn is_variadic(self) -> bool {
        matches!(self, Self::Min | Self::Max)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind {
    Number(Exact),
    Constant(Exact),
    Variable(u8),
    Pi,
    Function(Function),
    Plus,
    Minus,
    Times,
    Divide,
    Power,
    Open,
    Close,
    Comma,
    Equals,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) span: Span,
}

pub(super) fn is_name_start(c: char) -> bool {
    c.is_alphabetic()
}

pub(super) fn is_name_part(c: char) -> bool {
    c.is_alphabetic() || c.is_ascii_digit() || c == '_'
}

/// The digit that a raised digit stands for.
fn raised_digit(c: char) -> Option<char> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().zip('0'..='9').find(|(raised, _)| *raised == c).map(|(_, digit)| digit)
}

/// Splits a formula into tokens.
pub(super) fn tokenize(text: &str, constants: &Constants) -> Result<Vec<Token>, Problem> {
    let chars: Vec<char> = text.chars().collect();
    let mut lexer = Lexer { chars: &chars, at: 0, run_end: 0, constants, tokens: Vec::new() };
    while lexer.at < chars.len() {
        lexer.next()?;
    }
    Ok(lexer.tokens)
}

struct Lexer<'a> {
    chars: &'a [char],
    at: usize,
    /// End of the run of letters and digits that was met last.
    run_end: usize,
    constants: &'a Constants,
    tokens: Vec<Token>,
}

impl Lexer<'_> {
    fn peek(&self, ahead: usize) -> Option<char> {
        self.chars.get(self.at + ahead).copied()
    }

    fn span(&self, start: usize, end: usize) -> Span {
        Span { column: start + 1, length: end - start }
    }

    fn push(&mut self, kind: TokenKind, length: usize) {
        let span = self.span(self.at, self.at + length);
        self.tokens.push(Token { kind, span });
        self.at += length;
    }

    fn next(&mut self) -> Result<(), Problem> {
        let Some(c) = self.peek(0) else { return Ok(()) };
        match c {
            c if c.is_whitespace() => self.at += 1,
            '0'..='9' | '.' => self.number()?,
            c if raised_digit(c).is_some() => self.raised()?,
            c if is_name_start(c) => self.names()?,
            '+' => self.push(TokenKind::Plus, 1),
            '-' | '−' => self.push(TokenKind::Minus, 1),
            '*' if self.peek(1) == Some('*') => self.push(TokenKind::Power, 2),
            '*' | '·' | '×' | '⋅' => self.push(TokenKind::Times, 1),
            '/' => self.push(TokenKind::Divide, 1),
            '^' => self.push(TokenKind::Power, 1),
            '(' => self.push(TokenKind::Open, 1),
            ')' => self.push(TokenKind::Close, 1),
            ',' => self.push(TokenKind::Comma, 1),
            '=' => self.push(TokenKind::Equals, 1),
            _ => {
                return Err(Problem::new(
                    FormulaErrorKind::UnknownSymbol(c),
                    self.span(self.at, self.at + 1),
                ));
            }
        }
        Ok(())
    }

    fn digits(&self, mut end: usize) -> usize {
        while self.chars.get(end).is_some_and(char::is_ascii_digit) {
            end += 1;
        }
        end
    }

    /// A decimal number; an e belongs to it only where digits follow.
    fn number(&mut self) -> Result<(), Problem> {
        let mut end = self.digits(self.at);
        if self.chars.get(end) == Some(&'.') {
            end = self.digits(end + 1);
        }
        if matches!(self.chars.get(end), Some('e' | 'E')) {
            let sign = usize::from(matches!(self.chars.get(end + 1), Some('+' | '-')));
            let exponent_end = self.digits(end + 1 + sign);
            if exponent_end > end + 1 + sign {
                end = exponent_end;
            }
        }
        let text: String = self.chars[self.at..end].iter().collect();
        let Some(value) = parse_decimal(&text) else {
            return Err(Problem::new(FormulaErrorKind::BadNumber(text), self.span(self.at, end)));
        };
        self.push(TokenKind::Number(value), end - self.at);
        Ok(())
    }

    /// Raised digits: a power.
    fn raised(&mut self) -> Result<(), Problem> {
        let digits: String = self.chars[self.at..].iter().map_while(|c| raised_digit(*c)).collect();
        let length = digits.chars().count();
        let span = self.span(self.at, self.at + length);
        let value =
            parse_decimal(&digits).ok_or_else(|| Problem::new(FormulaErrorKind::BadNumber(digits), span))?;
        self.tokens.push(Token { kind: TokenKind::Power, span });
        self.push(TokenKind::Number(value), length);
        Ok(())
    }

    /// A run of letters and digits, split into the longest known names.
    fn names(&mut self) -> Result<(), Problem> {
        if self.at >= self.run_end {
            let run = self.chars[self.at..].iter().take_while(|c| is_name_part(**c)).count();
            self.run_end = self.at + run;
        }
        let end = self.run_end;
        // A name that can't be split is reported from behind the variables that it starts with: w in xyw.
        let mut culprit = self.at;
        while self.at < end {
            let Some((kind, length)) = self.longest_name(end) else {
                // Digits behind a name are a token of their own, which the parser refuses with a hint.
                if self.peek(0).is_some_and(|c| c.is_ascii_digit()) && culprit == self.at {
                    return Ok(());
                }
                return Err(self.unknown_name(culprit, end));
            };
            let is_variable = matches!(kind, TokenKind::Variable(_));
            let was_culprit = culprit == self.at;
            self.push(kind, length);
            if is_variable && was_culprit || self.peek(0).is_some_and(|c| c.is_ascii_digit()) {
                culprit = self.at;
            }
        }
        Ok(())
    }

    fn longest_name(&self, end: usize) -> Option<(TokenKind, usize)> {
        let starts_with = |name: &str| {
            let length = name.chars().count();
            (length <= end - self.at
                && name.chars().eq(self.chars[self.at..self.at + length].iter().copied()))
            .then_some(length)
        };
        let fixed = [
            ("x", TokenKind::Variable(0)),
            ("y", TokenKind::Variable(1)),
            ("z", TokenKind::Variable(2)),
            ("pi", TokenKind::Pi),
            ("π", TokenKind::Pi),
        ];
        let functions = FUNCTIONS.iter().map(|(name, function)| (*name, TokenKind::Function(*function)));
        let constants = self
            .constants
            .names()
            .enumerate()
            .map(|(i, name)| (name, TokenKind::Constant(self.constants.value(i).clone())));
        fixed
            .into_iter()
            .chain(functions)
            .chain(constants)
            .filter_map(|(name, kind)| starts_with(name).map(|length| (kind, length)))
            .max_by_key(|(_, length)| *length)
    }

    fn unknown_name(&self, start: usize, end: usize) -> Problem {
        let name: String = self.chars[start..end].iter().collect();
        let suggestion = self.suggestion(&name);
        Problem::new(FormulaErrorKind::UnknownName { name, suggestion }, self.span(start, end))
    }

    /// A known name that differs little from the unknown one.
    fn suggestion(&self, name: &str) -> Option<String> {
        const LONGEST: usize = 20;
        if name.chars().count() > LONGEST {
            return None;
        }
        let lower = name.to_lowercase();
        let known = FUNCTIONS.iter().map(|(known, _)| *known).chain(["pi"]).chain(self.constants.names());
        if ["x", "y", "z"].contains(&lower.as_str()) {
            return Some(lower);
        }
        // One wrong, missing or additional letter; two in a name of five or more.
        let allowed = if lower.chars().count() >= 5 { 2 } else { 1 };
        known
            .map(|known| (edit_distance(&lower, known), known))
            .filter(|(distance, known)| *distance <= allowed && *distance < known.chars().count())
            .min_by_key(|(distance, _)| *distance)
            .map(|(_, known)| known.to_owned())
    }
}

/// The number of letters to insert, delete or replace to turn one word into the other (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, c) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, d) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(c != *d);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}
