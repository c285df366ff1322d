//! Test data: golden files in the repository, larger ones from `ISOPATCH_TEST_DATA`.
#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

pub mod bodies;
pub mod flat_mesh;
pub mod golden;
pub mod meshes;
pub mod polyhedra;
pub mod python;
pub mod step;

use isopatch::geom::Point3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A golden file of the repository, by its name without ending.
pub fn golden(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The folder of outside test data: `ISOPATCH_TEST_DATA`, or `../shared` beside the repository.
pub fn data_folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    std::env::var_os("ISOPATCH_TEST_DATA").map_or(beside, PathBuf::from)
}

/// A JSON file of the outside test data, if that is there.
pub fn data_file(name: &str) -> Option<Value> {
    let text = std::fs::read_to_string(data_folder().join(name)).ok()?;
    Some(serde_json::from_str(&text).unwrap())
}

/// Reports a test that could not run for want of outside data.
pub fn skip(test: &str) {
    eprintln!("skipped: {test} (needs ISOPATCH_TEST_DATA)");
}

pub fn float(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

pub fn floats(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(float).collect()
}

pub fn point(v: &Value) -> Point3 {
    Point3::new(float(&v[0]), float(&v[1]), float(&v[2]))
}

pub fn points(v: &Value) -> Vec<Point3> {
    v.as_array().unwrap().iter().map(point).collect()
}
