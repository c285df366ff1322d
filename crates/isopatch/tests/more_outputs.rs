//! 3MF, Gmsh and OFF files, read back by programs that share no code with the writers; creased surfaces in every format of
//! triangles.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::apatch::APatchSurface;
use isopatch::bernstein::triangle::evaluate;
use isopatch::geom::{Aabb, Point3, Vec3};
use isopatch::io::Unit;
use isopatch::io::gmsh::{write_gmsh, write_gmsh_mesh};
use isopatch::io::off::write_off;
use isopatch::io::png::write_png;
use isopatch::io::read::PolygonMesh;
use isopatch::io::stl::write_stl;
use isopatch::io::threemf::{ThreemfOptions, write_3mf};
use isopatch::recipes::apatch::{self, APatchRecipe};
use isopatch::render::{RenderOptions, Style, Subject, draw, scene};
use isopatch::tessellate::{
    APatchResolution, TessellateOptions, Tessellation, tessellate, tessellate_a_patches,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use support::golden::{joined, scaled, sphere};
use support::python::{self, Missing, check};

/// Writes a file into a folder of this test program, under the target folder.
fn write(name: &str, write: impl FnOnce(&mut Vec<u8>)) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("more_outputs");
    std::fs::create_dir_all(&folder).unwrap();
    let mut bytes = Vec::new();
    write(&mut bytes);
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A script beside this test.
fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support").join(name)
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {report:#}"))
}

fn points(report: &Value, key: &str) -> Vec<Vec3> {
    let found: Vec<[f64; 3]> = serde_json::from_value(report[key].clone()).unwrap();
    found.into_iter().map(Vec3::from).collect()
}

/// Gmsh's reader of decimals is not always correctly rounded.
fn assert_close(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).norm() < 1e-15));
}

/// The A-patches of a cube whose edges are creases: six square faces, each bulging a little at its normals.
fn creased_cube() -> APatchSurface {
    let positions: Vec<Point3> = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0)).corners().to_vec();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = PolygonMesh { positions, faces: faces.map(|f| f.to_vec()).to_vec(), normals: None };
    let recipe = APatchRecipe { crease_angle: Some(0.7), ..Default::default() };
    apatch::fit(&mesh, &recipe, &|_| ()).unwrap().surface
}

/// A lens: two caps that meet in a curved crease around the rim.
fn creased_lens() -> APatchSurface {
    let rim = (0..12).map(|i| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / 12.0).sin_cos();
        Point3::new(c, s, 0.15 * (2.0 * s * c))
    });
    let positions: Vec<Point3> =
        rim.chain([Point3::new(0.0, 0.0, 0.7), Point3::new(0.0, 0.0, -0.7)]).collect();
    let faces: Vec<Vec<u32>> =
        (0..12).flat_map(|i| [vec![i, (i + 1) % 12, 12], vec![(i + 1) % 12, i, 13]]).collect();
    let mesh = PolygonMesh { positions, faces, normals: None };
    let recipe = APatchRecipe { crease_angle: Some(1.0), ..Default::default() };
    apatch::fit(&mesh, &recipe, &|_| ()).unwrap().surface
}

fn flat(surface: &APatchSurface) -> Tessellation {
    tessellate_a_patches(surface, APatchResolution { along: 5, across: 2 }).unwrap()
}

/// Reads a mesh file back with trimesh: closed, outward, with all vertices and the volume of the triangles.
fn assert_mesh(path: &str, mesh: &Tessellation, scale: f64, relative: f64) -> Result<Value, Missing> {
    let report = python::run(&script("check_mesh.py"), &[path])?;
    assert_eq!(report["faces"], mesh.triangles.len(), "{path}: {report:#}");
    assert_eq!(
        (&report["watertight"], &report["winding_consistent"]),
        (&true.into(), &true.into()),
        "{path}"
    );
    let (found, expected) = (number(&report, "volume"), scale.powi(3) * mesh.signed_volume());
    assert!(expected > 0.0 && (found - expected).abs() <= relative * expected, "{path}: {found} {expected}");
    Ok(report)
}

#[test]
fn threemf_keeps_vertices_and_units() {
    check("threemf_keeps_vertices_and_units", || {
        python::interpreter()?;
        let two = joined(&[sphere(), scaled(&sphere(), 0.5, Vec3::new(4.0, 0.0, 0.0))]);
        let mesh = tessellate(&two, &TessellateOptions { resolution: 5 }).unwrap();
        for unit in Unit::ALL {
            let name = format!("two_{}.3mf", unit.symbol());
            let path = write(&name, |out| write_3mf(&mesh, &ThreemfOptions { unit }, out).unwrap());
            let report = assert_mesh(&path, &mesh, 1.0, 1e-12)?;
            assert_eq!((&report["vertices"], &report["euler"]), (&mesh.positions.len().into(), &4.into()));
            let name = match unit {
                Unit::Mm => "millimeter",
                Unit::Cm => "centimeter",
                Unit::M => "meter",
                Unit::In => "inch",
            };
            assert_eq!(report["units"], name);
            assert_eq!(points(&report, "first"), mesh.positions[..12]);
        }
        Ok(())
    });
}

#[test]
fn off_keeps_every_digit() {
    check("off_keeps_every_digit", || {
        python::interpreter()?;
        let mesh = tessellate(&sphere(), &TessellateOptions::default()).unwrap();
        let path = write("sphere.off", |out| write_off(&mesh, out).unwrap());
        let report = assert_mesh(&path, &mesh, 1.0, 1e-12)?;
        assert_eq!((&report["vertices"], &report["euler"]), (&642.into(), &2.into()));
        assert_eq!(points(&report, "first"), sphere().base.positions);
        Ok(())
    });
}

#[test]
fn gmsh_reads_the_patches_exactly() {
    check("gmsh_reads_the_patches_exactly", || {
        python::interpreter()?;
        let sphere = sphere();
        let path = write("sphere.msh", |out| write_gmsh(&sphere, out).unwrap());
        let report = python::run(&script("check_msh.py"), &[&path])?;
        for (key, expected) in [
            ("dimension", 2),
            ("order", 7),
            ("nodes_each", 36),
            ("elements", 20),
            ("nodes", 12 + 30 * 6 + 20 * 15),
            ("open_edges", 0),
            ("largest_edge_use", 2),
        ] {
            assert_eq!(report[key], expected, "{key} of {report:#}");
        }
        assert_close(&points(&report, "first"), &sphere.base.positions);
        for (net, found) in sphere.nets.iter().zip(points(&report, "inside")) {
            // Gmsh finds its basis of degree 7 by inverting a matrix, which costs digits.
            assert!((found - evaluate(7, net, [0.3, 0.2]).point).norm() < 1e-11);
        }
        assert!(number(&report, "smallest_determinant") > 0.0);
        Ok(())
    });
}

#[test]
fn gmsh_reads_flat_triangles_of_a_patches() {
    check("gmsh_reads_flat_triangles_of_a_patches", || {
        python::interpreter()?;
        let mesh = flat(&creased_lens());
        let path = write("lens.msh", |out| write_gmsh_mesh(&mesh, out).unwrap());
        let report = python::run(&script("check_msh.py"), &[&path])?;
        assert_eq!((&report["order"], &report["open_edges"]), (&1.into(), &0.into()));
        assert_eq!(
            (&report["elements"], &report["nodes"]),
            (&mesh.triangles.len().into(), &mesh.positions.len().into())
        );
        assert_close(&points(&report, "first"), &mesh.positions[..12]);
        let inside = points(&report, "inside");
        for (t, found) in mesh.triangles.iter().zip(inside) {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            assert!((0.3 * a + 0.2 * b + 0.5 * c - found).norm() < 1e-14);
        }
        Ok(())
    });
}

/// The same nodes in the same places of an element as in a file that a program from outside wrote.
#[test]
fn gmsh_elements_have_the_golden_order() {
    check("gmsh_elements_have_the_golden_order", || {
        let golden = std::fs::read_to_string(python::test_data("golden/formats/sphere_p7.msh")?).unwrap();
        let mut own = Vec::new();
        write_gmsh(&sphere(), &mut own).unwrap();
        let own = String::from_utf8(own).unwrap();
        // All elements are alike, as those of a regular icosahedron: the distances to the three corners tell the places.
        let (golden, own) = (signature(&golden), signature(&own));
        assert_eq!(golden.len(), 36);
        for (place, (a, b)) in golden.iter().zip(&own).enumerate() {
            for k in 0..3 {
                // The splines have other parameters along their curves, which moves nodes by 0.015; neighbours are 0.12 apart.
                assert!((a[k] - b[k]).abs() < 0.03, "place {place}: {a:?} {b:?}");
            }
        }
        Ok(())
    });
}

/// Mean distances of the 36 nodes to the three corners of their element.
fn signature(text: &str) -> Vec<[f64; 3]> {
    let section = |name: &str| {
        let lines = text.lines().skip_while(|line| *line != format!("${name}")).skip(1);
        lines.take_while(|line| !line.starts_with('$')).collect::<Vec<_>>()
    };
    let numbers = |line: &str| line.split_whitespace().map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let nodes = section("Nodes");
    let count = numbers(nodes[0])[1] as usize;
    let position = |tag: usize| Vec3::from_vec(numbers(nodes[2 + count + tag - 1]));
    let elements = section("Elements");
    let mut sums = vec![[0.0; 3]; 36];
    for line in &elements[2..] {
        let tags: Vec<usize> = numbers(line)[1..].iter().map(|x| *x as usize).collect();
        let points: Vec<Vec3> = tags.iter().map(|t| position(*t)).collect();
        for (sum, p) in sums.iter_mut().zip(&points) {
            (0..3).for_each(|k| sum[k] += (p - points[k]).norm() / (elements.len() - 2) as f64);
        }
    }
    sums
}

#[test]
fn creased_surfaces_are_closed_in_files_for_printing() {
    check("creased_surfaces_are_closed_in_files_for_printing", || {
        python::interpreter()?;
        for (name, surface) in [("cube", creased_cube()), ("lens", creased_lens())] {
            assert!(surface.crease_counts().straight + surface.crease_counts().curved > 0, "{name}");
            let mesh = flat(&surface);
            assert!(!mesh.corner_normals.is_empty(), "{name} has creases");
            let stl = write(&format!("{name}.stl"), |out| write_stl(&mesh, out).unwrap());
            assert_mesh(&stl, &mesh, 1.0, 1e-6)?;
            let options = ThreemfOptions::default();
            let threemf = write(&format!("{name}.3mf"), |out| write_3mf(&mesh, &options, out).unwrap());
            assert_mesh(&threemf, &mesh, 1.0, 1e-12)?;
            let off = write(&format!("{name}.off"), |out| write_off(&mesh, out).unwrap());
            assert_mesh(&off, &mesh, 1.0, 1e-12)?;
        }
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
            let mesh = tessellate(&surface, &TessellateOptions { resolution: 6 }).unwrap();
            write_gmsh(&surface, &mut bytes[0]).unwrap();
            write_3mf(&mesh, &ThreemfOptions::default(), &mut bytes[1]).unwrap();
            write_off(&mesh, &mut bytes[2]).unwrap();
            let subject = Subject { surface: Some(&surface), ..Subject::default() };
            let options = RenderOptions { size: [240, 180], ..RenderOptions::default() };
            let scene = scene(&mesh, &subject, Style::Net).unwrap();
            write_png(&draw(&scene, &options).unwrap(), &mut bytes[3]).unwrap();
            bytes
        })
    };
    assert_eq!(all(1), all(3));
}
