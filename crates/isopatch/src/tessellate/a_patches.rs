use super::crease_normals;
use super::{TessellateError, Tessellation};
use crate::apatch::grid::{EdgeTable, FaceTable, GridOut};
use crate::apatch::{APatchSurface, CreasedFace};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeMesh};
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
    let (points, directions) = samples(surface, &numbering);
    positions.extend(points);
    normals.extend(directions);
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
            return Err(TessellateError::Sharing(super::SharingError::TooManyPoints { points }));
        }
        let edge_start = edge_start.into_iter().map(|start| start as u32).collect();
        Ok(Self { n, m, edge_start, patch, interior })
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

    /// Lattice point (i, j, k) of a face.
    fn on_face(&self, mesh: &HalfEdgeMesh, f: FaceId, ijk: [usize; 3]) -> u32 {
        let Some(third) = (0..3).find(|c| ijk[*c] == 0) else {
            let [i, j, k] = ijk.map(|c| c - 1);
            return self.faces_start() + (f.index() * self.interior + index::position([i, j, k])) as u32;
        };
        let corner = (third + 1) % 3;
        let steps = ijk[(corner + 1) % 3];
        let Some(h) = mesh.face_half_edges(f).nth(corner) else { return 0 };
        let e = mesh.edge(h);
        if mesh.edge_half_edge(e) == h {
            self.on_edge(mesh, e, steps, self.m)
        } else {
            self.on_edge(mesh, e, self.n - steps, 0)
        }
    }

    fn triangles(&self, surface: &APatchSurface) -> (Vec<[u32; 3]>, Vec<PatchId>) {
        let mesh = surface.function().hull().data().mesh();
        let small = super::triangles::small_triangles(self.n);
        let of_faces = mesh.faces().flat_map(|f| {
            let small = &small;
            small.iter().map(move |t| (t.map(|ijk| self.on_face(mesh, f, ijk)), PatchId(f.0)))
        });
        let of_edges =
            surface.square_edges().iter().zip(mesh.face_count() as u32..).flat_map(|(e, patch)| {
                (0..self.n).flat_map(move |i| (0..self.m).map(move |j| (i, j))).flat_map(move |(i, j)| {
                    let at = |i, j| self.on_edge(mesh, *e, i, j);
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let halves = [[a, b, c], [a, c, d]].into_iter();
                    halves.filter(|[a, b, c]| a != b && b != c && c != a).map(move |t| (t, PatchId(patch)))
                })
            });
        of_faces.chain(of_edges).unzip()
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

/// Points and normals of the edges, then of the interiors of the faces.
fn samples(surface: &APatchSurface, numbering: &Numbering) -> (Vec<Point3>, Vec<Vec3>) {
    let (n, m) = (numbering.n, numbering.m);
    let function = surface.function();
    let mesh = function.hull().data().mesh();
    // Both weights as quotients, so that they are the same seen from either end.
    let weights = |i: usize| [(n - i) as f64 / n as f64, i as f64 / n as f64];
    let over_edge: Vec<[f64; 3]> = (1..n)
        .flat_map(|i| (0..=m).map(move |j| (i, j)))
        .map(|(i, j)| [weights(i)[0], weights(i)[1], j as f64 / m as f64])
        .collect();
    let (edge_table, face_table) =
        (EdgeTable::new(&over_edge), FaceTable::new(&triangle::interior_lattice(n)));
    let evaluated = |count: usize, evaluate: &dyn Fn(&mut GridOut<'_>)| {
        let (mut points, mut normals) = (Points::zeros(count), Points::zeros(count));
        evaluate(&mut GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) });
        (0..count).map(|i| (points.get(i), normals.get(i))).collect::<Vec<_>>()
    };
    let of_creased = |face: &CreasedFace<'_>, x: &[f64; 3]| {
        let nan = Vec3::repeat(f64::NAN);
        face.sample(*x).map_or((nan, nan), |sample| (sample.point, sample.normal))
    };
    let straight = |e: EdgeId| -> Vec<(Point3, Vec3)> {
        let h = mesh.edge_half_edge(e);
        let k = mesh.side(h);
        let x = |i: usize| {
            let mut x = [0.0; 3];
            [x[k], x[(k + 1) % 3]] = weights(i);
            x
        };
        if function.hull().data().is_crease(e) {
            let creased = function.creased_face(mesh.face(h));
            return creased.map_or_else(Vec::new, |face| (1..n).map(|i| of_creased(&face, &x(i))).collect());
        }
        let at = |i: usize| function.shoot_face(mesh.face(h), x(i));
        let nan = Vec3::repeat(f64::NAN);
        (1..n).map(|i| at(i).map_or((nan, nan), |shot| (shot.point, shot.gradient.normalize()))).collect()
    };
    let interior = triangle::interior_lattice(n);
    let of_edges = (0..mesh.edge_count()).into_par_iter().flat_map_iter(|e| match numbering.patch[e] {
        Some(_) => evaluated(edge_table.len(), &|out| edge_table.evaluate(function, e.into(), out)),
        None => straight(e.into()),
    });
    let of_faces = (0..mesh.face_count()).into_par_iter().flat_map_iter(|f| {
        function.creased_face(f.into()).map_or_else(
            || evaluated(face_table.len(), &|out| face_table.evaluate(function, f.into(), out)),
            |face| interior.iter().map(|x| of_creased(&face, x)).collect(),
        )
    });
    of_edges.chain(of_faces).unzip()
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
