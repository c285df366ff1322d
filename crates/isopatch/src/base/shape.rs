//! Shape of one triangle beside the normals of the surface at its corners.

use crate::geom::{Mat3, Point3, Vec3};

/// Largest absolute principal curvature, from the curvature tensor (its third eigenvalue, along the normal, is zero).
///
/// k₁ + k₂ = tr M and k₁² + k₂² = |M|², so |k|max = |tr M|/2 + √(|M|²/2 − (tr M)²/4).
pub fn largest_curvature(tensor: &Mat3) -> f64 {
    let half_trace = 0.5 * tensor.trace();
    half_trace.abs() + (0.5 * tensor.norm_squared() - half_trace * half_trace).max(0.0).sqrt()
}

/// The vector scaled to length 1, or zero if it has no direction.
pub(super) fn unit_or_zero(v: &Vec3) -> Vec3 {
    let n = v / v.norm();
    if n.sum().is_finite() { n } else { Vec3::zeros() }
}

/// Twice the area times the unit normal.
pub(super) fn area_vector([a, b, c]: [Point3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// Cosine of the largest angle of a triangle; −1 if two corners agree.
pub(super) fn largest_angle_cosine([a, b, c]: [Point3; 3]) -> f64 {
    let (ab, bc, ca) = ((b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared());
    // The largest angle is opposite to the longest edge; law of cosines. Which one that is cannot be foretold by branches.
    let (s, longer) = if ab < bc { (ab, bc) } else { (bc, ab) };
    let (t, longest) = if longer < ca { (longer, ca) } else { (ca, longer) };
    if s * t == 0.0 { -1.0 } else { (s + t - longest) / (2.0 * (s * t).sqrt()) }
}

/// Smallest cosine between the face normal and the normals at the corners; −1 for a face without area.
pub(super) fn facing(corners: [Point3; 3], normals: [&Vec3; 3]) -> f64 {
    let n = area_vector(corners);
    let length = n.norm();
    if length > 0.0 { normals.iter().map(|m| n.dot(m)).fold(f64::INFINITY, f64::min) / length } else { -1.0 }
}
