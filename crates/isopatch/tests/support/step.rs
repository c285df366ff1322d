//! The pass rule for STEP files: what OpenCASCADE and a reader of the text must find in a file.
#![allow(clippy::unwrap_used, clippy::panic)] // A file that breaks the rule has to stop the test.

use super::python::{self, Missing};
use serde_json::Value;
use std::path::Path;

/// What a file holds, and how finely it is looked at.
pub struct Expected {
    pub solids: u64,
    pub shells: u64,
    /// Bézier triangles, each of which becomes three faces.
    pub patches: u64,
    /// Edges of the base mesh, each of which becomes two, beside the three inside each patch.
    pub seams: u64,
    /// Vertices − edges + faces.
    pub euler: i64,
    pub volume: f64,
    /// Options of the kernel's check.
    pub kernel_options: &'static [&'static str],
}

/// Valid, one solid for each component, no free edge, no message, tolerance 1e-7, gap ≤ 1e-9, strict.
pub fn assert_passes(path: &Path, expected: &Expected) -> Result<(), Missing> {
    let (kernel, text) =
        (python::test_data("tools/check_step.py")?, python::test_data("tools/check_step_text.py")?);
    let path = path.to_str().unwrap();
    let kernel = python::run(&kernel, &[&[path], expected.kernel_options].concat())?;
    let text = python::run(&text, &[path])?;
    println!(
        "{path}: {} bytes, kernel {} s, text {} s, {} edges of {}, gap {:.1e}, jump {:.1e} deg",
        kernel["bytes"],
        kernel["total_s"],
        text["time_s"],
        kernel["shared_edges"],
        kernel["edges"],
        number(&kernel, "g0_face_face_max"),
        number(&text, "g1_max_deg"),
    );
    assert_kernel(&kernel, expected);
    assert_text(&text, expected);
    Ok(())
}

fn assert_kernel(report: &Value, expected: &Expected) {
    assert_eq!(report["brepcheck_valid"], true, "{report:#}");
    assert_eq!(report["ok_closed_solid"], true, "{report:#}");
    for (key, count) in [
        ("solids", expected.solids),
        ("shells", expected.shells),
        ("faces", 3 * expected.patches),
        ("edges", 2 * expected.seams + 3 * expected.patches),
        ("free_edges", 0),
        ("transfer_fails", 0),
        ("transfer_warnings", 0),
    ] {
        assert_eq!(report[key], count, "{key} of {report:#}");
    }
    assert_eq!(report["euler_V-E+F"], expected.euler, "{report:#}");
    for key in ["max_tol_edge", "max_tol_vertex", "max_tol_face"] {
        assert!(number(report, key) <= 1e-7, "{key} of {report:#}");
    }
    assert!(number(report, "shared_edges") > 0.0, "{report:#}");
    for key in ["g0_face_face_max", "g0_face_curve_max"] {
        assert!(number(report, key) <= 1e-9, "{key} of {report:#}");
    }
    let (found, volume) = (number(report, "volume"), expected.volume);
    assert!(volume > 0.0 && (found - volume).abs() <= 1e-9 * volume, "volume {found}, not {volume}");
}

fn assert_text(report: &Value, expected: &Expected) {
    assert_eq!(report["strict_ok"], true, "{report:#}");
    assert_eq!(report["euler"], expected.euler, "{report:#}");
    assert_eq!(number(report, "edge_curve_vs_surface_boundary_ctrl_dist_max"), 0.0);
    assert_eq!(number(report, "vertex_curve_end_dist_max"), 0.0);
    assert!(number(report, "g1_max_deg") < 1e-9, "{report:#}");
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {report:#}"))
}
