//! Polynomials without repeated factors: where a factor occurs twice, all of its zeros would be singular.

use super::SingularError;
use crate::field::{Exponents, Polynomial, QuadraticPolynomial};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

/// f with every factor once, up to a constant: f over its greatest common divisor with its derivatives.
pub(super) fn square_free(f: &QuadraticPolynomial) -> Result<QuadraticPolynomial, SingularError> {
    if is_square_free(f) {
        return Ok(f.clone());
    }
    if f.radicand != 1 {
        return Err(SingularError::Repeated);
    }
    let mut common = f.rational.clone();
    for axis in 0..3 {
        common = gcd(&common, &f.rational.derivative(axis)).ok_or(SingularError::Repeated)?;
    }
    let reduced = divide(&f.rational, &common).ok_or(SingularError::Repeated)?;
    Ok(QuadraticPolynomial::plain(reduced))
}

/// Lines on which f is looked at.
const LINES: [[[i32; 3]; 2]; 3] =
    [[[3, -7, 5], [11, 2, -13]], [[-5, 17, 4], [7, 19, 3]], [[23, 1, -9], [-2, 8, 29]]];

/// Has f no repeated factor? If f on a line keeps its degree and has no repeated root, then certainly. That is asked
/// modulo a prime, in which √d is a number; a no may be wrong, with a tiny chance on all lines.
fn is_square_free(f: &QuadraticPolynomial) -> bool {
    LINES.iter().any(|[from, along]| {
        PRIMES.iter().any(|p| restricted(f, from, along, *p).is_some_and(|u| u.is_square_free()))
    })
}

/// A polynomial of one variable modulo a prime, from the constant up.
struct Residues {
    values: Vec<u64>,
    prime: u64,
}

/// Primes below 2³¹, for products in 64 bits, that are 3 modulo 4: square roots are powers then. √d is a number modulo
/// every second one.
const PRIMES: [u64; 5] = [2_147_483_647, 2_147_483_587, 2_147_483_579, 2_147_483_563, 2_147_483_543];

impl Residues {
    fn trimmed(mut values: Vec<u64>, prime: u64) -> Self {
        while values.last() == Some(&0) {
            values.pop();
        }
        Self { values, prime }
    }

    /// gcd(u, u') = 1.
    fn is_square_free(&self) -> bool {
        let derivative = self.values.iter().enumerate().skip(1).map(|(k, c)| c * k as u64 % self.prime).collect();
        let mut a = Self { values: self.values.clone(), prime: self.prime };
        let mut b = Self::trimmed(derivative, self.prime);
        while !b.values.is_empty() {
            let rest = a.remainder(&b);
            a = std::mem::replace(&mut b, rest);
        }
        a.values.len() == 1
    }

    fn remainder(&self, divisor: &Self) -> Self {
        let prime = self.prime;
        let mut rest = self.values.clone();
        let inverse = divisor.values.last().map_or(0, |leading| power(*leading, prime - 2, prime));
        while rest.len() >= divisor.values.len() {
            let factor = rest.last().copied().unwrap_or(0) * inverse % prime;
            let offset = rest.len() - divisor.values.len();
            for (i, c) in divisor.values.iter().enumerate() {
                rest[offset + i] = (rest[offset + i] + (prime - factor) * c) % prime;
            }
            rest.pop();
        }
        Self::trimmed(rest, prime)
    }
}

fn power(base: u64, exponent: u64, prime: u64) -> u64 {
    let digits = u64::BITS - exponent.leading_zeros();
    (0..digits).rev().fold(1, |p, i| {
        let square = p * p % prime;
        if exponent >> i & 1 == 1 { square * base % prime } else { square }
    })
}

/// f on the line `from` + t `along`; none if the prime divides a denominator, √d is no number modulo it, or the degree
/// falls.
fn restricted(f: &QuadraticPolynomial, from: &[i32; 3], along: &[i32; 3], prime: u64) -> Option<Residues> {
    let residue = |n: &BigInt| -> u64 {
        let prime = BigInt::from(prime);
        u64::try_from(((n % &prime) + &prime) % &prime).unwrap_or(0)
    };
    // p = 3 mod 4: a root of d is d^((p+1)/4), if there is one.
    let root = power(f.radicand % prime, prime.div_ceil(4), prime);
    if root * root % prime != f.radicand % prime {
        return None;
    }
    let degree = f.degree() as usize;
    let mut sum = vec![0; degree + 1];
    for (part, factor) in [(&f.rational, 1), (&f.irrational, root)] {
        for (e, c) in part.terms() {
            let denominator = residue(c.denom());
            if denominator == 0 {
                return None;
            }
            let c = residue(c.numer()) * power(denominator, prime - 2, prime) % prime * factor % prime;
            let mut term = vec![c];
            for a in 0..3 {
                let number = |n: i32| residue(&BigInt::from(n));
                for _ in 0..e[a] {
                    let mut next = vec![0; term.len() + 1];
                    for (k, t) in term.iter().enumerate() {
                        next[k] = (next[k] + t * number(from[a])) % prime;
                        next[k + 1] = (next[k + 1] + t * number(along[a])) % prime;
                    }
                    term = next;
                }
            }
            sum.iter_mut().zip(term).for_each(|(s, t)| *s = (*s + t) % prime);
        }
    }
    let sum = Residues::trimmed(sum, prime);
    (sum.values.len() == degree + 1).then_some(sum)
}

/// Most terms of a polynomial on the way to a common divisor.
const MOST_TERMS: usize = 4_000;

/// A greatest common divisor over the rationals, up to a constant: Euclid's algorithm in one variable, with coefficients
/// in the others, whose common content is divided out at each step.
pub(super) fn gcd(a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
    if a.is_zero() {
        return Some(b.clone());
    }
    if b.is_zero() {
        return Some(a.clone());
    }
    let Some(axis) = (0..3).rev().find(|&axis| degree_in(a, axis) > 0 || degree_in(b, axis) > 0) else {
        return Some(constant());
    };
    let (content_a, content_b) = (content(a, axis)?, content(b, axis)?);
    let content_both = gcd(&content_a, &content_b)?;
    let (mut p, mut q) = (divide(a, &content_a)?, divide(b, &content_b)?);
    if degree_in(&p, axis) < degree_in(&q, axis) {
        std::mem::swap(&mut p, &mut q);
    }
    while !q.is_zero() {
        if degree_in(&q, axis) == 0 {
            // No common divisor but contents.
            return Some(content_both);
        }
        let rest = pseudo_remainder(&p, &q, axis)?;
        let rest = if rest.is_zero() { rest } else { normalized(&divide(&rest, &content(&rest, axis)?)?) };
        p = std::mem::replace(&mut q, rest);
    }
    Some(normalized(&product(&content_both, &p)))
}

fn constant() -> Polynomial {
    Polynomial::from_terms([([0; 3], BigRational::one())])
}

fn degree_in(p: &Polynomial, axis: usize) -> u32 {
    p.terms().map(|(e, _)| e[axis]).max().unwrap_or(0)
}

/// The coefficient of x_axis^k, a polynomial in the others.
fn coefficient_in(p: &Polynomial, axis: usize, k: u32) -> Polynomial {
    Polynomial::from_terms(p.terms().filter(|(e, _)| e[axis] == k).map(|(mut e, c)| {
        e[axis] = 0;
        (e, c.clone())
    }))
}

/// The common divisor of all coefficients.
fn content(p: &Polynomial, axis: usize) -> Option<Polynomial> {
    (0..=degree_in(p, axis))
        .map(|k| coefficient_in(p, axis, k))
        .filter(|c| !c.is_zero())
        .try_fold(Polynomial::from_terms([]), |common, c| gcd(&common, &c))
}

/// Divided by the leading coefficient, so that numbers stay small.
fn normalized(p: &Polynomial) -> Polynomial {
    match p.terms().last() {
        Some((_, leading)) => {
            let inverse = leading.recip();
            Polynomial::from_terms(p.terms().map(|(e, c)| (e, c * &inverse)))
        }
        None => p.clone(),
    }
}

fn product(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let add = |e: Exponents, f: Exponents| [e[0] + f[0], e[1] + f[1], e[2] + f[2]];
    Polynomial::from_terms(a.terms().flat_map(|(e, c)| b.terms().map(move |(f, d)| (add(e, f), c * d))))
}

fn minus(a: &Polynomial, b: &Polynomial) -> Polynomial {
    Polynomial::from_terms(a.terms().map(|(e, c)| (e, c.clone())).chain(b.terms().map(|(e, c)| (e, -c.clone()))))
}

fn power_of(axis: usize, k: u32) -> Polynomial {
    let mut e = [0; 3];
    e[axis] = k;
    Polynomial::from_terms([(e, BigRational::one())])
}

/// A remainder of a multiple of p divided by q, as polynomials in one variable.
fn pseudo_remainder(p: &Polynomial, q: &Polynomial, axis: usize) -> Option<Polynomial> {
    let n = degree_in(q, axis);
    let leading = coefficient_in(q, axis, n);
    let mut rest = p.clone();
    while !rest.is_zero() && degree_in(&rest, axis) >= n {
        let m = degree_in(&rest, axis);
        let top = coefficient_in(&rest, axis, m);
        let subtrahend = product(&product(&top, &power_of(axis, m - n)), q);
        rest = minus(&product(&leading, &rest), &subtrahend);
        if rest.terms().len() > MOST_TERMS {
            return None;
        }
    }
    Some(rest)
}

/// a / b where b divides a; else none.
pub(super) fn divide(a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
    let (leading, inverse) = b.terms().last().map(|(e, c)| (e, c.recip()))?;
    let (mut rest, mut quotient) = (a.clone(), Vec::new());
    while let Some((e, c)) = rest.terms().last().map(|(e, c)| (e, c.clone())) {
        if (0..3).any(|a| e[a] < leading[a]) {
            return None;
        }
        let term = ([e[0] - leading[0], e[1] - leading[1], e[2] - leading[2]], c * &inverse);
        rest = minus(&rest, &product(&Polynomial::from_terms([term.clone()]), b));
        quotient.push(term);
    }
    Some(Polynomial::from_terms(quotient)).filter(|q| !q.is_zero() || a.is_zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};

    fn parsed(text: &str) -> QuadraticPolynomial {
        Formula::parse(text, &Constants::new()).unwrap().quadratic_polynomial().unwrap()
    }

    #[test]
    fn repeated_factors_are_divided_out() {
        for (text, expected) in [
            ("(x^2+y^2+z^2-1)^2", "x^2+y^2+z^2-1"),
            ("(x-y)^3 (x^2+y z+1)^2 (z-2)", "(x-y)(x^2+y z+1)(z-2)"),
            ("z^2 (x+1)^2 y", "z (x+1) y"),
            ("x^2-y z^2", "x^2-y z^2"),
        ] {
            let reduced = square_free(&parsed(text)).unwrap().rational;
            assert_eq!(normalized(&reduced), normalized(&parsed(expected).rational), "{text}");
        }
    }

    #[test]
    fn repeated_factors_beside_a_root_are_refused() {
        assert_eq!(square_free(&parsed("(x - sqrt(2) y)^2 z")), Err(SingularError::Repeated));
        assert!(square_free(&parsed("(x - sqrt(2) y)(x + sqrt(2) y) z")).is_ok());
    }

    #[test]
    fn zero_and_constants_have_divisors() {
        assert!(BigRational::zero().is_zero());
        assert_eq!(gcd(&parsed("x y").rational, &parsed("x z").rational).map(|g| normalized(&g)), Some(parsed("x").rational));
    }
}
