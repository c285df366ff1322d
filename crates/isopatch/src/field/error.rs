//! What can be wrong with the text of a formula.

use super::token::Span;
use std::fmt;

/// Why a text is not a formula, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaError {
    /// What is wrong.
    pub kind: FormulaErrorKind,
    /// Which characters of the text are to blame.
    pub span: Span,
    /// The line of the formula around the culprit, and the position of the culprit in it.
    excerpt: Option<(String, usize)>,
}

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormulaErrorKind {
    /// Nothing but blanks.
    #[error("the formula is empty")]
    Empty,
    /// More characters than [`Formula::MAX_LENGTH`](super::Formula::MAX_LENGTH).
    #[error("the formula has {length} characters; the limit is {limit}")]
    TooLong {
        /// Its length.
        length: usize,
        /// The limit.
        limit: usize,
    },
    /// More open parentheses than [`Formula::MAX_NESTING`](super::Formula::MAX_NESTING).
    #[error("parentheses are nested more than {limit} deep")]
    TooDeep {
        /// The limit.
        limit: usize,
    },
    /// A character that means nothing.
    #[error("unknown symbol {}", of_symbol(*.0))]
    UnknownSymbol(char),
    /// A name that is no variable, function or constant.
    #[error("unknown name \"{name}\"{}", hint(name, suggestion))]
    UnknownName {
        /// The name.
        name: String,
        /// A known name that is similar.
        suggestion: Option<String>,
    },
    /// Not a number, or none that a float can hold.
    #[error("\"{0}\" is not a number, or too large or too small for one")]
    BadNumber(String),
    /// Something stands where a number, a name or a parenthesis should.
    #[error("expected a number, a name or \"(\", found \"{0}\"")]
    ExpectedOperand(String),
    /// The formula stops where a number, a name or a parenthesis should stand.
    #[error("the formula ends where a number, a name or \"(\" should follow")]
    UnexpectedEnd,
    /// A number right after something that is complete.
    #[error("a number can't follow here: write * or ^ before it")]
    NumberAfterOperand,
    /// A function without its arguments.
    #[error("{0} needs its argument in parentheses")]
    FunctionWithoutParenthesis(&'static str),
    /// Too many or too few arguments.
    #[error("{function} takes {expected}, not {found}")]
    ArgumentCount {
        /// The function.
        function: &'static str,
        /// How many it takes.
        expected: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A closing parenthesis without an opening one.
    #[error("\")\" without \"(\"")]
    UnmatchedClose,
    /// An opening parenthesis without a closing one.
    #[error("\"(\" without \")\"")]
    UnmatchedOpen,
    /// A comma that separates no arguments.
    #[error("a comma may only separate the arguments of min and max")]
    MisplacedComma,
    /// An equals sign in parentheses, or a second one.
    #[error("\"=\" may stand only once, outside all parentheses")]
    MisplacedEquals,
}

/// A symbol, and what to write instead of it.
fn of_symbol(symbol: char) -> String {
    let instead = match symbol {
        '<' | '>' | '≤' | '≥' => ": write =, the solid is where the left side is less",
        _ => "",
    };
    format!("{symbol:?}{instead}")
}

fn hint(name: &str, suggestion: &Option<String>) -> String {
    match suggestion {
        Some(known) => format!("; did you mean \"{known}\"?"),
        None => format!("; --set {name}=VALUE makes it a number"),
    }
}

/// An error before the text is attached to it.
#[derive(Debug)]
pub(super) struct Problem {
    kind: FormulaErrorKind,
    span: Span,
}

/// Longest excerpt of a formula in a message, in characters: a line of a terminal.
const EXCERPT: usize = 72;

impl Problem {
    pub(super) fn new(kind: FormulaErrorKind, span: Span) -> Self {
        Self { kind, span }
    }

    /// An equals sign in a parenthesis that is never closed is no fault of the sign.
    pub(super) fn or_unmatched(self, open: Option<Span>) -> Self {
        match (&self.kind, open) {
            (FormulaErrorKind::MisplacedEquals, Some(open)) if open.column < self.span.column => {
                Self::new(FormulaErrorKind::UnmatchedOpen, open)
            }
            _ => self,
        }
    }

    pub(super) fn in_text(self, text: &str) -> FormulaError {
        let excerpt = (!text.trim().is_empty()).then(|| excerpt(text, self.span.column - 1));
        FormulaError { kind: self.kind, span: self.span, excerpt }
    }
}

/// A window of the text around the character `at`, on one line, and the place of that character in it.
fn excerpt(text: &str, at: usize) -> (String, usize) {
    let length = text.chars().count();
    let start = if length <= EXCERPT { 0 } else { at.saturating_sub(EXCERPT / 2).min(length - EXCERPT) };
    let mut line = String::new();
    let mut position = at - start;
    if start > 0 {
        line.push('…');
        position += 1;
    }
    line.extend(text.chars().skip(start).take(EXCERPT).map(|c| if c.is_control() { ' ' } else { c }));
    if start + EXCERPT < length {
        line.push('…');
    }
    (line, position)
}

impl FormulaError {
    /// The first character to blame, counted from 1.
    pub fn column(&self) -> usize {
        self.span.column
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "column {}: {}", self.span.column, self.kind)?;
        if let Some((line, position)) = &self.excerpt {
            let shown = line.chars().count().saturating_sub(*position).max(1);
            let carets = "^".repeat(self.span.length.clamp(1, shown));
            write!(out, "\n  {line}\n  {:position$}{carets}", "")?;
        }
        Ok(())
    }
}

impl std::error::Error for FormulaError {}
