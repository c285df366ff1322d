//! Where an algebraic surface is singular, and what it is there.

mod cell;
mod cluster;
mod deflation;
mod error;
mod find;
mod graph;
mod lattice;
pub mod mesh;
mod multiplicity;
mod points;
mod recognize;
mod search;
mod set;
mod square_free;
mod subdivide;
mod taylor;
mod tolerance;
mod trace;
mod unit;

pub use error::SingularError;
pub use search::{SingularOptions, singular_set};
pub use set::{
    CurveKind, CurveSample, LowerDimensional, PointKind, SingularCurve, SingularPoint, SingularSet,
    SpecialKind, SpecialPoint, Status,
};
