use super::places::{Places, Room};
use super::{SharedLattice, SharingError, sharp_normals};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Vec3};
use crate::parallel::Evenly;
use crate::surface::{PatchForm, PatchId, Surface};
use rayon::prelude::*;
use std::borrow::Cow;

/// How finely to tessellate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TessellateOptions {
    /// Intervals along each patch edge, from 1; a patch becomes `resolution`² triangles. Default 8: the flat
    /// triangles are then about 64 times closer to the surface than the base mesh.
    pub resolution: usize,
}

impl Default for TessellateOptions {
    fn default() -> Self {
        Self { resolution: 8 }
    }
}

/// Why a surface cannot be tessellated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TessellateError {
    /// The resolution is out of range.
    #[error("resolution {resolution} is not between 1 and {MAX_RESOLUTION}")]
    Resolution {
        /// What was asked for.
        resolution: usize,
    },
    /// The patches do not say what they share.
    #[error(transparent)]
    Sharing(#[from] SharingError),
    /// A patch is not defined everywhere: the function of an A-patch has no zero on one of its rays.
    #[error("patch {patch} is not defined everywhere")]
    NoRoot {
        /// The patch.
        patch: u32,
    },
}

/// Largest resolution: a million triangles a patch.
pub const MAX_RESOLUTION: usize = 1000;

/// A triangle mesh on a surface, without cracks: triangles share the vertices on common corners and seams.
///
/// The corners of the patches come first, by their own numbers; then the points of each seam; then the interior
/// points of each patch.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation {
    /// Points of the surface.
    pub positions: Vec<Point3>,
    /// Unit normals of the surface at these points, outward; at a point of a crease, on one of its sides, and those on the
    /// other sides after the last.
    pub normals: Vec<Vec3>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The numbers of the normals at the corners of each triangle; empty where those are the vertex numbers.
    pub corner_normals: Vec<[u32; 3]>,
    /// The patch of each triangle.
    pub patches: Vec<PatchId>,
}

/// Samples every patch on a lattice and joins the points to triangles.
///
/// Seam points are evaluated once, on the seam's first patch; along seams that are not smooth there is a normal for each side. The result does not depend on the number of threads.
pub fn tessellate(
    surface: &dyn Surface,
    options: &TessellateOptions,
) -> Result<Tessellation, TessellateError> {
    let n = options.resolution;
    if n == 0 || n > MAX_RESOLUTION {
        return Err(TessellateError::Resolution { resolution: n });
    }
    let lattice = SharedLattice::new(surface, n)?;
    let (positions, mut normals) = samples(surface, &lattice, n);
    let small = small_triangles(n);
    let (triangles, patches) = joined(surface, &lattice, n, &small);
    let places = triangle::lattice(n);
    let normal = |patch: PatchId, at: usize| surface.sample(patch, [places[at][0], places[at][1]]).normal;
    let corner_normals = sharp_normals::number(surface, &lattice, n, &small, &normal, &mut normals);
    let mut mesh = Tessellation { positions, normals, triangles, corner_normals, patches };
    fill_missing_normals(&mut mesh);
    Ok(mesh)
}

/// Points and normals in the order of their numbers.
fn samples(surface: &dyn Surface, lattice: &SharedLattice, n: usize) -> (Vec<Point3>, Vec<Vec3>) {
    let degree = match (surface.patch_count() > 0).then(|| surface.form(PatchId(0))) {
        Some(PatchForm::BezierTriangle { degree, .. }) => degree.clamp(1, triangle::MAX_DEGREE),
        Some(PatchForm::RationalTriangle { .. } | PatchForm::APatch) | None => 1,
    };
    let all = triangle::lattice(n);
    let corners = [0, 1, 2].map(|c| Places::new(degree, &[all[index::row(n, c, 0, 0)]]));
    let along = |edge: usize, reversed: bool| {
        let at = |m: usize| all[index::row(n, edge, 0, if reversed { n - m } else { m })];
        Places::new(degree, &(1..n).map(at).collect::<Vec<_>>())
    };
    let edges = [0, 1, 2].map(|edge| [along(edge, false), along(edge, true)]);
    let inside = Places::new(degree, &triangle::interior_lattice(n));

    let count = lattice.point_count();
    let (mut positions, mut normals) = (vec![Point3::zeros(); count], vec![Vec3::zeros(); count]);
    let parts = lattice.parts(&mut positions).into_iter().zip(lattice.parts(&mut normals));
    let lengths = [1, n - 1, lattice.interior_count()];
    for (part, ((points, normals), length)) in parts.zip(lengths).enumerate() {
        // Nothing has the length 0 but parts without any entry.
        let runs = points.par_chunks_mut(length.max(1)).zip(normals.par_chunks_mut(length.max(1))).evenly();
        runs.enumerate().for_each_init(Room::default, |room, (i, (points, normals))| {
            let (patch, places) = match part {
                0 => {
                    let (patch, corner) = lattice.corner_owners()[i];
                    (patch, &corners[usize::from(corner)])
                }
                1 => {
                    let (patch, side, edge) = lattice.seam_owners()[i];
                    (patch, &edges[usize::from(edge)][usize::from(side.reversed)])
                }
                _ => (PatchId(i as u32), &inside),
            };
            places.sample(surface, patch, room, points, normals);
        });
    }
    (positions, normals)
}

/// The triangles of all patches, and the patch of each.
fn joined(
    surface: &dyn Surface,
    lattice: &SharedLattice,
    n: usize,
    small: &[[[usize; 3]; 3]],
) -> (Vec<[u32; 3]>, Vec<PatchId>) {
    let small: Vec<[usize; 3]> = small.iter().map(|t| t.map(index::position)).collect();
    let count = surface.patch_count() * small.len();
    let (mut triangles, mut patches) = (vec![[0; 3]; count], vec![PatchId(0); count]);
    let runs = triangles.par_chunks_mut(small.len()).zip(patches.par_chunks_mut(small.len())).evenly();
    let room = || vec![0; index::count(n)];
    runs.enumerate().for_each_init(room, |numbers, (p, (triangles, patches))| {
        let patch = PatchId(p as u32);
        lattice.numbers(patch, numbers);
        triangles.iter_mut().zip(&small).for_each(|(t, local)| *t = local.map(|at| numbers[at]));
        patches.fill(patch);
    });
    (triangles, patches)
}

/// The n² triangles of a lattice, counter-clockwise.
pub(crate) fn small_triangles(n: usize) -> Vec<[[usize; 3]; 3]> {
    let upright = index::indices(n - 1).map(|[i, j, k]| [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]]);
    let inverted = index::indices(n.saturating_sub(2))
        .filter(|_| n >= 2)
        .map(|[i, j, k]| [[i, j + 1, k + 1], [i + 1, j, k + 1], [i + 1, j + 1, k]]);
    upright.chain(inverted).collect()
}

/// Where a patch has no normal (parallel derivatives), takes the mean of the triangles around the point.
fn fill_missing_normals(mesh: &mut Tessellation) {
    let missing = |n: &Vec3| !n.iter().all(|c| c.is_finite());
    if !mesh.normals.iter().any(missing) {
        return;
    }
    let mut sum = vec![Vec3::zeros(); mesh.normals.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let area = (b - a).cross(&(c - a));
        mesh.normal_numbers(t).iter().for_each(|v| sum[*v as usize] += area);
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sum) {
        if missing(normal) {
            // A point whose triangles have no area has no normal; any unit vector keeps the file valid.
            *normal = sum.try_normalize(0.0).unwrap_or(Vec3::z());
        }
    }
}

impl Tessellation {
    /// The numbers of the normals at the corners of triangle t.
    pub fn normal_numbers(&self, t: usize) -> [u32; 3] {
        self.corner_normals.get(t).copied().unwrap_or(self.triangles[t])
    }

    /// The mesh with one normal a vertex: vertices on creases are there once for each of their normals. It has cracks by number,
    /// not by position.
    pub fn with_split_creases(&self) -> Cow<'_, Self> {
        if self.corner_normals.is_empty() {
            return Cow::Borrowed(self);
        }
        // The vertex of each normal; those after the last vertex get one of their own.
        let mut positions = self.positions.clone();
        positions.resize(self.normals.len(), Point3::zeros());
        for (triangle, normals) in self.triangles.iter().zip(&self.corner_normals) {
            for (v, n) in triangle.iter().zip(normals) {
                positions[*n as usize] = self.positions[*v as usize];
            }
        }
        Cow::Owned(Self {
            positions,
            normals: self.normals.clone(),
            triangles: self.corner_normals.clone(),
            corner_normals: Vec::new(),
            patches: self.patches.clone(),
        })
    }

    /// Signed volume enclosed by the triangles, relative to the first vertex: positive if they face outward.
    pub fn signed_volume(&self) -> f64 {
        let Some(origin) = self.positions.first() else { return 0.0 };
        let corner = |v: u32| self.positions[v as usize] - origin;
        self.triangles.iter().map(|t| corner(t[0]).cross(&corner(t[1])).dot(&corner(t[2])) / 6.0).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::angle_between;
    use crate::golden::{flat_triangle, sphere};
    use std::collections::HashMap;

    #[test]
    fn a_closed_surface_becomes_a_closed_mesh_with_base_vertices_first() {
        let base = sphere();
        for n in [1, 2, 3, 8] {
            let mesh = tessellate(&base, &TessellateOptions { resolution: n }).unwrap();
            assert_eq!(mesh.triangles.len(), 20 * n * n);
            assert_eq!(mesh.positions.len(), 10 * n * n + 2);
            assert_eq!(mesh.positions[..12], base.base.positions[..]);
            let mut uses = HashMap::new();
            for t in &mesh.triangles {
                (0..3).for_each(|k| *uses.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1);
            }
            assert!(uses.iter().all(|(&(a, b), &count)| count == 1 && uses.contains_key(&(b, a))));
            assert!(mesh.signed_volume() > 0.0);
        }
    }

    #[test]
    fn points_and_normals_are_those_of_the_surface() {
        let mesh = tessellate(&sphere(), &TessellateOptions::default()).unwrap();
        // The golden spline is within 8.6e-5 of the diagonal 2.95, and 0.128 degrees in the normals.
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((p.norm() - 1.0).abs() < 2.6e-4);
            assert!(angle_between(p, n).to_degrees() < 0.13);
        }
        for (t, p) in mesh.triangles.iter().zip(&mesh.patches) {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            assert!((b - a).cross(&(c - a)).dot(&a) > 0.0, "triangle of {p:?}");
        }
    }

    #[test]
    fn an_open_surface_keeps_its_boundary() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 4 }).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (15, 16));
    }

    #[test]
    fn the_resolution_is_checked() {
        for resolution in [0, MAX_RESOLUTION + 1] {
            let error = tessellate(&sphere(), &TessellateOptions { resolution }).unwrap_err();
            assert_eq!(error, TessellateError::Resolution { resolution });
        }
    }
}
