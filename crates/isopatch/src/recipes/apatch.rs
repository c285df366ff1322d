//! Rational A-patches over a mesh: Xu, Huang & Bajaj 2001, with the corrections of PAPERS.md.
//!
//! ```text
//! polygons ──► prepare ──► triangles ──► gradients ──► hull (§3) ──► function (§4) ──► surface
//!              repairs                   normals, lengths
//! ```

use crate::apatch::{self, APatchFunction, APatchOptions, APatchSurface, Free};
use crate::base::Repair;
use crate::geom::{Point3, Vec3};
use crate::hull::{self, HermiteError, HermiteMesh, HullOptions, Problem, Reason};
use crate::io::read::PolygonMesh;
use crate::mesh::{
    self, EdgeId, FaceId, HalfEdgeMesh, MeshError, MeshFault, Place, PrepareOptions, Prepared,
    TooManyCorners, Triangles, VertexId, creases, gradient_lengths,
    normals::{self, NormalRule},
    place_names,
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
    /// The mesh can't be repaired.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// A face has too many corners.
    #[error(transparent)]
    Corners(#[from] TooManyCorners),
    /// The triangles into which polygons were cut are no manifold.
    #[error("its polygons, cut into triangles, are no manifold: {0}")]
    Triangles(MeshError),
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
    let base = seconds.measure("mesh", || triangles(mesh, recipe))?;
    progress("normals");
    let sharp = sharp_edges(&base, recipe);
    let (gradients, turned) = seconds.measure("normals", || gradients(mesh, &base, &sharp, recipe))?;
    progress("hull");
    let data = HermiteMesh::with_creases(base.connectivity, base.positions, gradients, sharp)
        .map_err(|error| in_numbers_of_the_input(error, &base.vertex_source, &base.face_source))?;
    let hull = seconds.measure("hull", || hull::build(data, &recipe.hull));
    progress("patches");
    let free = of_triangles(&recipe.patches.free, &base.face_source);
    let options = APatchOptions { free, ..recipe.patches };
    let function = seconds.measure("patches", || apatch::build(hull, &options));

    let mut repairs = base.repairs;
    repairs.extend(turned);
    repairs.extend(problems(&function, &base.vertex_source, &base.face_source));
    let figures = APatchReport {
        normals: Some(source(mesh, recipe).name().to_owned()),
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

/// An oriented manifold of triangles, and what became of the mesh on the way.
struct Base {
    connectivity: HalfEdgeMesh,
    positions: Vec<Point3>,
    /// Number that each vertex and each triangle has in the mesh as it is given.
    vertex_source: Vec<u32>,
    face_source: Vec<u32>,
    repairs: Vec<Repair>,
}

fn triangles(given: &PolygonMesh, recipe: &APatchRecipe) -> Result<Base, APatchError> {
    let Prepared { positions, faces, vertex_source, face_source, repairs, .. } =
        mesh::prepare(&given.positions, &given.faces, &recipe.prepare)?;
    let polygons = faces.iter().filter(|corners| corners.len() > 3).count();
    let in_input = |error: TooManyCorners| TooManyCorners { face: face_source[error.face as usize], ..error };
    let Triangles { faces, source } = mesh::triangulate(&positions, &faces).map_err(in_input)?;
    let connectivity = HalfEdgeMesh::from_faces(positions.len(), &faces).map_err(APatchError::Triangles)?;
    let mut repairs: Vec<Repair> =
        repairs.iter().map(|r| repair(r.what(), r.place(), r.kind.why().to_owned())).collect();
    if polygons > 0 {
        let why = "patches are over triangles".to_owned();
        repairs.push(repair(format!("polygons cut into triangles: {polygons}"), "mesh".to_owned(), why));
    }
    let face_source = source.into_iter().map(|f: FaceId| face_source[f.index()]).collect();
    Ok(Base { connectivity, positions, vertex_source, face_source, repairs })
}

fn repair(what: String, place: String, why: String) -> Repair {
    Repair { what, place, why }
}

/// The source of normals that is asked for, or else the default.
fn source(mesh: &PolygonMesh, recipe: &APatchRecipe) -> NormalSource {
    let default = if mesh.normals.is_some() { NormalSource::File } else { NormalSource::Loop };
    recipe.normals.unwrap_or(default)
}

/// Which edges are creases.
fn sharp_edges(base: &Base, recipe: &APatchRecipe) -> Vec<bool> {
    match recipe.crease_angle {
        Some(angle) => creases::by_angle(&base.connectivity, &base.positions, angle),
        None => vec![false; base.connectivity.edge_count()],
    }
}

/// The gradient at every corner, and which normals of the file were changed.
fn gradients(
    given: &PolygonMesh,
    base: &Base,
    sharp: &[bool],
    recipe: &APatchRecipe,
) -> Result<(Vec<Vec3>, Vec<Repair>), APatchError> {
    let (mesh, positions) = (&base.connectivity, &base.positions[..]);
    let computed = |rule| (normals::at_corners(mesh, positions, sharp, rule), Vec::new());
    let (vectors, repairs) = match source(given, recipe) {
        NormalSource::File => of_file(given, base, sharp)?,
        NormalSource::Loop => computed(NormalRule::LoopLimit),
        NormalSource::Angle => computed(NormalRule::AngleWeighted),
        NormalSource::Area => computed(NormalRule::AreaWeighted),
    };
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

/// The normals of the file, turned to the side where the faces show after repairs. Where there is none, and where several
/// are needed because sharp edges meet, the Loop limit.
fn of_file(
    given: &PolygonMesh,
    base: &Base,
    sharp: &[bool],
) -> Result<(Vec<Vec3>, Vec<Repair>), APatchError> {
    let filed = given.normals.as_ref().ok_or(APatchError::NoNormals)?;
    let (mesh, positions) = (&base.connectivity, &base.positions[..]);
    let outward = normals::angle_weighted(mesh, positions);
    let limit = normals::at_corners(mesh, positions, sharp, NormalRule::LoopLimit);
    let mut vectors = limit.clone();
    let (mut missing, mut turned, mut several) = (Vec::new(), Vec::new(), Vec::new());
    for v in mesh.vertices() {
        let vertex = base.vertex_source[v.index()];
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
    let word = |what: &str, vertices: Vec<u32>, why: &str| {
        let places: Vec<Place> = vertices.into_iter().map(Place::Vertex).collect();
        (!places.is_empty())
            .then(|| repair(format!("{what}: {}", places.len()), place_names(&places), why.to_owned()))
    };
    let repairs = [
        word("normals computed", missing, "those of the file are zero"),
        word("normals computed on creases", several, "the file has one each, and several are needed"),
        word("normals turned over", turned, "they pointed behind the faces around them"),
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

/// What does not fit, a line for every reason, and the normals that were moved to make more fit.
fn problems(function: &APatchFunction, vertex_source: &[u32], face_source: &[u32]) -> Vec<Repair> {
    let hull = function.hull();
    let vertex = |v: &VertexId| Place::Vertex(vertex_source[v.index()]);
    let edge = |e: EdgeId| {
        let mesh = hull.data().mesh();
        let h = mesh.edge_half_edge(e);
        let [a, b] = [mesh.origin(h), mesh.dest(h)].map(|v| vertex_source[v.index()]);
        Place::Edge(a.min(b), a.max(b))
    };
    let mut lines = Vec::new();
    if !hull.moved_normals().is_empty() {
        let places: Vec<Place> = hull.moved_normals().iter().map(vertex).collect();
        let why = "they did not see the faces around them, or left no room for an apex".to_owned();
        lines.push(repair(format!("normals moved: {}", places.len()), place_names(&places), why));
    }
    let added = hull.added_creases();
    if !added.is_empty() {
        let places: Vec<Place> = added.iter().map(|crease| edge(crease.edge)).collect();
        let why = "without them there is no valid surface".to_owned();
        lines.push(repair(format!("creases added: {}", places.len()), place_names(&places), why));
    }
    if !hull.corners().is_empty() {
        let places: Vec<Place> = hull.corners().iter().map(|corner| vertex(&corner.vertex)).collect();
        let why = "no single normal sees all faces around them, or leaves room for an apex".to_owned();
        lines.push(repair(format!("corners made: {}", places.len()), place_names(&places), why));
    }
    for reason in Reason::ALL {
        let place = |problem: &Problem| match problem {
            Problem::Vertex { vertex: v, .. } => vertex(v),
            Problem::Face { face, .. } => Place::Face(face_source[face.index()]),
            Problem::Edge { edge: e, .. } => edge(*e),
        };
        let places: Vec<Place> =
            hull.problems().iter().filter(|problem| problem.reason() == reason).map(place).collect();
        if !places.is_empty() {
            let what = format!("surface not certain: {}", places.len());
            lines.push(repair(what, place_names(&places), reason.to_string()));
        }
    }
    lines
}

fn in_numbers_of_the_input(error: HermiteError, vertex_source: &[u32], face_source: &[u32]) -> HermiteError {
    let (v, f) = (|v: u32| vertex_source[v as usize], |f: u32| face_source[f as usize]);
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
