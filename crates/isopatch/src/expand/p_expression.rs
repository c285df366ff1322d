//! The surface near one of its points as a graph over the tangent plane there (Bajaj & Xu 1997, §4.1).

use super::polynomials::{Bivariate, Trivariate, on_circle};
use crate::field::Exponents;
use crate::geom::{Mat3, Point3, Vec3};

/// The power series Z = φ(X, Y) of a surface at one of its points, up to some degree.
#[derive(Clone, Debug)]
pub struct PExpression {
    origin: Point3,
    /// Rows: the axes X, Y of the P-plane, and Z along the gradient.
    frame: Mat3,
    degree: usize,
    /// f in the coordinates X, Y, Z.
    local: Trivariate,
    /// φ_k.
    graph: Bivariate,
    /// f(X, Y, φ_k(X, Y)), all of it.
    residual: Bivariate,
}

/// The rows of the paper's transform T: an orthonormal frame whose third axis is the gradient. Where f_x = f_y = 0, its
/// formulas are 0/0, and X is kept.
pub fn p_frame(gradient: &Vec3) -> Option<Mat3> {
    let (length, across) = (gradient.norm(), gradient.x.hypot(gradient.y));
    if !(length.is_finite() && length > 0.0) {
        return None;
    }
    if across <= f64::EPSILON * length {
        let s = gradient.z.signum();
        return Some(Mat3::new(1.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s));
    }
    let (c1, s1) = (gradient.z / length, across / length);
    let (c2, s2) = (-gradient.y / across, gradient.x / across);
    Some(Mat3::new(c2, s2, 0.0, -c1 * s2, c1 * c2, s1, s1 * s2, -s1 * c2, c1))
}

/// Steps of bisection for a radius: to some thousandth of it.
const RADIUS_STEPS: usize = 12;

impl PExpression {
    /// The series of degree `k` ≥ 1 of the surface of a polynomial at a point of it; none where the gradient vanishes.
    ///
    /// Each step of the fixed point Z = Z − f(X, Y, Z)/f_Z(0) settles one more degree. O(k d⁴) for degree d.
    pub fn new(terms: &[(Exponents, f64)], gradient: &Vec3, p: Point3, k: usize) -> Option<Self> {
        let frame = p_frame(gradient)?;
        let form = |axis: usize| [p[axis], frame[(0, axis)], frame[(1, axis)], frame[(2, axis)]];
        let local = Trivariate::substituted(terms, &[form(0), form(1), form(2)]);
        let slope = local.coefficient([0, 0, 1]);
        if !(slope.is_finite() && slope > 0.0) {
            return None;
        }
        let mut graph = Bivariate::zero(k);
        for _ in 1..k {
            // The terms of degree 0 and 1 are rounding: f(p) and the gradient in the P-plane.
            let there = local.on_graph(&graph, k);
            there.terms().filter(|([i, j], _)| i + j > 1).for_each(|(ij, c)| graph.add(ij, -c / slope));
        }
        let all = local.terms().map(|([i, j, l], _)| i + j + l * k).max().unwrap_or(0);
        let residual = local.on_graph(&graph, all);
        Some(Self { origin: p, frame, degree: k, local, graph, residual })
    }

    /// The degree k.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Rows: the axes of the P-plane, then the unit normal.
    pub fn frame(&self) -> &Mat3 {
        &self.frame
    }

    /// Coordinates in the frame: P(p), then the height over the P-plane.
    pub fn project(&self, p: &Point3) -> Vec3 {
        self.frame * (p - self.origin)
    }

    /// φ_k(X, Y).
    pub fn height(&self, q: [f64; 2]) -> f64 {
        self.graph.value(q)
    }

    /// The larger principal curvature of the surface at the point, in size.
    pub fn curvature(&self) -> f64 {
        let [xx, xy, yy] = [[2, 0], [1, 1], [0, 2]].map(|ij| self.graph.coefficient(ij));
        (xx + yy).abs() + (xx - yy).hypot(xy)
    }

    /// The point (q, φ_k(q)) in space, which is near the surface.
    pub fn lift(&self, q: [f64; 2]) -> Point3 {
        self.origin + self.frame.transpose() * Vec3::new(q[0], q[1], self.height(q))
    }

    /// Is the distance between φ_k and the surface below `epsilon` on the disc of radius r? True only if it is, but for
    /// rounding: with m a lower bound of f_Z over the disc, for |Z| up to that of φ_k and ε, |f(X, Y, φ_k)| < m ε encloses
    /// the only root.
    pub fn holds(&self, r: f64, epsilon: f64) -> bool {
        let height = self.graph.bound(r) + epsilon;
        let slope = self.local.coefficient([0, 0, 1]);
        let change: f64 = self
            .local
            .terms()
            .filter(|(ijl, _)| ijl[2] > 0 && *ijl != [0, 0, 1])
            .map(|([i, j, l], c)| {
                let z = l as f64 * height.powi(l as i32 - 1);
                c.abs() * on_circle(i, j) * r.powi((i + j) as i32) * z
            })
            .sum();
        let least = slope - change;
        least > 0.0 && self.residual.bound(r) < least * epsilon
    }

    /// A certified lower bound of the (p, k, ε)-radius, up to `most`. Zero if none is found.
    pub fn radius(&self, epsilon: f64, most: f64) -> f64 {
        if self.holds(most, epsilon) {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        // First down by halves, as good radii can be far smaller than the largest.
        for _ in 0..MOST_HALVINGS {
            let middle = high / 2.0;
            if self.holds(middle, epsilon) {
                low = middle;
                break;
            }
            high = middle;
        }
        if low == 0.0 {
            return 0.0;
        }
        for _ in 0..RADIUS_STEPS {
            let middle = (low + high) / 2.0;
            if self.holds(middle, epsilon) { low = middle } else { high = middle }
        }
        low
    }
}

/// Halvings until a radius counts as none: a millionth of the largest.
const MOST_HALVINGS: usize = 20;
