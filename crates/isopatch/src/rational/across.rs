//! The correction that makes a patch tangent to the planes along an edge, without a linear system.
//!
//! Along edge k let C be the wire, b(t) the direction across it that both patches share ([`crate::network::wire::across`]), and R
//! the derivative of P₃ across the edge. The patch is to have D = h C′ + k b for a derivative: it lies in the plane of C′ and
//! b whatever h and k are. They are linear, and such that D = R at both ends, where R is in the plane already. D and R are
//! polynomials, of degree 3 and 2, so D − R is the cubic that [`RationalPatch::across`] holds.

use super::patch::RationalPatch;
use crate::geom::Vec3;

/// Share of k at the other end that a singular end takes where its own has the wrong sign.
const SINGULAR_SHARE: f64 = 0.25;

/// The coefficients for edge k. `b` along the edge, to the side of the patch; `regular`: has the patch a tangent plane at the
/// start and at the end of the edge, with b in it? There the correction vanishes, elsewhere it has a pole.
pub fn correction(patch: &RationalPatch, k: usize, b: &[Vec3; 3], regular: [bool; 2]) -> [Vec3; 4] {
    let r = patch.derivative_across(k);
    let wire = patch.wire(k);
    let c: [Vec3; 3] = std::array::from_fn(|m| 3.0 * (wire[m + 1] - wire[m]));
    let share = |of: &Vec3, in_direction: &Vec3| match in_direction.norm_squared() {
        0.0 => 0.0,
        square => of.dot(in_direction) / square,
    };
    let h = [share(&r[0], &c[0]), share(&r[2], &c[2])];
    let k = of_one_sign([share(&r[0], &b[0]), share(&r[2], &b[2])], regular);
    let along = times(h, &c);
    let aside = times(k, b);
    let raised = [r[0], (r[0] + 2.0 * r[1]) / 3.0, (2.0 * r[1] + r[2]) / 3.0, r[2]];
    let mut t: [Vec3; 4] = std::array::from_fn(|i| along[i] + aside[i] - raised[i]);
    for (end, i) in [0, 3].into_iter().enumerate() {
        if regular[end] {
            t[i] = Vec3::zeros();
        }
    }
    t
}

/// If k changes its sign along the edge, the patch turns over. A singular end can take the sign of the other.
fn of_one_sign([k0, k1]: [f64; 2], regular: [bool; 2]) -> [f64; 2] {
    if k0 * k1 > 0.0 {
        return [k0, k1];
    }
    match regular {
        [false, true] => [SINGULAR_SHARE * k1, k1],
        [true, false] => [k0, SINGULAR_SHARE * k0],
        // b points into the patch.
        [false, false] if k0 > 0.0 => [k0, SINGULAR_SHARE * k0],
        [false, false] if k1 > 0.0 => [SINGULAR_SHARE * k1, k1],
        _ => [k0, k1],
    }
}

/// Bernstein coefficients of the product of a linear and a quadratic polynomial.
fn times([x0, x1]: [f64; 2], q: &[Vec3; 3]) -> [Vec3; 4] {
    [x0 * q[0], (2.0 * x0 * q[1] + x1 * q[0]) / 3.0, (x0 * q[2] + 2.0 * x1 * q[1]) / 3.0, x1 * q[2]]
}
