//! Formulas that never change their sign: they have no surface, only places where they touch zero.

use crate::field::{Field, Formula};
use crate::geom::{Aabb, Point3, Vec3};

/// A formula that has no surface, as far as samples tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no surface was found: the formula is nowhere {} where it was sampled, so that its zeros are points, curves or doubled sheets \
     at most (isopatch singular with a --box finds points and curves; of a squared formula, take the root)",
    if *.negative { "positive" } else { "negative" }
)]
pub struct Touching {
    /// Is f ≤ 0 (or else f ≥ 0)?
    pub negative: bool,
}

/// Half the sides of the cubes that are sampled, from details around a point up to everything, as powers of 2.
const SCALES: [i32; 9] = [-20, -10, -5, -2, 0, 2, 5, 10, 20];
/// Samples along each side of a cube or a box.
const SAMPLES: usize = 16;

/// Does f keep its sign, or vanish, in `bounds`, or else in cubes of all sizes around the origin, and around `near` if
/// something seemed to be there? None if it has both signs, or no values.
pub fn touching(formula: &Formula, bounds: Option<&Aabb>, near: Option<Point3>) -> Option<Touching> {
    let cubes = |center: Point3| SCALES.map(|n| cube(center, 2f64.powi(n)));
    let mut regions = Vec::new();
    match bounds {
        Some(bounds) => regions.push(*bounds),
        None => regions.extend(cubes(Point3::zeros())),
    }
    regions.extend(near.into_iter().flat_map(cubes));
    let signs = regions.iter().map(|region| signs(formula, region));
    let [positive, negative] = signs.fold([false; 2], |a, b| [a[0] | b[0], a[1] | b[1]]);
    (positive != negative).then_some(Touching { negative })
}

fn cube(center: Point3, half: f64) -> Aabb {
    let half = Vec3::repeat(half);
    Aabb::new(center - half, center + half)
}

/// Is f above zero, and is it below, at a sample?
fn signs(formula: &Formula, region: &Aabb) -> [bool; 2] {
    let share = |i: usize| i as f64 / (SAMPLES - 1) as f64;
    let mut found = [false; 2];
    for n in 0..SAMPLES.pow(3) {
        let t = Vec3::new(share(n % SAMPLES), share(n / SAMPLES % SAMPLES), share(n / SAMPLES / SAMPLES));
        let p = region.min + region.size().component_mul(&t);
        let f = formula.value(p);
        let is_certain = f.abs() > formula.rounding_bound(p);
        found[0] |= is_certain && f > 0.0;
        found[1] |= is_certain && f < 0.0;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Constants;

    fn sign(text: &str, bounds: Option<Aabb>) -> Option<bool> {
        let formula = Formula::parse(text, &Constants::new()).unwrap();
        touching(&formula, bounds.as_ref(), Some(Point3::new(1.0, 0.0, 0.0))).map(|found| found.negative)
    }

    #[test]
    fn points_curves_and_doubled_sheets_keep_the_sign() {
        for text in
            ["x^2+y^2+z^2", "x^2+y^2", "(x^2+y^2+z^2-1)^2", "exp(x^2+y^2+z^2)-1", "abs(x)+abs(y)+abs(z)"]
        {
            assert_eq!(sign(text, None), Some(false), "{text}");
            assert_eq!(sign(&format!("-({text})"), None), Some(true), "{text}");
        }
    }

    #[test]
    fn surfaces_change_the_sign() {
        for text in ["x", "x*y*z", "x^2+y^2-z^2", "x^2+y^2+z^2-1e-3", "(x-1)^2+y^2-z^2"] {
            assert_eq!(sign(text, None), None, "{text}");
        }
        let box_inside = cube(Point3::zeros(), 0.25);
        assert_eq!(sign("x^2+y^2+z^2-1", Some(box_inside)), None, "the point beside counts, too");
    }
}
