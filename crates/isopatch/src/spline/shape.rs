//! What the G1 conditions leave free: Tong & Kim 2009, sections 6.3 to 6.5.

use super::build::SplineError;
use super::surface::NET;
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};

/// Values for what the G1 conditions leave free, where others are wanted than those that [`super::build`] chooses. The surface
/// stays G1 with the same vertices, normals, curvatures and boundary curves whatever they are; only its shape changes. Elements
/// that are named twice get the last value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeParameters {
    /// μ1 of the curve of a half edge, at the vertex where it starts, seen with the half edge's face on the left; without a value,
    /// that of the least change of the twist points. μ3 of a curve is 1 − μ1 of the twin. At a vertex of even valence not all
    /// curves can have a given value.
    pub mu1: Vec<(HalfEdgeId, f64)>,
    /// ν of an edge, by which μ2 differs from (23): μ2 = (−μ0 + 4μ1 + 4μ3 − μ4)/6 + (λ1 − λ0) ν/6. Default 0. Nothing changes
    /// along edges with λ0 = λ1 but the difference r − p of the first rows.
    pub nu: Vec<(EdgeId, f64)>,
    /// What is added in the end to b_322, b_232 and b_223 of a patch, the points that no condition binds.
    pub inner: Vec<(FaceId, [Vec3; 3])>,
}

/// Why there is no surface with the wanted shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A value is not a number, or its element is not there.
    #[error("a shape parameter is not a finite number, or is for an element that the mesh does not have")]
    Value,
    /// The conditions can't be solved, perhaps because of values for μ1 that can't be had together.
    #[error(transparent)]
    Spline(#[from] SplineError),
}

impl ShapeParameters {
    /// Do all elements exist, and are all values numbers?
    pub(super) fn check(&self, mesh: &HalfEdgeMesh) -> Result<(), ShapeError> {
        let good = self.mu1.iter().all(|(h, x)| h.index() < mesh.half_edge_count() && x.is_finite())
            && self.nu.iter().all(|(e, x)| e.index() < mesh.edge_count() && x.is_finite())
            && self.inner.iter().all(|(f, points)| {
                f.index() < mesh.face_count() && points.iter().flatten().all(|x| x.is_finite())
            });
        if good { Ok(()) } else { Err(ShapeError::Value) }
    }

    /// ν of every edge.
    pub(super) fn nu_of_edges(&self, count: usize) -> Vec<f64> {
        let mut nu = vec![0.0; count];
        self.nu.iter().for_each(|(e, x)| nu[e.index()] = *x);
        nu
    }

    /// Moves the points that no condition binds.
    pub(super) fn move_inner_points(&self, nets: &mut [[Point3; NET]], positions: [usize; 3]) {
        for (f, offsets) in &self.inner {
            for (at, offset) in positions.into_iter().zip(offsets) {
                nets[f.index()][at] += offset;
            }
        }
    }
}
