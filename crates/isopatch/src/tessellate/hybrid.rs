use super::{APatchResolution, MAX_INTERVALS, SharingError, TessellateError, Tessellation};
use crate::apatch::Shot;
use crate::apatch::grid::{EdgeTable, GridOut};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points, Vec3};
use crate::hybrid::grid::{PyramidTable, SectorTable, TriangleTable};
use crate::hybrid::{Foot, HybridFunction, HybridSurface};
use crate::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use crate::parallel::Evenly;
use crate::surface::{Domain, PatchId};
use rayon::prelude::*;

/// A tessellation of a hybrid surface.
#[derive(Clone, Debug, PartialEq)]
pub struct HybridTessellation {
    /// In triangles.
    pub mesh: Tessellation,
    /// The same points in quadrilaterals, where patches are squares: pyramids, and edges.
    pub quads: Vec<[u32; 4]>,
    /// The triangles that these do not replace.
    pub triangles: Vec<[u32; 3]>,
}

/// Samples every patch and joins the points to triangles, and to quadrilaterals where patches are squares.
///
/// First come the vertices of the mesh; then, per edge, the points of its patch with both of its borders (or of its straight
/// line) from start to end; then the interior points of each face. Borders are evaluated once, with the patch over the edge, so
/// there are no cracks. A crease that is not straight is sampled on its left face. The result does not depend on the number of
/// threads.
pub fn tessellate_hybrid(
    surface: &HybridSurface,
    resolution: APatchResolution,
) -> Result<HybridTessellation, TessellateError> {
    let APatchResolution { along: n, across: m } = resolution;
    for resolution in [n, m] {
        if resolution == 0 || resolution > MAX_INTERVALS {
            return Err(TessellateError::Resolution { resolution });
        }
    }
    let numbering = Numbering::new(surface, n, m)?;
    let (mut positions, mut normals) = numbering.vertices();
    for (point, normal) in numbering.samples() {
        positions.push(point);
        normals.push(normal);
    }
    if let Some(at) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(TessellateError::NoRoot { patch: numbering.patch_of(at).0 });
    }
    let parts = numbering.parts();
    let mut found = HybridTessellation {
        mesh: Tessellation {
            positions,
            normals,
            triangles: Vec::new(),
            corner_normals: Vec::new(),
            patches: Vec::new(),
        },
        quads: Vec::new(),
        triangles: Vec::new(),
    };
    for (part, patch) in parts {
        found.add(part, patch);
    }
    numbering.number_crease_normals(&mut found.mesh);
    Ok(found)
}

impl HybridTessellation {
    /// Adds a quadrilateral, or a triangle where two of its corners are one, with the last corner repeated.
    fn add(&mut self, [a, b, c, d]: [u32; 4], patch: PatchId) {
        let halves = [[a, b, c], [a, c, d]];
        let whole = halves.into_iter().filter(|[a, b, c]| a != b && b != c && c != a);
        let first = self.mesh.triangles.len();
        self.mesh.triangles.extend(whole);
        let added = &self.mesh.triangles[first..];
        self.mesh.patches.extend(added.iter().map(|_| patch));
        match added {
            [_, _] => self.quads.push([a, b, c, d]),
            some => self.triangles.extend_from_slice(some),
        }
    }
}

/// A point of the lattice of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Node {
    /// Point i of edge k, from the start of the edge; 0 is the corner.
    Border(usize, usize),
    /// An interior point, by its number in the face.
    Interior(usize),
}

/// The lattice over a face with n intervals along each edge.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    n: usize,
    domain: Domain,
}

impl Lattice {
    /// Number of interior points.
    fn interior(&self) -> usize {
        let n = self.n;
        match self.domain {
            Domain::Triangle => (n - 1) * n.saturating_sub(2) / 2,
            Domain::Square => (n - 1) * (n - 1),
            Domain::Polygon(corners) => 1 + usize::from(corners) * n * (n - 1) / 2,
        }
    }

    /// Point (i, j, k) of a triangle, i + j + k = n.
    fn in_triangle(&self, [i, j, k]: [usize; 3]) -> Node {
        match (i, j, k) {
            (_, _, 0) if j < self.n => Node::Border(0, j),
            (0, _, _) if k < self.n => Node::Border(1, k),
            (_, 0, _) => Node::Border(2, i),
            _ => Node::Interior(index::position([i - 1, j - 1, k - 1])),
        }
    }

    /// Point (i, j) of a square.
    fn in_square(&self, i: usize, j: usize) -> Node {
        let n = self.n;
        match (i, j) {
            (_, 0) if i < n => Node::Border(0, i),
            (_, _) if i == n && j < n => Node::Border(1, j),
            (_, _) if j == n && i > 0 => Node::Border(2, n - i),
            (0, _) => Node::Border(3, n - j),
            _ => Node::Interior((j - 1) * (n - 1) + i - 1),
        }
    }

    /// Point j of sector k on ring r around the center of a polygon; ring n is the border.
    fn in_polygon(&self, corners: usize, k: usize, r: usize, j: usize) -> Node {
        // The end of a sector is the start of the next one.
        let (k, j) = if j == r { (if k + 1 == corners { 0 } else { k + 1 }, 0) } else { (k, j) };
        match r {
            0 => Node::Interior(0),
            _ if r == self.n => Node::Border(k, j),
            _ => Node::Interior(1 + k * self.n * (self.n - 1) / 2 + r * (r - 1) / 2 + j),
        }
    }

    /// The quadrilaterals of the lattice; triangles have their last corner twice.
    fn parts(&self) -> Vec<[Node; 4]> {
        let n = self.n;
        match self.domain {
            Domain::Triangle => {
                let triangle = |t: &[[usize; 3]; 3]| {
                    let [a, b, c] = t.map(|ijk| self.in_triangle(ijk));
                    [a, b, c, c]
                };
                super::small_triangles(n).iter().map(triangle).collect()
            }
            Domain::Square => (0..n)
                .flat_map(|j| (0..n).map(move |i| (i, j)))
                .map(|(i, j)| {
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.in_square(i, j))
                })
                .collect(),
            Domain::Polygon(corners) => {
                let corners = usize::from(corners);
                let mut parts = Vec::with_capacity(corners * n * n);
                for (k, r) in (0..corners).flat_map(|k| (0..n).map(move |r| (k, r))) {
                    let at = |r: usize, j: usize| self.in_polygon(corners, k, r, j);
                    for j in 0..=r {
                        let (a, b, c) = (at(r, j), at(r + 1, j), at(r + 1, j + 1));
                        parts.push([a, b, c, c]);
                        if j < r {
                            let d = at(r, j + 1);
                            parts.push([a, c, d, d]);
                        }
                    }
                }
                parts
            }
        }
    }
}

/// The tables for the points of all patches but the corners and what is on their borders: over edges with their borders to the
/// faces, inside of triangles and squares, and in the sectors of polygons with their start but without the center.
struct Tables {
    over_edge: Vec<[f64; 3]>,
    edge: EdgeTable,
    triangle: TriangleTable,
    pyramid: PyramidTable,
    sector: SectorTable,
}

/// Points and normals from what writes them to a grid.
fn evaluated(count: usize, evaluate: impl Fn(&mut GridOut<'_>)) -> Vec<(Point3, Vec3)> {
    let (mut points, mut normals) = (Points::zeros(count), Points::zeros(count));
    evaluate(&mut GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) });
    (0..count).map(|i| (points.get(i), normals.get(i))).collect()
}

impl Tables {
    fn new(n: usize, m: usize) -> Self {
        let part = |i: usize| i as f64 / n as f64;
        let over_edge: Vec<[f64; 3]> = (1..n)
            .flat_map(|i| (0..=m).map(move |j| (i, j)))
            .map(|(i, j)| [part(n - i), part(i), j as f64 / m as f64])
            .collect();
        // The first corner of the face is at s = t = 1.
        let in_square: Vec<[f64; 2]> = (1..n)
            .flat_map(|j| (1..n).map(move |i| (i, j)))
            .map(|(i, j)| [part(n - i), part(n - j)])
            .collect();
        let in_sector: Vec<[f64; 3]> = (1..n)
            .flat_map(|r| (0..r).map(move |j| (r, j)))
            .map(|(r, j)| [part(n - r), part(r - j), part(j)])
            .collect();
        Self {
            edge: EdgeTable::new(&over_edge),
            over_edge,
            triangle: TriangleTable::new(&triangle::interior_lattice(n)),
            pyramid: PyramidTable::new(&in_square),
            sector: SectorTable::new(&in_sector),
        }
    }

    fn edge(&self, function: &HybridFunction, e: EdgeId) -> Vec<(Point3, Vec3)> {
        evaluated(self.edge.len(), |out| function.evaluate_edge(&self.edge, &self.over_edge, e, out))
    }

    fn face(&self, function: &HybridFunction, f: FaceId) -> Vec<(Point3, Vec3)> {
        match function.face_domain(f) {
            Domain::Triangle => {
                evaluated(self.triangle.len(), |out| self.triangle.evaluate(function, f, out))
            }
            Domain::Square => evaluated(self.pyramid.len(), |out| self.pyramid.evaluate(function, f, out)),
            Domain::Polygon(corners) => {
                let center = function.shoot_from(f, Foot::Sector(0, [1.0, 0.0, 0.0]), [[0.0; 3]; 2]);
                let nan = Vec3::repeat(f64::NAN);
                let mut found = vec![center.map_or((nan, nan), |s| (s.point, s.gradient.normalize()))];
                for k in 0..usize::from(corners) {
                    found.extend(evaluated(self.sector.len(), |out| {
                        self.sector.evaluate(function, f, k, out);
                    }));
                }
                found
            }
        }
    }
}

/// Which number each point has.
struct Numbering<'a> {
    surface: &'a HybridSurface,
    n: usize,
    m: usize,
    /// First point of each edge.
    edge_start: Vec<u32>,
    /// The patch over each edge.
    patch: Vec<Option<PatchId>>,
    /// First interior point of each face, and the first past the last face.
    face_start: Vec<u32>,
}

impl<'a> Numbering<'a> {
    fn new(surface: &'a HybridSurface, n: usize, m: usize) -> Result<Self, TessellateError> {
        let function = surface.function();
        let mesh = function.hull().data.mesh();
        let mut patch = vec![None; mesh.edge_count()];
        for (i, e) in surface.square_edges().iter().enumerate() {
            patch[e.index()] = Some(PatchId((mesh.face_count() + i) as u32));
        }
        let mut total = mesh.vertex_count() as u64;
        let mut next = |count: usize| {
            let first = total;
            total += count as u64;
            first
        };
        let rows = |e: usize| if patch[e].is_some() { m + 1 } else { 1 };
        let edge_start: Vec<u64> = (0..mesh.edge_count()).map(|e| next((n - 1) * rows(e))).collect();
        let mut face_start: Vec<u64> =
            mesh.faces().map(|f| next(Lattice { n, domain: function.face_domain(f) }.interior())).collect();
        face_start.push(total);
        if u32::try_from(total).is_err() {
            let points = u128::from(total);
            return Err(TessellateError::Sharing(SharingError::TooManyPoints { points }));
        }
        let narrow = |starts: Vec<u64>| starts.into_iter().map(|start| start as u32).collect();
        Ok(Self { surface, n, m, edge_start: narrow(edge_start), patch, face_start: narrow(face_start) })
    }

    fn function(&self) -> &'a HybridFunction {
        self.surface.function()
    }

    fn mesh(&self) -> &'a HalfEdgeMesh {
        self.function().hull().data.mesh()
    }

    fn lattice(&self, f: FaceId) -> Lattice {
        Lattice { n: self.n, domain: self.function().face_domain(f) }
    }

    /// The vertices of the mesh with their normals.
    fn vertices(&self) -> (Vec<Point3>, Vec<Vec3>) {
        let data = &self.function().hull().data;
        let normal = |v| data.mesh().ring(v).next().map_or_else(Vec3::z, |h| data.gradient(h).normalize());
        (data.positions().to_vec(), data.mesh().vertices().map(normal).collect())
    }

    /// Points and normals of the edges, then of the interiors of the faces.
    fn samples(&self) -> Vec<(Point3, Vec3)> {
        let (tables, nan) = (Tables::new(self.n, self.m), Vec3::repeat(f64::NAN));
        let found = |shot: Option<Shot>| shot.map_or((nan, nan), |s| (s.point, s.gradient.normalize()));
        let of_edges =
            (0..self.edge_start.len()).into_par_iter().evenly().flat_map_iter(|e| match self.patch[e] {
                Some(_) => tables.edge(self.function(), e.into()),
                None => (1..self.n).map(|i| found(self.on_straight(e.into(), i))).collect(),
            });
        let of_faces = (0..self.mesh().face_count())
            .into_par_iter()
            .evenly()
            .flat_map_iter(|f| tables.face(self.function(), f.into()));
        of_edges.chain(of_faces).collect()
    }

    /// Weights of the start and the end of an edge at point i, the same seen from either end.
    fn weights(&self, i: usize) -> [f64; 2] {
        [(self.n - i) as f64 / self.n as f64, i as f64 / self.n as f64]
    }

    /// Point i of an edge without a patch, on its left face.
    fn on_straight(&self, e: EdgeId, i: usize) -> Option<Shot> {
        let (mesh, function) = (self.mesh(), self.function());
        let h = mesh.edge_half_edge(e);
        let f = mesh.face(h);
        let uv = function.face_domain(f).on_edge(mesh.side(h) as u8, self.weights(i));
        function.shoot_face(f, uv)
    }

    /// Point i of an edge, from its start, on row j across its patch (0 on the right).
    fn on_edge(&self, e: EdgeId, i: usize, j: usize) -> u32 {
        let h = self.mesh().edge_half_edge(e);
        if i == 0 {
            return self.mesh().origin(h).0;
        }
        if i == self.n {
            return self.mesh().dest(h).0;
        }
        let rows = if self.patch[e.index()].is_some() { self.m + 1 } else { 1 };
        self.edge_start[e.index()] + ((i - 1) * rows + j.min(rows - 1)) as u32
    }

    fn on_face(&self, f: FaceId, node: Node) -> u32 {
        let (k, i) = match node {
            Node::Interior(number) => return self.face_start[f.index()] + number as u32,
            Node::Border(k, i) => (k, i),
        };
        let mesh = self.mesh();
        let Some(h) = mesh.face_half_edges(f).nth(k) else { return 0 };
        let e = mesh.edge(h);
        if mesh.edge_half_edge(e) == h { self.on_edge(e, i, self.m) } else { self.on_edge(e, self.n - i, 0) }
    }

    /// Quadrilaterals of all patches; triangles have their last corner twice.
    fn parts(&self) -> Vec<([u32; 4], PatchId)> {
        let of_faces = self.mesh().faces().flat_map(|f| {
            let parts = self.lattice(f).parts().into_iter();
            parts.map(move |nodes| (nodes.map(|node| self.on_face(f, node)), PatchId(f.0)))
        });
        let of_edges = self.surface.square_edges().iter().zip(self.mesh().face_count() as u32..).flat_map(
            |(e, patch)| {
                (0..self.n).flat_map(move |i| (0..self.m).map(move |j| (i, j))).map(move |(i, j)| {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    (corners.map(|(i, j)| self.on_edge(*e, i, j)), PatchId(patch))
                })
            },
        );
        of_faces.chain(of_edges).collect()
    }

    /// The patch that a point was evaluated with.
    fn patch_of(&self, point: usize) -> PatchId {
        let before = |starts: &[u32]| starts.partition_point(|start| *start as usize <= point).checked_sub(1);
        let first_of_faces = self.face_start.first().copied().unwrap_or(0) as usize;
        match before(if point >= first_of_faces { &self.face_start } else { &self.edge_start }) {
            Some(f) if point >= first_of_faces => PatchId(f as u32),
            Some(e) => {
                let left = self.mesh().face(self.mesh().edge_half_edge(EdgeId::from(e)));
                self.patch[e].unwrap_or(PatchId(left.0))
            }
            None => PatchId(0),
        }
    }

    /// Where creases part faces, gives each corner of a triangle the normal of its own face.
    fn number_crease_normals(&self, mesh: &mut Tessellation) {
        let data = &self.function().hull().data;
        if !self.mesh().edges().any(|e| data.is_crease(e)) {
            return;
        }
        // The normals of a face at its border points, where a crease or a corner of one is.
        let mut own = std::collections::HashMap::new();
        for f in self.mesh().faces() {
            for (k, h) in self.mesh().face_half_edges(f).enumerate() {
                let corner = (f, self.mesh().origin(h).0);
                let normal = data.gradient(h).normalize();
                own.insert(corner, numbered(&mut mesh.normals, self.mesh().origin(h).0, normal));
                let e = self.mesh().edge(h);
                if !data.is_crease(e) || self.mesh().edge_half_edge(e) == h {
                    continue;
                }
                for i in 1..self.n {
                    let uv = self.function().face_domain(f).on_edge(k as u8, self.weights(i));
                    let Some(shot) = self.function().shoot_face(f, uv) else { continue };
                    let point = self.on_edge(e, self.n - i, 0);
                    own.insert((f, point), numbered(&mut mesh.normals, point, shot.gradient.normalize()));
                }
            }
        }
        let faces = self.mesh().face_count();
        let number = |(triangle, patch): (&[u32; 3], &PatchId)| {
            let f = match patch.index().checked_sub(faces) {
                None => FaceId(patch.0),
                // At its ends the patch over an edge has the normals of its left face.
                Some(square) => {
                    let e = self.surface.square_edges()[square];
                    self.mesh().face(self.mesh().edge_half_edge(e))
                }
            };
            triangle.map(|point| own.get(&(f, point)).copied().unwrap_or(point))
        };
        mesh.corner_normals = mesh.triangles.iter().zip(&mesh.patches).map(number).collect();
    }
}

/// The number of a normal: that of its point if it is the one there, else a new one.
fn numbered(normals: &mut Vec<Vec3>, point: u32, normal: Vec3) -> u32 {
    if normals[point as usize] == normal {
        return point;
    }
    normals.push(normal);
    normals.len() as u32 - 1
}
