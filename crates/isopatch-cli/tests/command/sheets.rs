//! isopatch fit of singular formulas, of meshes of polygons, and with rational patches.

use super::Folder;
use serde_json::Value;
use std::fs;

fn report(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.path(name)).unwrap()).unwrap()
}

const UMBRELLA: [&str; 4] = ["fit", "x^2 = y z^2", "--box", "-3,3,-3,3,-2,2"];

#[test]
fn a_singular_formula_becomes_triangles_that_conform() {
    for (how, faults) in [(None, 0), (Some("conforming"), 0), (Some("edge"), 0), (Some("vertex"), 0)] {
        let folder = Folder::new();
        let mut arguments = UMBRELLA.to_vec();
        arguments.extend(["-o", "u.glb", "-o", "u.ply", "--report", "r.json"]);
        arguments.extend(how.iter().flat_map(|how| ["--triangulate", how]));
        folder.run(&arguments).assert_done();
        let found = report(&folder, "r.json");
        assert_eq!(found["method"], "triangles", "{how:?}");
        assert_eq!(found["surface"]["continuity"], "G0", "{how:?}");
        assert_eq!(found["base"]["euler"], 1, "{how:?}: {found}");
        assert_eq!(found["repairs"].as_array().map(Vec::len), Some(faults), "{how:?}: {found}");
        let valences = found["singular"]["edges_by_valence"].as_object().unwrap();
        assert_eq!(valences.keys().collect::<Vec<_>>(), ["4"], "{how:?}");
        assert!(folder.path("u.glb").exists() && folder.path("u.ply").exists());
    }
}

#[test]
fn a_singular_formula_becomes_rational_patches_for_step() {
    let folder = Folder::new();
    folder
        .run(&["fit", "x^2+y^2=z^2", "--box", "-3,3,-3,3,-2,2", "-o", "cone.step", "--report", "r.json"])
        .assert_done();
    let found = report(&folder, "r.json");
    assert_eq!(
        (&found["method"], &found["surface"]["kind"]),
        (&"rational".into(), &"rational-triangle".into())
    );
    assert!(found["surface"]["max_gap"].as_f64().unwrap() == 0.0);
    let step = fs::read_to_string(folder.path("cone.step")).unwrap();
    assert!(step.contains("RATIONAL_B_SPLINE_SURFACE"));
}

/// A cube of six quadrilaterals.
const CUBE: &str = "OFF\n8 6 0\n-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n-1 1 1\n\
    4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";

#[test]
fn a_cube_of_quadrilaterals_becomes_a_sphere_of_eighteen_patches() {
    let folder = Folder::new();
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    folder
        .run(&["fit", "cube.off", "-o", "s.glb", "-o", "s.isopatch", "-o", "s.vtu", "--report", "r.json"])
        .assert_done();
    let found = report(&folder, "r.json");
    assert_eq!(found["surface"]["patches"], 18, "{found}");
    assert_eq!(found["base"]["euler"], 2);
    let volume = found["surface"]["volume"].as_f64().unwrap();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 27f64.sqrt();
    assert!((volume / ball - 1.0).abs() < 0.05, "{volume} {ball}");
    folder.run(&["inspect", "s.isopatch"]).assert_done();
    folder.run(&["convert", "s.isopatch", "s.stl"]).assert_done();
    folder
        .run(&["fit", "cube.off", "--polygons", "split", "-o", "t.glb", "--report", "t.json"])
        .assert_done();
    assert_eq!(report(&folder, "t.json")["surface"]["patches"], 30);
}

#[test]
fn a_mesh_becomes_rational_patches() {
    let folder = Folder::new();
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    let arguments = [
        "fit",
        "cube.off",
        "--method",
        "rational",
        "-o",
        "s.step",
        "-o",
        "s.isopatch",
        "-o",
        "s.vtu",
        "--report",
        "r.json",
    ];
    folder.run(&arguments).assert_done();
    let found = report(&folder, "r.json");
    assert_eq!(found["surface"]["kind"], "rational-triangle");
    assert!(found["surface"]["max_normal_jump_rad"].as_f64().unwrap() < 1e-9);
    folder.run(&["inspect", "s.isopatch"]).assert_done();
    folder.run(&["convert", "s.isopatch", "t.step"]).assert_done();
    assert_eq!(
        fs::read(folder.path("s.step")).unwrap().len(),
        fs::read(folder.path("t.step")).unwrap().len()
    );
}
