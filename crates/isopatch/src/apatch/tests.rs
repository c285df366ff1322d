use super::*;
use crate::geom::{Point3, Vec3};
use crate::hull::test_meshes::{icosahedron, quadrics};
use crate::hull::{self, ApexRule, HermiteMesh, HullOptions, Side};
use crate::mesh::HalfEdgeMesh;

fn noise(n: usize) -> f64 {
    let x = (n as f64 * 12.9898 + 4.1).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

fn noise3(n: usize) -> Vec3 {
    Vec3::new(noise(3 * n), noise(3 * n + 1), noise(3 * n + 2))
}

/// The icosahedron with moved vertices and gradients that are neither radial nor of unit length.
fn perturbed(position: f64, gradient: f64) -> HermiteMesh {
    let (p, faces) = icosahedron();
    let gradients: Vec<Vec3> = p.iter().enumerate().map(|(i, p)| p + gradient * noise3(i + 100)).collect();
    let moved: Vec<Point3> = p.iter().enumerate().map(|(i, p)| p + position * noise3(i)).collect();
    let mesh = HalfEdgeMesh::from_faces(moved.len(), &faces).unwrap();
    HermiteMesh::new(mesh, moved, &gradients).unwrap()
}

fn function(data: HermiteMesh, rule: ApexRule) -> APatchFunction {
    let options = HullOptions { rule, ..HullOptions::default() };
    build(hull::build(data, &options), &APatchOptions::default())
}

#[test]
fn quadrics_are_reproduced() {
    for (name, quadric, data) in quadrics() {
        for rule in [ApexRule::Paper, HullOptions::default().rule] {
            for layer2 in [Layer2Rule::Interpolate, Layer2Rule::LeastSquares] {
                let options = APatchOptions { layer2, ..APatchOptions::default() };
                let hull = hull::build(data.clone(), &HullOptions { rule, ..HullOptions::default() });
                let f = build(hull, &options);
                let mut worst: f64 = 0.0;
                let mesh = data.mesh();
                for x in crate::bernstein::triangle::lattice(6) {
                    for face in mesh.faces() {
                        let shot = f.shoot_face(face, x).unwrap();
                        worst = worst.max(quadric.distance(&shot.point));
                        let normal = quadric.gradient(&shot.point).normalize();
                        assert!((shot.gradient.normalize() - normal).norm() < 1e-12, "{name}");
                    }
                }
                for e in mesh.edges() {
                    for i in 0..=6 {
                        for j in 0..=4 {
                            let x = f64::from(i) / 6.0;
                            if let Some(shot) = f.shoot_edge(e, [x, 1.0 - x], f64::from(j) / 4.0) {
                                worst = worst.max(quadric.distance(&shot.point));
                            }
                        }
                    }
                }
                eprintln!("{name} {layer2:?}: {worst:.1e}");
                assert!(worst <= if name == "plane" { 0.0 } else { 1e-14 }, "{name}: {worst:e}");
            }
        }
    }
}

/// Largest jumps of value and gradient, relative to the largest gradient, across all internal faces of the hull.
fn c1_jump(f: &APatchFunction) -> f64 {
    let mesh = f.hull().data().mesh();
    let (mut worst, mut compared): (f64, usize) = (0.0, 0);
    let mut compare = |pairs: Vec<[Option<(f64, Vec3)>; 2]>| {
        let pairs: Vec<_> = pairs.into_iter().map(|[a, b]| (a.unwrap(), b.unwrap())).collect();
        let scale = pairs.iter().map(|(a, _)| a.1.norm()).fold(0.0, f64::max);
        for (a, b) in &pairs {
            worst = worst.max((a.1 - b.1).norm() / scale).max((a.0 - b.0).abs() / scale);
        }
        compared += pairs.len();
    };
    let points = crate::bernstein::triangle::interior_lattice(9);
    for face in mesh.faces() {
        if let [Some(_), Some(_)] = f.hull().faces()[face.index()].apexes {
            compare(points.iter().map(|[x, y, z]| Side::BOTH.map(|s| f.in_face_cell(face, s, [*x, *y, *z, 0.0]))).collect());
        }
    }
    for e in mesh.edges() {
        let Some(joint) = f.hull().data().joint(e) else { continue };
        for side in Side::BOTH.into_iter().filter(|s| f.edges()[e.index()][s.index()].is_some()) {
            for (h, left) in joint.into_iter().zip([true, false]) {
                let (face, k) = (mesh.face(h), mesh.side(h));
                let at = |[x, z, w]: [f64; 3]| {
                    let mut in_face = [0.0, 0.0, 0.0, w];
                    let (i, j) = if left { (k, (k + 1) % 3) } else { ((k + 1) % 3, k) };
                    (in_face[i], in_face[j]) = (x, z);
                    let in_edge = if left { [0.0, x, z, w] } else { [w, x, z, 0.0] };
                    [f.in_face_cell(face, side, in_face), f.in_edge_cell(e, side, in_edge)]
                };
                compare(points.iter().map(|x| at(*x)).collect());
            }
        }
    }
    assert!(compared > 0);
    worst
}

#[test]
fn the_function_is_c1_across_the_faces_of_the_hull() {
    for (position, gradient) in [(0.0, 0.0), (0.0, 0.3), (0.1, 0.0), (0.1, 0.3), (0.1, 0.6)] {
        for rule in [ApexRule::Paper, HullOptions::default().rule] {
            let f = function(perturbed(position, gradient), rule);
            let mut classes = std::collections::BTreeMap::new();
            f.hull().faces().iter().for_each(|f| *classes.entry(format!("{:?}", f.class)).or_insert(0) += 1);
            let jump = c1_jump(&f);
            eprintln!("{position} {gradient}: {jump:.1e} {classes:?} {:?}", f.hull().problems());
            assert!(jump < 1e-11, "{position} {gradient}: {jump:e}");
        }
    }
}
