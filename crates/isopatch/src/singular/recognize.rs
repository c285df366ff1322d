//! Exact coordinates of points that are known to many digits, and the proof that they are right.
//!
//! A relation with whole coefficients between powers of a coordinate is guessed by lattice reduction. The point is then
//! a point over a number field Q[t]/(m), and f = 0, ∇f = 0 are checked there in exact arithmetic. The guess may fail; what
//! passes the check is proven.

use super::lattice::relation;
use super::unit::{Fixed, UnitPolynomial, exact};
use crate::field::{Polynomial, QuadraticPolynomial};
use crate::geom::{Mat3, Point3, Vec3};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

/// Binary digits of the coordinates from which relations are guessed.
const DIGITS: u64 = 240;
/// Degrees of number fields that are tried; points of higher degree stay numerical.
const FIELD_DEGREES: [usize; 4] = [1, 2, 4, 8];

/// An element of a number field: coefficients of 1, θ, θ², …
type Element = Vec<BigRational>;

/// A point with coordinates in a number field.
#[derive(Clone, Debug)]
pub(super) struct AlgebraicPoint {
    /// The coordinates.
    coordinates: [Element; 3],
    /// √d, where the polynomial has one.
    root: Option<Element>,
    /// θ^n as a combination of lower powers.
    reduction: Element,
}

impl AlgebraicPoint {
    /// The coordinates, if they are rational.
    pub fn rational(&self) -> Option<[BigRational; 3]> {
        (self.reduction.len() == 1).then(|| self.coordinates.clone().map(|c| c[0].clone()))
    }

    /// Do f and ∇f vanish there, exactly?
    pub fn is_singular_on(&self, f: &QuadraticPolynomial) -> bool {
        let powers: [Vec<Element>; 3] = [0, 1, 2].map(|a| {
            let highest = [&f.rational, &f.irrational]
                .iter()
                .flat_map(|p| p.terms().map(|(e, _)| e[a]).collect::<Vec<_>>())
                .max()
                .unwrap_or(0);
            let mut list = vec![self.one()];
            for k in 0..highest as usize {
                list.push(self.times(&list[k], &self.coordinates[a]));
            }
            list
        });
        let value = |p: &Polynomial| {
            let mut sum = vec![BigRational::zero(); self.reduction.len()];
            for (e, c) in p.terms() {
                let xy = self.times(&powers[0][e[0] as usize], &powers[1][e[1] as usize]);
                let term = self.times(&xy, &powers[2][e[2] as usize]);
                sum.iter_mut().zip(term).for_each(|(s, t)| *s += c * t);
            }
            sum
        };
        let vanishes = |p: &Polynomial, q: &Polynomial| {
            let mut sum = value(p);
            if let Some(root) = &self.root {
                let rooted = self.times(&value(q), root);
                sum.iter_mut().zip(rooted).for_each(|(s, t)| *s += t);
            }
            sum.iter().all(Zero::is_zero)
        };
        let is_root = self.root.as_ref().is_none_or(|root| {
            let square = self.times(root, root);
            let (first, rest) = square.split_at(1);
            first[0] == BigRational::from(BigInt::from(f.radicand)) && rest.iter().all(Zero::is_zero)
        });
        is_root
            && vanishes(&f.rational, &f.irrational)
            && (0..3).all(|a| vanishes(&f.rational.derivative(a), &f.irrational.derivative(a)))
    }

    fn one(&self) -> Element {
        let mut one = vec![BigRational::zero(); self.reduction.len()];
        one[0] = BigRational::one();
        one
    }

    fn times(&self, a: &Element, b: &Element) -> Element {
        let n = self.reduction.len();
        let mut product = vec![BigRational::zero(); 2 * n - 1];
        for (i, a) in a.iter().enumerate().filter(|(_, a)| !a.is_zero()) {
            for (j, b) in b.iter().enumerate().filter(|(_, b)| !b.is_zero()) {
                product[i + j] += a * b;
            }
        }
        for k in (n..product.len()).rev() {
            let high = std::mem::replace(&mut product[k], BigRational::zero());
            if !high.is_zero() {
                (0..n).for_each(|i| product[k - n + i] += &high * &self.reduction[i]);
            }
        }
        product.truncate(n);
        product
    }
}

/// The simple root of ∇f = 0 near a point, to [`DIGITS`] binary digits, in model units over 2^DIGITS: Newton's method
/// with the inverse Hessian of the start, which gains the same number of digits every step.
pub(super) fn polish(f: &UnitPolynomial, start: Point3) -> Option<[BigInt; 3]> {
    /// Digits beyond those that are wanted, for the last step.
    const GUARD: u64 = 16;
    const STEPS: usize = 12;
    let digits = DIGITS + GUARD;
    let inverse: Mat3 = f.taylor(start).hessian().try_inverse()?;
    let mut at = [0, 1, 2].map(|a| rounded(&exact(start[a]), digits));
    for _ in 0..STEPS {
        let point = at.each_ref().map(|n| Fixed { numerator: n.clone(), digits });
        let gradient = [0, 1, 2].map(|a| {
            let mut by = [0; 3];
            by[a] = 1;
            let (value, below) = f.fixed_derivative(&point, by);
            // In units of 2^-digits.
            shift(value, digits as i64 - below as i64 - f.digits() as i64)
        });
        let size = gradient.iter().map(BigInt::bits).max().unwrap_or(0);
        // The step in floats, at the scale of the gradient.
        let floats = Vec3::from_fn(|a, _| super::unit::ratio(&gradient[a], size));
        let step = inverse * floats;
        let mut largest = 0;
        for a in 0..3 {
            let change = rounded(&exact(step[a]), 60);
            let change = shift(change, size as i64 - 60);
            largest = largest.max(change.bits());
            at[a] -= change;
        }
        if largest <= GUARD / 2 {
            break;
        }
    }
    let scale = exact(f.scale);
    Some([0, 1, 2].map(|a| {
        let unit = BigRational::new(at[a].clone(), BigInt::one() << digits);
        rounded(&(exact(f.center[a]) + &scale * unit), DIGITS)
    }))
}

fn shift(n: BigInt, by: i64) -> BigInt {
    if by >= 0 { n << by } else { n >> -by }
}

/// q · 2^digits, rounded.
fn rounded(q: &BigRational, digits: u64) -> BigInt {
    (q * BigRational::from(BigInt::one() << digits)).round().to_integer()
}

/// The point with coordinates in a number field of small degree near the given one (over 2^DIGITS).
pub(super) fn recognize(f: &QuadraticPolynomial, point: &[BigInt; 3]) -> Option<AlgebraicPoint> {
    let root = (f.radicand > 1).then(|| (BigInt::from(f.radicand) << (2 * DIGITS)).sqrt());
    let numbers: Vec<&BigInt> = point.iter().chain(root.as_ref()).collect();
    // A combination that generates the field, unless the coordinates conspire: √d itself, a coordinate, a mixture.
    let mixture = numbers.iter().zip([3, -5, 7, 11]).map(|(n, k)| *n * k).sum::<BigInt>();
    FIELD_DEGREES.iter().find_map(|&degree| {
        let generators = numbers.iter().rev().copied().chain([&mixture]);
        let mut generators: Vec<&BigInt> = generators.collect();
        generators.dedup();
        generators.into_iter().find_map(|theta| in_field(&numbers, theta, degree))
    })
}

/// The coordinates as combinations of 1, θ, …, θ^(n−1), where θ has a minimal polynomial of degree n.
fn in_field(numbers: &[&BigInt], theta: &BigInt, degree: usize) -> Option<AlgebraicPoint> {
    let mut powers = vec![BigInt::one() << DIGITS];
    for k in 0..degree {
        powers.push((&powers[k] * theta) >> DIGITS);
    }
    let minimal = relation(&powers, DIGITS)?;
    let leading = minimal.last().filter(|c| !c.is_zero())?;
    let reduction: Element =
        minimal[..degree].iter().map(|c| -BigRational::new(c.clone(), leading.clone())).collect();
    let mut elements = numbers.iter().map(|number| {
        let mut list: Vec<BigInt> = powers[..degree].to_vec();
        list.push((*number).clone());
        let found = relation(&list, DIGITS)?;
        let last = found.last().filter(|c| !c.is_zero())?;
        Some(found[..degree].iter().map(|c| -BigRational::new(c.clone(), last.clone())).collect::<Element>())
    });
    let coordinates = [elements.next()??, elements.next()??, elements.next()??];
    let root = match elements.next() {
        Some(found) => Some(found?),
        None => None,
    };
    Some(AlgebraicPoint { coordinates, root, reduction })
}

/// The singular point of f near a point that is known to so many binary digits: rational, or over a number field if they
/// are enough to guess one. What is returned is proven.
pub(super) fn recognize_place(
    f: &QuadraticPolynomial,
    point: &[BigRational; 3],
    digits: u64,
) -> Option<AlgebraicPoint> {
    /// Digits that may be wrong at the end.
    const DOUBTFUL: u64 = 8;
    let tolerance = BigRational::new(BigInt::one(), BigInt::one() << digits.saturating_sub(DOUBTFUL));
    let guess = point.each_ref().map(|q| simplest(q, &tolerance));
    if is_singular_at(f, &guess) {
        let coordinates = guess.map(|q| vec![q]);
        return Some(AlgebraicPoint { coordinates, root: None, reduction: vec![BigRational::one()] });
    }
    if digits < DIGITS {
        return None;
    }
    let point = point.each_ref().map(|q| rounded(q, DIGITS));
    recognize(f, &point).filter(|point| point.is_singular_on(f))
}

/// The point with rational coordinates of small denominators nearest to a float point, for points that are no simple
/// roots and known to the digits of floats only.
pub(super) fn recognize_rational(p: Point3, tolerance: f64) -> [BigRational; 3] {
    [0, 1, 2].map(|a| simplest(&exact(p[a]), &exact(tolerance)))
}

/// The rational number with the smallest denominator within `tolerance` of q: continued fractions.
fn simplest(q: &BigRational, tolerance: &BigRational) -> BigRational {
    let (mut p0, mut q0, mut p1, mut q1) = (BigInt::zero(), BigInt::one(), BigInt::one(), BigInt::zero());
    let mut rest = q.clone();
    loop {
        let whole = rest.floor().to_integer();
        (p0, p1) = (p1.clone(), &whole * &p1 + p0);
        (q0, q1) = (q1.clone(), &whole * &q1 + q0);
        let convergent = BigRational::new(p1.clone(), q1.clone());
        let fraction = rest - BigRational::from(whole);
        if (&convergent - q).abs() <= *tolerance || fraction.is_zero() {
            return convergent;
        }
        rest = fraction.recip();
    }
}

/// Do f and ∇f vanish at a rational point? Both parts must, because √d is irrational.
pub(super) fn is_singular_at(f: &QuadraticPolynomial, p: &[BigRational; 3]) -> bool {
    [&f.rational, &f.irrational]
        .iter()
        .all(|part| part.value(p).is_zero() && (0..3).all(|a| part.derivative(a).value(p).is_zero()))
}
