//! The G1 spline of Tong & Kim 2009 through the vertices of a triangle mesh.
//!
//! ```text
//! polygons ──► prepare ──► triangles ──► normals ──► curvature tensors ──► curves ──► patches ──► folds? ──► surface
//!              repairs                      ▲               ▲                                       │
//!                                           └───────────────┴──────── rounds ───────────────────────┘
//! ```

mod visible;

use crate::base::{BaseMesh, Repair, Weights, compatible_curvatures};
use crate::geom::Point3;
use crate::io::read::PolygonMesh;
use crate::mesh::{
    self, FaceId, HalfEdgeMesh, MeshError, MeshFault, PrepareOptions, Prepared, TooManyCorners, Triangles,
};
use crate::network::{CurveError, CurveOptions, QuarticCurve, interpolate_edges};
use crate::report::Seconds;
use crate::spline::{self, SplineError, TriangularSpline, normal_deviations};
use std::f64::consts::FRAC_PI_2;

/// What the recipe is given besides the mesh.
#[derive(Clone, Debug)]
pub struct MeshSplineRecipe {
    /// Repairs.
    pub prepare: PrepareOptions,
    /// Boundary curves.
    pub curves: CurveOptions,
    /// Most times that normals and curvature tensors are changed because patches fold.
    pub rounds: usize,
    pub epsilon: f64,
    pub prior: f64,
    pub sweeps: usize,
}

impl Default for MeshSplineRecipe {
    fn default() -> Self {
        Self { prepare: PrepareOptions::default(), curves: CurveOptions::default(), rounds: 12, epsilon: 1e-3, prior: 1e-2, sweeps: 20 }
    }
}

/// A finished surface.
#[derive(Clone, Debug)]
pub struct MeshFitted {
    /// The surface.
    pub surface: TriangularSpline,
    /// Largest angle between patch normals and blended vertex normals, of each patch, in radians.
    pub deviations: Vec<f64>,
    /// What was changed.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshSplineError {
    /// The mesh can't be repaired.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// A face has too many corners.
    #[error(transparent)]
    Corners(#[from] TooManyCorners),
    /// The triangles into which polygons were cut are no manifold.
    #[error("its polygons, cut into triangles, are no manifold: {0}")]
    Triangles(MeshError),
    /// A boundary curve failed.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// A G1 system failed.
    #[error(transparent)]
    Spline(#[from] SplineError),
    /// Patches fold over.
    #[error("{} patches fold over: over faces {}", faces.len(), named(faces))]
    Folded {
        /// Faces of the mesh as it was given.
        faces: Vec<u32>,
    },
}

const NAMED: usize = 10;

fn named(faces: &[u32]) -> String {
    let names: Vec<String> = faces.iter().take(NAMED).map(u32::to_string).collect();
    names.join(", ") + if faces.len() > NAMED { ", …" } else { "" }
}

const LATTICE: usize = 10;
const STIFFER: f64 = 10.0;

/// The spline through the vertices of a mesh; `progress` is told the name of each stage as it starts.
pub fn fit(
    given: &PolygonMesh,
    recipe: &MeshSplineRecipe,
    progress: &dyn Fn(&str),
) -> Result<MeshFitted, MeshSplineError> {
    let mut seconds = Seconds::default();
    progress("mesh");
    let Triangulated { mesh, positions, face_source, repairs, .. } = seconds.measure("mesh", || triangles(given, recipe))?;
    progress("normals and curvatures");
    let mut base = seconds.measure("normals and curvatures", || BaseMesh::estimated(mesh, positions));
    let visibility = visible::see_faces(&base.mesh, &base.positions, &mut base.normals);
    let debug = std::env::var("MS_DEBUG").is_ok();
    if debug { eprintln!("moved {} hidden {}", visibility.moved.len(), visibility.hidden.len()); }
    progress("patches");
    let mut stiffness = vec![1.0; base.mesh.edge_count()];
    let mut best: Option<(TriangularSpline, Vec<f64>, Vec<usize>)> = None;
    let mut failure = None;
    for round in 0..=recipe.rounds {
        base.curvatures = seconds.measure("normals and curvatures", || {
            compatible_curvatures(&base, &Weights { epsilon: recipe.epsilon, prior: recipe.prior, sweeps: recipe.sweeps, stiffness: &stiffness })
        });
        let fits = interpolate_edges(&base, &recipe.curves);
        let mut failed = 0;
        for (e, fit) in fits.iter().enumerate() {
            if let Err(error) = fit {
                failed += 1;
                failure = Some(*error);
                stiffness[e] *= STIFFER;
            }
        }
        if failed > 0 { if debug { eprintln!("round {round}: {failed} curves failed"); } continue; }
        let curves: Vec<QuarticCurve> = fits.into_iter().flatten().collect();
        let surface = seconds.measure("patches", || spline::fill(base.clone(), &curves))?;
        let deviations = seconds.measure("check", || normal_deviations(&surface, LATTICE));
        let folded: Vec<usize> = (0..deviations.len()).filter(|f| deviations[*f] >= FRAC_PI_2).collect();
        if debug { eprintln!("round {round}: {} folded", folded.len()); }
        let var = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
        let mut vertices: Vec<crate::mesh::VertexId> = folded.iter().flat_map(|f| base.mesh.triangle(FaceId::from(*f))).collect();
        vertices.sort_unstable();
        vertices.dedup();
        for f in &folded {
            for h in base.mesh.face_half_edges(FaceId::from(*f)) {
                let s = &mut stiffness[base.mesh.edge(h).index()];
                *s = (*s * var("STIFFER", 10.)).min(var("STIFFEST", 1000.));
            }
        }
        visible::see_better(&base.mesh, &base.positions, &mut base.normals, &vertices, var("SHARE", 0.5));
        let done = folded.is_empty();
        if best.as_ref().is_none_or(|b| folded.len() < b.2.len()) {
            best = Some((surface, deviations, folded));
        }
        if done { break; }
    }
    let Some((surface, deviations, folded)) = best else {
        return Err(failure.map_or(MeshSplineError::Folded { faces: Vec::new() }, MeshSplineError::Curve));
    };
    if !folded.is_empty() {
        return Err(MeshSplineError::Folded { faces: folded.into_iter().map(|f| face_source[f]).collect() });
    }
    Ok(MeshFitted { surface, deviations, repairs, seconds })
}

/// An oriented manifold of triangles, and what became of the mesh on the way.
struct Triangulated {
    mesh: HalfEdgeMesh,
    positions: Vec<Point3>,
    /// Number that each triangle has in the mesh as it is given.
    face_source: Vec<u32>,
    repairs: Vec<Repair>,
}

fn triangles(given: &PolygonMesh, recipe: &MeshSplineRecipe) -> Result<Triangulated, MeshSplineError> {
    let Prepared { positions, faces, face_source, repairs, .. } =
        mesh::prepare(&given.positions, &given.faces, &recipe.prepare)?;
    let polygons = faces.iter().filter(|corners| corners.len() > 3).count();
    let in_input = |error: TooManyCorners| TooManyCorners { face: face_source[error.face as usize], ..error };
    let Triangles { faces, source } = mesh::triangulate(&positions, &faces).map_err(in_input)?;
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).map_err(MeshSplineError::Triangles)?;
    let mut repairs: Vec<Repair> =
        repairs.iter().map(|r| repair(r.what(), r.place(), r.kind.why().to_owned())).collect();
    if polygons > 0 {
        let why = "patches are over triangles".to_owned();
        repairs.push(repair(format!("polygons cut into triangles: {polygons}"), "mesh".to_owned(), why));
    }
    let face_source = source.into_iter().map(|f: FaceId| face_source[f.index()]).collect();
    Ok(Triangulated { mesh, positions, face_source, repairs })
}

fn repair(what: String, place: String, why: String) -> Repair {
    Repair { what, place, why }
}
