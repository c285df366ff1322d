//! One file per paper, each reads like the paper's outline.

mod differentiable;
mod least;
mod refine;
pub mod spline;

pub use differentiable::{Defect, find_defect};
