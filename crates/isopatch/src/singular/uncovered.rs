//! What floats take for curves and is none, and the points in boxes that no curve explains.

use super::SingularError;
use super::cell::{Cell, Stratum};
use super::cluster::{clusters, hull};
use super::precise::{critical_point, critical_point_across};
use super::subdivide::{MOST_CELLS, refine};
use super::trace::{Arc, NEAR, STEP};
use super::unit::UnitPolynomial;
use crate::geom::{Aabb, BoxTree, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// A sample of a curve is this close to it, in unit coordinates, also where sheets touch.
const CLOSE: f64 = 1e-5;
/// A curve this long, in unit coordinates, is believed where Newton's method decides nothing.
const LONG: f64 = 0.05;
/// How often boxes that nothing explains are divided.
const LEVELS: usize = 5;
/// Most boxes that are divided so: more are along something that was missed.
const MOST: usize = 20_000;
/// Fewer boxes than this are looked at with exact sums of derivatives, which take a millisecond each.
const MOST_EXACT: usize = 2_000;
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

/// What is in boxes that no arc and no special point explains.
pub(super) struct Uncovered {
    /// Singular points, with their radii.
    pub points: Vec<(Point3, f64)>,
    /// Boxes that hold one critical point each.
    pub simple: Vec<Aabb>,
    /// Boxes in which nothing could be shown.
    pub cells: Vec<Cell>,
}

/// Looks into boxes through which no arc passes. Nearly all hold nothing, which smaller boxes and exact sums of derivatives
/// show; the boxes along the valley of an A_k point look like those along a curve, and Newton's method finds the point.
pub(super) fn uncovered(
    f: &UnitPolynomial,
    cells: &[Cell],
    arcs: &[Arc],
    places: &[(Point3, f64)],
) -> Result<Uncovered, SingularError> {
    let explained = Explained::new(arcs, places);
    let mut cells = cells.to_vec();
    let mut simple = Vec::new();
    for level in 0..=LEVELS {
        cells.retain(|cell| cell.bounds.overlaps(&f.bounds) && !explained.holds(cell));
        if cells.len() < MOST_EXACT {
            cells = cells.into_par_iter().evenly().filter(|cell| may_be_singular(f, cell)).collect();
        }
        if cells.is_empty() || cells.len() > MOST || level == LEVELS {
            break;
        }
        let rest = refine(cells, 1, MOST_CELLS, Stratum::Singular)?;
        simple.extend(rest.found);
        cells = rest.cells;
    }
    if cells.len() > MOST {
        return Ok(Uncovered { points: Vec::new(), simple, cells });
    }
    let groups = clusters(&cells);
    let found: Vec<Vec<Point3>> = groups
        .par_iter()
        .evenly()
        .map(|members| {
            let stride = members.len().div_ceil(STARTS);
            let hull = hull(members.iter().map(|i| &cells[*i]));
            let centers = members.iter().step_by(stride).map(|i| cells[*i].bounds.center());
            // Those of one box are one point.
            let corners = hull.corners().map(|c| hull.center() + CORNER * (c - hull.center()));
            points_from(f, std::iter::once(hull.center()).chain(centers).chain(corners))
        })
        .collect();
    let points: Vec<(Point3, f64)> = found.into_iter().flatten().map(|p| (p, f64::EPSILON)).collect();
    let explained = Explained::new(&[], &points);
    cells.retain(|cell| !explained.holds(cell));
    Ok(Uncovered { points, simple, cells })
}

/// Places beside which boxes need no other explanation: bounds of floats do not tell a degenerate point or a curve from what
/// is next to it.
struct Explained {
    tree: BoxTree,
}

impl Explained {
    fn new(arcs: &[Arc], places: &[(Point3, f64)]) -> Self {
        let samples = arcs.iter().flat_map(|arc| &arc.samples).map(|s| Aabb::new(s.at, s.at).grown(STEP));
        let special = places.iter().map(|(p, _)| Aabb::new(*p, *p).grown(NEAR));
        Self { tree: BoxTree::new(&samples.chain(special).collect::<Vec<_>>()) }
    }

    fn holds(&self, cell: &Cell) -> bool {
        let mut is_near = false;
        self.tree.visit(|b| b.overlaps(&cell.bounds), |_| is_near = true);
        is_near
    }
}

/// Might f and ∇f vanish in a box? No if f or its derivative in an eigendirection of the Hessian has a sign there.
fn may_be_singular(f: &UnitPolynomial, cell: &Cell) -> bool {
    let directions = f.taylor(cell.bounds.center()).hessian().symmetric_eigen().eigenvectors;
    f.net(&cell.bounds).range().contains(0.0)
        && directions
            .column_iter()
            .all(|d| f.directional_net(d.into_owned(), &cell.bounds).range().contains(0.0))
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
