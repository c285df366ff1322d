//! Rational patches over an algebraic surface with singularities: Bajaj & Xu 1997, whole.
//!
//! ```text
//! formula ──► singular set (§3) ──► conforming mesh (§4) ──► frame: sheets, limit normals ──► wires (§5), patches (§6)
//! ```
//!
//! Each step is a module: [`crate::singular`], [`crate::singular::mesh`], [`crate::rational`]. The surface is G1 on every sheet, goes exactly
//! through singular points, and its sheets share the wires along singular curves. Wires and the middles of patches are brought
//! onto the surface.

use super::adapt::{AdaptGoal, adapt};
use super::spline::Size;
use crate::base::{self, BaseError, FieldTarget, Repair};
use crate::bernstein::triangle;
use crate::field::Formula;
use crate::geom::{Aabb, Vec3};
use crate::inspect::{InspectOptions, inspect_rational};
use crate::rational::{
    BuildOptions, Built, Frame, FrameError, FrameSeam, RationalSurface, build_with, is_folded_over,
    relax_folds,
};
use crate::report::Seconds;
use crate::singular::mesh::{
    LowerPart, SingularMesh, TriangulateError, TriangulateOptions, Triangulated, sheets, triangulate,
};
use crate::singular::{SingularError, SingularOptions, SingularSet, singular_set};
use crate::surface::{Surface, Target};
use std::collections::BTreeSet;

/// What the recipe is given besides the formula.
#[derive(Clone, Debug, Default)]
pub struct AlgebraicRecipe {
    /// The box; none for one around the surface, if that is bounded.
    pub bounds: Option<Aabb>,
    /// How many patches: as follows from `mesh`, this many, or as many as it takes to be so close to the surface, relative to the diagonal of
    /// the vertices.
    pub size: Size,
    /// Singular points and curves.
    pub singular: SingularOptions,
    /// The mesh with which it begins. It is made finer where patches need it.
    pub mesh: TriangulateOptions,
}

/// A finished surface.
#[derive(Clone, Debug)]
pub struct FittedAlgebraic {
    /// The surface: patch i over triangle i of the mesh.
    pub surface: RationalSurface,
    /// The mesh.
    pub mesh: SingularMesh,
    /// What the surface is singular in.
    pub set: SingularSet,
    /// Where the surface was looked for.
    pub bounds: Aabb,
    /// What was left out or is uncertain, and how the sheets hang together.
    pub notes: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Debug, thiserror::Error)]
pub enum AlgebraicError {
    /// There is no box, or no surface in it.
    #[error(transparent)]
    Base(#[from] BaseError),
    /// The singular set can't be found.
    #[error(transparent)]
    Singular(#[from] SingularError),
    /// There is no conforming mesh.
    #[error(transparent)]
    Mesh(#[from] TriangulateError),
    /// The mesh can't be interpolated.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Fewer triangles are wanted than keep the singular points and curves and the shape.
    #[error(
        "{asked} patches are too few: with its singular points and curves this surface needs {least} or more"
    )]
    Faces {
        /// How many are wanted.
        asked: usize,
        /// How many there are when no edge can be collapsed any more.
        least: usize,
    },
    /// The box holds no sheet of the surface.
    #[error("no surface in the box, only points or curves at most: isopatch singular lists them")]
    Empty,
}

/// Without a size, patches come this much closer to the surface than the flat triangles that they begin with have to be.
const CLOSER: f64 = 0.2;
/// For a tolerance on patches, whose order is about 4 in the length of edges, the flat triangles, whose order is 2, begin with this times its
/// square root.
const FLAT_SHARE: f64 = 0.1;
/// Distances are sampled; patches aim at this share of the tolerance.
const SAFETY: f64 = 0.9;
/// Times that they aim at less because the inspection finds more.
const AIMS: usize = 4;
/// Most triangles, if no number is given.
const MOST_TRIANGLES: usize = 400_000;
/// If the mesh has more triangles than are wanted, the share of these with which it begins; the others go where patches need them.
const FIRST_SHARE: f64 = 0.7;
/// Then this share of the diagonal of the box is close enough for flat triangles.
const LOOSE: f64 = 0.05;

/// Rational patches over the surface of a polynomial; `progress` is told the name of each stage as it starts.
pub fn fit(
    formula: &Formula,
    recipe: &AlgebraicRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedAlgebraic, AlgebraicError> {
    let mut seconds = Seconds::default();
    progress("box");
    let bounds = seconds.measure("box", || recipe.bounds.map_or_else(|| base::find_box(formula), Ok))?;
    progress("singularities");
    let set = seconds.measure("singularities", || singular_set(formula, &bounds, &recipe.singular))?;
    let degree = formula.quadratic_polynomial().map_or(0, |p| p.degree());
    let options = mesh_options(recipe);
    progress("mesh");
    let mut found = seconds.measure("mesh", || triangulate(formula, degree, &set, &bounds, &options))?;
    let options = match recipe.size {
        Size::Faces(n) if found.mesh.triangles.len() > n => {
            let first = (FIRST_SHARE * n as f64) as usize;
            let options = TriangulateOptions { triangles: Some(first), tolerance: LOOSE, ..options };
            found = seconds.measure("mesh", || triangulate(formula, degree, &set, &bounds, &options))?;
            options
        }
        _ => options,
    };
    let triangles = found.mesh.triangles.len();
    if triangles == 0 {
        return Err(AlgebraicError::Empty);
    }
    let diagonal = Aabb::around(&found.mesh.positions).diagonal();
    let flat = options.tolerance * bounds.diagonal();
    let mut goal = match recipe.size {
        Size::Automatic => AdaptGoal { distance: CLOSER * flat, triangles: MOST_TRIANGLES, flat },
        Size::Faces(asked) if triangles > asked => {
            return Err(AlgebraicError::Faces { asked, least: triangles });
        }
        Size::Faces(asked) => AdaptGoal { distance: 0.0, triangles: asked, flat },
        Size::Tolerance(tolerance) => {
            AdaptGoal { distance: SAFETY * tolerance * diagonal, triangles: MOST_TRIANGLES, flat }
        }
    };
    progress("patches");
    let target = FieldTarget::new(formula, bounds.diagonal());
    let mut patches =
        |goal: &AdaptGoal| seconds.measure("patches", || adapt(formula, &bounds, &mut found, &target, goal));
    let mut built = patches(&goal)?;
    if let Size::Tolerance(tolerance) = recipe.size {
        for _ in 1..AIMS {
            let distance = distance(&built.surface, formula);
            if distance <= tolerance {
                break;
            }
            goal.distance *= SAFETY * tolerance / distance;
            built = patches(&goal)?;
        }
    }
    let notes = notes(&found, &built);
    let Triangulated { mesh, .. } = found;
    Ok(FittedAlgebraic { surface: built.surface, mesh, set, bounds, notes, seconds })
}

fn mesh_options(recipe: &AlgebraicRecipe) -> TriangulateOptions {
    let options = recipe.mesh.clone();
    match recipe.size {
        Size::Automatic | Size::Faces(_) => options,
        Size::Tolerance(tolerance) => {
            TriangulateOptions { tolerance: options.tolerance.min(FLAT_SHARE * tolerance.sqrt()), ..options }
        }
    }
}

/// The largest distance that the inspection will find.
fn distance(surface: &RationalSurface, formula: &Formula) -> f64 {
    let options = InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect_rational(surface, Some(formula), &options);
    found.common.deviation.map_or(f64::INFINITY, |d| d.max_distance)
}

/// Farthest move of the middle of a patch, in its longest edge.
const MOST_MOVE: f64 = 0.05;

/// Intervals of the lattice on which folds are looked for.
const FOLD_LATTICE: usize = 12;

/// Patches over the sheets of a mesh; with a target, wires and middles are brought onto it. Wires along the sides of the box lie in them.
///
/// # Errors
/// [`FrameError`] for a mesh that does not fit together.
pub fn over_singular_mesh(mesh: &SingularMesh, target: Option<&dyn Target>) -> Result<Built, FrameError> {
    let is_singular: Vec<bool> = mesh.vertices.iter().map(|kind| kind.is_singular()).collect();
    let mut frame = Frame::over_sheets(
        mesh.positions.clone(),
        mesh.triangles.clone(),
        &mesh.normals,
        &mesh.singular_edges,
        &is_singular,
    );
    let planes = planes(mesh, &frame);
    let options = BuildOptions { planes: &planes, target };
    relax_folds(&mut frame, &options, FOLD_LATTICE)?;
    let mut built = build_with(&frame, &options)?;
    if let Some(target) = target {
        built.surface.fit_middles(target, MOST_MOVE);
        let lattice = triangle::lattice(FOLD_LATTICE);
        for patch in built.surface.patches() {
            if is_folded_over(&built.surface, patch, &lattice) {
                built.surface.set_middle(patch, Vec3::zeros());
            }
        }
    }
    Ok(built)
}

/// The sides of the box in which the wires on boundaries lie.
fn planes(mesh: &SingularMesh, frame: &Frame) -> Vec<Option<Vec3>> {
    let mut planes = vec![None; frame.wire_count()];
    let mut uses = vec![0; planes.len()];
    for seam in &frame.seams {
        uses[seam.wire as usize] += 1 + usize::from(seam.second.is_some());
        let [a, b] = frame.ends(seam.first).map(|v| mesh.sides[v as usize]);
        planes[seam.wire as usize] = a.common(b).iter().next().map(|side| Vec3::ith(side.axis, 1.0));
    }
    for (plane, uses) in planes.iter_mut().zip(uses) {
        *plane = plane.filter(|_| uses == 1);
    }
    planes
}

fn notes(found: &Triangulated, built: &Built) -> Vec<Repair> {
    let note = |what: String, place: String, why: &str| Repair { what, place, why: why.to_owned() };
    let mesh = &found.mesh;
    let mut notes = Vec::new();
    let sheets = sheets(mesh).len();
    if !mesh.singular_edges.is_empty() || sheets > 1 {
        let shared = mesh.singular_edges.len();
        notes.push(note(
            format!("sheets: {sheets}"),
            format!("{shared} shared curves"),
            "the surface is smooth on each; in STEP each is a shell, and they share points, edges and vertices",
        ));
    }
    for part in &mesh.lower {
        notes.push(match part {
            LowerPart::Point(p) => note(
                "point left out".to_owned(),
                format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z),
                "the surface has no sheet there",
            ),
            LowerPart::Stick(points) => {
                let at = points
                    .first()
                    .map_or_else(String::new, |p| format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z));
                note("curve left out".to_owned(), format!("from {at}"), "the surface has no sheet there")
            }
        });
    }
    if let Some(p) = found.doubtful.first() {
        notes.push(note(
            format!("mesh not certain: {} places", found.doubtful.len()),
            format!("first ({:.6}, {:.6}, {:.6})", p.x, p.y, p.z),
            "what was found there is not as expected",
        ));
    }
    let frame = built.surface.frame();
    let sharp: Vec<&FrameSeam> = frame.seams.iter().filter(|s| s.second.is_some() && !s.smooth).collect();
    if let Some(seam) = sharp.first() {
        let [a, b] = frame.ends(seam.first);
        let p = 0.5 * (frame.positions[a as usize] + frame.positions[b as usize]);
        notes.push(note(
            format!("edges where patches only meet: {}", sharp.len()),
            format!("first near ({:.6}, {:.6}, {:.6})", p.x, p.y, p.z),
            "patches with the same tangent planes along them fold",
        ));
    }
    let mut lost: BTreeSet<u32> =
        built.lost_normals.iter().map(|(f, c)| mesh.triangles[*f as usize][usize::from(*c)]).collect();
    let corners = mesh.triangles.iter().zip(&frame.normals);
    let relaxed = corners.flat_map(|(t, normals)| t.iter().zip(normals)).filter(|(_, n)| n.is_none());
    lost.extend(relaxed.map(|(v, _)| *v).filter(|v| !mesh.vertices[*v as usize].is_singular()));
    if let Some(v) = lost.first() {
        let p = mesh.positions[*v as usize];
        notes.push(note(
            format!("vertices where patches have no tangent plane: {}", lost.len()),
            format!("first ({:.6}, {:.6}, {:.6})", p.x, p.y, p.z),
            "the planes of the sheets there have no line in common, or the surface turns within less than a triangle",
        ));
    }
    notes
}
