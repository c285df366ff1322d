//! Hybrid A-patch surfaces of real meshes are valid, give quadrics back, and have fewer patches than their triangulations.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod support;

use isopatch::geom::{Aabb, Point3, Vec3};
use isopatch::hybrid::hull::{HybridOptions, Sheets, build};
use isopatch::hybrid::{HermitePolygons, HybridFunction, HybridSurface, broken_faces, mended};
use isopatch::inspect::{APatchInspectOptions, APatchInspection, inspect_hybrid};
use isopatch::io::native::{NativeModel, NativeSurface, Provenance, read_native};
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::recipes::apatch::{self, APatchRecipe, GradientLengths};
use isopatch::recipes::hybrid::{Fitted, FittedPolygons, HybridRecipe, Polygons, TriangleElement, fit};
use isopatch::surface::{Domain, PatchId, Surface};
use isopatch::tessellate::{APatchResolution, tessellate_hybrid};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use support::bodies::{Body, bodies, grid, quadrics};

fn polygons(fitted: Fitted) -> FittedPolygons {
    match fitted {
        Fitted::Polygons(fitted) => *fitted,
        Fitted::Triangles(fitted) => panic!("made over triangles: {:?}", fitted.repairs),
    }
}

fn run(mesh: &PolygonMesh, recipe: &HybridRecipe) -> FittedPolygons {
    polygons(fit(mesh, recipe, &|_| ()).unwrap())
}

fn mesh_of(body: &Body, normals: impl Fn(&Point3) -> Vec3) -> PolygonMesh {
    let normals = body.positions.iter().map(normals).collect();
    PolygonMesh { positions: body.positions.clone(), faces: body.faces.clone(), normals: Some(normals) }
}

/// Parameters all over a domain.
fn parameters(domain: Domain, n: usize) -> Vec<[f64; 2]> {
    let at = |i: usize| i as f64 / n as f64;
    let square = |k: f64| (0..=n).flat_map(move |i| (0..=n).map(move |j| [k + at(i), at(j)]));
    match domain {
        Domain::Triangle => (0..=n).flat_map(|i| (0..=n - i).map(move |j| [at(i), at(j)])).collect(),
        Domain::Square => square(0.0).collect(),
        Domain::Polygon(count) => (0..count).flat_map(|k| square(f64::from(k))).collect(),
    }
}

/// The largest of a quantity over points all over a surface.
fn worst(surface: &HybridSurface, n: usize, of: impl Fn(&Point3) -> f64) -> f64 {
    let of_patch = |patch: PatchId| {
        let points =
            parameters(surface.domain(patch), n).into_iter().map(|uv| surface.sample(patch, uv).point);
        points.map(|p| of(&p)).fold(0.0, |a: f64, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
    };
    surface.patches().map(of_patch).fold(0.0, f64::max)
}

fn inspected(surface: &HybridSurface) -> APatchInspection {
    let options = APatchInspectOptions { lattice: 10, seam_intervals: 8, intersections: None };
    inspect_hybrid(surface, &options)
}

/// All that a valid surface is asked for.
fn assert_valid(name: &str, surface: &HybridSurface, euler: Option<i64>) {
    let found = inspected(surface);
    assert!(found.undefined.is_empty() && found.folded.is_empty(), "{name}: {found:?}");
    assert!(broken_faces(surface.function()).is_empty(), "{name}");
    let common = &found.common;
    assert!(common.seams.max_gap < 1e-14, "{name}: {:?}", common.seams);
    assert!(common.seams.max_normal_jump < 1e-12, "{name}: {:?}", common.seams);
    assert!(common.interpolation.max_position_error == 0.0, "{name}: {:?}", common.interpolation);
    assert!(common.interpolation.max_normal_error < 1e-12, "{name}: {:?}", common.interpolation);
    if let Some(euler) = euler {
        assert_eq!((common.topology.euler, common.topology.boundary_loops), (euler, 0), "{name}");
    }
}

/// Every quadric comes back from its gradients, and from unit normals if their lengths are recovered.
#[test]
fn quadrics_come_back() {
    for (q, body) in quadrics() {
        let exact = run(&mesh_of(&body, |p| q.gradient(p)), &HybridRecipe::default());
        let miss = worst(&exact.surface, 6, |p| q.distance(p));
        assert!(miss < 1e-12, "{}: {miss:e}", body.name);
        let triangles = APatchRecipe { lengths: GradientLengths::Recovered, ..APatchRecipe::default() };
        let recipe = HybridRecipe { triangles, ..HybridRecipe::default() };
        let recovered = run(&mesh_of(&body, |p| q.gradient(p).normalize()), &recipe);
        let miss = worst(&recovered.surface, 6, |p| q.distance(p));
        assert!(miss < 1e-11, "{} from unit normals: {miss:e}", body.name);
    }
}

/// Files with polygons in them, and their Euler numbers.
const FILES: [(&str, i64); 8] = [
    ("cgal_cross_quad", 2),
    ("cgal_torus_quad", 0),
    ("conway_ambo_dodeca", 2),
    ("conway_dgC_snub_cube", 2),
    ("conway_gC_pentagonal_icositetrahedron", 2),
    ("conway_prism5", 2),
    ("conway_trunc_icosahedron_soccer", 2),
    ("geomview_dodec", 2),
];

fn file(name: &str) -> Option<PolygonMesh> {
    let path = support::data_folder().join("meshes").join(format!("{name}.off"));
    path.exists().then(|| read_mesh(&path).unwrap())
}

/// Every closed mesh of polygons becomes a valid surface over these polygons; its patches and cells against those of its
/// triangulation are printed.
#[test]
fn real_meshes_are_valid_and_have_fewer_patches() {
    println!("| mesh | patches | triangulated | cells | triangulated |\n|---|---|---|---|---|");
    for (name, euler) in FILES {
        let Some(mesh) = file(name) else { return support::skip("real meshes of polygons") };
        let made = run(&mesh, &HybridRecipe::default());
        assert_valid(name, &made.surface, Some(euler));
        let elements = made.figures.elements.unwrap();
        assert_eq!((elements.cut, elements.flat), (0, 0), "{name}");
        let cut = apatch::fit(&mesh, &APatchRecipe::default(), &|_| ()).unwrap();
        let (ours, theirs) = (made.surface.patch_count(), cut.surface.patch_count());
        let cells = |f: &isopatch::report::APatchReport| f.face_cells + f.edge_cells;
        let found = inspected(&made.surface);
        println!(
            "| {name} | {ours} | {theirs} | {} | {} | steep {:?} {:?}",
            cells(&made.figures),
            cells(&cut.figures),
            found.steep.len(),
            made.repairs
        );
        assert!(ours <= theirs, "{name}: {ours} patches, {theirs} over triangles");
        let all_quads = mesh.faces.iter().all(|f| f.len() == 4);
        assert!(!all_quads || 5 * ours == 3 * theirs, "{name}: {ours} patches, {theirs} over triangles");
    }
}

fn torus(n: u32) -> (Body, impl Fn(&Point3) -> Vec3) {
    let mut body = grid("torus", [3 * n, n], true, |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let r = 2.0 + 0.8 * b.cos();
        Point3::new(r * a.cos(), r * a.sin(), 0.8 * b.sin())
    });
    // The last ring is the first one again.
    body.faces.iter_mut().flatten().for_each(|v| *v %= 3 * n * n);
    body.positions.truncate((3 * n * n) as usize);
    (body, |p: &Point3| {
        let ring = Vec3::new(p.x, p.y, 0.0).normalize() * 2.0;
        (p - ring).normalize()
    })
}

fn torus_distance(p: &Point3) -> f64 {
    let ring = Vec3::new(p.x, p.y, 0.0).normalize() * 2.0;
    ((p - ring).norm() - 0.8).abs()
}

/// A torus of quadrilaterals with its normals: whenever the edges are halved the largest error falls to an eighth or less.
#[test]
fn a_torus_of_quadrilaterals_converges() {
    let misses = [6, 12, 24, 48].map(|n| {
        let (body, normal) = torus(n);
        let made = run(&mesh_of(&body, normal), &HybridRecipe::default());
        assert_valid("torus", &made.surface, Some(0));
        worst(&made.surface, 5, torus_distance)
    });
    let orders: Vec<f64> = misses.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("largest errors {misses:?}, orders {orders:?}");
    assert!(orders.iter().all(|o| *o >= 3.0), "{misses:?} {orders:?}");
}

/// A mesh of triangles alone goes to the triangle method, unless the hybrid cells are asked for: then a quadric is the same.
#[test]
fn triangles_alone_stay_with_the_triangle_method() {
    let (q, body) = quadrics().into_iter().rfind(|(_, body)| body.name == "pentagonal pyramid").unwrap();
    let faces: Vec<Vec<u32>> =
        body.faces.iter().flat_map(|f| (1..f.len() - 1).map(|k| vec![f[0], f[k], f[k + 1]])).collect();
    let mesh = PolygonMesh { faces, ..mesh_of(&body, |p| q.gradient(p)) };
    let Fitted::Triangles(made) = fit(&mesh, &HybridRecipe::default(), &|_| ()).unwrap() else {
        panic!("a mesh of triangles became a hybrid surface")
    };
    let direct = apatch::fit(&mesh, &APatchRecipe::default(), &|_| ()).unwrap();
    assert_eq!(made.surface.patch_count(), direct.surface.patch_count());
    for patch in direct.surface.patches() {
        for uv in parameters(direct.surface.domain(patch), 4) {
            assert_eq!(made.surface.sample(patch, uv).point, direct.surface.sample(patch, uv).point);
        }
    }
    let recipe = HybridRecipe { triangle_element: TriangleElement::Hybrid, ..HybridRecipe::default() };
    let hybrid = run(&mesh, &recipe);
    assert!(worst(&hybrid.surface, 6, |p| q.distance(p)) < 1e-12);
    // Polygons that are cut go the same way.
    let whole = mesh_of(&body, |p| q.gradient(p));
    let recipe = HybridRecipe { polygons: Polygons::Split, ..recipe };
    assert!(worst(&run(&whole, &recipe).surface, 6, |p| q.distance(p)) < 1e-12);
}

/// Numbers from −1 to 1 that look random.
fn noise(n: usize) -> f64 {
    let x = (n as f64 * 12.9898 + 4.1).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// With normals that are far off no ray loses its root, and the surface stays smooth.
#[test]
fn noisy_normals_give_single_sheets() {
    for (_, body) in quadrics().into_iter().take(12) {
        for seed in 0..4usize {
            let mut at = 1000 * seed;
            let mut noisy = |p: &Point3| {
                at += 3;
                (p + 0.3 * Vec3::new(noise(at), noise(at + 1), noise(at + 2))).normalize()
            };
            let gradients: Vec<Vec3> = body.positions.iter().map(&mut noisy).collect();
            let connectivity = HalfEdgeMesh::from_faces(body.positions.len(), &body.faces).unwrap();
            let data = HermitePolygons::new(connectivity, body.positions.clone(), &gradients).unwrap();
            let built = build(data, &HybridOptions::default());
            let (function, broken) = mended(HybridFunction::new(built.hull), Sheets::OffQuadrics);
            assert!(broken.is_empty(), "{} {seed}: {broken:?}", body.name);
            let found = inspected(&HybridSurface::new(function));
            assert!(found.undefined.is_empty(), "{} {seed}", body.name);
            assert!(
                found.common.seams.max_normal_jump < 1e-12,
                "{} {seed}: {:?}",
                body.name,
                found.common.seams
            );
        }
    }
}

/// What no cells over polygons suit becomes triangles, and the report says so.
#[test]
fn polygons_that_do_not_fit_are_cut_and_named() {
    // A prism over a U, which no point sees whole.
    let u = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [4.0, 5.0], [4.0, 1.0], [1.0, 1.0], [1.0, 5.0], [0.0, 5.0]];
    let ring = |z: f64| u.iter().map(move |[x, y]| Point3::new(*x, *y, z));
    let positions: Vec<Point3> = ring(0.0).chain(ring(1.0)).collect();
    let mut faces: Vec<Vec<u32>> = (0..8u32).map(|i| vec![i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i]).collect();
    faces.push((0..8).rev().collect());
    faces.push((8..16).collect());
    let mesh = PolygonMesh { positions, faces, normals: None };
    let repairs = match fit(&mesh, &HybridRecipe::default(), &|_| ()).unwrap() {
        Fitted::Polygons(made) => made.repairs,
        Fitted::Triangles(made) => made.repairs,
    };
    assert!(repairs.iter().any(|r| r.what.starts_with("polygons cut into triangles")), "{repairs:?}");
}

fn very_noisy(body: &Body, seed: usize, size: f64) -> PolygonMesh {
    mesh_of(body, |p| {
        let vertex = body.positions.iter().position(|q| q == p).unwrap();
        let at = 1000 * seed + 3 * (vertex + 1);
        (p + size * Vec3::new(noise(at), noise(at + 1), noise(at + 2))).normalize()
    })
}

/// Where normals are beyond what cells over a polygon can follow, that polygon is cut, and not all of them; what is made over
/// triangles alone is valid as well.
#[test]
fn faults_are_mended_where_they_are() {
    let split = HybridRecipe {
        polygons: Polygons::Split,
        triangle_element: TriangleElement::Hybrid,
        ..HybridRecipe::default()
    };
    let mut cut = 0;
    for body in bodies() {
        for (seed, size) in [(1, 0.8), (2, 1.2), (3, 2.0)] {
            let mesh = very_noisy(&body, seed, size);
            for recipe in [HybridRecipe::default(), split.clone()] {
                let Fitted::Polygons(made) = fit(&mesh, &recipe, &|_| ()).unwrap() else { continue };
                assert_valid(&format!("{} {seed}", body.name), &made.surface, None);
                let says = |what: &str| made.repairs.iter().any(|r| r.what.starts_with(what));
                let of_hull = made.figures.elements.unwrap().cut;
                assert_eq!(says("creases added"), made.figures.creases_added > 0, "{} {seed}", body.name);
                assert!(of_hull == 0 || says("polygons cut into triangles"), "{} {seed}", body.name);
                assert!(of_hull < mesh.faces.len(), "{} {seed}", body.name);
                cut += of_hull;
            }
        }
    }
    assert!(cut > 0);
}

/// A native file gives the same surface back, bit for bit.
#[test]
fn native_files_give_the_same_surface_back() {
    for (q, body) in quadrics() {
        let noisy = |p: &Point3| {
            let at = (p.x * 100.0 + p.y * 10.0 + p.z).abs() as usize;
            q.gradient(p).normalize() + 0.2 * Vec3::new(noise(at), noise(at + 7), noise(at + 9))
        };
        let Fitted::Polygons(made) = fit(&mesh_of(&body, noisy), &HybridRecipe::default(), &|_| ()).unwrap()
        else {
            continue;
        };
        let provenance = Provenance { source: body.name.to_owned(), diagonal: 2.5, ..Provenance::default() };
        let model = NativeModel { surface: NativeSurface::Hybrid(Box::new(made.surface)), provenance };
        let mut bytes = Vec::new();
        model.write(&mut bytes).unwrap();
        let read = read_native(&mut &*bytes).unwrap();
        assert_eq!(read.provenance, model.provenance);
        let (old, new) = (model.as_surface(), read.as_surface());
        assert_eq!((old.patch_count(), old.seams()), (new.patch_count(), new.seams()));
        for patch in old.patches() {
            for uv in parameters(old.domain(patch), 3) {
                assert_eq!(format!("{:?}", old.sample(patch, uv)), format!("{:?}", new.sample(patch, uv)));
            }
        }
        let mut again = Vec::new();
        read.write(&mut again).unwrap();
        assert_eq!(bytes, again);
        // No part of a file makes the reader panic, and none is mistaken for the whole.
        for end in (0..bytes.len()).step_by(97) {
            assert!(read_native(&mut &bytes[..end]).is_err());
        }
    }
}

/// A prism over a regular polygon, of radius and height 1; its ends are polygons.
fn cylinder(n: u32) -> PolygonMesh {
    let ring = |z: f64| {
        (0..n).map(move |i| {
            let a = TAU * f64::from(i) / f64::from(n);
            Point3::new(a.cos(), a.sin(), z)
        })
    };
    let side = |i: u32| vec![i, (i + 1) % n, n + (i + 1) % n, n + i];
    let mut faces: Vec<Vec<u32>> = (0..n).map(side).collect();
    faces.push((0..n).rev().collect());
    faces.push((n..2 * n).collect());
    PolygonMesh { positions: ring(0.0).chain(ring(1.0)).collect(), faces, normals: None }
}

fn with_creases(degrees: f64) -> HybridRecipe {
    let triangles = APatchRecipe { crease_angle: Some(degrees.to_radians()), ..APatchRecipe::default() };
    HybridRecipe { triangles, ..HybridRecipe::default() }
}

/// Creases are local: polygons stay, nothing is open, and there are fewer patches than over triangles.
#[test]
fn creases_keep_polygons() {
    let (_, cube) = quadrics().into_iter().next().unwrap();
    let cube = PolygonMesh { normals: None, ..mesh_of(&cube, |p| *p) };
    for (name, mesh, curved) in
        [("cube", cube, 0), ("prism of six sides", cylinder(6), 0), ("cylinder", cylinder(16), 32)]
    {
        let recipe = with_creases(40.0);
        let made = run(&mesh, &recipe);
        assert_valid(name, &made.surface, Some(2));
        let counts = made.surface.crease_counts();
        assert_eq!(counts.curved, curved, "{name}: {counts:?}");
        let elements = made.figures.elements.unwrap();
        assert_eq!(elements.cut, 0, "{name}: {:?}", made.repairs);
        let over_triangles = apatch::fit(&mesh, &recipe.triangles, &|_| ()).unwrap();
        let (ours, theirs) = (made.surface.patch_count(), over_triangles.surface.patch_count());
        println!("| {name} | {ours} | {theirs} |");
        assert!(ours < theirs, "{name}: {ours} patches, {theirs} over triangles");
        let drawn = tessellate_hybrid(&made.surface, APatchResolution { along: 8, across: 3 }).unwrap().mesh;
        assert_eq!(open_edges(&drawn.triangles), 0, "{name}");
    }
}

/// Edges that have a triangle on one side only.
fn open_edges(triangles: &[[u32; 3]]) -> usize {
    let mut sides: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for t in triangles {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    sides.values().filter(|sum| **sum != 0).count()
}

/// The ends of a cylinder are flat, its rims nearly circles, and its side is round.
#[test]
fn a_cylinder_of_polygons_has_flat_ends_and_a_round_side() {
    let made = run(&cylinder(16), &with_creases(40.0));
    let off_side = |p: &Point3| if p.z > 0.0 && p.z < 1.0 { (p.xy().norm() - 1.0).abs() } else { 0.0 };
    let off_ends = |p: &Point3| (p.xy().norm() - 1.0).max(0.0);
    for patch in made.surface.patches() {
        let is_end = (16..18).contains(&patch.index());
        for uv in parameters(made.surface.domain(patch), 10) {
            let sample = made.surface.sample(patch, uv);
            let p = sample.point;
            if is_end {
                assert!((p.z - p.z.round()).abs() < 1e-15 && off_ends(&p) < 1e-5, "{p:?}");
                assert!((sample.normal.z.abs() - 1.0).abs() < 1e-12, "{:?}", sample.normal);
            } else {
                assert!(off_side(&p) < 2e-3, "{p:?}");
            }
        }
    }
    // Derivatives are those of the points that creases pull, too.
    const STEP: f64 = 1e-6;
    for (patch, u, v) in [(0, 0.3, 0.2), (0, 2.6, 0.7), (3, 0.9, 0.05), (16, 4.2, 0.1), (17, 9.5, 0.01)] {
        let at = |u: f64, v: f64| made.surface.sample(PatchId(patch), [u, v]);
        let found = at(u, v);
        let du = (at(u + STEP, v).point - at(u - STEP, v).point) / (2.0 * STEP);
        let dv = (at(u, v + STEP).point - at(u, v - STEP).point) / (2.0 * STEP);
        assert!((found.du - du).norm() < 1e-8 && (found.dv - dv).norm() < 1e-8, "{found:?} {du} {dv}");
        assert!((found.normal - du.cross(&dv).normalize()).norm() < 1e-7, "{found:?}");
    }
    let bounds = made.surface.patches().fold(Aabb::EMPTY, |b, p| b.union(&made.surface.bounds(p)));
    let of_points = worst(&made.surface, 6, |p| if bounds.grown(1e-9).contains(p) { 0.0 } else { 1.0 });
    assert_eq!(of_points, 0.0);
}

/// A boundary changes nothing but that no patch stands over its edges.
#[test]
fn open_meshes_end_in_their_boundary() {
    for (q, body) in quadrics().into_iter().filter(|(_, body)| body.name.contains("paraboloid")) {
        let noisy = |p: &Point3| {
            let at = (p.x * 100.0 + p.y * 10.0).abs() as usize;
            q.gradient(p).normalize() + 0.05 * Vec3::new(noise(at), noise(at + 7), 0.0)
        };
        let made = run(&mesh_of(&body, noisy), &HybridRecipe::default());
        assert_valid(body.name, &made.surface, None);
        assert_eq!(inspected(&made.surface).common.topology.boundary_loops, 1);
    }
}
