//! The G1 spline of Tong & Kim 2009 from a formula: the paper's section 3.4, with the corrections of PAPERS.md.
//!
//! ```text
//! box ──► (i) base mesh ──► (ii) curves ──► (iii) fit, (iv) G1, (v) free points ──► check ──► best so far
//!                 ▲                                                                   │
//!                 └──── edge lengths from the error of every patch (refine.rs) ───────┘
//! ```

use super::differentiable::{Defect, explain, find_defect};
use super::finish::Finisher;
use super::least::least_that_works;
use super::patchwork::{MakeError, Patchwork, Workshop};
use super::refine::{Wish, expected_faces, is_bad, lengths_for_error, median_error, misses, shorter_at};
use crate::base::{
    self, BaseError, BaseMesh, BaseMethod, BaseOptions, BaseOutcome, Draft, Repair, SeedOptions,
};
use crate::field::Formula;
use crate::geom::{Aabb, Point3};
use crate::inspect::{NORMAL_ERROR_LIMIT, PatchDeviation, coverage, extent};
use crate::io::read::PolygonMesh;
use crate::network::{CurveError, CurveOptions, QuarticCurve};
use crate::report::{Seconds, SplineReport};
use crate::spline::{SplineError, SplineOptions, TriangularSpline};
use crate::surface::PatchId;

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
    /// Is it certified that the surface has the topology of the zero set in the box?
    pub certified_topology: bool,
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

/// Points of the zero set from which the distance back is measured before a tolerance counts as kept.
const BACK_SAMPLES: usize = 30_000;
/// Normals at the ends of a seed edge that differ by more than this (the length of their difference, about 17°) make one
/// look for a kink at once.
const SHARP: f64 = 0.3;
/// The error that edge lengths aim at, as a share of the tolerance: the largest of thousands of errors scatters.
const AIM: f64 = 0.7;
/// The share of the tolerance that the samples of the rounds must keep: a later inspection takes other samples.
const MARGIN: f64 = 0.95;
/// Times that the whole mesh is remade for a tolerance.
const GLOBAL_ROUNDS: usize = 3;
/// Share of failing patches that is left to local changes.
const FEW: f64 = 0.03;
/// Meshes with fewer faces take little time in any case.
const QUICK_FROM: usize = 1_500;
/// Errors above this share of the tolerance are measured on a fine lattice.
const NEAR: f64 = 0.35;
/// Times that the patch is split that is nearest to where the zero set is too far from the surface.
const BACK_ROUNDS: usize = 3;
/// Turn of the normal along the edges of the first mesh for a tolerance: patches that fail are split.
const TOLERANCE_TURN: f64 = 1.25;
/// Its anisotropy: corners may be wider than where no patch is measured before the end.
const TOLERANCE_ANISOTROPY: f64 = 3.0;

/// The spline surface of the zero set of `formula`; `progress` is told the name of each stage as it starts.
///
/// The base mesh is remade while patches fold, curves fail or the tolerance is missed, up to `recipe.rounds` times; the
/// best surface is kept. If a wanted number of faces is too small, the error names one that works.
pub fn fit(formula: &Formula, recipe: &SplineRecipe, progress: &dyn Fn(&str)) -> Result<Fitted, RecipeError> {
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
    let mut work = Work { formula: oriented, bounds, recipe };

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
    let large = mesh.mesh.face_count() >= QUICK_FROM;
    let mut quick = matches!(recipe.size, Size::Tolerance(_)) && recipe.given.is_none() && large;
    let mut made = work.surface(&mesh, quick, &mut stages);
    if quick && work.is_hard(&made) {
        quick = false;
        made = work.surface(&mesh, quick, &mut stages);
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
        let made = work.surface(&mesh, quick, &mut stages);
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
        Best::Mesh { mesh, .. } => work.surface(&mesh, quick, &mut stages)?,
    };
    let mut reached = true;
    if let Size::Tolerance(tolerance) = recipe.size {
        if recipe.given.is_none() {
            (kept, reached) = stages.run("finishing", || work.finish(kept, tolerance, quick))?;
        } else {
            let near = kept.failing(tolerance) == 0;
            reached = near && stages.run("check", || work.far_patch(&kept.work, tolerance).is_none());
        }
    }
    kept.require_no_folds()?;
    let figures = figures(&kept.work.curves, &recipe.curves, &kept.work.patches);
    let Work { formula, bounds, .. } = work;
    let seconds = stages.seconds;
    let surface = kept.work.surface;
    Ok(Fitted { surface, formula, negated, bounds, reached, figures, certified_topology, repairs, seconds })
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

/// What stays the same in all rounds.
struct Work<'a> {
    formula: Formula,
    bounds: Aabb,
    recipe: &'a SplineRecipe,
}

/// The best surface so far.
enum Best {
    Surface(Round),
    /// Its mesh, over which it can be built again.
    Mesh {
        mesh: BaseMesh,
        score: (f64, f64),
    },
}

/// A surface with its errors.
struct Round {
    work: Patchwork,
}

impl Work<'_> {
    /// Step (i) of the paper: polygonise, decimate, project; no kink may be on the surface.
    fn first_mesh(&self, faces: Option<usize>) -> Result<BaseOutcome, RecipeError> {
        let faces = match self.recipe.size {
            Size::Faces(n) => faces.or(Some(n)),
            Size::Automatic | Size::Tolerance(_) => faces,
        };
        // Counts are searched for where the whole surface is made, not only its base mesh.
        let mut options = BaseOptions { faces, trial: faces.is_some(), ..self.recipe.base };
        if let Size::Tolerance(_) = self.recipe.size {
            let sizing = &mut options.remesh.sizing;
            (sizing.turn, sizing.anisotropy) = (TOLERANCE_TURN, TOLERANCE_ANISOTROPY);
        }
        let outcome = match &self.recipe.given {
            Some(mesh) => base::from_mesh(&self.formula, &mesh.positions, &mesh.faces, &options),
            None => {
                // In a box that was found, the surface is bounded.
                let seed =
                    SeedOptions { open: options.seed.open && self.recipe.bounds.is_some(), ..options.seed };
                let seed = base::seed_mesh(&self.formula, &self.bounds, faces, &seed);
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
    fn surface(&self, mesh: &BaseMesh, quick: bool, stages: &mut Stages<'_>) -> Result<Round, RecipeError> {
        let stamps = (0..mesh.mesh.face_count() as u64).collect();
        let work =
            stages.run("patches", || self.workshop(mesh.diagonal(), quick).build(mesh.clone(), stamps))?;
        Ok(Round { work })
    }

    /// Does the first surface fail, or miss the tolerance in more than a few patches?
    fn is_hard(&self, made: &Result<Round, RecipeError>) -> bool {
        match (made, self.recipe.size) {
            (Ok(made), Size::Tolerance(tolerance)) => {
                made.failing(tolerance) as f64 > FEW * made.work.patches.len() as f64
            }
            _ => true,
        }
    }

    /// Without relaxation if it is to be quick.
    fn workshop(&self, diagonal: f64, quick: bool) -> Workshop<'_> {
        let relaxation_steps = if quick { 0 } else { self.recipe.spline.relaxation_steps };
        Workshop {
            field: &self.formula,
            curves: &self.recipe.curves,
            spline: SplineOptions { relaxation_steps, ..self.recipe.spline },
            diagonal,
            fine_above: match self.recipe.size {
                Size::Tolerance(tolerance) => NEAR * tolerance,
                Size::Automatic | Size::Faces(_) => f64::INFINITY,
            },
        }
    }

    /// Local changes until the tolerance is kept, both ways, with as few faces as that takes; is it kept?
    fn finish(&self, made: Round, tolerance: f64, quick: bool) -> Result<(Round, bool), RecipeError> {
        let base = &made.work.surface.base;
        let diagonal = base.diagonal();
        let workshop = self.workshop(diagonal, quick);
        let last = self.workshop(diagonal, false);
        let mut finisher = Finisher {
            workshop: &workshop,
            options: &self.recipe.base,
            tolerance: MARGIN * tolerance,
            draft: Draft::new(&self.formula, base, &self.recipe.base),
            built: made.work.patches.len(),
            work: made.work,
        };
        finisher.run()?;
        finisher.workshop = &last;
        if quick {
            finisher.build_again()?;
        }
        let (mut kept, mut reached) = (finisher.split_failing()?, false);
        for _ in 0..=BACK_ROUNDS {
            if !kept || reached {
                break;
            }
            match self.far_patch(&finisher.work, tolerance) {
                Some(patch) => kept = finisher.split(vec![patch.index()])? && finisher.split_failing()?,
                None => reached = true,
            }
        }
        Ok((Round { work: finisher.work }, reached))
    }

    /// The patch nearest to the point of the zero set that is farthest from the surface, if that is too far.
    fn far_patch(&self, work: &Patchwork, tolerance: f64) -> Option<PatchId> {
        let (surface, diagonal) = (&work.surface, work.surface.base.diagonal());
        let (area, box_) = (extent(surface).area, Some(self.bounds));
        coverage(surface, &self.formula, diagonal, area, BACK_SAMPLES, box_)
            .filter(|c| c.max_distance > tolerance || c.max_distance.is_nan())
            .map(|c| c.worst_patch)
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
        let (base, patches) = (&made.work.surface.base, &made.work.patches);
        let bad = patches.iter().any(is_bad);
        let mut wish = match self.recipe.size {
            Size::Tolerance(tolerance) => {
                if round >= GLOBAL_ROUNDS {
                    return None;
                }
                let faces = base.mesh.face_count() as f64;
                let mut wish = lengths_for_error(base, patches, AIM * tolerance);
                if made.failing(tolerance) as f64 <= FEW * faces {
                    return None;
                }
                let count = wish.faces as f64;
                wish.faces = 2 * (0.5 * count).round() as usize;
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

    /// Less is better: with a tolerance, the number of faces to be expected when it is kept; or else the number of bad
    /// patches, then the error.
    fn score(&self, round: &Round) -> (f64, f64) {
        match self.recipe.size {
            Size::Tolerance(tolerance) => (expected_faces(&round.work.patches, MARGIN * tolerance), 0.0),
            Size::Automatic | Size::Faces(_) => (round.bad_patches() as f64, round.max_distance()),
        }
    }

    /// The best surface while the next one is built: of a large one only the mesh is kept.
    fn put_aside(&self, best: Best) -> Best {
        match (best, self.recipe.size) {
            (Best::Surface(round), Size::Automatic | Size::Faces(_)) => {
                let score = self.score(&round);
                Best::Mesh { mesh: round.work.surface.base, score }
            }
            (best, _) => best,
        }
    }

    fn better_of(&self, made: Round, best: Best) -> Best {
        let score = match &best {
            Best::Surface(round) => self.score(round),
            Best::Mesh { score, .. } => *score,
        };
        if score < self.score(&made) { best } else { Best::Surface(made) }
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
    fn max_distance(&self) -> f64 {
        self.work.patches.iter().map(|p| p.max_distance).fold(0.0, f64::max)
    }

    fn bad_patches(&self) -> usize {
        self.work.patches.iter().filter(|p| is_bad(p)).count()
    }

    /// Number of patches that are bad or beyond the tolerance.
    fn failing(&self, tolerance: f64) -> usize {
        self.work.patches.iter().filter(|p| misses(p, MARGIN * tolerance)).count()
    }

    fn require_no_folds(&self) -> Result<(), RecipeError> {
        let folded = || self.work.patches.iter().enumerate().filter(|(_, p)| p.folded);
        let Some((face, _)) = folded().next() else { return Ok(()) };
        let at = self.work.surface.nets[face][0];
        Err(RecipeError::Folded { count: folded().count(), face, at })
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

fn figures(curves: &[QuarticCurve], options: &CurveOptions, patches: &[PatchDeviation]) -> SplineReport {
    let steps: usize = curves.iter().map(|c| c.steps).sum();
    SplineReport {
        sqp_iterations_mean: steps as f64 / curves.len().max(1) as f64,
        sqp_unconverged: curves.iter().filter(|c| c.steps >= options.max_steps).count(),
        curves_at_bound: curves.iter().filter(|c| c.at_bound).count(),
        folded: patches.iter().filter(|p| p.folded).count(),
        faces_over_20deg: patches.iter().filter(|p| p.max_normal_error > NORMAL_ERROR_LIMIT).count(),
    }
}
