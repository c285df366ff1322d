//! Arcs and the points where they meet, as a graph.

use super::deflation::{System, solve};
use super::find::lexicographic;
use super::points::{Algebraic, nearest};
use super::set::{
    CurveKind, CurveSample, LowerDimensional, SingularCurve, SingularSet, SpecialKind, SpecialPoint, Status,
};
use super::trace::{Arc, End, STEP};
use crate::geom::{Point3, Vec3};

/// Points on sides of the box that are closer than this, in unit coordinates, are one.
const SAME: f64 = 1e-7;
/// Points on sides are known to this, in unit coordinates.
const SIDE_RADIUS: f64 = 1e-12;
/// Two arcs go on into each other if the cosine of the angle between their tangents is above this.
const SMOOTH: f64 = 0.999;

/// An arc between numbered places.
struct Edge {
    kind: CurveKind,
    samples: Vec<CurveSample>,
    ends: Option<[usize; 2]>,
}

/// The graph of the arcs, in model units, and the places that no arc reaches.
pub(super) fn graph(algebraic: &Algebraic, known: &[(Point3, f64)], arcs: Vec<Arc>) -> (SingularSet, Vec<usize>) {
    let mut places: Vec<(Point3, Option<SpecialKind>)> = known.iter().map(|(p, _)| (*p, None)).collect();
    let mut place = |end: &End| match *end {
        End::Special(i) => i,
        End::Side(p) | End::Lost(p) => {
            let kind = if matches!(end, End::Side(_)) { SpecialKind::Box } else { SpecialKind::End };
            places.iter().position(|(q, _)| (q - p).norm() < SAME).unwrap_or_else(|| {
                places.push((p, Some(kind)));
                places.len() - 1
            })
        }
    };
    let mut edges: Vec<Edge> = arcs
        .into_iter()
        .filter(|arc| arc.samples.len() > 1)
        .map(|arc| Edge {
            kind: kind(algebraic, &arc),
            ends: arc.ends.as_ref().map(|ends| [place(&ends[0]), place(&ends[1])]),
            samples: arc.samples,
        })
        .collect();
    for number in 0..known.len() {
        join(&mut edges, number);
    }
    let mut set = SingularSet::default();
    let mut alone = Vec::new();
    let mut numbers = vec![usize::MAX; places.len()];
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| lexicographic(&places[*a].0, &places[*b].0));
    for number in order {
        let (at, found) = places[number];
        let incident: Vec<CurveKind> = edges
            .iter()
            .flat_map(|edge| edge.ends.iter().flatten().filter(|end| **end == number).map(|_| edge.kind))
            .collect();
        if incident.is_empty() {
            let passed = edges.iter().flat_map(|e| &e.samples).any(|s| (s.at - at).norm() < STEP);
            if !passed && number < known.len() {
                alone.push(number);
            }
            continue;
        }
        let radius = known.get(number).map_or(SIDE_RADIUS, |(_, r)| *r);
        let exact = algebraic.exact_place(at, radius);
        numbers[number] = set.special.len();
        set.special.push(SpecialPoint {
            at: exact.as_ref().map_or(algebraic.unit.model(at), nearest),
            kind: found.unwrap_or_else(|| special_kind(algebraic, at, &incident)),
            status: if exact.is_some() { Status::Exact } else { Status::Numerical },
        });
    }
    for edge in edges {
        let ends = edge.ends.map(|ends| ends.map(|i| numbers[i]));
        let mut samples: Vec<CurveSample> = edge
            .samples
            .iter()
            .map(|s| CurveSample { at: algebraic.unit.model(s.at), tangent: s.tangent })
            .collect();
        if let Some([first, last]) = ends {
            set_end(&mut samples, 0, set.special[first].at);
            let length = samples.len();
            set_end(&mut samples, length - 1, set.special[last].at);
        }
        set.curves.push(SingularCurve {
            kind: edge.kind,
            closed: ends.is_none(),
            status: Status::Numerical,
            samples,
            ends,
        });
    }
    set.curves.sort_by(|a, b| lexicographic(&a.samples[0].at, &b.samples[0].at));
    let sticks = set.curves.iter().enumerate().filter(|(_, c)| c.kind == CurveKind::Stick);
    set.lower_dimensional.extend(sticks.map(|(i, _)| LowerDimensional::Curve(i)));
    (set, alone)
}

fn set_end(samples: &mut [CurveSample], index: usize, at: Point3) {
    if let Some(sample) = samples.get_mut(index) {
        sample.at = at;
    }
}

/// Joins two arcs that go on into each other at a place where no other arc ends: nothing special is there.
fn join(edges: &mut Vec<Edge>, place: usize) {
    let ends: Vec<(usize, usize)> = edges
        .iter()
        .enumerate()
        .flat_map(|(i, e)| {
            e.ends.iter().flat_map(move |ends| (0..2).filter(move |k| ends[*k] == place).map(move |k| (i, k)))
        })
        .collect();
    let [(i, a), (j, b)] = ends[..] else { return };
    let leaving = |edge: &Edge, end: usize| {
        let n = edge.samples.len();
        let (first, second) = if end == 0 { (0, 1) } else { (n - 1, n - 2) };
        (edge.samples[second].at - edge.samples[first].at).normalize()
    };
    if edges[i].kind != edges[j].kind || leaving(&edges[i], a).dot(&leaving(&edges[j], b)) > -SMOOTH {
        return;
    }
    if i == j {
        edges[i].samples.pop();
        edges[i].ends = None;
        return;
    }
    let mut second = edges.remove(i.max(j));
    let (first_end, second_end) = if i < j { (a, b) } else { (b, a) };
    let first = &mut edges[i.min(j)];
    // The first ends where the second begins.
    if first_end == 0 {
        reverse(first);
    }
    if second_end == 1 {
        reverse(&mut second);
    }
    first.samples.extend(second.samples.drain(1..));
    first.ends = match (first.ends, second.ends) {
        (Some([from, _]), Some([_, to])) => Some([from, to]),
        _ => None,
    };
}

fn reverse(edge: &mut Edge) {
    edge.samples.reverse();
    edge.samples.iter_mut().for_each(|s| s.tangent = -s.tangent);
    if let Some(ends) = &mut edge.ends {
        ends.swap(0, 1);
    }
}

/// What the surface is along an arc, from its middle.
fn kind(algebraic: &Algebraic, arc: &Arc) -> CurveKind {
    let middle = arc.samples[arc.samples.len() / 2];
    match arc.system {
        System::Gradient => {
            let h = algebraic.unit.taylor(middle.at).hessian();
            // The product of the two eigenvalues across the curve.
            let product = 0.5 * (h.trace() * h.trace() - (h * h).trace());
            if product < 0.0 { CurveKind::Crossing } else { CurveKind::Stick }
        }
        System::RankOne => CurveKind::Cuspidal,
        System::Flat | System::Touching => {
            if has_both_signs(algebraic, &middle) { CurveKind::Tangential } else { CurveKind::Stick }
        }
    }
}

/// Has f both signs around a point of a curve, in the plane across it?
fn has_both_signs(algebraic: &Algebraic, sample: &CurveSample) -> bool {
    /// Directions around the curve. Sheets that touch lie close together, but no sign is wanted between them.
    const DIRECTIONS: usize = 256;
    /// Distance from the curve, in unit coordinates.
    const RADIUS: f64 = 1e-2;
    let t = sample.tangent;
    let axis = Vec3::ith(t.iamin(), 1.0);
    let u = t.cross(&axis).normalize();
    let v = t.cross(&u);
    let signs: Vec<bool> = (0..DIRECTIONS)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / DIRECTIONS as f64;
            algebraic.unit.value(sample.at + RADIUS * (angle.cos() * u + angle.sin() * v)) > 0.0
        })
        .collect();
    signs.contains(&true) && signs.contains(&false)
}

/// What a point is, by the arcs that end there.
fn special_kind(algebraic: &Algebraic, at: Point3, incident: &[CurveKind]) -> SpecialKind {
    match incident {
        [_, _, _, ..] => SpecialKind::Triple,
        [a, b] => match (a, b) {
            (CurveKind::Crossing, CurveKind::Stick) | (CurveKind::Stick, CurveKind::Crossing) => SpecialKind::Pinch,
            _ => SpecialKind::Cusp,
        },
        // A pinch point in a side of the box, or the true end of an arc.
        _ => match solve(algebraic.unit, System::RankOne, at, 3, STEP) {
            Some(foot) if foot.sigma[2] > PINCH => SpecialKind::Pinch,
            _ => SpecialKind::End,
        },
    }
}

/// At a pinch point the equations of rank 1 are regular: the smallest singular value over the largest is above this.
const PINCH: f64 = 1e-6;
