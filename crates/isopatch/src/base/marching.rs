//! The zero set of a piecewise linear function on tetrahedra: marching tetrahedra.
//!
//! Neighbouring tetrahedra share their triangles, and each is cut by at most one triangle or quadrilateral: the result
//! is a manifold without self-intersections, and its boundary lies in the boundary of the leaves.

use super::clip::{BoxSides, Clip};
use super::cover::{Cover, Nodes};
use super::error::BaseError;
use super::octree::{KeyMap, node_of};
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

/// Vertices on the edges between nodes, as they are asked for.
struct Vertices<'a> {
    cover: &'a Cover<'a>,
    nodes: &'a Nodes,
    on_edge: KeyMap<u32>,
    positions: Vec<Point3>,
}

impl Vertices<'_> {
    fn on(&mut self, a: usize, b: usize) -> u32 {
        let (a, b) = (a.min(b), a.max(b));
        *self.on_edge.entry((a as u64) << 32 | b as u64).or_insert_with(|| {
            let [p, q] = [a, b].map(|n| self.cover.lattice.position(node_of(self.nodes.places[n])));
            let t = crossing(self.nodes.values[a], self.nodes.values[b]);
            self.positions.push(p + t * (q - p));
            self.positions.len() as u32 - 1
        })
    }
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
    let mut vertices = Vertices { cover, nodes, on_edge: KeyMap::default(), positions: Vec::new() };
    let mut faces = Vec::new();
    crossed.iter().for_each(|corners| cut(*corners, &mut vertices, &mut faces));
    if let Some(n) = crossed.into_iter().flatten().find(|n| nodes.values[*n].is_nan()) {
        let place = nodes.places[n];
        let share = nodes.values.iter().filter(|f| f.is_nan()).count() as f64 / nodes.values.len() as f64;
        return Err(BaseError::Undefined { share, at: Some(cover.lattice.position(node_of(place))) });
    }
    let positions = vertices.positions;
    let sides: Vec<BoxSides> = positions.iter().map(|p| BoxSides::of(p, bounds)).collect();
    let is_clipped = sides.iter().any(|s| !s.is_empty());
    let clip = is_clipped.then_some(Clip { bounds: *bounds, sides });
    Ok(TriangleMesh { positions, faces, clip })
}

/// The part of the surface in one tetrahedron, counter-clockwise seen from outside; the corners are positively oriented.
fn cut(corners: [usize; 4], vertices: &mut Vertices<'_>, faces: &mut Vec<[u32; 3]>) {
    let is_inside = corners.map(|n| vertices.nodes.values[n] < 0.0);
    let count = is_inside.iter().filter(|inside| **inside).count();
    if count == 2 {
        let order =
            TWO_FIRST.into_iter().find(|o| is_inside[o[0]] && is_inside[o[1]]).unwrap_or(TWO_FIRST[0]);
        let [a, b, c, d] = order.map(|k| corners[k]);
        let quad = [(a, c), (a, d), (b, d), (b, c)].map(|(p, q)| vertices.on(p, q));
        let length = |i: usize, j: usize| {
            (vertices.positions[quad[i] as usize] - vertices.positions[quad[j] as usize]).norm_squared()
        };
        let first = usize::from(length(1, 3) < length(0, 2));
        let [p, q, r, s] = [0, 1, 2, 3].map(|k| quad[(k + first) % 4]);
        faces.extend([[p, q, r], [p, r, s]]);
    } else {
        let single = count == 1;
        let order = ONE_FIRST.into_iter().find(|o| is_inside[o[0]] == single).unwrap_or(ONE_FIRST[0]);
        let [a, b, c, d] = order.map(|k| corners[k]);
        let [p, q, r] = [b, c, d].map(|other| vertices.on(a, other));
        faces.push(if single { [p, q, r] } else { [p, r, q] });
    }
}
