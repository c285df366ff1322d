//! The G1 spline of Tong & Kim 2009 from a formula: the paper's section 3.4, with the corrections of PAPERS.md.
//!
//! ```text
//! box ──► (i) base mesh ──► (ii) curves ──► (iii) fit, (iv) G1, (v) free points ──► check ──► best so far
//!                 ▲                                                                   │
//!                 └──── edge lengths from the error of every patch (refine.rs) ───────┘
//! ```

use super::differentiable::Defect;
use super::least::least_that_works;
use super::patchwork::{MakeError, Patchwork};
use super::refine::Wish;
use super::rounds::{Best, Checked, Rounds};
use crate::base::{self, BaseError, BaseMesh, BaseMethod, BaseOptions, Repair};
use crate::field::Formula;
use crate::geom::{Aabb, Point3};
use crate::inspect::{Coverage, NORMAL_ERROR_LIMIT, PatchDeviation};
use crate::io::read::PolygonMesh;
use crate::network::{CurveError, CurveOptions, QuarticCurve};
use crate::parallel::awake;
use crate::report::{Seconds, SplineReport};
use crate::spline::{SplineError, SplineOptions, TriangularSpline};

/// How many patches a surface gets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Size {
    /// As many as its curvature asks for.
    #[default]
    Automatic,
    /// This many.
    Faces(usize),
    /// As many as it takes to keep the largest distance, measured both ways, below this share of the diagonal.
    Tolerance(f64),
}

/// What a surface costs in time, and in patches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// As quick as can be: no edge lengths are evened out, rows and free points are not relaxed unless a tolerance is missed
    /// without, and the mesh is not thinned where a tolerance leaves room. Guarantees and checks are the same.
    Quick,
    /// The smallest errors for a number of patches, and the fewest patches for a tolerance.
    #[default]
    Full,
}

/// What the recipe is given besides the formula. The default is a good choice for every stage.
#[derive(Clone, Debug)]
pub struct SplineRecipe {
    /// Where the surface is; found if the surface is bounded and none is given.
    pub bounds: Option<Aabb>,
    /// Number of patches.
    pub size: Size,
    /// Time for fewer patches, or not.
    pub effort: Effort,
    /// Connectivity and approximate vertices of the base mesh; made from the surface if none is given. A given mesh is
    /// used as it is, without rounds; of `size`, only a tolerance counts, which the result keeps or not.
    pub given: Option<PolygonMesh>,
    /// Base mesh.
    pub base: BaseOptions,
    /// Boundary curves.
    pub curves: CurveOptions,
    /// Patches.
    pub spline: SplineOptions,
    /// Most times that the base mesh is remade because patches fold, or miss the tolerance.
    pub rounds: usize,
    /// Most faces on the way to a tolerance.
    pub most_faces: usize,
    /// Times that edge lengths are evened out by the measured errors when the number of faces is fixed.
    pub evening: usize,
}

impl Default for SplineRecipe {
    fn default() -> Self {
        Self {
            bounds: None,
            size: Size::default(),
            effort: Effort::default(),
            given: None,
            base: BaseOptions::default(),
            curves: CurveOptions::default(),
            spline: SplineOptions::default(),
            rounds: 10,
            most_faces: 400_000,
            evening: 1,
        }
    }
}

/// A finished surface.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The surface.
    pub surface: TriangularSpline,
    /// The formula, negated if that makes the solid {f < 0} bounded.
    pub formula: Formula,
    /// Was it negated?
    pub negated: bool,
    /// Where the surface was looked for.
    pub bounds: Aabb,
    /// Was the wanted tolerance reached? Always so if none was wanted.
    pub reached: bool,
    /// Figures of the curve fits and of the last check.
    pub figures: SplineReport,
    /// Is it certified that the surface has the topology of the zero set in the box?
    pub certified_topology: bool,
    /// From the zero set to the surface, as [`crate::inspect::inspect`] measures it with its default options in `bounds`;
    /// known where a tolerance asked for it.
    pub coverage: Option<Coverage>,
    /// Departures from what was asked.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecipeError {
    /// No base mesh.
    #[error(transparent)]
    Base(#[from] BaseError),
    /// The formula is not smooth, or undefined, on the surface.
    #[error(transparent)]
    Defect(#[from] Defect),
    /// A boundary curve failed.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// A G1 system failed.
    #[error(transparent)]
    Spline(#[from] SplineError),
    /// Patches fold over, however the mesh was refined.
    #[error(
        "patches fold over: {count}, the first over face {face} near ({:.4}, {:.4}, {:.4}): more faces are needed",
        at.x, at.y, at.z
    )]
    Folded {
        /// How many.
        count: usize,
        /// The first one.
        face: usize,
        /// A corner of it.
        at: Point3,
    },
}

/// Meshes with fewer faces take little time in any case.
const QUICK_FROM: usize = 1_500;

/// The spline surface of the zero set of `formula`; `progress` is told the name of each stage as it starts.
///
/// The base mesh is remade while patches fold, curves fail or the tolerance is missed, up to `recipe.rounds` times; the
/// best surface is kept. If a wanted number of faces is too small, the error names one that works.
pub fn fit(formula: &Formula, recipe: &SplineRecipe, progress: &dyn Fn(&str)) -> Result<Fitted, RecipeError> {
    awake(|| attempts(formula, recipe, progress))
}

/// The first attempt, or what others give where it fails or misses the tolerance.
fn attempts(
    formula: &Formula,
    recipe: &SplineRecipe,
    progress: &dyn Fn(&str),
) -> Result<Fitted, RecipeError> {
    let error = match attempt(formula, recipe, None, progress) {
        Err(error) => error,
        Ok(fitted) if fitted.reached || recipe.given.is_some() => return Ok(fitted),
        Ok(missed) => return Ok(nearer(formula, recipe, missed, progress)),
    };
    if recipe.given.is_some() || !error.asks_for_more_faces() {
        return Err(error);
    }
    match recipe.size {
        Size::Faces(asked) => {
            progress("least count");
            let trial = SplineRecipe { rounds: SEARCH_ROUNDS, ..recipe.clone() };
            let works = |n| attempt(formula, &trial, Some(n), &|_| ()).is_ok();
            let least = least_that_works(asked, SEARCHED * asked.max(FEWEST), works);
            Err(least.map_or(error, |least| BaseError::TooFewFaces { asked, least }.into()))
        }
        Size::Automatic | Size::Tolerance(_) => from_more_faces(formula, recipe, error, progress),
    }
}

/// A count that works is searched for up to this multiple of the one that was asked for, which counts as [`FEWEST`] if it
/// is less.
const SEARCHED: usize = 20;
const FEWEST: usize = 500;
/// Rounds of each trial: a count that needs many repairs is too small.
const SEARCH_ROUNDS: usize = 2;
/// Growth of the first mesh, and the largest that is tried, where the curvature asks for too few faces.
const MORE: f64 = 1.6;
const MOST_FIRST: usize = 40_000;

/// First meshes that are tried where the tolerance was missed, as multiples of what the faces were then.
const FINER: [f64; 3] = [1.5, 2.5, 4.0];

/// The first surface from a finer first mesh that keeps the tolerance, or else the one that missed it.
fn nearer(formula: &Formula, recipe: &SplineRecipe, missed: Fitted, progress: &dyn Fn(&str)) -> Fitted {
    let faces = missed.surface.nets.len() as f64;
    for factor in FINER {
        let count = 2 * (0.5 * factor * faces) as usize;
        if let Ok(mut fitted) = attempt(formula, recipe, Some(count.min(recipe.most_faces)), progress)
            && fitted.reached
        {
            fitted.repairs.push(remade(count, "the tolerance was missed from a coarser mesh"));
            return fitted;
        }
    }
    missed
}

/// Tries larger and larger first meshes, where the curvature alone asked for too few faces.
fn from_more_faces(
    formula: &Formula,
    recipe: &SplineRecipe,
    first: RecipeError,
    progress: &dyn Fn(&str),
) -> Result<Fitted, RecipeError> {
    let mut faces = FEWEST;
    while faces <= MOST_FIRST {
        if let Ok(mut fitted) = attempt(formula, recipe, Some(faces), progress) {
            fitted.repairs.push(remade(faces, "a mesh by curvature alone had too few faces"));
            return Ok(fitted);
        }
        faces = (MORE * faces as f64) as usize;
        faces += faces % 2;
    }
    Err(first)
}

/// One way through all stages; `faces` is the size of the first mesh if it is not the recipe's.
fn attempt(
    formula: &Formula,
    recipe: &SplineRecipe,
    faces: Option<usize>,
    progress: &dyn Fn(&str),
) -> Result<Fitted, RecipeError> {
    if let Some(value) = formula.constant() {
        return Err(BaseError::ConstantField { value }.into());
    }
    let mut stages = Stages { seconds: Seconds::default(), progress };
    let bounds = stages.run("box", || recipe.bounds.map_or_else(|| base::find_box(formula), Ok))?;
    let negated = stages.run("box", || base::outside_is_negative(formula, &bounds))?;
    let oriented = if negated { formula.negated() } else { formula.clone() };
    let mut work = Rounds { formula: oriented, bounds, recipe };

    let mut first = stages.run("base mesh", || work.first_mesh(faces))?;
    // The samples of the box have missed where the surface leaves it.
    let is_open = first.base.clip.is_some();
    if negated && is_open {
        work.formula = formula.clone();
        first = stages.run("base mesh", || work.first_mesh(faces))?;
    }
    let negated = negated && !is_open;
    let certified_topology = first.certified;
    let (mut mesh, mut repairs) = (first.base, first.repairs);
    mesh.frozen_diagonal = Some(mesh.diagonal());
    // Where the tolerance is easily kept, the rounds do without the last step of the fit.
    let has_tolerance = matches!(recipe.size, Size::Tolerance(_));
    let large = mesh.mesh.face_count() >= QUICK_FROM;
    let is_quick = recipe.effort == Effort::Quick;
    let without = is_quick || has_tolerance && recipe.given.is_none() && large;
    let most_steps = recipe.spline.relaxation_steps.min(if is_quick { 1 } else { usize::MAX });
    let mut steps = if without { 0 } else { most_steps };
    if is_quick && has_tolerance && recipe.given.is_none() {
        mesh = stages.run("base mesh", || work.within_limits(mesh));
    }
    let surface = |work: &Rounds<'_>, mesh: &BaseMesh, steps: usize, stages: &mut Stages<'_>| {
        stages.run("patches", || work.surface(mesh, steps))
    };
    let mut made = surface(&work, &mesh, steps, &mut stages);
    if without && has_tolerance && work.is_hard(&made) {
        steps = most_steps;
        made = made.map(|made| stages.run("patches", || work.relaxed(made, steps)));
    }
    let mut wish = work.wish(&made, &mesh, 0);
    let mut kept = made.map(Best::Surface);
    for round in 1..=recipe.rounds {
        // A decimated mesh is changed in places only, unless patches fail.
        let stays = |wish: &Wish| recipe.base.method == BaseMethod::Decimate && wish.reason.is_none();
        let allowed = |wish: &Wish| recipe.given.is_none() && wish.faces <= recipe.most_faces && !stays(wish);
        let Some(Wish { lengths, faces, reason }) = wish.filter(allowed) else { break };
        let refined =
            stages.run("base mesh", || base::refine(&work.formula, &mesh, &lengths, faces, &recipe.base));
        match refined {
            Ok(finer) => mesh = finer.base,
            Err(error) => {
                kept = kept.or(Err(error.into()));
                break;
            }
        }
        repairs.extend(reason.map(|why| remade(mesh.mesh.face_count(), why)));
        kept = kept.map(|best| work.put_aside(best));
        let made = surface(&work, &mesh, steps, &mut stages);
        wish = work.wish(&made, &mesh, round);
        // A surface stays, whatever becomes of later rounds; without one, the last failure counts.
        kept = match (made, kept) {
            (Ok(made), Ok(best)) => Ok(work.better_of(made, best)),
            (Err(_), Ok(best)) => Ok(best),
            (made, Err(_)) => made.map(Best::Surface),
        };
    }
    let mut kept = match kept? {
        Best::Surface(kept) => kept,
        Best::Mesh { mesh, .. } => surface(&work, &mesh, steps, &mut stages)?,
    };
    let mut checked = Checked { reached: true, coverage: None };
    if let Size::Tolerance(tolerance) = recipe.size {
        if recipe.given.is_none() {
            (kept, checked) = stages.run("finishing", || work.finish(kept, tolerance, steps))?;
        } else {
            checked = stages.run("check", || work.check(&kept, tolerance));
        }
    }
    let Checked { reached, coverage } = checked;
    require_no_folds(&kept)?;
    let figures = figures(&kept.curves, &recipe.curves, &kept.patches);
    let Rounds { formula, bounds, .. } = work;
    Ok(Fitted {
        surface: kept.surface,
        formula,
        negated,
        bounds,
        reached,
        figures,
        certified_topology,
        coverage,
        repairs,
        seconds: stages.seconds,
    })
}

impl From<MakeError> for RecipeError {
    fn from(error: MakeError) -> Self {
        match error {
            MakeError::Base(error) => error.into(),
            MakeError::Curve(error) => error.into(),
            MakeError::Spline(error) => error.into(),
        }
    }
}

impl RecipeError {
    /// Would more faces help?
    fn asks_for_more_faces(&self) -> bool {
        match self {
            Self::Base(error) => {
                matches!(error, BaseError::TooFewFaces { .. } | BaseError::InvertedCorner { .. })
            }
            Self::Defect(_) => false,
            Self::Curve(_) | Self::Spline(_) | Self::Folded { .. } => true,
        }
    }
}

/// Runs stages, tells their names and sums up their times.
struct Stages<'a> {
    seconds: Seconds,
    progress: &'a dyn Fn(&str),
}

impl Stages<'_> {
    fn run<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        (self.progress)(name);
        self.seconds.measure(name, work)
    }
}

fn require_no_folds(made: &Patchwork) -> Result<(), RecipeError> {
    let folded = || made.patches.iter().enumerate().filter(|(_, p)| p.folded);
    let Some((face, _)) = folded().next() else { return Ok(()) };
    Err(RecipeError::Folded { count: folded().count(), face, at: made.surface.nets[face][0] })
}

fn remade(faces: usize, why: &str) -> Repair {
    Repair {
        what: format!("base mesh remade with {faces} faces"),
        place: "whole mesh".into(),
        why: why.into(),
    }
}

pub(super) fn figures(
    curves: &[QuarticCurve],
    options: &CurveOptions,
    patches: &[PatchDeviation],
) -> SplineReport {
    // Where Algorithm 5.1 failed, the steps are those of another solver.
    let counted = || curves.iter().filter(|c| !c.sqp_failed);
    let steps: usize = counted().map(|c| c.steps).sum();
    SplineReport {
        sqp_iterations_mean: steps as f64 / counted().count().max(1) as f64,
        sqp_unconverged: curves.iter().filter(|c| c.sqp_failed || c.steps >= options.max_steps).count(),
        curves_at_bound: curves.iter().filter(|c| c.at_bound).count(),
        folded: patches.iter().filter(|p| p.folded).count(),
        faces_over_20deg: patches.iter().filter(|p| p.max_normal_error > NORMAL_ERROR_LIMIT).count(),
    }
}
