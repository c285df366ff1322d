//! Scalar functions of space: what an implicit surface is the zero set of.
//!
//! A [`Formula`] goes through four forms, one file each: text → tokens → an expression with exact
//! constants, as typed, from which polynomials and diagnoses are made → a graph of operations on floats, each once,
//! and the graphs of its derivatives → tapes, which are evaluated with floats in blocks or at a point, with
//! intervals, and with running error bounds.

mod constants;
mod diagnose;
mod error;
mod exact;
mod expression;
mod formula;
mod graph;
mod lower;
mod number;
mod parse;
mod polynomial;
mod quadratic;
mod tape;
mod token;

#[cfg(test)]
pub(crate) mod conformance;
#[cfg(test)]
mod tests;

pub use constants::{ConstantError, Constants};
pub use diagnose::{DomainError, DomainErrorKind, Kink};
pub use error::{FormulaError, FormulaErrorKind};
pub use formula::Formula;
pub use polynomial::{Exponents, Polynomial};
pub use quadratic::QuadraticPolynomial;
pub use token::Span;

use crate::geom::{Aabb, Affine, Interval, Jet, Jets, Point3, PointsMut, PointsView, Vec3};

/// A scalar function f(x, y, z); its surface is f = 0, inside is f < 0, and ∇f points out.
///
/// Batch forms take one array per coordinate, or cells; all slices of one call have the same length. They have defaults
/// that call the pointwise forms, and give the same values as these, bit for bit.
pub trait Field: Send + Sync {
    /// f(p). NaN or infinite outside the domain of the formula.
    fn value(&self, p: Point3) -> f64;

    /// f(p) and ∇f(p).
    fn gradient(&self, p: Point3) -> (f64, Vec3);

    /// f, ∇f and ∇²f at p.
    fn jet(&self, p: Point3) -> Jet;

    /// An interval that holds f(p) for every p of the cell, rounded outward; infinite where nothing is known.
    fn range(&self, cell: &Aabb) -> Interval;

    /// Enclosures of f and of the three components of ∇f over the cell, rounded outward.
    fn gradient_range(&self, cell: &Aabb) -> (Interval, [Interval; 3]);

    /// f over the cell as a linear function and a bound on the rest, rounded outward.
    fn linear_range(&self, cell: &Aabb) -> Affine {
        self.range(cell).into()
    }

    /// f and the three components of ∇f over the cell as linear functions and bounds on the rest, rounded outward.
    fn linear_gradient_range(&self, cell: &Aabb) -> (Affine, [Affine; 3]) {
        let (f, gradient) = self.gradient_range(cell);
        (f.into(), gradient.map(Affine::from))
    }

    /// A bound on the difference between the computed and the exact f(p), from rounding alone.
    fn rounding_bound(&self, p: Point3) -> f64;

    /// f at every point.
    fn values(&self, points: PointsView<'_>, f: &mut [f64]) {
        for (i, f) in f.iter_mut().enumerate() {
            *f = self.value(points.get(i));
        }
    }

    /// f and ∇f at every point.
    fn gradients(&self, points: PointsView<'_>, f: &mut [f64], gradient: PointsMut<'_>) {
        for (i, f) in f.iter_mut().enumerate() {
            let (value, g) = self.gradient(points.get(i));
            *f = value;
            (gradient.x[i], gradient.y[i], gradient.z[i]) = (g.x, g.y, g.z);
        }
    }

    /// f, ∇f and ∇²f at every point; as many jets as points.
    fn jets(&self, points: PointsView<'_>, jets: &mut Jets) {
        for i in 0..points.len() {
            jets.set(i, &self.jet(points.get(i)));
        }
    }

    /// [`Field::range`] of every cell.
    fn ranges(&self, cells: &[Aabb], ranges: &mut [Interval]) {
        for (range, cell) in ranges.iter_mut().zip(cells) {
            *range = self.range(cell);
        }
    }
}
