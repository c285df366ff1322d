//! What a surface of hybrid A-patches is worth: every patch is sampled on a lattice, every seam from both sides.

use super::a_patches::{CHUNK, Figures, Grid, figures, seams};
use super::{
    APatchInspectOptions, APatchInspection, Extent, Inspection, Interpolation, intersections::places,
    mesh_intersections, or_infinite, topology,
};
use crate::apatch::{Over, Shot};
use crate::bernstein::{index, triangle};
use crate::geom::normal_jump;
use crate::geom::{Aabb, Vec3};
use crate::hybrid::{HermitePolygons, HybridSurface};
use crate::mesh::FaceId;
use crate::parallel::Evenly;
use crate::surface::{Domain, PatchId, Surface};
use crate::tessellate::{small_triangles, tessellate_hybrid};
use rayon::prelude::*;

/// Measures a surface of hybrid A-patches, as [`inspect_a_patches`](super::inspect_a_patches) does those over triangles. Time and
/// memory are linear in the number of patches, apart from the test for self-intersections.
pub fn inspect_hybrid(surface: &HybridSurface, options: &APatchInspectOptions) -> APatchInspection {
    let data = &surface.function().hull().data;
    let n = options.lattice.max(1);
    let patches: Vec<PatchId> = surface.patches().collect();
    // Sums of chunks of fixed size: the same whatever the number of threads.
    let of_chunk = |chunk: &[PatchId]| {
        chunk.iter().fold(Figures::NONE, |sum, patch| sum.and(measured(surface, *patch, n)))
    };
    let chunks: Vec<Figures> = patches.par_chunks(CHUNK).evenly().map(of_chunk).collect();
    let all = chunks.into_iter().fold(Figures::NONE, Figures::and);
    let intersections = options.intersections.and_then(|resolution| {
        let mesh = tessellate_hybrid(surface, resolution).ok()?.mesh;
        Some(places(&mesh, |patch| matches!(surface.over(patch), Over::Edge(_))))
    });
    let common = Inspection {
        diagonal: data.diagonal(),
        bounds: Aabb::around(data.positions()),
        patches: surface.patch_count(),
        topology: topology(data.mesh()),
        extent: Extent { bounds: all.bounds, area: all.area, volume: all.volume },
        seams: seams(surface, data.diagonal(), options.seam_intervals.max(1)),
        interpolation: Interpolation {
            max_position_error: all.position_error / data.diagonal(),
            max_normal_error: all.normal_error,
            max_curvature_error: f64::NAN,
            max_mixed_curvature_error: f64::NAN,
            worst_curvature: None,
        },
        intersections,
        deviation: None,
        coverage: None,
    };
    let has_some = common.intersections.as_ref().is_some_and(|found| found.count > 0);
    let input_intersections = has_some.then(|| intersections_of_input(surface));
    let Figures { undefined, steep, folded, .. } = all;
    APatchInspection { common, undefined, steep, folded, input_intersections }
}

/// Parameters of the samples of a patch, and triangles of them, counter-clockwise seen from outside.
fn lattice(domain: Domain, n: usize) -> (Vec<[f64; 2]>, Vec<[usize; 3]>) {
    let share = |i: usize| i as f64 / n as f64;
    let in_triangle = || small_triangles(n).into_iter().map(|t| t.map(index::position));
    match domain {
        Domain::Triangle => {
            (triangle::lattice(n).into_iter().map(|x| [x[0], x[1]]).collect(), in_triangle().collect())
        }
        Domain::Square => {
            let at = |i: usize, j: usize| i * (n + 1) + j;
            let points = (0..=n).flat_map(|i| (0..=n).map(move |j| [share(i), share(j)])).collect();
            let quads = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let halves = quads.flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            });
            (points, halves.collect())
        }
        Domain::Polygon(count) => {
            let lattice = triangle::lattice(n);
            let (mut points, mut triangles) = (Vec::new(), Vec::new());
            for k in 0..usize::from(count) {
                let first = points.len();
                // x is the weight of the centre; at the centre every direction is the same point.
                points.extend(lattice.iter().map(|[x, p, q]| {
                    let turn = if p + q > 0.0 { q / (p + q) } else { 0.5 };
                    // The end of a sector is the start of the next one, and counts as that.
                    [k as f64 + turn.min(1.0 - f64::EPSILON * count as f64), *x]
                }));
                triangles.extend(in_triangle().map(|t| t.map(|i| first + i)));
            }
            (points, triangles)
        }
    }
}

fn shot(surface: &HybridSurface, patch: PatchId, [u, v]: [f64; 2]) -> Option<Shot> {
    match surface.over(patch) {
        Over::Face(f) => surface.function().shoot_face(f, [u, v]),
        Over::Edge(e) => surface.function().shoot_edge(e, [1.0 - u, u], v),
    }
}

fn measured(surface: &HybridSurface, patch: PatchId, n: usize) -> Figures {
    let function = surface.function();
    let data = &function.hull().data;
    let (points, triangles) = lattice(surface.domain(patch), n);
    let shots: Vec<Option<Shot>> = points.iter().map(|uv| shot(surface, patch, *uv)).collect();
    let nan = Vec3::repeat(f64::NAN);
    let found = shots.iter().map(|s| s.as_ref().map_or((nan, nan), |s| (s.point, s.gradient.normalize())));
    let (positions, normals): (Vec<Vec3>, Vec<Vec3>) = found.unzip();
    let grid = Grid { points: positions.into_iter().collect(), normals: normals.into_iter().collect() };
    let mut figures = figures(patch, &grid, &triangles, &data.positions()[0]);
    if !figures.undefined.is_empty() {
        return figures;
    }
    if let Over::Face(f) = surface.over(patch) {
        compare_corners(surface, f, &mut figures);
    }
    // On the way from the base to the apex the function rises, so its gradient is on that side of the ray.
    let apex = |shot: &Shot, uv: &[f64; 2]| match surface.over(patch) {
        Over::Face(f) => function.hull().faces[f.index()].apexes[shot.side.index()],
        Over::Edge(e) => {
            function.edge_cell(e, shot.side).map(|[u_l, _, _, u_k]| uv[1] * u_k + (1.0 - uv[1]) * u_l)
        }
    };
    let folds = |(shot, uv): (&Option<Shot>, &[f64; 2])| {
        let Some(shot) = shot else { return false };
        apex(shot, uv).is_some_and(|a| shot.side.sign() * shot.gradient.dot(&(a - shot.point)) <= 0.0)
    };
    if shots.iter().zip(&points).any(folds) {
        figures.folded.push(patch);
    }
    figures
}

/// Positions and normals at the corners of the patch over a face, against those that it interpolates.
fn compare_corners(surface: &HybridSurface, f: FaceId, figures: &mut Figures) {
    let data: &HermitePolygons = &surface.function().hull().data;
    let domain = surface.function().face_domain(f);
    for (k, h) in data.mesh().face_half_edges(f).enumerate() {
        let uv = domain.on_edge(k as u8, [1.0, 0.0]);
        let Some(found) = surface.function().shoot_face(f, uv) else { continue };
        let miss = or_infinite((found.point - data.position(h)).norm());
        figures.position_error = figures.position_error.max(miss);
        figures.normal_error = figures.normal_error.max(normal_jump(&found.gradient, &data.gradient(h)));
    }
}

/// Pairs of triangles between the edges of the mesh and the centres of its polygons that intersect.
fn intersections_of_input(surface: &HybridSurface) -> usize {
    let hull = surface.function().hull();
    let mesh = hull.data.mesh();
    let mut positions = hull.data.positions().to_vec();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for f in mesh.faces() {
        if mesh.face_half_edges(f).len() == 3 {
            triangles.push(mesh.triangle(f).map(|v| v.0));
            continue;
        }
        let center = positions.len() as u32;
        positions.push(hull.faces[f.index()].center);
        triangles.extend(mesh.face_half_edges(f).map(|h| [center, mesh.origin(h).0, mesh.dest(h).0]));
    }
    mesh_intersections(&positions, &triangles).count
}
