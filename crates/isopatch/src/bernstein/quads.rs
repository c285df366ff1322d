//! The exact split of a Bézier triangle of degree 7 into three bi-degree-7 tensor-product patches.
//!
//! ```text
//!                0                   Quad m has its corner (0,0) at vertex m, (7,0) at the midpoint of edge
//!               / \                  m → m + 1, (7,7) at the centroid, (0,7) at the midpoint of edge
//!              / 0 \                 m + 2 → m. Row j = 0 of quad m is the first half of edge m; row i = 0
//!             01   20                of quad m + 1 is the second half, backwards.
//!            /  \ /  \
//!           /    c    \
//!          /  1  |  2  \
//!         1 ---- 12 --- 2
//! ```

use super::{curve::binomial, index};
use crate::geom::Point3;
use nalgebra::SMatrix;
use pulp::{Arch, NullaryFnOnce};
use std::sync::LazyLock;

/// Degree of the triangle and of the quads in either direction.
pub const DEGREE: usize = 7;
const SIDE: usize = DEGREE + 1;
const NET: usize = index::count(DEGREE);

/// Control points `c[i][j]` of a tensor-product patch, i in the first parameter.
pub type QuadNet = [[Point3; SIDE]; SIDE];

/// What each control point of the triangle gives to those of quad 0, which stand at 8 i + j; the other quads are turned copies.
static CONVERSION: LazyLock<Vec<[f64; SIDE * SIDE]>> = LazyLock::new(|| {
    let rows = conversion_rows();
    (0..NET).map(|c| std::array::from_fn(|p| rows[p][c])).collect()
});

/// For each quad, where the control points of the triangle stand when its corner there comes first.
static TURNED: LazyLock<[[usize; NET]; 3]> = LazyLock::new(|| std::array::from_fn(turned));

/// c_ij = 1/(C(7,i) C(7,j)) Σ 7!/(n00! n10! n01! n11!) · blossom(P00^n00 P10^n10 P01^n01 P11^n11) with
/// n10 + n11 = i, n01 + n11 = j and seven arguments in all: the triangle's polynomial after the
/// bilinear map onto the quad, multiplied out. All weights are ≥ 0.
fn conversion_rows() -> Vec<[f64; NET]> {
    let corner = [1.0, 0.0, 0.0];
    let (next, previous, centre) = ([0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [1.0 / 3.0; 3]);
    let mut rows = Vec::with_capacity(SIDE * SIDE);
    for i in 0..SIDE {
        for j in 0..SIDE {
            let mut row = [0.0; NET];
            for n11 in (i + j).saturating_sub(DEGREE)..=i.min(j) {
                let (n10, n01) = (i - n11, j - n11);
                let n00 = DEGREE - n10 - n01 - n11;
                let count = binomial(DEGREE, i) * binomial(i, n11) * binomial(DEGREE - i, n01);
                let weight = count / (binomial(DEGREE, i) * binomial(DEGREE, j));
                let arguments = [(corner, n00), (next, n10), (previous, n01), (centre, n11)];
                let blossom = blossom_row(&arguments);
                row.iter_mut().zip(blossom).for_each(|(r, b)| *r += weight * b);
            }
            rows.push(row);
        }
    }
    rows
}

/// Coefficients of the blossom (polar form) at the given arguments, each repeated.
fn blossom_row(arguments: &[([f64; 3], usize)]) -> [f64; NET] {
    let mut rows = SMatrix::<f64, NET, NET>::identity();
    let mut degree = DEGREE;
    for (a, repeat) in arguments {
        for _ in 0..*repeat {
            degree -= 1;
            for [i, j, k] in index::indices(degree) {
                let raised = [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]].map(index::position);
                let combined =
                    rows.row(raised[0]) * a[0] + rows.row(raised[1]) * a[1] + rows.row(raised[2]) * a[2];
                rows.set_row(index::position([i, j, k]), &combined);
            }
        }
    }
    std::array::from_fn(|c| rows[(0, c)])
}

/// The three quads of a degree-7 net, see the drawing. The quads agree with the triangle to rounding; points
/// that neighbouring quads share are computed more than once and can differ in the last bit.
pub fn split(net: &[Point3; NET]) -> [QuadNet; 3] {
    Arch::new().dispatch(Split { net, conversion: &CONVERSION, turned: &TURNED })
}

struct Split<'a> {
    net: &'a [Point3; NET],
    conversion: &'a [[f64; SIDE * SIDE]],
    turned: &'a [[usize; NET]; 3],
}

impl NullaryFnOnce for Split<'_> {
    type Output = [QuadNet; 3];

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut quads = [[[Point3::zeros(); SIDE]; SIDE]; 3];
        for (quad, turned) in quads.iter_mut().zip(self.turned) {
            for axis in 0..3 {
                let mut sums = [0.0; SIDE * SIDE];
                for (shares, at) in self.conversion.iter().zip(turned) {
                    let x = self.net[*at][axis];
                    sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * x);
                }
                for (p, sum) in sums.iter().enumerate() {
                    quad[p / SIDE][p % SIDE][axis] = *sum;
                }
            }
        }
        quads
    }
}

/// The net's numbers in the order in which corner `m` comes first.
fn turned(m: usize) -> [usize; NET] {
    let mut turned = [0; NET];
    for ijk in index::indices(DEGREE) {
        let mut source = [0; 3];
        (0..3).for_each(|c| source[(c + m) % 3] = ijk[c]);
        turned[index::position(ijk)] = index::position(source);
    }
    turned
}
