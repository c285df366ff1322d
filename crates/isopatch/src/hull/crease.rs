//! The curves in which two faces meet at a sharp edge.

use super::hermite::HermiteMesh;
use super::problem::Reason;
use super::shear;
use super::simplicial_hull::HullFace;
use crate::geom::{Point3, Vec3, angle_between};
use crate::mesh::{EdgeId, HalfEdgeId, VertexId};

/// The curve over a sharp edge: a cubic Bézier curve from its start to its end, which lies in the tangent planes of both of its
/// faces at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreaseCurve {
    /// Control points.
    pub net: [Point3; 4],
    /// Is it the edge itself?
    pub is_straight: bool,
}

/// Normals with a smaller sine of the angle between them are the same: the crease ends there, and any direction in the tangent
/// plane would do.
const SAME_NORMAL: f64 = 1e-8;

/// A curve that leaves the edge by a smaller angle (as the sine) is straight: what counts as zero for classes of edges, with
/// the rounding of two normals and their cross product.
const STRAIGHT: f64 = 1e-10;

/// Direction of the crease where the normals on its two sides are n and m, towards `along` (a unit vector).
///
/// Their cross product; where they agree, `along` in the tangent plane.
fn direction(n: Vec3, m: Vec3, along: &Vec3) -> Vec3 {
    let [n, m] = [n.normalize(), m.normalize()];
    let cross = n.cross(&m);
    let tangent = if cross.norm() > SAME_NORMAL {
        along.dot(&cross).signum() * cross
    } else {
        along - along.dot(&n) * n
    };
    tangent.try_normalize(0.0).unwrap_or(*along)
}

impl CreaseCurve {
    /// The curve over an edge from p to q, with the normals on its left and on its right at both ends.
    ///
    /// A cubic Hermite curve. Where it leaves the edge by the angle φ its derivative has the length 2 |q − p| / (1 + cos φ),
    /// which brings it within O(φ⁶) of an arc of a circle.
    pub fn new([p, q]: [Point3; 2], normals: [[Vec3; 2]; 2]) -> Self {
        let (length, along) = ((q - p).norm(), (q - p).normalize());
        let tangents = normals.map(|[n, m]| direction(n, m, &along));
        let is_straight = tangents.iter().all(|t| t.cross(&along).norm() <= STRAIGHT);
        let [start, end] = tangents.map(|t| 2.0 / 3.0 * length / (1.0 + t.dot(&along)) * t);
        Self { net: [p, p + start, q - end, q], is_straight }
    }

    /// Point where x is the weight of the start and z that of the end, x + z = 1.
    #[inline]
    pub fn point(&self, x: f64, z: f64) -> Point3 {
        let [a, b, c, d] = &self.net;
        if self.is_straight {
            return x * a + z * d;
        }
        (x * x * x) * a + (3.0 * (x * x) * z) * b + (3.0 * x * (z * z)) * c + (z * z * z) * d
    }

    /// Derivative by z.
    #[inline]
    pub fn derivative(&self, x: f64, z: f64) -> Vec3 {
        let [a, b, c, d] = &self.net;
        if self.is_straight {
            return d - a;
        }
        3.0 * ((x * x) * (b - a) + (2.0 * x * z) * (c - b) + (z * z) * (d - c))
    }
}

impl HermiteMesh {
    /// The curve over a sharp edge, in the direction of its half edge; none for other edges.
    pub fn crease_curve(&self, e: EdgeId) -> Option<CreaseCurve> {
        let ends = self.crease_corners(e)?;
        let at = ends.map(|[h, _]| self.positions()[self.mesh().origin(h).index()]);
        Some(CreaseCurve::new(at, ends.map(|corners| corners.map(|h| self.gradient(h)))))
    }

    /// The corners on the left and the right of a sharp edge, at its start and at its end.
    fn crease_corners(&self, e: EdgeId) -> Option<[[HalfEdgeId; 2]; 2]> {
        let [h, g] = self.pair(e).filter(|_| self.is_crease(e))?;
        Some([[h, self.mesh().next(g)], [self.mesh().next(h), g]])
    }
}

/// A crease may leave its edge by no more than this (radians, 80°).
const WIDEST_TURN: f64 = 1.396;

/// How far a crease may lean over the faces beside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lean {
    /// How far it may turn into a face, as a part of the angle of the face there, if one or if both edges there are creases.
    turn: [f64; 2],
    /// How deep its control points may be over a face, as a part of the height of the face over the edge.
    depth: f64,
}

impl Lean {
    /// All limits divided by this.
    pub fn over(&self, divisor: f64) -> Self {
        Self { turn: self.turn.map(|turn| turn / divisor), depth: self.depth / divisor }
    }
}

/// With more the faces fold, or nearly.
pub(super) const WIDEST: Lean = Lean { turn: [0.9, 0.6], depth: 0.6 };

/// With less they don't.
pub(super) const HARMLESS: Lean = Lean { turn: [0.6, 0.35], depth: 0.35 };

/// By how much the curve over a sharp edge turns too far, over both ends and both faces; zero where [`fault`] has nothing to say.
pub(super) fn excess(data: &HermiteMesh, e: EdgeId, limit: &Lean) -> f64 {
    leans(data, e).into_iter().flatten().map(|lean| lean.excess(limit)).sum()
}

/// What is wrong with the curve over a sharp edge: the faces beside it would fold. With the end where it is.
pub(super) fn fault(data: &HermiteMesh, e: EdgeId, limit: &Lean) -> Option<(VertexId, Reason)> {
    let bad = leans(data, e)?.into_iter().find(|lean| lean.excess(limit) > 0.0)?;
    Some((bad.vertex, Reason::CreaseTurns))
}

/// The vertex at an end of a sharp edge where a face beside it turns over at its corner, and by how much they all do.
pub(super) fn turns_back(data: &HermiteMesh, faces: &[HullFace], e: EdgeId) -> (Option<VertexId>, f64) {
    let (mesh, mut first, mut sum) = (data.mesh(), None, 0.0);
    for h in data.pair(e).into_iter().flatten() {
        let f = mesh.face(h);
        for corner in [h, mesh.next(h)] {
            let excess = shear::corner_turns_back(data, f, &faces[f.index()], mesh.side(corner));
            if excess > 0.0 {
                first = first.or(Some(mesh.origin(corner)));
                sum += excess;
            }
        }
    }
    (first, sum)
}

/// How a crease leaves its edge at one end.
struct LeanAt {
    vertex: VertexId,
    /// Angle with the edge.
    turn: f64,
    /// On the left and the right: the angle into the face, that of the face there, how deep the control point is over the face,
    /// and whether the other edge there is a crease.
    sides: [(f64, f64, f64, bool); 2],
}

impl LeanAt {
    fn excess(&self, limit: &Lean) -> f64 {
        let over = |(turn, angle, depth, creased): (f64, f64, f64, bool)| {
            (depth - limit.depth).max(0.0) + (turn - limit.turn[usize::from(creased)] * angle).max(0.0)
        };
        (self.turn - WIDEST_TURN).max(0.0) + self.sides.map(over).iter().sum::<f64>()
    }
}

/// How a crease leaves its edge at both ends; none if it is straight.
fn leans(data: &HermiteMesh, e: EdgeId) -> Option<[LeanAt; 2]> {
    let curve = data.crease_curve(e).filter(|curve| !curve.is_straight)?;
    let (mesh, [h, g]) = (data.mesh(), data.pair(e)?);
    let [p, b, c, q] = curve.net;
    let ends = [
        (mesh.origin(h), [p, b, q], [(h, mesh.prev(h)), (g, mesh.next(g))]),
        (mesh.origin(g), [q, c, p], [(h, mesh.next(h)), (g, mesh.prev(g))]),
    ];
    Some(ends.map(|(vertex, [p, b, q], sides)| {
        let (edge, control) = (q - p, b - p);
        let along = edge.normalize();
        let side = |(h, beside): (HalfEdgeId, HalfEdgeId)| {
            let third = data.positions()[mesh.origin(mesh.prev(h)).index()] - p;
            let into = third - third.dot(&along) * along;
            let depth = control.dot(&into) / into.norm_squared();
            let turn = (depth * into.norm()).atan2(control.dot(&along));
            (turn, angle_between(&edge, &third), depth, data.is_crease(mesh.edge(beside)))
        };
        LeanAt { vertex, turn: angle_between(&control, &edge), sides: sides.map(side) }
    }))
}
