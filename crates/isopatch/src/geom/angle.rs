//! Angles between vectors.

use super::Vec3;
use std::f64::consts::PI;

/// The angle between two nonzero vectors, in radians, in [0, π].
///
/// Accurate for tiny angles, where the arc cosine of the dot product would lose half of the digits.
pub fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// The angle between two normals of any length; π if one of them vanishes or is not a number.
pub fn normal_jump(a: &Vec3, b: &Vec3) -> f64 {
    let usable = |n: &Vec3| n.norm_squared() > 0.0 && n.norm_squared().is_finite();
    if usable(a) && usable(b) { angle_between(a, b) } else { PI }
}

/// The widest angle between two normals, found by its tangent: an arc tangent takes as long as the rest of a sample.
#[derive(Default)]
pub struct Widest {
    /// Square of the largest tangent of an acute angle, and the normals that have it.
    tangent: f64,
    normals: Option<[Vec3; 2]>,
    /// The largest of the other angles.
    obtuse: f64,
}

impl Widest {
    /// Takes the angle between two normals of any length; is it acute?
    pub fn add(&mut self, a: Vec3, b: Vec3) -> bool {
        let cosine = a.dot(&b);
        let tangent = a.cross(&b).norm_squared() / (cosine * cosine);
        // Neither if a number is not finite, or over- or underflows.
        if !(cosine > 0.0 && tangent.is_finite()) {
            self.obtuse = self.obtuse.max(normal_jump(&a, &b));
            return cosine > 0.0;
        }
        if tangent > self.tangent {
            (self.tangent, self.normals) = (tangent, Some([a, b]));
        }
        true
    }

    /// The widest angle, in radians; 0 if there was none.
    pub fn angle(&self) -> f64 {
        self.normals.map_or(0.0, |[a, b]| normal_jump(&a, &b)).max(self.obtuse)
    }
}
