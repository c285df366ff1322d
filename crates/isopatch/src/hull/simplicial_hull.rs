//! A finished hull: its faces and edges with their cells, and what does not fit.

use super::check::edge_frame;
use super::class::{Class, Side};
use super::crease;
use super::edge::EdgeCell;
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::options::HullOptions;
use super::problem::{Problem, Reason};
use super::refine::Refinement;
use super::relief::Reliefs;
use super::shear;
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, VertexId};

/// A face of the hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace {
    /// How the surface bends over it.
    pub class: Class,
    /// Unit direction of the line through the centroid on which its apexes are.
    pub direction: Vec3,
    /// Heights of the outer and the inner apex over the centroid, whether the side has a cell or not.
    pub heights: [f64; 2],
    /// The apexes of its cells: u on the outer side, v on the inner side.
    pub apexes: [Option<Point3>; 2],
}

/// An edge of the hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullEdge {
    /// How the surface bends over it; seen from the left face if it is a crease.
    pub class: Class,
    /// Its cells on the outer and the inner side; a boundary or a crease has none.
    pub cells: [Option<EdgeCell>; 2],
}

/// The simplicial hull of a mesh.
#[derive(Clone, Debug)]
pub struct Hull {
    pub(super) data: HermiteMesh,
    pub(super) faces: Vec<HullFace>,
    pub(super) edges: Vec<HullEdge>,
    pub(super) problems: Vec<Problem>,
    pub(super) moved_normals: Vec<VertexId>,
    pub(super) corners: Vec<Corner>,
    pub(super) added_creases: Vec<AddedCrease>,
    pub(super) options: HullOptions,
    pub(super) reliefs: Reliefs,
    pub(super) refinement: Refinement,
}

/// A vertex that was given several normals, because no single one would do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// The vertex.
    pub vertex: VertexId,
    /// Why: no vector sees all faces around it ([`Reason::NoVisibleNormal`]), or one does, but with it no valid hull was found.
    pub reason: Reason,
}

/// An edge that was made a crease, because the surface cannot be smooth across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddedCrease {
    /// The edge.
    pub edge: EdgeId,
    /// Why: what was wrong there, or at one of its ends.
    pub reason: Reason,
}

/// A hull taken apart, as files have it.
#[derive(Clone, Debug)]
pub struct HullParts {
    /// See [`Hull::data`].
    pub data: HermiteMesh,
    /// See [`Hull::faces`].
    pub faces: Vec<HullFace>,
    /// See [`Hull::edges`].
    pub edges: Vec<HullEdge>,
    /// See [`Hull::problems`].
    pub problems: Vec<Problem>,
    /// See [`Hull::moved_normals`].
    pub moved_normals: Vec<VertexId>,
    /// See [`Hull::corners`].
    pub corners: Vec<Corner>,
    /// See [`Hull::added_creases`].
    pub added_creases: Vec<AddedCrease>,
}

impl From<HullParts> for Hull {
    /// The hull of parts that belong together: one face and one edge for each of the mesh. Should it be changed, the default
    /// options hold.
    fn from(parts: HullParts) -> Self {
        let HullParts { data, faces, edges, problems, moved_normals, corners, added_creases } = parts;
        let (options, reliefs) = (HullOptions::default(), Reliefs::default());
        let refinement = Refinement::default();
        Self {
            data,
            faces,
            edges,
            problems,
            moved_normals,
            corners,
            added_creases,
            options,
            reliefs,
            refinement,
        }
    }
}

impl Hull {
    /// What is interpolated. Its gradients are those given, but for [`Hull::moved_normals`].
    pub fn data(&self) -> &HermiteMesh {
        &self.data
    }

    /// The faces, in the order of the mesh.
    pub fn faces(&self) -> &[HullFace] {
        &self.faces
    }

    /// The edges, in the order of the mesh; the left face of an edge is that of its half edge.
    pub fn edges(&self) -> &[HullEdge] {
        &self.edges
    }

    /// Every element that is not valid: vertices, then faces, then edges, in order.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Vertices whose gradient was turned so that it sees the faces around it.
    pub fn moved_normals(&self) -> &[VertexId] {
        &self.moved_normals
    }

    /// Vertices that were given several normals so that no problem remains, in order. Those of tagged creases are not among them.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Edges that were made creases so that no problem remains, in order: those of the corners, and single ones.
    pub fn added_creases(&self) -> &[AddedCrease] {
        &self.added_creases
    }

    /// Vertices of the given mesh around which it was refined, in order: corners of faces there were cut off, in their planes and
    /// with straight edges, so that no vertex sees its faces otherwise, because no smooth hull was found without.
    ///
    /// The vertices that were given come first and keep their numbers, and so do the faces, of which one piece each does.
    pub fn refined_vertices(&self) -> &[VertexId] {
        &self.refinement.vertices
    }

    /// Vertices of the given mesh that were rounded, in order: faces around them were cut, and the new vertices put off the mesh so that
    /// all see their faces well, because no smooth hull was found without.
    ///
    /// Numbers are as for [`Hull::refined_vertices`].
    pub fn rounded_vertices(&self) -> &[VertexId] {
        &self.refinement.rounded
    }

    /// Largest distance of a new vertex around rounded ones from the edge of the given mesh on which it was cut.
    pub fn rounded_distance(&self) -> f64 {
        self.refinement.farthest
    }

    /// The face of the given mesh in which a face lies.
    pub fn source_face(&self, f: FaceId) -> FaceId {
        self.refinement.face(f)
    }

    /// The vertices of the given mesh between which a vertex lies: the ends of an edge, or the same vertex twice, itself or, inside
    /// a face, one of it.
    pub fn source_vertices(&self, v: VertexId) -> [VertexId; 2] {
        self.refinement.vertex(v)
    }

    /// The ends of the edge of the given mesh on which an edge lies; a vertex nearby twice if it lies on none.
    pub fn source_edge(&self, e: EdgeId) -> [VertexId; 2] {
        let mesh = self.data.mesh();
        let h = mesh.edge_half_edge(e);
        self.refinement.edge_of([mesh.origin(h), mesh.dest(h)])
    }

    /// How many faces refinement and rounding added.
    pub fn added_faces(&self) -> usize {
        self.refinement.added_faces()
    }

    /// Faces that have a problem themselves or at one of their edges, in order.
    pub fn bad_faces(&self) -> Vec<FaceId> {
        let mut faces: Vec<FaceId> = self
            .problems
            .iter()
            .flat_map(|problem| match problem {
                Problem::Vertex { .. } => [None, None],
                Problem::Face { face, .. } => [Some(*face), None],
                Problem::Edge { faces, .. } => faces.map(Some),
            })
            .flatten()
            .collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// May the patch over a face turn over? If so it has to be looked at.
    pub fn is_delicate(&self, f: FaceId) -> bool {
        let mesh = self.data.mesh();
        let leans = |e| crease::fault(&self.data, e, &crease::HARMLESS).is_some();
        shear::corners_fold(&self.face_frame(f), &self.faces[f.index()])
            || mesh.face_half_edges(f).map(|h| mesh.edge(h)).any(|e| self.data.is_crease(e) && leans(e))
    }

    /// May the patch over an edge turn over?
    pub fn is_delicate_edge(&self, e: EdgeId) -> bool {
        shear::crossing_folds(&self.data, &self.faces, e, self.edges[e.index()].class, HARMLESS_SHEAR)
    }

    /// Corners and gradients of a face.
    pub fn face_frame(&self, f: FaceId) -> FaceFrame {
        frame(&self.data, f)
    }

    /// The same hull with barycentric coordinates that keep their digits in thin cells, as a function on it needs them. The
    /// search for a hull has no use for them.
    pub fn sharpened(mut self) -> Self {
        for e in 0..self.edges.len() {
            let Some(frame) = edge_frame(&self.data, e.into()) else { continue };
            for side in Side::BOTH {
                let apexes = self.edge_apexes(e.into(), side);
                if let (Some(cell), Some([u_k, u_l])) = (&mut self.edges[e].cells[side.index()], apexes) {
                    *cell = frame.sharpened(cell, &u_k, &u_l);
                }
            }
        }
        self
    }

    /// Apexes of the left and the right face of an edge on a side, where it has a cell.
    pub fn edge_apexes(&self, e: EdgeId, side: Side) -> Option<[Point3; 2]> {
        apexes_beside(&self.data, &self.faces, e, side)
    }
}

/// Sines of the angles in patches that go through their edge above which these do not turn over.
const HARMLESS_SHEAR: f64 = 0.6;

pub(super) fn frame(data: &HermiteMesh, f: FaceId) -> FaceFrame {
    FaceFrame::new(data.corners(f), data.corner_gradients(f))
}

pub(super) fn apexes_beside(
    data: &HermiteMesh,
    faces: &[HullFace],
    e: EdgeId,
    side: Side,
) -> Option<[Point3; 2]> {
    let [h, g] = data.joint(e)?.map(|h| faces[data.mesh().face(h).index()].apexes[side.index()]);
    Some([h?, g?])
}
