//! Where expansions start.

use super::front::{FAIR, Front, FrontEdge, GOOD, POOR, Vertex};
use super::plane::Plane;
use super::sheet::{Sheet, sign_changes};
use crate::geom::{Point3, Vec3};
use std::f64::consts::TAU;

/// Directions in which sheets are looked for around a wall.
const AROUND: usize = 180;
/// A seed this flat on a triangle, relative to its edges, is covered by it.
const COVERED: f64 = 0.35;
/// Normals of one sheet have at least this product.
const SAME_SHEET: f64 = 0.3;

/// The foot of a seed, if it is a smooth point in the box.
pub(super) fn start(sheet: &Sheet<'_>, seed: Point3) -> Option<Point3> {
    let p = sheet.foot(seed)?;
    let near = (p - seed).norm() < 0.1 * sheet.bounds.diagonal();
    (near && !sheet.is_outside(&p) && sheet.normal(p).is_some()).then_some(p)
}

/// Puts a triangle on each half-sheet that ends in a segment of a wall. The strips that they make are where the expansion
/// starts from singular curves: what the paper stitches in the end fits from the beginning.
pub(super) fn strips(front: &mut Front<'_>) {
    let walls = front.walls;
    for [a, b] in &walls.segments {
        let (p, q) = (front.at(*a), front.at(*b));
        let (middle, along, length) = ((p + q) / 2.0, (q - p).normalize(), (q - p).norm());
        let mut branches = half_sheets(front.sheet, p, q);
        // Those that have a triangle already, from a neighbouring segment.
        let away = |p: &Point3| ((p - middle) - along * along.dot(&(p - middle))).normalize();
        for c in front.thirds(*a, *b) {
            let there = away(&front.at(c));
            let nearest = |i: &usize, j: &usize| {
                away(&branches[*j]).dot(&there).total_cmp(&away(&branches[*i]).dot(&there))
            };
            if let Some(i) = (0..branches.len()).min_by(nearest) {
                branches.remove(i);
            }
        }
        for c in branches {
            let Some(normal) = front.sheet.normal(c) else { continue };
            let is_left = (q - p).cross(&(c - p)).dot(&normal) > 0.0;
            let edge = if is_left { (*a, *b) } else { (*b, *a) };
            front.edges.insert(edge, FrontEdge { normal, center: c });
            let made = [GOOD, FAIR, POOR]
                .into_iter()
                .find_map(|demand| front.attach_beside_wall(edge, c, length, demand));
            if made.is_none() {
                front.edges.remove(&edge);
            }
        }
    }
}

/// A point on each half-sheet that ends in the segment from p to q of a wall.
pub(super) fn half_sheets(sheet: &Sheet<'_>, p: Point3, q: Point3) -> Vec<Point3> {
    let (middle, along, length) = ((p + q) / 2.0, (q - p).normalize(), (q - p).norm());
    let plane = Plane::new(middle, along.cross(&any_other(&along)), along);
    on_circle(sheet, &plane, HEIGHT * length)
}

/// Height of these triangles, in lengths of the segment: that of an equilateral one.
const HEIGHT: f64 = 0.866;

/// Puts a fan of triangles around each point of the walls without segments, on every sheet that ends there: a ring goes along
/// the link, the curve in which a small sphere cuts the surface.
pub(super) fn fans(front: &mut Front<'_>, radius: f64) {
    for (i, p) in front.walls.points.iter().enumerate() {
        if front.walls.segments.iter().any(|segment| segment.contains(&(i as u32))) {
            continue;
        }
        let mut rings: Vec<Vec<Point3>> = Vec::new();
        for start in beside(front.sheet, p, radius) {
            let is_new = rings.iter().flatten().all(|q| (q - start).norm() > 0.7 * radius);
            if is_new && let Some(ring) = link(front.sheet, p, start, radius) {
                rings.push(ring);
            }
        }
        for ring in rings {
            fan(front, i as u32, &ring);
        }
    }
}

/// The closed curve through `start` in which a sphere about p cuts the surface, as points at about the radius from each
/// other.
fn link(sheet: &Sheet<'_>, p: &Point3, start: Point3, radius: f64) -> Option<Vec<Point3>> {
    let step = LINK_STEP * radius;
    let mut walk = vec![start];
    for n in 0..LINK_STEPS {
        let at = walk[n];
        let along = sheet.field.gradient(at).1.cross(&(at - p)).try_normalize(0.0)?;
        walk.push(on_sphere(sheet, p, radius, at + along * step)?);
        if n > 2 && (walk[n + 1] - start).norm() < step {
            let count = ((n + 1) as f64 * LINK_STEP * POINTS).ceil().max(3.0) as usize;
            return Some((0..count).map(|k| walk[k * (n + 1) / count]).collect());
        }
    }
    None
}

/// Points of a ring, per radius of its length.
const POINTS: f64 = 1.4;
/// A step along a link, in units of its radius, and the most steps.
const LINK_STEP: f64 = 0.05;
const LINK_STEPS: usize = 2000;

/// Newton's method for a point that is on the surface and on a sphere.
fn on_sphere(sheet: &Sheet<'_>, center: &Point3, radius: f64, mut p: Point3) -> Option<Point3> {
    for _ in 0..SPHERE_STEPS {
        let radial = (p - center).try_normalize(0.0)?;
        p = center + radial * radius;
        let (f, gradient) = sheet.field.gradient(p);
        let g = gradient - radial * gradient.dot(&radial);
        let step = g * (f / g.norm_squared());
        if !step.iter().all(|c| c.is_finite()) || step.norm() > radius {
            return None;
        }
        p -= step;
        if step.norm() <= f64::EPSILON * radius {
            break;
        }
    }
    Some(p)
}

/// Newton steps on a sphere.
const SPHERE_STEPS: usize = 20;

fn fan(front: &mut Front<'_>, center: u32, ring: &[Point3]) {
    if ring.iter().any(|q| front.sheet.is_outside(q) || front.sheet.normal(*q).is_none()) {
        return;
    }
    let first = front.vertices.len() as u32;
    let n = ring.len() as u32;
    for q in ring {
        let vertex = Vertex { at: *q, normal: front.sheet.normal(*q), sides: front.sheet.sides(q) };
        front.vertices.push(vertex);
    }
    for k in 0..n {
        let [u, v] = [first + k, first + (k + 1) % n];
        let normal = (front.at(u) - front.at(center)).cross(&(front.at(v) - front.at(center)));
        let is_left = front.normal(u).is_some_and(|n| n.dot(&normal) > 0.0);
        front.add_triangle(if is_left { [center, u, v] } else { [center, v, u] }, ring[k as usize]);
    }
}

/// Points on the sheets that meet in a point: zeros of f on circles about it.
fn beside(sheet: &Sheet<'_>, p: &Point3, r: f64) -> Vec<Point3> {
    let axes = [Vec3::new(0.3, 0.5, 0.8), Vec3::new(0.8, -0.5, 0.3), Vec3::new(-0.5, 0.8, 0.3)];
    axes.iter()
        .flat_map(|n| on_circle(sheet, &Plane::new(*p, n.cross(&Vec3::x()), n.normalize()), r))
        .collect()
}

fn any_other(v: &Vec3) -> Vec3 {
    Vec3::ith(v.iamin(), 1.0)
}

/// Zeros of f on a circle in a plane.
fn on_circle(sheet: &Sheet<'_>, plane: &Plane, r: f64) -> Vec<Point3> {
    // Not through the axes, where zeros like to be.
    let at = |t: f64| plane.lift([r * ((t + SHIFT) * TAU).cos(), r * ((t + SHIFT) * TAU).sin()]);
    sign_changes(|t| sheet.field.value(at(t)), AROUND).into_iter().map(at).collect()
}

/// Where a circle starts, in turns.
const SHIFT: f64 = 0.0137;

/// Is a point of the surface on a part that has triangles?
pub(super) fn is_covered(front: &Front<'_>, p: &Point3) -> bool {
    let Some(normal) = front.sheet.normal(*p) else { return true };
    front.triangles.iter().any(|t| {
        let [a, b, c] = t.map(|v| front.at(v));
        let along = (b - a).cross(&(c - a));
        let size = (b - a).norm().max((c - a).norm()).max((c - b).norm());
        if (p - a).norm() > 2.0 * size || along.norm() == 0.0 || along.normalize().dot(&normal) < SAME_SHEET {
            return false;
        }
        let n = along.normalize();
        let flat = (p - a).dot(&n).abs() < COVERED * size;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(u, v)| n.dot(&(v - u).cross(&(p - u))) > -0.05 * (v - u).norm() * size);
        flat && inside
    })
}
