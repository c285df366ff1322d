//! `isopatch fit` of a mesh: a spline through its vertices.

use super::{finish, is_read, weakest, write_unmeasured};
use crate::arguments::FitOptions;
use crate::failure::Failure;
use crate::making;
use crate::progress::Progress;
use isopatch::inspect::{InspectOptions, Inspection, inspect};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::read::read_mesh;
use isopatch::recipes::mesh_spline::{self, FittedMeshSpline, MeshSplineRecipe};
use isopatch::report::{self, BaseReport, Report, SCHEMA, Seconds, SurfaceReport};
use std::path::Path;

/// Makes the spline through the vertices of a mesh file.
pub fn run(path: &Path, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let mut seconds = Seconds::default();
    progress.stage("read");
    let mesh = seconds
        .measure("read", || read_mesh(path))
        .map_err(|source| Failure::InputMesh { path: path.to_owned(), source })?;
    let recipe = MeshSplineRecipe {
        crease_angle: options.crease_angle.map(f64::to_radians),
        ..MeshSplineRecipe::default()
    };
    let fitted = mesh_spline::fit(&mesh, &recipe, &|stage| progress.stage(stage))
        .map_err(|source| Failure::MeshSpline { path: path.to_owned(), source })?;
    drop(mesh);
    seconds.append(&fitted.seconds);

    let input = path.display().to_string();
    let provenance = making::of_mesh_spline(&input, options, fitted.surface.base.diagonal())?;
    let with = |surface| NativeModel { surface: NativeSurface::Spline(Box::new(surface)), provenance };
    if !is_read(options) {
        return write_unmeasured(&with(fitted.surface), options, progress);
    }

    progress.stage("inspection");
    let surface = &fitted.surface;
    let inspection =
        seconds.measure("inspection", || inspect(surface, &surface.base, None, &InspectOptions::default()));
    let mut report = Report { seconds, ..describe(&input, options, &fitted, &inspection) };
    finish(&with(fitted.surface), options, &mut report, progress)
}

fn describe(input: &str, options: &FitOptions, fitted: &FittedMeshSpline, inspection: &Inspection) -> Report {
    Report {
        schema: SCHEMA,
        input: input.to_owned(),
        method: Some("spline".to_owned()),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: options.unit.unwrap_or_default().symbol().to_owned(),
        negated: false,
        diagonal: inspection.diagonal,
        bounds: report::corners(&inspection.bounds),
        base: BaseReport::new(inspection),
        surface: SurfaceReport::new(inspection, "bezier-triangle-7", weakest(&fitted.surface)),
        spline: None,
        apatch: None,
        singular: None,
        rational: None,
        repairs: fitted.repairs.clone(),
        seconds: Seconds::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}
