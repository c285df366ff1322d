//! `isopatch fit` of a formula with singularities: flat triangles that conform to them.

use super::{finish_with, formula, style};
use crate::arguments::{FitOptions, Method, Triangulation};
use crate::failure::Failure;
use crate::input::Input;
use crate::outputs;
use crate::progress::Progress;
use crate::summary::counted;
use isopatch::base::Repair;
use isopatch::expand::{Approach, ExpandOptions};
use isopatch::field::Formula;
use isopatch::geom::Aabb;
use isopatch::recipes::singular::{self, FittedSingular, SingularRecipe, fit_with};
use isopatch::report::{self, Report, SCHEMA, Seconds};
use isopatch::singular::SingularSet;

/// What was found in a box, and how long that took.
pub struct Found {
    bounds: Aabb,
    set: SingularSet,
    seconds: Seconds,
}

impl Found {
    /// Is the surface regular in the box?
    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }
}

/// Is it left to isopatch how the surface is made? A spline that is asked for says itself what is wrong with the formula.
pub fn is_free(options: &FitOptions) -> bool {
    let of_spline = options.base.is_some()
        || options.base_method.is_some()
        || options.recipe.is_some()
        || options.effort.is_some();
    matches!(options.method, None | Some(Method::Auto)) && !of_spline
}

/// The singular set of the surface.
pub fn find(
    formula: &Formula,
    input: &Input,
    options: &FitOptions,
    progress: &Progress,
) -> Result<Found, Failure> {
    progress.stage("singular set");
    let mut seconds = Seconds::default();
    let (bounds, set) =
        seconds.measure("singular set", || singular::find(formula, &recipe(input, options)))?;
    Ok(Found { bounds, set, seconds })
}

fn recipe(input: &Input, options: &FitOptions) -> SingularRecipe {
    SingularRecipe {
        bounds: options.bounds.or(input.bounds),
        size: formula::size(input, options),
        expand: expand_options(options),
        ..SingularRecipe::default()
    }
}

fn expand_options(options: &FitOptions) -> Option<ExpandOptions> {
    let approach = match options.triangulate? {
        Triangulation::Conforming => return None,
        Triangulation::Edge => Approach::Edge,
        Triangulation::Vertex => Approach::Vertex,
    };
    Some(ExpandOptions { approach, ..ExpandOptions::default() })
}

/// The triangles of `formula`.
pub fn fit(
    formula: &Formula,
    found: Found,
    input: &Input,
    options: &FitOptions,
    progress: &Progress,
) -> Result<FittedSingular, Failure> {
    let Found { bounds, set, seconds } = found;
    let recipe = recipe(input, options);
    Ok(fit_with(formula, bounds, set, &recipe, seconds, &|stage| progress.stage(stage))?)
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
    let fitted = fit(formula, found, input, options, &progress)?;
    check_tolerance(&fitted, options)?;
    let mut report = describe(text, options, &fitted);
    report.seconds = fitted.seconds.clone();
    report.repairs.extend(left_out(&fitted, options));
    let made = outputs::Conforming {
        mesh: fitted.tessellation(),
        thin: fitted.thin_parts(),
        singular: fitted.set.lines(),
    };
    let unit = options.unit.unwrap_or_default();
    finish_with(options, &mut report, progress, &|outputs| {
        outputs::write_triangles(&made, unit, &options.output, outputs)
    })
}

/// The files that can't hold isolated points and curves without sheets, if there are any.
fn left_out(fitted: &FittedSingular, options: &FitOptions) -> Vec<Repair> {
    let thin = fitted.thin_parts();
    let files = options.output.iter().filter(|file| !outputs::holds_thin_parts(file.format));
    let said = |file: &outputs::OutputFile| Repair {
        what: format!(
            "{} and {} without sheets left out",
            counted(thin.points.len(), "isolated point"),
            counted(thin.curves.len(), "curve")
        ),
        place: file.path.display().to_string(),
        why: "this format holds triangles only; .glb, .obj, .ply and .vtu hold them".into(),
    };
    if thin.is_empty() { Vec::new() } else { files.map(said).collect() }
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
        rational: None,
        singular: Some(fitted.singular_report()),
        repairs: fitted.repairs(),
        seconds: Seconds::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}
