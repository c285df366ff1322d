//! The G1 condition along an edge for any degrees: Tong & Kim 2009, (1) to (3), Tables 1 and 2.
//!
//! ```text
//!   [1 − λ(t)] p(t) + λ(t) r(t) = [1 − μ(t)] q_b(t) + μ(t) q_t(t)                                     (1)
//!     r    n − 1              degrees           s    m − 1                       r + n = s + m
//! ```
//!
//! λ has degree r, μ degree s, the boundary curve q degree m, the patches on both sides degree n; p and r are their first rows,
//! q_b and q_t the control points of q without its last and without its first. In Bernstein form (1) has r + n rows, one for each k
//! of (3). [`super::vertex`] and [`super::edge`] solve them for r = 1, s = 4, m = 4, n = 7, as Table 2 has them; this file is for any
//! degrees, to check those rows and to see which degrees leave all systems local.

use crate::bernstein::curve::binomial;
use nalgebra::DMatrix;

/// The degrees r, s, m, n of (1), with r + n = s + m and m ≤ n.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degrees {
    lambda: usize,
    mu: usize,
    curve: usize,
    patch: usize,
}

/// Degrees for which (1) makes no sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DegreeError {
    /// The sides of (1) have different degrees.
    #[error(
        "λ of degree {lambda} and patches of degree {patch} do not go with μ of degree {mu} and curves of degree {curve}"
    )]
    Unbalanced {
        /// r.
        lambda: usize,
        /// s.
        mu: usize,
        /// m.
        curve: usize,
        /// n.
        patch: usize,
    },
    /// A curve has no tangent, or a higher degree than the patches that it bounds.
    #[error("curves of degree {curve} can't bound patches of degree {patch}")]
    Curve {
        /// m.
        curve: usize,
        /// n.
        patch: usize,
    },
}

/// Why the systems of two vertices, or of a vertex and an edge, can't be solved one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Obstacle {
    /// m < 4: a control point of the curve lies in the rows k = 0, 1 of both ends, which both bind it by their normal curvature.
    SharedCurvePoint,
    /// n < 5: a point of the first rows is a twist point of both ends.
    SharedTwist,
    /// r = 0: λ is the same at both ends, where the tangents give it two values. r = 2: λ1 stands in the rows k = 1 of both ends.
    SharedLambda,
    /// s < 3: a coefficient of μ stands in the rows of both ends.
    SharedMu,
    /// s = 3: no coefficient of μ is left to make the rows of an edge consistent where λ is constant, eq. (22).
    NoMuForEdge,
}

/// A row of (3): Σ `p`ᵢ pᵢ + Σ `r`ᵢ rᵢ = Σ `q`ᵢ qᵢ.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Factors of the first row of the right patch, n of them.
    pub p: Vec<f64>,
    /// Factors of the first row of the left patch, n of them.
    pub r: Vec<f64>,
    /// Factors of the control points of the curve, m + 1 of them.
    pub q: Vec<f64>,
}

impl Degrees {
    /// The choice of the paper: r = 1, s = 4, m = 4, n = 7.
    pub const PAPER: Self = Self { lambda: 1, mu: 4, curve: 4, patch: 7 };

    /// Degrees r of λ, s of μ, m of the curve and n of the patches.
    ///
    /// # Errors
    /// r + n is not s + m, or not 1 ≤ m ≤ n.
    pub fn new(lambda: usize, mu: usize, curve: usize, patch: usize) -> Result<Self, DegreeError> {
        if lambda + patch != mu + curve {
            return Err(DegreeError::Unbalanced { lambda, mu, curve, patch });
        }
        if curve == 0 || curve > patch {
            return Err(DegreeError::Curve { curve, patch });
        }
        Ok(Self { lambda, mu, curve, patch })
    }

    /// Number of rows, r + n.
    pub fn rows(self) -> usize {
        self.lambda + self.patch
    }

    /// Rows that no vertex settles: k = 2 … r + n − 3.
    pub fn edge_rows(self) -> std::ops::Range<usize> {
        2..self.rows().saturating_sub(2).max(2)
    }

    /// Points of each first row that no vertex settles: 2 … n − 3.
    pub fn edge_points(self) -> std::ops::Range<usize> {
        2..self.patch.saturating_sub(2).max(2)
    }

    /// Coefficients of μ that are left to an edge: all but two at either end.
    pub fn free_mu(self) -> usize {
        (self.mu + 1).saturating_sub(4)
    }

    /// Control points of a patch that no condition binds: those at least two rows inside.
    pub fn free_points(self) -> usize {
        // b_ijk with i, j, k ≥ 2: a net of degree n − 6.
        self.patch.checked_sub(6).map_or(0, |n| (n + 1) * (n + 2) / 2)
    }

    /// What keeps the systems of vertices and edges from being solved one after the other, in the order of [`Obstacle`]; empty
    /// for degrees with which they can be, as section 7 of the paper asks for.
    pub fn obstacles(self) -> Vec<Obstacle> {
        let all = [
            (Obstacle::SharedCurvePoint, self.curve < 4),
            (Obstacle::SharedTwist, self.patch < 5),
            (Obstacle::SharedLambda, self.lambda == 0 || self.lambda == 2),
            (Obstacle::SharedMu, self.mu < 3),
            (Obstacle::NoMuForEdge, self.mu == 3),
        ];
        all.into_iter().filter(|(_, is_there)| *is_there).map(|(obstacle, _)| obstacle).collect()
    }

    /// Row k of (3), for the Bernstein coefficients of λ (r + 1) and μ (s + 1); none if k or their number is not that of
    /// the degrees.
    pub fn row(self, k: usize, lambda: &[f64], mu: &[f64]) -> Option<Row> {
        if k >= self.rows() || lambda.len() != self.lambda + 1 || mu.len() != self.mu + 1 {
            return None;
        }
        let Self { curve: m, patch: n, .. } = self;
        let mut row = Row { p: vec![0.0; n], r: vec![0.0; n], q: vec![0.0; m + 1] };
        // The index ranges of (3) are clipped to the degrees of the factors.
        for (i, l) in lambda.iter().enumerate().filter(|(i, _)| (*i..*i + n).contains(&k)) {
            let weight = binomial(self.lambda, i) * binomial(n - 1, k - i);
            row.p[k - i] += weight * (1.0 - l);
            row.r[k - i] += weight * l;
        }
        for (i, u) in mu.iter().enumerate().filter(|(i, _)| (*i..*i + m).contains(&k)) {
            let weight = binomial(self.mu, i) * binomial(m - 1, k - i);
            row.q[k - i] += weight * (1.0 - u);
            row.q[k - i + 1] += weight * u;
        }
        Some(row)
    }

    /// The matrix A of an edge system, (20): the rows of [`Degrees::edge_rows`] over the unknowns p2, r2, p3, r3, … of
    /// [`Degrees::edge_points`]. None if λ has not r + 1 coefficients.
    pub fn edge_matrix(self, lambda: &[f64]) -> Option<DMatrix<f64>> {
        let mu = vec![0.0; self.mu + 1];
        let rows: Vec<Row> = self.edge_rows().map(|k| self.row(k, lambda, &mu)).collect::<Option<_>>()?;
        let points = self.edge_points();
        Some(DMatrix::from_fn(rows.len(), 2 * points.len(), |i, j| {
            let side = if j % 2 == 0 { &rows[i].p } else { &rows[i].r };
            side[points.start + j / 2]
        }))
    }
}
