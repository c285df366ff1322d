//! What floats take for curves and is none, and the points in boxes that no curve explains.

use super::cell::Cell;
use super::cluster::{clusters, hull};
use super::precise::{PrecisePoint, critical_point, critical_point_across};
use super::trace::{Arc, STEP};
use super::unit::UnitPolynomial;
use crate::geom::Point3;
use rayon::prelude::*;

/// A sample of a curve is this close to it, in unit coordinates, also where sheets touch.
const CLOSE: f64 = 1e-5;
/// Starts of Newton's method in one cluster of boxes.
const STARTS: usize = 12;
/// How far from a start a point is looked for, in unit coordinates.
const REACH: f64 = 1.0;

/// Is f singular along an arc? Two samples are looked at in many digits, as critical points of f on the plane across the
/// arc: near an A_k point f and ∇f vanish along a short curve to the rounding of floats, and nowhere exactly.
pub(super) fn is_singular_along(f: &UnitPolynomial, arc: &Arc) -> bool {
    let n = arc.samples.len();
    [n / 3, 2 * n / 3].iter().all(|&i| {
        let sample = arc.samples[i];
        match critical_point_across(f, sample.at, sample.tangent, CLOSE) {
            Some(point) => point.is_singular,
            None => false,
        }
    })
}

/// Singular points in boxes through which no arc passes: the boxes along the valley of an A_k point look like those along
/// a curve.
pub(super) fn uncovered(
    f: &UnitPolynomial,
    cells: &[Cell],
    arcs: &[Arc],
    places: &[(Point3, f64)],
) -> Vec<(Point3, f64)> {
    let samples: Vec<Point3> = arcs.iter().flat_map(|arc| &arc.samples).map(|s| s.at).collect();
    let explained = |cell: &&Cell| {
        let reach = cell.bounds.diagonal() + STEP;
        let center = cell.bounds.center();
        samples.iter().any(|s| (s - center).norm() < reach)
            || places.iter().any(|(p, _)| cell.bounds.grown(CLOSE).contains(p))
    };
    let rest: Vec<Cell> = cells.par_iter().filter(|cell| !explained(cell)).cloned().collect();
    let groups = clusters(&rest);
    let starts: Vec<Point3> = groups
        .iter()
        .flat_map(|members| {
            let stride = members.len().div_ceil(STARTS);
            let centers = members.iter().step_by(stride).map(|i| rest[*i].bounds.center());
            centers.chain([hull(members.iter().map(|i| &rest[*i])).center()]).collect::<Vec<_>>()
        })
        .collect();
    let found: Vec<Option<PrecisePoint>> =
        starts.par_iter().map(|start| critical_point(f, *start, REACH)).collect();
    let singular = found.into_iter().flatten().filter(|point| point.is_singular);
    singular.map(|point| (point.nearest(), f64::EPSILON)).collect()
}
