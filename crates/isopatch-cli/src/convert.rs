//! `isopatch convert`: a native file to other formats.

use crate::arguments::Convert;
use crate::failure::Failure;
use crate::inspect::read;
use crate::making;
use crate::outputs::{self, Style};
use crate::threads;
use isopatch::base::Repair;
use isopatch::io::Format;
use isopatch::io::native::NativeModel;
use std::io::{Write, stderr};

pub fn run(arguments: &Convert) -> Result<(), Failure> {
    threads::start(None)?;
    outputs::check(&arguments.output, None)?;
    let mut model = read(&arguments.input)?;
    if !outputs::has_nets(&model) {
        check_no_step(&model, arguments)?;
        outputs::check_a_patches(&arguments.output, arguments.cells)?;
    }
    if model.rational().is_some() {
        outputs::check_rational(arguments.cells)?;
    }
    model.provenance.unit = arguments.unit.unwrap_or(model.provenance.unit);
    let style = Style::new(arguments.resolution, arguments.chord, arguments.cells);
    outputs::write_all(&model, &arguments.output, &style)?;
    if let Some(Repair { what, place, why }) = outputs::open_shells(&model, &arguments.output) {
        // Nobody can be told that stderr is closed.
        let _ = writeln!(stderr(), "warning: {place}: {what}: {why}");
    }
    Ok(())
}

/// A-patches can't be written as STEP: what can be, from the same source?
fn check_no_step(model: &NativeModel, arguments: &Convert) -> Result<(), Failure> {
    let Some(file) = arguments.output.iter().find(|file| file.format == Format::Step) else { return Ok(()) };
    let (path, source) = (file.path.display(), &model.provenance.source);
    let way_out = match making::is_of_mesh(&model.provenance) {
        true => format!("isopatch fit {source:?} -o {path} makes a spline from the same mesh"),
        false => format!("isopatch fit {source:?} --method rational -o {path} makes what it can hold"),
    };
    Err(Failure::Unfit(format!("{path}: a STEP file can't hold A-patches; {way_out}")))
}
