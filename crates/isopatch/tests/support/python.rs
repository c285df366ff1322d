//! Programs from outside that read a file back and print what they found as JSON.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Why a check cannot run here.
pub type Missing = String;

/// The Python interpreter with the packages of tests/requirements.txt.
pub fn interpreter() -> Result<PathBuf, Missing> {
    let path = std::env::var_os("ISOPATCH_PYTHON").map(PathBuf::from);
    path.filter(|p| p.is_file())
        .ok_or_else(|| "ISOPATCH_PYTHON, a Python with tests/requirements.txt".to_owned())
}

/// A file of the test data that is not in the repository.
pub fn test_data(path: &str) -> Result<PathBuf, Missing> {
    let root = std::env::var_os("ISOPATCH_TEST_DATA").map(PathBuf::from);
    root.map(|r| r.join(path))
        .filter(|p| p.is_file())
        .ok_or_else(|| format!("ISOPATCH_TEST_DATA with {path}"))
}

/// What a script prints about its arguments.
pub fn run(script: &Path, arguments: &[&str]) -> Result<Value, Missing> {
    let output = Command::new(interpreter()?).arg(script).args(arguments).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // OpenCASCADE may print lines of its own before the object.
    let object = stdout.find("{\n").or_else(|| stdout.find('{')).map(|start| &stdout[start..]);
    let parsed = object.and_then(|o| serde_json::from_str(o).ok());
    Ok(parsed.unwrap_or_else(|| panic!("{} printed no JSON:\n{stdout}\n{stderr}", script.display())))
}
