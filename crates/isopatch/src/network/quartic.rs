//! Quartic geometric Hermite curves: Tong & Kim 2009, section 5.
//!
//! ```text
//!   q1 = q0 + λ t0                       q3 = q4 + μ t1,  μ < 0 since t1 points forward    (7)
//!            q1 •---------• q2
//!              /           \            4 λ² k0 = 3 (q2 − q0)·N0                          (8), (9b)
//!          q0 •             • q3        4 μ² k1 = 3 (q2 − q4)·N1
//!                            \
//!                             • q4
//! ```
//!
//! A curve in a side of the box that cuts the surface lies in that plane: its tangents are those of the plane section, and
//! (9b) holds with the parts of N0, N1 within the plane, scaled to length 1, and the curvature k / |part of N| of the
//! section (Meusnier). As all other vectors are in the plane too, every coordinate across it is exactly that of the side.
//!
//! For given (λ, μ) the best q2 is a projection onto two planes, so the fit (9) is a problem of two unknowns in a
//! box, solved by Levenberg–Marquardt steps; three Gauss–Newton steps then trade the distance from projected
//! samples for the distance along the normal (PAPERS.md, deviations).

use crate::base::{BaseMesh, BoxSide};
use crate::bernstein::curve::basis;
use crate::geom::{Point3, Points, Vec3};
use crate::mesh::EdgeId;
use crate::surface::Target;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use rayon::prelude::*;
use std::sync::LazyLock;

/// How boundary curves are fitted. Lengths are in units of the edge's chord L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveOptions {
    /// Least λ and −μ. A curve that ends on a bound is flagged: the edge is too long for its curvature.
    pub shortest_tangent: f64,
    /// Largest λ and −μ.
    pub longest_tangent: f64,
    /// Levenberg–Marquardt steps at most.
    pub max_steps: usize,
    /// Levenberg–Marquardt stops when (λ, μ) moves by less.
    pub step_tolerance: f64,
    /// Gauss–Newton steps on the distance along the normal; 0 leaves the fit to projected samples.
    pub normal_distance_steps: usize,
    /// Weight of tangential motion in these steps.
    pub tangential_weight: f64,
    /// Largest violation of (9b) that counts as solved.
    pub constraint_tolerance: f64,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self {
            shortest_tangent: 0.08,
            longest_tangent: 0.6,
            max_steps: 40,
            step_tolerance: 1e-9,
            normal_distance_steps: 3,
            tangential_weight: 1e-3,
            constraint_tolerance: 1e-10,
        }
    }
}

/// A boundary curve with what its fit found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarticCurve {
    /// Control points, from the origin of the edge's half edge to its end.
    pub q: [Point3; 5],
    /// Levenberg–Marquardt steps.
    pub steps: usize,
    /// λ or −μ ended on a bound of [`CurveOptions`].
    pub at_bound: bool,
}

/// Why a boundary curve could not be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// The tangent at one end is undefined: the chord is zero or along the normal.
    #[error("edge {edge} between vertices {from} and {to} has no tangent direction at one of its ends")]
    NoTangent {
        /// Edge number.
        edge: u32,
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
    /// The edge runs along an edge of the box that cuts the surface.
    #[error(
        "edge {edge} between vertices {from} and {to} lies along an edge of the box: the surface must not contain any of it"
    )]
    AlongBoxEdge {
        /// Edge number.
        edge: u32,
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
    /// No curve with λ > 0 > μ was found that has both normal curvatures (Tong & Kim, Fig. 8): split the edge.
    #[error(
        "edge {edge} between vertices {from} and {to}: no quartic has both normal curvatures (split the edge)"
    )]
    Infeasible {
        /// Edge number.
        edge: u32,
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
}

/// Samples t_j = j/10 of a curve, ends left out.
const SAMPLES: usize = 9;
/// Edges whose samples are evaluated in one batch.
const BATCH: usize = 64;
/// Added to the Gram matrix of N0 and N1, which is singular where both normals agree.
const GRAM_REGULARISATION: f64 = 1e-9;
/// First damping of Levenberg–Marquardt, and the damping at which it gives up.
const DAMPING: [f64; 2] = [1e-6, 1e8];
/// Newton steps that restore (9b); quadratic convergence needs two or three.
const RESTORATION_STEPS: usize = 6;
/// Longest Gauss–Newton step, in chords.
const TRUST: f64 = 0.1;

/// Constants of the fit at the fixed samples.
struct Table {
    t: [f64; SAMPLES],
    b: [[f64; 5]; SAMPLES],
    /// Σ B2², and Σ B1 B2 over it (Σ B3 B2 is the same by symmetry).
    b22: f64,
    a: f64,
    /// B1 − a B2 and B3 − a B2.
    p1: [f64; SAMPLES],
    p3: [f64; SAMPLES],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let t: [f64; SAMPLES] = std::array::from_fn(|j| (j + 1) as f64 / (SAMPLES + 1) as f64);
    let b = t.map(basis::<5>);
    let b22: f64 = b.iter().map(|b| b[2] * b[2]).sum();
    let a = b.iter().map(|b| b[1] * b[2]).sum::<f64>() / b22;
    Table { t, b, b22, a, p1: b.map(|b| b[1] - a * b[2]), p3: b.map(|b| b[3] - a * b[2]) }
});

/// One boundary curve for each edge of the base mesh, from its positions, normals and curvature tensors.
///
/// Linear time, parallel over edges, independent of the number of threads.
pub fn fit_quartics(
    base: &BaseMesh,
    target: &dyn Target,
    options: &CurveOptions,
) -> Result<Vec<QuarticCurve>, CurveError> {
    let edges: Vec<EdgeId> = base.mesh.edges().collect();
    let batches: Result<Vec<_>, _> =
        edges.par_chunks(BATCH).map(|batch| fit_batch(base, target, options, batch)).collect();
    Ok(batches?.concat())
}

fn fit_batch(
    base: &BaseMesh,
    target: &dyn Target,
    options: &CurveOptions,
    edges: &[EdgeId],
) -> Result<Vec<QuarticCurve>, CurveError> {
    let ends: Vec<Ends> = edges.iter().map(|e| Ends::of(base, *e)).collect::<Result<_, _>>()?;
    let mut points: Points = ends.iter().flat_map(|e| TABLE.t.map(|t| e.q0 + t * e.chord)).collect();
    target.project(&mut points);
    project_within_sides(target, &ends, &mut points);

    let mut fits: Vec<Fit> = ends
        .iter()
        .enumerate()
        .map(|(i, e)| e.fit(std::array::from_fn(|j| points.get(i * SAMPLES + j) - e.q0), options))
        .collect();
    if options.normal_distance_steps > 0 {
        reduce_normal_distance(target, options, &ends, &mut fits);
    }
    edges
        .iter()
        .zip(ends.iter().zip(&fits))
        .map(|(edge, (ends, fit))| ends.finish(base, *edge, fit, options))
        .collect()
}

/// Newton steps of samples within a side of the box, at most: from points projected in space, three or four are usual.
const SECTION_STEPS: usize = 8;

/// Puts the samples of curves in a side of the box onto the section of the target by it, from where they are.
///
/// A step is limited to [`TRUST`] chords: where the surface is almost parallel to the side, the section may be far.
fn project_within_sides(target: &dyn Target, ends: &[Ends], points: &mut Points) {
    let samples: Vec<(usize, usize, &Ends)> = ends
        .iter()
        .enumerate()
        .filter_map(|(i, e)| e.across.map(|axis| (i, axis, e)))
        .flat_map(|(i, axis, e)| (0..SAMPLES).map(move |j| (i * SAMPLES + j, axis, e)))
        .collect();
    let mut section: Points = samples
        .iter()
        .map(|(i, axis, e)| {
            let mut p = points.get(*i);
            p[*axis] = e.q0[*axis];
            p
        })
        .collect();
    let mut offset = vec![0.0; samples.len()];
    let mut normal = Points::zeros(samples.len());
    for _ in 0..SECTION_STEPS {
        target.offsets(section.view(), &mut offset, normal.view_mut());
        for (i, (_, axis, e)) in samples.iter().enumerate() {
            let mut n = normal.get(i);
            n[*axis] = 0.0;
            let step = -offset[i] / n.norm_squared() * n;
            let length = step.norm();
            if length.is_finite() {
                section.set(i, section.get(i) + step * (TRUST * e.length / length).min(1.0));
            }
        }
    }
    for (i, (place, _, _)) in samples.iter().enumerate() {
        points.set(*place, section.get(i));
    }
}

/// What a curve interpolates. Positions are relative to `q0`.
struct Ends {
    q0: Point3,
    q4: Point3,
    chord: Vec3,
    length: f64,
    n: [Vec3; 2],
    /// Unit tangents, both pointing forward.
    t: [Vec3; 2],
    /// Normal curvatures along the tangents.
    k: [f64; 2],
    /// The coordinate that is constant on the side of the box that the curve lies in.
    across: Option<usize>,
}

/// The unknowns of a curve: q2 is relative to q0.
#[derive(Clone, Copy)]
struct Fit {
    lambda: f64,
    mu: f64,
    q2: Vec3,
    steps: usize,
}

impl Fit {
    fn as_vector(&self) -> SVector<f64, 5> {
        SVector::from([self.lambda, self.mu, self.q2.x, self.q2.y, self.q2.z])
    }

    fn moved(&self, step: &SVector<f64, 5>) -> Self {
        let q2 = self.q2 + Vec3::new(step[2], step[3], step[4]);
        Self { lambda: self.lambda + step[0], mu: self.mu + step[1], q2, steps: self.steps }
    }
}

impl Ends {
    fn of(base: &BaseMesh, edge: EdgeId) -> Result<Self, CurveError> {
        let h = base.mesh.edge_half_edge(edge);
        let (from, to) = (base.mesh.origin(h), base.mesh.dest(h));
        let (q0, q4) = (base.positions[from.index()], base.positions[to.index()]);
        let chord = q4 - q0;
        let n = [from, to].map(|v| base.normals[v.index()]);
        let m = [from, to].map(|v| base.curvatures[v.index()]);
        let length = chord.norm();
        let no_tangent = CurveError::NoTangent { edge: edge.0, from: from.0, to: to.0 };
        let unit = |v: Vec3| v.try_normalize(f64::EPSILON * length).ok_or(no_tangent);
        let t = [unit(base.direction(edge, from))?, -unit(base.direction(edge, to))?];
        let k = std::array::from_fn(|i| t[i].dot(&(m[i] * t[i])));
        let free = Self { q0, q4, chord, length, n, t, k, across: None };
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
            *k /= length;
        }
        Self { across: Some(side.axis), ..self }
    }

    /// Fit (9) to projected samples (relative to q0): Levenberg–Marquardt in (λ, μ), then (9b) restored exactly.
    fn fit(&self, samples: [Vec3; SAMPLES], options: &CurveOptions) -> Fit {
        let problem = Reduced::new(self, samples);
        let low = Vector2::new(options.shortest_tangent, -options.longest_tangent) * self.length;
        let high = Vector2::new(options.longest_tangent, -options.shortest_tangent) * self.length;
        let unconstrained =
            problem.h.try_inverse().map_or_else(Vector2::zeros, |inverse| inverse * problem.g);
        let mut x = unconstrained.sup(&low).inf(&high);
        let mut value = problem.objective(&x);
        let (mut damping, mut steps) = (DAMPING[0], 0);
        while steps < options.max_steps && damping < DAMPING[1] {
            steps += 1;
            let (gradient, mut hessian) = problem.derivatives(&x);
            (0..2).for_each(|i| hessian[(i, i)] *= 1.0 + damping);
            let Some(inverse) = hessian.try_inverse() else { break };
            let next = (x - inverse * gradient).sup(&low).inf(&high);
            let next_value = problem.objective(&next);
            let small = (next - x).norm() < options.step_tolerance * self.length;
            if next_value <= value {
                (x, value, damping) = (next, next_value, (0.1 * damping).max(1e-12));
            } else {
                damping *= 10.0;
            }
            if small {
                break;
            }
        }
        let fit = Fit { lambda: x[0], mu: x[1], q2: problem.q2(&x), steps };
        self.restore(fit)
    }

    /// Residuals of (9b), divided by 3.
    fn constraints(&self, fit: &Fit) -> Vector2<f64> {
        Vector2::new(
            fit.q2.dot(&self.n[0]) - 4.0 / 3.0 * fit.lambda * fit.lambda * self.k[0],
            (fit.q2 - self.chord).dot(&self.n[1]) - 4.0 / 3.0 * fit.mu * fit.mu * self.k[1],
        )
    }

    fn constraint_gradients(&self, fit: &Fit) -> SMatrix<f64, 2, 5> {
        let [n0, n1] = self.n;
        SMatrix::<f64, 2, 5>::from_row_slice(&[
            -8.0 / 3.0 * fit.lambda * self.k[0],
            0.0,
            n0.x,
            n0.y,
            n0.z,
            0.0,
            -8.0 / 3.0 * fit.mu * self.k[1],
            n1.x,
            n1.y,
            n1.z,
        ])
    }

    /// Least-norm Newton steps onto (9b).
    fn restore(&self, mut fit: Fit) -> Fit {
        for _ in 0..RESTORATION_STEPS {
            let gradients = self.constraint_gradients(&fit);
            let gram = gradients * gradients.transpose() + Matrix2::identity() * f64::EPSILON;
            let Some(inverse) = gram.try_inverse() else { break };
            fit = fit.moved(&-(gradients.transpose() * (inverse * self.constraints(&fit))));
        }
        fit
    }

    /// Control points relative to q0.
    fn control_points(&self, fit: &Fit) -> [Vec3; 5] {
        [Vec3::zeros(), fit.lambda * self.t[0], fit.q2, self.chord + fit.mu * self.t[1], self.chord]
    }

    fn in_box(&self, fit: &Fit, options: &CurveOptions) -> bool {
        let inside =
            |x: f64| x > options.shortest_tangent * self.length && x < options.longest_tangent * self.length;
        inside(fit.lambda) && inside(-fit.mu)
    }

    fn finish(
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
        let q1 = self.q0 + fit.lambda * self.t[0];
        let q3 = self.q4 + fit.mu * self.t[1];
        let q = [self.q0, q1, self.q0 + fit.q2, q3, self.q4];
        Ok(QuarticCurve { q, steps: fit.steps, at_bound: !self.in_box(fit, options) })
    }
}

/// The fit with q2 eliminated: ½-scaled objective xᵀHx − 2 g·x + Σ B2² dᵀ G⁻¹ d over x = (λ, μ), where d is the
/// violation of (9b) by the unconstrained best q2 and G the Gram matrix of the two normals.
struct Reduced<'a> {
    ends: &'a Ends,
    h: Matrix2<f64>,
    g: Vector2<f64>,
    gram_inverse: Matrix2<f64>,
    /// The best q2 for λ = μ = 0.
    q2: Vec3,
}

impl<'a> Reduced<'a> {
    fn new(ends: &'a Ends, samples: [Vec3; SAMPLES]) -> Self {
        let table = &*TABLE;
        let rest: [Vec3; SAMPLES] =
            std::array::from_fn(|j| samples[j] - (table.b[j][3] + table.b[j][4]) * ends.chord);
        let q2 = (0..SAMPLES).map(|j| table.b[j][2] * rest[j]).sum::<Vec3>() / table.b22;
        let mut g = Vector2::zeros();
        for j in 0..SAMPLES {
            let r = rest[j] - table.b[j][2] * q2;
            g += Vector2::new(table.p1[j] * r.dot(&ends.t[0]), table.p3[j] * r.dot(&ends.t[1]));
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let cross = dot(&table.p1, &table.p3) * ends.t[0].dot(&ends.t[1]);
        let h = Matrix2::new(dot(&table.p1, &table.p1), cross, cross, dot(&table.p3, &table.p3));
        let c = ends.n[0].dot(&ends.n[1]);
        let gram = Matrix2::new(1.0 + GRAM_REGULARISATION, c, c, 1.0 + GRAM_REGULARISATION);
        let gram_inverse = gram.try_inverse().unwrap_or_else(Matrix2::identity);
        Self { ends, h, g, gram_inverse, q2 }
    }

    fn free_q2(&self, x: &Vector2<f64>) -> Vec3 {
        self.q2 - TABLE.a * (x[0] * self.ends.t[0] + x[1] * self.ends.t[1])
    }

    fn violation(&self, x: &Vector2<f64>) -> Vector2<f64> {
        self.ends.constraints(&Fit { lambda: x[0], mu: x[1], q2: self.free_q2(x), steps: 0 })
    }

    /// The best q2 on both planes.
    fn q2(&self, x: &Vector2<f64>) -> Vec3 {
        let y = self.gram_inverse * self.violation(x);
        self.free_q2(x) - y[0] * self.ends.n[0] - y[1] * self.ends.n[1]
    }

    fn objective(&self, x: &Vector2<f64>) -> f64 {
        let d = self.violation(x);
        (x.transpose() * self.h * x)[0] - 2.0 * self.g.dot(x)
            + TABLE.b22 * (d.transpose() * self.gram_inverse * d)[0]
    }

    /// Half the gradient, and half the Gauss–Newton Hessian.
    fn derivatives(&self, x: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let Ends { t, n, k, .. } = self.ends;
        let jacobian = Matrix2::new(
            -8.0 / 3.0 * x[0] * k[0],
            -TABLE.a * t[1].dot(&n[0]),
            -TABLE.a * t[0].dot(&n[1]),
            -8.0 / 3.0 * x[1] * k[1],
        );
        let weighted = TABLE.b22 * jacobian.transpose() * self.gram_inverse;
        (self.h * x - self.g + weighted * self.violation(x), self.h + weighted * jacobian)
    }
}

/// Gauss–Newton steps on Σ (f/|∇f|)² + weight · (tangential motion)² at the samples, with (9b) kept; a curve keeps
/// its result only if the sum fell and (λ, μ) stayed inside the box.
fn reduce_normal_distance(target: &dyn Target, options: &CurveOptions, ends: &[Ends], fits: &mut [Fit]) {
    let start: Vec<Fit> = fits.to_vec();
    let mut batch = NormalBatch::new(ends.len());
    let before = batch.evaluate(target, ends, fits);
    for step in 0..options.normal_distance_steps {
        if step > 0 {
            batch.evaluate(target, ends, fits);
        }
        for (i, fit) in fits.iter_mut().enumerate() {
            *fit = batch.gauss_newton_step(i, &ends[i], fit, &start[i], options.tangential_weight);
        }
    }
    for (fit, ends) in fits.iter_mut().zip(ends) {
        *fit = ends.restore(*fit);
    }
    let after = batch.evaluate(target, ends, fits);
    for i in 0..fits.len() {
        // Written so that a NaN keeps the start.
        let better = after[i] <= before[i] && ends[i].in_box(&fits[i], options);
        if !better {
            fits[i] = start[i];
        }
    }
}

/// Offsets and normals of the target at the samples of a batch of curves.
struct NormalBatch {
    points: Points,
    offset: Vec<f64>,
    normal: Points,
}

impl NormalBatch {
    fn new(curves: usize) -> Self {
        let n = curves * SAMPLES;
        Self { points: Points::zeros(n), offset: vec![0.0; n], normal: Points::zeros(n) }
    }

    /// Evaluates the target; the sum of squared offsets of each curve.
    fn evaluate(&mut self, target: &dyn Target, ends: &[Ends], fits: &[Fit]) -> Vec<f64> {
        for (i, (ends, fit)) in ends.iter().zip(fits).enumerate() {
            let q = ends.control_points(fit);
            for (j, b) in TABLE.b.iter().enumerate() {
                let p: Vec3 = b.iter().zip(&q).map(|(b, q)| *b * q).sum();
                self.points.set(i * SAMPLES + j, ends.q0 + p);
            }
        }
        target.offsets(self.points.view(), &mut self.offset, self.normal.view_mut());
        self.offset.chunks(SAMPLES).map(|d| d.iter().map(|d| d * d).sum()).collect()
    }

    fn gauss_newton_step(&self, i: usize, ends: &Ends, fit: &Fit, start: &Fit, weight: f64) -> Fit {
        let moved = fit.as_vector() - start.as_vector();
        let mut a = SMatrix::<f64, 5, 5>::zeros();
        let mut gradient = SVector::<f64, 5>::zeros();
        for (j, b) in TABLE.b.iter().enumerate() {
            // The derivative of the sample by (λ, μ, q2) has these columns.
            let mut columns =
                [b[1] * ends.t[0], b[3] * ends.t[1], b[2] * Vec3::x(), b[2] * Vec3::y(), b[2] * Vec3::z()];
            if let Some(axis) = ends.across {
                columns[2 + axis] = Vec3::zeros();
            }
            let n = self.normal.get(i * SAMPLES + j);
            let row = SVector::from(columns.map(|c| c.dot(&n)));
            let motion = SMatrix::<f64, 3, 5>::from_columns(&columns);
            a += row * row.transpose() + weight * motion.transpose() * motion;
            gradient += self.offset[i * SAMPLES + j] * row + weight * motion.transpose() * (motion * moved);
        }
        // The row of a coordinate that does not move is zero but for this.
        ends.across.iter().for_each(|axis| a[(2 + axis, 2 + axis)] = 1.0);
        let gradients = ends.constraint_gradients(fit);
        let mut kkt = SMatrix::<f64, 7, 7>::zeros();
        kkt.fixed_view_mut::<5, 5>(0, 0).copy_from(&a);
        kkt.fixed_view_mut::<2, 5>(5, 0).copy_from(&gradients);
        kkt.fixed_view_mut::<5, 2>(0, 5).copy_from(&gradients.transpose());
        // Keeps the system regular where both normals, and so both constraints, agree.
        (5..7).for_each(|i| kkt[(i, i)] = -1e-15);
        let mut right = SVector::<f64, 7>::zeros();
        right.fixed_rows_mut::<5>(0).copy_from(&-gradient);
        right.fixed_rows_mut::<2>(5).copy_from(&-ends.constraints(fit));
        let Some(solution) = kkt.lu().solve(&right) else { return *fit };
        let step: SVector<f64, 5> = solution.fixed_rows::<5>(0).into();
        let length = step.norm();
        let limit = TRUST * ends.length;
        fit.moved(&(if length > limit { step * (limit / length) } else { step }))
    }
}
