//! The wedges between the cells of two polygons that share an edge: do apexes and edges stand in their order?

use super::place::Placed;
use crate::geom::Point3;
use crate::hull::{EdgeCell, EdgeFrame, Reason, Side};
use crate::hybrid::HermitePolygons;
use crate::mesh::EdgeId;
use std::f64::consts::PI;

/// A wedge is wanted to open by this many radians at least and at most.
const OPENING: [f64; 2] = [0.03, 0.97 * PI];

/// μ and ν of the far apexes are wanted to be above this. At −1 a free parameter pulls the surface over the edge the wrong way, so
/// that raising it does not lead to a single sheet.
const REACH: f64 = -0.6;

/// What one wedge that is out of order costs at least; how far it is out of order is added, up to the same.
const OUT_OF_ORDER: f64 = 1.0;

/// The cell over an edge on a side, with the centres of the polygons as third points; none where one of them has no apex.
pub(super) fn cell(data: &HermitePolygons, faces: &[Placed], e: EdgeId, side: Side) -> Option<EdgeCell> {
    let [h, g] = data.joint(e)?;
    let [left, right] = [h, g].map(|h| &faces[data.mesh().face(h).index()]);
    between(data, e, [left, right], side)
}

/// The same of two polygons in the making.
pub(super) fn between(
    data: &HermitePolygons,
    e: EdgeId,
    [left, right]: [&Placed; 2],
    side: Side,
) -> Option<EdgeCell> {
    let h = data.mesh().edge_half_edge(e);
    let apex = |face: &Placed| -> Option<Point3> { face.apexes()[side.index()] };
    let (u_k, u_l) = (apex(left)?, apex(right)?);
    let frame = EdgeFrame {
        p_i: data.position(h),
        p_j: data.position(data.mesh().next(h)),
        p_k: left.center,
        p_l: right.center,
    };
    Some(frame.cell(side, &u_k, &u_l))
}

/// 0 if a wedge is as wanted; more the worse it is.
pub(super) fn cost(cell: &EdgeCell) -> f64 {
    let [least, most] = OPENING;
    let excess = |x: f64| if x > 0.0 { OUT_OF_ORDER + x.min(1.0) } else { 0.0 };
    let reach = cell.reach();
    if !reach.iter().all(|r| r.is_finite()) {
        return 4.0 * OUT_OF_ORDER;
    }
    let low: f64 = reach.iter().map(|r| excess(REACH - r)).sum();
    excess(least - cell.angle) + excess(cell.angle - most) + low
}

/// What is wrong with a wedge, where nothing else made it better.
pub(super) fn fault(cell: &EdgeCell) -> Option<Reason> {
    if cell.angle <= 0.0 {
        return Some(Reason::ApexOverlap);
    }
    (cell.angle >= PI || !cell.reach().iter().all(|r| r.is_finite())).then_some(Reason::FlatEdgeCell)
}
