//! The G1 spline of Tong & Kim 2009 through the vertices of a triangle mesh, for solids that a CAD program can read.
//!
//! ```text
//! polygons ──► triangles ──► pieces ──► normals, tensors ──► curves ──► patches ──► no fold ──► surface
//!              mesh::prepare    ▲         ▲    estimate,                  spline::     │
//!                               │         │    compatible                 fill         │ folds
//!                               │         └── rounds: other normals and tensors ───────┤
//!                               └──────────── more sharp edges ────────────────────────┘
//! ```
//!
//! There is no surface to fit to: normals and curvature tensors are estimated at the vertices, the curves interpolate
//! them, and the patches are filled between the curves as smoothly as the G1 conditions let them be. The surface has one patch a
//! face, goes through all vertices, and is G1 but across sharp edges. Sharp edges are those that were asked for, and
//! those across which no smooth surface could be made that does not fold; the latter are listed among the repairs.

mod cut;
mod pieces;
mod rim;
mod sharpen;
mod visible;

use super::triangulated::{Sources, Triangulated, TriangulationError, word};
use crate::base::{EdgeFeature, Repair};
use crate::io::read::PolygonMesh;
use crate::mesh::{EdgeId, FaceId, MeshError, Place, PrepareOptions, creases, place_names};
use crate::network::CurveOptions;
use crate::report::Seconds;
use crate::spline::TriangularSpline;
use pieces::{Attempt, Maker};
pub(super) use sharpen::Sharpness;

/// What the recipe is given besides the mesh. The default is a good choice for smooth meshes.
#[derive(Clone, Debug)]
pub struct MeshSplineRecipe {
    /// Repairs of the mesh.
    pub prepare: PrepareOptions,
    /// Edges whose faces have normals that differ by more than this many radians are sharp; none for no sharp edges but
    /// those that are needed.
    pub crease_angle: Option<f64>,
    /// Boundary curves; of these options, only those of the first fit count.
    pub curves: CurveOptions,
    /// Most times that normals and curvature tensors are changed because patches fold. Default 4.
    pub rounds: usize,
    /// Most times that more edges become sharp because patches still fold; with 0, a fold is an error. Default 100: each
    /// leaves fewer edges smooth, so that they end.
    pub sharpenings: usize,
}

impl Default for MeshSplineRecipe {
    fn default() -> Self {
        Self {
            prepare: PrepareOptions::default(),
            crease_angle: None,
            curves: CurveOptions::default(),
            rounds: 4,
            sharpenings: 100,
        }
    }
}

/// A finished surface.
#[derive(Clone, Debug)]
pub struct FittedMeshSpline {
    /// The surface: patch i over triangle i.
    pub surface: TriangularSpline,
    /// Number that each triangle has in the mesh as it is given; those of a polygon have the same.
    pub face_source: Vec<u32>,
    /// Number that each vertex has there.
    pub vertex_source: Vec<u32>,
    /// Number of sharp edges.
    pub sharp_edges: usize,
    /// Largest angle between the normal of each patch and the blended normals of its corners, in radians: below π/2, as no
    /// patch folds.
    pub normal_deviations: Vec<f64>,
    /// What was changed, in the numbers of the mesh as it is given.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface. Vertices and faces have the numbers of the mesh as it is given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshSplineError {
    /// The mesh can't be made an oriented manifold of triangles.
    #[error(transparent)]
    Mesh(#[from] TriangulationError),
    /// The pieces between sharp edges are no manifold.
    #[error("cut along its sharp edges, it is no manifold: {0}")]
    Pieces(#[from] MeshError),
    /// Edges have no curve with the normals and curvatures of their ends, or no G1 patches beside them.
    #[error("no smooth surface is possible along {} edges: {}", edges.len(), named(edges.iter().map(|[a, b]| Place::Edge(*a, *b))))]
    NoCurve {
        /// Their ends.
        edges: Vec<[u32; 2]>,
    },
    /// Patches fold over, whatever was tried.
    #[error("{} patches fold over: {}", faces.len(), named(faces.iter().map(|f| Place::Face(*f))))]
    Folded {
        /// Their faces.
        faces: Vec<u32>,
    },
}

fn named(places: impl Iterator<Item = Place>) -> String {
    place_names(&places.collect::<Vec<_>>())
}

/// The spline through the vertices of a mesh; `progress` is told the name of each stage as it starts.
///
/// Linear time for each round. Closed and open meshes of any number of components; boundaries are curves through their
/// vertices.
pub fn fit(
    given: &PolygonMesh,
    recipe: &MeshSplineRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedMeshSpline, MeshSplineError> {
    let mut seconds = Seconds::default();
    progress("mesh");
    let base = seconds.measure("mesh", || Triangulated::new(given, &recipe.prepare))?;
    let (mesh, positions) = (&base.mesh, &base.positions[..]);
    let edges = match recipe.crease_angle {
        Some(angle) => creases::by_angle(mesh, positions, angle),
        None => vec![false; mesh.edge_count()],
    };
    let mut sharpness = Sharpness { edges, corners: vec![false; mesh.vertex_count()] };
    let asked = sharpness.edges.clone();
    let maker = Maker { whole: mesh, positions, curves: &recipe.curves, rounds: recipe.rounds };
    let mut left = recipe.sharpenings;
    let (made, moved) = loop {
        progress("patches");
        let Attempt { made, failed, moved } = maker.attempt(&sharpness, &mut seconds)?;
        let folded = match made {
            Some(made) if made.folded.is_empty() => break (made, moved),
            Some(made) => made.folded,
            None => Vec::new(),
        };
        if left == 0 || !sharpness.sharpen(mesh, positions, &folded, &failed) {
            return Err(error(&base, &folded, &failed));
        }
        left -= 1;
    };
    let mut repairs = base.repairs.clone();
    let moved: Vec<Place> = moved.iter().map(|v| base.sources.of_vertex(*v)).collect();
    let added = mesh.edges().filter(|e| sharpness.edges[e.index()] && !asked[e.index()]);
    let added: Vec<Place> = added.map(|e| base.sources.of_edge(mesh, e)).collect();
    repairs.extend(word(
        "normals moved",
        &moved,
        "they did not see the faces around them, or patches there folded",
    ));
    repairs.extend(word("edges made sharp", &added, "smooth patches folded there"));
    let normal_deviations = made.deviations.clone();
    let surface = made.joined(mesh, positions);
    let sharp_edges = surface.base.features.iter().filter(|f| **f == EdgeFeature::Sharp).count();
    let Sources { face: face_source, vertex: vertex_source } = base.sources;
    Ok(FittedMeshSpline {
        surface,
        face_source,
        vertex_source,
        sharp_edges,
        normal_deviations,
        repairs,
        seconds,
    })
}

fn error(base: &Triangulated, folded: &[FaceId], failed: &[EdgeId]) -> MeshSplineError {
    if folded.is_empty() {
        let ends = failed.iter().map(|e| base.sources.ends(&base.mesh, *e));
        return MeshSplineError::NoCurve { edges: ends.collect() };
    }
    MeshSplineError::Folded { faces: folded.iter().map(|f| base.sources.face[f.index()]).collect() }
}
