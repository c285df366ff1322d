//! Questions to a finished surface: what is nearest, what does a ray hit, what is inside?
//!
//! [`SurfaceQuery`] is made once for a surface of any kind and answers any number of them, from any thread. It covers each
//! patch with a few parts, triangles of its parameter domain, whose boxes ([`Surface::part_bounds`]) hold every point of
//! them, and puts the boxes into a tree. What a box rules out is ruled out for certain; in the parts that remain, points are
//! found by Newton's method on the patch itself, so that they have all digits and lie on the surface, not on a tessellation.
//!
//! | question | answer | how |
//! |---|---|---|
//! | [`nearest`](SurfaceQuery::nearest) | [`Nearest`] | branch and bound; Newton on the squared distance, in the domain of the patch |
//! | [`hits`](SurfaceQuery::hits), [`first_hit`](SurfaceQuery::first_hit) | [`RayHit`] | Newton in parts that are small enough to have one root, as their normals show |
//! | [`is_inside`](SurfaceQuery::is_inside) | `bool` | hits of a ray, if they leave no doubt, else of another one |
//!
//! Each has a form for many points at once, with the same results. What is not finite gets no answer.

mod domain;
mod inside;
mod nearest;
mod ray;

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;

pub use nearest::Nearest;
pub use ray::{Ray, RayHit};

use crate::geom::{Aabb, BoxTree, Point3};
use crate::parallel::Evenly;
use crate::surface::{PatchId, Surface};
use rayon::prelude::*;

/// Options of [`SurfaceQuery::new`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueryOptions {
    /// How often the domain of each patch is quartered to get parts, up to [`MAX_SPLITS`]. More cost memory, some 150 bytes a
    /// part, and time to build; fewer let more parts come into question. Default 1.
    pub splits: u32,
}

impl Default for QueryOptions {
    fn default() -> Self {
        Self { splits: 1 }
    }
}

/// Most splits: 4096 parts a triangle.
pub const MAX_SPLITS: u32 = 6;

/// A part of a patch.
#[derive(Clone, Copy, Debug)]
struct Part {
    patch: PatchId,
    triangle: [[f64; 2]; 3],
}

/// A surface with a search tree.
pub struct SurfaceQuery<'a> {
    surface: &'a dyn Surface,
    parts: Vec<Part>,
    tree: BoxTree,
    bounds: Aabb,
    closed: bool,
}

impl<'a> SurfaceQuery<'a> {
    /// Covers the patches with parts. Parts whose box is not finite are left out: the surface is not defined there.
    pub fn new(surface: &'a dyn Surface, options: &QueryOptions) -> Self {
        let splits = options.splits.min(MAX_SPLITS);
        let (parts, boxes): (Vec<Part>, Vec<Aabb>) = (0..surface.patch_count() as u32)
            .into_par_iter()
            .evenly()
            .flat_map_iter(|patch| {
                let patch = PatchId(patch);
                let mut triangles = domain::halves(surface.domain(patch));
                for _ in 0..splits {
                    triangles = triangles.into_iter().flat_map(domain::quarters).collect();
                }
                triangles.into_iter().filter_map(move |triangle| {
                    let bounds = surface.part_bounds(patch, triangle);
                    let finite = (bounds.min.sum() + bounds.max.sum()).is_finite();
                    finite.then_some((Part { patch, triangle }, bounds))
                })
            })
            .unzip();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        let closed = !parts.is_empty() && surface.seams().iter().all(|seam| seam.second.is_some());
        Self { surface, parts, tree: BoxTree::new(&boxes), bounds, closed }
    }

    /// Do all seams have two sides? Then the surface has an inside.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// [`nearest`](Self::nearest) of many points.
    pub fn nearest_of(&self, points: &[Point3]) -> Vec<Option<Nearest>> {
        points.par_iter().evenly().map(|p| self.nearest(p)).collect()
    }

    /// [`hits`](Self::hits) of many rays.
    pub fn hits_of(&self, rays: &[Ray]) -> Vec<Vec<RayHit>> {
        rays.par_iter().evenly().map(|ray| self.hits(ray)).collect()
    }

    /// [`is_inside`](Self::is_inside) of many points.
    pub fn are_inside(&self, points: &[Point3]) -> Vec<Option<bool>> {
        points.par_iter().evenly().map(|p| self.is_inside(p)).collect()
    }
}
