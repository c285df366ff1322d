//! Everything that can go wrong, and the exit status that it ends with.

use crate::config::ConfigError;
use crate::fit::FreeError;
use crate::input::InputError;
use isopatch::base::SEARCH_RADII;
use isopatch::io::atomic::OutputError;
use isopatch::io::native::NativeError;
use isopatch::io::read::ReadError;
use isopatch::recipes::Touching;
use isopatch::recipes::algebraic::AlgebraicError;
use isopatch::recipes::apatch::APatchError;
use isopatch::recipes::mesh_spline::MeshSplineError;
use isopatch::recipes::rational::RationalError;
use isopatch::recipes::singular::SingularRecipeError;
use isopatch::recipes::singular_apatch::SingularAPatchError;
use isopatch::recipes::spline::RecipeError;
use isopatch::render::RenderError;
use isopatch::singular::SingularError;
use isopatch::tessellate::TessellateError;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The input can't be handled.
const EXIT_INPUT: u8 = 1;
/// The command line is wrong.
const EXIT_USAGE: u8 = 2;
/// A surface was made, but not to the tolerance.
const EXIT_TOLERANCE: u8 = 3;
/// Ctrl-C.
pub const EXIT_INTERRUPTED: u8 = 130;

/// How far from the origin a surface is looked for.
const SEARCHED: f64 = SEARCH_RADII[0];

/// Why a command ends without its result.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Usage(#[from] clap::Error),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("{} is to be written twice", .0.display())]
    OutputTwice(PathBuf),
    #[error(transparent)]
    Input(#[from] InputError),
    #[error("{0}")]
    Unfit(String),
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    #[error(transparent)]
    Touching(#[from] Touching),
    #[error(transparent)]
    Conforming(#[from] SingularRecipeError),
    #[error(transparent)]
    Singular(#[from] SingularError),
    #[error(transparent)]
    Algebraic(#[from] AlgebraicError),
    #[error(transparent)]
    SingularAPatches(#[from] SingularAPatchError),
    #[error("{}", of_mesh(path, source))]
    InputMesh { path: PathBuf, source: ReadError },
    #[error("{}: {source}", path.display())]
    APatch { path: PathBuf, source: APatchError },
    #[error(transparent)]
    Free(#[from] FreeError),
    #[error("{}: {source}", path.display())]
    MeshSpline { path: PathBuf, source: MeshSplineError },
    #[error("{}: {source}", path.display())]
    Rational { path: PathBuf, source: RationalError },
    #[error("{}: {source}", path.display())]
    Native { path: PathBuf, source: NativeError },
    #[error("--base: {}", of_mesh(path, source))]
    Mesh { path: PathBuf, source: ReadError },
    #[error("{} is a mesh, not an isopatch file: isopatch fit makes a surface of it", .0.display())]
    NotNative(PathBuf),
    #[error(
        "no surface was found: the formula is {} everywhere, up to a distance of {SEARCHED:.0e} from the origin",
        if *.0 { "negative" } else { "positive" }
    )]
    NoSurface(bool),
    #[error("{} names no formula to measure against: give one with --against", .0.display())]
    NoFormula(PathBuf),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Tessellate(#[from] TessellateError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error("the report can't be made: {0}")]
    Report(#[from] serde_json::Error),
    #[error("threads can't be started: {0}")]
    Threads(rayon::ThreadPoolBuildError),
    #[error("Ctrl-C can't be watched for: {0}")]
    Handler(io::Error),
    #[error(
        "the distance is {distance:.2e} of the diagonal with {patches} patches; --tol {tolerance:e} was not reached, and no file is written"
    )]
    Tolerance { distance: f64, tolerance: f64, patches: usize },
    #[error(
        "--chord {0:e} asks for more flat triangles than a file can hold: give a larger one, or --resolution"
    )]
    Chord(f64),
    #[error("interrupted")]
    Interrupted,
}

impl Failure {
    fn status(&self) -> u8 {
        match self {
            // Help and version are no errors.
            Self::Usage(error) => u8::try_from(error.exit_code()).unwrap_or(EXIT_USAGE),
            Self::Config(_)
            | Self::OutputTwice(_)
            | Self::Unfit(_)
            | Self::Free(_)
            | Self::Input(InputError::Constant(_)) => EXIT_USAGE,
            Self::Input(_)
            | Self::Recipe(_)
            | Self::Touching(_)
            | Self::Conforming(_)
            | Self::Singular(_)
            | Self::Algebraic(_)
            | Self::SingularAPatches(_)
            | Self::InputMesh { .. }
            | Self::APatch { .. }
            | Self::MeshSpline { .. }
            | Self::Rational { .. }
            | Self::Native { .. }
            | Self::Mesh { .. }
            | Self::NoFormula(_)
            | Self::NotNative(_)
            | Self::NoSurface(_)
            | Self::Output(_)
            | Self::Tessellate(_)
            | Self::Render(_)
            | Self::Report(_)
            | Self::Threads(..)
            | Self::Chord(_)
            | Self::Handler(_) => EXIT_INPUT,
            Self::Tolerance { .. } => EXIT_TOLERANCE,
            Self::Interrupted => EXIT_INTERRUPTED,
        }
    }

    /// Prints what is wrong on stderr (help on stdout) and returns the exit status.
    pub fn report(&self) -> ExitCode {
        // Nobody can be told that stderr is closed.
        let _ = match self {
            Self::Usage(error) => error.print(),
            Self::Interrupted => writeln!(io::stderr(), "{self}"),
            other => writeln!(io::stderr(), "error: {other}"),
        };
        ExitCode::from(self.status())
    }
}

/// What is wrong with a mesh file, which is named once.
fn of_mesh(path: &Path, source: &ReadError) -> String {
    match source {
        ReadError::File { .. } | ReadError::UnknownEnding { .. } => source.to_string(),
        _ => format!("{}: {source}", path.display()),
    }
}

/// Prints on stdout. A reader that has seen enough, as in `isopatch gallery | head`, is no error.
pub fn print(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}
