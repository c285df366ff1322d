//! Edges that become sharp because a smooth surface across them would fold.

use crate::geom::{Point3, angle_between};
use crate::mesh::{EdgeId, FaceId, HalfEdgeMesh, VertexId, normals};

/// Edges at a vertex become sharp together whose faces turn by more than this share of the largest turn there.
const SHARE: f64 = 0.7;
/// Edges whose faces turn by less (20°) become sharp only if no other will do.
const LEAST_TURN: f64 = 0.35;

/// Where the surface is not smooth.
#[derive(Clone, Debug, PartialEq)]
pub struct Sharpness {
    /// Of the edges: are they sharp?
    pub edges: Vec<bool>,
    /// Of the vertices: do sharp edges leave them along their chords?
    pub corners: Vec<bool>,
}

impl Sharpness {
    /// Makes edges sharp around folded faces and at the ends of edges without a curve. False if nothing is left to sharpen.
    ///
    /// First the edges around them that turn most; where there are none that turn, all edges of the faces; and where these
    /// are sharp already, the corners of the faces become corners. A face between straight edges is flat.
    pub fn sharpen(
        &mut self,
        mesh: &HalfEdgeMesh,
        positions: &[Point3],
        folded: &[FaceId],
        failed: &[EdgeId],
    ) -> bool {
        let before = self.clone();
        let corners = folded.iter().flat_map(|f| mesh.triangle(*f));
        let ends = failed.iter().flat_map(|e| ends(mesh, *e));
        let vertices: Vec<VertexId> = corners.chain(ends).collect();
        let turned = self.turned_edges(mesh, positions, &vertices);
        if !turned.is_empty() {
            turned.into_iter().for_each(|e| self.edges[e.index()] = true);
            return true;
        }
        let beside = failed.iter().flat_map(|e| {
            let h = mesh.edge_half_edge(*e);
            [Some(h), mesh.twin(h)].into_iter().flatten().map(|h| mesh.face(h))
        });
        for f in folded.iter().copied().chain(beside) {
            let inner: Vec<EdgeId> =
                mesh.face_half_edges(f).filter(|h| mesh.twin(*h).is_some()).map(|h| mesh.edge(h)).collect();
            if inner.iter().all(|e| before.edges[e.index()]) {
                mesh.triangle(f).iter().for_each(|v| self.corners[v.index()] = true);
            }
            inner.iter().for_each(|e| self.edges[e.index()] = true);
        }
        *self != before
    }

    /// The smooth edges at some vertices whose faces turn most there.
    fn turned_edges(&self, mesh: &HalfEdgeMesh, positions: &[Point3], vertices: &[VertexId]) -> Vec<EdgeId> {
        let turn = |e: EdgeId| {
            let h = mesh.edge_half_edge(e);
            let [n, m] = [h, mesh.twin(h)?].map(|h| normals::of_face(mesh, positions, mesh.face(h)));
            Some((angle_between(&n, &m), e))
        };
        let at_vertex = |v: &VertexId| {
            let smooth = mesh.ring(*v).map(|h| mesh.edge(h)).filter(|e| !self.edges[e.index()]);
            let turns: Vec<(f64, EdgeId)> = smooth.filter_map(turn).collect();
            let least = turns.iter().map(|(t, _)| SHARE * t).fold(LEAST_TURN, f64::max);
            turns.into_iter().filter(move |(t, _)| *t >= least).map(|(_, e)| e)
        };
        vertices.iter().flat_map(at_vertex).collect()
    }
}

fn ends(mesh: &HalfEdgeMesh, e: EdgeId) -> [VertexId; 2] {
    let h = mesh.edge_half_edge(e);
    [mesh.origin(h), mesh.dest(h)]
}
