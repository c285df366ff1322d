//! Puts apexes over the faces of a mesh and checks what stands between them.

use super::class::{Class, Side, bend};
use super::corner;
use super::crease;
use super::edge::{EdgeCell, EdgeFrame};
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::problem::{Problem, Reason};
use super::relief::Reliefs;
use super::repair;
use super::shear;
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId};
use rayon::prelude::*;
use std::f64::consts::PI;

/// How far apexes stay above the tangent planes of their faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Margin {
    /// Times the smallest distance from the centroid of the face to its edges.
    Relative(f64),
    /// A length in model units, as in the paper's figures.
    Absolute(f64),
}

impl Margin {
    fn of(self, face: &FaceFrame) -> f64 {
        match self {
            Self::Relative(factor) => factor * face.inner_radius,
            Self::Absolute(length) => length,
        }
    }
}

/// Where apexes go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApexRule {
    /// On the normal of the face, at the height of the paper's §3.1. Gradients are left as they are.
    Paper,
    /// On the mean of the vertex normals, as low as layer 1 allows, and higher or elsewhere where that does not fit.
    Robust(RobustApexes),
}

/// What the robust rule tries. The defaults are those that were good on fifteen scanned and modelled meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustApexes {
    /// A vertex normal whose product with the unit normal of a face around it is less gives way to the most visible
    /// direction; default 0.15.
    pub visibility: f64,
    /// The mean of the vertex normals whose product with the unit normal of the face is less gives way to that; default
    /// 0.3.
    pub facing: f64,
    /// Apexes are raised while μ_4 or ν_1 of an edge cell is less; default −0.45, above the −1/2 where the cell fails.
    pub reach: f64,
    /// Apexes are raised while an edge cell opens wider than this many radians; default 0.97 π.
    pub widest: f64,
    /// What a height is multiplied by; default 1.3.
    pub raise: f64,
    /// Most times it is; default 12.
    pub raises: usize,
    /// Rounds of other directions and normals for what is still wrong, each linear in the number of such faces; default 3.
    pub repairs: usize,
    /// Make creases and corners where nothing else helps, until no problem remains; default true.
    pub corners: bool,
}

impl Default for RobustApexes {
    fn default() -> Self {
        Self {
            visibility: 0.15,
            facing: 0.3,
            reach: -0.45,
            widest: 0.97 * PI,
            raise: 1.3,
            raises: 12,
            repairs: 3,
            corners: true,
        }
    }
}

/// Options of [`build`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullOptions {
    /// Where apexes go; default robust.
    pub rule: ApexRule,
    /// How far they stay above tangent planes; default 0.05 of the distance from the centroid to the edges.
    pub margin: Margin,
}

impl Default for HullOptions {
    fn default() -> Self {
        Self { rule: ApexRule::Robust(RobustApexes::default()), margin: Margin::Relative(0.05) }
    }
}

/// A face of the hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace {
    /// How the surface bends over it.
    pub class: Class,
    /// Unit direction of the line through the centroid on which its apexes are.
    pub direction: Vec3,
    /// Heights of the outer and the inner apex over the centroid, whether the side has a cell or not.
    pub heights: [f64; 2],
    /// The apexes of its cells: u on the outer side, v on the inner side.
    pub apexes: [Option<Point3>; 2],
}

/// An edge of the hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullEdge {
    /// How the surface bends over it; seen from the left face if it is a crease.
    pub class: Class,
    /// Its cells on the outer and the inner side; a boundary or a crease has none.
    pub cells: [Option<EdgeCell>; 2],
}

/// The simplicial hull of a mesh.
#[derive(Clone, Debug)]
pub struct Hull {
    data: HermiteMesh,
    faces: Vec<HullFace>,
    edges: Vec<HullEdge>,
    problems: Vec<Problem>,
    moved_normals: Vec<VertexId>,
    corners: Vec<Corner>,
    added_creases: Vec<AddedCrease>,
    options: HullOptions,
    pub(super) reliefs: Reliefs,
}

/// A vertex that was given several normals, because no single one would do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// The vertex.
    pub vertex: VertexId,
    /// Why: what was wrong there, or at a face there.
    pub reason: Reason,
}

/// An edge that was made a crease, because the surface cannot be smooth across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddedCrease {
    /// The edge.
    pub edge: EdgeId,
    /// Why: what was wrong there, or at one of its ends.
    pub reason: Reason,
}

/// A hull taken apart, as files have it.
#[derive(Clone, Debug)]
pub struct HullParts {
    /// See [`Hull::data`].
    pub data: HermiteMesh,
    /// See [`Hull::faces`].
    pub faces: Vec<HullFace>,
    /// See [`Hull::edges`].
    pub edges: Vec<HullEdge>,
    /// See [`Hull::problems`].
    pub problems: Vec<Problem>,
    /// See [`Hull::moved_normals`].
    pub moved_normals: Vec<VertexId>,
    /// See [`Hull::corners`].
    pub corners: Vec<Corner>,
    /// See [`Hull::added_creases`].
    pub added_creases: Vec<AddedCrease>,
}

impl From<HullParts> for Hull {
    /// The hull of parts that belong together: one face and one edge for each of the mesh. Should it be changed, the default
    /// options hold.
    fn from(parts: HullParts) -> Self {
        let HullParts { data, faces, edges, problems, moved_normals, corners, added_creases } = parts;
        let (options, reliefs) = (HullOptions::default(), Reliefs::default());
        Self { data, faces, edges, problems, moved_normals, corners, added_creases, options, reliefs }
    }
}

impl Hull {
    /// What is interpolated. Its gradients are those given, but for [`Hull::moved_normals`].
    pub fn data(&self) -> &HermiteMesh {
        &self.data
    }

    /// The faces, in the order of the mesh.
    pub fn faces(&self) -> &[HullFace] {
        &self.faces
    }

    /// The edges, in the order of the mesh; the left face of an edge is that of its half edge.
    pub fn edges(&self) -> &[HullEdge] {
        &self.edges
    }

    /// Every element that is not valid: vertices, then faces, then edges, in order.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Vertices whose gradient was turned so that it sees the faces around it.
    pub fn moved_normals(&self) -> &[VertexId] {
        &self.moved_normals
    }

    /// Vertices that were given several normals so that no problem remains, in order. Those of tagged creases are not among them.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Edges that were made creases so that no problem remains, in order: those of the corners, and single ones.
    pub fn added_creases(&self) -> &[AddedCrease] {
        &self.added_creases
    }

    /// Faces that have a problem themselves or at one of their edges, in order.
    pub fn bad_faces(&self) -> Vec<FaceId> {
        let mut faces: Vec<FaceId> = self
            .problems
            .iter()
            .flat_map(|problem| match problem {
                Problem::Vertex { .. } => [None, None],
                Problem::Face { face, .. } => [Some(*face), None],
                Problem::Edge { faces, .. } => faces.map(Some),
            })
            .flatten()
            .collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// May the patch over a face turn over? If so it has to be looked at.
    pub fn is_delicate(&self, f: FaceId) -> bool {
        let mesh = self.data.mesh();
        let leans = |e| crease::fault(&self.data, e, &crease::HARMLESS).is_some();
        shear::corners_fold(&self.face_frame(f), &self.faces[f.index()])
            || mesh.face_half_edges(f).map(|h| mesh.edge(h)).any(|e| self.data.is_crease(e) && leans(e))
    }

    /// May the patch over an edge turn over?
    pub fn is_delicate_edge(&self, e: EdgeId) -> bool {
        shear::crossing_folds(&self.data, &self.faces, e, self.edges[e.index()].class, HARMLESS_SHEAR)
    }

    /// Corners and gradients of a face.
    pub fn face_frame(&self, f: FaceId) -> FaceFrame {
        frame(&self.data, f)
    }

    /// Apexes of the left and the right face of an edge on a side, where it has a cell.
    pub fn edge_apexes(&self, e: EdgeId, side: Side) -> Option<[Point3; 2]> {
        apexes_beside(&self.data, &self.faces, e, side)
    }
}

/// Takes a finished hull to pieces, lets `change` alter it, and finishes it again.
pub(super) fn altered<T>(
    hull: Hull,
    change: impl FnOnce(&mut Builder<'_>, &RobustApexes) -> T,
) -> (Hull, Option<T>) {
    let ApexRule::Robust(rule) = hull.options.rule else { return (hull, None) };
    let options = hull.options;
    let given = gradients(&hull.data);
    let moved = hull.moved_normals;
    let mut builder = Builder::with_faces(hull.data, hull.faces, given, &options);
    builder.corners = hull.corners;
    builder.added_creases = hull.added_creases;
    builder.reliefs = hull.reliefs;
    let result = change(&mut builder, &rule);
    let mut hull = builder.finish();
    hull.moved_normals.extend(moved);
    hull.moved_normals.sort_unstable();
    hull.moved_normals.dedup();
    let is_corner = |v: &VertexId| hull.corners.binary_search_by_key(v, |c| c.vertex).is_ok();
    let moved = hull.moved_normals.iter().copied().filter(|v| !is_corner(v)).collect();
    hull.moved_normals = moved;
    (hull, Some(result))
}

fn gradients(data: &HermiteMesh) -> Vec<Vec3> {
    data.mesh().half_edges().map(|h| data.gradient(h)).collect()
}

fn frame(data: &HermiteMesh, f: FaceId) -> FaceFrame {
    FaceFrame::new(data.corners(f), data.corner_gradients(f))
}

fn apexes_beside(data: &HermiteMesh, faces: &[HullFace], e: EdgeId, side: Side) -> Option<[Point3; 2]> {
    let [h, g] = data.joint(e)?.map(|h| faces[data.mesh().face(h).index()].apexes[side.index()]);
    Some([h?, g?])
}

/// Builds the hull of a mesh: classes, apexes, edge cells, and a list of what does not fit.
///
/// Linear in the number of faces. The paper's rule follows §3.1; the robust rule then raises apexes, and looks for other
/// directions and, at the vertices concerned, other normals, for the faces where that fails.
pub fn build(data: HermiteMesh, options: &HullOptions) -> Hull {
    let mut builder = Builder::new(data, options);
    if let ApexRule::Robust(rule) = options.rule {
        builder.raise((0..builder.edges.len()).map(EdgeId::from).collect(), &rule);
        repair::repair(&mut builder, &rule);
        if rule.corners {
            corner::make_corners(&mut builder, &rule);
        }
    }
    builder.finish()
}

/// A hull in the making. `faults` counts, per face, what is wrong with it and its edges.
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
    pub corners: Vec<Corner>,
    pub added_creases: Vec<AddedCrease>,
    pub reliefs: Reliefs,
}

/// What was there before a change.
enum Change {
    Face(FaceId, HullFace),
    Gradient(HalfEdgeId, Vec3),
    Crease(EdgeId),
}

impl<'a> Builder<'a> {
    fn new(mut data: HermiteMesh, options: &'a HullOptions) -> Self {
        let given = gradients(&data);
        if let ApexRule::Robust(rule) = options.rule {
            repair::turn_hidden_normals(&mut data, rule.visibility);
        }
        let faces: Vec<HullFace> = (0..data.mesh().face_count())
            .into_par_iter()
            .map(|f| {
                let frame = frame(&data, f.into());
                placed(&frame, default_direction(&frame, options), options)
            })
            .collect();
        Self::with_faces(data, faces, given, options)
    }

    /// With faces that are placed already; everything is checked.
    fn with_faces(
        data: HermiteMesh,
        faces: Vec<HullFace>,
        given: Vec<Vec3>,
        options: &'a HullOptions,
    ) -> Self {
        let edge_count = data.mesh().edge_count();
        let blank = HullEdge { class: Class::Zero, cells: [None; 2] };
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
            corners: Vec::new(),
            added_creases: Vec::new(),
            reliefs: Reliefs::default(),
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
            edges.par_iter().map(make).collect()
        };
        for (e, edge) in edges.iter().zip(made) {
            let faults = edge.cells.iter().flatten().filter_map(|cell| cell.fault(LEAST_REACH));
            let of_crease = || crease::fault(&self.data, *e, &crease::WIDEST).map(|(_, reason)| reason);
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
    fn raise(&mut self, mut edges: Vec<EdgeId>, rule: &RobustApexes) {
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

    fn edges_around(&self, faces: impl Iterator<Item = FaceId>) -> Vec<EdgeId> {
        let mut edges: Vec<EdgeId> = faces.flat_map(|f| self.edges_of(f)).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
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
        self.journal.clear();
        for e in creases {
            if self.data.is_crease(*e) {
                continue;
            }
            self.journal.push(Change::Crease(*e));
            self.data.set_crease(*e, true);
        }
        for (corner, gradient) in gradients {
            self.journal.push(Change::Gradient(*corner, self.data.gradient(*corner)));
            self.data.set_gradient(*corner, *gradient);
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
        let journal = std::mem::take(&mut self.journal);
        let mut touched = Vec::new();
        for change in journal.into_iter().rev() {
            match change {
                Change::Face(f, face) => {
                    self.faces[f.index()] = face;
                    touched.push(f);
                }
                Change::Gradient(corner, gradient) => self.data.set_gradient(corner, gradient),
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

    /// The direction that a face has before anything is repaired.
    pub fn default_direction(&self, f: FaceId) -> Vec3 {
        default_direction(&self.frame(f), self.options)
    }

    fn finish(mut self) -> Hull {
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
        let moved_normals = mesh.vertices().filter(|v| moved(v) && !is_corner(v)).collect();
        Hull {
            faces: self.faces,
            edges: self.edges,
            problems,
            moved_normals,
            corners: self.corners,
            added_creases: self.added_creases,
            options: *self.options,
            reliefs: self.reliefs,
            data: self.data,
        }
    }
}

/// Sines of the angles in patches that go through their edge above which these do not turn over.
const HARMLESS_SHEAR: f64 = 0.6;

/// How often apexes are raised so that a patch does not turn over; where that takes more, it makes the shape worse.
const RAISES_FOR_FOLDS: usize = 5;

/// Fewer edges are not worth sharing out between threads.
const FEW: usize = 512;

/// μ_4 and ν_1 have to be larger: at −1/2 the free parameter has no hold on the surface over the edge.
const LEAST_REACH: f64 = -0.5;

/// Mean direction of the gradients of a face for the robust rule, its normal for the paper's.
fn default_direction(frame: &FaceFrame, options: &HullOptions) -> Vec3 {
    match options.rule {
        ApexRule::Paper => frame.normal,
        ApexRule::Robust(rule) => repair::facing(repair::mean_normal(frame), frame, rule.facing),
    }
}

/// A face with its apexes on the line in `direction`.
fn placed(frame: &FaceFrame, direction: Vec3, options: &HullOptions) -> HullFace {
    let class = Class::of_face([0, 1, 2].map(|k| frame.edge_class(k)));
    let margin = options.margin.of(frame);
    let heights = Side::BOTH.map(|side| match options.rule {
        ApexRule::Paper => frame.paper_height(side, &direction, margin),
        ApexRule::Robust(_) if !class.reaches(side) => 0.0,
        // Without a valid height, one that does not spoil the neighbours more than needed; the face is reported.
        ApexRule::Robust(_) => frame.lowest_height(side, &direction, margin).unwrap_or(frame.inner_radius),
    });
    let mut face = HullFace { class, direction, heights, apexes: [None; 2] };
    face.apexes = apexes(frame, &face);
    if let ApexRule::Robust(rule) = options.rule {
        let low = face;
        for _ in 0..=RAISES_FOR_FOLDS {
            if !shear::corners_fold(frame, &face) {
                return face;
            }
            face.heights = face.heights.map(|height| rule.raise * height);
            face.apexes = apexes(frame, &face);
        }
        return low;
    }
    face
}

fn apexes(frame: &FaceFrame, face: &HullFace) -> [Option<Point3>; 2] {
    Side::BOTH.map(|side| {
        let height = face.heights[side.index()];
        face.class.reaches(side).then(|| frame.apex(side, &face.direction, height))
    })
}

fn face_fault(frame: &FaceFrame, face: &HullFace) -> Option<Reason> {
    if !frame.n.iter().all(|n| n.dot(&frame.normal) > 0.0) {
        return Some(Reason::NoVisibleNormal);
    }
    let low = Side::BOTH.into_iter().any(|side| {
        let apex = face.apexes[side.index()];
        apex.is_some_and(|apex| !frame.layer1(side, &apex).is_copositive())
    });
    low.then_some(Reason::NoApex)
}

fn made_edge(data: &HermiteMesh, faces: &[HullFace], e: EdgeId) -> HullEdge {
    let mesh = data.mesh();
    let h = mesh.edge_half_edge(e);
    let [i, j] = [mesh.origin(h), mesh.dest(h)].map(|v| data.positions()[v.index()]);
    let [n_i, n_j] = [h, mesh.next(h)].map(|h| data.gradient(h));
    let class = Class::of_edge(bend(&i, &j, &n_i), bend(&j, &i, &n_j));
    let Some([_, g]) = data.joint(e) else { return HullEdge { class, cells: [None; 2] } };
    let [p_k, p_l] = [h, g].map(|h| data.positions()[mesh.origin(mesh.prev(h)).index()]);
    let frame = EdgeFrame { p_i: i, p_j: j, p_k, p_l };
    let cells = Side::BOTH.map(|side| {
        let [u_k, u_l] = class.reaches(side).then(|| apexes_beside(data, faces, e, side))??;
        Some(frame.cell(side, &u_k, &u_l))
    });
    HullEdge { class, cells }
}
