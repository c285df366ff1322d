//! Leaves of an octree that cover the surface, refined until each of them has its certificate.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::bounds::may_vanish;
use super::certificate::{Bounds, Doubt, Piece, check, has_sign_of};
use super::numbering::Numbering;
use super::octree::{Cell, DEEPEST, Index, Lattice, Surroundings, key, node_of, surroundings};
use super::tetrahedra::{CENTER, LOCAL_NODES, NodeSet, local, middle, ring};
use crate::field::Field;
use crate::geom::{Point3, Points, PointsView};

/// Settings of a [`Cover`].
#[derive(Clone, Copy, Debug)]
pub(super) struct CoverOptions {
    /// Largest change of ∇f, to first order, from the lower to the upper side of a leaf that meets the surface, as a share of |∇f|.
    pub(super) turn: f64,
    /// Most leaves.
    pub(super) most_leaves: usize,
}

/// A cell that may hold zeros of f.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) cell: Cell,
    pub(super) bounds: Bounds,
    /// How often the bounds of ∇f did not get tighter from parent to child, less [`RELIEF`] for each time they did.
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
const PATIENCE: u8 = 5;

/// What a halving counts that makes the bounds of ∇f tighter: cells on a kink sometimes lose one of its branches.
const RELIEF: u8 = 1;

/// The same where f has no value at the centre: there is not much to be expected.
const PATIENCE_WITHOUT_VALUE: u8 = 2;

/// Components of ∇f with bounds narrower than this share of ∇f do not matter for that.
const SHARE: f64 = 0.1;

/// Bounds that shrink to this share or less in a halving get tighter.
const TIGHTER: f64 = 0.75;

/// Halvings that the sides of the box are worth: if more are in vain, the surface touches a side.
const SIDE_PATIENCE: u8 = 5;

impl Leaf {
    /// What is known of a cell, and whether f has no zero in it.
    fn of(field: &dyn Field, lattice: &Lattice, cell: Cell, parent: Option<&Leaf>) -> (Self, bool) {
        let space = lattice.cell_box(&cell);
        let (value, slopes) = field.linear_gradient_range(&space);
        // Far from the surface, plain intervals can be tighter.
        let is_empty = value.excludes_zero() || !may_vanish(field, &space);
        let half = 0.5 * space.size();
        let gradient = [0, 1, 2].map(|i| slopes[i].scaled(half[i]));
        let side_doubts = parent.map_or(0, |p| p.side_doubts);
        let bounds = Bounds { value, gradient };
        let mut leaf = Self { cell, bounds, stalls: 0, side_doubts, passed: None, uncertain: false };
        if let Some(parent) = parent {
            leaf.uncertain = parent.uncertain;
            let is_stuck = leaf.is_stuck_after(parent);
            leaf.stalls = if is_stuck { parent.stalls + 1 } else { parent.stalls.saturating_sub(RELIEF) };
            let has_value = value.radius().is_finite() || !field.value(space.center()).is_nan();
            leaf.uncertain |= leaf.stalls >= if has_value { PATIENCE } else { PATIENCE_WITHOUT_VALUE };
        }
        (leaf, is_empty)
    }

    /// Are the bounds of ∇f as wide as those over the parent, although those of f are narrower?
    fn is_stuck_after(&self, parent: &Self) -> bool {
        let is_tighter = |now: f64, before: f64| now < TIGHTER * before;
        let (now, before) = (self.bounds.value.radius(), parent.bounds.value.radius());
        let radii = |leaf: &Self| leaf.bounds.gradient.map(|g| g.radius());
        let (now_by_axis, before_by_axis) = (radii(self), radii(parent));
        let most = now_by_axis.iter().fold(0.0, |most: f64, r| most.max(*r));
        let size = self.bounds.gradient.iter().fold(most, |size: f64, g| size.max(g.center.abs()));
        // Derivatives by u are half as large from the start.
        let is_stuck =
            |a: usize| now_by_axis[a] >= SHARE * size && !is_tighter(2.0 * now_by_axis[a], before_by_axis[a]);
        let is_telling = now.is_infinite() || most.is_infinite() || is_tighter(now, before);
        is_telling && (0..3).any(is_stuck)
    }

    /// Can f and ∇f both vanish in the cell, by their bounds?
    pub(super) fn may_be_singular(&self) -> bool {
        self.bounds.gradient.iter().all(|g| !g.excludes_zero())
    }

    /// Is the change of ∇f over the cell at most `turn`·|∇f|, to first order?
    fn is_flat(&self, turn: f64) -> bool {
        let squares = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        let g = &self.bounds.gradient;
        let change: f64 = g.iter().map(|form| squares(form.slope)).sum();
        4.0 * change <= turn * turn * squares(g.map(|form| form.center))
    }

    /// The leaf with a certificate, given with these nodes.
    fn passed(self, set: NodeSet) -> Self {
        Self { passed: Some(set), side_doubts: 0, uncertain: false, ..self }
    }

    fn can_be_split(&self) -> bool {
        self.cell.level < DEEPEST && !self.uncertain
    }

    /// The children, and which of them have no zeros.
    fn children(&self, field: &dyn Field, lattice: &Lattice) -> [(Self, bool); 8] {
        self.cell.children().map(|cell| Self::of(field, lattice, cell, Some(self)))
    }

    /// The children that may have zeros.
    fn open_children(&self, field: &dyn Field, lattice: &Lattice) -> impl Iterator<Item = Leaf> {
        // Half of them have none, and mostly plain intervals tell, which cost much less.
        let may_vanish = |cell: &Cell| may_vanish(field, &lattice.cell_box(cell));
        let cells = self.cell.children().into_iter().filter(may_vanish);
        open(cells.map(|cell| Self::of(field, lattice, cell, Some(self))))
    }
}

/// Those of the cells that may have zeros.
fn open(cells: impl Iterator<Item = (Leaf, bool)>) -> impl Iterator<Item = Leaf> {
    cells.filter(|(_, is_empty)| !is_empty).map(|(leaf, _)| leaf)
}

/// The children of a leaf, and which of them have no zeros.
type Children = Box<[(Leaf, bool); 8]>;

/// What a check says of a leaf.
enum Checked {
    /// It has its certificate with these nodes.
    Passed(NodeSet),
    /// To be replaced by these.
    Split(Children),
    /// As fine as can be, and in doubt.
    Failed,
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
    /// The leaves by their cells.
    index: Index,
    /// Of the nodes on the surface of leaves.
    numbering: Numbering,
    /// Corners of each leaf.
    corners: Vec<[u32; 8]>,
    /// Nodes in use of each leaf.
    pub(super) sets: Vec<NodeSet>,
    /// Where each node is; centres of leaves come last.
    pub(super) places: Vec<u64>,
    /// f at each node.
    pub(super) values: Vec<f64>,
}

/// Leaves that one task looks at, where there is little to do for each.
const TASK: usize = 128;

/// Local numbers of the corners.
const CORNERS: [usize; 8] = [0, 2, 6, 8, 18, 20, 24, 26];

impl<'a> Cover<'a> {
    /// Halves cells until they have their certificates, as far as can be said before they know their neighbours. `report`
    /// sees the cells of every level that are to be halved, and may stop everything by an error.
    pub(super) fn new<E>(
        field: &'a dyn Field,
        lattice: Lattice,
        options: CoverOptions,
        report: impl Fn(&Lattice, &[Leaf]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut cover = Self { field, lattice, options, leaves: Vec::new() };
        let roots = lattice.root_cells();
        let mut pending: Vec<Leaf> =
            open(roots.iter().map(|cell| Leaf::of(field, &lattice, *cell, None))).collect();
        while !pending.is_empty() {
            if cover.leaves.len() + 8 * pending.len() > options.most_leaves {
                cover.leaves.extend(pending.iter().map(|leaf| Leaf { uncertain: true, ..*leaf }));
                break;
            }
            let checked: Vec<Checked> =
                pending.par_iter().evenly().map(|leaf| cover.check_alone(leaf)).collect();
            let mut next = Vec::new();
            for (leaf, checked) in pending.iter().zip(checked) {
                match checked {
                    Checked::Passed(set) => cover.leaves.push(leaf.passed(set)),
                    Checked::Failed => cover.leaves.push(Leaf { uncertain: true, ..*leaf }),
                    Checked::Split(children) => next.extend(open(children.into_iter())),
                }
            }
            report(&lattice, &next)?;
            pending = next;
        }
        Ok(cover)
    }

    /// Checks a leaf whose neighbours are not known.
    fn check_alone(&self, leaf: &Leaf) -> Checked {
        let mut values = [0.0; LOCAL_NODES];
        let mut points = [[0.0; NodeSet::PLAIN_COUNT]; 3];
        for (i, n) in NodeSet::PLAIN.iter().enumerate() {
            let position = self.lattice.position(leaf.cell.node(local(n)));
            (0..3).for_each(|axis| points[axis][i] = position[axis]);
        }
        let [x, y, z] = &points;
        let mut f = [0.0; NodeSet::PLAIN_COUNT];
        self.field.values(PointsView { x, y, z }, &mut f);
        NodeSet::PLAIN.iter().zip(f).for_each(|(n, f)| values[n] = f);
        let is_crossed = f.iter().any(|v| (*v < 0.0) != (f[0] < 0.0));
        if is_crossed && !leaf.is_flat(self.options.turn) && leaf.can_be_split() {
            return Checked::Split(Box::new(leaf.children(self.field, &self.lattice)));
        }
        self.check_with(leaf, NodeSet::CORNERS, &values)
    }

    /// Checks a leaf, at first by its own bounds, then by those of its children. One without nodes between its corners may
    /// be cut with or without its centre.
    fn check_with(&self, leaf: &Leaf, set: NodeSet, values: &[f64; LOCAL_NODES]) -> Checked {
        let sides = self.lattice.sides(&leaf.cell);
        let offset = self.offset(&leaf.cell);
        let whole = [Piece::whole(&leaf.bounds)];
        let cuts = if set.is_plain() { [NodeSet::CORNERS, NodeSet::PLAIN] } else { [set; 2] };
        for set in cuts {
            if check(&leaf.cell, &whole, set, values, &sides, offset).is_ok() {
                return Checked::Passed(set);
            }
        }
        if !leaf.can_be_split() {
            return Checked::Failed;
        }
        let children = leaf.children(self.field, &self.lattice);
        let pieces: [Piece; 8] = std::array::from_fn(|i| Piece::child(i, &children[i].0.bounds));
        match check(&leaf.cell, &pieces, cuts[1], values, &sides, offset) {
            Ok(()) => Checked::Passed(cuts[1]),
            Err(doubt) => {
                let side_doubts = if doubt == Doubt::OnSide { leaf.side_doubts + 1 } else { 0 };
                if side_doubts > SIDE_PATIENCE {
                    return Checked::Failed;
                }
                let with_doubts = |(child, is_empty)| (Leaf { side_doubts, ..child }, is_empty);
                Checked::Split(Box::new(children.map(with_doubts)))
            }
        }
    }

    /// The function.
    pub(super) fn field(&self) -> &'a dyn Field {
        self.field
    }

    /// Replaces leaves by their children; leaves that could not be certified stay so in their children.
    fn split(&mut self, is_split: &[bool]) {
        let (field, lattice) = (self.field, &self.lattice);
        self.leaves = (self.leaves.par_iter().zip(is_split).evenly_by(TASK))
            .flat_map_iter(|(leaf, is_split)| match is_split {
                true => leaf.open_children(field, lattice).collect(),
                false => vec![*leaf],
            })
            .collect();
    }

    /// Splits leaves until those that touch differ by one level at most.
    fn balance(&mut self) -> (Index, Vec<Surroundings>) {
        loop {
            let index = Index::of(self.leaves.iter().map(|leaf| leaf.cell).collect());
            let around = surroundings(&self.lattice, &index);
            if !around.iter().any(|s| s.too_coarse) {
                return (index, around);
            }
            let too_coarse: Vec<bool> = around.iter().map(|s| s.too_coarse).collect();
            self.split(&too_coarse);
        }
    }

    /// Splits every leaf of the coarsest level among those that the surface passes through.
    pub(super) fn split_coarsest(&mut self, nodes: &Nodes) {
        let is_crossed = |i: usize, leaf: &Leaf| leaf.cell.level < DEEPEST && nodes.is_crossed(i, &leaf.cell);
        let leaves = self.leaves.par_iter().enumerate().evenly_by(TASK);
        let level: Vec<Option<u32>> =
            leaves.map(|(i, leaf)| is_crossed(i, leaf).then_some(leaf.cell.level)).collect();
        let coarsest = level.iter().flatten().min().copied();
        let is_split: Vec<bool> = level.iter().map(|l| l.is_some() && *l == coarsest).collect();
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
            let (index, around) = self.balance();
            let mut nodes = self.nodes(index, &around);
            let leaves = (0..self.leaves.len()).into_par_iter().evenly();
            let checked: Vec<Option<Checked>> = leaves.map(|i| self.check_leaf(i, &nodes)).collect();
            let mut room = self.options.most_leaves.saturating_sub(checked.len());
            let mut split = Vec::new();
            for (i, (leaf, checked)) in self.leaves.iter_mut().zip(checked).enumerate() {
                match checked {
                    None => {}
                    Some(Checked::Passed(set)) => *leaf = leaf.passed(set),
                    Some(Checked::Split(children)) if room >= 8 => {
                        room -= 8;
                        split.push((i, children));
                    }
                    Some(Checked::Failed | Checked::Split(_)) => leaf.uncertain = true,
                }
            }
            if split.is_empty() {
                let cuts = self.leaves.par_iter().map(|leaf| leaf.passed);
                let sets = nodes.sets.par_iter_mut().zip(cuts).evenly_by(TASK);
                sets.for_each(|(set, cut)| *set = cut.unwrap_or(*set));
                return nodes;
            }
            self.replace(split);
        }
    }

    /// Checks a leaf among its neighbours; none if it has its certificate with its nodes as they are.
    fn check_leaf(&self, i: usize, nodes: &Nodes) -> Option<Checked> {
        let leaf = &self.leaves[i];
        let set = nodes.sets[i];
        let is_new = leaf.passed != Some(set);
        is_new.then(|| self.check_with(leaf, set, &nodes.local_values(i, &leaf.cell)))
    }

    /// Puts those of the children that may have zeros into the places of their leaves; these ascend.
    fn replace(&mut self, split: Vec<(usize, Children)>) {
        let mut leaves = Vec::with_capacity(self.leaves.len() + 7 * split.len());
        let mut rest = 0;
        for (i, children) in split {
            leaves.extend_from_slice(&self.leaves[rest..i]);
            leaves.extend(open(children.into_iter()));
            rest = i + 1;
        }
        leaves.extend_from_slice(&self.leaves[rest..]);
        self.leaves = leaves;
    }

    /// How far rounding moves nodes, in half edges of the cell.
    fn offset(&self, cell: &Cell) -> f64 {
        let space = self.lattice.cell_box(cell);
        let (half, reach) =
            (0.5 * space.size().min(), self.lattice.bounds.min.abs().sup(&self.lattice.bounds.max.abs()));
        f64::EPSILON * reach.max() / half
    }

    fn nodes(&self, index: Index, around: &[Surroundings]) -> Nodes {
        let of_corners = |leaf: &Leaf| CORNERS.map(|n| key(leaf.cell.node(local(n))));
        let corners: Vec<[u64; 8]> = self.leaves.par_iter().evenly_by(TASK).map(of_corners).collect();
        let (mut numbering, numbers) = Numbering::of(corners.as_flattened());
        let corner_count = numbering.keys.len() as u32;
        let sets: Vec<NodeSet> = (self.leaves.par_iter().zip(around).evenly_by(TASK))
            .map(|(leaf, around)| match around.beside_finer {
                true => NodeSet::beside_finer(|n| {
                    numbering.get(key(leaf.cell.node(local(n)))).is_some_and(|k| k < corner_count)
                }),
                // The cut that was good enough before is so again.
                false => leaf.passed.filter(|set| set.is_plain()).unwrap_or(NodeSet::PLAIN),
            })
            .collect();
        // Middles of sides that no leaf has as a corner.
        for (leaf, set) in self.leaves.iter().zip(&sets).filter(|(_, set)| !set.is_plain()) {
            let middles = (0..6).map(middle).filter(|n| set.contains(*n));
            middles.for_each(|n| numbering.add(key(leaf.cell.node(local(n)))));
        }
        let mut places = std::mem::take(&mut numbering.keys);
        let center = |leaf: &Leaf| key(leaf.cell.node(local(CENTER)));
        places.par_extend(self.leaves.par_iter().evenly_by(TASK).map(center));
        let values = self.values(&places);
        let corners = numbers.as_chunks().0.to_vec();
        Nodes { index, numbering, corners, sets, places, values }
    }

    /// f at nodes.
    fn values(&self, places: &[u64]) -> Vec<f64> {
        /// Points of a task; the result does not depend on it.
        const CHUNK: usize = 128;
        let mut values = vec![0.0; places.len()];
        let chunks = values.par_chunks_mut(CHUNK).zip(places.par_chunks(CHUNK)).evenly();
        chunks.for_each_init(Points::default, |points, (values, places)| {
            points.clear();
            places.iter().for_each(|key| points.push(self.lattice.position(node_of(*key))));
            self.field.values(points.view(), values);
        });
        values
    }

    /// Condition 3 of the certificate: next to cells without zeros, values at nodes have the sign that f has there.
    pub(super) fn borders_are_certain(&self, nodes: &Nodes) -> bool {
        (0..self.leaves.len()).into_par_iter().evenly_by(TASK).all(|i| {
            let cell = &self.leaves[i].cell;
            let values = nodes.local_values(i, cell);
            let set = nodes.sets[i];
            self.border_nodes(&nodes.index, cell).iter().filter(|n| set.contains(*n)).all(|n| {
                let position = self.lattice.position(cell.node(local(n)));
                has_sign_of(&self.leaves[i].bounds.value, n, values[n])
                    || values[n].abs() > self.field.rounding_bound(position)
            })
        })
    }

    /// The local nodes of a leaf on the parts of its surface where no leaf is on the other side.
    fn border_nodes(&self, index: &Index, cell: &Cell) -> NodeSet {
        let mut found = NodeSet::NONE;
        for side in 0..6 {
            let mut steps = [0; 3];
            steps[side / 2] = if side % 2 == 1 { 1 } else { -1 };
            let Some(beside) = self.lattice.neighbor(cell, steps) else { continue };
            // The neighbour may be one level coarser.
            let coarser = beside.level.saturating_sub(1);
            if (coarser..=beside.level).rev().any(|level| index.find(&beside.ancestor(level)).is_some()) {
                continue;
            }
            let around = ring(side);
            for quarter in 0..4 {
                let corner = around[2 * quarter];
                let mut finer = None;
                if beside.level < DEEPEST {
                    finer = beside.children().into_iter().find(|child| touches(child, cell, corner, side));
                }
                if finer.is_none_or(|child| index.find(&child).is_none()) {
                    let last = around[(2 * quarter + 7) % 8];
                    let nodes = [corner, around[2 * quarter + 1], last, middle(side)];
                    found = nodes.into_iter().fold(found, NodeSet::with);
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
            None => self.numbering.get(key(cell.node(local(node)))).map_or(0, |n| n as usize),
        }
    }

    /// f at the local nodes in use.
    pub(super) fn local_values(&self, leaf: usize, cell: &Cell) -> [f64; LOCAL_NODES] {
        let mut values = [0.0; LOCAL_NODES];
        for (corner, n) in CORNERS.into_iter().enumerate() {
            values[n] = self.values[self.corners[leaf][corner] as usize];
        }
        values[CENTER] = self.values[self.number(leaf, cell, CENTER)];
        for n in self.sets[leaf].iter().filter(|n| *n != CENTER && !CORNERS.contains(n)) {
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
