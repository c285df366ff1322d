//! Hybrid A-patches: triangles, quadrilaterals and larger polygons as they are (Xu, Bajaj & Evans).
//!
//! The construction of [`apatch`](crate::apatch) with other cells over the faces: see [`Element`].

mod cells;
mod data;
pub mod hull;
mod quadric;

pub use cells::{Element, HybridEdge, HybridFace, HybridHull, Jet};
pub use data::{HermitePolygons, PolygonFrame, middle_gradient};
pub use quadric::Quadric;
