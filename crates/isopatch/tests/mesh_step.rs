//! The G1 spline through the vertices of a triangle mesh, and STEP files of it.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::inspect::{InspectOptions, inspect};
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::io::step::{StepOptions, write_step};
use isopatch::recipes::mesh_spline::{MeshFitted, MeshSplineRecipe, fit};
use std::fs::File;
use std::io::{BufWriter, Write};
use support::python::{self, Missing, check};
use support::step::{self, Expected};

/// A mesh of the test data.
fn given(name: &str) -> Result<PolygonMesh, Missing> {
    Ok(read_mesh(&python::test_data(&format!("meshes/{name}"))?).unwrap())
}

fn fitted(name: &str) -> Result<MeshFitted, Missing> {
    let mesh = given(name)?;
    Ok(fit(&mesh, &MeshSplineRecipe::default(), &|_| ()).unwrap_or_else(|e| panic!("{name}: {e}")))
}

/// The kernel looks at every edge, at both ends and three points between them.
const KERNEL_OPTIONS: &[&str] = &["--edge-samples", "5"];

/// The STEP file of a closed mesh of one component passes the rule, with seams that are G1 and no folded patch.
fn step_passes(name: &str) -> Result<(), Missing> {
    python::interpreter()?;
    let fitted = fitted(name)?;
    let surface = &fitted.surface;
    let options = InspectOptions { intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect(surface, &surface.base, None, &options);
    assert!(found.seams.max_normal_jump <= 1e-9, "{name}: {found}");
    assert_eq!((found.seams.max_gap, found.interpolation.max_position_error), (0.0, 0.0), "{name}: {found}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{name}.step"));
    let mut out = BufWriter::new(File::create(&path).unwrap());
    write_step(surface, &StepOptions::default(), &mut out).unwrap();
    out.flush().unwrap();
    let expected = Expected {
        solids: 1,
        shells: 1,
        patches: surface.nets.len() as u64,
        seams: found.topology.edges as u64,
        euler: found.topology.euler,
        volume: found.extent.volume,
        kernel_options: KERNEL_OPTIONS,
    };
    step::assert_passes(&path, &expected)
}

#[test]
fn the_step_file_of_the_eight_passes() {
    check("the_step_file_of_the_eight_passes", || step_passes("cgal_eight.off"));
}

#[test]
#[ignore = "minutes of checks"]
fn the_step_file_of_the_bunny_passes() {
    check("the_step_file_of_the_bunny_passes", || step_passes("npm_bunny.off"));
}

#[test]
#[ignore = "minutes of checks"]
fn the_step_file_of_the_knot_passes() {
    check("the_step_file_of_the_knot_passes", || step_passes("cgal_knot1.off"));
}
