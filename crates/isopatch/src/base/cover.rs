//! Leaves of an octree that cover the surface, refined until each of them has its certificate.

use rayon::prelude::*;

use super::certificate::{Bounds, Doubt, check, has_one_sign};
use super::octree::{
    Cell, DEEPEST, KeyMap, Lattice, Node, Surroundings, find, index, key, node_of, surroundings,
};
use super::tetrahedra::{CENTER, LOCAL_NODES, NodeSet, local, middle, ring};
use crate::field::Field;
use crate::geom::{Affine, Point3, Points};

/// Settings of a [`Cover`].
#[derive(Clone, Copy, Debug)]
pub(super) struct CoverOptions {
    /// Largest change of ∇f over a leaf, from its centre outward, as a share of |∇f|.
    pub(super) turn: f64,
    /// Most leaves.
    pub(super) most_leaves: usize,
}

/// A cell that may hold zeros of f.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) cell: Cell,
    pub(super) bounds: Bounds,
    /// How often in a row the bounds of ∇f did not get tighter from parent to child.
    stalls: u8,
    /// How often in a row only the sides of the box were in the way.
    side_doubts: u8,
    /// The nodes with which the certificate was given.
    passed: Option<NodeSet>,
    /// No certificate, and no hope for one.
    pub(super) uncertain: bool,
}

/// ∇f is taken not to be continuous in a cell if its bounds stay as wide as they are, while those of f get narrower, in so
/// many halvings.
const PATIENCE: u8 = 6;

/// The same where f has no value at the centre: there is not much to be expected.
const PATIENCE_WITHOUT_VALUE: u8 = 2;

/// Bounds that shrink to this share or less in a halving get tighter.
const TIGHTER: f64 = 0.75;

/// Halvings that the sides of the box are worth: if more are in vain, the surface touches a side.
const SIDE_PATIENCE: u8 = 5;

impl Leaf {
    /// The leaf of a cell; none if f has no zero in it.
    fn of(field: &dyn Field, lattice: &Lattice, cell: Cell, parent: Option<&Leaf>) -> Option<Self> {
        let space = lattice.cell_box(&cell);
        let value = field.linear_range(&space);
        if value.excludes_zero() {
            return None;
        }
        let range = field.range(&space);
        if range.lo > 0.0 || range.hi < 0.0 {
            return None;
        }
        let (_, slopes) = field.linear_gradient_range(&space);
        let half = 0.5 * space.size();
        let gradient = [0, 1, 2].map(|i| slopes[i].scaled(half[i]));
        let mut leaf = Self {
            cell,
            bounds: Bounds { value, gradient },
            stalls: 0,
            side_doubts: parent.map_or(0, |p| p.side_doubts),
            passed: None,
            uncertain: false,
        };
        if let Some(parent) = parent {
            let is_tighter = |now: f64, before: f64| now < TIGHTER * before;
            // Of children, derivatives by u are half as large from the start.
            let stuck = !is_tighter(2.0 * leaf.slack(), parent.slack());
            let (now, before) = (value.radius(), parent.bounds.value.radius());
            let narrower = is_tighter(now, before) || now.is_infinite();
            leaf.stalls = if stuck && narrower { parent.stalls + 1 } else { 0 };
            let patience = match now.is_infinite() && field.value(space.center()).is_nan() {
                true => PATIENCE_WITHOUT_VALUE,
                false => PATIENCE,
            };
            leaf.uncertain = leaf.stalls >= patience;
        }
        Some(leaf)
    }

    /// Width of the bounds of ∇f, by u.
    fn slack(&self) -> f64 {
        self.bounds.gradient.iter().map(Affine::radius).sum()
    }

    /// Does ∇f stay on the side of its value at the centre, with a margin by `turn`?
    fn is_flat(&self, turn: f64) -> bool {
        let g = &self.bounds.gradient;
        let m = [0, 1, 2].map(|i| g[i].center);
        let spread: f64 = (0..3).map(|j| (0..3).map(|i| m[i] * g[i].slope[j]).sum::<f64>().abs()).sum();
        let error: f64 = (0..3).map(|i| m[i].abs() * g[i].error).sum();
        spread + error < turn * m.iter().map(|x| x * x).sum::<f64>()
    }

    /// Can f and ∇f both vanish in the cell, by their bounds?
    pub(super) fn may_be_singular(&self) -> bool {
        self.bounds.gradient.iter().all(|g| !g.excludes_zero())
    }

    fn can_be_split(&self) -> bool {
        self.cell.level < DEEPEST && !self.uncertain
    }

    fn children(&self, field: &dyn Field, lattice: &Lattice) -> Vec<Self> {
        let cells = self.cell.children();
        cells.into_iter().filter_map(|cell| Self::of(field, lattice, cell, Some(self))).collect()
    }
}

/// Leaves that cover the surface.
pub(super) struct Cover<'a> {
    field: &'a dyn Field,
    pub(super) lattice: Lattice,
    options: CoverOptions,
    pub(super) leaves: Vec<Leaf>,
}

/// Nodes of the leaves, and the values of f there.
pub(super) struct Nodes {
    /// Numbers of the nodes on the surface of leaves.
    numbers: KeyMap<u32>,
    /// Corners of each leaf.
    corners: Vec<[u32; 8]>,
    /// Nodes in use of each leaf.
    pub(super) sets: Vec<NodeSet>,
    /// Where each node is; centres of leaves come last.
    pub(super) places: Vec<u64>,
    /// f at each node.
    pub(super) values: Vec<f64>,
}

/// Local numbers of the corners.
const CORNERS: [usize; 8] = [0, 2, 6, 8, 18, 20, 24, 26];

impl<'a> Cover<'a> {
    /// Halves cells until ∇f hardly turns in them. `report` sees the cells that are not good enough of every level, and may
    /// stop everything by an error.
    pub(super) fn new<E>(
        field: &'a dyn Field,
        lattice: Lattice,
        options: CoverOptions,
        report: impl Fn(&Lattice, &[Leaf]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut leaves = Vec::new();
        let mut open: Vec<Leaf> =
            lattice.root_cells().iter().filter_map(|cell| Leaf::of(field, &lattice, *cell, None)).collect();
        while !open.is_empty() {
            open.retain(|leaf| {
                let is_done = leaf.is_flat(options.turn) || !leaf.can_be_split();
                if is_done {
                    leaves.push(*leaf);
                }
                !is_done
            });
            report(&lattice, &open)?;
            if leaves.len() + 8 * open.len() > options.most_leaves {
                leaves.extend(open.iter().map(|leaf| Leaf { uncertain: true, ..*leaf }));
                break;
            }
            open = open.par_iter().flat_map_iter(|leaf| leaf.children(field, &lattice)).collect();
        }
        Ok(Self { field, lattice, options, leaves })
    }

    /// The function.
    pub(super) fn field(&self) -> &'a dyn Field {
        self.field
    }

    fn cells(&self) -> Vec<Cell> {
        self.leaves.iter().map(|leaf| leaf.cell).collect()
    }

    /// Replaces leaves by their children; leaves that could not be certified stay so in their children.
    fn split(&mut self, is_split: &[bool]) {
        let (field, lattice) = (self.field, &self.lattice);
        self.leaves = (self.leaves.par_iter().zip(is_split))
            .flat_map_iter(|(leaf, split)| match split {
                true if leaf.uncertain => {
                    let hopeless = |child| Leaf { uncertain: true, ..child };
                    leaf.children(field, lattice).into_iter().map(hopeless).collect()
                }
                true => leaf.children(field, lattice),
                false => vec![*leaf],
            })
            .collect();
    }

    /// Splits leaves until those that touch differ by one level at most.
    fn balance(&mut self) -> (KeyMap<u32>, Vec<Surroundings>) {
        loop {
            let cells = self.cells();
            let index = index(&cells);
            let around = surroundings(&self.lattice, &cells, &index);
            if !around.iter().any(|s| s.too_coarse) {
                return (index, around);
            }
            let too_coarse: Vec<bool> = around.iter().map(|s| s.too_coarse).collect();
            self.split(&too_coarse);
        }
    }

    /// Splits every leaf of the coarsest level.
    pub(super) fn split_coarsest(&mut self) {
        let coarsest = self.leaves.iter().map(|leaf| leaf.cell.level).min().unwrap_or(0);
        let is_split: Vec<bool> =
            self.leaves.iter().map(|leaf| leaf.cell.level == coarsest && coarsest < DEEPEST).collect();
        self.split(&is_split);
    }

    /// Splits every leaf that has no certificate; false if there would be too many.
    pub(super) fn split_uncertain(&mut self) -> bool {
        let is_split: Vec<bool> =
            self.leaves.iter().map(|leaf| leaf.uncertain && leaf.cell.level < DEEPEST).collect();
        let added = 7 * is_split.iter().filter(|s| **s).count();
        if self.leaves.len() + added > self.options.most_leaves {
            return false;
        }
        self.split(&is_split);
        true
    }

    /// Splits leaves until each has a certificate, or no hope for one, and returns the nodes.
    pub(super) fn certify(&mut self) -> Nodes {
        loop {
            let (_, around) = self.balance();
            let nodes = self.nodes(&around);
            let doubts: Vec<Result<(), Doubt>> =
                (0..self.leaves.len()).into_par_iter().map(|i| self.check_leaf(i, &nodes)).collect();
            let mut is_split = vec![false; doubts.len()];
            let mut room = self.options.most_leaves.saturating_sub(doubts.len());
            for ((leaf, doubt), is_split) in self.leaves.iter_mut().zip(&doubts).zip(&mut is_split) {
                match doubt {
                    Ok(()) => {
                        leaf.side_doubts = 0;
                        continue;
                    }
                    Err(Doubt::OnSide) => leaf.side_doubts += 1,
                    Err(Doubt::Inside) => leaf.side_doubts = 0,
                }
                leaf.uncertain |= leaf.side_doubts > SIDE_PATIENCE || room < 7;
                *is_split = leaf.can_be_split();
                leaf.uncertain |= !*is_split;
                room -= if *is_split { 7 } else { 0 };
            }
            for (leaf, (doubt, set)) in self.leaves.iter_mut().zip(doubts.iter().zip(&nodes.sets)) {
                leaf.passed = doubt.is_ok().then_some(*set);
            }
            if !is_split.contains(&true) {
                return nodes;
            }
            self.split(&is_split);
        }
    }

    fn check_leaf(&self, i: usize, nodes: &Nodes) -> Result<(), Doubt> {
        let leaf = &self.leaves[i];
        let set = nodes.sets[i];
        if leaf.uncertain || leaf.passed == Some(set) {
            return Ok(());
        }
        let sides = self.lattice.sides(&leaf.cell);
        check(
            &leaf.cell,
            &leaf.bounds,
            set,
            &nodes.local_values(i, &leaf.cell),
            &sides,
            self.offset(&leaf.cell),
        )
    }

    /// How far rounding moves nodes, in half edges of the cell.
    fn offset(&self, cell: &Cell) -> f64 {
        let space = self.lattice.cell_box(cell);
        let (half, reach) =
            (0.5 * space.size().min(), self.lattice.bounds.min.abs().sup(&self.lattice.bounds.max.abs()));
        f64::EPSILON * reach.max() / half
    }

    fn nodes(&self, around: &[Surroundings]) -> Nodes {
        let mut numbers = KeyMap::default();
        let mut places = Vec::new();
        let mut number = |node: Node| -> u32 {
            let key = key(node);
            *numbers.entry(key).or_insert_with(|| {
                places.push(key);
                places.len() as u32 - 1
            })
        };
        let corners: Vec<[u32; 8]> =
            self.leaves.iter().map(|leaf| CORNERS.map(|n| number(leaf.cell.node(local(n))))).collect();
        let corner_count = corners.iter().flatten().max().map_or(0, |n| n + 1);
        let sets: Vec<NodeSet> = (self.leaves.iter().zip(around))
            .map(|(leaf, around)| match around.beside_finer {
                true => NodeSet::beside_finer(|n| {
                    numbers.get(&key(leaf.cell.node(local(n)))).is_some_and(|k| *k < corner_count)
                }),
                false => NodeSet::PLAIN,
            })
            .collect();
        // Middles of sides that no leaf has as a corner.
        for (leaf, set) in self.leaves.iter().zip(&sets) {
            for n in (0..6).map(middle).filter(|n| set.contains(*n)) {
                let key = key(leaf.cell.node(local(n)));
                numbers.entry(key).or_insert_with(|| {
                    places.push(key);
                    places.len() as u32 - 1
                });
            }
        }
        places.extend(self.leaves.iter().map(|leaf| key(leaf.cell.node(local(CENTER)))));
        let values = self.values(&places);
        Nodes { numbers, corners, sets, places, values }
    }

    /// f at nodes.
    fn values(&self, places: &[u64]) -> Vec<f64> {
        /// Points of a task; the result does not depend on it.
        const CHUNK: usize = 1024;
        let mut values = vec![0.0; places.len()];
        values.par_chunks_mut(CHUNK).zip(places.par_chunks(CHUNK)).for_each(|(values, places)| {
            let points: Points = places.iter().map(|key| self.lattice.position(node_of(*key))).collect();
            self.field.values(points.view(), values);
        });
        values
    }

    /// Condition 3 of the certificate: next to cells without zeros, values at nodes have the sign that f has there.
    pub(super) fn borders_are_certain(&self, nodes: &Nodes) -> bool {
        let cells = self.cells();
        let index = index(&cells);
        (0..cells.len()).into_par_iter().all(|i| {
            let values = nodes.local_values(i, &cells[i]);
            let set = nodes.sets[i];
            self.border_nodes(&cells, &index, i).into_iter().filter(|n| set.contains(*n)).all(|n| {
                let position = self.lattice.position(cells[i].node(local(n)));
                has_one_sign(&self.leaves[i].bounds.value, &[n], &values)
                    || values[n].abs() > self.field.rounding_bound(position)
            })
        })
    }

    /// The local nodes of a leaf on the parts of its surface where no leaf is on the other side.
    fn border_nodes(&self, cells: &[Cell], index: &KeyMap<u32>, i: usize) -> Vec<usize> {
        let mut found = Vec::new();
        let cell = &cells[i];
        for side in 0..6 {
            let mut steps = [0; 3];
            steps[side / 2] = if side % 2 == 1 { 1 } else { -1 };
            let Some(beside) = self.lattice.neighbor(cell, steps) else { continue };
            // The neighbour may be one level coarser.
            let coarser = beside.level.saturating_sub(1);
            if (coarser..=beside.level).any(|level| find(cells, index, &beside.ancestor(level)).is_some()) {
                continue;
            }
            let around = ring(side);
            for quarter in 0..4 {
                let corner = around[2 * quarter];
                let mut finer = None;
                if beside.level < DEEPEST {
                    finer = beside.children().into_iter().find(|child| touches(child, cell, corner, side));
                }
                if finer.is_none_or(|child| find(cells, index, &child).is_none()) {
                    let last = around[(2 * quarter + 7) % 8];
                    found.extend([corner, around[2 * quarter + 1], last, middle(side)]);
                }
            }
        }
        found
    }
}

/// Does a cell of the next level, on the other side, have this corner of the cell?
fn touches(child: &Cell, cell: &Cell, corner: usize, side: usize) -> bool {
    let node = cell.node(local(corner));
    let axis = side / 2;
    (0..3).all(|a| {
        let (low, high) = (child.corner[a], child.corner[a] + child.edge());
        if a == axis {
            node[a] == if side % 2 == 1 { low } else { high }
        } else {
            node[a] == low || node[a] == high
        }
    })
}

impl Nodes {
    /// Number of a node of a leaf.
    pub(super) fn number(&self, leaf: usize, cell: &Cell, node: usize) -> usize {
        if node == CENTER {
            return self.places.len() - self.corners.len() + leaf;
        }
        match CORNERS.iter().position(|n| *n == node) {
            Some(c) => self.corners[leaf][c] as usize,
            None => self.numbers.get(&key(cell.node(local(node)))).map_or(0, |n| *n as usize),
        }
    }

    /// f at the local nodes in use.
    pub(super) fn local_values(&self, leaf: usize, cell: &Cell) -> [f64; LOCAL_NODES] {
        let mut values = [0.0; LOCAL_NODES];
        for (corner, n) in CORNERS.into_iter().enumerate() {
            values[n] = self.values[self.corners[leaf][corner] as usize];
        }
        for n in self.sets[leaf].iter().filter(|n| !CORNERS.contains(n)) {
            values[n] = self.values[self.number(leaf, cell, n)];
        }
        values
    }

    /// Do values at the nodes of the leaf differ in sign, or lack one?
    pub(super) fn is_crossed(&self, leaf: usize, cell: &Cell) -> bool {
        let values = self.local_values(leaf, cell);
        let mut nodes = self.sets[leaf].iter();
        let negative = nodes.next().is_some_and(|n| values[n] < 0.0);
        nodes.any(|n| (values[n] < 0.0) != negative)
    }
}

/// The middle of a leaf.
pub(super) fn center(lattice: &Lattice, leaf: &Leaf) -> Point3 {
    lattice.position(leaf.cell.node(local(CENTER)))
}
