//! What a native file keeps about the making of its surface, besides the formula as it was typed.

use crate::arguments::FitOptions;
use crate::failure::Failure;
use crate::input::Input;
use isopatch::field::{Constants, Formula};
use isopatch::geom::Aabb;
use isopatch::io::native::Provenance;
use isopatch::recipes::spline::Fitted;
use isopatch::report::{self, APatchReport};
use serde::{Deserialize, Serialize};

/// The options of a native file.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Making {
    method: String,
    /// Is the source the name of a mesh file, not a formula?
    mesh: bool,
    /// NAME=VALUE, the last for a name counts.
    set: Vec<String>,
    level: Option<f64>,
    negated: bool,
    /// Where the surface was looked for, smallest and largest coordinates.
    r#box: Option<[[f64; 3]; 2]>,
    /// Where normals came from, and how long gradients are.
    normals: Option<String>,
    gradient_lengths: Option<String>,
    /// In degrees.
    crease_angle: Option<f64>,
}

fn provenance(
    making: &Making,
    source: String,
    options: &FitOptions,
    diagonal: f64,
) -> Result<Provenance, Failure> {
    Ok(Provenance {
        options: serde_json::to_string(making)?,
        source,
        unit: options.unit.unwrap_or_default(),
        diagonal,
        ..Default::default()
    })
}

/// What a native file says about a surface that was just made from a formula.
pub fn of_formula(
    input: &Input,
    options: &FitOptions,
    fitted: &Fitted,
    diagonal: f64,
) -> Result<Provenance, Failure> {
    let making = Making {
        method: "spline".to_owned(),
        set: input.assignments.clone(),
        level: options.level,
        negated: fitted.negated,
        r#box: Some(report::corners(&fitted.bounds)),
        ..Making::default()
    };
    provenance(&making, input.formula.text().to_owned(), options, diagonal)
}

/// What a native file says about patches that were just made with a method from a formula with singularities.
pub fn of_patches_of_formula(
    method: &str,
    input: &Input,
    options: &FitOptions,
    bounds: &Aabb,
    diagonal: f64,
) -> Result<Provenance, Failure> {
    let making = Making {
        method: method.to_owned(),
        set: input.assignments.clone(),
        level: options.level,
        r#box: Some(report::corners(bounds)),
        normals: Some("field".to_owned()),
        ..Making::default()
    };
    provenance(&making, input.formula.text().to_owned(), options, diagonal)
}

/// What a native file says about a surface that was just made from the mesh of a file.
pub fn of_mesh(
    input: &str,
    options: &FitOptions,
    figures: &APatchReport,
    diagonal: f64,
) -> Result<Provenance, Failure> {
    let making = Making {
        method: "apatch".to_owned(),
        mesh: true,
        normals: figures.normals.clone(),
        gradient_lengths: figures.gradient_lengths.clone(),
        crease_angle: options.crease_angle,
        ..Making::default()
    };
    provenance(&making, input.to_owned(), options, diagonal)
}

/// What a native file says about a spline that was just made through the vertices of a mesh file.
pub fn of_mesh_spline(input: &str, options: &FitOptions, diagonal: f64) -> Result<Provenance, Failure> {
    let making = Making {
        method: "spline".to_owned(),
        mesh: true,
        crease_angle: options.crease_angle,
        ..Making::default()
    };
    provenance(&making, input.to_owned(), options, diagonal)
}

/// What a native file says about rational patches that were just made through the vertices of a mesh file.
pub fn of_rational_mesh(
    input: &str,
    options: &FitOptions,
    normals: &str,
    diagonal: f64,
) -> Result<Provenance, Failure> {
    let making = Making {
        method: "rational".to_owned(),
        mesh: true,
        normals: Some(normals.to_owned()),
        crease_angle: options.crease_angle,
        ..Making::default()
    };
    provenance(&making, input.to_owned(), options, diagonal)
}

/// Where the normals of rational patches came from, if the file says so.
pub fn normals(provenance: &Provenance) -> Option<String> {
    let making: Making = serde_json::from_str(&provenance.options).unwrap_or_default();
    making.normals
}

/// The figures of A-patches, with what the file says about their making.
pub fn figures(provenance: &Provenance, figures: APatchReport) -> APatchReport {
    let making: Making = serde_json::from_str(&provenance.options).unwrap_or_default();
    APatchReport { normals: making.normals, gradient_lengths: making.gradient_lengths, ..figures }
}

/// Was a native file made from a mesh?
pub fn is_of_mesh(provenance: &Provenance) -> bool {
    serde_json::from_str(&provenance.options).is_ok_and(|making: Making| making.mesh)
}

/// The formula that a native file was made from, negative inside; none if the file names none.
pub fn formula(provenance: &Provenance) -> Option<Formula> {
    let making: Making = serde_json::from_str(&provenance.options).unwrap_or_default();
    let mut constants = Constants::new();
    making.set.iter().try_for_each(|assignment| constants.assign(assignment)).ok()?;
    let formula = Formula::parse(&provenance.source, &constants).ok()?;
    let formula = making.level.map_or_else(|| formula.clone(), |level| formula.minus(level));
    Some(if making.negated { formula.negated() } else { formula })
}
