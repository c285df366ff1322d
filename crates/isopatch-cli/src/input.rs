//! What a surface is made from: a formula, or a gallery surface with its own box, constants and number of patches.

use isopatch::field::{ConstantError, Constants, Formula, FormulaError};
use isopatch::gallery::{self, Entry};
use isopatch::geom::Aabb;
use std::path::{Path, PathBuf};

/// What a surface is made from.
pub enum Source {
    /// A formula or a gallery surface.
    Formula(Box<Input>),
    /// A mesh file.
    Mesh(PathBuf),
}

impl Source {
    /// The mesh file, gallery surface or formula of that text.
    pub fn new(text: &str, assignments: &[String]) -> Result<Self, InputError> {
        let path = Path::new(text);
        match is_mesh(path) && gallery::surface(text).is_none() {
            true => Ok(Self::Mesh(path.to_owned())),
            false => Ok(Self::Formula(Box::new(Input::new(text, assignments)?))),
        }
    }
}

/// A formula with what is known about it.
pub struct Input {
    /// The formula, its level not yet subtracted.
    pub formula: Formula,
    /// A box that holds the surface.
    pub bounds: Option<Aabb>,
    /// How many patches the surface looks good with.
    pub faces: Option<usize>,
    /// The constants, as NAME=VALUE; the last for a name counts.
    pub assignments: Vec<String>,
}

/// Why an input is none.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    #[error("in the formula, {0}")]
    Formula(#[from] FormulaError),
    #[error(transparent)]
    Constant(#[from] ConstantError),
    #[error("there is no surface \"{name}\"; did you mean \"{suggestion}\"? (isopatch gallery lists them)")]
    UnknownSurface { name: String, suggestion: &'static str },
    #[error(
        "\"{name}\" is no surface of the gallery (isopatch gallery lists them), and as a formula: {source}"
    )]
    NeitherNameNorFormula { name: String, source: FormulaError },
    #[error(
        "{0} is a finished surface: \"isopatch inspect\" measures it, \"isopatch convert\" writes it in other formats"
    )]
    NativeFile(String),
    #[error("{0} is a mesh: --against takes a formula, or a gallery name")]
    MeshFile(String),
    #[error(
        "{0} is no formula, and no such file is there (fit takes a formula, a gallery name, or a mesh: .obj .off .ply .stl)"
    )]
    NoSuchFile(String),
    #[error("{0} is a file: fit takes a formula, a gallery name, or a mesh (.obj .off .ply .stl)")]
    OtherFile(String),
}

/// Endings of meshes that can be read.
const MESH_ENDINGS: [&str; 4] = ["obj", "off", "ply", "stl"];

impl Input {
    /// The input of that name or formula. `assignments` are NAME=VALUE; the last for a name wins, and all of them over
    /// the gallery's own.
    pub fn new(text: &str, assignments: &[String]) -> Result<Self, InputError> {
        if let Some(entry) = gallery::surface(text) {
            return Self::from_gallery(entry, assignments);
        }
        match Formula::parse(text, &constants(assignments)?) {
            Ok(formula) => Ok(Self { formula, bounds: None, faces: None, assignments: assignments.to_vec() }),
            Err(error) => Err(explain(text, error)),
        }
    }

    fn from_gallery(entry: &Entry, assignments: &[String]) -> Result<Self, InputError> {
        let own = entry.constants.iter().map(|(name, value)| format!("{name}={value}"));
        let assignments: Vec<String> = own.chain(assignments.iter().cloned()).collect();
        Ok(Self {
            formula: Formula::parse(&entry.formula, &constants(&assignments)?)?,
            bounds: entry.bounds,
            faces: Some(entry.faces),
            assignments,
        })
    }
}

fn constants(assignments: &[String]) -> Result<Constants, ConstantError> {
    let mut constants = Constants::new();
    assignments.iter().try_for_each(|assignment| constants.assign(assignment))?;
    Ok(constants)
}

/// The ending of a file name, in lower case.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Does the ending of the name tell that of a mesh?
pub fn is_mesh(path: &Path) -> bool {
    MESH_ENDINGS.contains(&ending(path).as_str())
}

/// What a text that is no formula may be instead.
fn explain(text: &str, error: FormulaError) -> InputError {
    let path = Path::new(text);
    let name = text.trim().to_owned();
    if ending(path) == "isopatch" {
        InputError::NativeFile(name)
    } else if is_mesh(path) {
        InputError::MeshFile(name)
    } else if path.is_file() {
        InputError::OtherFile(name)
    } else if is_file_name(&name) {
        InputError::NoSuchFile(name)
    } else if !is_word(&name) {
        InputError::Formula(error)
    } else if let Some(suggestion) = similar(&name) {
        InputError::UnknownSurface { name, suggestion }
    } else {
        InputError::NeitherNameNorFormula { name, source: error }
    }
}

/// Does it look like a file name: letters and no operators, and an ending that begins with a letter?
fn is_file_name(text: &str) -> bool {
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '/' | '\\');
    text.chars().all(is_plain) && ending(Path::new(text)).starts_with(char::is_alphabetic)
}

/// Could it be meant as a name?
fn is_word(text: &str) -> bool {
    text.starts_with(char::is_alphabetic)
        && text.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' '))
}

/// The gallery's name for which `name` may be a slip: a third of its letters may differ.
fn similar(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    gallery::surfaces()
        .iter()
        .map(|entry| (strsim::damerau_levenshtein(&name, entry.name), entry.name))
        .filter(|(distance, known)| 3 * distance <= known.len())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, known)| known)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Input::new(text, &[]).err().map(|e| e.to_string()).unwrap_or_default()
    }

    #[test]
    fn every_gallery_surface_is_an_input() {
        for entry in gallery::surfaces() {
            let input = Input::new(entry.name, &[]).unwrap_or_else(|e| panic!("{}: {e}", entry.name));
            assert_eq!((input.bounds, input.faces), (entry.bounds, Some(entry.faces)));
        }
    }

    #[test]
    fn constants_of_the_gallery_can_be_replaced() {
        assert!(Input::new("chair", &["a=0.9".into(), "a=1".into()]).is_ok());
        assert!(message("x^2+b").contains("\"b\""));
        assert!(Input::new("x^2+b", &["b=-1".into()]).is_ok());
    }

    #[test]
    fn slips_get_a_suggestion() {
        for (slip, meant) in [("decocub", "decocube"), ("Sphere", "sphere"), ("tours", "torus")] {
            let message = message(slip);
            assert!(message.contains(&format!("did you mean \"{meant}\"")), "{message}");
        }
        assert!(message("elephant").contains("isopatch gallery"));
    }

    #[test]
    fn files_are_told_where_they_belong() {
        assert!(message("a/part.isopatch").contains("isopatch convert"));
        assert!(message("hand.OFF").contains("is a mesh"));
        assert!(matches!(Source::new("a b/hand.OFF", &[]), Ok(Source::Mesh(_))));
        assert!(matches!(Source::new("x^2+y^2+z^2-1", &[]), Ok(Source::Formula(_))));
        assert!(message("part.dwg").contains("no such file"));
        assert!(message("2.5x+w").contains("unknown name \"w\""));
        assert!(message(file!().rsplit_once('/').map_or("", |_| "Cargo.toml")).contains("is a file"));
    }
}
