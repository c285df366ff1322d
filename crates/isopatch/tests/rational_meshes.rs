//! Rational patches through the vertices of meshes, and the files that hold them.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::geom::Point3;
use isopatch::inspect::{InspectOptions, inspect_rational};
use isopatch::io::native::{NativeModel, NativeSurface, Provenance, read_native};
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::io::step::{StepOptions, write_step};
use isopatch::io::vtk::{Cells, VtkOptions, write_vtk};
use isopatch::rational::RationalSurface;
use isopatch::recipes::rational::{FittedRational, RationalRecipe, fit};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{TessellateOptions, tessellate};
use std::path::Path;
use support::meshes::{icosphere, torus_distance};
use support::python::{self, Missing, check};

fn quiet(_: &str) {}

fn polygons((positions, faces): (Vec<Point3>, Vec<[u32; 3]>)) -> PolygonMesh {
    PolygonMesh { positions, faces: faces.iter().map(|f| f.to_vec()).collect(), normals: None }
}

fn sphere(levels: usize) -> FittedRational {
    let mut mesh = polygons(icosphere(levels));
    mesh.normals = Some(mesh.positions.clone());
    fit(&mesh, &RationalRecipe::default(), &quiet).unwrap()
}

/// Without a gap, G1 to rounding where it says so, no fold.
fn assert_sound(name: &str, fitted: &FittedRational) {
    let options = InspectOptions { lattice: 10, intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect_rational(&fitted.surface, None, &options);
    println!(
        "{name}: {} patches, jump {:.1e}, {} sharp edges, {} folded, {} tips, {:?}",
        found.common.patches,
        found.common.seams.max_normal_jump,
        fitted.sharp_edges,
        found.folded.len(),
        found.singular_vertices,
        fitted.repairs.iter().map(|r| r.what.as_str()).collect::<Vec<_>>(),
    );
    assert_eq!(found.common.seams.max_gap, 0.0, "{name}");
    let jump = found.common.seams.max_normal_jump;
    assert!(jump <= 2e-11, "{name}: {jump}");
    assert_eq!(found.common.interpolation.max_position_error, 0.0, "{name}");
    let normal_error = found.common.interpolation.max_normal_error;
    assert!(normal_error <= 1e-9, "{name}: {normal_error}");
    assert!(fitted.folded.is_empty() && found.folded.is_empty(), "{name}: {:?}", found.folded);
}

#[test]
fn a_sphere_is_smooth_and_close() {
    let fitted = sphere(1);
    assert_sound("sphere", &fitted);
    assert_eq!((fitted.sharp_edges, fitted.surface.patch_count()), (0, 80));
    for patch in fitted.surface.patches() {
        let p = fitted.surface.sample(patch, [0.3, 0.4]);
        assert!((p.point.norm() - 1.0).abs() < 1e-3 && p.normal.dot(&p.point) > 0.99);
    }
}

fn native(surface: &RationalSurface) -> Vec<u8> {
    let surface = NativeSurface::Rational(Box::new(surface.clone()));
    let mut bytes = Vec::new();
    NativeModel { surface, provenance: Provenance::default() }.write(&mut bytes).unwrap();
    bytes
}

/// The native format gives back every bit; any byte that is changed is found.
#[test]
fn the_native_round_trip_is_exact() {
    let fitted = sphere(0);
    let bytes = native(&fitted.surface);
    let back = read_native(&mut &bytes[..]).unwrap();
    assert_eq!(back.rational().unwrap(), &fitted.surface);
    assert_eq!(native(back.rational().unwrap()), bytes);
    for i in (0..bytes.len()).step_by(97) {
        let mut broken = bytes.clone();
        broken[i] ^= 0x10;
        let read = read_native(&mut &broken[..]);
        // A tag that is not known any more leaves its section out.
        assert!(read.is_err(), "byte {i}");
        assert!(read_native(&mut &bytes[..i]).is_err());
    }
}

#[test]
fn tessellations_are_closed_and_on_the_surface() {
    let fitted = sphere(1);
    let mesh = tessellate(&fitted.surface, &TessellateOptions { resolution: 4 }).unwrap();
    assert_eq!(mesh.positions.len(), 10 * 16 * 4 + 2);
    assert!(mesh.positions.iter().all(|p| (p.norm() - 1.0).abs() < 1e-3));
    assert!((mesh.signed_volume() - 4.18).abs() < 0.1);
}

/// Quadrilateral cells with weights, four a patch.
#[test]
fn vtk_cells_have_weights() {
    let fitted = sphere(0);
    let mut bytes = Vec::new();
    write_vtk(&fitted.surface, &VtkOptions::default(), &mut bytes).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("RationalWeights=\"RationalWeights\"") && text.contains("NumberOfCells=\"80\""));
    // Three pieces of degree (5, 6) and one of (6, 6).
    assert!(text.contains(&format!("NumberOfPoints=\"{}\"", 20 * (3 * 6 * 7 + 7 * 7))));
    let lagrange = VtkOptions { cells: Cells::Lagrange };
    assert!(write_vtk(&fitted.surface, &lagrange, &mut Vec::new()).is_err());
}

fn step_report(name: &str, surface: &RationalSurface) -> Result<serde_json::Value, Missing> {
    let kernel = python::test_data("tools/check_step.py")?;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rational");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    let mut bytes = Vec::new();
    write_step(surface, &StepOptions::default(), &mut bytes).unwrap();
    std::fs::write(&path, bytes).unwrap();
    python::run(&kernel, &[path.to_str().unwrap()])
}

/// OpenCASCADE reads a closed surface as one valid solid without healing.
#[test]
fn step_is_a_valid_solid() {
    check("step_is_a_valid_solid", || {
        let report = step_report("sphere.step", &sphere(0).surface)?;
        for (key, expected) in [
            ("solids", 1),
            ("shells", 1),
            ("faces", 80),
            ("free_edges", 0),
            ("nonmanifold_edges", 0),
            ("transfer_fails", 0),
            ("transfer_warnings", 0),
            ("euler_V-E+F", 2),
        ] {
            assert_eq!(report[key], expected, "{key}: {report:#}");
        }
        assert_eq!((&report["brepcheck_valid"], &report["ok_closed_solid"]), (&true.into(), &true.into()));
        let number = |key: &str| report[key].as_f64().unwrap();
        assert!(number("max_tol_edge") <= 1e-7 && number("g0_face_face_max") < 1e-12);
        assert!(number("g1_max_deg") < 1e-3, "{report:#}");
        Ok(())
    });
}

/// The closed meshes of the test data.
#[test]
fn every_mesh_has_a_sound_surface() {
    check("every_mesh_has_a_sound_surface", || {
        let folder = python::test_data("meshes/MANIFEST.tsv")?.parent().unwrap().to_owned();
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.ends_with(".off") && !name.starts_with("nasty_"))
            .collect();
        names.sort();
        assert!(names.len() > 20);
        for name in names {
            let mesh = read_mesh(&python::test_data(&format!("meshes/{name}"))?).unwrap();
            assert_sound(&name, &fit(&mesh, &RationalRecipe::default(), &quiet).unwrap());
        }
        Ok(())
    });
}

/// A box with sharp edges keeps its planes.
#[test]
fn creases_stay_sharp() {
    let p = |i: u32| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5u32]];
    let mesh = PolygonMesh {
        positions: (0..8).map(p).collect(),
        faces: faces.iter().map(|f| f.to_vec()).collect(),
        normals: None,
    };
    let recipe = RationalRecipe { crease_angle: Some(0.5), ..RationalRecipe::default() };
    let fitted = fit(&mesh, &recipe, &quiet).unwrap();
    assert_sound("box", &fitted);
    assert_eq!(fitted.sharp_edges, 12);
    for patch in fitted.surface.patches() {
        let sample = fitted.surface.sample(patch, [0.3, 0.3]);
        assert!((sample.normal.amax() - 1.0).abs() < 1e-12, "{patch:?}");
    }
}

#[test]
fn a_torus_from_estimated_normals() {
    let torus = support::meshes::torus([16, 8]);
    let faces = torus.mesh().faces().map(|f| torus.mesh().triangle(f).map(|v| v.0)).collect();
    let mesh = polygons((torus.positions().to_vec(), faces));
    let fitted = fit(&mesh, &RationalRecipe::default(), &quiet).unwrap();
    assert_sound("torus", &fitted);
    let distance = |p: PatchId| torus_distance(&fitted.surface.sample(p, [0.2, 0.5]).point).abs();
    assert!(fitted.surface.patches().map(distance).fold(0.0, f64::max) < 0.05);
}
