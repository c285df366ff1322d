use super::Aabb;

/// Most boxes in a leaf.
const LEAF: usize = 4;

/// Axis-aligned boxes in a binary tree, for searches that skip whole groups of them.
#[derive(Clone, Debug)]
pub struct BoxTree {
    /// Numbers of the boxes in the order of the leaves.
    order: Vec<u32>,
    boxes: Vec<Aabb>,
    /// In preorder: the box of a node, the end of its range in `order`, and the node after its subtree.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    range: [u32; 2],
    /// Where the walk goes on if this node is skipped; the next node is its first child unless it is a leaf.
    after: u32,
}

impl BoxTree {
    /// Takes O(n log n) time for n boxes, split at medians of their centers.
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut tree =
            Self { order: (0..boxes.len() as u32).collect(), boxes: boxes.to_vec(), nodes: Vec::new() };
        if !boxes.is_empty() {
            tree.split(0, boxes.len());
        }
        tree
    }

    fn split(&mut self, start: usize, end: usize) {
        let group = &mut self.order[start..end];
        let bounds = group.iter().fold(Aabb::EMPTY, |b, n| b.union(&self.boxes[*n as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, range: [start as u32, end as u32], after: 0 });
        if group.len() > LEAF {
            let boxes = &self.boxes;
            let axis = bounds.size().imax();
            let center = |n: &u32| boxes[*n as usize].center()[axis];
            let middle = group.len() / 2;
            group.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)).then(a.cmp(b)));
            self.split(start, start + middle);
            self.split(start + middle, end);
        }
        self.nodes[node].after = self.nodes.len() as u32;
    }

    /// Calls `found` with the number of every box that `wanted` accepts. `wanted` must accept a box that holds one that it
    /// accepts.
    pub fn visit(&self, wanted: impl Fn(&Aabb) -> bool, mut found: impl FnMut(usize)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let is_leaf = node.after as usize == at + 1;
            if !wanted(&node.bounds) {
                at = node.after as usize;
                continue;
            }
            if is_leaf {
                let [start, end] = node.range.map(|n| n as usize);
                let inside = self.order[start..end].iter().map(|n| *n as usize);
                inside.filter(|n| wanted(&self.boxes[*n])).for_each(&mut found);
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point3;

    #[test]
    fn every_box_that_is_wanted_is_found_once() {
        let at = |n: usize, k: f64| ((n as f64 + k) * 12.9898).sin();
        let boxes: Vec<Aabb> = (0..300)
            .map(|n| {
                let p = Point3::new(at(n, 0.1), at(n, 0.4), at(n, 0.7));
                Aabb::new(p, p + Point3::repeat(0.3))
            })
            .collect();
        let tree = BoxTree::new(&boxes);
        for n in 0..50 {
            let p = Point3::new(at(n, 0.2), at(n, 0.3), at(n, 0.9));
            let mut found = Vec::new();
            tree.visit(|b| b.contains(&p), |n| found.push(n));
            found.sort_unstable();
            let wanted: Vec<usize> = (0..boxes.len()).filter(|n| boxes[*n].contains(&p)).collect();
            assert_eq!(found, wanted);
        }
        BoxTree::new(&[]).visit(|_| true, |_| unreachable!());
    }
}
