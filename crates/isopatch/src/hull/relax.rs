//! Looks for normals and apexes with which a hull is valid by descending what is missing: where the repairs have no candidate left,
//! the normals of vertices, the directions of apexes and their heights are varied together.
//!
//! Every condition on a face or an edge has an excess, a number that says by how much it fails; the sum over a neighbourhood
//! is descended one variable at a time, with steps that shrink when none helps. Near-linear: only what is at fault and what
//! is around it takes part, for a limited number of rounds.

use super::builder::Builder;
use super::check::made_edge;
use super::class::{Class, Side};
use super::crease;
use super::edge::EdgeCell;
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::options::RobustApexes;
use super::repair::most_visible;
use super::shear;
use super::simplicial_hull::{HullFace, apexes_beside};
use super::visibility::most_visible_direction;
use crate::geom::Vec3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

/// Steps by which normals and directions turn (as the tangent of the angle): the first, and the one after which the search ends.
const FIRST_STEP: f64 = 0.5;
const LAST_STEP: f64 = 0.01;

/// Rounds over all variables of a neighbourhood.
const ROUNDS: usize = 24;
const FEW_ROUNDS: usize = 10;

/// Ways to turn that are tried at each step.
const WAYS: usize = 6;

/// Turns the ways of one round against those of the one before: the golden angle, so that they do not repeat.
const BETWEEN_ROUNDS: f64 = 2.399963;

/// A normal should see the faces around it under this product at least.
const SEEN: f64 = 0.01;

/// What a product below that counts.
const HIDDEN: f64 = 5.0;

/// Edge cells should open at least this wide (radians).
const NARROWEST: f64 = 0.1;

/// Excess of a face without a height for its apexes, apart from that of its conditions.
const NO_HEIGHT: f64 = 0.3;

/// Excess of a patch that turns over to first order: it is no fault of the hull yet.
const TURNED: f64 = 0.02;

/// What a wish counts beside what is needed; wishes grow by 1 each time that a patch turns over.
const WISH: f64 = 0.3;

/// Per unit of a wish: angle of an edge cell (radians), product of normals and directions, sine in patches through an edge.
const WISHED_ANGLE: f64 = 0.15;
const WISHED_VIEW: f64 = 0.1;
const WISHED_SHEAR: f64 = 0.1;

/// Per unit of a wish: what the limits of creases are divided by, beside 1.
const WISHED_LEAN: f64 = 0.5;

/// Height of apexes, in radii of their face, above which lower ones are looked for, and what the logarithm of more counts.
const HIGHEST: f64 = 32.0;
const TOO_HIGH: f64 = 0.02;

/// Shift of apexes along an edge, in its lengths, for a wish of 1.
const WIDEST_SHIFT: f64 = 2.0;

/// Least product of a direction of apexes with the normal of the face.
const LEAST_FACING: f64 = 0.1;

/// What is descended around some faces.
struct Relaxation<'b, 'a> {
    builder: &'b mut Builder<'a>,
    rule: &'b RobustApexes,
    /// Heights of apexes as multiples of the lowest ones, of faces that take part.
    factors: BTreeMap<FaceId, [f64; 2]>,
    rounds: usize,
    phase: f64,
    /// Faces that were changed.
    touched: BTreeSet<FaceId>,
}

/// Where a descent starts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Start {
    /// Where things are.
    Here,
    /// Normals at fault in the most visible direction, apexes on the normals of their faces.
    Visible,
    /// Apexes where their three normals see them best.
    Apexes,
}

const STARTS: [Start; 6] =
    [Start::Here, Start::Visible, Start::Apexes, Start::Here, Start::Visible, Start::Apexes];

/// Descends around faces at fault, and keeps what that leads to if fewer faces are bad.
pub(super) fn relax(builder: &mut Builder<'_>, cluster: &[FaceId], rule: &RobustApexes) -> bool {
    let (before, mark) = (builder.score, builder.mark());
    for (n, start) in STARTS.into_iter().enumerate() {
        if !cluster.iter().any(|f| builder.is_bad(*f)) {
            break;
        }
        relax_from(builder, cluster, start, n, rule, ROUNDS, |after, before| after <= before);
    }
    if builder.score < before {
        return true;
    }
    builder.roll_back_to(mark);
    false
}

/// The same from where things are, if something is bad.
pub(super) fn relax_here(builder: &mut Builder<'_>, cluster: &[FaceId], rule: &RobustApexes) -> bool {
    relax_from(builder, cluster, Start::Here, 0, rule, ROUNDS, |after, before| after < before)
}

/// Descends around faces that are wanted to be better than valid; nothing becomes bad by it.
pub(super) fn loosen(builder: &mut Builder<'_>, cluster: &[FaceId], rule: &RobustApexes) -> bool {
    relax_from(builder, cluster, Start::Here, 0, rule, FEW_ROUNDS, |after, before| after <= before)
}

fn relax_from(
    builder: &mut Builder<'_>,
    cluster: &[FaceId],
    start: Start,
    phase: usize,
    rule: &RobustApexes,
    rounds: usize,
    accept: impl Fn((usize, usize), (usize, usize)) -> bool,
) -> bool {
    let (before, mark) = (builder.score, builder.mark());
    let (factors, touched) = (BTreeMap::new(), BTreeSet::new());
    let mut relaxation = Relaxation { builder, rule, factors, rounds, phase: phase as f64, touched };
    relaxation.start(cluster, start);
    relaxation.descend(cluster);
    let touched: Vec<FaceId> = relaxation.touched.into_iter().collect();
    builder.recheck(&touched);
    let better = accept(builder.score, before);
    if !better {
        builder.roll_back_to(mark);
    }
    better
}

impl Relaxation<'_, '_> {
    fn start(&mut self, cluster: &[FaceId], start: Start) {
        let mut region = cluster.to_vec();
        let (vertices, faces) = match start {
            Start::Here => return,
            _ => self.at_fault(&mut region),
        };
        if start == Start::Visible {
            let data = &self.builder.data;
            let sectors: Vec<Vec<HalfEdgeId>> = vertices.iter().flat_map(|v| data.sectors(*v)).collect();
            for sector in sectors {
                let seen = most_visible(&self.builder.data, &sector);
                let seen = seen.filter(|_| !is_alone(&self.builder.data, &sector));
                if let Some((direction, _)) = seen {
                    self.take_normal(&sector, direction);
                }
            }
        }
        let around: Vec<FaceId> = if start == Start::Visible { region } else { faces };
        for f in around {
            let frame = self.builder.frame(f);
            let direction = match start {
                Start::Apexes => most_visible_direction(&frame.n.map(|n| n.normalize())).map(|(d, _)| d),
                _ => None,
            };
            let direction = direction.filter(|d| d.dot(&frame.normal) > LEAST_FACING).unwrap_or(frame.normal);
            self.factors.insert(f, [1.0; 2]);
            let face = self.placed(f, direction);
            self.take_face(f, face);
        }
    }

    fn take_normal(&mut self, sector: &[HalfEdgeId], direction: Vec3) {
        for h in sector {
            let length = self.builder.data.gradient(*h).norm();
            self.builder.turn(*h, length * direction);
            self.touched.insert(self.builder.data.mesh().face(*h));
        }
    }

    fn take_face(&mut self, f: FaceId, face: HullFace) {
        self.builder.replace_face(f, face);
        self.touched.insert(f);
    }

    fn descend(&mut self, cluster: &[FaceId]) {
        let mut region: Vec<FaceId> = cluster.to_vec();
        let mut step = FIRST_STEP;
        for round in 0..self.rounds {
            let (vertices, faces) = self.at_fault(&mut region);
            if faces.is_empty() || step < LAST_STEP || self.builder.effort == 0 {
                break;
            }
            let phase = self.phase + BETWEEN_ROUNDS * round as f64;
            let mut better = false;
            for f in &faces {
                better |= self.turn_direction(*f, step, phase);
                better |= self.change_heights(*f, step);
            }
            for v in &vertices {
                for sector in self.builder.data.sectors(*v) {
                    better |= self.turn_normal(&sector, step, phase);
                }
            }
            if !better {
                step *= 0.5;
            }
        }
    }

    /// The faces with an excess, or at an edge with one, with their vertices; adds the faces around them to the region.
    fn at_fault(&self, region: &mut Vec<FaceId>) -> (Vec<VertexId>, Vec<FaceId>) {
        let mesh = self.builder.data.mesh();
        let mut faces: Vec<FaceId> = region.iter().copied().filter(|f| self.face_excess(*f) > 0.0).collect();
        for e in self.builder.edges_around(region.iter().copied()) {
            if self.edge_excess(e) > 0.0 {
                faces.extend(self.builder.data.pair(e).into_iter().flatten().map(|h| mesh.face(h)));
            }
        }
        faces.sort_unstable();
        faces.dedup();
        let mut vertices: Vec<VertexId> = faces.iter().flat_map(|f| mesh.triangle(*f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        region.extend(vertices.iter().flat_map(|v| mesh.ring(*v)).map(|h| mesh.face(h)));
        region.sort_unstable();
        region.dedup();
        (vertices, faces)
    }

    /// Tries a change; the excess of the faces and edges that it reaches, if that is smaller than `best`.
    fn excess(&mut self, faces: &[FaceId], edges: &[EdgeId], best: f64) -> f64 {
        self.builder.effort = self.builder.effort.saturating_sub(faces.len() + edges.len());
        let mut sum = 0.0;
        for f in faces {
            sum += self.face_excess(*f);
            if sum >= best {
                return sum;
            }
        }
        for e in edges {
            sum += self.edge_excess(*e);
            if sum >= best {
                return sum;
            }
        }
        sum
    }

    fn turn_normal(&mut self, sector: &[HalfEdgeId], step: f64, phase: f64) -> bool {
        let mesh = self.builder.data.mesh();
        let Some(first) = sector.first() else { return false };
        if is_alone(&self.builder.data, sector) {
            return false;
        }
        let faces: Vec<FaceId> = sector.iter().map(|h| mesh.face(*h)).collect();
        let edges = self.builder.edges_around(faces.iter().copied());
        let mut least = self.excess(&faces, &edges, f64::INFINITY);
        if least == 0.0 {
            return false;
        }
        let gradient = self.builder.data.gradient(*first);
        let kept: Vec<HullFace> = faces.iter().map(|f| self.builder.faces[f.index()]).collect();
        let mut best: Option<(Vec3, Vec<HullFace>)> = None;
        for way in ways(gradient, step, phase) {
            sector.iter().for_each(|h| self.builder.data.set_gradient(*h, way));
            for with_default in [false, true] {
                for (f, face) in faces.iter().zip(&kept) {
                    let direction =
                        if with_default { self.builder.default_direction(*f) } else { face.direction };
                    self.builder.faces[f.index()] = self.placed(*f, direction);
                }
                let sum = self.excess(&faces, &edges, least);
                if sum < least {
                    least = sum;
                    best = Some((way, faces.iter().map(|f| self.builder.faces[f.index()]).collect()));
                }
            }
        }
        sector.iter().for_each(|h| self.builder.data.set_gradient(*h, gradient));
        for (f, face) in faces.iter().zip(kept) {
            self.builder.faces[f.index()] = face;
        }
        let Some((way, moved)) = best else { return false };
        sector.iter().for_each(|h| self.builder.turn(*h, way));
        for (f, face) in faces.into_iter().zip(moved) {
            self.take_face(f, face);
        }
        true
    }

    fn turn_direction(&mut self, f: FaceId, step: f64, phase: f64) -> bool {
        let frame = self.builder.frame(f);
        let before = self.builder.faces[f.index()];
        let seen = most_visible_direction(&frame.n.map(|n| n.normalize())).map(|(d, _)| d);
        let tried = ways(before.direction, step, phase).into_iter().chain(seen).chain([frame.normal]);
        let tried = tried.filter(|d| d.dot(&frame.normal) > LEAST_FACING);
        let tried: Vec<HullFace> = tried.map(|d| self.placed(f, d)).collect();
        self.best_face(f, tried).is_some()
    }

    fn change_heights(&mut self, f: FaceId, step: f64) -> bool {
        let mut better = false;
        for side in Side::BOTH {
            for factor in [1.0 + 2.0 * step, 1.0 / (1.0 + step)] {
                let before = self.factors_of(f);
                let mut factors = before;
                factors[side.index()] = (factor * factors[side.index()]).max(1.0);
                if factors == before || !self.builder.faces[f.index()].class.reaches(side) {
                    continue;
                }
                self.factors.insert(f, factors);
                let placed = self.placed(f, self.builder.faces[f.index()].direction);
                if self.best_face(f, vec![placed]).is_some() {
                    better = true;
                } else {
                    self.factors.insert(f, before);
                }
            }
        }
        better
    }

    /// Takes the one of these for a face that leaves the least excess.
    fn best_face(&mut self, f: FaceId, tried: Vec<HullFace>) -> Option<usize> {
        let edges = self.builder.edges_of(f);
        let before = self.builder.faces[f.index()];
        let mut least = self.excess(&[f], &edges, f64::INFINITY);
        let mut best = None;
        for (n, face) in tried.iter().enumerate() {
            self.builder.faces[f.index()] = *face;
            let sum = self.excess(&[f], &edges, least);
            if sum < least {
                (least, best) = (sum, Some(n));
            }
        }
        self.builder.faces[f.index()] = before;
        if let Some(n) = best {
            self.take_face(f, tried[n]);
        }
        best
    }

    /// A face with its apexes on a line, at its multiples of the lowest heights.
    fn placed(&mut self, f: FaceId, direction: Vec3) -> HullFace {
        let factors = self.factors_of(f);
        self.builder.placed_at(f, direction, factors)
    }

    fn factors_of(&mut self, f: FaceId) -> [f64; 2] {
        if let Some(factors) = self.factors.get(&f) {
            return *factors;
        }
        let face = self.builder.faces[f.index()];
        let lowest = self.builder.placed_at(f, face.direction, [1.0; 2]);
        let factors = Side::BOTH.map(|side| {
            let s = side.index();
            if lowest.heights[s] > 0.0 { (face.heights[s] / lowest.heights[s]).max(1.0) } else { 1.0 }
        });
        self.factors.insert(f, factors);
        factors
    }

    fn face_excess(&self, f: FaceId) -> f64 {
        let wish = self.builder.reliefs.wish_of_face(f);
        face_excess(&self.builder.frame(f), &self.builder.faces[f.index()], wish)
    }

    fn edge_excess(&self, e: EdgeId) -> f64 {
        let data = &self.builder.data;
        if data.is_crease(e) {
            let faces = data.pair(e).into_iter().flatten().map(|h| data.mesh().face(h));
            let wish = faces.map(|f| self.builder.reliefs.wish_of_face(f)).fold(0.0, f64::max);
            let leans = crease::excess(data, e, &crease::WIDEST.over(1.0 + WISHED_LEAN * wish));
            return leans + crease::turns_back(data, &self.builder.faces, e).1;
        }
        let edge = made_edge(data, &self.builder.faces, e);
        if edge.class == Class::Zero {
            return 0.0;
        }
        let wish = self.builder.reliefs.wish_of_edge(e);
        let mut sum = edge.cells.iter().flatten().map(|cell| cell_excess(cell, wish, self.rule)).sum::<f64>();
        if wish > 0.0 {
            sum += self.shift(e, wish);
        }
        if shear::crossing_folds(data, &self.builder.faces, e, edge.class, WISHED_SHEAR * wish) {
            sum += TURNED;
        }
        sum
    }

    /// By how much the apexes beside an edge are shifted along it against each other.
    fn shift(&self, e: EdgeId, wish: f64) -> f64 {
        let data = &self.builder.data;
        let h = data.mesh().edge_half_edge(e);
        let [a, b] = [data.mesh().origin(h), data.mesh().dest(h)].map(|v| data.positions()[v.index()]);
        let along = (b - a) / (b - a).norm_squared();
        let shifts = Side::BOTH.map(|side| {
            let Some([u, v]) = apexes_beside(data, &self.builder.faces, e, side) else { return 0.0 };
            ((u - v).dot(&along).abs() - WIDEST_SHIFT / wish).max(0.0)
        });
        WISH * shifts.iter().sum::<f64>().ln_1p()
    }
}

/// Is this one face of a vertex all of whose edges are creases? Then it keeps the normal that it has, in the end its own, so that
/// cutting vertices ends.
fn is_alone(data: &HermiteMesh, sector: &[HalfEdgeId]) -> bool {
    let ([only], mesh) = (sector, data.mesh()) else { return false };
    let v = mesh.origin(*only);
    mesh.ring(v).count() > 1 && data.sectors(v).iter().all(|sector| sector.len() == 1)
}

/// The vector turned in several ways, as long as before.
fn ways(v: Vec3, step: f64, phase: f64) -> [Vec3; WAYS] {
    let length = v.norm();
    let unit = v / length;
    let across = unit.cross(&Vec3::ith(unit.iamin(), 1.0)).normalize();
    let third = unit.cross(&across);
    std::array::from_fn(|n| {
        let (sin, cos) = (phase + TAU * n as f64 / WAYS as f64).sin_cos();
        length * (unit + step * (cos * across + sin * third)).normalize()
    })
}

fn face_excess(frame: &FaceFrame, face: &HullFace, wish: f64) -> f64 {
    let hidden = |least: f64| -> f64 {
        frame.n.iter().map(|n| (least - n.dot(&frame.normal) / n.norm()).max(0.0)).sum()
    };
    let low = Side::BOTH
        .into_iter()
        .any(|side| face.apexes[side.index()].is_some_and(|apex| !frame.layer1(side, &apex).is_copositive()));
    let rise = |least: f64| -> f64 {
        frame.n.iter().map(|n| (least - n.dot(&face.direction) / n.norm()).max(0.0)).sum()
    };
    let mut sum = HIDDEN * hidden(SEEN);
    if frame.n.iter().any(|n| n.dot(&frame.normal) <= 0.0) {
        sum += NO_HEIGHT;
    }
    if low {
        sum += NO_HEIGHT + rise(LEAST_FACING);
    }
    if wish > 0.0 {
        sum += WISH * (hidden(WISHED_VIEW * wish) + rise(WISHED_VIEW * wish));
    }
    let high = face.heights.map(|height| (height / (HIGHEST * frame.inner_radius)).max(1.0).ln());
    sum += TOO_HIGH * high.iter().sum::<f64>();
    if face.class == Class::Nonconvex && shear::corners_fold(frame, face) {
        sum += TURNED;
    }
    sum
}

fn cell_excess(cell: &EdgeCell, wish: f64, rule: &RobustApexes) -> f64 {
    let narrow = (NARROWEST - cell.angle).max(0.0) + WISH * (WISHED_ANGLE * wish - cell.angle).max(0.0);
    let wide = (cell.angle - rule.widest.min(PI)).max(0.0);
    let steep = |reach: f64| if reach.is_finite() { (rule.reach - reach).max(0.0).ln_1p() } else { 1.0 };
    narrow + wide + cell.reach().map(steep).iter().sum::<f64>()
}
