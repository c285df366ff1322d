//! The spline method against numbers computed by independent programs (tests/golden; larger files from
//! `ISOPATCH_TEST_DATA`).
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::base::{BaseMesh, EdgeFeature};
use isopatch::bernstein::{curve, quads};
use isopatch::geom::{Mat3, Point3, Points, PointsMut, PointsView, Vec3};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::network::{CurveOptions, CurveSolver, fit_quartics};
use isopatch::spline::edge::EdgeSystem;
use isopatch::spline::vertex::{EndWeights, RingCurve, VertexSystem, end_weights, solve};
use isopatch::spline::{self, SampledFrom, SplineOptions, TriangularSpline};
use isopatch::surface::Target;
use serde_json::Value;
use support::{data_file, float, floats, golden, point, points, skip};

/// The zero set of a function given with its gradient, reached by plain Newton steps along the gradient.
struct Implicit(fn(Point3) -> (f64, Vec3));

impl Target for Implicit {
    fn project(&self, points: &mut Points) {
        for i in 0..points.len() {
            let mut p = points.get(i);
            for _ in 0..30 {
                let (f, g) = (self.0)(p);
                let step = f / g.norm_squared() * g;
                p -= step;
                if step.norm() < 1e-14 {
                    break;
                }
            }
            points.set(i, p);
        }
    }

    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], normal: PointsMut<'_>) {
        for i in 0..points.len() {
            let (f, g) = (self.0)(points.get(i));
            let (length, n) = (g.norm(), g.normalize());
            offset[i] = f / length;
            (normal.x[i], normal.y[i], normal.z[i]) = (n.x, n.y, n.z);
        }
    }
}

fn matrix(v: &Value) -> Mat3 {
    let rows = points(v);
    Mat3::from_rows(&[rows[0].transpose(), rows[1].transpose(), rows[2].transpose()])
}

fn base_mesh(golden: &Value) -> BaseMesh {
    let faces: Vec<[u32; 3]> = golden["faces"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| std::array::from_fn(|k| f[k].as_u64().unwrap() as u32))
        .collect();
    let positions = points(&golden["vertices"]);
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
    let features = vec![EdgeFeature::Smooth; mesh.edge_count()];
    let curvatures = golden["curvature_tensor_M"].as_array().unwrap().iter().map(matrix).collect();
    BaseMesh {
        mesh,
        positions,
        normals: points(&golden["normals"]),
        curvatures,
        features,
        clip: None,
        frozen_diagonal: None,
    }
}

/// The golden nets were made with tangents along the chords, and moved only the free points by the normal distance.
const GOLDEN_CURVES: CurveOptions = CurveOptions {
    shortest_tangent: 0.08,
    longest_tangent: 0.6,
    max_steps: 40,
    step_tolerance: 1e-9,
    normal_distance_steps: 3,
    tangential_weight: 1e-3,
    damping: 0.0,
    largest_turn: 0.0,
    solver: CurveSolver::Reduced,
    sqp_tolerance: 1e-6,
    constraint_tolerance: 1e-10,
};
const GOLDEN_PATCHES: SplineOptions = SplineOptions {
    samples: SampledFrom::Filled,
    normal_distance_steps: 2,
    tangential_weight: 1e-2,
    relaxation_steps: 0,
    relaxation_weight: 0.0,
};

fn build(golden: &Value, target: &Implicit) -> (Vec<[Point3; 5]>, TriangularSpline) {
    let base = base_mesh(golden);
    let curves = fit_quartics(&base, target, &GOLDEN_CURVES).unwrap();
    assert!(curves.iter().all(|c| !c.at_bound));
    let q = curves.iter().map(|c| c.q).collect();
    (q, spline::build(base, &curves, target, &GOLDEN_PATCHES).unwrap())
}

/// Curves and nets of the whole pipeline; the Levenberg–Marquardt fits stop at 1e-9, which bounds the agreement.
fn check_pipeline(golden: &Value, target: &Implicit) {
    let (curves, spline) = build(golden, target);
    let edges = &golden["edges"];
    for (e, q) in edges["half_edge"].as_array().unwrap().iter().zip(edges["q"].as_array().unwrap()) {
        let h = isopatch::mesh::HalfEdgeId(e.as_u64().unwrap() as u32);
        let ours = curves[spline.base.mesh.edge(h).index()];
        let mut wanted = points(q);
        if spline.base.mesh.edge_half_edge(spline.base.mesh.edge(h)) != h {
            wanted.reverse();
        }
        assert!(
            ours.iter().zip(&wanted).all(|(a, b)| (a - b).norm() < 1e-7),
            "edge {h:?}: {}",
            (ours[2] - wanted[2]).norm()
        );
    }
    for (f, (net, wanted)) in spline.nets.iter().zip(golden["control_nets"].as_array().unwrap()).enumerate() {
        for (c, (a, b)) in net.iter().zip(points(wanted)).enumerate() {
            assert!((a - b).norm() < 1e-7, "face {f}, control point {c}: {}", (a - b).norm());
        }
    }
}

fn sphere(p: Point3) -> (f64, Vec3) {
    (p.norm_squared() - 1.0, 2.0 * p)
}

fn torus(p: Point3) -> (f64, Vec3) {
    let rho = p.x.hypot(p.y);
    let a = 2.0 * (rho - 5.0);
    ((rho - 5.0).powi(2) + p.z * p.z - 1.0, Vec3::new(a * p.x / rho, a * p.y / rho, 2.0 * p.z))
}

fn ellipsoid(p: Point3) -> (f64, Vec3) {
    (p.x * p.x + p.y * p.y / 4.0 + p.z * p.z / 9.0 - 1.0, Vec3::new(2.0 * p.x, p.y / 2.0, 2.0 * p.z / 9.0))
}

#[test]
fn the_icosahedral_sphere_is_reproduced() {
    check_pipeline(&golden("sphere_icosahedron_rec"), &Implicit(sphere));
}

#[test]
fn the_torus_of_144_faces_is_reproduced() {
    let Some(golden) = data_file("golden/spline/torus_12x6_rec.json") else {
        return skip("the_torus_of_144_faces_is_reproduced");
    };
    check_pipeline(&golden, &Implicit(torus));
}

#[test]
fn the_small_ellipsoid_is_reproduced() {
    let Some(golden) = data_file("golden/spline/ellipsoid_small_rec.json") else {
        return skip("the_small_ellipsoid_is_reproduced");
    };
    check_pipeline(&golden, &Implicit(ellipsoid));
}

#[test]
fn vertex_systems_agree_with_dense_solves() {
    for system in golden("vertex_systems").as_array().unwrap() {
        let (o, n) = (point(&system["o"]), point(&system["N"]));
        let curves: Vec<RingCurve> = points(&system["ring_q1"])
            .iter()
            .zip(points(&system["ring_q2"]))
            .map(|(q1, q2)| RingCurve { d: q1 - o, e: q2 - o })
            .collect();
        let count = curves.len();
        let weights: Vec<EndWeights> = (0..count)
            .map(|i| {
                end_weights(&curves[(i + count - 1) % count].d, &curves[i].d, &curves[(i + 1) % count].d, &n)
            })
            .collect();
        for (w, (l, m)) in weights.iter().zip(floats(&system["lambda0"]).iter().zip(floats(&system["mu0"]))) {
            assert!((w.lambda - l).abs() < 1e-12 && (w.mu - m).abs() < 1e-12);
        }
        let twists: Vec<Vec3> = points(&system["T0_corner"]).iter().map(|t| t - o).collect();
        let far = floats(&system["lambda_far"]);
        let solution = solve(&VertexSystem {
            normal: n,
            curvature: matrix(&system["M"]),
            curves: &curves,
            weights: &weights,
            far_lambda: &far,
            twists: &twists,
        })
        .unwrap();
        for (t, wanted) in solution.twists.iter().zip(points(&system["out_T_corner"])) {
            assert!((t + o - wanted).norm() < 1e-10, "valence {count}: {}", (t + o - wanted).norm());
        }
        for (mu, wanted) in solution.mu1.iter().zip(floats(&system["out_mu1"])) {
            assert!((mu - wanted).abs() < 1e-10, "valence {count}");
        }
    }
}

#[test]
fn edge_systems_agree_with_dense_solves_and_satisfy_the_g1_condition() {
    for system in golden("edge_systems").as_array().unwrap() {
        let row = |name: &str| <[Point3; 7]>::try_from(points(&system[name])).unwrap();
        let mu = floats(&system["mu"]);
        let edge = EdgeSystem {
            q: points(&system["q"]).try_into().unwrap(),
            p: row("p_in"),
            r: row("r_in"),
            lambda: [float(&system["lambda0"]), float(&system["lambda1"])],
            mu: [mu[0], mu[1], mu[3], mu[4]],
            nu: float(&system["nu"]),
        };
        let solution = edge.solve().unwrap();
        let (mut p, mut r) = (edge.p, edge.r);
        p[2..5].copy_from_slice(&solution.p);
        r[2..5].copy_from_slice(&solution.r);
        for (ours, name) in [(&p, "p_out"), (&r, "r_out")] {
            for (a, b) in ours.iter().zip(row(name)) {
                assert!((a - b).norm() < 1e-10, "{name}: {}", (a - b).norm());
            }
        }
        let coefficients = edge.mu_coefficients();
        let (q_b, q_t): ([Point3; 4], [Point3; 4]) =
            (std::array::from_fn(|i| edge.q[i]), std::array::from_fn(|i| edge.q[i + 1]));
        for s in 0..=32 {
            let t = s as f64 / 32.0;
            let lambda = (1.0 - t) * edge.lambda[0] + t * edge.lambda[1];
            let mu: f64 = curve::basis::<5>(t).iter().zip(coefficients).map(|(b, m)| b * m).sum();
            let left = (1.0 - lambda) * curve::point(&p, t) + lambda * curve::point(&r, t);
            let right = (1.0 - mu) * curve::point(&q_b, t) + mu * curve::point(&q_t, t);
            assert!((left - right).norm() < 1e-12, "equation (1) at t = {t}: {}", (left - right).norm());
        }
    }
}

#[test]
fn quads_of_a_triangle_agree() {
    let golden = golden("quad_conversion");
    for (net, wanted) in golden["nets"].as_array().unwrap().iter().zip(golden["quads"].as_array().unwrap()) {
        let ours = quads::split(&points(net).try_into().unwrap());
        for m in 0..3 {
            for i in 0..8 {
                for (a, b) in ours[m][i].iter().zip(points(&wanted[m][i])) {
                    assert!((a - b).norm() < 1e-14);
                }
            }
        }
    }
}
