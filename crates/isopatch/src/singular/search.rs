//! From a formula to its singular set.

use super::SingularError;
use super::components::Components;
use super::find::find;
use super::set::SingularSet;
use super::square_free::square_free;
use super::unit::UnitPolynomial;
use crate::field::{Formula, QuadraticPolynomial};
use crate::geom::{Aabb, Point3};

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

/// What is known about a surface in a box.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Where it is singular.
    pub singular: SingularSet,
    /// Its connected parts, of every dimension; none if they are too many or too fine to be counted.
    pub components: Option<Components>,
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
    let (reduced, unit) = prepared(formula, bounds, options)?;
    find(&reduced, &unit, bounds)
}

/// The singular set and the connected components of the real surface f = 0 in a closed box.
pub fn analyse(
    formula: &Formula,
    bounds: &Aabb,
    options: &SingularOptions,
) -> Result<Analysis, SingularError> {
    let (reduced, unit) = prepared(formula, bounds, options)?;
    let singular = find(&reduced, &unit, bounds)?;
    let components = connected(&unit, &singular);
    Ok(Analysis { singular, components })
}

/// The connected components of the real surface f = 0 in a closed box whose singular set there is known; none if they
/// are too many or too fine to be counted.
pub fn components(
    formula: &Formula,
    bounds: &Aabb,
    singular: &SingularSet,
    options: &SingularOptions,
) -> Result<Option<Components>, SingularError> {
    let (_, unit) = prepared(formula, bounds, options)?;
    Ok(connected(&unit, singular))
}

fn connected(unit: &UnitPolynomial, singular: &SingularSet) -> Option<Components> {
    let samples = singular.curves.iter().flat_map(|curve| &curve.samples).map(|s| s.at);
    let places = singular.points.iter().map(|p| p.at).chain(singular.special.iter().map(|s| s.at));
    let places: Vec<Point3> = places.chain(samples).map(|p| (p - unit.center) / unit.scale).collect();
    super::components::components(unit, &places)
}

/// f without repeated factors, exact and in unit coordinates.
fn prepared(
    formula: &Formula,
    bounds: &Aabb,
    options: &SingularOptions,
) -> Result<(QuadraticPolynomial, UnitPolynomial), SingularError> {
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
    let unit = UnitPolynomial::new(&reduced, bounds);
    Ok((reduced, unit))
}
