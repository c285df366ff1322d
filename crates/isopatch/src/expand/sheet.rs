//! The surface that is expanded: its points, normals and series, and where the box cuts it.

use super::p_expression::PExpression;
use crate::field::{Exponents, Field};
use crate::geom::{Aabb, Point3, Vec3};

/// A surface f = 0 in a box.
pub(super) struct Sheet<'a> {
    pub field: &'a dyn Field,
    /// The terms of f.
    pub terms: &'a [(Exponents, f64)],
    pub bounds: Aabb,
}

/// Newton steps to a point of the surface.
const NEWTON_STEPS: usize = 40;
/// A step this small, relative to the box, is the last one.
const CONVERGED: f64 = 1e-14;
/// A point is on a side of the box within this distance, relative to the diagonal.
const ON_SIDE: f64 = 1e-9;
/// Steps between the sides of the box that a point has to be put on.
const SIDES: usize = 3;

impl Sheet<'_> {
    /// Newton's method along the gradient; none where it does not arrive.
    pub fn foot(&self, p: Point3) -> Option<Point3> {
        self.foot_within(p, [false; 3])
    }

    /// The same, with some coordinates held.
    fn foot_within(&self, mut p: Point3, held: [bool; 3]) -> Option<Point3> {
        let size = self.bounds.diagonal();
        for _ in 0..NEWTON_STEPS {
            let (f, mut g) = self.field.gradient(p);
            (0..3).filter(|axis| held[*axis]).for_each(|axis| g[axis] = 0.0);
            let step = g * (f / g.norm_squared());
            if f == 0.0 {
                return Some(p);
            }
            if !step.iter().all(|c| c.is_finite()) || step.norm() > size {
                return None;
            }
            p -= step;
            if step.norm() <= CONVERGED * size {
                return Some(p);
            }
        }
        None
    }

    /// The unit normal; none where the gradient is too small to have a direction.
    pub fn normal(&self, p: Point3) -> Option<Vec3> {
        self.field.gradient(p).1.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()))
    }

    /// The power series at a point.
    pub fn series(&self, p: Point3, degree: usize) -> Option<PExpression> {
        PExpression::new(self.terms, &self.field.gradient(p).1, p, degree)
    }

    /// The sides of the box on which a point is, one bit each: below and above in x, then y, then z.
    pub fn sides(&self, p: &Point3) -> u8 {
        let reach = ON_SIDE * self.bounds.diagonal();
        (0..3).fold(0, |bits, axis| {
            let below = u8::from((p[axis] - self.bounds.min[axis]).abs() <= reach);
            let above = u8::from((p[axis] - self.bounds.max[axis]).abs() <= reach);
            bits | below << (2 * axis) | above << (2 * axis + 1)
        })
    }

    /// Is a point outside of the box?
    pub fn is_outside(&self, p: &Point3) -> bool {
        let reach = ON_SIDE * self.bounds.diagonal();
        (0..3).any(|axis| p[axis] < self.bounds.min[axis] - reach || p[axis] > self.bounds.max[axis] + reach)
    }

    /// Where the surface goes through the edges of the box.
    pub fn on_box_edges(&self) -> Vec<Point3> {
        let (min, max) = (self.bounds.min, self.bounds.max);
        let mut found = Vec::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for corner in 0..4 {
                let at = |t: f64| {
                    let mut p = Point3::zeros();
                    p[axis] = min[axis] + (max[axis] - min[axis]) * t;
                    p[u] = if corner & 1 == 0 { min[u] } else { max[u] };
                    p[v] = if corner & 2 == 0 { min[v] } else { max[v] };
                    p
                };
                found.extend(sign_changes(|t| self.field.value(at(t)), EDGE_SAMPLES).into_iter().map(at));
            }
        }
        found
    }

    /// Where the surface, gone along from a point inside to one outside, meets the border of the box; from close to the
    /// inside of the border too, for `margin` > 0.
    ///
    /// None where the way does not lead to the border.
    pub fn clip(&self, inside: &Point3, p: &Point3, margin: f64) -> Option<Point3> {
        let (min, max) = (self.bounds.min, self.bounds.max);
        let d = p - inside;
        let exits = (0..3).filter_map(|axis| {
            let side = if d[axis] > 0.0 { max[axis] } else { min[axis] };
            let beyond = if d[axis] > 0.0 { p[axis] - side } else { side - p[axis] };
            (d[axis] != 0.0 && beyond > -margin)
                .then(|| (((side - inside[axis]) / d[axis]).max(0.0), axis, side))
        });
        let (t, axis, side) = exits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut q = inside + d * t;
        let (mut held, mut at) = ([false; 3], q);
        (held[axis], at[axis]) = (true, side);
        for _ in 0..SIDES {
            (0..3).filter(|axis| held[*axis]).for_each(|axis| q[axis] = at[axis]);
            q = self.foot_within(q, held)?;
            let Some(axis) =
                (0..3).find(|axis| !held[*axis] && (q[*axis] < min[*axis] || q[*axis] > max[*axis]))
            else {
                return Some(q);
            };
            (held[axis], at[axis]) = (true, q[axis].clamp(min[axis], max[axis]));
        }
        None
    }
}

/// Samples along an edge of the box.
const EDGE_SAMPLES: usize = 64;
/// Steps of bisection.
const BISECTIONS: usize = 60;

/// Parameters in [0, 1] at which a function changes its sign between samples, by bisection.
pub(super) fn sign_changes(f: impl Fn(f64) -> f64, samples: usize) -> Vec<f64> {
    let at = |n: usize| n as f64 / samples as f64;
    let brackets = (0..samples).filter(|n| f(at(*n)) * f(at(n + 1)) < 0.0 || (f(at(*n)) == 0.0));
    brackets
        .map(|n| {
            let (mut a, mut b) = (at(n), at(n + 1));
            let sign = f(a);
            if sign == 0.0 {
                return a;
            }
            for _ in 0..BISECTIONS {
                let middle = (a + b) / 2.0;
                if f(middle) * sign > 0.0 { a = middle } else { b = middle }
            }
            a
        })
        .collect()
}
