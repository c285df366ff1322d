//! A wrong command line: status 2, nothing done.

use super::{Folder, assert_fit_fails};
use std::fs;

#[test]
fn unknown_options_are_refused() {
    assert_fit_fails(&["sphere", "--speed", "9"], 2, &["'--speed'"]);
    assert_fit_fails(&["--speed"], 2, &["'--speed'"]);
    assert_fit_fails(&["sphere", "--method", "voxels"], 2, &["voxels", "auto, spline, rational, apatch"]);
    assert_fit_fails(&["sphere", "--base-method", "voxels"], 2, &["voxels", "remesh, qem"]);
}

#[test]
fn boxes_that_are_reversed_or_flat_are_refused() {
    assert_fit_fails(&["sphere", "--box", "1,-1,-1,1,-1,1"], 2, &["--box", "reversed in x"]);
    assert_fit_fails(&["sphere", "--box", "-1,1,-1,1,2,2"], 2, &["--box", "flat in z"]);
    assert_fit_fails(&["sphere", "--box", "-1,1,-1,1"], 2, &["--box", "six numbers"]);
    assert_fit_fails(&["sphere", "--box", "-1,1,-1,nan,-1,1"], 2, &["--box", "\"nan\"", "not finite"]);
}

#[test]
fn numbers_out_of_range_are_refused() {
    for tolerance in ["0", "-1e-3", "nan", "inf", "small", "1e-20"] {
        assert_fit_fails(&["sphere", "--tol", tolerance], 2, &["--tol", tolerance]);
    }
    for faces in ["0", "-80", "8.5", "99999999999"] {
        assert_fit_fails(&["sphere", "--faces", faces], 2, &["--faces", faces]);
    }
    assert_fit_fails(&["sphere", "--level", "nan"], 2, &["--level"]);
    assert_fit_fails(&["sphere", "--threads", "0"], 2, &["--threads"]);
    assert_fit_fails(&["sphere", "--resolution", "0"], 2, &["--resolution"]);
    assert_fit_fails(&["sphere", "--unit", "ft"], 2, &["--unit", "ft", "mm, cm, m and in"]);
    assert_fit_fails(&["sphere", "--set", "r"], 2, &["--set", "NAME=VALUE"]);
    assert_fit_fails(&["sphere", "--set", "x=1"], 2, &["--set", "\"x\""]);
}

#[test]
fn options_that_contradict_each_other_are_refused() {
    assert_fit_fails(&["sphere", "--faces", "80", "--tol", "1e-3"], 2, &["--faces", "--tol"]);
    assert_fit_fails(&["sphere", "--faces", "80", "--base", "b.off"], 2, &["--faces", "--base"]);
    assert_fit_fails(&["sphere", "-o", "./older.step"], 2, &["older.step", "twice"]);
    assert_fit_fails(&["sphere", "--report", "older.step"], 2, &["older.step", "twice"]);
}

#[test]
fn unknown_endings_are_refused() {
    assert_fit_fails(
        &["sphere", "-o", "a.dwg"],
        2,
        &["a.dwg", ".step .stp .vtu .msh .glb .3mf .obj .off .ply .stl .png .isopatch"],
    );
}

#[test]
fn files_of_options_are_checked_like_typed_options() {
    let folder = Folder::new();
    let fails = |text: &str, status, words: &[&str]| {
        fs::write(folder.path("c.toml"), text).unwrap();
        let run = folder.run(&["fit", "sphere", "--config", "c.toml", "-o", "older.step"]);
        run.assert_fails(status, words);
    };
    fails("colour = 'red'", 2, &["c.toml", "unknown key \"colour\"", "faces"]);
    fails("faces = -3", 2, &["c.toml", "--faces", "'-3'"]);
    fails("box = [1, -1, -1, 1, -1, 1]", 2, &["c.toml", "reversed in x"]);
    fails("faces =", 2, &["c.toml"]);
    fs::remove_file(folder.path("c.toml")).unwrap();
    folder.run(&["fit", "sphere", "--config", "c.toml"]).assert_fails(2, &["c.toml"]);
    folder.assert_untouched();
}

#[test]
fn options_come_from_a_file_and_from_the_command_line() {
    let folder = Folder::new();
    let config = "output = ['a.isopatch']\nfaces = 1000000\nunit = 'cm'\nreport = 'r.json'\nset = { r = 3 }\nbox = [-4, 4, -4, 4, -4, 4]";
    fs::write(folder.path("c.toml"), config).unwrap();
    let typed = ["--faces", "40", "--set", "r=2", "--threads", "1"];
    let run = folder.run(&[&["fit", "x^2+y^2+z^2=r^2", "--config", "c.toml"], &typed[..]].concat());
    run.assert_done();
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path("r.json")).unwrap()).unwrap();
    assert_eq!((&report["base"]["faces"], &report["unit"]), (&40.into(), &"cm".into()));
    assert_eq!(report["threads"], 1);
    let area = report["surface"]["area"].as_f64().unwrap();
    assert!((area / (16.0 * std::f64::consts::PI) - 1.0).abs() < 1e-2, "{area}");
    assert!(folder.path("a.isopatch").exists());
}
