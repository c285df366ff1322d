//! The whole search: isolated points, special points, arcs.

use super::SingularError;
use super::cell::{Cell, Stratum};
use super::cluster::{clusters, hull};
use super::graph::graph;
use super::points::Algebraic;
use super::set::{PointKind, LowerDimensional, SingularPoint, SingularSet, Status};
use super::subdivide::{Located, MOST_CELLS, Rest, locate, refine};
use super::tolerance::TAU;
use super::trace::{Arc, End, STEP, Tracer};
use super::unit::UnitPolynomial;
use crate::field::QuadraticPolynomial;
use crate::geom::{Aabb, Point3};
use rayon::prelude::*;

/// How deep the box is divided before what is left is looked at in clusters.
const DEPTH: usize = 6;
/// Levels more, for each stratum, until points and curves of it can be told apart.
const FINER: usize = 3;
/// Boxes along curves are divided for the next stratum while there are no more than this.
const MOST_FINER: usize = 4_000;
/// A cluster with a longer side than this many boxes is part of a curve.
const COMPACT: f64 = 8.0;
/// Special points closer than this, in unit coordinates, are one: they were found with different equations.
const SAME: f64 = 1e-9;
/// Half the side of the box around the end of a lost arc in which a special point is looked for.
const AROUND: f64 = 1.7e-2;
/// How often arcs are followed again, with special points that were missed.
const REPAIRS: usize = 2;
/// How far from a box its curve is looked for, in diagonals of the box.
const REACH: f64 = 1.5;

/// The boxes that may hold parts of curves, and points that were told apart.
#[derive(Default)]
struct Search {
    /// Boxes around simple critical points.
    simple: Vec<Aabb>,
    /// Points to which boxes have shrunk: isolated ones, and special ones of curves.
    degenerate: Vec<(Point3, f64)>,
    /// Boxes of clusters through which curves pass.
    along: Vec<Cell>,
}

impl Search {
    /// Sorts what is left of the box: compact clusters are looked at closely, the others are searched for points of the
    /// next stratum.
    fn sort(&mut self, f: &UnitPolynomial, cells: &[Cell], stratum: Stratum) -> Result<Vec<Cell>, SingularError> {
        let mut long = Vec::new();
        let groups = clusters(cells);
        let located: Vec<Result<Option<Located>, SingularError>> = groups
            .par_iter()
            .map(|members| {
                let bounds = hull(members.iter().map(|i| &cells[*i]));
                let side = members.iter().fold(0.0_f64, |s, i| s.max(cells[*i].bounds.size().max()));
                let compact = bounds.size().max() <= COMPACT * side;
                compact.then(|| locate(f, bounds, stratum)).transpose()
            })
            .collect();
        for (members, located) in groups.iter().zip(located) {
            match located? {
                Some(located) if !located.extended => {
                    self.simple.extend(located.found);
                    self.degenerate.extend(located.points);
                }
                _ => long.extend(members.iter().map(|i| cells[*i].clone())),
            }
        }
        Ok(long)
    }
}

/// The singular set of f = 0 in a box, f without repeated factors.
pub(super) fn find(
    exact: &QuadraticPolynomial,
    unit: &UnitPolynomial,
    bounds: &Aabb,
) -> Result<SingularSet, SingularError> {
    let algebraic = Algebraic { exact, unit, bounds };
    // Larger by a little: what is on a side of the box is inside then, and can be enclosed.
    let margin = 1.37e-3 * unit.bounds.size().max();
    let Rest { cells, found } = refine(vec![Cell::new(unit, unit.bounds.grown(margin))], DEPTH, MOST_CELLS, Stratum::Singular)?;
    let mut search = Search { simple: found, ..Search::default() };
    let mut long = search.sort(unit, &cells, Stratum::Singular)?;
    search.along = long.clone();
    for stratum in [Stratum::RankOne, Stratum::Irregular, Stratum::Flat] {
        if long.is_empty() {
            break;
        }
        let kept = long.into_par_iter().filter(|cell| cell.may_hold(stratum)).collect();
        let rest = refine(kept, FINER, MOST_FINER, stratum)?;
        search.simple.extend(rest.found);
        long = search.sort(unit, &rest.cells, stratum)?;
    }
    let mut places = merged(&search.degenerate);
    let mut arcs = arcs(unit, &search.along, &places);
    for _ in 0..REPAIRS {
        let more = missed(unit, &arcs, &places)?;
        if more.is_empty() {
            break;
        }
        places = merged(&[places, more].concat());
        arcs = self::arcs(unit, &search.along, &places);
    }
    let (mut set, alone) = graph(&algebraic, &places, arcs);
    let simple = separate(&search.simple);
    let simple: Vec<SingularPoint> = simple.par_iter().filter_map(|b| algebraic.simple_point(b)).collect();
    let degenerate = alone.iter().filter_map(|i| algebraic.degenerate_point(places[*i].0, places[*i].1));
    set.points = simple.into_iter().chain(degenerate).collect();
    set.points.sort_by(|a, b| lexicographic(&a.at, &b.at));
    set.tau = TAU;
    let isolated = set.points.iter().enumerate().filter(|(_, p)| p.kind == PointKind::Isolated);
    set.lower_dimensional.extend(isolated.map(|(i, _)| LowerDimensional::Point(i)));
    debug_assert!(set.points.iter().all(|p| p.status >= Status::Numerical));
    Ok(set)
}

/// The order of the lists in a result.
pub(super) fn lexicographic(a: &Point3, b: &Point3) -> std::cmp::Ordering {
    (0..3).fold(std::cmp::Ordering::Equal, |order, i| order.then(a[i].total_cmp(&b[i])))
}

/// Special points that subdivision has not told apart from the curves: looked for where arcs could not be followed.
fn missed(
    f: &UnitPolynomial,
    arcs: &[Arc],
    places: &[(Point3, f64)],
) -> Result<Vec<(Point3, f64)>, SingularError> {
    let mut lost: Vec<Point3> = Vec::new();
    for end in arcs.iter().flat_map(|arc| arc.ends.iter().flatten()) {
        if let End::Lost(p) = end
            && !lost.iter().any(|q| (p - q).norm() < AROUND)
        {
            lost.push(*p);
        }
    }
    let mut found = Vec::new();
    for p in lost {
        for stratum in [Stratum::Flat, Stratum::Irregular, Stratum::RankOne] {
            let located = locate(f, Aabb::new(p, p).grown(AROUND), stratum)?;
            let new: Vec<_> = located
                .points
                .into_iter()
                .filter(|(q, _)| !places.iter().any(|(known, _)| (known - q).norm() < SAME))
                .collect();
            if !located.extended && !new.is_empty() {
                found.extend(new);
                break;
            }
        }
    }
    Ok(found)
}

/// Points closer together than [`SAME`] as one, with the smallest radius.
fn merged(points: &[(Point3, f64)]) -> Vec<(Point3, f64)> {
    let mut result: Vec<(Point3, f64)> = Vec::new();
    for &(p, r) in points {
        match result.iter_mut().find(|(q, _)| (p - *q).norm() < SAME) {
            Some(known) if r < known.1 => *known = (p, r),
            Some(_) => {}
            None => result.push((p, r)),
        }
    }
    result
}

/// Boxes with one critical point each, where none is there twice: boxes that overlap are of the same point, because they
/// come from looks at the same place.
fn separate(boxes: &[Aabb]) -> Vec<Aabb> {
    let mut result: Vec<Aabb> = Vec::new();
    for b in boxes {
        if !result.iter().any(|known| known.overlaps(b)) {
            result.push(*b);
        }
    }
    result
}

/// All arcs that pass through the boxes.
fn arcs(f: &UnitPolynomial, cells: &[Cell], places: &[(Point3, f64)]) -> Vec<Arc> {
    let special: Vec<Point3> = places.iter().map(|(p, _)| *p).collect();
    let tracer = Tracer { f, special: &special, bounds: f.bounds };
    let feet: Vec<_> = cells
        .par_iter()
        .map(|cell| {
            let reach = REACH * cell.bounds.diagonal();
            tracer.foot(cell.bounds.center(), reach).filter(|(_, foot)| f.bounds.contains(&foot.at))
        })
        .collect();
    let mut arcs: Vec<Arc> = Vec::new();
    for (system, foot) in feet.into_iter().flatten() {
        let covered = |arc: &Arc| {
            arc.samples.iter().any(|s| {
                (s.at - foot.at).norm() < STEP && (s.tangent.dot(&foot.tangent).abs() > 0.9 || s.tangent == Point3::zeros())
            })
        };
        let at_special = special.iter().any(|s| (s - foot.at).norm() < STEP);
        if !at_special && !arcs.iter().any(covered) {
            arcs.push(tracer.arc(system, &foot));
        }
    }
    arcs
}
