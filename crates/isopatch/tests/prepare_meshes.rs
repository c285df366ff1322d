//! Every mesh of the collection becomes an oriented manifold or is refused by name.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod support;

use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::mesh::{HalfEdgeMesh, PrepareOptions, Prepared, RepairKind, check, prepare};
use std::path::PathBuf;

/// The folder of the mesh collection, or none after a line that says so.
fn collection(test: &str) -> Option<PathBuf> {
    let folder = support::data_folder().join("meshes");
    if !folder.is_dir() {
        println!("skipped: {test} (needs ISOPATCH_TEST_DATA)");
        return None;
    }
    Some(folder)
}

fn prepared(mesh: &PolygonMesh) -> Prepared {
    let found = prepare(&mesh.positions, &mesh.faces, &PrepareOptions::default()).unwrap();
    assert!(found.summary.is_oriented_manifold(), "{}", found.summary);
    let half_edges = HalfEdgeMesh::from_faces(found.positions.len(), &found.faces).unwrap();
    assert_eq!(found.summary.euler, half_edges.euler_number());
    assert_eq!(found.summary.holes.len(), half_edges.boundary_loop_count());
    assert_eq!(found.summary.components.len(), half_edges.component_count());
    found
}

fn words(found: &Prepared) -> String {
    let repairs: Vec<String> = found.repairs.iter().map(|r| format!("  {r}\n")).collect();
    format!("{}\n{}", found.summary, repairs.concat())
}

#[test]
fn collection_print() {
    let Some(folder) = collection("collection_print") else { return };
    let mut names: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    for path in names.iter().filter(|p| p.extension().is_some_and(|e| e == "off")) {
        println!("== {}", path.file_name().unwrap().to_string_lossy());
        match read_mesh(path) {
            Err(e) => println!("  refused: {e}"),
            Ok(mesh) => {
                println!("  before: {}", check(&mesh.positions, &mesh.faces).to_string().replace('\n', "; "));
                println!("  after:  {}", words(&prepared(&mesh)));
            }
        }
    }
    let _ = RepairKind::CutEdge;
}
