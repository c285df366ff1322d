//! Isolated singular points: what they are, how exactly they are known, and whether they are on the surface at all.

use super::cell::{Cell, Critical};
use super::multiplicity::multiplicity;
use super::precise::critical_point;
use super::recognize::{is_singular_at, polish, recognize, recognize_place, recognize_rational};
use super::set::{PointKind, SingularPoint, Status};
use super::tolerance::is_singular;
use super::unit::UnitPolynomial;
use crate::field::{Polynomial, QuadraticPolynomial};
use crate::geom::{Aabb, Mat3, Point3};
use num_rational::BigRational;
use num_traits::ToPrimitive;

/// Side of the boxes around simple critical points in which they are enclosed, in unit coordinates: small for the Hessian
/// to be almost constant, large against rounding.
const ENCLOSURE: f64 = 1e-6;
/// Newton steps from inside a box in which the root is certain.
const STEPS: usize = 30;
/// A singular point this close to a side of the box, in unit coordinates, is taken to be on it, where its coordinates are
/// not known exactly.
pub(super) const ON_SIDE: f64 = 1e-12;
/// How far from the centre of a box that has shrunk no more its point is looked for, in radii of the box.
const REACH: f64 = 16.0;
/// Eigenvalues of a Hessian below this part of the largest count as 0.
const FLAT: f64 = 1e-7;

/// The two forms of a polynomial.
pub(super) struct Algebraic<'a> {
    /// In model coordinates, exact.
    pub exact: &'a QuadraticPolynomial,
    /// In unit coordinates.
    pub unit: &'a UnitPolynomial,
    /// The box in model coordinates.
    pub bounds: &'a Aabb,
}

impl Algebraic<'_> {
    /// The singular point that is the only critical point in a box of unit coordinates, if f vanishes there and it is in
    /// the closed box.
    pub fn simple_point(&self, alone: &Aabb) -> Option<SingularPoint> {
        let start = self.newton(alone.center());
        // Newton's method may have left the box, where its start was a rough one.
        let start = if alone.grown(ENCLOSURE).contains(&start) { start } else { alone.center() };
        let enclosure = self.enclose(start).unwrap_or(*alone);
        let at = enclosure.center();
        let radius = 0.5 * enclosure.diagonal();
        if !self.may_vanish(at, radius) {
            return None;
        }
        let algebraic = polish(self.unit, at)
            .and_then(|digits| recognize(self.exact, &digits))
            .filter(|point| point.is_singular_on(self.exact));
        let exact = algebraic.as_ref().and_then(|point| point.rational());
        self.is_inside(at, radius, exact.as_ref()).then(|| SingularPoint {
            at: exact.as_ref().map_or(self.unit.model(at), nearest),
            kind: kind(&self.unit.taylor(at).hessian()),
            multiplicity: Some(1),
            radius: if exact.is_some() { 0.0 } else { self.unit.scale * radius },
            status: if algebraic.is_some() { Status::Exact } else { Status::Numerical },
        })
    }

    /// The singular point at which boxes have shrunk to rounding, if it is in the closed box. The multiplicity is known
    /// where the point is rational, and so are f and √d.
    pub fn degenerate_point(&self, at: Point3, radius: f64) -> Option<SingularPoint> {
        let mut exact = self.exact_place(at, radius);
        let (mut at, mut radius, mut proven) = (at, radius, exact.is_some());
        if exact.is_none() {
            match critical_point(self.unit, at, REACH * radius.max(ON_SIDE)) {
                Some(limit) if !limit.is_singular => return None,
                Some(limit) => {
                    at = limit.nearest();
                    radius = f64::EPSILON;
                    let point = recognize_place(self.exact, &limit.model(self.unit), limit.digits);
                    proven = point.is_some();
                    exact = point.and_then(|p| p.rational());
                }
                None if !is_singular(self.unit, at) => return None,
                None => {}
            }
        }
        self.is_inside(at, radius, exact.as_ref()).then(|| SingularPoint {
            at: exact.as_ref().map_or(self.unit.model(at), nearest),
            kind: exact
                .as_ref()
                .map_or_else(|| kind(&self.unit.taylor(at).hessian()), |p| self.exact_kind(p)),
            multiplicity: exact
                .as_ref()
                .filter(|_| self.exact.radicand == 1)
                .and_then(|p| multiplicity(&self.exact.rational, p)),
            radius: if exact.is_some() { 0.0 } else { self.unit.scale * radius },
            status: if proven { Status::Exact } else { Status::Numerical },
        })
    }

    /// The rational singular point near a point of unit coordinates, if there is one with small denominators.
    pub fn exact_place(&self, at: Point3, radius: f64) -> Option<[BigRational; 3]> {
        /// Rounding of model coordinates, relative to their size.
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        let p = self.unit.model(at);
        let tolerance = self.unit.scale * (radius + ROUNDING) + ROUNDING * p.amax();
        let guess = recognize_rational(p, tolerance);
        is_singular_at(self.exact, &guess).then_some(guess)
    }

    /// What the surface is at a rational point, from the exact Hessian.
    fn exact_kind(&self, p: &[BigRational; 3]) -> PointKind {
        let root = (self.exact.radicand as f64).sqrt();
        let entry = |a: usize, b: usize| {
            let part = |q: &Polynomial| q.derivative(a).derivative(b).value(p).to_f64().unwrap_or(f64::NAN);
            part(&self.exact.rational) + root * part(&self.exact.irrational)
        };
        kind(&Mat3::from_fn(entry))
    }

    /// Is the point in the closed box? Exactly where its coordinates are known, else to its radius and [`ON_SIDE`].
    fn is_inside(&self, at: Point3, radius: f64, exact: Option<&[BigRational; 3]>) -> bool {
        match exact {
            Some(p) => (0..3).all(|a| {
                let side = |value: f64| BigRational::from_float(value);
                side(self.bounds.min[a]).is_some_and(|s| s <= p[a])
                    && side(self.bounds.max[a]).is_some_and(|s| s >= p[a])
            }),
            None => self.unit.bounds.grown(radius + ON_SIDE).contains(&at),
        }
    }

    fn newton(&self, start: Point3) -> Point3 {
        let mut at = start;
        for _ in 0..STEPS {
            let taylor = self.unit.taylor(at);
            let Some(step) = taylor.hessian().lu().solve(&taylor.gradient()) else { break };
            at -= step;
            if step.norm() <= f64::EPSILON {
                break;
            }
        }
        at
    }

    /// A tiny box with exactly one critical point, around a numerical one.
    fn enclose(&self, at: Point3) -> Option<Aabb> {
        let around = |half: f64| Aabb::new(at, at).grown(half);
        let enclosed = |bounds| match Cell::new(self.unit, bounds).critical() {
            Critical::One(inner) => Some(inner),
            Critical::None | Critical::Unknown => None,
        };
        let first = enclosed(around(ENCLOSURE))?;
        // Once more: the enclosure shrinks with the square of the box.
        let tight = first.grown(first.size().max() + 16.0 * f64::EPSILON);
        Some(enclosed(tight).unwrap_or(first))
    }

    /// May f be zero at the critical point within `radius` of `at`? Certain where the answer is no: f changes by at most
    /// |∇f| r + |∇²f| r²/2 there, and is computed exactly.
    fn may_vanish(&self, at: Point3, radius: f64) -> bool {
        let (value, error) = self.unit.exact_derivative(at, [0; 3]);
        let taylor = self.unit.taylor(at);
        // The Hessian is bounded by its norm here and the growth over the tiny radius; the factor 2 covers both.
        let change = 2.0 * (taylor.gradient().norm() * radius + taylor.hessian().norm() * radius * radius);
        value.abs() <= change + error
    }
}

/// A rational point as floats.
pub(super) fn nearest(p: &[BigRational; 3]) -> Point3 {
    Point3::from_fn(|a, _| p[a].to_f64().unwrap_or(f64::NAN))
}

/// What a Hessian says about a singular point.
pub(super) fn kind(hessian: &Mat3) -> PointKind {
    let eigenvalues = hessian.symmetric_eigenvalues();
    let largest = eigenvalues.amax();
    if eigenvalues.iter().any(|e| e.abs() <= FLAT * largest) {
        PointKind::Degenerate
    } else if eigenvalues.iter().all(|e| *e > 0.0) || eigenvalues.iter().all(|e| *e < 0.0) {
        PointKind::Isolated
    } else {
        PointKind::Node
    }
}
