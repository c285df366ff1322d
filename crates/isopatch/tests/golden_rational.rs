//! Wires and rational patches against golden files: exactly, in rational numbers, for the constructions of the paper; to 1e-12 for the
//! default one.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::bernstein::index;
use isopatch::geom::{Point3, Vec3};
use isopatch::network::number::{Vector, determinant, off, whole};
use isopatch::network::wire_conic::Conic;
use isopatch::network::wire_cubic::Cubic;
use isopatch::rational::conic::{EdgeCondition, condition, cover, patch, vectors, vectors_relaxed};
use isopatch::rational::weighted::weighted_net;
use isopatch::rational::{Frame, FrameSeam, build};
use isopatch::surface::{PatchId, Surface};
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};
use serde_json::Value;
use support::golden;

type Q = BigRational;

fn number(v: &Value) -> Q {
    v.as_str().unwrap().parse().unwrap()
}

fn vector(v: &Value) -> Vector<Q> {
    let c: Vec<Q> = v.as_array().unwrap().iter().map(number).collect();
    Vector::from_vec(c)
}

fn float(v: &Vector<Q>) -> Vec3 {
    v.map(|x| x.to_f64().unwrap())
}

fn list<'a>(file: &'a Value, key: &str) -> &'a Vec<Value> {
    file[key].as_array().unwrap()
}

/// Ends and normals of an edge.
fn ends(case: &Value) -> ([Vector<Q>; 2], [Vector<Q>; 2]) {
    (["p0", "p1"].map(|key| vector(&case[key])), ["n0", "n1"].map(|key| vector(&case[key])))
}

/// Problem 1, both parts; Lemma 5.1 (the solution is unique: that of the file), Lemma 5.2 (when it has a normal function).
#[test]
fn conic_wires_with_two_normals() {
    let file = golden("rational/wires_patches");
    let (mut solved, mut failed) = (0, 0);
    for case in list(&file, "quad") {
        let (name, (p, n)) = (&case["name"], ends(case));
        let status = case["status"].as_str().unwrap();
        let Ok(conic) = Conic::with_two_normals(p.each_ref(), n.each_ref(), &Q::zero()) else {
            assert!(status.starts_with("no_quadratic"), "{name}");
            continue;
        };
        let expected = ["A", "B", "C"].map(|key| vector(&case[key]));
        assert_eq!([conic.a.clone(), conic.b.clone(), conic.c.clone()], expected, "{name}");
        assert_eq!(conic.energy(), number(&case["energy_C1sq"]), "{name}");
        assert_eq!(whole::<Q>(4) * conic.a.dot(&conic.a), number(&case["energy_C2sq"]), "{name}");
        match conic.normals(n.each_ref(), &Q::zero()) {
            Ok(normals) => {
                solved += 1;
                assert_eq!(normals.one_plus_w, number(&case["one_plus_w"]), "{name}");
                let [start, end] = &normals.numerator;
                if case.get("E").is_some() {
                    assert_eq!(
                        (start.clone(), end - start),
                        (vector(&case["E"]), vector(&case["D"])),
                        "{name}"
                    );
                }
                // (5.4), identically: three Bernstein coefficients of n·C'.
                let [c0, c1] = conic.end_tangents();
                assert!(start.dot(&c0).is_zero() && end.dot(&c1).is_zero());
                assert!((start.dot(&c1) + end.dot(&c0)).is_zero(), "{name}");
            }
            Err(_) => {
                failed += 1;
                assert!(status.starts_with("lemma5.2_fails"), "{name}");
            }
        }
    }
    assert_eq!((solved, failed), (6, 2));
}

/// Problem 2, both parts, and problem 3(i).
#[test]
fn conic_wires_with_one_normal_and_without() {
    let file = golden("rational/wires_patches");
    for case in list(&file, "one_normal") {
        let (p0, p1, n) = (vector(&case["p0"]), vector(&case["p1"]), vector(&case["n"]));
        let end = case["end"].as_u64().unwrap() as usize;
        let conic = Conic::with_one_normal([&p0, &p1], &n, end);
        let expected = ["A", "B", "C"].map(|key| vector(&case[key]));
        assert_eq!([conic.a.clone(), conic.b.clone(), conic.c.clone()], expected, "{}", case["name"]);

        let d = &p1 - &p0;
        if d.cross(&n) == Vector::zeros() {
            continue;
        }
        let other = conic.companion_normal(&n, end);
        let normals = if end == 0 { [&n, &other] } else { [&other, &n] };
        let found = conic.normals(normals, &Q::zero()).unwrap();
        let (c, [start, last]) = (conic.end_tangents(), &found.numerator);
        assert!(start.dot(&c[0]).is_zero() && last.dot(&c[1]).is_zero());
        assert!((start.dot(&c[1]) + last.dot(&c[0])).is_zero());
        // In the plane of the normal and the chord, and on the same side of the chord.
        assert!(determinant(&n, &other, &d).is_zero());
        assert!(off(&n, &d).dot(&other) > Q::zero());

        let straight = Conic::straight([&p0, &p1]);
        assert_eq!((straight.a, straight.b), (Vector::zeros(), d));
    }
}

/// Cubic wires (5.10)–(5.13), both cases, and the normal functions of 5.4.
#[test]
fn cubic_wires() {
    let file = golden("rational/wires_patches");
    let mut singular = 0;
    for case in list(&file, "cubic") {
        let (name, ([p0, p1], n)) = (&case["name"], ends(case));
        let p2 = vector(&case["p2"]);
        let cubic = Cubic::through([&p0, &p2, &p1], n.each_ref(), &Q::zero());
        let expected = ["A", "B", "C", "D"].map(|key| vector(&case[key]));
        assert_eq!([cubic.a.clone(), cubic.b.clone(), cubic.c.clone(), cubic.d.clone()], expected, "{name}");
        let half = Q::one() / whole::<Q>(2);
        let through = case.get("p2_projected").map_or(p2, vector);
        assert_eq!(cubic.point(&half), through, "{name}");
        assert_eq!(cubic.determinant(), number(&case["det_ABC"]), "{name}");
        match cubic.normals(n.each_ref()) {
            Some(normals) => {
                let expected = ["E", "F", "G"].map(|key| vector(&case[key]));
                assert_eq!([normals.e.clone(), normals.f.clone(), normals.g.clone()], expected, "{name}");
                for t in (0..=8).map(|i| whole::<Q>(i) / whole::<Q>(8)) {
                    assert!(normals.at(&t).dot(&cubic.derivative(&t)).is_zero(), "{name}");
                }
            }
            None => {
                singular += 1;
                assert!(cubic.determinant().is_zero());
                // What the paper does then: least squares, whose normals are at the ends as asked in any case.
                let [a, b, c, d] = [&cubic.a, &cubic.b, &cubic.c, &cubic.d].map(float);
                let normals = n.each_ref().map(float);
                let found = Cubic { a, b, c, d }.normals_least_squares(normals.each_ref(), 1e-10);
                assert_eq!(found.at(&0.0), normals[0]);
                assert!((found.at(&1.0) - normals[1]).norm() < 1e-14);
            }
        }
    }
    assert_eq!(singular, 1);
}

/// Theorem 5.3: parallel normals and p₂ by (5.13); the determinant vanishes only where one of its conditions fails.
#[test]
fn theorem_5_3() {
    let v = |x: i64, y: i64, z: i64| Vector::new(x, y, z).map(|c| Q::from_integer(c.into()));
    let n = v(0, 0, 1);
    let (p0, p1) = (v(0, 0, 0), v(4, 0, 2));
    for y in -2..=2 {
        let p2 = v(2, y, 1);
        let cubic = Cubic::through([&p0, &p2, &p1], [&n, &n], &Q::zero());
        let holds = !(&p2 - &p0).dot(&n).is_zero() && !determinant(&(&p2 - &p1), &(&p2 - &p0), &n).is_zero();
        assert_eq!(holds, y != 0);
        assert_eq!(cubic.determinant().is_zero(), !holds);
    }
}

/// The paper's edge i, opposite vertex i, is edge i + 1 of the library.
const PAPER_EDGES: [usize; 3] = [1, 2, 0];

fn conic_conditions(case: &Value) -> ([Vector<Q>; 6], [EdgeCondition<Q>; 3]) {
    let p: Vec<_> = list(case, "p").iter().map(vector).collect();
    let n: Vec<_> = list(case, "n").iter().map(vector).collect();
    let wires = [0, 1, 2].map(|k| {
        let end = (k + 1) % 3;
        Conic::with_two_normals([&p[k], &p[end]], [&n[k], &n[end]], &Q::zero()).unwrap()
    });
    let net = cover(wires.each_ref());
    let conditions = [0, 1, 2].map(|k| {
        let functions = wires[k].normals([&n[k], &n[(k + 1) % 3]], &Q::zero()).unwrap();
        condition(&net, &functions, k)
    });
    (net, conditions)
}

/// The conic cover (6.1) and the vectors of (6.13), exactly: Lemma 6.1. Then the patch in floating point, and its form with weights.
#[test]
fn conic_patches() {
    let file = golden("rational/wires_patches");
    for case in list(&file, "patch") {
        let name = &case["name"];
        let (net, conditions) = conic_conditions(case);
        for ([i, j, k], point) in index::indices(2).zip(&net) {
            assert_eq!(*point, vector(&case["P2"][format!("{i}{j}{k}")]), "{name}");
        }
        for (i, abc) in list(case, "abc").iter().enumerate() {
            assert_eq!(conditions[PAPER_EDGES[i]].constant, number(abc), "{name}");
        }
        let found = vectors(&conditions, &vector(&case["control_p"])).unwrap();
        for (i, key) in ["P_u", "P_v", "P_w"].iter().enumerate() {
            assert_eq!(found[PAPER_EDGES[i]], vector(&case[key]), "{name}");
        }

        let patch = patch(&net.each_ref().map(float), &found.each_ref().map(float));
        for (key, uv) in [("P_at_centroid", [1.0 / 3.0; 2]), ("P_at_half_third_sixth", [0.5, 1.0 / 3.0])] {
            assert!((patch.evaluate(uv).point - float(&vector(&case[key]))).norm() < 1e-14, "{name} {key}");
        }
        let weighted = weighted_net(&patch);
        assert_eq!(weighted.degree, 5);
        for ([i, j, k], p) in index::indices(5).zip(&weighted.points) {
            let expected = &case["rational_bezier_deg5"][format!("{i}{j}{k}")];
            assert!((p.w - number(&expected["weight"]).to_f64().unwrap()).abs() < 1e-15, "{name}");
            assert!((p.xyz() - float(&vector(&expected["homog"]))).norm() < 1e-14, "{name} {i}{j}{k}");
        }
    }
}

/// Conic patches have the normals of the normal functions all along their edges.
#[test]
fn conic_patches_have_the_normals_asked_for() {
    let file = golden("rational/wires_patches");
    for case in list(&file, "patch") {
        let (net, conditions) = conic_conditions(case);
        let vectors = vectors(&conditions, &vector(&case["control_p"])).unwrap();
        let patch = patch(&net.each_ref().map(float), &vectors.each_ref().map(float));
        let normals: Vec<Vec3> = list(case, "n").iter().map(|n| float(&vector(n))).collect();
        for k in 0..3 {
            let paper_edge = (k + 2) % 3;
            let one_plus_w = number(&case["one_plus_w"][paper_edge]).to_f64().unwrap();
            for i in 0..=16 {
                let t = f64::from(i) / 16.0;
                let mut l = [0.0; 3];
                (l[k], l[(k + 1) % 3]) = (1.0 - t, t);
                let n = (1.0 - t) * normals[k] + one_plus_w * t * normals[(k + 1) % 3];
                let s = patch.evaluate([l[0], l[1]]);
                assert!(s.du.dot(&n).abs() < 1e-13 && s.dv.dot(&n).abs() < 1e-13, "{} {k} {t}", case["name"]);
            }
        }
    }
}

/// The note after Lemma 6.1: normals that are dependent, but independent in pairs. The conditions hold, and the middle comes as close as
/// it can.
#[test]
fn the_relaxed_case_of_lemma_6_1() {
    let on_cylinder = |angle: f64, z: f64| {
        (Vec3::new(angle.cos(), angle.sin(), z), Vec3::new(angle.cos(), angle.sin(), 0.0))
    };
    let corners = [on_cylinder(0.0, 0.0), on_cylinder(0.7, 0.2), on_cylinder(0.3, 1.0)];
    let ends = |k: usize| (corners[k], corners[(k + 1) % 3]);
    let wires = [0, 1, 2].map(|k| {
        let ((p, n), (q, m)) = ends(k);
        Conic::with_two_normals([&p, &q], [&n, &m], &1e-9).unwrap()
    });
    let net = cover(wires.each_ref());
    let conditions = [0, 1, 2].map(|k| {
        let ((_, n), (_, m)) = ends(k);
        condition(&net, &wires[k].normals([&n, &m], &1e-9).unwrap(), k)
    });
    assert_eq!(vectors(&conditions, &Vec3::zeros()), None);
    let middle = Vec3::new(0.1, 0.2, 0.05);
    let found = vectors_relaxed(&conditions, &middle, 1e-9);
    // The free vectors all lie along the axis of the cylinder.
    assert!((found.iter().sum::<Vec3>().z / 3.0 - middle.z).abs() < 1e-12);
    for (k, (u, of)) in found.iter().zip(&conditions).enumerate() {
        let ((_, n), (_, m)) = ends(k);
        assert!((u - of.particular).dot(&n).abs() < 1e-12 && (u - of.particular).dot(&m).abs() < 1e-12);
    }
}

fn vec3(v: &Value) -> Vec3 {
    let [x, y, z]: [f64; 3] = serde_json::from_value(v.clone()).unwrap();
    Vec3::new(x, y, z)
}

/// One triangle, alone; smooth, so that its tangent planes are kept also along edges with one singular end.
fn lone_triangle(case: &Value) -> Frame {
    let singular: [bool; 3] = serde_json::from_value(case["singular"].clone()).unwrap();
    let normal = |c: usize| Some(vec3(&case["n"][c])).filter(|_| !singular[c]);
    let seam = |k: u8| {
        let is_singular = singular[usize::from(k)] && singular[(usize::from(k) + 1) % 3];
        FrameSeam { first: (0, k), second: None, smooth: !is_singular, wire: u32::from(k) }
    };
    Frame {
        positions: list(case, "p").iter().map(vec3).collect(),
        faces: vec![[0, 1, 2]],
        normals: vec![[0, 1, 2].map(normal)],
        seams: [0, 1, 2].map(seam).to_vec(),
    }
}

/// The default construction: wires, directions across them, corrections, points. Five triangles, among them an inflection, parallel
/// normals, the tip of a cone, and one with two singular vertices.
#[test]
fn robust_patches() {
    let file = golden("rational/robust_patches");
    for case in list(&file, "patches") {
        let name = &case["name"];
        let surface = build(&lone_triangle(case)).unwrap().surface;
        let patch = surface.patch(PatchId(0));
        assert!((patch.net[4] - vec3(&case["c111"])).norm() < 1e-12, "{name}");
        for (i, k) in PAPER_EDGES.into_iter().enumerate() {
            let wire = list(case, "bezier_edges")[i].as_array().unwrap();
            for (found, expected) in patch.wire(k).iter().zip(wire) {
                assert!((found - vec3(expected)).norm() < 1e-12, "{name} wire {i}");
            }
            let expected = &list(case, "edges")[i];
            if expected.is_null() {
                assert_eq!(patch.across[k], [Vec3::zeros(); 4], "{name}");
                continue;
            }
            let r = patch.derivative_across(k);
            assert!((r[0] - vec3(&expected["R0"])).norm() < 1e-12, "{name} {i}");
            assert!((r[2] - vec3(&expected["R1"])).norm() < 1e-12, "{name} {i}");
            for (t, key) in [(0.25, "U_at_quarter"), (0.5, "U_at_half")] {
                let [c0, c1, c2, c3] = patch.across[k];
                let s = 1.0 - t;
                let product: Point3 =
                    c0 * (s * s * s) + c1 * (3.0 * s * s * t) + c2 * (3.0 * s * t * t) + c3 * (t * t * t);
                assert!((product / (s * t) - vec3(&expected[key])).norm() < 1e-12, "{name} {i} {key}");
            }
        }
        for sample in list(case, "eval") {
            let l = vec3(&sample["l"]);
            let found = surface.sample(PatchId(0), [l.x, l.y]).point;
            assert!((found - vec3(&sample["P"])).norm() < 1e-12, "{name} {l:?}");
        }
    }
}
