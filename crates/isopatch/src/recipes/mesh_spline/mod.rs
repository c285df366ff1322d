//! The G1 spline of Tong & Kim 2009 through the vertices of a triangle mesh.
//!
//! ```text
//! polygons ──► prepare ──► triangles ──► normals ──► curvature tensors ──► curves ──► patches ──► folds? ──► surface
//!              repairs                      ▲               ▲                                       │
//!                                           └───────────────┴──────── rounds ───────────────────────┘
//! ```

mod cut;
mod rim;
mod visible;

use cut::{Cut, cut};
use rim::Rims;

use crate::base::{BaseMesh, EdgeFeature, Repair, Weights, compatible_curvatures};
use crate::geom::{Point3, angle_between};
use crate::io::read::PolygonMesh;
use crate::mesh::{
    self, EdgeId, FaceId, HalfEdgeMesh, MeshError, MeshFault, PrepareOptions, Prepared, TooManyCorners, Triangles, VertexId,
    creases, normals,
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
    /// Edges whose faces have normals that differ by more than this many radians are sharp.
    pub crease_angle: Option<f64>,
    pub sharpenings: usize,
    pub epsilon: f64,
    pub prior: f64,
    pub sweeps: usize,
}

impl Default for MeshSplineRecipe {
    fn default() -> Self {
        Self { prepare: PrepareOptions::default(), curves: CurveOptions::default(), rounds: 4, crease_angle: None, sharpenings: 20, epsilon: 1e-3, prior: 1e-2, sweeps: 20 }
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
const STIFFEST: f64 = 1e3;

/// The spline through the vertices of a mesh; `progress` is told the name of each stage as it starts.
pub fn fit(
    given: &PolygonMesh,
    recipe: &MeshSplineRecipe,
    progress: &dyn Fn(&str),
) -> Result<MeshFitted, MeshSplineError> {
    let mut seconds = Seconds::default();
    progress("mesh");
    let Triangulated { mesh, positions, face_source, mut repairs, .. } = seconds.measure("mesh", || triangles(given, recipe))?;
    let mut maker = Maker { whole: &mesh, positions: &positions, recipe, seconds };
    let mut sharp = match recipe.crease_angle {
        Some(angle) => creases::by_angle(&mesh, &positions, angle),
        None => vec![false; mesh.edge_count()],
    };
    progress("patches");
    let debug = std::env::var("MS_DEBUG").is_ok();
    let asked = sharp.clone();
    let mut last = Vec::new();
    for round in 0..=recipe.sharpenings {
        let piece = maker.pieces(&sharp)?;
        if debug { eprintln!("sharpening {round}: {} sharp, {} folded, {} curves", sharp.iter().filter(|s| **s).count(), piece.folded.len(), piece.failed.len()); }
        if piece.folded.is_empty() && piece.failed.is_empty() {
            let surface = maker.whole_surface(&piece, &sharp);
            let added = (0..sharp.len()).filter(|e| sharp[*e] && !asked[*e]).count();
            if added > 0 {
                repairs.push(repair(format!("edges made sharp: {added}"), "mesh".into(), "patches beside them folded over".into()));
            }
            return Ok(MeshFitted { surface, deviations: piece.deviations, repairs, seconds: maker.seconds });
        }
        sharpen(&mesh, &positions, &piece.folded, &piece.failed, &mut sharp);
        last = piece.folded;
    }
    Err(MeshSplineError::Folded { faces: last.into_iter().map(|f| face_source[f]).collect() })
}

/// Edges of bad faces become sharp: those with the larger angles first, and then all of them.
fn sharpen(mesh: &HalfEdgeMesh, positions: &[Point3], folded: &[usize], failed: &[EdgeId], sharp: &mut [bool]) {
    let normals = normals::of_faces(mesh, positions);
    let turn = |e: EdgeId| {
        let h = mesh.edge_half_edge(e);
        let g = mesh.twin(h)?;
        Some(angle_between(&normals[mesh.face(h).index()], &normals[mesh.face(g).index()]))
    };
    let mut made = vec![false; sharp.len()];
    let around = |v: VertexId| mesh.ring(v).map(|h| mesh.edge(h)).collect::<Vec<_>>();
    let corners = folded.iter().flat_map(|f| mesh.triangle(FaceId::from(*f)));
    let ends = failed.iter().flat_map(|e| { let h = mesh.edge_half_edge(*e); [mesh.origin(h), mesh.dest(h)] });
    let mut vertices: Vec<VertexId> = corners.chain(ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    for v in vertices {
        let candidates: Vec<(f64, EdgeId)> = around(v).into_iter().filter(|e| !sharp[e.index()]).filter_map(|e| Some((turn(e)?, e))).collect();
        let most = candidates.iter().map(|(t, _)| *t).fold(0.0, f64::max);
        for (t, e) in candidates {
            if t >= SHARPEST_SHARE * most && t > LEAST_SHARP {
                made[e.index()] = true;
            }
        }
    }
    if !made.iter().any(|m| *m) {
        for f in folded {
            mesh.face_half_edges(FaceId::from(*f)).for_each(|h| made[mesh.edge(h).index()] = mesh.twin(h).is_some());
        }
        for v in failed.iter().flat_map(|e| { let h = mesh.edge_half_edge(*e); [mesh.origin(h), mesh.dest(h)] }) {
            around(v).into_iter().for_each(|e| made[e.index()] = mesh.twin(mesh.edge_half_edge(e)).is_some());
        }
    }
    sharp.iter_mut().zip(made).for_each(|(s, m)| *s |= m);
}

const SHARPEST_SHARE: f64 = 0.7;
const LEAST_SHARP: f64 = 0.35;

struct Maker<'a> {
    whole: &'a HalfEdgeMesh,
    positions: &'a [Point3],
    recipe: &'a MeshSplineRecipe,
    seconds: Seconds,
}

/// The best surface of the pieces.
struct Pieces {
    cut: Cut,
    surface: Option<TriangularSpline>,
    deviations: Vec<f64>,
    folded: Vec<usize>,
    /// Edges of the whole without a curve.
    failed: Vec<EdgeId>,
}

impl Maker<'_> {
    fn pieces(&mut self, sharp: &[bool]) -> Result<Pieces, MeshSplineError> {
        let (whole, positions, recipe) = (self.whole, self.positions, self.recipe);
        let debug = std::env::var("MS_DEBUG").is_ok();
        let seconds = &mut self.seconds;
        let cut = cut(whole, positions, sharp).map_err(MeshSplineError::Triangles)?;
        let rims = Rims::new(whole, &cut, positions);
        let mut base = seconds.measure("normals and curvatures", || BaseMesh::estimated(cut.mesh.clone(), cut.positions.clone()));
        let visibility = visible::see_faces(&base.mesh, &base.positions, &mut base.normals);
        if debug { eprintln!("moved {} hidden {}", visibility.moved.len(), visibility.hidden.len()); }
        let mesh = cut.mesh.clone();
        let inner: Vec<EdgeId> = mesh.edges().filter(|e| mesh.twin(mesh.edge_half_edge(*e)).is_some()).collect();
        let mut stiffness = vec![1.0; mesh.edge_count()];
        let mut best: Option<(TriangularSpline, Vec<f64>, Vec<usize>)> = None;
        let mut failed = Vec::new();
        for round in 0..=recipe.rounds {
            for v in mesh.vertices() {
                base.normals[v.index()] = rims.across(&cut, v, &base.normals[v.index()]);
            }
            base.curvatures = seconds.measure("normals and curvatures", || {
                compatible_curvatures(&base, &Weights { epsilon: recipe.epsilon, prior: recipe.prior, sweeps: recipe.sweeps, stiffness: &stiffness })
            });
            let fits = interpolate_edges(&base, &inner, &recipe.curves);
            failed.clear();
            for (e, fit) in inner.iter().zip(&fits) {
                if fit.is_err() {
                    // Half edges of pieces and whole have the same numbers.
                    failed.push(whole.edge(mesh.edge_half_edge(*e)));
                    stiffness[e.index()] *= STIFFER;
                }
            }
            if !failed.is_empty() { if debug { eprintln!("round {round}: {} curves failed", failed.len()); } continue; }
            let mut fits = fits.into_iter().flatten();
            let curves: Vec<QuarticCurve> = mesh.edges().filter_map(|e| {
                let h = mesh.edge_half_edge(e);
                match mesh.twin(h) {
                    Some(_) => fits.next(),
                    None => {
                        let first = whole.edge_half_edge(whole.edge(h));
                        let mut curve = rims.curve(whole, positions, first);
                        if first != h { curve.q.reverse(); }
                        Some(curve)
                    }
                }
            }).collect();
            let surface = seconds.measure("patches", || spline::fill(base.clone(), &curves))?;
            let deviations = seconds.measure("check", || normal_deviations(&surface, LATTICE));
            let folded: Vec<usize> = (0..deviations.len()).filter(|f| deviations[*f] >= FRAC_PI_2).collect();
            if debug { eprintln!("round {round}: {} folded", folded.len()); }
            let mut vertices: Vec<VertexId> = folded.iter().flat_map(|f| mesh.triangle(FaceId::from(*f))).collect();
            vertices.sort_unstable();
            vertices.dedup();
            for f in &folded {
                for h in mesh.face_half_edges(FaceId::from(*f)) {
                    let s = &mut stiffness[mesh.edge(h).index()];
                    *s = (*s * STIFFER).min(STIFFEST);
                }
            }
            let done = folded.is_empty();
            if best.as_ref().is_none_or(|b| folded.len() < b.2.len()) {
                best = Some((surface, deviations, folded));
            }
            if done { break; }
            visible::see_better(&base.mesh, &base.positions, &mut base.normals, &vertices, 0.5);
        }
        Ok(match best {
            Some((surface, deviations, folded)) => Pieces { cut, surface: Some(surface), deviations, folded, failed: Vec::new() },
            None => Pieces { cut, surface: None, deviations: Vec::new(), folded: Vec::new(), failed },
        })
    }

    /// The pieces joined along their rims.
    fn whole_surface(&self, pieces: &Pieces, _sharp: &[bool]) -> TriangularSpline {
        let (whole, cut) = (self.whole, &pieces.cut);
        let Some(surface) = pieces.surface.clone() else { unreachable!() };
        let mut first = vec![usize::MAX; whole.vertex_count()];
        cut.source.iter().enumerate().rev().for_each(|(copy, v)| first[v.index()] = copy);
        let normals = first.iter().map(|v| surface.base.normals[*v]).collect();
        let curvatures = first.iter().map(|v| surface.base.curvatures[*v]).collect();
        let mut base = BaseMesh::from_parts(whole.clone(), self.positions.to_vec(), normals, curvatures);
        let mut curves = Vec::with_capacity(whole.edge_count());
        for e in whole.edges() {
            let h = whole.edge_half_edge(e);
            let in_cut = cut.mesh.edge(h);
            let mut q = surface.curves[in_cut.index()];
            if cut.mesh.edge_half_edge(in_cut) != h { q.reverse(); }
            curves.push(q);
            if cut.mesh.twin(h).is_none() && whole.twin(h).is_some() {
                base.features[e.index()] = EdgeFeature::Sharp;
            }
        }
        TriangularSpline::new(base, curves, surface.nets)
    }
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
