//! `isopatch fit` of a formula: rational patches, which may have singularities.

use super::{describe_rational, finish, formula};
use crate::arguments::{FitOptions, Recipe};
use crate::failure::Failure;
use crate::input::Input;
use crate::making;
use crate::progress::Progress;
use isopatch::inspect::{InspectOptions, inspect_rational};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::recipes::algebraic::{self, AlgebraicRecipe, FittedAlgebraic};
use isopatch::recipes::paper_rational;
use isopatch::report::{BaseReport, RationalReport, Report};

/// Makes the surface of `input`, which was typed as `text`.
pub fn run(text: &str, input: &Input, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let field = match options.level {
        Some(level) => input.formula.minus(level),
        None => input.formula.clone(),
    };
    let recipe = AlgebraicRecipe {
        bounds: options.bounds.or(input.bounds),
        size: formula::size(input, options),
        ..AlgebraicRecipe::default()
    };
    let tell = |stage: &str| progress.stage(stage);
    let fitted = match options.recipe {
        Some(Recipe::Paper) => paper_rational::fit_formula(&field, &recipe, &tell)?,
        Some(Recipe::Default) | None => algebraic::fit(&field, &recipe, &tell)?,
    };
    progress.stage("inspection");
    let FittedAlgebraic { surface, set, bounds, notes, mut seconds, .. } = fitted;
    let inspect = InspectOptions { region: Some(bounds), ..InspectOptions::default() };
    let found = seconds.measure("inspection", || inspect_rational(&surface, Some(&field), &inspect));
    let unit = options.unit.unwrap_or_default();
    let described = describe_rational(text, unit.symbol(), &surface, &found);
    if let (Some(tolerance), Some(distance)) = (options.tol, described.surface.max_distance)
        && distance > tolerance
    {
        return Err(Failure::Tolerance { distance, tolerance, patches: found.common.patches });
    }
    let normals = Some("field".to_owned());
    let rational = described.rational.clone().map(|of| RationalReport { normals, ..of });
    let base = BaseReport {
        singular_points: set.points.len() + set.special.len(),
        singular_curves: set.curves.len(),
        ..described.base
    };
    let mut report =
        Report { method: Some("rational".to_owned()), base, rational, repairs: notes, seconds, ..described };
    let provenance =
        making::of_patches_of_formula("rational", input, options, &bounds, found.common.diagonal)?;
    let model = NativeModel { surface: NativeSurface::Rational(Box::new(surface)), provenance };
    finish(&model, options, &mut report, progress)
}
