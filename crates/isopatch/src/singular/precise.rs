//! Newton's method in many digits, where floats can't tell a degenerate point from a short curve.
//!
//! At an A_k point f grows like t^(k+1) along one direction: at a distance of 10⁻⁴ it is below the rounding of floats for
//! k > 3, and the point looks like a piece of a curve. In a thousand binary digits it does not.

use super::unit::{UnitPolynomial, exact, ratio};
use crate::geom::{Point3, Vec3};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

/// Binary digits after the point. A point at which Newton's method converges linearly with the rate 1 − 1/k is known to a
/// k-th of them.
const WORKING: u64 = 1024;
/// A step below 2^−this ends the iteration: more digits than are needed to recognize a number.
const CONVERGED: u64 = 264;
/// A limit that is known to fewer digits than this is none.
const FEWEST: u64 = 60;
/// Coefficients with √d are known to 256 digits; what is derived from them, to this many.
const OF_ROOTS: u64 = 240;
/// A start from which so many steps have found no more than these digits is given up.
const EARLY: usize = 36;
const EARLY_DIGITS: u64 = 18;
/// Steps: an extrapolation, once in six steps, gains eight digits or more.
const STEPS: usize = 240;
/// Where nothing is known of the order of a root, it is taken for one of this order.
const HIGHEST_ORDER: u32 = 8;
/// The rate of convergence is known when two estimates are this close.
const RATE: f64 = 5e-3;
/// A sequence that converges more slowly, over two steps, is none of a root of an order that is met.
const SLOWEST: f64 = 0.9;
/// An extrapolation goes this part of the way: one that hits a root to all digits leaves nothing but rounding in its
/// direction, and the others not yet found.
const SHORT_OF: f64 = 1.0 - 1.0 / 256.0;
/// Part of the digits of a point to which f and ∇f must vanish there.
const VANISHING: f64 = 0.75;
/// A start at which the equations have no step is moved by this, in directions that are no axes.
const NUDGE: [f64; 3] = [3.1e-4, -2.3e-4, 1.7e-4];

/// A critical point of f, or of f on a plane, in unit coordinates.
#[derive(Clone, Debug)]
pub(super) struct PrecisePoint {
    /// Coordinates over 2^[`WORKING`].
    at: [BigInt; 3],
    /// Binary digits after the point that are right.
    pub digits: u64,
    /// Do f and ∇f vanish there, to [`VANISHING`] of these digits?
    pub is_singular: bool,
}

impl PrecisePoint {
    /// The nearest point of floats.
    pub fn nearest(&self) -> Point3 {
        Point3::from_fn(|a, _| ratio(&self.at[a], WORKING))
    }

    /// In model units.
    pub fn model(&self, f: &UnitPolynomial) -> [BigRational; 3] {
        let scale = exact(f.scale);
        [0, 1, 2].map(|a| {
            let unit = BigRational::new(self.at[a].clone(), BigInt::one() << WORKING);
            exact(f.center[a]) + &scale * unit
        })
    }
}

/// The critical point of f to which Newton's method leads from `start`; none if it does not converge.
pub(super) fn critical_point(f: &UnitPolynomial, start: Point3, reach: f64) -> Option<PrecisePoint> {
    Precise::new(f).newton(start, &[Vec3::x(), Vec3::y(), Vec3::z()], reach)
}

/// The critical point of f on the plane through `start` across `normal`.
pub(super) fn critical_point_across(
    f: &UnitPolynomial,
    start: Point3,
    normal: Vec3,
    reach: f64,
) -> Option<PrecisePoint> {
    let u = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    Precise::new(f).newton(start, &[u, normal.cross(&u)], reach)
}

/// The coefficients in fixed point.
struct Precise {
    terms: Vec<([usize; 3], BigInt)>,
    degrees: [usize; 3],
    /// Digits that are right, of the coefficients.
    digits: u64,
}

/// Value, gradient and Hessian (xx, xy, xz, yy, yz, zz) over 2^[`WORKING`].
struct Jet {
    value: BigInt,
    gradient: [BigInt; 3],
    hessian: [BigInt; 6],
}

const FIRST: [[usize; 3]; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const SECOND: [[usize; 3]; 6] = [[2, 0, 0], [1, 1, 0], [1, 0, 1], [0, 2, 0], [0, 1, 1], [0, 0, 2]];
/// The place of ∂a∂b in [`SECOND`].
const PAIR: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

impl Precise {
    fn new(f: &UnitPolynomial) -> Self {
        let terms = f.terms().iter().map(|(e, c)| (e.map(|n| n as usize), (c << WORKING) >> f.digits()));
        let digits = if f.is_exact() { WORKING } else { OF_ROOTS };
        Self { terms: terms.collect(), degrees: f.degrees, digits }
    }

    fn jet(&self, at: &[BigInt; 3]) -> Jet {
        let powers: [Vec<BigInt>; 3] = [0, 1, 2].map(|a| {
            let mut list = vec![BigInt::one() << WORKING];
            for k in 0..self.degrees[a] {
                list.push((&list[k] * &at[a]) >> WORKING);
            }
            list
        });
        let derivative = |by: &[usize; 3]| {
            let terms = self.terms.iter().filter(|(e, _)| (0..3).all(|a| e[a] >= by[a]));
            terms
                .map(|(e, c)| {
                    let falling: usize =
                        (0..3).map(|a| (0..by[a]).map(|k| e[a] - k).product::<usize>()).product();
                    (0..3)
                        .filter(|a| e[*a] > by[*a])
                        .fold(c * falling, |term, a| (term * &powers[a][e[a] - by[a]]) >> WORKING)
                })
                .sum::<BigInt>()
        };
        Jet {
            value: derivative(&[0; 3]),
            gradient: FIRST.each_ref().map(derivative),
            hessian: SECOND.each_ref().map(derivative),
        }
    }

    /// Newton's method for the gradient in the space that the directions span. Where it converges linearly, its limit is
    /// extrapolated from every other point, because steps towards a valley and along it take turns.
    fn newton(&self, start: Point3, directions: &[Vec3], reach: f64) -> Option<PrecisePoint> {
        let basis: Vec<[BigInt; 3]> = directions.iter().map(|d| [d.x, d.y, d.z].map(fixed)).collect();
        let origin = [start.x, start.y, start.z].map(fixed);
        let mut at = origin.clone();
        let mut pairs = Pairs::new(&at);
        let (mut digits, mut last) = (0, None);
        for number in 0..STEPS {
            let jet = self.jet(&at);
            let gradient: Vec<BigInt> = basis.iter().map(|b| dot(b, &jet.gradient)).collect();
            // Where |∇f| ≈ t^m is rounding, so are the digits of t beyond an m-th of those of f.
            let rounding = WORKING - self.digits + GUARD;
            let settled = self.digits / u64::from(pairs.order.unwrap_or(HIGHEST_ORDER) + 1);
            if gradient.iter().all(|g| g.bits() <= rounding) {
                digits = digits.max(settled);
                break;
            }
            let Some(step) = newton_step(&jet.hessian, &gradient, &basis) else {
                if number > 0 {
                    digits = digits.max(settled);
                    break;
                }
                (0..3).for_each(|a| at[a] += fixed(NUDGE[a]));
                pairs = Pairs::new(&at);
                continue;
            };
            let short = WORKING.saturating_sub(step.iter().map(BigInt::bits).max().unwrap_or(0));
            // The longer one of two: steps towards a valley and along it.
            let found = short.min(last.replace(short).unwrap_or(0));
            if found + GUARD < digits {
                // Rounding.
                digits -= GUARD;
                break;
            }
            digits = digits.max(found);
            for a in 0..3 {
                at[a] -= basis.iter().zip(&step).map(|(b, s)| (&b[a] * s) >> WORKING).sum::<BigInt>();
            }
            let moved = Point3::from_fn(|a, _| ratio(&(&at[a] - &origin[a]), WORKING));
            if moved.norm() > reach {
                return None;
            }
            if number > EARLY && digits < EARLY_DIGITS {
                return None;
            }
            if found >= CONVERGED || (number == 0 && short >= CONVERGED) {
                break;
            }
            if number % 2 == 1 {
                pairs.advance(&mut at);
            }
        }
        let digits = digits.min(self.digits);
        if digits < FEWEST {
            return None;
        }
        let jet = self.jet(&at);
        let zero = WORKING - (VANISHING * digits as f64) as u64;
        let is_singular = std::iter::once(&jet.value).chain(&jet.gradient).all(|v| v.bits() <= zero);
        Some(PrecisePoint { at, digits, is_singular })
    }
}

/// Digits by which a step may be larger than one before: that of another direction.
const GUARD: u64 = 24;

/// Every other point of Newton's method.
struct Pairs {
    last: [BigInt; 3],
    /// The last change, times 2^[`CONVERGED`], and the part of the one before that it is.
    change: Option<Point3>,
    rate: Option<f64>,
    /// The order of the root, where a rate was found.
    order: Option<u32>,
}

impl Pairs {
    fn new(at: &[BigInt; 3]) -> Self {
        Self { last: at.clone(), change: None, rate: None, order: None }
    }

    /// Takes a point, and moves it to the limit where the changes are a geometric sequence.
    fn advance(&mut self, at: &mut [BigInt; 3]) {
        let changes = [0, 1, 2].map(|a| &at[a] - &self.last[a]);
        let change = Point3::from_fn(|a, _| ratio(&changes[a], WORKING - CONVERGED));
        let rate = self.change.map(|before| before.dot(&change) / before.norm_squared());
        let known =
            matches!((self.rate, rate), (Some(a), Some(b)) if (a - b).abs() < RATE && b > 0.0 && b < SLOWEST);
        if let (true, Some(rate)) = (known, rate) {
            let order = (1.0 / (1.0 - rate.sqrt())).round();
            self.order = self.order.max(Some((order as u32).min(HIGHEST_ORDER)));
            let factor = fixed(SHORT_OF * rate / (1.0 - rate));
            (0..3).for_each(|a| at[a] += (&changes[a] * &factor) >> WORKING);
            (self.change, self.rate) = (None, None);
        } else {
            (self.change, self.rate) = (Some(change), rate);
        }
        self.last = at.clone();
    }
}

fn fixed(value: f64) -> BigInt {
    (exact(value) * BigRational::from(BigInt::one() << WORKING)).to_integer()
}

fn dot(a: &[BigInt; 3], b: &[BigInt; 3]) -> BigInt {
    (0..3).map(|i| &a[i] * &b[i]).sum::<BigInt>() >> WORKING
}

/// (Bᵀ H B)⁻¹ g by Cramer's rule, in whole numbers, so that nothing is lost where the determinant is small; none if it
/// is 0.
fn newton_step(hessian: &[BigInt; 6], gradient: &[BigInt], basis: &[[BigInt; 3]]) -> Option<Vec<BigInt>> {
    let n = basis.len();
    let image = |b: &[BigInt; 3]| [0, 1, 2].map(|i| dot(&[0, 1, 2].map(|j| hessian[PAIR[i][j]].clone()), b));
    let images: Vec<[BigInt; 3]> = basis.iter().map(image).collect();
    let h: Vec<Vec<BigInt>> =
        basis.iter().map(|b| images.iter().map(|image| dot(b, image)).collect()).collect();
    let determinant = determinant(&h);
    if determinant.is_zero() {
        return None;
    }
    let component = |k: usize| {
        let mut replaced = h.clone();
        (0..n).for_each(|i| replaced[i][k] = gradient[i].clone());
        (self::determinant(&replaced) << WORKING) / &determinant
    };
    Some((0..n).map(component).collect())
}

/// Of a matrix with two or three rows.
fn determinant(m: &[Vec<BigInt>]) -> BigInt {
    match m {
        [a, b] => &a[0] * &b[1] - &a[1] * &b[0],
        [a, b, c] => {
            &a[0] * (&b[1] * &c[2] - &b[2] * &c[1]) - &a[1] * (&b[0] * &c[2] - &b[2] * &c[0])
                + &a[2] * (&b[0] * &c[1] - &b[1] * &c[0])
        }
        _ => BigInt::zero(),
    }
}
