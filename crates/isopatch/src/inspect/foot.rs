//! The closest point of a field's zero set to a point near it.

use crate::field::Field;
use crate::geom::{Mat3, Point3, Points};

/// Rounds of the batched iteration. Its error shrinks by |distance · curvature| a round, which is below 1e-2 for
/// a surface that fits at all; the rest goes to [`closest_zero`] one by one.
const ROUNDS: usize = 4;
/// A foot is accepted when the last step is below this part of the distance; the distance is stationary along the
/// surface, so its own error is of the order of the square.
const STEP_TOLERANCE: f64 = 1e-4;
/// Steps below this part of the diagonal are rounding.
const ROUNDING_STEP: f64 = 1e-14;
/// Limits of the search for one point: they end a search that does not converge, and are never reached by one that
/// converges quadratically.
const MAX_LANDING_STEPS: usize = 40;
const MAX_SLIDES: usize = 40;
const MAX_HALVINGS: usize = 12;

/// Distances of many points to the zero set, from f and ∇f at the points.
///
/// Each round projects the point onto the linearised surface at the last foot,
/// q' = p − (f(q) + ∇f(q)·(p − q)) ∇f(q) / |∇f(q)|², whose fixed points are the points of the zero set
/// with p − q parallel to ∇f(q): the stationary points of the distance, not only a first-order estimate.
/// Infinite where no point of the zero set was found.
pub(super) fn distances(
    field: &dyn Field,
    points: &Points,
    f: &[f64],
    gradient: &Points,
    diagonal: f64,
) -> Vec<f64> {
    let step = |p: &Point3, q: &Point3, f: f64, g: Point3| p - (f + g.dot(&(p - q))) / g.norm_squared() * g;
    let first = |i: usize| {
        let p = points.get(i);
        step(&p, &p, f[i], gradient.get(i))
    };
    let mut distances = vec![f64::INFINITY; points.len()];
    // Those that have not settled, and their feet.
    let mut open: Vec<usize> = (0..points.len()).collect();
    let mut feet: Points = open.iter().map(|i| first(*i)).collect();
    let (mut f, mut gradient) = (vec![0.0; open.len()], Points::zeros(open.len()));
    for _ in 0..ROUNDS {
        let count = open.len();
        field.gradients(feet.view(), &mut f[..count], gradient.slice_mut(0..count));
        let mut left = 0;
        for k in 0..count {
            let (i, p, q) = (open[k], points.get(open[k]), feet.get(k));
            let next = step(&p, &q, f[k], gradient.get(k));
            if (next - q).norm() <= tolerance(&p, &next, diagonal) {
                distances[i] = (next - p).norm();
            } else {
                open[left] = i;
                feet.set(left, next);
                left += 1;
            }
        }
        open.truncate(left);
        feet.truncate(left);
        if open.is_empty() {
            break;
        }
    }
    for i in open {
        let p = points.get(i);
        distances[i] = closest_zero(field, p, diagonal).map_or(f64::INFINITY, |q| (q - p).norm());
    }
    distances
}

/// Length of a step from which on the foot `q` of `p` counts as found.
fn tolerance(p: &Point3, q: &Point3, diagonal: f64) -> f64 {
    let rounding = (ROUNDING_STEP * diagonal).max(4.0 * f64::EPSILON * p.amax());
    STEP_TOLERANCE * (p - q).norm() + rounding
}

/// A point of the zero set whose distance to `p` is locally the smallest; none if no point of the zero set is found.
///
/// Lands on the zero set by damped Newton steps along the gradient, then slides along it: with tangential offset τ
/// and normal offset d of p, the Newton step of the distance is t = (I − d M)⁻¹ τ, M the curvature tensor. A
/// slide is taken only if it brings the foot closer, so the result is never farther than the first landing.
pub fn closest_zero(field: &dyn Field, p: Point3, diagonal: f64) -> Option<Point3> {
    let mut q = land(field, p, diagonal)?;
    for _ in 0..MAX_SLIDES {
        let jet = field.jet(q);
        let n = jet.gradient.normalize();
        let d = (p - q).dot(&n);
        let tangential = p - q - d * n;
        if tangential.norm() <= tolerance(&p, &q, diagonal) {
            break;
        }
        let newton = (Mat3::identity() - d * jet.curvature_tensor()).cholesky().map(|a| a.solve(&tangential));
        let mut slide = newton.unwrap_or(tangential);
        let closer = (0..MAX_HALVINGS).find_map(|_| {
            let next = land(field, q + slide, diagonal).filter(|next| (next - p).norm() < (q - p).norm());
            slide *= 0.5;
            next
        });
        match closer {
            Some(next) => q = next,
            None => break,
        }
    }
    Some(q)
}

/// A point of the zero set near `q`.
fn land(field: &dyn Field, mut q: Point3, diagonal: f64) -> Option<Point3> {
    let (mut f, mut g) = field.gradient(q);
    for _ in 0..MAX_LANDING_STEPS {
        let mut step = -f / g.norm_squared() * g;
        let length = step.norm();
        if !length.is_finite() {
            return None;
        }
        if length <= tolerance(&q, &q, diagonal) {
            return Some(q + step);
        }
        let reached = (0..MAX_HALVINGS).find_map(|_| {
            let next = q + step;
            let (value, gradient) = field.gradient(next);
            step *= 0.5;
            (value.abs() < f.abs()).then_some((next, value, gradient))
        });
        let Some(reached) = reached else {
            // |f| no longer falls: at its rounding error, or at a minimum of |f| that is not a zero.
            return (f.abs() <= field.rounding_bound(q)).then_some(q);
        };
        (q, f, g) = reached;
    }
    None
}
