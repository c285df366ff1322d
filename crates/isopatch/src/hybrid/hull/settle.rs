//! Other heights and directions of apexes, polygon by polygon, where wedges between cells are out of order.

use super::place::{Placed, mean_normal};
use super::wedge;
use crate::geom::Vec3;
use crate::hull::{Class, Side};
use crate::hybrid::{Element, HermitePolygons};
use crate::mesh::{EdgeId, FaceId};

/// Heights above the tangent planes that are tried, as parts of the diameter.
const HEIGHTS: [f64; 9] = [0.02, 0.05, 0.1, 0.15, 0.25, 0.4, 0.7, 1.2, 2.0];

/// Rounds over the polygons beside wedges that are out of order. What can be mended is after three.
const SWEEPS: usize = 6;

/// A change has to save this much to be made, so that rounding decides nothing.
const SAVING: f64 = 1e-9;

/// Moves apexes while that puts wedges in order.
pub(super) fn settle(data: &HermitePolygons, faces: &mut [Placed]) {
    for _ in 0..SWEEPS {
        let bad: Vec<FaceId> =
            data.mesh().faces().filter(|f| cost(data, faces, *f, &faces[f.index()]) > 0.0).collect();
        let mut better = false;
        for f in bad {
            better |= improve(data, faces, f);
        }
        if !better {
            return;
        }
    }
}

/// What the wedges at a polygon cost, were it like this.
fn cost(data: &HermitePolygons, faces: &[Placed], f: FaceId, placed: &Placed) -> f64 {
    let mesh = data.mesh();
    let at = |e: EdgeId| {
        let Some(pair) = data.joint(e) else { return 0.0 };
        let both = pair.map(|h| mesh.face(h)).map(|g| if g == f { placed } else { &faces[g.index()] });
        let cells = Side::BOTH.into_iter().filter_map(|side| wedge::between(data, e, both, side));
        cells.map(|cell| wedge::cost(&cell)).sum()
    };
    mesh.face_half_edges(f).map(|h| at(mesh.edge(h))).sum()
}

/// Tries all heights on every line.
fn improve(data: &HermitePolygons, faces: &mut [Placed], f: FaceId) -> bool {
    let frame = data.frame(f);
    let now = faces[f.index()].clone();
    if now.element.is_none() {
        return false;
    }
    let mut best = (cost(data, faces, f, &now), now.clone());
    let mean = mean_normal(&frame);
    let between = |a: Vec3, b: Vec3| (a + b).try_normalize(0.0).unwrap_or(a);
    let candidates = [now.direction, now.normal, mean, between(mean, now.normal)];
    // A fan keeps its axis.
    let lines = if now.element == Some(Element::Fan) { &candidates[..1] } else { &candidates };
    let others: &[f64] = if now.class == Class::Nonconvex { &HEIGHTS } else { &HEIGHTS[..1] };
    for line in lines {
        for above in HEIGHTS {
            for other in others {
                let above = if now.class == Class::Nonconvex { [above, *other] } else { [above; 2] };
                let Some(moved) = now.raised(&frame, *line, above) else { continue };
                let cost = cost(data, faces, f, &moved);
                if cost < best.0 - SAVING {
                    best = (cost, Placed { fault: None, ..moved });
                }
            }
        }
    }
    let better = best.1.heights != now.heights || best.1.direction != now.direction;
    faces[f.index()] = best.1;
    better
}
