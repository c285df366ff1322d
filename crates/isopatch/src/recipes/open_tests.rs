//! Surfaces cut by a box, the whole way.

use super::spline::{Fitted, RecipeError, Size, SplineRecipe, fit};
use crate::base::BoxSides;
use crate::field::{Constants, Formula};
use crate::geom::Aabb;
use crate::inspect::{InspectOptions, Inspection, inspect};
use crate::mesh::EdgeId;
use std::f64::consts::PI;

const GYROID: &str = "sin(x)cos(y)+sin(y)cos(z)+sin(z)cos(x)";
const SCHWARZ_P: &str = "cos(x)+cos(y)+cos(z)";

fn made(text: &str, min: [f64; 3], max: [f64; 3], size: Size) -> Fitted {
    attempt(text, min, max, size).unwrap_or_else(|error| panic!("{text}, {size:?}: {error}"))
}

fn attempt(text: &str, min: [f64; 3], max: [f64; 3], size: Size) -> Result<Fitted, RecipeError> {
    let formula = Formula::parse(text, &Constants::new()).unwrap();
    let recipe = SplineRecipe { bounds: Some(Aabb::new(min.into(), max.into())), size, ..Default::default() };
    fit(&formula, &recipe, &|_| ())
}

fn inspected(fitted: &Fitted) -> Inspection {
    let options = InspectOptions { region: Some(fitted.bounds), ..Default::default() };
    inspect(&fitted.surface, &fitted.surface.base, Some(&fitted.formula), &options)
}

/// All control points of boundary curves lie in their side, to the bit; at a corner of the boundary in both.
fn assert_ends_in_the_box(fitted: &Fitted) {
    let base = &fitted.surface.base;
    let clip = base.clip.as_ref().unwrap();
    for e in base.mesh.edges() {
        let boundary = base.mesh.twin(base.mesh.edge_half_edge(e)).is_none();
        let sides = base.sides_of(e);
        assert_eq!(sides.len(), usize::from(boundary), "{e:?}");
        for p in fitted.surface.curves[e.index()].iter().chain(&row(fitted, e)) {
            assert!(BoxSides::of(p, &clip.bounds).contains_all(sides), "{e:?}: {p:?}");
        }
    }
}

/// The control points of a patch over an edge.
fn row(fitted: &Fitted, e: EdgeId) -> [crate::geom::Point3; 8] {
    let mesh = &fitted.surface.base.mesh;
    let h = mesh.edge_half_edge(e);
    let net = &fitted.surface.nets[mesh.face(h).index()];
    std::array::from_fn(|m| net[crate::bernstein::index::row(7, mesh.side(h), 0, m)])
}

#[test]
fn surfaces_cut_by_a_box_are_smooth_inside_and_end_in_its_sides() {
    let r = 0.9 * PI;
    for (text, min, max, faces) in [
        (GYROID, [-r; 3], [r; 3], 331),
        (GYROID, [-r; 3], [r; 3], 2000),
        // Through all corners of the box.
        (GYROID, [-PI; 3], [PI; 3], 400),
        (GYROID, [0.0; 3], [2.0 * PI; 3], 401),
        (SCHWARZ_P, [-r; 3], [r; 3], 300),
        (SCHWARZ_P, [-6.0; 3], [6.0; 3], 2500),
        ("sin(z)-sinh(x)sinh(y)", [-2.0, -2.0, -4.0], [2.0, 2.0, 4.0], 600),
        ("cos(x) exp(z) - cos(y)", [-4.0, -4.0, -1.5], [4.0, 4.0, 1.5], 700),
        ("x-0.1", [-1.0; 3], [1.0; 3], 20),
        ("x+2y+3z", [-1.0; 3], [1.0; 3], 21),
        ("x+y+z", [-1.0; 3], [1.0; 3], 21),
        ("x+y+z-1", [-1.0; 3], [1.0; 3], 21),
        ("x-y", [-1.0; 3], [1.0; 3], 21),
        ("x^2+y^2-1", [-1.0; 3], [1.0; 3], 60),
        ("z-x^2-y^2", [-1.0, -1.0, -0.25], [1.0, 1.0, 0.9], 150),
        ("x^2+y^2-1", [-1.5, -1.5, -1.0], [1.5, 1.5, 1.0], 60),
    ] {
        let fitted = match attempt(text, min, max, Size::Faces(faces)) {
            Ok(f) => f,
            Err(e) => {
                eprintln!("ERR loops {text} {e}");
                continue;
            }
        };
        let found = inspected(&fitted);
        let deviation = found.deviation.as_ref().unwrap();
        eprintln!(
            "{text} {faces}: {} loops {} jump {:.1e} max {:.1e} back {:?} n {:.2} folded {}",
            fitted.surface.nets.len(),
            found.topology.boundary_loops,
            found.seams.max_normal_jump,
            deviation.max_distance,
            found.coverage.map(|c| c.max_distance),
            deviation.max_normal_error.to_degrees(),
            deviation.folded
        );
        assert_eq!(fitted.surface.nets.len(), faces, "{text}");
        assert!(!fitted.negated);
        assert_ends_in_the_box(&fitted);
        assert!(
            found.seams.max_gap == 0.0 && found.seams.max_normal_jump < 1e-9,
            "{text}: {:?}",
            found.seams
        );
        assert_eq!(deviation.folded, 0, "{text}");
    }
}
