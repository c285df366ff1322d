//! The quadric near a polygon, in two stages.
//!
//! On a planar polygon, Q + λ h² has the same values and gradients as Q at all corners, h being the height over its plane: own data
//! say nothing of λ, which is the curvature along the normal. So the corners of the face determine all but that, and then λ is
//! what suits the corners around the face best.

use super::shape::Shape;
use crate::geom::{Mat3, Point3, Vec3};
use crate::hybrid::{HermitePolygons, Quadric};
use crate::mesh::{FaceId, HalfEdgeId};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

/// Coefficients of a quadric but for H_zz, in local coordinates with z along the normal: q_0; g; H_xx, H_yy, H_xy, H_xz, H_yz.
const KNOWN: usize = 9;
/// Singular values below this, relative to 1 (coordinates and gradients are of that size), are zero.
const SINGULAR: f64 = 1e-10;

/// The quadric that is near the data of a face; zero over one that no cells can stand on.
pub(super) fn near_face(data: &HermitePolygons, f: FaceId) -> Quadric {
    let shape = Shape::new(&data.frame(f).p);
    shape.map_or(Quadric::ZERO, |shape| two_stage(data, f, shape.center, shape.normal))
}

/// Do the corners of a face and those around it belong to this quadric, but for rounding? Then it may not be changed.
pub(super) fn is_quadric(data: &HermitePolygons, f: FaceId, quadric: &Quadric) -> bool {
    let own = data.mesh().face_half_edges(f);
    own.chain(corners_around(data, f)).all(|h| {
        let (p, gradient) = (data.position(h), data.gradient(h));
        let size = gradient.norm();
        let off = (quadric.gradient(&p) - gradient).norm() + quadric.value(&p).abs() / quadric.scale;
        off <= ON_QUADRIC * size
    })
}

/// Corners are on a quadric if value and gradient are off by less than this part of the gradient: lengths of gradients that are
/// recovered from unit normals have this many digits.
const ON_QUADRIC: f64 = 1e-9;

/// The quadric that is near the data of a face, centred at `center`; `normal` is a unit vector.
fn two_stage(data: &HermitePolygons, f: FaceId, center: Point3, normal: Vec3) -> Quadric {
    let mesh = data.mesh();
    let own: Vec<HalfEdgeId> = mesh.face_half_edges(f).collect();
    let scale = own.iter().map(|h| (data.position(*h) - center).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let axes = axes(&normal);
    let equations = |corners: &[HalfEdgeId]| {
        Equations::new(corners.iter().map(|h| {
            let x = axes * (data.position(*h) - center) / scale;
            (x, axes * data.gradient(*h) * scale)
        }))
    };
    let at_own = equations(&own);
    let around = equations(&corners_around(data, f));
    let (from_data, by_curvature) = at_own.solutions();
    let curvature = best_curvature(&[at_own, around], &from_data, &by_curvature);
    let q = from_data + curvature * by_curvature;
    let hessian = Mat3::new(q[4], q[6], q[7], q[6], q[5], q[8], q[7], q[8], curvature);
    let (g, hessian) = (axes.tr_mul(&Vec3::new(q[1], q[2], q[3])), axes.transpose() * hessian * axes);
    Quadric {
        coefficients: [
            q[0],
            g.x,
            g.y,
            g.z,
            hessian[(0, 0)],
            hessian[(1, 1)],
            hessian[(2, 2)],
            hessian[(0, 1)],
            hessian[(0, 2)],
            hessian[(1, 2)],
        ],
        center,
        scale,
    }
}

/// Rows: two unit vectors across the normal, and the normal.
fn axes(normal: &Vec3) -> Mat3 {
    let first = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    Mat3::from_rows(&[first.transpose(), normal.cross(&first).transpose(), normal.transpose()])
}

/// The corners of the faces around a face that are not at its vertices: one for each vertex, in order. What lies beyond creases
/// does not count.
fn corners_around(data: &HermitePolygons, f: FaceId) -> Vec<HalfEdgeId> {
    let mesh = data.mesh();
    let own: BTreeSet<u32> = mesh.face_vertices(f).map(|v| v.0).collect();
    let mut faces: Vec<FaceId> = Vec::new();
    for h in mesh.face_half_edges(f) {
        let smooth = |h: &HalfEdgeId| !data.is_crease(mesh.edge(*h));
        let onward = |h: &HalfEdgeId| mesh.ring_next(*h).filter(smooth).filter(|n| *n != *h);
        let back = |h: &HalfEdgeId| Some(*h).filter(smooth).and_then(|h| mesh.ring_prev(h));
        let turn = mesh.valence(mesh.origin(h));
        faces.extend(std::iter::successors(Some(h), onward).take(turn).map(|h| mesh.face(h)));
        faces.extend(std::iter::successors(Some(h), back).take(turn).map(|h| mesh.face(h)));
    }
    faces.sort_unstable();
    faces.dedup();
    let mut seen = own;
    let corners = faces.into_iter().flat_map(|f| mesh.face_half_edges(f));
    corners.filter(|h| seen.insert(mesh.origin(*h).0)).collect()
}

/// Equations for a quadric: rows · (the known coefficients) + `curvature` · H_zz = `wanted`.
struct Equations {
    rows: DMatrix<f64>,
    curvature: DVector<f64>,
    wanted: DVector<f64>,
}

impl Equations {
    /// Value 0 and the given gradient at each point.
    fn new(data: impl ExactSizeIterator<Item = (Vec3, Vec3)>) -> Self {
        let count = 4 * data.len();
        let mut all = Self {
            rows: DMatrix::zeros(count, KNOWN),
            curvature: DVector::zeros(count),
            wanted: DVector::zeros(count),
        };
        for (n, (p, gradient)) in data.enumerate() {
            let (x, y, z) = (p.x, p.y, p.z);
            let at = [
                [1.0, x, y, z, 0.5 * x * x, 0.5 * y * y, x * y, x * z, y * z],
                [0.0, 1.0, 0.0, 0.0, x, 0.0, y, z, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0, y, x, 0.0, z],
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, x, y],
            ];
            for (k, row) in at.iter().enumerate() {
                all.rows.row_mut(4 * n + k).copy_from_slice(row);
            }
            (all.curvature[4 * n], all.curvature[4 * n + 3]) = (0.5 * z * z, z);
            all.wanted.rows_mut(4 * n + 1, 3).copy_from(&gradient);
        }
        all
    }

    /// The least-squares solution for H_zz = 0, and how it changes with H_zz.
    fn solutions(&self) -> (DVector<f64>, DVector<f64>) {
        let svd = self.rows.clone().svd(true, true);
        let solved = |b: &DVector<f64>| svd.solve(b, SINGULAR).unwrap_or_else(|_| DVector::zeros(KNOWN));
        (solved(&self.wanted), solved(&-&self.curvature))
    }
}

/// The H_zz with the least sum of squared residuals; 0 where they do not depend on it.
fn best_curvature(all: &[Equations], from_data: &DVector<f64>, by_curvature: &DVector<f64>) -> f64 {
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for e in all {
        let residual = &e.rows * from_data - &e.wanted;
        let change = &e.rows * by_curvature + &e.curvature;
        numerator -= residual.dot(&change);
        denominator += change.norm_squared();
    }
    if denominator > UNDETERMINED { numerator / denominator } else { 0.0 }
}

/// With less, every corner around is in the plane of the face and says nothing.
const UNDETERMINED: f64 = 1e-12;
