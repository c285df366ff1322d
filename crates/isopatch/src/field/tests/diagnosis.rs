//! Where formulas are not differentiable or not defined.

use super::super::Field;
use super::*;
use crate::geom::Point3;

const TOLERANCE: f64 = 1e-9;

fn told(text: &str, p: [f64; 3]) -> Option<String> {
    formula(text).kink_near(Point3::from(p), TOLERANCE).map(|kink| kink.to_string())
}

/// Without the advice that follows.
fn kink(text: &str, p: [f64; 3]) -> Option<String> {
    told(text, p).and_then(|message| Some(message.split_once("; smooth is ")?.0.to_owned()))
}

fn failure(text: &str, p: [f64; 3]) -> Option<String> {
    formula(text).domain_error(Point3::from(p)).map(|error| error.to_string())
}

#[test]
fn kinks_are_found_with_their_tokens() {
    assert_eq!(
        kink("x + min(y, z)", [0.3, 0.5, 0.5]).as_deref(),
        Some("min at column 5: both branches are equal")
    );
    assert_eq!(
        kink("max(x, y, z)", [0.5, 0.5, 0.1]).as_deref(),
        Some("max at column 1: both branches are equal")
    );
    assert_eq!(
        kink("abs(x) + y", [1e-12, 0.5, 0.5]).as_deref(),
        Some("abs at column 1: its argument is zero")
    );
    assert_eq!(
        kink("z - sqrt(x^2+y^2)", [0.0, 0.0, 0.0]).as_deref(),
        Some("sqrt at column 5: its argument is zero")
    );
    assert_eq!(
        kink("z - sqrt(x^2+y^2)", [1e-12, 0.0, 0.0]).as_deref(),
        Some("sqrt at column 5: its argument is zero")
    );
    assert_eq!(kink("y + x^0.5", [0.0, 0.0, 0.0]).as_deref(), Some("power at column 6: its base is zero"));
    assert_eq!(
        kink("abs(x)+abs(y)+abs(z)-1", [0.5, 0.5, 0.0]).as_deref(),
        Some("abs at column 15: its argument is zero")
    );
}

#[test]
fn kinks_are_told_with_what_has_none() {
    for (text, smooth) in [
        ("min(x, y)", "(a + b - sqrt((a - b)^2 + e^2))/2 in place of min(a, b)"),
        ("max(x, y)", "(a + b + sqrt((a - b)^2 + e^2))/2 in place of max(a, b)"),
        ("z + abs(x)", "sqrt(a^2 + e^2) in place of abs(a)"),
        ("z - sqrt(x^2+y^2)", "sqrt(a + e^2) in place of sqrt(a)"),
        ("y + x^0.5", "(a^2 + e^2)^(p/2) in place of a^p"),
    ] {
        let message = told(text, [0.0; 3]).unwrap_or_default();
        assert!(message.contains(smooth), "{text}: {message}");
    }
}

#[test]
fn smooth_places_are_not_kinks() {
    assert_eq!(told("x + min(y, z)", [0.3, 0.5, 0.5001]), None);
    assert_eq!(told("abs(x) + y", [1e-6, 0.5, 0.5]), None);
    // The inner min is not the larger branch.
    assert_eq!(told("max(min(x, y), z)", [0.1, 0.1, 0.5]), None);
    assert!(kink("max(min(x, y), z)", [0.1, 0.1, -0.5]).is_some());
    // |x|² and |x²| are smooth.
    assert_eq!(told("abs(x)^2 + y", [1e-12, 0.5, 0.5]), None);
    assert_eq!(told("abs(x^2) + y", [0.0, 0.5, 0.5]), None);
    assert_eq!(told("min(x, x) + y", [0.2, 0.5, 0.5]), None);
    assert_eq!(told(TORUS, [6.0, 0.0, 0.0]), None);
    assert_eq!(told(DECOCUBE, [0.0, 0.0, 0.0]), None);
}

#[test]
fn the_distance_to_a_kink_is_a_length() {
    for scale in [1e-6, 1.0, 1e6] {
        let formula = formula("abs(1000x) + y");
        let kink = formula.kink_near(Point3::new(1e-4 * scale, scale, 0.0), 1e-3 * scale).expect("close");
        assert!((kink.distance / scale - 1e-4).abs() < 1e-12);
        assert_eq!(formula.kink_near(Point3::new(1e-4 * scale, scale, 0.0), 1e-5 * scale), None);
    }
}

#[test]
fn failures_are_found_with_their_tokens() {
    for (text, p, message) in [
        ("y + sqrt(x)", [-1.0, 0.0, 0.0], "column 5: square root of a negative number"),
        ("log(x)", [0.0, 0.0, 0.0], "column 1: logarithm of a number that is not positive"),
        ("1 + 1/(x-y)", [2.0, 2.0, 0.0], "column 6: division by zero"),
        ("x^-2", [0.0, 2.0, 0.0], "column 2: division by zero"),
        ("asin(x)", [1.5, 2.0, 0.0], "column 1: argument outside -1 to 1"),
        ("z + x^0.5", [-1.5, 2.0, 0.0], "column 6: a power that is not whole, of a negative number"),
        ("exp(x)", [1e4, 2.0, 0.0], "column 1: the result is too large"),
        ("1/(2-2) + x", [0.0, 0.0, 0.0], "column 2: division by zero"),
        ("y + x", [f64::NAN, 0.0, 0.0], "column 5: the coordinate is not finite"),
        ("min(x, sqrt(y))", [0.0, -1.0, 0.0], "column 8: square root of a negative number"),
    ] {
        assert_eq!(failure(text, p).as_deref(), Some(message), "{text}");
        assert!(!formula(text).value(Point3::from(p)).is_finite());
    }
    assert_eq!(failure("sqrt(x)", [0.0, 0.0, 0.0]), None);
}
