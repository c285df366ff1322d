//! Points onto the surface, and onto its singular curves.

use super::assemble::Solver;
use super::plane_curve::Plane;
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};

/// Newton steps onto the surface.
const NEWTON_STEPS: usize = 20;
/// Steps onto a singular curve: where the Hessian has rank 1, each takes only half of the distance.
const CURVE_STEPS: usize = 60;
/// Share of the trace that is added at least, so that the direction of the curve has a solution, too.
const LEAST_DAMPING: f64 = 1e-13;
/// A point is not moved onto a curve from farther away than this share of the diagonal of the box.
const CURVE_REACH: f64 = 1e-2;
/// |f| over |∇f| and the diagonal of the cell at which a point is on the surface.
const ON_SURFACE: f64 = 1e-14;

/// The point of the surface in a cell near `start`: by Newton's method, else the nearest on a line through the cell along `normal`.
pub(super) fn onto_surface(solver: &Solver<'_>, start: Point3, normal: Vec3, cell: &Aabb) -> Option<Point3> {
    let mut p = start;
    for _ in 0..NEWTON_STEPS {
        let (f, gradient) = solver.field.gradient(p);
        let step = gradient * (f / gradient.norm_squared());
        p -= step;
        if !cell.contains(&p) {
            break;
        }
        if step.norm() <= ON_SURFACE * cell.diagonal() {
            return Some(p);
        }
    }
    let axis = normal.iamax();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let plane = Plane { field: solver.field, isolator: &solver.isolator, axes: [u, v, axis], height: start[u] };
    let roots = plane.on_line(0, start[v], [cell.min[axis], cell.max[axis]]);
    let distance = |z: &f64| (z - start[axis]).abs();
    let nearest = roots.into_iter().map(|(z, _)| z).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let mut p = start;
    p[axis] = nearest;
    Some(p)
}

/// The point of a singular curve near `start`, by Levenberg–Marquardt steps for ∇f = 0; in the plane where coordinate `fixed`
/// has its value, if one is given. The start itself if that leads nowhere.
pub(super) fn onto_curve(field: &dyn Field, start: Point3, fixed: Option<usize>, bounds: &Aabb) -> Point3 {
    let mut p = start;
    let mut jet = field.jet(p);
    let mut damping = 1e-6;
    for _ in 0..CURVE_STEPS {
        let mut h = jet.hessian;
        if let Some(axis) = fixed {
            h.set_column(axis, &Vec3::zeros());
        }
        let normal_matrix = h.transpose() * h;
        let scale = normal_matrix.trace();
        if scale == 0.0 {
            break;
        }
        let damped = normal_matrix + damping * scale * Mat3::identity();
        let Some(factor) = damped.cholesky() else { break };
        let mut step = factor.solve(&(h.transpose() * jet.gradient));
        if let Some(axis) = fixed {
            step[axis] = 0.0;
        }
        let trial = p - step;
        let trial_jet = field.jet(trial);
        if trial_jet.gradient.norm() < jet.gradient.norm() {
            (p, jet) = (trial, trial_jet);
            damping = (0.1 * damping).max(LEAST_DAMPING);
        } else {
            damping *= 10.0;
        }
        if damping > 1.0 || jet.gradient.norm() == 0.0 || step.norm() <= f64::EPSILON * bounds.diagonal() {
            break;
        }
    }
    if (p - start).norm() <= CURVE_REACH * bounds.diagonal() && bounds.contains(&p) { p } else { start }
}
