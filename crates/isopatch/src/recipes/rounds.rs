//! Rounds of the spline recipe: a surface is made and checked, and the next base mesh follows from its errors.

use super::differentiable::{explain, find_defect};
use super::finish::Finisher;
use super::patchwork::{Patchwork, Workshop};
use super::refine::{Wish, expected_faces, is_bad, lengths_for_error, median_error, misses, shorter_at};
use super::spline::{Effort, RecipeError, Size, SplineRecipe};
use crate::base::{self, BaseError, BaseMesh, BaseOptions, BaseOutcome, Draft, SeedOptions, validity};
use crate::field::Formula;
use crate::geom::Aabb;
use crate::inspect::{Coverage, InspectOptions, coverage, extent};
use crate::network::CurveError;
use crate::spline::{SplineError, SplineOptions};

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
/// Errors above this share of the tolerance are measured on a fine lattice.
const NEAR: f64 = 0.35;
/// Radians that normals may be off by for the square root of a tolerance, and the least (½°) and most (10°).
const NORMAL_SHARE: f64 = 2.27;
const LEAST_NORMAL: f64 = 0.5 * std::f64::consts::PI / 180.0;
const MOST_NORMAL: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Times that edges of faces beyond the limits are split before any patch is built.
const LIMIT_ROUNDS: usize = 8;
/// Times that the patch is split that is nearest to where the zero set is too far from the surface.
const BACK_ROUNDS: usize = 3;
/// Points of the zero set for each patch, and at least, from which the way back is measured with little effort.
const SAMPLES_PER_PATCH: usize = 2;
const FEWEST_SAMPLES: usize = 2_000;
/// Turn of the normal along the edges of the first mesh for a tolerance: patches that fail are split.
const TOLERANCE_TURN: f64 = 1.25;
/// Its anisotropy: corners may be wider than where no patch is measured before the end.
const TOLERANCE_ANISOTROPY: f64 = 3.0;

/// What stays the same in all rounds.
pub(super) struct Rounds<'a> {
    pub formula: Formula,
    pub bounds: Aabb,
    pub recipe: &'a SplineRecipe,
}

/// The best surface so far.
pub(super) enum Best {
    Surface(Patchwork),
    /// Its mesh, over which it can be built again.
    Mesh {
        mesh: BaseMesh,
        score: (f64, f64),
    },
}

/// Is a tolerance kept, both ways?
pub(super) struct Checked {
    pub reached: bool,
    /// The way back, if it was measured.
    pub coverage: Option<Coverage>,
}

impl Rounds<'_> {
    /// Step (i) of the paper: polygonise, decimate, project; no kink may be on the surface.
    pub fn first_mesh(&self, faces: Option<usize>) -> Result<BaseOutcome, RecipeError> {
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
    pub fn surface(&self, mesh: &BaseMesh, relaxation_steps: usize) -> Result<Patchwork, RecipeError> {
        let stamps = (0..mesh.mesh.face_count() as u64).collect();
        Ok(self.workshop(mesh.diagonal(), relaxation_steps).build(mesh.clone(), stamps)?)
    }

    /// The same surface after more steps of relaxation.
    pub fn relaxed(&self, made: Patchwork, more: usize) -> Patchwork {
        self.workshop(made.surface.base.diagonal(), more).relaxed(made, more)
    }

    /// A mesh without faces beyond the limits, as far as splits of their edges make it one.
    pub fn within_limits(&self, mut mesh: BaseMesh) -> BaseMesh {
        let mut draft = Draft::new(&self.formula, &mesh, &self.recipe.base);
        for _ in 0..LIMIT_ROUNDS {
            let mut faces: Vec<usize> =
                validity(&mesh, &self.recipe.base.limits).iter().map(|v| v.face.index()).collect();
            faces.sort_unstable();
            faces.dedup();
            let Some(mut batch) = draft.batch().filter(|_| !faces.is_empty()) else { break };
            for face in faces {
                let side = batch.most_turned_side(face);
                batch.split(side);
            }
            match draft.base() {
                Ok(split) => mesh = split,
                Err(_) => break,
            }
        }
        mesh
    }

    /// Does the first surface fail, or miss the tolerance in more than a few patches?
    pub fn is_hard(&self, made: &Result<Patchwork, RecipeError>) -> bool {
        match (made, self.recipe.size) {
            (Ok(made), Size::Tolerance(tolerance)) => {
                failing(made, tolerance) as f64 > FEW * made.patches.len() as f64
            }
            _ => true,
        }
    }

    fn workshop(&self, diagonal: f64, relaxation_steps: usize) -> Workshop<'_> {
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

    /// Local changes until the tolerance is kept, both ways, with as few faces as that takes.
    pub fn finish(
        &self,
        made: Patchwork,
        tolerance: f64,
        relaxation_steps: usize,
    ) -> Result<(Patchwork, Checked), RecipeError> {
        let base = &made.surface.base;
        let diagonal = base.diagonal();
        let workshop = self.workshop(diagonal, relaxation_steps);
        // Where the tolerance is easily kept, one step of the relaxation will do.
        let is_easy = relaxation_steps == 0;
        let all_steps = self.recipe.spline.relaxation_steps;
        let last = self.workshop(diagonal, if is_easy { all_steps.min(1) } else { all_steps });
        let mut finisher = Finisher {
            workshop: &workshop,
            options: &self.recipe.base,
            tolerance: MARGIN * tolerance,
            normal_tolerance: normal_tolerance(tolerance),
            draft: Draft::new(&self.formula, base, &self.recipe.base),
            built: made.patches.len(),
            work: made,
        };
        if self.recipe.effort == Effort::Full {
            finisher.run()?;
            finisher.workshop = &last;
            if is_easy {
                finisher.build_again()?;
            }
        }
        let mut kept = finisher.split_failing()?;
        for _ in 0..=BACK_ROUNDS {
            if !kept {
                break;
            }
            let coverage = self.coverage(&finisher.work);
            let Some(far) = coverage.filter(|c| !is_near(c, tolerance)) else {
                return Ok((finisher.work, Checked { reached: true, coverage }));
            };
            kept = finisher.split(vec![far.worst_patch.index()])? && finisher.split_failing()?;
        }
        Ok((finisher.work, Checked { reached: false, coverage: None }))
    }

    /// Is the tolerance kept as it is?
    pub fn check(&self, made: &Patchwork, tolerance: f64) -> Checked {
        if failing(made, tolerance) > 0 {
            return Checked { reached: false, coverage: None };
        }
        let coverage = self.coverage(made);
        Checked { reached: coverage.is_none_or(|c| is_near(&c, tolerance)), coverage }
    }

    /// From points of the zero set to the surface; none where it has no points.
    fn coverage(&self, made: &Patchwork) -> Option<Coverage> {
        let (surface, area) = (&made.surface, extent(&made.surface).area);
        let most = InspectOptions::default().back_samples;
        let samples = match self.recipe.effort {
            Effort::Full => most,
            Effort::Quick => (SAMPLES_PER_PATCH * made.patches.len()).clamp(FEWEST_SAMPLES, most),
        };
        coverage(surface, &self.formula, surface.base.diagonal(), area, samples, Some(self.bounds))
    }

    /// The mesh to try next; none if the surface will do, or its failure has nothing to do with the mesh.
    pub fn wish(&self, made: &Result<Patchwork, RecipeError>, mesh: &BaseMesh, round: usize) -> Option<Wish> {
        match made {
            Ok(made) => self.wish_after(made, round),
            Err(error) => self.wish_after_failure(error, mesh),
        }
    }

    /// The mesh to try next; none if the surface will do.
    fn wish_after(&self, made: &Patchwork, round: usize) -> Option<Wish> {
        let (base, patches) = (&made.surface.base, &made.patches);
        let bad = patches.iter().any(is_bad);
        let mut wish = match self.recipe.size {
            Size::Tolerance(tolerance) => {
                if round >= GLOBAL_ROUNDS {
                    return None;
                }
                let faces = base.mesh.face_count() as f64;
                let mut wish = lengths_for_error(base, patches, AIM * tolerance);
                if failing(made, tolerance) as f64 <= FEW * faces {
                    return None;
                }
                let count = wish.faces as f64;
                wish.faces = 2 * (0.5 * count).round() as usize;
                wish
            }
            Size::Automatic | Size::Faces(_) => {
                let evened = round >= self.recipe.evening || self.recipe.effort == Effort::Quick;
                if !bad && self.violations(base) == 0 && evened {
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
    /// patches and faces, then the error.
    fn score(&self, made: &Patchwork) -> (f64, f64) {
        match self.recipe.size {
            Size::Tolerance(tolerance) => (expected_faces(&made.patches, MARGIN * tolerance), 0.0),
            Size::Automatic | Size::Faces(_) => {
                let bad = made.patches.iter().filter(|p| is_bad(p)).count();
                let bad = bad + self.violations(&made.surface.base);
                (bad as f64, made.patches.iter().map(|p| p.max_distance).fold(0.0, f64::max))
            }
        }
    }

    /// Faces beyond the limits of a base mesh; a given mesh is taken as it is.
    fn violations(&self, base: &BaseMesh) -> usize {
        if self.recipe.given.is_some() { 0 } else { validity(base, &self.recipe.base.limits).len() }
    }

    /// The best surface while the next one is built: of a large one only the mesh is kept.
    pub fn put_aside(&self, best: Best) -> Best {
        match (best, self.recipe.size) {
            (Best::Surface(made), Size::Automatic | Size::Faces(_)) => {
                let score = self.score(&made);
                Best::Mesh { mesh: made.surface.base, score }
            }
            (best, _) => best,
        }
    }

    pub fn better_of(&self, made: Patchwork, best: Best) -> Best {
        let score = match &best {
            Best::Surface(made) => self.score(made),
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

/// What normals may be off by: an angle goes with the square root of a height, 1.3° with 1e-4 of the diagonal.
fn normal_tolerance(tolerance: f64) -> f64 {
    (NORMAL_SHARE * tolerance.sqrt()).clamp(LEAST_NORMAL, MOST_NORMAL)
}

/// Number of patches that are bad or beyond the tolerance.
fn failing(made: &Patchwork, tolerance: f64) -> usize {
    made.patches.iter().filter(|p| misses(p, MARGIN * tolerance)).count()
}

fn is_near(coverage: &Coverage, tolerance: f64) -> bool {
    coverage.max_distance <= tolerance
}
