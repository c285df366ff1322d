//! Four rays at a time: roots, points and normals.

use crate::geom::{Mat3, Point3, Vec3};
use crate::hull::Side;
use wide::f64x4;

/// Rays that are computed together.
pub const LANES: usize = 4;

/// One number for each of [`LANES`] rays.
pub type Lane = f64x4;

/// Steps of Newton's method for a root.
const STEPS: usize = 4;

/// The last step relative to the root, below which the root has all its digits: errors are squared by a step.
const SETTLED: f64 = 3e-8;

/// The numbers of a run of points in lanes, the last one repeated to fill them.
pub fn lane(points: &[[f64; 3]], f: impl Fn([f64; 3]) -> f64) -> Lane {
    Lane::new(std::array::from_fn(|i| f(points[i.min(points.len() - 1)])))
}

/// The same number in all lanes.
#[inline(always)]
pub fn all(x: f64) -> Lane {
    Lane::splat(x)
}

/// Roots s = t/(1 − t) of cubics with the given layers, as [`crate::bernstein::cubic::simple_root`] finds them. None unless all
/// have the signs (−, +, +, +), or start at zero, and have settled.
#[inline(always)]
pub fn roots(b: &[Lane; 4]) -> Option<Lane> {
    let (c1, c2) = (all(3.0) * b[1], all(3.0) * b[2]);
    let mut s = all(-2.0) * b[0] / (c1 + (c1 * c1 - all(4.0) * (b[0] * c2)).sqrt());
    let mut last = s;
    let (d3, d2) = (all(3.0) * b[3], all(2.0) * c2);
    for _ in 0..STEPS {
        last = s;
        let value = ((b[3] * s + c2) * s + c1) * s + b[0];
        let slope = (d3 * s + d2) * s + c1;
        s -= value / slope;
    }
    let zero = all(0.0);
    let signs = b[0].simd_le(zero) & b[1].simd_gt(zero) & b[2].simd_ge(zero) & b[3].simd_gt(zero);
    let settled = (last - s).abs().simd_le(all(SETTLED) * s);
    (signs & settled).all().then_some(s)
}

/// Are any of the numbers positive, and any negative?
#[inline(always)]
pub fn signs(x: Lane) -> (bool, bool) {
    (x.simd_gt(all(0.0)).any(), all(0.0).simd_gt(x).any())
}

/// The points on rays from q to w, as (q + s w)/(1 + s) = q + t (w − q), and t.
#[inline(always)]
pub fn points(base: [Lane; 3], top: [Lane; 3], s: Lane) -> ([Lane; 3], Lane) {
    let t = s / (all(1.0) + s);
    (std::array::from_fn(|c| base[c] + t * (top[c] - base[c])), t)
}

/// The value of a polynomial in r = 1 − t and t with the binomial factors 1, 2, 1 left out.
#[inline(always)]
pub fn quadratic(r: Lane, t: Lane, [a, b, c]: [Lane; 3]) -> Lane {
    r * (r * a + all(2.0) * (t * b)) + t * t * c
}

/// From derivatives by the barycentric coordinates of a cell to unit normals.
pub struct Normals {
    inverse: [[Lane; 3]; 3],
}

impl Normals {
    /// For the function times the sign of the side.
    pub fn new(side: Side, corners: &[Point3; 4]) -> Self {
        let edges = [1, 2, 3].map(|c| (corners[c] - corners[0]).transpose());
        let inverse = Mat3::from_rows(&edges).try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
        Self { inverse: [0, 1, 2].map(|r| [0, 1, 2].map(|c| all(side.sign() * inverse[(r, c)]))) }
    }

    /// The normals.
    #[inline(always)]
    pub fn of(&self, d: [Lane; 4]) -> [Lane; 3] {
        let e = [d[1] - d[0], d[2] - d[0], d[3] - d[0]];
        let g = self.inverse.map(|m| m[0] * e[0] + m[1] * e[1] + m[2] * e[2]);
        let length = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt();
        g.map(|g| g / length)
    }
}

/// What lanes give: points, and normals if they are wanted.
pub struct Found {
    /// Positions.
    pub points: [Lane; 3],
    /// Unit normals.
    pub normals: Option<[Lane; 3]>,
}

/// The outer result where the base is at most zero, the inner one elsewhere.
pub fn select(base: Lane, outer: Found, inner: Found) -> Found {
    let below = base.simd_le(all(0.0));
    let pick = |a: [Lane; 3], b: [Lane; 3]| std::array::from_fn(|c| below.bitselect(a[c], b[c]));
    let normals = outer.normals.zip(inner.normals).map(|(a, b)| pick(a, b));
    Found { points: pick(outer.points, inner.points), normals }
}

/// The coordinates of a point in all lanes.
pub fn splat(p: &Vec3) -> [Lane; 3] {
    [p.x, p.y, p.z].map(all)
}
