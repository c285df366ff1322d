//! A hull in the making: apexes are put over faces, what stands between them is checked, and changes can be undone.

use super::check::{face_fault, made_edge};
use super::class::{Class, Side};
use super::crease;
use super::edge::EdgeCell;
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::options::{ApexRule, HullOptions, RobustApexes};
use super::place::{RAISES_FOR_FOLDS, apexes, default_direction, placed, placed_at};
use super::problem::{Problem, Reason};
use super::refine::{self, Refined, Refinement, Way};
use super::relief::Reliefs;
use super::repair;
use super::shear;
use super::simplicial_hull::{AddedCrease, Corner, Hull, HullEdge, HullFace, frame};
use super::visibility::most_visible_direction;
use crate::geom::Vec3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId};
use crate::parallel::Evenly;
use rayon::prelude::*;
use std::sync::Arc;

/// A hull in the making. `faults` counts, per face, what is wrong with it and its edges.
#[derive(Clone)]
pub(super) struct Builder<'a> {
    pub data: HermiteMesh,
    options: &'a HullOptions,
    pub faces: Vec<HullFace>,
    face_fault: Vec<Option<Reason>>,
    edges: Vec<HullEdge>,
    edge_fault: Vec<Option<Reason>>,
    faults: Vec<u8>,
    /// Number of faces with a fault, and number of faults.
    pub score: (usize, usize),
    given: Vec<Vec3>,
    journal: Vec<Change>,
    /// Length of the journal when something was set last.
    begun: usize,
    /// How many more faces and edges may be looked at in relaxing.
    pub effort: usize,
    pub corners: Vec<Corner>,
    pub added_creases: Vec<AddedCrease>,
    pub reliefs: Reliefs,
    pub refinement: Refinement,
}

/// How many faces and edges may be looked at in relaxing: so many, and so many more for each face of the mesh.
const EFFORT: usize = 16_000_000;
const EFFORT_PER_FACE: usize = 20;

/// How many more each time that something is refined.
const EFFORT_OF_REFINEMENT: usize = 1_000_000;

/// Height of apexes on parallel lines, as a multiple of the largest of the lowest ones.
const ALIGNED: f64 = 1.5;

/// The part of the best product from which on a normal perpendicular to its edge is good enough.
const STRAIGHT_SHARE: f64 = 0.3;
const RAISES_OF_ALIGNED: usize = 24;

/// What was there before a change.
#[derive(Clone)]
enum Change {
    Face(FaceId, HullFace),
    Gradient(HalfEdgeId, Vec3),
    Crease(EdgeId),
}

impl<'a> Builder<'a> {
    pub fn new(mut data: HermiteMesh, options: &'a HullOptions) -> Self {
        let given = gradients(&data);
        if let ApexRule::Robust(rule) = options.rule {
            repair::turn_hidden_normals(&mut data, rule.visibility);
        }
        let faces: Vec<HullFace> = (0..data.mesh().face_count())
            .into_par_iter()
            .evenly()
            .map(|f| {
                let frame = frame(&data, f.into());
                placed(&frame, default_direction(&frame, options), options)
            })
            .collect();
        Self::with_faces(data, faces, given, options)
    }

    /// With faces that are placed already; everything is checked.
    pub fn with_faces(
        data: HermiteMesh,
        faces: Vec<HullFace>,
        given: Vec<Vec3>,
        options: &'a HullOptions,
    ) -> Self {
        let edge_count = data.mesh().edge_count();
        let blank = HullEdge { class: Class::Zero, cells: [None; 2] };
        let face_count = faces.len();
        let mut builder = Self {
            faults: vec![0; faces.len()],
            face_fault: vec![None; faces.len()],
            edges: vec![blank; edge_count],
            edge_fault: vec![None; edge_count],
            score: (0, 0),
            data,
            options,
            faces,
            given,
            journal: Vec::new(),
            begun: 0,
            effort: EFFORT + EFFORT_PER_FACE * face_count,
            corners: Vec::new(),
            added_creases: Vec::new(),
            reliefs: Reliefs::default(),
            refinement: Refinement::default(),
        };
        for f in 0..builder.faces.len() {
            builder.check_face(f.into());
        }
        builder.check_edges(&(0..edge_count).map(EdgeId::from).collect::<Vec<_>>());
        builder
    }

    pub fn frame(&self, f: FaceId) -> FaceFrame {
        frame(&self.data, f)
    }

    pub fn is_bad(&self, f: FaceId) -> bool {
        self.faults[f.index()] > 0
    }

    /// Edges that have a fault themselves.
    pub fn bad_edges(&self) -> Vec<EdgeId> {
        self.data.mesh().edges().filter(|e| self.is_bad_edge(*e)).collect()
    }

    pub fn fault_of_face(&self, f: FaceId) -> Option<Reason> {
        self.face_fault[f.index()]
    }

    pub fn fault_of_edge(&self, e: EdgeId) -> Option<Reason> {
        self.edge_fault[e.index()]
    }

    pub fn is_bad_edge(&self, e: EdgeId) -> bool {
        self.edge_fault[e.index()].is_some()
    }

    pub fn edges_of(&self, f: FaceId) -> [EdgeId; 3] {
        [0, 1, 2].map(|k| self.data.mesh().edge(HalfEdgeId(3 * f.0 + k)))
    }

    fn count_fault(&mut self, f: FaceId, by: i32) {
        let before = self.faults[f.index()];
        let after = (i32::from(before) + by) as u8;
        self.faults[f.index()] = after;
        self.score.0 = self.score.0 + usize::from(after > 0) - usize::from(before > 0);
        self.score.1 = self.score.1 + usize::from(after) - usize::from(before);
    }

    fn check_face(&mut self, f: FaceId) {
        let fault = face_fault(&self.frame(f), &self.faces[f.index()]);
        let by = i32::from(fault.is_some()) - i32::from(self.face_fault[f.index()].is_some());
        self.face_fault[f.index()] = fault;
        self.count_fault(f, by);
    }

    fn check_edges(&mut self, edges: &[EdgeId]) {
        let make = |e: &EdgeId| made_edge(&self.data, &self.faces, *e);
        let made: Vec<HullEdge> = if edges.len() < FEW {
            edges.iter().map(make).collect()
        } else {
            edges.par_iter().evenly().map(make).collect()
        };
        for (e, edge) in edges.iter().zip(made) {
            let faults = edge.cells.iter().flatten().filter_map(|cell| cell.fault(LEAST_REACH));
            let of_crease = || self.fault_of_crease(*e).map(|_| Reason::CreaseTurns);
            let fault = if self.data.is_crease(*e) { of_crease() } else { faults.min() };
            let by = i32::from(fault.is_some()) - i32::from(self.edge_fault[e.index()].is_some());
            self.edges[e.index()] = edge;
            self.edge_fault[e.index()] = fault;
            if by != 0 {
                for h in self.data.pair(*e).into_iter().flatten() {
                    self.count_fault(self.data.mesh().face(h), by);
                }
            }
        }
    }

    /// The end of a crease where the faces beside it would fold.
    pub fn fault_of_crease(&self, e: EdgeId) -> Option<VertexId> {
        if !self.data.is_crease(e) {
            return None;
        }
        let leans = crease::fault(&self.data, e, &crease::WIDEST).map(|(v, _)| v);
        leans.or_else(|| crease::turns_back(&self.data, &self.faces, e).0)
    }

    /// Multiplies the heights of the apexes of a face.
    pub fn raise_face(&mut self, f: FaceId, factor: f64) {
        let mut face = self.faces[f.index()];
        face.heights = face.heights.map(|height| factor * height);
        self.set_face(f, face);
    }

    /// Checks the edges of faces that were changed, and raises apexes there.
    pub fn settle(&mut self, faces: &[FaceId], rule: &RobustApexes) {
        let edges = self.edges_around(faces.iter().copied());
        self.check_edges(&edges);
        self.raise(edges, rule);
    }

    /// Raises the apexes beside edges whose cells are too wide or reach too low, as often as the rule allows.
    pub fn raise(&mut self, mut edges: Vec<EdgeId>, rule: &RobustApexes) {
        for round in 0..rule.raises {
            let mut wanted: Vec<(FaceId, Side)> = Vec::new();
            for e in &edges {
                let class = self.edges[e.index()].class;
                let folds = round < RAISES_FOR_FOLDS
                    && shear::crossing_folds(&self.data, &self.faces, *e, class, 0.0);
                for side in Side::BOTH {
                    let low = |cell: &EdgeCell| {
                        cell.angle > 0.0 && cell.reach().iter().any(|r| *r < rule.reach)
                            || cell.angle > rule.widest
                    };
                    if folds || self.edges[e.index()].cells[side.index()].as_ref().is_some_and(low) {
                        let faces = self.data.joint(*e).into_iter().flatten();
                        wanted.extend(faces.map(|h| (self.data.mesh().face(h), side)));
                    }
                }
            }
            wanted.sort_unstable();
            wanted.dedup();
            if wanted.is_empty() {
                return;
            }
            for (f, side) in &wanted {
                let mut face = self.faces[f.index()];
                face.heights[side.index()] *= rule.raise;
                self.set_face(*f, face);
            }
            edges = self.edges_around(wanted.into_iter().map(|(f, _)| f));
            self.check_edges(&edges);
        }
    }

    pub fn edges_around(&self, faces: impl Iterator<Item = FaceId>) -> Vec<EdgeId> {
        let mut edges: Vec<EdgeId> = faces.flat_map(|f| self.edges_of(f)).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Checks faces that were changed from outside, and their edges.
    pub fn recheck(&mut self, faces: &[FaceId]) {
        faces.iter().for_each(|f| self.check_face(*f));
        let edges = self.edges_around(faces.iter().copied());
        self.check_edges(&edges);
    }

    /// A face with apexes on the line in `direction`, at multiples of the lowest heights.
    pub fn placed_at(&self, f: FaceId, direction: Vec3, factors: [f64; 2]) -> HullFace {
        placed_at(&self.frame(f), direction, factors, self.options)
    }

    /// Replaces class, direction and heights of a face; apexes follow. Its edges have to be checked.
    fn set_face(&mut self, f: FaceId, mut face: HullFace) {
        let frame = self.frame(f);
        face.apexes = apexes(&frame, &face);
        self.journal.push(Change::Face(f, self.faces[f.index()]));
        self.faces[f.index()] = face;
        self.check_face(f);
    }

    /// Changes some directions and gradients, and keeps that if fewer faces are bad (or as many with fewer faults).
    pub fn attempt(
        &mut self,
        gradients: &[(HalfEdgeId, Vec3)],
        directions: &[(FaceId, Vec3)],
        rule: &RobustApexes,
    ) -> bool {
        let before = self.score;
        self.set(&[], gradients);
        self.place(directions, rule);
        if self.score < before {
            return true;
        }
        self.roll_back();
        false
    }

    /// Makes creases of edges and changes gradients. The faces beside them have to be placed next.
    pub fn set(&mut self, creases: &[EdgeId], gradients: &[(HalfEdgeId, Vec3)]) {
        self.begun = self.journal.len();
        for e in creases {
            if self.data.is_crease(*e) {
                continue;
            }
            self.journal.push(Change::Crease(*e));
            self.data.set_crease(*e, true);
        }
        for (corner, gradient) in gradients {
            self.turn(*corner, *gradient);
        }
    }

    /// Gives faces the directions that they have before anything is repaired, with the gradients as they are now.
    pub fn place_by_default(&mut self, faces: &[FaceId], rule: &RobustApexes) {
        let directions: Vec<(FaceId, Vec3)> =
            faces.iter().map(|f| (*f, self.default_direction(*f))).collect();
        self.place(&directions, rule);
    }

    fn place(&mut self, directions: &[(FaceId, Vec3)], rule: &RobustApexes) {
        for (f, direction) in directions {
            let face = placed(&self.frame(*f), *direction, self.options);
            self.set_face(*f, face);
        }
        let edges = self.edges_around(directions.iter().map(|(f, _)| *f));
        self.check_edges(&edges);
        self.raise(edges, rule);
    }

    /// Undoes what was set and placed last.
    pub fn roll_back(&mut self) {
        self.roll_back_to(self.begun);
    }

    /// What [`Builder::roll_back_to`] comes back to.
    pub fn mark(&self) -> usize {
        self.journal.len()
    }

    /// Replaces a gradient; the faces there have to be checked.
    pub fn turn(&mut self, corner: HalfEdgeId, gradient: Vec3) {
        self.journal.push(Change::Gradient(corner, self.data.gradient(corner)));
        self.data.set_gradient(corner, gradient);
    }

    /// Replaces a face as it is; it and its edges have to be checked.
    pub fn replace_face(&mut self, f: FaceId, face: HullFace) {
        self.journal.push(Change::Face(f, self.faces[f.index()]));
        self.faces[f.index()] = face;
    }

    /// Undoes what was changed since a mark.
    pub fn roll_back_to(&mut self, mark: usize) {
        let journal = self.journal.split_off(mark);
        let mut touched = Vec::new();
        for change in journal.into_iter().rev() {
            match change {
                Change::Face(f, face) => {
                    self.faces[f.index()] = face;
                    touched.push(f);
                }
                Change::Gradient(corner, gradient) => {
                    self.data.set_gradient(corner, gradient);
                    touched.push(self.data.mesh().face(corner));
                }
                Change::Crease(e) => self.data.set_crease(e, false),
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for f in &touched {
            self.check_face(*f);
        }
        let edges = self.edges_around(touched.into_iter());
        self.check_edges(&edges);
    }

    /// Keeps the mesh as it was given, if it is none with other faces already.
    pub fn keep_given(&mut self) {
        if self.refinement.given.is_some() {
            return;
        }
        let mut given = self.data.clone();
        self.data.mesh().half_edges().for_each(|h| given.set_gradient(h, self.given[h.index()]));
        self.added_creases.iter().for_each(|crease| given.set_crease(crease.edge, false));
        self.refinement.given = Some(Arc::new(given));
    }

    /// Cuts off the corners of the faces at some vertices, which changes no shape. What was there before can't be rolled back to.
    pub fn refine(&mut self, vertices: &[VertexId]) -> bool {
        self.keep_given();
        let Some(refined) = refine::cut_corners(&self.data, vertices, self.refinement.way) else {
            return false;
        };
        let Refined { data, face_source, edge_source, vertex_source } = refined;
        let (old, mesh) = (self.data.mesh(), data.mesh());
        let mut is_new = vec![false; mesh.face_count()];
        (old.face_count()..mesh.face_count()).for_each(|f| {
            is_new[f] = true;
            is_new[face_source[f].index()] = true;
        });
        let faces = mesh.faces().map(|f| match is_new[f.index()] {
            true => {
                let frame = frame(&data, f);
                placed(&frame, default_direction(&frame, self.options), self.options)
            }
            false => self.faces[f.index()],
        });
        let faces: Vec<HullFace> = faces.collect();
        // What was given at the corners of old vertices; nothing was at those of new ones.
        let given = mesh.half_edges().map(|h| {
            let v = mesh.origin(h);
            let source = face_source[mesh.face(h).index()];
            let corner = old.face_half_edges(source).find(|g| old.origin(*g) == v);
            corner.map_or(data.gradient(h), |g| self.given[g.index()])
        });
        let given: Vec<Vec3> = given.collect();
        let mut added_creases = Vec::new();
        for crease in &self.added_creases {
            let parts = mesh.edges().filter(|e| edge_source[e.index()] == Some(crease.edge));
            added_creases.extend(parts.map(|edge| AddedCrease { edge, ..*crease }));
        }
        let mut reliefs = std::mem::take(&mut self.reliefs);
        reliefs.forget(&|f| is_new[f.index()]);
        let mut refinement = std::mem::take(&mut self.refinement);
        refinement.extend(vertices, &face_source, &vertex_source, old.vertex_count());
        let builder = Self::with_faces(data, faces, given, self.options);
        *self = Self {
            corners: std::mem::take(&mut self.corners),
            added_creases,
            reliefs,
            refinement,
            effort: self.effort + EFFORT_OF_REFINEMENT,
            ..builder
        };
        if self.refinement.way != Way::AtPart {
            vertices.iter().for_each(|v| self.align(*v));
        }
        true
    }

    /// Puts the apexes of the faces around a vertex on parallel lines, equally far, so that none is in another's cell, and turns the
    /// normals at the other ends of its edges so that layer 1 of these faces is positive.
    fn align(&mut self, v: VertexId) {
        for sector in self.data.sectors(v) {
            let faces: Vec<FaceId> = sector.iter().map(|h| self.data.mesh().face(*h)).collect();
            let Some(direction) = sector.first().map(|h| self.data.gradient(*h).normalize()) else {
                continue;
            };
            if faces.iter().any(|f| self.frame(*f).normal.dot(&direction) <= 0.0) {
                continue;
            }
            let mesh = self.data.mesh();
            let mut ends: Vec<HalfEdgeId> =
                sector.iter().flat_map(|h| [mesh.next(*h), mesh.prev(*h)]).collect();
            let mut turned: Vec<(HalfEdgeId, Vec3)> = Vec::new();
            ends.sort_unstable();
            while let Some(first) = ends.first().copied() {
                let end = mesh.origin(first);
                let sectors = self.data.sectors(end);
                let Some(around) = sectors.into_iter().find(|sector| sector.contains(&first)) else { break };
                let here: Vec<HalfEdgeId> = ends.iter().copied().filter(|h| around.contains(h)).collect();
                ends.retain(|h| !here.contains(h));
                if let Some(gradient) = self.aligned_gradient(v, &here, &direction) {
                    turned.extend(around.into_iter().map(|h| (h, gradient)));
                }
            }
            let mut touched: Vec<FaceId> = turned.iter().map(|(h, _)| mesh.face(*h)).collect();
            touched.sort_unstable();
            touched.dedup();
            turned.iter().for_each(|(h, gradient)| self.turn(*h, *gradient));
            for f in &touched {
                let face = placed(&self.frame(*f), self.default_direction(*f), self.options);
                self.set_face(*f, face);
            }
            let mut placed: Vec<HullFace> =
                faces.iter().map(|f| placed(&self.frame(*f), direction, self.options)).collect();
            for side in Side::BOTH {
                let s = side.index();
                let highest = placed.iter().map(|face| face.heights[s]).fold(0.0, f64::max);
                placed.iter_mut().for_each(|face| face.heights[s] = ALIGNED * highest);
            }
            faces.iter().zip(placed).for_each(|(f, face)| self.set_face(*f, face));
            let edges = self.edges_around(touched.into_iter());
            self.check_edges(&edges);
            let spokes: Vec<EdgeId> = sector.iter().map(|h| self.data.mesh().edge(*h)).collect();
            for _ in 0..RAISES_OF_ALIGNED {
                if !spokes.iter().any(|e| self.is_bad_edge(*e)) {
                    break;
                }
                faces.iter().for_each(|f| self.raise_face(*f, ALIGNED));
                let edges = self.edges_around(faces.iter().copied());
                self.check_edges(&edges);
            }
        }
    }

    /// A gradient for the end of an edge from v, where the corners of faces at v are, with which the coefficients of layer 1 over the
    /// edges of these faces are positive if all apexes are far away in `direction`.
    ///
    /// Over an edge along the unit vector e, between gradients n and m, that is (n + m)·r > 0 with r = d − 3 (d·e) e; a long m
    /// does that if m·r > 0.
    fn aligned_gradient(&self, v: VertexId, corners: &[HalfEdgeId], direction: &Vec3) -> Option<Vec3> {
        let mesh = self.data.mesh();
        let at = |v: VertexId| self.data.positions()[v.index()];
        let first = *corners.first()?;
        let end = mesh.origin(first);
        let towards = |w: VertexId| {
            let along = (at(w) - at(end)).normalize();
            direction - 3.0 * direction.dot(&along) * along
        };
        let mut seen = vec![*direction, towards(v).normalize()];
        for h in corners {
            let third = mesh.triangle(mesh.face(*h)).into_iter().find(|w| *w != v && *w != end)?;
            seen.extend([towards(third).normalize(), repair::normal_at(&self.data, *h)]);
        }
        let (best, product) = most_visible_direction(&seen)?;
        if product <= 0.0 {
            return None;
        }
        // Perpendicular to the edge if that will do: then what comes behind it can be straight.
        let along = (at(end) - at(v)).normalize();
        let across = (direction - direction.dot(&along) * along).normalize();
        let least = seen.iter().map(|s| s.dot(&across)).fold(f64::INFINITY, f64::min);
        let normal = if least >= STRAIGHT_SHARE * product { across } else { best };
        let length = self.data.gradient(first).norm();
        let least = -direction.dot(&towards(v)) / normal.dot(&towards(v));
        Some(length * least.max(1.0) * normal)
    }

    /// The direction that a face has before anything is repaired.
    pub fn default_direction(&self, f: FaceId) -> Vec3 {
        default_direction(&self.frame(f), self.options)
    }

    pub fn finish(mut self) -> Hull {
        self.reliefs.effort = self.effort;
        self.corners.sort_unstable_by_key(|corner| corner.vertex);
        self.added_creases.sort_unstable_by_key(|crease| crease.edge);
        let mesh = self.data.mesh();
        let hidden = mesh.vertices().filter(|v| {
            repair::visibility(&self.data, *v, |h| self.data.gradient(h)).is_some_and(|least| least <= 0.0)
        });
        let mut problems: Vec<Problem> =
            hidden.map(|vertex| Problem::Vertex { vertex, reason: Reason::NoVisibleNormal }).collect();
        let of_faces = mesh
            .faces()
            .filter_map(|face| self.face_fault[face.index()].map(|reason| Problem::Face { face, reason }));
        problems.extend(of_faces);
        for edge in mesh.edges() {
            if let (Some(reason), Some(pair)) = (self.edge_fault[edge.index()], self.data.pair(edge)) {
                let faces = pair.map(|h| mesh.face(h));
                problems.push(Problem::Edge { edge, faces, reason });
            }
        }
        let is_corner = |v: &VertexId| self.corners.binary_search_by_key(v, |c| c.vertex).is_ok();
        let moved = |v: &VertexId| mesh.ring(*v).any(|h| self.given[h.index()] != self.data.gradient(h));
        let moved_normals =
            mesh.vertices().filter(|v| moved(v) && !is_corner(v) && !self.refinement.is_new(*v)).collect();
        Hull {
            faces: self.faces,
            edges: self.edges,
            problems,
            moved_normals,
            corners: self.corners,
            added_creases: self.added_creases,
            options: *self.options,
            reliefs: self.reliefs,
            refinement: self.refinement,
            data: self.data,
        }
    }
}

pub(super) fn gradients(data: &HermiteMesh) -> Vec<Vec3> {
    data.mesh().half_edges().map(|h| data.gradient(h)).collect()
}

/// Fewer edges are not worth sharing out between threads.
const FEW: usize = 512;

/// μ_4 and ν_1 have to be larger: at −1/2 the free parameter has no hold on the surface over the edge.
const LEAST_REACH: f64 = -0.5;
