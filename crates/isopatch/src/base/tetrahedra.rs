//! Leaves of an octree cut into tetrahedra that fit together, also where a leaf meets smaller ones.
//!
//! A leaf is cut from its centre: each tetrahedron has the centre and a triangle of the leaf's surface. A side with nothing
//! special is cut along one diagonal; one with nodes of finer leaves on it is cut from its middle:
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
//!
//! With these diagonals a leaf beside no finer ones can also be cut without its centre, into six tetrahedra around the
//! space diagonal from its one corner with three even coordinates to the one with three odd ones (Kuhn's subdivision): half
//! as many triangles, but gradients are worse.

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
    pub(super) const NONE: Self = Self(0);
    /// Only the corners: six tetrahedra.
    pub(super) const CORNERS: Self =
        Self(1 | 1 << 2 | 1 << 6 | 1 << 8 | 1 << 18 | 1 << 20 | 1 << 24 | 1 << 26);
    /// Corners and centre: twelve tetrahedra.
    pub(super) const PLAIN: Self = Self(Self::CORNERS.0 | 1 << CENTER);
    /// How many these are.
    pub(super) const PLAIN_COUNT: usize = 9;

    /// Is nothing of it between corners?
    pub(super) fn is_plain(self) -> bool {
        self.0 | Self::PLAIN.0 == Self::PLAIN.0
    }

    pub(super) fn contains(self, node: usize) -> bool {
        self.0 >> node & 1 == 1
    }

    pub(super) fn with(self, node: usize) -> Self {
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

/// Calls `visit` with the corners of every tetrahedron, positively oriented.
pub(super) fn for_tetrahedra(cell: &Cell, nodes: NodeSet, mut visit: impl FnMut([usize; 4])) {
    if !nodes.contains(CENTER) {
        around_diagonal(cell, visit);
        return;
    }
    for side in 0..6 {
        let upper = side % 2 == 1;
        let mut outward =
            |[p, q, r]: [usize; 3]| visit(if upper { [CENTER, p, q, r] } else { [CENTER, p, r, q] });
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

/// The six ways from the even corner to the odd one along edges.
fn around_diagonal(cell: &Cell, mut visit: impl FnMut([usize; 4])) {
    const WAYS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let is_odd = [0, 1, 2].map(|axis| cell.corner[axis] / cell.edge() % 2 == 1);
    let even = is_odd.map(|odd| if odd { 2 } else { 0 });
    let mirrored = is_odd.iter().filter(|odd| **odd).count() % 2 == 1;
    let number = |at: [usize; 3]| at[0] + 3 * at[1] + 9 * at[2];
    for (i, way) in WAYS.into_iter().enumerate() {
        let mut at = even;
        let mut corners = [number(at); 4];
        for (corner, axis) in corners[1..].iter_mut().zip(way) {
            at[axis] = 2 - at[axis];
            *corner = number(at);
        }
        // The last three ways are odd permutations.
        if (i >= 3) != mirrored {
            corners.swap(2, 3);
        }
        visit(corners);
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Six times the volume, in units of half edges.
    fn volume(corners: [usize; 4]) -> i64 {
        let [o, a, b, c] = corners.map(|n| local(n).map(i64::from));
        let [a, b, c] = [a, b, c].map(|p| [p[0] - o[0], p[1] - o[1], p[2] - o[2]]);
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    fn cells() -> [Cell; 8] {
        Cell { corner: [0; 3], level: 3 }.children()
    }

    #[test]
    fn tetrahedra_fill_the_cell() {
        let sets = [
            NodeSet::CORNERS,
            NodeSet::PLAIN,
            NodeSet::beside_finer(|n| n == 1),
            NodeSet::beside_finer(|n| [4, 1, 3].contains(&n)),
            NodeSet::beside_finer(|n| n != CENTER),
        ];
        for cell in cells() {
            for set in sets {
                let mut volumes = Vec::new();
                for_tetrahedra(&cell, set, |t| volumes.push(volume(t)));
                assert!(volumes.iter().all(|v| *v > 0), "{volumes:?}");
                assert_eq!(volumes.iter().sum::<i64>(), 48);
            }
        }
    }

    /// Triangles on the surface of a block of cells belong to one tetrahedron, those inside to two.
    #[test]
    fn cells_share_their_triangles_however_they_are_cut() {
        for pattern in 0..256 {
            let mut uses = HashMap::new();
            for (i, cell) in cells().iter().enumerate() {
                let set = if pattern >> i & 1 == 1 { NodeSet::CORNERS } else { NodeSet::PLAIN };
                for_tetrahedra(cell, set, |t| {
                    let nodes = t.map(|n| cell.node(local(n)));
                    for left_out in 0..4 {
                        let mut triangle: Vec<_> =
                            (0..4).filter(|k| *k != left_out).map(|k| nodes[k]).collect();
                        triangle.sort_unstable();
                        *uses.entry(triangle).or_insert(0) += 1;
                    }
                });
            }
            let extent = 2 * cells()[0].edge();
            for (triangle, count) in uses {
                let is_outside = (0..3)
                    .any(|a| [0, extent].iter().any(|side| triangle.iter().all(|node| node[a] == *side)));
                assert_eq!(count, if is_outside { 1 } else { 2 });
            }
        }
    }
}
