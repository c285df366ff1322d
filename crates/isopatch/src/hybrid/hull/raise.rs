//! Other heights of apexes in a finished hull.

use super::wedge;
use crate::hull::{EdgeFrame, Side};
use crate::hybrid::HybridHull;
use crate::mesh::{EdgeId, FaceId};

/// The same hull with the apexes over some faces `factor` times as far from them, with the default parameters there. A face whose
/// cells would overlap with those over its edges stays as it is.
pub fn raised(hull: &HybridHull, faces: &[FaceId], factor: f64) -> HybridHull {
    let mut changed = hull.clone();
    for f in faces {
        let before = changed.faces[f.index()].clone();
        let face = &mut changed.faces[f.index()];
        let center = face.center;
        face.apexes.iter_mut().flatten().for_each(|apex| *apex = center + factor * (*apex - center));
        face.at_apex = [None; 2];
        let mesh = changed.data.mesh();
        if mesh.face_half_edges(*f).any(|h| overlaps(&changed, mesh.edge(h))) {
            changed.faces[f.index()] = before;
        }
    }
    changed
}

/// Is the cell over an edge out of order on a side that the surface reaches?
fn overlaps(hull: &HybridHull, e: EdgeId) -> bool {
    let Some([h, g]) = hull.data.joint(e) else { return false };
    let mesh = hull.data.mesh();
    let [left, right] = [h, g].map(|h| &hull.faces[mesh.face(h).index()]);
    let frame = EdgeFrame {
        p_i: hull.data.position(h),
        p_j: hull.data.position(g),
        p_k: left.center,
        p_l: right.center,
    };
    let is_bad = |side: Side| {
        let (Some(u_k), Some(u_l)) = (left.apexes[side.index()], right.apexes[side.index()]) else {
            return false;
        };
        wedge::fault(&frame.cell(side, &u_k, &u_l)).is_some()
    };
    Side::BOTH.into_iter().filter(|side| hull.edges[e.index()].class.reaches(*side)).any(is_bad)
}
