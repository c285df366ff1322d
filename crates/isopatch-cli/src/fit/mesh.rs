//! `isopatch fit` of a mesh: rational A-patches, over triangles or over polygons.

use super::{finish, free, style, write_unmeasured};
use crate::arguments::{FitOptions, FreeValues, Recipe};
use crate::failure::Failure;
use crate::making;
use crate::outputs;
use crate::progress::Progress;
use isopatch::apatch::{APatchOptions, Free};
use isopatch::base::Repair;
use isopatch::inspect::{APatchInspectOptions, APatchInspection, inspect_a_patches, inspect_hybrid};
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::read::read_mesh;
use isopatch::recipes::apatch::{APatchRecipe, FittedMesh};
use isopatch::recipes::hybrid::{self, Fitted, FittedPolygons, HybridRecipe};
use isopatch::recipes::paper_hybrid;
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
    let tell = |stage: &str| progress.stage(stage);
    let fitted = match options.recipe {
        Some(Recipe::Paper) => paper_hybrid::fit(&mesh, &recipe, &tell),
        Some(Recipe::Default) | None => hybrid::fit(&mesh, &recipe, &tell),
    };
    let fitted = fitted.map_err(|source| Failure::APatch { path: path.to_owned(), source })?;
    drop(mesh);
    let Made { surface, figures, repairs, diagonal, seconds: stages } = Made::from(fitted);
    seconds.append(&stages);

    progress.stage("inspection");
    let inspection = seconds.measure("inspection", || {
        // What nobody reads is not measured.
        let options = match (&options.report, options.quiet) {
            (Some(_), _) => APatchInspectOptions::default(),
            (None, false) => APatchInspectOptions::QUICK,
            (None, true) => return None,
        };
        match &surface {
            NativeSurface::APatches(surface) => Some(inspect_a_patches(surface, &options)),
            NativeSurface::Hybrid(surface) => Some(inspect_hybrid(surface, &options)),
            NativeSurface::Spline(_) | NativeSurface::Rational(_) => None,
        }
    });
    let input = path.display().to_string();
    let provenance = making::of_mesh(&input, options, &figures, diagonal)?;
    let model = NativeModel { surface, provenance };
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

/// A surface of A-patches, whatever it is over.
struct Made {
    surface: NativeSurface,
    figures: report::APatchReport,
    repairs: Vec<Repair>,
    /// Of the mesh.
    diagonal: f64,
    seconds: Seconds,
}

impl From<Fitted> for Made {
    fn from(fitted: Fitted) -> Self {
        match fitted {
            Fitted::Triangles(fitted) => {
                let FittedMesh { surface, figures, repairs, seconds } = *fitted;
                let diagonal = surface.function().hull().data().diagonal();
                let surface = NativeSurface::APatches(Box::new(surface));
                Self { surface, figures, repairs, diagonal, seconds }
            }
            Fitted::Polygons(fitted) => {
                let FittedPolygons { surface, figures, repairs, seconds } = *fitted;
                let diagonal = surface.function().hull().data.diagonal();
                let surface = NativeSurface::Hybrid(Box::new(surface));
                Self { surface, figures, repairs, diagonal, seconds }
            }
        }
    }
}

fn recipe(options: &FitOptions) -> Result<HybridRecipe, Failure> {
    let free = match &options.free {
        None => Free::Default,
        Some(FreeValues::All(value)) => Free::Global(*value),
        Some(FreeValues::File(path)) => Free::PerFace(free::read(path)?),
    };
    let triangles = APatchRecipe {
        normals: options.normals.map(Into::into),
        lengths: options.gradient_lengths.map_or_else(Default::default, Into::into),
        crease_angle: options.crease_angle.map(f64::to_radians),
        patches: APatchOptions { free, ..Default::default() },
        ..Default::default()
    };
    Ok(HybridRecipe {
        triangles,
        polygons: options.polygons.map_or_else(Default::default, Into::into),
        triangle_element: options.triangle_element.map_or_else(Default::default, Into::into),
        ..Default::default()
    })
}

/// What is known of a surface of A-patches, however it came to be.
pub fn describe(input: &str, model: &NativeModel, inspection: &APatchInspection) -> Report {
    let common = &inspection.common;
    let continuity = weakest(model.as_surface());
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
        singular: None,
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
