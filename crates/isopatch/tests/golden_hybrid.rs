//! Hybrid A-patches against numbers of an independent program (tests/golden/hybrid; the larger files from
//! `ISOPATCH_TEST_DATA`).
//!
//! The files give the hull: apexes, quadrics and F, ∇F at an apex. Coefficients are named by the multiplicities of the corners of
//! a cell, apexes first, in the sign of the function on both sides.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::bernstein::{cubic, pyramid, tetrahedron};
use isopatch::geom::Point3;
use isopatch::hull::{Class, Side};
use isopatch::hybrid::{
    Element, FaceCells, FanNet, Foot, HermitePolygons, HybridEdge, HybridFace, HybridFunction, HybridHull,
    Jet, PyramidCell, Quadric, Sectors,
};
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use serde_json::Value;
use support::{data_file, float, floats, golden, point, points, skip};

const TOLERANCE: f64 = 1e-11;

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
        "pos" => Class::Positive,
        "neg" => Class::Negative,
        "zero" => Class::Zero,
        "non" => Class::Nonconvex,
        other => unreachable!("class {other}"),
    }
}

fn digits(name: &str) -> Vec<usize> {
    name.bytes().map(|b| usize::from(b - b'0')).collect()
}

/// The edge between two vertices.
fn edge_between(mesh: &HalfEdgeMesh, i: u32, j: u32) -> EdgeId {
    let ends = |e: &EdgeId| {
        let h = mesh.edge_half_edge(*e);
        [mesh.origin(h).0, mesh.dest(h).0]
    };
    mesh.edges().find(|e| ends(e) == [i, j] || ends(e) == [j, i]).unwrap()
}

fn face(golden: &Value) -> HybridFace {
    let element = match golden["kind"].as_str().unwrap() {
        "tri" => Element::Triangle,
        "pyr" => Element::Pyramid,
        "fan" => Element::Fan,
        "gpyr" | "gbip" => Element::Sectors,
        other => unreachable!("element {other}"),
    };
    let apexes = ["u", "v"].map(|name| golden[name].is_array().then(|| point(&golden[name])));
    let quadric = &golden["quadric"];
    let theta = floats(&golden["theta"]);
    let jet = Jet { value: theta[0], gradient: Point3::new(theta[1], theta[2], theta[3]) };
    let at_apex = match element {
        Element::Sectors => [None; 2],
        Element::Fan => [None, Some(jet)],
        Element::Triangle | Element::Pyramid => apexes.map(|apex| apex.map(|_| jet)),
    };
    HybridFace {
        class: class(&golden["pclass"]),
        element: Some(element),
        center: point(&golden["c"]),
        normal: point(&golden["n"]),
        apexes,
        at_apex,
        quadric: Quadric {
            coefficients: floats(&quadric["q"]).try_into().unwrap(),
            center: point(&quadric["centre"]),
            scale: float(&quadric["scale"]),
        },
    }
}

fn build(golden: &Value) -> HybridFunction {
    let polygons: Vec<Vec<u32>> = serde_json::from_value(golden["polys"].clone()).unwrap();
    let positions = points(&golden["V"]);
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &polygons).unwrap();
    let mut data = HermitePolygons::new(mesh, positions, &points(&golden["N"])).unwrap();
    let faces: Vec<HybridFace> = golden["polygons"].as_array().unwrap().iter().map(face).collect();
    let mut edges = vec![HybridEdge { class: Class::Zero, cells: [false; 2] }; data.mesh().edge_count()];
    for (ends, wanted) in golden["edges"].as_object().unwrap() {
        let (i, j) = ends.split_once(',').unwrap();
        let e = edge_between(data.mesh(), i.parse().unwrap(), j.parse().unwrap());
        let h = data.mesh().edge_half_edge(e);
        let class = class(&wanted["cls"]);
        assert_eq!(data.edge_class(h), class, "{ends}");
        // The files with relaxed fans have moved what is not fixed by the vertices.
        data.move_middle(e, point(&wanted["g"]) - data.middle(h));
        all_close(data.middle(h).as_slice(), &wanted["g"], "g");
        let beside = data.joint(e).map(|pair| pair.map(|h| &faces[data.mesh().face(h).index()].apexes));
        let cells =
            [0, 1].map(|s| beside.is_some_and(|beside| beside.iter().all(|apexes| apexes[s].is_some())));
        edges[e.index()] = HybridEdge { class, cells };
    }
    HybridFunction::new(HybridHull { data, faces, edges })
}

/// A net of 20 by the names of the file.
fn check_net(ours: &[f64], golden: &Value, what: &str) {
    for (name, wanted) in golden.as_object().unwrap() {
        let index: [usize; 4] = digits(name).try_into().unwrap();
        close(ours[tetrahedron::position(index)], float(wanted), &format!("{what} {name}"));
    }
}

fn check_triangle(f: &HybridFunction, face: usize, golden: &Value) {
    let FaceCells::Triangle { function, free } = &f.faces()[face] else { unreachable!() };
    let side = Side::BOTH.into_iter().find(|side| function.sides[side.index()].is_some()).unwrap();
    let (s, base, b) = (side.sign(), &function.base, s_free(free, side));
    let cell = function.sides[side.index()].as_ref().unwrap();
    let mean = base.middle.iter().sum::<f64>() / 3.0;
    for (name, wanted) in golden["co"].as_object().unwrap() {
        let index = digits(name);
        let at = |n: usize| (1..4).find(|c| index[*c] == n).map(|c| c - 1);
        let ours = match index[0] {
            3 => s * b,
            2 => s * (b / 3.0 + 2.0 / 3.0 * cell.q[at(1).unwrap()]),
            1 => match at(2) {
                Some(corner) => s * cell.layer1.corner[corner],
                None => s * cell.layer1.edge[(at(0).unwrap() + 1) % 3],
            },
            _ => match (at(3), at(2)) {
                (Some(_), _) => 0.0,
                (_, Some(two)) => base.e[two][at(1).unwrap()],
                _ => mean,
            },
        };
        close(ours, float(wanted), name);
    }
    // t^(m) belongs to the edge opposite to corner m.
    let rational = [0, 1, 2].map(|m| base.middle[(m + 1) % 3] - mean);
    all_close(&rational, &golden["rat"], "t_0111");
}

fn s_free(free: &[f64; 2], side: Side) -> f64 {
    free[side.index()]
}

fn check_pyramid(cell: &PyramidCell, golden: &Value) {
    let s = cell.side.sign();
    for [i, j, k] in pyramid::indices(3) {
        let inner = |j: usize, k: usize| [[2, 2], [1, 2], [2, 1], [1, 1]].iter().position(|c| *c == [j, k]);
        let ours = match (i, inner(j, k)) {
            (0, Some(n)) => 0.5 * (cell.inner[n][0] + cell.inner[n][1]),
            (0, _) => cell.base[j][k],
            (1, _) if j == 1 && k == 1 => cell.middle.iter().sum::<f64>() / 4.0,
            (1, _) => cell.layer1[j][k],
            (2, _) => cell.layer2[j][k],
            _ => cell.layer3,
        };
        close(s * ours, float(&golden["b"][i][j][k]), &format!("b_{i}{j}{k}"));
    }
    let names = [["022l", "022b"], ["012r", "012b"], ["021l", "021t"], ["011r", "011t"]];
    for (names, values) in names.iter().zip(cell.inner) {
        let mean = 0.5 * (values[0] + values[1]);
        for (name, value) in names.iter().zip(values) {
            close(s * (value - mean), float(&golden["rat"][name]), name);
        }
    }
    let mean = cell.middle.iter().sum::<f64>() / 4.0;
    for (name, value) in ["111l", "111r", "111t", "111b"].iter().zip(cell.middle) {
        close(s * (value - mean), float(&golden["rat"][name]), name);
    }
}

fn check_fan(f: &HybridFunction, face: usize, golden: &Value) {
    let hull = f.hull();
    let given = &hull.faces[face];
    let [u, v] = given.apexes.map(Option::unwrap);
    let net = FanNet::new(&hull.data.frame(face.into()), &u, &v, &given.at_apex[1].unwrap());
    for (s, wanted) in golden.as_array().unwrap().iter().enumerate() {
        check_net(&net.sector(s), &wanted["co"], "fan");
    }
}

/// The net of [a c p_k p_(k+1)] and its rational data.
fn sector_net(sectors: &Sectors, side: Side, k: usize) -> ([f64; 20], [f64; 4]) {
    let (base, cell) = (&sectors.base[k], &sectors.sides[side.index()].as_ref().unwrap()[k]);
    let s = side.sign();
    let mut net = [0.0; 20];
    for index in tetrahedron::indices(3) {
        let [a, c, p, q] = index;
        let pick = |names: &[[usize; 3]], values: &[f64]| {
            names.iter().position(|n| *n == [c, p, q]).map_or(0.0, |n| values[n])
        };
        let quadratic = [[2, 0, 0], [1, 1, 0], [1, 0, 1], [0, 2, 0], [0, 1, 1], [0, 0, 2]];
        let cubic = [[3, 0, 0], [2, 1, 0], [2, 0, 1], [1, 2, 0], [1, 1, 1], [1, 0, 2], [0, 2, 1], [0, 1, 2]];
        net[tetrahedron::position(index)] = match a {
            0 => pick(&cubic, &base.net),
            1 => s * pick(&quadratic, &cell.layer1),
            2 => s * pick(&[[1, 0, 0], [0, 1, 0], [0, 0, 1]], &cell.layer2),
            _ => s * cell.layer3,
        };
    }
    (net, [base.turn[0], base.turn[1], s * cell.turn[0], s * cell.turn[1]])
}

fn check_sectors(sectors: &Sectors, golden: &Value, both: bool) {
    let sides: Vec<Side> =
        Side::BOTH.into_iter().filter(|side| sectors.sides[side.index()].is_some()).collect();
    assert_eq!(sides.len(), if both { 2 } else { 1 });
    for (n, side) in sides.into_iter().enumerate() {
        let golden = if both { &golden[n] } else { golden };
        for (k, wanted) in golden.as_array().unwrap().iter().enumerate() {
            let (net, rational) = sector_net(sectors, side, k);
            check_net(&net, &wanted["co"], "sector");
            all_close(&rational, &wanted["rat"], "rational");
        }
    }
}

fn check_edges(f: &HybridFunction, golden: &Value) {
    let mesh = f.hull().data.mesh();
    let cells = golden["edge_tets"].as_array().unwrap();
    assert_eq!(cells.len(), f.cell_counts()[1]);
    for wanted in cells {
        let [i, j]: [u32; 2] = serde_json::from_value(wanted["edge"].clone()).unwrap();
        let side = if wanted["sign"] == 1 { Side::Outer } else { Side::Inner };
        let e = edge_between(mesh, i, j);
        let h = mesh.edge_half_edge(e);
        assert_eq!(u64::from(mesh.face(h).0), wanted["lr"][0].as_u64().unwrap());
        let (function, s) = (f.edge_function(e, side).unwrap(), side.sign());
        // Our edges run as the left face does.
        let forward = mesh.origin(h).0 == i;
        let turn = |pair: [f64; 2]| if forward { pair } else { [pair[1], pair[0]] };
        let (left, right) = (&function.left, &function.right);
        for (name, wanted) in wanted["co"].as_object().unwrap() {
            let [l, r, at_i, at_j]: [usize; 4] = digits(name).try_into().unwrap();
            let on_rim = |rim: &isopatch::apatch::Rim| match (l + r, at_i.max(at_j)) {
                (3, _) => rim.b,
                (2, _) => turn([rim.layer2(1.0, 0.0), rim.layer2(0.0, 1.0)])[at_j],
                (_, 1) => rim.layer1[1],
                _ => turn([rim.layer1[0], rim.layer1[2]])[usize::from(at_j == 2)],
            };
            let ours = match (l, r) {
                (0, 0) if at_i == 3 || at_j == 3 => 0.0,
                (0, 0) => turn(function.e)[usize::from(at_j == 2)],
                (_, 0) => on_rim(left),
                (0, _) => on_rim(right),
                (2, 1) => function.far[0],
                (1, 2) => function.far[1],
                _ => 0.0,
            };
            close(s * ours, float(wanted), name);
        }
        let ([l_i, l_j], [r_i, r_j]) = (turn(function.b), turn(function.a));
        all_close(&[l_i, r_i, l_j, r_j].map(|x| s * x), &wanted["rat"], "rational");
    }
}

/// A point of the surface, or that there is none.
fn check_sample(f: &HybridFunction, wanted: &Value) {
    let tag = wanted["tag"].as_array().unwrap();
    let numbers = |v: &Value| floats(v);
    let (layers, shot) = if tag[0] == "edge" {
        // Edges whose start has no cell are named by their number alone.
        if tag.len() < 4 || tag[2].is_u64() && tag[3].is_u64() && wanted["x"].is_null() {
            return;
        }
        let [i, j]: [u32; 2] = serde_json::from_value(tag[1].clone()).unwrap();
        let mesh = f.hull().data.mesh();
        let e = edge_between(mesh, i, j);
        let (to_j, to_right) = (float(&tag[2]), float(&tag[3]));
        let forward = mesh.origin(mesh.edge_half_edge(e)).0 == i;
        let x = if forward { [1.0 - to_j, to_j] } else { [to_j, 1.0 - to_j] };
        let shot = f.shoot_edge(e, x, 1.0 - to_right);
        let layers = shot.and_then(|shot| {
            Some((shot.side, f.edge_function(e, shot.side)?.layers(x[0], x[1], 1.0 - to_right)))
        });
        (layers, shot)
    } else {
        let face = FaceId(u32::try_from(tag[1].as_u64().unwrap()).unwrap());
        let at = numbers(&tag[2]);
        let foot = match tag[0].as_str().unwrap() {
            "tri" => Foot::Triangle([at[1], at[2], at[3]]),
            "pyr" => Foot::Pyramid([at[0], at[1]]),
            _ => Foot::Sector(at[0] as usize, [1.0 - at[1] - at[2], at[1], at[2]]),
        };
        let class = f.hull().faces[face.index()].class;
        (f.faces()[face.index()].layers(class, foot), f.shoot_from(face, foot, [[0.0; 3]; 2]))
    };
    if let Some((side, layers)) = layers {
        let signed = layers.map(|b| side.sign() * b);
        all_close(&signed, &wanted["L"], &format!("layers of {tag:?}"));
    }
    if wanted["x"].is_null() {
        assert!(shot.is_none(), "{tag:?} {}", wanted["status"]);
        return;
    }
    let shot = shot.unwrap_or_else(|| unreachable!("no root for {tag:?}"));
    close(shot.t, float(&wanted["t"]), "t");
    all_close(shot.point.as_slice(), &wanted["x"], "point");
    all_close(shot.gradient.as_slice(), &wanted["g"], &format!("gradient of {tag:?}"));
}

fn check(golden: &Value) {
    let f = build(golden);
    for (n, wanted) in golden["polygons"].as_array().unwrap().iter().enumerate() {
        let elements = &wanted["el"];
        match (&f.faces()[n], wanted["kind"].as_str().unwrap()) {
            (FaceCells::Triangle { .. }, "tri") => check_triangle(&f, n, elements),
            (FaceCells::Pyramid(cell), "pyr") => check_pyramid(cell, elements),
            (FaceCells::Sectors(_), "fan") => check_fan(&f, n, elements),
            (FaceCells::Sectors(sectors), kind) => check_sectors(sectors, elements, kind == "gbip"),
            _ => unreachable!(),
        }
    }
    check_edges(&f, golden);
    golden["samples"].as_array().unwrap().iter().for_each(|sample| check_sample(&f, sample));
}

#[test]
fn formulas_are_reproduced() {
    let golden = golden("hybrid/formulas");
    let net = |json: &Value| -> Vec<f64> {
        let degree: usize = digits(json.as_object().unwrap().keys().next().unwrap()).iter().sum();
        let name = |index: [usize; 4]| index.map(|i| i.to_string()).concat();
        tetrahedron::indices(degree).map(|index| float(&json[name(index)])).collect()
    };
    let array = |json: &Value| -> [f64; 4] { floats(json).try_into().unwrap() };
    let compare = |ours: &[f64], wanted: &Value, degree: usize| {
        for ([i, j, k], b) in pyramid::indices(degree).zip(ours) {
            close(*b, float(&wanted[i][j][k]), "pyramid");
        }
    };
    let conversion = &golden["tet_to_pyr_deg2"];
    let quadratic = pyramid::from_tetrahedron(2, &net(&conversion["a"]), &array(&conversion["a4"]));
    compare(&quadratic, &conversion["b"], 2);
    let cubic = pyramid::elevated(3, &quadratic);
    compare(&cubic, &conversion["elevated_deg3"], 3);

    let corners: [Point3; 5] = points(&conversion["P"]).try_into().unwrap();
    for sample in golden["pyramid_eval"].as_array().unwrap() {
        let ust: [f64; 3] = floats(&sample["ust"]).try_into().unwrap();
        all_close(pyramid::point(&corners, ust).as_slice(), &sample["x"], "point");
        close(pyramid::value(3, &cubic, ust), float(&sample["F"]), "value");
        all_close(&pyramid::derivatives(3, &cubic, ust), &sample["dF_dust"], "derivatives");
    }

    let corollary = &golden["corollary21"];
    let (a, p1, p3) = (net(&corollary["a"]), array(&corollary["av"]), array(&corollary["bv"]));
    for (name, wanted) in corollary["b"].as_object().unwrap() {
        let ijk: [usize; 3] = digits(name).try_into().unwrap();
        close(pyramid::continued_c1(3, &a, [&p1, &p3], ijk), float(wanted), name);
        close(pyramid::continued(3, &a, [&p1, &p3], ijk), float(wanted), name);
    }

    for roots in golden["cubic_roots"].as_array().unwrap() {
        let ours = cubic::minimal_root(&array(&roots["L"]));
        match roots["roots"].get(0) {
            Some(wanted) => close(ours.unwrap(), float(wanted), "root"),
            None => assert_eq!(ours, None),
        }
    }
}

#[test]
fn fans_and_sectors_of_quadrilaterals_are_reproduced() {
    for name in ["nonconvex_convex_quads_fan", "nonconvex_quad_pair_fan", "nonconvex_quad_pair_gbip"] {
        check(&golden(&format!("hybrid/{name}")));
    }
}

#[test]
fn the_other_golden_files_are_reproduced() {
    let quads = ["convex_quads_open", "cube_sphere", "mixed_cubocta", "mixed_cubocta_g"];
    let pentagons = ["dodeca_ellipsoid_fan", "dodeca_ellipsoid_gpyr"];
    let mixed = ["pentagon_triangles_fan_relaxed", "pentagon_triangles_gpyr"];
    for name in quads.into_iter().chain(pentagons).chain(mixed) {
        let Some(golden) = data_file(&format!("golden/hybrid/{name}.json")) else {
            return skip("the_other_golden_files_are_reproduced");
        };
        eprintln!("{name}");
        check(&golden);
    }
}
