//! What a finished surface is worth, measured on fresh samples and with nothing taken from the solver.
//!
//! | question | answered by |
//! |---|---|
//! | do neighbours meet, and with one normal? | [`seams`] |
//! | how far is the surface from the zero set? | [`deviation`] |
//! | how far is the zero set from the surface, does it miss a part? | [`coverage`] |
//! | does it interpolate the base mesh? | [`interpolation`] |
//! | does it go through itself? | [`intersections`] |
//! | what is it, as a whole? | [`topology`], [`extent`] |
//!
//! [`inspect`] asks all of them of a spline, [`inspect_a_patches`] those of A-patches that need no formula, and besides
//! whether every patch is defined everywhere and none folds. Lengths are relative to the diagonal of the base mesh, angles are in radians.
//! [`inspect_rational`] asks all that can be asked of rational patches.
//! All figures are *measured*: they hold for the samples, and are bounds of nothing.

mod a_patches;
mod box_tree;
mod closest;
mod coverage;
mod deviation;
mod foot;
mod hybrid;
mod interpolation;
mod intersections;
mod measure;
mod rational;
mod samples;
mod seams;
mod text;
mod tree;
mod triangle_pair;
mod zeros;

#[cfg(test)]
mod tests;

pub use a_patches::{APatchInspectOptions, APatchInspection, inspect_a_patches};
pub use closest::{ClosestPatch, Nearest};
pub use coverage::{Coverage, coverage};
pub use deviation::{Deviation, NORMAL_ERROR_LIMIT, PatchDeviation, deviation, deviation_of};
pub use foot::closest_zero;
pub use hybrid::inspect_hybrid;
pub use interpolation::{Interpolation, interpolation};
pub use intersections::{Intersection, Intersections, MeshIntersections, intersections, mesh_intersections};
pub use measure::{Extent, Topology, extent, topology};
pub use rational::{RationalInspection, inspect_rational};
pub use seams::{Seams, seams};
pub use zeros::zeros;

use crate::base::BaseMesh;
use crate::field::Field;
use crate::geom::Aabb;
use crate::surface::Surface;

/// How finely [`inspect`] samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectOptions {
    /// Parameters along every seam, both ends among them, at least 2. Default 33.
    pub seam_samples: usize,
    /// Intervals of the barycentric lattice on every patch, at least 1. Default 21, that is 253 samples a patch. 21 has no
    /// factor in common with 8 and 10, the lattices to which patches and curves are fitted, so that only corners are
    /// shared; and it has the centroid, where the error often is largest.
    pub lattice: usize,
    /// Points of the zero set to look for, about; the distance back is left out if it is 0. Default 30,000.
    pub back_samples: usize,
    /// Intervals along each patch edge for the triangles that are tested for self-intersections; no test if it is 0.
    /// Default 4, that is 16 triangles a patch.
    pub intersection_lattice: usize,
    /// Where to look for the zero set, in model units; the box that the field was polygonised in, if there was
    /// one. Default none: the box of the surface, so a part of the zero set far outside it is not seen.
    pub region: Option<Aabb>,
    /// The distance back, if it has been measured with these options before.
    pub coverage: Option<Coverage>,
}

impl Default for InspectOptions {
    fn default() -> Self {
        Self {
            seam_samples: 33,
            lattice: 21,
            back_samples: 30_000,
            intersection_lattice: 4,
            region: None,
            coverage: None,
        }
    }
}

/// All that [`inspect`] measures. [`Display`](std::fmt::Display) writes it as a short table.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Diagonal of the bounding box of the base mesh's vertices, in model units: the unit of the lengths below.
    pub diagonal: f64,
    /// That box.
    pub bounds: Aabb,
    /// Number of patches.
    pub patches: usize,
    /// Connectivity of the base mesh.
    pub topology: Topology,
    /// Box, area and volume.
    pub extent: Extent,
    /// Positions and normals across seams.
    pub seams: Seams,
    /// Positions, normals and curvatures at the vertices of the base mesh.
    pub interpolation: Interpolation,
    /// Where it goes through itself; none if that was not asked for, or if the patches do not say what they share.
    pub intersections: Option<Intersections>,
    /// From the surface to the zero set; none without a field.
    pub deviation: Option<Deviation>,
    /// From the zero set to the surface; none without a field, or where no zero was found or asked for.
    pub coverage: Option<Coverage>,
}

/// Measures a surface: patch i over face i of the base mesh, against a field that is negative inside.
pub fn inspect(
    surface: &dyn Surface,
    base: &BaseMesh,
    field: Option<&dyn Field>,
    options: &InspectOptions,
) -> Inspection {
    let diagonal = base.diagonal();
    let extent = extent(surface);
    let lattice = Some(options.intersection_lattice).filter(|n| *n > 0);
    let back = field.filter(|_| options.back_samples > 0);
    Inspection {
        diagonal,
        bounds: base.bounds(),
        patches: surface.patch_count(),
        topology: topology(&base.mesh),
        extent,
        seams: seams(surface, diagonal, options.seam_samples),
        interpolation: interpolation(base, surface, diagonal),
        intersections: lattice.and_then(|n| intersections(surface, n).ok()),
        deviation: field.map(|f| deviation(surface, f, diagonal, options.lattice)),
        coverage: options.coverage.or_else(|| {
            coverage(surface, back?, diagonal, extent.area, options.back_samples, options.region)
        }),
    }
}

/// A difference that is not a number as an infinite one, so that no maximum passes over it.
fn or_infinite(difference: f64) -> f64 {
    if difference.is_nan() { f64::INFINITY } else { difference }
}
