//! `isopatch convert`: a native file to other formats.

use crate::arguments::Convert;
use crate::failure::Failure;
use crate::inspect::read;
use crate::outputs::{self, Style};

pub fn run(arguments: &Convert) -> Result<(), Failure> {
    outputs::check(&arguments.output, None)?;
    let model = read(&arguments.input)?;
    if !outputs::has_nets(&model) {
        outputs::check_a_patches(&arguments.output, arguments.cells)?;
    }
    if model.rational().is_some() {
        outputs::check_rational(arguments.cells)?;
    }
    let style = Style::new(arguments.resolution, arguments.chord, arguments.cells);
    outputs::write_all(&model, &arguments.output, &style)
}
