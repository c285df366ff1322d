//! The whole search: isolated points, special points, arcs.

use super::SingularError;
use super::cell::{Cell, Stratum};
use super::cluster::{clusters, hull};
use super::graph::graph;
use super::points::{Algebraic, nearest};
use super::set::{CurveSample, LowerDimensional, PointKind, SingularPoint, SingularSet, Status};
use super::subdivide::{Located, MOST_CELLS, Rest, locate, refine};
use super::tolerance::TAU;
use super::trace::{Arc, End, STEP, Tracer};
use super::uncovered::{is_singular_along, uncovered};
use super::unit::UnitPolynomial;
use crate::field::QuadraticPolynomial;
use crate::geom::{Aabb, BoxTree, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// How deep the box is divided before what is left is looked at in clusters.
const DEPTH: usize = 6;
/// How deep it is divided where points can't be told apart sooner.
const DEEPEST: usize = 10;
/// Boxes along a curve double at every level; those around points grow no more, sooner or later.
const GROWTH: f64 = 1.6;
/// After so many levels of growth in a row it is taken for a curve.
const GROWTHS: usize = 2;
/// Levels more, for each stratum, until points and curves of it can be told apart.
const FINER: usize = 2;
/// Boxes along curves are divided for the next stratum while there are no more than this.
const MOST_FINER: usize = 3_000;
/// A cluster with a longer side than this many boxes is part of a curve.
const COMPACT: f64 = 8.0;
/// Special points closer than this, in unit coordinates, are one: they were found with different equations.
const SAME: f64 = 1e-9;
/// Half the side of the box around the end of a lost arc in which a special point is looked for.
const AROUND: f64 = 1.7e-2;
/// Ends of arcs that could not be followed, and that are closer than this, are one point.
const TOGETHER: f64 = 1e-5;
/// Arcs that are continued meet if they come this close, in unit coordinates.
const MEETING: f64 = 1e-8;
const MEETING_STEPS: usize = 20;
/// Above this cosine of the angle between their tangents, two curves at one place are one.
const PARALLEL: f64 = 0.9;
/// How often arcs are followed again, with special points that were missed.
const REPAIRS: usize = 4;
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
    /// Divides what is left farther, as long as it does not look like curves, whose boxes double at every level. Returns
    /// the boxes of compact clusters and those along curves.
    fn separate(&mut self, cells: Vec<Cell>) -> Result<(Vec<Cell>, Vec<Cell>), SingularError> {
        let (mut compact, mut long) = (Vec::new(), Vec::new());
        let mut groups: Vec<(Vec<Cell>, usize)> =
            split_by_cluster(cells).into_iter().map(|g| (g, 0)).collect();
        for depth in DEPTH..=DEEPEST {
            let mut next = Vec::new();
            for (group, growths) in groups {
                if depth == DEEPEST || growths >= GROWTHS {
                    if is_compact(&group) {
                        compact.extend(group)
                    } else {
                        long.extend(group)
                    }
                    continue;
                }
                let before = group.len() as f64;
                let rest = refine(group, 1, MOST_CELLS, Stratum::Singular)?;
                self.simple.extend(rest.found);
                let grown = rest.cells.len() as f64 > GROWTH * before;
                let growths = if grown && depth > DEPTH { growths + 1 } else { 0 };
                next.extend(split_by_cluster(rest.cells).into_iter().map(|g| (g, growths)));
            }
            groups = next;
        }
        Ok((compact, long))
    }

    /// Sorts what is left of the box: compact clusters are looked at closely, the others are searched for points of the
    /// next stratum.
    fn sort(
        &mut self,
        f: &UnitPolynomial,
        cells: &[Cell],
        stratum: Stratum,
    ) -> Result<Vec<Cell>, SingularError> {
        let mut long = Vec::new();
        let groups = clusters(cells);
        let located: Vec<Result<Option<Located>, SingularError>> = groups
            .par_iter()
            .evenly()
            .map(|members| {
                let bounds = hull(members.iter().map(|i| &cells[*i]));
                let side = cells[members[0]].bounds.size().max();
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

/// The boxes of each cluster.
fn split_by_cluster(cells: Vec<Cell>) -> Vec<Vec<Cell>> {
    clusters(&cells).iter().map(|members| members.iter().map(|i| cells[*i].clone()).collect()).collect()
}

/// Is a cluster only a few boxes long?
fn is_compact(cells: &[Cell]) -> bool {
    cells.first().is_some_and(|first| hull(cells).size().max() <= COMPACT * first.bounds.size().max())
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
    let start = Cell::new(unit, unit.bounds.grown(margin));
    let Rest { cells, found } = refine(vec![start], DEPTH, MOST_CELLS, Stratum::Singular)?;
    let mut search = Search { simple: found, ..Search::default() };
    let (compact, mut long) = search.separate(cells)?;
    long.extend(search.sort(unit, &compact, Stratum::Singular)?);
    search.along = long.clone();
    for stratum in [Stratum::RankOne, Stratum::Irregular, Stratum::Flat] {
        if long.is_empty() {
            break;
        }
        let kept = long.into_par_iter().evenly().filter(|cell| cell.may_hold(stratum)).collect();
        let rest = refine(kept, FINER, MOST_FINER, stratum)?;
        search.simple.extend(rest.found);
        long = search.sort(unit, &rest.cells, stratum)?;
    }
    let mut places = merged(&search.degenerate);
    let mut arcs = arcs(unit, &search.along, &places);
    let mut undecided = Vec::new();
    for _ in 0..REPAIRS {
        let mut all = merged(&[places.clone(), missed(&algebraic, &arcs, &places)?].concat());
        if all.len() == places.len() {
            let rest = uncovered(unit, &search.along, &arcs, &places)?;
            search.simple.extend(rest.simple);
            undecided = rest.cells;
            all = merged(&[places.clone(), rest.points].concat());
        }
        if all.len() == places.len() {
            break;
        }
        places = all;
        arcs = self::arcs(unit, &search.along, &places);
    }
    let (mut set, alone) = graph(&algebraic, &places, arcs);
    let simple = separate(&search.simple);
    let simple: Vec<SingularPoint> =
        simple.par_iter().evenly().filter_map(|b| algebraic.simple_point(b)).collect();
    let degenerate = alone.iter().filter_map(|i| algebraic.degenerate_point(places[*i].0, places[*i].1));
    set.points = distinct(simple.into_iter().chain(degenerate), SAME * unit.scale);
    set.points.sort_by(|a, b| lexicographic(&a.at, &b.at));
    set.tau = TAU;
    let groups = clusters(&undecided);
    set.undecided = groups.iter().map(|g| unit.model_box(&hull(g.iter().map(|i| &undecided[*i])))).collect();
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
    algebraic: &Algebraic,
    arcs: &[Arc],
    places: &[(Point3, f64)],
) -> Result<Vec<(Point3, f64)>, SingularError> {
    let ends = arcs.iter().flat_map(|arc| arc.ends.iter().flatten());
    let every: Vec<Point3> =
        ends.filter_map(|end| if let End::Lost(p) = end { Some(*p) } else { None }).collect();
    let mut lost: Vec<Point3> = Vec::new();
    for p in &every {
        if !lost.iter().any(|q| (p - q).norm() < AROUND) {
            lost.push(*p);
        }
    }
    let mut found = Vec::new();
    for p in lost {
        let mut ends: Vec<Vec<CurveSample>> = arcs.iter().flat_map(|arc| lost_ends(arc, p)).collect();
        ends.extend(arcs.iter().filter_map(|arc| passing(arc, p)));
        // The two that cross at the largest angle meet where it is best known.
        let pairs = ends.iter().enumerate().flat_map(|(i, a)| ends[..i].iter().map(move |b| (a, b)));
        let cosine = |(a, b): &(&Vec<CurveSample>, &Vec<CurveSample>)| match (a.last(), b.last()) {
            (Some(a), Some(b)) => a.tangent.dot(&b.tangent).abs(),
            _ => 1.0,
        };
        let widest =
            pairs.min_by(|a, b| cosine(a).total_cmp(&cosine(b))).filter(|pair| cosine(pair) < PARALLEL);
        if let Some(at) = widest.and_then(|(a, b)| meeting(a, b)) {
            found.push((at, MEETING));
            continue;
        }
        let mut located = strata_near(algebraic.unit, p, places)?;
        if located.is_empty() {
            located.extend(where_ends_are(algebraic, p, &every, places));
        }
        found.extend(located);
    }
    Ok(found)
}

/// Points of the strata that are told apart near the end of a lost arc, but for those that are known.
fn strata_near(
    f: &UnitPolynomial,
    p: Point3,
    places: &[(Point3, f64)],
) -> Result<Vec<(Point3, f64)>, SingularError> {
    for stratum in [Stratum::Flat, Stratum::Irregular, Stratum::RankOne] {
        let located = locate(f, Aabb::new(p, p).grown(AROUND), stratum)?;
        let new = |q: &Point3| !places.iter().any(|(known, _)| (known - q).norm() < SAME);
        let points: Vec<_> = located.points.into_iter().filter(|(q, _)| new(q)).collect();
        if !located.extended && !points.is_empty() {
            return Ok(points);
        }
    }
    Ok(Vec::new())
}

/// Where arcs were followed so closely to a point that has no regular equations that they end together: at the rational
/// singular point there, or at one of the ends.
fn where_ends_are(
    algebraic: &Algebraic,
    p: Point3,
    ends: &[Point3],
    places: &[(Point3, f64)],
) -> Option<(Point3, f64)> {
    let distances: Vec<f64> = ends.iter().map(|q| (q - p).norm()).filter(|d| *d < TOGETHER).collect();
    if distances.len() < 2 || places.iter().any(|(q, _)| (p - q).norm() < AROUND) {
        return None;
    }
    let radius = distances.iter().fold(f64::EPSILON, |m, d| m.max(*d));
    let exact = algebraic
        .exact_place(p, TOGETHER)
        .map(|q| (nearest(&q) - algebraic.unit.center) / algebraic.unit.scale);
    let is_regular = |q: Point3| {
        let tracer = Tracer { f: algebraic.unit, special: &[], bounds: algebraic.unit.bounds };
        tracer.foot(q, SAME).is_some()
    };
    Some(exact.filter(|q| !is_regular(*q)).map_or((p, radius), |q| (q, f64::EPSILON)))
}

/// The samples of an arc towards each end that was lost near p.
fn lost_ends(arc: &Arc, p: Point3) -> Vec<Vec<CurveSample>> {
    let is_near = |end: &End| matches!(end, End::Lost(q) if (p - q).norm() < AROUND);
    let Some([first, last]) = &arc.ends else { return Vec::new() };
    let mut ends = Vec::new();
    if is_near(last) {
        ends.push(arc.samples.clone());
    }
    if is_near(first) {
        let turned = |s: &CurveSample| CurveSample { at: s.at, tangent: -s.tangent };
        ends.push(arc.samples.iter().rev().map(turned).collect());
    }
    ends
}

/// The samples of an arc up to where it passes p.
fn passing(arc: &Arc, p: Point3) -> Option<Vec<CurveSample>> {
    let distances = arc.samples.iter().map(|s| (s.at - p).norm()).enumerate();
    let (nearest, distance) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let inner = nearest > 0 && nearest + 1 < arc.samples.len();
    (inner && distance < AROUND).then(|| arc.samples[..=nearest].to_vec())
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

/// Points that were found in two boxes, as one.
fn distinct(points: impl Iterator<Item = SingularPoint>, same: f64) -> Vec<SingularPoint> {
    let mut result: Vec<SingularPoint> = Vec::new();
    for p in points {
        if !result.iter().any(|q| (p.at - q.at).norm() <= same + p.radius + q.radius) {
            result.push(p);
        }
    }
    result
}

/// All arcs that pass through the boxes. A box in or beside which an arc passes is not searched again.
fn arcs(f: &UnitPolynomial, cells: &[Cell], places: &[(Point3, f64)]) -> Vec<Arc> {
    let special: Vec<Point3> = places.iter().map(|(p, _)| *p).collect();
    let tracer = Tracer { f, special: &special, bounds: f.bounds };
    let boxes: Vec<Aabb> = cells.iter().map(|c| c.bounds.grown(c.bounds.size().max())).collect();
    let tree = BoxTree::new(&boxes);
    let mut done = vec![false; cells.len()];
    let mut arcs: Vec<Arc> = Vec::new();
    for (i, cell) in cells.iter().enumerate() {
        if done[i] {
            continue;
        }
        let reach = REACH * cell.bounds.diagonal();
        let Some((system, foot)) = tracer.foot(cell.bounds.center(), reach) else { continue };
        let covered = |arc: &Arc| {
            let near = |s: &CurveSample| {
                (s.at - foot.at).norm() < STEP && s.tangent.dot(&foot.tangent).abs() > PARALLEL
            };
            arc.samples.iter().any(near)
        };
        let at_special = special.iter().any(|s| (s - foot.at).norm() < STEP);
        if !f.bounds.contains(&foot.at) || at_special || arcs.iter().any(covered) {
            continue;
        }
        let arc = tracer.arc(system, &foot);
        for sample in &arc.samples {
            tree.visit(|b| b.contains(&sample.at), |k| done[k] = true);
        }
        arcs.push(arc);
    }
    let repeats: Vec<bool> = (0..arcs.len()).map(|i| is_repeat(&arcs, i, &special)).collect();
    let alone = arcs
        .into_par_iter()
        .evenly()
        .zip(repeats)
        .filter(|(arc, repeat)| !repeat && is_singular_along(f, arc));
    alone.map(|(arc, _)| arc).collect()
}

/// Is a closed arc only a turn on the spot, beside another arc or a special point?
fn is_repeat(arcs: &[Arc], i: usize, special: &[Point3]) -> bool {
    /// Samples of an arc that may be one.
    const FEW: usize = 16;
    let others = arcs.iter().enumerate().filter(|(j, _)| *j != i).flat_map(|(_, arc)| &arc.samples);
    let places: Vec<Point3> = others.map(|s| s.at).chain(special.iter().copied()).collect();
    let is_beside = |s: &CurveSample| places.iter().any(|p| (p - s.at).norm() < STEP);
    let Arc { samples, ends, .. } = &arcs[i];
    ends.is_none() && samples.len() < FEW && samples.iter().all(is_beside)
}

/// Where two arcs that could not be followed to their ends meet, if they are continued: polynomials through samples
/// before the ends.
fn meeting(a: &[CurveSample], b: &[CurveSample]) -> Option<Point3> {
    let (p, q) = (Continued::new(a)?, Continued::new(b)?);
    let (mut s, mut t) = (0.0, 0.0);
    for _ in 0..MEETING_STEPS {
        let apart = p.at(s) - q.at(t);
        let (u, v) = (p.tangent(s), -q.tangent(t));
        let normal = nalgebra::Matrix2::new(u.dot(&u), u.dot(&v), u.dot(&v), v.dot(&v));
        let step = normal.lu().solve(&nalgebra::Vector2::new(u.dot(&apart), v.dot(&apart)))?;
        (s, t) = (s - step.x, t - step.y);
        if s.abs() > 2.0 * AROUND || t.abs() > 2.0 * AROUND {
            return None;
        }
    }
    let (x, y) = (p.at(s), q.at(t));
    ((x - y).norm() < MEETING).then(|| 0.5 * (x + y))
}

/// An arc as a polynomial in the length along the tangent at its end.
struct Continued {
    parameters: Vec<f64>,
    /// Newton's divided differences.
    differences: Vec<Point3>,
}

impl Continued {
    /// Through every third sample before the end, the last of which are left out: they are the least exact.
    fn new(samples: &[CurveSample]) -> Option<Self> {
        const POINTS: usize = 6;
        const STRIDE: usize = 3;
        let end = samples.last()?;
        let chosen: Vec<&CurveSample> =
            samples.iter().rev().skip(STRIDE).step_by(STRIDE).take(POINTS).collect();
        if chosen.len() < POINTS {
            return None;
        }
        let parameters: Vec<f64> = chosen.iter().map(|s| (s.at - end.at).dot(&end.tangent)).collect();
        let mut differences: Vec<Point3> = chosen.iter().map(|s| s.at).collect();
        for order in 1..POINTS {
            for i in (order..POINTS).rev() {
                differences[i] =
                    (differences[i] - differences[i - 1]) / (parameters[i] - parameters[i - order]);
            }
        }
        Some(Self { parameters, differences })
    }

    fn at(&self, s: f64) -> Point3 {
        let last = self.differences.len() - 1;
        (0..last)
            .rev()
            .fold(self.differences[last], |p, i| p * (s - self.parameters[i]) + self.differences[i])
    }

    fn tangent(&self, s: f64) -> Point3 {
        const H: f64 = 1e-6;
        (self.at(s + H) - self.at(s - H)) / (2.0 * H)
    }
}
