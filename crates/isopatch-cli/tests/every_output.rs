//! Every output of every kind of surface, read back by programs that share no code with the writers, and equal within the
//! precision of the format. (STEP files of the six surfaces of Tong & Kim 2009: `paper_004.rs` of the library.)

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

#[path = "../../isopatch/tests/support/python.rs"]
mod python;

use isopatch::geom::Point3;
use isopatch::io::native::{NativeModel, NativeSurface, read_native};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{
    APatchResolution, TessellateOptions, Tessellation, tessellate, tessellate_a_patches, tessellate_hybrid,
};
use python::{Missing, check};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name, and what the command line is given besides the outputs.
type Model = (&'static str, &'static [&'static str]);

/// The six surfaces of Tong & Kim 2009 at their numbers of faces, A-patches, patches over polygons, a singular surface.
const MODELS: [Model; 9] = [
    ("torus", &["torus"]),
    ("dodeca", &["dodeca"]),
    ("dtorus", &["dtorus"]),
    ("mcmullen", &["mcmullen"]),
    ("chair", &["chair"]),
    ("decocube", &["decocube"]),
    ("triangles", &["octahedron.off", "--crease-angle", "60"]),
    ("polygons", &["prism.off"]),
    ("cone", &["x^2+y^2=z^2", "--box=-3,3,-3,3,-2,2", "--method", "rational", "--cells", "linear"]),
];
/// Those that a STEP file can hold and no other test reads as STEP.
const STEP: [&str; 1] = ["cone"];
const ENDINGS: [&str; 9] = ["isopatch", "vtu", "msh", "glb", "3mf", "obj", "off", "ply", "stl"];
/// Intervals along an edge in files of triangles.
const RESOLUTION: usize = 2;

/// An octahedron with a long axis, whose waist is a crease.
const OCTAHEDRON: &str = "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 0.6\n0 0 -0.6\n\
    3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";
/// A pentagonal prism with a point on top: triangles, quadrilaterals and a pentagon.
const PRISM: &str = "OFF\n11 11 0\n1 0 -1\n0.309 0.951 -1\n-0.809 0.588 -1\n-0.809 -0.588 -1\n0.309 -0.951 -1\n\
    1 0 1\n0.309 0.951 1\n-0.809 0.588 1\n-0.809 -0.588 1\n0.309 -0.951 1\n0 0 1.6\n\
    5 4 3 2 1 0\n4 0 1 6 5\n4 1 2 7 6\n4 2 3 8 7\n4 3 4 9 8\n4 4 0 5 9\n\
    3 5 6 10\n3 6 7 10\n3 7 8 10\n3 8 9 10\n3 9 5 10\n";

/// Largest miss of a coordinate, relative to the largest: digits of the format.
fn precision(file: &str) -> f64 {
    match file.rsplit('.').next() {
        // Single precision.
        Some("glb" | "stl") => 1e-7,
        // Gmsh finds its basis of degree 7 by inverting a matrix.
        Some("msh") => 1e-11,
        // VTK multiplies by the powers of its own basis.
        Some("vtu") => 1e-13,
        // Every digit.
        _ => 0.0,
    }
}

fn make(folder: &Path, (name, arguments): &Model) -> NativeModel {
    let outputs = ENDINGS.iter().copied().chain(STEP.contains(name).then_some("step"));
    let outputs = outputs.flat_map(|ending| ["-o".to_owned(), format!("{name}.{ending}")]);
    let run = Command::new(env!("CARGO_BIN_EXE_isopatch"))
        .current_dir(folder)
        .arg("fit")
        .args(*arguments)
        .args(["--resolution", &RESOLUTION.to_string(), "--quiet"])
        .args(outputs)
        .output()
        .unwrap();
    assert!(run.status.success(), "{name}: {}", String::from_utf8_lossy(&run.stderr));
    read(folder, name)
}

fn read(folder: &Path, name: &str) -> NativeModel {
    let file = File::open(folder.join(format!("{name}.isopatch"))).unwrap();
    read_native(&mut BufReader::new(file)).unwrap()
}

fn flat(model: &NativeModel) -> Tessellation {
    let along = TessellateOptions { resolution: RESOLUTION };
    let of_a_patches = APatchResolution { along: RESOLUTION, across: 1 };
    match &model.surface {
        NativeSurface::Spline(spline) => tessellate(spline.as_ref(), &along).unwrap(),
        NativeSurface::Rational(surface) => tessellate(surface.as_ref(), &along).unwrap(),
        NativeSurface::APatches(surface) => tessellate_a_patches(surface, of_a_patches).unwrap(),
        NativeSurface::Hybrid(surface) => tessellate_hybrid(surface, of_a_patches).unwrap().mesh,
    }
}

fn write_points(path: PathBuf, points: impl Iterator<Item = Point3>) {
    let bytes: Vec<u8> = points.flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes).collect();
    fs::write(path, bytes).unwrap();
}

/// What the files of a model should hold.
fn write_expected(folder: &Path, name: &str, model: &NativeModel) {
    let mesh = flat(model);
    let corners = mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]);
    write_points(folder.join(format!("{name}.triangles")), corners);
    // The others are written as flat triangles.
    let Some(surface) = model.spline() else { return };
    // Where the parameters (0.2, 0.5) of VTK and Gmsh are, the weights of corners 1 and 2.
    let inside = |p: u32| surface.sample(PatchId(p), [0.3, 0.2]).point;
    let count = surface.patch_count() as u32;
    write_points(folder.join(format!("{name}.inside")), (0..count).map(inside));
}

#[test]
fn every_output_of_every_kind_of_surface_is_read_back() {
    check("every_output_of_every_kind_of_surface_is_read_back", || {
        python::interpreter()?;
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("octahedron.off"), OCTAHEDRON).unwrap();
        fs::write(folder.path().join("prism.off"), PRISM).unwrap();
        for model in &MODELS {
            let made = make(folder.path(), model);
            let is_kind = matches!(
                (model.0, &made.surface),
                ("triangles", NativeSurface::APatches(_))
                    | ("polygons", NativeSurface::Hybrid(_))
                    | ("cone", NativeSurface::Rational(_))
                    | (_, NativeSurface::Spline(_))
            );
            assert!(is_kind, "{} is another kind of surface", model.0);
            write_expected(folder.path(), model.0, &made);
        }
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_outputs.py");
        let names = MODELS.map(|(name, _)| name);
        let root = folder.path().to_str().unwrap();
        let report = python::run(&script, &[&[root], &names[..]].concat())?;
        let files = report.as_object().unwrap();
        assert_eq!(files.len(), MODELS.len() * (ENDINGS.len() - 1));
        for (file, miss) in files {
            println!("{file}: {miss}");
            let miss = miss.as_f64().unwrap_or_else(|| panic!("{file}: {miss}"));
            assert!(miss <= precision(file), "{file}: {miss:e}");
        }
        steps(folder.path())
    });
}

/// The STEP files: valid, nothing healed, and with the faces that the patches become.
fn steps(folder: &Path) -> Result<(), Missing> {
    let kernel = python::test_data("tools/check_step.py")?;
    for name in STEP {
        let diagonal = read(folder, name).provenance.diagonal;
        let path = folder.join(format!("{name}.step"));
        let report = python::run(&kernel, &[path.to_str().unwrap()])?;
        assert_eq!((&report["brepcheck_valid"], &report["transfer_warnings"]), (&true.into(), &0.into()));
        assert_eq!(report["transfer_fails"], 0, "{report:#}");
        let gap = report["g0_face_face_max"].as_f64().unwrap() / diagonal;
        assert!(gap <= 1e-9, "{name}: {gap:e}");
    }
    Ok(())
}
