//! The box as cells of an octree, small enough for the surface in each to be known from its boundary.
//!
//! A cell away from the singular set is a leaf when bounds show that f has no zero in it, or that f rises along one
//! direction everywhere in it, so that the surface there is a graph. A cell that holds a centre (a singular point, or where
//! singular arcs begin) or a piece of one arc is a leaf when it holds nothing else; it must be small enough for the surface
//! to be a cone there, which is checked by what is found on its boundary. Cells next to these are small, too; bounds can not
//! tell anything about them.

use std::collections::{HashMap, HashSet};

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::arcs::{Arc, Piece, PieceEnd, divide, joined_at_seams};
use super::grid::{Cell, Node, Tree};
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};

/// A point from which the surface is a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Center {
    pub(super) at: Point3,
    /// Are there sheets at it? Not at an isolated point.
    pub(super) has_sheets: bool,
    /// In how many parts the surface meets a small sphere around it, where that is known.
    pub(super) parts: Option<usize>,
}

/// What the partition has to respect.
pub(super) struct Skeleton {
    pub(super) centers: Vec<Center>,
    pub(super) arcs: Vec<Arc>,
    /// The whole arcs.
    pub(super) pieces: Vec<Piece>,
    /// Points all over the singular set.
    pub(super) samples: Vec<Point3>,
}

/// What a leaf holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// f rises along a direction.
    Graph(Vec3),
    /// Nothing is certain; singularities are near, or the cell is as small as cells get.
    Uncertain,
    /// A piece of an arc that goes from one side to another.
    Arc(Piece),
    /// A centre and the pieces of arcs that end there.
    Center(usize, Vec<Piece>),
}

/// How fine the partition is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fineness {
    /// Largest distance between a graph and flat triangles, a length (estimated).
    pub(super) chord: f64,
    /// Least level of all cells, of cells near arcs, and near centres.
    pub(super) levels: [u8; 3],
    /// Highest level.
    pub(super) deepest: u8,
}

/// The parts of the singular set in and near a cell.
#[derive(Clone, Debug, Default)]
struct Inside {
    pieces: Vec<Piece>,
    centers: Vec<usize>,
    near: Vec<u32>,
}

/// An octree whose leaves have a content.
pub(super) struct Partition<'a> {
    field: &'a dyn Field,
    skeleton: &'a Skeleton,
    fineness: Fineness,
    pub(super) tree: Tree,
    pub(super) leaves: HashMap<Cell, Content>,
    inside: HashMap<Cell, Inside>,
}

enum Verdict {
    Empty,
    Split,
    Leaf(Content),
}

/// The gradient turns by at most this in a leaf that is a graph, in radians (estimated).
const LARGEST_TURN: f64 = 0.8;
/// Height of a chord over the length times the turn of the normal, of a circle.
const CHORD_FACTOR: f64 = 0.125;
/// Most cells: beyond, the surface has singularities that are not in the set, and cells there are as small as they may be.
const MOST_CELLS: usize = 60_000;
/// Cells nearer to the singular set than this many of their edges are excused from bounds.
const NEAR: f64 = 2.0;

impl<'a> Partition<'a> {
    /// Divides the box. `ratio` is where edges of cells are divided.
    pub(super) fn new(
        field: &'a dyn Field,
        bounds: &Aabb,
        skeleton: &'a Skeleton,
        fineness: Fineness,
        ratio: [f64; 3],
    ) -> Self {
        let mut partition = Self {
            field,
            skeleton,
            fineness,
            tree: Tree::new(*bounds, ratio),
            leaves: HashMap::new(),
            inside: HashMap::new(),
        };
        let all = Inside {
            pieces: skeleton.pieces.clone(),
            centers: (0..skeleton.centers.len()).collect(),
            near: (0..skeleton.samples.len() as u32).collect(),
        };
        partition.grow(vec![(Cell::ROOT, all)]);
        partition
    }

    /// Divides leaves.
    pub(super) fn split(&mut self, cells: &HashSet<Cell>) {
        let mut cells: Vec<Cell> = cells.iter().copied().collect();
        cells.sort_unstable();
        let mut frontier = Vec::new();
        for cell in cells {
            self.leaves.remove(&cell);
            let Some(inside) = self.inside.remove(&cell) else { continue };
            self.tree.nodes.insert(cell, Node::Inner);
            frontier.extend(self.divided(cell, &inside));
        }
        self.grow(frontier);
    }

    /// Are there too many cells to go on?
    pub(super) fn is_full(&self, more: usize) -> bool {
        self.leaves.len() + more > MOST_CELLS
    }

    /// Leaves of which nothing is certain although no singularity is known near them.
    pub(super) fn lost(&self) -> Vec<Cell> {
        let is_lost = |cell: &Cell| {
            self.leaves[cell] == Content::Uncertain
                && self.inside.get(cell).is_some_and(|i| i.near.is_empty())
        };
        self.tree.leaves().into_iter().filter(is_lost).collect()
    }

    fn grow(&mut self, mut frontier: Vec<(Cell, Inside)>) {
        while !frontier.is_empty() {
            let is_full = self.is_full(frontier.len());
            let verdicts: Vec<Verdict> = frontier
                .par_iter()
                .evenly()
                .map(|(cell, inside)| self.verdict(*cell, inside, is_full))
                .collect();
            let mut next = Vec::new();
            for ((cell, inside), verdict) in frontier.into_iter().zip(verdicts) {
                match verdict {
                    Verdict::Empty => {
                        self.tree.nodes.insert(cell, Node::Empty);
                    }
                    Verdict::Split => {
                        self.tree.nodes.insert(cell, Node::Inner);
                        next.extend(self.divided(cell, &inside));
                    }
                    Verdict::Leaf(content) => {
                        self.tree.nodes.insert(cell, Node::Leaf);
                        self.leaves.insert(cell, content);
                        self.inside.insert(cell, inside);
                    }
                }
            }
            frontier = next;
        }
    }

    fn divided(&self, cell: Cell, inside: &Inside) -> Vec<(Cell, Inside)> {
        let children = cell.children();
        let mut parts: Vec<Inside> = children.iter().map(|_| Inside::default()).collect();
        for piece in &inside.pieces {
            for (child, part) in divide(&self.skeleton.arcs, piece, &self.tree, cell) {
                parts[child].pieces.push(part);
            }
        }
        let boxes = children.map(|child| self.tree.bounds_of(child));
        for c in &inside.centers {
            let at = self.skeleton.centers[*c].at;
            let middle = boxes[7].min;
            let child: usize = (0..3).map(|a| usize::from(at[a] >= middle[a]) << a).sum();
            parts[child].centers.push(*c);
        }
        for (child, part) in parts.iter_mut().enumerate() {
            let reach = NEAR * boxes[child].size().max();
            let is_near = |s: &&u32| {
                boxes[child].distance_squared(&self.skeleton.samples[**s as usize]) <= reach * reach
            };
            part.near = inside.near.iter().filter(is_near).copied().collect();
        }
        children.into_iter().zip(parts).collect()
    }

    fn verdict(&self, cell: Cell, inside: &Inside, is_full: bool) -> Verdict {
        let bounds = self.tree.bounds_of(cell);
        let is_deepest = is_full || cell.level >= self.fineness.deepest;
        if inside.centers.is_empty() && inside.pieces.is_empty() {
            let (f, gradient) = self.field.linear_gradient_range(&bounds);
            if f.excludes_zero() {
                return Verdict::Empty;
            }
            if cell.level < self.fineness.levels[0] {
                return Verdict::Split;
            }
            // ∇f in model units: the forms are for coordinates in half edges only in their slopes.
            if let Some((direction, turn)) = rising(&gradient) {
                let chord = CHORD_FACTOR * bounds.diagonal() * turn;
                let is_fine = turn <= LARGEST_TURN && chord <= self.fineness.chord;
                return if is_fine || is_deepest {
                    Verdict::Leaf(Content::Graph(direction))
                } else {
                    Verdict::Split
                };
            }
            let is_near = !inside.near.is_empty() && cell.level >= self.fineness.levels[1];
            return if is_near || is_deepest { Verdict::Leaf(Content::Uncertain) } else { Verdict::Split };
        }
        if is_deepest {
            return Verdict::Leaf(self.single(inside).unwrap_or(Content::Uncertain));
        }
        let least = self.fineness.levels[if inside.centers.is_empty() { 1 } else { 2 }];
        match self.single(inside) {
            Some(content) if cell.level >= least => Verdict::Leaf(content),
            _ => Verdict::Split,
        }
    }

    /// The one thing that a cell holds, if it is only one.
    fn single(&self, inside: &Inside) -> Option<Content> {
        let pieces = joined_at_seams(&self.skeleton.arcs, &inside.pieces);
        let plane = |e: &PieceEnd| matches!(e, PieceEnd::Plane { .. });
        match (&inside.centers[..], &pieces[..]) {
            ([], [piece]) => {
                let crosses = piece.ends.iter().all(plane) && piece.ends[0] != piece.ends[1];
                crosses.then_some(Content::Arc(*piece))
            }
            ([center], pieces) => {
                let own = PieceEnd::Center(*center);
                let leaves = |p: &Piece| {
                    (p.ends[0] == own && plane(&p.ends[1])) || (p.ends[1] == own && plane(&p.ends[0]))
                };
                pieces.iter().all(leaves).then(|| Content::Center(*center, pieces.to_vec()))
            }
            _ => None,
        }
    }
}

/// A direction along which f rises everywhere in a cell, and a bound on how far ∇f turns away from it.
fn rising(gradient: &[crate::geom::Affine; 3]) -> Option<(Vec3, f64)> {
    let center = Vec3::from_fn(|a, _| gradient[a].center);
    let norm = center.norm();
    if !(norm.is_finite() && norm > 0.0) {
        return None;
    }
    let direction = center / norm;
    // The component along the direction: parts that the three share are added before their size is taken.
    let shared: f64 =
        (0..3).map(|j| (0..3).map(|a| direction[a] * gradient[a].slope[j]).sum::<f64>().abs()).sum();
    let errors: f64 = (0..3).map(|a| direction[a].abs() * gradient[a].error).sum();
    /// Bounds the rounding of these few sums.
    const ROUNDING: f64 = 64.0 * f64::EPSILON;
    let least = norm - shared - errors - ROUNDING * (norm + shared + errors);
    let spread = Vec3::from_fn(|a, _| gradient[a].radius()).norm();
    (least > 0.0).then(|| (direction, (spread / norm).atan()))
}
