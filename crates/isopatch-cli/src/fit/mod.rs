//! `isopatch fit`: a formula or a mesh to files.

mod algebraic;
mod formula;
mod free;
mod mesh;
mod mesh_spline;
mod method;
mod rational;
mod singular;
mod singular_apatch;

use crate::arguments::{Fit, FitOptions, Method};
use crate::config;
use crate::failure::{Failure, print};
use crate::input::Source;
use crate::interrupt::Writing;
use crate::outputs::{self, Style, Written};
use crate::progress::Progress;
use crate::summary::summary;
use crate::threads;
use isopatch::io::atomic::Outputs;
use isopatch::io::native::NativeModel;
use isopatch::report::Report;
use std::path::Path;

pub use free::FreeError;
pub use mesh::{describe, weakest};
use method::MeshMethod;
pub use rational::describe as describe_rational;

pub fn run(arguments: &Fit) -> Result<(), Failure> {
    let options = match &arguments.config {
        Some(path) => config::complete(&arguments.options, path)?,
        None => arguments.options.clone(),
    };
    let source = Source::new(&arguments.input, &options.set)?;
    method::check(&source, &options)?;
    outputs::check(&options.output, options.report.as_deref())?;
    threads::start(options.threads)?;
    match &source {
        Source::Formula(input) if options.method == Some(Method::Rational) => {
            algebraic::run(&arguments.input, input, &options)
        }
        Source::Formula(input) if options.method == Some(Method::Apatch) => {
            singular_apatch::run(&arguments.input, input, &options)
        }
        Source::Formula(input) => formula::run(&arguments.input, input, &options),
        Source::Mesh(path) => match method::of_mesh(&options) {
            MeshMethod::Spline => mesh_spline::run(path, &options),
            MeshMethod::Rational => rational::run(path, &options),
            MeshMethod::APatches => mesh::run(path, &options),
        },
    }
}

fn style(options: &FitOptions) -> Style {
    Style::new(options.resolution, options.chord, options.cells)
}

/// Does anyone read what is measured on the surface?
fn is_read(options: &FitOptions) -> bool {
    options.report.is_some() || !options.quiet
}

/// Writes the files of a run that nobody wants a word about.
fn write_unmeasured(model: &NativeModel, options: &FitOptions, progress: Progress) -> Result<(), Failure> {
    progress.stage("files");
    outputs::write_all(model, &options.output, &style(options))
}

/// Writes the files and prints the summary.
fn finish(
    model: &NativeModel,
    options: &FitOptions,
    report: &mut Report,
    progress: Progress,
) -> Result<(), Failure> {
    let style = style(options);
    report.repairs.extend(outputs::open_shells(model, &options.output));
    finish_with(options, report, progress, &|outputs| outputs::write(model, &options.output, &style, outputs))
}

/// The same with files that are written by `write_files`.
fn finish_with(
    options: &FitOptions,
    report: &mut Report,
    progress: Progress,
    write_files: &dyn Fn(&mut Outputs) -> Result<(), Failure>,
) -> Result<(), Failure> {
    progress.stage("files");
    let written = write(options, report, write_files)?;
    drop(progress);
    if !options.quiet {
        print(&summary(report, Some(&written)));
    }
    Ok(())
}

/// Writes the files, then the report, which tells how long that took.
fn write(
    options: &FitOptions,
    report: &mut Report,
    write_files: &dyn Fn(&mut Outputs) -> Result<(), Failure>,
) -> Result<Vec<Written>, Failure> {
    let writing = Writing::begin();
    let mut outputs = Outputs::new();
    let mut paths: Vec<&Path> = options.output.iter().map(|file| file.path.as_path()).collect();
    let result = report.seconds.measure("files", || write_files(&mut outputs));
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    result?;
    if let Some(path) = &options.report {
        report.peak_memory_bytes = isopatch::report::peak_memory_bytes();
        let json = report.to_json()?;
        outputs.write(path, |out| Ok(std::io::Write::write_all(out, json.as_bytes())?))?;
        paths.push(path);
    }
    outputs::commit(outputs, &writing, &paths)
}
