use super::base::Base;
use super::edge::{Flank, Rim};
use crate::hull::Layer1;

/// The function in the cell of a face on one side, without its free parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceSide {
    /// Layer 1: from the gradients and the mid-edge rule.
    pub layer1: Layer1,
    /// q with one index at a corner and one at the apex: layer 2 is b/3 + 2/3 Σ q_a x_a.
    pub q: [f64; 3],
}

/// The function in the cells of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceFunction {
    /// On the face itself, in the sign of the function.
    pub base: Base,
    /// On the outer and the inner side, where there is a cell.
    pub sides: [Option<FaceSide>; 2],
}

impl FaceSide {
    /// Layers 1, 2 and 3 over the point x of the base, with Σ x = 1, and the free parameter b.
    #[inline(always)]
    pub fn layers(&self, x: [f64; 3], b: f64) -> [f64; 3] {
        [self.layer1.value(x), layer2(self.q[0] * x[0] + self.q[1] * x[1] + self.q[2] * x[2], b), b]
    }

    /// Value and derivatives by the four barycentric coordinates, given those of the base for this side.
    pub fn value(&self, b: f64, (base, base_d): (f64, [f64; 3]), x: [f64; 4]) -> (f64, [f64; 4]) {
        let (y, w) = ([x[0], x[1], x[2]], x[3]);
        let sum: f64 = y.iter().sum();
        let quadratic = self.layer1.value(y);
        let linear = b / 3.0 * sum + 2.0 / 3.0 * (0..3).map(|a| self.q[a] * y[a]).sum::<f64>();
        let value = base + w * (3.0 * quadratic + w * (3.0 * linear + w * b));
        let mut d = [0.0; 4];
        for a in 0..3 {
            d[a] = base_d[a] + 3.0 * w * (self.layer1.derivative(y, a) + w * (b + 2.0 * self.q[a]) / 3.0);
        }
        d[3] = 3.0 * (quadratic + w * (2.0 * linear + w * b));
        (value, d)
    }

    /// What the cell gives to the cell of its edge k, as seen along that edge or against it.
    pub fn flank(&self, k: usize, reversed: bool, b: f64) -> Flank {
        let turn = |[start, end]: [usize; 2]| if reversed { [end, start] } else { [start, end] };
        let [i, j] = turn([k, (k + 1) % 3]);
        let corner = self.layer1.corner;
        let rim = Rim { layer1: [corner[i], self.layer1.edge[k], corner[j]], q: [self.q[i], self.q[j]], b };
        // Edge k + 2 joins the third corner to the start of edge k, edge k + 1 to its end.
        let third = turn([(k + 2) % 3, (k + 1) % 3]).map(|edge| self.layer1.edge[edge]);
        Flank { rim, third, third_q: self.q[(k + 2) % 3] }
    }
}

/// Layer 2 from the sum of q_a x_a.
#[inline(always)]
pub(super) fn layer2(q: f64, b: f64) -> f64 {
    b / 3.0 + 2.0 / 3.0 * q
}
