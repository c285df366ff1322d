use super::{BasisTable, SharedLattice, SharingError, sharp_normals};
use crate::bernstein::index;
use crate::geom::{Point3, Vec3};
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

/// Largest resolution: a table of 36 weights at more lattice points would need gigabytes.
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
    let samples = Samples::new(surface, n);
    let (positions, mut normals): (Vec<Point3>, Vec<Vec3>) =
        lattice.gather(|patch, at| samples.at(patch, at)).into_iter().unzip();
    let small = small_triangles(n);
    let triangles = (0..surface.patch_count() as u32).into_par_iter().flat_map_iter(|p| {
        let lattice = &lattice;
        small.iter().map(move |t| t.map(|ijk| lattice.number(PatchId(p), ijk)))
    });
    let triangles = triangles.collect();
    let normal = |patch: PatchId, at: usize| samples.at(patch, at).1;
    let corner_normals = sharp_normals::number(surface, &lattice, n, &small, &normal, &mut normals);
    let mut mesh = Tessellation {
        positions,
        normals,
        triangles,
        corner_normals,
        patches: surface.patches().flat_map(|p| std::iter::repeat_n(p, n * n)).collect(),
    };
    fill_missing_normals(&mut mesh);
    Ok(mesh)
}

/// Points and normals at the lattice points of patches.
struct Samples<'a> {
    surface: &'a dyn Surface,
    degree: usize,
    table: BasisTable,
    parameters: Vec<[f64; 3]>,
}

impl<'a> Samples<'a> {
    fn new(surface: &'a dyn Surface, n: usize) -> Self {
        let first = (surface.patch_count() > 0).then(|| surface.form(PatchId(0)));
        let degree = match first {
            Some(PatchForm::BezierTriangle { degree, .. }) => degree,
            Some(PatchForm::RationalTriangle { .. } | PatchForm::APatch) | None => 1,
        };
        let parameters = crate::bernstein::triangle::lattice(n);
        Self { surface, degree, table: BasisTable::new(degree, n), parameters }
    }

    /// Point and normal of a patch at a lattice point, by its position in net order.
    fn at(&self, patch: PatchId, at: usize) -> (Point3, Vec3) {
        match self.surface.form(patch) {
            PatchForm::BezierTriangle { degree, net } if degree == self.degree => {
                let t = self.table.evaluate(net, at);
                (t.point, t.du.cross(&t.dv).normalize())
            }
            PatchForm::BezierTriangle { .. } | PatchForm::RationalTriangle { .. } | PatchForm::APatch => {
                let [u, v, _] = self.parameters[at];
                let sample = self.surface.sample(patch, [u, v]);
                (sample.point, sample.normal)
            }
        }
    }
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
