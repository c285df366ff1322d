//! Where the patches of a tessellation meet, and where it ends.

use super::Color;
use super::color::PATCH_COLORS;
use crate::geom::{Point3, Vec3, angle_between};
use crate::parallel::Evenly;
use crate::tessellate::Tessellation;
use rayon::prelude::*;

/// Normals on both sides of an edge that differ by more than this many radians make it a crease: far above the jumps of a surface
/// that is smooth to rounding.
const CREASE: f64 = 1e-4;

/// Edges of a tessellation by what they are, as vertex numbers; an edge can be of several kinds.
#[derive(Clone, Debug, Default)]
pub struct Borders {
    /// Between two patches.
    pub seams: Vec<[u32; 2]>,
    /// The normals on both sides differ.
    pub creases: Vec<[u32; 2]>,
    /// There is a triangle on one side only.
    pub boundary: Vec<[u32; 2]>,
    /// Pairs of patches with a seam, the smaller number first; sorted, each once.
    pub neighbours: Vec<[u32; 2]>,
}

impl Borders {
    /// Finds them.
    pub fn new(mesh: &Tessellation) -> Self {
        let side = |t: usize, k: usize| {
            let [a, b] = [mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]];
            (a.min(b), a.max(b), t as u32, k as u8)
        };
        let mut sides: Vec<(u32, u32, u32, u8)> = (0..mesh.triangles.len())
            .into_par_iter()
            .evenly()
            .flat_map_iter(|t| (0..3).map(move |k| side(t, k)))
            .collect();
        sides.par_sort_unstable();
        let mut borders = Self::default();
        for edge in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let ends = [edge[0].0, edge[0].1];
            if edge.len() == 1 {
                borders.boundary.push(ends);
            }
            let mut patches: Vec<u32> = edge.iter().map(|side| mesh.patches[side.2 as usize].0).collect();
            patches.sort_unstable();
            patches.dedup();
            if patches.len() > 1 {
                borders.seams.push(ends);
                borders.neighbours.extend(patches.windows(2).map(|pair| [pair[0], pair[1]]));
            }
            if edge.windows(2).any(|pair| is_crease(mesh, pair[0], pair[1])) {
                borders.creases.push(ends);
            }
        }
        borders.neighbours.sort_unstable();
        borders.neighbours.dedup();
        borders
    }

    /// A colour for each patch, none the same as that of a neighbour unless there are too many of them.
    pub fn colors(&self, patches: usize) -> Vec<Color> {
        let palette = PATCH_COLORS.map(Color::srgb);
        let mut neighbours = vec![Vec::new(); patches];
        for [a, b] in &self.neighbours {
            neighbours[*b as usize].push(*a as usize);
        }
        let mut chosen: Vec<usize> = Vec::with_capacity(patches);
        let mut used = [0usize; PATCH_COLORS.len()];
        for patch in 0..patches {
            // Neighbours with a larger number will avoid this one's colour themselves.
            let conflicts = |c: usize| neighbours[patch].iter().filter(|n| chosen[**n] == c).count();
            let turn = |c: usize| (c + patch) % palette.len();
            let color = (0..palette.len()).min_by_key(|c| (conflicts(*c), used[*c], turn(*c))).unwrap_or(0);
            used[color] += 1;
            chosen.push(color);
        }
        chosen.into_iter().map(|c| palette[c]).collect()
    }
}

fn is_crease(mesh: &Tessellation, a: (u32, u32, u32, u8), b: (u32, u32, u32, u8)) -> bool {
    let normal = |side: (u32, u32, u32, u8), v: u32| -> Vec3 {
        let t = side.2 as usize;
        let corner = mesh.triangles[t].iter().position(|w| *w == v).unwrap_or(0);
        mesh.normals[mesh.normal_numbers(t)[corner] as usize]
    };
    [a.0, a.1].iter().any(|v| angle_between(&normal(a, *v), &normal(b, *v)) > CREASE)
}

/// The ends of edges in space.
pub(super) fn segments(mesh: &Tessellation, edges: &[[u32; 2]]) -> Vec<[Point3; 2]> {
    edges.iter().map(|edge| edge.map(|v| mesh.positions[v as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::{flat_triangle, sphere};
    use crate::tessellate::{TessellateOptions, tessellate};

    #[test]
    fn the_icosahedron_has_thirty_seams() {
        let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 5 }).unwrap();
        let borders = Borders::new(&mesh);
        assert_eq!((borders.seams.len(), borders.boundary.len(), borders.creases.len()), (150, 0, 0));
        assert_eq!(borders.neighbours.len(), 30);
        let colors = borders.colors(20);
        assert!(borders.neighbours.iter().all(|[a, b]| colors[*a as usize] != colors[*b as usize]));
    }

    #[test]
    fn a_triangle_has_three_sides() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 4 }).unwrap();
        let borders = Borders::new(&mesh);
        assert_eq!((borders.seams.len(), borders.boundary.len()), (0, 12));
    }

    #[test]
    fn other_normals_on_the_other_side_make_a_crease() {
        let mut mesh = tessellate(&sphere(), &TessellateOptions { resolution: 1 }).unwrap();
        mesh.corner_normals = mesh.triangles.clone();
        // The first triangle gets normals of its own.
        let first = mesh.normals.len() as u32;
        mesh.normals.extend([Vec3::x(); 3]);
        mesh.corner_normals[0] = [first, first + 1, first + 2];
        assert_eq!(Borders::new(&mesh).creases.len(), 3);
    }
}
