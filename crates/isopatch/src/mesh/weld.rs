//! Vertices at one place become one, where the mesh is open.

use super::polygons::{Edges, Joined};
use crate::geom::Point3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Tolerances below this fraction of the diagonal mean exact equality: coordinates of the size of the diagonal are
/// no finer than that, and the cells of the grid would have numbers that `i64` can't tell apart.
const EXACT: f64 = 1e-15;

/// Width of a cell of the grid in tolerances: a ball of that radius then meets three or four cells on average, not 27.
const CELL_WIDTH: f64 = 4.0;

/// For every vertex the one that takes its place: itself, or a vertex with a smaller number.
///
/// A vertex takes part if it is on an edge that has not two faces; a vertex with faces all around needs no partner,
/// and two of them that touch would make a non-manifold vertex. The ends of an edge that is no longer than the
/// tolerance become one in any case. `tolerance` is a length; a vertex goes to the smallest number within it among
/// those that stay, so vertices do not creep along a chain. With a tolerance of 0, coordinates must be equal.
///
/// `diagonal` is that of the bounding box. Vertices must be finite where faces use them. Time O(n) on average.
pub(super) fn weld(positions: &[Point3], edges: &Edges, tolerance: f64, diagonal: f64) -> Vec<u32> {
    let mut takes_part = vec![false; positions.len()];
    for half_edges in edges.iter().filter(|h| h.len() != 2) {
        edges.ends(half_edges[0]).iter().for_each(|v| takes_part[*v as usize] = true);
    }
    let candidates = (0..positions.len() as u32).filter(|v| takes_part[*v as usize]);
    let tolerance = if tolerance > EXACT * diagonal { tolerance } else { 0.0 };
    let mut joined = Joined::new(positions.len());
    for [v, kept] in coincident(positions, candidates, tolerance) {
        joined.join(v, kept);
    }
    for half_edges in edges.iter() {
        let [a, b] = edges.ends(half_edges[0]).map(|v| joined.root(v));
        if a != b && (positions[a as usize] - positions[b as usize]).norm() <= tolerance {
            joined.join(a, b);
        }
    }
    (0..positions.len() as u32).map(|v| joined.root(v)).collect()
}

/// Pairs of a vertex and the earlier one at its place: exactly, or within a tolerance above 0.
pub(super) fn coincident(
    positions: &[Point3],
    candidates: impl Iterator<Item = u32>,
    tolerance: f64,
) -> Vec<[u32; 2]> {
    if tolerance > 0.0 { within(positions, candidates, tolerance) } else { equal(positions, candidates) }
}

fn equal(positions: &[Point3], candidates: impl Iterator<Item = u32>) -> Vec<[u32; 2]> {
    let mut first = HashMap::new();
    let mut pairs = Vec::new();
    for v in candidates {
        // Adding 0 turns -0 into 0.
        let key: [u64; 3] = (positions[v as usize].add_scalar(0.0)).map(f64::to_bits).into();
        match first.entry(key) {
            Entry::Occupied(kept) => pairs.push([v, *kept.get()]),
            Entry::Vacant(free) => _ = free.insert(v),
        }
    }
    pairs
}

/// Vertices that stay are further apart than the tolerance, so a cell holds no more than some hundred of them.
fn within(positions: &[Point3], candidates: impl Iterator<Item = u32>, tolerance: f64) -> Vec<[u32; 2]> {
    let cell = |p: Point3| p.map(|x| (x / (CELL_WIDTH * tolerance)).floor() as i64);
    let cells_around = |p: &Point3| {
        let (lo, hi) = (cell(p.add_scalar(-tolerance)), cell(p.add_scalar(tolerance)));
        (lo.x..=hi.x)
            .flat_map(move |x| (lo.y..=hi.y).flat_map(move |y| (lo.z..=hi.z).map(move |z| [x, y, z])))
    };
    let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut pairs = Vec::new();
    for v in candidates {
        let p = &positions[v as usize];
        let near = cells_around(p)
            .filter_map(|c| kept.get(&c))
            .flatten()
            .filter(|k| (positions[**k as usize] - p).norm() <= tolerance)
            .min();
        match near {
            Some(k) => pairs.push([v, *k]),
            None => kept.entry(cell(*p).into()).or_default().push(v),
        }
    }
    pairs
}
