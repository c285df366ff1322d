//! The whole way from a field in a box to a base mesh.

use rayon::prelude::*;

use super::base_mesh::{BaseMesh, EdgeFeature};
use super::bounds::{side_beyond, tighten};
use super::connectivity::Connectivity;
use super::decimate::decimate;
use super::error::BaseError;
use super::polygonize::{Grid, check_samples, polygonize, sample};
use super::project::{ProjectOptions, project_positions};
use super::remesh::{RemeshOptions, remesh};
use super::shape::{largest_curvature, unit_or_zero};
use super::singular::find_singular;
use super::sizing::automatic_count;
use super::triangle_mesh::TriangleMesh;
use super::validity::{Limit, ValidityLimits, Violation, validity};
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::mesh::HalfEdgeMesh;

/// Settings of [`build`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseOptions {
    /// Exact number of faces; an odd one is raised by one, as a closed triangle mesh has an even number. None: as many as
    /// the curvature asks for.
    pub faces: Option<usize>,
    /// The seed grid.
    pub seed: SeedOptions,
    /// Remeshing, with edge lengths and projection.
    pub remesh: RemeshOptions,
    /// What the result is measured against.
    pub limits: ValidityLimits,
    /// The caller looks for a sufficient number of faces itself: if too few were asked for, no search is made, and the
    /// error says where the first stage stopped. Default false: it names a count that works.
    pub trial: bool,
}

/// Settings of [`seed_mesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeedOptions {
    /// Cells along the longest side of the surface's box in the first grid. Default 40.
    pub cells: usize,
    /// Largest number of cells along the longest side. Default 210: ten million samples at most, some 200 MB.
    pub most_cells: usize,
    /// How much finer each grid is than the one before. Default 1.5.
    pub refinement: f64,
    /// Largest product of curvature and cell size, |k|max·h. Default 1.0: a feature, two radii of curvature wide, is then
    /// two cells wide.
    pub turn: f64,
    /// The finest grid has at least this many faces for each face asked for. Default 3: decimation needs a choice.
    pub surplus: f64,
}

impl Default for SeedOptions {
    fn default() -> Self {
        Self { cells: 40, most_cells: 210, refinement: 1.5, turn: 1.0, surplus: 3.0 }
    }
}

/// Something that was changed or is not as it should be.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Repair {
    /// What was done or found.
    pub what: String,
    /// To which element, or near which point.
    #[serde(rename = "where")]
    pub place: String,
    /// For which reason.
    pub why: String,
}

/// A base mesh and what is to be said about it.
#[derive(Clone, Debug)]
pub struct BaseOutcome {
    /// The mesh.
    pub base: BaseMesh,
    /// Departures from what was asked.
    pub repairs: Vec<Repair>,
    /// Corners beyond the limits; a spline surface exists all the same, but may be poor there.
    pub violations: Vec<Violation>,
}

/// A fine triangle mesh near the surface, from [`seed_mesh`].
#[derive(Clone, Debug)]
pub struct Seed {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// The field's unit normal at each vertex.
    pub normals: Vec<Vec3>,
    /// |k|max at each vertex.
    pub curvatures: Vec<f64>,
    /// Is f < 0 outside, so that the field is to be negated for the solid to be bounded?
    pub negative_outside: bool,
    /// Edge length of a grid cell.
    pub step: f64,
    /// Diagonal of the bounding box.
    pub diagonal: f64,
}

/// A base mesh of the closed surface f = 0 inside a box: [`seed_mesh`], then [`base_from_seed`].
pub fn build(field: &dyn Field, bounds: &Aabb, options: &BaseOptions) -> Result<BaseOutcome, BaseError> {
    let seed = seed_mesh(field, bounds, options.faces, &options.seed)?;
    base_from_seed(field, &seed, options)
}

/// The base mesh over a seed mesh: [`decimate`], [`remesh`], [`finish`].
///
/// Faces are counter-clockwise seen from where f > 0. If no spline surface could be built over a mesh with so few faces,
/// the error names a count that works; an automatic count is raised instead.
pub fn base_from_seed(
    field: &dyn Field,
    seed: &Seed,
    options: &BaseOptions,
) -> Result<BaseOutcome, BaseError> {
    let mut repairs = Vec::new();
    let faces = match options.faces {
        None => seed.automatic_faces(&options.remesh),
        Some(asked) if asked % 2 == 0 => asked,
        Some(asked) => {
            repairs.push(Repair {
                what: format!("{} faces instead of {asked}", asked + 1),
                place: "whole mesh".into(),
                why: "a closed triangle mesh has an even number of faces".into(),
            });
            asked + 1
        }
    };
    let base = match shaped(field, seed, faces, options) {
        Ok(base) => base,
        Err(error @ (BaseError::TooFewFaces { .. } | BaseError::InvertedCorner { .. })) => {
            if options.trial {
                return Err(error);
            }
            let (least, base) = least_that_works(field, seed, faces, options).ok_or(error)?;
            if let Some(asked) = options.faces {
                return Err(BaseError::TooFewFaces { asked, least });
            }
            base
        }
        Err(error) => return Err(error),
    };
    let violations = validity(&base, &options.limits);
    Ok(BaseOutcome { base, repairs, violations })
}

/// The stages after the seed mesh, for one number of faces.
fn shaped(
    field: &dyn Field,
    seed: &Seed,
    faces: usize,
    options: &BaseOptions,
) -> Result<BaseMesh, BaseError> {
    let coarse = decimate(&seed.mesh, &seed.normals, faces)?;
    let fine = remesh(field, &coarse, faces, seed.diagonal, &options.remesh)?;
    let base = finish(field, fine, &options.remesh.projection)?;
    require_convex_corners(&validity(&base, &options.limits))?;
    Ok(base)
}

/// The smallest count found above `faces` for which there is a mesh: by growing steps, then by bisection.
///
/// Counts do not fail or work monotonically, so this is the least that was seen to work, not a proven minimum.
fn least_that_works(
    field: &dyn Field,
    seed: &Seed,
    faces: usize,
    options: &BaseOptions,
) -> Option<(usize, BaseMesh)> {
    const GROWTH: f64 = 1.3;
    const BISECTIONS: usize = 3;
    let even = |f: usize| f + f % 2;
    let mut too_few = faces;
    let mut found = None;
    while found.is_none() {
        let count = even((too_few as f64 * GROWTH) as usize + 2);
        if count > seed.mesh.faces.len() {
            return None;
        }
        match shaped(field, seed, count, options) {
            Ok(base) => found = Some((count, base)),
            // Decimation names a lower bound by itself.
            Err(BaseError::TooFewFaces { least, .. }) => too_few = count.max(least.saturating_sub(2)),
            Err(_) => too_few = count,
        }
    }
    for _ in 0..BISECTIONS {
        let enough = found.as_ref().map_or(0, |f| f.0);
        let middle = even((too_few + enough) / 2);
        if middle >= enough || middle <= too_few {
            break;
        }
        match shaped(field, seed, middle, options) {
            Ok(base) => found = Some((middle, base)),
            Err(_) => too_few = middle,
        }
    }
    found
}

impl Seed {
    /// Edges, by their ends, at which the difference of the unit normals is longer than `turn`.
    pub fn sharp_edges(&self, turn: f64) -> impl Iterator<Item = [usize; 2]> + '_ {
        let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
        let edges = self.mesh.faces.iter().flat_map(sides).filter(|[a, b]| a < b);
        let edges = edges.map(|ends| ends.map(|v| v as usize));
        edges.filter(move |[a, b]| (self.normals[*a] - self.normals[*b]).norm() > turn)
    }

    /// The number of faces that the curvature asks for.
    pub fn automatic_faces(&self, options: &RemeshOptions) -> usize {
        let x = &self.mesh.positions;
        Connectivity::from_faces(x.len(), &self.mesh.faces)
            .map_or(0, |c| automatic_count(&c, x, &self.curvatures, self.diagonal, &options.sizing))
    }
}

/// Polygonises ever finer grids until Euler number and number of components repeat and the curvature is resolved.
///
/// The grids cover the part of the box where the surface is. `faces` is the number of faces wanted in the end, if known.
pub fn seed_mesh(
    field: &dyn Field,
    bounds: &Aabb,
    faces: Option<usize>,
    options: &SeedOptions,
) -> Result<Seed, BaseError> {
    let mut region = tighten(field, bounds)?;
    let enclosure = region;
    let mut cells = options.cells.max(4);
    let mut last: Option<(i64, usize)> = None;
    loop {
        let mut next_cells = (cells as f64 * options.refinement).ceil() as usize;
        let finest = next_cells > options.most_cells;
        let samples = sample(field, &Grid::covering(&region, cells));
        let negative_outside = match check_samples(&samples) {
            Ok(negative) => negative,
            // The box around the coarser mesh was too narrow: take all of it again.
            Err(BaseError::SurfaceLeavesBox { .. }) if region != enclosure => {
                region = enclosure;
                continue;
            }
            Err(BaseError::NoSurface { .. }) if !finest => {
                cells = next_cells;
                continue;
            }
            Err(BaseError::SurfaceLeavesBox { side, at }) => {
                // The grid may stick out of the box a little.
                let at = at.sup(&bounds.min).inf(&bounds.max);
                return Err(BaseError::SurfaceLeavesBox { side, at });
            }
            Err(error) => return Err(error),
        };
        let mesh = polygonize(&samples)?;
        let step = samples.grid.step;
        let topology = (mesh.euler_number(), mesh.component_count());
        let around = Aabb::around(&mesh.positions);
        let wanted = options.surplus * faces.unwrap_or(0) as f64;
        let fine_faces = mesh.faces.len() as f64;
        let enough = fine_faces >= wanted;
        if (last == Some(topology) && enough) || finest {
            let seed = describe(field, mesh, negative_outside, step);
            if let Some(at) = find_singular(field, &seed.mesh.positions, step) {
                return Err(match side_beyond(bounds, &at) {
                    None => BaseError::Singular { at },
                    Some(side) => BaseError::SurfaceLeavesBox { side, at },
                });
            }
            require_surface(field, &seed)?;
            let resolved = seed.curvatures.iter().filter(|k| **k * step > options.turn).count()
                <= seed.curvatures.len() / UNRESOLVED_SHARE;
            if last == Some(topology) && (resolved || finest) {
                return Ok(seed);
            }
            if finest {
                let euler = [last.map_or(0, |t| t.0), topology.0];
                return Err(BaseError::Unresolved { cells, euler });
            }
        }
        // Two cells are more than the surface can stick out between the nodes if the grid resolves it at all.
        let narrow = around.grown(2.0 * step);
        region = Aabb::new(narrow.min.sup(&enclosure.min), narrow.max.inf(&enclosure.max));
        last = Some(topology);
        // No finer than needed for the number of faces, which grows with the square of the cells.
        let needed = cells as f64 * (1.1 * wanted / fine_faces).sqrt();
        next_cells = next_cells.min((needed as usize).max((cells as f64 * LEAST_REFINEMENT).ceil() as usize));
        cells = next_cells;
    }
}

/// Grids differ at least by this factor, so that equal topologies say something.
const LEAST_REFINEMENT: f64 = 1.25;

/// One vertex in so many may have a larger curvature than the grid resolves.
const UNRESOLVED_SHARE: usize = 100;

fn describe(field: &dyn Field, mesh: TriangleMesh, negative_outside: bool, step: f64) -> Seed {
    let (normals, curvatures): (Vec<Vec3>, Vec<f64>) = mesh
        .positions
        .par_iter()
        .map(|p| {
            let jet = field.jet(*p);
            let k = largest_curvature(&jet.curvature_tensor());
            (unit_or_zero(&jet.gradient), if k.is_finite() { k } else { 0.0 })
        })
        .unzip();
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let curvatures = with_turns(&mesh, &normals, curvatures);
    Seed { mesh, normals, curvatures, negative_outside, step, diagonal }
}

/// Curvatures that are at least the turn of the normal along the edges at a vertex: a sharp rim can pass between all
/// vertices of a coarse mesh.
fn with_turns(mesh: &TriangleMesh, normals: &[Vec3], mut curvatures: Vec<f64>) -> Vec<f64> {
    for f in &mesh.faces {
        for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
            let (a, b) = (a as usize, b as usize);
            let turn = (normals[a] - normals[b]).norm() / (mesh.positions[a] - mesh.positions[b]).norm();
            if turn.is_finite() {
                curvatures[a] = curvatures[a].max(turn);
                curvatures[b] = curvatures[b].max(turn);
            }
        }
    }
    curvatures
}

/// A sign change need not be a zero: if more vertices than this share cannot be projected, it is something else.
const STRAY_SHARE: f64 = 0.01;

/// Fails if the sign changes at a pole or a jump instead of a zero.
fn require_surface(field: &dyn Field, seed: &Seed) -> Result<(), BaseError> {
    let mut positions = seed.mesh.positions.clone();
    let report = project_positions(field, &mut positions, seed.diagonal, &ProjectOptions::default());
    match report.failures.first() {
        Some(i) if report.failures.len() as f64 > STRAY_SHARE * positions.len() as f64 => {
            Err(BaseError::NotOnSurface { at: seed.mesh.positions[*i] })
        }
        _ => Ok(()),
    }
}

/// Projects the vertices once more, now to the full tolerance, and takes normals and curvatures from the field.
pub fn finish(
    field: &dyn Field,
    mut mesh: TriangleMesh,
    projection: &ProjectOptions,
) -> Result<BaseMesh, BaseError> {
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let report = project_positions(field, &mut mesh.positions, diagonal, projection);
    let step = diagonal / (mesh.faces.len() as f64).sqrt();
    if let Some(i) = report.failures.first() {
        let at = mesh.positions[*i];
        return Err(match find_singular(field, &mesh.positions, step) {
            Some(at) => BaseError::Singular { at },
            None => BaseError::NotOnSurface { at },
        });
    }
    let connectivity = HalfEdgeMesh::from_faces(mesh.positions.len(), &mesh.faces)?;
    Ok(BaseMesh::from_field(field, connectivity, mesh.positions))
}

/// The base mesh of faces whose vertices are known.
pub(super) fn base_of(
    faces: &[[u32; 3]],
    positions: Vec<Point3>,
    normals: Vec<Vec3>,
    curvatures: Vec<Mat3>,
) -> Result<BaseMesh, BaseError> {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces)?;
    let feature = |e| match mesh.twin(mesh.edge_half_edge(e)) {
        Some(_) => EdgeFeature::Smooth,
        None => EdgeFeature::Boundary,
    };
    let features = mesh.edges().map(feature).collect();
    Ok(BaseMesh { mesh, positions, normals, curvatures, features, clip: None })
}

/// No spline surface exists over a mesh with a corner that is not between 0 and 180 degrees.
pub(super) fn require_convex_corners(violations: &[Violation]) -> Result<(), BaseError> {
    let inverted = |v: &&Violation| v.limit == Limit::Corner && !(v.value > 0.0 && v.value < 180.0);
    match violations.iter().find(inverted) {
        Some(v) => Err(BaseError::InvertedCorner { at: v.at, degrees: v.value }),
        None => Ok(()),
    }
}
