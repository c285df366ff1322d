//! Polynomials whose coefficients hold one square root, such as that of 5 in the surfaces of Barth.

use super::exact::Exact;
use super::expression::{Expression, Operator, Term, TermId};
use super::polynomial::{Budget, Polynomial};
use super::token::Function;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// P + Q √d, with exact rational P and Q and a whole number d > 1 without square factors below 1000²; d = 1 and Q = 0
/// where there is no root.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticPolynomial {
    /// P.
    pub rational: Polynomial,
    /// Q.
    pub irrational: Polynomial,
    /// d.
    pub radicand: u64,
}

/// Square factors of a radicand are looked for up to the square of this number.
const LARGEST_FACTOR: u64 = 1000;

impl QuadraticPolynomial {
    /// The expanded term of an expression; none if it has another function than the square root of a number, or square
    /// roots that do not belong to one field Q(√d), or is beyond the limits of [`Polynomial`].
    pub(super) fn of(expression: &Expression, root: TermId) -> Option<Self> {
        let parts = expression.parts(root);
        let mut known: Vec<Option<Self>> = vec![None; parts.len()];
        let budget = &mut Budget::default();
        for id in (0..parts.len()).filter(|&id| parts[id]) {
            let of = |operand: TermId| known[operand as usize].as_ref();
            let expanded = match expression.term(id as TermId) {
                Term::Constant(_) => Self::plain(Polynomial::constant(
                    expression.constant_of(id as TermId).and_then(Exact::as_rational)?.clone(),
                )),
                Term::Variable(axis) => Self::plain(Polynomial::variable(usize::from(axis))),
                Term::Negate(a) => of(a)?.scaled(&-BigRational::one(), budget)?,
                Term::Power(a, n) => of(a)?.power(n, budget)?,
                Term::Call(Function::Sqrt, a) => of(a)?.root()?,
                Term::Binary(Operator::Add, a, b) => of(a)?.plus(of(b)?, budget)?,
                Term::Binary(Operator::Sub, a, b) => {
                    of(a)?.plus(&of(b)?.scaled(&-BigRational::one(), budget)?, budget)?
                }
                Term::Binary(Operator::Mul, a, b) => of(a)?.times(of(b)?, budget)?,
                Term::Binary(Operator::Div, a, b) => of(a)?.times(&of(b)?.reciprocal(budget)?, budget)?,
                Term::Binary(Operator::Pow | Operator::Min | Operator::Max, ..)
                | Term::Pi
                | Term::Call(..) => return None,
            };
            known[id] = Some(expanded);
        }
        known.pop().flatten()
    }

    /// A polynomial without a root.
    pub fn plain(rational: Polynomial) -> Self {
        Self { rational, irrational: Polynomial::constant(BigRational::zero()), radicand: 1 }
    }

    /// Total degree.
    pub fn degree(&self) -> u32 {
        self.rational.degree().max(self.irrational.degree())
    }

    /// The field of both: d.
    fn common_radicand(&self, other: &Self) -> Option<u64> {
        match (self.radicand, other.radicand) {
            (a, 1) => Some(a),
            (1, b) => Some(b),
            (a, b) => (a == b).then_some(a),
        }
    }

    fn made(rational: Polynomial, irrational: Polynomial, radicand: u64) -> Self {
        let radicand = if irrational.is_zero() { 1 } else { radicand };
        Self { rational, irrational, radicand }
    }

    fn plus(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        let radicand = self.common_radicand(other)?;
        Some(Self::made(
            self.rational.plus(&other.rational, budget)?,
            self.irrational.plus(&other.irrational, budget)?,
            radicand,
        ))
    }

    fn scaled(&self, factor: &BigRational, budget: &mut Budget) -> Option<Self> {
        Some(Self::made(
            self.rational.scaled(factor, budget)?,
            self.irrational.scaled(factor, budget)?,
            self.radicand,
        ))
    }

    /// (P + Q√d)(R + S√d) = PR + d QS + (PS + QR)√d.
    fn times(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        let radicand = self.common_radicand(other)?;
        let both = self.irrational.times(&other.irrational, budget)?;
        let both = both.scaled(&BigRational::from(BigInt::from(radicand)), budget)?;
        let rational = self.rational.times(&other.rational, budget)?.plus(&both, budget)?;
        let left = self.rational.times(&other.irrational, budget)?;
        let right = self.irrational.times(&other.rational, budget)?;
        Some(Self::made(rational, left.plus(&right, budget)?, radicand))
    }

    fn power(&self, exponent: i32, budget: &mut Budget) -> Option<Self> {
        let base = if exponent < 0 { self.reciprocal(budget)? } else { self.clone() };
        let exponent = exponent.unsigned_abs();
        if self.irrational.is_zero() {
            return Some(Self::plain(base.rational.power(exponent, budget)?));
        }
        (0..exponent)
            .try_fold(Self::plain(Polynomial::constant(BigRational::one())), |p, _| p.times(&base, budget))
    }

    /// The two numbers that a polynomial without x, y, z is made of.
    fn as_constant(&self) -> Option<(BigRational, BigRational)> {
        (self.degree() == 0)
            .then(|| (self.rational.coefficient([0; 3]), self.irrational.coefficient([0; 3])))
    }

    /// 1/(p + q√d) = (p − q√d)/(p² − d q²).
    fn reciprocal(&self, budget: &mut Budget) -> Option<Self> {
        let (p, q) = self.as_constant()?;
        let norm = &p * &p - &q * &q * BigRational::from(BigInt::from(self.radicand));
        if norm.is_zero() {
            return None;
        }
        let conjugate = Self::made(
            Polynomial::constant(p),
            Polynomial::constant(-q),
            self.radicand,
        );
        conjugate.scaled(&norm.recip(), budget)
    }

    /// The square root of a rational number: √(p/q) = √(pq)/q, with the squares drawn out.
    fn root(&self) -> Option<Self> {
        let (p, q) = self.as_constant()?;
        if !q.is_zero() || p.is_negative() {
            return None;
        }
        let mut rest = p.numer() * p.denom();
        let mut outside = BigInt::one();
        for k in 2..=LARGEST_FACTOR {
            let square = BigInt::from(k * k);
            while !rest.is_zero() && (&rest % &square).is_zero() {
                rest /= &square;
                outside *= k;
            }
        }
        // A large square that is left over.
        let whole = rest.sqrt();
        if &whole * &whole == rest {
            (outside, rest) = (outside * whole, BigInt::one());
        }
        let factor = Polynomial::constant(BigRational::new(outside, p.denom().clone()));
        let none = Polynomial::constant(BigRational::zero());
        match rest.to_u64()? {
            1 => Some(Self::plain(factor)),
            radicand => Some(Self::made(none, factor, radicand)),
        }
    }
}
