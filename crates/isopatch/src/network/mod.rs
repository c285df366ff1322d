//! Boundary curves over the edges of a base mesh.

mod ends;
mod normal_distance;
mod quartic;
mod reduced;
mod section;

pub use quartic::{CurveError, CurveOptions, QuarticCurve, fit_edges, fit_quartics, interpolate_edges};

#[cfg(test)]
mod tests;
