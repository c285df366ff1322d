//! Self-intersections of meshes from files and of fitted surfaces.
#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::gallery;
use isopatch::inspect::{MeshIntersections, intersections, mesh_intersections};
use isopatch::io::read::read_mesh;
use isopatch::recipes::spline::{Size, SplineRecipe, fit};
use support::{data_folder, skip};

/// A mesh of the collection; polygons are cut into fans.
fn found_in(name: &str) -> Option<MeshIntersections> {
    let mesh = read_mesh(&data_folder().join("meshes").join(name)).ok()?;
    let fan = |face: &Vec<u32>| -> Vec<[u32; 3]> {
        face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]).collect()
    };
    let triangles: Vec<[u32; 3]> = mesh.faces.iter().flat_map(fan).collect();
    Some(mesh_intersections(&mesh.positions, &triangles))
}

/// Triangles of cgal_eight.
const ONE_COPY: u32 = 634;

#[test]
fn meshes_from_files() {
    for name in ["cgal_eight.off", "cgal_sphere966.off", "cgal_icosahedron.off", "npm_bunny.off"] {
        let Some(found) = found_in(name) else { return skip("meshes_from_files") };
        assert_eq!(found.count, 0, "{name}");
    }
    // Two copies of cgal_eight, the second one moved into the first.
    let planted = found_in("nasty_self_intersecting.off").unwrap();
    assert_eq!((planted.count, planted.first.len()), (402, 10));
    assert!(planted.first.iter().all(|[a, b]| *a < ONE_COPY && *b >= ONE_COPY), "{planted:?}");
}

/// The surfaces with a name that are not among the paper's; those are looked at with their other figures.
#[test]
fn fitted_surfaces_do_not_go_through_themselves() {
    for name in ["sphere", "tangle", "orthocircles"] {
        let entry = gallery::surface(name).unwrap();
        let size = Size::Faces(entry.faces);
        let recipe = SplineRecipe { bounds: entry.bounds, size, ..SplineRecipe::default() };
        let surface = fit(&entry.field().unwrap(), &recipe, &|_| ()).unwrap().surface;
        let found = intersections(&surface, 8).unwrap();
        assert_eq!((found.triangles, found.count), (64 * entry.faces, 0), "{name}");
    }
}
