use super::crease_normals;
use super::places::Room;
use super::shared_lattice::number_net;
use super::{SharingError, TessellateError, Tessellation};
use crate::apatch::grid::{EdgeTable, FaceTable, GridOut};
use crate::apatch::{APatchSurface, CreasedFace};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};
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
    let APatchResolution { along: n, across: m } = resolution;
    for resolution in [n, m] {
        if resolution == 0 || resolution > MAX_INTERVALS {
            return Err(TessellateError::Resolution { resolution });
        }
    }
    let numbering = Numbering::new(surface, n, m)?;
    let (mut positions, mut normals) = corners(surface);
    let corners = positions.len();
    positions.resize(numbering.count(), Point3::zeros());
    normals.resize(numbering.count(), Vec3::zeros());
    sample(surface, &numbering, &mut positions[corners..], &mut normals[corners..]);
    if let Some(at) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(TessellateError::NoRoot { patch: numbering.patch_of(surface, at).0 });
    }
    let (triangles, patches) = numbering.triangles(surface);
    let corner_normals = crease_normals::number(surface, n, &triangles, &patches, &mut normals);
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

    fn triangles(&self, surface: &APatchSurface) -> (Vec<[u32; 3]>, Vec<PatchId>) {
        let mesh = surface.function().hull().data().mesh();
        let small: Vec<[usize; 3]> =
            super::small_triangles(self.n).iter().map(|t| t.map(index::position)).collect();
        let over_edges: Vec<_> = surface.square_edges().iter().zip(mesh.face_count() as u32..).collect();
        // Both ends of the patch over an edge are points, where half of the triangles have no area.
        let of_edge = 2 * self.m * self.n - 2 * self.m;
        let (in_faces, in_edges) = (self.faces * small.len(), over_edges.len() * of_edge);
        let mut triangles = vec![[0; 3]; in_faces + in_edges];
        let mut patches = vec![PatchId(0); triangles.len()];
        let (over_face, over_edge) = triangles.split_at_mut(in_faces);
        let room = || vec![0; index::count(self.n)];
        over_face.par_chunks_mut(small.len()).enumerate().for_each_init(room, |numbers, (f, out)| {
            self.on_face(mesh, f.into(), numbers);
            out.iter_mut().zip(&small).for_each(|(t, local)| *t = local.map(|at| numbers[at]));
        });
        over_edge.par_chunks_mut(of_edge.max(1)).zip(&over_edges).for_each(|(out, (e, _))| {
            let at = |i, j| self.on_edge(mesh, **e, i, j);
            let cells = (0..self.n).flat_map(|i| (0..self.m).map(move |j| (i, j)));
            let halves = cells.flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            });
            let with_area = halves.filter(|[a, b, c]| a != b && b != c && c != a);
            out.iter_mut().zip(with_area).for_each(|(out, t)| *out = t);
        });
        patches[..in_faces]
            .chunks_mut(small.len())
            .zip(mesh.faces())
            .for_each(|(of_face, f)| of_face.fill(PatchId(f.0)));
        patches[in_faces..]
            .chunks_mut(of_edge.max(1))
            .zip(&over_edges)
            .for_each(|(of_edge, (_, patch))| of_edge.fill(PatchId(*patch)));
        (triangles, patches)
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

/// Points and normals of the edges, then of the interiors of the faces; NaN where the function has no zero on a ray.
fn sample(surface: &APatchSurface, numbering: &Numbering, points: &mut [Point3], normals: &mut [Vec3]) {
    let (n, m) = (numbering.n, numbering.m);
    let function = surface.function();
    let mesh = function.hull().data().mesh();
    // Both weights as quotients, so that they are the same seen from either end.
    let weights = |i: usize| [(n - i) as f64 / n as f64, i as f64 / n as f64];
    let over_edge: Vec<[f64; 3]> = (1..n)
        .flat_map(|i| (0..=m).map(move |j| (i, j)))
        .map(|(i, j)| [weights(i)[0], weights(i)[1], j as f64 / m as f64])
        .collect();
    let interior = triangle::interior_lattice(n);
    let (edge_table, face_table) = (EdgeTable::new(&over_edge), FaceTable::new(&interior));
    let at = |f: FaceId, creased: Option<&CreasedFace<'_>>, x: [f64; 3]| {
        let found = match creased {
            Some(face) => face.sample(x).map(|sample| (sample.point, sample.normal)),
            None => function.shoot_face(f, x).map(|shot| (shot.point, shot.gradient.normalize())),
        };
        found.unwrap_or_else(|| [Vec3::repeat(f64::NAN); 2].into())
    };
    // Of an edge without a patch of its own.
    let straight = |e: EdgeId, points: &mut [Point3], normals: &mut [Vec3]| {
        let h = mesh.edge_half_edge(e);
        let (f, k) = (mesh.face(h), mesh.side(h));
        let creased = if function.hull().data().is_crease(e) { function.creased_face(f) } else { None };
        for (i, (point, normal)) in (1..).zip(points.iter_mut().zip(normals)) {
            let mut x = [0.0; 3];
            [x[k], x[(k + 1) % 3]] = weights(i);
            (*point, *normal) = at(f, creased.as_ref(), x);
        }
    };
    let lengths = numbering.edge_start.windows(2).map(|w| (w[1] - w[0]) as usize);
    let (of_edges, of_faces) = points.split_at_mut(lengths.clone().sum());
    let (normals_of_edges, normals_of_faces) = normals.split_at_mut(of_edges.len());
    let runs: Vec<_> = runs(of_edges, lengths.clone()).zip(runs(normals_of_edges, lengths)).collect();
    runs.into_par_iter().enumerate().for_each_init(Room::default, |room, (e, (points, normals))| {
        match numbering.patch[e] {
            Some(_) => room.by_axis(points, normals, |points, normals| {
                edge_table.evaluate(function, e.into(), &mut GridOut { points, normals: Some(normals) });
            }),
            None => straight(e.into(), points, normals),
        }
    });
    let length = interior.len().max(1);
    let runs = of_faces.par_chunks_mut(length).zip(normals_of_faces.par_chunks_mut(length));
    runs.enumerate().for_each_init(Room::default, |room, (f, (points, normals))| {
        if let Some(face) = function.creased_face(f.into()) {
            let out = points.iter_mut().zip(normals).zip(&interior);
            out.for_each(|((point, normal), x)| (*point, *normal) = at(f.into(), Some(&face), *x));
            return;
        }
        room.by_axis(points, normals, |points, normals| {
            face_table.evaluate(function, f.into(), &mut GridOut { points, normals: Some(normals) });
        });
    });
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
