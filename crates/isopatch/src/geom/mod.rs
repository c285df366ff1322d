//! Points, boxes, intervals and jets: the small values that everything else is made of.
//!
//! Positions are vectors ([`Point3`] is an alias of [`Vec3`]), because Bernstein–Bézier algebra forms affine
//! combinations of points all the time and a separate point type would hide the formulas.

mod aabb;
mod affine;
mod angle;
mod box_tree;
mod interval;
mod jet;
mod morton;
mod points;

pub use aabb::Aabb;
pub use affine::Affine;
pub use angle::angle_between;
pub(crate) use angle::{Widest, normal_jump};
pub use box_tree::BoxTree;
pub use interval::Interval;
pub use jet::{Jet, Jets};
pub use morton::morton_order;
pub use points::{Points, PointsMut, PointsView};

/// A vector of three coordinates, in model units.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A position, in model units, as its vector from the origin.
pub type Point3 = Vec3;
/// A point in homogeneous coordinates: weight times position, then the weight.
pub type Vec4 = nalgebra::Vector4<f64>;
/// A 3×3 matrix, such as a Hessian or a curvature tensor.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Are all coordinates finite? The loop has no end before the last vector, which makes it one over lanes.
pub fn are_finite(vectors: &[Vec3]) -> bool {
    vectors.iter().fold(true, |all, v| all & v.x.is_finite() & v.y.is_finite() & v.z.is_finite())
}
