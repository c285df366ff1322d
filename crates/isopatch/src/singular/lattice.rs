//! Short vectors of integer lattices, and relations between numbers.

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, Signed, Zero};

/// Reduces a basis of an integer lattice, in whole numbers throughout: the algorithm of Lenstra, Lenstra & Lovász in the
/// form of de Weger (Cohen, A Course in Computational Algebraic Number Theory, 2.6.7). The rows are linearly independent.
pub(super) fn reduce(basis: &mut [Vec<BigInt>]) {
    let n = basis.len();
    // d[i + 1] = product of the squared lengths of the first i + 1 orthogonal vectors, λ[i][j] = d[j + 1] μ[i][j].
    let mut d = vec![BigInt::one(); n + 1];
    let mut lambda = vec![vec![BigInt::zero(); n]; n];
    let mut known = 0;
    let mut k = 0;
    while k < n {
        if k == known {
            for j in 0..=k {
                let mut u: BigInt = basis[k].iter().zip(&basis[j]).map(|(a, b)| a * b).sum();
                for i in 0..j {
                    u = (&d[i + 1] * u - &lambda[k][i] * &lambda[j][i]) / &d[i];
                }
                if j < k {
                    lambda[k][j] = u;
                } else {
                    d[k + 1] = u;
                }
            }
            known = k + 1;
        }
        if k == 0 {
            k = 1;
            continue;
        }
        shorten(basis, &d, &mut lambda, k, k - 1);
        // Lovász' condition with 3/4.
        let left = 4 * (&d[k + 1] * &d[k - 1] + &lambda[k][k - 1] * &lambda[k][k - 1]);
        if left < 3 * &d[k] * &d[k] {
            swap(basis, &mut d, &mut lambda, k, known);
            k = (k - 1).max(1);
        } else {
            for l in (0..k - 1).rev() {
                shorten(basis, &d, &mut lambda, k, l);
            }
            k += 1;
        }
    }
}

fn shorten(basis: &mut [Vec<BigInt>], d: &[BigInt], lambda: &mut [Vec<BigInt>], k: usize, l: usize) {
    if 2 * lambda[k][l].abs() <= d[l + 1] {
        return;
    }
    let doubled: BigInt = 2 * &d[l + 1];
    let numerator: BigInt = 2 * &lambda[k][l] + &d[l + 1];
    let q = numerator.div_floor(&doubled);
    let (before, rest) = basis.split_at_mut(k);
    rest[0].iter_mut().zip(&before[l]).for_each(|(a, b)| *a -= &q * b);
    lambda[k][l] -= &q * &d[l + 1];
    for i in 0..l {
        let change = &q * &lambda[l][i];
        lambda[k][i] -= change;
    }
}

fn swap(basis: &mut [Vec<BigInt>], d: &mut [BigInt], lambda: &mut [Vec<BigInt>], k: usize, known: usize) {
    basis.swap(k, k - 1);
    for j in 0..k - 1 {
        let (a, b) = lambda.split_at_mut(k);
        std::mem::swap(&mut a[k - 1][j], &mut b[0][j]);
    }
    let l = lambda[k][k - 1].clone();
    let new = (&d[k - 1] * &d[k + 1] + &l * &l) / &d[k];
    for i in k + 1..known {
        let t = lambda[i][k].clone();
        lambda[i][k] = (&d[k + 1] * &lambda[i][k - 1] - &l * &t) / &d[k];
        lambda[i][k - 1] = (&new * &t + &l * &lambda[i][k]) / &d[k + 1];
    }
    d[k] = new;
}

/// Whole numbers, not all zero, whose combination of `numbers` (over 2^digits) vanishes within rounding, if there are
/// some so small that this is no accident.
pub(super) fn relation(numbers: &[BigInt], digits: u64) -> Option<Vec<BigInt>> {
    /// Of the digits that the numbers have, this part may be used up by the relation: then one by accident has a chance
    /// of 2^(−digits/3) or less. A relation is proven afterwards in any case.
    const SHARE: (u64, u64) = (2, 3);
    let n = numbers.len();
    let mut basis: Vec<Vec<BigInt>> = (0..n)
        .map(|i| (0..=n).map(|j| if j == n { numbers[i].clone() } else { BigInt::from(u8::from(i == j)) }).collect())
        .collect();
    reduce(&mut basis);
    let first = &basis[0][..n];
    let bits: u64 = first.iter().map(BigInt::bits).sum();
    let rest = basis[0][n].bits();
    (bits * SHARE.1 < digits * SHARE.0 && rest < digits / 3).then(|| first.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_minimal_polynomial_of_a_sum_of_roots_is_found() {
        // θ = √2 + √3: θ⁴ − 10 θ² + 1 = 0.
        let digits = 200_usize;
        let root = |n: u32| -> BigInt { (BigInt::from(n) << (2 * digits)).sqrt() };
        let theta: BigInt = root(2) + root(3);
        let mut powers = vec![BigInt::one() << digits];
        for k in 0..4 {
            powers.push((&powers[k] * &theta) >> digits);
        }
        let found = relation(&powers, digits as u64).unwrap();
        let sign = if found[4].is_negative() { -1 } else { 1 };
        let found: Vec<i64> = found.iter().map(|c| i64::try_from(c * sign).unwrap()).collect();
        assert_eq!(found, [1, 0, -10, 0, 1]);
        assert_eq!(relation(&powers[..4], digits as u64), None);
    }
}
