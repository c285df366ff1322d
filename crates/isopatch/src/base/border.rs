//! What the sides of a box allow at the border of a mesh.
//!
//! A vertex of the border lies in one side of the box, or in several at once, and stays there. No edge but those of the
//! border joins two vertices of one side: over a triangle with all its corners in a plane the surface would have to be
//! that plane, and the corner between two edges of one border curve would be 180° wide.

use super::clip::BoxSides;
use super::connectivity::Connectivity;

/// Where the ends of an edge may be merged, so that the boundary stays in the sides of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Merge {
    /// Anywhere between them, within their common sides.
    Between,
    /// Where the first end is, which lies in more sides.
    AtFirst,
    /// Where the second end is.
    AtSecond,
}

impl Merge {
    /// For an edge between vertices with these sides; none if a vertex would leave a side, or enter one.
    pub fn of(first: BoxSides, second: BoxSides, is_boundary: bool) -> Option<Self> {
        if is_boundary == first.common(second).is_empty() {
            return None;
        }
        if first == second {
            // Two points on an edge of the box are where two boundary curves cross it: they are not the same.
            (first.len() <= 1).then_some(Self::Between)
        } else if first.contains_all(second) {
            Some(Self::AtFirst)
        } else {
            second.contains_all(first).then_some(Self::AtSecond)
        }
    }
}

/// Would an edge inside join two vertices of one side once the ends of `h` are merged, or an edge of the border two of the
/// same edge of the box?
pub(super) fn collapse_bridges(mesh: &Connectivity, sides: &[BoxSides], h: u32) -> bool {
    let ends = [mesh.origin(h), mesh.dest(h)];
    let merged = larger(ends.map(|v| sides[v as usize]));
    if merged.is_empty() {
        return false;
    }
    let on_border =
        |v: u32| mesh.boundary_neighbours(v).is_some_and(|both| ends.iter().any(|end| both.contains(end)));
    ends.iter().flat_map(|end| mesh.neighbours(*end)).filter(|v| !ends.contains(v)).any(|v| {
        match sides[v as usize].common(merged).len() {
            0 => false,
            1 => !on_border(v),
            _ => true,
        }
    })
}

/// Would the edge between the apexes join two vertices of one side?
pub(super) fn flip_bridges(mesh: &Connectivity, sides: &[BoxSides], h: u32) -> bool {
    mesh.apexes(h).is_some_and(|[c, d]| !sides[c as usize].common(sides[d as usize]).is_empty())
}

/// The sides of the vertex into which two are merged, one of which has all sides of the other.
pub(super) fn larger([first, second]: [BoxSides; 2]) -> BoxSides {
    if first.contains_all(second) { first } else { second }
}
