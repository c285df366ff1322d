//! Options from a TOML file. The file's keys are the long names of the options of `fit`, and its values are read as
//! if they had been typed: one set of rules, and the same messages.

use crate::arguments::FitOptions;
use crate::failure::Failure;
use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Why a file of options can't be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ConfigError {
    path: PathBuf,
    problem: Problem,
}

#[derive(Debug, thiserror::Error)]
enum Problem {
    #[error(transparent)]
    Read(#[from] std::io::Error),
    #[error("{0}")]
    Toml(#[from] toml::de::Error),
    #[error("unknown key \"{key}\"; the keys are {known}")]
    UnknownKey { key: String, known: String },
    #[error("\"{key}\" can't be {found}")]
    WrongType { key: String, found: &'static str },
    #[error("{0}")]
    Value(String),
}

/// The options alone, as a command line without a program name.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true, disable_version_flag = true)]
struct ConfigLine {
    #[command(flatten)]
    options: FitOptions,
}

/// The options of `typed`, and those of the file where `typed` has none.
pub fn complete(typed: &FitOptions, path: &Path) -> Result<FitOptions, Failure> {
    let read = || -> Result<FitOptions, Problem> { parse(&std::fs::read_to_string(path)?) };
    let filed = read().map_err(|problem| ConfigError { path: path.to_owned(), problem })?;
    Ok(merge(typed.clone(), filed))
}

fn parse(text: &str) -> Result<FitOptions, Problem> {
    let table: Table = toml::from_str(text)?;
    let mut line = Vec::new();
    for (key, value) in &table {
        check_key(key)?;
        type_option(key, value, &mut line)?;
    }
    let parsed = ConfigLine::try_parse_from(line).map_err(|error| Problem::Value(first_paragraph(&error)))?;
    Ok(parsed.options)
}

fn check_key(key: &str) -> Result<(), Problem> {
    let command = ConfigLine::command();
    let known: Vec<&str> = command.get_arguments().filter_map(|argument| argument.get_long()).collect();
    if known.contains(&key) {
        return Ok(());
    }
    Err(Problem::UnknownKey { key: key.to_owned(), known: known.join(", ") })
}

/// Appends `--key=value` as often as the value needs.
fn type_option(key: &str, value: &Value, line: &mut Vec<OsString>) -> Result<(), Problem> {
    let wrong = |found| Problem::WrongType { key: key.to_owned(), found };
    let scalar = |value: &Value| match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        other => Err(wrong(other.type_str())),
    };
    let mut push = |text: String| line.push(format!("--{key}={text}").into());
    match value {
        Value::Boolean(true) if key == "quiet" => line.push("--quiet".into()),
        Value::Boolean(false) if key == "quiet" => {}
        Value::Table(table) if key == "set" => {
            for (name, value) in table {
                push(format!("{name}={}", scalar(value)?));
            }
        }
        Value::Array(array) if key == "box" => {
            push(array.iter().map(scalar).collect::<Result<Vec<_>, _>>()?.join(","));
        }
        Value::Array(array) if key == "output" || key == "set" => {
            for value in array {
                push(scalar(value)?);
            }
        }
        value => push(scalar(value)?),
    }
    Ok(())
}

/// What is wrong, without the usage that follows it.
fn first_paragraph(error: &clap::Error) -> String {
    let text = error.to_string();
    let paragraph = text.split("\n\n").next().unwrap_or_default();
    paragraph.trim_start_matches("error: ").trim().to_owned()
}

/// `typed` where it says something, else `filed`. Of --faces, --tol and --base, one that is typed replaces all filed.
fn merge(typed: FitOptions, filed: FitOptions) -> FitOptions {
    let sized = typed.faces.is_some() || typed.tol.is_some() || typed.base.is_some();
    let (faces, tol, base) =
        if sized { (typed.faces, typed.tol, typed.base) } else { (filed.faces, filed.tol, filed.base) };
    let (resolution, chord) = match (typed.resolution, typed.chord) {
        (None, None) => (filed.resolution, filed.chord),
        typed => typed,
    };
    FitOptions {
        output: if typed.output.is_empty() { filed.output } else { typed.output },
        method: typed.method.or(filed.method),
        bounds: typed.bounds.or(filed.bounds),
        level: typed.level.or(filed.level),
        faces,
        tol,
        // Typed values come last, so they win for the names that both set.
        set: [filed.set, typed.set].concat(),
        base,
        effort: typed.effort.or(filed.effort),
        base_method: typed.base_method.or(filed.base_method),
        triangulate: typed.triangulate.or(filed.triangulate),
        recipe: typed.recipe.or(filed.recipe),
        normals: typed.normals.or(filed.normals),
        gradient_lengths: typed.gradient_lengths.or(filed.gradient_lengths),
        crease_angle: typed.crease_angle.or(filed.crease_angle),
        free: typed.free.or(filed.free),
        polygons: typed.polygons.or(filed.polygons),
        triangle_element: typed.triangle_element.or(filed.triangle_element),
        resolution,
        chord,
        cells: typed.cells.or(filed.cells),
        unit: typed.unit.or(filed.unit),
        report: typed.report.or(filed.report),
        quiet: typed.quiet || filed.quiet,
        threads: typed.threads.or(filed.threads),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{FreeValues, Lengths, MeshMethod, Normals};

    #[test]
    fn every_option_can_be_filed() {
        let text = r#"
            output = ["a.step", "b.vtu"]
            method = "spline"
            box = [-1, 1.5, -1, 1, -1, 1]
            level = -0.5
            faces = 600
            base-method = "qem"
            normals = "angle"
            gradient-lengths = "recovered"
            crease-angle = 30
            free = 2.5
            resolution = 4
            cells = "lagrange"
            unit = "cm"
            report = "r.json"
            quiet = true
            threads = 2
            [set]
            a = 0.25
        "#;
        let options = parse(text).unwrap();
        assert_eq!(options.output.len(), 2);
        assert_eq!(options.bounds.map(|b| b.max.x), Some(1.5));
        assert_eq!((options.level, options.faces, options.threads), (Some(-0.5), Some(600), Some(2)));
        assert_eq!(options.base_method, Some(MeshMethod::Qem));
        assert_eq!((options.normals, options.crease_angle), (Some(Normals::Angle), Some(30.0)));
        assert_eq!(options.gradient_lengths, Some(Lengths::Recovered));
        assert_eq!(options.free, Some(FreeValues::All(2.5)));
        assert_eq!(options.set, ["a=0.25"]);
        assert!(options.quiet);
    }

    #[test]
    fn a_typed_chord_replaces_a_filed_resolution() {
        let (typed, filed) = (parse("chord = 1e-4").unwrap(), parse("resolution = 4").unwrap());
        let merged = merge(typed, filed);
        assert_eq!((merged.chord, merged.resolution), (Some(1e-4), None));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let problem = |text: &str| parse(text).unwrap_err().to_string();
        assert!(problem("colour = 1").starts_with("unknown key \"colour\""));
        assert!(problem("input = 'x'").starts_with("unknown key \"input\""));
        assert!(problem("faces = 0").contains("'0'"));
        assert!(problem("faces = true").starts_with("\"faces\" can't be boolean"));
        assert!(problem("tol = nan").contains("not finite"));
        assert!(problem("box = [1, -1, 0, 1, 0, 1]").contains("reversed"));
        assert!(problem("faces = 60\ntol = 0.1").contains("--tol"));
        assert!(problem("faces =").contains("faces"));
    }

    #[test]
    fn what_is_typed_wins() {
        let filed = parse("faces = 600\nlevel = 1\noutput = ['a.step']\nset = { a = 1 }").unwrap();
        let typed = parse("tol = 1e-3\nlevel = 2\nset = { a = 2 }").unwrap();
        let merged = merge(typed, filed);
        assert_eq!((merged.faces, merged.tol, merged.level), (None, Some(1e-3), Some(2.0)));
        assert_eq!(merged.set, ["a=1", "a=2"]);
        assert_eq!(merged.output.len(), 1);
    }
}
