//! G1 splines of degree-7 Bézier triangles: Tong & Kim 2009, section 6, with the corrections of PAPERS.md.
//!
//! [`build`] is the recipe: boundary rows from the curve network, interior points fitted to the target
//! ([`fit`]), twist points by the [`vertex`] systems, inner rows by the [`edge`] systems, free points last.

mod build;
pub mod condition;
pub mod edge;
mod fill;
pub mod fit;
mod folds;
mod relaxation;
mod shape;
mod surface;
pub mod vertex;

pub use build::{
    Construction, SampledFrom, SplineError, SplineOptions, build, build_shaped, rebuild, relaxed,
};
pub use fill::fill;
pub use folds::normal_deviations;
pub use shape::{ShapeError, ShapeParameters};
pub use surface::{DEGREE, NET, TriangularSpline};
