//! `isopatch gallery`: the surfaces that have a name.

use crate::arguments::Gallery;
use crate::failure::{Failure, print};
use isopatch::gallery::{Entry, surfaces};
use isopatch::report;
use std::collections::BTreeMap;
use std::fmt::Write;

/// An entry as JSON.
#[derive(serde::Serialize)]
struct Listed<'a> {
    name: &'a str,
    title: &'a str,
    formula: &'a str,
    constants: BTreeMap<&'a str, f64>,
    /// Smallest and largest coordinates.
    bounds: Option<[[f64; 3]; 2]>,
    faces: usize,
    singular: bool,
    origin: &'a str,
}

impl<'a> From<&'a Entry> for Listed<'a> {
    fn from(entry: &'a Entry) -> Self {
        Self {
            name: entry.name,
            title: &entry.title,
            formula: &entry.formula,
            constants: entry.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect(),
            bounds: entry.bounds.as_ref().map(report::corners),
            faces: entry.faces,
            singular: entry.singular,
            origin: &entry.origin,
        }
    }
}

pub fn run(arguments: &Gallery) -> Result<(), Failure> {
    let text = if arguments.json {
        let listed: Vec<Listed> = surfaces().iter().map(Listed::from).collect();
        serde_json::to_string_pretty(&listed)? + "\n"
    } else {
        table()
    };
    print(&text);
    Ok(())
}

fn table() -> String {
    let width = surfaces().iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for entry in surfaces() {
        let Entry { name, title, formula, faces, origin, .. } = entry;
        let constants: String =
            entry.constants.iter().map(|(name, value)| format!(", {name} = {value}")).collect();
        // Writing to a string does not fail.
        let _ = match entry.singular {
            true => writeln!(text, "{name:width$}  {title}, for isopatch singular. {origin}."),
            false => writeln!(text, "{name:width$}  {title}, {faces} patches. {origin}."),
        };
        let _ = writeln!(text, "{:width$}  {formula}{constants}\n", "");
    }
    text + "Make one with: isopatch fit NAME -o NAME.step\nFind singularities with: isopatch singular NAME\n"
}
