//! Boundary curves over the edges of a base mesh: the quartics of splines, and the wires of rational patches.

mod ends;
mod normal_distance;
pub mod number;
mod quartic;
mod reduced;
mod section;
mod sqp;
pub mod wire;
pub mod wire_conic;
pub mod wire_cubic;
pub mod wire_fit;

pub use quartic::{
    CurveError, CurveOptions, CurveSolver, QuarticCurve, fit_edges, fit_quartics, interpolate_edges,
};

#[cfg(test)]
mod tests;
