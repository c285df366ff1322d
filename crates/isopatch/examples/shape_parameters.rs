//! The shape parameters of the four papers: what may be changed without a crack, a kink, or another vertex or normal.
//!
//! `cargo run --example shape_parameters` changes each on a small model and prints how far the surface moves and how smooth it stays.

use isopatch::apatch::{APatchSurface, Free};
use isopatch::base::{self, BaseOptions, FieldTarget};
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Point3, Vec3};
use isopatch::hull::Side;
use isopatch::hybrid::{HybridSurface, Jet};
use isopatch::inspect::{InspectOptions, Seams, inspect_a_patches, inspect_hybrid, seams};
use isopatch::io::read::PolygonMesh;
use isopatch::mesh::{EdgeId, FaceId, VertexId};
use isopatch::network::{CurveOptions, fit_quartics};
use isopatch::recipes::hybrid::{Fitted, HybridRecipe};
use isopatch::recipes::rational::{self, RationalRecipe};
use isopatch::recipes::{apatch, hybrid};
use isopatch::spline::{ShapeParameters, SplineOptions, build, build_shaped};
use isopatch::surface::{PatchId, Surface};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    spline()?;
    a_patches()?;
    polygons()?;
    rational_patches()
}

/// Tong & Kim 2009: μ1 of a vertex system (μ3 is that of the other end), μ2 of an edge by ν, and the three inner points of a patch.
fn spline() -> Result<(), Box<dyn Error>> {
    let field = Formula::parse("x^2 + 2 y^2 + z^2 - 1", &Constants::new())?;
    let bounds = base::find_box(&field)?;
    let made = base::build(&field, &bounds, &BaseOptions { faces: Some(60), ..BaseOptions::default() })?;
    let target = FieldTarget::new(&field, made.base.diagonal());
    let curves = fit_quartics(&made.base, &target, &CurveOptions::default())?;
    let options = SplineOptions::default();
    let plain = build(made.base.clone(), &curves, &target, &options)?;

    let start = made.base.mesh.ring(VertexId(0)).next().ok_or("a vertex without edges")?;
    let shapes = [
        ("mu1 = 0.9 at a vertex", ShapeParameters { mu1: vec![(start, 0.9)], ..Default::default() }),
        ("nu = 0.5 along an edge", ShapeParameters { nu: vec![(EdgeId(7), 0.5)], ..Default::default() }),
        (
            "an inner point 0.05 higher",
            ShapeParameters {
                inner: vec![(FaceId(3), [0.05 * Vec3::z(), Vec3::zeros(), Vec3::zeros()])],
                ..Default::default()
            },
        ),
    ];
    for (what, shape) in shapes {
        let shaped = build_shaped(made.base.clone(), &curves, &target, &options, &shape)?;
        let found = seams(&shaped, 1.0, InspectOptions::default().seam_samples);
        tell(&format!("spline, {what}"), &plain, &shaped, &found);
    }
    Ok(())
}

/// Xu, Huang & Bajaj 2001, section 5.3: a number for each face and side. Large ones pull the surface to the mesh.
fn a_patches() -> Result<(), Box<dyn Error>> {
    let surface = apatch::fit(&octahedron(), &Default::default(), &|_| ())?.surface;
    let function = surface.function().clone();
    let mut free = function.free().to_vec();
    free[0][Side::Outer.index()] += 2.0;
    let changed = APatchSurface::new(function.with_free(&Free::PerFace(free)));
    let found = inspect_a_patches(&changed, &Default::default()).common.seams;
    tell("A-patches, free parameter of a face + 2", &surface, &changed, &found);
    Ok(())
}

/// Xu, Bajaj & Evans: value and gradient at the apex over a polygon.
fn polygons() -> Result<(), Box<dyn Error>> {
    let Fitted::Polygons(fitted) = hybrid::fit(&cube(), &HybridRecipe::default(), &|_| ())? else {
        return Err("no surface over polygons".into());
    };
    let surface = fitted.surface;
    let function = surface.function().clone();
    let f = FaceId(0);
    let face = &function.hull().faces[f.index()];
    let side = Side::BOTH.into_iter().find(|side| face.jet(*side).is_some()).ok_or("no apex there")?;
    let Jet { value, gradient } = face.jet(side).ok_or("no apex there")?;
    let higher = Jet { value: 1.5 * value, gradient };
    let changed = HybridSurface::new(function.with_jets(&[(f, side, higher)]));
    let found = inspect_hybrid(&changed, &Default::default()).common.seams;
    tell("patches over polygons, value at an apex × 1.5", &surface, &changed, &found);
    Ok(())
}

/// Bajaj & Xu 1997, after (6.13): where the middle of a patch is.
fn rational_patches() -> Result<(), Box<dyn Error>> {
    let surface = rational::fit(&octahedron(), &RationalRecipe::default(), &|_| ())?.surface;
    let mut changed = surface.clone();
    changed.set_middle(PatchId(0), Vec3::repeat(0.05));
    let found = seams(&changed, 1.0, InspectOptions::default().seam_samples);
    tell("rational patches, a middle moved by (0.05, 0.05, 0.05)", &surface, &changed, &found);
    Ok(())
}

fn octahedron() -> PolygonMesh {
    let positions = [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().flat_map(|e| [e, -e]).collect();
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    PolygonMesh { positions, faces: faces.map(|f| f.to_vec()).to_vec(), normals: None }
}

fn cube() -> PolygonMesh {
    let corner = |i: usize| {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| 2.0 * bit as f64 - 1.0);
        Point3::new(x, y, z)
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let positions = (0..8).map(corner).collect();
    PolygonMesh { positions, faces: faces.map(|f| f.to_vec()).to_vec(), normals: None }
}

/// How far points of the surface moved, and how its seams are.
fn tell(what: &str, before: &dyn Surface, after: &dyn Surface, found: &Seams) {
    const SAMPLES: [[f64; 2]; 3] = [[1.0 / 3.0; 2], [0.5, 0.25], [0.2, 0.3]];
    let moved = after.patches().flat_map(|p| SAMPLES.map(|uv| (p, uv)));
    let moved = moved.map(|(p, uv)| (after.sample(p, uv).point - before.sample(p, uv).point).norm());
    println!(
        "{what}: moves by up to {:.4}; gap {:.0e}, normal jump {:.0e} rad",
        moved.fold(0.0, f64::max),
        found.max_gap,
        found.max_normal_jump
    );
}
