//! Input that can't be handled: status 1, one message that names the culprit, no file touched.

use super::{Folder, assert_fit_fails};

#[test]
fn unknown_names_are_pointed_at() {
    assert_fit_fails(&["x^2+y^2+q*z-1"], 1, &["column 9", "\"q\"", "\n  x^2+y^2+q*z-1\n          ^"]);
    assert_fit_fails(&["x^2+sn(y)"], 1, &["\"sn\""]);
    assert_fit_fails(&["x^2+y^2+z^2=r"], 1, &["\"r\"", "--set r=VALUE"]);
    assert_fit_fails(&["x^2+y^2+z^2<1"], 1, &["'<'", "write ="]);
}

#[test]
fn unknown_symbols_are_pointed_at() {
    assert_fit_fails(&["x^2+y^2#z"], 1, &["column 8", "'#'", "\n         ^"]);
}

#[test]
fn unbalanced_parentheses_are_pointed_at() {
    assert_fit_fails(&["(x^2+y^2 = 1"], 1, &["column 1", "\"(\" without \")\"", "\n  (x^2+y^2 = 1\n  ^"]);
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
    assert_fit_fails(
        &["torus", "--faces", "4"],
        1,
        &["4 faces are too few", " worked, and a tolerance (--tol) may do with fewer"],
    );
}

#[test]
fn formulas_that_only_touch_zero_have_no_surface() {
    for formula in
        ["x^2+y^2+z^2=0", "x^2+y^2=0", "(x^2+y^2+z^2-1)^2", "(x-1/3)^2+(y-1/7)^2+z^2", "exp(x^2+y^2+z^2)=1"]
    {
        assert_fit_fails(&[formula], 1, &["no surface was found", "nowhere negative", "points, curves"]);
    }
    let there = ["x^2+y^2+z^2=0", "--box", "-1,1,-1,1,-1,1"];
    assert_fit_fails(&there, 1, &["no surface in the box", "points", "isopatch singular"]);
    assert_fit_fails(&["x^2+y^2+z^2=-1"], 1, &["no surface was found", "positive everywhere"]);
}

#[test]
fn kinks_are_told_with_what_has_none() {
    let smooth = "x^2+y^2+z^2-1 + x-0.3 + sqrt((x^2+y^2+z^2-1 - (x-0.3))^2 + e^2)";
    assert_fit_fails(&["max(x^2+y^2+z^2-1, x-0.3)"], 1, &["smooth is (a + b + sqrt((a - b)^2 + e^2))/2"]);
    Folder::new().run(&["fit", smooth, "--set", "e=0.1"]).assert_done();
    let smooth = "sqrt(x^2+e^2)+sqrt(y^2+e^2)+sqrt(z^2+e^2)=1";
    assert_fit_fails(&["abs(x)+abs(y)+abs(z)=1"], 1, &["smooth is sqrt(a^2 + e^2) in place of abs(a)"]);
    Folder::new().run(&["fit", smooth, "--set", "e=0.1"]).assert_done();
}

#[test]
fn missing_files_are_named_once() {
    for (arguments, name) in [(&["no.obj"][..], "no.obj"), (&["sphere", "--base", "no.off"], "no.off")] {
        let folder = Folder::new();
        let run = folder.run(&[&["fit"], arguments].concat());
        run.assert_fails(1, &[name]);
        assert_eq!(run.stderr.matches(name).count(), 1, "{}", run.stderr);
    }
    assert_fit_fails(&["part.dwg"], 1, &["part.dwg", "no such file"]);
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
