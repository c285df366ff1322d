//! Every mesh of the collection becomes an oriented manifold, with a word for every change, or is refused by name.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod support;

use isopatch::inspect::mesh_intersections;
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::mesh::{HalfEdgeMesh, MeshFault, PrepareOptions, Prepared, RepairKind, check, prepare};
use std::path::PathBuf;

/// What must become of a mesh that is not clean: kinds and numbers of repairs, Euler number, components, holes.
type Expected = (&'static str, &'static [(RepairKind, usize)], i64, usize, usize);

/// The collection's eight is a surface of genus 2: Euler number −2.
#[rustfmt::skip]
const REPAIRED: &[Expected] = {
    use RepairKind::{CutEdge, FlatFace, FlippedFace, RepeatedCorner, SplitVertex, TurnedComponent, UnusedVertex, WeldedVertex};
    &[
        // Closed, but its normals point inward.
        ("conway_prism5", &[(TurnedComponent, 1)], 2, 1, 0),
        // Its 32 patches have vertices of their own; four parts remain: body, lid, handle, spout. None is closed.
        ("npm_teapot", &[(WeldedVertex, 262)], 2, 4, 6),
        ("pyvista_airplane", &[(CutEdge, 1), (SplitVertex, 8)], 5, 8, 11),
        ("nasty_cgal_blobby-shuffled", &[(FlippedFace, 2017)], 2, 1, 0),
        // Two vertices at the end of a sharp edge: welded, the mesh is closed.
        ("nasty_cgal_corner_with_sharp_edge", &[(WeldedVertex, 1)], 2, 1, 0),
        ("nasty_cgal_quads_to_stitch", &[(WeldedVertex, 5)], 1, 1, 1),
        ("nasty_degenerate", &[(RepeatedCorner, 1), (FlatFace, 1), (UnusedVertex, 1)], -2, 1, 0),
        ("nasty_flipped20pct", &[(FlippedFace, 126)], -2, 1, 0),
        // Six pairs of holes have a corner in common.
        ("nasty_holes25", &[(SplitVertex, 6)], -18, 1, 16),
        ("nasty_nonmanifold_fin", &[(CutEdge, 1), (SplitVertex, 2)], -1, 2, 1),
        ("nasty_polygon_soup", &[(WeldedVertex, 1587)], -2, 1, 0),
    ]
};

/// These pass as they are: Euler number, components, holes.
const NASTY_AND_UNCHANGED: &[(&str, i64, usize, usize)] = &[
    // 106 holes, some with corners at one place but with vertices of their own.
    ("nasty_cgal_elephant-with-holes", -110, 1, 106),
    // Its hole is that of a torus.
    ("nasty_cgal_hole", 0, 1, 0),
    ("nasty_noise1pct", -2, 1, 0),
    ("nasty_self_intersecting", -4, 2, 0),
];

/// The names of the collection without ending, with the files; none after a line that says so.
fn collection(test: &str) -> Option<Vec<(String, PathBuf)>> {
    let Ok(entries) = std::fs::read_dir(support::data_folder().join("meshes")) else {
        support::skip(test);
        return None;
    };
    let named = |path: PathBuf| (path.file_stem().unwrap().to_string_lossy().into_owned(), path);
    let mut found: Vec<_> = entries.map(|e| named(e.unwrap().path())).collect();
    found.retain(|(_, path)| path.extension().is_some_and(|e| e == "off"));
    found.sort();
    assert!(found.len() >= 30, "only {} meshes", found.len());
    Some(found)
}

fn prepared(name: &str, mesh: &PolygonMesh) -> Prepared {
    let found = prepare(&mesh.positions, &mesh.faces, &PrepareOptions::default())
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let half_edges = HalfEdgeMesh::from_faces(found.positions.len(), &found.faces).unwrap();
    let summary = &found.summary;
    assert!(summary.is_oriented_manifold() && summary.flat.is_empty(), "{name}: {summary}");
    assert_eq!(summary.euler, half_edges.euler_number(), "{name}");
    assert_eq!(summary.holes.len(), half_edges.boundary_loop_count(), "{name}");
    assert_eq!(summary.components.len(), half_edges.component_count(), "{name}");
    assert!(summary.components.iter().all(|c| !c.is_inside_out), "{name}: {summary}");
    let places: Vec<_> = found.vertex_source.iter().map(|v| mesh.positions[*v as usize]).collect();
    assert_eq!(found.positions, places, "{name}");
    found
}

#[test]
fn meshes_of_the_collection() {
    let Some(files) = collection("meshes_of_the_collection") else { return };
    for (name, path) in files.iter().filter(|(name, _)| name != "nasty_nan_vertex") {
        let mesh = read_mesh(path).unwrap();
        let found = prepared(name, &mesh);
        let s = &found.summary;
        let numbers = (s.euler, s.components.len(), s.holes.len());
        let repairs: Vec<_> = found.repairs.iter().map(|r| (r.kind, r.places.len())).collect();
        if let Some((_, kinds, euler, components, holes)) = REPAIRED.iter().find(|r| r.0 == name) {
            assert_eq!((&repairs[..], numbers), (*kinds, (*euler, *components, *holes)), "{name}");
            continue;
        }
        assert_eq!(
            (repairs, &found.positions, &found.faces),
            (vec![], &mesh.positions, &mesh.faces),
            "{name}"
        );
        let expected = NASTY_AND_UNCHANGED.iter().find(|r| r.0 == name);
        assert_eq!(expected.is_some(), name.starts_with("nasty_"), "{name}");
        if let Some((_, euler, components, holes)) = expected {
            assert_eq!(numbers, (*euler, *components, *holes), "{name}");
        }
    }
}

/// The reader refuses it; given as it is, so does `prepare`, and `check` lists it.
#[test]
fn a_vertex_that_is_not_a_number_is_refused() {
    let Some(files) = collection("a_vertex_that_is_not_a_number_is_refused") else { return };
    let (_, path) = files.iter().find(|(name, _)| name == "cgal_eight").unwrap();
    let mut mesh = read_mesh(path).unwrap();
    mesh.positions[5].fill(f64::NAN);
    let fault = prepare(&mesh.positions, &mesh.faces, &PrepareOptions::default()).unwrap_err();
    assert!(matches!(fault, MeshFault::NotFinite { vertex: 5, .. }), "{fault}");
    let found = check(&mesh.positions, &mesh.faces);
    assert_eq!((found.not_finite, found.holes.len()), (vec![5], 1));
    let (_, path) = files.iter().find(|(name, _)| name == "nasty_nan_vertex").unwrap();
    assert!(read_mesh(path).is_err());
}

/// A caller finds these after `prepare`, with the triangles that it fits.
#[test]
fn self_intersections_are_left_to_the_caller() {
    let Some(files) = collection("self_intersections_are_left_to_the_caller") else { return };
    for (name, expected) in [("nasty_self_intersecting", true), ("cgal_eight", false)] {
        let (_, path) = files.iter().find(|(n, _)| n == name).unwrap();
        let found = prepared(name, &read_mesh(path).unwrap());
        let triangles: Vec<[u32; 3]> = found.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
        assert_eq!(mesh_intersections(&found.positions, &triangles).count > 0, expected, "{name}");
    }
}
