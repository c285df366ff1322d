//! Curves moved until the surface is as near along its normal as they can be.
//!
//! Positions, normals and normal curvatures at the ends leave an error t³(1 − t)³ E L⁶ along the normal. Where the surface
//! bends along the chord, λ and μ can undo its E; along a direction without curvature they only move samples along the
//! curve, but there a turn of the tangents changes the normal curvature most. So the first control vectors
//!
//! ```text
//! w0 = λ t0 + α s0,   w1 = μ t1 + β s1        s = N × t
//! ```
//!
//! have both components free, and (8) is 3 (q2 − q0)·N0 = 4 w0ᵀ M0 w0: the curvature of the surface in whatever direction
//! the curve leaves. What that is worth is in PAPERS.md, deviations of the tangents.

use super::ends::{Ends, Fit, TRUST, UNKNOWNS};
use super::quartic::{CurveOptions, SAMPLES, TABLE};
use crate::geom::{Points, Vec3};
use crate::surface::Target;
use nalgebra::{SMatrix, SVector};

/// Factors of [`CurveOptions::damping`] after a step that counts and one that does not.
const LESS_DAMPING: f64 = 0.1;
const MORE_DAMPING: f64 = 30.0;

/// Levenberg–Marquardt steps on Σ (f/|∇f|)² + weight · (tangential motion)² at the samples, with (9b) kept exactly. A
/// step counts only if the sum fell and the tangents stayed within their limits.
pub(super) fn reduce_normal_distance(
    target: &dyn Target,
    options: &CurveOptions,
    ends: &[Ends],
    fits: &mut [Fit],
) {
    if options.damping == 0.0 {
        return plain_steps(target, options, ends, fits);
    }
    let start: Vec<Fit> = fits.to_vec();
    let mut points = Points::default();
    put_samples(ends, fits, &mut points);
    let origin = points.clone();
    let weight = options.tangential_weight;
    let mut best = NormalBatch::new(ends.len());
    let mut sums = best.evaluate(target, &origin, &origin, weight);
    let mut trial = NormalBatch::new(ends.len());
    let mut damping = vec![options.damping; ends.len()];
    let mut next = fits.to_vec();
    for _ in 0..options.normal_distance_steps {
        for (i, next) in next.iter_mut().enumerate() {
            let step = best.step(i, &ends[i], &fits[i], &start[i], damping[i], options);
            *next = ends[i].restore(ends[i].within_limits(step, options));
        }
        put_samples(ends, &next, &mut points);
        let after = trial.evaluate(target, &points, &origin, weight);
        for i in 0..fits.len() {
            // Written so that a NaN does not count.
            if after[i] < sums[i] && ends[i].in_box(&next[i], options) {
                (fits[i], sums[i]) = (next[i], after[i]);
                best.copy_curve(&trial, i);
                damping[i] *= LESS_DAMPING;
            } else {
                damping[i] *= MORE_DAMPING;
            }
        }
    }
}

/// All steps of Gauss and Newton, whether or not they are good ones; then (9b) is restored, and a curve keeps its result
/// only if the sum of squared offsets fell.
fn plain_steps(target: &dyn Target, options: &CurveOptions, ends: &[Ends], fits: &mut [Fit]) {
    let start: Vec<Fit> = fits.to_vec();
    let mut points = Points::default();
    put_samples(ends, fits, &mut points);
    let origin = points.clone();
    let mut batch = NormalBatch::new(ends.len());
    let before = batch.evaluate(target, &origin, &origin, 0.0);
    for step in 0..options.normal_distance_steps {
        if step > 0 {
            put_samples(ends, fits, &mut points);
            batch.evaluate(target, &points, &origin, 0.0);
        }
        for (i, fit) in fits.iter_mut().enumerate() {
            *fit = batch.step(i, &ends[i], fit, &start[i], 0.0, options);
        }
    }
    fits.iter_mut().zip(ends).for_each(|(fit, ends)| *fit = ends.restore(*fit));
    put_samples(ends, fits, &mut points);
    let after = batch.evaluate(target, &points, &origin, 0.0);
    for i in 0..fits.len() {
        // Written so that a NaN keeps the start.
        let better = after[i] <= before[i] && ends[i].in_box(&fits[i], options);
        if !better {
            fits[i] = start[i];
        }
    }
}

/// Makes `out` the samples of all curves.
fn put_samples(ends: &[Ends], fits: &[Fit], out: &mut Points) {
    out.resize(ends.len() * SAMPLES);
    for (c, (ends, fit)) in ends.iter().zip(fits).enumerate() {
        let q = ends.control_points(fit);
        for (j, b) in TABLE.b.iter().enumerate() {
            let sample = ends.q0 + b.iter().zip(&q).map(|(b, q)| *b * q).sum::<Vec3>();
            out.set(c * SAMPLES + j, sample);
        }
    }
}

/// Offsets and normals of the target at the samples of a batch of curves.
struct NormalBatch {
    offset: Vec<f64>,
    normal: Points,
}

impl NormalBatch {
    fn new(curves: usize) -> Self {
        let n = curves * SAMPLES;
        Self { offset: vec![0.0; n], normal: Points::zeros(n) }
    }

    /// Evaluates the target; the sum to be made small, for each curve.
    fn evaluate(&mut self, target: &dyn Target, points: &Points, origin: &Points, weight: f64) -> Vec<f64> {
        target.offsets(points.view(), &mut self.offset, self.normal.view_mut());
        let moved = |i: usize| (points.get(i) - origin.get(i)).norm_squared();
        let curves = self.offset.chunks(SAMPLES).enumerate();
        curves
            .map(|(c, d)| d.iter().enumerate().map(|(j, d)| d * d + weight * moved(c * SAMPLES + j)).sum())
            .collect()
    }

    /// Takes over what another batch found for curve `i`.
    fn copy_curve(&mut self, other: &Self, i: usize) {
        for j in i * SAMPLES..(i + 1) * SAMPLES {
            self.offset[j] = other.offset[j];
            self.normal.set(j, other.normal.get(j));
        }
    }

    /// The next fit to try; a vector that may not move keeps a row of the identity.
    fn step(
        &self,
        i: usize,
        ends: &Ends,
        fit: &Fit,
        start: &Fit,
        damping: f64,
        options: &CurveOptions,
    ) -> Fit {
        let weight = options.tangential_weight;
        let moved = fit.as_vector() - start.as_vector();
        let fixed: [bool; UNKNOWNS] = std::array::from_fn(|j| match j {
            2..5 => ends.across == Some(j - 2),
            5.. => ends.turn[j - 5] == 0.0,
            _ => false,
        });
        let mut a = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        let mut gradient = SVector::<f64, UNKNOWNS>::zeros();
        for (j, b) in TABLE.b.iter().enumerate() {
            // The derivatives of the sample by the unknowns.
            let mut columns = [
                b[1] * ends.t[0],
                b[3] * ends.t[1],
                b[2] * Vec3::x(),
                b[2] * Vec3::y(),
                b[2] * Vec3::z(),
                b[1] * ends.s[0],
                b[3] * ends.s[1],
            ];
            columns.iter_mut().zip(fixed).filter(|(_, fixed)| *fixed).for_each(|(c, _)| c.fill(0.0));
            let n = self.normal.get(i * SAMPLES + j);
            let row = SVector::from(columns.map(|c| c.dot(&n)));
            let motion = SMatrix::<f64, 3, UNKNOWNS>::from_columns(&columns);
            a += row * row.transpose() + (weight + damping) * motion.transpose() * motion;
            gradient += self.offset[i * SAMPLES + j] * row + weight * motion.transpose() * (motion * moved);
        }
        let mut gradients = ends.constraint_gradients(fit);
        for j in (0..UNKNOWNS).filter(|j| fixed[*j]) {
            a[(j, j)] = 1.0;
            gradients.column_mut(j).fill(0.0);
        }
        const ALL: usize = UNKNOWNS + 2;
        let mut kkt = SMatrix::<f64, ALL, ALL>::zeros();
        kkt.fixed_view_mut::<UNKNOWNS, UNKNOWNS>(0, 0).copy_from(&a);
        kkt.fixed_view_mut::<2, UNKNOWNS>(UNKNOWNS, 0).copy_from(&gradients);
        kkt.fixed_view_mut::<UNKNOWNS, 2>(0, UNKNOWNS).copy_from(&gradients.transpose());
        // Keeps the system regular where both normals, and so both constraints, agree.
        (UNKNOWNS..ALL).for_each(|i| kkt[(i, i)] = -1e-15);
        let mut right = SVector::<f64, ALL>::zeros();
        right.fixed_rows_mut::<UNKNOWNS>(0).copy_from(&-gradient);
        right.fixed_rows_mut::<2>(UNKNOWNS).copy_from(&-ends.constraints(fit));
        let Some(solution) = kkt.lu().solve(&right) else { return *fit };
        let step: SVector<f64, UNKNOWNS> = solution.fixed_rows::<UNKNOWNS>(0).into();
        let length = step.norm();
        let limit = TRUST * ends.length;
        fit.moved(&(if length > limit { step * (limit / length) } else { step }))
    }
}
