//! The command line of isopatch: translates arguments into calls of the library, and results into text and files.

mod arguments;
mod config;
mod convert;
mod failure;
mod fit;
mod gallery;
mod input;
mod inspect;
mod interrupt;
mod making;
mod outputs;
mod progress;
mod render;
mod singular;
mod summary;
mod threads;
mod values;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run() -> Result<(), Failure> {
    let arguments = Arguments::try_parse()?;
    interrupt::install()?;
    match &arguments.command {
        Command::Fit(fit) => fit::run(fit),
        Command::Inspect(inspect) => inspect::run(inspect),
        Command::Convert(convert) => convert::run(convert),
        Command::Singular(singular) => singular::run(singular),
        Command::Render(render) => render::run(render),
        Command::Gallery(gallery) => gallery::run(gallery),
    }
}
