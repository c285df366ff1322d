//! Points onto the surface: damped Newton iteration along the gradient.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::clip::BoxSides;
use crate::field::Field;
use crate::geom::{Point3, Points, PointsMut, Vec3};

/// Settings of [`project_points`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectOptions {
    /// A point has arrived when its Newton step is shorter than this share of the diagonal. Default 1e-13, some
    /// hundred units in the last place of coordinates as large as the diagonal.
    pub tolerance: f64,
    /// Longest step, as a share of the diagonal. Default 0.1: farther away f is no longer nearly linear.
    pub longest_step: f64,
    /// Largest number of field evaluations for a point. Default 60: three to five are usual.
    pub evaluations: usize,
}

impl Default for ProjectOptions {
    fn default() -> Self {
        Self { tolerance: 1e-13, longest_step: 0.1, evaluations: 60 }
    }
}

/// What became of the points of [`project_points`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Projection {
    /// Points that did not arrive (ascending): the gradient vanishes, f is undefined, or progress stopped. They are left
    /// where |f| was smallest.
    pub failures: Vec<usize>,
    /// Evaluations of f and ∇f, all points together.
    pub evaluations: usize,
}

/// Points that one task works on; the result does not depend on it, only the speed (batches that fit the cache).
const CHUNK: usize = 64;

/// Moves every point onto the surface f = 0 along the gradient: p ← p − f ∇f / |∇f|², Tong & Kim 2009, eq. (4).
///
/// A step that does not make |f| smaller is halved. A point has arrived when a step shorter than
/// `options.tolerance`·`diagonal`, or than the spacing of floats there, was taken, or when |f| is within the field's
/// rounding bound. Points are independent of each
/// other: the result is the same whatever the number of threads.
pub fn project_points(
    field: &dyn Field,
    points: &mut Points,
    diagonal: f64,
    options: &ProjectOptions,
) -> Projection {
    let mut positions: Vec<Point3> = (0..points.len()).map(|i| points.get(i)).collect();
    let report = project_positions(field, &mut positions, &[], diagonal, options);
    positions.into_iter().enumerate().for_each(|(i, p)| points.set(i, p));
    report
}

/// [`project_points`] with the points kept in the sides of a box that are listed for them (for none of them, if the list
/// is empty): along the part of the gradient within the side or along the edge. Their coordinates do not change there.
pub(super) fn project_positions(
    field: &dyn Field,
    positions: &mut [Point3],
    sides: &[BoxSides],
    diagonal: f64,
    options: &ProjectOptions,
) -> Projection {
    let sides_of = |chunk: usize| sides.get(chunk * CHUNK..).unwrap_or_default();
    let project =
        |(i, chunk): (usize, &mut [Point3])| project_chunk(field, chunk, sides_of(i), diagonal, options);
    let chunks: Vec<Projection> = positions.par_chunks_mut(CHUNK).enumerate().evenly().map(project).collect();
    let mut all = Projection::default();
    for (i, chunk) in chunks.into_iter().enumerate() {
        all.failures.extend(chunk.failures.into_iter().map(|j| i * CHUNK + j));
        all.evaluations += chunk.evaluations;
    }
    all
}

/// Where the iteration of one point stands.
#[derive(Clone, Copy)]
struct Walker {
    /// Which point of the chunk.
    point: usize,
    /// Best point so far, and |f| there.
    best: Point3,
    residual: f64,
    /// Length of the whole Newton step from there.
    newton: f64,
    /// Step on trial from `best`.
    step: Vec3,
}

impl Walker {
    fn new(point: usize, start: Point3) -> Self {
        let far = f64::INFINITY;
        Self { point, best: start, residual: far, newton: far, step: Vec3::zeros() }
    }
}

/// [`project_points`] of one point, within the sides of a box; none if it does not arrive.
pub(super) fn project_point(
    field: &dyn Field,
    start: Point3,
    sides: BoxSides,
    diagonal: f64,
    options: &ProjectOptions,
) -> Option<Point3> {
    if sides.len() == 3 {
        return Some(start);
    }
    let mut walker = Walker::new(0, start);
    for _ in 0..options.evaluations {
        let trial = walker.best + walker.step;
        let (f, gradient) = field.gradient(trial);
        match advance(field, &mut walker, trial, f, sides.within(gradient), diagonal, options) {
            Progress::Arrived => return Some(walker.best),
            Progress::Stuck => return None,
            Progress::Walking => {}
        }
    }
    None
}

/// [`project_positions`] of so many that they fit into the cache, by one thread.
pub(super) fn project_chunk(
    field: &dyn Field,
    positions: &mut [Point3],
    sides: &[BoxSides],
    diagonal: f64,
    options: &ProjectOptions,
) -> Projection {
    let n = positions.len();
    // A corner of the box cannot move.
    let can_move = |i: &usize| sides.get(*i).is_none_or(|s| s.len() < 3);
    let mut walkers = Vec::with_capacity(n);
    walkers.extend((0..n).filter(can_move).map(|i| Walker::new(i, positions[i])));
    let (mut trial, mut gradient, mut f) = (Points::zeros(n), Points::zeros(n), vec![0.0; n]);
    let mut report = Projection::default();
    for _ in 0..options.evaluations {
        let active = walkers.len();
        if active == 0 {
            break;
        }
        for (i, w) in walkers.iter().enumerate() {
            trial.set(i, w.best + w.step);
        }
        let g = gradient.view_mut();
        let g = PointsMut { x: &mut g.x[..active], y: &mut g.y[..active], z: &mut g.z[..active] };
        field.gradients(trial.view().slice(0..active), &mut f[..active], g);
        report.evaluations += active;
        let mut kept = 0;
        for i in 0..active {
            let mut w = walkers[i];
            let gradient = sides.get(w.point).map_or(gradient.get(i), |s| s.within(gradient.get(i)));
            match advance(field, &mut w, trial.get(i), f[i], gradient, diagonal, options) {
                Progress::Arrived => positions[w.point] = w.best,
                Progress::Stuck => {
                    positions[w.point] = w.best;
                    report.failures.push(w.point);
                }
                Progress::Walking => {
                    walkers[kept] = w;
                    kept += 1;
                }
            }
        }
        walkers.truncate(kept);
    }
    for w in walkers {
        positions[w.point] = w.best;
        report.failures.push(w.point);
    }
    report.failures.sort_unstable();
    report
}

enum Progress {
    Walking,
    Arrived,
    Stuck,
}

/// Steps shorter than this share of the diagonal may be rounding alone: then the rounding bound is looked at. It costs
/// about as much as an evaluation, so not before.
const NEAR: f64 = 1e-9;

/// Spacing of the floats at a point, as a share of its largest coordinate, with room for the rounding of all three:
/// far from the origin no point is nearer to the surface than this.
const SPACING: f64 = 2.0 * f64::EPSILON;

/// Judges the trial point of a walker and chooses its following step.
fn advance(
    field: &dyn Field,
    w: &mut Walker,
    trial: Point3,
    f: f64,
    gradient: Vec3,
    diagonal: f64,
    options: &ProjectOptions,
) -> Progress {
    let newton = -f / gradient.norm_squared() * gradient;
    let length = newton.norm();
    if length.is_finite() && f.abs() < w.residual {
        (w.best, w.residual, w.newton) = (trial, f.abs(), length);
        let longest = options.longest_step * diagonal;
        w.step = if length > longest { newton * (longest / length) } else { newton };
    } else {
        w.step *= 0.5;
    }
    let tolerance = (options.tolerance * diagonal).max(SPACING * w.best.amax());
    if w.newton < tolerance {
        w.best += w.step;
        return Progress::Arrived;
    }
    if w.newton < NEAR * diagonal && w.residual <= field.rounding_bound(w.best) {
        return Progress::Arrived;
    }
    if w.step.norm() < tolerance { Progress::Stuck } else { Progress::Walking }
}
