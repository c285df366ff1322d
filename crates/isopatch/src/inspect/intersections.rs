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
    let corners = |t: u32| -> Corners { triangles[t as usize].map(|v| positions[v as usize]) };
    let exists = |t: &u32| triangles[*t as usize].iter().all(|v| (*v as usize) < positions.len());
    let usable: Vec<u32> =
        (0..triangles.len() as u32).filter(|t| exists(t) && has_area(&corners(*t))).collect();
    let tree = BoxTree::new(&usable, |t| Aabb::around(&corners(t)));
    let mut pairs =
        tree.pairs(|a, b| intersect(&corners(a), &corners(b), [a, b].map(|t| triangles[t as usize])));
    pairs.sort_unstable();
    let count = pairs.len();
    pairs.truncate(PLACES);
    MeshIntersections { count, first: pairs }
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
    Ok(places(&tessellate(surface, &TessellateOptions { resolution })?))
}

/// Where the triangles of a tessellation intersect.
pub(super) fn places(mesh: &Tessellation) -> Intersections {
    let found = mesh_intersections(&mesh.positions, &mesh.triangles);
    let bounds = |t: u32| Aabb::around(mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]).iter());
    let place = |pair: &[u32; 2]| Intersection {
        patches: pair.map(|t| mesh.patches[t as usize]),
        at: bounds(pair[0]).common(&bounds(pair[1])).center(),
    };
    Intersections {
        triangles: mesh.triangles.len(),
        count: found.count,
        first: found.first.iter().map(place).collect(),
    }
}
