//! What the cell of an edge takes from the cells of the faces beside it (Sub-algorithm 4).

use super::tetra::barycentric;
use crate::apatch::{EdgeFunction, Rim};
use crate::geom::Point3;

/// What a cell over a face shows at one of its edges, for the function times the sign of the side: its coefficients over the
/// edge, and those that lead away from it. Any element has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flank {
    /// The apex a.
    pub apex: Point3,
    /// Start and end of the edge.
    pub ends: [Point3; 2],
    /// Over the edge.
    pub rim: Rim,
    /// What continues the coefficients at the start, and at the end.
    pub third: [Third; 2],
}

/// A point beyond an edge, with the coefficients that have an index there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Third {
    /// The point w.
    pub point: Point3,
    /// F(a, p, w) with the end p of the edge that this belongs to.
    pub mixed: f64,
    /// F(a, a, w).
    pub far: f64,
}

/// Coefficients with an index at a point on the other side of the edge cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extension {
    /// F(w, a, p) with the start and the end of the edge.
    pub mixed: [f64; 2],
    /// F(w, a, a).
    pub far: f64,
}

/// A [`Rim`] from coefficients over an edge: layer 1 at the start, in the middle and at the end, layer 2 at the start and the
/// end, and layer 3.
pub fn rim(layer1: [f64; 3], layer2: [f64; 2], layer3: f64) -> Rim {
    // Layer 2 is b/3 + 2/3 q.
    Rim { layer1, q: layer2.map(|f| 0.5 * (3.0 * f - layer3)), b: layer3 }
}

impl Flank {
    /// The same edge seen from its other end.
    pub fn reversed(self) -> Self {
        let ([i, j], [t_i, t_j], Rim { layer1: [f_i, f_ij, f_j], q: [q_i, q_j], b }) =
            (self.ends, self.third, self.rim);
        Self {
            ends: [j, i],
            third: [t_j, t_i],
            rim: Rim { layer1: [f_j, f_ij, f_i], q: [q_j, q_i], b },
            ..self
        }
    }

    /// The function of the cell, continued to a point w.
    pub fn extended(&self, w: &Point3) -> Extension {
        let ([p_i, p_j], rim) = (self.ends, &self.rim);
        let layer2 = [rim.layer2(1.0, 0.0), rim.layer2(0.0, 1.0)];
        let weights = self.third.map(|third| barycentric([self.apex, p_i, p_j, third.point], w));
        let mixed = [0, 1].map(|v| {
            let [a, i, j, t] = weights[v];
            a * layer2[v] + i * rim.layer1[v] + j * rim.layer1[v + 1] + t * self.third[v].mixed
        });
        let [a, i, j, t] = weights[0];
        Extension { mixed, far: a * rim.b + i * layer2[0] + j * layer2[1] + t * self.third[0].far }
    }

    /// The function in the cell of the edge that is C1 with both flanks: `self` is that of the left face, e are the coefficients
    /// on the edge.
    pub fn edge_function(&self, right: &Self, e: [f64; 2]) -> EdgeFunction {
        let (from_left, from_right) = (self.extended(&right.apex), right.extended(&self.apex));
        EdgeFunction {
            e,
            left: self.rim,
            right: right.rim,
            b: from_left.mixed,
            a: from_right.mixed,
            far: [from_left.far, from_right.far],
        }
    }
}
