//! isopatch singular.

use super::Folder;
use serde_json::Value;

#[test]
fn the_whitney_umbrella_is_told_as_json() {
    let run = Folder::new().run(&["singular", "x^2 = y z^2", "--box", "-3,3,-3,3,-2,2", "--json"]);
    run.assert_done();
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(found["points"].as_array().map(Vec::len), Some(0));
    let curves = found["curves"].as_array().unwrap();
    let mut kinds: Vec<&str> = curves.iter().map(|c| c["kind"].as_str().unwrap()).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, ["crossing", "stick"]);
    for curve in curves {
        let special = curve["special"].as_array().unwrap();
        let kinds: Vec<&Value> = special.iter().map(|s| &s["kind"]).collect();
        assert!(kinds.contains(&&"pinch".into()) && kinds.contains(&&"box".into()), "{kinds:?}");
        assert_eq!(curve["closed"], false);
        assert!(curve["samples"].as_array().unwrap().len() > 100);
    }
    assert_eq!(found["components"], 1);
    assert_eq!(found["seeds"].as_array().map(Vec::len), Some(1));
    assert_eq!(found["lower_dimensional"][0]["dimension"], 1);
    assert!(found["tau"].as_f64().unwrap() > 0.0 && found["seconds"].as_f64().unwrap() > 0.0);
}

#[test]
fn nodes_of_a_gallery_surface_are_a_table() {
    let run = Folder::new().run(&["singular", "cayley"]);
    run.assert_done();
    assert!(run.stdout.starts_with("4 isolated singular points\n"), "{}", run.stdout);
    assert_eq!(run.stdout.matches("node        multiplicity 1    exact").count(), 4, "{}", run.stdout);
    assert!(run.stdout.contains("1 connected component;"));
    let smooth = Folder::new().run(&["singular", "clebsch"]);
    smooth.assert_done();
    assert!(smooth.stdout.starts_with("No singular point in the box.\n"));
}

#[test]
fn inputs_that_can_not_be_handled_are_named() {
    let folder = Folder::new();
    folder.run(&["singular", "sin(x)+y", "--box", "0,1,0,1,0,1"]).assert_fails(1, &["polynomials only"]);
    folder.run(&["singular", "1", "--box", "0,1,0,1,0,1"]).assert_fails(1, &["constant"]);
    folder.run(&["singular", "x^40", "--box", "0,1,0,1,0,1"]).assert_fails(1, &["degree 40", "16"]);
    folder.run(&["singular", "x^2+y^2-z^2"]).assert_fails(2, &["--box"]);
    folder.run(&["singular", "x^2+y^2-z^2", "--box", "0,0,0,1,0,1"]).assert_fails(2, &["--box"]);
    folder
        .run(&["singular", "(x - sqrt(2) y)^2", "--box", "0,1,0,1,0,1"])
        .assert_fails(1, &["more than once"]);
    folder.assert_untouched();
}

#[test]
fn the_level_and_constants_count() {
    let run = Folder::new().run(&[
        "singular",
        "x^2+y^2-a z^2",
        "--set",
        "a=2",
        "--level",
        "1",
        "--box",
        "-2,2,-2,2,-2,2",
    ]);
    run.assert_done();
    assert!(run.stdout.starts_with("No singular point"));
}

#[test]
fn sticks_are_in_the_files_that_can_hold_them() {
    let folder = Folder::new();
    let run = folder.run(&[
        "fit",
        "x^2 = y z^2",
        "--box",
        "-1,1,-1,1,-1,1",
        "-o",
        "a.obj",
        "-o",
        "a.ply",
        "-o",
        "a.vtu",
        "-o",
        "a.glb",
        "-o",
        "a.stl",
        "-o",
        "a.png",
    ]);
    run.assert_done();
    assert!(run.stdout.contains("left out at a.stl"), "{}", run.stdout);
    assert_eq!(run.stdout.matches("left out").count(), 1, "{}", run.stdout);
    let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
    assert!(bytes("a.png").starts_with(b"\x89PNG"));

    // The stick is x = z = 0, y < 0: every point of a line is there, and it goes all the way.
    let text = String::from_utf8(bytes("a.obj")).unwrap();
    let rows = |key: &str| -> Vec<Vec<f64>> {
        let rows = text.lines().filter_map(|l| l.strip_prefix(key)?.strip_prefix(' '));
        rows.map(|l| l.split(' ').map(|n| n.parse().unwrap()).collect()).collect()
    };
    let (vertices, lines) = (rows("v"), rows("l"));
    assert_eq!(lines.len(), 1);
    let stick: Vec<&Vec<f64>> = lines[0].iter().map(|n| &vertices[*n as usize - 1]).collect();
    assert!(stick.iter().all(|p| p[0].abs() < 1e-9 && p[2].abs() < 1e-9 && p[1] <= 1e-9), "{stick:?}");
    let lowest = stick.iter().map(|p| p[1]).fold(0.0, f64::min);
    assert!((lowest + 1.0).abs() < 1e-12, "{lowest}");

    let ply = bytes("a.ply");
    let header = String::from_utf8_lossy(&ply[..ply.windows(10).position(|w| w == b"end_header").unwrap()])
        .into_owned();
    let count = |what: &str| -> usize {
        let row = header.lines().find_map(|l| l.strip_prefix(&format!("element {what} "))).unwrap();
        row.parse().unwrap()
    };
    assert_eq!(count("edge"), lines[0].len() - 1);
    assert_eq!(ply.len(), header.len() + 11 + 48 * count("vertex") + 17 * count("face") + 8 * count("edge"));
    let mesh = isopatch::io::read::read_ply(&ply).unwrap();
    assert_eq!(mesh.positions.len(), count("vertex"));

    // Types of the cells are the last bytes of the grid: triangles, then lines.
    let vtu = bytes("a.vtu");
    let end = vtu.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
    let edges = lines[0].len() - 1;
    assert!(vtu[end - edges..end].iter().all(|t| *t == 3));
    assert_eq!(vtu[end - edges - 1], 5);

    let glb = bytes("a.glb");
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let scene: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let more = &scene["meshes"][0]["primitives"][1];
    assert_eq!(more["mode"], 1);
    let accessor = &scene["accessors"][more["attributes"]["POSITION"].as_u64().unwrap() as usize];
    assert_eq!(accessor["count"].as_u64().unwrap() as usize, 2 * edges);
    let view = &scene["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let total = scene["buffers"][0]["byteLength"].as_u64().unwrap();
    assert_eq!(view["byteOffset"].as_u64().unwrap() + view["byteLength"].as_u64().unwrap(), total);
    assert_eq!(glb.len() as u64, 28 + length as u64 + total);
}

#[test]
fn isolated_points_are_in_the_files_that_can_hold_them() {
    let folder = Folder::new();
    let formula = "(x^2+y^2+z^2)*(x-1)+x^4";
    let run = folder.run(&["fit", formula, "--box", "-2,2,-2,2,-2,2", "-o", "a.obj", "-o", "a.off"]);
    run.assert_done();
    assert!(
        run.stdout.contains("1 isolated point and 0 curves without sheets left out at a.off"),
        "{}",
        run.stdout
    );
    let text = std::fs::read_to_string(folder.path("a.obj")).unwrap();
    let number: usize = text.lines().find_map(|l| l.strip_prefix("p ")).unwrap().parse().unwrap();
    let vertices: Vec<&str> = text.lines().filter(|l| l.starts_with("v ")).collect();
    assert_eq!(vertices[number - 1], "v 0.0 0.0 0.0");
}
