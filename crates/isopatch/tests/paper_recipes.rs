//! The recipes of Xu, Huang & Bajaj 2001, Xu, Bajaj & Evans, and Bajaj & Xu 1997 as printed, and what they say that they break.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::base::Repair;
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Point3, Vec3};
use isopatch::inspect::{InspectOptions, inspect_rational, seams};
use isopatch::io::read::PolygonMesh;
use isopatch::recipes::algebraic::AlgebraicRecipe;
use isopatch::recipes::apatch::{self, APatchRecipe, FittedMesh};
use isopatch::recipes::hybrid::{Fitted, HybridRecipe};
use isopatch::recipes::rational::RationalRecipe;
use isopatch::recipes::{paper_apatch, paper_hybrid, paper_rational};
use isopatch::tessellate::{APatchResolution, tessellate_a_patches};
use support::meshes::icosahedron;

fn ball() -> PolygonMesh {
    let (positions, faces) = icosahedron();
    let normals = Some(positions.clone());
    PolygonMesh { faces: faces.iter().map(|f| f.to_vec()).collect(), normals, positions }
}

/// A torus of triangles in an uneven grid: convex outside, saddles inside.
fn torus() -> PolygonMesh {
    let (around, about) = (12, 8);
    let turn = |i: f64, n: u32| (std::f64::consts::TAU * i / f64::from(n)).sin_cos();
    let places = (0..around).flat_map(|i| (0..about).map(move |j| (i, j)));
    let data: Vec<(Point3, Vec3)> = places
        .clone()
        .map(|(i, j)| {
            let uneven = 0.4 * f64::from(i % 3);
            let ((s, c), (t, d)) = (turn(i.into(), around), turn(f64::from(j) + uneven, about));
            let normal = Vec3::new(d * c, d * s, t);
            (2.0 * Vec3::new(c, s, 0.0) + 0.7 * normal, normal)
        })
        .collect();
    let at = |i: u32, j: u32| i % around * about + j % about;
    let faces = places.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [vec![a, b, c], vec![a, c, d]]
    });
    PolygonMesh {
        faces: faces.collect(),
        normals: Some(data.iter().map(|(_, n)| *n).collect()),
        positions: data.into_iter().map(|(p, _)| p).collect(),
    }
}

fn says(repairs: &[Repair], what: &str) -> bool {
    repairs.iter().any(|repair| repair.what.starts_with(what))
}

/// Step 8 misses the sphere by 3.1e-2 (`paper_000.rs`), which the default recipe gives to rounding.
#[test]
fn a_patches_as_printed_are_those_of_step_8() {
    let fitted = paper_apatch::fit(&ball(), &APatchRecipe::default(), &|_| ()).unwrap();
    let mesh = tessellate_a_patches(&fitted.surface, APatchResolution { along: 12, across: 4 }).unwrap();
    let miss = mesh.positions.iter().map(|p| (p.norm() - 1.0).abs()).fold(0.0, f64::max);
    assert!((0.02..0.04).contains(&miss), "{miss}");
    assert!(fitted.repairs.is_empty(), "{:?}", fitted.repairs);
}

/// Nothing is mended, and what does not fit is listed: a flat pyramid whose normals see some faces from behind.
#[test]
fn a_patches_as_printed_say_what_does_not_fit() {
    let mut mesh = torus();
    let normals = mesh.normals.as_mut().unwrap();
    normals[5] = -normals[6].cross(&Vec3::z());
    let fitted = paper_apatch::fit(&mesh, &APatchRecipe::default(), &|_| ()).unwrap();
    assert!(fitted.surface.function().hull().added_creases().is_empty());
    assert!(fitted.surface.function().hull().moved_normals().is_empty());
    assert!(says(&fitted.repairs, "surface not certain"), "{:?}", fitted.repairs);
}

#[test]
fn polygons_as_printed_keep_their_cells_or_say_why_not() {
    let cube = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let positions: Vec<Point3> = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0)).corners().to_vec();
    let mesh = PolygonMesh { positions, faces: cube.map(|f| f.to_vec()).to_vec(), normals: None };
    match paper_hybrid::fit(&mesh, &HybridRecipe::default(), &|_| ()).unwrap() {
        Fitted::Polygons(fitted) => assert_eq!(fitted.surface.function().hull().faces.len(), 6),
        Fitted::Triangles(fitted) => assert!(says(&fitted.repairs, "no cells over polygons")),
    }
    // Of triangles alone the triangle method makes its own.
    let fitted = paper_hybrid::fit(&ball(), &HybridRecipe::default(), &|_| ()).unwrap();
    assert!(matches!(fitted, Fitted::Triangles(_)));
}

/// On a sphere all wires are conics and (6.13) has solutions: G1 to rounding.
#[test]
fn conic_patches_as_printed_are_g1_on_a_sphere() {
    let fitted = paper_rational::fit(&ball(), &RationalRecipe::default(), &|_| ()).unwrap();
    assert!(fitted.repairs.is_empty() && fitted.folded.is_empty(), "{:?}", fitted.repairs);
    let found = seams(&fitted.surface, fitted.surface.diagonal(), 21);
    assert!(found.max_gap < 1e-15 && found.max_normal_jump < 1e-12, "{found:?}");
}

/// Between convex and saddle no conic has a normal function (Lemma 5.2): cubic wires and patches, and a word about them.
#[test]
fn cubic_wires_stand_where_there_are_no_conics() {
    let fitted = paper_rational::fit(&torus(), &RationalRecipe::default(), &|_| ()).unwrap();
    assert!(
        says(&fitted.repairs, "cubic wires") && says(&fitted.repairs, "cubic patches"),
        "{:?}",
        fitted.repairs
    );
    assert!(seams(&fitted.surface, 1.0, 5).max_gap < 1e-14);
}

/// A cone: straight wires through the tip, normals of its own at each.
#[test]
fn singular_formulas_go_through_the_same_scheme() {
    let cone = Formula::parse("x^2 + y^2 - z^2", &Constants::new()).unwrap();
    let bounds = Aabb::new(Vec3::new(-3.0, -3.0, -2.0), Vec3::new(3.0, 3.0, 2.0));
    let recipe = AlgebraicRecipe { bounds: Some(bounds), ..AlgebraicRecipe::default() };
    let fitted = paper_rational::fit_formula(&cone, &recipe, &|_| ()).unwrap();
    let options = InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect_rational(&fitted.surface, Some(&cone), &options).common;
    assert!(found.seams.max_gap < 1e-14);
    assert!(found.deviation.unwrap().max_first_order < 0.02);
    assert!(says(&fitted.notes, "patches with dependent normals"), "{:?}", fitted.notes);
}

/// The Butterfly scheme divides edges over which tetrahedra intersect; what comes of it is told, and the result has no more faulty
/// faces than before.
#[test]
fn edges_are_divided_where_tetrahedra_intersect() {
    let faulty = |fitted: &FittedMesh| fitted.surface.function().hull().bad_faces().len();
    let mut mesh = PolygonMesh { normals: None, ..torus() };
    // Every other vertex out, every other one in.
    let normals = torus().normals.unwrap();
    for (v, (p, n)) in mesh.positions.iter_mut().zip(&normals).enumerate() {
        *p += (if v % 2 == 0 { 0.25 } else { -0.25 }) * n;
    }
    let whole = paper_apatch::fit(&mesh, &APatchRecipe::default(), &|_| ()).unwrap();
    let recipe = APatchRecipe { hull: paper_apatch::recipe().hull, ..APatchRecipe::default() };
    let undivided = apatch::fit(&mesh, &recipe, &|_| ()).unwrap();
    assert!(faulty(&undivided) > 0, "nothing to divide");
    assert!(says(&whole.repairs, "Butterfly subdivision"), "{:?}", whole.repairs);
    assert!(faulty(&whole) <= faulty(&undivided));
}
