//! The G1 conditions at a vertex: Tong & Kim 2009, section 6.3.
//!
//! ```text
//!            curve i+1                Around a vertex o, curves leave counter-clockwise with d_i = q1 − o and
//!               |    corner i        c_i = (4/7) d_i; corner i lies between curves i and i + 1 and holds the
//!               |   • t_i            twist point t_i. Everything is an offset from o.
//!               |
//!               o———————— curve i    6[(1−λ0) t_{i−1} + λ0 t_i] − 4 μ1 d_i
//!                \                      = −[(1−λ1) c_{i−1} + λ1 c_{i+1}] + 3[(1−μ0) d_i + μ0 e_i]    (14)
//!                 \  • t_{i−1}
//!              curve i−1             with e_i = q2 − o and λ0, λ1, μ0, μ1 of curve i seen from o.
//! ```
//!
//! Row i of (14) has a normal part, solved in closed form for every valence by t_i·N = 7/6 c_iᵀ M c_{i+1}, and a
//! tangential part with the scalar μ1 free. Taking the component across d_i removes μ1, and the least change of
//! the twist points is then one small positive definite system per vertex. A closed vertex has as many rows as
//! corners; a boundary vertex has no row for its first and last curve.

use crate::geom::{Mat3, Vec3};
use nalgebra::{DMatrix, DVector};

/// One curve of the ring, as offsets from the vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingCurve {
    /// d = q1 − o.
    pub d: Vec3,
    /// e = q2 − o.
    pub e: Vec3,
}

/// λ0 and μ0 of a curve, equation (15): (1 − λ0) c_{i−1} + λ0 c_{i+1} = μ0 d_i.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndWeights {
    /// λ0, in (0, 1) where both corner angles are between 0 and π.
    pub lambda: f64,
    /// μ0.
    pub mu: f64,
}

/// Ratio of the first control vector in degree 7 to that in degree 4.
const ELEVATION: f64 = 4.0 / 7.0;

/// How far μ1 may be from a wanted value for the system to count as solved: far above rounding, far below what is seen.
const KEPT: f64 = 1e-6;

/// λ0 and μ0 from the directions of three consecutive curves at a vertex with unit normal `n`.
pub fn end_weights(previous: &Vec3, d: &Vec3, next: &Vec3, n: &Vec3) -> EndWeights {
    let (before, after) = (previous.cross(d).dot(n), d.cross(next).dot(n));
    let lambda = before / (before + after);
    let sum = ELEVATION * ((1.0 - lambda) * previous + lambda * next);
    EndWeights { lambda, mu: sum.dot(d) / d.norm_squared() }
}

/// The data of the conditions at one vertex.
#[derive(Clone, Debug)]
pub struct VertexSystem<'a> {
    /// Unit normal N.
    pub normal: Vec3,
    /// Curvature tensor M.
    pub curvature: Mat3,
    /// Curves of the ring, counter-clockwise.
    pub curves: &'a [RingCurve],
    /// λ0 and μ0 of each curve; unused for the first and last curve of an open ring.
    pub weights: &'a [EndWeights],
    /// λ1 of each curve: its λ at the far end, in the orientation of this ring.
    pub far_lambda: &'a [f64],
    /// Wanted twist points, one a corner: as many as curves, one less in an open ring.
    pub twists: &'a [Vec3],
}

/// Twist points and weights that satisfy (14).
#[derive(Clone, Debug)]
pub struct VertexSolution {
    /// Twist points t_i as offsets, one a corner.
    pub twists: Vec<Vec3>,
    /// μ1 of each curve; 0 for the first and last curve of an open ring.
    pub mu1: Vec<f64>,
}

/// Solves (14) with the exact second fundamental form in every corner and the least tangential change of the
/// wanted twist points. O(n³) for valence n. None if the tangential system is singular (a corner angle of 0 or π).
pub fn solve(system: &VertexSystem<'_>) -> Option<VertexSolution> {
    solve_with(system, &[])
}

/// As [`solve`], with the values of μ1 that `wanted` has for curves of the ring; missing entries are none. None also if the
/// conditions with these values have no unique solution: they have none in general where all curves around a vertex of even valence
/// get a value.
pub fn solve_with(system: &VertexSystem<'_>, wanted: &[Option<f64>]) -> Option<VertexSolution> {
    let VertexSystem { normal, curvature, curves, weights, far_lambda, twists } = system;
    let (n, corners) = (curves.len(), twists.len());
    let open = corners < n;
    let previous = |i: usize| (i + n - 1) % n;
    let c = |i: usize| ELEVATION * curves[i % n].d;

    // Normal part: the full second fundamental form (PAPERS.md, Appendix C with 7/6 in place of 2/3).
    let normal_part = |i: usize| 7.0 / 6.0 * c(i).dot(&(curvature * c(i + 1)));
    let tangential = |v: &Vec3| v - v.dot(normal) * normal;

    let rows: Vec<usize> = if open { (1..n - 1).collect() } else { (0..n).collect() };
    let right = |i: usize| {
        let (w, far) = (weights[i], far_lambda[i]);
        let (d, e) = (curves[i].d, curves[i].e);
        -((1.0 - far) * c(previous(i)) + far * c(i + 1)) + 3.0 * ((1.0 - w.mu) * d + w.mu * e)
    };
    // A condition of row i along a vector, with the part of μ1 that is known. Across d_i there is none of μ1.
    let across = |i: &usize| (*i, normal.cross(&curves[*i].d).normalize(), Vec3::zeros());
    let along = |i: &usize| {
        let mu = wanted.get(*i).copied().flatten()?;
        Some((*i, curves[*i].d.normalize(), 4.0 * mu * curves[*i].d))
    };
    let conditions: Vec<(usize, Vec3, Vec3)> =
        rows.iter().map(across).chain(rows.iter().filter_map(along)).collect();
    let mut t: Vec<Vec3> = twists.iter().map(tangential).collect();

    // Row r couples corners r − 1 and r through (coefficient, corner) pairs; G = A Aᵀ is cyclic tridiagonal.
    let coefficients =
        |i: usize| [(6.0 * (1.0 - weights[i].lambda), previous(i)), (6.0 * weights[i].lambda, i)];
    let residual = |i: usize, t: &[Vec3]| {
        let left: Vec3 = coefficients(i).iter().map(|(a, corner)| *a * t[*corner]).sum();
        right(i) - left
    };
    let mut gram = DMatrix::zeros(conditions.len(), conditions.len());
    for (r, (i, u, _)) in conditions.iter().enumerate() {
        for (s, (j, v, _)) in conditions.iter().enumerate() {
            let shared: f64 = coefficients(*i)
                .iter()
                .flat_map(|(a, p)| coefficients(*j).map(|(b, q)| if *p == q { a * b } else { 0.0 }))
                .sum();
            gram[(r, s)] = shared * u.dot(v);
        }
    }
    let violation = DVector::from_iterator(
        conditions.len(),
        conditions.iter().map(|(i, u, known)| (residual(*i, &t) + known).dot(u)),
    );
    // The corner vertex of a boundary has no rows.
    let multipliers = if rows.is_empty() { violation } else { gram.lu().solve(&violation)? };
    for (r, (i, u, _)) in conditions.iter().enumerate() {
        for (a, corner) in coefficients(*i) {
            t[corner] += a * multipliers[r] * u;
        }
    }
    let mut mu1 = vec![0.0; n];
    for i in rows {
        let d = curves[i].d;
        mu1[i] = -residual(i, &t).dot(&d) / (4.0 * d.norm_squared());
    }
    let twists: Vec<Vec3> = t.iter().enumerate().map(|(i, t)| t + normal_part(i) * normal).collect();
    let finite = twists.iter().all(|t| t.iter().all(|x| x.is_finite()));
    // A singular system that rounding has made regular does not keep the wanted values.
    let kept = mu1.iter().enumerate().all(|(i, mu)| {
        wanted
            .get(i)
            .copied()
            .flatten()
            .is_none_or(|wanted| (mu - wanted).abs() <= KEPT * (1.0 + wanted.abs()))
            || (open && (i == 0 || i == n - 1))
    });
    (finite && kept).then_some(VertexSolution { twists, mu1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of `n` curves on the graph z = ½ xᵀ M x with uneven angles and lengths, whose q2 have the right normal
    /// curvature.
    fn ring(n: usize) -> (Vec<RingCurve>, Mat3) {
        let curvature = Mat3::new(0.7, -0.4, 0.0, -0.4, -1.3, 0.0, 0.0, 0.0, 0.0);
        let curves = (0..n)
            .map(|i| {
                let angle = std::f64::consts::TAU * (i as f64 + 0.2 * (3.0 * i as f64).sin()) / n as f64;
                let d = (0.3 + 0.1 * (i as f64).cos()) * Vec3::new(angle.cos(), angle.sin(), 0.0);
                // (8): the normal part of q2 − o is 4/3 dᵀ M d.
                let e = 1.9 * d
                    + 0.05 * Vec3::new((i as f64).sin(), 0.3, 0.0)
                    + 4.0 / 3.0 * d.dot(&(curvature * d)) * Vec3::z();
                RingCurve { d, e }
            })
            .collect();
        (curves, curvature)
    }

    fn row_residual(
        i: usize,
        curves: &[RingCurve],
        w: &[EndWeights],
        far: f64,
        t: &[Vec3],
        mu1: f64,
    ) -> Vec3 {
        let n = curves.len();
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        let c = |i: usize| ELEVATION * curves[i].d;
        let left = 6.0 * ((1.0 - w[i].lambda) * t[before] + w[i].lambda * t[i]) - 4.0 * mu1 * curves[i].d;
        let right = -((1.0 - far) * c(before) + far * c(after))
            + 3.0 * ((1.0 - w[i].mu) * curves[i].d + w[i].mu * curves[i].e);
        left - right
    }

    fn weights_of(curves: &[RingCurve]) -> Vec<EndWeights> {
        let n = curves.len();
        (0..n)
            .map(|i| {
                end_weights(&curves[(i + n - 1) % n].d, &curves[i].d, &curves[(i + 1) % n].d, &Vec3::z())
            })
            .collect()
    }

    #[test]
    fn rows_hold_for_every_valence() {
        for n in 3..=12 {
            let (curves, curvature) = ring(n);
            let weights = weights_of(&curves);
            let far: Vec<f64> = (0..n).map(|i| 0.5 + 0.1 * (i as f64).sin()).collect();
            let twists: Vec<Vec3> = (0..n).map(|i| 0.5 * (curves[i].d + curves[(i + 1) % n].d)).collect();
            let system = VertexSystem {
                normal: Vec3::z(),
                curvature,
                curves: &curves,
                weights: &weights,
                far_lambda: &far,
                twists: &twists,
            };
            let solution = solve(&system).unwrap();
            for i in 0..n {
                let residual = row_residual(i, &curves, &weights, far[i], &solution.twists, solution.mu1[i]);
                assert!(residual.norm() < 1e-13, "valence {n}, row {i}: {residual}");
            }
        }
    }

    #[test]
    fn rows_of_an_open_ring_hold_between_its_ends() {
        let (mut curves, curvature) = ring(7);
        curves.truncate(4);
        let weights = weights_of(&curves);
        let twists: Vec<Vec3> = (0..3).map(|i| 0.5 * (curves[i].d + curves[i + 1].d)).collect();
        let system = VertexSystem {
            normal: Vec3::z(),
            curvature,
            curves: &curves,
            weights: &weights,
            far_lambda: &[0.5; 4],
            twists: &twists,
        };
        let solution = solve(&system).unwrap();
        assert_eq!(solution.twists.len(), 3);
        for i in 1..3 {
            let residual = row_residual(i, &curves, &weights, 0.5, &solution.twists, solution.mu1[i]);
            assert!(residual.norm() < 1e-13, "row {i}: {residual}");
        }
    }

    #[test]
    fn the_normal_part_needs_the_factor_seven_sixths() {
        let n = 5;
        let (curves, curvature) = ring(n);
        let weights = weights_of(&curves);
        let residual_with = |factor: f64| {
            let t: Vec<Vec3> = (0..n)
                .map(|i| {
                    let next = ELEVATION * curves[(i + 1) % n].d;
                    factor * (ELEVATION * curves[i].d).dot(&(curvature * next)) * Vec3::z()
                })
                .collect();
            (0..n).map(|i| row_residual(i, &curves, &weights, 0.5, &t, 0.0).z.abs()).fold(0.0, f64::max)
        };
        assert!(residual_with(7.0 / 6.0) < 1e-14);
        assert!(residual_with(2.0 / 3.0) > 1e-2, "the factor as printed must fail");
    }
}
