//! `isopatch fit` of a formula with singularities: A-patches.

use super::{describe, finish, singular, style};
use crate::arguments::FitOptions;
use crate::failure::Failure;
use crate::input::Input;
use crate::making;
use crate::outputs;
use crate::progress::Progress;
use isopatch::hull::HullOptions;
use isopatch::inspect::{APatchInspectOptions, inspect_a_patches};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::recipes::singular_apatch::{SingularAPatches, over_conforming};
use isopatch::report::{APatchReport, Report};

/// Makes the surface of `input`, which was typed as `text`.
pub fn run(text: &str, input: &Input, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let formula = match options.level {
        Some(level) => input.formula.minus(level),
        None => input.formula.clone(),
    };
    let found = singular::find(&formula, input, options, &progress)?;
    if found.is_empty() {
        return Err(Failure::Unfit(
            "--method apatch takes a mesh, or a formula with singular points; this surface has none in the box: --method spline"
                .into(),
        ));
    }
    let fitted = singular::fit(&formula, found, input, options, &progress)?;
    let whole = &fitted.triangulated.mesh;
    let made = over_conforming(&formula, whole, &HullOptions::default(), &Default::default(), &|stage| {
        progress.stage(stage);
    })?;
    let SingularAPatches { surface, figures, repairs, seconds: stages, .. } = made;
    progress.stage("inspection");
    let mut seconds = fitted.seconds.clone();
    seconds.append(&stages);
    let inspection =
        seconds.measure("inspection", || inspect_a_patches(&surface, &APatchInspectOptions::default()));
    let provenance =
        making::of_patches_of_formula("apatch", input, options, &fitted.bounds, inspection.common.diagonal)?;
    let model = NativeModel { surface: NativeSurface::APatches(Box::new(surface)), provenance };
    let resolution = outputs::intervals(&model, &options.output, &style(options))?;
    let mut report = Report {
        apatch: Some(APatchReport { resolution, ..figures.inspected(&inspection) }),
        singular: Some(fitted.singular_report()),
        repairs,
        method: Some("apatch".to_owned()),
        seconds,
        ..describe(text, &model, &inspection)
    };
    finish(&model, options, &mut report, progress)
}
