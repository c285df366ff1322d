//! Singular points, singular curves and components of algebraic surfaces, against a computer algebra system.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

#[path = "support/singular_golden.rs"]
mod singular_golden;

use isopatch::field::{Field, Polynomial};
use isopatch::geom::{Aabb, Point3};
use isopatch::singular::{
    Analysis, CurveKind, LowerDimensional, PointKind, SingularError, SingularOptions, SingularPoint,
    SpecialKind, Status, singular_set,
};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};
use singular_golden::{Golden, T, analysed, formula, relative};

fn cube(half: f64) -> Aabb {
    Aabb::new(Point3::repeat(-half), Point3::repeat(half))
}

fn check(name: &str, golden: &Golden) {
    let Analysis { singular: set, components } = analysed(&golden.text, &golden.bounds);
    let size = relative(&golden.bounds);
    let expected = golden.points("isolated_real_singular_points");
    assert_eq!(set.points.len(), expected.len(), "{name}: {:?}", set.points);
    for p in &expected {
        let near = set.points.iter().filter(|q| (q.at - p).norm() <= 1e-10 * size).count();
        assert_eq!(near, 1, "{name}: {p:?}");
    }
    assert!(set.points.iter().all(|p| p.status == Status::Exact), "{name}: {:?}", set.points);

    // The equations hold along the curves, relative to their size in the box.
    let field = formula(&golden.text);
    let repeated = golden.entry["nonreduced"] == true;
    let corners = golden.bounds.corners().map(|c| field.gradient(c));
    let largest = corners.iter().fold(0.0_f64, |m, (f, g)| m.max(f.abs()).max(size * g.norm()));
    let samples: Vec<Point3> = set.curves.iter().flat_map(|c| &c.samples).map(|s| s.at).collect();
    for p in &samples {
        assert!(golden.bounds.grown(1e-9 * size).contains(p), "{name}: {p:?} outside");
        let (value, gradient) = field.gradient(*p);
        assert!(value.abs() <= 1e-10 * largest, "{name}: f = {value:e} at {p:?}");
        assert!(size * gradient.norm() <= 1e-10 * largest, "{name}: gradient {gradient:?} at {p:?}");
    }
    for p in golden.curve_points() {
        let distance = samples.iter().map(|s| (s - p).norm()).fold(f64::INFINITY, f64::min);
        assert!(distance <= 1e-3 * size, "{name}: {p:?} is {distance:e} from the curves");
    }
    let has_curves = golden.entry["singular_curves"].is_array();
    assert!(has_curves || repeated || set.curves.is_empty(), "{name}: {} curves", set.curves.len());

    let special = golden.points("special_points_on_curves");
    for p in &special {
        assert!(
            set.special.iter().any(|s| (s.at - p).norm() <= 1e-10 * size && s.kind != SpecialKind::Box),
            "{name}: {p:?} is missing in {:?}",
            set.special
        );
    }
    let inner = set.special.iter().filter(|s| s.kind != SpecialKind::Box).count();
    assert_eq!(inner, special.len(), "{name}: {:?}", set.special);

    let components = components.unwrap();
    assert_eq!(components.seeds.len() as u64, golden.entry["components_in_box"].as_u64().unwrap(), "{name}");
    for seed in &components.seeds {
        assert!(golden.bounds.grown(1e-9 * size).contains(seed), "{name}");
        assert!(field.value(*seed).abs() <= 1e-10 * largest, "{name}: f = {:e}", field.value(*seed));
    }
}

/// Surfaces along whose curves the Hessian has rank 1 or 0: they take seconds.
const SLOW: [&str; 5] = ["crixxi", "daisy", "heart", "nepali", "swallowtail"];

#[test]
fn points_curves_and_components_are_those_of_computer_algebra() {
    let all = Golden::all();
    assert_eq!(all.len(), 32);
    for (name, golden) in all.iter().filter(|(name, _)| !SLOW.contains(&name.as_str())) {
        check(name, golden);
    }
}

#[test]
fn cusps_and_flat_curves_are_those_of_computer_algebra() {
    for (name, golden) in Golden::all().iter().filter(|(name, _)| SLOW.contains(&name.as_str())) {
        check(name, golden);
    }
}

fn barth_sextic() -> String {
    format!("4({T}^2x^2-y^2)({T}^2y^2-z^2)({T}^2z^2-x^2)-(1+2{T})(x^2+y^2+z^2-1)^2")
}

#[test]
fn the_nodes_of_the_barth_sextic_are_proven() {
    let set = singular_set(&formula(&barth_sextic()), &cube(2.0), &SingularOptions::default()).unwrap();
    assert_eq!(set.points.len(), 50);
    for p in &set.points {
        assert_eq!((p.kind, p.multiplicity, p.status), (PointKind::Node, Some(1), Status::Exact));
        assert!(p.radius < 1e-13);
    }
}

#[test]
fn the_barth_decic_has_300_nodes() {
    let text = format!(
        "8(x^2-{T}^4y^2)(y^2-{T}^4z^2)(z^2-{T}^4x^2)(x^4+y^4+z^4-2x^2y^2-2x^2z^2-2y^2z^2)\
         +(3+5{T})(x^2+y^2+z^2-1)^2(x^2+y^2+z^2-(2-{T}))^2"
    );
    let set = singular_set(&formula(&text), &cube(2.0), &SingularOptions::default()).unwrap();
    assert_eq!((set.points.len(), set.curves.len()), (300, 0));
    assert!(set.points.iter().all(|p| p.status == Status::Exact));
}

/// f with the coordinates turned: entries of the matrix over 3.
fn turned(text: &str) -> String {
    let rows = ["(2x-y+2z)/3", "(2x+2y-z)/3", "(-x+2y+2z)/3"];
    let marked = text.replace('x', "X").replace('y', "Y").replace('z', "Z");
    let mut result = marked;
    for (name, row) in ["X", "Y", "Z"].iter().zip(rows) {
        result = result.replace(name, &format!("({row})"));
    }
    result
}

#[test]
fn a_rotation_about_the_centre_changes_no_count() {
    let cayley = "1-x^2-y^2-z^2+2*x*y*z";
    for (text, nodes) in [(cayley, 4), ("x^2+y^2-z^2", 1), ("x^2+y^2-z^3", 1), ("x^3-3*x*y^2+z^2", 1)] {
        let set = analysed(&turned(text), &cube(2.5)).singular;
        assert_eq!((set.points.len(), set.curves.len()), (nodes, 0), "{text}: {:?}", set.points);
        let plain = analysed(text, &cube(2.5)).singular;
        let multiplicities =
            |points: &[SingularPoint]| points.iter().map(|p| (p.multiplicity, p.kind)).collect::<Vec<_>>();
        assert_eq!(multiplicities(&set.points), multiplicities(&plain.points), "{text}");
    }
    let umbrella = analysed(&turned("x^2-y*z^2"), &cube(1.0)).singular;
    let mut kinds: Vec<CurveKind> = umbrella.curves.iter().map(|c| c.kind).collect();
    kinds.sort_by_key(|k| *k == CurveKind::Stick);
    assert_eq!(kinds, [CurveKind::Crossing, CurveKind::Stick]);
    let pinch: Vec<_> = umbrella.special.iter().filter(|s| s.kind == SpecialKind::Pinch).collect();
    assert!(pinch.len() == 1 && pinch[0].at.norm() < 1e-10, "{:?}", umbrella.special);
}

#[test]
fn a_singular_point_in_a_side_of_the_box_counts() {
    let half = Aabb::new(Point3::new(-1.0, -1.0, 0.0), Point3::new(1.0, 1.0, 2.0));
    let cone = analysed("x^2+y^2-z^2", &half);
    assert_eq!((cone.singular.points.len(), cone.components.unwrap().seeds.len()), (1, 1));
    let beside = Aabb::new(Point3::new(-1.0, -1.0, 1e-6), Point3::new(1.0, 1.0, 2.0));
    assert!(analysed("x^2+y^2-z^2", &beside).singular.is_empty());
}

#[test]
fn a_box_that_touches_the_surface_holds_one_point_of_it() {
    let beside = Aabb::new(Point3::new(1.0, -1.0, -1.0), Point3::new(2.0, 1.0, 1.0));
    let found = analysed("x^2+y^2+z^2-1", &beside);
    assert!(found.singular.is_empty());
    let seeds = found.components.unwrap().seeds;
    assert!(seeds.len() == 1 && (seeds[0] - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-6, "{seeds:?}");
    let farther = Aabb::new(Point3::new(1.001, -1.0, -1.0), Point3::new(2.0, 1.0, 1.0));
    assert!(analysed("x^2+y^2+z^2-1", &farther).components.unwrap().seeds.is_empty());
}

#[test]
fn parts_of_lower_dimension_are_listed() {
    let found = analysed("(x^2+y^2+z^2)*(x-1)+x^4", &cube(2.0)).singular;
    assert_eq!(found.lower_dimensional, [LowerDimensional::Point(0)]);
    let stick = analysed("x^2-y z^2", &cube(1.0)).singular;
    // The line is singular as a whole: that is proven.
    assert!(stick.curves.iter().all(|c| c.status == Status::Exact), "{:?}", stick.special);
    assert_eq!(stick.lower_dimensional.len(), 1);
    assert_eq!(stick.lower_dimensional[0].dimension(), 1);
}

#[test]
fn what_can_not_be_done_is_said() {
    let error =
        |text: &str| singular_set(&formula(text), &cube(1.0), &SingularOptions::default()).unwrap_err();
    assert_eq!(error("sin(x)+y"), SingularError::NotPolynomial);
    assert_eq!(error("2"), SingularError::Constant);
    assert_eq!(error("(x-sqrt(2)y)^2"), SingularError::Repeated);
    assert!(matches!(error("x^30+y"), SingularError::Degree { degree: 30, .. }));
    let flat = Aabb::new(Point3::zeros(), Point3::new(1.0, 1.0, 0.0));
    assert_eq!(singular_set(&formula("x"), &flat, &SingularOptions::default()), Err(SingularError::Box));
}

/// The resultant of two polynomials by z, at rational (x, y): the determinant of Sylvester's matrix.
fn resultant(f: &Polynomial, g: &Polynomial, x: &BigRational, y: &BigRational) -> BigRational {
    let coefficients = |p: &Polynomial| {
        let degree = p.terms().map(|(e, _)| e[2] as usize).max().unwrap_or(0);
        let mut list = vec![BigRational::zero(); degree + 1];
        for (e, c) in p.terms() {
            list[degree - e[2] as usize] += c * x.pow(e[0] as i32) * y.pow(e[1] as i32);
        }
        list
    };
    let (f, g) = (coefficients(f), coefficients(g));
    let (m, n) = (f.len() - 1, g.len() - 1);
    let mut rows = vec![vec![BigRational::zero(); m + n]; m + n];
    for i in 0..n {
        f.iter().enumerate().for_each(|(k, c)| rows[i][i + k] = c.clone());
    }
    for i in 0..m {
        g.iter().enumerate().for_each(|(k, c)| rows[n + i][i + k] = c.clone());
    }
    let mut determinant = BigRational::one();
    for k in 0..m + n {
        let Some(pivot) = (k..m + n).find(|r| !rows[*r][k].is_zero()) else { return BigRational::zero() };
        if pivot != k {
            rows.swap(pivot, k);
            determinant = -determinant;
        }
        determinant *= &rows[k][k];
        for r in k + 1..m + n {
            let factor = &rows[r][k] / &rows[k][k];
            for c in k..m + n {
                let change = &factor * &rows[k][c];
                rows[r][c] -= change;
            }
        }
    }
    determinant
}

#[test]
fn resultants_lose_singular_points_without_a_shear() {
    // Section 3: points with f = f_x = f_y = 0 are projected along z by resultants. The derivatives of the cone, of the
    // ding-dong and of the cusp are free of z, so that Res_z(f_x, f_y) is the empty determinant, 1, even below the
    // singular point; after a shear it vanishes there, and is not zero everywhere.
    let origin = BigRational::zero();
    let elsewhere = BigRational::from(BigInt::from(3));
    for text in ["x^2+y^2-z^2", "x^2+y^2+z^3-z^2", "x^2+y^2-z^3"] {
        let derivatives = |text: &str| {
            let f = formula(text).polynomial().unwrap().clone();
            [f.derivative(0), f.derivative(1)]
        };
        let [fx, fy] = derivatives(text);
        assert!(resultant(&fx, &fy, &origin, &origin).is_one(), "{text}");
        // A generic combination of the coordinates in place of x and y.
        let sheared = text.replace('x', "(x+2z)").replace('y', "(y-3z)").replace("z^", "(z+x+5y)^");
        let [fx, fy] = derivatives(&sheared);
        assert!(resultant(&fx, &fy, &origin, &origin).is_zero(), "{sheared}");
        assert!(!resultant(&fx, &fy, &elsewhere, &BigRational::one()).is_zero(), "{sheared}");
    }
}
