//! Where an algebraic surface is singular, and what it is there.

pub mod mesh;
mod set;

pub use set::{
    CurveKind, CurveSample, LowerDimensional, PointKind, SingularCurve, SingularPoint, SingularSet,
    SpecialKind, SpecialPoint, Status,
};
