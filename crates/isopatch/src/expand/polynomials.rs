//! Polynomials in local coordinates, dense by total degree: what a power series of a surface is computed with.

use crate::field::Exponents;

/// A polynomial in X, Y, Z up to a total degree.
#[derive(Clone, Debug)]
pub(super) struct Trivariate {
    degree: usize,
    /// Coefficients by powers (i, j, l), each from 0 to the degree; those above the total degree stay zero.
    terms: Vec<f64>,
}

impl Trivariate {
    fn zero(degree: usize) -> Self {
        Self { degree, terms: vec![0.0; (degree + 1).pow(3)] }
    }

    fn at(&self, [i, j, l]: [usize; 3]) -> usize {
        (i * (self.degree + 1) + j) * (self.degree + 1) + l
    }

    /// Powers with a total degree up to that of the polynomial.
    fn powers(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let n = self.degree;
        (0..=n).flat_map(move |i| (0..=n - i).flat_map(move |j| (0..=n - i - j).map(move |l| [i, j, l])))
    }

    /// Nonzero terms as powers and coefficient.
    pub fn terms(&self) -> impl Iterator<Item = ([usize; 3], f64)> {
        self.powers().map(|ijl| (ijl, self.terms[self.at(ijl)])).filter(|(_, c)| *c != 0.0)
    }

    /// The coefficient of X^i Y^j Z^l.
    pub fn coefficient(&self, ijl: [usize; 3]) -> f64 {
        if ijl.iter().sum::<usize>() > self.degree { 0.0 } else { self.terms[self.at(ijl)] }
    }

    /// Times c_0 + c_1 X + c_2 Y + c_3 Z, without what exceeds the degree.
    fn times_linear(&mut self, c: [f64; 4]) {
        let mut product = Self::zero(self.degree);
        for (ijl, value) in self.terms() {
            let at = product.at(ijl);
            product.terms[at] += c[0] * value;
            if ijl.iter().sum::<usize>() < self.degree {
                for axis in 0..3 {
                    let mut raised = ijl;
                    raised[axis] += 1;
                    let at = product.at(raised);
                    product.terms[at] += c[axis + 1] * value;
                }
            }
        }
        *self = product;
    }

    fn add(&mut self, other: &Self) {
        self.terms.iter_mut().zip(&other.terms).for_each(|(a, b)| *a += b);
    }

    /// A polynomial in x, y, z, where each of these is c_0 + c_1 X + c_2 Y + c_3 Z: Horner's scheme in x, y, z in turn.
    pub fn substituted(terms: &[(Exponents, f64)], forms: &[[f64; 4]; 3]) -> Self {
        let degree = terms.iter().map(|(e, _)| e.iter().sum::<u32>() as usize).max().unwrap_or(0);
        Self::horner(terms, forms, 0, degree)
    }

    fn horner(terms: &[(Exponents, f64)], forms: &[[f64; 4]; 3], axis: usize, degree: usize) -> Self {
        let mut sum = Self::zero(degree);
        if axis == 3 {
            sum.terms[0] = terms.iter().map(|(_, c)| c).sum();
            return sum;
        }
        let highest = terms.iter().map(|(e, _)| e[axis]).max().unwrap_or(0);
        for power in (0..=highest).rev() {
            sum.times_linear(forms[axis]);
            let those: Vec<_> = terms.iter().filter(|(e, _)| e[axis] == power).copied().collect();
            if !those.is_empty() {
                sum.add(&Self::horner(&those, forms, axis + 1, degree));
            }
        }
        sum
    }

    /// F(X, Y, φ(X, Y)) up to a total degree in X and Y.
    pub fn on_graph(&self, graph: &Bivariate, degree: usize) -> Bivariate {
        let mut sum = Bivariate::zero(degree);
        for l in (0..=self.degree).rev() {
            sum = sum.times(graph, degree);
            for i in 0..=self.degree - l {
                for j in 0..=self.degree - l - i {
                    if i + j <= degree {
                        let at = sum.at([i, j]);
                        sum.terms[at] += self.terms[self.at([i, j, l])];
                    }
                }
            }
        }
        sum
    }
}

/// A polynomial in X, Y up to a total degree.
#[derive(Clone, Debug)]
pub(super) struct Bivariate {
    degree: usize,
    terms: Vec<f64>,
}

impl Bivariate {
    /// Nothing yet, with room up to a degree.
    pub fn zero(degree: usize) -> Self {
        Self { degree, terms: vec![0.0; (degree + 1).pow(2)] }
    }

    fn at(&self, [i, j]: [usize; 2]) -> usize {
        i * (self.degree + 1) + j
    }

    /// Nonzero terms as powers and coefficient.
    pub fn terms(&self) -> impl Iterator<Item = ([usize; 2], f64)> {
        let n = self.degree;
        (0..=n)
            .flat_map(move |i| (0..=n - i).map(move |j| [i, j]))
            .map(|ij| (ij, self.terms[self.at(ij)]))
            .filter(|(_, c)| *c != 0.0)
    }

    fn times(&self, other: &Self, degree: usize) -> Self {
        let mut product = Self::zero(degree);
        for (a, x) in self.terms() {
            for (b, y) in other.terms().filter(|(b, _)| a[0] + a[1] + b[0] + b[1] <= degree) {
                let at = product.at([a[0] + b[0], a[1] + b[1]]);
                product.terms[at] += x * y;
            }
        }
        product
    }

    /// Adds to the coefficient of X^i Y^j.
    pub fn add(&mut self, ij: [usize; 2], value: f64) {
        let at = self.at(ij);
        self.terms[at] += value;
    }

    /// The coefficient of X^i Y^j.
    pub fn coefficient(&self, ij: [usize; 2]) -> f64 {
        if ij[0] + ij[1] > self.degree { 0.0 } else { self.terms[self.at(ij)] }
    }

    /// The value at (X, Y).
    pub fn value(&self, [x, y]: [f64; 2]) -> f64 {
        self.terms().map(|([i, j], c)| c * x.powi(i as i32) * y.powi(j as i32)).sum()
    }

    /// A bound of its size on the disc X² + Y² ≤ r².
    pub fn bound(&self, r: f64) -> f64 {
        self.terms().map(|([i, j], c)| c.abs() * on_circle(i, j) * r.powi((i + j) as i32)).sum()
    }
}

/// The largest |X^i Y^j| on the unit circle, where X² : Y² = i : j.
pub(super) fn on_circle(i: usize, j: usize) -> f64 {
    let (a, b) = (i as f64, j as f64);
    let power = |part: f64| if part == 0.0 { 1.0 } else { (part / (a + b)).powf(part / 2.0) };
    power(a) * power(b)
}
