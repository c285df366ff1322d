//! An octree over the box, whose cells, faces and edges are known by whole numbers.

use std::collections::HashMap;

use crate::geom::{Aabb, Point3};

/// Levels that numbers can express. Coordinates are whole numbers from 0 to 2^LEVELS.
pub(super) const LEVELS: u8 = 24;
/// 2^LEVELS.
pub(super) const SPAN: u32 = 1 << LEVELS;

/// A cell: a cube in whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Cell {
    pub(super) level: u8,
    /// Its lower corner.
    pub(super) at: [u32; 3],
}

/// A square between two cells, in the plane where coordinate `axis` is `at[axis]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Face {
    pub(super) axis: usize,
    pub(super) level: u8,
    pub(super) at: [u32; 3],
}

/// A segment along `axis`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Edge {
    pub(super) axis: usize,
    pub(super) level: u8,
    pub(super) at: [u32; 3],
}

/// Edge of a cell of that level.
pub(super) fn size(level: u8) -> u32 {
    1 << (LEVELS - level)
}

impl Cell {
    pub(super) const ROOT: Self = Self { level: 0, at: [0; 3] };

    pub(super) fn children(self) -> [Self; 8] {
        let half = size(self.level + 1);
        std::array::from_fn(|n| Self {
            level: self.level + 1,
            at: std::array::from_fn(|a| self.at[a] + if n >> a & 1 == 1 { half } else { 0 }),
        })
    }

    /// The cell of the same size beyond a side; none outside of the box.
    fn neighbour(self, axis: usize, upper: bool) -> Option<Self> {
        let size = size(self.level);
        let mut at = self.at;
        at[axis] = if upper { at[axis] + size } else { at[axis].checked_sub(size)? };
        (at[axis] < SPAN).then_some(Self { at, ..self })
    }

    fn side(self, axis: usize, upper: bool) -> Face {
        let mut at = self.at;
        if upper {
            at[axis] += size(self.level);
        }
        Face { axis, level: self.level, at }
    }
}

impl Face {
    /// The axes of its plane, such that the first, the second and `axis` are right-handed.
    pub(super) fn plane_axes(self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// It has children.
    Inner,
    /// There is no zero of f in it.
    Empty,
    /// It is a cell of the partition.
    Leaf,
}

/// The cells, and where they are.
pub(super) struct Tree {
    pub(super) bounds: Aabb,
    /// Where edges are divided, per axis.
    ratio: [f64; 3],
    pub(super) nodes: HashMap<Cell, Node>,
}

impl Tree {
    pub(super) fn new(bounds: Aabb, ratio: [f64; 3]) -> Self {
        Self { bounds, ratio, nodes: HashMap::new() }
    }

    /// The coordinate of a plane.
    pub(super) fn coordinate(&self, axis: usize, key: u32) -> f64 {
        let (mut lo, mut hi) = (self.bounds.min[axis], self.bounds.max[axis]);
        if key == SPAN {
            return hi;
        }
        for level in (0..LEVELS).rev() {
            if key & ((1 << level) - 1) == 0 && key >> level & 1 == 0 {
                return lo;
            }
            let middle = lo + self.ratio[axis] * (hi - lo);
            if key >> level & 1 == 1 { lo = middle } else { hi = middle }
        }
        lo
    }

    pub(super) fn point(&self, at: [u32; 3]) -> Point3 {
        Point3::from_fn(|a, _| self.coordinate(a, at[a]))
    }

    pub(super) fn bounds_of(&self, cell: Cell) -> Aabb {
        let size = size(cell.level);
        Aabb::new(self.point(cell.at), self.point(cell.at.map(|c| c + size)))
    }

    fn is_inner(&self, cell: Cell) -> bool {
        self.nodes.get(&cell) == Some(&Node::Inner)
    }

    /// The leaves, in order.
    pub(super) fn leaves(&self) -> Vec<Cell> {
        let leaves = self.nodes.iter().filter(|(_, node)| **node == Node::Leaf);
        let mut leaves: Vec<Cell> = leaves.map(|(cell, _)| *cell).collect();
        leaves.sort_unstable();
        leaves
    }

    /// The smallest squares into which cells on either side divide a side of a leaf.
    pub(super) fn faces(&self, cell: Cell, axis: usize, upper: bool) -> Vec<Face> {
        let mut faces = Vec::new();
        match cell.neighbour(axis, upper) {
            Some(next) if self.is_inner(next) => self.collect_faces(next, axis, !upper, &mut faces),
            _ => faces.push(cell.side(axis, upper)),
        }
        faces
    }

    fn collect_faces(&self, cell: Cell, axis: usize, upper: bool, faces: &mut Vec<Face>) {
        if !self.is_inner(cell) {
            return faces.push(cell.side(axis, upper));
        }
        let on_side = |child: &Cell| (child.at[axis] != cell.at[axis]) == upper;
        for child in cell.children().into_iter().filter(on_side) {
            self.collect_faces(child, axis, upper, faces);
        }
    }

    /// The smallest segments into which cells around it divide a segment, in order.
    pub(super) fn segments(&self, edge: Edge, found: &mut Vec<Edge>) {
        let size_here = size(edge.level);
        let [u, v] = [(edge.axis + 1) % 3, (edge.axis + 2) % 3];
        let around = |n: usize| {
            let mut at = edge.at;
            at[u] = if n & 1 == 1 { at[u] } else { at[u].checked_sub(size_here)? };
            at[v] = if n & 2 == 2 { at[v] } else { at[v].checked_sub(size_here)? };
            Some(Cell { level: edge.level, at })
        };
        if (0..4).filter_map(around).any(|cell| self.is_inner(cell)) {
            let level = edge.level + 1;
            let mut upper = edge.at;
            upper[edge.axis] += size(level);
            self.segments(Edge { level, ..edge }, found);
            self.segments(Edge { level, at: upper, ..edge }, found);
        } else {
            found.push(edge);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_in_order_and_the_same_at_every_level() {
        let bounds = Aabb::new(Point3::new(-1.0, 0.0, 2.0), Point3::new(1.0, 3.0, 7.0));
        let tree = Tree::new(bounds, [0.487, 0.509, 0.494]);
        assert_eq!(tree.point([0, SPAN, SPAN]), Point3::new(-1.0, 3.0, 7.0));
        let middle = tree.coordinate(0, SPAN / 2);
        assert_eq!(middle, -1.0 + 0.487 * 2.0);
        let planes: Vec<f64> = (0..=64).map(|k| tree.coordinate(1, k * (SPAN / 64))).collect();
        assert!(planes.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn a_coarse_side_is_divided_by_finer_neighbours() {
        let mut tree = Tree::new(Aabb::new(Point3::zeros(), Point3::repeat(1.0)), [0.5; 3]);
        tree.nodes.insert(Cell::ROOT, Node::Inner);
        let children = Cell::ROOT.children();
        for child in children {
            tree.nodes.insert(child, Node::Leaf);
        }
        tree.nodes.insert(children[1], Node::Inner);
        for child in children[1].children() {
            tree.nodes.insert(child, Node::Leaf);
        }
        assert_eq!(tree.faces(children[0], 0, true).len(), 4);
        assert_eq!(tree.faces(children[0], 1, true).len(), 1);
        // The edge of child 2 that it shares with the divided one.
        let mut found = Vec::new();
        tree.segments(Edge { axis: 2, level: 1, at: [SPAN / 2, SPAN / 2, 0] }, &mut found);
        assert_eq!(found.len(), 2);
    }
}
