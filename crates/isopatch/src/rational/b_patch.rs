//! B-patches, and the triangular B-spline form of a patch.
//!
//! A B-patch (Seidel) of degree n has n knots at each corner of its triangle. Its control point (i, j, k) is the polar form of the
//! polynomial at the first i knots of corner 0, the first j of corner 1 and the first k of corner 2; with all knots of a corner in the
//! corner itself, it is the Bézier form. Over a triangulation these are the control points of the triangular B-spline (Dahmen,
//! Micchelli & Seidel) with the same knots: where all knots are in the vertices, its simplex splines are the Bernstein polynomials
//! of one triangle each, and any continuity that the patches have comes from their control points.

use crate::bernstein::index;
use crate::geom::{Point3, Vec4};

/// Knots of a corner, as barycentric coordinates in the triangle of the patch.
pub type Knots = Vec<[f64; 3]>;

/// A rational B-patch.
#[derive(Clone, Debug, PartialEq)]
pub struct BPatch {
    degree: usize,
    knots: [Knots; 3],
    points: Vec<Vec4>,
}

/// Knots from which a B-patch can't be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KnotError {
    /// A corner has another number of knots than the degree.
    #[error("corner {corner} has {given} knots; the degree is {degree}")]
    Count {
        /// The corner.
        corner: usize,
        /// How many knots it has.
        given: usize,
        /// The degree.
        degree: usize,
    },
    /// Three knots that make a triangle of the recursion are on a line.
    #[error("knots {knots:?} of the three corners are on a line")]
    Collinear {
        /// Which knot of each corner.
        knots: [usize; 3],
    },
}

/// Triangles of knots with a smaller area, relative to that of the patch, count as none.
const LEAST_AREA: f64 = 1e-9;

impl BPatch {
    /// The B-patch with given knots that is the same surface as a rational Bézier triangle. Weights can become negative where knots are far
    /// from the corners.
    pub fn new(degree: usize, weighted: &[Vec4], knots: [Knots; 3]) -> Result<Self, KnotError> {
        for (corner, of_corner) in knots.iter().enumerate() {
            if of_corner.len() != degree {
                return Err(KnotError::Count { corner, given: of_corner.len(), degree });
            }
        }
        for ijk in (0..degree).flat_map(index::indices) {
            if area(&triangle(&knots, ijk)).abs() < LEAST_AREA {
                return Err(KnotError::Collinear { knots: ijk });
            }
        }
        let point = |ijk: [usize; 3]| {
            let arguments = (0..3).flat_map(|c| knots[c][..ijk[c]].iter().copied());
            polar_form(weighted, degree, arguments)
        };
        let points = index::indices(degree).map(point).collect();
        Ok(Self { degree, knots, points })
    }

    /// All knots in the corners: the triangular B-spline with knots of full multiplicity.
    pub fn with_multiple_knots(degree: usize, weighted: &[Vec4]) -> Self {
        let corner = |c: usize| vec![std::array::from_fn(|i| f64::from(u8::from(i == c))); degree];
        Self { degree, knots: [0, 1, 2].map(corner), points: weighted.to_vec() }
    }

    /// Polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The knots of the three corners.
    pub fn knots(&self) -> &[Knots; 3] {
        &self.knots
    }

    /// Weighted control points in the order of [`crate::bernstein`].
    pub fn points(&self) -> &[Vec4] {
        &self.points
    }

    /// The point at (u, v), by Seidel's recursion: in each step a triangle of knots takes the place of that of the patch.
    pub fn evaluate(&self, [u, v]: [f64; 2]) -> Point3 {
        let x = [u, v, 1.0 - u - v];
        let mut steps = self.points.clone();
        for degree in (0..self.degree).rev() {
            for ijk in index::indices(degree) {
                let weights = coordinates(&triangle(&self.knots, ijk), x);
                let term = |c: usize| {
                    let mut raised = ijk;
                    raised[c] += 1;
                    weights[c] * steps[index::position(raised)]
                };
                // Positions of the lower degree come no later than those they are made from.
                let sum = term(0) + term(1) + term(2);
                steps[index::position(ijk)] = sum;
            }
        }
        let p = steps.first().copied().unwrap_or_else(Vec4::zeros);
        p.xyz() / p.w
    }
}

fn triangle(knots: &[Knots; 3], ijk: [usize; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| knots[c][ijk[c]])
}

/// Area of a triangle in barycentric coordinates, 1 for that of the patch.
fn area([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// Barycentric coordinates of x in a triangle.
fn coordinates(corners: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    let whole = area(corners);
    std::array::from_fn(|c| {
        let mut replaced = *corners;
        replaced[c] = x;
        area(&replaced) / whole
    })
}

/// The polar form of a polynomial in Bézier form at `degree` arguments.
fn polar_form(net: &[Vec4], degree: usize, arguments: impl Iterator<Item = [f64; 3]>) -> Vec4 {
    let mut steps = net.to_vec();
    for (degree, [u, v, w]) in (0..degree).rev().zip(arguments) {
        for (p, [_, j, k]) in index::indices(degree).enumerate() {
            let row = j + k;
            steps[p] = steps[p] * u + steps[p + row + 1] * v + steps[p + row + 2] * w;
        }
    }
    steps.first().copied().unwrap_or_else(Vec4::zeros)
}
