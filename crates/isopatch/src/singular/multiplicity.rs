//! How many times a point counts as a root of the ideal (f, ∇f): the dimension of its local algebra.

use crate::field::Polynomial;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use std::collections::HashMap;

/// Arithmetic is modulo this prime, 2⁶¹ − 1. A rank can only fall by that, with a chance of the order of 2⁻⁶⁰ a pivot for
/// coefficients that are not made for it.
const PRIME: u64 = (1 << 61) - 1;

/// Beyond this order of truncation the search ends: points of this multiplicity or more are left unknown.
const HIGHEST_ORDER: usize = 14;

/// dim Q[x]_p/(f, ∇f) at a rational point: the Tjurina number, 1 for a node, k for A_k, D_k and E_k. None if it is
/// infinite, as on a singular curve, or above a limit.
///
/// The dimension of Q[x]/(I + m^(k+1)) is the number of monomials up to degree k less the rank of the multiples of the
/// generators, truncated at degree k. When it stays the same from one k to the next, it stays for good (Nakayama).
pub(super) fn multiplicity(f: &Polynomial, p: &[BigRational; 3]) -> Option<usize> {
    let generators: Vec<Vec<([usize; 3], u64)>> =
        std::iter::once(f.clone()).chain((0..3).map(|a| f.derivative(a))).map(|g| moved(&g, p)).collect::<Option<_>>()?;
    let mut last = 0;
    for order in 0..=HIGHEST_ORDER {
        let monomials = monomials(order);
        let column: HashMap<[usize; 3], usize> = monomials.iter().enumerate().map(|(i, e)| (*e, i)).collect();
        let mut rows = Vec::new();
        for shift in &monomials {
            for generator in &generators {
                let mut row = vec![0; monomials.len()];
                for (e, c) in generator {
                    if let Some(&i) = column.get(&[e[0] + shift[0], e[1] + shift[1], e[2] + shift[2]]) {
                        row[i] = *c;
                    }
                }
                rows.push(row);
            }
        }
        let dimension = monomials.len() - rank(rows);
        if order > 0 && dimension == last {
            return Some(dimension);
        }
        last = dimension;
    }
    None
}

/// Exponents up to a total degree.
fn monomials(degree: usize) -> Vec<[usize; 3]> {
    (0..=degree)
        .flat_map(|d| (0..=d).flat_map(move |i| (0..=d - i).map(move |j| [i, j, d - i - j])))
        .collect()
}

/// The terms of g(p + x) modulo the prime; none if a denominator is a multiple of it.
fn moved(g: &Polynomial, p: &[BigRational; 3]) -> Option<Vec<([usize; 3], u64)>> {
    let p = [residue(&p[0])?, residue(&p[1])?, residue(&p[2])?];
    let mut sum: HashMap<[usize; 3], u64> = HashMap::new();
    for (e, c) in g.terms() {
        let c = residue(c)?;
        let e = e.map(|n| n as usize);
        for i in 0..=e[0] {
            for j in 0..=e[1] {
                for k in 0..=e[2] {
                    let target = [i, j, k];
                    let factor = (0..3).fold(c, |product, a| {
                        let binomial = num_integer::binomial(e[a] as u128, target[a] as u128) % u128::from(PRIME);
                        times(times(product, binomial as u64), power(p[a], (e[a] - target[a]) as u64))
                    });
                    let entry = sum.entry(target).or_insert(0);
                    *entry = (*entry + factor) % PRIME;
                }
            }
        }
    }
    let mut terms: Vec<_> = sum.into_iter().filter(|(_, c)| *c != 0).collect();
    terms.sort_unstable();
    Some(terms)
}

fn residue(q: &BigRational) -> Option<u64> {
    let prime = BigInt::from(PRIME);
    let reduce = |n: &BigInt| (((n % &prime) + &prime) % &prime).to_u64();
    let denominator = reduce(q.denom())?;
    (!denominator.is_zero()).then(|| reduce(q.numer()).map(|n| times(n, power(denominator, PRIME - 2)))).flatten()
}

fn times(a: u64, b: u64) -> u64 {
    // The remainder is below 2^61.
    (u128::from(a) * u128::from(b) % u128::from(PRIME)) as u64
}

fn power(base: u64, exponent: u64) -> u64 {
    let digits = u64::BITS - exponent.leading_zeros();
    (0..digits).rev().fold(1, |p, i| {
        let square = times(p, p);
        if exponent >> i & 1 == 1 { times(square, base) } else { square }
    })
}

/// The rank of a matrix modulo the prime, by elimination.
fn rank(rows: Vec<Vec<u64>>) -> usize {
    let mut pivots: Vec<(usize, Vec<u64>)> = Vec::new();
    for mut row in rows {
        for (column, pivot) in &pivots {
            let factor = row[*column];
            if factor != 0 {
                row.iter_mut().zip(pivot).for_each(|(a, b)| *a = (*a + PRIME - times(factor, *b)) % PRIME);
            }
        }
        if let Some(column) = row.iter().position(|c| *c != 0) {
            let inverse = power(row[column], PRIME - 2);
            row.iter_mut().for_each(|c| *c = times(*c, inverse));
            pivots.push((column, row));
        }
    }
    pivots.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};

    #[test]
    fn simple_singularities_have_their_numbers() {
        let cases = [
            ("x^2+y^2-z^2", 1),
            ("x^2+y^2-z^3", 2),
            ("x^2+y^2-z^4", 3),
            ("x^3-3x y^2+z^2", 4),
            ("x^2+y^3+z^4", 6),
            ("x^2+y^3+y z^3", 7),
            ("x^2+y^3+z^5", 8),
            ("x^2+y^2-z^3+5z^4 x-y^7", 2),
        ];
        let origin = [0, 0, 0].map(|n: i32| BigRational::from(BigInt::from(n)));
        for (text, expected) in cases {
            let formula = Formula::parse(text, &Constants::new()).unwrap();
            assert_eq!(multiplicity(formula.polynomial().unwrap(), &origin), Some(expected), "{text}");
        }
        let lemon = Formula::parse("x^2+z^2-y^3(1-y)^3", &Constants::new()).unwrap();
        let tip = [0, 1, 0].map(|n: i32| BigRational::from(BigInt::from(n)));
        assert_eq!(multiplicity(lemon.polynomial().unwrap(), &tip), Some(2));
        let umbrella = Formula::parse("x^2-y z^2", &Constants::new()).unwrap();
        assert_eq!(multiplicity(umbrella.polynomial().unwrap(), &origin), None);
    }
}
