//! What the surface does at the vertices of its base mesh, from the control nets.

use super::or_infinite;
use super::samples::net;
use crate::base::{BaseMesh, EdgeFeature};
use crate::bernstein::index;
use crate::geom::normal_jump;
use crate::geom::{Mat3, Vec3};
use crate::mesh::{FaceId, VertexId};
use crate::surface::{PatchId, Surface};

/// Largest differences between the patch corners and the data of the base mesh; normals and curvatures not at sharp edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interpolation {
    /// Between patch corner and vertex, relative to the diagonal.
    pub max_position_error: f64,
    /// Between the normal of the patch corner and that of the vertex, in radians; π where one vanishes.
    pub max_normal_error: f64,
    /// Between the normal curvature of a boundary curve and tᵀ M t, over max(|tᵀ M t|, 1/diagonal).
    pub max_curvature_error: f64,
    /// Between the mixed term of the second fundamental form of the patch corner, for unit tangents s and t of its
    /// two edges, and sᵀ M t, over max(|M|, 1/diagonal).
    pub max_mixed_curvature_error: f64,
    /// Vertex of the largest normal curvature error.
    pub worst_curvature: Option<VertexId>,
}

/// Compares corner k of every patch with the vertex at corner k of the face of the same number.
pub fn interpolation(base: &BaseMesh, surface: &dyn Surface, diagonal: f64) -> Interpolation {
    let mut result = Interpolation::default();
    let sharp = sharp_vertices(base);
    for patch in surface.patches() {
        for (k, v) in base.mesh.triangle(FaceId(patch.0)).into_iter().enumerate() {
            let corner = Corner::new(surface, patch, k);
            let (n, m) = (base.normals[v.index()], base.curvatures[v.index()]);
            let position = or_infinite((corner.point - base.positions[v.index()]).norm() / diagonal);
            result.max_position_error = result.max_position_error.max(position);
            if sharp[v.index()] {
                continue;
            }
            let normal = normal_jump(&corner.along.cross(&corner.back), &n);
            result.max_normal_error = result.max_normal_error.max(normal);
            let mixed = corner.mixed_curvature_error(&n, &m, diagonal);
            result.max_mixed_curvature_error = result.max_mixed_curvature_error.max(mixed);
            let curvature = corner.curvature_error(&n, &m, diagonal);
            if curvature > result.max_curvature_error {
                (result.max_curvature_error, result.worst_curvature) = (curvature, Some(v));
            }
        }
    }
    result
}

/// Vertices at sharp edges: the surface has several normals there, the base mesh one.
fn sharp_vertices(base: &BaseMesh) -> Vec<bool> {
    let mut sharp = vec![false; base.mesh.vertex_count()];
    for e in base.mesh.edges().filter(|e| base.features[e.index()] == EdgeFeature::Sharp) {
        let h = base.mesh.edge_half_edge(e);
        [base.mesh.origin(h), base.mesh.dest(h)].iter().for_each(|v| sharp[v.index()] = true);
    }
    sharp
}

/// A net of degree 1 that is nowhere: for patches without a net, whose figures come out as infinite.
static NO_NET: [Vec3; 3] = [Vec3::new(f64::NAN, f64::NAN, f64::NAN); 3];

/// Offsets of the control points around a corner of a Bézier triangle of degree n.
struct Corner {
    degree: f64,
    point: Vec3,
    /// First differences along the two edges: counter-clockwise from the corner, and back along the previous edge.
    along: Vec3,
    back: Vec3,
    /// Second differences along these edges.
    along2: Vec3,
    back2: Vec3,
    /// Mixed second difference.
    mixed: Vec3,
}

impl Corner {
    fn new(surface: &dyn Surface, patch: PatchId, k: usize) -> Self {
        let (n, net) = net(surface, patch).unwrap_or((1, &NO_NET));
        let o = net[index::row(n, k, 0, 0)];
        let offset = |depth, m| net[index::row(n, k, depth, m)] - o;
        let (along, back) = (offset(0, 1), offset(1, 0));
        // A triangle of degree 1 is flat: its second differences vanish.
        let second = |depth, m, first: Vec3| if n < 2 { Vec3::zeros() } else { offset(depth, m) - first };
        Self {
            degree: n as f64,
            point: o,
            along,
            back,
            along2: second(0, 2, 2.0 * along),
            back2: second(2, 0, 2.0 * back),
            mixed: second(1, 1, along + back),
        }
    }

    /// II(s, t) = n (n − 1) Δ²·N / (n² |Δs| |Δt|) for a second difference Δ² and first differences Δs, Δt: eq. (8)
    /// of Tong & Kim 2009, there for a quartic curve.
    fn second_form(&self, difference: &Vec3, normal: &Vec3, s: &Vec3, t: &Vec3) -> f64 {
        (self.degree - 1.0) / self.degree * difference.dot(normal) / (s.norm() * t.norm())
    }

    fn curvature_error(&self, normal: &Vec3, m: &Mat3, diagonal: f64) -> f64 {
        let of_curve = |second: &Vec3, first: &Vec3| {
            let t = first.normalize();
            let exact = t.dot(&(m * t));
            let k = self.second_form(second, normal, first, first);
            or_infinite((k - exact).abs() / exact.abs().max(1.0 / diagonal))
        };
        of_curve(&self.along2, &self.along).max(of_curve(&self.back2, &self.back))
    }

    fn mixed_curvature_error(&self, normal: &Vec3, m: &Mat3, diagonal: f64) -> f64 {
        let (s, t) = (self.along.normalize(), self.back.normalize());
        let mixed = self.second_form(&self.mixed, normal, &self.along, &self.back);
        or_infinite((mixed - s.dot(&(m * t))).abs() / m.norm().max(1.0 / diagonal))
    }
}
