//! Boundary curves over the edges of a base mesh.

mod quartic;

pub use quartic::{CurveError, CurveOptions, QuarticCurve, fit_quartics};

#[cfg(test)]
mod tests;
