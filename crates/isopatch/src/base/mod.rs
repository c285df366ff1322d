//! From a field to a [`BaseMesh`]: few well-shaped triangles with their vertices exactly on the surface.
//!
//! [`build`] goes the whole way; its stages are separate functions:
//!
//! ```text
//! find_box ──► seed_mesh ──► decimate ──► remesh ──► finish ──► BaseMesh
//!  interval     octree with   quadric      splits,    projection,
//!  bounds       certificates, errors       collapses, normals,
//!               marching                   flips,     curvatures
//!               tetrahedra                 smoothing
//! ```
//!
//! [`validity`] says whether a mesh, wherever it comes from, is fit for a spline surface.

mod base_mesh;
mod batch;
mod border;
mod bounds;
mod build;
mod certificate;
mod clip;
mod compatible;
mod connectivity;
mod corners;
mod cover;
mod decimate;
mod error;
mod estimate;
mod failures;
mod given;
mod jets;
mod local;
mod marching;
mod numbering;
mod octree;
mod polygonize;
mod project;
mod refine;
mod remesh;
mod seed;
mod shape;
mod singular;
mod sizing;
mod star;
mod target;
mod tetrahedra;
mod triangle_mesh;
mod validity;

#[cfg(test)]
mod open_fixtures;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod open_tests;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod seed_tests;
#[cfg(test)]
mod test_fields;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;

pub use base_mesh::{BaseMesh, EdgeFeature};
pub use batch::Batch;
pub use bounds::{SEARCH_RADII, check_box, find_box, outside_is_negative, tighten};
pub use build::{BaseMethod, BaseOptions, BaseOutcome, Repair, base_from_seed, build, finish};
pub use clip::{BoxSide, BoxSides, Clip};
pub use compatible::compatible_curvatures;
pub use decimate::decimate;
pub use error::BaseError;
pub use estimate::curvature_tensors;
pub use given::from_mesh;
pub use local::{Change, Draft, Part, part};
pub use polygonize::{Polygonization, PolygonizeOptions, polygonize};
pub use project::{ProjectOptions, Projection, project_points};
pub use refine::{edge_lengths, refine};
pub use remesh::{RemeshOptions, remesh};
pub use seed::{Seed, SeedOptions, seed_mesh};
pub use shape::largest_curvature;
pub use singular::find_singular;
pub use sizing::SizingOptions;
pub use target::FieldTarget;
pub use triangle_mesh::TriangleMesh;
pub use validity::{Limit, Quality, ValidityLimits, Violation, quality, validity};
