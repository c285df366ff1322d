//! Meshes in, A-patches or splines out.

use super::{Folder, assert_fit_fails, data_folder, model, report};
use std::fs;

/// The unit cube of quadrilaterals.
pub const CUBE: &str = "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
    4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

fn torus() -> String {
    model("torus-20x10.off").to_str().unwrap().to_owned()
}

/// Runs `fit` of a cube with some options and returns the report.
fn cube(options: &[&str]) -> serde_json::Value {
    let folder = Folder::new();
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    let line = [&["fit", "cube.off", "-o", "a.isopatch", "--report", "r.json"], options].concat();
    folder.run(&line).assert_done();
    report(&folder, "r.json")
}

fn number(report: &serde_json::Value, path: &str) -> f64 {
    report.pointer(path).and_then(serde_json::Value::as_f64).unwrap()
}

#[test]
fn a_mesh_becomes_every_kind_of_file() {
    let folder = Folder::new();
    let outputs =
        ["a.vtu", "a.msh", "a.glb", "a.3mf", "a.obj", "a.off", "a.ply", "a.stl", "a.png", "a.isopatch"];
    let torus = torus();
    let mut line = vec!["fit", &torus, "--report", "r.json", "--resolution", "3"];
    line.extend(outputs.iter().flat_map(|name| ["-o", *name]));
    let run = folder.run(&line);
    run.assert_done();
    for word in
        ["400 over faces, 600 over edges", "normals loop", "closed", "genus 1", "no self-intersections"]
    {
        assert!(run.stdout.contains(word), "\"{word}\" is not in: {}", run.stdout);
    }
    let unchecked = folder.run(&["fit", &torus]);
    assert!(unchecked.stdout.contains("not checked for self-intersections"), "{}", unchecked.stdout);
    let (to_step, spline) =
        (["convert", "a.isopatch", "b.step"], "a STEP file can't hold A-patches; isopatch fit");
    folder.run(&to_step).assert_fails(2, &["b.step", spline, "torus-20x10.off"]);
    folder.run(&["convert", "a.off", "b.step"]).assert_fails(1, &["a.off is a mesh", "isopatch fit"]);
    let obj = fs::read_to_string(folder.path("a.obj")).unwrap();
    // A patch over an edge is a lens: 3 intervals along it are 2 triangles at the ends and 2 between them.
    assert_eq!(obj.lines().filter(|line| line.starts_with("f ")).count(), 400 * 9 + 600 * 4);
    let vtu = fs::read(folder.path("a.vtu")).unwrap();
    assert!(String::from_utf8_lossy(&vtu).contains("NumberOfCells=\"6000\""));

    let report = report(&folder, "r.json");
    assert_eq!(
        (&report["method"], &report["surface"]["kind"]),
        (&"apatch".into(), &"rational-a-patch".into())
    );
    assert_eq!((&report["base"]["euler"], &report["surface"]["patches"]), (&0.into(), &1000.into()));
    assert_eq!(
        (&report["surface"]["closed"], &report["surface"]["continuity"]),
        (&true.into(), &"G1".into())
    );
    assert_eq!(
        (&report["surface"]["max_gap"], &report["surface"]["max_vertex_error"]),
        (&0.0.into(), &0.0.into())
    );
    assert!(number(&report, "/surface/max_normal_jump_rad") < 1e-12);
    let apatch = &report["apatch"];
    assert_eq!((&apatch["normals"], &apatch["gradient_lengths"]), (&"loop".into(), &"given".into()));
    assert_eq!((&apatch["undefined"], &apatch["folded"]), (&0.into(), &0.into()));
    assert_eq!(apatch["resolution"], serde_json::json!([3, 1]));
    assert!(report["surface"]["max_distance"].is_null(), "there is no formula");
}

#[test]
fn native_files_are_inspected_and_converted() {
    let folder = Folder::new();
    let torus = torus();
    let made = ["fit", &torus, "--quiet", "-o", "a.isopatch", "-o", "a.ply", "--report", "r.json"];
    folder.run(&made).assert_done();
    let inspected = folder.run(&["inspect", "a.isopatch", "--json"]);
    inspected.assert_done();
    let inspected: serde_json::Value = serde_json::from_str(&inspected.stdout).unwrap();
    let fitted = report(&folder, "r.json");
    for (inspected, fitted) in
        [(&inspected["surface"], &fitted["surface"]), (&inspected["base"], &fitted["base"])]
    {
        assert_eq!(inspected, fitted);
    }
    for figure in ["normals", "gradient_lengths", "faces", "edges", "edge_cells", "free_raised", "folded"] {
        assert_eq!(inspected["apatch"][figure], fitted["apatch"][figure], "{figure}");
    }
    folder.run(&["convert", "a.isopatch", "b.ply", "b.isopatch", "b.vtu"]).assert_done();
    let same = |a: &str, b: &str| fs::read(folder.path(a)).unwrap() == fs::read(folder.path(b)).unwrap();
    assert!(same("a.ply", "b.ply") && same("a.isopatch", "b.isopatch"));
    folder.run(&["convert", "a.isopatch", "b.step"]).assert_fails(2, &["b.step", "A-patches"]);
    folder
        .run(&["convert", "a.isopatch", "c.vtu", "--cells", "bezier"])
        .assert_fails(2, &["--cells", "linear"]);
    folder.run(&["inspect", "a.isopatch", "--against", "x"]).assert_fails(2, &["--against"]);
}

#[test]
fn the_same_bytes_whatever_the_number_of_threads() {
    let folder = Folder::new();
    let torus = torus();
    for (threads, name) in [("1", "a"), ("2", "b")] {
        let [native, glb] = ["isopatch", "glb"].map(|ending| format!("{name}.{ending}"));
        folder
            .run(&["fit", &torus, "--quiet", "--threads", threads, "-o", &native, "-o", &glb])
            .assert_done();
    }
    for ending in ["isopatch", "glb"] {
        let [a, b] = ["a", "b"].map(|name| fs::read(folder.path(&format!("{name}.{ending}"))).unwrap());
        assert_eq!(a, b);
    }
}

#[test]
fn normals_and_their_lengths_are_chosen() {
    let folder = Folder::new();
    // An octahedron with gradients of the ellipsoid x² + y²/4 + z² = 1, but for a factor.
    let mesh = "NOFF\n6 8 0\n1 0 0 4 0 0\n0 2 0 0 2 0\n0 0 1 0 0 4\n-1 0 0 -4 0 0\n0 -2 0 0 -2 0\n0 0 -1 0 0 -4\n\
        3 0 1 2\n3 1 3 2\n3 3 4 2\n3 4 0 2\n3 1 0 5\n3 3 1 5\n3 4 3 5\n3 0 4 5\n";
    fs::write(folder.path("e.off"), mesh).unwrap();
    let volume = |options: &[&str], words: [&str; 2]| {
        folder.run(&[&["fit", "e.off", "--quiet", "--report", "r.json"], options].concat()).assert_done();
        let report = report(&folder, "r.json");
        let apatch = &report["apatch"];
        assert_eq!((&apatch["normals"], &apatch["gradient_lengths"]), (&words[0].into(), &words[1].into()));
        number(&report, "/surface/volume")
    };
    let given = volume(&[], ["file", "given"]);
    let ellipsoid = 8.0 / 3.0 * std::f64::consts::PI;
    assert!((given / ellipsoid - 1.0).abs() < 1e-2, "{given} {ellipsoid}");
    let recovered = volume(&["--gradient-lengths", "recovered"], ["file", "recovered"]);
    assert!((recovered / given - 1.0).abs() < 1e-9, "{recovered} {given}");
    let unit = volume(&["--gradient-lengths", "unit"], ["file", "unit"]);
    assert!((unit / given - 1.0).abs() > 1e-4, "{unit} {given}");
    for source in ["loop", "angle", "area"] {
        assert!(volume(&["--normals", source], [source, "given"]) > 0.9 * given);
    }
}

#[test]
fn sharp_edges_stay_sharp_where_they_are_asked_for() {
    let smooth = cube(&[]);
    assert_eq!(smooth["apatch"]["creases_straight"], 0);
    assert!(number(&smooth, "/surface/volume") > 1.2, "the smooth surface bulges");
    let sharp = cube(&["--crease-angle", "30"]);
    assert_eq!(
        (&sharp["apatch"]["creases_straight"], &sharp["apatch"]["creases_added"]),
        (&12.into(), &0.into())
    );
    assert_eq!(sharp["surface"]["continuity"], "G0");
    assert!((number(&sharp, "/surface/volume") - 1.0).abs() < 1e-13);
    assert_eq!(sharp["repairs"].as_array().unwrap().len(), 0);
    assert_eq!((&sharp["surface"]["patches"], &sharp["apatch"]["elements"]["flat"]), (&6.into(), &6.into()));
}

#[test]
fn free_parameters_shape_the_surface() {
    let [low, high] = ["1", "40"].map(|b| number(&cube(&["--free", b]), "/surface/volume"));
    assert!(low > high + 0.05, "{low} {high}");
    let folder = Folder::new();
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    let with = |text: &str| {
        fs::write(folder.path("free.txt"), text).unwrap();
        folder.run(&["fit", "cube.off", "--free", "free.txt", "--quiet", "--report", "r.json"])
    };
    with(&"40 40\n".repeat(6)).assert_done();
    assert_eq!(number(&report(&folder, "r.json"), "/surface/volume"), high);
    with(&"- -\n".repeat(6)).assert_done();
    assert_eq!(
        number(&report(&folder, "r.json"), "/surface/volume"),
        number(&cube(&["--polygons", "split"]), "/surface/volume")
    );
    with("1 1\n").assert_fails(1, &["cube.off", "1 faces", "6"]);
    with("1 1\n2\n").assert_fails(2, &["free.txt", "line 2"]);
    with("1 x\n").assert_fails(2, &["free.txt", "line 1", "\"x\""]);
}

#[test]
fn a_mesh_becomes_a_step_file() {
    let folder = Folder::new();
    let run = folder.run(&["fit", &torus(), "-o", "a.step", "-o", "a.isopatch", "--report", "r.json"]);
    run.assert_done();
    for word in ["400 of degree 7", "closed", "genus 1", "no self-intersections"] {
        assert!(run.stdout.contains(word), "\"{word}\" is not in: {}", run.stdout);
    }
    let written = report(&folder, "r.json");
    assert_eq!(
        (&written["method"], &written["surface"]["continuity"], &written["surface"]["max_gap"]),
        (&"spline".into(), &"G1".into(), &0.0.into())
    );
    assert!(number(&written, "/surface/max_normal_jump_rad") < 1e-12);
    assert!(number(&written, "/surface/max_vertex_error") < 1e-15);
    folder.run(&["inspect", "a.isopatch"]).assert_done();
    let step = fs::read(folder.path("a.step")).unwrap();
    folder.run(&["convert", "a.isopatch", "a.step"]).assert_done();
    assert!(fs::read(folder.path("a.step")).unwrap() == step, "the converted file differs");
    // A cube with sharp edges is flat.
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    let line = ["fit", "cube.off", "--crease-angle", "60", "-o", "c.step", "--report", "r.json"];
    folder.run(&line).assert_done();
    let cube = report(&folder, "r.json");
    assert_eq!(cube["surface"]["continuity"], "G0");
    assert!((number(&cube, "/surface/volume") - 1.0).abs() < 1e-12);
    for option in [["--normals", "loop"], ["--gradient-lengths", "unit"], ["--free", "1"]] {
        let line = [&["fit", "cube.off", "-o", "d.step"], &option[..]].concat();
        folder.run(&line).assert_fails(2, &[option[0], "for A-patches"]);
    }
}

#[test]
fn flat_triangles_are_as_fine_as_the_chord_asks_for() {
    let folder = Folder::new();
    let torus = torus();
    let triangles = |input: &str, chord: &str| {
        folder.run(&["fit", input, "-o", "a.stl", "--quiet", "--chord", chord]).assert_done();
        fs::metadata(folder.path("a.stl")).unwrap().len() / 50
    };
    for input in [&torus[..], "sphere"] {
        let (coarse, fine) = (triangles(input, "1e-3"), triangles(input, "1e-4"));
        // Smooth patches take ten times as many, those that bend hard at vertices more.
        assert!(fine > 4 * coarse && fine < 60 * coarse, "{input}: {coarse} {fine}");
    }
    folder.run(&["fit", "sphere", "-o", "a.stl", "--chord", "1e-15"]).assert_fails(1, &["--chord"]);
    let both = ["fit", "sphere", "-o", "a.stl", "--chord", "1e-3", "--resolution", "4"];
    folder.run(&both).assert_fails(2, &["--chord", "--resolution"]);
}

#[test]
fn options_without_a_meaning_are_refused() {
    let torus = torus();
    for option in [
        ["--box", "-1,1,-1,1,-1,1"],
        ["--level", "1"],
        ["--faces", "80"],
        ["--tol", "1e-3"],
        ["--set", "r=2"],
        ["--base", "b.off"],
        ["--base-method", "qem"],
    ] {
        let folder = Folder::new();
        let line = [&["fit", &torus, "-o", "a.glb"], &option[..]].concat();
        folder.run(&line).assert_fails(2, &[option[0], "for formulas"]);
        folder.assert_untouched();
    }
    for option in
        [["--normals", "loop"], ["--gradient-lengths", "unit"], ["--crease-angle", "30"], ["--free", "1"]]
    {
        assert_fit_fails(&[&["sphere"], &option[..]].concat(), 2, &[option[0], "for meshes"]);
    }
    assert_fit_fails(&["sphere", "--method", "apatch"], 2, &["older.step", "--method rational"]);
    let folder = Folder::new();
    folder
        .run(&["fit", "sphere", "--method", "apatch", "-o", "a.glb"])
        .assert_fails(2, &["--method apatch", "mesh", "singular", "--method spline"]);
    assert_fit_fails(&[&torus, "--method", "apatch"], 2, &["older.step", "--method spline"]);
    let folder = Folder::new();
    for cells in ["bezier", "lagrange"] {
        folder.run(&["fit", &torus, "-o", "a.vtu", "--cells", cells]).assert_fails(2, &["--cells", "linear"]);
    }
    folder.run(&["fit", &torus, "-o", "a.glb", "--crease-angle", "200"]).assert_fails(2, &["--crease-angle"]);
    folder
        .run(&["fit", &torus, "-o", "a.glb", "--normals", "file"])
        .assert_fails(1, &["torus", "no normals"]);
    folder.assert_untouched();
}

#[test]
fn meshes_that_cannot_be_read_are_pointed_at() {
    let folder = Folder::new();
    folder.run(&["fit", "hand.off", "-o", "a.glb"]).assert_fails(1, &["hand.off"]);
    let fails = |name: &str, text: &str, words: &[&str]| {
        fs::write(folder.path(name), text).unwrap();
        folder.run(&["fit", name, "-o", "a.glb"]).assert_fails(1, &[&[name], words].concat());
        fs::remove_file(folder.path(name)).unwrap();
    };
    fails("a.off", &CUBE.replace("1 1 1\n", "1 one 1\n"), &["line 10", "one"]);
    fails("a.off", &CUBE.replace("4 1 3 7 5", "4 1 3 7 8"), &["8"]);
    fails("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["face 0 names vertex 4"]);
    fails("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", &["no face with an area"]);
    fails("a.stl", "solid\nendsolid\n", &["no face"]);
    folder.assert_untouched();
}

/// What becomes of the broken meshes of the collection: words of the repairs, or of the message that refuses them.
const NASTY: [(&str, Result<&str, &str>); 13] = [
    ("nasty_cgal_blobby-shuffled", Ok("faces turned over: 2017")),
    ("nasty_cgal_corner_with_sharp_edge", Ok("vertices welded: 1")),
    ("nasty_cgal_elephant-with-holes", Ok("")),
    ("nasty_cgal_hole", Ok("creases added")),
    ("nasty_cgal_quads_to_stitch", Ok("vertices welded: 5")),
    ("nasty_degenerate", Ok("faces without area dropped: 1")),
    ("nasty_flipped20pct", Ok("faces turned over: 126")),
    ("nasty_holes25", Ok("vertices split: 6")),
    ("nasty_nan_vertex", Err("vertex 5 has a coordinate that is not a finite number")),
    ("nasty_noise1pct", Ok("creases added")),
    ("nasty_nonmanifold_fin", Ok("sheets taken apart at edges: 1 at edge")),
    ("nasty_polygon_soup", Ok("vertices welded: 1587")),
    ("nasty_self_intersecting", Ok("")),
];

#[test]
fn broken_meshes_are_repaired_or_refused_by_name() {
    let meshes = data_folder().join("meshes");
    if !meshes.is_dir() {
        return eprintln!("skipped: no test data at {}", meshes.display());
    }
    for (name, expected) in NASTY {
        let folder = Folder::new();
        let file = meshes.join(format!("{name}.off"));
        let file = file.to_str().unwrap();
        let run = folder.run(&["fit", file, "-o", "a.isopatch", "-o", "a.ply", "--report", "r.json"]);
        match expected {
            Ok(word) => {
                run.assert_done();
                assert!(run.stdout.contains(word), "{name}: \"{word}\" is not in: {}", run.stdout);
                let report = report(&folder, "r.json");
                assert_eq!(report["apatch"]["undefined"], 0, "{name}");
                assert!(report["apatch"]["problems"].as_object().unwrap().is_empty(), "{name}");
            }
            Err(word) => {
                run.assert_fails(1, &[name, word]);
                folder.assert_untouched();
            }
        }
    }
}
