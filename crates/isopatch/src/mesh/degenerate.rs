//! Faces that are none: repeated corners, the corners of another face, corners on a line.

use super::polygons::{Edges, Polygons};
use super::repairs::{Log, Place, RepairKind};
use super::walls::other_sides;
use crate::geom::{Point3, Vec3};
use rayon::slice::ParallelSliceMut;
use std::collections::HashMap;

/// A face has no area if it is at most this fraction of the square of its longest edge: a hundred times what
/// rounding leaves of the cross product of parallel vectors of about that size.
pub(super) const FLATNESS: f64 = 1e-13;

/// Rounds of stitching flat faces; a flat face may have a flat neighbour, which the next round comes to.
const STITCHING_ROUNDS: usize = 8;

/// Does a face name a vertex twice, or has it fewer than three corners? Time O(n log n) in its corners.
pub(super) fn has_repeated_corner(corners: &[u32]) -> bool {
    if corners.len() < 3 {
        return true;
    }
    if let [a, b, c] = corners {
        return a == b || b == c || c == a;
    }
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).any(|pair| pair[0] == pair[1])
}

/// Calls `emit` with the simple loops of a closed walk that have three corners or more.
///
/// `a b b c` becomes `a b c`; a spike `… a b a …` disappears; a figure eight `a b c a d e` becomes two loops.
fn simple_loops(walk: &[u32], mut emit: impl FnMut(&[u32])) {
    let mut path: Vec<u32> = Vec::with_capacity(walk.len());
    let mut place = HashMap::new();
    for v in walk {
        if let Some(i) = place.get(v).copied() {
            if path.len() - i >= 3 {
                emit(&path[i..]);
            }
            path.drain(i + 1..).for_each(|u| _ = place.remove(&u));
        } else {
            place.insert(*v, path.len());
            path.push(*v);
        }
    }
    if path.len() >= 3 {
        emit(&path);
    }
}

/// The faces as simple loops.
pub(super) fn without_repeated_corners(polygons: Polygons, log: &mut Log) -> Polygons {
    if !polygons.iter().any(|(_, corners)| has_repeated_corner(corners)) {
        return polygons;
    }
    let mut kept = Polygons::with_capacity(polygons.len(), polygons.corners().len());
    for (source, corners) in polygons.iter() {
        if has_repeated_corner(corners) {
            log.note(RepairKind::RepeatedCorner, Place::Face(source));
            simple_loops(corners, |face| kept.push(source, face.iter().copied()));
        } else {
            kept.push(source, corners.iter().copied());
        }
    }
    kept
}

/// The corners of a face from its smallest, in the direction of its smaller neighbour: the same for faces that
/// differ in start and orientation only.
fn canonical(corners: &[u32]) -> impl Iterator<Item = u32> + '_ {
    let n = corners.len();
    let start = (0..n).min_by_key(|i| corners[*i]).unwrap_or(0);
    let forward = corners[(start + 1) % n] <= corners[(start + n - 1) % n];
    (0..n).map(move |i| corners[(start + if forward { i } else { n - i }) % n])
}

/// Pairs of a face and the first one with the same corners in the same order or the reverse. Faces must not be empty.
pub(super) fn duplicates(polygons: &Polygons) -> Vec<[usize; 2]> {
    let mut keys = Polygons::with_capacity(polygons.len(), polygons.corners().len());
    for (source, corners) in polygons.iter() {
        keys.push(source, canonical(corners));
    }
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.par_sort_unstable_by(|a, b| keys.face(*a).cmp(keys.face(*b)).then(a.cmp(b)));
    let mut pairs = Vec::new();
    for group in order.chunk_by(|a, b| keys.face(*a) == keys.face(*b)) {
        pairs.extend(group[1..].iter().map(|f| [*f, group[0]]));
    }
    pairs.sort_unstable();
    pairs
}

/// The faces without those that have the corners of an earlier one; those on the other side of a wall between two bodies
/// stay.
pub(super) fn without_duplicates(polygons: Polygons, log: &mut Log) -> Polygons {
    let pairs = duplicates(&polygons);
    if pairs.is_empty() {
        return polygons;
    }
    let mut dropped = vec![false; polygons.len()];
    let is_other_side = other_sides(&polygons, &pairs);
    for ([f, kept], _) in pairs.into_iter().zip(is_other_side).filter(|(_, is_other_side)| !is_other_side) {
        dropped[f] = true;
        let place = Place::FaceLike(polygons.source(f), polygons.source(kept));
        log.note(RepairKind::DuplicateFace, place);
    }
    filtered(&polygons, |f| !dropped[f])
}

fn filtered(polygons: &Polygons, keep: impl Fn(usize) -> bool) -> Polygons {
    let mut kept = Polygons::with_capacity(polygons.len(), polygons.corners().len());
    for (f, (source, corners)) in polygons.iter().enumerate().filter(|(f, _)| keep(*f)) {
        debug_assert_eq!(polygons.source(f), source);
        kept.push(source, corners.iter().copied());
    }
    kept
}

/// Twice the area vector of a polygon (Newell's), relative to its first corner.
pub(super) fn area_vector(positions: &[Point3], corners: &[u32]) -> Vec3 {
    let p = |i: usize| positions[corners[i] as usize] - positions[corners[0] as usize];
    (1..corners.len().saturating_sub(1)).map(|i| p(i).cross(&p(i + 1))).sum()
}

/// Has the polygon no area? The middle corner of a triangle without one, and so on, lie on a line.
pub(super) fn is_flat(positions: &[Point3], corners: &[u32]) -> bool {
    let longest = (0..corners.len())
        .map(|i| positions[corners[i] as usize] - positions[corners[(i + 1) % corners.len()] as usize])
        .map(|edge| edge.norm_squared())
        .fold(0.0, f64::max);
    area_vector(positions, corners).norm() <= FLATNESS * longest
}

/// Drops faces without area. Where faces lie on both sides of one, its middle corner becomes a corner of the face
/// beyond its longest edge (a triangle becomes two), so that no slit is left.
pub(super) fn without_flat_faces(mut polygons: Polygons, positions: &[Point3], log: &mut Log) -> Polygons {
    for _ in 0..STITCHING_ROUNDS {
        let flat: Vec<bool> = polygons.iter().map(|(_, corners)| is_flat(positions, corners)).collect();
        if !flat.contains(&true) {
            return polygons;
        }
        match stitching_round(&polygons, &flat, positions, log) {
            // Parts of a face that was split may be there already.
            Some(changed) => polygons = without_duplicates(changed, log),
            None => break,
        }
    }
    for (source, _) in polygons.iter().filter(|(_, corners)| is_flat(positions, corners)) {
        log.note(RepairKind::FlatFaceKept, Place::Face(source));
    }
    polygons
}

/// Deals with the flat faces that have no other in the way; none if there are none of those.
fn stitching_round(
    polygons: &Polygons,
    flat: &[bool],
    positions: &[Point3],
    log: &mut Log,
) -> Option<Polygons> {
    let edges = Edges::new(polygons);
    let mut edge_of = vec![0u32; edges.half_edge_count()];
    for (e, half_edges) in edges.iter().enumerate() {
        half_edges.iter().for_each(|h| edge_of[*h as usize] = e as u32);
    }
    let at = |h: usize| edges.of(edge_of[h] as usize);
    let mut changed: HashMap<usize, Vec<Vec<u32>>> = HashMap::new();
    for f in (0..polygons.len()).filter(|f| flat[*f]) {
        let range = polygons.range(f);
        let length = |h: &usize| {
            (positions[edges.dest[*h] as usize] - positions[edges.origin[*h] as usize]).norm_squared()
        };
        let Some(longest) = range.clone().max_by(|a, b| length(a).total_cmp(&length(b))) else { continue };
        let short_are_free = range.clone().filter(|h| *h != longest).all(|h| at(h).len() == 1);
        let source = Place::Face(polygons.source(f));
        if changed.contains_key(&f) {
            continue;
        }
        if short_are_free || at(longest).len() == 1 {
            changed.insert(f, Vec::new());
            log.note(RepairKind::FlatFace, source);
            continue;
        }
        let ([g, h], 3) = (at(longest), range.len()) else { continue };
        let g = if *g as usize == longest { *h as usize } else { *g as usize };
        let neighbour = edges.face[g] as usize;
        let middle = edges.dest[edges.next[longest] as usize];
        let taken = flat[neighbour] || changed.contains_key(&neighbour);
        if taken || polygons.face(neighbour).contains(&middle) {
            continue;
        }
        changed.insert(neighbour, with_corner(polygons, neighbour, g, middle));
        changed.insert(f, Vec::new());
        log.note(RepairKind::FlatFaceStitched, source);
    }
    if changed.is_empty() {
        return None;
    }
    let mut result = Polygons::with_capacity(polygons.len(), polygons.corners().len());
    for (f, (source, corners)) in polygons.iter().enumerate() {
        match changed.get(&f) {
            Some(faces) => faces.iter().for_each(|face| result.push(source, face.iter().copied())),
            None => result.push(source, corners.iter().copied()),
        }
    }
    Some(result)
}

/// A face with one more corner in the middle of half edge `h`; a triangle becomes two.
fn with_corner(polygons: &Polygons, face: usize, h: usize, middle: u32) -> Vec<Vec<u32>> {
    let range = polygons.range(face);
    let mut corners = polygons.face(face).to_vec();
    corners.rotate_left(h - range.start);
    match corners[..] {
        [a, b, apex] => vec![vec![a, middle, apex], vec![middle, b, apex]],
        _ => {
            corners.insert(1, middle);
            vec![corners]
        }
    }
}
