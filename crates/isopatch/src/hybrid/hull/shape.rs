//! The form of a polygon: its mean normal, a point that sees all of its sides, its size.

use crate::geom::{Point3, Vec3};

/// A polygon that can carry cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Unit vector along the area vector.
    pub normal: Vec3,
    /// A point from which all sides are seen in their order, in the projection along the normal.
    pub center: Point3,
    /// Largest distance between two corners.
    pub diameter: f64,
    /// Are all corners in one plane, but for rounding?
    pub planar: bool,
}

/// The area between the centre and a side has to be more than this part of the area of the polygon.
const LEAST_SECTOR: f64 = 1e-3;

/// Distances from the mean plane below this, relative to the diameter, are rounding.
const PLANAR: f64 = 1e-10;

/// Roundings of the largest coordinate that a corner may be wrong by.
const COORDINATE_ROUNDINGS: f64 = 8.0;

impl Shape {
    /// None if the polygon has no area, or no point sees all of its sides.
    pub fn new(p: &[Point3]) -> Option<Self> {
        let area = area_vector(p);
        let normal = area.try_normalize(0.0)?;
        let diameter = p.iter().flat_map(|a| p.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
        let mean = mean(p);
        let sees = |c: &Point3| {
            sides(p).all(|[a, b]| (a - c).cross(&(b - c)).dot(&normal) > LEAST_SECTOR * area.norm())
        };
        let center = if sees(&mean) { mean } else { kernel_center(p, &normal).filter(|c| sees(c))? };
        let coordinates = p.iter().map(Vec3::amax).fold(0.0, f64::max);
        let flat = PLANAR * diameter + COORDINATE_ROUNDINGS * f64::EPSILON * coordinates;
        let planar = p.iter().all(|q| (q - mean).dot(&normal).abs() <= flat);
        Some(Self { normal, center, diameter, planar })
    }
}

/// Can cells stand over a polygon with these corners? It needs an area, and a point that sees all of its sides.
pub fn has_room(p: &[Point3]) -> bool {
    Shape::new(p).is_some()
}

fn sides(p: &[Point3]) -> impl Iterator<Item = [&Point3; 2]> {
    (0..p.len()).map(|k| [&p[k], &p[(k + 1) % p.len()]])
}

/// Mean of the corners, relative to the first one, so that a polygon far from the origin loses nothing.
fn mean(p: &[Point3]) -> Point3 {
    p[0] + p.iter().map(|q| q - p[0]).sum::<Vec3>() / p.len() as f64
}

fn area_vector(p: &[Point3]) -> Vec3 {
    0.5 * sides(p).map(|[a, b]| (a - p[0]).cross(&(b - p[0]))).sum::<Vec3>()
}

/// The mean of the corners of the kernel of the polygon: of what is to the left of all sides, seen along the normal. None if
/// that is empty.
fn kernel_center(p: &[Point3], normal: &Vec3) -> Option<Point3> {
    let mut kernel: Vec<Point3> = p.to_vec();
    for [a, b] in sides(p) {
        let left = |x: &Point3| (b - a).cross(&(x - a)).dot(normal);
        let mut clipped = Vec::with_capacity(kernel.len() + 1);
        for [x, y] in sides(&kernel) {
            let (at_x, at_y) = (left(x), left(y));
            if at_x >= 0.0 {
                clipped.push(*x);
            }
            if at_x * at_y < 0.0 {
                clipped.push(x + at_x / (at_x - at_y) * (y - x));
            }
        }
        kernel = clipped;
        if kernel.len() < 3 {
            return None;
        }
    }
    Some(mean(&kernel))
}

/// The line that meets both diagonals of a quadrilateral, along its normal: the middle of the two feet and the unit normal.
///
/// With this axis the tetrahedra of a fan are C1 for any gradients. None if a diagonal is met too close to its ends.
pub(super) fn diagonal_axis(p: &[Point3; 4]) -> Option<(Point3, Vec3)> {
    let [first, second] = [p[2] - p[0], p[3] - p[1]];
    let across = first.cross(&second);
    let normal = across.try_normalize(0.0)?;
    // first · s − second · t is p_1 − p_0 but for a part along the normal.
    let between = p[1] - p[0];
    let squared = across.norm_squared();
    let s = between.cross(&second).dot(&across) / squared;
    let t = between.cross(&first).dot(&across) / squared;
    let inside = DIAGONAL_ENDS..=1.0 - DIAGONAL_ENDS;
    let middle = 0.5 * (p[0] + s * first + p[1] + t * second);
    (inside.contains(&s) && inside.contains(&t)).then_some((middle, normal))
}

/// How close to the end of a diagonal, as a part of its length, the axis may meet it.
const DIAGONAL_ENDS: f64 = 0.02;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_center_sees_all_sides() {
        let flat =
            |xy: &[[f64; 2]]| -> Vec<Point3> { xy.iter().map(|[x, y]| Point3::new(*x, *y, 0.0)).collect() };
        // An L: its mean is outside the kernel, which is the square at the corner.
        let l = flat(&[[0.0, 0.0], [5.0, 0.0], [5.0, 1.0], [1.0, 1.0], [1.0, 5.0], [0.0, 5.0]]);
        let shape = Shape::new(&l).unwrap();
        assert!((shape.center - Point3::new(0.5, 0.5, 0.0)).norm() < 1e-12 && shape.planar);
        assert_eq!(shape.normal, Vec3::z());
        // A U has no such point.
        let u =
            [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [4.0, 5.0], [4.0, 1.0], [1.0, 1.0], [1.0, 5.0], [0.0, 5.0]];
        assert!(Shape::new(&flat(&u)).is_none());
        assert!(Shape::new(&flat(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])).is_none());
    }

    #[test]
    fn the_axis_of_a_bent_quadrilateral_meets_both_diagonals() {
        let p = [[0.0, 0.0, 0.1], [2.0, 0.3, -0.2], [1.8, 1.5, 0.4], [-0.2, 1.2, 0.0]].map(Point3::from);
        let (middle, normal) = diagonal_axis(&p).unwrap();
        for [a, b] in [[0, 2], [1, 3]] {
            let volume = (p[b] - p[a]).cross(&normal).dot(&(middle - p[a]));
            assert!(volume.abs() < 1e-14);
        }
    }
}
