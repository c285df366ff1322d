//! The input: polygons with a gradient at each corner.

use crate::geom::{Aabb, Point3, Vec3};
use crate::hull::{Class, HermiteError, bend};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};

/// A polygon mesh with positions, gradients and creases.
///
/// A gradient belongs to a corner, the origin of a half edge; the corners of a vertex share one unless creases part them.
#[derive(Clone, Debug)]
pub struct HermitePolygons {
    mesh: HalfEdgeMesh,
    positions: Vec<Point3>,
    gradients: Vec<Vec3>,
    /// Middle coefficient of the quadratic gradient along each half edge, as seen from its face.
    middles: Vec<Vec3>,
    sharp: Vec<bool>,
    diagonal: f64,
}

/// The middle Bézier coefficient of the gradient along an edge from p to q: with it the gradient across the edge at its
/// midpoint is the mean of those at its ends (steps 2 and 3 of the paper).
pub fn middle_gradient([p, q]: [&Point3; 2], [at_p, at_q]: [&Vec3; 2]) -> Vec3 {
    let mean = 0.5 * (at_p + at_q);
    let edge = q - p;
    mean - 3.0 * mean.dot(&edge) / edge.norm_squared() * edge
}

impl HermitePolygons {
    /// One gradient a vertex, smooth everywhere.
    pub fn new(mesh: HalfEdgeMesh, positions: Vec<Point3>, gradients: &[Vec3]) -> Result<Self, HermiteError> {
        let wanted = mesh.vertex_count();
        if gradients.len() != wanted {
            return Err(HermiteError::Count { what: "gradients", given: gradients.len(), wanted });
        }
        let of_corners = mesh.half_edges().map(|h| gradients[mesh.origin(h).index()]).collect();
        let sharp = vec![false; mesh.edge_count()];
        Self::with_creases(mesh, positions, of_corners, sharp)
    }

    /// One gradient a corner, at the origin of each half edge, and a crease at every edge tagged in `sharp`.
    ///
    /// Corners of one vertex may have different gradients only with sharp edges between them. A tag on a boundary is ignored.
    pub fn with_creases(
        mesh: HalfEdgeMesh,
        positions: Vec<Point3>,
        gradients: Vec<Vec3>,
        mut sharp: Vec<bool>,
    ) -> Result<Self, HermiteError> {
        for (what, given, wanted) in [
            ("positions", positions.len(), mesh.vertex_count()),
            ("gradients", gradients.len(), mesh.half_edge_count()),
            ("tags", sharp.len(), mesh.edge_count()),
        ] {
            if given != wanted {
                return Err(HermiteError::Count { what, given, wanted });
            }
        }
        let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
        if let Some(vertex) = positions.iter().position(|p| !finite(p)) {
            return Err(HermiteError::Position { vertex: vertex as u32 });
        }
        if let Some(corner) = gradients.iter().position(|g| !finite(g) || g.norm() == 0.0) {
            return Err(HermiteError::Gradient { vertex: mesh.origin(corner.into()).0 });
        }
        for h in mesh.half_edges() {
            let smooth = mesh.twin(h).filter(|_| !sharp[mesh.edge(h).index()]);
            if smooth.is_some_and(|g| gradients[h.index()] != gradients[mesh.next(g).index()]) {
                return Err(HermiteError::Sector { vertex: mesh.origin(h).0 });
            }
            let [p, q] = [mesh.origin(h), mesh.dest(h)].map(|v| positions[v.index()]);
            if p == q {
                return Err(HermiteError::DegenerateFace { face: mesh.face(h).0 });
            }
        }
        for e in mesh.edges() {
            sharp[e.index()] &= mesh.twin(mesh.edge_half_edge(e)).is_some();
        }
        let middles = mesh
            .half_edges()
            .map(|h| {
                let [p, q] = [mesh.origin(h), mesh.dest(h)].map(|v| &positions[v.index()]);
                middle_gradient([p, q], [h, mesh.next(h)].map(|h| &gradients[h.index()]))
            })
            .collect();
        let diagonal = Aabb::around(&positions).diagonal();
        Ok(Self { mesh, positions, gradients, middles, sharp, diagonal })
    }

    /// The connectivity.
    pub fn mesh(&self) -> &HalfEdgeMesh {
        &self.mesh
    }

    /// Position of each vertex.
    pub fn positions(&self) -> &[Point3] {
        &self.positions
    }

    /// Diagonal of the bounding box of the vertices.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Gradient at the corner where a half edge starts.
    pub fn gradient(&self, corner: HalfEdgeId) -> Vec3 {
        self.gradients[corner.index()]
    }

    /// Middle coefficient of the gradient along a half edge, see [`middle_gradient`].
    pub fn middle(&self, h: HalfEdgeId) -> Vec3 {
        self.middles[h.index()]
    }

    /// Moves the middle coefficient of the gradient along an edge, on both sides of it. Its part along the edge is fixed by
    /// the ends of the edge and is left as it is.
    pub fn move_middle(&mut self, e: EdgeId, by: Vec3) {
        let h = self.mesh.edge_half_edge(e);
        let edge = self.position(self.mesh.next(h)) - self.position(h);
        let across = by - by.dot(&edge) / edge.norm_squared() * edge;
        for h in [Some(h), self.mesh.twin(h)].into_iter().flatten() {
            self.middles[h.index()] += across;
        }
    }

    /// Replaces the middle coefficients of all half edges by those that a file has.
    pub(crate) fn set_middles(&mut self, middles: Vec<Vec3>) {
        self.middles = middles;
    }

    /// Where a half edge starts.
    pub fn position(&self, corner: HalfEdgeId) -> Point3 {
        self.positions[self.mesh.origin(corner).index()]
    }

    /// Do two faces meet in this edge without the same tangent planes?
    pub fn is_crease(&self, e: EdgeId) -> bool {
        self.sharp[e.index()]
    }

    /// The two half edges of an edge across which the function is C1; none for a boundary or a crease.
    pub fn joint(&self, e: EdgeId) -> Option<[HalfEdgeId; 2]> {
        if self.is_crease(e) {
            return None;
        }
        let h = self.mesh.edge_half_edge(e);
        self.mesh.twin(h).map(|g| [h, g])
    }

    /// How the surface bends over an edge, by the gradients of the face of its half edge `h`.
    pub fn edge_class(&self, h: HalfEdgeId) -> Class {
        let (i, j) = (h, self.mesh.next(h));
        let at = |a, b| bend(&self.position(a), &self.position(b), &self.gradient(a));
        Class::of_edge(at(i, j), at(j, i))
    }

    /// Corners and gradients of a face.
    pub fn frame(&self, f: FaceId) -> PolygonFrame {
        let corners: Vec<HalfEdgeId> = self.mesh.face_half_edges(f).collect();
        PolygonFrame {
            p: corners.iter().map(|h| self.position(*h)).collect(),
            n: corners.iter().map(|h| self.gradient(*h)).collect(),
            middle: corners.iter().map(|h| self.middle(*h)).collect(),
            forward: corners.iter().map(|h| self.mesh.edge_half_edge(self.mesh.edge(*h)) == *h).collect(),
        }
    }
}

/// Corners, gradients and mid-edge gradients of a polygon: all coefficients with two indices at one of its corners, or one at
/// either end of one of its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonFrame {
    /// Corners, counter-clockwise seen from outside.
    pub p: Vec<Point3>,
    /// Gradients at the corners.
    pub n: Vec<Vec3>,
    /// Middle coefficient of the gradient along edge k, from corner k to corner k + 1.
    pub middle: Vec<Vec3>,
    /// Does edge k run as the edge of the mesh does?
    pub forward: Vec<bool>,
}

impl PolygonFrame {
    /// Number of corners.
    pub fn count(&self) -> usize {
        self.p.len()
    }

    /// The corner after k.
    pub fn after(&self, k: usize) -> usize {
        if k + 1 == self.count() { 0 } else { k + 1 }
    }

    /// The corner before k.
    pub fn before(&self, k: usize) -> usize {
        if k == 0 { self.count() - 1 } else { k - 1 }
    }

    /// F(p_k, p_k, w).
    pub fn at_corner(&self, k: usize, w: &Point3) -> f64 {
        self.n[k].dot(&(w - self.p[k])) / 3.0
    }

    /// F(p_k, p_k, p_(k+1)) and F(p_k, p_(k+1), p_(k+1)) on edge k.
    pub fn along(&self, k: usize) -> [f64; 2] {
        let next = self.after(k);
        [self.at_corner(k, &self.p[next]), self.at_corner(next, &self.p[k])]
    }

    /// F(p_k, p_(k+1), w) of the ends of edge k (step 3). The same bits from both sides of the edge.
    pub fn on_edge(&self, k: usize, w: &Point3) -> f64 {
        let (i, j) = if self.forward[k] { (k, self.after(k)) } else { (self.after(k), k) };
        self.at_corner(i, &self.p[j]) + self.middle[k].dot(&(w - self.p[i])) / 3.0
    }
}
