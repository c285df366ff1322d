//! One file per paper, each reads like the paper's outline.

mod differentiable;
pub mod spline;

pub use differentiable::{Defect, find_defect};
