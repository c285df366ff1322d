//! What is wrong with a face, and what stands between the faces at an edge.

use super::class::{Class, Side, bend};
use super::edge::EdgeFrame;
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::problem::Reason;
use super::simplicial_hull::{HullEdge, HullFace, apexes_beside};
use crate::mesh::EdgeId;

/// What is wrong with a face and its apexes.
pub(super) fn face_fault(frame: &FaceFrame, face: &HullFace) -> Option<Reason> {
    if !frame.n.iter().all(|n| n.dot(&frame.normal) > 0.0) {
        return Some(Reason::NoVisibleNormal);
    }
    let low = Side::BOTH.into_iter().any(|side| {
        let apex = face.apexes[side.index()];
        apex.is_some_and(|apex| !frame.layer1(side, &apex).is_copositive())
    });
    low.then_some(Reason::NoApex)
}

/// An edge with its cells, between the apexes of its faces.
pub(super) fn made_edge(data: &HermiteMesh, faces: &[HullFace], e: EdgeId) -> HullEdge {
    let mesh = data.mesh();
    let h = mesh.edge_half_edge(e);
    let [i, j] = [mesh.origin(h), mesh.dest(h)].map(|v| data.positions()[v.index()]);
    let [n_i, n_j] = [h, mesh.next(h)].map(|h| data.gradient(h));
    let class = Class::of_edge(bend(&i, &j, &n_i), bend(&j, &i, &n_j));
    let Some(frame) = edge_frame(data, e) else { return HullEdge { class, cells: [None; 2] } };
    let cells = Side::BOTH.map(|side| {
        let [u_k, u_l] = class.reaches(side).then(|| apexes_beside(data, faces, e, side))??;
        Some(frame.cell(side, &u_k, &u_l))
    });
    HullEdge { class, cells }
}

/// An edge with the faces beside it; none where they do not join smoothly.
pub(super) fn edge_frame(data: &HermiteMesh, e: EdgeId) -> Option<EdgeFrame> {
    let mesh = data.mesh();
    let h = mesh.edge_half_edge(e);
    let [_, g] = data.joint(e)?;
    let [p_i, p_j, p_k, p_l] =
        [mesh.origin(h), mesh.dest(h), mesh.origin(mesh.prev(h)), mesh.origin(mesh.prev(g))]
            .map(|v| data.positions()[v.index()]);
    Some(EdgeFrame { p_i, p_j, p_k, p_l })
}
