//! Surfaces cut by a box, the whole way.

use super::spline::{Fitted, Size, SplineRecipe, fit};
use crate::base::BoxSides;
use crate::bernstein::index;
use crate::field::{Constants, Field, Formula};
use crate::geom::{Aabb, Point3};
use crate::inspect::{InspectOptions, Inspection, inspect};
use crate::io::native::{NativeError, Provenance, read_native, write_native};
use crate::mesh::EdgeId;
use crate::spline::DEGREE;
use std::f64::consts::PI;

const GYROID: &str = "sin(x)cos(y)+sin(y)cos(z)+sin(z)cos(x)";
const SCHWARZ_P: &str = "cos(x)+cos(y)+cos(z)";
/// One sphere inside, one that the box cuts.
const SPHERES: &str = "((x-1)^2+y^2+z^2-0.5)((x+1)^2+y^2+z^2-0.5)";

fn made(text: &str, min: [f64; 3], max: [f64; 3], size: Size) -> Fitted {
    let formula = Formula::parse(text, &Constants::new()).unwrap();
    let recipe = SplineRecipe { bounds: Some(Aabb::new(min.into(), max.into())), size, ..Default::default() };
    fit(&formula, &recipe, &|_| ()).unwrap_or_else(|error| panic!("{text}, {size:?}: {error}"))
}

fn inspected(fitted: &Fitted) -> Inspection {
    let options = InspectOptions { region: Some(fitted.bounds), back_samples: 4000, ..Default::default() };
    inspect(&fitted.surface, &fitted.surface.base, Some(&fitted.formula), &options)
}

/// The control points of a patch over an edge.
fn row(fitted: &Fitted, e: EdgeId) -> [Point3; DEGREE + 1] {
    let mesh = &fitted.surface.base.mesh;
    let h = mesh.edge_half_edge(e);
    let net = &fitted.surface.nets[mesh.face(h).index()];
    std::array::from_fn(|m| net[index::row(DEGREE, mesh.side(h), 0, m)])
}

/// Every control point of a boundary curve lies in the curve's side, to the bit, and no other edge has a side.
fn assert_ends_in_the_box(fitted: &Fitted) {
    let base = &fitted.surface.base;
    for e in base.mesh.edges() {
        let is_boundary = base.mesh.twin(base.mesh.edge_half_edge(e)).is_none();
        let sides = base.sides_of(e);
        assert_eq!(sides.len(), usize::from(is_boundary), "{e:?}");
        for p in fitted.surface.curves[e.index()].iter().chain(&row(fitted, e)) {
            assert!(BoxSides::of(p, &fitted.bounds).contains_all(sides), "{e:?}: {p:?}");
        }
    }
}

/// `loops` of the border, Euler number, and the largest distance both ways.
fn assert_well_made(
    text: &str,
    (min, max): ([f64; 3], [f64; 3]),
    faces: usize,
    (loops, euler): (usize, i64),
    limit: f64,
) {
    let fitted = made(text, min, max, Size::Faces(faces));
    let found = inspected(&fitted);
    let deviation = found.deviation.as_ref().unwrap();
    let case = format!("{text}, {faces} faces");
    let topology = found.topology;
    assert_eq!((topology.faces, topology.boundary_loops, topology.euler), (faces, loops, euler), "{case}");
    assert!(!fitted.negated, "{case}");
    assert_ends_in_the_box(&fitted);
    assert!(found.seams.max_gap == 0.0 && found.seams.max_normal_jump <= 1e-9, "{case}: {:?}", found.seams);
    assert_eq!(deviation.folded, 0, "{case}");
    let back = found.coverage.unwrap().max_distance;
    assert!(deviation.max_distance.max(back) <= limit, "{case}: {:e} {back:e}", deviation.max_distance);
}

#[test]
fn surfaces_cut_by_a_box_are_smooth_inside_and_end_in_its_sides() {
    let (r, tall) = (0.9 * PI, [2.0, 2.0, 4.0]);
    for (text, min, max, faces, loops, euler, limit) in [
        (GYROID, [-r; 3], [r; 3], 331, 1, -3, 5e-5),
        // Through all corners of the box, or nearly, as π is rounded.
        (GYROID, [-PI; 3], [PI; 3], 401, 1, -3, 1e-4),
        (SCHWARZ_P, [-r; 3], [r; 3], 300, 6, -4, 5e-5),
        ("sin(z)-sinh(x)sinh(y)", tall.map(|x| -x), tall, 600, 1, -1, 1e-5),
        ("cos(x) exp(z) - cos(y)", [-4.0, -4.0, -1.5], [4.0, 4.0, 1.5], 700, 1, 1, 1e-5),
        ("z-x^2-y^2", [-1.0, -1.0, -0.25], [1.0, 1.0, 0.9], 150, 1, 1, 1e-5),
        ("x^2+y^2-1", [-1.5, -1.5, -1.0], [1.5, 1.5, 1.0], 61, 2, 0, 1e-4),
        // Touches four sides of the box.
        ("x^2+y^2-1", [-1.0; 3], [1.0; 3], 60, 2, 0, 1e-4),
        ("x-0.1", [-1.0; 3], [1.0; 3], 20, 1, 1, 1e-14),
        // Through two corners; through two edges.
        ("x+2y+3z", [-1.0; 3], [1.0; 3], 21, 1, 1, 1e-14),
        ("x-y", [-1.0; 3], [1.0; 3], 21, 1, 1, 1e-14),
        (SPHERES, [-1.0; 3], [2.0, 1.0, 1.0], 301, 1, 3, 1e-4),
    ] {
        assert_well_made(text, (min, max), faces, (loops, euler), limit);
    }
}

#[test]
fn large_surfaces_cut_by_a_box_are_so_too() {
    let r = 0.9 * PI;
    assert_well_made(GYROID, ([-r; 3], [r; 3]), 5000, (1, -3), 1e-6);
    assert_well_made(SCHWARZ_P, ([-6.0; 3], [6.0; 3]), 2500, (24, -32), 5e-5);
}

#[test]
fn open_surfaces_keep_a_tolerance() {
    for (text, min, max) in [(GYROID, [-3.0; 3], [3.0; 3]), (SPHERES, [-1.0; 3], [2.0, 1.0, 1.0])] {
        let fitted = made(text, min, max, Size::Tolerance(1e-4));
        let found = inspected(&fitted);
        assert!(fitted.reached, "{text}");
        assert!(found.seams.max_normal_jump <= 1e-9, "{text}: {:?}", found.seams);
        assert_ends_in_the_box(&fitted);
        let distance = found.deviation.unwrap().max_distance.max(found.coverage.unwrap().max_distance);
        assert!(distance <= 1e-4, "{text}: {distance:e}");
    }
}

#[test]
fn an_open_surface_looks_along_the_gradient_as_typed() {
    for text in ["x^2+y^2+z^2-1", "1-x^2-y^2-z^2"] {
        let fitted = made(text, [-2.0; 3], [2.0, 2.0, 0.5], Size::Faces(101));
        let base = &fitted.surface.base;
        assert!(!fitted.negated);
        let typed = Formula::parse(text, &Constants::new()).unwrap();
        let outward = |(p, n): (&Point3, &Point3)| typed.gradient(*p).1.dot(n) > 0.0;
        assert!(base.positions.iter().zip(&base.normals).all(outward), "{text}");
    }
}

#[test]
fn a_native_file_keeps_the_box() {
    let fitted = made("x^2+y^2-1", [-1.5, -1.5, -1.0], [1.5, 1.5, 1.0], Size::Faces(61));
    let mut bytes = Vec::new();
    write_native(&fitted.surface, &Provenance::default(), &mut bytes).unwrap();
    let model = read_native(&mut &*bytes).unwrap();
    let read = model.spline().unwrap();
    assert_eq!(read.base.clip, fitted.surface.base.clip);
    assert_eq!(read.nets, fitted.surface.nets);

    let mut moved = fitted.surface.clone();
    let clip = moved.base.clip.as_mut().unwrap();
    clip.bounds.max.z += 0.5;
    let vertex = clip.sides.iter().position(|s| s.iter().any(|s| s.axis == 2 && s.upper)).unwrap();
    bytes.clear();
    write_native(&moved, &Provenance::default(), &mut bytes).unwrap();
    let error = read_native(&mut &*bytes).unwrap_err();
    assert!(matches!(error, NativeError::Clip { vertex: v } if v == vertex), "{error}");
}
