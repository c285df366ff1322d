//! Points of the surface where the gradient vanishes, looked for near given points.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::jets::of_jets;
use crate::field::Field;
use crate::geom::{Aabb, Jet, Mat3, Point3};

/// Largest number of points from which a search starts.
const STARTS: usize = 256;

/// Steps of one search: twenty would do for a simple singular point; the rest serves degenerate ones, where every step
/// only halves the distance.
const STEPS: usize = 80;

/// |∇f| over its typical size at which a point counts as critical. Newton's method for ∇f = 0 gains half of the digits
/// at least wherever it converges.
const CRITICAL: f64 = 1e-7;

/// |f| over (typical |∇f| · diagonal) at which a critical point counts as lying on the surface: above rounding, far below
/// any detail of a surface that f64 can resolve.
const ON_SURFACE: f64 = 1e-12;

/// A singular point near the given points of the surface, if there is one within `reach` of any of them.
///
/// Starts from the points at which ∇f would vanish soonest, |∇f|/|∇²f| ≤ `reach`, and solves ∇f = 0 by damped
/// Gauss–Newton steps. A numerical search: it may miss singular points, but what it finds is one to rounding.
pub fn find_singular(field: &dyn Field, points: &[Point3], reach: f64) -> Option<Point3> {
    let diagonal = Aabb::around(points).diagonal();
    let jets: Vec<Jet> = of_jets(field, points, Clone::clone);
    let typical = median(jets.iter().map(|j| j.gradient.norm()).collect());
    let mut starts: Vec<(f64, usize)> = jets
        .iter()
        .enumerate()
        .map(|(i, j)| (j.gradient.norm() / j.hessian.norm(), i))
        .filter(|(distance, _)| *distance <= reach)
        .collect();
    starts.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    starts.truncate(STARTS);
    starts
        .par_iter()
        .evenly()
        .find_map_first(|(_, i)| singular_near(field, points[*i], reach, typical, diagonal))
}

/// A singular point within a few times `reach` of `start`, if the search from there finds one. `typical` is the usual
/// |∇f| on the surface, `diagonal` the size of the surface.
pub(super) fn singular_near(
    field: &dyn Field,
    start: Point3,
    reach: f64,
    typical: f64,
    diagonal: f64,
) -> Option<Point3> {
    let p = critical_point(field, start, reach)?;
    let (f, gradient) = field.gradient(p);
    let singular = gradient.norm() <= CRITICAL * typical && f.abs() <= ON_SURFACE * typical * diagonal;
    singular.then_some(p)
}

/// Minimises |∇f|² from `start` by Levenberg–Marquardt steps; none if that leads farther away than a few times `reach`.
fn critical_point(field: &dyn Field, start: Point3, reach: f64) -> Option<Point3> {
    const FARTHEST: f64 = 4.0;
    let mut p = start;
    let mut jet = field.jet(p);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let h = jet.hessian;
        let scale = h.norm_squared();
        let normal_matrix = h * h + damping * scale * Mat3::identity();
        let step = normal_matrix.cholesky()?.solve(&(h * jet.gradient));
        let trial = p - step;
        let trial_jet = field.jet(trial);
        if trial_jet.gradient.norm() < jet.gradient.norm() {
            (p, jet) = (trial, trial_jet);
            damping = (0.1 * damping).max(f64::EPSILON);
        } else {
            damping *= 10.0;
        }
        if (p - start).norm() > FARTHEST * reach || jet.gradient.norm() == 0.0 || damping > 1e6 {
            break;
        }
    }
    ((p - start).norm() <= FARTHEST * reach).then_some(p)
}

/// The middle one of the values; zero if there is none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
