//! Input that can't be handled: status 1, one message that names the culprit, no file touched.

use super::{Folder, assert_fit_fails};

#[test]
fn unknown_names_are_pointed_at() {
    assert_fit_fails(&["x^2+y^2+q*z-1"], 1, &["column 9", "\"q\"", "\n  x^2+y^2+q*z-1\n          ^"]);
    assert_fit_fails(&["x^2+sn(y)"], 1, &["\"sn\""]);
}

#[test]
fn unknown_symbols_are_pointed_at() {
    assert_fit_fails(&["x^2+y^2#z"], 1, &["column 8", "'#'", "\n         ^"]);
}

#[test]
fn unbalanced_parentheses_are_pointed_at() {
    assert_fit_fails(&["(x^2+(y^2+z^2-1"], 1, &["\"(\" without \")\"", "^"]);
    assert_fit_fails(&["x^2+y^2)+z^2-1"], 1, &["column 8", "\")\" without \"(\""]);
}

#[test]
fn slips_in_gallery_names_get_a_suggestion() {
    assert_fit_fails(&["decocub"], 1, &["\"decocub\"", "did you mean \"decocube\"?"]);
}

#[test]
fn long_formulas_are_refused() {
    let terms = vec!["x"; 50_000].join("+") + "0";
    assert_eq!(terms.len(), 100_000);
    assert_fit_fails(&[&terms], 1, &["100000 characters", "limit"]);
}

#[test]
fn deep_formulas_are_refused() {
    let depth = 10_000;
    let formula = "(".repeat(depth) + "x" + &")".repeat(depth);
    assert_fit_fails(&[&formula], 1, &["nested", "1000"]);
}

#[test]
fn a_box_without_surface_is_refused() {
    assert_fit_fails(&["x^2+y^2+z^2-1", "--box", "5,6,5,6,5,6"], 1, &["no surface in the box", "positive"]);
}

#[test]
fn unbounded_surfaces_without_a_box_are_refused() {
    assert_fit_fails(&["x+y+z"], 1, &["unbounded", "box"]);
}

#[test]
fn constant_fields_are_refused() {
    assert_fit_fails(&["3", "--box", "-1,1,-1,1,-1,1"], 1, &["the field is constant: 3"]);
    assert_fit_fails(&["0x", "--box", "-1,1,-1,1,-1,1"], 1, &["the field is constant: 0"]);
}

#[test]
fn fields_without_sign_change_are_refused() {
    assert_fit_fails(
        &["x^2+y^2+z^2+1", "--box", "-1,1,-1,1,-1,1"],
        1,
        &["no surface", "positive everywhere"],
    );
}

#[test]
fn fields_without_values_are_refused() {
    let message = ["square root of a negative number", "column 1"];
    assert_fit_fails(&["sqrt(-1-x^2-y^2-z^2)", "--box", "-1,1,-1,1,-1,1"], 1, &message);
}

#[test]
fn singular_surfaces_are_refused_with_the_place() {
    // The figure eight turned around its axis has a node at the origin.
    assert_fit_fails(
        &["x^4-x^2+y^2+z^2", "--method", "spline", "--box", "-1.3,1.3,-1.2,1.2,-1.2,1.2"],
        1,
        &["singular", "gradient vanishes at (", "0.000000"],
    );
}

#[test]
fn kinks_are_refused_with_place_and_function() {
    let run = ["max(abs(x),abs(y),abs(z))-1", "--box", "-1.5,1.5,-1.5,1.5,-1.5,1.5"];
    assert_fit_fails(&run, 1, &["not differentiable", "near (", "column 1", "max"]);
    // A curved kink, from a part cut off a sphere.
    let cut = ["max(x^2+y^2+z^2-1, x-0.3)", "--box", "-1.5,1.5,-1.5,1.5,-1.5,1.5"];
    assert_fit_fails(&cut, 1, &["not differentiable", "near (0.3", "column 1", "max"]);
}

#[test]
fn too_few_faces_are_refused_with_the_least_number() {
    assert_fit_fails(&["torus", "--faces", "4"], 1, &["4 faces are too few", "the least that works is"]);
}

#[test]
fn files_as_input_are_told_where_they_belong() {
    assert_fit_fails(&["part.isopatch"], 1, &["part.isopatch", "isopatch inspect", "isopatch convert"]);
    assert_fit_fails(&["notes.txt"], 1, &["notes.txt"]);
}

#[test]
fn unwritable_outputs_are_refused_before_the_work() {
    let folder = Folder::new();
    // So many patches would take minutes: the message comes before.
    let work = ["fit", "decocube", "--faces", "1000000", "-o"];
    for output in ["missing/a.step", "older.step/a.step"] {
        folder.run(&[&work[..], &[output]].concat()).assert_fails(1, &["cannot write", output]);
        folder.assert_untouched();
    }
    std::fs::create_dir(folder.path("folder.step")).unwrap();
    folder.run(&[&work[..], &["folder.step"]].concat()).assert_fails(1, &["cannot write folder.step"]);
    let report = [&work[..], &["older.step", "--report", "missing/r.json"]].concat();
    folder.run(&report).assert_fails(1, &["cannot write missing/r.json"]);
}

#[test]
fn missing_and_damaged_native_files_are_named() {
    let folder = Folder::new();
    for command in [&["inspect", "no.isopatch"][..], &["convert", "no.isopatch", "a.step"]] {
        folder.run(command).assert_fails(1, &["no.isopatch"]);
    }
    for command in [&["inspect", "older.step"][..], &["convert", "older.step", "a.step"]] {
        folder.run(command).assert_fails(1, &["older.step", "not an isopatch file"]);
    }
    folder.assert_untouched();
}
