//! `isopatch fit` of a formula with singularities: flat triangles that conform to them.

use super::{finish_with, formula, style};
use crate::arguments::{FitOptions, Method};
use crate::failure::Failure;
use crate::input::Input;
use crate::outputs;
use crate::progress::Progress;
use isopatch::field::Formula;
use isopatch::geom::Aabb;
use isopatch::recipes::singular::{FittedSingular, SingularRecipe, find, fit_with};
use isopatch::report::{self, Report, SCHEMA, Seconds};
use isopatch::singular::SingularSet;

/// What was found in a box, and how long that took.
pub struct Found {
    bounds: Aabb,
    set: SingularSet,
    seconds: Seconds,
}

/// The singular set, if the surface is to conform to it: if there is one, or if --triangulate asks for it.
pub fn look(
    formula: &Formula,
    input: &Input,
    options: &FitOptions,
    progress: &Progress,
) -> Result<Option<Found>, Failure> {
    let is_asked = options.triangulate.is_some();
    let of_spline = options.base.is_some() || options.base_method.is_some() || options.recipe.is_some();
    let is_free = matches!(options.method, None | Some(Method::Auto)) && !of_spline;
    if !is_asked && !is_free {
        return Ok(None);
    }
    progress.stage("singular set");
    let mut seconds = Seconds::default();
    match seconds.measure("singular set", || find(formula, &recipe(input, options))) {
        Ok((bounds, set)) if is_asked || !set.is_empty() => Ok(Some(Found { bounds, set, seconds })),
        Err(error) if is_asked => Err(error.into()),
        // A spline says itself what is wrong with the box or the formula.
        Ok(_) | Err(_) => Ok(None),
    }
}

fn recipe(input: &Input, options: &FitOptions) -> SingularRecipe {
    SingularRecipe {
        bounds: options.bounds.or(input.bounds),
        size: formula::size(input, options),
        ..SingularRecipe::default()
    }
}

/// Makes the triangles of `formula`, which was typed as `text`.
pub fn run(
    text: &str,
    formula: &Formula,
    found: Found,
    input: &Input,
    options: &FitOptions,
    progress: Progress,
) -> Result<(), Failure> {
    outputs::check_triangles(&options.output, &style(options))?;
    let Found { bounds, set, seconds } = found;
    let recipe = recipe(input, options);
    let fitted = fit_with(formula, bounds, set, &recipe, seconds, &|stage| progress.stage(stage))?;
    check_tolerance(&fitted, options)?;
    let mut report = describe(text, options, &fitted);
    report.seconds = fitted.seconds.clone();
    let mesh = fitted.tessellation();
    let unit = options.unit.unwrap_or_default();
    finish_with(options, &mut report, progress, &|outputs| {
        outputs::write_triangles(&mesh, unit, &options.output, outputs)
    })
}

/// Is the measured distance within --tol?
fn check_tolerance(fitted: &FittedSingular, options: &FitOptions) -> Result<(), Failure> {
    let (distance, patches) = (fitted.measured.distance, fitted.triangulated.mesh.triangles.len());
    match options.tol {
        Some(tolerance) if distance > tolerance => Err(Failure::Tolerance { distance, tolerance, patches }),
        _ => Ok(()),
    }
}

fn describe(text: &str, options: &FitOptions, fitted: &FittedSingular) -> Report {
    Report {
        schema: SCHEMA,
        input: text.to_owned(),
        method: Some("triangles".to_owned()),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: options.unit.unwrap_or_default().symbol().to_owned(),
        negated: false,
        diagonal: fitted.measured.diagonal,
        bounds: report::corners(&Aabb::around(&fitted.triangulated.mesh.positions)),
        base: fitted.base_report(),
        surface: fitted.surface_report(),
        spline: None,
        apatch: None,
        singular: Some(fitted.singular_report()),
        repairs: Vec::new(),
        seconds: Seconds::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}
