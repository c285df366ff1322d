use super::crease_normals;
use super::places::Room;
use super::shared_lattice::number_net;
use super::{SharingError, TessellateError, Tessellation};
use crate::apatch::grid::{EdgeTable, FaceTable, GridOut};
use crate::apatch::{APatchSurface, CreasedFace};
use crate::bernstein::{index, triangle};
use crate::geom::{Aabb, Point3, Points, Vec3, are_finite};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};
use crate::parallel::Evenly;
use crate::surface::PatchId;
use rayon::prelude::*;

/// How finely to tessellate A-patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct APatchResolution {
    /// Intervals along the edges of the mesh, from 1; default 8.
    pub along: usize,
    /// Intervals across the patch over an edge, from 1; default 2.
    pub across: usize,
}

impl Default for APatchResolution {
    fn default() -> Self {
        Self { along: 8, across: 2 }
    }
}

/// Largest number of intervals along an edge or across it.
pub const MAX_INTERVALS: usize = 1000;

/// Samples every patch and joins the points to triangles; a patch over an edge shrinks to a point at both ends of it.
///
/// First come the vertices of the mesh; then, per edge, the points of its patch with both of its borders (or of its straight
/// line) from start to end; then the interior points of each face. Borders are evaluated once, with the patch over the edge, so
/// there are no cracks; points on creases are those of the crease, and have a normal on each side. The result does not depend on
/// the number of threads.
pub fn tessellate_a_patches(
    surface: &APatchSurface,
    resolution: APatchResolution,
) -> Result<Tessellation, TessellateError> {
    let flattened = APatchTriangles::new(surface, resolution)?;
    let (positions, mut normals) = flattened.samples();
    if !are_finite(&positions) {
        let at = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())).unwrap_or_default();
        return Err(flattened.no_root(at));
    }
    let (triangles, patches) = flattened.triangles();
    let corner_normals =
        crease_normals::number(surface, resolution.along, &triangles, &patches, &mut normals);
    Ok(Tessellation { positions, normals, triangles, corner_normals, patches })
}

/// The vertices of the mesh with their normals.
fn corners(surface: &APatchSurface) -> (Vec<Point3>, Vec<Vec3>) {
    let data = surface.function().hull().data();
    let normal = |v| data.mesh().ring(v).next().map_or_else(Vec3::z, |h| data.gradient(h).normalize());
    (data.positions().to_vec(), data.mesh().vertices().map(normal).collect())
}

/// Which number each point has.
struct Numbering {
    n: usize,
    m: usize,
    /// First point of each edge, and the first past the last edge.
    edge_start: Vec<u32>,
    /// The patch over each edge.
    patch: Vec<Option<PatchId>>,
    faces: usize,
    /// Interior points of a face.
    interior: usize,
}

impl Numbering {
    fn new(surface: &APatchSurface, n: usize, m: usize) -> Result<Self, TessellateError> {
        let mesh = surface.function().hull().data().mesh();
        let mut patch = vec![None; mesh.edge_count()];
        for (i, e) in surface.square_edges().iter().enumerate() {
            patch[e.index()] = Some(PatchId((mesh.face_count() + i) as u32));
        }
        let interior = if n > 2 { index::count(n - 3) } else { 0 };
        let rows = |e: usize| if patch[e].is_some() { m + 1 } else { 1 };
        let mut edge_start = vec![mesh.vertex_count() as u64];
        for e in 0..mesh.edge_count() {
            edge_start.push(edge_start[e] + ((n - 1) * rows(e)) as u64);
        }
        let total = edge_start[mesh.edge_count()] + (mesh.face_count() * interior) as u64;
        if u32::try_from(total).is_err() {
            let points = u128::from(total);
            return Err(TessellateError::Sharing(SharingError::TooManyPoints { points }));
        }
        let edge_start = edge_start.into_iter().map(|start| start as u32).collect();
        Ok(Self { n, m, edge_start, patch, faces: mesh.face_count(), interior })
    }

    /// Weights of the start and the end of an edge in point i. Both are quotients, so that they are the same seen from either end.
    fn weights(&self, i: usize) -> [f64; 2] {
        [(self.n - i) as f64 / self.n as f64, i as f64 / self.n as f64]
    }

    /// Number of points of an edge.
    fn length(&self, e: usize) -> usize {
        (self.edge_start[e + 1] - self.edge_start[e]) as usize
    }

    /// Number of points.
    fn count(&self) -> usize {
        self.faces_start() as usize + self.faces * self.interior
    }

    fn faces_start(&self) -> u32 {
        self.edge_start.last().copied().unwrap_or(0)
    }

    /// Point i of an edge, from its start, on row j across its patch (0 on the right).
    fn on_edge(&self, mesh: &HalfEdgeMesh, e: EdgeId, i: usize, j: usize) -> u32 {
        let h = mesh.edge_half_edge(e);
        if i == 0 {
            return mesh.origin(h).0;
        }
        if i == self.n {
            return mesh.dest(h).0;
        }
        let rows = if self.patch[e.index()].is_some() { self.m + 1 } else { 1 };
        self.edge_start[e.index()] + ((i - 1) * rows + j.min(rows - 1)) as u32
    }

    /// The lattice points of a face, in net order.
    fn on_face(&self, mesh: &HalfEdgeMesh, f: FaceId, numbers: &mut [u32]) {
        let sides = [0, 1, 2].map(|k| HalfEdgeId(3 * f.0 + k));
        let on_edge = |side: usize, steps: usize| {
            let e = mesh.edge(sides[side]);
            if mesh.edge_half_edge(e) == sides[side] {
                self.on_edge(mesh, e, steps, self.m)
            } else {
                self.on_edge(mesh, e, self.n - steps, 0)
            }
        };
        let inside = self.faces_start() + (f.index() * self.interior) as u32;
        number_net(self.n, sides.map(|h| mesh.origin(h).0), on_edge, inside, numbers);
    }

    /// The patch that a point was evaluated with.
    fn patch_of(&self, surface: &APatchSurface, point: usize) -> PatchId {
        let mesh = surface.function().hull().data().mesh();
        match (point as u32).checked_sub(self.faces_start()) {
            Some(at) => PatchId(at / self.interior.max(1) as u32),
            None => {
                let e = self.edge_start.partition_point(|start| *start as usize <= point).saturating_sub(1);
                let face = mesh.face(mesh.edge_half_edge(EdgeId::from(e)));
                self.patch[e].unwrap_or(PatchId(face.0))
            }
        }
    }
}

/// The triangles of A-patches, made part by part, with what the parts share.
///
/// The points are in [`Self::point_parts`] parts: the vertices of the mesh, each edge, the interior of each face. The triangles are in
/// [`Self::triangle_parts`]: each face, each patch over an edge.
pub struct APatchTriangles<'a> {
    surface: &'a APatchSurface,
    numbering: Numbering,
    over_edge: EdgeTable,
    over_face: FaceTable,
    interior: Vec<[f64; 3]>,
    /// Small triangles of a face, by positions in a net.
    small: Vec<[usize; 3]>,
}

impl<'a> APatchTriangles<'a> {
    /// The triangles with some resolution, none of them made yet.
    pub fn new(surface: &'a APatchSurface, resolution: APatchResolution) -> Result<Self, TessellateError> {
        let APatchResolution { along: n, across: m } = resolution;
        for resolution in [n, m] {
            if resolution == 0 || resolution > MAX_INTERVALS {
                return Err(TessellateError::Resolution { resolution });
            }
        }
        let numbering = Numbering::new(surface, n, m)?;
        let over_edge: Vec<[f64; 3]> = (1..n)
            .flat_map(|i| (0..=m).map(move |j| (i, j)))
            .map(|(i, j)| [numbering.weights(i)[0], numbering.weights(i)[1], j as f64 / m as f64])
            .collect();
        let interior = triangle::interior_lattice(n);
        Ok(Self {
            surface,
            numbering,
            over_edge: EdgeTable::new(&over_edge),
            over_face: FaceTable::new(&interior),
            interior,
            small: super::small_triangles(n).iter().map(|t| t.map(index::position)).collect(),
        })
    }

    fn mesh(&self) -> &HalfEdgeMesh {
        self.surface.function().hull().data().mesh()
    }

    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.numbering.count()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.mesh().face_count() * self.small.len()
            + self.surface.square_edges().len() * self.triangles_over_edge()
    }

    /// Number of parts of the points.
    pub fn point_parts(&self) -> usize {
        1 + self.mesh().edge_count() + self.mesh().face_count()
    }

    /// The number of the first point of a part.
    pub fn first_point(&self, part: usize) -> usize {
        let numbering = &self.numbering;
        let start = |e: usize| numbering.edge_start.get(e).map(|start| *start as usize);
        let in_face = |e: usize| (e - self.mesh().edge_count()) * numbering.interior;
        part.checked_sub(1)
            .map_or(0, |e| start(e).unwrap_or_else(|| numbering.faces_start() as usize + in_face(e)))
    }

    /// Number of parts of the triangles.
    pub fn triangle_parts(&self) -> usize {
        self.mesh().face_count() + self.surface.square_edges().len()
    }

    /// Both ends of the patch over an edge are points, where half of the triangles have no area.
    fn triangles_over_edge(&self) -> usize {
        2 * self.numbering.m * (self.numbering.n - 1)
    }

    fn no_root(&self, point: usize) -> TessellateError {
        TessellateError::NoRoot { patch: self.numbering.patch_of(self.surface, point).0 }
    }

    /// Has the surface one normal at each point, so that normals have the numbers of points?
    pub fn is_smooth(&self) -> bool {
        let data = self.surface.function().hull().data();
        !self.mesh().edges().any(|e| data.is_crease(e))
    }

    /// The smallest box around all points.
    pub fn bounds(&self) -> Result<Aabb, TessellateError> {
        let of_part = |room: &mut [Points; 2], part: usize| {
            let [points, normals] = room;
            self.points(part, false, points, normals);
            let all = || (0..points.len()).map(|i| points.get(i));
            match all().position(|p| !p.iter().all(|c| c.is_finite())) {
                Some(at) => Err(self.no_root(self.first_point(part) + at)),
                None => Ok(all().fold(Aabb::EMPTY, |bounds, p| bounds.including(&p))),
            }
        };
        let parts = (0..self.point_parts()).into_par_iter().evenly().map_init(Default::default, of_part);
        // In order: of several errors the first one counts.
        let parts: Vec<Result<Aabb, TessellateError>> = parts.collect();
        parts.into_iter().try_fold(Aabb::EMPTY, |bounds, part| Ok(bounds.union(&part?)))
    }

    /// The points of a part and, if they are wanted, normals; NaN where the function has no zero on a ray.
    pub fn points(&self, part: usize, with_normals: bool, points: &mut Points, normals: &mut Points) {
        let data = self.surface.function().hull().data();
        let edges = self.mesh().edge_count();
        let count = match part.checked_sub(1) {
            None => data.positions().len(),
            Some(e) if e < edges => self.numbering.length(e),
            Some(_) => self.interior.len(),
        };
        points.resize(count);
        normals.resize(if with_normals { count } else { 0 });
        let mut out =
            GridOut { points: points.view_mut(), normals: with_normals.then(|| normals.view_mut()) };
        match part.checked_sub(1) {
            None => self.vertices(&mut out),
            Some(e) if e < edges => self.edge(e.into(), &mut out),
            Some(f) => self.face((f - edges).into(), &mut out),
        }
    }

    fn vertices(&self, out: &mut GridOut<'_>) {
        let (positions, normals) = corners(self.surface);
        positions.into_iter().zip(normals).enumerate().for_each(|(v, (p, n))| out.set(v, p, n));
    }

    /// The points of an edge.
    fn edge(&self, e: EdgeId, out: &mut GridOut<'_>) {
        let function = self.surface.function();
        if self.numbering.patch[e.index()].is_some() {
            return self.over_edge.evaluate(function, e, out);
        }
        let mesh = self.mesh();
        let h = mesh.edge_half_edge(e);
        let (f, k) = (mesh.face(h), mesh.side(h));
        let creased = if function.hull().data().is_crease(e) { function.creased_face(f) } else { None };
        for i in 1..self.numbering.n {
            let mut x = [0.0; 3];
            [x[k], x[(k + 1) % 3]] = self.numbering.weights(i);
            let (point, normal) = self.shoot(f, creased.as_ref(), x);
            out.set(i - 1, point, normal);
        }
    }

    /// The points inside a face.
    fn face(&self, f: FaceId, out: &mut GridOut<'_>) {
        let Some(face) = self.surface.function().creased_face(f) else {
            return self.over_face.evaluate(self.surface.function(), f, out);
        };
        for (i, x) in self.interior.iter().enumerate() {
            let (point, normal) = self.shoot(f, Some(&face), *x);
            out.set(i, point, normal);
        }
    }

    fn shoot(&self, f: FaceId, creased: Option<&CreasedFace<'_>>, x: [f64; 3]) -> (Point3, Vec3) {
        let found = match creased {
            Some(face) => face.sample(x).map(|sample| (sample.point, sample.normal)),
            None => {
                let shot = self.surface.function().shoot_face(f, x);
                shot.map(|shot| (shot.point, shot.gradient.normalize()))
            }
        };
        found.unwrap_or_else(|| [Vec3::repeat(f64::NAN); 2].into())
    }

    /// All points and normals.
    fn samples(&self) -> (Vec<Point3>, Vec<Vec3>) {
        let (mut positions, mut normals) = corners(self.surface);
        let corners = positions.len();
        positions.resize(self.point_count(), Point3::zeros());
        normals.resize(self.point_count(), Vec3::zeros());
        let edges = self.mesh().edge_count();
        let lengths = (0..edges).map(|e| self.numbering.length(e));
        let (of_edges, of_faces) = positions[corners..].split_at_mut(lengths.clone().sum());
        let (normals_of_edges, normals_of_faces) = normals[corners..].split_at_mut(of_edges.len());
        let runs: Vec<_> = runs(of_edges, lengths.clone()).zip(runs(normals_of_edges, lengths)).collect();
        runs.into_par_iter().evenly().enumerate().for_each_init(
            Room::default,
            |room, (e, (points, normals))| {
                room.by_axis(points, normals, |points, normals| {
                    self.edge(e.into(), &mut GridOut { points, normals: Some(normals) });
                });
            },
        );
        let length = self.interior.len().max(1);
        let runs = of_faces.par_chunks_mut(length).zip(normals_of_faces.par_chunks_mut(length)).evenly();
        runs.enumerate().for_each_init(Room::default, |room, (f, (points, normals))| {
            room.by_axis(points, normals, |points, normals| {
                self.face(f.into(), &mut GridOut { points, normals: Some(normals) });
            });
        });
        (positions, normals)
    }

    /// The triangles of a part, in order; `numbers` is memory.
    pub fn part_triangles(&self, part: usize, numbers: &mut Vec<u32>, mut put: impl FnMut([u32; 3])) {
        let mesh = self.mesh();
        let (n, m) = (self.numbering.n, self.numbering.m);
        let Some(edge) = part.checked_sub(mesh.face_count()) else {
            numbers.resize(index::count(n), 0);
            self.numbering.on_face(mesh, part.into(), numbers);
            return self.small.iter().for_each(|local| put(local.map(|at| numbers[at])));
        };
        let e = self.surface.square_edges()[edge];
        numbers.clear();
        numbers.extend(
            (0..=n)
                .flat_map(|i| (0..=m).map(move |j| (i, j)))
                .map(|(i, j)| self.numbering.on_edge(mesh, e, i, j)),
        );
        for (i, two) in numbers.windows(2 * (m + 1)).step_by(m + 1).enumerate() {
            let (near, far) = two.split_at(m + 1);
            for (near, far) in near.windows(2).zip(far.windows(2)) {
                let ([a, d], [b, c]) = ([near[0], near[1]], [far[0], far[1]]);
                if i + 1 < n {
                    put([a, b, c]);
                }
                if i > 0 {
                    put([a, c, d]);
                }
            }
        }
    }

    /// All triangles, and the patch of each.
    fn triangles(&self) -> (Vec<[u32; 3]>, Vec<PatchId>) {
        let faces = self.mesh().face_count();
        let (of_face, of_edge) = (self.small.len(), self.triangles_over_edge());
        let mut triangles = vec![[0; 3]; self.triangle_count()];
        let mut patches = vec![PatchId(0); triangles.len()];
        let (over_faces, over_edges) = triangles.split_at_mut(faces * of_face);
        let fill = |numbers: &mut Vec<u32>, part: usize, out: &mut [[u32; 3]]| {
            let mut out = out.iter_mut();
            self.part_triangles(part, numbers, |t| {
                if let Some(out) = out.next() {
                    *out = t;
                }
            });
        };
        let parts = over_faces.par_chunks_mut(of_face).enumerate().evenly();
        parts.for_each_init(Vec::new, |numbers, (f, out)| fill(numbers, f, out));
        let parts = over_edges.par_chunks_mut(of_edge.max(1)).enumerate().evenly();
        parts.for_each_init(Vec::new, |numbers, (e, out)| fill(numbers, faces + e, out));
        let (over_faces, over_edges) = patches.split_at_mut(faces * of_face);
        let parts = over_faces.chunks_mut(of_face).chain(over_edges.chunks_mut(of_edge.max(1)));
        parts.zip(0..).for_each(|(part, patch)| part.fill(PatchId(patch)));
        (triangles, patches)
    }
}

/// Parts of a slice, one after the other.
fn runs<T>(all: &mut [T], lengths: impl Iterator<Item = usize>) -> impl Iterator<Item = &mut [T]> {
    let mut rest = all;
    lengths.map(move |length| {
        let (first, others) = std::mem::take(&mut rest).split_at_mut(length);
        rest = others;
        first
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::apatch::{self, APatchOptions};
    use crate::hull::test_meshes::{quadrics, torus, torus_distance};
    use crate::hull::{self, HermiteMesh, HullOptions};
    use std::collections::HashMap;

    fn surface(data: HermiteMesh) -> APatchSurface {
        APatchSurface::new(apatch::build(
            hull::build(data, &HullOptions::default()),
            &APatchOptions::default(),
        ))
    }

    /// Edges that are in one triangle only, and whether any edge is used twice in one direction.
    fn border(mesh: &Tessellation) -> usize {
        let mut uses: HashMap<(u32, u32), usize> = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for edge in [(*a, *b), (*b, *c), (*c, *a)] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        assert!(uses.values().all(|n| *n == 1));
        uses.keys().filter(|(a, b)| !uses.contains_key(&(*b, *a))).count()
    }

    #[test]
    fn a_closed_surface_has_no_cracks() {
        let surface = surface(torus([16, 10]));
        for (along, across) in [(1, 1), (2, 1), (3, 2), (8, 3)] {
            let mesh = tessellate_a_patches(&surface, APatchResolution { along, across }).unwrap();
            assert_eq!(border(&mesh), 0, "{along} {across}");
            let edges = 3 * mesh.triangles.len() / 2;
            let euler = mesh.positions.len() as i64 - edges as i64 + mesh.triangles.len() as i64;
            assert_eq!(euler, 0, "{along} {across}");
        }
    }

    #[test]
    fn every_point_is_on_the_torus_with_its_normal() {
        let mesh = tessellate_a_patches(&surface(torus([16, 10])), APatchResolution { along: 6, across: 3 })
            .unwrap();
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            let rho = p.x.hypot(p.y);
            assert!(torus_distance(p) < 5e-3);
            let normal = Vec3::new(p.x / rho * (rho - 1.0), p.y / rho * (rho - 1.0), p.z).normalize();
            assert!(n.dot(&normal) > 0.99 && (n.norm() - 1.0).abs() < 1e-14);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let area = (b - a).cross(&(c - a));
            assert!(t.iter().all(|v| mesh.normals[*v as usize].dot(&area) >= 0.0));
        }
    }

    #[test]
    fn open_surfaces_keep_their_boundary() {
        for (name, quadric, data) in quadrics() {
            let open = data.mesh().half_edges().filter(|h| data.mesh().twin(*h).is_none()).count();
            let mesh =
                tessellate_a_patches(&surface(data), APatchResolution { along: 5, across: 2 }).unwrap();
            assert_eq!(border(&mesh), 5 * open, "{name}");
            assert!(mesh.positions.iter().all(|p| quadric.distance(p) < 1e-14), "{name}");
        }
    }

    #[test]
    fn resolutions_have_limits() {
        let resolution = APatchResolution { along: 0, across: 1 };
        let error = tessellate_a_patches(&surface(torus([16, 10])), resolution).unwrap_err();
        assert_eq!(error, TessellateError::Resolution { resolution: 0 });
    }
}
