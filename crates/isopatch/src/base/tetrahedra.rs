//! Leaves of an octree cut into tetrahedra that fit together, also where a leaf meets smaller ones.
//!
//! Every leaf is cut from its centre: each tetrahedron has the centre and a triangle of the leaf's surface. A side with
//! nothing special is cut along one diagonal; one with nodes of finer leaves on it is cut from its middle:
//!
//! ```text
//!    ┌──────┐      ┌──────┐      ┌───┬──┐
//!    │    ╱ │      │╲    ╱│      │╲  │ ╱│
//!    │  ╱   │      │  ╳───┤      ├───╳  │
//!    │╱     │      │╱    ╲│      │╱    ╲│
//!    └──────┘      └──────┘      └──────┘
//!    the plain     one node      two nodes, or the
//!    diagonal      on an edge    middle and them
//! ```
//!
//! The diagonal runs through the corner that is the middle of the side of a cell twice as large: a leaf and its coarser
//! neighbour then cut their common square alike. Nodes on an edge are those that some leaf has as a corner, the same for
//! all leaves around the edge.

use super::octree::Cell;

/// The 27 nodes of a leaf, (i, j, k) at i + 3j + 9k: corners have even coordinates.
pub(super) const LOCAL_NODES: usize = 27;
/// The centre.
pub(super) const CENTER: usize = 13;

/// Coordinates of a local node, 0 to 2.
pub(super) fn local(index: usize) -> [u32; 3] {
    [index as u32 % 3, index as u32 / 3 % 3, index as u32 / 9]
}

/// Which nodes of a leaf are in use, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NodeSet(u32);

impl NodeSet {
    /// Corners and centre.
    pub(super) const PLAIN: Self =
        Self(1 << CENTER | 1 | 1 << 2 | 1 << 6 | 1 << 8 | 1 << 18 | 1 << 20 | 1 << 24 | 1 << 26);

    pub(super) fn contains(self, node: usize) -> bool {
        self.0 >> node & 1 == 1
    }

    fn with(self, node: usize) -> Self {
        Self(self.0 | 1 << node)
    }

    /// The nodes in it, ascending.
    pub(super) fn iter(self) -> impl Iterator<Item = usize> {
        (0..LOCAL_NODES).filter(move |n| self.contains(*n))
    }

    /// Corners, centre, and the nodes on edges and sides that leaves have as corners or that the cut of a side needs.
    pub(super) fn beside_finer(is_corner: impl Fn(usize) -> bool) -> Self {
        let mut set = Self::PLAIN;
        for node in 0..LOCAL_NODES {
            if node != CENTER && !set.contains(node) && is_corner(node) {
                set = set.with(node);
            }
        }
        for side in 0..6 {
            let ring = ring(side);
            if (1..8).step_by(2).any(|i| set.contains(ring[i])) {
                set = set.with(middle(side));
            }
        }
        set
    }
}

/// Side 2a + s is where coordinate a is 0 (s = 0) or 2 (s = 1).
fn on_side(side: usize, b: u32, c: u32) -> usize {
    let (axis, upper) = (side / 2, side % 2);
    let mut at = [0; 3];
    at[axis] = 2 * upper as u32;
    at[(axis + 1) % 3] = b;
    at[(axis + 2) % 3] = c;
    (at[0] + 3 * at[1] + 9 * at[2]) as usize
}

/// The middle of a side.
pub(super) fn middle(side: usize) -> usize {
    on_side(side, 1, 1)
}

/// The nodes around a side, counter-clockwise seen from the upper end of its axis; corners have even places.
pub(super) fn ring(side: usize) -> [usize; 8] {
    [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)].map(|(b, c)| on_side(side, b, c))
}

/// Calls `visit` with the three nodes of every triangle on the surface of the leaf, counter-clockwise seen from outside.
/// With the centre, each makes a tetrahedron.
pub(super) fn for_triangles(cell: &Cell, nodes: NodeSet, mut visit: impl FnMut([usize; 3])) {
    for side in 0..6 {
        let upper = side % 2 == 1;
        let mut outward = |[p, q, r]: [usize; 3]| visit(if upper { [p, q, r] } else { [p, r, q] });
        let ring = ring(side);
        let middle = middle(side);
        if nodes.contains(middle) {
            let mut last = ring[0];
            for node in (1..9).map(|i| ring[i % 8]).filter(|n| nodes.contains(*n)) {
                outward([middle, last, node]);
                last = node;
            }
        } else {
            let first = diagonal_start(cell, side);
            let [p, q, r, s] = [0, 2, 4, 6].map(|i| ring[(first + i) % 8]);
            outward([p, q, r]);
            outward([p, r, s]);
        }
    }
}

/// Place in the ring of the corner from which the diagonal of a side starts: the one with odd coordinates, counted in
/// edges of the cell.
fn diagonal_start(cell: &Cell, side: usize) -> usize {
    let is_odd = |axis: usize| cell.corner[axis] / cell.edge() % 2 == 1;
    let axis = side / 2;
    match (is_odd((axis + 1) % 3), is_odd((axis + 2) % 3)) {
        // The lower corner is odd, or the upper one.
        (true, true) => 0,
        (false, true) => 2,
        (false, false) => 4,
        (true, false) => 6,
    }
}
