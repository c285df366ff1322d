//! A polynomial in unit coordinates: the box is scaled so that its longest edge is between 1 and 2, and moved to the
//! origin. All coefficients stay exact; floats are made from them where they are needed, with error bounds.

use super::taylor::{ORDER, Taylor};
use crate::bernstein::tensor::TensorNet;
use crate::field::{Exponents, QuadraticPolynomial};
use crate::geom::{Aabb, Point3, Vec3};
use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A root √d is replaced by a number this many binary digits after the point: the error of the coefficients is far
/// below that of any float that is made from them.
const ROOT_DIGITS: u32 = 256;

/// f with x = center + scale · u, multiplied by a positive number that makes the coefficients whole.
#[derive(Clone, Debug)]
pub(super) struct UnitPolynomial {
    /// The origin of the unit coordinates, in model units.
    pub center: Point3,
    /// Model units a unit: a power of 2.
    pub scale: f64,
    /// The box in unit coordinates.
    pub bounds: Aabb,
    /// Exponents and coefficients.
    terms: Vec<(Exponents, BigInt)>,
    /// Highest exponents.
    pub degrees: [usize; 3],
    /// The sum of the errors of all coefficients is at most this.
    error: BigInt,
    /// Binary digits of the largest coefficient.
    digits: u64,
    /// The coefficients over 2^digits, z fastest.
    floats: Vec<f64>,
    /// Counts what has been done with it.
    pub work: Work,
}

/// Steps of splitting nets, by all threads: what a search has cost, whatever the machine.
#[derive(Clone, Debug, Default)]
pub(super) struct Work(Arc<AtomicU64>);

impl Work {
    /// A search that has cost more than this, some ten seconds, ends with an error: it would go on for minutes. The Barth
    /// decic with its 300 nodes takes a third of it.
    const MOST: u64 = 3_000_000_000;

    /// Adds the cost of a box with such a net.
    pub fn add(&self, net: &TensorNet) {
        let steps = net.coefficients.len() * net.degrees.iter().sum::<usize>();
        self.0.fetch_add(steps as u64, Ordering::Relaxed);
    }

    /// Is it too much?
    pub fn is_spent(&self) -> bool {
        self.0.load(Ordering::Relaxed) > Self::MOST
    }
}

impl UnitPolynomial {
    /// The polynomial in the unit coordinates of a box.
    pub fn new(f: &QuadraticPolynomial, bounds: &Aabb) -> Self {
        let longest = bounds.size().max();
        let scale = 2.0_f64.powi(longest.log2().floor() as i32);
        // On a coarse grid, so that differences from the corners of the box are exact.
        let grid = scale / 16.0;
        let center = bounds.center().map(|c| (c / grid).round() * grid);
        let moved = |p: Point3| (p - center) / scale;
        let bounds = Aabb::new(moved(bounds.min), moved(bounds.max));
        let (coefficients, error) = whole(f);
        let degrees = highest(&coefficients);
        let mut dense = Dense::new(degrees, coefficients);
        for axis in 0..3 {
            dense.shift(axis, center[axis], scale);
        }
        let digits = dense.values.iter().map(|c| c.bits()).max().unwrap_or(0);
        let floats = dense.values.iter().map(|c| ratio(c, digits)).collect();
        let terms = dense.terms();
        // The errors grow as the coefficients do when the origin is moved.
        let growth: BigRational = (0..3)
            .map(|a| (exact(center[a]).abs() + exact(scale) + BigRational::one()).pow(degrees[a] as i32))
            .product();
        let error = (growth * BigRational::from(error) * dense.factor).ceil().to_integer();
        Self { center, scale, bounds, terms, degrees, error, digits, floats, work: Work::default() }
    }

    /// Exponents and whole coefficients.
    pub fn terms(&self) -> &[(Exponents, BigInt)] {
        &self.terms
    }

    /// Are the coefficients exact? They are unless they hold a square root.
    pub fn is_exact(&self) -> bool {
        self.error.is_zero()
    }

    /// The point in model units.
    pub fn model(&self, u: Point3) -> Point3 {
        self.center + self.scale * u
    }

    /// The box in model units.
    pub fn model_box(&self, b: &Aabb) -> Aabb {
        Aabb::new(self.model(b.min), self.model(b.max))
    }

    /// Total degree.
    pub fn degree(&self) -> usize {
        self.terms.iter().map(|(e, _)| e.iter().sum::<u32>() as usize).max().unwrap_or(0)
    }

    /// The sum of the absolute values of the coefficients of the floating-point form: |f| and its rounding in the unit
    /// cube are bounded by it.
    pub fn magnitude(&self) -> f64 {
        self.floats.iter().map(|c| c.abs()).sum()
    }

    /// The derivatives at a point, of the floating-point form.
    pub fn taylor(&self, u: Point3) -> Taylor {
        Taylor::of(&self.floats, self.degrees, u, ORDER)
    }

    /// The value of the floating-point form.
    pub fn value(&self, u: Point3) -> f64 {
        Taylor::of(&self.floats, self.degrees, u, 0).derivative([0; 3])
    }

    /// Value and gradient of the floating-point form.
    pub fn gradient(&self, u: Point3) -> (f64, Point3) {
        let taylor = Taylor::of(&self.floats, self.degrees, u, 1);
        (taylor.derivative([0; 3]), taylor.gradient())
    }

    /// The net of f on a box, from the exact coefficients: every coefficient is right to the rounding of the largest.
    pub fn net(&self, cell: &Aabb) -> TensorNet {
        self.net_of(self.degrees, self.terms.iter().cloned(), &BigInt::one(), cell).0
    }

    /// The net of the derivative by the parameter of an axis, in units of the whole coefficients: those of the three
    /// axes have one scale.
    pub fn derivative_net(&self, axis: usize, cell: &Aabb) -> TensorNet {
        if self.degrees[axis] == 0 {
            return TensorNet::new([0; 3], vec![0.0], 0.0);
        }
        let mut degrees = self.degrees;
        degrees[axis] -= 1;
        let terms = self.terms.iter().filter(|(e, _)| e[axis] > 0).map(|(e, c)| {
            let mut lower = *e;
            lower[axis] -= 1;
            (lower, c * e[axis])
        });
        let (net, scale) = self.net_of(degrees, terms, &BigInt::from(self.degrees[axis]), cell);
        net.scaled(scale * (cell.max[axis] - cell.min[axis]))
    }

    /// The net of the derivative in a direction, up to a positive factor: summed before it is rounded, so that what
    /// cancels is gone.
    pub fn directional_net(&self, direction: Vec3, cell: &Aabb) -> TensorNet {
        /// Binary digits of the direction.
        const DIGITS: u64 = 64;
        let weights = [0, 1, 2]
            .map(|a| (exact(direction[a]) * BigRational::from(BigInt::one() << DIGITS)).to_integer());
        let terms = weights.iter().enumerate().flat_map(|(axis, weight)| {
            self.terms.iter().filter(move |(e, _)| e[axis] > 0).map(move |(e, c)| {
                let mut lower = *e;
                lower[axis] -= 1;
                (lower, c * e[axis] * weight)
            })
        });
        let growth: BigInt = weights.iter().zip(self.degrees).map(|(w, n)| w.abs() * n).sum();
        self.net_of(self.degrees, terms, &growth, cell).0
    }

    /// The net of a polynomial on a box, scaled to size 1, and the factor to its values; `growth` bounds what
    /// differentiation does to errors.
    fn net_of(
        &self,
        degrees: [usize; 3],
        terms: impl Iterator<Item = (Exponents, BigInt)>,
        growth: &BigInt,
        cell: &Aabb,
    ) -> (TensorNet, f64) {
        let mut dense = Dense::new(degrees, terms);
        let mut factor = BigInt::one();
        for axis in 0..3 {
            factor *= dense.bernstein(axis, cell.min[axis], cell.max[axis]);
        }
        let digits = dense.values.iter().map(|c| c.bits()).max().unwrap_or(0);
        let coefficients: Vec<f64> = dense.values.iter().map(|c| ratio(c, digits)).collect();
        // Bernstein coefficients of degree n are at most 4^n times as large as the polynomial on the interval.
        let condition = 2 * degrees.iter().sum::<usize>();
        let inherited = ratio(&(((&self.error * growth * &factor) << condition) + 1), digits);
        let rounding = 2.0 * f64::EPSILON;
        let error = if self.error.is_zero() { rounding } else { rounding + 2.0 * inherited };
        (TensorNet::new(degrees, coefficients, error), 1.0 / ratio(&factor, digits))
    }

    /// The exact value of a partial derivative at a point of floats, over 2^digits of the floating-point form, rounded
    /// once, and a bound on its error.
    pub fn exact_derivative(&self, u: Point3, by: Exponents) -> (f64, f64) {
        let fixed = [0, 1, 2].map(|a| Fixed::new(u[a]));
        let (value, digits) = self.fixed_derivative(&fixed, by);
        let value = ratio(&value, digits + self.digits);
        let factorials: f64 = (0..3)
            .map(|a| (0..by[a]).map(|k| (self.degrees[a] as f64 - f64::from(k)).max(1.0)).product::<f64>())
            .product();
        let inherited =
            if self.error.is_zero() { 0.0 } else { 2.0 * factorials * ratio(&self.error, self.digits) };
        (value, inherited + f64::EPSILON * value.abs() + f64::MIN_POSITIVE)
    }

    /// A partial derivative at a point of binary fractions: (n, k) for n / 2^k, in units of the whole coefficients.
    pub fn fixed_derivative(&self, u: &[Fixed; 3], by: Exponents) -> (BigInt, u64) {
        let powers: [Vec<BigInt>; 3] = [0, 1, 2].map(|a| {
            let n = self.degrees[a] as u32;
            (0..=n).map(|k| u[a].numerator.pow(k) << (u[a].digits * u64::from(n - k))).collect()
        });
        let mut sum = BigInt::zero();
        for (e, c) in &self.terms {
            if (0..3).any(|a| e[a] < by[a]) {
                continue;
            }
            let mut term = c.clone();
            for a in 0..3 {
                let falling: BigInt = (0..by[a]).map(|k| BigInt::from(e[a] - k)).product();
                term *= falling * &powers[a][(e[a] - by[a]) as usize];
            }
            sum += term;
        }
        (sum, (0..3).map(|a| u[a].digits * self.degrees[a] as u64).sum())
    }

    /// Binary digits of the largest coefficient.
    pub fn digits(&self) -> u64 {
        self.digits
    }
}

/// A binary fraction: numerator / 2^digits.
#[derive(Clone, Debug)]
pub(super) struct Fixed {
    pub numerator: BigInt,
    pub digits: u64,
}

impl Fixed {
    /// The exact value of a float, which is finite.
    pub fn new(value: f64) -> Self {
        let exact = exact(value);
        let digits = exact.denom().bits() - 1;
        Self { numerator: exact.numer().clone(), digits }
    }
}

/// The exact value of a float; 0 if it is not finite.
pub(super) fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap_or_else(BigRational::zero)
}

/// n / 2^digits as a float.
pub(super) fn ratio(n: &BigInt, digits: u64) -> f64 {
    /// More digits than a float has, so that one rounding is left.
    const KEPT: u64 = 64;
    let excess = n.bits().saturating_sub(KEPT);
    let kept = (n >> excess).to_f64().unwrap_or(f64::NAN);
    let exponent = excess as i64 - digits as i64;
    // In two steps, because 2^exponent alone may be too small for a float.
    let half = (exponent / 2).clamp(-1000, 1000) as i32;
    let rest = (exponent - i64::from(half)).clamp(-1070, 1020) as i32;
    kept * 2.0_f64.powi(half) * 2.0_f64.powi(rest)
}

/// The coefficients over their common denominator, with √d to [`ROOT_DIGITS`], and the sum of the errors.
fn whole(f: &QuadraticPolynomial) -> (Vec<(Exponents, BigInt)>, BigInt) {
    let root = (BigInt::from(f.radicand) << (2 * ROOT_DIGITS)).sqrt();
    let denominators = f.rational.terms().chain(f.irrational.terms()).map(|(_, c)| c.denom().clone());
    let common = denominators.fold(BigInt::one(), |a, b| a.lcm(&b));
    let number = |c: &BigRational| c.numer() * (&common / c.denom());
    if f.radicand == 1 {
        return (f.rational.terms().map(|(e, c)| (e, number(c))).collect(), BigInt::zero());
    }
    let plain = f.rational.terms().map(|(e, c)| (e, number(c) << ROOT_DIGITS));
    let rooted = f.irrational.terms().map(|(e, c)| (e, number(c) * &root));
    let error = f.irrational.terms().map(|(_, c)| number(c).abs()).sum();
    (plain.chain(rooted).collect(), error)
}

fn highest(terms: &[(Exponents, BigInt)]) -> [usize; 3] {
    [0, 1, 2].map(|a| terms.iter().map(|(e, _)| e[a] as usize).max().unwrap_or(0))
}

/// Whole coefficients of all exponents up to the highest, z fastest.
struct Dense {
    degrees: [usize; 3],
    values: Vec<BigInt>,
    /// What they have been multiplied by since the beginning.
    factor: BigRational,
}

impl Dense {
    fn new(degrees: [usize; 3], terms: impl IntoIterator<Item = (Exponents, BigInt)>) -> Self {
        let [_, m, n] = degrees.map(|d| d + 1);
        let mut values = vec![BigInt::zero(); degrees.iter().map(|d| d + 1).product()];
        for (e, c) in terms {
            values[(e[0] as usize * m + e[1] as usize) * n + e[2] as usize] += c;
        }
        Self { degrees, values, factor: BigRational::one() }
    }

    fn terms(&self) -> Vec<(Exponents, BigInt)> {
        let [_, m, n] = self.degrees.map(|d| d + 1);
        let exponents = |i: usize| [(i / n / m) as u32, (i / n % m) as u32, (i % n) as u32];
        self.values
            .iter()
            .enumerate()
            .filter(|(_, c)| !c.is_zero())
            .map(|(i, c)| (exponents(i), c.clone()))
            .collect()
    }

    /// Replaces every row along an axis by the matrix (rows of n + 1 numbers) times it.
    fn multiply(&mut self, axis: usize, matrix: &[Vec<BigInt>]) {
        let counts = self.degrees.map(|n| n + 1);
        let inner: usize = counts[axis + 1..].iter().product();
        let count = counts[axis];
        let mut result = vec![BigInt::zero(); self.values.len()];
        for start in (0..self.values.len()).filter(|i| (i / inner).is_multiple_of(count)) {
            for (k, value) in (0..count).map(|k| (k, &self.values[start + k * inner])) {
                if value.is_zero() {
                    continue;
                }
                for (i, row) in matrix.iter().enumerate() {
                    if !row[k].is_zero() {
                        result[start + i * inner] += &row[k] * value;
                    }
                }
            }
        }
        self.values = result;
    }

    /// Substitutes center + scale · u for a variable.
    fn shift(&mut self, axis: usize, center: f64, scale: f64) {
        let n = self.degrees[axis];
        let (matrix, digits) = powers_matrix(n, &Fixed::new(center), &Fixed::new(scale));
        self.multiply(axis, &matrix);
        self.factor *= BigRational::from(BigInt::one() << (digits * n as u64));
    }

    /// Replaces monomials along an axis by Bernstein polynomials over [lo, hi]; returns the factor on the coefficients
    /// over that of the binary digits.
    fn bernstein(&mut self, axis: usize, lo: f64, hi: f64) -> BigInt {
        let n = self.degrees[axis];
        let (lo, hi) = (Fixed::new(lo), Fixed::new(hi));
        let digits = lo.digits.max(hi.digits);
        let width = Fixed {
            numerator: (&hi.numerator << (digits - hi.digits)) - (&lo.numerator << (digits - lo.digits)),
            digits,
        };
        let (powers, digits) = powers_matrix(n, &lo, &width);
        let binomial = |n: usize, k: usize| num_integer::binomial(BigInt::from(n), BigInt::from(k));
        let common = (0..=n).fold(BigInt::one(), |a, j| a.lcm(&binomial(n, j)));
        // b_i = Σ_j (i choose j)/(n choose j) a_j for Σ a_j t^j.
        let matrix: Vec<Vec<BigInt>> = (0..=n)
            .map(|i| {
                (0..=n)
                    .map(|e| {
                        (0..=i)
                            .map(|j| binomial(i, j) * (&common / binomial(n, j)) * &powers[j][e])
                            .sum::<BigInt>()
                    })
                    .collect()
            })
            .collect();
        self.multiply(axis, &matrix);
        common << (digits * n as u64)
    }
}

/// The coefficient of t^j in (a + b t)^e, for each j (rows) and e (columns) up to n, times 2^(digits·n).
fn powers_matrix(n: usize, a: &Fixed, b: &Fixed) -> (Vec<Vec<BigInt>>, u64) {
    let digits = a.digits.max(b.digits);
    let (a, b) = (&a.numerator << (digits - a.digits), &b.numerator << (digits - b.digits));
    let entry = |j: usize, e: usize| {
        if j > e {
            return BigInt::zero();
        }
        let binomial = num_integer::binomial(BigInt::from(e), BigInt::from(j));
        (binomial * a.pow((e - j) as u32) * b.pow(j as u32)) << (digits * (n - e) as u64)
    };
    ((0..=n).map(|j| (0..=n).map(|e| entry(j, e)).collect()).collect(), digits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};

    fn polynomial(text: &str) -> QuadraticPolynomial {
        Formula::parse(text, &Constants::new()).unwrap().quadratic_polynomial().unwrap()
    }

    #[test]
    fn nets_and_derivatives_agree_with_the_polynomial() {
        for text in ["x^3 y - 2 z^2 + x y z + 1/3", "(1+sqrt(5))/2 x^2 - y z^3"] {
            let f = polynomial(text);
            let bounds = Aabb::new(Point3::new(0.3, -2.0, 1.0), Point3::new(3.1, 1.5, 2.0));
            let unit = UnitPolynomial::new(&f, &bounds);
            let root5 = 5.0_f64.sqrt();
            let value = |p: Point3| {
                let p = [0, 1, 2].map(|a| exact(p[a]));
                f.rational.value(&p).to_f64().unwrap() + root5 * f.irrational.value(&p).to_f64().unwrap()
            };
            let cell = Aabb::new(Point3::new(-0.25, 0.1, -0.5), Point3::new(0.75, 0.2, 0.5));
            let net = unit.net(&cell);
            let t = [0.3, 0.8, 0.6];
            let u = Point3::from_fn(|a, _| cell.min[a] + t[a] * (cell.max[a] - cell.min[a]));
            let (p, q) = (u, Point3::new(0.1, 0.4, -0.3));
            let expected = value(unit.model(p)) / value(unit.model(q));
            assert!((unit.value(p) / unit.value(q) - expected).abs() < 1e-13 * expected.abs());
            let ratios = [net.value([0.5; 3]) / net.value(t), unit.value(cell.center()) / unit.value(u)];
            assert!((ratios[0] - ratios[1]).abs() < 1e-12 * ratios[0].abs(), "{text}: {ratios:?}");
            for by in [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 2], [2, 1, 0]] {
                let (exact, bound) = unit.exact_derivative(u, by.map(|n| n as u32));
                assert!((exact - unit.taylor(u).derivative(by)).abs() < 1e-14 + bound, "{text} {by:?}");
            }
        }
    }
}
