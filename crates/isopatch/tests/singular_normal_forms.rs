//! Simple singularities (Arnold's A, D, E) turned and moved, in several boxes: each must be found, alone.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Point3};
use isopatch::singular::{PointKind, SingularOptions, SingularSet, Status, singular_set};

/// Name, formula with the singular point at the origin and no other, Tjurina number, Hessian.
const FORMS: [(&str, &str, usize, PointKind); 26] = {
    use PointKind::{Degenerate, Isolated, Node};
    [
        ("A1", "x^2+y^2-z^2", 1, Node),
        ("A1+", "x^2+y^2+z^2", 1, Isolated),
        ("A2", "x^2+y^2-z^3", 2, Degenerate),
        ("A2+", "x^2+y^2+z^3", 2, Degenerate),
        ("A3", "x^2+y^2-z^4", 3, Degenerate),
        ("A3+", "x^2+y^2+z^4", 3, Degenerate),
        ("A3 saddle", "x^2-y^2+z^4", 3, Degenerate),
        ("A4", "x^2+y^2-z^5", 4, Degenerate),
        ("A4+", "x^2+y^2+z^5", 4, Degenerate),
        ("A5", "x^2+y^2-z^6", 5, Degenerate),
        ("A5+", "x^2+y^2+z^6", 5, Degenerate),
        ("A6", "x^2+y^2-z^7", 6, Degenerate),
        ("A6+", "x^2+y^2+z^7", 6, Degenerate),
        ("A6 saddle", "x^2-y^2+z^7", 6, Degenerate),
        ("D4-", "x^2*y-y^3+z^2", 4, Degenerate),
        ("D4+", "x^2*y+y^3+z^2", 4, Degenerate),
        ("D4- other side", "x^2*y-y^3-z^2", 4, Degenerate),
        ("D5", "x^2*y+y^4+z^2", 5, Degenerate),
        ("D5 other side", "x^2*y+y^4-z^2", 5, Degenerate),
        ("E6", "x^3+y^4+z^2", 6, Degenerate),
        ("E6 other side", "x^3+y^4-z^2", 6, Degenerate),
        ("E7", "x^3+x*y^3+z^2", 7, Degenerate),
        ("E8", "x^3+y^5+z^2", 8, Degenerate),
        ("E8 other side", "x^3+y^5-z^2", 8, Degenerate),
        ("curved A3", "x^2+y^2*z-z^2", 3, Degenerate),
        ("curved A5", "x^2+(z-y^2)^2-y^6", 5, Degenerate),
    ]
};

/// Rational rotations: integer quaternions.
const ROTATIONS: [[i32; 4]; 4] = [[1, 0, 0, 0], [2, 1, 0, 0], [3, -1, 2, 1], [5, 2, -4, 3]];

/// Where the singular point is moved to, over 30.
const PLACES: [[i32; 3]; 4] = [[0, 0, 0], [10, -5, 6], [-7, 11, 3], [3, 4, -9]];

/// f(R(x − p)).
fn placed(text: &str, [a, b, c, d]: [i32; 4], place: [i32; 3]) -> String {
    let n = a * a + b * b + c * c + d * d;
    let rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ];
    let from = |i: usize| format!("({}-({})/30)", ["x", "y", "z"][i], place[i]);
    let row =
        |r: [i32; 3]| format!("((({})*{}+({})*{}+({})*{})/{n})", r[0], from(0), r[1], from(1), r[2], from(2));
    let marked = text.replace('x', "X").replace('y', "Y").replace('z', "Z");
    marked.replace('X', &row(rows[0])).replace('Y', &row(rows[1])).replace('Z', &row(rows[2]))
}

fn boxes() -> [Aabb; 4] {
    let new = |a: [f64; 3], b: [f64; 3]| Aabb::new(Point3::from(a), Point3::from(b));
    [
        new([-1.0; 3], [1.0; 3]),
        new([-1.5; 3], [1.5; 3]),
        new([-0.9, -1.37, -0.61], [1.73, 0.83, 2.11]),
        new([-3.3, -2.0, -1.1], [0.95, 3.7, 1.3]),
    ]
}

fn found(text: &str, bounds: &Aabb) -> SingularSet {
    let formula = Formula::parse(text, &Constants::new()).unwrap_or_else(|e| panic!("{text}: {e}"));
    singular_set(&formula, bounds, &SingularOptions::default()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn check(name: &str, text: &str, bounds: &Aabb, at: Point3, multiplicity: usize, kind: PointKind) {
    let set = found(text, bounds);
    assert!(set.curves.is_empty() && set.points.len() == 1, "{name} in {bounds:?}: {set:?}");
    let point = &set.points[0];
    assert!((point.at - at).norm() < 1e-14, "{name} in {bounds:?}: {point:?}");
    let expected = (kind, Some(multiplicity), Status::Exact);
    assert_eq!((point.kind, point.multiplicity, point.status), expected, "{name} in {bounds:?}");
}

#[test]
fn simple_singularities_are_found_wherever_they_are() {
    for (name, text, multiplicity, kind) in FORMS {
        for ((rotation, place), bounds) in ROTATIONS.into_iter().zip(PLACES).zip(boxes()).skip(1).step_by(2) {
            let at = Point3::from_fn(|a, _| f64::from(place[a]) / 30.0);
            check(name, &placed(text, rotation, place), &bounds, at, multiplicity, kind);
        }
    }
}

#[test]
fn points_beside_curves_are_found() {
    // A plane cuts each in a curve; it passes the point at a distance of 1/40 or more.
    let forms = [
        ("A3", "(x^2+y^2-z^4)*(z-1/4)", 3),
        ("curved A3", "(x^2+y^2*z-z^2)*(x+y/2-1/10)", 3),
        ("A5", "(x^2-y^2+z^6)*(z+2*y-1/6)", 5),
        ("D4", "(x^2*y-y^3+z^2)*(y+1/5)", 4),
        ("E6", "(x^3+y^4-z^2)*(x-z-1/7)", 6),
        ("node", "(x^2+y^2-z^2)*(z-1/40)", 1),
    ];
    for (name, text, multiplicity) in forms {
        for (rotation, bounds) in ROTATIONS.into_iter().zip(boxes()).skip(1).step_by(2) {
            let place = PLACES[1];
            let set = found(&placed(text, rotation, place), &bounds);
            let at = Point3::from_fn(|a, _| f64::from(place[a]) / 30.0);
            assert_eq!(set.points.len(), 1, "{name} in {bounds:?}: {:?}", set.points);
            let point = &set.points[0];
            assert!((point.at - at).norm() < 1e-14, "{name} in {bounds:?}: {point:?}");
            assert_eq!(point.multiplicity, Some(multiplicity), "{name} in {bounds:?}");
            assert!(!set.curves.is_empty(), "{name} in {bounds:?}");
        }
    }
}

#[test]
fn the_point_of_calypso_is_no_arc() {
    for half in [0.7, 1.0, 1.3, 1.5, 2.0, 3.1] {
        let bounds = Aabb::new(Point3::repeat(-half), Point3::repeat(half));
        check("calypso", "x^2+y^2*z-z^2", &bounds, Point3::zeros(), 3, PointKind::Degenerate);
    }
}
