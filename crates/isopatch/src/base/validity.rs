//! What a base mesh must fulfil for a good spline surface over it.

use super::base_mesh::BaseMesh;
use super::shape::{area_vector, largest_angle_cosine};
use crate::geom::{Point3, angle_between};
use crate::mesh::{FaceId, HalfEdgeId};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Limits of [`validity`], each with the default that measurements on the surfaces of Tong & Kim 2009 suggest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValidityLimits {
    /// Smallest angle between the directions of neighbouring curves at a vertex, in degrees. Default 5.
    pub smallest_corner: f64,
    /// Largest such angle, in degrees. Default 170; at 180 there is no smooth surface any more.
    pub largest_corner: f64,
    /// Largest angle between a face's normal and the surface normals at its corners, in degrees. Default 45.
    pub facet_deviation: f64,
    /// Largest turn of the normal along an edge, |M (q − p)|: edge length times curvature in its direction. Default 1.5.
    pub curvature_length: f64,
    /// Smallest number of edges at a vertex. Default 3; on the boundary, one less.
    pub valence: usize,
}

impl Default for ValidityLimits {
    fn default() -> Self {
        Self {
            smallest_corner: 5.0,
            largest_corner: 170.0,
            facet_deviation: 45.0,
            curvature_length: 1.5,
            valence: 3,
        }
    }
}

/// Which limit is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// A corner angle in the tangent plane, in degrees.
    Corner,
    /// Angle between face normal and vertex normal, in degrees.
    FacetDeviation,
    /// Curvature at a vertex in the direction of an edge, times its length.
    CurvatureLength,
    /// Number of edges at a vertex.
    Valence,
}

/// A face, at one of its corners, beyond a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The limit.
    pub limit: Limit,
    /// The face.
    pub face: FaceId,
    /// Position of the corner.
    pub at: Point3,
    /// What was measured, in the limit's unit.
    pub value: f64,
}

/// What is measured at one corner of a face.
struct CornerMeasures {
    at: Point3,
    corner: f64,
    deviation: f64,
    curvature_length: f64,
    valence: usize,
}

fn corner_measures(base: &BaseMesh, h: HalfEdgeId) -> CornerMeasures {
    let mesh = &base.mesh;
    let v = mesh.origin(h);
    let [p, q, r] = [h, mesh.next(h), mesh.prev(h)].map(|e| base.positions[mesh.origin(e).index()]);
    let n = &base.normals[v.index()];
    let [first, second] = [h, mesh.prev(h)].map(|h| base.direction(mesh.edge(h), v));
    CornerMeasures {
        at: p,
        corner: n.dot(&first.cross(&second)).atan2(first.dot(&second)).to_degrees(),
        deviation: angle_between(&area_vector([p, q, r]), n).to_degrees(),
        curvature_length: (base.curvatures[v.index()] * (q - p)).norm(),
        valence: mesh.valence(v),
    }
}

/// All corners beyond the limits, in the order of the faces. Empty for a mesh that is fit for a spline surface.
pub fn validity(base: &BaseMesh, limits: &ValidityLimits) -> Vec<Violation> {
    /// Corners that one task looks at.
    const TASK: usize = 64;
    let corners: Vec<HalfEdgeId> = base.mesh.half_edges().collect();
    corners.into_par_iter().evenly_by(TASK).flat_map_iter(|h| violations_at(base, h, limits)).collect()
}

/// The violations at one corner.
fn violations_at(
    base: &BaseMesh,
    h: HalfEdgeId,
    limits: &ValidityLimits,
) -> impl Iterator<Item = Violation> + use<> {
    let m = corner_measures(base, h);
    let valence =
        limits.valence.saturating_sub(usize::from(base.mesh.is_boundary_vertex(base.mesh.origin(h))));
    // Comparisons are such that NaN is bad.
    let checks = [
        (limits.smallest_corner < m.corner && m.corner < limits.largest_corner, Limit::Corner, m.corner),
        (m.deviation < limits.facet_deviation, Limit::FacetDeviation, m.deviation),
        (m.curvature_length < limits.curvature_length, Limit::CurvatureLength, m.curvature_length),
        (m.valence >= valence, Limit::Valence, m.valence as f64),
    ];
    let (face, at) = (base.mesh.face(h), m.at);
    let violated = checks.into_iter().filter(|(good, ..)| !good);
    violated.map(move |(_, limit, value)| Violation { limit, face, at, value })
}

/// Extremes over a whole base mesh, in the units of [`ValidityLimits`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest angle of a flat face, in degrees.
    pub smallest_angle: f64,
    /// Largest angle of a flat face, in degrees.
    pub largest_angle: f64,
    /// Smallest and largest corner angle in a tangent plane, in degrees.
    pub corners: [f64; 2],
    /// Largest facet deviation, in degrees.
    pub facet_deviation: f64,
    /// Largest curvature in the direction of an edge, times its length.
    pub curvature_length: f64,
    /// Smallest and largest valence.
    pub valences: [usize; 2],
}

/// Measures the extremes.
pub fn quality(base: &BaseMesh) -> Quality {
    let mut q = Quality {
        smallest_angle: f64::INFINITY,
        largest_angle: 0.0,
        corners: [f64::INFINITY, f64::NEG_INFINITY],
        facet_deviation: 0.0,
        curvature_length: 0.0,
        valences: [usize::MAX, 0],
    };
    for h in base.mesh.half_edges() {
        let m = corner_measures(base, h);
        q.corners = [q.corners[0].min(m.corner), q.corners[1].max(m.corner)];
        q.facet_deviation = q.facet_deviation.max(m.deviation);
        q.curvature_length = q.curvature_length.max(m.curvature_length);
        q.valences = [q.valences[0].min(m.valence), q.valences[1].max(m.valence)];
        let mesh = &base.mesh;
        let [p, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|e| base.positions[mesh.origin(e).index()]);
        q.smallest_angle = q.smallest_angle.min(angle_between(&(a - p), &(b - p)).to_degrees());
        q.largest_angle = q.largest_angle.max(largest_angle_cosine([p, a, b]).acos().to_degrees());
    }
    q
}
