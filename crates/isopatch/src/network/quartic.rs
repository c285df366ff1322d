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
//! box, solved by Levenberg–Marquardt steps ([`super::reduced`]). Steps on the distance along the normal follow, in which
//! the tangents also turn out of the direction of the chord ([`super::normal_distance`]; PAPERS.md, deviations).

use super::ends::{Ends, Fit};
use super::normal_distance::reduce_normal_distance;
use super::section::project_within_sides;
use crate::base::BaseMesh;
use crate::bernstein::curve::basis;
use crate::geom::{Point3, Points};
use crate::mesh::EdgeId;
use crate::parallel::Evenly;
use crate::surface::Target;
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
    /// Steps on the distance along the normal; 0 leaves the fit to projected samples.
    pub normal_distance_steps: usize,
    /// Weight of tangential motion from the first fit in these steps: only enough to make them unique, as the tangents have
    /// their own limits.
    pub tangential_weight: f64,
    /// First weight of any motion from the present curve in a step: more after a step that made the curve worse, less after
    /// others. 0 makes them plain Gauss–Newton steps, of which all count together or none.
    pub damping: f64,
    /// Largest turn of the tangents out of the direction of the chord in these steps, as the tangent of the angle;
    /// 0 keeps them there, as the paper does. It does not depend on the corners beside the edge, so that a curve depends on
    /// nothing but its ends; corners of less than twice the angle could close.
    pub largest_turn: f64,
    /// How (9) is solved; default by Levenberg–Marquardt steps.
    pub solver: CurveSolver,
    /// ε of Algorithm 5.1: it stops when the unknowns and multipliers move by less.
    pub sqp_tolerance: f64,
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
            normal_distance_steps: 5,
            tangential_weight: 1e-6,
            damping: 1e-4,
            largest_turn: 0.35,
            solver: CurveSolver::Reduced,
            sqp_tolerance: 1e-6,
            constraint_tolerance: 1e-10,
        }
    }
}

/// How the fit (9) of a curve is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveSolver {
    /// In two unknowns, by Levenberg–Marquardt steps: it always ends in the box of tangent lengths.
    Reduced,
    /// By the paper's Algorithm 5.1; where that fails, as above, and the curve is flagged.
    Sqp,
}

/// A boundary curve with what its fit found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarticCurve {
    /// Control points, from the origin of the edge's half edge to its end.
    pub q: [Point3; 5],
    /// Levenberg–Marquardt steps, or iterations of Algorithm 5.1.
    pub steps: usize,
    /// Algorithm 5.1 was asked for and found no curve.
    pub sqp_failed: bool,
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
pub(super) const SAMPLES: usize = 9;
/// Edges whose samples are evaluated in one batch.
const BATCH: usize = 8;

/// Constants of the fit at the fixed samples.
pub(super) struct Table {
    t: [f64; SAMPLES],
    /// Quartic Bernstein polynomials.
    pub b: [[f64; 5]; SAMPLES],
    /// Quintic ones.
    quintic: [[f64; 6]; SAMPLES],
    /// Σ B2², and Σ B1 B2 over it (Σ B3 B2 is the same by symmetry).
    pub b22: f64,
    pub a: f64,
    /// B1 − a B2 and B3 − a B2.
    pub p1: [f64; SAMPLES],
    pub p3: [f64; SAMPLES],
}

pub(super) static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let t: [f64; SAMPLES] = std::array::from_fn(|j| (j + 1) as f64 / (SAMPLES + 1) as f64);
    let b = t.map(basis::<5>);
    let b22: f64 = b.iter().map(|b| b[2] * b[2]).sum();
    let a = b.iter().map(|b| b[1] * b[2]).sum::<f64>() / b22;
    let quintic = t.map(basis::<6>);
    Table { t, b, quintic, b22, a, p1: b.map(|b| b[1] - a * b[2]), p3: b.map(|b| b[3] - a * b[2]) }
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
    fit_edges(base, &edges, target, options)
}

/// The boundary curves of some edges, in their order: the same as those of [`fit_quartics`].
pub fn fit_edges(
    base: &BaseMesh,
    edges: &[EdgeId],
    target: &dyn Target,
    options: &CurveOptions,
) -> Result<Vec<QuarticCurve>, CurveError> {
    let batches: Result<Vec<_>, _> =
        edges.par_chunks(BATCH).evenly().map(|batch| fit_batch(base, target, options, batch)).collect();
    Ok(batches?.concat())
}

/// One boundary curve for each of some edges from the data at its ends alone, for a surface of which nothing else is known: the fit
/// (9) to the quintic curve with the positions, tangents and normal curvatures of both ends.
pub fn interpolate_edges(
    base: &BaseMesh,
    edges: &[EdgeId],
    options: &CurveOptions,
) -> Vec<Result<QuarticCurve, CurveError>> {
    edges
        .par_iter()
        .evenly_by(BATCH)
        .map(|edge| {
            let ends = Ends::of(base, *edge, options)?;
            let fit = ends.fit(ends.hermite_points(&TABLE.quintic), options);
            ends.finish(base, *edge, &fit, options)
        })
        .collect()
}

fn fit_batch(
    base: &BaseMesh,
    target: &dyn Target,
    options: &CurveOptions,
    edges: &[EdgeId],
) -> Result<Vec<QuarticCurve>, CurveError> {
    let ends: Vec<Ends> = edges.iter().map(|e| Ends::of(base, *e, options)).collect::<Result<_, _>>()?;
    let mut points = Points::with_capacity(ends.len() * SAMPLES);
    ends.iter().for_each(|e| TABLE.t.iter().for_each(|t| points.push(e.q0 + *t * e.chord)));
    target.project(&mut points);
    project_within_sides(target, &ends, &mut points);

    let mut fits: Vec<Fit> = ends
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let samples = std::array::from_fn(|j| points.get(i * SAMPLES + j) - e.q0);
            match options.solver {
                CurveSolver::Reduced => e.fit(samples, options),
                CurveSolver::Sqp => e
                    .fit_sqp(samples, options)
                    .unwrap_or_else(|| Fit { sqp_failed: true, ..e.fit(samples, options) }),
            }
        })
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
