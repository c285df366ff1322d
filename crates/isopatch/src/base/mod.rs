//! From a field to a [`BaseMesh`]: few well-shaped triangles with their vertices exactly on the surface.

mod base_mesh;

pub use base_mesh::{BaseMesh, EdgeFeature};
