//! The G1 spline through the vertices of a triangle mesh, and STEP files of it.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::base::{BaseMesh, EdgeFeature};
use isopatch::geom::{Mat3, Point3, Vec3};
use isopatch::inspect::{InspectOptions, Inspection, inspect};
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::io::step::{StepOptions, write_step};
use isopatch::mesh::{EdgeId, HalfEdgeMesh};
use isopatch::network::{CurveOptions, QuarticCurve, interpolate_edges};
use isopatch::recipes::mesh_spline::{FittedMeshSpline, MeshSplineError, MeshSplineRecipe, fit};
use isopatch::spline::{TriangularSpline, fill, normal_deviations};
use isopatch::surface::{PatchId, Surface};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fs::File;
use std::io::{BufWriter, Write};
use support::meshes::{grid, icosphere, torus_distance};
use support::python::{self, Missing, check};
use support::step::{self, Expected};

fn quiet(_: &str) {}

/// A mesh of the test data.
fn given(name: &str) -> Result<PolygonMesh, Missing> {
    Ok(read_mesh(&python::test_data(&format!("meshes/{name}"))?).unwrap())
}

fn polygons((positions, faces): (Vec<Point3>, Vec<[u32; 3]>)) -> PolygonMesh {
    PolygonMesh { positions, faces: faces.iter().map(|f| f.to_vec()).collect(), normals: None }
}

fn with_creases(degrees: f64) -> MeshSplineRecipe {
    MeshSplineRecipe { crease_angle: Some(degrees.to_radians()), ..MeshSplineRecipe::default() }
}

/// Seams without a gap, G1 where they say so; vertices of the mesh exactly; no folds.
fn sound(name: &str, mesh: &PolygonMesh, fitted: &FittedMeshSpline) -> Inspection {
    let surface = &fitted.surface;
    let options = InspectOptions { intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect(surface, &surface.base, None, &options);
    let deviation = fitted.normal_deviations.iter().fold(0.0, |a: f64, b| a.max(*b));
    println!(
        "{name}: {} faces, jump {:.1e}, normals off by {:.0} deg, {} sharp edges, {:?}",
        surface.nets.len(),
        found.seams.max_normal_jump,
        deviation.to_degrees(),
        fitted.sharp_edges,
        fitted.repairs.iter().map(|r| r.what.as_str()).collect::<Vec<_>>(),
    );
    assert!(found.seams.max_normal_jump <= 1e-9, "{name}: {found}");
    assert_eq!((found.seams.max_gap, found.interpolation.max_position_error), (0.0, 0.0), "{name}: {found}");
    assert!(deviation < FRAC_PI_2, "{name}: {deviation}");
    assert_eq!(fitted.face_source.len(), surface.nets.len(), "{name}");
    for (vertex, position) in fitted.vertex_source.iter().zip(&surface.base.positions) {
        assert_eq!(*position, mesh.positions[*vertex as usize], "{name}");
    }
    found
}

/// The kernel looks at every edge, at both ends and three points between them.
const KERNEL_OPTIONS: &[&str] = &["--edge-samples", "5"];

/// The STEP file of a closed mesh of one component passes the rule.
fn step_passes(name: &str, recipe: &MeshSplineRecipe) -> Result<FittedMeshSpline, Missing> {
    python::interpreter()?;
    let mesh = given(name)?;
    let fitted = fit(&mesh, recipe, &quiet).unwrap_or_else(|e| panic!("{name}: {e}"));
    let found = sound(name, &mesh, &fitted);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{name}.step"));
    let mut out = BufWriter::new(File::create(&path).unwrap());
    write_step(&fitted.surface, &StepOptions::default(), &mut out).unwrap();
    out.flush().unwrap();
    let expected = Expected {
        solids: 1,
        shells: 1,
        patches: fitted.surface.nets.len() as u64,
        seams: found.topology.edges as u64,
        euler: found.topology.euler,
        volume: found.extent.volume,
        kernel_options: KERNEL_OPTIONS,
    };
    step::assert_passes(&path, &expected)?;
    Ok(fitted)
}

fn smooth_step_passes(name: &str) -> Result<(), Missing> {
    let fitted = step_passes(name, &MeshSplineRecipe::default())?;
    assert_eq!(fitted.sharp_edges, 0, "{name}");
    Ok(())
}

#[test]
fn the_step_file_of_the_eight_passes() {
    check("the_step_file_of_the_eight_passes", || smooth_step_passes("cgal_eight.off"));
}

#[test]
#[ignore = "minutes of checks: 3674 patches"]
fn the_step_file_of_the_bunny_passes() {
    check("the_step_file_of_the_bunny_passes", || smooth_step_passes("npm_bunny.off"));
}

#[test]
#[ignore = "minutes of checks: 6400 patches"]
fn the_step_file_of_the_knot_passes() {
    check("the_step_file_of_the_knot_passes", || smooth_step_passes("cgal_knot1.off"));
}

const MESHES: [&str; 25] = [
    "cgal_blobby_3cc.off",
    "cgal_cow.off",
    "cgal_cross_quad.off",
    "cgal_eight.off",
    "cgal_ellipsoid.off",
    "cgal_fandisk.off",
    "cgal_hand.off",
    "cgal_head.off",
    "cgal_icosahedron.off",
    "cgal_knot1.off",
    "cgal_nefertiti.off",
    "cgal_pig.off",
    "cgal_rotor.off",
    "cgal_sphere966.off",
    "cgal_torus_quad.off",
    "conway_ambo_dodeca.off",
    "conway_dgC_snub_cube.off",
    "conway_gC_pentagonal_icositetrahedron.off",
    "conway_prism5.off",
    "conway_trunc_icosahedron_soccer.off",
    "geomview_dodec.off",
    "npm_bunny.off",
    "npm_teapot.off",
    "pyvista_airplane.off",
    "pyvista_ant.off",
];

/// Meshes on which the search for what can be smooth takes seconds.
const SLOW: [&str; 3] = ["cgal_cow.off", "cgal_fandisk.off", "pyvista_ant.off"];

fn every_mesh_is_sound(is_wanted: impl Fn(&str) -> bool) -> Result<(), Missing> {
    for name in MESHES.into_iter().filter(|name| is_wanted(name)) {
        let mesh = given(name)?;
        let fitted =
            fit(&mesh, &MeshSplineRecipe::default(), &quiet).unwrap_or_else(|e| panic!("{name}: {e}"));
        sound(name, &mesh, &fitted);
    }
    Ok(())
}

#[test]
fn every_mesh_has_a_sound_surface() {
    check("every_mesh_has_a_sound_surface", || every_mesh_is_sound(|name| !SLOW.contains(&name)));
}

#[test]
fn every_hard_mesh_has_a_sound_surface() {
    check("every_hard_mesh_has_a_sound_surface", || every_mesh_is_sound(|name| SLOW.contains(&name)));
}

#[test]
fn smooth_meshes_stay_smooth() {
    check("smooth_meshes_stay_smooth", || {
        for name in ["cgal_eight.off", "npm_bunny.off", "cgal_knot1.off", "cgal_blobby_3cc.off"] {
            let fitted = fit(&given(name)?, &MeshSplineRecipe::default(), &quiet).unwrap();
            assert_eq!(fitted.sharp_edges, 0, "{name}: {:?}", fitted.repairs);
            assert!(fitted.surface.base.features.iter().all(|f| *f != EdgeFeature::Sharp));
        }
        Ok(())
    });
}

#[test]
fn broken_meshes_are_repaired_or_refused() {
    check("broken_meshes_are_repaired_or_refused", || {
        for name in
            ["nasty_cgal_hole.off", "nasty_degenerate.off", "nasty_holes25.off", "nasty_flipped20pct.off"]
        {
            let mesh = given(name)?;
            let fitted = fit(&mesh, &MeshSplineRecipe::default(), &quiet);
            match fitted {
                Ok(fitted) => drop(sound(name, &mesh, &fitted)),
                Err(error) => println!("{name}: {error}"),
            }
        }
        Ok(())
    });
}

#[test]
fn a_vertex_that_is_no_point_is_refused() {
    let mut mesh = cube(1);
    mesh.positions[3].x = f64::NAN;
    let error = fit(&mesh, &MeshSplineRecipe::default(), &quiet).unwrap_err();
    assert!(matches!(error, MeshSplineError::Mesh(_)), "{error}");
}

#[test]
fn without_sharpenings_a_fold_is_an_error_that_names_faces() {
    check("without_sharpenings_a_fold_is_an_error_that_names_faces", || {
        let recipe = MeshSplineRecipe { sharpenings: 0, ..MeshSplineRecipe::default() };
        match fit(&given("cgal_hand.off")?, &recipe, &quiet) {
            Err(error @ MeshSplineError::Folded { .. }) => {
                assert!(error.to_string().contains("patches fold over: face "), "{error}");
            }
            other => panic!("{:?}", other.map(|fitted| fitted.repairs)),
        }
        Ok(())
    });
}

/// A cube of unit edges; each side is cut into `n` × `n` squares, and these into triangles.
fn cube(n: u32) -> PolygonMesh {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = Point3::zeros();
                    p[axis] = side;
                    p[(axis + 1) % 3] = f64::from(i) / f64::from(n);
                    p[(axis + 2) % 3] = f64::from(j) / f64::from(n);
                    positions.push(p);
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let at = |i: u32, j: u32| first + i * (n + 1) + j;
                    let mut square = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    if side == 0.0 {
                        square.reverse();
                    }
                    faces.push(square);
                }
            }
        }
    }
    PolygonMesh { positions, faces, normals: None }
}

#[test]
fn a_cube_with_creases_is_a_cube() {
    let mesh = cube(3);
    let fitted = fit(&mesh, &with_creases(45.0), &quiet).unwrap();
    let found = sound("cube", &mesh, &fitted);
    assert_eq!(fitted.sharp_edges, 12 * 3);
    assert!((found.extent.volume - 1.0).abs() < 1e-12 && (found.extent.area - 6.0).abs() < 1e-12, "{found}");
    assert!(fitted.normal_deviations.iter().all(|d| *d < 1e-9));
}

#[test]
fn a_cylinder_with_creases_has_flat_ends_and_round_rims() {
    const N: u32 = 16;
    let turn = |i: u32| TAU * f64::from(i) / f64::from(N);
    let mut positions = Vec::new();
    for z in [0.0, 1.0] {
        positions.extend((0..N).map(|i| Point3::new(turn(i).cos(), turn(i).sin(), z)));
    }
    positions.extend([Point3::zeros(), Point3::z()]);
    let mut faces = Vec::new();
    for i in 0..N {
        let j = (i + 1) % N;
        faces.push(vec![i, j, N + j, N + i]);
        faces.push(vec![j, i, 2 * N]);
        faces.push(vec![N + i, N + j, 2 * N + 1]);
    }
    let mesh = PolygonMesh { positions, faces, normals: None };
    let fitted = fit(&mesh, &with_creases(45.0), &quiet).unwrap();
    let found = sound("cylinder", &mesh, &fitted);
    assert_eq!(fitted.sharp_edges, 2 * N as usize);
    assert!((found.extent.volume - 0.5 * TAU).abs() < 2e-3, "{found}");
    let distance = |p: &Point3| (p.x.hypot(p.y) - 1.0).abs().min(p.z.abs()).min((p.z - 1.0).abs());
    assert!(largest(&fitted.surface, distance) < 1e-3);
}

/// Largest distance of samples of the patches.
fn largest(surface: &TriangularSpline, distance: impl Fn(&Point3) -> f64) -> f64 {
    let uv = [[1.0 / 3.0, 1.0 / 3.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [0.6, 0.2], [0.2, 0.6], [0.2, 0.2]];
    let patches = (0..surface.nets.len() as u32).map(PatchId);
    let samples = patches.flat_map(|p| uv.map(|uv| surface.sample(p, uv).point));
    samples.map(|p| distance(&p)).fold(0.0, f64::max)
}

/// The torus with radii 1 and 0.4, uneven in both directions.
fn torus_mesh(n: usize) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let turn = |i: usize, n: usize| {
        let t = TAU * i as f64 / n as f64;
        t + 0.1 * (2.0 * t).sin()
    };
    grid([2 * n, n], [true, true], |i, j| {
        let (u, v) = (turn(i, 2 * n), turn(j, n));
        Point3::new(u.cos(), u.sin(), 0.0) + 0.4 * Vec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin())
    })
}

/// Normal and curvature tensor of that torus.
fn torus_data(p: &Point3) -> (Vec3, Mat3) {
    let axis = Vec3::new(p.x, p.y, 0.0).normalize();
    let n = (p - axis) / 0.4;
    let around = Vec3::new(-axis.y, axis.x, 0.0);
    let tube = n.cross(&around);
    let k = -axis.dot(&n) / Vec3::new(p.x, p.y, 0.0).norm();
    (n, k * around * around.transpose() - tube * tube.transpose() / 0.4)
}

#[test]
fn estimated_data_converge_and_exact_data_more_so() {
    let mut errors = Vec::new();
    for n in [12, 24] {
        let (positions, faces) = torus_mesh(n);
        let turned: Vec<[u32; 3]> = faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        let outward = (positions[faces[0][1] as usize] - positions[faces[0][0] as usize])
            .cross(&(positions[faces[0][2] as usize] - positions[faces[0][0] as usize]))
            .dot(&torus_data(&positions[faces[0][0] as usize]).0)
            > 0.0;
        let faces = if outward { faces } else { turned };
        let fitted =
            fit(&polygons((positions.clone(), faces.clone())), &MeshSplineRecipe::default(), &quiet).unwrap();
        let (normals, tensors) = positions.iter().map(torus_data).unzip();
        let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
        let base = BaseMesh::from_parts(mesh, positions, normals, tensors);
        let edges: Vec<EdgeId> = base.mesh.edges().collect();
        let curves: Vec<QuarticCurve> = interpolate_edges(&base, &edges, &CurveOptions::default())
            .into_iter()
            .collect::<Result<_, _>>()
            .unwrap();
        let exact = fill(base, &curves).unwrap();
        assert!(normal_deviations(&exact, 10).iter().all(|d| *d < FRAC_PI_2));
        errors.push([&fitted.surface, &exact].map(|s| largest(s, torus_distance)));
    }
    println!("torus: {errors:?}");
    let [[coarse, coarse_exact], [fine, fine_exact]] = [errors[0], errors[1]];
    assert!(fine < 0.35 * coarse && fine < 4e-3, "{errors:?}");
    assert!(fine_exact < 0.1 * coarse_exact && fine_exact < 0.1 * fine, "{errors:?}");
}

#[test]
fn the_sphere_is_almost_exact() {
    let mut errors = Vec::new();
    for levels in [1, 2, 3] {
        let mesh = polygons(icosphere(levels));
        let fitted = fit(&mesh, &MeshSplineRecipe::default(), &quiet).unwrap();
        errors.push(largest(&fitted.surface, |p| (p.norm() - 1.0).abs()));
    }
    println!("sphere: {errors:?}");
    assert!(errors[0] < 1e-2 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1], "{errors:?}");
}

#[test]
fn the_threads_do_not_matter() {
    let mesh = polygons(torus_mesh(10));
    let nets = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&mesh, &MeshSplineRecipe::default(), &quiet).unwrap().surface.nets)
    };
    // No assert_eq: it would print all of them.
    assert!(nets(1) == nets(2));
}
