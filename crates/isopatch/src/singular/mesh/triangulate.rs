//! From a singular set to a conforming mesh.

use std::collections::BTreeSet;

use super::arcs::{Arc, Piece, PieceEnd};
use super::assemble::{RawMesh, Solver, assemble, divisible};
use super::decimate::{Limits, decimate};
use super::grid::{Cell, SPAN};
use super::mend::turned;
use super::normals::set_normals;
use super::partition::{Center, Content, Fineness, Partition, Skeleton};
use super::ridge::onto_ridges;
use super::roots::Isolator;
use super::singular_mesh::{LowerPart, SingularMesh, VertexKind};
use crate::base::{BoxSide, BoxSides};
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};
use crate::singular::{CurveKind, LowerDimensional, PointKind, SingularSet, SpecialKind};

/// How a conforming mesh is made. Lengths are relative to the diagonal of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangulateOptions {
    /// Largest distance between the surface and its triangles, |f| / |∇f|. Default 5e-3: what the eye sees as round.
    pub tolerance: f64,
    /// Least |∇f| in this quotient, in the units of f over those of the model. Default: a thousandth of the median of |∇f|
    /// over the vertices.
    pub gradient_floor: Option<f64>,
    /// Number of triangles at which thinning out ends, if the tolerance does not end it before. Default 0: the fewest
    /// that keep the tolerance; none for a mesh that is not thinned out.
    pub triangles: Option<usize>,
    /// Most rounds in which cells with something odd are divided. Default 8.
    pub rounds: usize,
}

impl Default for TriangulateOptions {
    fn default() -> Self {
        Self { tolerance: 5e-3, gradient_floor: None, triangles: Some(0), rounds: 8 }
    }
}

/// Why there is no conforming mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TriangulateError {
    /// The roots along an edge are not found reliably.
    #[error("the degree {degree} is above {MAX_DEGREE}, the highest for a conforming triangulation")]
    Degree {
        /// The degree.
        degree: u32,
    },
    /// The mesh would end in a singular curve.
    #[error("a singular curve lies in the side of the {side} of the box: move that side a little")]
    CurveInSide {
        /// The side.
        side: BoxSide,
    },
    /// What is cut off at the box there can not be told.
    #[error("the singular point ({:.6}, {:.6}, {:.6}) lies on an edge of the box: move a side of the box a little", at.x, at.y, at.z)]
    PointOnEdge {
        /// The point.
        at: Point3,
    },
}

/// A conforming mesh, and how sure it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulated {
    /// The mesh.
    pub mesh: SingularMesh,
    /// Triangles before it was thinned out.
    pub raw_triangles: usize,
    /// Cells of the octree that hold a part of the surface.
    pub cells: usize,
    /// Cells of these, beside singularities, for which no bounds show what is in them.
    pub uncertain: usize,
    /// Least |∇f| in distances.
    pub gradient_floor: f64,
    /// Places where what was found is not as expected; empty if all went well.
    pub doubtful: Vec<Point3>,
}

/// Highest degree: beyond, Bernstein coefficients from values lose more than half of their digits.
pub const MAX_DEGREE: u32 = 24;

/// Where edges of cells are divided, per axis: nothing simple lies on such planes. The next is tried where that happens.
const RATIOS: [[f64; 3]; 3] =
    [[0.48712, 0.50931, 0.49373], [0.51417, 0.48239, 0.50713], [0.47913, 0.49171, 0.51871]];
/// With more cells than this, other divisions are not tried.
const MANY_CELLS: usize = 30_000;
/// Levels of cells at least, of those along arcs, and of those around centres.
const LEVELS: [u8; 3] = [3, 5, 6];
/// Deepest cells: a detail smaller than the 2¹⁴th part of the box is lost.
const DEEPEST: u8 = 14;
/// Deepest cells that are divided because flat triangles in them are too far from the surface.
const DEEPEST_FOR_CHORD: u8 = 8;
/// The same because they turn over.
const DEEPEST_FOR_TURN: u8 = 6;
/// Parts in which the surface meets a small sphere around a node.
const NAPPES: usize = 2;
/// Share of the tolerance that the mesh may use before it is thinned out.
const RAW_SHARE: f64 = 0.5;
/// Points nearer to a side of the box than this share of its diagonal are taken as lying in it.
const SNAP: f64 = 1e-9;
/// Spacing of the points of arcs by which cells know that an arc is near, as a share of the diagonal of the box.
const SPACING: f64 = 2e-3;

/// The part of the surface f = 0 in a box as triangles that conform to its singular set there.
///
/// f is a polynomial of total degree `degree` without repeated factors, `set` its singular set in the box.
pub fn triangulate(
    field: &dyn Field,
    degree: u32,
    set: &SingularSet,
    bounds: &Aabb,
    options: &TriangulateOptions,
) -> Result<Triangulated, TriangulateError> {
    let isolator = Isolator::new(degree as usize).filter(|_| degree <= MAX_DEGREE);
    let isolator = isolator.ok_or(TriangulateError::Degree { degree })?;
    let solver = Solver { field, isolator };
    let (skeleton, kinds) = skeleton(&solver, set, bounds)?;
    let tolerance = options.tolerance * bounds.diagonal();
    let mut best: Option<(RawMesh, usize, usize)> = None;
    for ratio in RATIOS {
        let found = raw_mesh(&solver, &skeleton, &kinds, bounds, tolerance, ratio, options);
        let (is_clean, found_cells) = (found.0.doubtful.is_empty(), found.1);
        if best.as_ref().is_none_or(|b| found.0.doubtful.len() < b.0.doubtful.len()) {
            best = Some(found);
        }
        if is_clean || found_cells > MANY_CELLS {
            break;
        }
    }
    let (raw, cells, uncertain) = best.unwrap_or_default();
    let doubtful: Vec<Point3> = raw.doubtful_places();
    let raw_triangles = raw.triangles.len();
    let sides = raw.positions.iter().map(|p| BoxSides::of(p, bounds)).collect();
    let mut mesh = SingularMesh {
        positions: raw.positions,
        vertices: raw.kinds,
        sides,
        triangles: raw.triangles,
        normals: Vec::new(),
        singular_edges: Vec::new(),
        lower: lower(set),
    };
    // Before vertices move, an edge between two singular vertices is always a piece of an arc.
    let is_piece = |ends: &[u32; 2]| ends.iter().all(|v| mesh.vertices[*v as usize].is_singular());
    mesh.singular_edges = mesh.edges().into_keys().filter(is_piece).collect();
    let floor =
        options.gradient_floor.unwrap_or_else(|| FLOOR_SHARE * median_gradient(field, &mesh.positions));
    if let Some(enough) = options.triangles {
        mesh = thinned_out(field, &mesh, Limits { tolerance, floor, enough });
    }
    set_normals(field, &mut mesh);
    Ok(Triangulated { mesh, raw_triangles, cells, uncertain, gradient_floor: floor, doubtful })
}

/// Shares of the tolerance that are tried while triangles turn over: it may be larger than parts of the surface.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];

/// The mesh with fewer triangles, of which as few as possible turn over.
fn thinned_out(field: &dyn Field, raw: &SingularMesh, limits: Limits) -> SingularMesh {
    let mut best: Option<(usize, SingularMesh)> = None;
    for share in SHARES {
        let mut mesh = raw.clone();
        let limits = Limits { tolerance: share * limits.tolerance, ..limits };
        decimate(field, &mut mesh, limits);
        if onto_ridges(field, &mut mesh, limits) > 0 {
            decimate(field, &mut mesh, limits);
        }
        let turned = turned(field, &mesh).len();
        if best.as_ref().is_none_or(|(fewest, _)| turned < *fewest) {
            best = Some((turned, mesh));
        }
        if turned == 0 {
            break;
        }
    }
    best.map_or_else(|| raw.clone(), |(_, mesh)| mesh)
}

/// Share of the median of |∇f| below which a gradient counts as that long.
pub(super) const FLOOR_SHARE: f64 = 1e-3;

pub(super) fn median_gradient(field: &dyn Field, points: &[Point3]) -> f64 {
    let mut sizes: Vec<f64> = points.iter().map(|p| field.gradient(*p).1.norm()).collect();
    let middle = sizes.len() / 2;
    if sizes.is_empty() { 1.0 } else { *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

fn lower(set: &SingularSet) -> Vec<LowerPart> {
    let part = |part: &LowerDimensional| match *part {
        LowerDimensional::Point(i) => LowerPart::Point(set.points[i].at),
        LowerDimensional::Curve(i) => LowerPart::Stick(set.curves[i].samples.iter().map(|s| s.at).collect()),
    };
    set.lower_dimensional.iter().map(part).collect()
}

/// The partition with which as little as possible is odd, and its mesh; cells and uncertain ones.
fn raw_mesh(
    solver: &Solver<'_>,
    skeleton: &Skeleton,
    kinds: &[VertexKind],
    bounds: &Aabb,
    tolerance: f64,
    ratio: [f64; 3],
    options: &TriangulateOptions,
) -> (RawMesh, usize, usize) {
    let fineness = Fineness { chord: RAW_SHARE * tolerance, levels: LEVELS, deepest: DEEPEST };
    let mut partition = Partition::new(solver.field, bounds, skeleton, fineness, ratio);
    let mut round = 0;
    loop {
        let mut raw = assemble(solver, skeleton, kinds, &partition);
        let mut coarse = divisible(&raw.doubtful, DEEPEST);
        let errors = raw.far_cells(solver.field, tolerance, &partition);
        coarse.extend(errors.into_iter().filter(|cell| cell.level < DEEPEST_FOR_CHORD));
        if coarse.is_empty() || round == options.rounds || partition.is_full(coarse.len()) {
            raw.doubtful.extend(partition.lost());
            let uncertain = partition.leaves.values().filter(|c| **c == Content::Uncertain).count();
            return (raw, partition.leaves.len(), uncertain);
        }
        partition.split(&coarse);
        round += 1;
    }
}

/// Weights of the points at which a triangle is compared with the surface.
const SAMPLES: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];

impl RawMesh {
    /// Cells beside the singular set in which triangles are farther from the surface than the tolerance, or turn over.
    fn far_cells(&self, field: &dyn Field, tolerance: f64, partition: &Partition<'_>) -> BTreeSet<Cell> {
        let floor = FLOOR_SHARE * median_gradient(field, &self.positions);
        let is_far = |t: &[u32; 3], cell: &Cell| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let flat = (b - a).cross(&(c - a));
            let turns_over = |v: &u32| {
                self.kinds[*v as usize] == VertexKind::Regular
                    && field.gradient(self.positions[*v as usize]).1.dot(&flat) < 0.0
            };
            (cell.level < DEEPEST_FOR_TURN && t.iter().any(turns_over))
                || SAMPLES
                    .iter()
                    .any(|w| distance(field, a * w[0] + b * w[1] + c * w[2], floor) > RAW_SHARE * tolerance)
        };
        let pairs = self.triangles.iter().zip(&self.cells);
        let unknown = pairs.filter(|(_, cell)| !matches!(partition.leaves[cell], Content::Graph(_)));
        unknown.filter(|(t, cell)| is_far(t, cell)).map(|(_, cell)| *cell).collect()
    }

    fn doubtful_places(&self) -> Vec<Point3> {
        let mut first: std::collections::BTreeMap<Cell, Point3> = std::collections::BTreeMap::new();
        for (t, cell) in self.triangles.iter().zip(&self.cells) {
            if self.doubtful.contains(cell) {
                first.entry(*cell).or_insert(self.positions[t[0] as usize]);
            }
        }
        first.into_values().collect()
    }
}

/// |f| / |∇f|, with gradients at least as long as `floor`.
pub(super) fn distance(field: &dyn Field, p: Point3, floor: f64) -> f64 {
    let (f, gradient) = field.gradient(p);
    f.abs() / gradient.norm().max(floor)
}

/// The singular set as the partition wants it, with the kinds of its centres.
fn skeleton(
    solver: &Solver<'_>,
    set: &SingularSet,
    bounds: &Aabb,
) -> Result<(Skeleton, Vec<VertexKind>), TriangulateError> {
    let snap = |p: Point3| snapped(p, bounds);
    for curve in &set.curves {
        let sides = curve.samples.iter().map(|s| BoxSides::of(&snap(s.at), bounds));
        let common = sides.reduce(BoxSides::common).unwrap_or_default();
        if let Some(side) = common.iter().next() {
            return Err(TriangulateError::CurveInSide { side });
        }
    }
    let mut centers = Vec::new();
    let mut kinds = Vec::new();
    for (i, point) in set.points.iter().enumerate() {
        let at = snap(point.at);
        // A node in a side of the box may be cut in any way.
        let is_whole = point.kind == PointKind::Node && BoxSides::of(&at, bounds).is_empty();
        let parts = is_whole.then_some(NAPPES);
        centers.push(Center { at, has_sheets: point.kind != PointKind::Isolated, parts });
        kinds.push(VertexKind::Isolated(i as u32));
    }
    let mut center_of = vec![None; set.special.len()];
    for (i, special) in set.special.iter().enumerate() {
        let at = snap(special.at);
        let arcs = set.curves.iter().filter(|c| c.ends.is_some_and(|e| e.contains(&i)));
        let kinds_here: Vec<CurveKind> = arcs.map(|c| c.kind).collect();
        let sides = BoxSides::of(&at, bounds);
        let is_gate = special.kind == SpecialKind::Box
            && kinds_here.len() == 1
            && (kinds_here[0] != CurveKind::Crossing || goes_through(solver.field, at, sides, bounds));
        if is_gate && sides.len() == 1 {
            continue;
        }
        center_of[i] = Some(centers.len());
        let has_sheets = kinds_here.iter().any(|k| *k != CurveKind::Stick);
        centers.push(Center { at, has_sheets, parts: None });
        kinds.push(VertexKind::Special(i as u32));
    }
    if let Some(center) = centers.iter().find(|c| BoxSides::of(&c.at, bounds).len() > 1) {
        return Err(TriangulateError::PointOnEdge { at: center.at });
    }
    let arcs: Vec<Arc> = set.curves.iter().map(|curve| Arc::new(curve, snap)).collect();
    let end = |special: usize| match center_of[special] {
        Some(center) => PieceEnd::Center(center),
        None => {
            let side = BoxSides::of(&snap(set.special[special].at), bounds).iter().next();
            let (axis, upper) = side.map_or((0, false), |s| (s.axis, s.upper));
            PieceEnd::Plane { axis, key: if upper { SPAN } else { 0 } }
        }
    };
    let pieces = set.curves.iter().zip(&arcs).enumerate().map(|(i, (curve, arc))| Piece {
        arc: i,
        range: [0.0, arc.length()],
        ends: curve.ends.map_or([PieceEnd::Seam; 2], |ends| ends.map(end)),
    });
    let pieces = pieces.collect();
    let spacing = SPACING * bounds.diagonal();
    let samples =
        arcs.iter().flat_map(|arc| arc.points(spacing)).chain(centers.iter().map(|c| c.at)).collect();
    Ok((Skeleton { centers, arcs, pieces, samples }, kinds))
}

fn snapped(p: Point3, bounds: &Aabb) -> Point3 {
    let reach = SNAP * bounds.diagonal();
    let snap = |x: f64, lo: f64, hi: f64| {
        if (x - lo).abs() <= reach {
            lo
        } else if (x - hi).abs() <= reach {
            hi
        } else {
            x
        }
    };
    Point3::from_fn(|a, _| snap(p[a], bounds.min[a], bounds.max[a]))
}

/// Does f change its sign around a point of a side, in that side? Otherwise an arc ends there with its sheets.
fn goes_through(field: &dyn Field, p: Point3, sides: BoxSides, bounds: &Aabb) -> bool {
    /// Radius of the circle, as a share of the diagonal, and points on it.
    const RADIUS: f64 = 1e-3;
    const POINTS: usize = 64;
    let Some(side) = sides.iter().next() else { return false };
    let (u, v) = (Vec3::ith((side.axis + 1) % 3, 1.0), Vec3::ith((side.axis + 2) % 3, 1.0));
    let values: Vec<f64> = (0..POINTS)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / POINTS as f64;
            field.value(p + (u * angle.cos() + v * angle.sin()) * RADIUS * bounds.diagonal())
        })
        .collect();
    values.iter().any(|f| *f < 0.0) && values.iter().any(|f| *f > 0.0)
}
