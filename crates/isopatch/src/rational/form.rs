//! Products of polynomials over a triangle in Bernstein form.

use crate::bernstein::curve::binomial;
use crate::bernstein::index;
use std::ops::{AddAssign, Mul};

/// A polynomial of some degree: its coefficients in the order of [`crate::bernstein`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Form<T> {
    pub degree: usize,
    pub coefficients: Vec<T>,
}

/// n! / (i! j! k!).
fn multinomial([i, j, k]: [usize; 3]) -> f64 {
    binomial(i + j + k, i) * binomial(j + k, j)
}

impl<T: Copy + Mul<f64, Output = T> + AddAssign> Form<T> {
    pub fn new(degree: usize, coefficients: Vec<T>) -> Self {
        Self { degree, coefficients }
    }

    /// The product with a scalar polynomial. Coefficients that are zero stay exactly so.
    pub fn times(&self, factor: &Form<f64>, zero: T) -> Self {
        let degree = self.degree + factor.degree;
        let mut product = vec![zero; index::count(degree)];
        for (a, x) in index::indices(self.degree).zip(&self.coefficients) {
            for (b, y) in index::indices(factor.degree).zip(&factor.coefficients).filter(|(_, y)| **y != 0.0)
            {
                let sum = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
                product[index::position(sum)] += *x * (y * multinomial(a) * multinomial(b));
            }
        }
        for (ijk, c) in index::indices(degree).zip(&mut product) {
            *c = *c * (1.0 / multinomial(ijk));
        }
        Self { degree, coefficients: product }
    }

    /// The same polynomial in a degree that is higher by `by`.
    pub fn raised(&self, by: usize, zero: T) -> Self {
        let one = Form::new(1, vec![1.0; 3]);
        (0..by).fold(self.clone(), |form, _| form.times(&one, zero))
    }

    /// The sum of two polynomials of the same degree.
    pub fn plus(mut self, other: &Self) -> Self {
        self.coefficients.iter_mut().zip(&other.coefficients).for_each(|(a, b)| *a += *b);
        self
    }
}

impl Form<f64> {
    /// x l₀ + y l₁ + z l₂.
    pub fn linear(coefficients: [f64; 3]) -> Self {
        Self::new(1, coefficients.to_vec())
    }
}
