//! Singular points, singular curves and components of algebraic surfaces, against a computer algebra system.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use isopatch::field::{Constants, Field, Formula, Polynomial};
use isopatch::geom::{Aabb, Point3};
use isopatch::singular::{
    Analysis, CurveKind, LowerDimensional, PointKind, SingularError, SingularOptions, SingularPoint,
    SingularSet, SpecialKind, Status, analyse, singular_set,
};
use nalgebra::Matrix3;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};
use serde_json::{Map, Value};
use std::path::Path;

/// The golden ratio.
const T: &str = "((1+sqrt(5))/2)";

fn formula(text: &str) -> Formula {
    Formula::parse(text, &Constants::new()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn cube(half: f64) -> Aabb {
    Aabb::new(Point3::repeat(-half), Point3::repeat(half))
}

fn analysed(text: &str, bounds: &Aabb) -> Analysis {
    analyse(&formula(text), bounds, &SingularOptions::default()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// A surface of the golden file.
struct Golden {
    text: String,
    bounds: Aabb,
    entry: Value,
}

impl Golden {
    fn all() -> Vec<(String, Self)> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/singular.json");
        let json: Map<String, Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        json.into_iter().map(|(name, entry)| (name, Self::new(entry))).collect()
    }

    fn new(entry: Value) -> Self {
        let number = |v: &Value| match v.as_str() {
            Some(text) => formula(text).constant().unwrap(),
            None => v.as_f64().unwrap(),
        };
        let side = |a: usize, k: usize| number(&entry["box"][a][k]);
        let corner = |k: usize| Point3::from_fn(|a, _| side(a, k));
        let mut text = entry["f"].as_str().unwrap().replace("**", "^");
        // Rational(a,b) is a/b.
        while let Some(start) = text.find("Rational(") {
            let end = start + text[start..].find(')').unwrap();
            let quotient = text[start + "Rational".len()..end].replace(',', "/");
            text.replace_range(start..end, &quotient);
        }
        if entry["golden_ratio_t"] == true {
            text = text.replace('t', T);
        }
        Self { text, bounds: Aabb::new(corner(0), corner(1)), entry }
    }

    fn points(&self, key: &str) -> Vec<Point3> {
        let list = self.entry[key].as_array().cloned().unwrap_or_default();
        list.iter().map(|p| Point3::from_fn(|a, _| p[a].as_f64().unwrap())).collect()
    }

    /// Points of the curves that the file gives parameters for, in the box.
    fn curve_points(&self) -> Vec<Point3> {
        let mut points = Vec::new();
        for curve in self.entry["singular_curves"].as_array().into_iter().flatten() {
            let Some(parameters) = curve["param"].as_array() else { continue };
            for i in -80..=80 {
                // From −4 to 4, not through values of note.
                let mut constants = Constants::new();
                constants.set("s", 0.05 * f64::from(i) + 0.0037).unwrap();
                let value = |v: &Value| {
                    let text = v.as_str().unwrap().replace("**", "^");
                    Formula::parse(&text, &constants).unwrap().value(Point3::zeros())
                };
                let p = Point3::new(value(&parameters[0]), value(&parameters[1]), value(&parameters[2]));
                if self.bounds.contains(&p) {
                    points.push(p);
                }
            }
        }
        points
    }
}

/// The size of the box counts as 1.
fn relative(bounds: &Aabb) -> f64 {
    bounds.size().max()
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

/// The sphere inscribed in a box, with the surface turned about its centre.
struct Turned {
    center: Point3,
    radius: f64,
    /// Rows of the rotation.
    rotation: Matrix3<f64>,
    text: String,
}

impl Turned {
    /// By an integer quaternion, and scaled by 15/16.
    fn new(golden: &Golden, [a, b, c, d]: [i32; 4]) -> Self {
        let n = a * a + b * b + c * c + d * d;
        let rows = [
            [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
        ];
        let center = golden.bounds.center();
        let number = |i: usize| BigRational::from_float(center[i]).unwrap();
        let from = |i: usize| format!("({}-({}))", ["x", "y", "z"][i], number(i));
        let mut text = golden.text.replace('x', "X").replace('y', "Y").replace('z', "Z");
        for (i, name) in ["X", "Y", "Z"].iter().enumerate() {
            let r = rows[i];
            let sum = format!("({})*{}+({})*{}+({})*{}", r[0], from(0), r[1], from(1), r[2], from(2));
            text = text.replace(name, &format!("(16*({sum})/{}+({}))", 15 * n, number(i)));
        }
        let rotation = Matrix3::from_fn(|i, j| f64::from(rows[i][j]) / f64::from(n));
        Self { center, radius: 0.5 * golden.bounds.size().min(), rotation, text }
    }

    /// A point of the surface as it was, where it is now.
    fn image(&self, p: Point3) -> Point3 {
        self.center + self.rotation.transpose() * (p - self.center) * 15.0 / 16.0
    }

    fn holds(&self, p: Point3) -> bool {
        (p - self.center).norm() < 0.9 * self.radius
    }
}

fn check_turned(name: &str, golden: &Golden, quaternion: [i32; 4]) {
    let turned = Turned::new(golden, quaternion);
    let size = relative(&golden.bounds);
    let plain = analysed(&golden.text, &golden.bounds);
    let found = analysed(&turned.text, &golden.bounds);
    let (old, new) = (&plain.singular, &found.singular);

    let images: Vec<Point3> = old.points.iter().map(|p| turned.image(p.at)).collect();
    for (p, image) in old.points.iter().zip(&images).filter(|(_, image)| turned.holds(**image)) {
        let same = |q: &&SingularPoint| (q.at - image).norm() < 1e-10 * size;
        let near: Vec<&SingularPoint> = new.points.iter().filter(same).collect();
        assert_eq!(near.len(), 1, "{name}: {p:?} at {image:?} in {:?}", new.points);
        assert_eq!((near[0].kind, near[0].multiplicity), (p.kind, p.multiplicity), "{name}");
    }
    for q in new.points.iter().filter(|q| turned.holds(q.at)) {
        assert!(images.iter().any(|p| (p - q.at).norm() < 1e-10 * size), "{name}: {q:?} invented");
    }

    let inner = |set: &SingularSet| -> Vec<(Point3, SpecialKind)> {
        set.special.iter().filter(|s| s.kind != SpecialKind::Box).map(|s| (s.at, s.kind)).collect()
    };
    let places: Vec<(Point3, SpecialKind)> =
        inner(old).into_iter().map(|(p, kind)| (turned.image(p), kind)).collect();
    for (p, kind) in places.iter().filter(|(p, _)| turned.holds(*p)) {
        let near = inner(new).into_iter().filter(|(q, k)| (p - q).norm() < 1e-9 * size && k == kind).count();
        assert_eq!(near, 1, "{name}: {kind:?} at {p:?} in {:?}", new.special);
    }
    for (q, kind) in inner(new).iter().filter(|(q, _)| turned.holds(*q)) {
        assert!(
            places.iter().any(|(p, _)| (p - q).norm() < 1e-9 * size),
            "{name}: {kind:?} at {q:?} invented"
        );
    }

    // Every arc is covered by arcs of its kind, both ways.
    let samples = |set: &SingularSet, image: &dyn Fn(Point3) -> Point3| -> Vec<(Point3, CurveKind)> {
        set.curves.iter().flat_map(|c| c.samples.iter().map(|s| (image(s.at), c.kind))).collect()
    };
    let before = samples(old, &|p| turned.image(p));
    let after = samples(new, &|p| p);
    for (from, to) in [(&before, &after), (&after, &before)] {
        // One in eight will do.
        for (p, kind) in from.iter().filter(|(p, _)| turned.holds(*p)).step_by(8) {
            let distance = to
                .iter()
                .filter(|(_, k)| k == kind)
                .map(|(q, _)| (p - q).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(distance <= 2e-3 * size, "{name}: {kind:?} at {p:?} is {distance:e} from the others");
        }
    }

    // Surfaces that do not reach the sphere.
    let field = formula(&turned.text);
    let crosses = (0..4000).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        field.value(turned.center + turned.radius * Point3::new(flat * cos, flat * sin, z)) > 0.0
    });
    let signs: std::collections::BTreeSet<bool> = crosses.collect();
    if let (1, Some(a), Some(b)) = (signs.len(), &plain.components, &found.components) {
        let held = |seeds: &[Point3]| seeds.iter().filter(|p| turned.holds(**p)).count();
        let images: Vec<Point3> = a.seeds.iter().map(|p| turned.image(*p)).collect();
        assert_eq!(held(&images), held(&b.seeds), "{name}: components");
    }
}

/// Drawn at random, and then kept.
const QUATERNIONS: [[i32; 4]; 4] = [[3, 1, -2, 1], [2, -1, 1, 3], [4, 3, -1, 2], [1, 2, 3, -4]];

#[test]
fn turned_surfaces_have_the_same_singularities() {
    for (i, (name, golden)) in Golden::all().iter().enumerate() {
        if !SLOW.contains(&name.as_str()) {
            check_turned(name, golden, QUATERNIONS[i % QUATERNIONS.len()]);
        }
    }
}

#[test]
#[ignore = "up to half a minute for each surface"]
fn turned_cusps_and_flat_curves_are_the_same() {
    for (i, (name, golden)) in Golden::all().iter().enumerate() {
        if SLOW.contains(&name.as_str()) {
            check_turned(name, golden, QUATERNIONS[i % QUATERNIONS.len()]);
        }
    }
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
