//! Flat refinement: a mesh of the same shape with more faces around some vertices.
//!
//! ```text
//!           v                      v            The corner of each face at v is cut off, at a part of the length of
//!          /|\                    /|\           its edges. New vertices are inside straight edges: they see the two faces
//!         / | \                m_0─m_1─m_2      there from a whole lune of directions. Every vertex that there was sees
//!        /  |  \      ──►      /  \|\  \        what it saw.
//!       /   |   \             /    | \  \
//!     w_0──w_1──w_2          w_0──w_1──w_2
//! ```
//!
//! A hull fails where the normals of neighbouring vertices cannot be had together; after this, what stands between them can be
//! chosen freely.

use super::builder::Builder;
use super::corner;
use super::hermite::HermiteMesh;
use super::options::RobustApexes;
use super::repair::{self, normal_at};
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, VertexId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// How corners are cut off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Way {
    /// Equally long pieces of all edges; apexes around the vertex on parallel lines.
    #[default]
    Equal,
    /// At the same part of all edges; apexes as elsewhere.
    AtPart,
}

/// All, in the order in which they are tried.
const WAYS: [Way; 2] = [Way::Equal, Way::AtPart];

/// A finer mesh of the same shape. The vertices that there were keep their numbers; of the faces, one piece of each does.
pub(super) struct Refined {
    pub data: HermiteMesh,
    /// For each face that in which it lies.
    pub face_source: Vec<FaceId>,
    /// For each edge that on which it lies.
    pub edge_source: Vec<Option<EdgeId>>,
    /// For each new vertex the edge on which it lies, by its ends, the nearer one first; or a vertex of its face, twice.
    pub vertex_source: Vec<[VertexId; 2]>,
}

/// A corner of a piece of a face.
#[derive(Clone, Copy)]
struct Point {
    number: u32,
    /// The edges of the face on which it lies.
    on: [Option<usize>; 2],
    gradient: Vec3,
}

/// Where edges are cut, as parts of their lengths.
const FARTHEST: f64 = 1.0 / 3.0;
const NEAREST: f64 = 1e-3;

/// Best product with the normals of the faces at a vertex below which its edges are not all cut at the same part.
pub(super) const HARDLY_SEEN: f64 = 0.1;

/// Sine of the angle between an edge and the tangent plane from which on it is steep.
const STEEP: f64 = 0.5;

/// Cosine of that angle from which on the normal at the other end of the edge says nothing.
const LEAST_FLATNESS: f64 = 1e-6;

struct Cutter<'a> {
    data: &'a HermiteMesh,
    is_cut: Vec<bool>,
    /// Where edges are cut at their start and their end, as a part of their length.
    fractions: Vec<[f64; 2]>,
    positions: Vec<Point3>,
    sources: Vec<[VertexId; 2]>,
    /// Per edge, the vertices near its start and its end.
    on_edge: Vec<[Option<u32>; 2]>,
}

/// The mesh with the corners of all faces at some vertices cut off; none where that leaves faces without area.
pub(super) fn cut_corners(data: &HermiteMesh, vertices: &[VertexId], way: Way) -> Option<Refined> {
    let mesh = data.mesh();
    let mut is_cut = vec![false; mesh.vertex_count()];
    vertices.iter().for_each(|v| is_cut[v.index()] = true);
    let mut cutter = Cutter {
        data,
        is_cut,
        fractions: vec![[FARTHEST; 2]; mesh.edge_count()],
        positions: data.positions().to_vec(),
        sources: Vec::new(),
        on_edge: vec![[None; 2]; mesh.edge_count()],
    };
    vertices.iter().for_each(|v| cutter.level(*v, way));
    mesh.edges().for_each(|e| cutter.cut_edge(e));
    let mut pieces = Pieces::default();
    let mut more = Pieces::default();
    for f in mesh.faces() {
        let (first, others) = cutter.pieces(f);
        pieces.push(mesh, f, first);
        others.into_iter().for_each(|piece| more.push(mesh, f, piece));
    }
    pieces.append(more);
    pieces.into_mesh(cutter)
}

impl Cutter<'_> {
    /// Cuts the edges at a vertex where they are equally high above or deep below its tangent plane, as far as can be.
    fn level(&mut self, v: VertexId, way: Way) {
        let hardly_seen = repair::best_visibility(self.data, v) < HARDLY_SEEN;
        let mesh = self.data.mesh();
        let p = self.data.positions()[v.index()];
        let edges = mesh.ring(v).flat_map(|h| [h, mesh.prev(h)]).map(|h| {
            let (e, starts) = (mesh.edge(h), mesh.origin(h) == v);
            let (w, corner) = if starts { (mesh.dest(h), h) } else { (mesh.origin(h), mesh.next(h)) };
            let at = usize::from((mesh.edge_half_edge(e) == h) != starts);
            let edge = self.data.positions()[w.index()] - p;
            let rise = edge.dot(&self.data.gradient(corner).normalize()).abs();
            match (way, hardly_seen) {
                (Way::AtPart, _) => (e, at, edge.norm(), false),
                (_, true) => (e, at, rise, rise > STEEP * edge.norm()),
                (_, false) => (e, at, edge.norm(), true),
            }
        });
        let edges: Vec<_> = edges.collect();
        let steep = edges.iter().filter(|edge| edge.3).map(|edge| edge.2);
        let level = FARTHEST * steep.fold(f64::INFINITY, f64::min);
        for (e, at, rise, steep) in edges {
            let fraction = if steep { (level / rise).clamp(NEAREST, FARTHEST) } else { FARTHEST };
            self.fractions[e.index()][at] = fraction;
        }
    }

    fn cut_edge(&mut self, e: EdgeId) {
        let mesh = self.data.mesh();
        let h = mesh.edge_half_edge(e);
        let ends = [mesh.origin(h), mesh.dest(h)];
        for (n, [v, w]) in [ends, [ends[1], ends[0]]].into_iter().enumerate() {
            if self.is_cut[v.index()] {
                let [p, q] = [v, w].map(|v| self.data.positions()[v.index()]);
                self.on_edge[e.index()][n] = Some(self.positions.len() as u32);
                self.positions.push(p + self.fractions[e.index()][n] * (q - p));
                self.sources.push([v, w]);
            }
        }
    }

    /// The point on an edge of a face near its start (0) or its end (1), if it was cut there.
    fn point(&self, h: HalfEdgeId, end: usize) -> Option<Point> {
        let mesh = self.data.mesh();
        let (e, k) = (mesh.edge(h), mesh.side(h));
        let along = if mesh.edge_half_edge(e) == h { end } else { 1 - end };
        let number = self.on_edge[e.index()][along]?;
        Some(Point { number, on: [Some(k), None], gradient: self.gradient(h, end) })
    }

    /// The gradient at a new vertex, on the side of a face: between those at the ends of the edge and perpendicular to it, or, if
    /// that hardly sees the faces there, the mean of their normals.
    fn gradient(&self, h: HalfEdgeId, end: usize) -> Vec3 {
        let mesh = self.data.mesh();
        // Seen one way, so that the faces on both sides of a smooth edge find the same.
        let (h, end) = match self.data.joint(mesh.edge(h)) {
            Some([first, _]) if first != h => (first, 1 - end),
            _ => (h, end),
        };
        let (corner, [v, w]) = match end {
            0 => (h, [mesh.origin(h), mesh.dest(h)]),
            _ => (mesh.next(h), [mesh.dest(h), mesh.origin(h)]),
        };
        let [p, q] = [v, w].map(|v| self.data.positions()[v.index()]);
        let along = (q - p).normalize();
        let gradient = self.data.gradient(corner);
        let (length, normal) = (gradient.norm(), gradient.normalize());
        let slope = normal.dot(&along);
        let across = normal - slope * along;
        let flatness = across.norm();
        let beside = self.data.joint(mesh.edge(h)).map_or([h, h], |pair| pair);
        let normals = beside.map(|h| normal_at(self.data, h));
        let middle = (normals[0] + normals[1]).try_normalize(0.0).unwrap_or(normals[0]);
        if flatness < LEAST_FLATNESS || !normals.iter().all(|n| n.dot(&across) > 0.0) {
            return length * middle;
        }
        length / flatness * across
    }

    /// The pieces of a face; the first one is at a corner that is cut off, or the whole face.
    fn pieces(&mut self, f: FaceId) -> ([Point; 3], Vec<[Point; 3]>) {
        let mesh = self.data.mesh();
        let h = [0, 1, 2].map(|k| HalfEdgeId(3 * f.0 + k));
        let corner = |k: usize| Point {
            number: mesh.origin(h[k]).0,
            on: [Some(k), Some((k + 2) % 3)],
            gradient: self.data.gradient(h[k]),
        };
        let (mut corners, mut rest) = (Vec::new(), Vec::new());
        for k in 0..3 {
            match (self.point(h[(k + 2) % 3], 1), self.point(h[k], 0)) {
                (Some(before), Some(behind)) => {
                    corners.push([corner(k), behind, before]);
                    rest.extend([before, behind]);
                }
                _ => rest.push(corner(k)),
            }
        }
        if corners.is_empty() {
            return ([0, 1, 2].map(corner), Vec::new());
        }
        let first = corners.remove(0);
        let whole = |k: usize| !self.is_cut[mesh.origin(h[k]).index()];
        match rest.len() {
            4 => {
                let at = |n: usize| self.positions[rest[n].number as usize];
                // From a corner that is cut off on, so that no diagonal is an edge.
                if (at(0) - at(2)).norm() <= (at(1) - at(3)).norm() {
                    corners.extend([[rest[0], rest[1], rest[2]], [rest[0], rest[2], rest[3]]]);
                } else {
                    corners.extend([[rest[1], rest[2], rest[3]], [rest[1], rest[3], rest[0]]]);
                }
            }
            5 => {
                let start = (0..3).find(|k| whole(*k)).map_or(0, |k| 2 * k);
                let at = |n: usize| rest[(start + n) % 5];
                corners.extend((1..4).map(|n| [at(0), at(n), at(n + 1)]));
            }
            _ => {
                let center = self.center(f);
                corners.extend((0..6).map(|n| [center, rest[n], rest[(n + 1) % 6]]));
            }
        }
        (first, corners)
    }

    /// A vertex in the middle of a face, with its normal.
    fn center(&mut self, f: FaceId) -> Point {
        let number = self.positions.len() as u32;
        let [a, b, c] = self.data.corners(f);
        self.positions.push(a + ((b - a) + (c - a)) / 3.0);
        let first = self.data.mesh().triangle(f)[0];
        self.sources.push([first; 2]);
        let length = self.data.corner_gradients(f).map(|n| n.norm()).iter().sum::<f64>() / 3.0;
        let normal = normal_at(self.data, HalfEdgeId(3 * f.0));
        Point { number, on: [None; 2], gradient: length * normal }
    }
}

/// Pieces of faces, as lists.
#[derive(Default)]
struct Pieces {
    faces: Vec<[u32; 3]>,
    gradients: Vec<Vec3>,
    sources: Vec<FaceId>,
    /// Per half edge.
    edges: Vec<Option<EdgeId>>,
}

impl Pieces {
    fn push(&mut self, mesh: &HalfEdgeMesh, f: FaceId, piece: [Point; 3]) {
        self.faces.push(piece.map(|p| p.number));
        self.gradients.extend(piece.map(|p| p.gradient));
        self.sources.push(f);
        for k in 0..3 {
            let [a, b] = [piece[k], piece[(k + 1) % 3]];
            let side = a.on.into_iter().flatten().find(|side| b.on.contains(&Some(*side)));
            self.edges.push(side.map(|side| mesh.edge(HalfEdgeId(3 * f.0 + side as u32))));
        }
    }

    fn append(&mut self, other: Self) {
        self.faces.extend(other.faces);
        self.gradients.extend(other.gradients);
        self.sources.extend(other.sources);
        self.edges.extend(other.edges);
    }

    fn into_mesh(self, cutter: Cutter<'_>) -> Option<Refined> {
        let mesh = HalfEdgeMesh::from_faces(cutter.positions.len(), &self.faces).ok()?;
        let edge_source: Vec<Option<EdgeId>> =
            mesh.edges().map(|e| self.edges[mesh.edge_half_edge(e).index()]).collect();
        let sharp = edge_source.iter().map(|e| e.is_some_and(|e| cutter.data.is_crease(e))).collect();
        let data = HermiteMesh::with_creases(mesh, cutter.positions, self.gradients, sharp).ok()?;
        Some(Refined { data, face_source: self.sources, edge_source, vertex_source: cutter.sources })
    }
}

/// Rounds of refinement in a row.
const ROUNDS: usize = 8;

/// Best product with the normals of the faces at a vertex up to which it counts as seen from nowhere: cells over faces that are seen at
/// less than a degree are so thin that their patches turn over, whatever is done in the planes of the faces (tried on a hand and a
/// pig, at 7e-4 to 0.019). Rounding changes them.
const LEAST_SEEN: f64 = 0.02;

/// Most times that corners are cut off at one vertex.
const MOST_CUTS: usize = 4;

/// Refines around vertices at fault in the first way after which nothing is at fault any more, or else in the one with the fewest
/// corners and creases, which may be none at all.
pub(super) fn refine_or_cut(builder: &mut Builder<'_>, rule: &RobustApexes) {
    if builder.score.0 > 0 {
        builder.keep_given();
    }
    let mut best: Option<Builder<'_>> = None;
    let count = |builder: &Builder<'_>| builder.corners.len() + builder.added_creases.len();
    for way in WAYS.into_iter().map(Some).chain([None]) {
        if builder.score.0 == 0 {
            return;
        }
        if way.is_some() && builder.refinement.is_off {
            continue;
        }
        let mut tried = builder.clone();
        if let Some(way) = way {
            tried.refinement.way = way;
            refine_around_faults(&mut tried, rule);
        }
        let is_whole = tried.score.0 == 0;
        corner::make_corners(&mut tried, rule);
        if best.as_ref().is_none_or(|best| count(&tried) < count(best)) {
            best = Some(tried);
        }
        if is_whole {
            break;
        }
    }
    if let Some(best) = best {
        *builder = best;
    }
}

/// Refines around vertices at fault, and repairs what is left, until nothing is or that does not help.
pub(super) fn refine_around_faults(builder: &mut Builder<'_>, rule: &RobustApexes) {
    for _ in 0..ROUNDS {
        let vertices = repair::at_fault(builder);
        if builder.effort == 0 || !refine_at(builder, vertices, rule) {
            break;
        }
        repair::repair(builder, rule);
    }
}

/// Refines around these vertices, where that has not been done too often; those that nothing sees become corners.
pub(super) fn refine_at(builder: &mut Builder<'_>, mut vertices: Vec<VertexId>, rule: &RobustApexes) -> bool {
    if builder.refinement.is_off {
        return false;
    }
    vertices.sort_unstable();
    vertices.dedup();
    vertices.retain(|v| builder.refinement.cuts.get(v).is_none_or(|n| *n < MOST_CUTS));
    repair::show_hidden_normals(builder, &vertices);
    if vertices.is_empty() || !builder.refine(&vertices) {
        return false;
    }
    for v in vertices {
        *builder.refinement.cuts.entry(v).or_insert(0) += 1;
        if repair::best_visibility(&builder.data, v) <= LEAST_SEEN {
            corner::cut_hidden(builder, v, rule);
        }
    }
    true
}

/// What flat refinement did to a mesh, all times together.
#[derive(Clone, Debug, Default)]
pub(super) struct Refinement {
    /// Vertices at which corners of faces were cut off, in order.
    pub vertices: Vec<VertexId>,
    /// For each face that of the given mesh in which it lies; empty if nothing was refined.
    pub faces: Vec<FaceId>,
    /// For each new vertex, two vertices of the given mesh: the ends of its edge, or one vertex of its face twice.
    pub new_vertices: Vec<[VertexId; 2]>,
    /// How they are cut off.
    pub way: Way,
    /// How often corners were cut off at a vertex.
    pub cuts: BTreeMap<VertexId, usize>,
    /// Is nothing to be refined, because it was in vain?
    pub is_off: bool,
    /// The given mesh, if anything was at fault in it.
    pub given: Option<Arc<HermiteMesh>>,
    /// Number of vertices in the given mesh.
    pub given_vertices: usize,
    /// Vertices that were rounded before, in order, and how far new vertices around them are from their edges.
    pub rounded: Vec<VertexId>,
    pub farthest: f64,
}

impl Refinement {
    pub fn extend(
        &mut self,
        vertices: &[VertexId],
        face_source: &[FaceId],
        vertex_source: &[[VertexId; 2]],
        count: usize,
    ) {
        if self.faces.is_empty() {
            self.given_vertices = count;
        }
        self.vertices.extend(vertices.iter().filter(|v| v.index() < self.given_vertices));
        self.vertices.sort_unstable();
        self.vertices.dedup();
        let faces = face_source.iter().map(|f| self.face(*f)).collect();
        let sources: Vec<[VertexId; 2]> = vertex_source.iter().map(|s| self.edge_of(*s)).collect();
        self.faces = faces;
        self.new_vertices.extend(sources);
    }

    /// How many faces there are more than in the given mesh.
    pub fn added_faces(&self) -> usize {
        let given = self.faces.iter().map(|f| f.index() + 1).max().unwrap_or(0);
        self.faces.len() - given
    }

    /// Is this none of the vertices of the given mesh?
    pub fn is_new(&self, v: VertexId) -> bool {
        !self.faces.is_empty() && v.index() >= self.given_vertices
    }

    /// The face of the given mesh in which a face lies.
    pub fn face(&self, f: FaceId) -> FaceId {
        self.faces.get(f.index()).copied().unwrap_or(f)
    }

    /// The vertices of the given mesh between which a vertex is; those that are there are themselves.
    pub fn vertex(&self, v: VertexId) -> [VertexId; 2] {
        let new = || self.new_vertices.get(v.index() - self.given_vertices).copied();
        self.is_new(v).then(new).flatten().unwrap_or([v; 2])
    }

    /// The same for what is between two vertices, if it is on an edge of the given mesh; the first one of them, if not.
    pub fn edge_of(&self, [v, w]: [VertexId; 2]) -> [VertexId; 2] {
        let [[a, b], [c, d]] = [v, w].map(|v| self.vertex(v));
        let mut ends = vec![a, b, c, d];
        ends.sort_unstable();
        ends.dedup();
        match ends[..] {
            [first, second] => [first, second],
            _ => [a, a],
        }
    }
}
