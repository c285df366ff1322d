//! How far points of a patch slide along the face on their way towards the apex.
//!
//! Where the surface goes through a face, points on one side of the crossing slide towards u, those on the other side towards v. The
//! surface is smooth there, but its parametrisation by rays has a kink, and with low apexes small triangles across it turn
//! over. That does not depend on how small they are, so it has to be avoided by the hull.

use super::class::{Class, Side};
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::simplicial_hull::HullFace;
use crate::geom::Vec3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};
use std::f64::consts::FRAC_PI_2;

/// Rows of small triangles at a corner that are looked at.
const ROWS: u32 = 4;

/// Does a small triangle at a corner of a nonconvex face turn over?
pub(super) fn corners_fold(frame: &FaceFrame, face: &HullFace) -> bool {
    face.class == Class::Nonconvex && (0..3).any(|a| corner_folds(frame, face, a))
}

/// The same at corner a, with everything to first order: at y times the edge to b and z times the edge to c, the function is
/// 3 (y e_ab + z e_ac) on the face and rises by 3 f_aau per unit towards the apex, so that points are on the tangent plane.
fn corner_folds(frame: &FaceFrame, face: &HullFace, a: usize) -> bool {
    let (b, c) = ((a + 1) % 3, (a + 2) % 3);
    let (e_b, e_c) = (frame.e[a][b], frame.e[a][c]);
    if e_b * e_c >= 0.0 {
        return false;
    }
    let (to_b, to_c) = (frame.p[b] - frame.p[a], frame.p[c] - frame.p[a]);
    let towards = Side::BOTH.map(|side| {
        let apex = face.apexes[side.index()].map_or_else(Vec3::zeros, |apex| apex - frame.p[a]);
        apex * (3.0 / apex.dot(&frame.n[a]))
    });
    let at = |[y, z]: [u32; 2]| {
        let (y, z) = (f64::from(y), f64::from(z));
        let value = y * e_b + z * e_c;
        let side = if value > 0.0 { Side::Inner } else { Side::Outer };
        y * to_b + z * to_c - value * towards[side.index()]
    };
    let turned = |triangle: [[u32; 2]; 3]| {
        let [p, q, r] = triangle.map(at);
        (q - p).cross(&(r - p)).dot(&frame.n[a]) <= 0.0
    };
    (0..ROWS).any(|y| {
        (0..ROWS - y).any(|z| {
            turned([[y, z], [y + 1, z], [y, z + 1]]) || turned([[y + 1, z], [y + 1, z + 1], [y, z + 1]])
        })
    })
}

/// Directions at a corner, between its two edges, that are looked at.
const DIRECTIONS: usize = 24;

/// By how much of what the flat face turns between neighbouring directions a corner should turn at least.
const LEAST_TURN: f64 = 3e-3;

/// By how much the patch over a face with creases turns over at its corner a, to first order: points go along rays from the corner,
/// which must turn one way from one edge to the other.
///
/// The points are those of [`corner_folds`], pulled to the curves of the creases as the patch is, see `apatch/crease.rs`:
/// at y times the edge to b, by y (C′ − c′) times the weight of the crease there.
pub(super) fn corner_turns_back(data: &HermiteMesh, f: FaceId, face: &HullFace, a: usize) -> f64 {
    let frame = FaceFrame::new(data.corners(f), data.corner_gradients(f));
    let mesh = data.mesh();
    let (b, c) = ((a + 1) % 3, (a + 2) % 3);
    let edges = [frame.p[b] - frame.p[a], frame.p[c] - frame.p[a]];
    let e = [frame.e[a][b], frame.e[a][c]];
    let towards = Side::BOTH.map(|side| {
        let apex = face.apexes[side.index()].map_or_else(Vec3::zeros, |apex| apex - frame.p[a]);
        let rise = apex.dot(&frame.n[a]);
        if rise == 0.0 { Vec3::zeros() } else { apex * (3.0 / rise) }
    });
    let of_hull = |y: f64, z: f64| {
        let value = y * e[0] + z * e[1];
        let side = if value > 0.0 { Side::Inner } else { Side::Outer };
        y * edges[0] + z * edges[1] - value * towards[side.index()]
    };
    let half_edges = [HalfEdgeId(3 * f.0 + a as u32), HalfEdgeId(3 * f.0 + c as u32)];
    let ends = [of_hull(1.0, 0.0), of_hull(0.0, 1.0)];
    let pulls: [Option<Vec3>; 2] = std::array::from_fn(|k| {
        let id = mesh.edge(half_edges[k]);
        let [start, second, third, end] = data.crease_curve(id)?.net;
        let is_start = (mesh.edge_half_edge(id) == half_edges[k]) == (k == 0);
        let derivative = 3.0 * if is_start { second - start } else { third - end };
        Some(derivative - ends[k])
    });
    let lengths = edges.map(|edge| edge.norm_squared());
    // Closer together near the edges, where a corner turns back first.
    let angle = |n: usize| {
        let t = n as f64 / DIRECTIONS as f64;
        FRAC_PI_2 * t * t * (3.0 - 2.0 * t)
    };
    let at = |n: usize| {
        // Steps of lengths along the edges, not of weights: else a short edge has all directions.
        let (z, y) = angle(n).sin_cos();
        let weights = [y / lengths[0].sqrt(), z / lengths[1].sqrt()];
        let sum = y * y + z * z;
        let shares = [y * y / sum, z * z / sum];
        let pulled = |k: usize| pulls[k].map_or_else(Vec3::zeros, |pull| weights[k] * shares[k] * pull);
        of_hull(weights[0], weights[1]) + pulled(0) + pulled(1)
    };
    let normal = frame.n[a].normalize();
    let widest = edges[0].cross(&edges[1]).norm() / (lengths[0] * lengths[1]).sqrt();
    let points: [Vec3; DIRECTIONS + 1] = std::array::from_fn(at);
    let turn = |n: usize| {
        let (p, q) = (points[n], points[n + 1]);
        let sine = p.cross(&q).dot(&normal) / (p.norm() * q.norm());
        let least = LEAST_TURN * widest * (angle(n + 1) - angle(n));
        if sine.is_finite() { (least - sine).max(0.0) } else { 1.0 }
    };
    (0..DIRECTIONS).map(turn).sum()
}

/// Places across the patch over an edge that are looked at.
const ACROSS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Does the patch over a nonconvex edge turn over where it goes through the edge?
///
/// To first order the points at a distance ±1 along the edge are ±V(y) on the two sides, in one plane. A strip between two rows of
/// points is not turned over, however the rows lie, if V_A × V_B′ and V_A′ × V_B point the right way (A before the crossing, B
/// behind it): if the sines of their angles are above `least`.
pub(super) fn crossing_folds(
    data: &HermiteMesh,
    faces: &[HullFace],
    e: EdgeId,
    class: Class,
    least: f64,
) -> bool {
    if class != Class::Nonconvex {
        return false;
    }
    let Some(pair) = data.joint(e) else { return false };
    let mesh = data.mesh();
    let both = pair.map(|h| {
        (FaceFrame::new(data.corners(mesh.face(h)), data.corner_gradients(mesh.face(h))), mesh.side(h))
    });
    let (left, k) = &both[0];
    let [e_i, e_j] = left.on_edge(*k);
    let (p, q) = (left.p[*k], left.p[(k + 1) % 3]);
    // The function on the edge is 3 x z (e_i x + e_j z).
    let z = e_i / (e_i - e_j);
    let x = 1.0 - z;
    let (crossing, along, slope) = (x * p + z * q, q - p, 3.0 * x * z * (e_j - e_i));
    let rays = |side: Side| {
        let [u_k, u_l] = [0, 1].map(|n| faces[mesh.face(pair[n]).index()].apexes[side.index()]);
        let (u_k, u_l) = (u_k? - crossing, u_l? - crossing);
        let rise = |n: usize, apex: Vec3| {
            let (frame, k) = &both[n];
            let layer1 = frame.layer1(side, &(crossing + apex));
            let (start, end) = if n == 0 { (x, z) } else { (z, x) };
            let mut at = [0.0; 3];
            (at[*k], at[(k + 1) % 3]) = (start, end);
            3.0 * layer1.value(at)
        };
        let (rise_k, rise_l) = (rise(0, u_k), rise(1, u_l));
        let to_surface = -side.sign() * slope;
        Some(ACROSS.map(|y| {
            let (top, rise) = (y * u_k + (1.0 - y) * u_l, y * rise_k + (1.0 - y) * rise_l);
            let moved = (u_k - u_l) / rise - (rise_k - rise_l) / (rise * rise) * top;
            (along + to_surface / rise * top, to_surface * moved)
        }))
    };
    let (Some(outer), Some(inner)) = (rays(Side::Outer), rays(Side::Inner)) else { return false };
    let (before, behind) = if slope > 0.0 { (outer, inner) } else { (inner, outer) };
    let normal = x * left.n[*k] + z * left.n[(k + 1) % 3];
    let turned = |a: &Vec3, b: &Vec3| a.cross(b).dot(&normal) <= least * a.norm() * b.norm() * normal.norm();
    before.iter().zip(&behind).any(|((a, a_y), (b, b_y))| turned(a, b_y) || turned(a_y, b))
}
