//! The function in a pyramid [a p_1 p_2 p_3 p_4] over a convex quadrilateral (4.2), Sub-algorithm 2.
//!
//! Corners are numbered here by (j, k), where their weights are s^j (1−s)^(1−j) t^k (1−t)^(1−k): the first corner of the
//! face is (1, 1), then counter-clockwise (0, 1), (0, 0), (1, 0).

use super::cells::Jet;
use super::data::PolygonFrame;
use super::tetra::barycentric;
use crate::geom::{Mat3, Point3, Vec3};
use crate::hull::Side;

/// (j, k) of the corners of the face.
const CORNERS: [[usize; 2]; 4] = [[1, 1], [0, 1], [0, 0], [1, 0]];

/// The four sides of the base in the order of the paper's l, r, t, b, as numbers of edges of the face: s = 1, s = 0, t = 0, t = 1.
const SIDES: [usize; 4] = [3, 1, 2, 0];

/// The coefficients 022, 012, 021, 011 inside the base, and which of `SIDES` each has a rational value from: an upright one,
/// then a level one.
const INNER: [([usize; 2], [usize; 2]); 4] =
    [([2, 2], [0, 3]), ([1, 2], [1, 3]), ([2, 1], [0, 2]), ([1, 1], [1, 2])];

/// The function in a pyramid, for the function times the sign of the side.
#[derive(Clone, Debug, PartialEq)]
pub struct PyramidCell {
    /// The side of the face.
    pub side: Side,
    /// The apex.
    pub apex: Point3,
    /// p_1 … p_4 of (2.6).
    pub corners: [Point3; 4],
    /// b_0jk of the base, where the inner ones are rational; those are zero here.
    pub base: [[f64; 4]; 4],
    /// The rational values of 022, 012, 021 and 011: from the side s = 0 or 1, and from the side t = 0 or 1.
    pub inner: [[f64; 2]; 4],
    /// b_1jk, the middle one zero.
    pub layer1: [[f64; 3]; 3],
    /// The rational values of 111: p_111 of l, r, t, b.
    pub middle: [f64; 4],
    /// b_2jk.
    pub layer2: [[f64; 2]; 2],
    /// b_300, the value at the apex.
    pub layer3: f64,
    /// The gradient at the apex, in the sign of the function.
    pub gradient: Vec3,
}

/// A function of (s, t) with its derivatives.
pub type Form = (f64, [f64; 2]);

fn mul(a: &Form, b: &Form) -> Form {
    (a.0 * b.0, [a.1[0] * b.0 + a.0 * b.1[0], a.1[1] * b.0 + a.0 * b.1[1]])
}

fn plus(a: &Form, factor: f64, b: &Form) -> Form {
    (a.0 + factor * b.0, [a.1[0] + factor * b.1[0], a.1[1] + factor * b.1[1]])
}

/// Bernstein polynomials of degree N with their slopes.
fn basis<const M: usize>(x: f64) -> [[f64; 2]; M] {
    let (y, n) = (1.0 - x, M - 1);
    let choose = |n: usize, i: usize| [1.0, n as f64, if n == 3 { 3.0 } else { 1.0 }, 1.0][i];
    let term = |n: usize, i: usize| choose(n, i) * x.powi(i as i32) * y.powi((n - i) as i32);
    std::array::from_fn(|i| {
        let below = if i > 0 { term(n - 1, i - 1) } else { 0.0 };
        let above = if i < n { term(n - 1, i) } else { 0.0 };
        [term(n, i), n as f64 * (below - above)]
    })
}

fn tensor<const M: usize>(net: &[[f64; M]; M], s: f64, t: f64) -> Form {
    let (along_s, along_t) = (basis::<M>(s), basis::<M>(t));
    let mut form = (0.0, [0.0; 2]);
    for (j, [bs, ds]) in along_s.iter().enumerate() {
        let value: f64 = (0..M).map(|k| net[j][k] * along_t[k][0]).sum();
        let slope: f64 = (0..M).map(|k| net[j][k] * along_t[k][1]).sum();
        form = (form.0 + bs * value, [form.1[0] + ds * value, form.1[1] + bs * slope]);
    }
    form
}

/// a²/(a² + b²), or a half where both vanish, by its derivatives by a and b.
fn share(a: f64, b: f64) -> (f64, [f64; 2]) {
    let sum = a * a + b * b;
    if sum == 0.0 {
        return (0.5, [0.0; 2]);
    }
    let of_product = 2.0 * a * b / (sum * sum);
    (a * a / sum, [of_product * b, -of_product * a])
}

/// The factors of the rational values of 022, 012, 021, 011 in the base: those of the upright and of the level side.
pub fn inner_weights(s: f64, t: f64) -> [[Form; 2]; 4] {
    let (along_s, along_t) = (basis::<4>(s), basis::<4>(t));
    INNER.map(|([j, k], _)| {
        // Distance from the corner across the upright side, and across the level one.
        let (from_s, sign_s) = if j == 2 { (1.0 - s, -1.0) } else { (s, 1.0) };
        let (from_t, sign_t) = if k == 2 { (1.0 - t, -1.0) } else { (t, 1.0) };
        let (upright, [by_t, by_s]) = share(from_t, from_s);
        let polynomial =
            (along_s[j][0] * along_t[k][0], [along_s[j][1] * along_t[k][0], along_s[j][0] * along_t[k][1]]);
        let upright = (upright, [sign_s * by_s, sign_t * by_t]);
        let level = (1.0 - upright.0, upright.1.map(|d| -d));
        [mul(&polynomial, &upright), mul(&polynomial, &level)]
    })
}

/// The factors of the rational values of 111 in layer 1.
pub fn middle_weights(s: f64, t: f64) -> [Form; 4] {
    let square = |x: f64, sign: f64| (x * x, 2.0 * sign * x);
    let [s2, r2, t2, q2] = [square(s, 1.0), square(1.0 - s, -1.0), square(t, 1.0), square(1.0 - t, -1.0)];
    let form = |u: [(f64, f64); 2], v: [(f64, f64); 2]| -> Form {
        let of = |[a, b]: [(f64, f64); 2]| (a.0 * b.0, a.1 * b.0 + a.0 * b.1);
        let (u, v) = (of(u), of(v));
        (u.0 * v.0, [u.1 * v.0, u.0 * v.1])
    };
    let one = (1.0, 0.0);
    let v = [
        form([s2, one], [t2, q2]),
        form([r2, one], [t2, q2]),
        form([s2, r2], [q2, one]),
        form([s2, r2], [t2, one]),
    ];
    let sum = v.iter().fold((0.0, [0.0; 2]), |sum, v| plus(&sum, 1.0, v));
    // At the corners all vanish, and so does what they are multiplied by.
    if sum.0 == 0.0 {
        return [(0.0, [0.0; 2]); 4];
    }
    let (along_s, along_t) = (basis::<3>(s), basis::<3>(t));
    let polynomial =
        (along_s[1][0] * along_t[1][0], [along_s[1][1] * along_t[1][0], along_s[1][0] * along_t[1][1]]);
    v.map(|v| {
        let weight = v.0 / sum.0;
        mul(&polynomial, &(weight, [0, 1].map(|i| (v.1[i] - weight * sum.1[i]) / sum.0)))
    })
}

impl PyramidCell {
    /// From the data of a face with four corners, the apex on a side, and F(a), ∇F(a).
    pub fn new(frame: &PolygonFrame, side: Side, apex: &Point3, jet: &Jet) -> Self {
        let sign = side.sign();
        let p: [Point3; 4] = std::array::from_fn(|c| frame.p[c]);
        let (mut base, mut layer1) = ([[0.0; 4]; 4], [[0.0; 3]; 3]);
        let (mut layer2, mut inner) = ([[0.0; 2]; 2], [[0.0; 2]; 4]);
        for (c, [j, k]) in CORNERS.into_iter().enumerate() {
            layer1[2 * j][2 * k] = sign * frame.at_corner(c, apex);
            layer2[j][k] = sign * jet.towards(apex, &p[c]);
        }
        for (c, [j, k]) in CORNERS.into_iter().enumerate() {
            let next = frame.after(c);
            let [nj, nk] = CORNERS[next];
            layer1[j + nj][k + nk] = sign * frame.on_edge(c, apex);
            let [first, second] = frame.along(c).map(|f| sign * f);
            base[2 * j + nj][2 * k + nk] = first;
            base[j + 2 * nj][k + 2 * nk] = second;
        }
        for (slot, ([j, k], sides)) in inner.iter_mut().zip(INNER) {
            // The corner that the coefficient is closest to.
            let near = CORNERS.iter().position(|c| *c == [j - 1, k - 1]).unwrap_or(0);
            *slot = sides.map(|n| sign * across_edge(frame, SIDES[n], near));
        }
        let mut cell = Self {
            side,
            apex: *apex,
            corners: [p[0], p[1], p[3], p[2]],
            base,
            inner,
            layer1,
            middle: [0.0; 4],
            layer2,
            layer3: sign * jet.value,
            gradient: jet.gradient,
        };
        cell.middle = SIDES.map(|edge| cell.middle_of(&p, edge));
        cell
    }

    /// F(a, p_c, p_d) of two corners of the face that are one or share an edge.
    pub fn once(&self, c: usize, d: usize) -> f64 {
        let ([j, k], [m, n]) = (CORNERS[c], CORNERS[d]);
        self.layer1[j + m][k + n]
    }

    /// F(a, a, p_c).
    pub fn twice(&self, c: usize) -> f64 {
        let [j, k] = CORNERS[c];
        self.layer2[j][k]
    }

    /// p_111 of the side of edge `start`: the mean of the coefficients of both diagonals of the base, as they are for C1 across the
    /// face over the edge (2.9). It does not depend on what is beyond that face.
    fn middle_of(&self, p: &[Point3; 4], start: usize) -> f64 {
        let [a, b, across_b, across_a] = [0, 1, 2, 3].map(|k| (start + k) % 4);
        // The corner opposite to a in [u, the corner opposite to b, b, a].
        let [to_u, to_across, to_b, to_a] = barycentric([self.apex, p[across_b], p[b], p[a]], &p[across_a]);
        let direct =
            self.once(a, across_a) - to_u * self.twice(a) - to_b * self.once(a, b) - to_a * self.once(a, a);
        let other = to_u * self.twice(b)
            + to_across * self.once(b, across_b)
            + to_b * self.once(b, b)
            + to_a * self.once(a, b);
        0.5 * (direct / to_across + other)
    }

    /// Layer 0 with its derivatives by s and t.
    pub fn layer0(&self, s: f64, t: f64) -> Form {
        let mut form = tensor(&self.base, s, t);
        for (values, weights) in self.inner.iter().zip(inner_weights(s, t)) {
            form = plus(&plus(&form, values[0], &weights[0]), values[1], &weights[1]);
        }
        form
    }

    /// Layer 1 with its derivatives by s and t.
    pub fn layer1(&self, s: f64, t: f64) -> Form {
        let terms = self.middle.iter().zip(middle_weights(s, t));
        terms.fold(tensor(&self.layer1, s, t), |form, (value, weight)| plus(&form, *value, &weight))
    }

    /// Layers over a point of the base.
    pub fn layers(&self, s: f64, t: f64) -> [f64; 4] {
        [self.layer0(s, t).0, self.layer1(s, t).0, tensor(&self.layer2, s, t).0, self.layer3]
    }

    /// The point of the base (s, t), with its derivatives.
    pub fn foot(&self, s: f64, t: f64) -> (Point3, [Vec3; 2]) {
        let [p1, p2, p3, p4] = &self.corners;
        let point = t * (s * p1 + (1.0 - s) * p2) + (1.0 - t) * (s * p3 + (1.0 - s) * p4);
        let by_s = t * (p1 - p2) + (1.0 - t) * (p3 - p4);
        let by_t = s * (p1 - p3) + (1.0 - s) * (p2 - p4);
        (point, [by_s, by_t])
    }

    /// Value and gradient at (u, s, t), for the function times the sign of the side.
    pub fn value(&self, [u, s, t]: [f64; 3]) -> (f64, Vec3) {
        let rest = 1.0 - u;
        // The pyramid has no other directions at its apex.
        if rest == 0.0 {
            return (self.layer3, self.side.sign() * self.gradient);
        }
        let (zero, one, two) = (self.layer0(s, t), self.layer1(s, t), tensor(&self.layer2, s, t));
        let layers = [zero.0, one.0, two.0, self.layer3];
        // By s and t with the factor 1 − u of the Jacobian taken out.
        let by = |i: usize| rest * rest * zero.1[i] + 3.0 * u * (rest * one.1[i] + u * two.1[i]);
        let slope = crate::bernstein::cubic::derivative(&layers, u);
        let (foot, [by_s, by_t]) = self.foot(s, t);
        let rows = Mat3::from_rows(&[(self.apex - foot), by_s, by_t].map(|v| v.transpose()));
        let inverse = rows.try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
        (crate::bernstein::cubic::value(&layers, u), inverse * Vec3::new(slope, by(0), by(1)))
    }
}

/// The coefficient of the base next to an edge, at the end of it that is `near`, for C1 across the face over the edge: step 3 for
/// quadrilaterals by (2.9).
fn across_edge(frame: &PolygonFrame, edge: usize, near: usize) -> f64 {
    let (a, b) = (edge, frame.after(edge));
    let [a1, a2] = frame.along(edge);
    // From both ends of the edge to their other neighbours.
    let [at_a, at_b] =
        [(frame.before(a), a), (frame.after(b), b)].map(|(other, end)| frame.p[other] - frame.p[end]);
    let g = &frame.middle[edge];
    if near == a {
        a1 + (frame.n[a].dot(&at_b) + 2.0 * g.dot(&at_a)) / 9.0
    } else {
        a2 + (2.0 * g.dot(&at_b) + frame.n[b].dot(&at_a)) / 9.0
    }
}
