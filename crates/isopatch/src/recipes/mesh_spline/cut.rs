//! A mesh cut open along its sharp edges, so that every vertex has one tangent plane.

use crate::geom::Point3;
use crate::mesh::{HalfEdgeMesh, MeshError, VertexId, creases};

/// The pieces, with the faces and half edges of the whole in their order.
pub struct Cut {
    /// Connectivity; sharp edges are boundaries of it.
    pub mesh: HalfEdgeMesh,
    /// Position of each vertex.
    pub positions: Vec<Point3>,
    /// The vertex of the whole that each vertex is, or is a copy of.
    pub source: Vec<VertexId>,
}

/// Gives every sector between sharp edges its own copy of their vertex.
///
/// A sharp edge both of whose ends lie inside one sector stays joined.
pub fn cut(mesh: &HalfEdgeMesh, positions: &[Point3], sharp: &[bool]) -> Result<Cut, MeshError> {
    let mut source: Vec<VertexId> = mesh.vertices().collect();
    let mut corner: Vec<u32> = mesh.half_edges().map(|h| mesh.origin(h).0).collect();
    for v in mesh.vertices() {
        for sector in creases::sectors(mesh, sharp, v).into_iter().skip(1) {
            sector.iter().for_each(|h| corner[h.index()] = source.len() as u32);
            source.push(v);
        }
    }
    let faces: Vec<[u32; 3]> = corner.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    let mesh = HalfEdgeMesh::from_faces(source.len(), &faces)?;
    let positions = source.iter().map(|v| positions[v.index()]).collect();
    Ok(Cut { mesh, positions, source })
}
