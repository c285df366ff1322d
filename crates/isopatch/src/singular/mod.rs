//! Where an algebraic surface is singular, and what it is there.

mod cell;
mod cluster;
mod components;
mod containment;
mod deflation;
mod error;
mod find;
mod graph;
mod lattice;
pub mod mesh;
mod multiplicity;
mod points;
mod precise;
mod recognize;
mod reduced;
mod search;
mod set;
mod square_free;
mod subdivide;
mod taylor;
mod tolerance;
mod trace;
mod uncovered;
mod unit;

pub use components::Components;
pub use error::SingularError;
pub use reduced::without_repeated_factors;
pub use search::{Analysis, SingularOptions, analyse, components, singular_set};
pub use set::{
    CurveKind, CurveSample, LowerDimensional, PointKind, SingularCurve, SingularPoint, SingularSet,
    SpecialKind, SpecialPoint, Status,
};
