use crate::hull::{FaceFrame, alpha, mid_edge};

/// The function on a face: layer 0 of the cells on both of its sides.
///
/// A cubic in the barycentric coordinates x, zero at the corners, with the tangents of the gradients there, and the
/// mid-edge rule at each edge. One cubic can't do that at three edges: a rational term mixes three (4.10)–(4.12), or
/// the triangle is split at its centroid (Clough–Tocher). The rational form is not C1 across the face itself, so faces with
/// cells on both sides are split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Base {
    /// e\[a\]\[b\]: coefficient with two indices at corner a and one at corner b.
    pub e: [[f64; 3]; 3],
    /// Per edge k, the coefficient of the mid-edge rule with the third point at the opposite corner (g) or, for a split face,
    /// at the centroid (h).
    pub middle: [f64; 3],
    /// Clough–Tocher?
    pub split: bool,
}

/// What multiplies the nine data of a base in its value, and in its derivatives by the three barycentric coordinates.
pub type Terms = ([f64; 9], [[f64; 9]; 3]);

impl Base {
    /// Of a face; its edges whose `straight` is set have the function vanish on them.
    pub fn new(face: &FaceFrame, straight: [bool; 3], split: bool) -> Self {
        let mut e = face.e;
        for k in (0..3).filter(|k| straight[*k]) {
            let b = (k + 1) % 3;
            (e[k][b], e[b][k]) = (0.0, 0.0);
        }
        let at = |third: usize, k: usize| {
            let (a, b) = (k, (k + 1) % 3);
            let sides = [e[a][b], e[b][a]];
            let w = alpha(&face.p[third], &face.p[a], &face.p[b]);
            if split {
                let at_centroid = |a: usize| (e[a][(a + 1) % 3] + e[a][(a + 2) % 3]) / 3.0;
                // α is 2 and −1 at the ends of the edge, and affine: its mean is exact where the centroid of a tiny face is not.
                mid_edge((1.0 + w) / 3.0, sides, [at_centroid(a), at_centroid(b)])
            } else {
                mid_edge(w, sides, [e[a][third], e[b][third]])
            }
        };
        Self { e, middle: [0, 1, 2].map(|k| at((k + 2) % 3, k)), split }
    }

    /// f_1110 of step 5: the mean of the three values of the mid-edge rule for the opposite corners.
    pub fn center(face: &FaceFrame) -> f64 {
        let middle = Self::new(face, [false; 3], false).middle;
        middle.iter().sum::<f64>() / 3.0
    }

    /// The nine data: e of both directions of edge 0, of edge 1, of edge 2, then the three middles.
    pub fn data(&self) -> [f64; 9] {
        let e = |a: usize, b: usize| self.e[a][b];
        let m = self.middle;
        [e(0, 1), e(1, 0), e(1, 2), e(2, 1), e(2, 0), e(0, 2), m[0], m[1], m[2]]
    }

    /// Value and derivatives by the barycentric coordinates, of the homogeneous form of degree 3.
    pub fn value(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        if self.split { self.split_value(x) } else { self.rational_value(x) }
    }

    /// The function on edge k where x is the weight of its start and y that of its end.
    ///
    /// Written so that the same edge seen from its other end gives the same bits.
    #[inline(always)]
    pub fn on_edge(e: [f64; 2], x: f64, y: f64) -> f64 {
        3.0 * (x * y) * (e[0] * x + e[1] * y)
    }

    fn rational_value(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let (mut value, mut d) = (0.0, [0.0; 3]);
        let (mut mixed, mut mixed_d) = (0.0, [0.0; 3]);
        let (mut sum, mut sum_d) = (0.0, [0.0; 3]);
        for a in 0..3 {
            let b = (a + 1) % 3;
            let (e, g) = ([self.e[a][b], self.e[b][a]], self.middle[a]);
            value += Self::on_edge(e, x[a], x[b]);
            d[a] += 3.0 * x[b] * (2.0 * e[0] * x[a] + e[1] * x[b]);
            d[b] += 3.0 * x[a] * (e[0] * x[a] + 2.0 * e[1] * x[b]);
            let product = x[a] * x[b];
            sum += product;
            mixed += g * product;
            for (c, other) in [(a, b), (b, a)] {
                sum_d[c] += x[other];
                mixed_d[c] += g * x[other];
            }
        }
        // At a corner the term and its derivatives vanish.
        if sum != 0.0 {
            let product = x[0] * x[1] * x[2];
            let mean = mixed / sum;
            value += 6.0 * product * mean;
            for c in 0..3 {
                let others = x[(c + 1) % 3] * x[(c + 2) % 3];
                d[c] += 6.0 * (others * mean + product * (mixed_d[c] - mean * sum_d[c]) / sum);
            }
        }
        (value, d)
    }

    /// Coefficients at the centroid of the split: with two, one and no index at a corner (the edges' are `middle`).
    pub(super) fn split_net(&self) -> ([f64; 3], [f64; 3], f64) {
        let corner = [0, 1, 2].map(|a: usize| (self.e[a][(a + 1) % 3] + self.e[a][(a + 2) % 3]) / 3.0);
        let inner = [0, 1, 2].map(|a: usize| (corner[a] + self.middle[a] + self.middle[(a + 2) % 3]) / 3.0);
        (corner, inner, inner.iter().sum::<f64>() / 3.0)
    }

    fn split_value(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let (corner, inner, center) = self.split_net();
        // The part at edge k is where the opposite corner has the smallest coordinate.
        let third = (0..3).min_by(|a, b| x[*a].total_cmp(&x[*b])).unwrap_or(0);
        let (a, b) = ((third + 1) % 3, (third + 2) % 3);
        let (c, y, z) = (3.0 * x[third], x[a] - x[third], x[b] - x[third]);
        let (e, h) = ([self.e[a][b], self.e[b][a]], self.middle[a]);
        let quadratic = corner[a] * y * y + 2.0 * h * y * z + corner[b] * z * z;
        let linear = inner[a] * y + inner[b] * z;
        let value = Self::on_edge(e, y, z) + 3.0 * c * quadratic + 3.0 * c * c * linear + c * c * c * center;
        let dc = 3.0 * quadratic + 6.0 * c * linear + 3.0 * c * c * center;
        let dy = 3.0 * z * (2.0 * e[0] * y + e[1] * z)
            + 6.0 * c * (corner[a] * y + h * z)
            + 3.0 * c * c * inner[a];
        let dz = 3.0 * y * (e[0] * y + 2.0 * e[1] * z)
            + 6.0 * c * (h * y + corner[b] * z)
            + 3.0 * c * c * inner[b];
        let mut d = [0.0; 3];
        (d[a], d[b], d[third]) = (dy, dz, 3.0 * dc - dy - dz);
        (value, d)
    }

    /// The factors of the nine [`Base::data`] in the value at x: it is linear in them.
    pub fn terms(x: [f64; 3], split: bool) -> Terms {
        let (mut value, mut d) = ([0.0; 9], [[0.0; 9]; 3]);
        for n in 0..9 {
            let mut unit = Self { e: [[0.0; 3]; 3], middle: [0.0; 3], split };
            match n {
                0 | 2 | 4 => unit.e[n / 2][(n / 2 + 1) % 3] = 1.0,
                1 | 3 | 5 => unit.e[(n / 2 + 1) % 3][n / 2] = 1.0,
                _ => unit.middle[n - 6] = 1.0,
            }
            let (v, partials) = unit.value(x);
            value[n] = v;
            (0..3).for_each(|c| d[c][n] = partials[c]);
        }
        (value, d)
    }
}
