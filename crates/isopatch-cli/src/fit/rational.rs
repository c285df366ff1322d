//! `isopatch fit` of a mesh: rational patches through its vertices.

use super::{finish, is_read, weakest, write_unmeasured};
use crate::arguments::{FitOptions, Recipe};
use crate::failure::Failure;
use crate::making;
use crate::progress::Progress;
use isopatch::inspect::{InspectOptions, RationalInspection, inspect_rational};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::read::read_mesh;
use isopatch::rational::RationalSurface;
use isopatch::recipes::paper_rational;
use isopatch::recipes::rational::{self, FittedRational, RationalRecipe};
use isopatch::report::{self, BaseReport, RationalReport, Report, SCHEMA, Seconds, SurfaceReport};
use std::path::Path;

/// Makes the surface of a mesh file.
pub fn run(path: &Path, options: &FitOptions) -> Result<(), Failure> {
    let progress = Progress::new(options.quiet);
    let mut seconds = Seconds::default();
    progress.stage("read");
    let mesh = seconds
        .measure("read", || read_mesh(path))
        .map_err(|source| Failure::InputMesh { path: path.to_owned(), source })?;
    let recipe = RationalRecipe {
        normals: options.normals.map(Into::into),
        crease_angle: options.crease_angle.map(f64::to_radians),
        ..RationalRecipe::default()
    };
    let tell = |stage: &str| progress.stage(stage);
    let fitted = match options.recipe {
        Some(Recipe::Paper) => paper_rational::fit(&mesh, &recipe, &tell),
        Some(Recipe::Default) | None => rational::fit(&mesh, &recipe, &tell),
    };
    let fitted = fitted.map_err(|source| Failure::Rational { path: path.to_owned(), source })?;
    drop(mesh);
    seconds.append(&fitted.seconds);

    let FittedRational { surface, normals, repairs, .. } = fitted;
    let input = path.display().to_string();
    let provenance = making::of_rational_mesh(&input, options, normals.name(), surface.diagonal())?;
    let with = |surface| NativeModel { surface: NativeSurface::Rational(Box::new(surface)), provenance };
    if !is_read(options) {
        return write_unmeasured(&with(surface), options, progress);
    }

    progress.stage("inspection");
    let inspection =
        seconds.measure("inspection", || inspect_rational(&surface, None, &InspectOptions::default()));
    let unit = options.unit.unwrap_or_default();
    let described = describe(&input, unit.symbol(), &surface, &inspection);
    let figures = described
        .rational
        .clone()
        .map(|of| RationalReport { normals: Some(normals.name().to_owned()), ..of });
    let mut report =
        Report { method: Some("rational".to_owned()), rational: figures, repairs, seconds, ..described };
    finish(&with(surface), options, &mut report, progress)
}

/// What is known of a surface of rational patches, however it came to be.
pub fn describe(input: &str, unit: &str, surface: &RationalSurface, found: &RationalInspection) -> Report {
    let common = &found.common;
    let figures = SurfaceReport::new(common, "rational-triangle", weakest(surface));
    // Sheets that cross have sides that alternate, and so no inside.
    let volume = figures.volume.filter(|_| found.crossings == 0);
    Report {
        schema: SCHEMA,
        input: input.to_owned(),
        method: None,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: unit.to_owned(),
        negated: false,
        diagonal: common.diagonal,
        bounds: report::corners(&common.bounds),
        base: BaseReport::new(common),
        surface: SurfaceReport { volume, ..figures },
        spline: None,
        apatch: None,
        rational: Some(RationalReport::new(surface, found)),
        singular: None,
        repairs: Vec::new(),
        seconds: Seconds::default(),
        peak_memory_bytes: report::peak_memory_bytes(),
    }
}
