//! A bounding volume hierarchy that finds the pairs of boxes that overlap.

use crate::geom::Aabb;
use rayon::join;

/// Most boxes in a leaf: so many are cheaper to compare one by one.
const LEAF: usize = 4;
/// Height from which on the halves of a tree are worked on in parallel.
const PARALLEL_HEIGHT: u32 = 5;

/// An element, and the centre of its box relative to the centre of all of them: only the order of centres counts, so
/// `f32` will do.
type Item = ([f32; 3], u32);

/// Boxes in a complete binary tree: a node has half as many as its parent, to one.
///
/// Boxes of elements are not kept but asked for again, because a tree over all triangles of a large surface would take
/// more memory than the surface.
pub(super) struct BoxTree<F> {
    bounds: F,
    items: Vec<Item>,
    height: u32,
    /// In pre-order: a node, its left half, its right half.
    nodes: Vec<Aabb>,
}

/// A node with its place among the nodes and the range of its items.
#[derive(Clone, Copy)]
struct Node {
    number: usize,
    height: u32,
    start: usize,
    end: usize,
}

impl Node {
    fn halves(self) -> [Self; 2] {
        let middle = self.start + (self.end - self.start) / 2;
        let height = self.height - 1;
        [
            Self { number: self.number + 1, height, start: self.start, end: middle },
            Self { number: self.number + 1 + node_count(height), height, start: middle, end: self.end },
        ]
    }
}

/// Number of nodes of a complete tree.
fn node_count(height: u32) -> usize {
    (2 << height) - 1
}

impl<F: Fn(u32) -> Aabb + Sync> BoxTree<F> {
    /// The tree over `elements`, whose boxes `bounds` tells; they are finite.
    pub fn new(elements: &[u32], bounds: F) -> Self {
        let center = elements.iter().fold(Aabb::EMPTY, |b, e| b.union(&bounds(*e))).center();
        let item = |e: &u32| ((bounds(*e).center() - center).map(|x| x as f32).into(), *e);
        let mut items: Vec<Item> = elements.iter().map(item).collect();
        let height = items.len().div_ceil(LEAF).next_power_of_two().trailing_zeros();
        let mut nodes = vec![Aabb::EMPTY; node_count(height)];
        build(&mut items, &mut nodes, height, &bounds);
        Self { bounds, items, height, nodes }
    }

    /// The pairs of different elements whose boxes overlap and that pass `test`, in the order of the tree; the smaller
    /// number comes first in a pair.
    pub fn pairs(&self, test: impl Fn(u32, u32) -> bool + Sync) -> Vec<[u32; 2]> {
        let root = Node { number: 0, height: self.height, start: 0, end: self.items.len() };
        self.within(root, &test)
    }

    fn within(&self, node: Node, test: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<[u32; 2]> {
        let mut found = Vec::new();
        if node.height == 0 {
            let boxes = self.boxes(node);
            for i in 1..LEAF {
                self.compare((node.start + i, &boxes[i]), (node.start, &boxes[..i]), test, &mut found);
            }
            return found;
        }
        let [left, right] = node.halves();
        let both = || (self.within(left, test), self.within(right, test));
        let (mut first, mut second) = match node.height {
            ..PARALLEL_HEIGHT => both(),
            _ => join(|| self.within(left, test), || self.within(right, test)),
        };
        found.append(&mut first);
        found.append(&mut second);
        self.between(left, right, test, &mut found);
        found
    }

    /// Pairs with one element in each of two nodes of equal height.
    fn between(
        &self,
        a: Node,
        b: Node,
        test: &(impl Fn(u32, u32) -> bool + Sync),
        found: &mut Vec<[u32; 2]>,
    ) {
        if !self.nodes[a.number].overlaps(&self.nodes[b.number]) {
            return;
        }
        if a.height > 0 {
            for half in a.halves() {
                b.halves().iter().for_each(|other| self.between(half, *other, test, found));
            }
            return;
        }
        let (boxes, others) = (self.boxes(a), self.boxes(b));
        for (i, bounds) in boxes.iter().enumerate() {
            if bounds.overlaps(&self.nodes[b.number]) {
                self.compare((a.start + i, bounds), (b.start, &others), test, found);
            }
        }
    }

    /// Boxes of the items of a leaf, and empty ones, which overlap with none.
    fn boxes(&self, leaf: Node) -> [Aabb; LEAF] {
        let items = &self.items[leaf.start..leaf.end];
        std::array::from_fn(|i| items.get(i).map_or(Aabb::EMPTY, |(_, e)| (self.bounds)(*e)))
    }

    /// Pairs of one item with some that follow each other, all with their boxes.
    fn compare(
        &self,
        (item, bounds): (usize, &Aabb),
        (first, others): (usize, &[Aabb]),
        test: &impl Fn(u32, u32) -> bool,
        found: &mut Vec<[u32; 2]>,
    ) {
        for (k, _) in others.iter().enumerate().filter(|(_, other)| bounds.overlaps(other)) {
            let (e, f) = (self.items[item].1, self.items[first + k].1);
            let (e, f) = (e.min(f), e.max(f));
            if test(e, f) {
                found.push([e, f]);
            }
        }
    }
}

/// Sorts the items into the leaves and fits the nodes; halves are split at the median along the longer axis.
fn build(items: &mut [Item], nodes: &mut [Aabb], height: u32, bounds: &(impl Fn(u32) -> Aabb + Sync)) {
    if height == 0 {
        nodes[0] = items.iter().fold(Aabb::EMPTY, |b, (_, e)| b.union(&bounds(*e)));
        return;
    }
    let axis = longest_axis(items);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (low, high) = items.split_at_mut(middle);
    let (root, halves) = nodes.split_at_mut(1);
    let (left, right) = halves.split_at_mut(node_count(height - 1));
    let mut build_left = || build(low, left, height - 1, bounds);
    let mut build_right = || build(high, right, height - 1, bounds);
    if height < PARALLEL_HEIGHT {
        build_left();
        build_right();
    } else {
        join(build_left, build_right);
    }
    root[0] = left[0].union(&right[0]);
}

/// The axis along which the centres are spread farthest.
fn longest_axis(items: &[Item]) -> usize {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (center, _) in items {
        for axis in 0..3 {
            min[axis] = min[axis].min(center[axis]);
            max[axis] = max[axis].max(center[axis]);
        }
    }
    let spread = |axis: usize| max[axis] - min[axis];
    let longer = |a, b| if spread(b) > spread(a) { b } else { a };
    [1, 2].into_iter().fold(0, longer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point3;

    /// Pseudo-random boxes: the tree finds the pairs that a comparison of all with all finds.
    #[test]
    fn all_pairs_are_found_once() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for count in [0, 1, 2, 8, 9, 17, 500] {
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let corner = Point3::from_fn(|_, _| random());
                    Aabb::new(corner, corner + Point3::from_fn(|_, _| 0.2 * random()))
                })
                .collect();
            let elements: Vec<u32> = (0..count).collect();
            let tree = BoxTree::new(&elements, |e| boxes[e as usize]);
            let mut found = tree.pairs(|_, _| true);
            found.sort_unstable();
            let all = (0..count).flat_map(|e| (e + 1..count).map(move |f| [e, f]));
            let overlapping = |[e, f]: &[u32; 2]| boxes[*e as usize].overlaps(&boxes[*f as usize]);
            assert_eq!(found, all.filter(overlapping).collect::<Vec<_>>());
        }
    }
}
