use crate::bernstein::index;
use crate::bernstein::triangle::Tangents;
use crate::geom::{Point3, Vec3};

/// A patch over a triangle: with barycentric coordinates l₀, l₁, l₂,
///
/// P = P₃ + l₀l₁l₂ (Σ_k l_a l_b U_k(t_k) + 243 l₀l₁l₂ · M) / (l₀l₁ + l₁l₂ + l₂l₀),
///
/// where edge k runs from corner a = k to b = k + 1, o is the third corner, and t_k = l_b + l_o/2 is the parameter of the edge
/// carried on into the patch. This is (6.2) of Bajaj & Xu with U_k for P_u, P_v, P_w, there constants.
///
/// Along edge k the correction leaves the point as it is and adds t(1 − t) U_k(t) to the derivative ∂/∂l_o − ∂/∂l_b. That
/// product is kept, not U_k: it is a cubic polynomial, and U_k has a pole where it does not vanish at an end. There the patch is
/// continuous, like the tip of a cone, and has no normal.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalPatch {
    /// The net of P₃, in the order of [`crate::bernstein`]: its border is the wires.
    pub net: [Point3; CUBIC_NET],
    /// Bernstein coefficients of t(1 − t) U_k(t) for each edge.
    pub across: [[Vec3; 4]; 3],
    /// M, by which the centroid is moved. It changes no point and no tangent plane on the border.
    pub middle: Vec3,
}

/// Control points of a cubic triangle.
pub const CUBIC_NET: usize = index::count(3);
/// Makes the term of M equal to M at the centroid, where the product of the coordinates is 1/27 and the denominator 1/3.
pub(super) const MIDDLE_SCALE: f64 = 243.0;

/// Net positions of the cubic: corners, then the two inner points of each edge in its direction, then the middle.
pub(super) const CORNERS: [usize; 3] = [0, 6, 9];
pub(super) const EDGES: [[usize; 2]; 3] = [[1, 3], [7, 8], [5, 2]];
pub(super) const CENTER: usize = 4;

impl RationalPatch {
    /// P₃ over three wires, each along its edge, without a correction.
    ///
    /// The middle point is a quarter of the sum of the six points on the edges less a sixth of that of the corners: then P₃ is
    /// quadratic if the wires are. The correction along three edges takes its effect back, so that it does not matter.
    pub fn over_wires(wires: &[[Point3; 4]; 3]) -> Self {
        let mut net = [Point3::zeros(); CUBIC_NET];
        for (k, wire) in wires.iter().enumerate() {
            net[CORNERS[k]] = wire[0];
            [net[EDGES[k][0]], net[EDGES[k][1]]] = [wire[1], wire[2]];
        }
        let inner: Point3 = EDGES.iter().flatten().map(|p| net[*p]).sum();
        let corners: Point3 = CORNERS.iter().map(|p| net[*p]).sum();
        net[CENTER] = inner / 4.0 - corners / 6.0;
        Self { net, across: [[Vec3::zeros(); 4]; 3], middle: Vec3::zeros() }
    }

    /// Bézier points of the wire of edge k.
    pub fn wire(&self, k: usize) -> [Point3; 4] {
        let [first, second] = EDGES[k];
        [self.net[CORNERS[k]], self.net[first], self.net[second], self.net[CORNERS[(k + 1) % 3]]]
    }

    /// Is the patch without a tangent plane at a corner?
    pub fn is_singular(&self, corner: usize) -> bool {
        let zero = Vec3::zeros();
        self.across[corner][0] != zero || self.across[(corner + 2) % 3][3] != zero
    }

    /// Point and derivatives at (u, v). At a singular corner the derivatives are those of P₃.
    ///
    /// Sums are formed so that a point of an edge has the same bits from both of its patches.
    pub fn evaluate(&self, [u, v]: [f64; 2]) -> Tangents {
        let l = [u, v, 1.0 - u - v];
        let (mut point, mut partials) = self.cubic(l);
        let denominator = l[0] * l[1] + l[1] * l[2] + l[2] * l[0];
        if denominator > 0.0 {
            // F = l₀l₁l₂ / denominator, ∂F/∂l_i = (l_j l_k / denominator)².
            let product = l[0] * l[1] * l[2];
            let factor = product / denominator;
            let slope: [f64; 3] =
                std::array::from_fn(|i| (l[(i + 1) % 3] * l[(i + 2) % 3] / denominator).powi(2));
            let (mut sum, mut sums) = (MIDDLE_SCALE * product * self.middle, [Vec3::zeros(); 3]);
            for i in 0..3 {
                sums[i] = MIDDLE_SCALE * l[(i + 1) % 3] * l[(i + 2) % 3] * self.middle;
            }
            for k in 0..3 {
                let (value, [by_a, by_b, by_o]) = self.term(k, l);
                sum += value;
                sums[k] += by_a;
                sums[(k + 1) % 3] += by_b;
                sums[(k + 2) % 3] += by_o;
            }
            point += factor * sum;
            (0..3).for_each(|i| partials[i] += slope[i] * sum + factor * sums[i]);
        }
        Tangents { point, du: partials[0] - partials[2], dv: partials[1] - partials[2] }
    }

    /// P₃ and its derivatives by the three coordinates, up to a vector that all three have in common: it drops out of their differences, and
    /// points relative to a corner leave it no digits to take.
    fn cubic(&self, l: [f64; 3]) -> (Point3, [Vec3; 3]) {
        let corner = |k: usize| l[k] * l[k] * l[k] * self.net[CORNERS[k]];
        let corners = corner(0) + corner(1) + corner(2);
        let from_corner = |p: usize| self.net[p] - self.net[CORNERS[0]];
        let mut point = Point3::zeros();
        let mut partials: [Vec3; 3] = std::array::from_fn(|k| 3.0 * l[k] * l[k] * from_corner(CORNERS[k]));
        for k in 0..3 {
            let (x, y) = (l[k], l[(k + 1) % 3]);
            let [first, second] = EDGES[k].map(|p| self.net[p]);
            point += x * x * y * first + y * y * x * second;
            let [first, second] = EDGES[k].map(from_corner);
            partials[k] += 6.0 * x * y * first + 3.0 * y * y * second;
            partials[(k + 1) % 3] += 3.0 * x * x * first + 6.0 * x * y * second;
        }
        let middle = from_corner(CENTER);
        for k in 0..3 {
            partials[k] += 6.0 * l[(k + 1) % 3] * l[(k + 2) % 3] * middle;
        }
        (corners + 3.0 * point + 6.0 * l[0] * l[1] * l[2] * self.net[CENTER], partials)
    }

    /// l_a l_b U_k(t) and its derivatives by l_a, l_b, l_o.
    fn term(&self, k: usize, l: [f64; 3]) -> (Vec3, [Vec3; 3]) {
        let (a, b, o) = (l[k], l[(k + 1) % 3], l[(k + 2) % 3]);
        let (s, t) = (a + 0.5 * o, b + 0.5 * o);
        let [c0, c1, c2, c3] = &self.across[k];
        // U = 3 c₁ s + 3 c₂ t for s + t = 1.
        let u = 3.0 * (s * c1 + t * c2);
        let half = 1.5 * (c1 + c2);
        let mut value = a * b * u;
        let mut by = [b * u + 3.0 * a * b * c1, a * u + 3.0 * a * b * c2, a * b * half];
        // The poles, c₀ s²/t and c₃ t²/s; l_b/t and l_a/s are at most 1.
        if *c0 != Vec3::zeros() && t > 0.0 {
            let y = b / t;
            value += a * s * s * y * c0;
            by[0] += s * (s + 2.0 * a) * y * c0;
            by[1] += a * s * s * (0.5 * o / (t * t)) * c0;
            by[2] += a * s * (y - 0.5 * s * y / t) * c0;
        }
        if *c3 != Vec3::zeros() && s > 0.0 {
            let x = a / s;
            value += b * t * t * x * c3;
            by[1] += t * (t + 2.0 * b) * x * c3;
            by[0] += b * t * t * (0.5 * o / (s * s)) * c3;
            by[2] += b * t * (x - 0.5 * t * x / s) * c3;
        }
        (value, by)
    }

    /// Derivative of P₃ across edge k, (∂/∂l_o − ∂/∂l_b) P₃, as its three Bernstein coefficients along the edge.
    pub fn derivative_across(&self, k: usize) -> [Vec3; 3] {
        let row = |depth, m| self.net[index::row(3, k, depth, m)];
        std::array::from_fn(|m| 3.0 * (row(1, m) - row(0, m + 1)))
    }
}
