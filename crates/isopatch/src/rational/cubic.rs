//! Patches over cubic wires: Bajaj & Xu 1997, section 6, "covering cubic wire frames".
//!
//! The conditions ask three products of each vector, and have one solution only if the coefficients of the quadratic normal function are
//! independent; on plane wires they are not. Solved by least squares, as in the paper, the patch is G1 only about: the result says
//! how much is left.

use super::patch::RationalPatch;
use crate::geom::{Mat3, Vec3};
use crate::network::wire_cubic::{Cubic, CubicNormals, least_squares};

/// A patch that is about G1.
#[derive(Clone, Debug)]
pub struct CubicPatch {
    /// The patch.
    pub patch: RationalPatch,
    /// Largest angle between its tangent planes and the normal functions on the edges, in radians, at the samples.
    pub normal_error: f64,
}

/// The cubic triangle over three wires, along the edges of the triangle; `point` is where it is at the barycentric coordinates
/// `at`, which controls its shape. None if `at` is on the border, where the wires are.
pub fn cover(wires: [&Cubic<f64>; 3], at: [f64; 3], point: &Vec3) -> Option<RationalPatch> {
    let mut patch = RationalPatch::over_wires(&wires.map(Cubic::bezier));
    let weight = 6.0 * at[0] * at[1] * at[2];
    if weight.is_nan() || weight <= 0.0 {
        return None;
    }
    let miss = point - patch.evaluate([at[0], at[1]]).point;
    patch.net[super::patch::CENTER] += miss / weight;
    Some(patch)
}

/// The patch over a cover and the normal functions of its wires, with singular values below `tolerance` times the largest left out.
pub fn patch(cover: &RationalPatch, normals: [&CubicNormals<f64>; 3], tolerance: f64) -> CubicPatch {
    let mut patch = cover.clone();
    for k in 0..3 {
        let u = vector(cover, normals[k], k, tolerance);
        patch.across[k] = [Vec3::zeros(), u / 3.0, u / 3.0, Vec3::zeros()];
    }
    let errors = (0..3).map(|k| normal_error(&patch, normals[k], k));
    let normal_error = errors.fold(0.0, f64::max);
    CubicPatch { patch, normal_error }
}

/// U with U·n = −a₀, coefficient by coefficient, where R·n = a₀ t(1 − t) for the derivative R across edge k.
fn vector(cover: &RationalPatch, normals: &CubicNormals<f64>, k: usize, tolerance: f64) -> Vec3 {
    let (r, n) = (cover.derivative_across(k), normals.bezier());
    // Coefficients 1, 2, 3 of the quartic R·n; the outer two vanish.
    let quartic = [
        0.5 * (r[0].dot(&n[1]) + r[1].dot(&n[0])),
        (r[0].dot(&n[2]) + 4.0 * r[1].dot(&n[1]) + r[2].dot(&n[0])) / 6.0,
        0.5 * (r[1].dot(&n[2]) + r[2].dot(&n[1])),
    ];
    let matrix = Mat3::from_columns(&n).transpose();
    let wanted = Vec3::new(-4.0 * quartic[0], -3.0 * quartic[1], -4.0 * quartic[2]);
    least_squares(&matrix, &wanted, tolerance)
}

/// Samples along an edge.
const SAMPLES: usize = 32;

fn normal_error(patch: &RationalPatch, normals: &CubicNormals<f64>, k: usize) -> f64 {
    let at = |i: usize| {
        let t = i as f64 / SAMPLES as f64;
        let mut l = [0.0; 3];
        (l[k], l[(k + 1) % 3]) = (1.0 - t, t);
        let p = patch.evaluate([l[0], l[1]]);
        let (tangent, n) = (p.du.cross(&p.dv), normals.at(&t));
        // Either of two opposite normals will do.
        tangent.cross(&n).norm().atan2(tangent.dot(&n).abs())
    };
    (0..=SAMPLES).map(at).fold(0.0, f64::max)
}
