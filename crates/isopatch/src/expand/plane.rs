//! Plane geometry in a tangent plane.

use crate::geom::{Mat3, Point3, Vec3};

/// A frame at an edge: X along it, Y to its left, Z the normal.
pub(super) struct Plane {
    origin: Point3,
    frame: Mat3,
}

impl Plane {
    pub fn new(origin: Point3, along: Vec3, normal: Vec3) -> Self {
        let x = (along - normal * along.dot(&normal)).try_normalize(0.0).unwrap_or_else(Vec3::x);
        let y = normal.cross(&x);
        Self { origin, frame: Mat3::from_rows(&[x.transpose(), y.transpose(), normal.transpose()]) }
    }

    pub fn origin(&self) -> Point3 {
        self.origin
    }

    pub fn project(&self, p: &Point3) -> Vec3 {
        self.frame * (p - self.origin)
    }

    pub fn lift(&self, q: [f64; 2]) -> Point3 {
        self.origin + self.frame.transpose() * Vec3::new(q[0], q[1], 0.0)
    }
}

/// Twice the signed area of a triangle in the plane.
fn turn(p: &Vec3, q: &Vec3, r: &Vec3) -> f64 {
    (q - p).xy().perp(&(r - p).xy())
}

/// Do two segments in the plane have a point in common?
pub(super) fn crosses(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> bool {
    let apart = |u: f64, v: f64| u * v > 0.0;
    let beside =
        |u: &dyn Fn(&Vec3) -> f64| u(a).max(u(b)) < u(c).min(u(d)) || u(c).max(u(d)) < u(a).min(u(b));
    // Segments of one line meet if their ranges do.
    if beside(&|p| p.x) || beside(&|p| p.y) {
        return false;
    }
    !apart(turn(a, b, c), turn(a, b, d)) && !apart(turn(c, d, a), turn(c, d, b))
}

/// The shape of a triangle in the plane: 1 if equilateral, 0 if flat.
pub(super) fn shape(p: &Vec3, q: &Vec3, r: &Vec3) -> f64 {
    let squares: f64 = [(p, q), (q, r), (r, p)].iter().map(|(u, v)| (*u - *v).xy().norm_squared()).sum();
    2.0 * 3f64.sqrt() * turn(p, q, r).abs() / squares
}

/// Distance to a segment.
pub(super) fn distance_to_segment(p: &Vec3, [a, b]: &[Vec3; 2]) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    (p - (a + d * if t.is_finite() { t } else { 0.0 })).norm()
}
