//! `isopatch convert`: a native file to other formats.

use crate::arguments::Convert;
use crate::failure::Failure;
use crate::inspect::read;
use crate::interrupt::Writing;
use crate::outputs::{self, Style};
use isopatch::io::atomic::Outputs;
use std::path::Path;

pub fn run(arguments: &Convert) -> Result<(), Failure> {
    outputs::check(&arguments.output, None)?;
    let model = read(&arguments.input)?;
    let writing = Writing::begin();
    let mut outputs = Outputs::new();
    let style = Style { resolution: arguments.resolution, cells: arguments.cells };
    let result = outputs::write(&model, &arguments.output, &style, &mut outputs);
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    result?;
    let paths: Vec<&Path> = arguments.output.iter().map(|file| file.path.as_path()).collect();
    outputs::commit(outputs, &writing, &paths)?;
    Ok(())
}
