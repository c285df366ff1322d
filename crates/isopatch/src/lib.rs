//! Smooth surfaces made of few patches, from a formula or a polygon mesh.

pub mod base;
pub mod bernstein;
pub mod field;
pub mod gallery;
pub mod geom;
pub mod mesh;
pub mod network;
pub mod numeric;
pub mod spline;
pub mod surface;
