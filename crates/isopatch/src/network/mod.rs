//! Boundary curves over the edges of a base mesh.

mod ends;
mod normal_distance;
mod quartic;
mod reduced;
mod section;
mod sqp;

pub use quartic::{
    CurveError, CurveOptions, CurveSolver, QuarticCurve, fit_edges, fit_quartics, interpolate_edges,
};

#[cfg(test)]
mod tests;
