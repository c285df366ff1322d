//! Patches over the conforming meshes of the four surfaces of Bajaj & Xu 1997, section 6.3, in its boxes: rational ones (section 6), and
//! A-patches over the same sheets.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

mod support;

use isopatch::base::FieldTarget;
use isopatch::bernstein::triangle;
use isopatch::field::{Constants, Field, Formula};
use isopatch::geom::{Aabb, Point3};
use isopatch::inspect::{APatchInspectOptions, InspectOptions, inspect_a_patches, inspect_rational};
use isopatch::io::step::{StepOptions, write_step};
use isopatch::rational::RationalSurface;
use isopatch::recipes::adapt::{AdaptGoal, adapt};
use isopatch::recipes::algebraic::{AlgebraicError, AlgebraicRecipe, FittedAlgebraic, fit};
use isopatch::recipes::singular::{self, SingularRecipe};
use isopatch::recipes::singular_apatch::over_conforming;
use isopatch::recipes::spline::Size;
use isopatch::singular::mesh::{TriangulateOptions, triangulate};
use isopatch::singular::{SingularOptions, singular_set};
use isopatch::surface::Surface;
use std::collections::BTreeMap;
use support::python::{self, check};

struct Example {
    name: &'static str,
    formula: &'static str,
    bounds: [[f64; 3]; 2],
    /// Patches in the paper.
    patches: usize,
    /// Distance, |f| over |∇f| or 0.01, that an independent program found on structured meshes for this construction.
    distance: f64,
}

const EXAMPLES: [Example; 4] = [
    Example {
        name: "cone",
        formula: "x^2 + y^2 - z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 190,
        distance: 1.3e-3,
    },
    Example {
        name: "whitney",
        formula: "x^2 - y*z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 280,
        distance: 9.8e-3,
    },
    Example {
        name: "steiner",
        formula: "x^2*y^2 + y^2*z^2 + x^2*z^2 - 4*x*y*z",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 370,
        distance: 2.3e-2,
    },
    Example {
        name: "toroidal",
        formula: "(y^2 + z^2 - x^2 + 0.5*x^3 - 4)^2 - 16*x^2 + 8*x^3",
        bounds: [[-1.2, -4.0, -4.0], [4.0, 4.0, 4.0]],
        patches: 540,
        distance: 1.8e-2,
    },
];

impl Example {
    fn parsed(&self) -> Formula {
        Formula::parse(self.formula, &Constants::new()).unwrap()
    }

    fn bounds(&self) -> Aabb {
        let [min, max] = self.bounds.map(Point3::from);
        Aabb::new(min, max)
    }

    fn fitted(&self, size: Size) -> Result<FittedAlgebraic, AlgebraicError> {
        let recipe = AlgebraicRecipe { bounds: Some(self.bounds()), size, ..AlgebraicRecipe::default() };
        fit(&self.parsed(), &recipe, &|_| ())
    }
}

/// Largest distance of lattice points of all patches.
fn distance(field: &Formula, surface: &dyn Surface) -> f64 {
    let lattice = triangle::lattice(12);
    let at = |p: Point3| {
        let (f, gradient) = field.gradient(p);
        f.abs() / gradient.norm().max(0.01)
    };
    let points =
        surface.patches().flat_map(|p| lattice.iter().map(move |l| surface.sample(p, [l[0], l[1]]).point));
    points.map(at).fold(0.0, f64::max)
}

impl Example {
    /// Patches that are no farther than this, at no more than twice the paper's number.
    fn adapted(&self, distance: f64) -> RationalSurface {
        let (field, bounds) = (self.parsed(), self.bounds());
        let set = singular_set(&field, &bounds, &SingularOptions::default()).unwrap();
        let options = TriangulateOptions::default();
        let degree = field.quadratic_polynomial().unwrap().degree();
        let mut mesh = triangulate(&field, degree, &set, &bounds, &options).unwrap();
        let goal = AdaptGoal {
            // The lattice of the goal is not that of the test.
            distance: 0.9 * distance,
            triangles: 2 * self.patches,
            flat: options.tolerance * bounds.diagonal(),
        };
        let target = FieldTarget::new(&field, bounds.diagonal());
        adapt(&field, &bounds, &mut mesh, &target, &goal).unwrap().surface
    }
}

/// At no more than twice the paper's number of patches: half the distances, no fold, no gap, tangent planes across smooth edges.
#[test]
fn rational_patches_keep_the_distances_of_the_structured_meshes() {
    for example in EXAMPLES {
        let (name, wanted) = (example.name, 0.5 * example.distance);
        let surface = example.adapted(wanted);
        let options =
            InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
        let found = inspect_rational(&surface, None, &options);
        let (far, jump) = (distance(&example.parsed(), &surface), found.common.seams.max_normal_jump);
        println!(
            "{name}: {} patches, distance {far:.2e}, jump {jump:.1e}, {} folded",
            surface.patch_count(),
            found.folded.len()
        );
        assert!(surface.patch_count() <= 2 * example.patches, "{name}");
        assert!(far <= wanted, "{name}: {far}");
        assert!(found.folded.is_empty(), "{name}: {:?}", found.folded);
        assert_eq!(found.common.seams.max_gap, 0.0, "{name}");
        assert!(jump <= 2e-11, "{name}: {jump}");
    }
}

/// OpenCASCADE takes every sheet as a valid shell, at its least tolerance. Sheets share the edges on singular curves in the file, and no other
/// edges have an angle.
#[test]
fn step_files_are_valid_shells_that_share_edges() {
    check("step_files_are_valid_shells_that_share_edges", || {
        let kernel = python::test_data("tools/check_step.py")?;
        let folder = tempfile::tempdir().unwrap();
        for (example, shells) in EXAMPLES.iter().zip([2, 2, 4, 3]) {
            let (name, surface) = (example.name, example.adapted(example.distance));
            let mut bytes = Vec::new();
            write_step(&surface, &StepOptions::default(), &mut bytes).unwrap();
            let path = folder.path().join(format!("{name}.step"));
            std::fs::write(&path, &bytes).unwrap();
            let (crossing, creases) = crossings(&surface);
            assert_eq!(
                edges_with_more_than_two_uses(&String::from_utf8(bytes).unwrap()),
                2 * crossing,
                "{name}"
            );
            let report =
                python::run(&kernel, &[path.to_str().unwrap(), "--edge-samples", "3", "--no-volume"])?;
            let number = |key: &str| report[key].as_f64().unwrap();
            println!("{name}: {shells} shells, gap {:.1e}, {crossing} crossings", number("g0_face_face_max"));
            for (key, expected) in [
                ("shells", shells),
                ("faces", 4 * surface.patch_count()),
                ("transfer_fails", 0),
                ("transfer_warnings", 0),
                // Halves of wires at which one shell has two sheets.
                ("edges_over_0.1deg", 2 * creases),
            ] {
                assert_eq!(report[key], expected, "{name}: {key} of {report:#}");
            }
            assert_eq!(report["brepcheck_valid"], true, "{name}: {report:#}");
            for key in ["max_tol_edge", "max_tol_vertex", "max_tol_face"] {
                assert!(number(key) <= 1e-7, "{name}: {key} of {report:#}");
            }
            assert!(number("g0_face_face_max") <= 1e-9 * surface.diagonal(), "{name}: {report:#}");
        }
        Ok(())
    });
}

/// The number of wires where sheets cross, and at how many of them a connected sheet has two sides, counted once for every such sheet.
fn crossings(surface: &RationalSurface) -> (usize, usize) {
    let mut sheet: Vec<u32> = surface.patches().map(|p| p.0).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for pair in surface.seams().iter().filter_map(|s| Some([s.first.patch, s.second?.patch])) {
            let least = pair.map(|p| sheet[p.index()]).into_iter().min().unwrap();
            for p in pair {
                changed |= std::mem::replace(&mut sheet[p.index()], least) != least;
            }
        }
    }
    let mut uses: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
    for (s, seam) in surface.seams().iter().enumerate() {
        for side in std::iter::once(seam.first).chain(seam.second) {
            *uses.entry(surface.curve(s)).or_default().entry(sheet[side.patch.index()]).or_default() += 1;
        }
    }
    let crossing: Vec<_> = uses.values().filter(|of| of.values().sum::<usize>() > 2).collect();
    let twice = crossing.iter().flat_map(|of| of.values()).filter(|uses| **uses == 2).count();
    (crossing.len(), twice)
}

fn edges_with_more_than_two_uses(step: &str) -> usize {
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, of) in step.lines().filter_map(|line| line.split_once("ORIENTED_EDGE('',*,*,")) {
        *uses.entry(of.split(',').next().unwrap()).or_default() += 1;
    }
    uses.values().filter(|uses| **uses > 2).count()
}

/// A number of patches is kept, and more of them are closer; too few are refused.
#[test]
fn a_number_of_patches_can_be_asked_for() {
    let cone = &EXAMPLES[0];
    let far = [40, 240].map(|faces| {
        let fitted = cone.fitted(Size::Faces(faces)).unwrap();
        assert!(fitted.surface.patch_count() <= faces);
        distance(&cone.parsed(), &fitted.surface)
    });
    println!("40 and 240 patches: {far:?}");
    assert!(far[1] < 0.5 * far[0], "{far:?}");
    assert!(matches!(cone.fitted(Size::Faces(3)), Err(AlgebraicError::Faces { asked: 3, .. })));
    // A few more than the mesh has that the distance alone would give.
    let toroidal = &EXAMPLES[3];
    let fitted = toroidal.fitted(Size::Faces(toroidal.patches)).unwrap();
    let far = distance(&toroidal.parsed(), &fitted.surface);
    assert!(fitted.surface.patch_count() <= toroidal.patches && far <= toroidal.distance, "{far}");
}

#[test]
fn a_tolerance_is_kept() {
    for (example, tolerance) in [(&EXAMPLES[0], 1e-5), (&EXAMPLES[1], 3e-4)] {
        let fitted = example.fitted(Size::Tolerance(tolerance)).unwrap();
        let found = inspect_rational(&fitted.surface, Some(&example.parsed()), &InspectOptions::default());
        let far = found.common.deviation.unwrap().max_distance;
        println!("{}: {} patches, {far:.1e} of {tolerance:.0e}", example.name, fitted.surface.patch_count());
        assert!(far <= tolerance && found.folded.is_empty(), "{}: {far}", example.name);
    }
}

/// A-patches over the same sheets: every ray has its root, none folds, and the triangles of solids that touch along a singular curve have the same
/// points there.
#[test]
fn a_patches_meet_along_singular_curves() {
    for example in EXAMPLES {
        let name = example.name;
        let field = example.parsed();
        let mesh = TriangulateOptions { tolerance: 1e-2, ..TriangulateOptions::default() };
        let recipe = SingularRecipe { bounds: Some(example.bounds()), mesh, ..SingularRecipe::default() };
        let whole = singular::fit(&field, &recipe, &|_| ()).unwrap().triangulated.mesh;
        let made =
            over_conforming(&field, &whole, &Default::default(), &Default::default(), &|_| ()).unwrap();
        let options = APatchInspectOptions { intersections: None, ..APatchInspectOptions::default() };
        let found = inspect_a_patches(&made.surface, &options);
        let gap = made.gap;
        println!(
            "{name}: {} patches, jump {:.1e}, {} undefined, {} folded, {} steep, gap {gap:.1e}, {:?}",
            made.surface.patch_count(),
            found.common.seams.max_normal_jump,
            found.undefined.len(),
            found.folded.len(),
            found.steep.len(),
            made.repairs.iter().map(|r| &r.what).collect::<Vec<_>>()
        );
        assert!(found.undefined.is_empty() && found.folded.is_empty(), "{name}");
        assert_eq!(found.common.seams.max_gap, 0.0, "{name}");
        assert!(gap <= 1e-12, "{name}: {gap}");
    }
}
