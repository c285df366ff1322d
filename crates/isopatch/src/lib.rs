//! Smooth surfaces made of few patches, from a formula or a polygon mesh.

pub mod base;
pub mod bernstein;
pub mod field;
pub mod gallery;
pub mod geom;
pub mod inspect;
pub mod io;
pub mod mesh;
pub mod network;
pub mod numeric;
pub mod report;
pub mod spline;
pub mod surface;
pub mod tessellate;

// Test surfaces, shared with the integration tests, which name this crate from outside.
#[cfg(test)]
extern crate self as isopatch;
#[cfg(test)]
#[path = "../tests/support/golden.rs"]
mod golden;
