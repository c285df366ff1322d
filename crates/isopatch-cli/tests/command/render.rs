//! Pictures.

use super::meshes::CUBE;
use super::{Folder, data_folder, model};
use std::fs;

/// Width and height of a PNG file, from its header.
fn size(folder: &Folder, name: &str) -> [u32; 2] {
    let bytes = fs::read(folder.path(name)).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn a_native_file_is_drawn_in_every_style() {
    let folder = Folder::new();
    folder
        .run(&["fit", "torus", "--faces", "300", "--quiet", "-o", "a.isopatch", "-o", "a.png"])
        .assert_done();
    assert_eq!(size(&folder, "a.png"), [1200, 900]);
    folder.run(&["render", "a.isopatch", "-o", "default.png"]).assert_done();
    let same = |a: &str, b: &str| fs::read(folder.path(a)).unwrap() == fs::read(folder.path(b)).unwrap();
    assert!(same("a.png", "default.png"));
    let styles = [
        "shaded",
        "patches",
        "isophotes",
        "reflection",
        "gold",
        "curvature",
        "mean-curvature",
        "net",
        "mesh",
        "normals",
    ];
    let small = ["--size", "80x60", "--resolution", "4"];
    for style in styles {
        let output = format!("{style}.png");
        let line = ["render", "a.isopatch", "-o", &output, "--style", style];
        folder.run(&[&line[..], &small].concat()).assert_done();
        assert_eq!(size(&folder, &output), [80, 60]);
    }
    for pair in styles.windows(2) {
        assert!(!same(&format!("{}.png", pair[0]), &format!("{}.png", pair[1])), "{pair:?}");
    }
    for (threads, output) in [("1", "one.png"), ("3", "three.png")] {
        let line = ["render", "a.isopatch", "-o", output, "--style", "net", "--threads", threads];
        folder.run(&[&line[..], &small].concat()).assert_done();
    }
    assert!(same("one.png", "three.png"), "the same bytes whatever the number of threads");
    for (view, output) in [("top", "top.png"), ("-30,15", "aside.png")] {
        folder
            .run(&[&["render", "a.isopatch", "-o", output, "--view", view], &small[..]].concat())
            .assert_done();
        assert!(!same(output, "shaded.png"), "{view}");
    }
    let hull = folder.run(&["render", "a.isopatch", "-o", "h.png", "--style", "hull"]);
    hull.assert_fails(2, &["--style", "hull"]);
    assert!(!folder.path("h.png").exists());
}

#[test]
fn a_mesh_and_its_a_patches_are_drawn() {
    let folder = Folder::new();
    let torus = model("torus-20x10.off").to_str().unwrap().to_owned();
    folder.run(&["render", &torus, "-o", "mesh.png", "--style", "mesh", "--size", "80x60"]).assert_done();
    assert_eq!(size(&folder, "mesh.png"), [80, 60]);
    folder.run(&["fit", &torus, "--quiet", "-o", "a.isopatch"]).assert_done();
    for style in ["shaded", "hull", "singular"] {
        let output = format!("{style}.png");
        let line = ["render", "a.isopatch", "-o", &output, "--style", style, "--size", "80x60", "--up", "y"];
        folder.run(&line).assert_done();
        assert_eq!(size(&folder, &output), [80, 60]);
    }
    let net = ["render", "a.isopatch", "-o", "n.png", "--style", "net"];
    folder.run(&net).assert_fails(2, &["--style", "control points"]);
    folder.run(&["render", &torus, "-o", "n.png", "--resolution", "3"]).assert_fails(2, &["--resolution"]);
}

#[test]
fn hulls_over_polygons_are_drawn() {
    let folder = Folder::new();
    fs::write(folder.path("cube.off"), CUBE).unwrap();
    folder.run(&["fit", "cube.off", "--quiet", "-o", "a.isopatch"]).assert_done();
    for style in ["shaded", "hull"] {
        let output = format!("{style}.png");
        folder
            .run(&["render", "a.isopatch", "-o", &output, "--style", style, "--size", "80x60"])
            .assert_done();
        assert_eq!(size(&folder, &output), [80, 60]);
    }
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_ne!(read("shaded.png"), read("hull.png"));
}

#[test]
fn what_can_not_be_drawn_is_named() {
    let folder = Folder::new();
    let fails = |line: &[&str], status, words: &[&str]| {
        folder.run(&[&["render"], line].concat()).assert_fails(status, words);
        folder.assert_untouched();
    };
    fails(&["none.isopatch", "-o", "a.png"], 1, &["none.isopatch"]);
    fails(&["sphere", "-o", "a.png"], 1, &["sphere", ".obj"]);
    fails(&["a.off", "-o", "older.step"], 2, &["older.step", ".png"]);
    fails(&["a.off", "-o", "a.png", "--size", "0x9"], 2, &["--size"]);
    fails(&["a.off", "-o", "a.png", "--view", "above"], 2, &["--view", "above", "front"]);
    fails(&["a.off", "-o", "a.png", "--style", "oil"], 2, &["oil", "shaded"]);
    // A mesh that no surface can be made of is still drawn.
    let fin = data_folder().join("meshes/nasty_nonmanifold_fin.off");
    if let Some(fin) = fin.to_str().filter(|path| fs::exists(path).unwrap_or(false)) {
        folder.run(&["render", fin, "-o", "fin.png", "--size", "80x60"]).assert_done();
    }
}
