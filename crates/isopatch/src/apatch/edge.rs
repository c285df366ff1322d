use super::base::Base;
use super::face::layer2;
use crate::hull::EdgeCell;

/// What the cell of a face shows over one of its edges: all that the cell of the edge must continue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// Layer 1 at the start, in the middle and at the end of the edge.
    pub layer1: [f64; 3],
    /// q of layer 2 at the start and the end.
    pub q: [f64; 2],
    /// The free parameter: value at the apex.
    pub b: f64,
}

/// The function in the cell of an edge on one side, without free parameters, that is not known from the faces already.
///
/// The names are those of the paper's §4: indices of (u_l, p_i, p_j, u_k). To b_1101 comes μ_4 b_k/3, to a_1101 ν_1 b_l/3, to
/// f_1002 (1 + 2 μ_4) b_k/3, to f_2001 (1 + 2 ν_1) b_l/3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeSide {
    /// μ_4 and ν_1.
    pub reach: [f64; 2],
    /// b_1101 and b_1011, for C1 with the left face k.
    pub b: [f64; 2],
    /// a_1101 and a_1011, for C1 with the right face l.
    pub a: [f64; 2],
    /// f_1002 and f_2001.
    pub far: [f64; 2],
}

/// What the cell on one side of an edge gives to the cell of the edge: its rim, and the coefficients that lead away from it,
/// to the third corner of the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flank {
    /// Over the edge; its free parameter may be left at zero.
    pub rim: Rim,
    /// Coefficients with one index at the start or the end of the edge, one at the third corner and one at the apex.
    pub third: [f64; 2],
    /// q of layer 2 at the third corner.
    pub third_q: f64,
}

/// The value of a linear function at a point with the given barycentric coordinates, by its values at the corners.
///
/// In a thin cell coordinates are large and cancel. They multiply differences of the values here, which are small where the
/// corners are close together.
fn affine(weights: [f64; 4], values: [f64; 4]) -> f64 {
    let o = (1..4).fold(0, |o, c| if weights[c].abs() > weights[o].abs() { c } else { o });
    values[o] + (0..4).map(|c| weights[c] * (values[c] - values[o])).sum::<f64>()
}

impl EdgeSide {
    /// From the cells of the left and the right face (4.15)–(4.17), free parameters left out.
    pub fn new(cell: &EdgeCell, left: &Flank, right: &Flank) -> Self {
        let [mu_k, mu_i, mu_j, mu_u] = cell.mu;
        let [nu_u, nu_i, nu_j, nu_l] = cell.nu;
        // f_1002 is affine in μ over the four points of the left cell, f_2001 in ν over those of the right cell.
        let across = |flank: &Flank, weights: [f64; 4]| {
            let Rim { layer1, q, .. } = flank.rim;
            let q = q.map(|q| layer2(q, 0.0));
            let mixed = [
                affine(weights, [flank.third[0], layer1[0], layer1[1], q[0]]),
                affine(weights, [flank.third[1], layer1[1], layer1[2], q[1]]),
            ];
            (mixed, affine(weights, [layer2(flank.third_q, 0.0), q[0], q[1], 0.0]))
        };
        let (b, f_1002) = across(left, [mu_k, mu_i, mu_j, mu_u]);
        let (a, f_2001) = across(right, [nu_l, nu_i, nu_j, nu_u]);
        Self { reach: cell.reach(), b, a, far: [f_1002, f_2001] }
    }

    /// Least free parameters of the left and the right face with which layers 2 and 3 are positive over the whole edge,
    /// whatever that of the other face; infinite where no parameter is known to do that.
    pub(super) fn sufficient(&self, left: &Rim, right: &Rim) -> [f64; 2] {
        let bound = |reach: f64, mixed: [f64; 2], far: f64, rim: &Rim| {
            let pull = 1.0 + 2.0 * reach;
            if pull <= 0.0 {
                return f64::INFINITY;
            }
            let middle = (0..2).map(|v| -3.0 * (layer2(rim.q[v], 0.0) + 2.0 * mixed[v]) / pull);
            middle.fold(-3.0 * far / pull, f64::max)
        };
        [bound(self.reach[0], self.b, self.far[0], left), bound(self.reach[1], self.a, self.far[1], right)]
    }

    /// With the free parameters that the rims bring.
    pub fn function(&self, e: [f64; 2], left: Rim, right: Rim) -> EdgeFunction {
        let [mu, nu] = self.reach;
        EdgeFunction {
            e,
            b: self.b.map(|f| f + mu * left.b / 3.0),
            a: self.a.map(|f| f + nu * right.b / 3.0),
            far: [
                self.far[0] + (1.0 + 2.0 * mu) * left.b / 3.0,
                self.far[1] + (1.0 + 2.0 * nu) * right.b / 3.0,
            ],
            left,
            right,
        }
    }
}

/// The function in the cell of an edge on one side, all coefficients, for the function times the sign of the side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeFunction {
    /// Coefficients on the edge, near its start and near its end.
    pub e: [f64; 2],
    /// What the left face shows.
    pub left: Rim,
    /// What the right face shows.
    pub right: Rim,
    /// b_1101 and b_1011.
    pub b: [f64; 2],
    /// a_1101 and a_1011.
    pub a: [f64; 2],
    /// f_1002 and f_2001.
    pub far: [f64; 2],
}

impl Rim {
    /// Layer 1 where x is the weight of the start and z that of the end.
    #[inline(always)]
    pub fn layer1(&self, x: f64, z: f64) -> f64 {
        (self.layer1[0] * (x * x) + self.layer1[2] * (z * z)) + 2.0 * (self.layer1[1] * (x * z))
    }

    /// Layer 2, for x + z = 1.
    #[inline(always)]
    pub fn layer2(&self, x: f64, z: f64) -> f64 {
        layer2(self.q[0] * x + self.q[1] * z, self.b)
    }
}

impl EdgeFunction {
    /// The layers along the ray from the point of the edge with weights x (start) and z (end), x + z = 1, to the point of the
    /// upper edge with weight y at the left apex.
    #[inline(always)]
    pub fn layers(&self, x: f64, z: f64, y: f64) -> [f64; 4] {
        let r = 1.0 - y;
        let (b, a) = (self.b[0] * x + self.b[1] * z, self.a[0] * x + self.a[1] * z);
        let quadratic = y * y * self.left.layer2(x, z) + r * r * self.right.layer2(x, z);
        let [f_1002, f_2001] = self.far;
        [
            Base::on_edge(self.e, x, z),
            y * self.left.layer1(x, z) + r * self.right.layer1(x, z),
            quadratic + 2.0 * (y * r) * (y * b + r * a),
            y * y * y * self.left.b + r * r * r * self.right.b + 3.0 * (y * r) * (y * f_1002 + r * f_2001),
        ]
    }

    /// Value and derivatives by the barycentric coordinates of (u_l, p_i, p_j, u_k).
    pub fn value(&self, [l, i, j, k]: [f64; 4]) -> (f64, [f64; 4]) {
        let [e_0, e_1] = self.e;
        let mut value = 3.0 * i * j * (e_0 * i + e_1 * j);
        let mut d = [0.0, 3.0 * j * (2.0 * e_0 * i + e_1 * j), 3.0 * i * (e_0 * i + 2.0 * e_1 * j), 0.0];
        for (rim, at, w) in [(&self.left, 3, k), (&self.right, 0, l)] {
            let [f_i, f_ij, f_j] = rim.layer1;
            let q = rim.q.map(|q| layer2(q, rim.b));
            let quadratic = f_i * i * i + 2.0 * f_ij * i * j + f_j * j * j;
            let linear = q[0] * i + q[1] * j;
            value += w * (3.0 * quadratic + w * (3.0 * linear + w * rim.b));
            d[1] += w * (6.0 * (f_i * i + f_ij * j) + 3.0 * w * q[0]);
            d[2] += w * (6.0 * (f_ij * i + f_j * j) + 3.0 * w * q[1]);
            d[at] += 3.0 * quadratic + w * (6.0 * linear + 3.0 * w * rim.b);
        }
        let [f_1002, f_2001] = self.far;
        value += 3.0 * k * l * (k * f_1002 + l * f_2001);
        d[3] += 3.0 * l * (2.0 * k * f_1002 + l * f_2001);
        d[0] += 3.0 * k * (k * f_1002 + 2.0 * l * f_2001);
        let sum = l + k;
        // At the edge the rational terms and their derivatives vanish.
        if sum != 0.0 {
            let (b, a) = (self.b[0] * i + self.b[1] * j, self.a[0] * i + self.a[1] * j);
            let mean = (a * l + b * k) / sum;
            value += 6.0 * l * k * mean;
            d[0] += 6.0 * k * (mean + l * (a - mean) / sum);
            d[3] += 6.0 * l * (mean + k * (b - mean) / sum);
            for v in 0..2 {
                d[1 + v] += 6.0 * l * k * (self.a[v] * l + self.b[v] * k) / sum;
            }
        }
        (value, d)
    }
}
