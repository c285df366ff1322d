//! What a formula is made of: numbers, numbers with a gradient, or a peer's own expressions.

use std::ops::{Add, Mul, Sub};

/// A number that formulas can be evaluated with.
pub trait Number: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// A constant.
    fn constant(value: f64) -> Self;
    /// Its square.
    fn square(&self) -> Self;
    /// Its square root.
    fn sqrt(&self) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }
    fn square(&self) -> Self {
        self * self
    }
    fn sqrt(&self) -> Self {
        f64::sqrt(*self)
    }
}

/// A value with its gradient.
#[derive(Clone, Copy, Debug)]
pub struct Gradient {
    /// f.
    pub value: f64,
    /// ∇f.
    pub slope: [f64; 3],
}

impl Gradient {
    /// Coordinate `axis` of a point, where it is `value`.
    pub fn coordinate(value: f64, axis: usize) -> Self {
        Self { value, slope: std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 }) }
    }

    /// g(f), where g is `value` and g' is `derivative` at f.
    fn chain(&self, value: f64, derivative: f64) -> Self {
        Self { value, slope: self.slope.map(|s| derivative * s) }
    }

    fn both(self, other: Self, value: f64, [a, b]: [f64; 2]) -> Self {
        Self { value, slope: std::array::from_fn(|i| a * self.slope[i] + b * other.slope[i]) }
    }
}

impl Add for Gradient {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.both(other, self.value + other.value, [1.0, 1.0])
    }
}

impl Sub for Gradient {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.both(other, self.value - other.value, [1.0, -1.0])
    }
}

impl Mul for Gradient {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.both(other, self.value * other.value, [other.value, self.value])
    }
}

impl Number for Gradient {
    fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; 3] }
    }
    fn square(&self) -> Self {
        self.chain(self.value * self.value, 2.0 * self.value)
    }
    fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
}
