//! Which closed components lie inside others.

use super::orient::Flood;
use super::polygons::Polygons;
use crate::geom::{Aabb, Point3, Vec3};

/// Most solid angles that are computed, for all components together: about a second.
const SOLID_ANGLES: usize = 20_000_000;

/// Where a component lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nesting {
    /// In no other component, or in an even number of them.
    Outside,
    /// In an odd number of others: the surface of a void.
    Inside,
    /// Not found out: there are too many components.
    Unknown,
}

/// Where each component in question lies relative to the closed ones; the others count as outside.
///
/// The first corner of a component stands for all of it: components that cross each other have no better answer. It is
/// inside another one if the solid angle of that, with the faces as the flood turns them, is not zero.
pub(super) fn nesting(
    polygons: &Polygons,
    positions: &[Point3],
    flood: &Flood,
    closed: &[bool],
    in_question: &[bool],
) -> Vec<Nesting> {
    let mut found = vec![Nesting::Outside; flood.count()];
    if closed.iter().filter(|c| **c).count() < 2 || !in_question.contains(&true) {
        return found;
    }
    let (faces, boxes) = by_component(polygons, positions, flood);
    let mut left = SOLID_ANGLES;
    for c in (0..flood.count()).filter(|c| in_question[*c]) {
        let p = positions[polygons.face(flood.first[c] as usize)[0] as usize];
        let mut around = false;
        // A comparison of boxes costs about as much as a solid angle.
        let mut cost = flood.count();
        let candidates: Vec<usize> = if cost > left {
            Vec::new()
        } else {
            (0..flood.count()).filter(|d| *d != c && closed[*d] && boxes[*d].contains(&p)).collect()
        };
        cost += candidates.iter().map(|d| faces[*d].len()).sum::<usize>();
        if cost > left {
            found[c] = Nesting::Unknown;
            continue;
        }
        left -= cost;
        for d in candidates {
            let angle: f64 =
                faces[d].iter().map(|f| seen_angle(&p, *f as usize, polygons, positions, flood)).sum();
            around ^= angle.abs() > std::f64::consts::TAU;
        }
        if around {
            found[c] = Nesting::Inside;
        }
    }
    found
}

fn by_component(polygons: &Polygons, positions: &[Point3], flood: &Flood) -> (Vec<Vec<u32>>, Vec<Aabb>) {
    let mut faces = vec![Vec::new(); flood.count()];
    let mut boxes = vec![Aabb::EMPTY; flood.count()];
    for (f, (_, corners)) in polygons.iter().enumerate() {
        let c = flood.component[f] as usize;
        faces[c].push(f as u32);
        boxes[c] = corners.iter().fold(boxes[c], |b, v| b.including(&positions[*v as usize]));
    }
    (faces, boxes)
}

/// The signed solid angle of a face seen from a point, as a fan of triangles; 4π for all of a surface around the point.
fn seen_angle(p: &Point3, f: usize, polygons: &Polygons, positions: &[Point3], flood: &Flood) -> f64 {
    let corners = polygons.face(f);
    let to = |i: usize| positions[corners[i] as usize] - p;
    let angle: f64 = (1..corners.len() - 1).map(|i| solid_angle(&to(0), &to(i), &to(i + 1))).sum();
    if flood.turned[f] { -angle } else { angle }
}

/// The signed solid angle of a triangle seen from the origin (A. van Oosterom, J. Strackee, 1983).
fn solid_angle(a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let above = a.dot(&b.cross(c));
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * above.atan2(below)
}
