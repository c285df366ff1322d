//! What Xu, Huang & Bajaj (2001) state about rational A-patches, and what holds after the corrections.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::apatch::{self, APatchFunction, APatchOptions, APatchSurface, Free, FreeRule, Layer2Rule};
use isopatch::bernstein::{cubic, triangle};
use isopatch::geom::{Point3, Vec3};
use isopatch::hull::{self, ApexRule, Class, HermiteMesh, HullOptions, Side};
use isopatch::mesh::{FaceId, HalfEdgeMesh};
use isopatch::surface::Surface;
use isopatch::tessellate::{APatchResolution, tessellate_a_patches};
use support::meshes::{Quadric, from_file, noise, perturbed, quadrics, torus, torus_distance};
use support::skip;

fn with(data: HermiteMesh, options: &APatchOptions) -> APatchFunction {
    apatch::build(hull::build(data, &HullOptions::default()), options)
}

fn function(data: HermiteMesh) -> APatchFunction {
    with(data, &APatchOptions::default())
}

/// Largest `distance` of the points of a surface.
fn worst(f: APatchFunction, distance: impl Fn(&Point3) -> f64) -> f64 {
    let mesh =
        tessellate_a_patches(&APatchSurface::new(f), APatchResolution { along: 6, across: 4 }).unwrap();
    mesh.positions.iter().map(distance).fold(0.0, f64::max)
}

fn named(name: &str) -> (Quadric, HermiteMesh) {
    let found = quadrics().into_iter().find(|(n, ..)| *n == name).unwrap();
    (found.1, found.2)
}

/// The default of step 8 is exact for planes only: on the icosahedron of the sphere it misses by 3.1e-2. The neighbour rule
/// is exact.
#[test]
fn step_8_does_not_give_quadrics() {
    let linear = APatchOptions {
        rule: FreeRule::Linear,
        layer2: Layer2Rule::LeastSquares,
        ..APatchOptions::default()
    };
    let paper = HullOptions { rule: ApexRule::Paper, ..HullOptions::default() };
    let (sphere, data) = named("sphere");
    let missed = worst(apatch::build(hull::build(data.clone(), &paper), &linear), |p| sphere.distance(p));
    assert!((missed - 3.1e-2).abs() < 2e-3, "{missed}");
    assert!(worst(function(data), |p| sphere.distance(p)) < 1e-15);
    let (plane, data) = named("plane");
    assert_eq!(worst(apatch::build(hull::build(data, &paper), &linear), |p| plane.distance(p)), 0.0);
}

/// Gradients have lengths: with unit normals an ellipsoid is missed by 8e-3.
#[test]
fn unit_normals_lose_the_ellipsoid() {
    let (ellipsoid, data) = named("ellipsoid");
    let mesh = data.mesh().clone();
    let units: Vec<Vec3> = data.positions().iter().map(|p| ellipsoid.gradient(p).normalize()).collect();
    let unit = HermiteMesh::new(mesh, data.positions().to_vec(), &units).unwrap();
    let missed = worst(function(unit), |p| ellipsoid.distance(p));
    assert!((4e-3..2e-2).contains(&missed), "{missed}");
    assert!(worst(function(data), |p| ellipsoid.distance(p)) < 1e-15);
}

/// Theorem 4.2: over quadric data a face function is the quadric plus a multiple of the squared coordinate of the apex.
#[test]
fn face_functions_of_quadrics_differ_by_a_square() {
    for name in ["ellipsoid", "hyperboloid of one sheet"] {
        let (q, data) = named(name);
        for layer2 in [Layer2Rule::Interpolate, Layer2Rule::LeastSquares] {
            let f = with(
                data.clone(),
                &APatchOptions { layer2, free: Free::Global(0.7), ..APatchOptions::default() },
            );
            for face in data.mesh().faces() {
                for side in Side::BOTH {
                    let Some(cell) = f.face_cell(face, side) else { continue };
                    let lift = side.sign() * 0.7 - q.value(&cell[3]);
                    for [x, y, z] in triangle::lattice(4) {
                        let w = 0.5 * (1.0 - x * x);
                        let at = [x * (1.0 - w), y * (1.0 - w), z * (1.0 - w), w];
                        let p: Point3 = at.iter().zip(&cell).map(|(x, p)| *x * p).sum();
                        let (value, _) = f.in_face_cell(face, side, at).unwrap();
                        assert!((value - q.value(&p) - lift * w * w).abs() < 1e-14, "{name}");
                    }
                }
            }
        }
    }
}

/// Corollary 4.3: with c_k μ_4 = c_l ν_1 the edge function is a quadratic, without a rational term; but it is that of the
/// faces only if both are zero.
#[test]
fn edge_functions_of_quadrics_can_be_quadratic() {
    let (q, data) = named("ellipsoid");
    let f = function(data.clone());
    for e in data.mesh().edges().step_by(7) {
        let side = Side::Outer;
        let [mu, nu] = f.edges()[e.index()][0].unwrap().reach;
        let [h, g] = data.joint(e).unwrap();
        let [k, l] = [h, g].map(|h| data.mesh().face(h).index());
        let [u_k, u_l] = f.hull().edge_apexes(e, side).unwrap();
        let mut free = f.free().to_vec();
        free[k][0] = q.value(&u_k) + 0.3;
        free[l][0] = q.value(&u_l) + 0.3 * mu / nu;
        let f = f.clone().with_free(&Free::PerFace(free));
        let edge = f.edge_function(e, side).unwrap();
        for v in 0..2 {
            assert!((edge.a[v] - edge.b[v]).abs() < 1e-14);
        }
        let cell = f.edge_cell(e, side).unwrap();
        let p: Point3 = cell.iter().sum::<Point3>() / 4.0;
        let (value, _) = f.in_edge_cell(e, side, [0.25; 4]).unwrap();
        assert!((value - q.value(&p)).abs() > 1e-3);
    }
}

/// Plane recovery, Fig. 10: a face whose normals are its own stays in its plane, and joins a nonconvex face smoothly.
#[test]
fn a_flat_face_stays_flat_and_joins_smoothly() {
    let corners = [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, -1.0], [0.0, -4.0, 0.0]].map(Point3::from);
    let up = Vec3::z();
    let mesh = HalfEdgeMesh::from_faces(4, &[[2, 0, 1], [3, 1, 0]]).unwrap();
    let data = HermiteMesh::new(mesh, corners.to_vec(), &[up, up, Vec3::new(0.0, -1.0, 1.5), up]).unwrap();
    let f = function(data);
    assert_eq!(
        f.hull().faces().iter().map(|face| face.class).collect::<Vec<_>>(),
        [Class::Nonconvex, Class::Zero]
    );
    let [curved, flat] = [0, 1].map(FaceId);
    for x in triangle::lattice(8) {
        let hit = f.shoot_face(flat, x).unwrap();
        assert_eq!((hit.point.z, hit.gradient.normalize()), (0.0, up));
    }
    for s in [0.1, 0.25, 0.5, 0.9] {
        let hit = f.shoot_face(curved, [0.0, s, 1.0 - s]).unwrap();
        assert_eq!(hit.point.z, 0.0);
        assert!((hit.gradient.normalize() - up).norm() < 1e-14);
    }
    assert!(f.shoot_face(curved, [0.4, 0.3, 0.3]).unwrap().point.z.abs() > 1e-3);
}

/// Section 4: 5/2 patches a face on a closed mesh, against 4 of schemes that split every face in four.
#[test]
fn there_are_five_patches_for_two_faces() {
    let surface = APatchSurface::new(function(perturbed(0.1, 0.6)));
    assert_eq!(2 * surface.patch_count(), 5 * surface.function().faces().len());
}

#[test]
fn a_torus_is_approached_with_order_three() {
    let errors: Vec<f64> =
        [[12, 8], [24, 16], [48, 32]].map(|n| worst(function(torus(n)), torus_distance)).to_vec();
    assert!(errors[0] < 3.5e-3 && errors[2] < 4e-5, "{errors:?}");
    assert!(errors.windows(2).all(|pair| (pair[0] / pair[1]).log2() > 3.0), "{errors:?}");
}

/// The layers of every ray have the signs (−, +, +, +) with the default free parameters: one simple root (Appendix A).
fn check_signs(f: &APatchFunction, rays: usize) {
    let mesh = f.hull().data().mesh();
    let check = |layers: &[f64; 4], what: &str| {
        assert!(layers[1] > 0.0 && layers[2] >= 0.0 && layers[3] > 0.0, "{what}: {layers:?}");
        let root = cubic::minimal_root(layers);
        assert!(root.is_some() || layers[0] > 0.0);
        // Across the surface the function grows, so that its gradient is not zero there.
        assert!(layers[0] >= 0.0 || root.is_some_and(|t| cubic::derivative(layers, t) > 0.0), "{what}");
    };
    for n in 0..rays {
        let [a, b, c] = [0, 1, 2].map(|i| 0.5 + 0.5 * noise(5 * n + i));
        for face in mesh.faces() {
            let x = [a * b, a * (1.0 - b), 1.0 - a];
            if let Some((_, layers)) = f.face_layers(face, x) {
                check(&layers, "face");
            }
        }
        for e in mesh.edges() {
            for side in Side::BOTH {
                if let Some(edge) = f.edge_function(e, side) {
                    let layers = edge.layers(a, 1.0 - a, c);
                    check(&layers, "edge");
                }
            }
        }
    }
}

#[test]
fn every_ray_has_one_simple_root() {
    check_signs(&function(perturbed(0.1, 0.6)), 200);
    check_signs(&function(torus([12, 8])), 50);
    let Some(bunny) = from_file("npm_bunny.off") else { return skip("every_ray_has_one_simple_root") };
    let f = function(bunny);
    check_signs(&f, 20);
    // Some defaults of the rule had to be raised for that.
    let raised = f.default_free().iter().zip(f.free()).filter(|(default, free)| default != free).count();
    assert!(raised > 0 && raised < f.faces().len() / 10, "{raised}");
}

/// Section 5.3: other free parameters change nothing but the last layer and its part of the one before.
#[test]
fn free_parameters_move_the_surface_between_hull_and_mesh() {
    let f = function(perturbed(0.1, 0.3));
    let shot = |f: &APatchFunction| {
        let faces = f.hull().data().mesh().faces();
        faces.map(|face| f.shoot_face(face, [0.3, 0.4, 0.3]).unwrap().t).collect::<Vec<f64>>()
    };
    let bulged = shot(&f);
    let free: Vec<[f64; 2]> = f.free().iter().map(|b| b.map(|b| 4.0 * b)).collect();
    let flatter = f.clone().with_free(&Free::PerFace(free));
    assert_eq!((f.faces(), f.edges()), (flatter.faces(), flatter.edges()));
    assert!(bulged.iter().zip(shot(&flatter)).all(|(a, b)| b < *a && b > 0.0));
    // A value that is no number stands for the default.
    let back = flatter.with_free(&Free::PerFace(vec![[f64::NAN; 2]; f.faces().len()]));
    assert_eq!(back.free(), f.free());
}

/// A zero convex edge between two curved faces has no patch, and the faces are smooth across it.
#[test]
fn straight_edges_need_no_patch() {
    let (cylinder, data) = named("cylinder");
    let surface = APatchSurface::new(function(data.clone()));
    let straight: Vec<_> = data
        .mesh()
        .edges()
        .filter(|e| surface.function().hull().edges()[e.index()].class == Class::Zero)
        .filter(|e| data.joint(*e).is_some())
        .collect();
    assert_eq!(straight.len(), 48);
    for e in straight {
        let h = data.mesh().edge_half_edge(e);
        let [a, b] = data.joint(e).unwrap().map(|h| {
            let (mut x, k) = ([0.0; 3], data.mesh().side(h));
            (x[k], x[(k + 1) % 3]) =
                if data.mesh().edge_half_edge(e) == h { (0.25, 0.75) } else { (0.75, 0.25) };
            surface.function().shoot_face(data.mesh().face(h), x).unwrap()
        });
        assert_eq!(a.point, b.point);
        assert!((a.gradient.normalize() - b.gradient.normalize()).norm() < 1e-14);
        let [p, q] = [data.mesh().origin(h), data.mesh().dest(h)].map(|v| data.positions()[v.index()]);
        assert!((a.point - (0.25 * p + 0.75 * q)).norm() < 1e-15);
        assert!((a.gradient - cylinder.gradient(&a.point)).norm() < 1e-13);
    }
}

/// Real meshes: every point found, and the closed ones stay closed with their Euler number.
#[test]
fn scans_become_smooth_surfaces() {
    for name in ["npm_bunny.off", "cgal_eight.off", "cgal_head.off", "cgal_nefertiti.off"] {
        let Some(data) = from_file(name) else { return skip("scans_become_smooth_surfaces") };
        let f = function(data.clone());
        assert!(f.hull().problems().is_empty(), "{name}");
        let mesh =
            tessellate_a_patches(&APatchSurface::new(f), APatchResolution { along: 4, across: 2 }).unwrap();
        let triangles: Vec<[u32; 3]> = mesh.triangles.clone();
        let fine = HalfEdgeMesh::from_faces(mesh.positions.len(), &triangles).unwrap();
        assert_eq!(fine.euler_number(), data.mesh().euler_number(), "{name}");
        assert_eq!(fine.boundary_loop_count(), data.mesh().boundary_loop_count(), "{name}");
        assert_eq!(&mesh.positions[..data.positions().len()], data.positions());
    }
}
