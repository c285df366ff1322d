//! Does a surface go through itself? Asked of its tessellation, whose triangles are tested exactly.

use super::box_tree::BoxTree;
use super::triangle_pair::{Corners, has_area, intersect};
use crate::geom::{Aabb, Point3};
use crate::surface::{PatchId, Surface};
use crate::tessellate::{TessellateError, TessellateOptions, Tessellation, tessellate};

/// Places that are kept of each kind; the rest is only counted.
const PLACES: usize = 10;

/// Pairs of triangles of a mesh that intersect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshIntersections {
    /// Number of pairs.
    pub count: usize,
    /// The first ten of them, by their numbers, the smaller number first in a pair.
    pub first: Vec<[u32; 2]>,
}

/// Finds the triangles of a mesh that have a point in common which is not in a vertex or an edge that they share.
///
/// A vertex is shared if both triangles name it by the same number; another vertex at the same place is not, and
/// makes them touch, which counts. Neighbours across an edge intersect if they are folded onto each other. Signs are
/// exact: there is no tolerance. Triangles without an area, with a vertex that does not exist, or with a
/// coordinate that is not finite are left out.
pub fn mesh_intersections(positions: &[Point3], triangles: &[[u32; 3]]) -> MeshIntersections {
    let mut pairs = pairs(positions, triangles);
    let count = pairs.len();
    pairs.truncate(PLACES);
    MeshIntersections { count, first: pairs }
}

/// All pairs of triangles that intersect, in order.
fn pairs(positions: &[Point3], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let corners = |t: u32| -> Corners { triangles[t as usize].map(|v| positions[v as usize]) };
    let exists = |t: &u32| triangles[*t as usize].iter().all(|v| (*v as usize) < positions.len());
    let usable: Vec<u32> =
        (0..triangles.len() as u32).filter(|t| exists(t) && has_area(&corners(*t))).collect();
    let tree = BoxTree::new(&usable, |t| Aabb::around(&corners(t)));
    let mut pairs =
        tree.pairs(|a, b| intersect(&corners(a), &corners(b), [a, b].map(|t| triangles[t as usize])));
    pairs.sort_unstable();
    pairs
}

/// Where a surface goes through itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The two patches, or twice the same.
    pub patches: [PatchId; 2],
    /// The place, to within the size of a triangle of the tessellation.
    pub at: Point3,
}

/// Self-intersections of a tessellated surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Intersections {
    /// Number of triangles that were tested.
    pub triangles: usize,
    /// Number of pairs of triangles that intersect.
    pub count: usize,
    /// The first ten of them.
    pub first: Vec<Intersection>,
}

/// Tests the triangles of the tessellation with `resolution` intervals along each patch edge.
///
/// # Errors
/// The resolution is out of range, or the patches do not say what they share.
pub fn intersections(surface: &dyn Surface, resolution: usize) -> Result<Intersections, TessellateError> {
    Ok(places(&tessellate(surface, &TessellateOptions { resolution })?, |_| false))
}

/// Where the triangles of a tessellation intersect.
///
/// A lens may narrow to a point in its middle. Both of its sides have a number for that point then, and what touches there does
/// not intersect.
pub(super) fn places(mesh: &Tessellation, is_lens: impl Fn(PatchId) -> bool) -> Intersections {
    let mut found = pairs(&mesh.positions, &mesh.triangles);
    if !found.is_empty() {
        let numbers = joined_numbers(mesh, is_lens);
        let corners = |t: u32| mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
        let joined = |t: u32| mesh.triangles[t as usize].map(|v| numbers[v as usize]);
        found.retain(|[a, b]| intersect(&corners(*a), &corners(*b), [joined(*a), joined(*b)]));
    }
    let bounds = |t: u32| Aabb::around(mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]).iter());
    let place = |pair: &[u32; 2]| Intersection {
        patches: pair.map(|t| mesh.patches[t as usize]),
        at: bounds(pair[0]).common(&bounds(pair[1])).center(),
    };
    Intersections {
        triangles: mesh.triangles.len(),
        count: found.len(),
        first: found.iter().take(PLACES).map(place).collect(),
    }
}

/// The numbers of the points, but the same for points of a lens that are at the same place.
fn joined_numbers(mesh: &Tessellation, is_lens: impl Fn(PatchId) -> bool) -> Vec<u32> {
    // Adding zero takes the sign from a zero.
    let place = |v: u32| -> [u64; 3] { mesh.positions[v as usize].map(|x| (x + 0.0).to_bits()).into() };
    let of_lenses = mesh.triangles.iter().zip(&mesh.patches).filter(|(_, patch)| is_lens(**patch));
    let mut points: Vec<(u32, [u64; 3], u32)> =
        of_lenses.flat_map(|(triangle, patch)| triangle.map(|v| (patch.0, place(v), v))).collect();
    points.sort_unstable();
    let mut numbers: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for pair in points.windows(2) {
        let ((patch, at, v), (other, there, w)) = (pair[0], pair[1]);
        if (patch, at) == (other, there) {
            numbers[w as usize] = numbers[v as usize];
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two faces with a lens between them, from (0, 0, 0) to (2, 0, 0), that narrows to a point in the middle.
    fn lens(left: Point3) -> Tessellation {
        let [end, middle] = [Point3::new(2.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0)];
        let right = Point3::new(1.0, -1.0, 0.2);
        let between = [Point3::new(0.5, 0.1, 0.0), Point3::new(0.5, -0.1, 0.0)];
        let positions = vec![Point3::zeros(), end, middle, middle, left, right, between[0], between[1]];
        let of_left = [[4, 0, 6], [4, 6, 2], [4, 2, 1]];
        let of_right = [[5, 7, 0], [5, 3, 7], [5, 1, 3]];
        let of_lens = [[0, 7, 6], [7, 3, 2], [7, 2, 6], [3, 1, 2]];
        Tessellation {
            positions,
            normals: Vec::new(),
            triangles: [&of_left[..], &of_right, &of_lens].concat(),
            corner_normals: Vec::new(),
            patches: [0, 0, 0, 1, 1, 1, 2, 2, 2, 2].map(PatchId).to_vec(),
        }
    }

    #[test]
    fn lenses_that_narrow_to_a_point_touch_there() {
        let mesh = lens(Point3::new(1.0, 1.0, 0.0));
        assert!(places(&mesh, |_| false).count > 0);
        assert_eq!(places(&mesh, |patch| patch == PatchId(2)).count, 0);
        // The left face turned onto the right one.
        let folded = lens(Point3::new(1.0, -0.5, 0.1));
        assert!(places(&folded, |patch| patch == PatchId(2)).count > 0);
    }
}
