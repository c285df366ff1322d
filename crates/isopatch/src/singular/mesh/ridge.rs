//! Ridges: close to a pinch point the surface turns back on itself within a short way. An edge across such a ridge has ends
//! whose normals are all but opposite, and a smooth patch over it would have to make that turn. Its ends are joined in a
//! vertex on the ridge, from which the surface falls off to both sides, or they give way to their neighbours.

use std::collections::BTreeSet;

use super::decimate::{Limits, State};
use super::flip::flip;
use super::mend::{divide_edge, mend, turned};
use super::quality::Judge;
use super::singular_mesh::{EdgeTag, SingularMesh, VertexKind};
use super::split::onto_surface;
use crate::field::Field;
use crate::geom::{Point3, Vec3};

/// Cosine of the angle between the normals at the ends of an edge from which it is taken to cross a ridge (105°).
const TURNS_BACK: f64 = -0.26;
/// Farthest way of the ridge from the middle of the edge, in its length: a hairpin may be much deeper than it is wide.
const REACH: f64 = 20.0;
/// First step of the search for it, and the factor of each that follows.
const FIRST_STEP: f64 = 0.1;
const GROWTH: f64 = 1.3;
/// Then bisections.
const BISECTIONS: usize = 50;
/// Normals that are opposite to within this leave no direction between them.
const LEAST_LEAN: f64 = 1e-3;

/// Edges that are shorter than this share of the tolerance are joined as well: what they show can't be seen, and patches there are slivers.
const SHORT: f64 = 0.02;
/// Triangles that a change may turn over when others are tried.
const ON_THE_WAY: usize = 2;
/// Passes over all such edges.
const PASSES: usize = 10;

/// A vertex that comes to lie elsewhere, after another has been collapsed into it or not.
struct Change {
    from: Option<u32>,
    to: u32,
    at: Point3,
}

/// What is wrong with some triangles, the worst first.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Faults {
    /// Triangles that turn over.
    turned: usize,
    /// Edges across ridges, or too short.
    across: usize,
    /// 1 less the least cosine of an angle between triangle and surface.
    steepest: f64,
}

/// Joins, collapses or moves the ends of edges across ridges where that leaves fewer of them, and no more triangles that turn over; the
/// number of changes. What is left is tried again with triangles that turn over on the way.
pub(super) fn onto_ridges(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) -> usize {
    let count = changes(field, mesh, limits, 0);
    let (left, was_turned) = (across_ridges(field, mesh, limits).len(), turned(field, mesh).len());
    if left > 0 {
        let mut tried = mesh.clone();
        let more = changes(field, &mut tried, limits, ON_THE_WAY);
        mend(field, &mut tried, limits);
        if turned(field, &tried).len() <= was_turned && across_ridges(field, &tried, limits).len() < left {
            *mesh = tried;
            return count + more;
        }
    }
    count
}

fn changes(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits, allowed: usize) -> usize {
    let mut count = 0;
    for _ in 0..PASSES {
        let (changed, blocking) = pass(field, mesh, limits, allowed);
        // Ends that both have an edge to some other vertex can't be joined before there is a vertex on one of these edges.
        let divided = blocking.iter().filter(|ends| divide_edge(field, mesh, **ends)).count();
        if changed + divided == 0 {
            break;
        }
        count += changed + divided;
        if divided == 0 {
            flip(field, mesh, limits);
        }
    }
    count
}

/// Makes changes that do not touch each other; how many, and the edges that are in the way of others.
fn pass(
    field: &dyn Field,
    mesh: &mut SingularMesh,
    limits: Limits,
    allowed: usize,
) -> (usize, Vec<[u32; 2]>) {
    let edges = across_ridges(field, mesh, limits);
    if edges.is_empty() {
        return (0, Vec::new());
    }
    let (base, mut moved) = (mesh.clone(), mesh.clone());
    let mut state = State::new(field, &base, limits);
    let mut touched = vec![false; base.positions.len()];
    let mut count = 0;
    let mut blocking: Vec<[Point3; 2]> = Vec::new();
    for (ends, normals) in edges {
        let around = ends.iter().flat_map(|v| state.neighbours(*v));
        if around.chain(ends).any(|v| touched[v as usize]) {
            continue;
        }
        let Some(change) = best_change(field, &base, &state, ends, normals, limits, allowed) else {
            let beside = state.beside(ends[0], ends[1]);
            let at = |v: u32| base.positions[v as usize];
            blocking.extend(beside.into_iter().map(|w| [at(ends[0]), at(w)]));
            continue;
        };
        for v in change.from.into_iter().chain([change.to]) {
            touched[v as usize] = true;
            state.neighbours(v).into_iter().for_each(|w| touched[w as usize] = true);
        }
        moved.positions[change.to as usize] = change.at;
        if let Some(from) = change.from {
            state.collapse(from, change.to);
        }
        count += 1;
    }
    *mesh = state.finish(&moved);
    // Vertices have new numbers.
    let number = |p: &Point3| mesh.positions.iter().position(|q| q == p).map(|v| v as u32);
    let blocking = blocking.iter().filter_map(|[p, q]| Some([number(p)?, number(q)?]));
    (count, blocking.map(|[a, b]| [a.min(b), a.max(b)]).collect())
}

/// The change after which the fewest faults are left, if that is better than before.
fn best_change(
    field: &dyn Field,
    mesh: &SingularMesh,
    state: &State<'_>,
    ends: [u32; 2],
    normals: [Vec3; 2],
    limits: Limits,
    allowed: usize,
) -> Option<Change> {
    let [a, b] = ends;
    let mut changes = Vec::new();
    if let Some(at) = ridge_point(field, mesh, ends, normals) {
        changes.extend([
            Change { from: Some(a), to: b, at },
            Change { from: None, to: a, at },
            Change { from: None, to: b, at },
        ]);
    }
    for from in ends {
        for to in state.neighbours(from) {
            changes.push(Change { from: Some(from), to, at: mesh.positions[to as usize] });
        }
    }
    let better = changes.into_iter().filter_map(|change| {
        let (before, after) = stars(state, &change);
        let old = |v: u32| mesh.positions[v as usize];
        let new = |v: u32| if v == change.to { change.at } else { mesh.positions[v as usize] };
        let is_possible = change.from.is_none_or(|from| state.keeps_topology(from, change.to));
        let (was, is) =
            (faults(field, mesh, &before, &old, limits), faults(field, mesh, &after, &new, limits));
        let is_better = is_possible && is.turned <= was.turned + allowed && is.across < was.across;
        (is_better && is_near(field, &after, &new, limits)).then_some((is, change))
    });
    better
        .min_by(|(a, _), (b, _)| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal))
        .map(|(_, change)| change)
}

/// The triangles that a change touches, before and after it.
fn stars(state: &State<'_>, change: &Change) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
    let mut before: Vec<[u32; 3]> = state.corners_around(change.to).collect();
    let Some(from) = change.from else { return (before.clone(), before) };
    before.extend(state.corners_around(from).filter(|c| !c.contains(&change.to)));
    let after = before.iter().filter(|c| !(c.contains(&from) && c.contains(&change.to)));
    let after = after.map(|c| c.map(|v| if v == from { change.to } else { v })).collect();
    (before, after)
}

fn faults(
    field: &dyn Field,
    mesh: &SingularMesh,
    triangles: &[[u32; 3]],
    position: &dyn Fn(u32) -> Point3,
    limits: Limits,
) -> Faults {
    let normal = |v: u32| match mesh.vertices[v as usize] {
        VertexKind::Regular => field.gradient(position(v)).1.try_normalize(0.0),
        _ => None,
    };
    let mut found = Faults { turned: 0, across: 0, steepest: 0.0 };
    let mut edges = BTreeSet::new();
    for t in triangles {
        let [p, q, r] = t.map(position);
        let flat = (q - p).cross(&(r - p)).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let normals = t.map(normal);
        let least = normals.iter().flatten().map(|n| n.dot(&flat)).fold(1.0, f64::min);
        found.turned += usize::from(least <= 0.0);
        found.steepest = found.steepest.max(1.0 - least);
        for k in 0..3 {
            let (i, j) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
            let corners = [p, q, r];
            let is_short = (corners[k] - corners[(k + 1) % 3]).norm() < SHORT * limits.tolerance;
            let ends = (normals[k], normals[(k + 1) % 3]);
            let is_bad = matches!(ends, (Some(n), Some(m)) if is_short || n.dot(&m) < TURNS_BACK);
            if is_bad && edges.insert([i, j]) {
                found.across += 1;
            }
        }
    }
    found
}

fn is_near(
    field: &dyn Field,
    triangles: &[[u32; 3]],
    position: &dyn Fn(u32) -> Point3,
    limits: Limits,
) -> bool {
    triangles.iter().all(|t| {
        // Only this triangle is looked at: its corners under new numbers.
        let positions = t.map(position);
        Judge::new(field, &positions, &[VertexKind::Regular; 3], limits).is_near([0, 1, 2])
    })
}

/// Smooth edges across ridges, and those that are too short, the shortest first, with the normals at their ends.
fn across_ridges(field: &dyn Field, mesh: &SingularMesh, limits: Limits) -> Vec<([u32; 2], [Vec3; 2])> {
    let normal = |v: u32| field.gradient(mesh.positions[v as usize]).1.try_normalize(0.0);
    let is_free =
        |v: &u32| mesh.vertices[*v as usize] == VertexKind::Regular && mesh.sides[*v as usize].is_empty();
    let length =
        |ends: &[u32; 2]| (mesh.positions[ends[0] as usize] - mesh.positions[ends[1] as usize]).norm();
    let edges = mesh.edges();
    let smooth = edges.iter().filter(|(ends, t)| mesh.tag(**ends, t.len()) == EdgeTag::Smooth);
    let mut found: Vec<([u32; 2], [Vec3; 2])> = smooth
        .filter(|(ends, _)| ends.iter().all(is_free))
        .filter_map(|(ends, _)| Some((*ends, [normal(ends[0])?, normal(ends[1])?])))
        .filter(|(ends, [n, m])| n.dot(m) < TURNS_BACK || length(ends) < SHORT * limits.tolerance)
        .collect();
    found.sort_by(|a, b| length(&a.0).total_cmp(&length(&b.0)).then(a.0.cmp(&b.0)));
    found
}

/// Where the surface turns: outwards from the middle of the edge, in the direction between the normals.
fn ridge_point(field: &dyn Field, mesh: &SingularMesh, ends: [u32; 2], [n, m]: [Vec3; 2]) -> Option<Point3> {
    let [p, q] = ends.map(|v| mesh.positions[v as usize]);
    let chord = q - p;
    let between = n + m - chord * ((n + m).dot(&chord) / chord.norm_squared());
    // Normals point to where f > 0. Where they point away from each other f < 0 between them, and they lean outwards.
    let start = 0.5 * (p + q);
    let inside = field.value(start);
    let direction = between.try_normalize(LEAST_LEAN)? * if inside < 0.0 { 1.0 } else { -1.0 };
    let is_inside = |way: f64| (field.value(start + direction * way) > 0.0) == (inside > 0.0);
    let (mut near, mut far) = (0.0, FIRST_STEP * chord.norm());
    while is_inside(far) {
        (near, far) = (far, GROWTH * far);
        if far > REACH * chord.norm() {
            return None;
        }
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (near + far);
        if is_inside(middle) { near = middle } else { far = middle }
    }
    onto_surface(field, start + direction * far, &[])
}
