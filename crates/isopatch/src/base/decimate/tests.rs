use super::*;
use crate::geom::Aabb;
use crate::mesh::HalfEdgeMesh;

/// A torus of 2 · 120 · 90 triangles, with radii 3 and 1, and its normals.
fn torus() -> (TriangleMesh, Vec<Vec3>) {
    let [around, across] = [120, 90];
    let angle = |i: usize, n: usize| i as f64 / n as f64 * std::f64::consts::TAU;
    let mut mesh = TriangleMesh::default();
    let mut normals = Vec::new();
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let (s, t) = (angle(i, around), angle(j, across));
        let outward = Vec3::new(s.cos(), s.sin(), 0.0);
        normals.push(t.cos() * outward + t.sin() * Vec3::z());
        mesh.positions.push(3.0 * outward + normals[normals.len() - 1]);
        let at = |i: usize, j: usize| (i % around * across + j % across) as u32;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.faces.extend([[a, b, c], [a, c, d]]);
    }
    (mesh, normals)
}

/// A part of the graph of cos x cos y, of 2 · 100² triangles, cut by a box.
fn graph() -> (TriangleMesh, Vec<Vec3>) {
    let n = 100;
    let bounds = Aabb::new(Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, 1.0, 2.0));
    let mut mesh = TriangleMesh::default();
    let mut normals = Vec::new();
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let [x, y] = [i, j].map(|k| 2.0 * k as f64 / n as f64 - 1.0);
        mesh.positions.push(Vec3::new(x, y, x.cos() * y.cos()));
        normals.push(Vec3::new(x.sin() * y.cos(), x.cos() * y.sin(), 1.0).normalize());
        if i < n && j < n {
            let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    let sides = mesh.positions.iter().map(|p| BoxSides::of(p, &bounds)).collect();
    mesh.clip = Some(Clip { bounds, sides });
    (mesh, normals)
}

fn draft_of((mesh, normals): &(TriangleMesh, Vec<Vec3>)) -> Draft {
    Draft::new(vertices(mesh, normals, &Vec3::zeros()), mesh.faces.clone())
}

/// The root of the mean square distance of the middles of faces from the torus.
fn error(positions: &[Point3], faces: impl ExactSizeIterator<Item = [u32; 3]>) -> f64 {
    let count = faces.len() as f64;
    let middle = |face: [u32; 3]| face.iter().map(|v| positions[*v as usize]).sum::<Vec3>() / 3.0;
    let squares = faces.map(middle).map(|p| ((p.xy().norm() - 3.0).hypot(p.z) - 1.0).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    for (mesh, normals) in [torus(), graph()] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| decimate(&mesh, &normals, 1500)).unwrap()
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(4));
    }
}

#[test]
fn counts_are_exact_and_the_topology_is_kept() {
    let (mesh, normals) = torus();
    // Through short edges, through one pass and two, in one piece, and not at all.
    for faces in [300, 2000, 9000, 19_000, 21_000, 21_600] {
        let coarse = decimate(&mesh, &normals, faces).unwrap();
        let half_edges = HalfEdgeMesh::from_faces(coarse.positions.len(), &coarse.faces).unwrap();
        assert_eq!((coarse.faces.len(), half_edges.euler_number()), (faces, 0));
        assert!(half_edges.is_closed());
    }
    let error = decimate(&mesh, &normals, 8).unwrap_err();
    assert!(matches!(error, BaseError::TooFewFaces { asked: 8, least } if least < 100), "{error}");
}

#[test]
fn the_border_stays_in_the_sides_of_the_box() {
    let (mesh, normals) = graph();
    for faces in [400, 6000] {
        let coarse = decimate(&mesh, &normals, faces).unwrap();
        assert!((faces - 1..=faces).contains(&coarse.faces.len()));
        let half_edges = HalfEdgeMesh::from_faces(coarse.positions.len(), &coarse.faces).unwrap();
        assert_eq!((half_edges.euler_number(), half_edges.boundary_loop_count()), (1, 1));
        let clip = coarse.clip.unwrap();
        assert_eq!(clip.sides.iter().filter(|s| s.len() == 2).count(), 4);
        for (p, sides) in coarse.positions.iter().zip(&clip.sides) {
            assert_eq!(BoxSides::of(p, &clip.bounds), *sides);
        }
    }
}

#[test]
fn blocks_are_hardly_worse_than_the_order_of_all_errors() {
    let surface = torus();
    let faces = 4000;
    let coarse = decimate(&surface.0, &surface.1, faces).unwrap();
    let Draft { mut vertices, faces: all, .. } = draft_of(&surface);
    let mesh = Connectivity::from_faces(vertices.len(), &all).unwrap();
    let greedy = finish(mesh, &mut vertices, faces).unwrap();
    let positions: Vec<Point3> = vertices.iter().map(|v| v.position).collect();
    let greedy: Vec<[u32; 3]> = greedy.faces().collect();
    let ratio = error(&coarse.positions, coarse.faces.into_iter()) / error(&positions, greedy.into_iter());
    assert!(ratio < 1.05, "{ratio}");
}

#[test]
fn blocks_do_not_touch_each_other() {
    for (surface, euler) in [(torus(), 0), (graph(), 1)] {
        let mut draft = draft_of(&surface);
        let (mut before, mut between) = (Vec::new(), 0);
        draft.pass(|blocks, seams| {
            assert!(blocks.len() > 4);
            between = seams;
            for block in blocks {
                before.extend(block.vertices.iter().map(|vertex| vertex.position));
                block.fill(usize::MAX);
                block.run(0, u64::MAX);
            }
        });
        assert!(between > 0 && draft.faces.len() < surface.0.faces.len() / 2);
        let seams = &draft.faces[draft.faces.len() - between..];
        assert!(seams.iter().flatten().all(|v| draft.vertices[*v as usize].position == before[*v as usize]));
        let mut mesh = Connectivity::from_faces(before.len(), &draft.faces).unwrap();
        let vertices = mesh.compact().len();
        let faces: Vec<[u32; 3]> = mesh.faces().collect();
        assert_eq!(HalfEdgeMesh::from_faces(vertices, &faces).unwrap().euler_number(), euler);
    }
}
