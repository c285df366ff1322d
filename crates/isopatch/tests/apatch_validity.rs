//! A-patch surfaces are valid: one root a ray, nothing turned over, no cracks, smooth everywhere but on creases.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod support;

use isopatch::apatch::{self, APatchOptions, APatchSurface, Over};
use isopatch::geom::{Point3, Vec3, angle_between};
use isopatch::hull::{self, Class, HermiteMesh, HullOptions, Side};
use isopatch::io::read::read_mesh;
use isopatch::mesh::normals::{NormalRule, at_corners, of_face};
use isopatch::mesh::{HalfEdgeId, HalfEdgeMesh, PrepareOptions, VertexId, creases, prepare};
use isopatch::surface::{Continuity, Domain, PatchId, SeamSide, Surface};
use isopatch::tessellate::{APatchResolution, Tessellation, tessellate_a_patches};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// The surface of a mesh with creases where faces meet at more than `angle` degrees.
fn surface(positions: Vec<Point3>, faces: &[[u32; 3]], angle: f64) -> APatchSurface {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces).unwrap();
    let sharp = creases::by_angle(&mesh, &positions, angle.to_radians());
    let gradients = at_corners(&mesh, &positions, &sharp, NormalRule::LoopLimit);
    let data = HermiteMesh::with_creases(mesh, positions, gradients, sharp).unwrap();
    let hull = hull::build(data, &HullOptions::default());
    assert!(hull.problems().is_empty(), "{:?}", hull.problems());
    APatchSurface::new(apatch::build(hull, &APatchOptions::default()))
}

/// Points of a patch on a grid, with its small triangles.
fn grid(surface: &APatchSurface, patch: PatchId, n: usize) -> (Vec<[f64; 2]>, Vec<[usize; 3]>) {
    let at = |i: usize| i as f64 / n as f64;
    let mut triangles = Vec::new();
    if surface.domain(patch) == Domain::Triangle {
        let row = |i: usize| i * (2 * n + 3 - i) / 2;
        let points = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [at(i), at(j)])).collect();
        for i in 0..n {
            for j in 0..n - i {
                triangles.push([row(i + 1) + j, row(i) + j + 1, row(i) + j]);
                if i + j + 2 <= n {
                    triangles.push([row(i + 1) + j, row(i + 1) + j + 1, row(i) + j + 1]);
                }
            }
        }
        return (points, triangles);
    }
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| [at(i), at(j)])).collect();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let number = |i: usize, j: usize| i * (n + 1) + j;
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    (points, triangles)
}

/// The layers have the signs (−, +, +, + or 0) on every ray, so that there is one root and it is simple.
fn assert_one_root(surface: &APatchSurface, patch: PatchId, [u, v]: [f64; 2]) {
    let function = surface.function();
    let check = |[b0, b1, b2, b3]: [f64; 4]| {
        let signs = b1 > 0.0 && b2 > 0.0 && b3 >= 0.0;
        assert!(signs, "{:?} at {u} {v}: {b0} {b1} {b2} {b3}", surface.over(patch));
    };
    match surface.over(patch) {
        Over::Face(f) => {
            if let Some((_, layers)) = function.face_layers(f, [u, v, (1.0 - u - v).max(0.0)]) {
                check(layers);
            }
        }
        Over::Edge(e) => {
            let cells = Side::BOTH.into_iter().filter_map(|side| function.edge_function(e, side));
            cells.for_each(|cell| check(cell.layers(1.0 - u, u, v)));
        }
    }
}

/// Patches on an n × n grid: points everywhere, one root a ray, no triangle that faces away from the normals at its corners.
fn assert_patches(name: &str, surface: &APatchSurface, n: usize) {
    let least = 1e-13 * surface.function().hull().data().diagonal();
    let patches: Vec<PatchId> = surface.patches().collect();
    patches.into_par_iter().for_each(|patch| {
        let (points, triangles) = grid(surface, patch, n);
        points.iter().for_each(|uv| assert_one_root(surface, patch, *uv));
        let samples: Vec<_> = points.iter().map(|uv| surface.sample(patch, *uv)).collect();
        let over = surface.over(patch);
        for s in &samples {
            assert!(s.point.iter().chain(s.normal.iter()).all(|c| c.is_finite()), "{name}: {over:?}");
        }
        for t in triangles {
            let [a, b, c] = t.map(|i| samples[i].point);
            let area = (b - a).cross(&(c - a));
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            if area.norm() > least * longest {
                let normal: Vec3 = t.iter().map(|i| samples[*i].normal).sum();
                assert!(area.dot(&normal) > 0.0, "{name}: {over:?} turns over at {:?}", points[t[0]]);
            }
        }
    });
}

/// The side of a seam at the parameter s along it, in the parameters of its patch.
fn on_seam(surface: &APatchSurface, side: &SeamSide, s: f64) -> [f64; 2] {
    let (a, b) = if side.reversed { (1.0 - s, s) } else { (s, 1.0 - s) };
    surface.domain(side.patch).on_edge(side.edge, [b, a])
}

/// Both sides of a seam are the same bits; across smooth ones the normals agree.
fn assert_seams(name: &str, surface: &APatchSurface) {
    let mut creases = 0;
    for seam in surface.seams() {
        let Some(second) = seam.second else { continue };
        creases += usize::from(seam.continuity == Continuity::G0);
        for i in 0..=8 {
            let s = f64::from(i) / 8.0;
            let [a, b] =
                [seam.first, second].map(|side| surface.sample(side.patch, on_seam(surface, &side, s)));
            assert_eq!(a.point, b.point, "{name}: {seam:?} at {s}");
            let angle = angle_between(&a.normal, &b.normal);
            assert!(
                seam.continuity == Continuity::G0 || angle <= NORMAL_LIMIT,
                "{name}: {angle:e} at {s} of {seam:?}"
            );
        }
    }
    let counts = surface.crease_counts();
    assert_eq!(counts.straight + counts.curved, creases, "{name}");
}

/// What normals may be off by rounding, in radians: the cells of steep meshes are thin.
const NORMAL_LIMIT: f64 = 1e-10;

/// At the corners of patches the normals are those of the gradients, and they are the limits.
fn assert_vertices(name: &str, surface: &APatchSurface, step: f64, angle: f64) {
    let data = surface.function().hull().data();
    for f in data.mesh().faces() {
        for (k, h) in data.mesh().face_half_edges(f).enumerate() {
            let mut x = [0.0; 3];
            x[k] = 1.0;
            let at = |x: [f64; 3]| surface.sample(PatchId(f.0), [x[0], x[1]]);
            let (corner, normal) = (at(x), data.gradient(h).normalize());
            assert_eq!(corner.point, data.positions()[data.mesh().origin(h).index()], "{name}");
            let off = angle_between(&corner.normal, &normal);
            assert!(off < NORMAL_LIMIT, "{name}: {off:e} at corner {k} of face {}", f.0);
            (x[k], x[(k + 1) % 3], x[(k + 2) % 3]) = (1.0 - step, 0.4 * step, 0.6 * step);
            let turned = angle_between(&at(x).normal, &normal);
            assert!(turned < angle, "{name}: {turned} near corner {k} of face {}", f.0);
        }
    }
}

/// As many holes, components and boundaries as the mesh, by the numbers of the vertices.
fn assert_tessellation(name: &str, surface: &APatchSurface) -> Tessellation {
    let mesh = tessellate_a_patches(surface, APatchResolution { along: 4, across: 2 }).unwrap();
    let mut uses: HashMap<(u32, u32), usize> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        [(*a, *b), (*b, *c), (*c, *a)].into_iter().for_each(|edge| *uses.entry(edge).or_default() += 1);
    }
    assert!(uses.values().all(|n| *n == 1), "{name}");
    let border = uses.keys().filter(|(a, b)| !uses.contains_key(&(*b, *a))).count();
    let base = surface.function().hull().data().mesh();
    let open = base.half_edges().filter(|h| base.twin(*h).is_none()).count();
    assert_eq!(border, 4 * open, "{name}");
    let edges = (uses.len() + border) / 2;
    let euler = mesh.positions.len() as i64 - edges as i64 + mesh.triangles.len() as i64;
    assert_eq!(euler, base.euler_number(), "{name}");
    mesh
}

/// Every triangle faces the way of the normals at its corners, those on its own side of a crease.
fn assert_normals(name: &str, mesh: &Tessellation) {
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        let normal: Vec3 = mesh.normal_numbers(t).iter().map(|n| mesh.normals[*n as usize]).sum();
        assert!((b - a).cross(&(c - a)).dot(&normal) > -1e-13, "{name}: triangle {t}");
    }
}

fn assert_valid(name: &str, surface: &APatchSurface, n: usize) -> Tessellation {
    assert_patches(name, surface, n);
    assert_seams(name, surface);
    assert_tessellation(name, surface)
}

fn assert_no_cuts(surface: &APatchSurface) {
    let hull = surface.function().hull();
    assert!(hull.corners().is_empty() && hull.added_creases().is_empty());
}

/// Quads as pairs of triangles.
fn halved(quads: impl IntoIterator<Item = [u32; 4]>) -> Vec<[u32; 3]> {
    quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn around(i: u32, n: u32, radius: f64, z: f64) -> Point3 {
    let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
    Point3::new(radius * cos, radius * sin, z)
}

#[test]
fn a_cube_stays_a_cube() {
    let p = (0..8u32).map(|n| Point3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2)));
    let faces = halved([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]);
    let cube = surface(p.collect(), &faces, 40.0);
    assert_no_cuts(&cube);
    let counts = cube.crease_counts();
    assert_eq!((counts.straight, counts.curved), (12, 0));
    let mesh = assert_valid("cube", &cube, 20);
    assert_normals("cube", &mesh);
    assert_vertices("cube", &cube, 1e-3, 1e-12);
    assert!(mesh.positions.iter().all(|p| p.iter().any(|c| *c == 0.0 || *c == 1.0)));
    assert!((mesh.signed_volume() - 1.0).abs() < 1e-14);
    // Eight vertices have three normals, 12 creases with 3 points each have two.
    assert_eq!(mesh.normals.len(), mesh.positions.len() + 2 * 8 + 12 * 3);
    let split = mesh.with_split_creases();
    assert_eq!((split.positions.len(), split.normals.len()), (mesh.normals.len(), mesh.normals.len()));
    for (t, triangle) in split.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| split.positions[v as usize]);
        let normal = (b - a).cross(&(c - a)).normalize();
        assert!(triangle.iter().all(|v| (split.normals[*v as usize] - normal).norm() < 1e-12));
        assert_eq!([a, b, c], mesh.triangles[t].map(|v| mesh.positions[v as usize]));
    }
}

#[test]
fn a_cylinder_has_flat_ends_and_a_smooth_side() {
    const N: u32 = 16;
    let mut p: Vec<Point3> =
        (0..4).flat_map(|j| (0..N).map(move |i| around(i, N, 1.0, f64::from(j) * 0.5))).collect();
    p.extend([Point3::zeros(), Point3::new(0.0, 0.0, 1.5)]);
    let quads = (0..3).flat_map(|j| {
        (0..N).map(move |i| [j * N + i, j * N + (i + 1) % N, (j + 1) * N + (i + 1) % N, (j + 1) * N + i])
    });
    let mut faces = halved(quads);
    faces.extend((0..N).map(|i| [4 * N, (i + 1) % N, i]));
    faces.extend((0..N).map(|i| [4 * N + 1, 3 * N + i, 3 * N + (i + 1) % N]));
    let cylinder = surface(p, &faces, 40.0);
    assert_no_cuts(&cylinder);
    let counts = cylinder.crease_counts();
    assert_eq!((counts.straight, counts.curved), (0, 2 * N as usize));
    let mesh = assert_valid("cylinder", &cylinder, 20);
    assert_normals("cylinder", &mesh);
    assert_vertices("cylinder", &cylinder, 1e-5, 0.01);
    for (triangle, patch) in mesh.triangles.iter().zip(&mesh.patches) {
        for p in triangle.map(|v| mesh.positions[v as usize]) {
            let on_side = (p.x.hypot(p.y) - 1.0).abs();
            match patch.0 {
                f if (6 * N..7 * N).contains(&f) => assert!(p.z.abs() < 1e-15, "{p:?}"),
                f if (7 * N..8 * N).contains(&f) => assert!((p.z - 1.5).abs() < 1e-15, "{p:?}"),
                // The mesh itself is off by 1.9e-2 here; being pulled to the rims costs the faces beside them some of that.
                _ => assert!(on_side < 1e-2, "{on_side:e}"),
            }
        }
    }
    // The rims are cubic curves next to circles.
    for i in 0..=8 {
        let edge =
            (0..).map(isopatch::mesh::EdgeId).find_map(|e| cylinder.function().hull().data().crease_curve(e));
        let z = f64::from(i) / 8.0;
        let point = edge.unwrap().point(1.0 - z, z);
        assert!((point.x.hypot(point.y) - 1.0).abs() < 1e-6, "{point:?}");
    }
}

#[test]
fn a_plate_with_a_round_hole_is_flat_and_round() {
    const N: u32 = 16;
    // Angles to the corners of the square are multiples of one eighth.
    let square = |i: u32, z: f64| {
        let p = around(i, N, 1.0, 0.0);
        2.0 * p / p.x.abs().max(p.y.abs()) + z * Vec3::z()
    };
    let mut p = Vec::new();
    for z in [0.0, 0.5] {
        p.extend((0..N).map(|i| around(i, N, 1.0, z)));
        p.extend((0..N).map(|i| square(i, z)));
    }
    let [inner, outer, top] = [0, N, 2 * N];
    let ring = |a: u32, b: u32| (0..N).map(move |i| [a + i, b + i, b + (i + 1) % N, a + (i + 1) % N]);
    let mut faces = halved(ring(outer, inner));
    faces.extend(halved(ring(top + inner, top + outer)));
    faces.extend(halved(ring(inner, top + inner)));
    faces.extend(halved(ring(top + outer, outer)));
    let plate = surface(p, &faces, 40.0);
    assert_no_cuts(&plate);
    let counts = plate.crease_counts();
    assert_eq!((counts.straight, counts.curved), (2 * N as usize + 4, 2 * N as usize));
    let mesh = assert_valid("plate", &plate, 20);
    assert_normals("plate", &mesh);
    for (triangle, patch) in mesh.triangles.iter().zip(&mesh.patches) {
        for p in triangle.map(|v| mesh.positions[v as usize]) {
            match patch.0 / (2 * N) {
                0 => assert!(p.z.abs() < 1e-15),
                1 => assert!((p.z - 0.5).abs() < 1e-15),
                3 => assert!((p.x.abs().max(p.y.abs()) - 2.0).abs() < 1e-14),
                _ => assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-2, "{patch:?} {p:?}"),
            }
        }
    }
}

/// Faces that are all flat in themselves: with every vertex cut the surface is the mesh.
#[test]
fn a_spiky_mesh_gets_corners_and_says_why() {
    // Two tetrahedra that touch along a hinge so that no direction sees all faces at its ends.
    let p = [
        [0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.02, 0.0],
        [-1.0, 0.02, 0.0],
        [0.0, -0.3, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let spiky = surface(p.map(Point3::from).to_vec(), &faces, 180.0);
    assert_valid("spiky", &spiky, 20);
    for crease in spiky.function().hull().added_creases() {
        assert!(spiky.function().hull().data().is_crease(crease.edge));
    }
}

/// A mesh of the collection: its name and the angle of creases.
type Case = (&'static str, f64);

/// Intervals of the grids that the issue asks for.
const GRID: usize = 20;

/// The vertices of a mesh without a visible normal: in some sector between its creases, no direction sees all faces.
fn hidden_vertices(positions: &[Point3], faces: &[[u32; 3]], angle: f64) -> Vec<VertexId> {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces).unwrap();
    let sharp = creases::by_angle(&mesh, positions, angle.to_radians());
    let is_hidden = |sector: &Vec<HalfEdgeId>| {
        let normals: Vec<Vec3> = sector.iter().map(|h| of_face(&mesh, positions, mesh.face(*h))).collect();
        hull::most_visible_direction(&normals).is_none_or(|(_, product)| product <= 0.0)
    };
    mesh.vertices().filter(|v| creases::sectors(&mesh, &sharp, *v).iter().any(is_hidden)).collect()
}

fn assert_mesh((name, angle): Case) -> bool {
    let path = support::data_folder().join("meshes").join(name).with_extension("off");
    let Ok(read) = read_mesh(&path) else { return false };
    let prepared = prepare(&read.positions, &read.faces, &PrepareOptions::default()).unwrap();
    let faces: Vec<[u32; 3]> = prepared.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
    let hidden = hidden_vertices(&prepared.positions, &faces, angle);
    let given = prepared.positions.clone();
    let surface = surface(prepared.positions, &faces, angle);
    let hull = surface.function().hull();
    assert!(hull.problems().is_empty(), "{name}: {:?}", hull.problems());
    // Vertices of the mesh keep their numbers. One without a visible normal may get one where its neighbours were rounded.
    for corner in hull.corners() {
        assert!(hidden.contains(&corner.vertex), "{name}: {corner:?}");
    }
    if hull.rounded_vertices().is_empty() {
        assert_eq!(hull.corners().len(), hidden.len(), "{name}");
    }
    for (v, p) in given.iter().enumerate() {
        assert_eq!(hull.data().positions()[v], *p, "{name}: vertex {v} moved");
    }
    assert_eq!(hull.rounded_vertices().is_empty(), !ROUNDED.contains(&name), "{name}");
    assert!(hull.rounded_distance() <= FARTHEST_OFF * hull.data().diagonal(), "{name}");
    assert_valid(name, &surface, GRID);
    // A patch that turned back at a corner would be at 180 degrees however close.
    assert_vertices(name, &surface, 1e-9, 0.1);
    if !STEEP.contains(&(name, angle)) {
        assert_vertices(name, &surface, 1e-5, 0.1);
    }
    true
}

const SMOOTH: f64 = 180.0;

/// Meshes with vertices that see a face around them under 1.1 degrees at most, which are rounded there, and how far off its edges that
/// may lead, relative to the diagonal.
const ROUNDED: [&str; 2] = ["cgal_hand", "cgal_pig"];
const FARTHEST_OFF: f64 = 0.02;

/// Meshes with sharply bent patches, which come near their limits more slowly.
const STEEP: [Case; 3] = [("cgal_cow", SMOOTH), ("pyvista_ant", SMOOTH), ("cgal_fandisk", SMOOTH)];

#[test]
fn meshes_of_the_collection_become_valid_surfaces() {
    let smooth = [
        "cgal_icosahedron",
        "cgal_ellipsoid",
        "cgal_eight",
        "cgal_sphere966",
        "cgal_knot1",
        "cgal_blobby_3cc",
        "npm_bunny",
        "cgal_head",
        "cgal_nefertiti",
        "cgal_fandisk",
        "cgal_rotor",
        "cgal_hand",
        "cgal_cow",
        "cgal_pig",
        "pyvista_ant",
        "pyvista_airplane",
        "npm_teapot",
    ];
    let mut cases: Vec<Case> = smooth.into_iter().map(|name| (name, SMOOTH)).collect();
    cases.extend([("cgal_fandisk", 40.0), ("cgal_rotor", 40.0)]);
    if !cases.iter().all(|case| assert_mesh(*case)) {
        support::skip("meshes_of_the_collection_become_valid_surfaces");
    }
}

/// Where nothing is zero convex and nothing is sharp, no crease is made.
#[test]
fn smooth_data_stay_smooth() {
    for (name, _, data) in support::meshes::quadrics() {
        let hull = hull::build(data, &HullOptions::default());
        let surface = APatchSurface::new(apatch::build(hull, &APatchOptions::default()));
        assert_no_cuts(&surface);
        assert_patches(name, &surface, 12);
        let flat = surface.function().hull().faces().iter().all(|f| f.class == Class::Zero);
        assert_eq!(flat, name == "plane");
    }
}
