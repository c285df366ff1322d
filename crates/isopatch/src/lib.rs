//! Smooth surfaces made of few patches, from a formula or a polygon mesh.

pub mod base;
pub mod bernstein;
pub mod field;
pub mod geom;
pub mod io;
pub mod mesh;
pub mod network;
pub mod numeric;
pub mod spline;
pub mod surface;
