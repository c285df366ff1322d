//! Inputs made to go wrong: each is right, or ends with a message that says what is wrong with it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

#[path = "support/singular_golden.rs"]
mod singular_golden;

use isopatch::field::Field;
use isopatch::geom::{Aabb, Point3};
use isopatch::singular::{
    Analysis, CurveKind, PointKind, SingularError, SingularOptions, SpecialKind, Status, singular_set,
};
use singular_golden::{analysed, formula};

fn cube(half: f64) -> Aabb {
    Aabb::new(Point3::repeat(-half), Point3::repeat(half))
}

fn between(a: [f64; 3], b: [f64; 3]) -> Aabb {
    Aabb::new(a.into(), b.into())
}

fn error(text: &str, bounds: &Aabb) -> SingularError {
    singular_set(&formula(text), bounds, &SingularOptions::default()).unwrap_err()
}

/// Isolated points, arcs, special points that are not on the box, components. Nothing is left undecided, and seeds are on
/// the surface.
fn counts(text: &str, bounds: &Aabb) -> [usize; 4] {
    let Analysis { singular: set, components } = analysed(text, bounds);
    assert!(set.undecided.is_empty(), "{text}: {:?}", set.undecided);
    let inner = set.special.iter().filter(|s| s.kind != SpecialKind::Box).count();
    let seeds = components.unwrap_or_else(|| panic!("{text}")).seeds;
    let field = formula(text);
    for seed in &seeds {
        let (f, gradient) = field.gradient(*seed);
        let size = bounds.diagonal();
        assert!(f.abs() <= 1e-9 * size * gradient.norm().max(1e-3), "{text}: f = {f:e} at {seed:?}");
    }
    [set.points.len(), set.curves.len(), inner, seeds.len()]
}

/// The one isolated point.
fn only_point(text: &str, bounds: &Aabb) -> (Point3, PointKind, Status) {
    let set = analysed(text, bounds).singular;
    assert!(set.points.len() == 1 && set.curves.is_empty(), "{text}: {set:?}");
    (set.points[0].at, set.points[0].kind, set.points[0].status)
}

const TIP: (Point3, PointKind, Status) = (Point3::new(0.0, 0.0, 0.0), PointKind::Node, Status::Exact);

#[test]
fn a_squared_cone_is_a_cone() {
    assert_eq!(only_point("(x^2+y^2-z^2)^2", &cube(2.0)), TIP);
    assert_eq!(counts("(x^2+y^2-z^2)^2", &cube(2.0)), [1, 0, 0, 1]);
}

#[test]
fn a_plane_through_a_squared_sphere_crosses_it_once() {
    let text = "x*(x^2+y^2+z^2-1)^2";
    assert_eq!(counts(text, &cube(2.0)), [0, 1, 0, 1]);
    let set = analysed(text, &cube(2.0)).singular;
    assert!(set.curves[0].closed && set.curves[0].kind == CurveKind::Crossing);
}

#[test]
fn the_tip_of_a_cone_in_a_face_of_the_box() {
    assert_eq!(only_point("x^2+y^2-z^2", &between([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0])), TIP);
}

#[test]
fn the_tip_of_a_cone_in_an_edge_and_in_a_corner_of_the_box() {
    assert_eq!(only_point("x^2+y^2-z^2", &between([0.0, 0.0, -2.0], [1.0, 1.0, 2.0])), TIP);
    assert_eq!(only_point("x^2+y^2-z^2", &between([0.0, 0.0, 0.0], [1.0, 1.0, 2.0])), TIP);
}

#[test]
fn a_crossing_in_a_face_of_the_box() {
    // The circle x = 0, y² + z² = 3/4 lies in the side x = 0.
    let text = "((x-1/2)^2+y^2+z^2-1)*((x+1/2)^2+y^2+z^2-1)";
    assert_eq!(counts(text, &between([0.0, -2.0, -2.0], [2.0, 2.0, 2.0])), [0, 1, 0, 1]);
}

#[test]
fn a_box_that_touches_a_sphere_from_inside_and_outside() {
    let sphere = "x^2+y^2+z^2-1";
    assert_eq!(counts(sphere, &cube(1.0)), [0, 0, 0, 1]);
    assert_eq!(counts(sphere, &between([1.0, -1.0, -1.0], [2.0, 1.0, 1.0])), [0, 0, 0, 1]);
    assert_eq!(counts(sphere, &between([1.001, -1.0, -1.0], [2.0, 1.0, 1.0])), [0, 0, 0, 0]);
}

#[test]
fn no_real_point() {
    assert_eq!(counts("x^2+y^2+z^2+1", &cube(2.0)), [0; 4]);
    assert_eq!(counts("(x^2+y^2+z^2+1)^3", &cube(2.0)), [0; 4]);
}

#[test]
fn nothing_but_a_point_or_a_line() {
    assert_eq!(only_point("x^2+y^2+z^2", &cube(2.0)).1, PointKind::Isolated);
    assert_eq!(counts("x^2+y^2", &cube(2.0)), [0, 1, 0, 1]);
    let set = analysed("x^2+y^2", &cube(2.0)).singular;
    assert_eq!((set.curves[0].kind, set.lower_dimensional.len()), (CurveKind::Stick, 1));
}

#[test]
fn constants_are_no_surfaces() {
    assert_eq!(error("7", &cube(1.0)), SingularError::Constant);
    assert_eq!(error("x-x", &cube(1.0)), SingularError::Constant);
}

#[test]
fn two_and_three_planes() {
    assert_eq!(counts("x*y", &cube(2.0)), [0, 1, 0, 1]);
    assert_eq!(counts("x*y*z", &cube(2.0)), [0, 6, 1, 1]);
    assert_eq!(counts("x^2*y^2*z^2", &cube(2.0)), [0, 6, 1, 1]);
}

#[test]
fn a_triple_line() {
    assert_eq!(counts("x*y*(x-y)", &cube(2.0)), [0, 1, 0, 1]);
    assert_eq!(counts("x^3-3*x*y^2", &cube(2.0)), [0, 1, 0, 1]);
    // The Hessian has rank 0 there: no crossing of two sheets.
    let set = analysed("x*y*(x-y)", &cube(2.0)).singular;
    assert_eq!((set.curves[0].kind, set.curves[0].status), (CurveKind::Tangential, Status::Exact));
}

#[test]
fn coincident_curves_of_three_surfaces_are_one() {
    // A sphere, a plane and a cylinder through one circle, along which two of them touch. They part so slowly that bounds
    // leave boxes beside the circle undecided, and these are listed; nothing is invented in them.
    let set = analysed("z*(x^2+y^2-1)*(x^2+y^2+z^2-1)", &cube(2.0)).singular;
    assert_eq!((set.points.len(), set.curves.len(), set.special.len()), (0, 1, 0));
    assert!(set.curves[0].closed && set.curves[0].kind == CurveKind::Tangential);
    for b in &set.undecided {
        assert!(b.min.amax() < 1.1 && b.max.amax() < 1.1, "{b:?}");
    }
}

#[test]
fn tiny_and_huge_coefficients_change_nothing() {
    for factor in ["1e-12", "1e12", "1e-200"] {
        assert_eq!(only_point(&format!("{factor}*(x^2+y^2-z^2)"), &cube(2.0)), TIP, "{factor}");
    }
}

#[test]
fn a_nearly_singular_neck_is_smooth() {
    assert_eq!(counts("x^2+y^2-z^2-1e-9", &cube(2.0)), [0, 0, 0, 1]);
    // On the other side of the cone: two sheets.
    assert_eq!(counts("x^2+y^2-z^2+1/10000", &cube(2.0)), [0, 0, 0, 2]);
}

#[test]
fn degrees_that_are_too_high_are_refused_or_given_up() {
    let refused = error("x^20+y^20+z^20-1", &cube(2.0));
    assert_eq!(refused.to_string(), "the polynomial has degree 20; the limit is 16");
}

#[test]
fn formulas_with_functions_are_refused_by_name() {
    for text in ["sin(x)^2+sin(y)^2-z^2", "sqrt(x^2+y^2)-z", "exp(x)-y^2*z"] {
        assert_eq!(error(text, &cube(2.0)), SingularError::NotPolynomial, "{text}");
        assert!(error(text, &cube(2.0)).to_string().contains("polynomials only"));
    }
}

#[test]
fn flat_and_endless_boxes_are_refused() {
    let flat = between([0.0, -1.0, -1.0], [0.0, 1.0, 1.0]);
    assert_eq!(error("x^2+y^2-z^2", &flat), SingularError::Box);
    let reversed = between([1.0, -1.0, -1.0], [-1.0, 1.0, 1.0]);
    assert_eq!(error("x^2+y^2-z^2", &reversed), SingularError::Box);
    let endless = between([-1.0; 3], [1.0, 1.0, f64::INFINITY]);
    assert_eq!(error("x^2+y^2-z^2", &endless), SingularError::Box);
}

#[test]
fn spheres_that_touch_have_one_point_in_common() {
    let text = "((x-1)^2+y^2+z^2-1)*((x+1)^2+y^2+z^2-1)";
    let (at, kind, status) = only_point(text, &cube(2.0));
    assert_eq!((at, kind, status), (Point3::zeros(), PointKind::Degenerate, Status::Exact));
    assert_eq!(counts(text, &cube(2.0)), [1, 0, 0, 1]);
}

#[test]
fn a_sphere_of_a_thousandth_is_found() {
    assert_eq!(counts("x^2+y^2+z^2-1/1000000", &cube(2.0)), [0, 0, 0, 1]);
    let beside = "((x-1/3)^2+(y-1/5)^2+(z+1/7)^2-1/1000000)*(x^2+y^2+z^2-1)";
    assert_eq!(counts(beside, &cube(2.0)), [0, 0, 0, 2]);
}

#[test]
fn far_from_the_origin() {
    let bounds = between([999_999.0, -1.0, -1.0], [1_000_001.0, 1.0, 1.0]);
    let (at, kind, status) = only_point("(x-1000000)^2+y^2-z^2", &bounds);
    assert_eq!((at, kind, status), (Point3::new(1e6, 0.0, 0.0), PointKind::Node, Status::Exact));
}

#[test]
fn a_cylinder_through_a_cone_leaves_the_tip_alone() {
    let text = "(x^2+y^2-1)*(x^2+y^2-z^2)";
    assert_eq!(counts(text, &cube(2.0)), [1, 2, 0, 1]);
}

#[test]
fn nodes_of_a_high_degree_field_are_found() {
    // Their coordinates are cube roots and roots of y³ − y − 1: of degree 9 together, too high to be recognized.
    let text = "(x^3-2)^2+(y^3-y-1)^2-(z^3-z+1)^2";
    let set = analysed(text, &cube(2.0)).singular;
    assert_eq!(set.points.len(), 3);
    let expected = Point3::new(2.0_f64.cbrt(), 1.324_717_957_244_746, -1.324_717_957_244_746);
    assert!(set.points.iter().any(|p| (p.at - expected).norm() < 1e-12), "{:?}", set.points);
}

#[test]
fn spheres_that_nearly_coincide_are_given_up_with_a_message() {
    let message = error("(x^2+y^2+z^2-1)*(x^2+y^2+z^2-1.0000001)", &cube(2.0)).to_string();
    assert!(message.contains("boxes are left") || message.contains("given up"), "{message}");
}
