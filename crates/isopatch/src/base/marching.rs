//! The zero set of a piecewise linear function on tetrahedra: marching tetrahedra.
//!
//! Neighbouring tetrahedra share their triangles, and each is cut by at most one triangle or quadrilateral: the result
//! is a manifold without self-intersections, and its boundary lies in the boundary of the leaves.

use super::clip::{BoxSides, Clip};
use super::cover::{Cover, Nodes};
use super::error::BaseError;
use super::numbering::Numbering;
use super::octree::node_of;
use super::tetrahedra::for_tetrahedra;
use super::triangle_mesh::TriangleMesh;
use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Share of an edge of a tetrahedron at both of its ends where no vertex is put: it keeps triangles from collapsing
/// when the surface passes (nearly) through a node. Projection moves the vertices onto the surface anyway.
const END_GAP: f64 = 0.1;

/// Where f vanishes on an edge between values of different sign, as a share of its length.
fn crossing(f0: f64, f1: f64) -> f64 {
    let t = f0 / (f0 - f1);
    if t.is_finite() { t.clamp(END_GAP, 1.0 - END_GAP) } else { 0.5 }
}

/// Even permutations of the corners of a tetrahedron that put one corner first, and two.
const ONE_FIRST: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];
const TWO_FIRST: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];

/// The vertex on an edge between two nodes.
fn vertex(cover: &Cover<'_>, nodes: &Nodes, edge: u64) -> Point3 {
    let [a, b] = [edge >> 32, edge & u64::from(u32::MAX)].map(|n| n as usize);
    let [p, q] = [a, b].map(|n| cover.lattice.position(node_of(nodes.places[n])));
    p + crossing(nodes.values[a], nodes.values[b]) * (q - p)
}

/// Leaves that one task looks at.
const TASK: usize = 128;

/// Appends the tetrahedra of a leaf that the surface passes through, by the numbers of their corners.
fn crossed(cover: &Cover<'_>, nodes: &Nodes, leaf: usize, found: &mut Vec<[usize; 4]>) {
    let cell = &cover.leaves[leaf].cell;
    if !nodes.is_crossed(leaf, cell) {
        return;
    }
    let values = nodes.local_values(leaf, cell);
    for_tetrahedra(cell, nodes.sets[leaf], |corners| {
        let is_inside = corners.map(|n| values[n] < 0.0);
        if is_inside.contains(&true) && is_inside.contains(&false) {
            found.push(corners.map(|n| nodes.number(leaf, cell, n)));
        }
    });
}

/// The mesh of f = 0 as far as the nodes know it; f < 0 counts as inside, all else (zero and NaN too) as outside.
///
/// `bounds` is the box that cuts the surface. Fails if f has no value at a node beside the inside.
pub(super) fn march(cover: &Cover<'_>, nodes: &Nodes, bounds: &Aabb) -> Result<TriangleMesh, BaseError> {
    let leaves = (0..cover.leaves.len()).into_par_iter().evenly_by(TASK);
    let of_tasks = leaves.fold(Vec::new, |mut found, leaf| {
        crossed(cover, nodes, leaf, &mut found);
        found
    });
    let crossed = of_tasks.collect::<Vec<_>>().concat();
    let polygons: Vec<Polygon> =
        crossed.par_iter().evenly_by(TASK).map(|corners| cut(*corners, nodes)).collect();
    let mut edges = Vec::with_capacity(4 * polygons.len());
    polygons.iter().for_each(|polygon| edges.extend(polygon.edges()));
    let (Numbering { keys, .. }, numbers) = Numbering::of(&edges);
    let positions: Vec<Point3> =
        keys.par_iter().evenly_by(TASK).map(|edge| vertex(cover, nodes, *edge)).collect();
    let mut faces = Vec::with_capacity(2 * polygons.len());
    let mut rest = &numbers[..];
    for polygon in &polygons {
        let (corners, after) = rest.split_at(polygon.count);
        faces.extend(triangles(polygon, corners, &positions));
        rest = after;
    }
    if let Some(n) = crossed.into_iter().flatten().find(|n| nodes.values[*n].is_nan()) {
        let place = nodes.places[n];
        let share = nodes.values.iter().filter(|f| f.is_nan()).count() as f64 / nodes.values.len() as f64;
        return Err(BaseError::Undefined { share, at: Some(cover.lattice.position(node_of(place))) });
    }
    let sides: Vec<BoxSides> =
        positions.par_iter().evenly_by(TASK).map(|p| BoxSides::of(p, bounds)).collect();
    let is_clipped = sides.iter().any(|s| !s.is_empty());
    let clip = is_clipped.then_some(Clip { bounds: *bounds, sides });
    Ok(TriangleMesh { positions, faces, clip })
}

/// The part of the surface in one tetrahedron: the edges between nodes that its corners lie on.
struct Polygon {
    edges: [u64; 4],
    /// Three or four.
    count: usize,
    /// Are the corners clockwise seen from outside?
    is_clockwise: bool,
}

impl Polygon {
    fn edges(&self) -> &[u64] {
        &self.edges[..self.count]
    }
}

/// Cuts a tetrahedron; its corners are positively oriented.
fn cut(corners: [usize; 4], nodes: &Nodes) -> Polygon {
    let is_inside = corners.map(|n| nodes.values[n] < 0.0);
    let edge = |(a, b): (usize, usize)| (a.min(b) as u64) << 32 | a.max(b) as u64;
    let count = is_inside.iter().filter(|inside| **inside).count();
    if count == 2 {
        let order =
            TWO_FIRST.into_iter().find(|o| is_inside[o[0]] && is_inside[o[1]]).unwrap_or(TWO_FIRST[0]);
        let [a, b, c, d] = order.map(|k| corners[k]);
        let edges = [(a, c), (a, d), (b, d), (b, c)].map(edge);
        return Polygon { edges, count: 4, is_clockwise: false };
    }
    let single = count == 1;
    let order = ONE_FIRST.into_iter().find(|o| is_inside[o[0]] == single).unwrap_or(ONE_FIRST[0]);
    let [a, b, c, d] = order.map(|k| corners[k]);
    Polygon { edges: [(a, b), (a, c), (a, d), (a, d)].map(edge), count: 3, is_clockwise: !single }
}

/// The triangles of a polygon, counter-clockwise seen from outside; one with four corners is cut along its shorter diagonal.
fn triangles(polygon: &Polygon, corners: &[u32], positions: &[Point3]) -> impl Iterator<Item = [u32; 3]> {
    let length = |v: u32, w: u32| (positions[v as usize] - positions[w as usize]).norm_squared();
    let of = match *corners {
        [p, q, r, s] if length(q, s) < length(p, r) => [Some([q, r, s]), Some([q, s, p])],
        [p, q, r, s] => [Some([p, q, r]), Some([p, r, s])],
        [p, q, r] if polygon.is_clockwise => [Some([p, r, q]), None],
        [p, q, r] => [Some([p, q, r]), None],
        _ => [None; 2],
    };
    of.into_iter().flatten()
}
