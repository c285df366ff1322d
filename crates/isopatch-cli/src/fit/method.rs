//! Which method an input and its outputs ask for, and which options go with it.

use crate::arguments::{FitOptions, Method};
use crate::failure::Failure;
use crate::input::Source;
use crate::outputs;
use isopatch::io::Format;

/// Is there a method for the input and the outputs, and has every option a meaning for it?
pub fn check(source: &Source, options: &FitOptions) -> Result<(), Failure> {
    match source {
        Source::Formula(_) => check_formula(options),
        Source::Mesh(_) => check_mesh(options),
    }
}

fn check_formula(options: &FitOptions) -> Result<(), Failure> {
    if options.method == Some(Method::Apatch) {
        refuse(&of_bases(options), "for splines, not for A-patches")?;
        refuse(&[of_recipes(options)], "for splines and rational patches, not for A-patches")?;
        refuse(&[("--triangulate", options.triangulate.is_some())], "for flat triangles, not for A-patches")?;
        if let Some(file) = options.output.iter().find(|file| file.format == Format::Step) {
            return Err(Failure::Unfit(format!(
                "{}: a STEP file can't hold A-patches; --method rational makes what it can hold",
                file.path.display()
            )));
        }
        outputs::check_a_patches(&options.output, options.cells)?;
    }
    if options.triangulate.is_some() {
        if options.method == Some(Method::Spline) {
            return Err(Failure::Unfit(
                "--triangulate makes flat triangles, --method spline a spline".into(),
            ));
        }
        refuse(&of_bases(options), "for a spline, not for --triangulate")?;
        refuse(&[of_recipes(options)], "for patches, not for --triangulate")?;
    }
    if options.method == Some(Method::Rational) {
        refuse(&of_bases(options), "for splines, not for rational patches")?;
        outputs::check_rational(options.cells)?;
    }
    refuse(&of_meshes(options), "for meshes, not for a formula")
}

fn check_mesh(options: &FitOptions) -> Result<(), Failure> {
    let step = options.output.iter().find(|file| file.format == Format::Step);
    match (options.method.unwrap_or(Method::Auto), step) {
        (Method::Auto | Method::Apatch, None) => {
            refuse(&of_formulas(options), "for formulas, not for a mesh")?;
            outputs::check_a_patches(&options.output, options.cells)
        }
        (Method::Apatch, Some(file)) => Err(Failure::Unfit(format!(
            "{}: a STEP file can't hold A-patches; --method spline and --method auto make what it can hold",
            file.path.display()
        ))),
        (Method::Rational, _) => {
            refuse(&of_formulas(options), "for formulas, not for a mesh")?;
            refuse(&only_of_a_patches(options), "for A-patches; rational patches have no such thing")?;
            outputs::check_rational(options.cells)
        }
        (Method::Auto | Method::Spline, _) => {
            refuse(&of_formulas(options), "for formulas, not for a mesh")?;
            refuse(
                &[of_recipes(options)],
                "for A-patches and rational patches; over a mesh, no paper makes a spline",
            )?;
            refuse(&of_a_patches(options), "for A-patches; a STEP file and --method spline take a spline")
        }
    }
}

/// What a mesh is to become.
pub fn of_mesh(options: &FitOptions) -> MeshMethod {
    let step = options.output.iter().any(|file| file.format == Format::Step);
    match options.method {
        Some(Method::Rational) => MeshMethod::Rational,
        Some(Method::Spline) => MeshMethod::Spline,
        _ if step => MeshMethod::Spline,
        _ => MeshMethod::APatches,
    }
}

/// A surface through the vertices of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshMethod {
    Spline,
    Rational,
    APatches,
}

type Given = (&'static str, bool);

/// The options that only a mesh takes.
fn of_meshes(options: &FitOptions) -> [Given; 6] {
    [
        ("--normals", options.normals.is_some()),
        ("--gradient-lengths", options.gradient_lengths.is_some()),
        ("--crease-angle", options.crease_angle.is_some()),
        ("--free", options.free.is_some()),
        ("--polygons", options.polygons.is_some()),
        ("--triangle-element", options.triangle_element.is_some()),
    ]
}

/// The options that only a spline of a formula takes.
fn of_bases(options: &FitOptions) -> [Given; 3] {
    [
        ("--effort", options.effort.is_some()),
        ("--base", options.base.is_some()),
        ("--base-method", options.base_method.is_some()),
    ]
}

fn of_recipes(options: &FitOptions) -> Given {
    ("--recipe", options.recipe.is_some())
}

/// The options that only A-patches take.
fn of_a_patches(options: &FitOptions) -> [Given; 5] {
    [
        ("--normals", options.normals.is_some()),
        ("--gradient-lengths", options.gradient_lengths.is_some()),
        ("--free", options.free.is_some()),
        ("--polygons", options.polygons.is_some()),
        ("--triangle-element", options.triangle_element.is_some()),
    ]
}

/// Those of them that rational patches do not take.
fn only_of_a_patches(options: &FitOptions) -> [Given; 4] {
    let [_, others @ ..] = of_a_patches(options);
    others
}

/// The options that only a formula takes.
fn of_formulas(options: &FitOptions) -> [Given; 9] {
    [
        ("--box", options.bounds.is_some()),
        ("--level", options.level.is_some()),
        ("--faces", options.faces.is_some()),
        ("--tol", options.tol.is_some()),
        ("--effort", options.effort.is_some()),
        ("--set", !options.set.is_empty()),
        ("--base", options.base.is_some()),
        ("--base-method", options.base_method.is_some()),
        ("--triangulate", options.triangulate.is_some()),
    ]
}

fn refuse(options: &[Given], what_for: &str) -> Result<(), Failure> {
    match options.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Failure::Unfit(format!("{name} is {what_for}"))),
        None => Ok(()),
    }
}
