//! Hybrid A-patches over a mesh of polygons: Xu, Bajaj & Evans, with the corrections of PAPERS.md.
//!
//! ```text
//! polygons ──► prepare ──► gradients ──► hull (§3) ──► function (§4) ──► rays ──► surface
//!              repairs     normals,      cells over    cells over        other
//!                ▲         lengths       polygons      edges             parameters
//!                └───────── polygons that do not fit are cut ──────────────┘
//! ```
//!
//! What cannot be made over polygons is made over triangles, by [`apatch`], and the report says so.

use super::TriangulationError;
use super::apatch::{
    self, APatchError, APatchRecipe, FittedMesh, Ground, NormalSource, gradients, in_numbers_of_the_input,
    source,
};
use super::triangulated::{Repaired, word};
use crate::apatch::{Free, Over};
use crate::base::Repair;
use crate::geom::{Point3, Vec3};
use crate::hull::{Problem, Reason, most_visible_direction};
use crate::hybrid::hull::{BuiltHull, HybridOptions, build, has_room};
use crate::hybrid::{HermitePolygons, HybridFunction, HybridSurface, mended};
use crate::inspect::{APatchInspectOptions, inspect_hybrid};
use crate::io::read::PolygonMesh;
use crate::mesh::{FaceId, HalfEdgeId, HalfEdgeMesh, Place, VertexId, creases, normals};
use crate::report::{APatchReport, Seconds};
use std::collections::BTreeMap;

/// What becomes of polygons with more than three corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Polygons {
    /// They stay as they are, with cells of their own.
    #[default]
    Keep,
    /// They are cut into triangles.
    Split,
}

/// The cells over the triangles of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleElement {
    /// In a mesh of triangles alone, those of the triangle method.
    #[default]
    Triangle,
    /// Those of the hybrid method in any mesh.
    Hybrid,
}

/// What the recipe is given besides the mesh.
#[derive(Clone, Debug, Default)]
pub struct HybridRecipe {
    /// Repairs, normals and lengths of gradients; and all that the triangle method takes, where that is used. Without a choice
    /// and without normals in the file, normals are those of the faces weighted by angles.
    pub triangles: APatchRecipe,
    /// What becomes of polygons.
    pub polygons: Polygons,
    /// The cells over triangles.
    pub triangle_element: TriangleElement,
    /// Hull.
    pub hull: HybridOptions,
}

/// A finished surface through the vertices of a mesh of polygons.
#[derive(Debug)]
pub struct FittedPolygons {
    /// The surface.
    pub surface: HybridSurface,
    /// What the method did.
    pub figures: APatchReport,
    /// What was changed to make the mesh fit the method, and what does not fit.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// A finished surface, by the method that made it.
#[derive(Debug)]
pub enum Fitted {
    /// Over polygons.
    Polygons(Box<FittedPolygons>),
    /// Over triangles.
    Triangles(Box<FittedMesh>),
}

/// Rounds: as it is, with normals that are turned, then with polygons cut that do not fit.
const ROUNDS: usize = 5;

/// Polygons with more corners are cut into triangles: their sectors would be slivers.
const MOST_CORNERS: usize = 64;

/// The A-patch surface of a mesh; `progress` is told the name of each stage as it starts.
///
/// A mesh of triangles becomes the surface of [`apatch::fit`]. So does one with creases, and one for which no valid surface over
/// its polygons is found; the repairs of the result then say why.
pub fn fit(
    mesh: &PolygonMesh,
    recipe: &HybridRecipe,
    progress: &dyn Fn(&str),
) -> Result<Fitted, APatchError> {
    let over_triangles = |why: Option<&str>| -> Result<Fitted, APatchError> {
        let mut fitted = apatch::fit(mesh, &recipe.triangles, progress)?;
        fitted.repairs.extend(why.map(|why| Repair {
            what: "no cells over polygons".to_owned(),
            place: "the whole mesh".to_owned(),
            why: why.to_owned(),
        }));
        Ok(Fitted::Triangles(Box::new(fitted)))
    };
    if recipe.polygons == Polygons::Split && recipe.triangle_element == TriangleElement::Triangle {
        return over_triangles(None);
    }
    let mut seconds = Seconds::default();
    progress("mesh");
    let mut base = seconds.measure("mesh", || Repaired::new(mesh, &recipe.triangles.prepare))?;
    if recipe.polygons == Polygons::Split {
        base.cut(&vec![true; base.faces.len()])?;
    }
    let all_triangles = base.faces.iter().all(|f| f.len() == 3);
    if all_triangles && recipe.triangle_element == TriangleElement::Triangle {
        return over_triangles(None);
    }
    if recipe.triangles.patches.free != Free::Default {
        return over_triangles(Some("free parameters are given for triangles"));
    }
    let mut work = Work { given: mesh, recipe, base, seconds, turns: false, cut: BTreeMap::new() };
    match work.run(progress)? {
        Found::Surface(fitted) => Ok(Fitted::Polygons(fitted)),
        Found::Nothing(why) => over_triangles(Some(why)),
    }
}

/// The run so far.
struct Work<'a> {
    given: &'a PolygonMesh,
    recipe: &'a HybridRecipe,
    base: Repaired,
    seconds: Seconds,
    /// Are normals turned that do not see the faces around them? Not at first: those of a quadric may not, and do no harm.
    turns: bool,
    /// Polygons of the file that were cut, by the reason.
    cut: BTreeMap<&'static str, Vec<u32>>,
}

enum Found {
    Surface(Box<FittedPolygons>),
    Nothing(&'static str),
}

const UNSEEN: &str = "no point sees all of their sides";
const MANY: &str = "they have too many corners";
const UNFIT: &str = "no cells over them fit their normals";

impl Work<'_> {
    fn run(&mut self, progress: &dyn Fn(&str)) -> Result<Found, APatchError> {
        self.cut_hopeless()?;
        for round in 0..ROUNDS {
            let mesh = self.base.mesh().map_err(TriangulationError::from)?;
            let sharp = match self.recipe.triangles.crease_angle {
                Some(angle) => creases::by_angle(&mesh, &self.base.positions, angle),
                None => vec![false; mesh.edge_count()],
            };
            if sharp.contains(&true) {
                return Ok(Found::Nothing("it has creases, which are made over triangles"));
            }
            progress("normals");
            let made = self.data(mesh, sharp)?;
            progress("hull");
            let Made { data, changed, moved } = made;
            let built = self.seconds.measure("hull", || build(data, &self.recipe.hull));
            progress("patches");
            let BuiltHull { hull, problems, .. } = built;
            let (function, broken) = self
                .seconds
                .measure("patches", || mended(HybridFunction::new(hull), self.recipe.hull.sheets));
            let surface = HybridSurface::new(function);
            let mut bad = broken;
            bad.extend(self.folded(&surface));
            bad.extend(problems.iter().filter_map(|problem| match problem {
                Problem::Face { face, .. } => Some(*face),
                Problem::Vertex { .. } | Problem::Edge { .. } => None,
            }));
            bad.sort_unstable();
            bad.dedup();
            let to_cut: Vec<FaceId> =
                bad.iter().copied().filter(|f| self.base.faces[f.index()].len() > 3).collect();
            if bad.is_empty() {
                // Cells that overlap at an edge are mended by creases, which are made over triangles.
                if problems.iter().any(|problem| matches!(problem, Problem::Edge { .. })) {
                    break;
                }
                return Ok(Found::Surface(Box::new(self.finished(surface, &problems, changed, moved))));
            }
            if !std::mem::replace(&mut self.turns, true) {
                continue;
            }
            if to_cut.is_empty() || round + 1 == ROUNDS {
                break;
            }
            self.cut_faces(&to_cut, UNFIT)?;
        }
        Ok(Found::Nothing("no valid surface over its polygons is found"))
    }

    /// Cuts the polygons over which no cells can stand.
    fn cut_hopeless(&mut self) -> Result<(), APatchError> {
        let (mut unseen, mut many) = (Vec::new(), Vec::new());
        for (f, corners) in self.base.faces.iter().enumerate().filter(|(_, corners)| corners.len() > 3) {
            let p: Vec<_> = corners.iter().map(|v| self.base.positions[*v as usize]).collect();
            if corners.len() > MOST_CORNERS {
                many.push(FaceId::from(f));
            } else if !has_room(&p) {
                unseen.push(FaceId::from(f));
            }
        }
        // The numbers of the second kind change when the first kind is cut, so both are cut at once.
        for (faces, why) in [(&unseen, UNSEEN), (&many, MANY)] {
            self.note_cut(faces, why);
        }
        unseen.extend(many);
        self.cut_all(&unseen)
    }

    fn cut_faces(&mut self, faces: &[FaceId], why: &'static str) -> Result<(), APatchError> {
        self.note_cut(faces, why);
        self.cut_all(faces)
    }

    fn note_cut(&mut self, faces: &[FaceId], why: &'static str) {
        if !faces.is_empty() {
            let numbers = faces.iter().map(|f| self.base.sources.face[f.index()]);
            self.cut.entry(why).or_default().extend(numbers);
        }
    }

    fn cut_all(&mut self, faces: &[FaceId]) -> Result<(), APatchError> {
        if faces.is_empty() {
            return Ok(());
        }
        let mut chosen = vec![false; self.base.faces.len()];
        faces.iter().for_each(|f| chosen[f.index()] = true);
        Ok(self.base.cut(&chosen)?)
    }

    /// What is interpolated: positions and gradients, which see the faces around them.
    fn data(&mut self, mesh: HalfEdgeMesh, sharp: Vec<bool>) -> Result<Made, APatchError> {
        let base = &self.base;
        let (given, recipe) = (self.given, &self.recipe.triangles);
        let (mut gradients, mut changed) = self.seconds.measure("normals", || {
            let ground = Ground { mesh: &mesh, positions: &base.positions, sources: &base.sources };
            gradients(given, &ground, &sharp, recipe, NormalSource::Angle)
        })?;
        let least = if self.turns { self.recipe.hull.visibility } else { f64::NEG_INFINITY };
        let turned = turn_hidden(&mesh, &base.positions, &mut gradients, least);
        let moved: Vec<Place> = turned.into_iter().map(|v| base.sources.of_vertex(v)).collect();
        changed.extend(word("normals moved", &moved, "they did not see the faces around them"));
        let data = HermitePolygons::with_creases(mesh, base.positions.clone(), gradients, sharp)
            .map_err(|error| in_numbers_of_the_input(error, &base.sources))?;
        Ok(Made { data, changed, moved: moved.len() })
    }

    /// Faces with a patch that folds, or over an edge with one.
    fn folded(&mut self, surface: &HybridSurface) -> Vec<FaceId> {
        let found = inspect_hybrid(surface, &APatchInspectOptions::QUICK);
        let mesh = surface.function().hull().data.mesh();
        let faces =
            found.folded.iter().chain(&found.undefined).flat_map(|patch| match surface.over(*patch) {
                Over::Face(f) => vec![f],
                Over::Edge(e) => {
                    let h = mesh.edge_half_edge(e);
                    [Some(h), mesh.twin(h)].into_iter().flatten().map(|h| mesh.face(h)).collect()
                }
            });
        faces.collect()
    }

    fn finished(
        &mut self,
        surface: HybridSurface,
        problems: &[Problem],
        changed: Vec<Repair>,
        moved: usize,
    ) -> FittedPolygons {
        let sources = &self.base.sources;
        let mesh = surface.function().hull().data.mesh();
        let mut repairs = std::mem::take(&mut self.base.repairs);
        let mut cut = 0;
        for (why, faces) in &self.cut {
            let places: Vec<Place> = faces.iter().map(|f| Place::Face(*f)).collect();
            cut += places.len();
            repairs.extend(word("polygons cut into triangles", &places, why));
        }
        repairs.extend(changed);
        let place = |problem: &Problem| match problem {
            Problem::Vertex { vertex, .. } => sources.of_vertex(*vertex),
            Problem::Face { face, .. } => sources.of_face(*face),
            Problem::Edge { edge, .. } => sources.of_edge(mesh, *edge),
        };
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for reason in Reason::ALL {
            let of: Vec<Place> = problems.iter().filter(|p| p.reason() == reason).map(place).collect();
            if !of.is_empty() {
                counts.insert(reason.name().to_owned(), of.len());
            }
            repairs.extend(word("surface not certain", &of, &reason.to_string()));
        }
        let normals = source(self.given, self.recipe.triangles.normals, NormalSource::Angle);
        let mut figures = APatchReport {
            normals: Some(normals.name().to_owned()),
            gradient_lengths: Some(self.recipe.triangles.lengths.name().to_owned()),
            problems: counts,
            normals_moved: moved,
            ..APatchReport::of_hybrid(surface.function())
        };
        if let Some(elements) = &mut figures.elements {
            elements.cut = cut;
        }
        FittedPolygons { surface, figures, repairs, seconds: std::mem::take(&mut self.seconds) }
    }
}

/// Data, and what was done to the normals.
struct Made {
    data: HermitePolygons,
    changed: Vec<Repair>,
    moved: usize,
}

/// Turns every gradient whose product with the unit normal of a face around it is less than `least` into the most visible
/// direction. Returns their vertices.
fn turn_hidden(
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
    gradients: &mut [Vec3],
    least: f64,
) -> Vec<VertexId> {
    let of_faces = normals::of_faces(mesh, positions);
    let mut turned = Vec::new();
    for v in mesh.vertices() {
        let around: Vec<Vec3> = mesh.ring(v).map(|h| of_faces[mesh.face(h).index()]).collect();
        let seen = |n: &Vec3| around.iter().map(|m| m.dot(n)).fold(f64::INFINITY, f64::min);
        let hidden = |h: HalfEdgeId| seen(&gradients[h.index()].normalize()) < least;
        if !mesh.ring(v).any(hidden) {
            continue;
        }
        let Some((direction, best)) = most_visible_direction(&around) else { continue };
        let now = mesh.ring(v).map(|h| seen(&gradients[h.index()].normalize())).fold(f64::INFINITY, f64::min);
        if best > now {
            let corners: Vec<_> = mesh.ring(v).collect();
            corners.into_iter().for_each(|h| gradients[h.index()] = gradients[h.index()].norm() * direction);
            turned.push(v);
        }
    }
    turned
}
