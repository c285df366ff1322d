//! What floats take for curves and is none, and the points in boxes that no curve explains.

use super::cell::Cell;
use super::cluster::{clusters, hull};
use super::precise::{critical_point, critical_point_across};
use super::trace::{Arc, STEP};
use super::unit::UnitPolynomial;
use crate::geom::Point3;
use rayon::prelude::*;

/// A sample of a curve is this close to it, in unit coordinates, also where sheets touch.
const CLOSE: f64 = 1e-5;
/// A curve this long, in unit coordinates, is believed where Newton's method decides nothing.
const LONG: f64 = 0.05;
/// Starts of Newton's method in one cluster of boxes.
const STARTS: usize = 8;
/// As often as this one point is met before a cluster counts as explained.
const ENOUGH: usize = 3;
/// An isolated point is met from different starts.
const TWICE: usize = 2;
/// Limits closer than this are one, in unit coordinates.
const SAME: f64 = 1e-12;
/// Starts on the way from the centre of a cluster to its corners.
const CORNER: f64 = 0.61;
/// How far from a start a point is looked for, in unit coordinates.
const REACH: f64 = 1.0;

/// Is f singular along an arc? Two samples are looked at in many digits, as critical points of f on the plane across the
/// arc: near an A_k point f and ∇f vanish along a short curve to the rounding of floats, and nowhere exactly.
pub(super) fn is_singular_along(f: &UnitPolynomial, arc: &Arc) -> bool {
    let n = arc.samples.len();
    let length: f64 = arc.samples.windows(2).map(|w| (w[1].at - w[0].at).norm()).sum();
    [n / 3, 2 * n / 3].iter().all(|&i| {
        let sample = arc.samples[i];
        match critical_point_across(f, sample.at, sample.tangent, CLOSE) {
            Some(point) => point.is_singular,
            None => length > LONG,
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
    let found: Vec<Vec<Point3>> = groups
        .par_iter()
        .map(|members| {
            let stride = members.len().div_ceil(STARTS);
            let hull = hull(members.iter().map(|i| &rest[*i]));
            let centers = members.iter().step_by(stride).map(|i| rest[*i].bounds.center());
            // Those of one box are one point.
            let corners = hull.corners().map(|c| hull.center() + CORNER * (c - hull.center()));
            points_from(f, std::iter::once(hull.center()).chain(centers).chain(corners))
        })
        .collect();
    found.into_iter().flatten().map(|p| (p, f64::EPSILON)).collect()
}

/// The singular points to which Newton's method leads from more than one start: on a curve, each leads to a point of its
/// own. When one is met [`ENOUGH`] times, it is taken for the only one.
fn points_from(f: &UnitPolynomial, starts: impl Iterator<Item = Point3>) -> Vec<Point3> {
    let mut found: Vec<(Point3, usize)> = Vec::new();
    let mut last = None;
    for start in starts {
        let Some(point) = critical_point(f, start, REACH).filter(|point| point.is_singular) else { continue };
        let at = point.nearest();
        match found.iter_mut().find(|(p, _)| (p - at).norm() < SAME) {
            Some((_, times)) => *times += usize::from(Some(start) != last),
            None => found.push((at, 1)),
        }
        last = Some(start);
        let is_curve = found.len() >= ENOUGH && found.iter().all(|(_, times)| *times == 1);
        if is_curve || found.iter().any(|(_, times)| *times == ENOUGH) {
            break;
        }
    }
    found.into_iter().filter(|(_, times)| *times >= TWICE).map(|(p, _)| p).collect()
}
