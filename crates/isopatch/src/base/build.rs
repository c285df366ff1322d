//! The whole way from a field in a box to a base mesh.

use super::base_mesh::{BaseMesh, EdgeFeature};
use super::clip::Clip;
use super::decimate::Decimation;
use super::error::BaseError;
use super::project::{ProjectOptions, project_positions};
use super::remesh::{RemeshOptions, remesh};
use super::seed::{Seed, SeedOptions, seed_mesh};
use super::singular::find_singular;
use super::triangle_mesh::TriangleMesh;
use super::validity::{Limit, ValidityLimits, Violation, validity};
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::mesh::HalfEdgeMesh;

/// How a seed mesh becomes a base mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BaseMethod {
    /// Decimated, then remeshed with edge lengths that follow curvature and estimated errors.
    #[default]
    Remesh,
    /// Decimated by quadric errors (Garland & Heckbert 1997), then only flipped: the vertices stay where decimation left
    /// them, but for their projection.
    Decimate,
}

/// Settings of [`build`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseOptions {
    /// Exact number of faces; for a closed surface an odd one is raised by one, as a closed triangle mesh has an even
    /// number. None: as many as the curvature asks for.
    pub faces: Option<usize>,
    /// Default: remeshing.
    pub method: BaseMethod,
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

impl BaseOptions {
    /// How the decimated seed is remeshed.
    fn first_remesh(&self) -> RemeshOptions {
        match self.method {
            BaseMethod::Remesh => self.remesh,
            BaseMethod::Decimate => RemeshOptions { rounds: 0, polish: 1, smoothing: 0, ..self.remesh },
        }
    }
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
    /// Is it certified that the mesh has the topology of the zero set in the box? See [`super::polygonize`].
    pub certified: bool,
}

/// A base mesh of the surface f = 0 inside a box: [`seed_mesh`], then [`base_from_seed`].
pub fn build(field: &dyn Field, bounds: &Aabb, options: &BaseOptions) -> Result<BaseOutcome, BaseError> {
    let seed = seed_mesh(field, bounds, options.faces, &options.seed)?;
    base_from_seed(field, &seed, options)
}

/// The base mesh over a seed mesh: [`decimate`](super::decimate()), [`remesh`], [`finish`].
///
/// Faces are counter-clockwise seen from where f > 0. If no spline surface could be built over a mesh with so few faces,
/// the error names a count that works; an automatic count is raised instead.
pub fn base_from_seed(
    field: &dyn Field,
    seed: &Seed,
    options: &BaseOptions,
) -> Result<BaseOutcome, BaseError> {
    let is_closed = seed.mesh.clip.is_none();
    let possible = |asked: usize| if is_closed { asked.saturating_add(asked % 2) } else { asked };
    let (faces, decimation) = rayon::join(
        || options.faces.map_or_else(|| seed.automatic_faces(&options.remesh), possible),
        || Decimation::new(&seed.mesh, &seed.normals),
    );
    let raised = options.faces.filter(|asked| *asked != faces).map(|asked| Repair {
        what: format!("{faces} faces instead of {asked}"),
        place: "whole mesh".into(),
        why: "a closed triangle mesh has an even number of faces".into(),
    });
    let base = match shaped(field, seed, decimation, faces, options) {
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
    // Every later stage keeps the topology of the seed.
    Ok(BaseOutcome { base, repairs: raised.into_iter().collect(), violations, certified: seed.certified })
}

/// The stages after the seed mesh, for one number of faces.
fn shaped(
    field: &dyn Field,
    seed: &Seed,
    decimation: Decimation<'_>,
    faces: usize,
    options: &BaseOptions,
) -> Result<BaseMesh, BaseError> {
    let coarse = decimation.to(faces)?;
    let fine = remesh(field, &coarse, faces, seed.diagonal, &options.first_remesh())?;
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
    let shaped_to =
        |faces: usize| shaped(field, seed, Decimation::new(&seed.mesh, &seed.normals), faces, options);
    let mut too_few = faces;
    let mut found = None;
    while found.is_none() {
        let count = even((too_few as f64 * GROWTH) as usize + 2);
        if count > seed.mesh.faces.len() {
            return None;
        }
        match shaped_to(count) {
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
        match shaped_to(middle) {
            Ok(base) => found = Some((middle, base)),
            Err(_) => too_few = middle,
        }
    }
    found
}

/// Projects the vertices once more, now to the full tolerance, and takes normals and curvatures from the field.
pub fn finish(
    field: &dyn Field,
    mut mesh: TriangleMesh,
    projection: &ProjectOptions,
) -> Result<BaseMesh, BaseError> {
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let sides = mesh.clip.as_ref().map_or(&[][..], |c| &c.sides);
    let report = project_positions(field, &mut mesh.positions, sides, diagonal, projection);
    let step = diagonal / (mesh.faces.len() as f64).sqrt();
    if let Some(i) = report.failures.first() {
        let at = mesh.positions[*i];
        return Err(match find_singular(field, &mesh.positions, step) {
            Some(at) => BaseError::Singular { at },
            None => BaseError::NotOnSurface { at },
        });
    }
    let connectivity = HalfEdgeMesh::from_faces(mesh.positions.len(), &mesh.faces)?;
    let base = BaseMesh::from_field(field, connectivity, mesh.positions);
    Ok(BaseMesh { clip: mesh.clip, ..base })
}

/// The base mesh of faces whose vertices are known.
pub(super) fn base_of(
    faces: &[[u32; 3]],
    positions: Vec<Point3>,
    normals: Vec<Vec3>,
    curvatures: Vec<Mat3>,
    clip: Option<Clip>,
) -> Result<BaseMesh, BaseError> {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces)?;
    let feature = |e| match mesh.twin(mesh.edge_half_edge(e)) {
        Some(_) => EdgeFeature::Smooth,
        None => EdgeFeature::Boundary,
    };
    let features = mesh.edges().map(feature).collect();
    Ok(BaseMesh { mesh, positions, normals, curvatures, features, clip, frozen_diagonal: None })
}

/// No spline surface exists over a mesh with a corner that is not between 0 and 180 degrees.
pub(super) fn require_convex_corners(violations: &[Violation]) -> Result<(), BaseError> {
    let inverted = |v: &&Violation| v.limit == Limit::Corner && !(v.value > 0.0 && v.value < 180.0);
    match violations.iter().find(inverted) {
        Some(v) => Err(BaseError::InvertedCorner { at: v.at, degrees: v.value }),
        None => Ok(()),
    }
}
