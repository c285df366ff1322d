//! Curves over sharp edges and boundaries, where two patches share a curve but no tangent plane, or one patch ends.
//!
//! ```text
//!        \  |  /            A rim passes through a vertex along the direction from the neighbour before to the one
//!     ----• v •----  rim    after, unless it turns there by more than CORNER_TURN, or rims meet: then it leaves
//!        /  |  \            along its chord. The normals of the sectors beside it are across it.
//! ```

use super::cut::Cut;
use crate::geom::{Point3, Vec3, angle_between};
use crate::mesh::{HalfEdgeId, HalfEdgeMesh, VertexId};
use crate::network::QuarticCurve;

/// A rim that turns by more has a corner there (cosine of the angle, 70°): rounds are cut into six sides or more, so that
/// they stay round.
const CORNER_TURN: f64 = 0.342;
/// Two rims of a sector with a smaller sine of the angle between them run on as one (10°).
const COLLINEAR: f64 = 0.17;
/// Below this sine, directions are taken for equal: their cross product has no direction left.
const PARALLEL: f64 = 1e-6;

/// Unit tangents of rims: of the edge of each half edge of the whole mesh, where it starts. None inside.
pub struct Rims {
    tangents: Vec<Option<Vec3>>,
}

impl Rims {
    /// The tangents of all rims: the edges of the whole that are boundaries of the pieces. At `corners` they are along the
    /// chords.
    pub fn new(whole: &HalfEdgeMesh, cut: &Cut, positions: &[Point3], corners: &[bool]) -> Self {
        // Slot 2h is the start of half edge h, slot 2h + 1 its end.
        let mut tangents: Vec<Option<Vec3>> = vec![None; 2 * whole.half_edge_count()];
        for v in whole.vertices() {
            let rims = rims_at(whole, cut, v);
            if rims.is_empty() {
                continue;
            }
            let t = tangents_at(whole, positions, v, &rims, corners[v.index()]);
            for (Rim { half_edge: h, leaves, .. }, t) in rims.iter().zip(t) {
                tangents[2 * h.index() + usize::from(!leaves)] = Some(t);
                if let Some(g) = whole.twin(*h) {
                    tangents[2 * g.index() + usize::from(*leaves)] = Some(t);
                }
            }
        }
        Self { tangents }
    }

    /// Unit tangent out of a vertex along the rim over a half edge, at its start or end.
    fn tangent(&self, h: HalfEdgeId, at_end: bool) -> Option<Vec3> {
        self.tangents[2 * h.index() + usize::from(at_end)]
    }

    /// The normal nearest to the given one that is across the rims on both sides of a vertex of the pieces.
    pub fn across(&self, cut: &Cut, v: VertexId, normal: &Vec3) -> Vec3 {
        if !cut.mesh.is_boundary_vertex(v) {
            return *normal;
        }
        let Some(first) = cut.mesh.ring(v).next() else { return *normal };
        let last = cut.mesh.ring(v).last().unwrap_or(first);
        let (Some(a), Some(b)) = (self.tangent(first, false), self.tangent(cut.mesh.prev(last), true)) else {
            return *normal;
        };
        let both = a.cross(&b);
        if both.norm() > PARALLEL {
            return both.normalize() * both.dot(normal).signum();
        }
        (normal - normal.dot(&a) * a).try_normalize(0.0).unwrap_or(*normal)
    }

    /// The curve over the rim of a half edge: the cubic with its tangents that is as fast as an arc of a circle.
    pub fn curve(&self, whole: &HalfEdgeMesh, positions: &[Point3], h: HalfEdgeId) -> QuarticCurve {
        let (from, to) = (positions[whole.origin(h).index()], positions[whole.dest(h).index()]);
        let chord = to - from;
        let t0 = self.tangent(h, false).unwrap_or(chord);
        let t1 = -self.tangent(h, true).unwrap_or(-chord);
        let angle = 0.5 * (angle_between(&t0, &chord) + angle_between(&t1, &chord));
        let arc = chord.norm() * if angle > 0.0 { angle / angle.sin() } else { 1.0 };
        let (c1, c2) = (from + arc / 3.0 * t0, to - arc / 3.0 * t1);
        QuarticCurve {
            q: [from, from + arc / 4.0 * t0, 0.5 * (c1 + c2), to - arc / 4.0 * t1, to],
            steps: 0,
            sqp_failed: false,
            at_bound: false,
        }
    }
}

/// A rim at a vertex.
struct Rim {
    half_edge: HalfEdgeId,
    /// Does the half edge leave the vertex? At the end of a boundary it arrives there.
    leaves: bool,
    /// Faces from here to the next rim, counter-clockwise; none behind a boundary.
    faces: usize,
}

/// The rims at a vertex of the whole, counter-clockwise.
fn rims_at(whole: &HalfEdgeMesh, cut: &Cut, v: VertexId) -> Vec<Rim> {
    let ring: Vec<HalfEdgeId> = whole.ring(v).collect();
    let places: Vec<usize> = (0..ring.len()).filter(|i| cut.mesh.twin(ring[*i]).is_none()).collect();
    let open = whole.is_boundary_vertex(v);
    let next = |i: usize| match places.get(i + 1) {
        Some(next) => *next,
        None if open => ring.len(),
        None => places[0] + ring.len(),
    };
    let mut rims: Vec<Rim> = (0..places.len())
        .map(|i| Rim { half_edge: ring[places[i]], leaves: true, faces: next(i) - places[i] })
        .collect();
    if let (true, Some(last)) = (open, ring.last()) {
        rims.push(Rim { half_edge: whole.prev(*last), leaves: false, faces: 0 });
    }
    rims
}

/// Unit tangents of the rims out of a vertex.
fn tangents_at(
    whole: &HalfEdgeMesh,
    positions: &[Point3],
    v: VertexId,
    rims: &[Rim],
    is_corner: bool,
) -> Vec<Vec3> {
    let origin = positions[v.index()];
    let chord = |rim: &Rim| {
        let h = rim.half_edge;
        positions[if rim.leaves { whole.dest(h) } else { whole.origin(h) }.index()] - origin
    };
    let chords: Vec<Vec3> = rims.iter().map(chord).collect();
    let unit = |v: &Vec3| v.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    let mut t: Vec<Vec3> = chords.iter().map(unit).collect();
    if is_corner {
        return t;
    }
    if let [a, b] = rims {
        // A face alone between two rims needs a corner.
        if -t[0].dot(&t[1]) > CORNER_TURN && a.faces != 1 && b.faces != 1 {
            let along = unit(&(chords[0] - chords[1]));
            return vec![along, -along];
        }
        return t;
    }
    // Neighbours that almost run on as one do so exactly.
    let mut done = vec![false; t.len()];
    for i in 0..t.len() {
        let j = (i + 1) % t.len();
        let bends = rims[i].faces < 2 || t[i].cross(&t[j]).norm() > COLLINEAR || t[i].dot(&t[j]) > 0.0;
        if !done[i] && !done[j] && !bends {
            let along = unit(&(t[i] - t[j]));
            (t[i], t[j]) = (along, -along);
            (done[i], done[j]) = (true, true);
        }
    }
    t
}
