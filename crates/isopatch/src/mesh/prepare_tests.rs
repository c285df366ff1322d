//! Planted faults, and what becomes of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use super::*;
use crate::geom::Point3;
use proptest::prelude::*;

type Faces = Vec<Vec<u32>>;

/// A unit cube of quadrilaterals with a corner at `at`, normals outward.
fn cube(at: [f64; 3], size: f64) -> (Vec<Point3>, Faces) {
    let corner = |i: u32| {
        Point3::from(at) + size * Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), faces.map(|f| f.to_vec()).into())
}

/// A closed torus of n × m quadrilaterals, normals outward.
fn torus(n: u32, m: u32) -> (Vec<Point3>, Faces) {
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let point = |i, j| {
        let (u, v) = (angle(i, n), angle(j, m));
        let r = 2.0 + v.cos();
        Point3::new(r * u.cos(), r * u.sin(), v.sin())
    };
    let id = |i, j| (i % n) * m + j % m;
    let cells = || (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let faces = cells().map(|(i, j)| vec![id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]).collect();
    (cells().map(|(i, j)| point(i, j)).collect(), faces)
}

/// Triangles of a sphere: a subdivided octahedron, normals outward.
fn sphere(rounds: usize) -> (Vec<Point3>, Faces) {
    let mut p: Vec<Point3> = (0..3).flat_map(|i| [Point3::ith(i, 1.0), Point3::ith(i, -1.0)]).collect();
    let mut faces: Faces =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
            .map(|f| f.to_vec())
            .into();
    for _ in 0..rounds {
        let mut middle = std::collections::HashMap::new();
        let mut split = Faces::new();
        for f in &faces {
            let m: [u32; 3] = std::array::from_fn(|k| {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    p.push((p[a as usize] + p[b as usize]).normalize());
                    p.len() as u32 - 1
                })
            });
            split.extend([
                vec![f[0], m[0], m[2]],
                vec![m[0], f[1], m[1]],
                vec![m[2], m[1], f[2]],
                m.to_vec(),
            ]);
        }
        faces = split;
    }
    (p, faces)
}

fn joined(parts: &[(Vec<Point3>, Faces)]) -> (Vec<Point3>, Faces) {
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    for (p, f) in parts {
        let shift = positions.len() as u32;
        positions.extend_from_slice(p);
        faces.extend(f.iter().map(|face| face.iter().map(|v| v + shift).collect::<Vec<_>>()));
    }
    (positions, faces)
}

fn reversed(face: &[u32]) -> Vec<u32> {
    let mut face = face.to_vec();
    face[1..].reverse();
    face
}

fn prepared((positions, faces): &(Vec<Point3>, Faces)) -> Prepared {
    let found = prepare(positions, faces, &PrepareOptions::default()).unwrap();
    assert!(found.summary.is_oriented_manifold(), "{}", found.summary);
    assert_eq!(
        found.summary.euler,
        HalfEdgeMesh::from_faces(found.positions.len(), &found.faces).unwrap().euler_number()
    );
    found
}

fn volume(mesh: &Prepared) -> f64 {
    mesh.summary.components.iter().map(|c| c.volume.unwrap()).sum()
}

fn places(mesh: &Prepared, kind: RepairKind) -> Vec<Place> {
    mesh.repairs.iter().filter(|r| r.kind == kind).flat_map(|r| r.places.clone()).collect()
}

fn kinds(mesh: &Prepared) -> Vec<RepairKind> {
    mesh.repairs.iter().map(|r| r.kind).collect()
}

#[test]
fn clean_meshes_pass_unchanged() {
    for mesh in [cube([0.0; 3], 1.0), torus(7, 5), sphere(2)] {
        let found = prepared(&mesh);
        assert_eq!((&found.positions, &found.faces, found.repairs.len()), (&mesh.0, &mesh.1, 0));
        assert!(found.summary.is_closed() && volume(&found) > 0.0);
    }
}

#[test]
fn a_soup_of_a_cube_becomes_a_cube() {
    let (p, faces) = cube([3.0, -1.0, 0.5], 2.0);
    let soup: Vec<Point3> = faces.iter().flatten().map(|v| p[*v as usize]).collect();
    let apart: Faces = (0..6).map(|f| (4 * f..4 * f + 4).collect()).collect();
    let found = prepared(&(soup, apart));
    assert_eq!((found.positions.len(), found.summary.euler, volume(&found)), (8, 2, 8.0));
    assert_eq!(places(&found, RepairKind::WeldedVertex).len(), 16);
    assert_eq!(kinds(&found), [RepairKind::WeldedVertex]);
}

#[test]
fn vertices_within_the_tolerance_are_welded() {
    let (p, faces) = cube([0.0; 3], 1.0);
    let noise = |i: usize| 1e-7 * Point3::new((i % 3) as f64, (i % 5) as f64 - 2.0, (i % 2) as f64);
    let soup: Vec<Point3> =
        faces.iter().flatten().enumerate().map(|(i, v)| p[*v as usize] + noise(i)).collect();
    let apart: Faces = (0..6).map(|f| (4 * f..4 * f + 4).collect()).collect();
    let weld = |tolerance| prepare(&soup, &apart, &PrepareOptions { weld_tolerance: tolerance });
    assert_eq!(weld(1e-6).unwrap().summary.euler, 2);
    assert_eq!(weld(0.0).unwrap().summary.components.len(), 6);
    for tolerance in [-1.0, f64::NAN, 2.0] {
        assert!(matches!(weld(tolerance), Err(MeshFault::Tolerance { .. })));
    }
}

#[test]
fn closed_bodies_that_touch_stay_apart() {
    let mesh = joined(&[cube([0.0; 3], 1.0), cube([1.0; 3], 1.0)]);
    let found = prepared(&mesh);
    assert_eq!((found.faces, found.repairs), (mesh.1, vec![]));
    assert_eq!(found.summary.coincident, [[8, 7]]);
}

#[test]
fn bodies_that_share_a_vertex_or_an_edge_are_taken_apart() {
    // Two cubes that name one vertex, or the two ends of one edge, by the same numbers.
    for (at, shared, kind) in [
        ([1.0, 1.0, 1.0], vec![(8, 7)], vec![RepairKind::SplitVertex]),
        ([1.0, 1.0, 0.0], vec![(8, 3), (12, 7)], vec![RepairKind::CutEdge, RepairKind::SplitVertex]),
    ] {
        let (p, mut faces) = joined(&[cube([0.0; 3], 1.0), cube(at, 1.0)]);
        for v in faces.iter_mut().flatten() {
            *v = shared.iter().find(|s| s.0 == *v).map_or(*v, |s| s.1);
        }
        let found = prepared(&(p, faces));
        assert_eq!((found.summary.components.len(), found.summary.euler, volume(&found)), (2, 4, 2.0));
        assert!(kind.iter().all(|k| kinds(&found).contains(k)), "{:?}", found.repairs);
    }
}

/// A ring of cubes around an edge: one sheet meets itself there, so only the order of the faces around it helps.
#[test]
fn a_body_that_touches_itself_along_an_edge_is_taken_apart_there() {
    // An L of three cubes in the plane z = 0 and one above its ends: cells of a 2 × 2 × 2 block.
    let cells = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 1, 0]];
    let (found, _) = voxels(&cells);
    let found = prepared(&found);
    assert!(found.summary.is_closed());
    assert_eq!(volume(&found), cells.len() as f64);
}

/// The surface of unit cells, with one vertex a lattice point.
fn voxels(cells: &[[i32; 3]]) -> ((Vec<Point3>, Faces), usize) {
    let (_, faces) = cube([0.0; 3], 1.0);
    let mut number = std::collections::HashMap::new();
    let (mut positions, mut outer) = (Vec::new(), Faces::new());
    let steps = [[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]];
    for cell in cells {
        for (face, step) in faces.iter().zip(steps) {
            if cells.contains(&std::array::from_fn(|i| cell[i] + step[i])) {
                continue;
            }
            let corner = |i: &u32| -> u32 {
                let at: [i32; 3] = std::array::from_fn(|k| cell[k] + (i >> k & 1) as i32);
                *number.entry(at).or_insert_with(|| {
                    positions.push(Point3::from(at.map(f64::from)));
                    positions.len() as u32 - 1
                })
            };
            outer.push(face.iter().map(corner).collect());
        }
    }
    ((positions, outer), cells.len())
}

#[test]
fn a_fin_is_taken_off() {
    let (mut p, mut faces) = cube([0.0; 3], 1.0);
    p.push(Point3::new(2.0, 2.0, 0.5));
    faces.push(vec![3, 7, 8]);
    let found = prepared(&(p, faces));
    assert_eq!(places(&found, RepairKind::CutEdge), [Place::Edge(3, 7)]);
    assert_eq!(places(&found, RepairKind::SplitVertex), [Place::Vertex(3), Place::Vertex(7)]);
    let closed: Vec<bool> = found.summary.components.iter().map(|c| c.is_closed).collect();
    assert_eq!(closed, [true, false]);
    assert_eq!(found.summary.components[0].volume, Some(1.0));
}

#[test]
fn a_wall_inside_a_body_leaves_three_open_sheets() {
    let ((p, mut faces), _) = voxels(&[[0, 0, 0], [1, 0, 0]]);
    let at = |y, z| p.iter().position(|q| *q == Point3::new(1.0, y, z)).unwrap() as u32;
    faces.push(vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]);
    let mesh = (p, faces);
    assert_eq!(check(&mesh.0, &mesh.1).non_manifold_edges.len(), 4);
    let found = prepared(&mesh);
    assert_eq!((found.summary.components.len(), found.summary.holes.len()), (3, 3));
}

/// Every cell with all of its faces, over shared vertices, as welding makes of an STL file with bodies that touch.
#[test]
fn bodies_that_share_a_wall_are_taken_apart() {
    for cells in [vec![[0, 0, 0], [1, 0, 0]], vec![[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]] {
        let bodies: Vec<_> = cells.iter().map(|c| cube(c.map(f64::from), 1.0)).collect();
        let (p, faces) = joined(&bodies);
        let soup: Vec<Point3> = faces.iter().flatten().map(|v| p[*v as usize]).collect();
        // Triangles, so that walls have an inner edge.
        let halves = |f: u32| [vec![4 * f, 4 * f + 1, 4 * f + 2], vec![4 * f, 4 * f + 2, 4 * f + 3]];
        let found = prepared(&(soup, (0..faces.len() as u32).flat_map(halves).collect()));
        assert!(found.summary.components.iter().all(|c| c.volume == Some(1.0)), "{}", found.summary);
        assert_eq!(found.summary.components.len(), cells.len());
        assert_eq!(places(&found, RepairKind::DuplicateFace), []);
    }
}

#[test]
fn two_sided_sheets_and_doubled_bodies_become_single() {
    let (p, faces) = cube([0.0; 3], 1.0);
    let doubled = |faces: &[Vec<u32>]| -> Faces {
        faces.iter().cloned().chain(faces.iter().map(|f| reversed(f))).collect()
    };
    for kept in [6, 4] {
        let found = prepared(&(p.clone(), doubled(&faces[..kept])));
        assert_eq!((found.faces.len(), places(&found, RepairKind::DuplicateFace).len()), (kept, kept));
    }
}

#[test]
fn inside_out_bodies_are_turned_and_voids_are_not() {
    let inward = |(p, faces): (Vec<Point3>, Faces)| (p, faces.iter().map(|f| reversed(f)).collect::<Faces>());
    let outer = || cube([-2.0; 3], 4.0);
    let inner = || cube([-1.0; 3], 2.0);
    let found = prepared(&inward(outer()));
    assert_eq!((volume(&found), kinds(&found)), (64.0, vec![RepairKind::TurnedComponent]));
    // A body with a void, as it should be, and wholly inside out.
    let right = joined(&[outer(), inward(inner())]);
    let found = prepared(&right);
    assert_eq!((volume(&found), found.repairs.len()), (56.0, 0));
    // Inside out altogether: the inner one is outward, which is let be.
    let found = prepared(&joined(&[inward(outer()), inward(inner()), inward(cube([-0.5; 3], 1.0))]));
    assert_eq!(volume(&found), 64.0 - 8.0 + 1.0);
    assert_eq!(places(&found, RepairKind::TurnedComponent), [Place::Face(0), Place::Face(12)]);
    // One flipped face in the void: it is oriented by where it lies.
    let mut mixed = right;
    mixed.1[7] = reversed(&mixed.1[7]);
    let found = prepared(&mixed);
    assert_eq!((volume(&found), places(&found, RepairKind::FlippedFace)), (56.0, vec![Place::Face(7)]));
}

#[test]
fn degenerate_faces_are_dropped_or_reduced() {
    let (mut p, mut faces) = cube([0.0; 3], 1.0);
    p.push(Point3::new(9.0, 9.0, 9.0));
    faces[0] = vec![0, 2, 2, 3, 1, 0];
    faces.extend([vec![0, 1, 0], vec![5], vec![], vec![4, 5, 4, 5], vec![1, 5, 7, 3]]);
    let found = prepared(&(p, faces));
    assert_eq!((found.faces.len(), volume(&found)), (6, 1.0));
    let reduced = [0, 6, 7, 8, 9].map(Place::Face);
    assert_eq!(places(&found, RepairKind::RepeatedCorner), reduced);
    assert_eq!(places(&found, RepairKind::DuplicateFace), [Place::FaceLike(10, 5)]);
    assert_eq!(places(&found, RepairKind::UnusedVertex), [Place::Vertex(8)]);
}

#[test]
fn a_figure_eight_becomes_its_two_loops() {
    let p: Vec<Point3> =
        [(0., 0.), (1., 1.), (1., -1.), (-1., 1.), (-1., -1.)].map(|(x, y)| Point3::new(x, y, 0.0)).into();
    let found = prepared(&(p, vec![vec![1, 0, 2, 4, 0, 3]]));
    assert_eq!(found.face_source, [0, 0]);
    assert_eq!(found.summary.holes.len(), 2);
}

#[test]
fn a_flat_face_is_closed_into_its_neighbour() {
    // A tetrahedron with a vertex 4 on edge 0–1 that face 0 1 2 knows of and face 0 1 3 does not.
    let mut p: Vec<Point3> = vec![Point3::zeros(), Point3::x(), Point3::y(), Point3::z()];
    p.push(0.5 * Point3::x());
    let faces: Faces =
        vec![vec![0, 2, 4], vec![4, 2, 1], vec![1, 2, 3], vec![2, 0, 3], vec![0, 1, 3], vec![0, 4, 1]];
    let found = prepared(&(p.clone(), faces.clone()));
    assert_eq!(places(&found, RepairKind::FlatFaceStitched), [Place::Face(5)]);
    assert!(found.summary.is_closed() && found.summary.flat.is_empty());
    assert!((volume(&found) - 1.0 / 6.0).abs() < 1e-15);
    // The same without that face is a T-junction: a hole that is reported and stays.
    let open = prepared(&(p, faces[..5].to_vec()));
    assert_eq!(open.summary.holes.len(), 1);
    assert_eq!(open.summary.holes[0].length, 2.0);
}

#[test]
fn a_moebius_band_is_cut_open() {
    let n = 9u32;
    let point = |i: u32, s: f64| {
        let u = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let r = 1.0 + s * (u / 2.0).cos();
        Point3::new(r * u.cos(), r * u.sin(), s * (u / 2.0).sin())
    };
    let p = (0..n).flat_map(|i| [point(i, -0.3), point(i, 0.3)]).collect();
    let quad = |i: u32| match i + 1 == n {
        true => vec![2 * i, 1, 0, 2 * i + 1],
        false => vec![2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1],
    };
    let found = prepared(&(p, (0..n).map(quad).collect()));
    assert_eq!(places(&found, RepairKind::TornEdge).len(), 1);
    assert_eq!((found.summary.euler, found.summary.holes.len()), (1, 1));
}

#[test]
fn holes_have_a_length() {
    let (p, faces) = cube([0.0; 3], 2.0);
    let found = prepared(&(p, faces[1..].to_vec()));
    assert_eq!(found.repairs, []);
    let [hole] = &found.summary.holes[..] else { panic!("{}", found.summary) };
    assert_eq!((hole.length, hole.vertices.len()), (8.0, 4));
}

#[test]
fn faults_are_named() {
    let (p, faces) = cube([0.0; 3], 1.0);
    let fault =
        |p: &[Point3], faces: &Faces| prepare(p, faces, &PrepareOptions::default()).unwrap_err().to_string();
    let mut bad = p.clone();
    bad[2].y = f64::NAN;
    assert_eq!(fault(&bad, &faces), "vertex 2 of face 0 has a coordinate that is not a finite number");
    assert_eq!(check(&bad, &faces).not_finite, [2]);
    let far: Faces = vec![vec![0, 1, 8]];
    assert_eq!(fault(&p, &far), "face 0 names vertex 8, but there are only 8 vertices");
    assert_eq!(check(&p, &far).no_such_vertex, [[0, 8]]);
    assert_eq!(fault(&p, &vec![]), "the mesh has no face with an area");
    assert_eq!(fault(&[Point3::zeros(); 3], &vec![vec![0, 1, 2]]), "the mesh has no face with an area");
}

#[test]
fn sizes_from_tiny_to_huge() {
    let (p, faces) = sphere(1);
    for scale in [1e-300, 1e-12, 1e12, 1.5e308] {
        let mut faces = faces.clone();
        faces[3] = reversed(&faces[3]);
        let found =
            prepare(&p.iter().map(|p| p * scale).collect::<Vec<_>>(), &faces, &PrepareOptions::default())
                .unwrap();
        assert_eq!(places(&found, RepairKind::FlippedFace), [Place::Face(3)], "{scale}");
        assert_eq!(kinds(&found), [RepairKind::FlippedFace]);
    }
}

/// Reads as a sentence in a report.
#[test]
fn repairs_have_words() {
    let (p, mut faces) = cube([0.0; 3], 1.0);
    faces[1] = reversed(&faces[1]);
    let found = prepared(&(p, faces));
    assert_eq!(
        found.repairs[0].to_string(),
        "faces turned over: 1 (they are oriented against their neighbours): face 1"
    );
    assert_eq!(found.summary.to_string(), "8 vertices, 6 faces, 1 components (1 closed), Euler number 2");
}

prop_compose! {
    /// Faces without rhyme or reason among few vertices, some at one place, with indices that may be wrong.
    fn any_faces()(count in 1u32..12)(
        positions in prop::collection::vec(prop::array::uniform3(prop::sample::select(vec![-1.0, 0.0, -0.0, 0.5, 1.0, 1e-9, 2.0])), count as usize),
        faces in prop::collection::vec(prop::collection::vec(0..count, 0..6), 0..40),
        wrong in prop::option::weighted(0.05, any::<u32>()),
        tolerance in prop::sample::select(vec![0.0, 1e-17, 1e-6, 0.3, 1.0]),
        scale in prop::sample::select(vec![1.0, 1e-300, 8e307]),
    ) -> (Vec<Point3>, Faces, PrepareOptions) {
        let mut faces: Faces = faces;
        faces.extend(wrong.map(|v| vec![0, 0, v]));
        (positions.into_iter().map(|p| scale * Point3::from(p)).collect(), faces, PrepareOptions { weld_tolerance: tolerance })
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_flips_come_back(flips in prop::collection::vec(any::<bool>(), 70), start in 0usize..4) {
        let (p, faces) = torus(10, 7);
        let mixed: Faces = faces.iter().zip(&flips).map(|(f, flip)| {
            let mut face = if *flip { reversed(f) } else { f.clone() };
            face.rotate_left(start);
            face
        }).collect();
        let found = prepared(&(p, mixed));
        prop_assert!(volume(&found) > 0.0);
        for (f, face) in found.faces.iter().enumerate() {
            let i = face.iter().position(|v| *v == faces[f][0]).unwrap();
            let mut face = face.clone();
            face.rotate_left(i);
            prop_assert_eq!(&face, &faces[f]);
        }
    }

    #[test]
    fn a_shuffled_soup_of_a_sphere_welds(order in Just((0..128usize).collect::<Vec<_>>()).prop_shuffle(), flips in any::<u128>()) {
        let (p, faces) = sphere(2);
        let mut soup = (Vec::new(), Faces::new());
        for (i, f) in order.iter().enumerate() {
            let n = soup.0.len() as u32;
            soup.0.extend(faces[*f].iter().map(|v| p[*v as usize]));
            let face = [n, n + 1, n + 2];
            soup.1.push(if flips >> i & 1 == 1 { reversed(&face) } else { face.to_vec() });
        }
        let found = prepared(&soup);
        prop_assert_eq!((found.summary.euler, found.summary.components.len(), found.positions.len()), (2, 1, p.len()));
        prop_assert!(found.summary.is_closed() && volume(&found) > 3.0);
    }

    /// Whatever comes in, what goes out is a manifold, the same each time, and clean enough to pass unchanged.
    #[test]
    fn any_faces_are_repaired_or_refused((positions, faces, options) in any_faces()) {
        check(&positions, &faces);
        if let Ok(found) = prepare(&positions, &faces, &options) {
            prop_assert!(found.summary.is_oriented_manifold(), "{}", found.summary);
            HalfEdgeMesh::from_faces(found.positions.len(), &found.faces).unwrap();
            for (p, source) in found.positions.iter().zip(&found.vertex_source) {
                prop_assert_eq!(p, &positions[*source as usize]);
            }
            prop_assert_eq!(prepare(&positions, &faces, &options).unwrap(), found);
        }
    }
}

/// Found by the test above: stitching a flat face made a triangle that was there already.
#[test]
fn parts_of_a_stitched_face_that_are_there_already_are_dropped() {
    let p =
        [[-1.0, -1.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.5, 0.0, 0.0]].map(Point3::from).to_vec();
    let found = prepared(&(p, vec![vec![0, 2, 3], vec![1, 0, 2], vec![1, 2, 3]]));
    assert_eq!(places(&found, RepairKind::FlatFaceStitched), [Place::Face(2)]);
    assert_eq!(places(&found, RepairKind::DuplicateFace), [Place::FaceLike(1, 0)]);
    assert_eq!(found.faces.len(), 2);
}
