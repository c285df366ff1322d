//! Polynomials in x, y, z with exact rational coefficients.

use super::exact::Exact;
use super::expression::{Expression, Operator, Term, TermId};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};
use std::collections::BTreeMap;

/// The exponents of x, y and z.
pub type Exponents = [u32; 3];

/// A polynomial in x, y, z with exact rational coefficients; decimals in a formula are exact too: 0.64 is 16/25.
///
/// A formula is expanded only within [`MAX_DEGREE`](Self::MAX_DEGREE), [`MAX_TERMS`](Self::MAX_TERMS),
/// [`MAX_BITS`](Self::MAX_BITS) and [`MAX_PRODUCTS`](Self::MAX_PRODUCTS).
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// Coefficients that are not zero, by exponents.
    terms: BTreeMap<Exponents, BigRational>,
}

/// Products of coefficients that may still be formed.
pub(super) struct Budget(usize);

impl Default for Budget {
    fn default() -> Self {
        Self(Polynomial::MAX_PRODUCTS)
    }
}

impl Polynomial {
    /// Highest total degree.
    pub const MAX_DEGREE: u32 = 100;
    /// Most terms, in the result and in every part of the formula.
    pub const MAX_TERMS: usize = 5_000;
    /// Most bits of a numerator or denominator.
    pub const MAX_BITS: u64 = 2_400;
    /// Most products of two coefficients on the way, which bounds the time to a fraction of a second.
    pub const MAX_PRODUCTS: usize = 300_000;

    /// The expanded term of an expression.
    pub(super) fn of(expression: &Expression, root: TermId) -> Option<Self> {
        let parts = expression.parts(root);
        let mut known: Vec<Option<Self>> = vec![None; parts.len()];
        let mut budget = Budget::default();
        for id in (0..parts.len()).filter(|&id| parts[id]) {
            let of = |operand: TermId| known[operand as usize].as_ref();
            let expanded = match expression.term(id as TermId) {
                Term::Constant(_) => {
                    Self::constant(expression.constant_of(id as TermId).and_then(Exact::as_rational)?.clone())
                }
                Term::Variable(axis) => Self::variable(usize::from(axis)),
                Term::Negate(a) => of(a)?.scaled(&-BigRational::one(), &mut budget)?,
                Term::Power(a, n) => of(a)?.power(u32::try_from(n).ok()?, &mut budget)?,
                Term::Binary(operator, a, b) => {
                    let (a, b) = (of(a)?, of(b)?);
                    match operator {
                        Operator::Add => a.plus(b, &mut budget)?,
                        Operator::Sub => {
                            a.plus(&b.scaled(&-BigRational::one(), &mut budget)?, &mut budget)?
                        }
                        Operator::Mul => a.times(b, &mut budget)?,
                        Operator::Div => a.scaled(&b.as_constant()?.recip(), &mut budget)?,
                        Operator::Pow | Operator::Min | Operator::Max => return None,
                    }
                }
                Term::Pi | Term::Call(..) => return None,
            };
            known[id] = Some(expanded);
        }
        known.pop().flatten()
    }

    pub(super) fn constant(value: BigRational) -> Self {
        let terms = if value.is_zero() { BTreeMap::new() } else { BTreeMap::from([([0; 3], value)]) };
        Self { terms }
    }

    pub(super) fn variable(axis: usize) -> Self {
        let mut exponents = [0; 3];
        exponents[axis] = 1;
        Self { terms: BTreeMap::from([(exponents, BigRational::one())]) }
    }

    /// The number that this polynomial is, if it is one and not zero.
    fn as_constant(&self) -> Option<&BigRational> {
        self.terms.get(&[0; 3]).filter(|_| self.terms.len() == 1)
    }

    /// The polynomial of the given terms, if it is within the limits.
    fn checked(terms: BTreeMap<Exponents, BigRational>) -> Option<Self> {
        let small = |c: &BigRational| c.numer().bits().max(c.denom().bits()) <= Self::MAX_BITS;
        let fits = terms.len() <= Self::MAX_TERMS
            && terms.iter().all(|(e, c)| small(c) && e.iter().sum::<u32>() <= Self::MAX_DEGREE);
        fits.then_some(Self { terms })
    }

    pub(super) fn plus(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        budget.spend(self.terms.len() + other.terms.len())?;
        let mut terms = self.terms.clone();
        other.terms.iter().for_each(|(e, c)| accumulate(&mut terms, *e, c.clone()));
        Self::checked(terms)
    }

    pub(super) fn scaled(&self, factor: &BigRational, budget: &mut Budget) -> Option<Self> {
        budget.spend(self.terms.len())?;
        Self::checked(self.terms.iter().map(|(e, c)| (*e, c * factor)).collect())
    }

    pub(super) fn times(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        if self.degree().saturating_add(other.degree()) > Self::MAX_DEGREE {
            return None;
        }
        budget.spend(self.terms.len().saturating_mul(other.terms.len()))?;
        let mut terms = BTreeMap::new();
        for (e, c) in &self.terms {
            for (f, d) in &other.terms {
                accumulate(&mut terms, [e[0] + f[0], e[1] + f[1], e[2] + f[2]], c * d);
            }
        }
        Self::checked(terms)
    }

    pub(super) fn power(&self, exponent: u32, budget: &mut Budget) -> Option<Self> {
        if self.degree().saturating_mul(exponent) > Self::MAX_DEGREE {
            return None;
        }
        if self.is_zero() {
            return Some(self.clone());
        }
        if let Some(constant) = self.as_constant() {
            let bits = constant.numer().bits().max(constant.denom().bits());
            let exponent = i32::try_from(exponent).ok()?;
            let fits = (bits - 1).saturating_mul(u64::from(exponent.unsigned_abs())) <= 2 * Self::MAX_BITS;
            return fits
                .then(|| constant.pow(exponent))
                .and_then(|power| Self::checked(Self::constant(power).terms));
        }
        (0..exponent).try_fold(Self::constant(BigRational::one()), |power, _| power.times(self, budget))
    }

    /// The polynomial of the given terms; those with equal exponents are added.
    pub fn from_terms(terms: impl IntoIterator<Item = (Exponents, BigRational)>) -> Self {
        let mut sum = BTreeMap::new();
        for (exponents, coefficient) in terms {
            if !coefficient.is_zero() {
                accumulate(&mut sum, exponents, coefficient);
            }
        }
        Self { terms: sum }
    }

    /// Total degree; 0 for the zero polynomial.
    pub fn degree(&self) -> u32 {
        self.terms.keys().map(|e| e.iter().sum()).max().unwrap_or(0)
    }

    /// Exponents and coefficients of the terms that are not zero, in lexicographic order of the exponents.
    pub fn terms(&self) -> impl ExactSizeIterator<Item = (Exponents, &BigRational)> {
        self.terms.iter().map(|(e, c)| (*e, c))
    }

    /// The coefficient of x^i y^j z^k.
    pub fn coefficient(&self, exponents: Exponents) -> BigRational {
        self.terms.get(&exponents).cloned().unwrap_or_else(BigRational::zero)
    }

    /// Is it zero everywhere?
    pub fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// The exact value at a point.
    pub fn value(&self, point: &[BigRational; 3]) -> BigRational {
        // Over one denominator per coordinate only whole numbers are multiplied, and nothing is reduced on the way.
        let highest = [0, 1, 2].map(|axis| self.terms.keys().map(|e| e[axis]).max().unwrap_or(0));
        let powers: [Vec<BigInt>; 3] = [0, 1, 2].map(|axis| {
            let (n, d) = (point[axis].numer(), point[axis].denom());
            (0..=highest[axis]).map(|k| n.pow(k) * d.pow(highest[axis] - k)).collect()
        });
        let sum = self.terms.iter().fold(BigRational::zero(), |sum, (e, c)| {
            let product: BigInt = (0..3).map(|axis| &powers[axis][e[axis] as usize]).product();
            sum + c * product
        });
        let denominator: BigInt = (0..3).map(|axis| point[axis].denom().pow(highest[axis])).product();
        sum / denominator
    }

    /// The partial derivative by coordinate `axis` (0, 1, 2).
    pub fn derivative(&self, axis: usize) -> Self {
        let lowered = self.terms.iter().filter(|(e, _)| e[axis] > 0).map(|(e, c)| {
            let mut exponents = *e;
            exponents[axis] -= 1;
            (exponents, c * BigRational::from(BigInt::from(e[axis])))
        });
        Self { terms: lowered.collect() }
    }

    /// The coefficients as the nearest floats, in the order of [`terms`](Self::terms).
    pub fn float_terms(&self) -> Vec<(Exponents, f64)> {
        self.terms().map(|(e, c)| (e, c.to_f64().unwrap_or(f64::NAN))).collect()
    }
}

impl Budget {
    /// Takes from the budget; none when it is used up.
    fn spend(&mut self, products: usize) -> Option<()> {
        self.0 = self.0.checked_sub(products)?;
        Some(())
    }
}

fn accumulate(terms: &mut BTreeMap<Exponents, BigRational>, exponents: Exponents, coefficient: BigRational) {
    use std::collections::btree_map::Entry;
    match terms.entry(exponents) {
        Entry::Vacant(vacant) => {
            vacant.insert(coefficient);
        }
        Entry::Occupied(mut occupied) => {
            *occupied.get_mut() += coefficient;
            if occupied.get().is_zero() {
                occupied.remove();
            }
        }
    }
}
