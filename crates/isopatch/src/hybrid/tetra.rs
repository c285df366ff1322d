//! Barycentric coordinates in tetrahedra.

use crate::geom::{Mat3, Point3, Vec3};

/// Barycentric coordinates of x in a tetrahedron; not finite if that is flat.
pub fn barycentric(tetrahedron: [Point3; 4], x: &Point3) -> [f64; 4] {
    let [a, b, c, d] = tetrahedron;
    let inverse = Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse();
    let r = inverse.map_or(Vec3::repeat(f64::NAN), |inverse| inverse * (x - a));
    [1.0 - r.sum(), r.x, r.y, r.z]
}

/// Where x is along the line from `from`, where it is 0, to `to`, where it is 1.
pub fn fraction(from: &Point3, to: &Point3, x: &Point3) -> f64 {
    let line = to - from;
    (x - from).dot(&line) / line.norm_squared()
}

/// Gradient of a function in a tetrahedron by its derivatives by the barycentric coordinates.
pub fn gradient(corners: &[Point3; 4], d: [f64; 4]) -> Vec3 {
    let edges = [1, 2, 3].map(|c| (corners[c] - corners[0]).transpose());
    let inverse = Mat3::from_rows(&edges).try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
    inverse * Vec3::new(d[1] - d[0], d[2] - d[0], d[3] - d[0])
}
