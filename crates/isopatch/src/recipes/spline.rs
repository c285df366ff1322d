//! The G1 spline of Tong & Kim 2009 from a formula: the paper's section 3.4, with the corrections of PAPERS.md.
//!
//! ```text
//! box ──► (i) base mesh ──► (ii) curves ──► (iii) fit, (iv) G1, (v) free points ──► check ──► best so far
//!                 ▲                                                                   │
//!                 └──── edge lengths from the error of every patch (refine.rs) ───────┘
//! ```

use super::differentiable::{Defect, explain, find_defect};
use super::least::least_that_works;
use super::refine::{Wish, is_bad, lengths_for_error, median_error, shorter_at};
use crate::base::{self, BaseError, BaseMesh, BaseOptions, BaseOutcome, FieldTarget, Repair};
use crate::field::Formula;
use crate::geom::{Aabb, Point3};
use crate::inspect::{Deviation, coverage, deviation, extent};
use crate::io::read::PolygonMesh;
use crate::network::{CurveError, CurveOptions, QuarticCurve, fit_quartics};
use crate::report::{Seconds, SplineReport};
use crate::spline::{self, SplineError, SplineOptions, TriangularSpline};

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

/// What the recipe is given besides the formula. The default is a good choice for every stage.
#[derive(Clone, Debug)]
pub struct SplineRecipe {
    /// Where the surface is; found if the surface is bounded and none is given.
    pub bounds: Option<Aabb>,
    /// Number of patches.
    pub size: Size,
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
        "{count} patches fold over, the first over face {face} near ({:.4}, {:.4}, {:.4}): more faces are needed",
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

/// Lattice on which patches are checked between rounds: 91 samples each, finer than those of the fits. It and
/// [`BACK_SAMPLES`] are the defaults of [`crate::inspect::InspectOptions`]: a tolerance that is kept here is kept there.
const CHECK_LATTICE: usize = 12;
/// Points of the zero set from which the distance back is measured before a tolerance counts as kept.
const BACK_SAMPLES: usize = 30_000;
/// Normals at the ends of a seed edge that differ by more than this (the length of their difference, about 17°) make one
/// look for a kink at once.
const SHARP: f64 = 0.3;
/// The error that edge lengths aim at, as a share of the tolerance: the largest of thousands of errors scatters.
const AIM: f64 = 0.45;
/// The share of the tolerance that the samples of the rounds must keep: a later inspection takes other samples.
const MARGIN: f64 = 0.95;
/// In round r a mesh that misses the tolerance grows at least by the r-th power of this factor: the first round only
/// evens out the errors, and no count is out of reach.
const GROWTH: f64 = 1.06;

/// The spline surface of the zero set of `formula`; `progress` is told the name of each stage as it starts.
///
/// The base mesh is remade while patches fold, curves fail or the tolerance is missed, up to `recipe.rounds` times; the
/// best surface is kept. If a wanted number of faces is too small, the error names one that works.
pub fn fit(formula: &Formula, recipe: &SplineRecipe, progress: &dyn Fn(&str)) -> Result<Fitted, RecipeError> {
    let error = match attempt(formula, recipe, None, progress) {
        Err(error) => error,
        fitted => return fitted,
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
    let mut work = Work { formula: oriented, bounds, recipe };

    let mut first = stages.run("base mesh", || work.first_mesh(faces))?;
    // The samples of the box have missed where the surface leaves it.
    let is_open = first.base.clip.is_some();
    if negated && is_open {
        work.formula = formula.clone();
        first = stages.run("base mesh", || work.first_mesh(faces))?;
    }
    let negated = negated && !is_open;
    let (mut mesh, mut repairs) = (first.base, first.repairs);
    let made = work.surface(&mesh, &mut stages);
    let mut wish = work.wish(&made, &mesh, 0);
    let mut kept = made;
    for round in 1..=recipe.rounds {
        let allowed = |wish: &Wish| recipe.given.is_none() && wish.faces <= recipe.most_faces;
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
        let made = work.surface(&mesh, &mut stages);
        wish = work.wish(&made, &mesh, round);
        // A surface stays, whatever becomes of later rounds; without one, the last failure counts.
        kept = match (made, kept) {
            (Ok(made), Ok(best)) => Ok(made.better_of(best)),
            (Err(_), Ok(best)) => Ok(best),
            (made, Err(_)) => made,
        };
    }
    let kept = kept?;
    kept.require_no_folds()?;
    let reached = match recipe.size {
        Size::Tolerance(tolerance) => kept.keeps(tolerance),
        Size::Automatic | Size::Faces(_) => true,
    };
    let Work { formula, bounds, .. } = work;
    let seconds = stages.seconds;
    Ok(Fitted {
        surface: kept.surface,
        formula,
        negated,
        bounds,
        reached,
        figures: kept.figures,
        repairs,
        seconds,
    })
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

/// What stays the same in all rounds.
struct Work<'a> {
    formula: Formula,
    bounds: Aabb,
    recipe: &'a SplineRecipe,
}

/// A surface with its errors.
struct Round {
    surface: TriangularSpline,
    deviation: Deviation,
    /// Largest distance from the zero set to the surface; infinite before it is measured.
    back: f64,
    figures: SplineReport,
}

impl Work<'_> {
    /// Step (i) of the paper: polygonise, decimate, project; no kink may be on the surface.
    fn first_mesh(&self, faces: Option<usize>) -> Result<BaseOutcome, RecipeError> {
        let faces = match self.recipe.size {
            Size::Faces(n) => faces.or(Some(n)),
            Size::Automatic | Size::Tolerance(_) => faces,
        };
        // Counts are searched for where the whole surface is made, not only its base mesh.
        let options = BaseOptions { faces, trial: faces.is_some(), ..self.recipe.base };
        let outcome = match &self.recipe.given {
            Some(mesh) => base::from_mesh(&self.formula, &mesh.positions, &mesh.faces, &options),
            None => {
                let seed = base::seed_mesh(&self.formula, &self.bounds, faces, &options.seed);
                let seed = seed.map_err(|error| self.blame(error))?;
                // A sharp edge would ask for endlessly many faces.
                if let Some(defect) =
                    find_defect(&self.formula, &seed.mesh.positions, seed.sharp_edges(SHARP))
                {
                    return Err(defect.into());
                }
                base::base_from_seed(&self.formula, &seed, &options)
            }
        };
        let outcome = outcome.map_err(|error| self.blame(error))?;
        let base = &outcome.base;
        let ends = |e| {
            let h = base.mesh.edge_half_edge(e);
            [base.mesh.origin(h), base.mesh.dest(h)].map(|v| v.index())
        };
        match find_defect(&self.formula, &base.positions, base.mesh.edges().map(ends)) {
            Some(defect) => Err(defect.into()),
            None => Ok(outcome),
        }
    }

    /// What the formula has to say about a failure of the base mesh, or that failure.
    fn blame(&self, error: BaseError) -> RecipeError {
        match explain(&self.formula, &self.bounds, &error) {
            Some(defect) => RecipeError::Defect(defect),
            None => RecipeError::Base(error),
        }
    }

    /// Steps (ii) to (v): boundary curves, G0 fit, G1 systems, free points; then the check.
    fn surface(&self, mesh: &BaseMesh, stages: &mut Stages<'_>) -> Result<Round, RecipeError> {
        let diagonal = mesh.diagonal();
        let target = FieldTarget::new(&self.formula, diagonal);
        let curves = stages.run("curves", || fit_quartics(mesh, &target, &self.recipe.curves))?;
        let options = &self.recipe.spline;
        let surface = stages.run("patches", || spline::build(mesh.clone(), &curves, &target, options))?;
        let (deviation, back) = stages.run("check", || {
            let deviation = deviation(&surface, &self.formula, diagonal, CHECK_LATTICE);
            let back = match self.recipe.size {
                Size::Tolerance(tolerance) if deviation.max_distance <= tolerance => {
                    let (area, box_) = (extent(&surface).area, Some(self.bounds));
                    coverage(&surface, &self.formula, diagonal, area, BACK_SAMPLES, box_)
                        .map_or(f64::INFINITY, |c| c.max_distance)
                }
                _ => f64::INFINITY,
            };
            (deviation, back)
        });
        let figures = figures(&curves, &self.recipe.curves, &deviation);
        Ok(Round { surface, deviation, back, figures })
    }

    /// The mesh to try next; none if the surface will do, or its failure has nothing to do with the mesh.
    fn wish(&self, made: &Result<Round, RecipeError>, mesh: &BaseMesh, round: usize) -> Option<Wish> {
        match made {
            Ok(made) => self.wish_after(made, round),
            Err(error) => self.wish_after_failure(error, mesh),
        }
    }

    /// The mesh to try next; none if the surface will do.
    fn wish_after(&self, made: &Round, round: usize) -> Option<Wish> {
        let (base, patches) = (&made.surface.base, &made.deviation.patches);
        let bad = patches.iter().any(is_bad);
        let mut wish = match self.recipe.size {
            Size::Tolerance(tolerance) => {
                if !bad && made.keeps(tolerance) {
                    return None;
                }
                let mut wish = lengths_for_error(base, patches, AIM * tolerance);
                // A mesh that misses the tolerance gets no fewer faces, and the more of them the longer it misses.
                let least = (GROWTH.powi(round as i32) * base.mesh.face_count() as f64) as usize;
                wish.faces = wish.faces.max(least + least % 2);
                wish
            }
            Size::Automatic | Size::Faces(_) => {
                if !bad && round >= self.recipe.evening {
                    return None;
                }
                lengths_for_error(base, patches, median_error(patches))
            }
        };
        wish.reason = bad.then_some("patches folded or had normals off by more than 20°");
        // Evening out keeps the count, as does a count that was asked for.
        if matches!(self.recipe.size, Size::Faces(_))
            || (wish.reason.is_none() && self.recipe.size == Size::Automatic)
        {
            wish.faces = base.mesh.face_count();
        }
        Some(wish)
    }

    /// Shorter edges where a curve or a system has no solution.
    fn wish_after_failure(&self, error: &RecipeError, mesh: &BaseMesh) -> Option<Wish> {
        let vertices = match error {
            RecipeError::Curve(
                CurveError::Infeasible { from, to, .. } | CurveError::NoTangent { from, to, .. },
            )
            | RecipeError::Spline(SplineError::SingularEdge { from, to, .. }) => vec![*from, *to],
            RecipeError::Spline(SplineError::SingularVertex { vertex }) => vec![*vertex],
            _ => return None,
        };
        let mut wish = shorter_at(mesh, &vertices);
        wish.reason = Some("a boundary curve or a G1 system had no solution");
        if matches!(self.recipe.size, Size::Faces(_)) {
            wish.faces = mesh.mesh.face_count();
        }
        Some(wish)
    }
}

impl Round {
    /// Is the largest distance, both ways, within the tolerance, and a little more, for other samples to agree?
    fn keeps(&self, tolerance: f64) -> bool {
        self.deviation.max_distance.max(self.back) <= MARGIN * tolerance
    }

    fn bad_patches(&self) -> usize {
        self.deviation.patches.iter().filter(|p| is_bad(p)).count()
    }

    /// This one, unless the other has fewer bad patches, or as many and a smaller error.
    fn better_of(self, other: Self) -> Self {
        let score = |r: &Self| (r.bad_patches(), r.deviation.max_distance.max(r.back.min(f64::MAX)));
        let (mine, others) = (score(&self), score(&other));
        let worse = others.0 < mine.0 || (others.0 == mine.0 && others.1 < mine.1);
        if worse { other } else { self }
    }

    fn require_no_folds(&self) -> Result<(), RecipeError> {
        let Some(face) = self.deviation.patches.iter().position(|p| p.folded) else { return Ok(()) };
        let at = self.surface.nets[face][0];
        Err(RecipeError::Folded { count: self.deviation.folded, face, at })
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

fn remade(faces: usize, why: &str) -> Repair {
    Repair {
        what: format!("base mesh remade with {faces} faces"),
        place: "whole mesh".into(),
        why: why.into(),
    }
}

fn figures(curves: &[QuarticCurve], options: &CurveOptions, deviation: &Deviation) -> SplineReport {
    let steps: usize = curves.iter().map(|c| c.steps).sum();
    SplineReport {
        sqp_iterations_mean: steps as f64 / curves.len().max(1) as f64,
        sqp_unconverged: curves.iter().filter(|c| c.steps >= options.max_steps).count(),
        curves_at_bound: curves.iter().filter(|c| c.at_bound).count(),
        folded: deviation.folded,
        faces_over_20deg: deviation.over_limit,
    }
}
