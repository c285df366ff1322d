use super::*;
use crate::geom::Point3;
use crate::hull::test_meshes::{icosahedron, quadrics};
use crate::inspect::{APatchInspectOptions, inspect_a_patches};
use crate::tessellate::{APatchResolution, tessellate_a_patches};

fn mesh(positions: &[Point3], faces: &[[u32; 3]]) -> PolygonMesh {
    PolygonMesh {
        positions: positions.to_vec(),
        faces: faces.iter().map(|f| f.to_vec()).collect(),
        normals: None,
    }
}

fn fitted(mesh: &PolygonMesh, recipe: &APatchRecipe) -> FittedMesh {
    fit(mesh, recipe, &|_| ()).unwrap()
}

fn worst(surface: &APatchSurface, distance: impl Fn(&Point3) -> f64) -> f64 {
    let mesh = tessellate_a_patches(surface, APatchResolution { along: 6, across: 4 }).unwrap();
    mesh.positions.iter().map(distance).fold(0.0, f64::max)
}

/// With unit normals an ellipsoid is missed by 8e-3; with their lengths recovered it is exact.
#[test]
fn recovered_lengths_give_the_ellipsoid_back() {
    let (_, quadric, data) = quadrics().into_iter().find(|(name, ..)| *name == "ellipsoid").unwrap();
    let faces: Vec<[u32; 3]> = data.mesh().faces().map(|f| data.mesh().triangle(f).map(|v| v.0)).collect();
    let missed = |normals: &dyn Fn(&Point3) -> Vec3, lengths| {
        let normals = Some(data.positions().iter().map(normals).collect());
        let given = PolygonMesh { normals, ..mesh(data.positions(), &faces) };
        let recipe = APatchRecipe { lengths, ..APatchRecipe::default() };
        worst(&fitted(&given, &recipe).surface, |p| quadric.distance(p))
    };
    let unit = |p: &Point3| quadric.gradient(p).normalize();
    assert!(missed(&unit, GradientLengths::Given) > 4e-3);
    assert!(missed(&unit, GradientLengths::Recovered) < 1e-13);
    // Gradients of the file are taken as they are.
    let gradient = |p: &Point3| quadric.gradient(p);
    assert!(missed(&gradient, GradientLengths::Given) < 1e-14);
    assert!(missed(&gradient, GradientLengths::Unit) > 4e-3);
}

#[test]
fn the_report_tells_what_was_done() {
    let (positions, faces) = icosahedron();
    let fitted = fitted(&mesh(&positions, &faces), &APatchRecipe::default());
    let figures = &fitted.figures;
    assert_eq!(figures.normals.as_deref(), Some("loop"));
    assert_eq!((figures.faces.positive, figures.edges.positive), (20, 30));
    assert_eq!((figures.face_cells, figures.edge_cells), (20, 30));
    assert!(figures.problems.is_empty() && fitted.repairs.is_empty());
    let found = inspect_a_patches(&fitted.surface, &APatchInspectOptions::default());
    assert!(found.undefined.is_empty() && found.folded.is_empty());
    let common = &found.common;
    assert_eq!((common.patches, common.topology.euler), (50, 2));
    assert_eq!((common.seams.interior, common.seams.boundary, common.seams.max_gap), (60, 0, 0.0));
    assert!(common.seams.max_normal_jump < 1e-13, "{}", common.seams.max_normal_jump);
    assert_eq!(common.interpolation.max_position_error, 0.0);
    assert!(common.interpolation.max_normal_error < 1e-13);
    assert_eq!(common.intersections.as_ref().unwrap().count, 0);
    // Loop normals of the icosahedron are radial, so this is the unit sphere.
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((common.extent.volume / volume - 1.0).abs() < 2e-3, "{}", common.extent.volume);
}

#[test]
fn polygons_are_cut_and_free_parameters_stay_with_their_faces() {
    // A cube of quadrilaterals.
    let positions: Vec<Point3> =
        (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let given = PolygonMesh { positions, faces: quads.iter().map(|f| f.to_vec()).collect(), normals: None };
    let mut values = vec![[f64::NAN; 2]; 6];
    values[4] = [7.0, f64::NAN];
    let patches = APatchOptions { free: Free::PerFace(values.clone()), ..APatchOptions::default() };
    let recipe = APatchRecipe { patches, ..APatchRecipe::default() };
    let found = fitted(&given, &recipe);
    let free = found.surface.function().free();
    assert_eq!(free.len(), 12);
    let sevens: Vec<usize> = (0..12).filter(|f| free[*f][0] == 7.0).collect();
    assert_eq!(sevens, [8, 9]);
    assert!(found.repairs.iter().any(|r| r.what == "polygons cut into triangles: 6"));
    values.pop();
    let patches = APatchOptions { free: Free::PerFace(values), ..APatchOptions::default() };
    let error = fit(&given, &APatchRecipe { patches, ..APatchRecipe::default() }, &|_| ()).unwrap_err();
    assert_eq!(error, APatchError::FreeCount { given: 5, wanted: 6 });
}

#[test]
fn normals_of_a_file_follow_the_faces() {
    let (positions, faces) = icosahedron();
    let mut given = mesh(&positions, &faces);
    // Inside out, with the normals that go with it; one of them is missing.
    given.faces.iter_mut().for_each(|f| f.swap(1, 2));
    given.normals = Some(positions.iter().map(|p| -2.0 * p).collect());
    given.normals.as_mut().unwrap()[3] = Vec3::zeros();
    let found = fitted(&given, &APatchRecipe::default());
    assert_eq!(found.figures.normals.as_deref(), Some("file"));
    let whats: Vec<&str> = found.repairs.iter().map(|r| r.what.as_str()).collect();
    assert_eq!(
        whats,
        ["closed components turned inside out: 1", "normals computed: 1", "normals turned over: 11"]
    );
    assert!(found.surface.function().hull().data().mesh().is_closed());
    let without = PolygonMesh { normals: None, ..given };
    let recipe = APatchRecipe { normals: Some(NormalSource::File), ..APatchRecipe::default() };
    assert_eq!(fit(&without, &recipe, &|_| ()).unwrap_err(), APatchError::NoNormals);
}
