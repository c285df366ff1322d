//! An octree over a box: cells by integer coordinates, and the balance between neighbours.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Bits of one coordinate in a key: three of them fit into 64 bits.
const COORDINATE_BITS: u32 = 21;

/// Most levels below the roots: with [`MOST_ROOTS`] along a side, the last node has a coordinate of 2¹⁹.
pub(super) const DEEPEST: u32 = 14;

/// Most root cells along a side; in flatter boxes they are no cubes.
const MOST_ROOTS: f64 = 16.0;

/// The nodes that cells can have: a box with integer coordinates.
///
/// The unit is half an edge of the smallest cell, so that centres of cells are nodes too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    pub(super) bounds: Aabb,
    /// Root cells along each axis.
    roots: [u32; 3],
}

/// Integer coordinates of a node.
pub(super) type Node = [u32; 3];

/// A cell: its smallest corner and its level; roots have level 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) corner: Node,
    pub(super) level: u32,
}

/// A node as one number.
pub(super) fn key(node: Node) -> u64 {
    node.iter().fold(0, |key, c| key << COORDINATE_BITS | u64::from(*c))
}

/// The node of a key.
pub(super) fn node_of(key: u64) -> Node {
    const MASK: u64 = (1 << COORDINATE_BITS) - 1;
    [2, 1, 0].map(|i| (key >> (i * COORDINATE_BITS) & MASK) as u32)
}

impl Lattice {
    /// Roots that are cubes as nearly as may be, and fill the box exactly.
    pub(super) fn over(bounds: &Aabb) -> Self {
        let size = bounds.size();
        let edge = size.min().max(size.max() / MOST_ROOTS);
        let roots = [0, 1, 2].map(|i| (size[i] / edge).round().clamp(1.0, MOST_ROOTS) as u32);
        Self { bounds: *bounds, roots }
    }

    /// All root cells, x fastest.
    pub(super) fn root_cells(&self) -> Vec<Cell> {
        let [nx, ny, nz] = self.roots;
        let edge = Cell { corner: [0; 3], level: 0 }.edge();
        let at = |i: u32, j: u32, k: u32| Cell { corner: [i, j, k].map(|c| c * edge), level: 0 };
        (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| at(i, j, k)))).collect()
    }

    /// Number of units along an axis.
    pub(super) fn extent(&self, axis: usize) -> u32 {
        self.roots[axis] << (DEEPEST + 1)
    }

    fn coordinate(&self, axis: usize, c: u32) -> f64 {
        let extent = self.extent(axis);
        let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
        // Shares of a power of two are exact, and so are both ends.
        if c == extent { max } else { min + (max - min) * (f64::from(c) / f64::from(extent)) }
    }

    /// Where a node is; nodes on the sides of the box have the very coordinates of the sides.
    pub(super) fn position(&self, node: Node) -> Point3 {
        Point3::from_fn(|axis, _| self.coordinate(axis, node[axis]))
    }

    /// The box of a cell; boxes of neighbours share coordinates exactly.
    pub(super) fn cell_box(&self, cell: &Cell) -> Aabb {
        let edge = cell.edge();
        Aabb::new(self.position(cell.corner), self.position(cell.corner.map(|c| c + edge)))
    }

    /// For each axis, does the cell touch the lower and the upper side of the box?
    pub(super) fn sides(&self, cell: &Cell) -> [[bool; 2]; 3] {
        [0, 1, 2].map(|a| [cell.corner[a] == 0, cell.corner[a] + cell.edge() == self.extent(a)])
    }

    /// The cell of the same level that is `steps` cells away along each axis, if it is in the box.
    pub(super) fn neighbor(&self, cell: &Cell, steps: [i32; 3]) -> Option<Cell> {
        let mut corner = cell.corner;
        for axis in 0..3 {
            let moved = i64::from(corner[axis]) + i64::from(steps[axis]) * i64::from(cell.edge());
            if moved < 0 || moved >= i64::from(self.extent(axis)) {
                return None;
            }
            corner[axis] = moved as u32;
        }
        Some(Cell { corner, level: cell.level })
    }
}

impl Cell {
    /// Edge length in units of the lattice.
    pub(super) fn edge(&self) -> u32 {
        2 << (DEEPEST - self.level)
    }

    /// The eight cells of the next level; bit a of their number says upper half along axis a.
    pub(super) fn children(&self) -> [Self; 8] {
        let half = self.edge() / 2;
        std::array::from_fn(|c| {
            let corner = [0, 1, 2].map(|a| self.corner[a] + (c as u32 >> a & 1) * half);
            Self { corner, level: self.level + 1 }
        })
    }

    /// The cell of a lower level that it is part of.
    pub(super) fn ancestor(&self, level: u32) -> Self {
        let edge = Self { corner: [0; 3], level }.edge();
        Self { corner: self.corner.map(|c| c & !(edge - 1)), level }
    }

    /// Node (i, j, k) of the 3 × 3 × 3 nodes at corners, middles of edges and faces, and centre.
    pub(super) fn node(&self, local: [u32; 3]) -> Node {
        let half = self.edge() / 2;
        [0, 1, 2].map(|a| self.corner[a] + local[a] * half)
    }
}

/// 2⁶⁴ divided by the golden ratio: Fibonacci hashing (Knuth, The Art of Computer Programming 3, 6.4).
pub(super) const FIBONACCI: u64 = 0x9e37_79b9_7f4a_7c15;

/// Multiplication and a fold: keys are small integers, nobody attacks.
#[derive(Clone, Copy, Default)]
pub(super) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u64(&mut self, key: u64) {
        let product = (self.0 ^ key).wrapping_mul(FIBONACCI);
        self.0 = product ^ product >> 32;
    }
}

/// A map from keys of nodes.
pub(super) type KeyMap<V> = HashMap<u64, V, BuildHasherDefault<KeyHasher>>;

/// What the leaves around say to a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Surroundings {
    /// A leaf two or more levels finer touches it.
    pub(super) too_coarse: bool,
    /// A leaf one level finer touches it.
    pub(super) beside_finer: bool,
}

/// Leaves by the keys of their smallest corners, which no two share.
pub(super) struct Index {
    leaves: Vec<Cell>,
    numbers: KeyMap<u32>,
}

impl Index {
    pub(super) fn of(leaves: Vec<Cell>) -> Self {
        let mut numbers = KeyMap::with_capacity_and_hasher(leaves.len(), BuildHasherDefault::default());
        numbers.extend((0..).zip(&leaves).map(|(i, leaf)| (key(leaf.corner), i)));
        Self { leaves, numbers }
    }

    /// The number of the leaf that is just this cell.
    pub(super) fn find(&self, cell: &Cell) -> Option<usize> {
        let i = *self.numbers.get(&key(cell.corner))? as usize;
        (self.leaves[i].level == cell.level).then_some(i)
    }
}

/// For each leaf, whether finer ones touch it, if only at a corner. Levels differ by one at most if none is too coarse.
pub(super) fn surroundings(lattice: &Lattice, index: &Index) -> Vec<Surroundings> {
    /// Leaves that one task looks at.
    const TASK: usize = 128;
    let leaves = &index.leaves;
    let coarsest = leaves.iter().map(|leaf| leaf.level).min().unwrap_or(0);
    // The coarser leaves beside a leaf, and whether they are much coarser.
    let coarser_beside = |leaf: &Cell| {
        let parent = leaf.ancestor(leaf.level - 1);
        // Cells outside the parent that touch the leaf lie towards the leaf's corner of the parent.
        let toward = [0, 1, 2].map(|a| if leaf.corner[a] == parent.corner[a] { -1 } else { 1 });
        let around = (1..8).filter_map(move |octant| {
            lattice.neighbor(&parent, [0, 1, 2].map(|a| (octant >> a & 1) * toward[a]))
        });
        around.flat_map(move |beside| {
            let levels = coarsest..=beside.level;
            levels.filter_map(move |level| {
                index.find(&beside.ancestor(level)).map(|i| (i, level < beside.level))
            })
        })
    };
    let fine = leaves.par_iter().evenly_by(TASK).filter(|leaf| leaf.level > coarsest);
    let touching: Vec<(usize, bool)> = fine.flat_map_iter(coarser_beside).collect();
    let mut found = vec![Surroundings::default(); leaves.len()];
    for (i, is_much) in touching {
        found[i].too_coarse |= is_much;
        found[i].beside_finer |= !is_much;
    }
    found
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice::over(&Aabb::new(Point3::new(-0.1, 0.2, -3.0), Point3::new(0.3, 0.7, 1.1)))
    }

    #[test]
    fn nodes_fill_the_box_exactly() {
        let lattice = lattice();
        let last = [0, 1, 2].map(|a| lattice.extent(a));
        assert_eq!(lattice.position([0; 3]), lattice.bounds.min);
        assert_eq!(lattice.position(last), lattice.bounds.max);
        let cells = lattice.root_cells();
        assert_eq!(cells.len(), 10);
        let volume: f64 = cells.iter().map(|c| lattice.cell_box(c).size().product()).sum();
        assert!((volume - lattice.bounds.size().product()).abs() < 1e-14);
        assert!(cells.iter().all(|c| node_of(key(c.corner)) == c.corner && c.ancestor(0) == *c));
    }

    #[test]
    fn leaves_that_touch_much_finer_ones_are_too_coarse() {
        let lattice = Lattice::over(&Aabb::new(Point3::zeros(), Point3::repeat(1.0)));
        let root = lattice.root_cells()[0];
        let eight = root.children();
        // The last leaves of the first cell touch only the corner of the eighth one.
        let fine = eight[0].children();
        let finest = fine[7].children();
        let leaves: Vec<Cell> = finest.into_iter().chain(fine[..7].to_vec()).chain([eight[7]]).collect();
        let count = leaves.len();
        let found = surroundings(&lattice, &Index::of(leaves));
        let too_coarse: Vec<usize> = (0..count).filter(|i| found[*i].too_coarse).collect();
        assert_eq!(too_coarse, [count - 1]);
        assert_eq!(found.iter().filter(|s| s.beside_finer).count(), 7);
    }
}
