//! Sharp edges of splines and rational surfaces have a normal on each side in files of triangles and in pictures.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::geom::{Aabb, Point3, Vec3, angle_between};
use isopatch::io::read::PolygonMesh;
use isopatch::recipes::mesh_spline::{self, MeshSplineRecipe};
use isopatch::recipes::rational::{self, RationalRecipe};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use support::golden::{roof, sphere};

fn flat_normals(mesh: &Tessellation) -> impl Iterator<Item = (usize, Vec3)> + '_ {
    mesh.triangles.iter().enumerate().map(|(t, triangle)| {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        (t, (b - a).cross(&(c - a)).normalize())
    })
}

/// Two flat patches that meet in a sharp edge: points once, normals on both sides, those of the faces.
#[test]
fn the_faces_of_a_roof_have_their_own_normals() {
    for n in [1, 2, 5] {
        let mesh = tessellate(&roof(), &TessellateOptions { resolution: n }).unwrap();
        // 4 corners, 5 edges, two interiors.
        let interior = if n < 3 { 0 } else { (n - 1) * (n - 2) / 2 };
        assert_eq!(mesh.positions.len(), 4 + 5 * (n - 1) + 2 * interior);
        assert_eq!(mesh.normals.len(), mesh.positions.len() + n + 1);
        for (t, flat) in flat_normals(&mesh) {
            for number in mesh.normal_numbers(t) {
                assert!((mesh.normals[number as usize] - flat).norm() < 1e-12, "triangle {t}");
            }
        }
        let split = mesh.with_split_creases();
        assert_eq!((split.positions.len(), split.triangles.len()), (mesh.normals.len(), 2 * n * n));
    }
}

#[test]
fn smooth_surfaces_have_one_normal_a_point() {
    let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 4 }).unwrap();
    assert!(mesh.corner_normals.is_empty() && mesh.normals.len() == mesh.positions.len());
}

/// The cube, and the normal of each patch at each point of it.
#[test]
fn a_cube_has_flat_faces_and_shared_points() {
    let positions: Vec<Point3> = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0)).corners().to_vec();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = PolygonMesh { positions, faces: faces.map(|f| f.to_vec()).to_vec(), normals: None };
    let angle = Some(40f64.to_radians());
    let spline = MeshSplineRecipe { crease_angle: angle, ..MeshSplineRecipe::default() };
    let spline = mesh_spline::fit(&mesh, &spline, &|_| ()).unwrap().surface;
    let rational = RationalRecipe { crease_angle: angle, ..RationalRecipe::default() };
    let rational = rational::fit(&mesh, &rational, &|_| ()).unwrap().surface;
    for surface in [&spline as &dyn Surface, &rational] {
        let n = 4;
        let mesh = tessellate(surface, &TessellateOptions { resolution: n }).unwrap();
        // 8 corners, 12 edges of the cube and 6 diagonals, 12 patches.
        assert_eq!(mesh.positions.len(), 8 + 18 * (n - 1) + 12 * 3);
        assert_eq!(mesh.normals.len(), mesh.positions.len() + 16 + 12 * (n - 1));
        let worst = flat_normals(&mesh).flat_map(|(t, flat)| {
            mesh.normal_numbers(t).map(|number| angle_between(&mesh.normals[number as usize], &flat))
        });
        assert!(worst.fold(0.0, f64::max) < 1e-6);
        assert!((mesh.signed_volume() - 8.0).abs() < 1e-9);
        assert_eq!(mesh.patches.last(), Some(&PatchId(11)));
    }
}
