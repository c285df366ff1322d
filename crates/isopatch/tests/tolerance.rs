//! A tolerance is kept, both ways, on other samples than those of the fit, with few patches over a valid base mesh.

#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

use isopatch::base::{BaseMethod, BaseOptions, ValidityLimits, validity};
use isopatch::field::{Constants, Formula};
use isopatch::gallery;
use isopatch::inspect::{InspectOptions, inspect};
use isopatch::recipes::spline::{Effort, Fitted, Size, SplineRecipe, fit};

fn fitted(name: &str, tolerance: f64, method: BaseMethod, effort: Effort) -> Fitted {
    let entry = gallery::surface(name).unwrap();
    let mut constants = Constants::new();
    for (name, value) in &entry.constants {
        constants.assign(&format!("{name}={value}")).unwrap();
    }
    let recipe = SplineRecipe {
        bounds: entry.bounds,
        size: Size::Tolerance(tolerance),
        effort,
        base: BaseOptions { method, ..BaseOptions::default() },
        ..SplineRecipe::default()
    };
    fit(&Formula::parse(&entry.formula, &constants).unwrap(), &recipe, &|_| ()).unwrap()
}

/// Fails if the tolerance is missed, the base mesh is not valid, or there are more patches than `most`.
fn check(name: &str, tolerance: f64, method: BaseMethod, most: usize) {
    check_fitted(name, tolerance, &fitted(name, tolerance, method, Effort::Full), most);
}

fn check_fitted(name: &str, tolerance: f64, fitted: &Fitted, most: usize) {
    let base = &fitted.surface.base;
    let options = InspectOptions { region: Some(fitted.bounds), ..InspectOptions::default() };
    let found = inspect(&fitted.surface, base, Some(&fitted.formula), &options);
    let there = found.deviation.as_ref().unwrap();
    assert!(fitted.reached, "{name}");
    assert!(there.max_distance <= tolerance, "{name}: {:e}", there.max_distance);
    assert!(found.seams.max_normal_jump < 1e-9, "{name}: {:e}", found.seams.max_normal_jump);
    assert!(found.coverage.unwrap().max_distance <= tolerance, "{name}");
    assert_eq!((there.folded, there.over_limit), (0, 0), "{name}");
    assert_eq!(validity(base, &ValidityLimits::default()), [], "{name}");
    assert_eq!(found.diagonal, base.frozen_diagonal.unwrap());
    assert!(found.patches <= most, "{name}: {} patches for {tolerance:e}", found.patches);
}

#[test]
fn spheres_take_few_patches() {
    for (tolerance, most) in [(1e-3, 26), (1e-4, 39), (1e-5, 107), (1e-6, 248)] {
        check("sphere", tolerance, BaseMethod::Remesh, most);
    }
}

#[test]
fn little_effort_keeps_the_same_promises_with_more_patches() {
    for (name, tolerance, most) in [("sphere", 1e-4, 80), ("torus", 1e-4, 500), ("mcmullen", 1e-5, 1_900)] {
        let quick = fitted(name, tolerance, BaseMethod::Remesh, Effort::Quick);
        check_fitted(name, tolerance, &quick, most);
    }
}

#[test]
fn tori_take_few_patches() {
    for (tolerance, most) in [(1e-3, 211), (1e-4, 246), (1e-5, 859)] {
        check("torus", tolerance, BaseMethod::Remesh, most);
    }
}

#[test]
fn mcmullens_surface_takes_few_patches() {
    for (tolerance, most) in [(1e-3, 412), (1e-4, 395), (1e-5, 930)] {
        check("mcmullen", tolerance, BaseMethod::Remesh, most);
    }
}

#[test]
fn other_surfaces_keep_a_tolerance() {
    for (name, most) in [("dodeca", 310), ("dtorus", 844), ("tangle", 1_500)] {
        check(name, 1e-4, BaseMethod::Remesh, most);
    }
}

#[test]
fn a_decimated_mesh_will_do() {
    check("torus", 1e-4, BaseMethod::Decimate, 400);
}
