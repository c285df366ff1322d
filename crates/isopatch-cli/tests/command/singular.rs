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
    assert!(run.stdout.contains("1 connected components"));
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
