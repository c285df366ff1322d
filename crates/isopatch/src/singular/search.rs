//! From a formula to its singular set.

use super::SingularError;
use super::find::find;
use super::set::SingularSet;
use super::square_free::square_free;
use super::unit::UnitPolynomial;
use crate::field::Formula;
use crate::geom::Aabb;

/// How the search is done.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularOptions {
    /// Largest total degree that is tried.
    pub largest_degree: u32,
}

impl Default for SingularOptions {
    /// Degree 16: subdivision takes seconds a thousand boxes beyond that.
    fn default() -> Self {
        Self { largest_degree: 16 }
    }
}

/// The singular set of the surface f = 0 in a closed box.
///
/// f is a polynomial with rational coefficients, which may hold one square root; repeated factors are divided out. Outside
/// of what is listed there is no singular point in the box, to the resolution of the subdivision: a box is dropped only if
/// f or a combination of derivatives has a sign in it, rounding included.
pub fn singular_set(
    formula: &Formula,
    bounds: &Aabb,
    options: &SingularOptions,
) -> Result<SingularSet, SingularError> {
    let size = bounds.size();
    if !size.iter().all(|s| s.is_finite() && *s > 0.0) {
        return Err(SingularError::Box);
    }
    let polynomial = formula.quadratic_polynomial().ok_or(SingularError::NotPolynomial)?;
    let (degree, limit) = (polynomial.degree(), options.largest_degree);
    if degree == 0 {
        return Err(SingularError::Constant);
    }
    if degree > limit {
        return Err(SingularError::Degree { degree, limit });
    }
    let reduced = square_free(&polynomial)?;
    find(&reduced, &UnitPolynomial::new(&reduced, bounds), bounds)
}
