//! The connected parts of the real zero set in a closed box, and a point on each.
//!
//! Boxes in which f has no zero are dropped, by bounds. Where the gradients at any two points of a box are less than 90°
//! apart, the signs at its corners tell how the surface passes through it (Plantinga & Vegter 2004); the others are divided
//! down to the singular set. There, boxes that touch belong together, because the surface near a singular point is a cone
//! over what is around it. Nothing is sampled: a small component survives in the boxes around it.

use super::cell::Cell;
use super::tolerance::TAU;
use super::unit::UnitPolynomial;
use crate::geom::{Aabb, BoxTree, Interval, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// The connected parts of the zero set.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// A point on each, in model units, in lexicographic order.
    pub seeds: Vec<Point3>,
}

/// How deep boxes are divided.
const DEPTH: usize = 7;
/// How deep those are that are not at the singular set, because sheets that are close to each other are told apart at last.
const DEEPEST: usize = 14;
/// While there are no more of them than this.
const MOST_DEEPER: usize = 4_000;
/// Most boxes of one size: beyond it, counting is given up.
const MOST_CELLS: usize = 40_000;
/// Intervals along a side that two leaves have in common, where one of them is near the singular set.
const CLOSER: usize = 4;
/// Steps of a search for the smallest value in a box, and for a critical point.
const STEPS: usize = 80;

/// A box that is divided no more.
struct Leaf {
    bounds: Aabb,
    /// Does the gradient turn by less than 90° in it?
    smooth: bool,
    /// A zero of f in it, where one is known.
    zero: Option<Point3>,
}

/// Counts the components; `singular` are points of the singular set, in unit coordinates. None if that takes too many
/// boxes.
pub(super) fn components(f: &UnitPolynomial, singular: &[Point3]) -> Option<Components> {
    let mut cells = vec![Cell::new(f, f.bounds)];
    let mut leaves: Vec<Leaf> = Vec::new();
    let tree = BoxTree::new(&singular.iter().map(|p| Aabb::new(*p, *p)).collect::<Vec<_>>());
    let is_near = |cell: &Cell| {
        let mut near = false;
        tree.visit(|b| b.overlaps(&cell.bounds.grown(cell.bounds.diagonal())), |_| near = true);
        near
    };
    for depth in 0..=DEEPEST {
        let parts: Vec<(Cell, bool)> = cells
            .into_par_iter()
            .evenly()
            .filter(|cell| cell.net.range().contains(0.0))
            .map(|cell| {
                let smooth = is_smooth(&cell);
                (cell, smooth)
            })
            .collect();
        if parts.len() > MOST_CELLS {
            return None;
        }
        let (done, open): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|(cell, smooth)| *smooth || (depth >= DEPTH && is_near(cell)));
        let (done, open) = if depth == DEEPEST || (depth >= DEPTH && open.len() > MOST_DEEPER) {
            (done.into_iter().chain(open).collect(), Vec::new())
        } else {
            (done, open)
        };
        leaves.extend(done.into_iter().map(|(cell, smooth)| Leaf {
            bounds: cell.bounds,
            smooth,
            zero: None,
        }));
        cells = open.par_iter().evenly().flat_map_iter(|(cell, _)| cell.split()).collect();
    }
    let found: Vec<Option<Point3>> =
        leaves.par_iter().evenly().map(|leaf| zero(f, leaf, singular, &tree)).collect();
    leaves.iter_mut().zip(found).for_each(|(leaf, zero)| leaf.zero = zero);
    Some(Components { seeds: seeds(f, &leaves) })
}

/// Is the angle between the gradients at any two points less than 90°?
fn is_smooth(cell: &Cell) -> bool {
    let product = |r: Interval| (r.lo * r.lo).min(r.lo * r.hi).min(r.hi * r.hi);
    let least: f64 = (0..3).map(|a| product(cell.net.derivative(a).range())).sum();
    // Far above the rounding of three products, relative to their size.
    least > 0.0
}

/// A zero of f in a leaf, if there is one that tells: where corners have different signs, at a singular point, at a
/// critical point of the other sign, or where the surface reaches through a side of the whole box.
fn zero(f: &UnitPolynomial, leaf: &Leaf, singular: &[Point3], tree: &BoxTree) -> Option<Point3> {
    let corners = leaf.bounds.corners();
    let values = corners.map(|c| f.value(c));
    let (first, rest) = (values[0], &values[1..]);
    if let Some(i) = values.iter().position(|v| *v == 0.0) {
        return Some(corners[i]);
    }
    if let Some(i) = rest.iter().position(|v| v.signum() != first.signum()) {
        return Some(between(f, corners[0], corners[i + 1]));
    }
    if !leaf.smooth {
        let mut inside = Vec::new();
        tree.visit(|b| b.overlaps(&leaf.bounds), |i| inside.push(i));
        if let Some(i) = inside.iter().min() {
            return Some(singular[*i]);
        }
        let critical = critical_point(f, &leaf.bounds)?;
        return (f.value(critical).signum() != first.signum()).then(|| between(f, critical, corners[0]));
    }
    let on_side =
        (0..3).any(|a| leaf.bounds.min[a] <= f.bounds.min[a] || leaf.bounds.max[a] >= f.bounds.max[a]);
    // What reaches in from a neighbour is part of what is there.
    let is_on_side = |p: &Point3| (0..3).any(|a| p[a] <= f.bounds.min[a] || p[a] >= f.bounds.max[a]);
    on_side.then(|| lowest(f, &leaf.bounds, first.signum())).flatten().filter(is_on_side)
}

/// A zero on the segment between two points at which f has different signs.
fn between(f: &UnitPolynomial, a: Point3, b: Point3) -> Point3 {
    let sign = f.value(a).signum();
    let (mut low, mut high) = (0.0, 1.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return a + low * (b - a);
        }
        if f.value(a + middle * (b - a)).signum() == sign { low = middle } else { high = middle }
    }
}

/// A critical point of f in a box, by Newton's method from its centre.
fn critical_point(f: &UnitPolynomial, bounds: &Aabb) -> Option<Point3> {
    let mut at = bounds.center();
    for _ in 0..STEPS {
        let taylor = f.taylor(at);
        let step = taylor.hessian().lu().solve(&taylor.gradient())?;
        at -= step;
        if (at - bounds.center()).norm() > bounds.diagonal() {
            return None;
        }
        if step.norm() <= f64::EPSILON {
            break;
        }
    }
    bounds.contains(&at).then_some(at)
}

/// The point of a box at which `sign` · f is smallest, if that is not positive to rounding: projected gradient steps.
fn lowest(f: &UnitPolynomial, bounds: &Aabb, sign: f64) -> Option<Point3> {
    let clamp = |p: Point3| p.sup(&bounds.min).inf(&bounds.max);
    let mut at = bounds.center();
    let (mut value, mut gradient) = f.gradient(at);
    let mut length = bounds.diagonal() / gradient.norm().max(f64::MIN_POSITIVE);
    for _ in 0..STEPS {
        let trial = clamp(at - length * sign * gradient);
        let (v, g) = f.gradient(trial);
        if sign * v < sign * value {
            (at, value, gradient) = (trial, v, g);
            length *= 1.5;
        } else {
            length *= 0.4;
        }
        if sign * value <= 0.0 {
            break;
        }
    }
    (sign * value <= TAU * f.magnitude()).then_some(at)
}

/// One zero of each set of leaves that hang together.
fn seeds(f: &UnitPolynomial, leaves: &[Leaf]) -> Vec<Point3> {
    let boxes: Vec<Aabb> = leaves.iter().map(|leaf| leaf.bounds).collect();
    let tree = BoxTree::new(&boxes);
    let links: Vec<Vec<usize>> = leaves
        .par_iter()
        .evenly()
        .enumerate()
        .map(|(i, leaf)| {
            let mut near = Vec::new();
            tree.visit(|b| b.overlaps(&leaf.bounds), |j| near.push(j));
            near.retain(|&j| j > i && linked(f, leaf, &leaves[j]));
            near
        })
        .collect();
    let mut parent: Vec<usize> = (0..leaves.len()).collect();
    for (i, near) in links.iter().enumerate() {
        for &j in near {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut seeds: Vec<Option<Point3>> = vec![None; leaves.len()];
    for (i, leaf) in leaves.iter().enumerate() {
        let root = root(&mut parent, i);
        seeds[root] = seeds[root].or(leaf.zero);
    }
    let mut seeds: Vec<Point3> = seeds.into_iter().flatten().map(|p| f.model(p)).collect();
    seeds.sort_by(super::find::lexicographic);
    seeds
}

/// Does the zero set pass from one of two leaves that touch into the other?
fn linked(f: &UnitPolynomial, a: &Leaf, b: &Leaf) -> bool {
    // A rough leaf without a zero of its own may lie between two others; so may a smooth one that is larger than they are.
    if !a.smooth && !b.smooth {
        return true;
    }
    let common = a.bounds.common(&b.bounds);
    let flat = (0..3).filter(|i| common.min[*i] >= common.max[*i]).count();
    if flat > 1 {
        return false;
    }
    let holds = |leaf: &Leaf, other: &Leaf| {
        is_cap(f, leaf) && other.zero.is_some() && leaf.zero.is_some_and(|p| other.bounds.contains(&p))
    };
    if holds(a, b) || holds(b, a) {
        return true;
    }
    // Between smooth leaves the corners of the common side tell; elsewhere it is looked at more closely.
    let intervals = if a.smooth && b.smooth && !is_cap(f, a) && !is_cap(f, b) { 1 } else { CLOSER };
    let coordinate =
        |i: usize, k: usize| common.min[i] + (common.max[i] - common.min[i]) * k as f64 / intervals as f64;
    let steps = |i: usize| if common.min[i] < common.max[i] { 0..=intervals } else { 0..=0 };
    let (mut below, mut above) = (false, false);
    for i in steps(0) {
        for j in steps(1) {
            for k in steps(2) {
                let value = f.value(Point3::new(coordinate(0, i), coordinate(1, j), coordinate(2, k)));
                below |= value <= 0.0;
                above |= value >= 0.0;
            }
        }
    }
    below && above
}

/// Has a smooth leaf a zero, though its corners have one sign?
fn is_cap(f: &UnitPolynomial, leaf: &Leaf) -> bool {
    let values = leaf.bounds.corners().map(|c| f.value(c));
    values.iter().all(|v| *v > 0.0) || values.iter().all(|v| *v < 0.0)
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}
