//! Surfaces cut by a box, for tests.

use super::test_fields::field;
use super::*;
use crate::field::Formula;
use crate::geom::Aabb;

/// A surface with the box that cuts it.
pub struct Cut {
    pub name: &'static str,
    pub field: Formula,
    pub bounds: Aabb,
    /// A number of faces that suffices.
    pub least: usize,
}

fn cut(name: &'static str, text: &str, min: [f64; 3], max: [f64; 3], least: usize) -> Cut {
    Cut { name, field: field(text), bounds: Aabb::new(min.into(), max.into()), least }
}

pub const GYROID: &str = "sin(x)cos(y)+sin(y)cos(z)+sin(z)cos(x)";
pub const SCHWARZ_P: &str = "cos(x)+cos(y)+cos(z)";

pub fn gyroid() -> Cut {
    let r = 0.9 * std::f64::consts::PI;
    cut("gyroid", GYROID, [-r; 3], [r; 3], 300)
}

pub fn cuts() -> Vec<Cut> {
    let r = 0.9 * std::f64::consts::PI;
    vec![
        gyroid(),
        cut("Schwarz P", SCHWARZ_P, [-r; 3], [r; 3], 300),
        cut("Schwarz P, two periods", SCHWARZ_P, [-6.0, -6.0, -6.0], [6.0, 6.0, 6.0], 2000),
        cut("Scherk", "sin(z)-sinh(x)sinh(y)", [-2.0, -2.0, -4.0], [2.0, 2.0, 4.0], 300),
        cut("upright plane", "x-0.1", [-1.0; 3], [1.0; 3], 20),
        cut("oblique plane", "x+2y+3z-0.05", [-1.0; 3], [1.0; 3], 20),
        cut("paraboloid", "z-x^2-y^2", [-1.0, -1.0, -0.25], [1.0, 1.0, 0.9], 80),
        cut("cylinder", "x^2+y^2-1", [-1.5, -1.5, -1.0], [1.5, 1.5, 1.0], 60),
        // A sphere inside, and one that the box cuts.
        cut("two spheres", "((x-1)^2+y^2+z^2-0.5)((x+1)^2+y^2+z^2-0.5)", [-1.0; 3], [2.0, 1.0, 1.0], 200),
    ]
}

pub fn seed_of(cut: &Cut) -> Seed {
    seed_mesh(&cut.field, &cut.bounds, None, &SeedOptions::default()).unwrap()
}
