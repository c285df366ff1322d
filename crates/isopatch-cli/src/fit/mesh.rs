//! `isopatch fit` of a mesh: rational A-patches.

use super::{finish, free, style};
use crate::arguments::{FitOptions, FreeValues};
use crate::failure::Failure;
use crate::making;
use crate::outputs;
use crate::progress::Progress;
use isopatch::apatch::{APatchOptions, Free};
use isopatch::inspect::{APatchInspectOptions, APatchInspection, inspect_a_patches};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::read::read_mesh;
use isopatch::recipes::apatch::{self, APatchRecipe, FittedMesh};
use isopatch::report::{self, BaseReport, Report, SCHEMA, Seconds, SurfaceReport};
use isopatch::surface::{Continuity, Seam, Surface};
use std::path::Path;

/// Makes the surface of a mesh file.
pub fn run(path: &Path, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let recipe = recipe(options)?;
    let mut seconds = Seconds::default();
    progress.stage("read");
    let mesh = seconds
        .measure("read", || read_mesh(path))
        .map_err(|source| Failure::InputMesh { path: path.to_owned(), source })?;
    let fitted = apatch::fit(&mesh, &recipe, &|stage| progress.stage(stage))
        .map_err(|source| Failure::APatch { path: path.to_owned(), source })?;
    drop(mesh);
    seconds.append(&fitted.seconds);

    progress.stage("inspection");
    let inspection = seconds.measure("inspection", || {
        // What nobody reads is not measured.
        let options = match (&options.report, options.quiet) {
            (Some(_), _) => APatchInspectOptions::default(),
            (None, false) => APatchInspectOptions::QUICK,
            (None, true) => return None,
        };
        Some(inspect_a_patches(&fitted.surface, &options))
    });
    let input = path.display().to_string();
    let provenance = making::of_mesh(&input, options, &fitted)?;
    let FittedMesh { surface, figures, repairs, .. } = fitted;
    let model = NativeModel { surface: NativeSurface::APatches(Box::new(surface)), provenance };
    let resolution = outputs::intervals(&model, &options.output, &style(options))?;
    let Some(inspection) = inspection else { return write_unmeasured(&model, options, progress) };
    let mut report = Report {
        apatch: Some(report::APatchReport { resolution, ..figures.inspected(&inspection) }),
        repairs,
        method: Some("apatch".to_owned()),
        seconds,
        ..describe(&input, &model, &inspection)
    };
    finish(&model, options, &mut report, progress)
}

/// Writes the files of a run that nobody wants a word about.
fn write_unmeasured(model: &NativeModel, options: &FitOptions, progress: Progress) -> Result<(), Failure> {
    progress.stage("files");
    outputs::write_all(model, &options.output, &style(options))
}

fn recipe(options: &FitOptions) -> Result<APatchRecipe, Failure> {
    let free = match &options.free {
        None => Free::Default,
        Some(FreeValues::All(value)) => Free::Global(*value),
        Some(FreeValues::File(path)) => Free::PerFace(free::read(path)?),
    };
    Ok(APatchRecipe {
        normals: options.normals.map(Into::into),
        lengths: options.gradient_lengths.map_or_else(Default::default, Into::into),
        crease_angle: options.crease_angle.map(f64::to_radians),
        patches: APatchOptions { free, ..Default::default() },
        ..Default::default()
    })
}

/// What is known of a surface of A-patches, however it came to be.
pub fn describe(input: &str, model: &NativeModel, inspection: &APatchInspection) -> Report {
    let common = &inspection.common;
    let continuity = model.a_patches().map_or(Continuity::G0, |surface| weakest(surface));
    Report {
        schema: SCHEMA,
        input: input.to_owned(),
        method: None,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: model.provenance.unit.symbol().to_owned(),
        negated: false,
        diagonal: common.diagonal,
        bounds: report::corners(&common.bounds),
        base: BaseReport::new(common),
        surface: SurfaceReport::new(common, "rational-a-patch", continuity),
        spline: None,
        apatch: None,
        rational: None,
        repairs: Vec::new(),
        seconds: Seconds::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}

/// The weakest continuity of the seams between two patches.
pub fn weakest(surface: &dyn Surface) -> Continuity {
    let between = |seam: &&Seam| seam.second.is_some();
    match surface.seams().iter().filter(between).all(|seam| seam.continuity == Continuity::G1) {
        true => Continuity::G1,
        false => Continuity::G0,
    }
}
