//! Steps 5 and 8 of the paper: the quadric, and the linear function, nearest to what a cell knows already.

use super::base::Base;
use crate::bernstein::tetrahedron::elevation;
use crate::hull::{FaceFrame, Layer1, Side};
use nalgebra::{SMatrix, SVector};
use std::sync::LazyLock;

/// How layer 2 is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layer2Rule {
    /// From the quadric that has the gradients at the vertices: closed form, and positive wherever layer 1 is.
    #[default]
    Interpolate,
    /// From the quadric nearest to layers 0 and 1 in the least-squares sense (step 5, (4.13) and (4.14)).
    LeastSquares,
}

/// Coefficients of layers 0 and 1 of a cubic cell, in net order.
const KNOWN: usize = 16;
/// Coefficients of layers 0 and 1 of a quadric, in net order.
const QUADRIC: usize = 9;
/// Singular values below this are zero; those of the two matrices are all above 0.1.
const SINGULAR: f64 = 1e-9;

/// Least-squares inverse of the elevation of a quadric, q_0002 = 0, to layers 0 and 1 of a cubic (4.14).
static CUBIC_TO_QUADRIC: LazyLock<SMatrix<f64, QUADRIC, KNOWN>> = LazyLock::new(|| {
    let inverse = elevation(3, KNOWN, QUADRIC).pseudo_inverse(SINGULAR);
    inverse.map_or_else(|_| SMatrix::zeros(), |m| SMatrix::from_iterator(m.iter().copied()))
});

/// Least-squares inverse of the elevation of a linear function to layers 0 and 1 of a quadric (4.16), λ summing to 2.
static QUADRIC_TO_LINEAR: LazyLock<SMatrix<f64, 4, QUADRIC>> = LazyLock::new(|| {
    let inverse = elevation(2, QUADRIC, 4).pseudo_inverse(SINGULAR);
    inverse.map_or_else(|_| SMatrix::zeros(), |m| SMatrix::from_iterator(m.iter().copied()))
});

/// The quadric of a cell up to its coefficient q_0002, which nothing on one face determines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellQuadric {
    /// Net of degree 2 in the order of [`crate::bernstein::tetrahedron`], with q_0002 = 0.
    pub net: [f64; 10],
    /// Value at the apex of the linear function nearest to the quadric: the paper's default for the free parameter.
    pub linear: f64,
}

impl CellQuadric {
    /// Of the cell with this layer 1 on a side.
    pub fn new(face: &FaceFrame, side: Side, layer1: &Layer1, rule: Layer2Rule) -> Self {
        let (e, center) = (&face.e, Base::center(face));
        let base = [0.0, e[0][1], e[0][2], e[1][0], center, e[2][0], 0.0, e[1][2], e[2][1], 0.0];
        let [edge, corner] = [layer1.edge, layer1.corner];
        // Edge 2 joins corners 2 and 0.
        let first = [corner[0], edge[0], edge[2], corner[1], edge[1], corner[2]];
        let known = base.iter().map(|f| side.sign() * f).chain(first);
        let fitted = *CUBIC_TO_QUADRIC * SVector::<f64, KNOWN>::from_iterator(known);
        let linear = (*QUADRIC_TO_LINEAR * fitted)[3];
        let mut net = [0.0; 10];
        net[..QUADRIC].copy_from_slice(fitted.as_slice());
        if rule == Layer2Rule::Interpolate {
            // Its cubic form has f_aau = 2/3 q_au, where q_aa = 0.
            net[6..QUADRIC].copy_from_slice(&corner.map(|f| 1.5 * f));
        }
        Self { net, linear }
    }

    /// q with one index at a corner and one at the apex.
    pub fn towards_apex(&self) -> [f64; 3] {
        [self.net[6], self.net[7], self.net[8]]
    }
}
