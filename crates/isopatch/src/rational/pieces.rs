//! A rational Bézier triangle with base points as four tensor-product pieces with positive weights, exactly.
//!
//! ```text
//!                0                 Cut at the midpoints of the edges. A piece over the triangle A, B, C is
//!               / \                A + s ((1 − τ)(B − A) + τ (C − A)): the side s = 0 is the point A. If A is a
//!              / 0 \               corner, weights and weighted points have a factor s (or a power of it, where the
//!            01 ——— 20             patch has no tangent plane), which is cancelled. Piece k < 3 is at corner k, with B
//!            / \ 3 / \             the midpoint of edge k and C that of edge k + 2; piece 3 is the middle one, from the
//!           / 1 \ / 2 \            midpoints of edges 0, 1 and 2.
//!          1 ——— 12 ——— 2
//! ```

use crate::bernstein::curve::binomial;
use crate::bernstein::index;
use crate::bernstein::restrict::over_triangle;
use crate::geom::{Point3, Vec4};

/// A tensor-product rational Bézier patch over (s, τ) in the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Degrees in s and τ.
    pub degrees: [usize; 2],
    /// Weighted control points (w x, w y, w z, w), row after row; rows are those of equal index in s.
    pub points: Vec<Vec4>,
}

impl Piece {
    /// Weighted control point i in s, j in τ.
    pub fn point(&self, i: usize, j: usize) -> Vec4 {
        self.points[i * (self.degrees[1] + 1) + j]
    }

    /// The rational curve s = 1.
    pub fn far_side(&self) -> &[Vec4] {
        &self.points[self.degrees[0] * (self.degrees[1] + 1)..]
    }

    /// The point at (s, τ).
    pub fn evaluate(&self, s: f64, tau: f64) -> Point3 {
        let rows: Vec<Vec4> =
            self.points.chunks(self.degrees[1] + 1).map(|row| de_casteljau(row, tau)).collect();
        let p = de_casteljau(&rows, s);
        p.xyz() / p.w
    }
}

fn de_casteljau(points: &[Vec4], t: f64) -> Vec4 {
    let mut steps = points.to_vec();
    for left in (1..steps.len()).rev() {
        for i in 0..left {
            steps[i] = (1.0 - t) * steps[i] + t * steps[i + 1];
        }
    }
    steps.first().copied().unwrap_or_else(Vec4::zeros)
}

/// Barycentric corners A, B, C of the four pieces.
pub const TRIANGLES: [[[f64; 3]; 3]; 4] = {
    const CORNER: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const MIDDLE: [[f64; 3]; 3] = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];
    [
        [CORNER[0], MIDDLE[0], MIDDLE[2]],
        [CORNER[1], MIDDLE[1], MIDDLE[0]],
        [CORNER[2], MIDDLE[2], MIDDLE[1]],
        MIDDLE,
    ]
};

/// The four pieces of a triangle of degree `degree`, see the drawing.
pub fn pieces(degree: usize, weighted: &[Vec4]) -> [Piece; 4] {
    TRIANGLES.map(|triangle| piece(degree, &over_triangle(degree, weighted, &triangle)))
}

/// The triangle A, B, C as a tensor product, with the powers of s cancelled that all weights have.
fn piece(n: usize, net: &[Vec4]) -> Piece {
    let row = |r: usize| (0..=r).map(move |k| net[index::position([n - r, r - k, k])]);
    let vanishing = (0..n).take_while(|r| row(*r).all(|p| p.w == 0.0)).count();
    let m = n - vanishing;
    let mut points = Vec::with_capacity((m + 1) * (n + 1));
    for r in vanishing..=n {
        // Σ_r C(n, r) (1 − s)^(n−r) s^r row_r(τ), over s^v: C(n, r)/C(n − v, r − v) is what is left of the binomials.
        let scale = binomial(n, r) / binomial(m, r - vanishing);
        let row: Vec<Vec4> = row(r).map(|p| scale * p).collect();
        points.extend(raised(&row, n));
    }
    Piece { degrees: [m, n], points }
}

/// The same polynomial in degree n.
fn raised(row: &[Vec4], n: usize) -> Vec<Vec4> {
    let r = row.len() - 1;
    let coefficient = |i: usize| {
        let terms = i.saturating_sub(n - r)..=i.min(r);
        let weight = |j: usize| binomial(r, j) * binomial(n - r, i - j) / binomial(n, i);
        terms.map(|j| weight(j) * row[j]).sum()
    };
    (0..=n).map(coefficient).collect()
}
