//! The wedge between the cells of two faces that share an edge.

use super::class::Side;
use super::problem::Reason;
use super::tetrahedron;
use crate::geom::{Mat3, Point3, Vec3};
use std::f64::consts::PI;

/// An edge from p_i to p_j with the face k on its left and the face l on its right.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFrame {
    /// Start.
    pub p_i: Point3,
    /// End.
    pub p_j: Point3,
    /// The third corner of the left face.
    pub p_k: Point3,
    /// The third corner of the right face.
    pub p_l: Point3,
}

/// The cell [u_l, p_i, p_j, u_k] of an edge on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeCell {
    /// μ: barycentric coordinates of u_l in [p_k, p_i, p_j, u_k].
    pub mu: [f64; 4],
    /// ν: barycentric coordinates of u_k in [u_l, p_i, p_j, p_l].
    pub nu: [f64; 4],
    /// Angle at the edge, from the plane of u_k to the plane of u_l, in radians; negative if the face cells overlap.
    pub angle: f64,
}

/// Barycentric coordinates of x in a tetrahedron; not finite if that is flat. The search for a hull needs no more digits.
fn barycentric(tetrahedron: [Point3; 4], x: &Point3) -> [f64; 4] {
    let [a, b, c, d] = tetrahedron;
    let inverse = Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse();
    let r = inverse.map_or(Vec3::repeat(f64::NAN), |inverse| inverse * (x - a));
    [1.0 - r.sum(), r.x, r.y, r.z]
}

impl EdgeFrame {
    /// The cell between the apexes of the two faces.
    pub fn cell(&self, side: Side, u_k: &Point3, u_l: &Point3) -> EdgeCell {
        EdgeCell {
            mu: barycentric([self.p_k, self.p_i, self.p_j, *u_k], u_l),
            nu: barycentric([*u_l, self.p_i, self.p_j, self.p_l], u_k),
            angle: self.angle(side, u_k, u_l),
        }
    }

    /// The same cell with coordinates that keep their digits where cells are thin.
    pub(super) fn sharpened(&self, cell: &EdgeCell, u_k: &Point3, u_l: &Point3) -> EdgeCell {
        EdgeCell {
            mu: tetrahedron::barycentric(&[self.p_k, self.p_i, self.p_j, *u_k], u_l),
            nu: tetrahedron::barycentric(&[*u_l, self.p_i, self.p_j, self.p_l], u_k),
            angle: cell.angle,
        }
    }

    /// Angle between the planes through the edge and the two apexes, measured over the normals of the faces.
    fn angle(&self, side: Side, u_k: &Point3, u_l: &Point3) -> f64 {
        let edge = (self.p_j - self.p_i).normalize();
        let left = edge.cross(&(self.p_k - self.p_i)).try_normalize(0.0);
        let right = (self.p_l - self.p_i).cross(&edge).try_normalize(0.0);
        let sum = left.unwrap_or_else(Vec3::zeros) + right.unwrap_or_else(Vec3::zeros);
        let (up, towards_k) = (side.sign() * sum, sum.cross(&edge));
        // Both have the length of the sum, which cancels in the arc tangent.
        let lean = |v: Vec3| v.dot(&towards_k).atan2(v.dot(&up));
        lean(u_k - self.p_i) - lean(u_l - self.p_i)
    }
}

impl EdgeCell {
    /// μ_4 and ν_1: what the free parameters of the left and the right face do at the opposite one.
    pub fn reach(&self) -> [f64; 2] {
        [self.mu[3], self.nu[0]]
    }

    /// What is wrong with it, if its apexes may reach down to `least` (an open bound), and the worst thing first.
    pub fn fault(&self, least: f64) -> Option<Reason> {
        if self.angle <= 0.0 {
            return Some(Reason::ApexOverlap);
        }
        if self.angle >= PI || !self.reach().iter().all(|r| r.is_finite()) {
            return Some(Reason::FlatEdgeCell);
        }
        (!self.reach().iter().all(|r| *r > least)).then_some(Reason::SteepApex)
    }
}
