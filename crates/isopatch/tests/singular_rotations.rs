//! Surfaces turned and scaled about the centre of their box: what is inside the inscribed sphere must stay what it is.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

#[path = "support/singular_golden.rs"]
mod singular_golden;

use isopatch::field::Field;
use isopatch::geom::Point3;
use isopatch::singular::{Analysis, CurveKind, SingularPoint, SingularSet, SpecialKind};
use nalgebra::Matrix3;
use num_rational::BigRational;
use singular_golden::{Golden, analysed, formula, relative};
use std::collections::BTreeSet;

/// Isolated points are located to this, relative to the box: the bound of the golden file.
const LOCATED: f64 = 1e-10;
/// Special points of curves are.
const SPECIAL: f64 = 1e-9;
/// Samples of curves are at most a thousandth of the box apart.
const COVERED: f64 = 1e-3;

/// The sphere inscribed in a box, with the surface turned about its centre and enlarged.
struct Turned {
    center: Point3,
    radius: f64,
    rotation: Matrix3<f64>,
    factor: f64,
    text: String,
}

impl Turned {
    /// By an integer quaternion, and by the factor p/q, which is at least 1: what the sphere holds then was in the box.
    fn new(golden: &Golden, [a, b, c, d]: [i32; 4], [p, q]: [i32; 2]) -> Self {
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
            text = text.replace(name, &format!("({q}*({sum})/{}+({}))", p * n, number(i)));
        }
        let rotation = Matrix3::from_fn(|i, j| f64::from(rows[i][j]) / f64::from(n));
        let factor = f64::from(p) / f64::from(q);
        Self { center, radius: 0.5 * golden.bounds.size().min(), rotation, factor, text }
    }

    /// A point of the surface as it was, where it is now.
    fn image(&self, p: Point3) -> Point3 {
        self.center + self.rotation.transpose() * (p - self.center) * self.factor
    }

    /// Is the point in the sphere, and not within `tolerance` of it?
    fn holds(&self, p: Point3, tolerance: f64) -> bool {
        (p - self.center).norm() < self.radius - tolerance
    }

    /// Does the surface stay away from the sphere? f is looked at in many points of it.
    fn is_bounded(&self) -> bool {
        let field = formula(&self.text);
        let signs = (0..4000).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            field.value(self.center + self.radius * Point3::new(flat * cos, flat * sin, z)) > 0.0
        });
        signs.collect::<BTreeSet<bool>>().len() == 1
    }
}

fn check(name: &str, golden: &Golden, plain: &Analysis, quaternion: [i32; 4], factor: [i32; 2]) {
    let name = &format!("{name} turned by {quaternion:?} times {factor:?}");
    let turned = Turned::new(golden, quaternion, factor);
    let size = relative(&golden.bounds);
    let found = analysed(&turned.text, &golden.bounds);
    let (old, new) = (&plain.singular, &found.singular);
    assert!(new.undecided.is_empty(), "{name}: {:?}", new.undecided);
    same_points(name, &turned, old, new, size);
    same_special_points(name, &turned, old, new, size);
    same_arcs(name, &turned, old, new, size);
    if turned.is_bounded() {
        let (a, b) = (plain.components.as_ref().unwrap(), found.components.as_ref().unwrap());
        let held = |seeds: &[Point3]| seeds.iter().filter(|p| turned.holds(**p, 0.0)).count();
        let images: Vec<Point3> = a.seeds.iter().map(|p| turned.image(*p)).collect();
        assert_eq!(held(&images), held(&b.seeds), "{name}: components");
    }
}

fn same_points(name: &str, turned: &Turned, old: &SingularSet, new: &SingularSet, size: f64) {
    let tolerance = LOCATED * size;
    let images: Vec<Point3> = old.points.iter().map(|p| turned.image(p.at)).collect();
    for (p, image) in old.points.iter().zip(&images).filter(|(_, p)| turned.holds(**p, tolerance)) {
        let same = |q: &&SingularPoint| (q.at - image).norm() < tolerance;
        let near: Vec<&SingularPoint> = new.points.iter().filter(same).collect();
        assert_eq!(near.len(), 1, "{name}: {p:?} at {image:?} in {:?}", new.points);
        assert_eq!((near[0].kind, near[0].multiplicity), (p.kind, p.multiplicity), "{name}");
    }
    for q in new.points.iter().filter(|q| turned.holds(q.at, tolerance)) {
        assert!(images.iter().any(|p| (p - q.at).norm() < tolerance), "{name}: {q:?} invented");
    }
}

fn same_special_points(name: &str, turned: &Turned, old: &SingularSet, new: &SingularSet, size: f64) {
    let tolerance = SPECIAL * size;
    let inner = |set: &SingularSet| -> Vec<(Point3, SpecialKind)> {
        set.special.iter().filter(|s| s.kind != SpecialKind::Box).map(|s| (s.at, s.kind)).collect()
    };
    let places: Vec<(Point3, SpecialKind)> =
        inner(old).into_iter().map(|(p, kind)| (turned.image(p), kind)).collect();
    let found = inner(new);
    for (from, to) in [(&places, &found), (&found, &places)] {
        for (p, kind) in from.iter().filter(|(p, _)| turned.holds(*p, tolerance)) {
            let near = to.iter().filter(|(q, k)| (p - q).norm() < tolerance && k == kind).count();
            assert_eq!(near, 1, "{name}: {kind:?} at {p:?}; {places:?} became {found:?}");
        }
    }
}

fn same_arcs(name: &str, turned: &Turned, old: &SingularSet, new: &SingularSet, size: f64) {
    let samples = |set: &SingularSet, image: &dyn Fn(Point3) -> Point3| -> Vec<(Point3, CurveKind)> {
        set.curves.iter().flat_map(|c| c.samples.iter().map(|s| (image(s.at), c.kind))).collect()
    };
    let before = samples(old, &|p| turned.image(p));
    let after = samples(new, &|p| p);
    for (from, to) in [(&before, &after), (&after, &before)] {
        // One in four will do.
        for (p, kind) in from.iter().filter(|(p, _)| turned.holds(*p, SPECIAL * size)).step_by(4) {
            let same = to.iter().filter(|(_, k)| k == kind).map(|(q, _)| (p - q).norm());
            let distance = same.fold(f64::INFINITY, f64::min);
            // Half of the way between samples, which are farther apart in an enlarged surface.
            assert!(
                distance <= turned.factor * COVERED * size,
                "{name}: {kind:?} at {p:?} is {distance:e} from the others"
            );
        }
    }
    // Arcs that are in the sphere as a whole.
    let whole = |set: &SingularSet, image: &dyn Fn(Point3) -> Point3| -> Vec<(CurveKind, bool)> {
        let inside = set.curves.iter().filter(|c| {
            let far = c.samples.iter().map(|s| (image(s.at) - turned.center).norm()).fold(0.0, f64::max);
            // A sample may be before or behind the place where the arc comes closest to the sphere.
            far < turned.radius - COVERED * size
        });
        let mut kinds: Vec<(CurveKind, bool)> = inside.map(|c| (c.kind, c.closed)).collect();
        kinds.sort_by_key(|(kind, closed)| (format!("{kind:?}"), *closed));
        kinds
    };
    assert_eq!(whole(old, &|p| turned.image(p)), whole(new, &|p| p), "{name}: whole arcs");
}

/// Drawn at random, and then kept.
const QUATERNIONS: [[i32; 4]; 4] = [[3, 1, -2, 1], [2, -1, 1, 3], [4, 3, -1, 2], [1, 2, 3, -4]];
const FACTORS: [[i32; 2]; 2] = [[1, 1], [5, 4]];

/// Each surface by two rotations, one of them with a scaling; a third of the surfaces a test, so that they run side by side.
fn check_every_third(first: usize) {
    for (i, (name, golden)) in Golden::all().iter().enumerate().skip(first).step_by(3) {
        let plain = analysed(&golden.text, &golden.bounds);
        assert!(plain.singular.undecided.is_empty(), "{name}: {:?}", plain.singular.undecided);
        for (k, factor) in FACTORS.into_iter().enumerate() {
            check(name, golden, &plain, QUATERNIONS[(i + k) % QUATERNIONS.len()], factor);
        }
    }
}

#[test]
fn turned_surfaces_have_the_same_singularities() {
    check_every_third(0);
}

#[test]
fn turned_surfaces_have_the_same_singularities_second_third() {
    check_every_third(1);
}

#[test]
fn turned_surfaces_have_the_same_singularities_last_third() {
    check_every_third(2);
}
