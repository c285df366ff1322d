//! Fields with a known answer, for tests.

use crate::field::{Constants, Formula};
use crate::geom::{Aabb, Vec3};

pub const TORUS: &str = "(x^2+y^2+z^2+24)^2-100(x^2+y^2)";
pub const DODECA: &str = "x^6+y^6+z^6+20(x^4y^2+y^4z^2+z^4x^2)-1";
pub const DOUBLE_TORUS: &str = "(x^2(x^2-1)+y^2)^2+z^2-0.04";
pub const MCMULLEN: &str = "(x^2+1)(y^2+1)(z^2+1)+8xyz-2";
pub const CHAIR: &str = "(x^2+y^2+z^2-23.75)^2-0.8((z-5)^2-2x^2)((z+5)^2-2y^2)";
pub const DECOCUBE: &str =
    "((x^2+y^2-0.64)^2+(z^2-1)^2)((y^2+z^2-0.64)^2+(x^2-1)^2)((z^2+x^2-0.64)^2+(y^2-1)^2)-0.02";
/// Radii 1 and √2.
pub const NESTED_SPHERES: &str = "(x^2+y^2+z^2-1)(x^2+y^2+z^2-2)";
pub const TWO_SPHERES: &str = "(x^2+y^2+z^2-1)(x^2+y^2+(z-3)^2-1)";
/// Singular at (0, 0, 1).
pub const TOUCHING_SPHERES: &str = "(x^2+y^2+z^2-1)(x^2+y^2+(z-2)^2-1)";
/// Singular at the origin.
pub const LEMNISCATE: &str = "x^2+y^2-z^2(1-z^2)";
pub const PLANE: &str = "x+0.5y-0.25z";
pub const CYLINDER: &str = "x^2+y^2-1";
pub const NO_ZERO: &str = "x^2+y^2+z^2+1";
pub const CONSTANT: &str = "0(x+y+z)";
pub const NAN: &str = "sqrt(-1-x^2)";
/// The sign changes at a pole.
pub const POLE: &str = "1/(x^2+y^2+z^2-1)";

pub fn field(text: &str) -> Formula {
    Formula::parse(text, &Constants::new()).unwrap()
}

pub fn sphere_at(center: Vec3, radius: f64) -> Formula {
    let [x, y, z] = center.into();
    field(&format!("(x-({x:e}))^2+(y-({y:e}))^2+(z-({z:e}))^2-({radius:e})^2"))
}

pub fn unit_sphere() -> Formula {
    sphere_at(Vec3::zeros(), 1.0)
}

pub fn cube(half: f64) -> Aabb {
    Aabb::new(Vec3::repeat(-half), Vec3::repeat(half))
}

/// A surface of Tong & Kim 2009 with what must come out.
pub struct Example {
    pub name: &'static str,
    pub field: Formula,
    pub bounds: Aabb,
    pub faces: usize,
    pub euler: i64,
}

/// The six surfaces of table 3.
pub fn paper_surfaces() -> [Example; 6] {
    let flat = Aabb::new(Vec3::new(-6.4, -6.4, -1.4), Vec3::new(6.4, 6.4, 1.4));
    let double = Aabb::new(Vec3::new(-1.3, -0.9, -0.4), Vec3::new(1.3, 0.9, 0.4));
    [
        ("torus", TORUS, flat, 600, 0),
        ("dodeca", DODECA, cube(1.2), 1200, 2),
        ("double torus", DOUBLE_TORUS, double, 1800, -2),
        ("McMullen", MCMULLEN, cube(2.2), 2000, 2),
        ("chair", CHAIR, cube(8.0), 4000, -4),
        ("decocube", DECOCUBE, cube(1.5), 5000, -24),
    ]
    .map(|(name, text, bounds, faces, euler)| Example { name, field: field(text), bounds, faces, euler })
}
