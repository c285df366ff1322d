//! `isopatch fit` of a formula: a spline, or flat triangles where it has singularities.

use super::{algebraic, finish, singular};
use crate::arguments::{FitOptions, Recipe};
use crate::failure::Failure;
use crate::input::Input;
use crate::making;
use crate::progress::Progress;
use isopatch::base::{BaseError, BaseOptions};
use isopatch::field::Formula;
use isopatch::geom::Aabb;
use isopatch::inspect::{InspectOptions, Inspection, inspect};
use isopatch::io::Format;
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::recipes::spline::{self, Fitted, RecipeError, Size, SplineRecipe};
use isopatch::recipes::{Defect, paper_spline, touching};
use isopatch::report::{self, BaseReport, Certified, Report, SCHEMA, SplineReport, SurfaceReport};
use isopatch::surface::Continuity;
use std::path::Path;

/// Makes the surface of `input`, which was typed as `text`.
pub fn run(text: &str, input: &Input, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let formula = match options.level {
        Some(level) => input.formula.minus(level),
        None => input.formula.clone(),
    };
    if options.triangulate.is_some() {
        let found = singular::find(&formula, input, options, &progress)?;
        return singular::run(text, &formula, found, input, options, progress);
    }
    let made = make(&formula, input, options, &progress);
    // A certified topology leaves no place for a singularity. Elsewhere it is looked for, as the spline may have passed it by.
    let is_certain = matches!(&made, Ok(fitted) if fitted.certified_topology);
    if !is_certain
        && singular::is_free(options)
        && let Ok(found) = singular::find(&formula, input, options, &progress)
        && !found.is_empty()
    {
        // Flat triangles can't be STEP; rational patches can.
        if options.output.iter().any(|file| file.format == Format::Step) {
            drop(progress);
            return algebraic::run(text, input, options);
        }
        return singular::run(text, &formula, found, input, options, progress);
    }
    let mut fitted = made?;
    progress.stage("inspection");
    let mut seconds = std::mem::take(&mut fitted.seconds);
    let inspection = seconds.measure("inspection", || measure(&fitted));
    check_tolerance(&inspection, options)?;

    let mut report = describe(text, options, &fitted, &inspection);
    let provenance = making::of_formula(input, options, &fitted, inspection.diagonal)?;
    let model = NativeModel { surface: NativeSurface::Spline(Box::new(fitted.surface)), provenance };
    report.seconds = seconds;
    finish(&model, options, &mut report, progress)
}

/// The recipe, with the options of the command line.
fn make(
    formula: &Formula,
    input: &Input,
    options: &FitOptions,
    progress: &Progress,
) -> Result<Fitted, Failure> {
    let bounds = options.bounds.or(input.bounds);
    if options.recipe == Some(Recipe::Paper) {
        let faces = options.faces.or(input.faces);
        return Ok(paper_spline::fit(formula, bounds, faces, &|stage| progress.stage(stage))?);
    }
    let recipe = SplineRecipe {
        bounds,
        size: size(input, options),
        effort: options.effort.map_or_else(Default::default, Into::into),
        given: options.base.as_deref().map(read_base).transpose()?,
        base: BaseOptions {
            method: options.base_method.map_or_else(Default::default, Into::into),
            ..Default::default()
        },
        ..Default::default()
    };
    spline::fit(formula, &recipe, &|stage| progress.stage(stage))
        .map_err(|error| without_surface(formula, bounds.as_ref(), error))
}

/// Has the formula no surface at all, where the recipe says something else?
fn without_surface(formula: &Formula, bounds: Option<&Aabb>, error: RecipeError) -> Failure {
    let near = match &error {
        RecipeError::Base(BaseError::Singular { at }) | RecipeError::Defect(Defect::Kink { at, .. }) => {
            Some(*at)
        }
        RecipeError::Base(BaseError::Unbounded | BaseError::UnresolvedCells { .. }) => None,
        RecipeError::Base(BaseError::NoSurface { negative, proven: true }) if bounds.is_none() => {
            return Failure::NoSurface(*negative);
        }
        // A box that was found.
        RecipeError::Base(BaseError::FlatBox { .. }) if bounds.is_none() => None,
        _ => return error.into(),
    };
    touching(formula, bounds, near).map_or_else(|| error.into(), Into::into)
}

fn read_base(path: &Path) -> Result<PolygonMesh, Failure> {
    read_mesh(path).map_err(|source| Failure::Mesh { path: path.to_owned(), source })
}

pub(super) fn size(input: &Input, options: &FitOptions) -> Size {
    match (options.faces, options.tol, input.faces) {
        (Some(faces), ..) => Size::Faces(faces),
        (None, Some(tolerance), _) => Size::Tolerance(tolerance),
        (None, None, Some(faces)) => Size::Faces(faces),
        (None, None, None) => Size::Automatic,
    }
}

/// Measures the surface where the formula was looked at.
fn measure(fitted: &Fitted) -> Inspection {
    let options =
        InspectOptions { region: Some(fitted.bounds), coverage: fitted.coverage, ..Default::default() };
    inspect(&fitted.surface, &fitted.surface.base, Some(&fitted.formula), &options)
}

/// Is the larger of the two measured distances within --tol?
fn check_tolerance(inspection: &Inspection, options: &FitOptions) -> Result<(), Failure> {
    let there = inspection.deviation.as_ref().map_or(f64::INFINITY, |d| d.max_distance);
    let back = inspection.coverage.map_or(0.0, |c| c.max_distance);
    let distance = there.max(back);
    match options.tol {
        Some(tolerance) if distance > tolerance => {
            Err(Failure::Tolerance { distance, tolerance, patches: inspection.patches })
        }
        _ => Ok(()),
    }
}

fn describe(input: &str, options: &FitOptions, fitted: &Fitted, inspection: &Inspection) -> Report {
    let deviation = inspection.deviation.as_ref();
    Report {
        schema: SCHEMA,
        input: input.to_owned(),
        method: Some("spline".to_owned()),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: options.unit.unwrap_or_default().symbol().to_owned(),
        negated: fitted.negated,
        diagonal: inspection.diagonal,
        bounds: report::corners(&fitted.surface.base.bounds()),
        base: BaseReport::new(inspection),
        surface: SurfaceReport {
            certified: Certified { topology: fitted.certified_topology, distance: None },
            ..SurfaceReport::new(inspection, "bezier-triangle-7", Continuity::G1)
        },
        spline: Some(SplineReport {
            folded: deviation.map_or(0, |d| d.folded),
            faces_over_20deg: deviation.map_or(0, |d| d.over_limit),
            ..fitted.figures
        }),
        apatch: None,
        singular: None,
        rational: None,
        repairs: fitted.repairs.clone(),
        seconds: Default::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}
