//! The files that come out.

use super::{Folder, Run, model, report};
use serde_json::Value;
use std::fs;

#[test]
fn a_formula_becomes_every_kind_of_file() {
    let folder = Folder::new();
    let outputs = [
        "older.step",
        "a.stp",
        "a.vtu",
        "a.msh",
        "a.glb",
        "a.3mf",
        "a.obj",
        "a.off",
        "a.ply",
        "a.stl",
        "a.png",
        "a.isopatch",
    ];
    let mut line = vec!["fit", "-x^2-y^2-z^2+1", "--faces", "40", "--report", "r.json", "--resolution", "3"];
    line.extend(outputs.iter().flat_map(|name| ["-o", *name]));
    let run = folder.run(&line);
    run.assert_done();
    for word in
        ["40", "closed", "Euler number 2", "genus 0", "RMS", "normal jump", "no self-intersections", "files"]
    {
        assert!(run.stdout.contains(word), "\"{word}\" is not in: {}", run.stdout);
    }
    assert!(!run.stdout.contains('\x1b'), "no control characters in a pipe");
    for name in outputs {
        assert!(run.stdout.contains(name), "{name}");
        assert!(fs::metadata(folder.path(name)).unwrap().len() > 1000, "{name}");
    }
    assert_eq!(folder.names().len(), outputs.len() + 1, "{:?}", folder.names());
    let obj = fs::read_to_string(folder.path("a.obj")).unwrap();
    assert_eq!(obj.lines().filter(|line| line.starts_with("f ")).count(), 40 * 9);

    let report = report(&folder, "r.json");
    assert_eq!((&report["schema"], &report["negated"]), (&1.into(), &true.into()));
    assert_eq!((&report["base"]["euler"], &report["base"]["components"]), (&2.into(), &1.into()));
    assert!(report["surface"]["max_distance"].as_f64().unwrap() < 1e-3);
    assert!(report["surface"]["max_normal_jump_rad"].as_f64().unwrap() < 1e-9);
    assert!(report["surface"]["volume"].as_f64().unwrap() > 4.0, "positive: normals point out");
}

#[test]
fn native_files_are_inspected_and_converted() {
    let folder = Folder::new();
    let made = ["fit", "x^2+y^2/r+z^2", "--level", "1", "--set", "r=2", "--faces", "60", "--quiet"];
    let run = folder.run(&[&made[..], &["-o", "a.isopatch", "-o", "a.vtu", "--report", "r.json"]].concat());
    run.assert_done();
    assert_eq!(run.stdout, "");

    let inspected = folder.run(&["inspect", "a.isopatch", "--json"]);
    inspected.assert_done();
    let inspected: Value = serde_json::from_str(&inspected.stdout).unwrap();
    let fitted = report(&folder, "r.json");
    for figure in ["max_distance", "rms_distance", "max_normal_error_rad", "max_normal_jump_rad", "volume"] {
        assert_eq!(inspected["surface"][figure], fitted["surface"][figure], "{figure}");
    }
    let against = folder.run(&["inspect", "a.isopatch", "--against", "1=x^2+y^2/2+z^2"]);
    against.assert_done();
    assert!(against.stdout.contains("distance"), "{}", against.stdout);

    folder.run(&["convert", "a.isopatch", "b.vtu", "b.step", "c.isopatch"]).assert_done();
    let same = |a: &str, b: &str| fs::read(folder.path(a)).unwrap() == fs::read(folder.path(b)).unwrap();
    assert!(same("a.vtu", "b.vtu") && same("a.isopatch", "c.isopatch"));
}

#[test]
fn the_same_bytes_whatever_the_number_of_threads() {
    let folder = Folder::new();
    for (threads, output) in [("1", "a.isopatch"), ("2", "b.isopatch")] {
        folder.run(&["fit", "dodeca", "--faces", "400", "--threads", threads, "-o", output]).assert_done();
    }
    assert_eq!(fs::read(folder.path("a.isopatch")).unwrap(), fs::read(folder.path("b.isopatch")).unwrap());
}

#[test]
fn a_tolerance_that_is_reached_is_kept() {
    let folder = Folder::new();
    folder
        .run(&["fit", "x^2+y^2+z^2-1", "--tol", "1e-3", "-o", "a.step", "--report", "r.json"])
        .assert_done();
    let surface = &report(&folder, "r.json")["surface"];
    assert!(surface["max_distance"].as_f64().unwrap() <= 1e-3);
    assert!(surface["max_distance_back"].as_f64().unwrap() <= 1e-3);
}

#[test]
fn a_tolerance_that_is_not_reached_leaves_no_file() {
    let folder = Folder::new();
    // A given base mesh is used as it is.
    let base = model("torus-20x10.off");
    let base = base.to_str().unwrap();
    let arguments =
        ["fit", "torus", "--base", base, "--tol", "1e-9", "-o", "older.step", "--report", "r.json"];
    folder.run(&arguments).assert_fails(3, &["--tol 1e-9", "not reached"]);
    folder.assert_untouched();
}

#[test]
fn the_base_mesh_comes_from_a_file() {
    let folder = Folder::new();
    let base = model("torus-20x10.off");
    let run = folder.run(&["fit", "torus", "--base", base.to_str().unwrap(), "--report", "r.json"]);
    run.assert_done();
    let report = report(&folder, "r.json");
    let base = &report["base"];
    assert_eq!((&base["vertices"], &base["faces"], &base["euler"]), (&200.into(), &400.into(), &0.into()));
    assert!(report["surface"]["max_distance"].as_f64().unwrap() < 1e-3);
}

#[test]
fn a_box_that_cuts_the_surface_leaves_an_open_one() {
    let folder = Folder::new();
    let line = ["fit", "x^2+y^2+z^2-1", "--box", "-2,0.5,-2,2,-2,2", "--faces", "60", "-o", "a.step"];
    folder.run(&[&line[..], &["--report", "r.json"]].concat()).assert_done();
    let report = report(&folder, "r.json");
    assert_eq!((&report["surface"]["closed"], &report["surface"]["volume"]), (&false.into(), &Value::Null));
    assert_eq!((&report["base"]["boundary_loops"], &report["base"]["euler"]), (&1.into(), &1.into()));
    assert_eq!(report["surface"]["certified"]["topology"], true);
    assert_eq!(report["bounds"][1][0].as_f64(), Some(0.5));
}

#[test]
fn files_for_solids_that_hold_open_shells_are_named() {
    let folder = Folder::new();
    let line = ["fit", "x^2+y^2-1", "--box=-2,2,-2,2,-1,1", "--faces", "30"];
    let run = folder.run(&[&line[..], &["-o", "a.step", "-o", "a.glb", "-o", "a.isopatch"]].concat());
    run.assert_done();
    assert!(run.stdout.contains("open shell instead of a solid at a.step: the box cuts"), "{}", run.stdout);
    let run = folder.run(&["convert", "a.isopatch", "b.step", "b.stl", "b.obj"]);
    assert_eq!(run.status, Some(0));
    assert!(run.stderr.starts_with("warning: b.step, b.stl: open shell"), "{}", run.stderr);
    // Sheets that cross end in each other, not in the open.
    let run = folder.run(&["fit", "steiner", "--method", "rational", "--faces", "100", "-o", "c.step"]);
    run.assert_done();
    assert!(!run.stdout.contains("open shell"), "{}", run.stdout);
}

#[test]
fn step_files_tell_the_time_of_the_environment() {
    let folder = Folder::new();
    let made = |time: Option<&str>| {
        let mut command = folder.command(&["fit", "x^2+y^2+z^2=1", "--faces", "30", "-o", "a.step"]);
        command.env_remove("SOURCE_DATE_EPOCH");
        if let Some(time) = time {
            command.env("SOURCE_DATE_EPOCH", time);
        }
        Run::new(command.output().unwrap())
    };
    for (time, stamp) in [(None, "'2000-01-01T00:00:00'"), (Some("1735689599"), "'2024-12-31T23:59:59'")] {
        made(time).assert_done();
        assert!(fs::read_to_string(folder.path("a.step")).unwrap().contains(stamp), "{stamp}");
    }
    made(Some("today")).assert_fails(2, &["SOURCE_DATE_EPOCH=today", "whole number of seconds"]);
}

#[test]
fn units_are_changed_by_a_conversion() {
    let folder = Folder::new();
    folder.run(&["fit", "x^2+y^2+z^2=1", "--faces", "30", "-o", "a.isopatch"]).assert_done();
    folder.run(&["convert", "a.isopatch", "b.step", "b.isopatch", "--unit", "in"]).assert_done();
    assert!(fs::read_to_string(folder.path("b.step")).unwrap().contains("'INCH'"));
    assert!(folder.run(&["inspect", "b.isopatch"]).stdout.contains(" in³"));
}

#[test]
fn a_run_without_outputs_says_that_nothing_was_written() {
    let folder = Folder::new();
    let run = folder.run(&["fit", "x^2+y^2+z^2=1", "--faces", "30"]);
    run.assert_done();
    assert!(
        run.stdout.contains("30 of degree 7") && run.stdout.contains("nothing was written"),
        "{}",
        run.stdout
    );
    folder.assert_untouched();
}
