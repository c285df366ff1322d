//! `isopatch inspect`: what a native file is worth.

use crate::arguments::Inspect;
use crate::failure::{Failure, print};
use crate::fit::{describe, describe_rational, weakest};
use crate::input::{Input, is_mesh};
use crate::making;
use crate::summary::summary;
use crate::threads;
use isopatch::base::BaseMesh;
use isopatch::field::{Field, Formula};
use isopatch::geom::{Point3, Vec3};
use isopatch::inspect::{
    APatchInspectOptions, APatchInspection, InspectOptions, inspect, inspect_a_patches, inspect_hybrid,
    inspect_rational,
};
use isopatch::io::native::{NativeModel, NativeSurface, Provenance, read_native};
use isopatch::rational::RationalSurface;
use isopatch::report::{
    self, APatchReport, BaseReport, RationalReport, Report, SCHEMA, Seconds, SurfaceReport,
};
use isopatch::spline::TriangularSpline;
use std::fs::File;
use std::path::Path;

pub fn run(arguments: &Inspect) -> Result<(), Failure> {
    threads::start(None)?;
    let mut seconds = Seconds::default();
    let model = seconds.measure("read", || read(&arguments.file))?;
    let report = match &model.surface {
        NativeSurface::Spline(spline) => of_spline(arguments, spline, &model.provenance, seconds)?,
        NativeSurface::APatches(surface) => of_a_patches(arguments, &model, seconds, |options| {
            let found = inspect_a_patches(surface, options);
            (APatchReport::new(surface.function()), found)
        })?,
        NativeSurface::Hybrid(surface) => of_a_patches(arguments, &model, seconds, |options| {
            let found = inspect_hybrid(surface, options);
            (APatchReport::of_hybrid(surface.function()), found)
        })?,
        NativeSurface::Rational(surface) => of_rational(arguments, surface, &model.provenance, seconds)?,
    };
    let text = if arguments.json { report.to_json()? } else { summary(&report, None) };
    print(&text);
    Ok(())
}

fn of_spline(
    arguments: &Inspect,
    spline: &TriangularSpline,
    provenance: &Provenance,
    mut seconds: Seconds,
) -> Result<Report, Failure> {
    let (formula, region) = match &arguments.against {
        Some(text) => {
            let input = Input::new(text, &arguments.set)?;
            (Some(outward(input.formula, &spline.base)), input.bounds)
        }
        None if making::is_of_mesh(provenance) => (None, None),
        None => match making::formula(provenance) {
            Some(formula) => (Some(formula), None),
            None => return Err(Failure::NoFormula(arguments.file.clone())),
        },
    };
    // Where the surface was cut off, nothing is missing.
    let region = spline.base.clip.as_ref().map(|clip| clip.bounds).or(region);
    let options = InspectOptions { region, ..Default::default() };
    let field = formula.as_ref().map(|formula| formula as &dyn Field);
    let inspection = seconds.measure("inspection", || inspect(spline, &spline.base, field, &options));
    Ok(Report {
        schema: SCHEMA,
        input: arguments.file.display().to_string(),
        method: None,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        unit: provenance.unit.symbol().to_owned(),
        negated: false,
        diagonal: inspection.diagonal,
        bounds: report::corners(&spline.base.bounds()),
        base: BaseReport::new(&inspection),
        surface: SurfaceReport::new(&inspection, "bezier-triangle-7", weakest(spline)),
        spline: None,
        apatch: None,
        singular: None,
        rational: None,
        repairs: Vec::new(),
        seconds,
        peak_memory_bytes: report::peak_memory_bytes(),
    })
}

fn of_a_patches(
    arguments: &Inspect,
    model: &NativeModel,
    mut seconds: Seconds,
    measure: impl FnOnce(&APatchInspectOptions) -> (APatchReport, APatchInspection),
) -> Result<Report, Failure> {
    if arguments.against.is_some() {
        return Err(Failure::Unfit("--against measures splines, not A-patches".into()));
    }
    let (figures, inspection) = seconds.measure("inspection", || measure(&APatchInspectOptions::default()));
    let figures = figures.inspected(&inspection);
    Ok(Report {
        apatch: Some(making::figures(&model.provenance, figures)),
        seconds,
        ..describe(&arguments.file.display().to_string(), model, &inspection)
    })
}

fn of_rational(
    arguments: &Inspect,
    surface: &RationalSurface,
    provenance: &Provenance,
    mut seconds: Seconds,
) -> Result<Report, Failure> {
    let (formula, region) = match &arguments.against {
        Some(text) => {
            let input = Input::new(text, &arguments.set)?;
            (Some(input.formula), input.bounds)
        }
        None if making::is_of_mesh(provenance) => (None, None),
        None => (making::formula(provenance), None),
    };
    let field = formula.as_ref().map(|formula| formula as &dyn Field);
    let options = InspectOptions { region, ..Default::default() };
    let found = seconds.measure("inspection", || inspect_rational(surface, field, &options));
    let input = arguments.file.display().to_string();
    let described = describe_rational(&input, provenance.unit.symbol(), surface, &found);
    let normals = making::normals(provenance);
    let rational = described.rational.clone().map(|of| RationalReport { normals, ..of });
    Ok(Report { rational, seconds, ..described })
}

/// Reads a native file.
pub fn read(path: &Path) -> Result<NativeModel, Failure> {
    if is_mesh(path) {
        return Err(Failure::NotNative(path.to_owned()));
    }
    let fault = |source| Failure::Native { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(|error| fault(error.into()))?;
    read_native(&mut file).map_err(fault)
}

/// The formula or its negative: the one whose gradient points out of the solid at most vertices.
fn outward(formula: Formula, base: &BaseMesh) -> Formula {
    let along = |(p, n): (&Point3, &Vec3)| formula.gradient(*p).1.dot(n) > 0.0;
    let agreeing = base.positions.iter().zip(&base.normals).filter(|vertex| along(*vertex)).count();
    if 2 * agreeing < base.positions.len() { formula.negated() } else { formula }
}
