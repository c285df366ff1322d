//! Other heights and directions of apexes, polygon by polygon, where wedges between cells are out of order.

use super::place::{Placed, mean_normal};
use super::wedge;
use crate::geom::Vec3;
use crate::hull::Side;
use crate::hybrid::{Element, HermitePolygons, PolygonFrame, Quadric};
use crate::mesh::{EdgeId, FaceId};

/// Heights above the tangent planes that are tried, as parts of the diameter; of equally good ones the first.
const HEIGHTS: [f64; 9] = [0.15, 0.25, 0.1, 0.4, 0.05, 0.7, 0.02, 1.2, 2.0];

/// Rounds over the polygons beside wedges that are out of order. What can be mended is after three.
const SWEEPS: usize = 6;

/// A change has to save this much to be made, so that rounding decides nothing.
const SAVING: f64 = 1e-9;

/// Slopes by which a line is leaned away from an edge, or towards it.
const LEANS: [f64; 6] = [0.3, 0.6, 1.0, -0.3, -0.6, -1.0];

/// What the function will be near: the data, and a quadric for every face.
pub(super) struct Near<'a> {
    pub data: &'a HermitePolygons,
    pub quadrics: &'a [Quadric],
}

impl Near<'_> {
    /// Does the line between the apexes on both sides of an edge dip through the surface, as the quadrics of the two faces have it?
    /// Then rays of the cell over the edge end inside. A cost as of [`wedge::cost`].
    fn dip(&self, e: EdgeId, both: [&Placed; 2], numbers: [FaceId; 2], side: Side) -> f64 {
        if !self.data.edge_class(self.data.mesh().edge_half_edge(e)).reaches(side) {
            return 0.0;
        }
        let apexes = both.map(|face| face.apexes()[side.index()]);
        let [Some(a), Some(b)] = apexes else { return 0.0 };
        let of = |f: FaceId| {
            let q = &self.quadrics[f.index()];
            let ends = (q.value(&a).abs() + q.value(&b).abs()).max(f64::MIN_POSITIVE);
            let at = |y: f64| side.sign() * q.value(&(y * a + (1.0 - y) * b)) / ends;
            let lowest = DIPS.into_iter().map(at).fold(f64::INFINITY, f64::min);
            if lowest < LEAST_VALUE { 1.0 + (LEAST_VALUE - lowest).min(1.0) } else { 0.0 }
        };
        0.5 * numbers.into_iter().map(of).sum::<f64>()
    }
}

/// Places between two apexes that are looked at.
const DIPS: [f64; 3] = [0.25, 0.5, 0.75];

/// There the function is wanted to be this part of what it is at both apexes.
const LEAST_VALUE: f64 = 0.02;

/// Moves apexes while that puts wedges in order.
pub(super) fn settle(near: &Near<'_>, faces: &mut [Placed]) {
    for _ in 0..SWEEPS {
        let is_bad = |f: &FaceId| total(near, faces, *f, &faces[f.index()]) > 0.0;
        let bad: Vec<FaceId> = near.data.mesh().faces().filter(is_bad).collect();
        let mut better = false;
        for f in bad {
            better |= improve(near, faces, f);
        }
        if !better {
            return;
        }
    }
}

/// What the wedges at a polygon cost on a side, were it like this.
fn cost(near: &Near<'_>, faces: &[Placed], f: FaceId, placed: &Placed, side: Side) -> f64 {
    let mesh = near.data.mesh();
    let at = |e: EdgeId| {
        let Some(pair) = near.data.joint(e) else { return 0.0 };
        let numbers = pair.map(|h| mesh.face(h));
        let both = numbers.map(|g| if g == f { placed } else { &faces[g.index()] });
        let Some(cell) = wedge::between(near.data, e, both, side) else { return 0.0 };
        wedge::cost(&cell) + near.dip(e, both, numbers, side)
    };
    mesh.face_half_edges(f).map(|h| at(mesh.edge(h))).sum()
}

fn total(near: &Near<'_>, faces: &[Placed], f: FaceId, placed: &Placed) -> f64 {
    Side::BOTH.into_iter().map(|side| cost(near, faces, f, placed, side)).sum()
}

/// Tries lines, and on every line all heights, on both sides on their own.
fn improve(near: &Near<'_>, faces: &mut [Placed], f: FaceId) -> bool {
    let frame = near.data.frame(f);
    let now = faces[f.index()].clone();
    if now.element.is_none() {
        return false;
    }
    let before = total(near, faces, f, &now);
    let mut best = (before, now.clone());
    for line in lines(&frame, &now) {
        let mut moved = now.clone();
        let mut sum = 0.0;
        for side in Side::BOTH.into_iter().filter(|side| now.reaches(*side)) {
            let at = |above: f64| now.raised(&frame, line, [above; 2]);
            let costs = HEIGHTS.into_iter().filter_map(at).map(|p| (cost(near, faces, f, &p, side), p));
            let least = costs.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((cost, found)) = least else {
                sum = f64::INFINITY;
                break;
            };
            sum += cost;
            moved.direction = line;
            moved.heights[side.index()] = found.heights[side.index()];
        }
        if sum < best.0 - SAVING {
            best = (sum, Placed { fault: None, ..moved });
        }
    }
    let better = best.0 < before;
    faces[f.index()] = best.1;
    better
}

/// Directions of lines for apexes. A fan keeps its axis.
fn lines(frame: &PolygonFrame, now: &Placed) -> Vec<Vec3> {
    if now.element == Some(Element::Fan) {
        return vec![now.direction];
    }
    let mean = mean_normal(frame);
    let between = (mean + now.normal).try_normalize(0.0).unwrap_or(mean);
    let upright = [now.direction, now.normal, mean, between];
    let leaning = (0..frame.count()).flat_map(|k| {
        let edge = frame.p[frame.after(k)] - frame.p[k];
        let inward = now.normal.cross(&edge).normalize();
        LEANS.into_iter().map(move |slope| (now.normal + slope * inward).normalize())
    });
    upright.into_iter().chain(leaning).collect()
}
