//! Surfaces to test with: splines from golden files, and copies of them that are moved, turned and joined.

#![allow(clippy::unwrap_used, clippy::panic)] // Test data that is wrong has to stop the test.

use isopatch::base::{BaseMesh, EdgeFeature};
use isopatch::bernstein::{curve, index};
use isopatch::geom::{Mat3, Point3, Vec3};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::spline::TriangularSpline;
use std::collections::HashMap;
use std::path::Path;

const DEGREE: usize = 7;
const NET: usize = index::count(DEGREE);

/// The spline of a golden file. Borders are elevated here, once an edge, from the quartics in the file.
pub fn load(path: &Path) -> TriangularSpline {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let points = |v: &serde_json::Value| v.as_array().unwrap().iter().map(point).collect::<Vec<_>>();
    let faces: Vec<[u32; 3]> = serde_json::from_value(json["faces"].clone()).unwrap();
    let ends = |key: &str| serde_json::from_value::<Vec<u32>>(json["edges"][key].clone()).unwrap();
    let quartics = json["edges"]["q"].as_array().unwrap();
    let mut curves = HashMap::new();
    for ((a, b), q) in ends("a").into_iter().zip(ends("b")).zip(quartics) {
        let q: [Point3; 5] = points(q).try_into().unwrap();
        curves.insert((a, b), q);
        curves.insert((b, a), std::array::from_fn(|i| q[4 - i]));
    }
    let matrix = |v: &serde_json::Value| {
        let rows: Vec<Vec3> = points(v);
        Mat3::from_columns(&rows).transpose()
    };
    build(
        &faces,
        points(&json["vertices"]),
        points(&json["normals"]),
        json["curvature_tensor_M"].as_array().unwrap().iter().map(matrix).collect(),
        &curves,
        json["control_nets"].as_array().unwrap().iter().map(|n| points(n).try_into().unwrap()).collect(),
    )
}

fn point(v: &serde_json::Value) -> Point3 {
    let [x, y, z]: [f64; 3] = serde_json::from_value(v.clone()).unwrap();
    Point3::new(x, y, z)
}

/// The unit sphere over an icosahedron: 20 patches.
pub fn sphere() -> TriangularSpline {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/sphere_icosahedron_rec.json"))
}

/// One flat patch with three boundary edges, facing up.
pub fn flat_triangle() -> TriangularSpline {
    let corners = vec![Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
    let along = |a: u32, b: u32| -> [Point3; 5] {
        std::array::from_fn(|i| corners[a as usize].lerp(&corners[b as usize], i as f64 / 4.0))
    };
    let curves = [(0, 1), (1, 2), (2, 0)].into_iter().map(|(a, b)| ((a, b), along(a, b))).collect();
    let mut net = [Point3::zeros(); NET];
    for ijk in index::indices(DEGREE) {
        net[index::position(ijk)] = (0..3).map(|c| ijk[c] as f64 / DEGREE as f64 * corners[c]).sum();
    }
    build(&[[0, 1, 2]], corners.clone(), vec![Vec3::z(); 3], vec![Mat3::zeros(); 3], &curves, vec![net])
}

/// Two flat patches that meet in a sharp edge, as on a roof.
pub fn roof() -> TriangularSpline {
    let corners = vec![
        Point3::new(0.0, 0.0, 1.0),
        Point3::new(2.0, 0.0, 1.0),
        Point3::new(1.0, 1.0, 0.0),
        Point3::new(1.0, -1.0, 0.0),
    ];
    let faces = [[0, 1, 2], [1, 0, 3]];
    let at = |v: u32| corners[v as usize];
    let along =
        |a: u32, b: u32| -> [Point3; 5] { std::array::from_fn(|i| at(a).lerp(&at(b), i as f64 / 4.0)) };
    let edges = faces.iter().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]);
    let curves = edges.map(|(a, b)| ((a, b), along(a, b))).collect();
    let net = |f: &[u32; 3]| {
        let mut net = [Point3::zeros(); NET];
        for ijk in index::indices(DEGREE) {
            net[index::position(ijk)] = (0..3).map(|c| ijk[c] as f64 / DEGREE as f64 * at(f[c])).sum();
        }
        net
    };
    let nets = faces.iter().map(net).collect();
    let made = build(&faces, corners.clone(), vec![Vec3::z(); 4], vec![Mat3::zeros(); 4], &curves, nets);
    let mut base = made.base.clone();
    let inner = |feature: &EdgeFeature| *feature == EdgeFeature::Smooth;
    base.features.iter_mut().filter(|f| inner(f)).for_each(|feature| *feature = EdgeFeature::Sharp);
    TriangularSpline::new(base, made.curves, made.nets)
}

/// The spline enlarged by a factor and then moved.
pub fn scaled(spline: &TriangularSpline, factor: f64, shift: Vec3) -> TriangularSpline {
    let mut base = spline.base.clone();
    base.positions.iter_mut().for_each(|p| *p = factor * *p + shift);
    base.curvatures.iter_mut().for_each(|m| *m /= factor);
    let moved = |p: Point3| factor * p + shift;
    let curves = curves_of(spline).into_iter().map(|(ends, q)| (ends, q.map(moved))).collect();
    let nets = spline.nets.iter().map(|n| n.map(moved)).collect();
    build(&faces(spline), base.positions, base.normals, base.curvatures, &curves, nets)
}

/// The spline with its inside and outside exchanged.
pub fn inverted(spline: &TriangularSpline) -> TriangularSpline {
    let flipped: Vec<_> = faces(spline).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let mirror = |net: &[Point3; NET]| {
        let mut mirrored = *net;
        for [i, j, k] in index::indices(DEGREE) {
            mirrored[index::position([i, k, j])] = net[index::position([i, j, k])];
        }
        mirrored
    };
    let base = &spline.base;
    let normals = base.normals.iter().map(|n| -n).collect();
    let curvatures = base.curvatures.iter().map(|m| -m).collect();
    let nets = spline.nets.iter().map(mirror).collect();
    build(&flipped, base.positions.clone(), normals, curvatures, &curves_of(spline), nets)
}

/// Several splines as one.
pub fn joined(parts: &[TriangularSpline]) -> TriangularSpline {
    let (mut all_faces, mut nets, mut curves) = (Vec::new(), Vec::new(), HashMap::new());
    let (mut positions, mut normals, mut curvatures) = (Vec::new(), Vec::new(), Vec::new());
    for part in parts {
        let first = positions.len() as u32;
        all_faces.extend(faces(part).into_iter().map(|f| f.map(|v| v + first)));
        curves.extend(curves_of(part).into_iter().map(|((a, b), q)| ((a + first, b + first), q)));
        positions.extend(&part.base.positions);
        normals.extend(&part.base.normals);
        curvatures.extend(&part.base.curvatures);
        nets.extend(&part.nets);
    }
    build(&all_faces, positions, normals, curvatures, &curves, nets)
}

fn faces(spline: &TriangularSpline) -> Vec<[u32; 3]> {
    let mesh = &spline.base.mesh;
    mesh.faces().map(|f| mesh.triangle(f).map(|v| v.0)).collect()
}

fn curves_of(spline: &TriangularSpline) -> HashMap<(u32, u32), [Point3; 5]> {
    let mesh = &spline.base.mesh;
    let mut curves = HashMap::new();
    for e in mesh.edges() {
        let (h, q) = (mesh.edge_half_edge(e), spline.curves[e.index()]);
        curves.insert((mesh.origin(h).0, mesh.dest(h).0), q);
        curves.insert((mesh.dest(h).0, mesh.origin(h).0), std::array::from_fn(|i| q[4 - i]));
    }
    curves
}

fn build(
    faces: &[[u32; 3]],
    positions: Vec<Point3>,
    normals: Vec<Vec3>,
    curvatures: Vec<Mat3>,
    curves: &HashMap<(u32, u32), [Point3; 5]>,
    mut nets: Vec<[Point3; NET]>,
) -> TriangularSpline {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces).unwrap();
    let (mut features, mut ordered) = (Vec::new(), Vec::new());
    for e in mesh.edges() {
        let h = mesh.edge_half_edge(e);
        let quartic = curves[&(mesh.origin(h).0, mesh.dest(h).0)];
        ordered.push(quartic);
        let border = curve::elevate::<5, 8>(&quartic);
        let mut put = |h, reversed: bool| {
            let net: &mut [Point3; NET] = &mut nets[mesh.face(h).index()];
            for m in 0..=DEGREE {
                net[index::row(DEGREE, mesh.side(h), 0, m)] = border[if reversed { DEGREE - m } else { m }];
            }
        };
        put(h, false);
        features.push(match mesh.twin(h) {
            Some(g) => {
                put(g, true);
                EdgeFeature::Smooth
            }
            None => EdgeFeature::Boundary,
        });
    }
    let base = BaseMesh { mesh, positions, normals, curvatures, features, clip: None, frozen_diagonal: None };
    TriangularSpline::new(base, ordered, nets)
}
