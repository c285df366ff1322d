//! A-patches against numbers of an independent program (tests/golden/apatch; the larger files from
//! `ISOPATCH_TEST_DATA`).
//!
//! The files number edges by the opposite corner, name coefficients by the multiplicities of (v0, v1, v2, apex), and give values
//! in the sign of the function on both sides.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::apatch::{self, APatchFunction, APatchOptions, Free, FreeRule, Layer2Rule};
use isopatch::bernstein::{cubic, triangle};
use isopatch::geom::Point3;
use isopatch::hull::{self, ApexRule, Class, HermiteMesh, HullOptions, Margin, Side};
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use serde_json::Value;
use support::{data_file, float, floats, golden, point, points, skip};

const TOLERANCE: f64 = 1e-12;

fn close(ours: f64, wanted: f64, what: &str) {
    let error = (ours - wanted).abs() / (1.0 + wanted.abs());
    assert!(error <= TOLERANCE, "{what}: {ours} for {wanted}, off by {error:e}");
}

fn all_close(ours: &[f64], wanted: &Value, what: &str) {
    let wanted = floats(wanted);
    assert_eq!(ours.len(), wanted.len(), "{what}");
    ours.iter().zip(wanted).for_each(|(a, b)| close(*a, b, what));
}

fn class(v: &Value) -> Class {
    match v.as_str().unwrap() {
        "positive" => Class::Positive,
        "negative" => Class::Negative,
        "zero" => Class::Zero,
        "nonconvex" => Class::Nonconvex,
        other => unreachable!("class {other}"),
    }
}

/// Values by opposite corner, from values by edge.
fn by_corner(by_edge: [f64; 3]) -> [f64; 3] {
    [by_edge[1], by_edge[2], by_edge[0]]
}

const SIDES: [(Side, &str); 2] = [(Side::Outer, "u"), (Side::Inner, "v")];

fn build(golden: &Value) -> APatchFunction {
    let faces: Vec<[u32; 3]> = serde_json::from_value(golden["faces"].clone()).unwrap();
    let positions = points(&golden["vertices"]);
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
    let data = HermiteMesh::new(mesh, positions, &points(&golden["normals"])).unwrap();
    let eps = float(&golden["eps"]);
    let relative = golden["eps_mode"].as_str().unwrap().starts_with("relative");
    let margin = if relative { Margin::Relative(eps) } else { Margin::Absolute(eps) };
    let hull = hull::build(data, &HullOptions { rule: ApexRule::Paper, margin });
    let values = golden["faces_out"].as_array().unwrap().iter().map(|face| {
        SIDES.map(|(side, name)| face[name]["free"].as_f64().map_or(0.0, |free| side.sign() * free))
    });
    let rule = if golden["b_rule"] == "neigh" { FreeRule::Neighbour } else { FreeRule::Linear };
    assert_eq!(golden["q1_rule"], "lsq");
    let free = Free::PerFace(values.collect());
    apatch::build(hull, &APatchOptions { layer2: Layer2Rule::LeastSquares, rule, free })
}

fn check_hull(f: &APatchFunction, golden: &Value) {
    let hull = f.hull();
    let mesh = hull.data().mesh();
    for (face, hull_face) in mesh.faces().zip(hull.faces()) {
        let i = face.index();
        assert_eq!(hull_face.class, class(&golden["face_class"][i]));
        let classes: Vec<Class> =
            mesh.face_half_edges(face).map(|h| hull.edges()[mesh.edge(h).index()].class).collect();
        for (corner, wanted) in golden["edge_class_opposite_corner"][i].as_array().unwrap().iter().enumerate()
        {
            assert_eq!(classes[(corner + 1) % 3], class(wanted));
        }
        let (frame, n) = (hull.face_frame(face), hull_face.direction);
        all_close(&frame.tangent_heights(Side::Outer, &n), &golden["t_l"][i], "t_l");
        let t_lm = by_corner(frame.mid_edge_heights(Side::Outer, &n));
        all_close(&t_lm, &golden["t_lm_edge_opposite_corner"][i], "t_lm");
        close(hull_face.heights[0], float(&golden["t_max"][i]), "t_max");
        close(-hull_face.heights[1], float(&golden["t_min"][i]), "t_min");
        for (side, name) in SIDES {
            if let Some(apex) = hull_face.apexes[side.index()] {
                all_close(apex.as_slice(), &golden[name][i], name);
            }
        }
    }
}

fn check_face(f: &APatchFunction, face: FaceId, golden: &Value) {
    let ours = &f.faces()[face.index()];
    for (name, wanted) in golden["f2_base"].as_object().unwrap() {
        let digit = |d| name[1..].find(d).unwrap();
        close(ours.base.e[digit('2')][digit('1')], float(wanted), name);
    }
    assert_eq!(ours.base.split, golden["uses"] == "CT");
    let middle = if ours.base.split { "CT_c_edge_opposite" } else { "g_edge_opposite" };
    all_close(&by_corner(ours.base.middle), &golden[middle], middle);
    for (side, name) in SIDES {
        let (s, wanted) = (side.sign(), &golden[name]);
        let Some(cell) = &ours.sides[side.index()] else {
            assert!(wanted.is_null());
            continue;
        };
        all_close(&cell.layer1.corner.map(|f| s * f), &wanted["f_2a_apex"], "f_2a_apex");
        let edge = by_corner(cell.layer1.edge).map(|f| s * f);
        all_close(&edge, &wanted["f_edge_apex_opposite"], "f_edge_apex_opposite");
        all_close(&cell.q.map(|q| s * q), &wanted["q1"], "q1");
        let free = f.free()[face.index()][side.index()];
        close(s * free, float(&wanted["free"]), "free");
        let layer2: Vec<f64> = cell.q.iter().map(|q| s * (free + 2.0 * q) / 3.0).collect();
        all_close(&layer2, &wanted["f_a_2apex"], "f_a_2apex");
        close(
            s * f.sufficient_free()[face.index()][side.index()],
            float(&wanted["b_sufficient"]),
            "b_sufficient",
        );
    }
    for ((x, p), (t, base)) in points(&golden["grid_bary"])
        .iter()
        .zip(golden["points"].as_array().unwrap())
        .zip(golden["t"].as_array().unwrap().iter().zip(golden["F_base"].as_array().unwrap()))
    {
        let x: [f64; 3] = (*x).into();
        close(ours.base.value(x).0, float(base), "F_base");
        match (f.shoot_face(face, x), t.as_f64()) {
            (Some(shot), Some(t)) => {
                close(shot.side.sign() * shot.t, t, "t");
                all_close(shot.point.as_slice(), p, "point");
            }
            (ours, wanted) => assert!(ours.is_none() && wanted.is_none(), "{ours:?} for {wanted:?}"),
        }
    }
}

fn check_edge(f: &APatchFunction, golden: &Value) {
    let mesh = f.hull().data().mesh();
    let ends = floats(&golden["edge"]);
    let from = |h: &isopatch::mesh::HalfEdgeId| {
        (mesh.origin(*h).0 as f64, mesh.dest(*h).0 as f64) == (ends[0], ends[1])
    };
    let h = mesh.half_edges().find(from).unwrap();
    let e = mesh.edge(h);
    let against = mesh.edge_half_edge(e) != h;
    let turned = |v: [f64; 4]| if against { [v[3], v[2], v[1], v[0]] } else { v };
    for (side, name) in SIDES {
        let (s, wanted) = (side.sign(), &golden[name]);
        let Some(cell) = f.hull().edges()[e.index()].cells[side.index()] else {
            assert!(wanted.is_null());
            continue;
        };
        let (mu, nu) = if against { (turned(cell.nu), turned(cell.mu)) } else { (cell.mu, cell.nu) };
        all_close(&mu, &wanted["mu"], "mu");
        all_close(&nu, &wanted["nu"], "nu");
        let function = f.edge_function(e, side).unwrap();
        let names = if against {
            ["a1011", "a1101", "b1011", "b1101", "f2001", "f1002"]
        } else {
            ["b1101", "b1011", "a1101", "a1011", "f1002", "f2001"]
        };
        let ours =
            [function.b[0], function.b[1], function.a[0], function.a[1], function.far[0], function.far[1]];
        names.iter().zip(ours).for_each(|(name, ours)| close(s * ours, float(&wanted[*name]), name));
    }
    let (n, m) = (float(&golden["n"]), float(&golden["m"]));
    for (i, row) in golden["points"].as_array().unwrap().iter().enumerate() {
        for (j, p) in row.as_array().unwrap().iter().enumerate() {
            let (x, y) = (i as f64 / n, j as f64 / m);
            let shot = if against {
                f.shoot_edge(e, [1.0 - x, x], 1.0 - y)
            } else {
                f.shoot_edge(e, [x, 1.0 - x], y)
            };
            match (shot, golden["t"][i][j].as_f64()) {
                (Some(shot), Some(t)) => {
                    close(shot.side.sign() * shot.t, t, "t of an edge");
                    all_close(shot.point.as_slice(), p, "point of an edge");
                }
                // The file has points for an edge without a cell as well.
                (None, Some(0.0)) => assert_eq!(f.hull().edges()[e.index()].cells, [None; 2]),
                (ours, wanted) => assert!(ours.is_none() && wanted.is_none(), "{ours:?} for {wanted:?}"),
            }
        }
    }
}

fn check(golden: &Value) {
    let f = build(golden);
    check_hull(&f, golden);
    for (face, wanted) in f.hull().data().mesh().faces().zip(golden["faces_out"].as_array().unwrap()) {
        check_face(&f, face, wanted);
    }
    golden["edges_out"].as_array().unwrap().iter().for_each(|e| check_edge(&f, e));
    check_step_8(&f, golden);
    check_bounds(&f, golden);
}

/// Defaults of the paper's rule, whatever rule the file was made with.
fn check_step_8(f: &APatchFunction, golden: &Value) {
    let linear =
        APatchOptions { layer2: Layer2Rule::LeastSquares, rule: FreeRule::Linear, free: Free::Default };
    let f = apatch::build(f.hull().clone(), &linear);
    for (values, face) in f.default_free().iter().zip(golden["faces_out"].as_array().unwrap()) {
        for (side, name) in SIDES {
            if let Some(p0001) = face[name]["p0001"].as_f64() {
                close(side.sign() * values[side.index()], p0001, "p0001");
            }
        }
    }
}

/// The paper's lower bounds, sampled on the files' grid of 40: of the faces (sharp, and by the lemma), and with the edges.
fn check_bounds(f: &APatchFunction, golden: &Value) {
    let near = |ours: f64, wanted: &Value, what: &str| {
        let Some(wanted) = wanted.as_f64() else { return };
        assert!((ours - wanted).abs() <= 1e-3 * (1.0 + wanted.abs()), "{what}: {ours} for {wanted}");
    };
    let faces = golden["faces_out"].as_array().unwrap();
    let mut sharp = vec![[0.0; 2]; faces.len()];
    for (i, face) in faces.iter().enumerate() {
        for (side, name) in SIDES {
            let Some(cell) = &f.faces()[i].sides[side.index()] else { continue };
            let (mut most, mut lemma) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
            for x in triangle::lattice(40) {
                let [b1, b2, _] = cell.layers(x, 0.0);
                let layers = [side.sign() * f.faces()[i].base.value(x).0, b1, b2, 0.0];
                most = most.max(cubic::sharp_bound(&layers).0);
                lemma = lemma.max(cubic::lemma_bound(&layers));
            }
            near(side.sign() * most, &face[name]["B_face_sharp"], "B_face_sharp");
            near(side.sign() * lemma, &face[name]["B_face_lemma"], "B_face_lemma");
            sharp[i][side.index()] = most;
        }
    }
    check_lifts(f, golden, &sharp);
}

/// What the bounds of both faces must be raised by for the rays over an edge.
fn check_lifts(f: &APatchFunction, golden: &Value, sharp: &[[f64; 2]]) {
    let mesh = f.hull().data().mesh();
    let at_bound = f.clone().with_free(&Free::PerFace(sharp.to_vec()));
    let mut bounds = sharp.to_vec();
    for e in mesh.edges() {
        for side in Side::BOTH {
            let lift = lift(&at_bound, e, side);
            for h in f.hull().data().joint(e).into_iter().flatten().filter(|_| lift > 0.0) {
                let i = mesh.face(h).index();
                bounds[i][side.index()] = bounds[i][side.index()].max(sharp[i][side.index()] + lift);
            }
        }
    }
    for (face, bounds) in golden["faces_out"].as_array().unwrap().iter().zip(bounds) {
        for (side, name) in SIDES {
            if let Some(wanted) = face[name]["B_final"].as_f64() {
                let ours = side.sign() * bounds[side.index()];
                assert!((ours - wanted).abs() <= 1e-3 * (1.0 + wanted.abs()), "B_final: {ours} for {wanted}");
            }
        }
    }
}

fn lift(f: &APatchFunction, e: EdgeId, side: Side) -> f64 {
    let (Some(function), Some(cell)) = (f.edge_function(e, side), f.edges()[e.index()][side.index()]) else {
        return f64::NEG_INFINITY;
    };
    let [mu, nu] = cell.reach;
    let mut lift = f64::NEG_INFINITY;
    for i in 0..=40 {
        for j in 0..=40 {
            let (x, y) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
            let r = 1.0 - y;
            let beta = y * y * (1.0 + 2.0 * mu * r) + r * r * (1.0 + 2.0 * nu * y);
            lift = lift.max(cubic::sharp_bound(&function.layers(x, 1.0 - x, y)).0 / beta);
        }
    }
    lift
}

#[test]
fn the_figures_of_the_paper_are_reproduced() {
    for name in ["fig6", "fig7_printed", "fig9", "fig10", "fig2_b-1"] {
        check(&golden(&format!("apatch/{name}")));
    }
}

#[test]
fn the_other_golden_files_are_reproduced() {
    let names = ["fig2_b-2", "fig2_b0", "fig2_b1", "fig2_b4", "fig2_b16", "fig2_b64", "fig3_at_bound"];
    let more = ["fig7_n3_like_fig6", "icosahedron_sphere_neigh", "icosahedron_sphere_paper"];
    for name in names.into_iter().chain(more).chain(["icosahedron_mixed", "icosahedron_perturbed"]) {
        let Some(golden) = data_file(&format!("golden/apatch/{name}.json")) else {
            return skip("the_other_golden_files_are_reproduced");
        };
        eprintln!("{name}");
        check(&golden);
    }
}

#[test]
fn the_points_of_figure_6_are_those_of_the_text() {
    let f = build(&golden("apatch/fig6"));
    assert_eq!(f.hull().data().positions()[0], Point3::new(-2.0, 0.0, 0.0));
    assert!((f.hull().faces()[0].heights[0] - 4.46670).abs() < 5e-6);
    assert_eq!(point(&golden("apatch/fig6")["vertices"][0]), f.hull().data().positions()[0]);
}
