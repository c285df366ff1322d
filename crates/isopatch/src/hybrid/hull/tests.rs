use super::*;
use crate::geom::{Point3, Vec3, angle_between};
use crate::hull::{Class, Side};
use crate::hybrid::{Element, HermitePolygons, HybridFace, HybridHull};
use crate::mesh::HalfEdgeMesh;
use test_bodies::{Body, Quadratic, bodies, grid, quadrics};

fn data(body: &Body, gradient: impl Fn(usize) -> Vec3) -> HermitePolygons {
    let mesh = HalfEdgeMesh::from_faces(body.positions.len(), &body.faces).unwrap();
    let gradients: Vec<Vec3> = (0..body.positions.len()).map(gradient).collect();
    HermitePolygons::new(mesh, body.positions.clone(), &gradients).unwrap()
}

fn on_quadric(q: &Quadratic, body: &Body) -> HermitePolygons {
    data(body, |v| q.gradient(&body.positions[v]))
}

#[test]
fn bodies_have_the_faces_that_they_are_known_for() {
    let count = |name: &str| {
        let body = bodies().into_iter().find(|body| body.name == name).unwrap();
        let of = |n: usize| body.faces.iter().filter(|f| f.len() == n).count();
        [of(3), of(4), of(5), of(7)]
    };
    assert_eq!(count("dodecahedron"), [0, 0, 12, 0]);
    assert_eq!(count("snub cube"), [32, 6, 0, 0]);
    assert_eq!(count("icosidodecahedron"), [20, 0, 12, 0]);
    assert_eq!(count("rhombicuboctahedron"), [8, 18, 0, 0]);
    assert_eq!(count("heptagonal prism"), [0, 7, 0, 2]);
}

/// The quadric of every face is the one that the data come from, and its parameters are left alone.
#[test]
fn quadrics_are_found_again() {
    for (q, body) in quadrics() {
        let built = build(on_quadric(&q, &body), &HybridOptions::default());
        assert!(built.problems.is_empty(), "{}: {:?}", body.name, built.problems);
        for face in built.hull.faces.iter().filter(|face| face.element.is_some()) {
            for a in face.apexes.iter().flatten() {
                let miss = (face.quadric.value(a) - q.value(a))
                    .abs()
                    .max((face.quadric.gradient(a) - q.gradient(a)).norm());
                assert!(miss < 1e-12, "{}: {miss:e}", body.name);
            }
            assert_eq!(face.at_apex, [None; 2], "{}", body.name);
        }
    }
}

/// On quadrics the gradients in the middle of edges are the means already; on other surfaces they come nearer to the true ones.
#[test]
fn middle_gradients_are_exact_to_the_third_order() {
    for (q, body) in quadrics() {
        let mean = on_quadric(&q, &body);
        let built = build(mean.clone(), &HybridOptions::default());
        for h in mean.mesh().half_edges() {
            let moved = (built.hull.data.middle(h) - mean.middle(h)).norm();
            assert!(moved < 1e-12 * mean.gradient(h).norm(), "{}: {moved:e}", body.name);
        }
    }
    let height = |x: f64, y: f64| 0.2 * x * x * y - 0.1 * y * y * y + 0.3 * x * x;
    let slope = |p: &Point3| {
        let by_y = 0.2 * p.x * p.x - 0.3 * p.y * p.y;
        Vec3::new(-(0.4 * p.x * p.y + 0.6 * p.x), -by_y, 1.0)
    };
    let off = |n: u32, middles: Middles| {
        let body = grid("cubic", [n, n], false, |u, v| Point3::new(u, v, height(u, v)));
        let built = build(
            data(&body, |k| slope(&body.positions[k])),
            &HybridOptions { middles, ..HybridOptions::default() },
        );
        let data = &built.hull.data;
        let miss = |e| {
            let [h, g] = data.joint(e)?;
            let [p, r] = [h, g].map(|h| data.position(h));
            let edge = (r - p).normalize();
            // The tangent plane counts, not the length of the gradient; and along the edge, its values tell it.
            let turned = |v: Vec3| v - v.dot(&edge) * edge;
            let found = 0.25 * (data.gradient(h) + data.gradient(g)) + 0.5 * data.middle(h);
            Some(angle_between(&turned(found), &turned(slope(&(0.5 * (p + r))))))
        };
        data.mesh().edges().filter_map(miss).fold(0.0, f64::max)
    };
    let (mean, fitted) = ([8, 16].map(|n| off(n, Middles::Mean)), [8, 16].map(|n| off(n, Middles::Fitted)));
    assert!(fitted[0] < 0.1 * mean[0], "{fitted:?} {mean:?}");
    assert!(fitted[0] / fitted[1] > 7.0 && mean[0] / mean[1] < 4.5, "{fitted:?} {mean:?}");
}

/// Numbers from −1 to 1 that look random.
fn noise(n: usize) -> f64 {
    let x = (n as f64 * 12.9898 + 4.1).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

#[test]
fn noisy_normals_still_give_single_sheets() {
    let mut gained = 0;
    for body in bodies() {
        let noisy = |v: usize| {
            let by = Vec3::new(noise(3 * v), noise(3 * v + 1), noise(3 * v + 2));
            (body.positions[v] + 0.35 * by).normalize()
        };
        let with = |sheets| build(data(&body, noisy), &HybridOptions { sheets, ..HybridOptions::default() });
        let (left, made) = (with(Sheets::Nowhere), with(Sheets::Everywhere));
        let certain =
            |built: &BuiltHull| built.certainty.iter().filter(|c| **c == Certainty::Certain).count();
        assert!(made.certainty.iter().all(|c| *c <= Certainty::FaceOnly), "{}", body.name);
        assert!(certain(&made) >= certain(&left), "{}", body.name);
        gained += certain(&made) - certain(&left);
    }
    assert!(gained > 20, "{gained}");
}

/// The paper's rule misses the sphere over planar polygons, by as much as the prototypes of the method did, and gives quadrics
/// back over polygons that are not planar.
#[test]
fn the_rule_of_the_paper_is_exact_where_polygons_are_not_planar() {
    let miss = |q: &Quadratic, body: &Body, linear: bool| {
        let rule = DefaultRule::Paper { linear };
        let built = build(on_quadric(q, body), &HybridOptions { rule, ..HybridOptions::default() });
        let of = |face: &HybridFace| {
            let side = Side::BOTH.into_iter().find(|side| face.apexes[side.index()].is_some()).unwrap();
            let (a, jet) = (face.apexes[side.index()].unwrap(), face.jet(side).unwrap());
            assert_eq!(face.at_apex[side.index()], Some(jet));
            (jet.value - q.value(&a)).abs()
        };
        built.hull.faces.iter().map(of).fold(0.0, f64::max)
    };
    let named = |name: &str| quadrics().into_iter().find(|(_, body)| body.name == name).unwrap();
    let (q, cube) = named("cube");
    assert!(miss(&q, &cube, false) > 0.05 && miss(&q, &cube, true) > 0.05);
    // Over a grid along the axes the quadrilaterals of a paraboloid are planar, over a skew one they are not.
    let (q, _) = named("elliptic paraboloid");
    let skew = grid("skew", [4, 4], false, |u, v| {
        let (x, y) = (2.0 * u - 1.0 + 0.3 * (2.0 * v - 1.0), 2.0 * v - 1.0);
        Point3::new(x, y, -0.4 * x * x - 0.6 * y * y)
    });
    assert!(miss(&q, &skew, false) < 1e-9, "{:e}", miss(&q, &skew, false));
}

#[test]
fn polygons_get_the_cells_that_suit_them() {
    let built = |name: &str| -> HybridHull {
        let (q, body) = quadrics().into_iter().find(|(_, body)| body.name == name).unwrap();
        build(on_quadric(&q, &body), &HybridOptions::default()).hull
    };
    let elements = |hull: &HybridHull| -> Vec<(Option<Element>, Class)> {
        hull.faces.iter().map(|face| (face.element, face.class)).collect()
    };
    assert!(elements(&built("cube")).iter().all(|e| *e == (Some(Element::Pyramid), Class::Positive)));
    assert!(elements(&built("dodecahedron")).iter().all(|e| *e == (Some(Element::Sectors), Class::Positive)));
    let saddle = elements(&built("hyperbolic paraboloid along its lines"));
    assert!(saddle.iter().all(|e| *e == (Some(Element::Sectors), Class::Nonconvex)));
}
