//! When a number that floats make small counts as zero.

use super::unit::UnitPolynomial;
use crate::geom::Point3;

/// |f| over the sum of the absolute values of its coefficients in unit coordinates, below which a critical point counts
/// as lying on the surface if exact algebra has no answer. A few hundred units of rounding.
pub(super) const TAU: f64 = 1e-13;

/// |∇f| in the same unit.
const GRADIENT: f64 = 1e-12;

/// Do f and ∇f vanish at a point, within the tolerance? The coefficients are bounded by 1.
pub(super) fn is_singular(f: &UnitPolynomial, p: Point3) -> bool {
    let (value, gradient) = f.gradient(p);
    let size = f.magnitude();
    value.abs() <= TAU * size && gradient.norm() <= GRADIENT * size * f.degree() as f64
}
