//! What is done where nothing else helps: an edge becomes a crease, a vertex becomes a corner with several normals.
//!
//! It always ends: every step adds a crease or a corner, or cuts a corner finer, and when every face has its own normal at all
//! of its vertices the surface is the mesh itself.

use super::builder::Builder;
use super::hermite::HermiteMesh;
use super::options::RobustApexes;
use super::problem::Reason;
use super::repair::{self, most_visible, normal_at};
use super::simplicial_hull::{AddedCrease, Corner};
use crate::geom::{Vec3, angle_between};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId};
use std::collections::BTreeMap;

/// How finely a vertex is cut into sectors. Each step cuts at least as finely as the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    /// As it is cut already, every sector in the plane of the two sharp edges at its ends.
    Edges,
    /// Into as few sectors as can be seen under at least this product with their normals.
    Visible(f64),
    /// Every face by itself.
    Faces,
}

/// The steps, coarsest first.
const CUTS: [Cut; 5] = [Cut::Edges, Cut::Visible(0.5), Cut::Visible(0.8), Cut::Visible(0.95), Cut::Faces];

/// A mean normal is taken for a sector if its product with the normals of all faces there is at least this; otherwise the most
/// visible one.
const SEEN_BY_MEAN: f64 = 0.3;

/// The steps taken at the vertices that were cut.
pub(super) type Steps = BTreeMap<VertexId, usize>;

/// Cuts vertices and makes creases until no problem remains.
pub(super) fn make_corners(builder: &mut Builder<'_>, rule: &RobustApexes) {
    let mut steps = std::mem::take(&mut builder.reliefs.steps);
    let mut changed = true;
    while changed && builder.score.0 > 0 {
        changed = false;
        for f in builder.data.mesh().faces() {
            while let Some(reason) = builder.fault_of_face(f) {
                if !cut_face(builder, f, reason, &mut steps, rule) {
                    break;
                }
                changed = true;
            }
        }
        for e in builder.bad_edges() {
            if let Some(reason) = builder.fault_of_edge(e) {
                changed |= cut_edge(builder, e, reason, &mut steps, rule);
            }
        }
    }
    builder.reliefs.steps = steps;
}

/// Cuts a vertex at which something is not seen from any direction, as coarsely as leaves nothing bad around it.
pub(super) fn cut_hidden(builder: &mut Builder<'_>, v: VertexId, rule: &RobustApexes) {
    let mut steps = std::mem::take(&mut builder.reliefs.steps);
    let last = CUTS.len() - 1;
    for step in 1..=last {
        let mark = builder.mark();
        let Some(creases) = cut_vertex(builder, v, CUTS[step], rule) else { continue };
        let mesh = builder.data.mesh();
        if step == last || !mesh.ring(v).any(|h| builder.is_bad(mesh.face(h))) {
            keep(builder, v, step, Reason::NoVisibleNormal, creases, &mut steps);
            break;
        }
        builder.roll_back_to(mark);
    }
    builder.reliefs.steps = steps;
}

/// Cuts the first of these vertices that can be cut finer, as coarsely as changes anything.
pub(super) fn cut_further(
    builder: &mut Builder<'_>,
    vertices: &[VertexId],
    reason: Reason,
    rule: &RobustApexes,
) -> bool {
    let mut steps = std::mem::take(&mut builder.reliefs.steps);
    let next = |v: &VertexId| steps.get(v).map_or(0, |step| step + 1)..CUTS.len();
    let all: Vec<(VertexId, usize)> = vertices.iter().flat_map(|v| next(v).map(|step| (*v, step))).collect();
    let mut cut = false;
    for (v, step) in all {
        if let Some(creases) = cut_vertex(builder, v, CUTS[step], rule) {
            keep(builder, v, step, reason, creases, &mut steps);
            cut = true;
            break;
        }
    }
    builder.reliefs.steps = steps;
    cut
}

/// Cuts one of the vertices of a face.
fn cut_face(
    builder: &mut Builder<'_>,
    f: FaceId,
    reason: Reason,
    steps: &mut Steps,
    rule: &RobustApexes,
) -> bool {
    let (mesh, frame) = (builder.data.mesh(), builder.frame(f));
    let seen = |k: usize| frame.n[k].dot(&frame.normal) / frame.n[k].norm();
    let mut corners = [0, 1, 2];
    corners.sort_by(|a, b| seen(*a).total_cmp(&seen(*b)));
    let vertices = corners.map(|k| mesh.triangle(f)[k]);
    cut_one_of(builder, &vertices, reason, steps, rule)
}

/// Makes a crease of a smooth edge with a fault, or cuts a vertex at its ends.
fn cut_edge(
    builder: &mut Builder<'_>,
    e: EdgeId,
    reason: Reason,
    steps: &mut Steps,
    rule: &RobustApexes,
) -> bool {
    let Some(pair) = builder.data.pair(e) else { return false };
    let mesh = builder.data.mesh();
    if let Some(v) = builder.fault_of_crease(e) {
        return cut_one_of(builder, &[v], reason, steps, rule);
    }
    let (ends, faces) = (pair.map(|h| mesh.origin(h)), pair.map(|h| mesh.face(h)));
    let (before, mark) = (builder.score, builder.mark());
    builder.set(&[e], &[]);
    builder.place_by_default(&faces, rule);
    if builder.score >= before {
        repair::relax_around(builder, ends[0], rule);
        repair::relax_around(builder, ends[1], rule);
    }
    if builder.score < before {
        builder.added_creases.push(AddedCrease { edge: e, reason });
        return true;
    }
    builder.roll_back_to(mark);
    cut_one_of(builder, &ends, reason, steps, rule)
}

/// Cuts one of these vertices as coarsely as makes things better, or, if nothing does, the first that can be cut into its faces.
fn cut_one_of(
    builder: &mut Builder<'_>,
    vertices: &[VertexId],
    reason: Reason,
    steps: &mut Steps,
    rule: &RobustApexes,
) -> bool {
    let before = builder.score;
    for v in vertices {
        for step in steps.get(v).map_or(0, |step| step + 1)..CUTS.len() {
            let mark = builder.mark();
            if let Some(creases) = cut_vertex(builder, *v, CUTS[step], rule) {
                repair::relax_around(builder, *v, rule);
                if builder.score < before {
                    keep(builder, *v, step, reason, creases, steps);
                    return true;
                }
                builder.roll_back_to(mark);
            }
        }
    }
    let last = CUTS.len() - 1;
    let Some(v) = vertices.iter().find(|v| steps.get(v).is_none_or(|step| *step < last)) else {
        return false;
    };
    let creases = cut_vertex(builder, *v, Cut::Faces, rule).unwrap_or_default();
    repair::relax_around(builder, *v, rule);
    keep(builder, *v, last, reason, creases, steps);
    true
}

fn keep(
    builder: &mut Builder<'_>,
    vertex: VertexId,
    step: usize,
    reason: Reason,
    creases: Vec<EdgeId>,
    steps: &mut Steps,
) {
    if steps.insert(vertex, step).is_none() {
        builder.corners.push(Corner { vertex, reason: reason_at(builder, vertex, reason) });
    }
    builder.added_creases.extend(creases.into_iter().map(|edge| AddedCrease { edge, reason }));
}

/// Why a vertex becomes a corner: no vector at all sees the faces around it, or there is one, and with it no hull was found.
fn reason_at(builder: &Builder<'_>, vertex: VertexId, reason: Reason) -> Reason {
    let ring: Vec<HalfEdgeId> = builder.data.mesh().ring(vertex).collect();
    let is_seen = most_visible(&builder.data, &ring).is_some_and(|(_, product)| product > 0.0);
    match reason {
        _ if !is_seen => Reason::NoVisibleNormal,
        Reason::NoVisibleNormal => Reason::NoApex,
        found => found,
    }
}

/// Cuts a vertex, and says which creases that added; None if it changes nothing.
fn cut_vertex(builder: &mut Builder<'_>, v: VertexId, cut: Cut, rule: &RobustApexes) -> Option<Vec<EdgeId>> {
    let (data, mesh) = (&builder.data, builder.data.mesh());
    let sectors = data.sectors(v);
    let closed = sectors.len() == 1 && !mesh.is_boundary_vertex(v);
    let mut pieces: Vec<Vec<HalfEdgeId>> = Vec::new();
    for sector in &sectors {
        match cut {
            Cut::Edges => pieces.push(sector.clone()),
            Cut::Visible(least) => pieces.extend(visible_pieces(data, sector, closed, least)),
            Cut::Faces => pieces.extend(sector.iter().map(|h| vec![*h])),
        }
    }
    let normal = |piece: &[HalfEdgeId]| match cut {
        Cut::Edges if sectors.len() > 1 => normal_of_edges(data, piece),
        Cut::Edges => None,
        _ => Some(normal_of_piece(data, piece)),
    };
    let mut gradients = Vec::new();
    for piece in &pieces {
        let normal = normal(piece)?;
        gradients.extend(piece.iter().map(|h| (*h, data.gradient(*h).norm() * normal)));
    }
    let starts = pieces.iter().filter(|_| pieces.len() > 1).filter_map(|piece| piece.first());
    let creases: Vec<EdgeId> =
        starts.map(|h| mesh.edge(*h)).filter(|e| !data.is_crease(*e) && data.pair(*e).is_some()).collect();
    if creases.is_empty() && gradients.iter().all(|(h, gradient)| data.gradient(*h) == *gradient) {
        return None;
    }
    let faces: Vec<FaceId> = mesh.ring(v).map(|h| mesh.face(h)).collect();
    builder.set(&creases, &gradients);
    builder.place_by_default(&faces, rule);
    Some(creases)
}

/// Cuts a sector (a whole ring if it is closed) into as few pieces as can be seen under `least`, each as long as it may be.
fn visible_pieces(
    data: &HermiteMesh,
    sector: &[HalfEdgeId],
    closed: bool,
    least: f64,
) -> Vec<Vec<HalfEdgeId>> {
    let seen = |piece: &[HalfEdgeId]| most_visible(data, piece).map_or(-1.0, |(_, product)| product);
    let pieces_from = |start: usize| {
        let mut ring = sector.to_vec();
        ring.rotate_left(start);
        let mut pieces: Vec<Vec<HalfEdgeId>> = Vec::new();
        for h in ring {
            if let Some(piece) = pieces.last_mut() {
                piece.push(h);
                if seen(piece) >= least {
                    continue;
                }
                piece.pop();
            }
            pieces.push(vec![h]);
        }
        pieces
    };
    let starts = if closed { sector.len() } else { 1 };
    let all = (0..starts).map(pieces_from);
    all.min_by_key(Vec::len).unwrap_or_default()
}

/// Normal of the plane of the edges on both sides of a sector, if they span one that sees its faces.
fn normal_of_edges(data: &HermiteMesh, sector: &[HalfEdgeId]) -> Option<Vec3> {
    let mesh = data.mesh();
    let at = |v: VertexId| data.positions()[v.index()];
    let (first, last) = (*sector.first()?, *sector.last()?);
    let origin = at(mesh.origin(first));
    let [a, b] = [mesh.dest(first), mesh.origin(mesh.prev(last))].map(|v| at(v) - origin);
    let normal = a.cross(&b).try_normalize(0.0)?;
    let seen = |normal: &Vec3| sector.iter().all(|h| normal_at(data, *h).dot(normal) >= SEEN_BY_MEAN);
    [normal, -normal].into_iter().find(seen)
}

/// The normal of a face; of several, the mean weighted by angles if it sees them well, else the most visible one.
fn normal_of_piece(data: &HermiteMesh, piece: &[HalfEdgeId]) -> Vec3 {
    let mesh = data.mesh();
    let at = |v: VertexId| data.positions()[v.index()];
    let weighted = |h: &HalfEdgeId| {
        let origin = at(mesh.origin(*h));
        let [a, b] = [mesh.dest(*h), mesh.origin(mesh.prev(*h))].map(|v| at(v) - origin);
        angle_between(&a, &b) * normal_at(data, *h)
    };
    let [only] = piece else {
        let mean = piece.iter().map(weighted).sum::<Vec3>().try_normalize(0.0);
        let seen = |n: &Vec3| piece.iter().all(|h| normal_at(data, *h).dot(n) >= SEEN_BY_MEAN);
        let best = || most_visible(data, piece).map(|(direction, _)| direction);
        let fallback = || piece.first().map_or_else(Vec3::z, |h| normal_at(data, *h));
        return mean.filter(seen).or_else(best).unwrap_or_else(fallback);
    };
    normal_at(data, *only)
}
