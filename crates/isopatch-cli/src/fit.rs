//! `isopatch fit`: a formula to files.

use crate::arguments::{Fit, FitOptions};
use crate::config;
use crate::failure::{Failure, print};
use crate::input::Input;
use crate::interrupt::Writing;
use crate::making;
use crate::outputs::{self, Style, Written};
use crate::progress::Progress;
use crate::summary::summary;
use isopatch::base::BaseOptions;
use isopatch::inspect::{InspectOptions, Inspection, inspect};
use isopatch::io::atomic::Outputs;
use isopatch::io::native::NativeModel;
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::recipes::spline::{self, Fitted, Size, SplineRecipe};
use isopatch::report::{self, BaseReport, Certified, Report, SCHEMA, SplineReport, SurfaceReport};
use isopatch::surface::Continuity;
use std::path::Path;

pub fn run(arguments: &Fit) -> Result<(), Failure> {
    let options = match &arguments.config {
        Some(path) => config::complete(&arguments.options, path)?,
        None => arguments.options.clone(),
    };
    let input = Input::new(&arguments.input, &options.set)?;
    outputs::check(&options.output, options.report.as_deref())?;
    if let Some(threads) = options.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread();
        pool.build_global().map_err(|error| Failure::Threads(threads, error))?;
    }
    let progress = Progress::new(options.quiet);
    let mut fitted = make(&input, &options, &progress)?;
    progress.stage("inspection");
    let mut seconds = std::mem::take(&mut fitted.seconds);
    let inspection = seconds.measure("inspection", || measure(&fitted));
    check_tolerance(&inspection, &options)?;

    progress.stage("files");
    let mut report = describe(&arguments.input, &options, &fitted, &inspection);
    let provenance = making::provenance(&input, &options, &fitted, inspection.diagonal)?;
    let model = NativeModel { spline: fitted.surface, provenance };
    report.seconds = seconds;
    let written = write(&model, &options, &mut report)?;
    drop(progress);
    if !options.quiet {
        print(&summary(&report, &written));
    }
    Ok(())
}

/// The recipe, with the options of the command line.
fn make(input: &Input, options: &FitOptions, progress: &Progress) -> Result<Fitted, Failure> {
    let formula = match options.level {
        Some(level) => input.formula.minus(level),
        None => input.formula.clone(),
    };
    let recipe = SplineRecipe {
        bounds: options.bounds.or(input.bounds),
        size: size(input, options),
        given: options.base.as_deref().map(read_base).transpose()?,
        base: BaseOptions {
            method: options.base_method.map_or_else(Default::default, Into::into),
            ..Default::default()
        },
        ..Default::default()
    };
    Ok(spline::fit(&formula, &recipe, &|stage| progress.stage(stage))?)
}

fn read_base(path: &Path) -> Result<PolygonMesh, Failure> {
    read_mesh(path).map_err(|source| Failure::Mesh { path: path.to_owned(), source })
}

fn size(input: &Input, options: &FitOptions) -> Size {
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
        repairs: fitted.repairs.clone(),
        seconds: Default::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}

/// Writes the files, then the report, which tells how long that took.
fn write(model: &NativeModel, options: &FitOptions, report: &mut Report) -> Result<Vec<Written>, Failure> {
    let writing = Writing::begin();
    let mut outputs = Outputs::new();
    let style = Style { resolution: options.resolution, cells: options.cells };
    let mut paths: Vec<&Path> = options.output.iter().map(|file| file.path.as_path()).collect();
    let result =
        report.seconds.measure("files", || outputs::write(model, &options.output, &style, &mut outputs));
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    result?;
    if let Some(path) = &options.report {
        let json = report.to_json()?;
        outputs.write(path, |out| Ok(std::io::Write::write_all(out, json.as_bytes())?))?;
        paths.push(path);
    }
    outputs::commit(outputs, &writing, &paths)
}
