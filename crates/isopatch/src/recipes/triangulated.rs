//! A mesh as a file gives it, as an oriented manifold of triangles.

use crate::base::Repair;
use crate::geom::Point3;
use crate::io::read::PolygonMesh;
use crate::mesh::{
    self, EdgeId, FaceId, HalfEdgeMesh, MeshError, MeshFault, MeshRepair, Place, PrepareOptions, Prepared,
    TooManyCorners, Triangles, VertexId, place_names,
};

/// Why a mesh can't be made one. Faces have the numbers of the mesh as it is given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TriangulationError {
    /// The mesh can't be repaired.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// A face has too many corners.
    #[error(transparent)]
    Corners(#[from] TooManyCorners),
    /// The triangles into which polygons were cut are no manifold.
    #[error("its polygons, cut into triangles, are no manifold: {0}")]
    Triangles(#[from] MeshError),
}

/// An oriented manifold of triangles, and what became of the mesh on the way.
pub(super) struct Triangulated {
    pub mesh: HalfEdgeMesh,
    pub positions: Vec<Point3>,
    pub sources: Sources,
    pub repairs: Vec<Repair>,
}

/// Numbers in the mesh as it is given.
#[derive(Clone)]
pub(super) struct Sources {
    /// Of each vertex.
    pub vertex: Vec<u32>,
    /// Of each triangle; those of a polygon have the same.
    pub face: Vec<u32>,
}

impl Triangulated {
    /// Repairs the mesh and cuts its polygons.
    pub fn new(given: &PolygonMesh, options: &PrepareOptions) -> Result<Self, TriangulationError> {
        let Prepared { positions, faces, vertex_source, face_source, repairs, .. } =
            mesh::prepare(&given.positions, &given.faces, options)?;
        let polygons: Vec<Place> =
            (0..faces.len()).filter(|f| faces[*f].len() > 3).map(|f| Place::Face(face_source[f])).collect();
        let in_input =
            |error: TooManyCorners| TooManyCorners { face: face_source[error.face as usize], ..error };
        let Triangles { faces, source } = mesh::triangulate(&positions, &faces).map_err(in_input)?;
        let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces)?;
        let mut repairs: Vec<Repair> = repairs.iter().map(told).collect();
        repairs.extend(word("polygons cut into triangles", &polygons, "patches are over triangles"));
        let face = source.into_iter().map(|f: FaceId| face_source[f.index()]).collect();
        let sources = Sources { vertex: vertex_source, face };
        Ok(Self { mesh, positions, sources, repairs })
    }
}

/// A mesh as its file has it, repaired, before and after some of its polygons are cut.
pub(super) struct Repaired {
    pub positions: Vec<Point3>,
    pub faces: Vec<Vec<u32>>,
    pub sources: Sources,
    pub repairs: Vec<Repair>,
}

impl Repaired {
    /// Repairs the mesh and keeps its polygons.
    pub fn new(given: &PolygonMesh, options: &PrepareOptions) -> Result<Self, TriangulationError> {
        let Prepared { positions, faces, vertex_source, face_source, repairs, .. } =
            mesh::prepare(&given.positions, &given.faces, options)?;
        let repairs = repairs.iter().map(told).collect();
        Ok(Self { positions, faces, sources: Sources { vertex: vertex_source, face: face_source }, repairs })
    }

    /// Cuts some faces into triangles. Those that are triangles stay.
    pub fn cut(&mut self, chosen: &[bool]) -> Result<(), TriangulationError> {
        let mut faces = Vec::with_capacity(self.faces.len());
        let mut sources = Vec::with_capacity(self.faces.len());
        for (f, corners) in std::mem::take(&mut self.faces).into_iter().enumerate() {
            let source = self.sources.face[f];
            let pieces: Vec<Vec<u32>> = if chosen[f] && corners.len() > 3 {
                let named = |error: TooManyCorners| TooManyCorners { face: source, ..error };
                let cut = mesh::triangulate(&self.positions, &[&corners]).map_err(named)?;
                cut.faces.iter().map(|t| t.to_vec()).collect()
            } else {
                vec![corners]
            };
            sources.resize(faces.len() + pieces.len(), source);
            faces.extend(pieces);
        }
        self.faces = faces;
        self.sources.face = sources;
        Ok(())
    }

    /// The connectivity.
    pub fn mesh(&self) -> Result<HalfEdgeMesh, MeshError> {
        HalfEdgeMesh::from_faces(self.positions.len(), &self.faces)
    }
}

fn told(r: &MeshRepair) -> Repair {
    Repair { what: r.what(), place: r.place(), why: r.kind.why().to_owned() }
}

impl Sources {
    /// A vertex.
    pub fn of_vertex(&self, v: VertexId) -> Place {
        Place::Vertex(self.vertex[v.index()])
    }

    /// A face.
    pub fn of_face(&self, f: FaceId) -> Place {
        Place::Face(self.face[f.index()])
    }

    /// The ends of an edge of `mesh`, the smaller number first.
    pub fn ends(&self, mesh: &HalfEdgeMesh, e: EdgeId) -> [u32; 2] {
        let h = mesh.edge_half_edge(e);
        let [a, b] = [mesh.origin(h), mesh.dest(h)].map(|v| self.vertex[v.index()]);
        [a.min(b), a.max(b)]
    }

    /// The edge between two vertices.
    pub fn between(&self, ends: [VertexId; 2]) -> Place {
        let [a, b] = ends.map(|v| self.vertex[v.index()]);
        Place::Edge(a.min(b), a.max(b))
    }

    /// An edge of `mesh`.
    pub fn of_edge(&self, mesh: &HalfEdgeMesh, e: EdgeId) -> Place {
        let [a, b] = self.ends(mesh, e);
        Place::Edge(a, b)
    }
}

/// A line of the report: how many, where, why; none if there are no places.
pub(super) fn word(what: &str, places: &[Place], why: &str) -> Option<Repair> {
    let line = || Repair {
        what: format!("{what}: {}", places.len()),
        place: place_names(places),
        why: why.to_owned(),
    };
    (!places.is_empty()).then(line)
}
