//! From the zero set of the field to the surface: does the surface miss a part of it?

use super::closest::{ClosestPatch, Nearest};
use super::zeros::zeros;
use crate::field::Field;
use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use crate::surface::{PatchId, Surface};
use rayon::prelude::*;

/// Limit on the number of cells that the zero set is searched with: 128³, some 10 ms of evaluation.
const MAX_CELLS: f64 = 2_097_152.0;
/// Grid edges that a surface crosses, times cell² / area: the mean of |n_x| + |n_y| + |n_z| over directions.
const CROSSINGS: f64 = 1.5;
/// Cells by which the box of a closed surface is grown, so that the zero set is bracketed at its extremes; not an
/// integer, so that grid vertices do not fall on symmetry planes.
const MARGIN: f64 = 1.618;
/// Queries that one task answers.
const CHUNK: usize = 64;

/// Distance from the zero set of a field to the surface, measured at points that were found without the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Number of points.
    pub samples: usize,
    /// Largest distance to the closest point of the surface, relative to the diagonal.
    pub max_distance: f64,
    /// Root mean square of that distance, relative to the diagonal.
    pub rms_distance: f64,
    /// The point of the zero set where it is largest.
    pub worst_point: Point3,
    /// The patch that is closest to that point.
    pub worst_patch: PatchId,
}

/// Finds about `samples` points of the zero set in `region` and their closest points on the surface, of area `area`.
///
/// None if no point was found, or the area is not a positive number. Without a region, the box of the surface is searched, somewhat larger if it is
/// closed: parts of the zero set that lie outside it are not seen.
pub fn coverage(
    surface: &dyn Surface,
    field: &dyn Field,
    diagonal: f64,
    area: f64,
    samples: usize,
    region: Option<Aabb>,
) -> Option<Coverage> {
    let mut cell = (CROSSINGS * area / samples.max(1) as f64).sqrt();
    let region = region.unwrap_or_else(|| search_box(surface, cell));
    // A flat box gets the thickness of a cell.
    let flat = region.size().map(|s| if s < cell { 0.5 * (cell - s) } else { 0.0 });
    let region = Aabb::new(region.min - flat, region.max + flat);
    cell = cell.max((region.size().product() / MAX_CELLS).cbrt());
    if !(cell > 0.0 && cell.is_finite()) {
        return None;
    }
    let points = zeros(field, &region, cell);
    let tree = ClosestPatch::new(surface);
    let chunks: Vec<Vec<(Point3, Nearest)>> = points
        .par_chunks(CHUNK)
        .evenly()
        .map(|chunk| chunk.iter().filter_map(|p| Some((*p, tree.nearest(p)?))).collect())
        .collect();
    let found = chunks.concat();
    let worst = found.iter().rev().max_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;
    let squares: f64 = found.iter().map(|(_, n)| (n.distance / diagonal).powi(2)).sum();
    Some(Coverage {
        samples: found.len(),
        max_distance: worst.1.distance / diagonal,
        rms_distance: (squares / found.len() as f64).sqrt(),
        worst_point: worst.0,
        worst_patch: worst.1.patch,
    })
}

/// The box of the surface; grown if the surface is closed, because an open one was cut off at its box.
fn search_box(surface: &dyn Surface, cell: f64) -> Aabb {
    let bounds = surface.patches().fold(Aabb::EMPTY, |b, p| b.union(&surface.bounds(p)));
    let closed = surface.seams().iter().all(|s| s.second.is_some());
    if closed { bounds.grown(MARGIN * cell) } else { bounds }
}
