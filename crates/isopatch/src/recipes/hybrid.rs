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
use crate::geom::Vec3;
use crate::hull::{Problem, Reason, most_visible_direction};
use crate::hybrid::hull::{BuiltHull, Certainty, HybridOptions, build, certainties, has_room};
use crate::hybrid::{HermitePolygons, HybridFunction, HybridSurface, mended};
use crate::inspect::{APatchInspectOptions, inspect_hybrid};
use crate::io::read::PolygonMesh;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, Place, VertexId, creases, normals};
use crate::report::{APatchReport, Seconds};
use std::collections::{BTreeMap, BTreeSet};

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

/// Rounds: as it is, with normals that are turned, with polygons cut that do not fit, then with flat faces and creases where nothing
/// else did.
const ROUNDS: usize = 8;

/// Polygons with more corners are cut into triangles: their sectors would be slivers.
const MOST_CORNERS: usize = 64;

/// The A-patch surface of a mesh; `progress` is told the name of each stage as it starts.
///
/// A mesh of triangles becomes the surface of [`apatch::fit`]. So does one for which no valid surface over its polygons is found;
/// the repairs of the result then say why.
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
    // Repairs make no polygons of triangles.
    let is_cut = recipe.polygons == Polygons::Split || mesh.faces.iter().all(|f| f.len() <= 3);
    if is_cut && recipe.triangle_element == TriangleElement::Triangle {
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
    let mut work = Work {
        given: mesh,
        recipe,
        base,
        seconds,
        turns: false,
        cut: BTreeMap::new(),
        parted: BTreeSet::new(),
        flat: BTreeSet::new(),
    };
    match work.run(progress)? {
        Found::Surface(fitted) => Ok(Fitted::Polygons(fitted)),
        Found::Nothing(why) => over_triangles(Some(why)),
    }
}

/// Where a surface is not valid: faces with rays that do not meet it once or patches that fold, and edges at which cells overlap.
struct Faults {
    faces: Vec<FaceId>,
    edges: Vec<EdgeId>,
}

/// The vertices of an edge, the smaller number first.
fn ends(mesh: &HalfEdgeMesh, e: EdgeId) -> [u32; 2] {
    let h = mesh.edge_half_edge(e);
    let mut ends = [mesh.origin(h).0, mesh.dest(h).0];
    ends.sort_unstable();
    ends
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
    /// Edges that became creases, by their vertices.
    parted: BTreeSet<[u32; 2]>,
    /// Triangles that came to be flat, by their vertices.
    flat: BTreeSet<Vec<u32>>,
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
        for _ in 0..ROUNDS {
            let mesh = self.base.mesh().map_err(TriangulationError::from)?;
            let sharp = self.sharp_edges(&mesh);
            progress("normals");
            let Made { data, changed, moved } = self.data(mesh, sharp)?;
            progress("hull");
            let built = self.seconds.measure("hull", || build(data, &self.recipe.hull));
            progress("patches");
            let BuiltHull { hull, problems, .. } = built;
            let (function, broken) = self
                .seconds
                .measure("patches", || mended(HybridFunction::new(hull), self.recipe.hull.sheets));
            let surface = HybridSurface::new(function);
            let faults = self.faults(&surface, broken, &problems);
            if faults.faces.is_empty() && faults.edges.is_empty() {
                return Ok(Found::Surface(Box::new(self.finished(surface, &problems, changed, moved))));
            }
            // Where cells overlap at an edge, other normals at its ends would move the surface far around.
            if !faults.faces.is_empty() && !std::mem::replace(&mut self.turns, true) {
                continue;
            }
            if !self.relieve(&faults, surface.function().hull().data.mesh())? {
                break;
            }
        }
        Ok(Found::Nothing("no valid surface over its polygons is found"))
    }

    /// The edges across which the surface need not be smooth: where faces meet at more than the angle that is given, and where it
    /// could not be.
    fn sharp_edges(&self, mesh: &HalfEdgeMesh) -> Vec<bool> {
        let mut sharp = match self.recipe.triangles.crease_angle {
            Some(angle) => creases::by_angle(mesh, &self.base.positions, angle),
            None => vec![false; mesh.edge_count()],
        };
        mesh.edges().filter(|e| self.is_added(mesh, *e)).for_each(|e| sharp[e.index()] = true);
        sharp
    }

    /// Is an edge a crease because the surface could not be smooth there?
    fn is_added(&self, mesh: &HalfEdgeMesh, e: EdgeId) -> bool {
        let h = mesh.edge_half_edge(e);
        let is_flat = |h: HalfEdgeId| self.flat.contains(&self.base.faces[mesh.face(h).index()]);
        self.parted.contains(&ends(mesh, e)) || [Some(h), mesh.twin(h)].into_iter().flatten().any(is_flat)
    }

    /// Where the surface is not valid.
    fn faults(&mut self, surface: &HybridSurface, broken: Vec<FaceId>, problems: &[Problem]) -> Faults {
        let mut faults = Faults { faces: broken, edges: Vec::new() };
        faults.faces.extend(self.folded(surface));
        for problem in problems {
            match problem {
                Problem::Face { face, .. } => faults.faces.push(*face),
                Problem::Edge { edge, .. } => faults.edges.push(*edge),
                Problem::Vertex { .. } => {}
            }
        }
        faults.faces.sort_unstable();
        faults.faces.dedup();
        faults
    }

    /// Makes the construction easier at faults: cuts polygons; where there are none, faces come to have their own normals, and
    /// edges become creases. Was there anything left to do?
    fn relieve(&mut self, faults: &Faults, mesh: &HalfEdgeMesh) -> Result<bool, APatchError> {
        let of_edge = |e: &EdgeId| {
            let h = mesh.edge_half_edge(*e);
            [Some(h), mesh.twin(h)].into_iter().flatten().map(|h| mesh.face(h))
        };
        let mut cut: Vec<FaceId> =
            faults.faces.iter().copied().chain(faults.edges.iter().flat_map(of_edge)).collect();
        cut.retain(|f| self.base.faces[f.index()].len() > 3);
        cut.sort_unstable();
        cut.dedup();
        if !cut.is_empty() {
            self.cut_faces(&cut, UNFIT)?;
            return Ok(true);
        }
        let before = self.parted.len() + self.flat.len();
        self.parted.extend(faults.edges.iter().map(|e| ends(mesh, *e)));
        self.flat.extend(faults.faces.iter().map(|f| self.base.faces[f.index()].clone()));
        Ok(self.parted.len() + self.flat.len() > before)
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
        let of_faces = normals::of_faces(&mesh, &base.positions);
        for h in mesh.half_edges().filter(|h| self.flat.contains(&base.faces[mesh.face(*h).index()])) {
            gradients[h.index()] = gradients[h.index()].norm() * of_faces[mesh.face(h).index()];
        }
        let turned = turn_hidden(&mesh, &of_faces, &sharp, &mut gradients, least);
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
        let parted: Vec<Place> = mesh
            .edges()
            .filter(|e| self.parted.contains(&ends(mesh, *e)))
            .map(|e| sources.of_edge(mesh, e))
            .collect();
        repairs.extend(word("creases added", &parted, "cells overlap there"));
        let is_flat = |f: &FaceId| self.flat.contains(&self.base.faces[f.index()]);
        let flat: Vec<Place> = mesh.faces().filter(is_flat).map(|f| sources.of_face(f)).collect();
        repairs.extend(word("faces made flat", &flat, "no cells over them fit their normals"));
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
            creases_added: mesh.edges().filter(|e| self.is_added(mesh, *e)).count(),
            ..APatchReport::of_hybrid(surface.function())
        };
        if let Some(elements) = &mut figures.elements {
            elements.cut = cut;
            let known = certainties(surface.function().hull());
            elements.measured = known.iter().filter(|known| **known != Certainty::Certain).count();
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

/// Turns every gradient whose product with the unit normal of a face that it belongs to is less than `least` into the most visible
/// direction. Returns their vertices.
fn turn_hidden(
    mesh: &HalfEdgeMesh,
    of_faces: &[Vec3],
    sharp: &[bool],
    gradients: &mut [Vec3],
    least: f64,
) -> Vec<VertexId> {
    let mut turned = Vec::new();
    for v in mesh.vertices() {
        for corners in creases::sectors(mesh, sharp, v) {
            let around: Vec<Vec3> = corners.iter().map(|h| of_faces[mesh.face(*h).index()]).collect();
            let seen = |n: &Vec3| around.iter().map(|m| m.dot(n)).fold(f64::INFINITY, f64::min);
            let Some(now) = corners.first().map(|h| seen(&gradients[h.index()].normalize())) else {
                continue;
            };
            if now >= least {
                continue;
            }
            let Some((direction, best)) = most_visible_direction(&around) else { continue };
            if best > now {
                corners.iter().for_each(|h| gradients[h.index()] = gradients[h.index()].norm() * direction);
                turned.push(v);
            }
        }
    }
    turned.dedup();
    turned
}
