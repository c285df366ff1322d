use super::test_fields::*;
use super::*;
use crate::field::Field;
use crate::geom::{Aabb, Points, Vec3};

fn with_faces(faces: usize) -> BaseOptions {
    BaseOptions { faces: Some(faces), ..BaseOptions::default() }
}

fn assert_on_surface(field: &dyn Field, base: &BaseMesh) {
    let diagonal = base.diagonal();
    for p in &base.positions {
        let (f, g) = field.gradient(*p);
        // Far from the origin the floats are too far apart for the first part alone.
        let reach = 2e-13 * diagonal + 2.0 * f64::EPSILON * p.amax();
        assert!(f.abs() <= reach * g.norm() || f.abs() <= field.rounding_bound(*p), "{f:e} at {p:?}");
    }
}

fn failure(field: &dyn Field, bounds: &Aabb) -> BaseError {
    build(field, bounds, &with_faces(200)).unwrap_err()
}

#[test]
fn paper_surfaces_have_the_right_topology_and_count_and_good_shape() {
    for Example { name, field, bounds, faces, euler } in paper_surfaces() {
        let outcome = build(&field, &bounds, &with_faces(faces)).unwrap();
        let quality = quality(&outcome.base);
        let mesh = &outcome.base.mesh;
        assert_eq!(
            (mesh.face_count(), mesh.euler_number(), mesh.component_count()),
            (faces, euler, 1),
            "{name}"
        );
        assert!(mesh.is_closed());
        assert_eq!(outcome.repairs, [], "{name}");
        assert_eq!(outcome.violations, [], "{name}");
        assert!(quality.smallest_angle > 15.0 && quality.corners[1] < 140.0, "{name}");
        assert_on_surface(&field, &outcome.base);
    }
}

#[test]
fn faces_look_outward_also_where_the_inside_is_outside() {
    let volume = |base: &BaseMesh| -> f64 {
        let corner = |v: crate::mesh::VertexId| base.positions[v.index()];
        base.mesh
            .faces()
            .map(|f| base.mesh.triangle(f).map(corner))
            .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
            .sum()
    };
    for sign in [1.0, -1.0] {
        let field = if sign < 0.0 { unit_sphere().negated() } else { unit_sphere() };
        assert_eq!(outside_is_negative(&field, &cube(1.3)), Ok(sign < 0.0));
        let base = build(&field, &cube(1.3), &with_faces(200)).unwrap().base;
        assert!((sign * volume(&base) - 4.0).abs() < 0.1, "{}", volume(&base));
    }
}

#[test]
fn components_are_kept() {
    let bounds = Aabb::new(Vec3::repeat(-1.5), Vec3::new(1.5, 1.5, 4.5));
    let two = build(&field(TWO_SPHERES), &bounds, &with_faces(300)).unwrap().base;
    assert_eq!((two.mesh.component_count(), two.mesh.euler_number()), (2, 4));
    let nested = build(&field(NESTED_SPHERES), &cube(1.6), &with_faces(400)).unwrap().base;
    assert_eq!((nested.mesh.component_count(), nested.mesh.euler_number()), (2, 4));
    assert!(validity(&nested, &ValidityLimits::default()).is_empty());
}

#[test]
fn boxes_are_found_for_spheres_of_any_size_and_place() {
    for (center, radius) in [
        (Vec3::zeros(), 1.0),
        (Vec3::zeros(), 1e-6),
        (Vec3::zeros(), 1e6),
        (Vec3::new(1e6, -1e6, 1e6), 1.0),
        (Vec3::new(0.3, 0.2, -0.1), 1e-6),
    ] {
        let field = sphere_at(center, radius);
        let found = find_box(&field).unwrap();
        let r = Vec3::repeat(radius);
        assert!(found.contains(&(center - r)) && found.contains(&(center + r)));
        assert!(found.size().max() < 2.5 * radius, "{found:?}");
        let base = build(&field, &found, &with_faces(200)).unwrap().base;
        assert_eq!((base.mesh.face_count(), base.mesh.euler_number()), (200, 2));
        assert_on_surface(&field, &base);
    }
}

#[test]
fn boxes_are_found_for_the_paper_surfaces() {
    for Example { name, field, bounds, .. } in paper_surfaces() {
        let found = find_box(&field).unwrap();
        assert!(found.size().max() < 2.0 * bounds.size().max(), "{name}: {found:?}");
    }
}

#[test]
fn unbounded_surfaces_have_no_box() {
    assert_eq!(find_box(&field(PLANE)), Err(BaseError::Unbounded));
    assert_eq!(find_box(&field(CYLINDER)), Err(BaseError::Unbounded));
    assert_eq!(find_box(&field(NO_ZERO)), Err(BaseError::NoSurface { negative: false, proven: true }));
}

#[test]
fn a_generous_box_costs_no_resolution() {
    let narrow = build(&unit_sphere(), &cube(1.1), &with_faces(200)).unwrap().base;
    let wide = build(&unit_sphere(), &cube(1e4), &with_faces(200)).unwrap().base;
    assert!(quality(&wide).smallest_angle > 0.8 * quality(&narrow).smallest_angle);
}

#[test]
fn bad_boxes_are_named() {
    let bounds = |min: [f64; 3], max: [f64; 3]| Aabb::new(min.into(), max.into());
    let of = |b: Aabb| failure(&unit_sphere(), &b);
    let (min, max) = (2.0, -2.0);
    assert_eq!(of(bounds([-2.0, 2.0, -2.0], [2.0, -2.0, 2.0])), BaseError::ReversedBox { axis: 1, min, max });
    assert_eq!(of(bounds([-2.0; 3], [2.0, 2.0, -2.0])), BaseError::FlatBox { axis: 2, min: -2.0, max: -2.0 });
    assert_eq!(of(bounds([f64::NAN, 0.0, 0.0], [1.0; 3])), BaseError::NonFiniteBox { axis: 0 });
    assert_eq!(of(bounds([0.0; 3], [f64::INFINITY, 1.0, 1.0])), BaseError::NonFiniteBox { axis: 0 });
}

#[test]
fn fields_without_a_closed_surface_are_named() {
    let no_surface = BaseError::NoSurface { negative: false, proven: true };
    assert_eq!(failure(&field(NO_ZERO), &cube(2.0)), no_surface);
    assert_eq!(failure(&field(NAN), &cube(2.0)), BaseError::Undefined { share: 1.0, at: None });
    assert_eq!(failure(&field(CONSTANT), &cube(2.0)), BaseError::ConstantField { value: 0.0 });
    let closed = |field: &dyn Field, bounds: &Aabb| {
        let options = SeedOptions { open: false, ..SeedOptions::default() };
        seed_mesh(field, bounds, None, &options).unwrap_err()
    };
    match closed(&field(CYLINDER), &cube(2.0)) {
        BaseError::SurfaceLeavesBox { side, .. } => assert_eq!(side.axis, 2),
        other => panic!("{other}"),
    }
    match closed(&unit_sphere(), &Aabb::new(Vec3::repeat(-2.0), Vec3::new(0.9, 2.0, 2.0))) {
        BaseError::SurfaceLeavesBox { side, at } => {
            assert_eq!(side, BoxSide { axis: 0, upper: true });
            assert!((at.x - 0.9).abs() < 1e-9);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_pole_is_no_surface() {
    let error = failure(&field(POLE), &cube(2.0));
    assert!(matches!(error, BaseError::NotOnSurface { .. }), "{error}");
}

#[test]
fn singular_points_are_found() {
    // A degenerate singular point is only found to half of the digits.
    let singular = |field: &dyn Field, bounds: &Aabb, at: Vec3| match failure(field, bounds) {
        BaseError::Singular { at: found } => assert!((found - at).norm() < 1e-4, "{found:?}"),
        other => panic!("{other}"),
    };
    singular(&field(LEMNISCATE), &cube(1.5), Vec3::zeros());
    let bounds = Aabb::new(Vec3::repeat(-1.5), Vec3::new(1.5, 1.5, 3.5));
    singular(&field(TOUCHING_SPHERES), &bounds, Vec3::z());
}

#[test]
fn face_counts_are_exact_or_refused() {
    for faces in [100, 102, 500] {
        let base = build(&unit_sphere(), &cube(1.3), &with_faces(faces)).unwrap().base;
        assert_eq!(base.mesh.face_count(), faces);
    }
    let odd = build(&unit_sphere(), &cube(1.3), &with_faces(101)).unwrap();
    assert_eq!((odd.base.mesh.face_count(), odd.repairs.len()), (102, 1));
    let flat = Aabb::new(Vec3::new(-6.4, -6.4, -1.4), Vec3::new(6.4, 6.4, 1.4));
    for faces in [0, 2, 8] {
        match build(&field(TORUS), &flat, &with_faces(faces)).unwrap_err() {
            BaseError::TooFewFaces { asked, least } => {
                assert_eq!(asked, faces);
                assert!((14..200).contains(&least), "{least}");
                assert!(build(&field(TORUS), &flat, &with_faces(least)).is_ok());
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn the_automatic_count_respects_the_curvature() {
    let options = BaseOptions::default();
    let base = build(&unit_sphere(), &cube(1.3), &options).unwrap().base;
    assert!((20..60).contains(&base.mesh.face_count()), "{}", base.mesh.face_count());
    let bounds = cube(1.2);
    let outcome = build(&field(DODECA), &bounds, &options).unwrap();
    assert_eq!(outcome.violations, []);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            build(&field(DOUBLE_TORUS), &paper_surfaces()[2].bounds, &with_faces(600)).unwrap().base
        })
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one.positions, two.positions);
    assert_eq!(one.mesh, two.mesh);
}

#[test]
fn projected_points_arrive_and_failures_are_counted() {
    let field = unit_sphere();
    let mut points: Points = (0..5000)
        .map(|i| Vec3::new((i as f64).sin(), (1.7 * i as f64).cos(), 0.1 + 1e-4 * i as f64))
        .collect();
    points.set(17, Vec3::zeros());
    let report = project_points(&field, &mut points, 3.5, &ProjectOptions::default());
    assert_eq!(report.failures, [17]);
    assert!((0..points.len()).all(|i| i == 17 || (points.get(i).norm() - 1.0).abs() < 4e-16));
    assert!(report.evaluations < 8 * points.len());
}
