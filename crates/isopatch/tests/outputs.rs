//! Written files, read back by programs that share no code with the writers.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::bernstein::triangle::evaluate;
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Vec3};
use isopatch::io::Unit;
use isopatch::io::gltf::{GlbOptions, write_glb};
use isopatch::io::obj::write_obj;
use isopatch::io::ply::write_ply;
use isopatch::io::step::{StepOptions, write_step};
use isopatch::io::stl::write_stl;
use isopatch::io::vtk::{Cells, VtkOptions, write_vtk};
use isopatch::numeric::quadrature::triangle_gauss;
use isopatch::recipes::spline::{Size, SplineRecipe, fit};
use isopatch::spline::TriangularSpline;
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use serde_json::Value;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use support::golden::{flat_triangle, inverted, joined, load, scaled, sphere};
use support::python::{self, Missing, check};
use support::step::{self, Expected};

fn torus() -> Result<TriangularSpline, Missing> {
    Ok(load(&python::test_data("golden/spline/torus_12x6_rec.json")?))
}

/// A folder of its own for each test, under the target folder.
fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("outputs");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn write(name: &str, write: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes);
    let path = file(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {report:#}"))
}

fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{what}: {found}, expected {expected}");
}

/// Volume of the spline's solid by the divergence theorem, exact for degree 7: the integrand has degree 19.
fn volume(surface: &TriangularSpline) -> f64 {
    let rule = triangle_gauss(11);
    let patch = |net: &[Vec3; 36]| -> f64 {
        let at = |([u, v, _], weight): &([f64; 3], f64)| {
            let t = evaluate(7, net, [*u, *v]);
            weight * t.point.dot(&t.du.cross(&t.dv)) / 6.0
        };
        rule.iter().map(at).sum()
    };
    surface.nets.iter().map(patch).sum()
}

fn assert_step(name: &str, surface: &TriangularSpline, solids: u64, shells: u64) -> Result<(), Missing> {
    let path = write(name, |out| write_step(surface, &StepOptions::default(), out).unwrap());
    let expected = Expected {
        solids,
        shells,
        patches: surface.nets.len() as u64,
        seams: surface.curves.len() as u64,
        euler: surface.base.mesh.euler_number(),
        volume: volume(surface),
        kernel_options: &[],
    };
    step::assert_passes(Path::new(&path), &expected)
}

#[test]
fn step_of_a_sphere() {
    check("step_of_a_sphere", || assert_step("sphere.step", &sphere(), 1, 1));
}

#[test]
fn step_of_a_torus() {
    check("step_of_a_torus", || assert_step("torus.step", &torus()?, 1, 1));
}

#[test]
fn step_of_a_sphere_with_a_cavity() {
    check("step_of_a_sphere_with_a_cavity", || {
        let cavity = inverted(&scaled(&sphere(), 0.5, Vec3::new(0.1, 0.2, 0.0)));
        assert_step("nested.step", &joined(&[sphere(), cavity]), 1, 2)
    });
}

#[test]
fn step_of_two_spheres_apart() {
    check("step_of_two_spheres_apart", || {
        let far = scaled(&sphere(), 0.7, Vec3::new(3.0, 0.0, 0.0));
        assert_step("apart.step", &joined(&[sphere(), far]), 2, 2)
    });
}

#[test]
fn step_units_reach_the_reader() {
    check("step_units_reach_the_reader", || {
        let kernel = python::test_data("tools/check_step.py")?;
        for unit in Unit::ALL {
            let options = StepOptions { unit, ..StepOptions::default() };
            let name = format!("sphere_{}.step", unit.symbol());
            let path = write(&name, |out| write_step(&sphere(), &options, out).unwrap());
            let report = python::run(&kernel, &[&path])?;
            // OpenCASCADE converts to millimetres.
            let expected = 4.0 / 3.0 * PI * (1000.0 * unit.metres()).powi(3);
            assert_eq!((&report["solids"], &report["transfer_warnings"]), (&1.into(), &0.into()));
            assert_close(number(&report, "volume"), expected, 1e-3, unit.symbol());
            assert!(number(&report, "max_tol_edge") <= 1e-7 && number(&report, "max_tol_vertex") <= 1e-7);
        }
        Ok(())
    });
}

/// A cylinder that the box cuts at both ends is one open shell; a sphere inside the box beside it is a solid.
#[test]
fn step_of_a_surface_cut_by_a_box() {
    check("step_of_a_surface_cut_by_a_box", || {
        let kernel = python::test_data("tools/check_step.py")?;
        let formula = Formula::parse("(x^2+y^2-1)((x-3)^2+y^2+z^2-1/2)", &Constants::new()).unwrap();
        let bounds = Aabb::new(Vec3::new(-2.0, -2.0, -1.0), Vec3::new(4.0, 2.0, 1.0));
        let recipe = SplineRecipe { bounds: Some(bounds), size: Size::Faces(131), ..Default::default() };
        let surface = fit(&formula, &recipe, &|_| ()).unwrap().surface;
        let border = surface.base.mesh.edges().filter(|e| !surface.base.sides_of(*e).is_empty()).count();
        let path = write("cut.step", |out| write_step(&surface, &StepOptions::default(), out).unwrap());
        let report = python::run(&kernel, &[&path])?;
        for (key, expected) in [("solids", 1), ("shells", 2), ("faces", 3 * 131), ("free_edges", 2 * border)]
        {
            assert_eq!(report[key], expected, "{key} of {report:#}");
        }
        assert_eq!((&report["brepcheck_valid"], &report["transfer_warnings"]), (&true.into(), &0.into()));
        assert!(number(&report, "max_tol_edge") <= 1e-7 && number(&report, "g0_face_face_max") <= 1e-9);
        Ok(())
    });
}

#[test]
fn step_of_an_open_patch_beside_a_solid() {
    check("step_of_an_open_patch_beside_a_solid", || {
        let kernel = python::test_data("tools/check_step.py")?;
        let far = scaled(&flat_triangle(), 1.0, Vec3::new(3.0, 0.0, 0.0));
        let mixed = joined(&[far, sphere()]);
        let path = write("mixed.step", |out| write_step(&mixed, &StepOptions::default(), out).unwrap());
        let report = python::run(&kernel, &[&path])?;
        for (key, expected) in [("solids", 1), ("shells", 2), ("faces", 63), ("free_edges", 6)] {
            assert_eq!(report[key], expected, "{key} of {report:#}");
        }
        assert_eq!((&report["brepcheck_valid"], &report["transfer_warnings"]), (&true.into(), &0.into()));
        Ok(())
    });
}

/// A script beside this test.
fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support").join(name)
}

/// Largest distance of the golden sphere from the unit sphere: 8.6e-5 of its diagonal, 2.95.
const SPHERE_ERROR: f64 = 2.6e-4;
/// Largest error of the golden sphere's normals: 0.128 degrees, in radians.
const SPHERE_NORMAL_ERROR: f64 = 2.3e-3;

#[test]
fn vtk_reads_both_kinds_of_cells() {
    check("vtk_reads_both_kinds_of_cells", || {
        python::interpreter()?;
        let sphere = sphere();
        for (cells, cell_type) in [(Cells::Bezier, 76), (Cells::Lagrange, 69)] {
            let path = write(&format!("sphere_{cell_type}.vtu"), |out| {
                write_vtk(&sphere, &VtkOptions { cells }, out).unwrap();
            });
            let report = python::run(&script("check_vtu.py"), &[&path])?;
            for (key, expected) in
                [("cells", 20), ("points", 12 + 30 * 6 + 20 * 15), ("degree", 7), ("open_edges", 0)]
            {
                assert_eq!(report[key], expected, "{key} of {report:#}");
            }
            assert_eq!(report["cell_types"], serde_json::json!([cell_type]));
            assert!(number(&report, "largest_distance") < SPHERE_ERROR, "{report:#}");
            assert_close(number(&report, "volume"), volume(&sphere), 5e-4, "volume");
            let vertices: Vec<[f64; 3]> = serde_json::from_value(report["vertices"].clone()).unwrap();
            assert!(vertices.iter().zip(&sphere.base.positions).all(|(a, b)| Vec3::from(*a) == *b));
            let inside: Vec<[f64; 3]> = serde_json::from_value(report["inside"].clone()).unwrap();
            for (net, found) in sphere.nets.iter().zip(inside) {
                // VTK's parameters are the barycentric coordinates of corners 1 and 2.
                let expected = evaluate(7, net, [0.3, 0.2]).point;
                assert!((Vec3::from(found) - expected).norm() < 1e-13);
            }
            if cells == Cells::Lagrange {
                assert!(number(&report, "largest_normal_error") < SPHERE_NORMAL_ERROR);
            }
        }
        Ok(())
    });
}

/// Reads a mesh file back: closed, with the volume of the triangles, and with their vertices in order.
fn assert_mesh(name: &str, write_mesh: impl Fn(&Tessellation, &mut Vec<u8>)) -> Result<Value, Missing> {
    python::interpreter()?;
    let mesh = tessellate(&sphere(), &TessellateOptions::default()).unwrap();
    let path = write(name, |out| write_mesh(&mesh, out));
    let report = python::run(&script("check_mesh.py"), &[&path])?;
    assert_eq!((&report["faces"], &report["euler"]), (&(20 * 64).into(), &2.into()), "{report:#}");
    assert_eq!(report["watertight"], true, "{report:#}");
    assert_eq!(report["winding_consistent"], true, "{report:#}");
    Ok(report)
}

/// The first vertices as they were read.
fn first_vertices(report: &Value) -> Vec<Vec3> {
    serde_json::from_value::<Vec<[f64; 3]>>(report["first"].clone())
        .unwrap()
        .into_iter()
        .map(Vec3::from)
        .collect()
}

/// Volume of the triangles that the mesh files hold.
fn mesh_volume() -> f64 {
    tessellate(&sphere(), &TessellateOptions::default()).unwrap().signed_volume()
}

#[test]
fn obj_and_ply_keep_every_digit() {
    check("obj_and_ply_keep_every_digit", || {
        let obj = assert_mesh("sphere.obj", |mesh, out| write_obj(mesh, out).unwrap())?;
        let ply = assert_mesh("sphere.ply", |mesh, out| write_ply(mesh, out).unwrap())?;
        for report in [obj, ply] {
            assert_eq!(report["vertices"], 642);
            assert_eq!(first_vertices(&report), sphere().base.positions);
            assert_close(number(&report, "volume"), mesh_volume(), 1e-12, "volume");
            assert_eq!(report["stored_normals"], true);
            assert!(number(&report, "largest_normal_error") < SPHERE_NORMAL_ERROR, "{report:#}");
        }
        Ok(())
    });
}

#[test]
fn glb_is_in_metres_with_y_up() {
    check("glb_is_in_metres_with_y_up", || {
        let report = assert_mesh("sphere.glb", |mesh, out| {
            write_glb(mesh, &GlbOptions { unit: Unit::Cm }, out).unwrap();
        })?;
        assert_eq!((&report["vertices"], &report["stored_normals"]), (&642.into(), &true.into()));
        for (found, p) in first_vertices(&report).iter().zip(&sphere().base.positions) {
            assert!((found - 0.01 * Vec3::new(p.x, p.z, -p.y)).norm() < 1e-9, "{found} of {p}");
        }
        assert_close(number(&report, "volume"), 1e-6 * mesh_volume(), 1e-6, "volume");
        assert!(number(&report, "largest_normal_error") < SPHERE_NORMAL_ERROR, "{report:#}");
        Ok(())
    });
}

#[test]
fn stl_is_closed_after_merging() {
    check("stl_is_closed_after_merging", || {
        let report = assert_mesh("sphere.stl", |mesh, out| write_stl(mesh, out).unwrap())?;
        assert_close(number(&report, "volume"), mesh_volume(), 1e-6, "volume");
        Ok(())
    });
}

#[test]
fn bytes_do_not_depend_on_the_threads() {
    let surface = joined(&[sphere(), scaled(&sphere(), 0.5, Vec3::new(4.0, 0.0, 0.0))]);
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut bytes = vec![Vec::new(); 4];
            write_step(&surface, &StepOptions::default(), &mut bytes[0]).unwrap();
            write_vtk(&surface, &VtkOptions { cells: Cells::Lagrange }, &mut bytes[1]).unwrap();
            let mesh = tessellate(&surface, &TessellateOptions { resolution: 5 }).unwrap();
            write_obj(&mesh, &mut bytes[2]).unwrap();
            write_glb(&mesh, &GlbOptions::default(), &mut bytes[3]).unwrap();
            bytes
        })
    };
    assert_eq!(all(1), all(3));
}
