//! Gradients in the middle of edges, to the third order.
//!
//! The mean of the gradients at both ends (step 2 of the paper) is off by the second derivative of the gradient along the edge,
//! −|e|²/8 ∂²∇F/∂e², so that errors of the surface fall with the third power of the edge length. Its part across the edge follows
//! from the corners of the two polygons: near an edge the function is a quadric and a cubic form T of the coordinates in the
//! tangent plane. On quadrics T vanishes and the mean stays.

use crate::geom::{Mat3, Vec3};
use crate::hybrid::{HermitePolygons, Quadric};
use crate::mesh::{EdgeId, HalfEdgeId};
use crate::parallel::Evenly;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

/// Coefficients of a quadric, then T_xxx, T_xxy, T_xyy, T_yyy.
const UNKNOWNS: usize = 14;
/// The place of T_xxy: x is along the edge, y across it.
const ACROSS: usize = 11;

/// Added to the diagonal of the normal equations, whose entries are about 1: combinations that the corners hardly determine stay
/// zero.
const DAMPING: f64 = 1e-6;

/// Gradients that differ from their mean by more than the first of these parts of its length, about 60°, are trusted less, and by
/// more than the second, about a right angle, not at all: over such a turn a cubic near an edge says nothing.
const TURN: [f64; 2] = [1.0, 1.5];

/// How far what is finer than the paper's rule is to be trusted where these gradients are: from 0 to 1.
pub(super) fn trust(gradients: impl Iterator<Item = Vec3> + Clone, mean: &Vec3) -> f64 {
    let turn = gradients.map(|g| (g - mean).norm()).fold(0.0, f64::max) / mean.norm();
    ((TURN[1] - turn) / (TURN[1] - TURN[0])).clamp(0.0, 1.0)
}

type Row = SVector<f64, UNKNOWNS>;

/// Moves the middle gradients of all smooth edges; `quadrics` are near the faces.
pub(super) fn refine(data: &mut HermitePolygons, quadrics: &[Quadric]) {
    let moves: Vec<Option<Vec3>> = (0..data.mesh().edge_count())
        .into_par_iter()
        .evenly()
        .map(|e| lacking(data, quadrics, e.into()))
        .collect();
    for (e, by) in moves.into_iter().enumerate() {
        if let Some(by) = by {
            data.move_middle(e.into(), by);
        }
    }
}

/// What the middle coefficient of an edge lacks across the edge; none at boundaries and creases.
fn lacking(data: &HermitePolygons, quadrics: &[Quadric], e: EdgeId) -> Option<Vec3> {
    let (mesh, [h, g]) = (data.mesh(), data.joint(e)?);
    let [start, end] = [h, g].map(|h| data.position(h));
    let middle = 0.5 * (start + end);
    let along = (end - start).normalize();
    let mean = data.gradient(h) + data.gradient(g);
    let up = (mean - mean.dot(&along) * along).try_normalize(0.0)?;
    let across = up.cross(&along);
    let axes = Mat3::from_rows(&[along, across, up].map(|v| v.transpose()));
    // The corners of the right face that are not on the edge follow those of the left one.
    let beyond = mesh.face_half_edges(mesh.face(g)).filter(|c| *c != g && *c != mesh.next(g));
    let corners: Vec<HalfEdgeId> = mesh.face_half_edges(mesh.face(h)).chain(beyond).collect();
    let scale = corners.iter().map(|c| (data.position(*c) - middle).norm()).fold(0.0, f64::max);
    let near = [h, g].map(|h| &quadrics[mesh.face(h).index()]);
    let (mut matrix, mut right) = (SMatrix::<f64, UNKNOWNS, UNKNOWNS>::identity() * DAMPING, Row::zeros());
    let trust = trust(corners.iter().map(|c| data.gradient(*c)), &(0.5 * mean));
    if trust == 0.0 {
        return None;
    }
    for c in corners {
        let p = data.position(c);
        let value = 0.5 * (near[0].value(&p) + near[1].value(&p)) / scale;
        let slope = data.gradient(c) - 0.5 * (near[0].gradient(&p) + near[1].gradient(&p));
        let missing = axes * slope;
        for (row, wanted) in
            rows(&(axes * (p - middle) / scale)).iter().zip([-value, missing.x, missing.y, missing.z])
        {
            matrix.ger(1.0, row, row, 1.0);
            right += wanted * row;
        }
    }
    let found = matrix.cholesky()?.solve(&right);
    // Over half the edge the slope across it changes by T_xxy x²/2, and a change of the middle coefficient counts half.
    let half = 0.5 * (end - start).norm() / scale;
    let by = -trust * found[ACROSS] * half * half;
    by.is_finite().then(|| by * across)
}

/// Value and derivatives of all terms at a point.
fn rows(at: &Vec3) -> [Row; 4] {
    let (x, y, z) = (at.x, at.y, at.z);
    let (xx, yy, zz) = (0.5 * x * x, 0.5 * y * y, 0.5 * z * z);
    [
        [1.0, x, y, z, xx, yy, zz, x * y, x * z, y * z, x * xx / 3.0, xx * y, x * yy, y * yy / 3.0],
        [0.0, 1.0, 0.0, 0.0, x, 0.0, 0.0, y, z, 0.0, xx, x * y, yy, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, x, 0.0, z, 0.0, xx, x * y, yy],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, z, 0.0, x, y, 0.0, 0.0, 0.0, 0.0],
    ]
    .map(Row::from)
}
