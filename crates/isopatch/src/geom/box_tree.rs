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

    /// Branch and bound: calls `found` for boxes whose `bound` is below the limit, those in groups of lower bound first. `found`
    /// takes the number of a box and the limit, and returns the new limit. A box within another one must not have the lower
    /// bound; a bound that is not a number is never below.
    pub fn search(
        &self,
        bound: impl Fn(&Aabb) -> f64,
        limit: f64,
        mut found: impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        match self.nodes.first() {
            Some(root) if bound(&root.bounds) < limit => self.descend(0, &bound, limit, &mut found),
            _ => limit,
        }
    }

    fn descend(
        &self,
        at: usize,
        bound: &impl Fn(&Aabb) -> f64,
        mut limit: f64,
        found: &mut impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        let Some(node) = self.nodes.get(at) else { return limit };
        if node.after as usize == at + 1 {
            for n in &self.order[node.range[0] as usize..node.range[1] as usize] {
                if bound(&self.boxes[*n as usize]) < limit {
                    limit = found(*n as usize, limit);
                }
            }
            return limit;
        }
        let left = at + 1;
        let right = self.nodes.get(left).map_or(left, |left| left.after as usize);
        let bounds = [left, right].map(|n| self.nodes.get(n).map_or(f64::INFINITY, |n| bound(&n.bounds)));
        let order = if bounds[1] < bounds[0] { [1, 0] } else { [0, 1] };
        for n in order {
            if bounds[n] < limit {
                limit = self.descend([left, right][n], bound, limit, found);
            }
        }
        limit
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

    #[test]
    fn branch_and_bound_finds_the_smallest() {
        let at = |n: usize, k: f64| ((n as f64 + k) * 78.233).sin();
        let points: Vec<Point3> = (0..500).map(|n| Point3::new(at(n, 0.1), at(n, 0.4), at(n, 0.7))).collect();
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb::new(*p, *p)).collect();
        let tree = BoxTree::new(&boxes);
        for n in 0..50 {
            let p = Point3::new(at(n, 0.2), at(n, 0.3), at(n, 0.9));
            let mut visited = 0;
            let smallest = tree.search(
                |b| b.distance_squared(&p),
                f64::INFINITY,
                |n, limit| {
                    visited += 1;
                    limit.min((points[n] - p).norm_squared())
                },
            );
            let wanted = points.iter().map(|q| (q - p).norm_squared()).fold(f64::INFINITY, f64::min);
            assert_eq!(smallest, wanted);
            assert!(visited < 60, "{visited}");
        }
        assert_eq!(BoxTree::new(&[]).search(|_| 0.0, 7.0, |_, _| unreachable!()), 7.0);
    }
}
