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
pub(super) fn collapse_bridges(mesh: &Connectivity, sides: impl Fn(u32) -> BoxSides, h: u32) -> bool {
    let ends = [mesh.origin(h), mesh.dest(h)];
    let merged = larger(ends.map(&sides));
    if merged.is_empty() {
        return false;
    }
    let on_border =
        |v: u32| mesh.boundary_neighbours(v).is_some_and(|both| ends.iter().any(|end| both.contains(end)));
    ends.iter().flat_map(|end| mesh.neighbours(*end)).filter(|v| !ends.contains(v)).any(|v| {
        match sides(v).common(merged).len() {
            0 => false,
            1 => !on_border(v),
            _ => true,
        }
    })
}

/// Would the edge between the apexes join two vertices of one side?
pub(super) fn flip_bridges(mesh: &Connectivity, sides: impl Fn(u32) -> BoxSides, h: u32) -> bool {
    mesh.apexes(h).is_some_and(|[c, d]| !sides(c).common(sides(d)).is_empty())
}

/// The sides of the vertex into which two are merged, one of which has all sides of the other.
pub(super) fn larger([first, second]: [BoxSides; 2]) -> BoxSides {
    if first.contains_all(second) { first } else { second }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::clip::BoxSide;
    use super::*;

    fn sides(of: &[usize]) -> BoxSides {
        of.iter().map(|axis| BoxSide { axis: *axis, upper: true }).collect()
    }

    #[test]
    fn a_vertex_merges_into_one_with_more_sides_only() {
        let [none, x, y, xy] = [&[][..], &[0], &[1], &[0, 1]].map(sides);
        assert_eq!(Merge::of(none, none, false), Some(Merge::Between));
        assert_eq!(Merge::of(x, x, true), Some(Merge::Between));
        assert_eq!(Merge::of(none, x, false), Some(Merge::AtSecond));
        assert_eq!(Merge::of(xy, x, true), Some(Merge::AtFirst));
        assert_eq!(Merge::of(y, xy, true), Some(Merge::AtSecond));
        // From one border curve to another; across the edge of the box; from one crossing of it to another.
        assert_eq!(Merge::of(x, x, false), None);
        assert_eq!(Merge::of(x, y, true), None);
        assert_eq!(Merge::of(xy, xy, true), None);
        assert_eq!(larger([x, xy]), xy);
        assert_eq!(larger([xy, none]), xy);
    }

    /// A fan of three triangles around vertex 0; 1, 2, 3, 4 are the border beside it.
    #[test]
    fn bridges_are_seen_before_they_are_built() {
        let mesh = Connectivity::from_faces(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]).unwrap();
        let [x, y] = [&[0][..], &[1]].map(sides);
        let edge = |ends: [u32; 2]| {
            mesh.edges()
                .into_iter()
                .find(|h| [mesh.origin(*h), mesh.dest(*h)].iter().all(|v| ends.contains(v)))
                .unwrap()
        };
        // A flip of 0–2 joins 1 and 3.
        assert!(flip_bridges(&mesh, |v| [x, x, y, x, y][v as usize], edge([0, 2])));
        assert!(!flip_bridges(&mesh, |v| [x, x, y, y, y][v as usize], edge([0, 2])));
        // Merged with 1, vertex 0 has an edge inside to 3.
        assert!(collapse_bridges(&mesh, |v| [x, x, y, x, y][v as usize], edge([0, 1])));
        assert!(!collapse_bridges(&mesh, |v| [x, x, y, y, x][v as usize], edge([0, 1])));
    }
}
