//! What a curve interpolates at its ends, and the conditions on its unknowns.

use super::quartic::{CurveError, CurveOptions, QuarticCurve};
use crate::base::{BaseMesh, BoxSide};
use crate::geom::{Point3, Vec3, angle_between};
use crate::mesh::{EdgeId, VertexId};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Newton steps that restore (9b); quadratic convergence needs two or three.
const RESTORATION_STEPS: usize = 6;
/// Longest step of an iteration, in chords.
pub(super) const TRUST: f64 = 0.1;

/// What a curve interpolates. Positions are relative to `q0`.
pub(super) struct Ends {
    pub q0: Point3,
    q4: Point3,
    /// Does it run against the edge? Curves start at the end with the smaller coordinates, so that they depend on nothing
    /// but the data at their ends.
    reversed: bool,
    /// q4 − q0.
    pub chord: Vec3,
    /// Of the chord.
    pub length: f64,
    /// Unit normals.
    pub n: [Vec3; 2],
    /// Unit tangents along the chord, both pointing forward.
    pub t: [Vec3; 2],
    /// Across them, N × t.
    pub s: [Vec3; 2],
    /// Largest tangent of the angle by which the curve may leave t.
    pub turn: [f64; 2],
    /// Curvature tensor in the basis t, s: kₜₜ, kₜₛ, kₛₛ.
    pub k: [[f64; 3]; 2],
    /// The coordinate that is constant on the side of the box that the curve lies in.
    pub across: Option<usize>,
}

/// The unknowns of a curve: q2 is relative to q0.
#[derive(Clone, Copy)]
pub(super) struct Fit {
    pub lambda: f64,
    pub mu: f64,
    pub q2: Vec3,
    /// q1 − q0 and q3 − q4 along s.
    pub aside: [f64; 2],
    /// Levenberg–Marquardt steps on the way, or iterations of Algorithm 5.1.
    pub steps: usize,
    /// Algorithm 5.1 was asked for and found nothing.
    pub sqp_failed: bool,
}

/// λ, μ, q2, and the two components aside.
pub(super) const UNKNOWNS: usize = 7;

impl Fit {
    pub fn as_vector(&self) -> SVector<f64, UNKNOWNS> {
        SVector::from([self.lambda, self.mu, self.q2.x, self.q2.y, self.q2.z, self.aside[0], self.aside[1]])
    }

    pub fn moved(&self, step: &SVector<f64, UNKNOWNS>) -> Self {
        Self {
            lambda: self.lambda + step[0],
            mu: self.mu + step[1],
            q2: self.q2 + Vec3::new(step[2], step[3], step[4]),
            aside: [self.aside[0] + step[5], self.aside[1] + step[6]],
            ..*self
        }
    }

    pub fn along(&self) -> [f64; 2] {
        [self.lambda, self.mu]
    }
}

impl Ends {
    pub fn of(base: &BaseMesh, edge: EdgeId, options: &CurveOptions) -> Result<Self, CurveError> {
        let h = base.mesh.edge_half_edge(edge);
        let (mut from, mut to) = (base.mesh.origin(h), base.mesh.dest(h));
        let at = |v: VertexId| base.positions[v.index()];
        let reversed = at(to).iter().partial_cmp(at(from).iter()).is_some_and(|order| order.is_lt());
        if reversed {
            (from, to) = (to, from);
        }
        let (q0, q4) = (at(from), at(to));
        let chord = q4 - q0;
        let n = [from, to].map(|v| base.normals[v.index()]);
        let m = [from, to].map(|v| base.curvatures[v.index()]);
        let length = chord.norm();
        let no_tangent = CurveError::NoTangent { edge: edge.0, from: from.0, to: to.0 };
        let unit = |v: Vec3| v.try_normalize(f64::EPSILON * length).ok_or(no_tangent);
        let t = [unit(base.direction(edge, from))?, -unit(base.direction(edge, to))?];
        let s: [Vec3; 2] = std::array::from_fn(|i| n[i].cross(&t[i]));
        let k = std::array::from_fn(|i| {
            let (mt, ms) = (m[i] * t[i], m[i] * s[i]);
            [t[i].dot(&mt), s[i].dot(&mt), s[i].dot(&ms)]
        });
        let turn = [options.largest_turn; 2];
        let free = Self { q0, q4, reversed, chord, length, n, t, s, turn, k, across: None };
        let sides = base.sides_of(edge);
        match (sides.iter().next(), sides.len()) {
            (None, _) => Ok(free),
            (Some(side), 1) => Ok(free.within(side)),
            _ => Err(CurveError::AlongBoxEdge { edge: edge.0, from: from.0, to: to.0 }),
        }
    }

    /// The data of the section by a side of the box. The tangents are not along its normal, so the parts are not zero.
    fn within(mut self, side: BoxSide) -> Self {
        for (n, k) in self.n.iter_mut().zip(&mut self.k) {
            n[side.axis] = 0.0;
            let length = n.norm();
            *n /= length;
            *k = k.map(|k| k / length);
        }
        Self { across: Some(side.axis), turn: [0.0; 2], ..self }
    }

    /// Points, relative to q0, of the quintic curve with the positions, tangents and normal curvatures of both ends: one for each
    /// row of the values of the six Bernstein polynomials.
    ///
    /// Its parameter runs as that of a circular arc through the ends does on average: the second derivatives are
    /// k ℓ² N, with ℓ the length of the arc that leaves the chord at the mean of the two angles.
    pub fn hermite_points<const N: usize>(&self, bases: &[[f64; 6]; N]) -> [Vec3; N] {
        let angle = 0.5 * (angle_between(&self.t[0], &self.chord) + angle_between(&self.t[1], &self.chord));
        let arc = self.length * if angle > 0.0 { angle / angle.sin() } else { 1.0 };
        let speed = self.t.map(|t| arc * t);
        let bend: [Vec3; 2] = std::array::from_fn(|i| arc * arc * self.k[i][0] * self.n[i]);
        let before = [Vec3::zeros(), speed[0] / 5.0, 2.0 / 5.0 * speed[0] + bend[0] / 20.0];
        let after =
            [self.chord - 2.0 / 5.0 * speed[1] + bend[1] / 20.0, self.chord - speed[1] / 5.0, self.chord];
        bases.map(|b| (0..3).map(|i| b[i] * before[i] + b[i + 3] * after[i]).sum())
    }

    /// wᵀ M w of the first control vector w at an end, λ² k for a tangent along the chord.
    fn bending(&self, end: usize, fit: &Fit) -> f64 {
        let (a, b, [tt, ts, ss]) = (fit.along()[end], fit.aside[end], self.k[end]);
        a * a * tt + 2.0 * a * b * ts + b * b * ss
    }

    /// Residuals of (9b), divided by 3.
    pub fn constraints(&self, fit: &Fit) -> Vector2<f64> {
        Vector2::new(
            fit.q2.dot(&self.n[0]) - 4.0 / 3.0 * self.bending(0, fit),
            (fit.q2 - self.chord).dot(&self.n[1]) - 4.0 / 3.0 * self.bending(1, fit),
        )
    }

    /// Their derivatives by the unknowns.
    pub fn constraint_gradients(&self, fit: &Fit) -> SMatrix<f64, 2, UNKNOWNS> {
        let mut gradients = SMatrix::<f64, 2, UNKNOWNS>::zeros();
        for i in 0..2 {
            let (a, b, [tt, ts, ss]) = (fit.along()[i], fit.aside[i], self.k[i]);
            gradients[(i, i)] = -8.0 / 3.0 * (a * tt + b * ts);
            (0..3).for_each(|c| gradients[(i, 2 + c)] = self.n[i][c]);
            gradients[(i, 5 + i)] = -8.0 / 3.0 * (a * ts + b * ss);
        }
        gradients
    }

    /// Least-norm Newton steps onto (9b) with λ, μ and q2.
    pub fn restore(&self, mut fit: Fit) -> Fit {
        for _ in 0..RESTORATION_STEPS {
            let mut gradients = self.constraint_gradients(&fit);
            gradients.fixed_view_mut::<2, 2>(0, 5).fill(0.0);
            let gram = gradients * gradients.transpose() + Matrix2::identity() * f64::EPSILON;
            let Some(inverse) = gram.try_inverse() else { break };
            fit = fit.moved(&-(gradients.transpose() * (inverse * self.constraints(&fit))));
        }
        fit
    }

    /// Control points relative to q0.
    pub fn control_points(&self, fit: &Fit) -> [Vec3; 5] {
        let arm = |i: usize| fit.along()[i] * self.t[i] + fit.aside[i] * self.s[i];
        [Vec3::zeros(), arm(0), fit.q2, self.chord + arm(1), self.chord]
    }

    /// Tangents shortened, lengthened and turned back to their limits.
    pub fn within_limits(&self, fit: Fit, options: &CurveOptions) -> Fit {
        let clamp =
            |x: f64| x.clamp(options.shortest_tangent * self.length, options.longest_tangent * self.length);
        let (lambda, mu) = (clamp(fit.lambda), -clamp(-fit.mu));
        let turn = |i: usize, along: f64| {
            let most = self.turn[i] * along.abs();
            fit.aside[i].clamp(-most, most)
        };
        Fit { lambda, mu, aside: [turn(0, lambda), turn(1, mu)], ..fit }
    }

    pub fn in_box(&self, fit: &Fit, options: &CurveOptions) -> bool {
        let inside =
            |x: f64| x > options.shortest_tangent * self.length && x < options.longest_tangent * self.length;
        inside(fit.lambda) && inside(-fit.mu)
    }

    pub fn finish(
        &self,
        base: &BaseMesh,
        edge: EdgeId,
        fit: &Fit,
        options: &CurveOptions,
    ) -> Result<QuarticCurve, CurveError> {
        let violation = self.constraints(fit).amax();
        let solved =
            violation <= options.constraint_tolerance * self.length && fit.lambda > 0.0 && fit.mu < 0.0;
        if !solved {
            let h = base.mesh.edge_half_edge(edge);
            let (from, to) = (base.mesh.origin(h).0, base.mesh.dest(h).0);
            return Err(CurveError::Infeasible { edge: edge.0, from, to });
        }
        let [_, q1, q2, q3, _] = self.control_points(fit).map(|q| self.q0 + q);
        let mut q = [self.q0, q1, q2, q3, self.q4];
        if self.reversed {
            q.reverse();
        }
        Ok(QuarticCurve {
            q,
            steps: fit.steps,
            sqp_failed: fit.sqp_failed,
            at_bound: !self.in_box(fit, options),
        })
    }
}
