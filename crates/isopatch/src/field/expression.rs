//! A formula as it was typed, with exact constants: what polynomials and diagnostics are made from.

use super::exact::Exact;
use super::token::{Function, Span};
use num_rational::BigRational;
use num_traits::{One, Zero};
use std::collections::HashMap;
use std::fmt;

/// Number of a term in its expression; operands have smaller numbers than their results.
pub(super) type TermId = u32;

/// An operation of two terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operator {
    Add,
    Sub,
    Mul,
    Div,
    /// A real power, not known to be a whole one.
    Pow,
    Min,
    Max,
}

/// A part of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Term {
    /// Number of a constant.
    Constant(u32),
    Pi,
    /// 0, 1, 2 for x, y, z.
    Variable(u8),
    Negate(TermId),
    Call(Function, TermId),
    /// A whole power; the exponent is neither 0 nor 1.
    Power(TermId, i32),
    Binary(Operator, TermId, TermId),
}

/// A formula, flat: equal terms are one, operands stand before what is made of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Expression {
    terms: Vec<Term>,
    spans: Vec<Span>,
    constants: Vec<Exact>,
    numbers: HashMap<Term, TermId>,
    rationals: HashMap<BigRational, TermId>,
}

impl Expression {
    pub(super) fn term(&self, id: TermId) -> Term {
        self.terms[id as usize]
    }

    /// The operator, function or name that made the term, where it first occurs.
    pub(super) fn span(&self, id: TermId) -> Span {
        self.spans[id as usize]
    }

    pub(super) fn constant_of(&self, id: TermId) -> Option<&Exact> {
        match self.term(id) {
            Term::Constant(k) => Some(&self.constants[k as usize]),
            _ => None,
        }
    }

    fn rational(&self, id: TermId) -> Option<&BigRational> {
        self.constant_of(id).and_then(Exact::as_rational)
    }

    pub(super) fn push(&mut self, term: Term, span: Span) -> TermId {
        let next = self.terms.len() as TermId;
        let id = *self.numbers.entry(term).or_insert(next);
        if id == next {
            self.terms.push(term);
            self.spans.push(span);
        }
        id
    }

    pub(super) fn constant(&mut self, value: Exact, span: Span) -> TermId {
        if let Exact::Rational(rational) = &value {
            if let Some(&id) = self.rationals.get(rational) {
                return id;
            }
            self.rationals.insert(rational.clone(), self.terms.len() as TermId);
        }
        self.constants.push(value);
        self.push(Term::Constant(self.constants.len() as u32 - 1), span)
    }

    pub(super) fn negate(&mut self, a: TermId, span: Span) -> TermId {
        match self.constant_of(a).map(Exact::negated) {
            Some(value) => self.constant(value, span),
            None => self.push(Term::Negate(a), span),
        }
    }

    pub(super) fn binary(&mut self, operator: Operator, a: TermId, b: TermId, span: Span) -> TermId {
        if let Some(value) = self.exact_binary(operator, a, b) {
            return self.constant(value, span);
        }
        if operator == Operator::Mul
            && let Some((base, exponent)) = self.common_power(a, b)
        {
            return self.power(base, exponent, span);
        }
        self.push(Term::Binary(operator, a, b), span)
    }

    /// Sums, differences, products, quotients of exact constants, while they are not enormous.
    fn exact_binary(&self, operator: Operator, a: TermId, b: TermId) -> Option<Exact> {
        let (a, b) = (self.rational(a)?, self.rational(b)?);
        Exact::rational(match operator {
            Operator::Add => a + b,
            Operator::Sub => a - b,
            Operator::Mul => a * b,
            Operator::Div if !b.is_zero() => a / b,
            _ => return None,
        })
    }

    /// a·b as a power of one base: x·x, x²·x.
    fn common_power(&self, a: TermId, b: TermId) -> Option<(TermId, i32)> {
        let split = |id| match self.term(id) {
            Term::Power(base, n) if n > 0 => (base, n),
            _ => (id, 1),
        };
        let ((base, m), (other, n)) = (split(a), split(b));
        (base == other).then(|| m.checked_add(n)).flatten().map(|n| (base, n))
    }

    /// base^exponent: a whole power if the exponent is a whole number that fits in 32 bits, else a real power.
    pub(super) fn pow(&mut self, base: TermId, exponent: TermId, span: Span) -> TermId {
        match self.constant_of(exponent).and_then(Exact::as_integer) {
            Some(n) => self.power(base, n, span),
            None => self.push(Term::Binary(Operator::Pow, base, exponent), span),
        }
    }

    fn power(&mut self, base: TermId, exponent: i32, span: Span) -> TermId {
        match exponent {
            0 => return self.constant(Exact::Rational(BigRational::one()), span),
            1 => return base,
            _ => {}
        }
        if let Some(value) = self.exact_power(base, exponent) {
            return self.constant(value, span);
        }
        if let Term::Power(inner, n) = self.term(base)
            && n > 0
            && exponent > 0
            && let Some(product) = n.checked_mul(exponent)
        {
            return self.push(Term::Power(inner, product), span);
        }
        self.push(Term::Power(base, exponent), span)
    }

    fn exact_power(&self, base: TermId, exponent: i32) -> Option<Exact> {
        /// Powers of more bits than this are not worth forming.
        const MAX_POWER_BITS: u64 = 4096;
        let base = self.rational(base)?;
        let bits = base.numer().bits().max(base.denom().bits());
        let too_large = bits.saturating_mul(u64::from(exponent.unsigned_abs())) > MAX_POWER_BITS;
        if too_large || (base.is_zero() && exponent < 0) {
            return None;
        }
        Exact::rational(base.pow(exponent))
    }

    /// For every term up to `root`: is it part of `root`?
    pub(super) fn parts(&self, root: TermId) -> Vec<bool> {
        let mut parts = vec![false; root as usize + 1];
        parts[root as usize] = true;
        for id in (0..=root as usize).rev() {
            if !parts[id] {
                continue;
            }
            for operand in operands(self.terms[id]).into_iter().flatten() {
                parts[operand as usize] = true;
            }
        }
        parts
    }

    /// Writes a term with all its parentheses, in the language that the parser reads.
    pub(super) fn write(&self, root: TermId, out: &mut impl fmt::Write) -> fmt::Result {
        enum Piece {
            Term(TermId),
            Text(&'static str),
            Exponent(i32),
        }
        let mut stack = vec![Piece::Term(root)];
        while let Some(piece) = stack.pop() {
            let id = match piece {
                Piece::Text(text) => {
                    out.write_str(text)?;
                    continue;
                }
                Piece::Exponent(n) => {
                    write!(out, "^({n}))")?;
                    continue;
                }
                Piece::Term(id) => id,
            };
            match self.term(id) {
                Term::Constant(k) => write_constant(&self.constants[k as usize], out)?,
                Term::Pi => out.write_str("pi")?,
                Term::Variable(axis) => out.write_str(["x", "y", "z"][usize::from(axis) % 3])?,
                Term::Negate(a) => stack.extend([Piece::Text(")"), Piece::Term(a), Piece::Text("(-")]),
                Term::Call(function, a) => {
                    out.write_str(function.name())?;
                    stack.extend([Piece::Text(")"), Piece::Term(a), Piece::Text("(")]);
                }
                Term::Power(a, n) => stack.extend([Piece::Exponent(n), Piece::Term(a), Piece::Text("(")]),
                Term::Binary(operator, a, b) => {
                    let (open, middle) = match operator {
                        Operator::Add => ("(", " + "),
                        Operator::Sub => ("(", " - "),
                        Operator::Mul => ("(", "*"),
                        Operator::Div => ("(", "/"),
                        Operator::Pow => ("(", "^"),
                        Operator::Min => ("min(", ", "),
                        Operator::Max => ("max(", ", "),
                    };
                    out.write_str(open)?;
                    stack.extend([Piece::Text(")"), Piece::Term(b), Piece::Text(middle), Piece::Term(a)]);
                }
            }
        }
        Ok(())
    }
}

fn write_constant(value: &Exact, out: &mut impl fmt::Write) -> fmt::Result {
    match value {
        Exact::Rational(r) if r.is_integer() && !value.is_negative() => write!(out, "{r}"),
        Exact::Rational(r) => write!(out, "({r})"),
        Exact::Rounded(v) if *v < 0.0 => write!(out, "({v:e})"),
        Exact::Rounded(v) => write!(out, "{v:e}"),
    }
}

/// The terms that a term is made of.
pub(super) fn operands(term: Term) -> [Option<TermId>; 2] {
    match term {
        Term::Constant(_) | Term::Pi | Term::Variable(_) => [None, None],
        Term::Negate(a) | Term::Call(_, a) | Term::Power(a, _) => [Some(a), None],
        Term::Binary(_, a, b) => [Some(a), Some(b)],
    }
}
