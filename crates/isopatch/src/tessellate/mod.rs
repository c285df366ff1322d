//! A surface as a triangle mesh with true normals.
//!
//! [`SharedLattice`] numbers the lattice points of all patches so that patches share those on their common
//! corners and seams; a tessellation is that lattice evaluated, so it has no cracks by construction.

mod a_patches;
mod adaptive;
mod crease_normals;
mod hybrid;
mod places;
mod shared_lattice;
mod sharp_normals;
mod triangles;

pub use a_patches::{APatchResolution, APatchTriangles, MAX_INTERVALS, tessellate_a_patches};
pub use adaptive::{AdaptedResolution, resolution_for};
pub use hybrid::{HybridTessellation, tessellate_hybrid};
pub use shared_lattice::{EdgeUse, SharedLattice, SharingError};
pub(crate) use triangles::small_triangles;
pub use triangles::{TessellateError, TessellateOptions, Tessellation, tessellate};
