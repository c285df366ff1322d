//! The whole way from a field in a box to a base mesh.

use super::base_mesh::BaseMesh;
use super::decimate::decimate;
use super::error::BaseError;
use super::project::{ProjectOptions, project_positions};
use super::remesh::{RemeshOptions, remesh};
use super::seed::{Seed, SeedOptions, seed_mesh};
use super::singular::find_singular;
use super::triangle_mesh::TriangleMesh;
use super::validity::{Limit, ValidityLimits, Violation, validity};
use crate::field::Field;
use crate::geom::Aabb;
use crate::mesh::HalfEdgeMesh;

/// Settings of [`build`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseOptions {
    /// Exact number of faces; for a closed surface an odd one is raised by one, as a closed triangle mesh has an even
    /// number. None: as many as the curvature asks for.
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

/// A base mesh of the surface f = 0 inside a box: [`seed_mesh`], then [`base_from_seed`].
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
        Some(asked) if asked % 2 == 0 || seed.mesh.clip.is_some() => asked,
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

/// No spline surface exists over a mesh with a corner that is not between 0 and 180 degrees.
pub(super) fn require_convex_corners(violations: &[Violation]) -> Result<(), BaseError> {
    let inverted = |v: &&Violation| v.limit == Limit::Corner && !(v.value > 0.0 && v.value < 180.0);
    match violations.iter().find(inverted) {
        Some(v) => Err(BaseError::InvertedCorner { at: v.at, degrees: v.value }),
        None => Ok(()),
    }
}
