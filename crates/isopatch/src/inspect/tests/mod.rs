//! Planted truths: fields and surfaces whose distances are known.

#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod fixtures;
mod intersections;

use super::*;
use crate::geom::{Point3, Points, Vec3};
use crate::surface::{PatchId, Surface};
use fixtures::*;
use std::f64::consts::PI;

/// Evaluations that the search for zeros of a smooth field spends on one of them, at most.
const STEPS_OF_ZEROS: usize = 12;

/// Few points, for tests that are not about accuracy.
fn coarse() -> InspectOptions {
    InspectOptions { back_samples: 2_000, ..InspectOptions::default() }
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs()
}

/// The sheet's figures of the golden surfaces, all on 91 samples a patch.
#[test]
fn golden_checks_are_reproduced() {
    let torus = Torus { major: 5.0, minor: 1.0 };
    let ellipsoid = Ellipsoid([1.0, 2.0, 3.0]);
    let sphere = Sphere::at(0.0, 1.0);
    let cases: [(&str, &dyn Field); 6] = [
        ("sphere_icosahedron_rec", &sphere),
        ("sphere_icosahedron_paper", &sphere),
        ("torus_12x6_rec", &torus),
        ("torus_12x6_paperobj", &torus),
        ("ellipsoid_small_rec", &ellipsoid),
        ("ellipsoid_small_paperobj", &ellipsoid),
    ];
    for (name, field) in cases {
        let Some(golden) = golden(name) else { continue };
        let expected = |key: &str| golden.json["check"][key].as_f64().unwrap();
        let d = deviation(&golden.spline, field, golden.spline.base.diagonal(), 12);
        assert!(close(golden.spline.base.diagonal(), expected("diag"), 1e-12), "{name}");
        assert!(close(d.max_first_order, expected("max_dist_over_diag"), 1e-8), "{name}");
        assert!(close(d.rms_first_order, expected("rms_dist_over_diag"), 1e-8), "{name}");
        assert!(close(d.max_normal_error.to_degrees(), expected("max_normal_err_deg"), 1e-8), "{name}");
        assert_eq!(d.folded, 0, "{name}");
        assert_eq!(d.over_limit > 0, expected("max_normal_err_deg") > 20.0, "{name}");
        // These surfaces are close: the true distance differs from the first-order one in the second order.
        assert!(close(d.max_distance, d.max_first_order, 0.02), "{name}: {d:?}");
        assert!(close(d.rms_distance, d.rms_first_order, 0.02), "{name}");
    }
}

#[test]
fn golden_splines_are_g1_and_the_nets_before_the_g1_step_are_not() {
    for name in
        ["sphere_icosahedron_rec", "torus_12x6_rec", "ellipsoid_small_rec", "ellipsoid_small_paperobj"]
    {
        let Some(golden) = golden(name) else { continue };
        let diagonal = golden.spline.base.diagonal();
        let smooth = seams(&golden.spline, diagonal, 33);
        assert!(smooth.max_normal_jump < 2e-14, "{name}: {smooth:?}");
        assert!(smooth.max_gap < 1e-15, "{name}: {smooth:?}");
        assert_eq!((smooth.interior, smooth.boundary), (golden.spline.base.mesh.edge_count(), 0));
        let sharp = seams(&golden.with_nets("g0_control_nets"), diagonal, 33);
        assert!(sharp.max_normal_jump > 1e-3 && sharp.max_gap < 1e-15, "{name}: {sharp:?}");
    }
}

#[test]
fn golden_splines_interpolate_their_vertices() {
    for name in ["sphere_icosahedron_rec", "torus_12x6_rec", "ellipsoid_small_rec"] {
        let Some(golden) = golden(name) else { continue };
        let i = interpolation(&golden.spline.base, &golden.spline, golden.spline.base.diagonal());
        assert!(i.max_position_error < 1e-15 && i.max_normal_error < 1e-13, "{name}: {i:?}");
        assert!(i.max_curvature_error < 1e-12 && i.max_mixed_curvature_error < 1e-12, "{name}: {i:?}");
    }
    // With the paper's rule for even valences the mixed term is off by a good deal, the rest is not (sheet, 2a).
    if let Some(golden) = golden("ellipsoid_small_paperobj") {
        let i = interpolation(&golden.spline.base, &golden.spline, golden.spline.base.diagonal());
        assert!(i.max_curvature_error < 1e-11 && i.max_mixed_curvature_error > 0.1, "{i:?}");
    }
}

#[test]
fn wrong_vertex_data_is_seen() {
    let mut spline = icosahedron();
    let diagonal = spline.base.diagonal();
    spline.base.curvatures[7] *= 1.01;
    let i = interpolation(&spline.base, &spline, diagonal);
    assert_eq!(i.worst_curvature.map(|v| v.0), Some(7));
    assert!(close(i.max_curvature_error, 0.01 / 1.01, 1e-9), "{i:?}");
    spline.base.positions[3] += Vec3::new(0.0, 1e-4 * diagonal, 0.0);
    spline.base.normals[3] = spline.base.normals[3].add_scalar(0.1);
    let i = interpolation(&spline.base, &spline, diagonal);
    assert!(close(i.max_position_error, 1e-4, 1e-9) && i.max_normal_error > 0.01, "{i:?}");
}

#[test]
fn a_sphere_that_is_too_large_is_seen_from_both_sides() {
    // The golden sphere is off by up to 2.5e-4 itself, so plant much more and compare the true distances.
    let (spline, field) = (icosahedron().scaled(1.1), Sphere::at(0.0, 1.0));
    let inspection = inspect(&spline, &spline.base, Some(&field), &InspectOptions::default());
    let diagonal = inspection.diagonal;
    let (d, c) = (inspection.deviation.unwrap(), inspection.coverage.unwrap());
    let largest = |lattice: usize| {
        let lattice = crate::bernstein::triangle::lattice(lattice);
        let radii = spline.patches().flat_map(|p| lattice.iter().map(move |uv| (p, [uv[0], uv[1]])));
        radii.map(|(p, uv)| spline.sample(p, uv).point.norm() - 1.0).fold(0.0, f64::max)
    };
    assert!(close(d.max_distance * diagonal, largest(InspectOptions::default().lattice), 1e-9), "{d:?}");
    assert!((0.0999..0.1001).contains(&(d.rms_distance * diagonal)));
    // The first-order figure is off by d²/2.
    assert!(d.max_first_order < 0.97 * d.max_distance);
    // The points of the zero set are many more than those of the lattice.
    assert!(close(c.max_distance * diagonal, largest(60), 3e-5), "{c:?}");
    assert!(c.samples > 20_000 && c.samples < 40_000);
    assert!(d.max_normal_error.to_degrees() < 0.15 && d.folded == 0);
}

#[test]
fn thin_shells_of_a_thousandth_are_measured_both_ways() {
    let (spline, field) = (icosahedron().scaled(1.001), Sphere::at(0.0, 1.0));
    let inspection = inspect(&spline, &spline.base, Some(&field), &InspectOptions::default());
    let diagonal = inspection.diagonal;
    let own = inspect(&icosahedron(), &spline.base, Some(&field), &InspectOptions::default());
    let own_error = own.deviation.unwrap().max_distance * diagonal;
    for distance in [inspection.deviation.unwrap().max_distance, inspection.coverage.unwrap().max_distance] {
        assert!((distance * diagonal - 0.001).abs() <= 1.01 * own_error, "{distance}");
    }
}

/// Newton from far away still ends at the closest point, which the first-order figure misses by far.
#[test]
fn distances_are_true_far_from_the_surface() {
    let points: Points = [[0.4, 0.1, 0.2], [3.0, -2.0, 5.0], [0.1, 0.9, 0.3], [-0.2, 0.6, 2.0]]
        .map(Point3::from)
        .into_iter()
        .collect();
    let sphere = Sphere::at(0.0, 1.0);
    let ellipsoid = Ellipsoid([1.0, 2.0, 3.0]);
    for i in 0..points.len() {
        let p = points.get(i);
        let q = closest_zero(&sphere, p, 3.0).unwrap();
        assert!((q - p.normalize()).norm() < 1e-3 * (p.norm() - 1.0).abs(), "{p}");
        // On the ellipsoid: on the surface, and the offset along the gradient.
        let q = closest_zero(&ellipsoid, p, 7.0).unwrap();
        let (f, g) = ellipsoid.gradient(q);
        assert!(f.abs() < 1e-13 && (p - q).cross(&g).norm() < 1e-3 * (p - q).norm() * g.norm(), "{p}");
        // No sampled point of the ellipsoid is closer.
        let sampled =
            (0..400).flat_map(|a| (0..200).map(move |b| [a as f64 * PI / 200.0, b as f64 * PI / 199.0]));
        let least = sampled
            .map(|[a, b]| Point3::new(b.sin() * a.cos(), 2.0 * b.sin() * a.sin(), 3.0 * b.cos()))
            .map(|x| (x - p).norm())
            .fold(f64::INFINITY, f64::min);
        assert!((p - q).norm() <= least, "{p}: {} {least}", (p - q).norm());
    }
}

#[test]
fn the_batched_distance_agrees_with_the_single_search() {
    let (spline, field) = (icosahedron().scaled(1.02), Ellipsoid([1.0, 1.05, 1.1]));
    let set = samples::SampleSet::new(&spline, &crate::bernstein::triangle::lattice(5));
    let points = set.sample(&spline, &spline.patches().collect::<Vec<_>>()).points;
    let n = points.len();
    let (mut f, mut g) = (vec![0.0; n], Points::zeros(n));
    field.gradients(points.view(), &mut f, g.view_mut());
    let batched = foot::distances(&field, &points, &f, &g, 2.0);
    for (i, distance) in batched.iter().enumerate() {
        let p = points.get(i);
        let single = (closest_zero(&field, p, 2.0).unwrap() - p).norm();
        assert!((distance - single).abs() <= 1e-6 * single, "{i}: {distance} {single}");
    }
}

#[test]
fn a_moved_patch_breaks_its_own_seams() {
    let mut spline = icosahedron();
    let diagonal = spline.base.diagonal();
    let offset = Vec3::new(0.0, 0.0, 1e-6);
    spline.nets[13].iter_mut().for_each(|b| *b += offset);
    let s = seams(&spline, diagonal, 33);
    assert!(close(s.max_gap * diagonal, 1e-6, 1e-6), "{s:?}");
    let worst = spline.seams()[s.worst_gap.unwrap()];
    assert!([worst.first.patch, worst.second.unwrap().patch].contains(&PatchId(13)));
    assert!(s.max_normal_jump < 1e-14);
}

#[test]
fn a_tiny_tilt_of_a_patch_is_a_normal_jump_on_its_seam_only() {
    let mut spline = icosahedron();
    let diagonal = spline.base.diagonal();
    // The middle of the row next to edge 1 of patch 4.
    let b = crate::bernstein::index::row(7, 1, 1, 3);
    let normal = spline.sample(PatchId(4), [1.0 / 3.0; 2]).normal;
    spline.nets[4][b] += 1e-12 * normal;
    let s = seams(&spline, diagonal, 33);
    assert!(s.max_normal_jump > 1e-13 && s.max_normal_jump < 1e-11 && s.max_gap < 1e-15, "{s:?}");
    let worst = spline.seams()[s.worst_normal_jump.unwrap()];
    let sides = [worst.first, worst.second.unwrap()];
    assert!(sides.iter().any(|s| (s.patch, s.edge) == (PatchId(4), 1)), "{sides:?}");
}

#[test]
fn a_fold_shows_as_a_half_turn() {
    let mut spline = icosahedron();
    let diagonal = spline.base.diagonal();
    // Reflect the row next to edge 0 of patch 0 in the boundary row: the tangent plane stays, its side turns.
    for m in 0..7 {
        let (edge, inner) =
            (crate::bernstein::index::row(7, 0, 0, m), crate::bernstein::index::row(7, 0, 1, m));
        let mirrored = 2.0 * spline.nets[0][edge] - spline.nets[0][inner];
        if (1..6).contains(&m) {
            spline.nets[0][inner] = mirrored;
        }
    }
    assert!(seams(&spline, diagonal, 33).max_normal_jump > 3.0);
    let d = deviation(&spline, &Sphere::at(0.0, 1.0), diagonal, 12);
    assert!((d.folded, d.over_limit, d.worst_normal) == (1, 1, Some(PatchId(0))), "{d:?}");
}

#[test]
fn a_patch_that_vanishes_has_no_normal() {
    let mut spline = icosahedron();
    let diagonal = spline.base.diagonal();
    spline.nets[2] = [spline.nets[2][0]; NET];
    assert_eq!(seams(&spline, diagonal, 5).max_normal_jump, PI);
    let d = deviation(&spline, &Sphere::at(0.0, 1.0), diagonal, 12);
    assert_eq!((d.folded, d.max_normal_error, d.worst_normal), (1, PI, Some(PatchId(2))));
}

#[test]
fn a_missing_component_shows_in_the_distance_back() {
    let (spline, field) = (icosahedron(), Union(Sphere::at(0.0, 1.0), Sphere::at(3.0, 0.5)));
    let blind = inspect(&spline, &spline.base, Some(&field), &InspectOptions::default());
    assert!(blind.coverage.unwrap().max_distance < 1e-3);
    let region = Some(Aabb::new(Point3::new(-1.5, -1.5, -1.5), Point3::new(4.0, 1.5, 1.5)));
    let seen = inspect(&spline, &spline.base, Some(&field), &InspectOptions { region, ..Default::default() });
    let coverage = seen.coverage.unwrap();
    // The far pole of the second sphere is at 3.5, the first one ends at 1.
    assert!(close(coverage.max_distance * seen.diagonal, 2.5, 1e-3), "{coverage:?}");
    assert!(close(coverage.worst_point.x, 3.5, 1e-3));
    assert_eq!(blind.deviation.unwrap().max_distance, seen.deviation.unwrap().max_distance);
}

#[test]
fn zeros_lie_on_the_zero_set_and_poles_are_left_out() {
    let region = Aabb::new(Point3::new(-6.5, -6.4, -1.3), Point3::new(6.5, 6.6, 1.4));
    let torus = Torus { major: 5.0, minor: 1.0 };
    let points = zeros(&torus, &region, 0.1);
    assert!(points.len() > 10_000);
    assert!(points.iter().all(|p| torus.value(*p).abs() < 1e-12));
    // A zero on a grid vertex, here the pole (0, 0, 1) of the sphere, is one too.
    let unit = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0));
    let points = zeros(&Sphere::at(0.0, 1.0), &unit, 0.125);
    assert!(points.iter().any(|p| (p - Vec3::z()).norm() < 1e-12));
    // The pole in a grid plane, in the middle of edges, and elsewhere.
    for side in [1.0, 1.05, 1.03] {
        let region = Aabb::new(Point3::repeat(-side), Point3::repeat(1.0));
        assert!(zeros(&Pole, &region, 0.1).is_empty(), "{side}");
    }
}

#[test]
fn bricks_without_a_zero_are_skipped() {
    let region = Aabb::new(Point3::repeat(-3.1), Point3::repeat(3.2));
    let sphere = Counted::new(Sphere::at(0.3, 1.0));
    let all = zeros(&sphere.field, &region, 0.05);
    assert_eq!(zeros(&sphere, &region, 0.05), all);
    // The ball with a margin of a brick's diagonal fills less than half of the region.
    let vertices = (6.3f64 / 0.05).powi(3) as usize;
    assert!(sphere.evaluations() < vertices / 2 + STEPS_OF_ZEROS * all.len());
}

#[test]
fn both_distances_of_a_good_fit_agree() {
    let fields: [(&str, &dyn Field); 2] = [
        ("torus_12x6_rec", &Torus { major: 5.0, minor: 1.0 }),
        ("ellipsoid_small_rec", &Ellipsoid([1.0, 2.0, 3.0])),
    ];
    for (name, field) in fields {
        let Some(golden) = golden(name) else { continue };
        let i = inspect(&golden.spline, &golden.spline.base, Some(field), &InspectOptions::default());
        let (there, back) = (i.deviation.unwrap(), i.coverage.unwrap());
        assert!(close(back.max_distance, there.max_distance, 0.1), "{name}: {back:?} {}", there.max_distance);
        // The two samplings weigh the few bad patches differently.
        assert!(close(back.rms_distance, there.rms_distance, 0.2), "{name}: {back:?} {}", there.rms_distance);
    }
}

#[test]
fn a_hole_is_a_boundary_and_shows_in_the_distance_back() {
    let spline = without_last_patch(&icosahedron());
    let field = Sphere::at(0.0, 1.0);
    let i = inspect(&spline, &spline.base, Some(&field), &InspectOptions::default());
    assert_eq!((i.seams.interior, i.seams.boundary), (27, 3));
    assert_eq!((i.topology.boundary_loops, i.topology.euler, i.topology.genus), (1, 1, 0));
    assert!(i.deviation.unwrap().max_distance < 1e-4);
    // The chord from the middle of a face of the icosahedron to the middle of its edge: half the angle between the
    // normals of two faces, 20.9°.
    let chord = 2.0 * (20.905_f64.to_radians() / 2.0).sin();
    assert!(close(i.coverage.unwrap().max_distance * i.diagonal, chord, 0.02), "{:?}", i.coverage);
}

#[test]
fn the_closest_point_of_the_surface_beats_every_sample() {
    let Some(golden) = golden("ellipsoid_small_rec") else { return };
    let spline = golden.spline;
    let tree = ClosestPatch::new(&spline);
    let lattice = crate::bernstein::triangle::lattice(12);
    let all: Vec<_> = spline.patches().flat_map(|p| lattice.iter().map(move |c| (p, [c[0], c[1]]))).collect();
    let points: Vec<Point3> = all.iter().map(|(p, uv)| spline.sample(*p, *uv).point).collect();
    for i in 0..200 {
        let p = Point3::from_fn(|a, _| ((i * 37 + a * 101) as f64 * 12.9898).sin() * [1.6, 2.4, 3.4][a]);
        let nearest = tree.nearest(&p).unwrap();
        let brute = points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest.distance <= brute + 1e-12, "{p}: {} {brute}", nearest.distance);
        assert!((spline.sample(nearest.patch, nearest.uv).point - nearest.point).norm() < 1e-13);
    }
    // A point of the surface is its own closest point.
    for (patch, uv) in all.iter().step_by(61) {
        assert!(tree.nearest(&spline.sample(*patch, *uv).point).unwrap().distance < 1e-9);
    }
    assert!(tree.nearest(&Point3::repeat(f64::NAN)).is_none());
}

#[test]
fn area_volume_and_topology_of_sphere_and_torus() {
    let sphere = icosahedron();
    let e = extent(&sphere);
    assert!(close(e.area, 4.0 * PI, 1e-3) && close(e.volume, 4.0 * PI / 3.0, 1e-3), "{e:?}");
    let shifted = extent(&sphere.translated(Vec3::repeat(1e6)));
    assert!(close(shifted.volume, e.volume, 1e-8) && close(shifted.area, e.area, 1e-8));
    let Some(golden) = golden("torus_12x6_rec") else { return };
    let e = extent(&golden.spline);
    assert!(close(e.area, 20.0 * PI * PI, 1e-3) && close(e.volume, 10.0 * PI * PI, 1e-3), "{e:?}");
    let t = topology(&golden.spline.base.mesh);
    assert_eq!((t.euler, t.genus, t.components, t.boundary_loops), (0, 1, 1, 0));
}

#[test]
fn the_same_figures_on_one_and_two_threads() {
    let (spline, field) = (icosahedron(), Sphere::at(0.0, 1.0));
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| inspect(&spline, &spline.base, Some(&field), &coarse()))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn surfaces_far_away_tiny_and_huge_are_measured_alike() {
    let field = |scale: f64, x: f64| Sphere { center: Vec3::new(x, 0.0, 0.0), radius: scale };
    let reference =
        inspect(&icosahedron(), &icosahedron().base, Some(&field(1.0, 0.0)), &InspectOptions::default());
    let reference = (reference.deviation.unwrap().max_distance, reference.coverage.unwrap().max_distance);
    for (scale, x) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e6)] {
        let spline = icosahedron().scaled(scale).translated(Vec3::new(x, 0.0, 0.0));
        let i = inspect(&spline, &spline.base, Some(&field(scale, x)), &InspectOptions::default());
        assert!(close(i.deviation.unwrap().max_distance, reference.0, 1e-5), "{scale} {x}");
        assert!(close(i.coverage.unwrap().max_distance, reference.1, 1e-2), "{scale} {x}");
        assert!(i.seams.max_normal_jump < 1e-8, "{scale} {x}: {:?}", i.seams);
    }
}

#[test]
fn a_field_that_is_not_a_number_gives_infinite_distances_and_no_panic() {
    let spline = icosahedron();
    let i = inspect(&spline, &spline.base, Some(&Nowhere), &coarse());
    let d = i.deviation.unwrap();
    assert_eq!((d.max_distance, d.max_first_order, d.folded), (f64::INFINITY, f64::INFINITY, 20));
    assert!(i.coverage.is_none());
}

#[test]
fn a_net_that_is_not_a_number_is_infinitely_wrong() {
    let mut spline = icosahedron();
    spline.nets[11][0].y = f64::NAN;
    let i = inspect(&spline, &spline.base, Some(&Sphere::at(0.0, 1.0)), &coarse());
    assert_eq!((i.seams.max_gap, i.seams.max_normal_jump), (f64::INFINITY, PI));
    assert_eq!((i.interpolation.max_position_error, i.interpolation.max_normal_error), (f64::INFINITY, PI));
    assert_eq!(
        (i.interpolation.max_curvature_error, i.deviation.unwrap().max_distance),
        (f64::INFINITY, f64::INFINITY)
    );
    // Without an area there is no grid for the way back; searches leave the patch out.
    assert!(i.coverage.is_none());
    let p = icosahedron().sample(PatchId(11), [1.0 / 3.0; 2]).point;
    let nearest = ClosestPatch::new(&spline).nearest(&p).unwrap();
    assert!(nearest.patch != PatchId(11) && nearest.distance > 0.1);
}

#[test]
fn a_surface_without_patches_is_inspected_without_panic() {
    let mesh = crate::mesh::HalfEdgeMesh::from_faces::<[u32; 3]>(0, &[]).unwrap();
    let field = Sphere::at(0.0, 1.0);
    let spline = crate::spline::TriangularSpline::new(
        crate::base::BaseMesh::from_field(&field, mesh, Vec::new()),
        Vec::new(),
        Vec::new(),
    );
    let i = inspect(&spline, &spline.base, Some(&field), &coarse());
    assert_eq!((i.patches, i.coverage, i.extent.area), (0, None, 0.0));
}

#[test]
fn the_table_names_every_figure() {
    let spline = icosahedron();
    let field = Sphere::at(0.0, 1.0);
    let text = inspect(&spline, &spline.base, Some(&field), &coarse()).to_string();
    for word in [
        "20 on 12 vertices",
        "closed, 1 component,",
        "largest gap",
        "self-intersections    0 in 320 triangles",
        "distance to field",
        "distance from field",
    ] {
        assert!(text.contains(word), "{word} in\n{text}");
    }
    let without = inspect(&spline, &spline.base, None, &coarse()).to_string();
    assert!(!without.contains("field"));
}
