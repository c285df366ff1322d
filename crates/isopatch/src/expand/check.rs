//! What an expansion came to.

use super::front::Front;
use super::seeds::half_sheets;
use std::collections::{BTreeMap, BTreeSet};

/// Counts on the finished triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Check {
    /// Edges with one triangle that are neither in a side of the box nor on a wall.
    pub gap_edges: usize,
    /// Edges off the walls with more than two triangles, or with two that are oriented against each other.
    pub bad_edges: usize,
    /// Segments of walls with one or no triangle, other than in a side of the box.
    pub missing_segments: usize,
    /// Segments of walls with more triangles than half-sheets end there: 4 where two sheets cross.
    pub crowded_segments: usize,
    /// Triangles whose normal is against that of one of its corners.
    pub folded: usize,
    /// Edges with one triangle, in sides of the box.
    pub border_edges: usize,
    /// Vertices − edges + triangles, of what has triangles.
    pub euler: i64,
    /// Area, in square model units.
    pub area: f64,
}

impl Check {
    /// Is there nothing to complain about?
    pub fn is_right(&self) -> bool {
        let faults =
            [self.gap_edges, self.bad_edges, self.missing_segments, self.crowded_segments, self.folded];
        faults.iter().all(|count| *count == 0)
    }
}

pub(super) fn check(front: &Front<'_>) -> Check {
    let mut edges: BTreeMap<[u32; 2], Vec<bool>> = BTreeMap::new();
    let mut vertices = BTreeSet::<u32>::new();
    let mut found = Check::default();
    for t in &front.triangles {
        let [a, b, c] = t.map(|v| front.at(v));
        let area = (b - a).cross(&(c - a)) / 2.0;
        found.area += area.norm();
        found.folded += usize::from(t.iter().filter_map(|v| front.normal(*v)).any(|n| n.dot(&area) <= 0.0));
        vertices.extend(t);
        for k in 0..3 {
            let (u, v) = (t[k], t[(k + 1) % 3]);
            edges.entry([u.min(v), u.max(v)]).or_default().push(u < v);
        }
    }
    for ([u, v], sides) in &edges {
        let is_wall = front.walls.segments.contains(&[*u, *v]);
        let on_side = front.vertices[*u as usize].sides & front.vertices[*v as usize].sides != 0;
        match sides[..] {
            _ if is_wall => {}
            [_] if on_side => found.border_edges += 1,
            [_] => found.gap_edges += 1,
            [a, b] if a != b => {}
            _ => found.bad_edges += 1,
        }
    }
    for [u, v] in &front.walls.segments {
        let on_side = front.vertices[*u as usize].sides & front.vertices[*v as usize].sides != 0;
        let count = edges.get(&[*u, *v]).map_or(0, Vec::len);
        found.missing_segments += usize::from(count < 2 && !on_side);
        let ends = [front.at(*u), front.at(*v)];
        // Two triangles are never too many: a sheet passes on both sides.
        let is_crowded = count > 2 && count > half_sheets(front.sheet, ends[0], ends[1]).len();
        found.crowded_segments += usize::from(is_crowded);
    }
    found.euler = vertices.len() as i64 - edges.len() as i64 + front.triangles.len() as i64;
    found
}
