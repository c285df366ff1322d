use crate::geom::{Aabb, Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, VertexId, creases};

/// A triangle mesh with positions and gradients: what an A-patch function interpolates.
///
/// A gradient has a length: where the mesh samples f = 0, that of ∇f makes the method exact for quadrics, while unit
/// normals do so for spheres and cylinders only. Gradients belong to corners, so that a vertex on a crease can have
/// several.
#[derive(Clone, Debug)]
pub struct HermiteMesh {
    mesh: HalfEdgeMesh,
    positions: Vec<Point3>,
    /// Gradient at the origin of each half edge.
    gradients: Vec<Vec3>,
    /// Per edge: may the surface have a crease there?
    sharp: Vec<bool>,
    diagonal: f64,
}

/// Why a mesh can't be interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HermiteError {
    /// A face has other than three corners.
    #[error("face {face} is no triangle")]
    NotATriangle {
        /// The face.
        face: u32,
    },
    /// A face has no area, or one that is lost in rounding.
    #[error("face {face} has no area")]
    DegenerateFace {
        /// The face.
        face: u32,
    },
    /// A position is infinite or not a number.
    #[error("the position of vertex {vertex} is not finite")]
    Position {
        /// The vertex.
        vertex: u32,
    },
    /// A gradient is zero, infinite or not a number.
    #[error("vertex {vertex} has no normal")]
    Gradient {
        /// The vertex.
        vertex: u32,
    },
    /// Two corners between which there is no sharp edge have different gradients.
    #[error("vertex {vertex} has several gradients where no sharp edge is")]
    Sector {
        /// The vertex.
        vertex: u32,
    },
    /// Another number of positions, gradients or tags than there are vertices, corners or edges.
    #[error("{given} {what} are given where {wanted} are needed")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there have to be.
        wanted: usize,
    },
}

/// Smallest height of a triangle relative to its longest edge: with less, barycentric coordinates of nearby points have
/// no correct digit left.
const FLAT: f64 = 1e-14;

impl HermiteMesh {
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
        corner_gradients: Vec<Vec3>,
        mut sharp: Vec<bool>,
    ) -> Result<Self, HermiteError> {
        for (what, given, wanted) in [
            ("positions", positions.len(), mesh.vertex_count()),
            ("gradients", corner_gradients.len(), mesh.half_edge_count()),
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
        if let Some(corner) = corner_gradients.iter().position(|g| !finite(g) || g.norm() == 0.0) {
            return Err(HermiteError::Gradient { vertex: mesh.origin(corner.into()).0 });
        }
        for f in mesh.faces() {
            if mesh.face_half_edges(f).len() != 3 {
                return Err(HermiteError::NotATriangle { face: f.0 });
            }
            let [a, b, c] = mesh.triangle(f).map(|v| positions[v.index()]);
            let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            if (b - a).cross(&(c - a)).norm() <= FLAT * longest {
                return Err(HermiteError::DegenerateFace { face: f.0 });
            }
        }
        for h in mesh.half_edges() {
            let smooth = mesh.twin(h).filter(|_| !sharp[mesh.edge(h).index()]);
            if smooth.is_some_and(|g| corner_gradients[h.index()] != corner_gradients[mesh.next(g).index()]) {
                return Err(HermiteError::Sector { vertex: mesh.origin(h).0 });
            }
        }
        for e in mesh.edges() {
            sharp[e.index()] &= mesh.twin(mesh.edge_half_edge(e)).is_some();
        }
        let diagonal = Aabb::around(&positions).diagonal();
        Ok(Self { mesh, positions, gradients: corner_gradients, sharp, diagonal })
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

    /// Replaces the gradient at the corner where a half edge starts.
    pub(super) fn set_gradient(&mut self, corner: HalfEdgeId, gradient: Vec3) {
        self.gradients[corner.index()] = gradient;
    }

    /// Positions of the corners of a face.
    pub fn corners(&self, f: FaceId) -> [Point3; 3] {
        self.mesh.triangle(f).map(|v| self.positions[v.index()])
    }

    /// Gradients at the corners of a face.
    pub fn corner_gradients(&self, f: FaceId) -> [Vec3; 3] {
        [0, 1, 2].map(|k| self.gradients[3 * f.index() + k])
    }

    /// Do two faces meet in this edge without the same tangent planes?
    pub fn is_crease(&self, e: EdgeId) -> bool {
        self.sharp[e.index()]
    }

    /// Makes a crease of an edge; a boundary stays what it is.
    pub(super) fn set_crease(&mut self, e: EdgeId) {
        self.sharp[e.index()] = self.mesh.twin(self.mesh.edge_half_edge(e)).is_some();
    }

    /// The two half edges of an edge; none for a boundary.
    pub fn pair(&self, e: EdgeId) -> Option<[HalfEdgeId; 2]> {
        let h = self.mesh.edge_half_edge(e);
        self.mesh.twin(h).map(|g| [h, g])
    }

    /// The corners around a vertex in sectors with one gradient each, see [`creases::sectors`].
    pub fn sectors(&self, v: VertexId) -> Vec<Vec<HalfEdgeId>> {
        creases::sectors(&self.mesh, &self.sharp, v)
    }

    /// The two half edges of an edge across which the function is C1; none for a boundary or a crease.
    pub fn joint(&self, e: EdgeId) -> Option<[HalfEdgeId; 2]> {
        if self.is_crease(e) {
            return None;
        }
        let h = self.mesh.edge_half_edge(e);
        self.mesh.twin(h).map(|g| [h, g])
    }
}
