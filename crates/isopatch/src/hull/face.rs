//! A face with its gradients: coefficients over it, and the heights of its apexes.

use super::class::{Class, Side, bend};
use crate::geom::{Point3, Vec3};

/// Corners and gradients of a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceFrame {
    /// Corners, counter-clockwise seen from outside.
    pub p: [Point3; 3],
    /// Gradients at the corners.
    pub n: [Vec3; 3],
    /// Centroid of the corners: the foot of the apexes.
    pub c: Point3,
    /// Unit normal of the face.
    pub normal: Vec3,
    /// Smallest distance from the centroid to an edge: the scale of margins.
    pub inner_radius: f64,
    /// e\[a\]\[b\] is the coefficient f with two indices at corner a and one at corner b: (p_b − p_a)·n_a / 3.
    pub e: [[f64; 3]; 3],
}

/// Coefficients of one layer off the base of a face cell, for the function times the sign of the side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer1 {
    /// f with two indices at corner a and one at the apex.
    pub corner: [f64; 3],
    /// f with one index at either end of edge k and one at the apex.
    pub edge: [f64; 3],
}

/// α(w, a, b) of (3.1): 2 − 3 s, where s is the parameter of the projection of w onto the line from a to b.
pub fn alpha(w: &Point3, a: &Point3, b: &Point3) -> f64 {
    let edge = b - a;
    2.0 - 3.0 * (w - a).dot(&edge) / edge.norm_squared()
}

/// The coefficient f_abw of a point w over the edge (a, b), from f_aab, f_bba and f_aaw, f_bbw: the one with which the
/// derivative across the edge, in the plane perpendicular to it at its midpoint, is the mean of those at its ends.
///
/// The mid-edge rule behind (3.1), (4.10)–(4.12) and the "number 3" coefficients, with f_1011 as it has to be (the printed
/// one names f_2100 for f_2010).
pub fn mid_edge(alpha: f64, [e_ab, e_ba]: [f64; 2], [f_aaw, f_bbw]: [f64; 2]) -> f64 {
    0.5 * (f_aaw + f_bbw + alpha * e_ab + (1.0 - alpha) * e_ba)
}

/// (b − a) · g, rounded once: computed in twice the precision. Two corners of a needle differ in it by less than the rounding
/// of the products.
fn slope(a: &Point3, b: &Point3, g: &Vec3) -> f64 {
    let (mut sum, mut rest) = (0.0, 0.0);
    for c in 0..3 {
        let difference = b[c] - a[c];
        // What the difference has lost, by Knuth's sum.
        let back = difference - b[c];
        let lost = (b[c] - (difference - back)) - (a[c] + back);
        let product = difference * g[c];
        let total: f64 = sum + product;
        let part = total - sum;
        rest += (sum - (total - part)) + (product - part) + difference.mul_add(g[c], -product) + lost * g[c];
        sum = total;
    }
    sum + rest
}

impl FaceFrame {
    /// From corners and gradients.
    pub fn new(p: [Point3; 3], n: [Vec3; 3]) -> Self {
        let edges: [Vec3; 3] = std::array::from_fn(|k| p[(k + 1) % 3] - p[k]);
        let area = edges[0].cross(&-edges[2]);
        let longest = edges.iter().map(Vec3::norm).fold(0.0, f64::max);
        // Relative to corner 0, so that a face far from the origin loses nothing.
        let c = p[0] + (edges[0] - edges[2]) / 3.0;
        let e = std::array::from_fn(|a| std::array::from_fn(|b| (p[b] - p[a]).dot(&n[a]) / 3.0));
        Self { p, n, c, normal: area.normalize(), inner_radius: area.norm() / (3.0 * longest), e }
    }

    /// With coefficients e that are rounded once, as a function needs them over needles. The search for a hull has no use for
    /// the digits.
    pub fn sharpened(self) -> Self {
        let (p, n) = (self.p, self.n);
        let e = std::array::from_fn(|a| std::array::from_fn(|b| slope(&p[a], &p[b], &n[a]) / 3.0));
        Self { e, ..self }
    }

    /// [e_ab, e_ba] of edge k.
    pub fn on_edge(&self, k: usize) -> [f64; 2] {
        let b = (k + 1) % 3;
        [self.e[k][b], self.e[b][k]]
    }

    /// How the surface bends over edge k, by the gradients of this face.
    pub fn edge_class(&self, k: usize) -> Class {
        let b = (k + 1) % 3;
        let at = |a: usize, b: usize| bend(&self.p[a], &self.p[b], &self.n[a]);
        Class::of_edge(at(k, b), at(b, k))
    }

    /// f_ab of the mid-edge rule for edge k and the point w.
    pub fn over_edge(&self, k: usize, w: &Point3, ends: [f64; 2]) -> f64 {
        mid_edge(alpha(w, &self.p[k], &self.p[(k + 1) % 3]), self.on_edge(k), ends)
    }

    /// Layer 1 of the cell with the given apex.
    pub fn layer1(&self, side: Side, apex: &Point3) -> Layer1 {
        self.layer1_from(side, apex, std::array::from_fn(|a| (apex - self.p[a]).dot(&self.n[a]) / 3.0))
    }

    /// The same for a function, see [`Self::sharpened`].
    pub fn sharp_layer1(&self, side: Side, apex: &Point3) -> Layer1 {
        self.layer1_from(side, apex, std::array::from_fn(|a| slope(&self.p[a], apex, &self.n[a]) / 3.0))
    }

    fn layer1_from(&self, side: Side, apex: &Point3, corner: [f64; 3]) -> Layer1 {
        let s = side.sign();
        let edge = std::array::from_fn(|k| self.over_edge(k, apex, [corner[k], corner[(k + 1) % 3]]));
        Layer1 { corner: corner.map(|f| s * f), edge: edge.map(|f| s * f) }
    }

    /// The centroid moved by `height` along `direction`, to the outer side, or against it to the inner one.
    pub fn apex(&self, side: Side, direction: &Vec3, height: f64) -> Point3 {
        self.c + side.sign() * height * direction
    }

    /// Heights at which an apex over the centroid reaches the tangent plane of each corner (t_l of the paper).
    pub fn tangent_heights(&self, side: Side, direction: &Vec3) -> [f64; 3] {
        std::array::from_fn(|a| {
            side.sign() * (self.p[a] - self.c).dot(&self.n[a]) / direction.dot(&self.n[a])
        })
    }

    /// Heights at which f_ab of each edge and the apex vanishes (t_lm of the paper): it is affine in the height.
    pub fn mid_edge_heights(&self, side: Side, direction: &Vec3) -> [f64; 3] {
        let [low, high] = self.layer1_ends(side, direction);
        std::array::from_fn(|k| -low.edge[k] / (high.edge[k] - low.edge[k]))
    }

    /// Layer 1 for an apex at the centroid and at height 1.
    fn layer1_ends(&self, side: Side, direction: &Vec3) -> [Layer1; 2] {
        [0.0, 1.0].map(|height| self.layer1(side, &self.apex(side, direction, height)))
    }

    /// The paper's height of an apex (§3.1): above all tangent planes by the margin, and where all f_ab are positive.
    pub fn paper_height(&self, side: Side, direction: &Vec3, margin: f64) -> f64 {
        let tangent = self.tangent_heights(side, direction).map(|t| t + margin);
        let middle = self.mid_edge_heights(side, direction);
        tangent.into_iter().chain(middle).fold(margin, f64::max)
    }

    /// The lowest height of an apex at which layer 1 is positive over the whole base, by the margin.
    ///
    /// That is: above all tangent planes; the matrix of layer 1 strictly copositive; and over each edge, above the mean of
    /// the tangent planes at its ends. None where the direction leads to no such apex.
    pub fn lowest_height(&self, side: Side, direction: &Vec3, margin: f64) -> Option<f64> {
        self.low_height(side, direction, margin, BISECTIONS)
    }

    /// The same, found by fewer bisections: up to twice as high for each that is left out, relative to the search interval.
    pub(super) fn low_height(
        &self,
        side: Side,
        direction: &Vec3,
        margin: f64,
        bisections: usize,
    ) -> Option<f64> {
        let [low, high] = self.layer1_ends(side, direction);
        let mut bottom = margin;
        for (start, end) in low.corner.iter().zip(high.corner) {
            let rise = end - start;
            if rise <= 0.0 {
                return None;
            }
            bottom = bottom.max(margin - start / rise);
        }
        for t in (0..3).filter_map(|k| self.height_over_edge(side, direction, k)) {
            bottom = bottom.max(t + margin);
        }
        let at = |t: f64| Layer1 {
            corner: std::array::from_fn(|a| low.corner[a] + t * (high.corner[a] - low.corner[a])),
            edge: std::array::from_fn(|k| low.edge[k] + t * (high.edge[k] - low.edge[k])),
        };
        if at(bottom).is_copositive() {
            return Some(bottom);
        }
        let mut top = bottom;
        for t in self.mid_edge_heights(side, direction) {
            top = top.max(t + margin);
        }
        for _ in 0..DOUBLINGS {
            if at(top).is_copositive() {
                break;
            }
            top = 2.0 * top + margin;
        }
        if !at(top).is_copositive() {
            return None;
        }
        for _ in 0..bisections {
            let middle = 0.5 * (bottom + top);
            if at(middle).is_copositive() {
                top = middle;
            } else {
                bottom = middle;
            }
        }
        Some(top)
    }

    /// Height at which the apex is on the mean of the tangent planes at the ends of edge k; none if it does not rise above
    /// that. This only helps the cell of the edge, which is checked by itself.
    fn height_over_edge(&self, side: Side, direction: &Vec3, k: usize) -> Option<f64> {
        let (a, b) = (self.p[k], self.p[(k + 1) % 3]);
        let mean = self.n[k].normalize() + self.n[(k + 1) % 3].normalize();
        let edge = (b - a).normalize();
        let across = |v: Vec3| v - v.dot(&edge) * edge;
        let rise = across(*direction).dot(&mean);
        (rise > 0.0).then(|| -side.sign() * across(self.c - a).dot(&mean) / rise)
    }
}

/// Bisections of the height of an apex: they leave 1e-12 of it.
const BISECTIONS: usize = 40;

/// Doublings of a height above which layer 1 ought to be copositive already.
const DOUBLINGS: usize = 8;

/// Off-diagonal entries are compared with this times what is allowed, so that layer 1 keeps a distance from zero.
const COPOSITIVE_SAFETY: f64 = 0.9;

impl Layer1 {
    /// Is the quadratic form with these coefficients positive on the whole triangle, with some distance?
    ///
    /// Hadeler's criterion for 3 × 3 matrices, with the diagonal shrunk to `COPOSITIVE_SAFETY`.
    pub fn is_copositive(&self) -> bool {
        if !self.corner.iter().all(|f| *f > 0.0) {
            return false;
        }
        let root = self.corner.map(|f| (COPOSITIVE_SAFETY * f).sqrt());
        let pair: [f64; 3] = std::array::from_fn(|k| self.edge[k] + root[k] * root[(k + 1) % 3]);
        if !pair.iter().all(|b| *b > 0.0) {
            return false;
        }
        let mixed: f64 = (0..3).map(|k| self.edge[k] * root[(k + 2) % 3]).sum();
        root.iter().product::<f64>() + mixed + (2.0 * pair.iter().product::<f64>()).sqrt() > 0.0
    }

    /// Value at barycentric coordinates, as a homogeneous form of degree 2.
    ///
    /// Written so that on an edge, seen from either end and from either face, it is the same sum of the same products.
    #[inline(always)]
    pub fn value(&self, x: [f64; 3]) -> f64 {
        let corner = |a: usize| self.corner[a] * (x[a] * x[a]);
        let edge = |k: usize| self.edge[k] * (x[k] * x[(k + 1) % 3]);
        (corner(0) + corner(1) + corner(2)) + 2.0 * (edge(0) + edge(1) + edge(2))
    }

    /// Derivative by the barycentric coordinate of corner a.
    pub fn derivative(&self, x: [f64; 3], a: usize) -> f64 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        2.0 * (self.corner[a] * x[a] + self.edge[a] * x[b] + self.edge[c] * x[c])
    }
}
