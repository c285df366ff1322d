//! Where an algebraic surface is singular, and what it is there.

mod set;
mod taylor;
mod unit;

pub use set::{
    CurveKind, CurveSample, LowerDimensional, PointKind, SingularCurve, SingularPoint, SingularSet,
    SpecialKind, SpecialPoint, Status,
};
