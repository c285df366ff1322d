//! Coefficients that depend on unknowns: a value, and how it changes with each of them.

use nalgebra::DVector;
use std::ops::{Add, Mul};

/// value + slope · x.
#[derive(Clone, Debug)]
pub(super) struct Affine {
    pub value: f64,
    pub slope: DVector<f64>,
}

impl Affine {
    /// The same for all x, of which there are `unknowns`.
    pub fn constant(value: f64, unknowns: usize) -> Self {
        Self { value, slope: DVector::zeros(unknowns) }
    }

    /// Σ weight · form.
    pub fn sum<const N: usize>(weights: [f64; N], forms: [&Self; N]) -> Self {
        let unknowns = forms.first().map_or(0, |form| form.slope.len());
        let zero = Self::constant(0.0, unknowns);
        weights.into_iter().zip(forms).fold(zero, |sum, (w, form)| &sum + &(w * form))
    }
}

impl Add for &Affine {
    type Output = Affine;
    fn add(self, other: Self) -> Affine {
        Affine { value: self.value + other.value, slope: &self.slope + &other.slope }
    }
}

impl Mul<&Affine> for f64 {
    type Output = Affine;
    fn mul(self, form: &Affine) -> Affine {
        Affine { value: self * form.value, slope: self * &form.slope }
    }
}
