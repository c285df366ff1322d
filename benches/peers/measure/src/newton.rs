//! The nearest point of a surface, by Newton's method.

use crate::surface::Surface;

/// Where the surface is nearest.
pub struct Foot {
    /// How far it is.
    pub distance: f64,
    /// ∇f there, of length 1.
    pub normal: [f64; 3],
}

/// Steps are at most this share of the diagonal, so that flat places of f throw none far away.
const LONGEST_STEP: f64 = 0.05;
/// A foot that moves by less than this share of the diagonal has been found; errors of 1e-5 are measured.
const FOUND: f64 = 1e-10;
const STEPS: usize = 60;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The foot of the perpendicular from `point`: every step goes to the surface along ∇f (Newton), and to the foot in the
/// tangent plane. It converges where the point is nearer than the centres of curvature.
pub fn foot(surface: Surface, point: [f64; 3], diagonal: f64) -> Foot {
    let longest = LONGEST_STEP * diagonal;
    let mut at = point;
    let mut normal = [0.0; 3];
    for _ in 0..STEPS {
        let f = surface.gradient(at);
        let length = dot(f.slope, f.slope).sqrt().max(f64::MIN_POSITIVE);
        normal = f.slope.map(|s| s / length);
        let off: [f64; 3] = std::array::from_fn(|i| point[i] - at[i]);
        let along = (-f.value / length).clamp(-longest, longest) - dot(off, normal);
        let step: [f64; 3] = std::array::from_fn(|i| off[i] + along * normal[i]);
        at = std::array::from_fn(|i| at[i] + step[i]);
        if dot(step, step) < (FOUND * diagonal).powi(2) {
            break;
        }
    }
    let off: [f64; 3] = std::array::from_fn(|i| point[i] - at[i]);
    Foot { distance: dot(off, off).sqrt(), normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_off_the_torus_is_as_far_as_it_was_moved() {
        for (distance, angle) in [(0.01, 0.3), (-0.2, 2.0), (0.3, 4.0)] {
            let (sin, cos) = f64::sin_cos(angle);
            let point = [5.0 + (1.0 + distance) * cos, 0.0, (1.0 + distance) * sin];
            let foot = foot(Surface::Torus, point, 17.0);
            assert!((foot.distance - f64::abs(distance)).abs() < 1e-8, "{}", foot.distance);
            assert!((dot(foot.normal, [cos, 0.0, sin]) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gradients_are_the_slopes_of_values() {
        let (at, step) = ([0.71, -0.52, 0.33], 1e-6);
        for surface in Surface::ALL {
            let gradient = surface.gradient(at);
            for axis in 0..3 {
                let moved =
                    |h: f64| surface.value(std::array::from_fn(|i| at[i] + if i == axis { h } else { 0.0 }));
                let slope: f64 = (moved(step) - moved(-step)) / (2.0 * step);
                let scale = 1.0 + gradient.slope[axis].abs();
                assert!((slope - gradient.slope[axis]).abs() < 1e-6 * scale, "{}", surface.name());
            }
        }
    }
}
