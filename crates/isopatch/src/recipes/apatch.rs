//! Rational A-patches over a mesh: Xu, Huang & Bajaj 2001, with the corrections of PAPERS.md.
//!
//! ```text
//! polygons ──► prepare ──► triangles ──► gradients ──► hull (§3) ──► function (§4) ──► surface
//!              repairs                   normals, lengths
//! ```

use super::triangulated::{Sources, Triangulated, TriangulationError, word};
use crate::apatch::{self, APatchFunction, APatchOptions, APatchSurface, Free};
use crate::base::Repair;
use crate::geom::{Point3, Vec3};
use crate::hull::{self, HermiteError, HermiteMesh, HullOptions, Problem, Reason};
use crate::io::read::PolygonMesh;
use crate::mesh::{
    EdgeId, HalfEdgeMesh, Place, PrepareOptions, VertexId, creases, gradient_lengths,
    normals::{self, NormalRule},
};
use crate::report::{APatchReport, Seconds};

/// Where the normals at the vertices come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalSource {
    /// The file.
    File,
    /// The limit of Loop subdivision, as in the paper.
    Loop,
    /// The faces around the vertex, weighted by their angles there.
    Angle,
    /// The faces around the vertex, weighted by their areas.
    Area,
}

impl NormalSource {
    /// One word, for options and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Loop => "loop",
            Self::Angle => "angle",
            Self::Area => "area",
        }
    }
}

/// How long gradients are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GradientLengths {
    /// As long as the normals of the file; computed normals have length 1.
    #[default]
    Given,
    /// 1.
    Unit,
    /// Such that the edges can be chords of a quadric, see [`gradient_lengths::recovered`].
    Recovered,
}

impl GradientLengths {
    /// One word, for options and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Unit => "unit",
            Self::Recovered => "recovered",
        }
    }
}

/// What the recipe is given besides the mesh. The default is a good choice for every stage.
#[derive(Clone, Debug, Default)]
pub struct APatchRecipe {
    /// Repairs.
    pub prepare: PrepareOptions,
    /// Where normals come from; none for the file if it has normals, which its maker knew best, and else for
    /// the Loop limit, the choice of the paper.
    pub normals: Option<NormalSource>,
    /// How long gradients are.
    pub lengths: GradientLengths,
    /// Edges whose faces have normals that differ by more than this many radians are creases; none for no creases but those
    /// that the hull needs.
    pub crease_angle: Option<f64>,
    /// Hull.
    pub hull: HullOptions,
    /// Function. Free parameters for each face are in the order of the faces of the mesh as it is given.
    pub patches: APatchOptions,
}

/// A finished surface through the vertices of a mesh.
#[derive(Debug)]
pub struct FittedMesh {
    /// The surface.
    pub surface: APatchSurface,
    /// What the method did.
    pub figures: APatchReport,
    /// What was changed to make the mesh fit the method, and what does not fit.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum APatchError {
    /// The mesh can't be made an oriented manifold of triangles.
    #[error(transparent)]
    Mesh(#[from] TriangulationError),
    /// The mesh has no positions or gradients that can be interpolated.
    #[error(transparent)]
    Data(#[from] HermiteError),
    /// Normals of the file are wanted, and it has none.
    #[error("the mesh has no normals")]
    NoNormals,
    /// Free parameters are given for another number of faces.
    #[error("free parameters are given for {given} faces; the mesh has {wanted}")]
    FreeCount {
        /// How many are given.
        given: usize,
        /// How many faces there are.
        wanted: usize,
    },
}

/// The A-patch surface of a mesh; `progress` is told the name of each stage as it starts.
///
/// Linear time, apart from the sorting of repairs. Repairs and problems are listed in the result, in the numbers of the mesh
/// as it is given; a face with a problem may have places where its patch is not defined, which tessellation then names.
pub fn fit(
    mesh: &PolygonMesh,
    recipe: &APatchRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedMesh, APatchError> {
    let mut seconds = Seconds::default();
    check_free(mesh, &recipe.patches.free)?;

    progress("mesh");
    let base = seconds.measure("mesh", || Triangulated::new(mesh, &recipe.prepare))?;
    progress("normals");
    let sharp = sharp_edges(&base, recipe);
    let (gradients, turned) = seconds.measure("normals", || {
        let ground = Ground { mesh: &base.mesh, positions: &base.positions, sources: &base.sources };
        gradients(mesh, &ground, &sharp, recipe, NormalSource::Loop)
    })?;
    progress("hull");
    let Triangulated { mesh: triangles, positions, sources, mut repairs } = base;
    let data = HermiteMesh::with_creases(triangles, positions, gradients, sharp)
        .map_err(|error| in_numbers_of_the_input(error, &sources))?;
    let hull = seconds.measure("hull", || hull::build(data, &recipe.hull));
    progress("patches");
    let free = of_triangles(&recipe.patches.free, &sources.face);
    let options = APatchOptions { free, ..recipe.patches };
    let function = seconds.measure("patches", || apatch::build(hull, &options));

    repairs.extend(turned);
    repairs.extend(problems(&function, &sources));
    let figures = APatchReport {
        normals: Some(source(mesh, recipe.normals, NormalSource::Loop).name().to_owned()),
        gradient_lengths: Some(recipe.lengths.name().to_owned()),
        ..APatchReport::new(&function)
    };
    Ok(FittedMesh { surface: APatchSurface::new(function), figures, repairs, seconds })
}

fn check_free(mesh: &PolygonMesh, free: &Free) -> Result<(), APatchError> {
    match free {
        Free::PerFace(values) if values.len() != mesh.faces.len() => {
            Err(APatchError::FreeCount { given: values.len(), wanted: mesh.faces.len() })
        }
        _ => Ok(()),
    }
}

/// The source of normals that is asked for, or else that of the file, or else `computed`.
pub(super) fn source(
    mesh: &PolygonMesh,
    asked: Option<NormalSource>,
    computed: NormalSource,
) -> NormalSource {
    let default = if mesh.normals.is_some() { NormalSource::File } else { computed };
    asked.unwrap_or(default)
}

/// A repaired mesh that gradients are made for, whatever its faces.
pub(super) struct Ground<'a> {
    pub mesh: &'a HalfEdgeMesh,
    pub positions: &'a [Point3],
    pub sources: &'a Sources,
}

/// Which edges are creases.
fn sharp_edges(base: &Triangulated, recipe: &APatchRecipe) -> Vec<bool> {
    match recipe.crease_angle {
        Some(angle) => creases::by_angle(&base.mesh, &base.positions, angle),
        None => vec![false; base.mesh.edge_count()],
    }
}

/// The gradient at every corner, and which normals of the file were changed. Without a file's normals and a choice, normals are
/// as in `default`.
pub(super) fn gradients(
    given: &PolygonMesh,
    base: &Ground<'_>,
    sharp: &[bool],
    recipe: &APatchRecipe,
    default: NormalSource,
) -> Result<(Vec<Vec3>, Vec<Repair>), APatchError> {
    let (mesh, positions) = (base.mesh, base.positions);
    let (vectors, repairs) = normals_from(source(given, recipe.normals, default), given, base, sharp)?;
    let units =
        || vectors.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect::<Vec<_>>();
    let gradients = match recipe.lengths {
        GradientLengths::Given => vectors,
        GradientLengths::Unit => units(),
        GradientLengths::Recovered => {
            let units = units();
            let lengths = gradient_lengths::recovered(mesh, positions, sharp, &units);
            units.iter().zip(lengths).map(|(n, length)| length * n).collect()
        }
    };
    Ok((gradients, repairs))
}

/// The normal at every corner, and which normals of the file were changed.
pub(super) fn normals_from(
    source: NormalSource,
    given: &PolygonMesh,
    base: &Ground<'_>,
    sharp: &[bool],
) -> Result<(Vec<Vec3>, Vec<Repair>), APatchError> {
    let computed = |rule| (normals::at_corners(base.mesh, base.positions, sharp, rule), Vec::new());
    Ok(match source {
        NormalSource::File => of_file(given, base, sharp)?,
        NormalSource::Loop => computed(NormalRule::LoopLimit),
        NormalSource::Angle => computed(NormalRule::AngleWeighted),
        NormalSource::Area => computed(NormalRule::AreaWeighted),
    })
}

/// The normals of the file, turned to the side where the faces show after repairs. Where there is none, and where several
/// are needed because sharp edges meet, the Loop limit.
fn of_file(
    given: &PolygonMesh,
    base: &Ground<'_>,
    sharp: &[bool],
) -> Result<(Vec<Vec3>, Vec<Repair>), APatchError> {
    let filed = given.normals.as_ref().ok_or(APatchError::NoNormals)?;
    let (mesh, positions) = (base.mesh, base.positions);
    let outward = normals::angle_weighted(mesh, positions);
    let limit = normals::at_corners(mesh, positions, sharp, NormalRule::LoopLimit);
    let mut vectors = limit.clone();
    let (mut missing, mut turned, mut several) = (Vec::new(), Vec::new(), Vec::new());
    for v in mesh.vertices() {
        let vertex = base.sources.vertex[v.index()];
        let normal = filed[vertex as usize];
        let is_one =
            mesh.ring(v).all(|h| limit[h.index()] == limit[mesh.ring(v).next().unwrap_or(h).index()]);
        if !is_one {
            several.push(vertex);
        } else if normal.norm() == 0.0 || !normal.norm().is_finite() {
            missing.push(vertex);
        } else {
            let points_back = normal.dot(&outward[v.index()]) < 0.0;
            if points_back {
                turned.push(vertex);
            }
            mesh.ring(v).for_each(|h| vectors[h.index()] = if points_back { -normal } else { normal });
        }
    }
    let at = |what, vertices: Vec<u32>, why| {
        word(what, &vertices.into_iter().map(Place::Vertex).collect::<Vec<_>>(), why)
    };
    let repairs = [
        at("normals computed", missing, "those of the file are zero"),
        at("normals computed on creases", several, "the file has one each, and several are needed"),
        at("normals turned over", turned, "they pointed behind the faces around them"),
    ];
    Ok((vectors, repairs.into_iter().flatten().collect()))
}

/// Free parameters of the triangles that the faces became.
fn of_triangles(free: &Free, face_source: &[u32]) -> Free {
    match free {
        Free::PerFace(values) => Free::PerFace(face_source.iter().map(|f| values[*f as usize]).collect()),
        other => other.clone(),
    }
}

/// What does not fit, a line for every reason, and what was changed to make more fit.
fn problems(function: &APatchFunction, sources: &Sources) -> Vec<Repair> {
    let hull = function.hull();
    // Of what refinement added, what it lies on.
    let at_vertex = |v: VertexId| sources.of_vertex(hull.source_vertices(v)[0]);
    let at_edge = |e: EdgeId| match hull.source_edge(e) {
        [v, w] if v == w => sources.of_vertex(v),
        ends => sources.between(ends),
    };
    let refined: Vec<Place> = hull.refined_vertices().iter().map(|v| sources.of_vertex(*v)).collect();
    let cut = format!(
        "faces around them were cut, in their planes, into {} more, which leaves room for smooth patches",
        hull.added_faces()
    );
    let rounded: Vec<Place> = hull.rounded_vertices().iter().map(|v| sources.of_vertex(*v)).collect();
    let off = format!(
        "faces around them were cut, and new vertices put up to {:.1e} of the diagonal off the edges, so that all \
         see their faces",
        hull.rounded_distance() / hull.data().diagonal()
    );
    let moved: Vec<Place> = hull.moved_normals().iter().map(|v| at_vertex(*v)).collect();
    let added: Vec<Place> = hull.added_creases().iter().map(|c| at_edge(c.edge)).collect();
    let corners: Vec<Place> = hull.corners().iter().map(|c| at_vertex(c.vertex)).collect();
    let changes = [
        ("vertices refined", refined, cut.as_str()),
        ("vertices rounded", rounded, off.as_str()),
        ("normals moved", moved, "they did not see the faces around them, or left no room for an apex"),
        ("creases added", added, "without them there is no valid surface"),
        ("corners made", corners, "no single normal sees all faces around them, or leaves room for an apex"),
    ];
    let changes = changes.into_iter().filter_map(|(what, places, why)| word(what, &places, why));
    let place = |problem: &Problem| match problem {
        Problem::Vertex { vertex, .. } => at_vertex(*vertex),
        Problem::Face { face, .. } => sources.of_face(hull.source_face(*face)),
        Problem::Edge { edge, .. } => at_edge(*edge),
    };
    let left = Reason::ALL.into_iter().filter_map(|reason| {
        let problems = hull.problems().iter().filter(|problem| problem.reason() == reason);
        word("surface not certain", &problems.map(place).collect::<Vec<_>>(), &reason.to_string())
    });
    changes.chain(left).collect()
}

pub(super) fn in_numbers_of_the_input(error: HermiteError, sources: &Sources) -> HermiteError {
    let (v, f) = (|v: u32| sources.vertex[v as usize], |f: u32| sources.face[f as usize]);
    match error {
        HermiteError::NotATriangle { face } => HermiteError::NotATriangle { face: f(face) },
        HermiteError::DegenerateFace { face } => HermiteError::DegenerateFace { face: f(face) },
        HermiteError::Position { vertex } => HermiteError::Position { vertex: v(vertex) },
        HermiteError::Gradient { vertex } => HermiteError::Gradient { vertex: v(vertex) },
        HermiteError::Sector { vertex } => HermiteError::Sector { vertex: v(vertex) },
        HermiteError::Count { .. } => error,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
