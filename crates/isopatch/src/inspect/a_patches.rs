//! What a surface of A-patches is worth: every patch is sampled on a lattice, every seam from both sides.

use super::{
    Extent, Inspection, Interpolation, Intersections, Seams, intersections::places, mesh_intersections,
    or_infinite, topology,
};
use crate::apatch::grid::{EdgeTable, FaceTable, GridOut};
use crate::apatch::{APatchFunction, APatchSurface, Base, Over};
use crate::bernstein::{index, triangle};
use crate::geom::normal_jump;
use crate::geom::{Aabb, Point3, Points, Vec3};
use crate::hull::{Class, HermiteMesh, Side};
use crate::mesh::{EdgeId, FaceId};
use crate::parallel::Evenly;
use crate::surface::{Continuity, PatchId, SeamSide, Surface};
use crate::tessellate::{APatchResolution, small_triangles, tessellate_a_patches};
use rayon::prelude::*;

/// How finely [`inspect_a_patches`] samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct APatchInspectOptions {
    /// Intervals of the lattice on every patch, at least 1; default 20.
    pub lattice: usize,
    /// Intervals along every seam, at least 1; default 32. With a power of two the parameters of both sides are the same to
    /// the bit.
    pub seam_intervals: usize,
    /// The triangles that are tested for self-intersections; no test if there is none. Default 4 along, 2 across.
    pub intersections: Option<APatchResolution>,
}

impl APatchInspectOptions {
    /// As much as can be measured while a surface is made: 8 intervals on patches, 4 along seams, no self-intersections.
    pub const QUICK: Self = Self { lattice: 8, seam_intervals: 4, intersections: None };
}

impl Default for APatchInspectOptions {
    fn default() -> Self {
        let intersections = Some(APatchResolution { along: 4, across: 2 });
        Self { lattice: 20, seam_intervals: 32, intersections }
    }
}

/// All that [`inspect_a_patches`] measures.
#[derive(Clone, Debug, PartialEq)]
pub struct APatchInspection {
    /// What is measured of every surface. Area and volume are those of the triangles of the lattices; curvatures, which the
    /// method does not interpolate, are NaN.
    pub common: Inspection,
    /// Patches with a ray that has no root, in order. They are left out of the figures.
    pub undefined: Vec<PatchId>,
    /// Patches that have a small triangle of the lattice which faces against the surface normals at its corners, in order: the
    /// surface bends hard there, and flat triangles show it.
    pub steep: Vec<PatchId>,
    /// Patches that fold over: somewhere the normal is at a right angle or more to the ray from the base of the cell to its
    /// apex. In order. Of faces beside creases only `steep` tells.
    pub folded: Vec<PatchId>,
    /// Pairs of triangles of the mesh itself that intersect: the surface keeps those of its mesh. None if no self-intersections of
    /// the surface were looked for or found.
    pub input_intersections: Option<usize>,
}

/// Measures a surface of A-patches. Time and memory are linear in the number of patches, apart from the test for
/// self-intersections.
pub fn inspect_a_patches(surface: &APatchSurface, options: &APatchInspectOptions) -> APatchInspection {
    let data = surface.function().hull().data();
    let lattice = Lattice::new(options.lattice.max(1));
    let patches: Vec<PatchId> = surface.patches().collect();
    // Sums of chunks of fixed size: the same whatever the number of threads.
    let chunks: Vec<Figures> = patches
        .par_chunks(CHUNK)
        .evenly()
        .map_init(Grid::default, |grid, chunk| {
            chunk.iter().fold(Figures::NONE, |sum, patch| sum.and(lattice.measure(surface, *patch, grid)))
        })
        .collect();
    let all = chunks.into_iter().fold(Figures::NONE, Figures::and);
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
        intersections: options.intersections.and_then(|resolution| intersections(surface, resolution)),
        deviation: None,
        coverage: None,
    };
    let has_some = common.intersections.as_ref().is_some_and(|found| found.count > 0);
    let input_intersections = has_some.then(|| intersections_of_input(data));
    let Figures { undefined, steep, folded, .. } = all;
    APatchInspection { common, undefined, steep, folded, input_intersections }
}

/// Patches that one task measures.
pub(super) const CHUNK: usize = 64;

/// Points and normals of a patch.
#[derive(Default)]
pub(super) struct Grid {
    pub points: Points,
    pub normals: Points,
}

impl Grid {
    fn evaluate(&mut self, count: usize, evaluate: impl Fn(&mut GridOut<'_>)) {
        if self.points.len() != count {
            (self.points, self.normals) = (Points::zeros(count), Points::zeros(count));
        }
        evaluate(&mut GridOut { points: self.points.view_mut(), normals: Some(self.normals.view_mut()) });
    }
}

/// What the samples of some patches show.
pub(super) struct Figures {
    pub bounds: Aabb,
    pub area: f64,
    pub volume: f64,
    /// Largest distance between corner and vertex, and largest angle between the normals there.
    pub position_error: f64,
    pub normal_error: f64,
    pub undefined: Vec<PatchId>,
    pub steep: Vec<PatchId>,
    pub folded: Vec<PatchId>,
}

impl Figures {
    /// Of no patch.
    pub const NONE: Self = Self {
        bounds: Aabb::EMPTY,
        area: 0.0,
        volume: 0.0,
        position_error: 0.0,
        normal_error: 0.0,
        undefined: Vec::new(),
        steep: Vec::new(),
        folded: Vec::new(),
    };

    /// Of the patches of both.
    pub fn and(mut self, other: Self) -> Self {
        self.undefined.extend(other.undefined);
        self.steep.extend(other.steep);
        self.folded.extend(other.folded);
        Self {
            bounds: self.bounds.union(&other.bounds),
            area: self.area + other.area,
            volume: self.volume + other.volume,
            position_error: self.position_error.max(other.position_error),
            normal_error: self.normal_error.max(other.normal_error),
            ..self
        }
    }
}

/// The lattices of both kinds of patches, as parameters and as triangles of them.
struct Lattice {
    face_points: Vec<[f64; 3]>,
    faces: FaceTable,
    face_triangles: Vec<[usize; 3]>,
    face_corners: [usize; 3],
    /// Weights of start, end and left apex.
    edge_points: Vec<[f64; 3]>,
    edges: EdgeTable,
    edge_triangles: Vec<[usize; 3]>,
}

impl Lattice {
    fn new(n: usize) -> Self {
        let share = |i: usize| i as f64 / n as f64;
        let face_points = triangle::lattice(n);
        let edge_points: Vec<[f64; 3]> =
            (0..=n).flat_map(|i| (0..=n).map(move |j| [share(n - i), share(i), share(j)])).collect();
        let at = |i: usize, j: usize| i * (n + 1) + j;
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let edge_triangles = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        Self {
            faces: FaceTable::new(&face_points),
            face_points,
            face_triangles: small_triangles(n).iter().map(|t| t.map(index::position)).collect(),
            face_corners: [[n, 0, 0], [0, n, 0], [0, 0, n]].map(index::position),
            edges: EdgeTable::new(&edge_points),
            edge_points,
            edge_triangles: edge_triangles.collect(),
        }
    }

    fn measure(&self, surface: &APatchSurface, patch: PatchId, grid: &mut Grid) -> Figures {
        let function = surface.function();
        let origin = &function.hull().data().positions()[0];
        match surface.over(patch) {
            Over::Face(f) => {
                self.sample_face(function, f, grid);
                let mut figures = figures(patch, grid, &self.face_triangles, origin);
                self.compare_corners(function, f, grid, &mut figures);
                if figures.undefined.is_empty() && self.folds_over_face(function, f, grid) {
                    figures.folded.push(patch);
                }
                figures
            }
            Over::Edge(e) => {
                grid.evaluate(self.edges.len(), |out| self.edges.evaluate(function, e, out));
                let mut figures = figures(patch, grid, &self.edge_triangles, origin);
                if figures.undefined.is_empty() && self.folds_over_edge(function, e, grid) {
                    figures.folded.push(patch);
                }
                figures
            }
        }
    }

    fn sample_face(&self, function: &APatchFunction, f: FaceId, grid: &mut Grid) {
        let Some(creased) = function.creased_face(f) else {
            return grid.evaluate(self.faces.len(), |out| self.faces.evaluate(function, f, out));
        };
        let nan = Vec3::repeat(f64::NAN);
        let samples = self.face_points.iter().map(|x| creased.sample(*x));
        let found = samples.map(|s| s.map_or((nan, nan), |s| (s.point, s.normal)));
        let (points, normals): (Vec<Vec3>, Vec<Vec3>) = found.unzip();
        (grid.points, grid.normals) = (points.into_iter().collect(), normals.into_iter().collect());
    }

    fn compare_corners(&self, function: &APatchFunction, f: FaceId, grid: &Grid, figures: &mut Figures) {
        let data = function.hull().data();
        let (positions, gradients) = (data.corners(f), data.corner_gradients(f));
        for (k, corner) in self.face_corners.into_iter().enumerate() {
            let miss = or_infinite((grid.points.get(corner) - positions[k]).norm());
            figures.position_error = figures.position_error.max(miss);
            let turn = normal_jump(&grid.normals.get(corner), &gradients[k]);
            figures.normal_error = figures.normal_error.max(turn);
        }
    }

    /// Does the normal point against the ray somewhere? A face beside a crease is pulled off its rays, so they say nothing there.
    fn folds_over_face(&self, function: &APatchFunction, f: FaceId, grid: &Grid) -> bool {
        if function.creased_face(f).is_some() {
            return false;
        }
        let (frame, apexes) = (function.hull().face_frame(f), function.hull().faces()[f.index()].apexes);
        (0..grid.points.len()).any(|i| {
            let (p, n) = (grid.points.get(i), grid.normals.get(i));
            let above = (p - frame.c).dot(&frame.normal) >= 0.0;
            let side =
                if above && apexes[0].is_some() || apexes[1].is_none() { Side::Outer } else { Side::Inner };
            apexes[side.index()].is_some_and(|apex| side.sign() * n.dot(&(apex - p)) <= 0.0)
        })
    }

    fn folds_over_edge(&self, function: &APatchFunction, e: EdgeId, grid: &Grid) -> bool {
        let (hull, mesh) = (function.hull(), function.hull().data().mesh());
        let h = mesh.edge_half_edge(e);
        let (base, k) = (&function.faces()[mesh.face(h).index()].base, mesh.side(h));
        let on_edge = [base.e[k][(k + 1) % 3], base.e[(k + 1) % 3][k]];
        let ends = [mesh.origin(h), mesh.dest(h)].map(|v| hull.data().positions()[v.index()]);
        let apexes = Side::BOTH.map(|side| hull.edge_apexes(e, side));
        let class = hull.edges()[e.index()].class;
        self.edge_points.iter().enumerate().any(|(i, [x, z, y])| {
            let goes_in = class == Class::Nonconvex && Base::on_edge(on_edge, *x, *z) > 0.0;
            let side = if class == Class::Negative || goes_in { Side::Inner } else { Side::Outer };
            apexes[side.index()].is_some_and(|[u_k, u_l]| {
                let ray = *y * u_k + (1.0 - y) * u_l - (*x * ends[0] + *z * ends[1]);
                side.sign() * grid.normals.get(i).dot(&ray) <= 0.0
            })
        })
    }
}

/// Figures of the triangles over a grid, volume as that of the cone from `origin`.
pub(super) fn figures(patch: PatchId, grid: &Grid, triangles: &[[usize; 3]], origin: &Point3) -> Figures {
    let mut figures = Figures::NONE;
    for p in (0..grid.points.len()).map(|i| grid.points.get(i)) {
        if !p.iter().all(|c| c.is_finite()) {
            figures.undefined.push(patch);
            return figures;
        }
        figures.bounds = figures.bounds.including(&p);
    }
    let mut is_steep = false;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| grid.points.get(i) - origin);
        let normal = (b - a).cross(&(c - a));
        let towards: Vec3 = triangle.map(|i| grid.normals.get(i)).iter().sum();
        figures.area += 0.5 * normal.norm();
        figures.volume += a.dot(&normal) / 6.0;
        is_steep |= normal.dot(&towards) < -FLAT * normal.norm();
    }
    if is_steep {
        figures.steep.push(patch);
    }
    figures
}

/// A triangle whose normal is off the surface normals by little more than a right angle is not counted: next to the ends of a
/// lens triangles are slivers, whose normals are rounding.
const FLAT: f64 = 1e-6;

/// Gaps and normal jumps of all seams, each sampled from both sides, one point after the other: only these, and not points
/// in vector lanes, have the same bits on both sides.
pub(super) fn seams(surface: &dyn Surface, diagonal: f64, intervals: usize) -> Seams {
    let measured: Vec<Option<(f64, f64)>> = surface
        .seams()
        .par_iter()
        .evenly()
        .map(|seam| {
            let (first, second) = (seam.first, seam.second?);
            let (mut gap, mut jump) = (0.0, 0.0);
            for i in 0..=intervals {
                let at = |side: SeamSide| surface.sample(side.patch, on_seam(surface, side, i, intervals));
                let (a, b) = (at(first), at(second));
                gap = f64::max(gap, or_infinite((a.point - b.point).norm()));
                jump = f64::max(jump, normal_jump(&a.normal, &b.normal));
            }
            Some((gap, if seam.continuity == Continuity::G1 { jump } else { 0.0 }))
        })
        .collect();
    Seams::gathered(measured, diagonal)
}

/// Parameters of point i of a seam, in the patch of one of its sides.
fn on_seam(surface: &dyn Surface, side: SeamSide, i: usize, intervals: usize) -> [f64; 2] {
    let i = if side.reversed { intervals - i } else { i };
    let (t, rest) = (i as f64 / intervals as f64, (intervals - i) as f64 / intervals as f64);
    surface.domain(side.patch).on_edge(side.edge, [rest, t])
}

fn intersections_of_input(data: &HermiteMesh) -> usize {
    let mesh = data.mesh();
    let triangles: Vec<[u32; 3]> = mesh.faces().map(|f| mesh.triangle(f).map(|v| v.0)).collect();
    mesh_intersections(data.positions(), &triangles).count
}

fn intersections(surface: &APatchSurface, resolution: APatchResolution) -> Option<Intersections> {
    let mesh = tessellate_a_patches(surface, resolution).ok()?;
    Some(places(&mesh, |patch| matches!(surface.over(patch), Over::Edge(_))))
}
