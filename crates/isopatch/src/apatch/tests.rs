use super::*;
use crate::geom::{Point3, Points, Vec3};
use crate::hull::test_meshes::{noise3, perturbed, quadrics};
use crate::hull::{self, ApexRule, HermiteMesh, HullOptions, Side};
use crate::surface::{Domain, SeamSide, Surface};

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
            compare(
                points
                    .iter()
                    .map(|[x, y, z]| Side::BOTH.map(|s| f.in_face_cell(face, s, [*x, *y, *z, 0.0])))
                    .collect(),
            );
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

/// The side of a seam at the parameter s along it, in the parameters of its patch.
fn on_seam(surface: &APatchSurface, side: &SeamSide, s: f64) -> [f64; 2] {
    let (a, b) = if side.reversed { (1.0 - s, s) } else { (s, 1.0 - s) };
    surface.domain(side.patch).on_edge(side.edge, [b, a])
}

#[test]
fn patches_share_the_bits_of_their_seams_and_the_normals() {
    for (position, gradient) in [(0.0, 0.3), (0.1, 0.3), (0.1, 0.6)] {
        let surface =
            APatchSurface::new(function(perturbed(position, gradient), HullOptions::default().rule));
        assert!(surface.function().hull().problems().is_empty());
        let mut nonconvex = 0;
        for seam in surface.seams() {
            let second = seam.second.unwrap();
            for i in 0..=16 {
                let s = f64::from(i) / 16.0;
                let [a, b] =
                    [seam.first, second].map(|side| surface.sample(side.patch, on_seam(&surface, &side, s)));
                assert_eq!(a.point, b.point, "{seam:?}");
                assert!(
                    (a.normal - b.normal).norm() < 1e-13,
                    "{:e} at {s} of {seam:?}",
                    (a.normal - b.normal).norm()
                );
                assert!(a.normal.dot(&a.du).abs() < 1e-12 * a.du.norm());
                assert!(a.normal.dot(&a.dv).abs() < 1e-12 * a.dv.norm());
            }
            nonconvex += usize::from(surface.domain(second.patch) == Domain::Square);
        }
        assert_eq!(nonconvex, surface.seams().len());
    }
}

#[test]
fn the_surface_goes_through_the_vertices_with_their_normals() {
    let data = perturbed(0.1, 0.6);
    let surface = APatchSurface::new(function(data.clone(), HullOptions::default().rule));
    for patch in surface.patches() {
        let uv = match surface.domain(patch) {
            Domain::Triangle => [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]],
            Domain::Square | Domain::Polygon(_) => [[0.0, 0.3], [1.0, 0.2], [1.0, 1.0]],
        };
        let corners = surface.corners(patch).map(|v| v as usize);
        for (uv, v) in uv.into_iter().zip(corners) {
            let sample = surface.sample(patch, uv);
            assert_eq!(sample.point, data.positions()[v]);
            let h = data.mesh().ring(crate::mesh::VertexId::from(v)).next().unwrap();
            assert!((sample.normal - data.gradient(h).normalize()).norm() < 1e-13);
        }
    }
}

#[test]
fn derivatives_agree_with_differences() {
    let surface = APatchSurface::new(function(perturbed(0.1, 0.6), HullOptions::default().rule));
    let h = 1e-6;
    for patch in surface.patches() {
        let [u, v] = [0.31, 0.23];
        let sample = surface.sample(patch, [u, v]);
        let at = |u, v| surface.sample(patch, [u, v]).point;
        let du = (at(u + h, v) - at(u - h, v)) / (2.0 * h);
        let dv = (at(u, v + h) - at(u, v - h)) / (2.0 * h);
        assert!((sample.du - du).norm() < 1e-7 && (sample.dv - dv).norm() < 1e-7, "{patch:?}");
        assert!(sample.du.cross(&sample.dv).dot(&sample.normal) > 0.0, "{patch:?}");
        assert!(surface.bounds(patch).grown(1e-12).contains(&sample.point));
    }
}

#[test]
fn points_near_the_surface_are_inside_or_outside() {
    for data in [perturbed(0.0, 0.0), perturbed(0.1, 0.3), perturbed(0.1, 0.6)] {
        let surface = APatchSurface::new(function(data, HullOptions::default().rule));
        let volume = surface.volume().unwrap();
        for patch in surface.patches() {
            for uv in [[0.2, 0.3], [0.45, 0.1], [0.7, 0.25]] {
                let sample = surface.sample(patch, uv);
                for (step, inside) in [(1e-6, false), (-1e-6, true), (-1e-2, true), (1e-2, false)] {
                    let p = sample.point + step * sample.normal;
                    assert_eq!(volume.is_inside(p), Some(inside), "{step} from {patch:?} at {uv:?}");
                }
                let (value, gradient) = volume.value(sample.point).unwrap();
                assert!(value.abs() < 1e-13);
                assert!((gradient.normalize() - sample.normal).norm() < 1e-9);
            }
        }
        assert_eq!(volume.is_inside(Point3::zeros()), Some(true));
        assert_eq!(volume.is_inside(Point3::new(0.1, 0.2, 9.0)), Some(false));
        assert_eq!(volume.is_inside(Point3::new(0.1, 0.2, -9.0)), Some(false));
        assert_eq!(volume.value(Point3::new(0.1, 0.2, -9.0)), None);
    }
}

/// On the unit sphere inside and outside are known everywhere.
#[test]
fn the_inside_of_a_sphere_is_the_ball() {
    let (_, _, data) = quadrics().swap_remove(0);
    let surface = APatchSurface::new(function(data, HullOptions::default().rule));
    let volume = surface.volume().unwrap();
    for n in 0..3000 {
        let p = 1.3 * noise3(n);
        if (p.norm() - 1.0).abs() > 1e-9 {
            assert_eq!(volume.is_inside(p), Some(p.norm() < 1.0), "{p:?}");
        }
    }
}

#[test]
fn grids_agree_with_single_points() {
    let lattice = crate::bernstein::triangle::lattice(7);
    let over_edge: Vec<[f64; 3]> = (0..=7)
        .flat_map(|i| (0..=5).map(move |j| (i, j)))
        .map(|(i, j)| {
            let x = f64::from(i) / 7.0;
            [x, 1.0 - x, f64::from(j) / 5.0]
        })
        .collect();
    for data in
        [perturbed(0.1, 0.3), perturbed(0.1, 0.6), quadrics().swap_remove(2).2, quadrics().swap_remove(8).2]
    {
        let surface = APatchSurface::new(function(data, HullOptions::default().rule));
        let f = surface.function();
        for patch in surface.patches() {
            let rays = match surface.over(patch) {
                Over::Face(_) => &lattice,
                Over::Edge(_) => &over_edge,
            };
            let (mut points, mut normals) = (Points::zeros(rays.len()), Points::zeros(rays.len()));
            let mut out = grid::GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) };
            match surface.over(patch) {
                Over::Face(face) => grid::FaceTable::new(rays).evaluate(f, face, &mut out),
                Over::Edge(e) => grid::EdgeTable::new(rays).evaluate(f, e, &mut out),
            }
            for (i, ray) in rays.iter().enumerate() {
                let shot = match surface.over(patch) {
                    Over::Face(face) => f.shoot_face(face, *ray),
                    Over::Edge(e) => f.shoot_edge(e, [ray[0], ray[1]], ray[2]),
                }
                .unwrap();
                assert!((points.get(i) - shot.point).norm() < 1e-15, "{patch:?} {ray:?}");
                let normal = shot.gradient.normalize();
                assert!(
                    (normals.get(i) - normal).norm() < 1e-13,
                    "{patch:?} {ray:?} {:?} {normal:?}",
                    normals.get(i)
                );
            }
        }
    }
}
