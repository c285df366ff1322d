//! Rational patches over a mesh: Bajaj & Xu 1997, sections 5 and 6, with the construction of [`crate::rational::across`].
//!
//! ```text
//! polygons ──► prepare ──► triangles ──► normals ──► frame ──► wires, patches ──► no fold ──► surface
//!              repairs                     ▲                                        │
//!                                          └──── turned, then more sharp edges ─────┘
//! ```
//!
//! The surface goes through all vertices and has the normals there; it is G1 but across sharp edges. Where patches fold, normals are
//! turned to see the faces around them better, then more edges become sharp, as for the spline of [`super::mesh_spline`].

use super::apatch::{self, NormalSource};
use super::mesh_spline::Sharpness;
use super::triangulated::{Triangulated, TriangulationError, word};
use crate::base::Repair;
use crate::geom::Vec3;
use crate::hull::most_visible_direction;
use crate::io::read::PolygonMesh;
use crate::mesh::{FaceId, HalfEdgeId, HalfEdgeMesh, Place, PrepareOptions, VertexId, creases, normals};
use crate::rational::{Built, Folds, Frame, FrameError, RationalSurface, build, folds};
use crate::report::Seconds;

/// What the recipe is given besides the mesh. The default is a good choice for smooth meshes.
#[derive(Clone, Debug)]
pub struct RationalRecipe {
    /// Repairs of the mesh.
    pub prepare: PrepareOptions,
    /// Where normals come from; none for the file if it has normals, and else for the Loop limit.
    pub normals: Option<NormalSource>,
    /// Edges whose faces have normals that differ by more than this many radians are sharp; none for no sharp edges but those that are
    /// needed.
    pub crease_angle: Option<f64>,
    /// Most times that normals are turned because patches fold. Default 4.
    pub rounds: usize,
    /// Most times that more edges become sharp because patches still fold. Default 20.
    pub sharpenings: usize,
    /// Intervals of the lattice on which patches are looked at for folds. Default 8.
    pub lattice: usize,
}

impl Default for RationalRecipe {
    fn default() -> Self {
        Self {
            prepare: PrepareOptions::default(),
            normals: None,
            crease_angle: None,
            rounds: 4,
            sharpenings: 20,
            lattice: 8,
        }
    }
}

/// A finished surface through the vertices of a mesh.
#[derive(Clone, Debug)]
pub struct FittedRational {
    /// The surface: patch i over triangle i.
    pub surface: RationalSurface,
    /// Where the normals came from.
    pub normals: NormalSource,
    /// Number of edges across which two patches meet, but are not G1.
    pub sharp_edges: usize,
    /// Faces whose patches fold over, whatever was tried, in the numbers of the mesh as it is given.
    pub folded: Vec<u32>,
    /// What was changed, in the numbers of the mesh as it is given.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RationalError {
    /// The mesh can't be made an oriented manifold of triangles.
    #[error(transparent)]
    Mesh(#[from] TriangulationError),
    /// The mesh has positions or normals that can't be interpolated.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Normals of the file are wanted, and it has none.
    #[error("the mesh has no normals")]
    NoNormals,
}

/// The rational surface of a mesh; `progress` is told the name of each stage as it starts.
///
/// Linear time for each round. Closed and open meshes of any number of components; boundaries are curves through their vertices.
pub fn fit(
    given: &PolygonMesh,
    recipe: &RationalRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedRational, RationalError> {
    let mut seconds = Seconds::default();
    let start = Start::new(given, recipe, &mut seconds, progress)?;
    let Start { base, source, sharp: asked, .. } = &start;
    let mesh = &base.mesh;
    let mut attempt = Attempt::new(&start);
    progress("patches");
    let Folds { middles, faces: folded } = seconds.measure("folds", || attempt.unfold(recipe))?;
    let Built { mut surface, lost_normals } = seconds.measure("patches", || build(&attempt.frame()))?;
    middles.iter().for_each(|(patch, middle)| surface.set_middle(*patch, *middle));

    let mut repairs = [base.repairs.as_slice(), &start.changed].concat();
    let of_faces = |faces: Vec<u32>| faces.into_iter().map(Place::Face).collect::<Vec<_>>();
    let source_of = |f: u32| base.sources.face[f as usize];
    let added = mesh.edges().filter(|e| attempt.sharpness.edges[e.index()] && !asked[e.index()]);
    let added: Vec<Place> = added.map(|e| base.sources.of_edge(mesh, e)).collect();
    let moved: Vec<Place> = attempt.moved().map(|v| base.sources.of_vertex(v)).collect();
    let folded: Vec<u32> = folded.into_iter().map(source_of).collect();
    let lost = of_faces(lost_normals.into_iter().map(|(f, _)| source_of(f)).collect());
    repairs.extend(word("normals moved", &moved, "patches there folded"));
    repairs.extend(word("edges made sharp", &added, "smooth patches folded there"));
    repairs.extend(word(
        "corners without a tangent plane",
        &lost,
        "the planes of the sharp edges there have no line in common",
    ));
    let filled: Vec<u32> = middles.into_iter().map(|(patch, _)| source_of(patch.0)).collect();
    repairs.extend(word("middles of patches moved", &of_faces(filled), "the patches folded there"));
    repairs.extend(word("surface not certain", &of_faces(folded.clone()), "a patch folds over"));
    let sharp = mesh.edges().filter(|e| attempt.sharpness.edges[e.index()]).count();
    Ok(FittedRational { surface, normals: *source, sharp_edges: sharp, folded, repairs, seconds })
}

/// What patches over a mesh begin with.
pub(super) struct Start {
    pub base: Triangulated,
    /// Where the normals come from.
    pub source: NormalSource,
    /// Of the edges: is one asked to be sharp?
    pub sharp: Vec<bool>,
    /// At the origin of each half edge.
    pub normals: Vec<Vec3>,
    /// What was changed for the sake of the normals.
    pub changed: Vec<Repair>,
}

impl Start {
    pub(super) fn new(
        given: &PolygonMesh,
        recipe: &RationalRecipe,
        seconds: &mut Seconds,
        progress: &dyn Fn(&str),
    ) -> Result<Self, RationalError> {
        progress("mesh");
        let base = seconds.measure("mesh", || Triangulated::new(given, &recipe.prepare))?;
        progress("normals");
        let source = apatch::source(given, recipe.normals, NormalSource::Loop);
        let Triangulated { mesh, positions, sources, .. } = &base;
        let sharp = match recipe.crease_angle {
            Some(angle) => creases::by_angle(mesh, positions, angle),
            None => vec![false; mesh.edge_count()],
        };
        let ground = apatch::Ground { mesh, positions, sources };
        let found = seconds.measure("normals", || apatch::normals_from(source, given, &ground, &sharp));
        let (normals, changed) = found.map_err(|_| RationalError::NoNormals)?;
        Ok(Self { base, source, sharp, normals, changed })
    }
}

/// Normals and sharp edges that are tried.
struct Attempt<'a> {
    base: &'a Triangulated,
    sharpness: Sharpness,
    /// At the origin of each half edge, of length 1, or zero.
    normals: Vec<Vec3>,
    /// Vertices at which normals were turned.
    turned: Vec<bool>,
}

impl<'a> Attempt<'a> {
    fn new(Start { base, sharp, normals, .. }: &'a Start) -> Self {
        let vertices = base.mesh.vertex_count();
        let unit = |n: &Vec3| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        Self {
            base,
            sharpness: Sharpness { edges: sharp.clone(), corners: vec![false; vertices] },
            normals: normals.iter().map(unit).collect(),
            turned: vec![false; vertices],
        }
    }

    fn frame(&self) -> Frame {
        Frame::over_mesh(&self.base.mesh, &self.base.positions, &self.normals, &self.sharpness.edges)
    }

    fn moved(&self) -> impl Iterator<Item = VertexId> + '_ {
        self.base.mesh.vertices().filter(|v| self.turned[v.index()])
    }

    /// Changes normals, then middles of patches, then edges, until no patch folds or nothing is left to try; gives what still folds.
    fn unfold(&mut self, recipe: &RationalRecipe) -> Result<Folds, FrameError> {
        let mesh = &self.base.mesh;
        let (mut rounds, mut sharpenings) = (recipe.rounds, recipe.sharpenings);
        loop {
            let folds = folds(&self.frame(), recipe.lattice)?;
            let vertices = |faces: &[FaceId]| -> Vec<VertexId> {
                faces.iter().flat_map(|f| mesh.triangle(*f)).collect()
            };
            let mut faces: Vec<FaceId> = folds.faces.iter().map(|f| FaceId(*f)).collect();
            if rounds > 0 {
                faces.extend(folds.middles.iter().map(|(patch, _)| FaceId(patch.0)));
                faces.sort_unstable();
            }
            if faces.is_empty() {
                return Ok(folds);
            }
            if rounds > 0 {
                rounds -= 1;
                // The whole way in the last round.
                let share = 1.0 / (rounds + 1) as f64;
                vertices(&faces).into_iter().for_each(|v| self.see_better(v, share));
            } else if sharpenings > 0 && self.sharpness.sharpen(mesh, &self.base.positions, &faces, &[]) {
                sharpenings -= 1;
                vertices(&faces).into_iter().for_each(|v| self.renew(v));
            } else {
                return Ok(folds);
            }
        }
    }

    /// Turns the normals at a vertex towards the directions that see the faces of their sectors best.
    fn see_better(&mut self, v: VertexId, share: f64) {
        let mesh = &self.base.mesh;
        for sector in creases::sectors(mesh, &self.sharpness.edges, v) {
            let Some(first) = sector.first() else { continue };
            let Some((best, _)) = most_visible_direction(&self.faces_of(mesh, &sector)) else { continue };
            let normal = self.normals[first.index()];
            let turned = ((1.0 - share) * normal + share * best).try_normalize(0.0).unwrap_or(best);
            sector.iter().for_each(|h| self.normals[h.index()] = turned);
            self.turned[v.index()] = true;
        }
    }

    /// New normals at a vertex at which edges became sharp: those that see the faces of each sector best; none at a corner, from which
    /// sharp edges leave along their chords. The neighbours keep theirs.
    fn renew(&mut self, v: VertexId) {
        let mesh = &self.base.mesh;
        for sector in creases::sectors(mesh, &self.sharpness.edges, v) {
            let best = match self.sharpness.corners[v.index()] {
                true => None,
                false => most_visible_direction(&self.faces_of(mesh, &sector)).map(|(best, _)| best),
            };
            sector.iter().for_each(|h| self.normals[h.index()] = best.unwrap_or_else(Vec3::zeros));
        }
    }

    fn faces_of(&self, mesh: &HalfEdgeMesh, sector: &[HalfEdgeId]) -> Vec<Vec3> {
        let of = |h: &HalfEdgeId| normals::of_face(mesh, &self.base.positions, mesh.face(*h));
        sector.iter().map(of).filter(|n| *n != Vec3::zeros()).collect()
    }
}
