//! Bajaj & Xu 1997, sections 5 and 6, as printed where that can work, to compare with [`super::rational`] and [`super::algebraic`].
//!
//! ```text
//! wires            conics of least energy, Problems 1(i), 2(i), 3(i)              §5.1
//! normals on them  linear over linear, Problems 1(ii), 2(ii), 3(ii)               §5.2, Lemma 5.2
//! where there is   cubics of least energy through a point, quadratic normals      §5.3, §5.4
//! none of these
//! patches          over three conics: P2 + uvw P1 with (6.2), (6.13)              §6.2
//!                  else: the cubic cover, conditions by least squares             §6.1, §6.2
//! ```
//!
//! Other than printed are only signs and exchanged points (PAPERS.md, misprints). What it breaks is among the notes of the result: edges
//! without a conic or a normal function, patches whose conditions have no solution, and how far tangent planes on edges are off.

use super::algebraic::{self, AlgebraicError, AlgebraicRecipe, FittedAlgebraic};
use super::rational::{FittedRational, RationalError, RationalRecipe, Start};
use super::triangulated::word;
use crate::base::{FieldTarget, Repair};
use crate::bernstein::{curve, index, triangle};
use crate::field::Formula;
use crate::geom::{Point3, Points, Vec3};
use crate::io::read::PolygonMesh;
use crate::mesh::{EdgeId, Place};
use crate::network::wire::{self, WireEnd};
use crate::network::wire_conic::{Conic, ConicNormals};
use crate::network::wire_cubic::{Cubic, CubicNormals};
use crate::parallel::Evenly;
use crate::rational::{
    Frame, FrameError, RationalParts, RationalPatch, RationalSurface, conic, cubic, is_folded,
};
use crate::report::Seconds;
use crate::surface::Target;
use rayon::prelude::*;

/// Sines and cosines up to this count as 0: far above the rounding of computed normals, and far below any angle that is meant.
const TOLERANCE: f64 = 1e-9;
/// Singular values up to this, relative to the largest, are left out of least squares.
const SINGULAR: f64 = 1e-10;

/// What came of the scheme, in numbers of triangles and edges.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Edges that got a cubic, because no conic exists or no normal function on it.
    pub cubic_wires: Vec<u32>,
    /// Triangles with a cubic patch: a wire of theirs is a cubic.
    pub cubic_patches: Vec<u32>,
    /// Triangles whose patch is about (6.2) with dependent normals: the 9 × 9 system has no unique solution.
    pub relaxed_patches: Vec<u32>,
    /// Largest angle, in radians, between the tangent planes of cubic patches and the normal functions on their edges.
    pub normal_error: f64,
    /// Triangles whose patch folds over.
    pub folded: Vec<u32>,
}

/// Rational patches over a mesh; `recipe` gives normals, creases and the lattice for folds, and its rounds are not made.
///
/// # Errors
/// As [`super::rational::fit`].
pub fn fit(
    given: &PolygonMesh,
    recipe: &RationalRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedRational, RationalError> {
    let mut seconds = Seconds::default();
    let Start { base, source, sharp, normals, changed } = Start::new(given, recipe, &mut seconds, progress)?;
    let mesh = &base.mesh;
    let frame = Frame::over_mesh(mesh, &base.positions, &normals, &sharp);
    progress("patches");
    let (surface, outcome) = seconds.measure("patches", || over_frame(&frame, None, recipe.lattice))?;

    let of_face = |f: &u32| Place::Face(base.sources.face[*f as usize]);
    let of_wire = |w: &u32| base.sources.of_edge(mesh, EdgeId(*w));
    let places = Places { faces: &of_face, wires: &of_wire };
    let mut repairs = [base.repairs.as_slice(), &changed].concat();
    repairs.extend(outcome.notes(&places));
    let folded = outcome.folded.iter().map(|f| base.sources.face[*f as usize]).collect();
    let sharp_edges = sharp.iter().filter(|sharp| **sharp).count();
    Ok(FittedRational { surface, normals: source, sharp_edges, folded, repairs, seconds })
}

/// Rational patches over the surface of a polynomial: triangulation, singular set and limits of normals are those of
/// [`super::algebraic`], wires and patches those of the paper. A tolerance in `recipe` is that of the patches of [`super::algebraic`],
/// for which the triangulation is made.
///
/// # Errors
/// As [`super::algebraic::fit`].
pub fn fit_formula(
    formula: &Formula,
    recipe: &AlgebraicRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedAlgebraic, AlgebraicError> {
    let mut fitted = algebraic::fit(formula, recipe, progress)?;
    progress("wires and patches of the paper");
    let target = FieldTarget::new(formula, fitted.bounds.diagonal());
    let lattice = RationalRecipe::default().lattice;
    let frame = fitted.surface.frame().clone();
    let made = fitted.seconds.measure("paper", || over_frame(&frame, Some(&target), lattice))?;
    let (surface, outcome) = made;
    let places = Places { faces: &|f| Place::Face(*f), wires: &|w| edge_of_wire(&frame, *w) };
    fitted.notes.extend(outcome.notes(&places));
    Ok(FittedAlgebraic { surface, ..fitted })
}

/// How triangles and wires are named.
struct Places<'a> {
    faces: &'a dyn Fn(&u32) -> Place,
    wires: &'a dyn Fn(&u32) -> Place,
}

fn edge_of_wire(frame: &Frame, wire: u32) -> Place {
    let seam = frame.seams.iter().find(|seam| seam.wire == wire);
    let [a, b] = seam.map_or([0; 2], |seam| frame.ends(seam.first));
    Place::Edge(a, b)
}

impl Outcome {
    fn notes(&self, places: &Places<'_>) -> Vec<Repair> {
        let faces = |faces: &[u32]| faces.iter().map(places.faces).collect::<Vec<_>>();
        let wires: Vec<Place> = self.cubic_wires.iter().map(places.wires).collect();
        let off = format!("tangent planes on their edges are off by up to {:.2e} rad", self.normal_error);
        let notes = [
            word("cubic wires", &wires, "no conic with a normal function exists (Lemmas 5.1, 5.2)"),
            word("cubic patches", &faces(&self.cubic_patches), &off),
            word(
                "patches with dependent normals",
                &faces(&self.relaxed_patches),
                "the system of (6.13) has no unique solution",
            ),
            word("surface not certain", &faces(&self.folded), "a patch folds over"),
        ];
        notes.into_iter().flatten().collect()
    }
}

/// The patches over a frame, with the middle points of cubic wires and of patches brought onto `target` if there is one; folds are looked
/// for on a lattice with that many intervals.
///
/// # Errors
/// [`FrameError`] for a frame that does not fit together.
pub fn over_frame(
    frame: &Frame,
    target: Option<&dyn Target>,
    lattice: usize,
) -> Result<(RationalSurface, Outcome), FrameError> {
    frame.check()?;
    let wires = wires(frame, target);
    let uses = wires_of_edges(frame);
    let made: Vec<Made> = (0..frame.faces.len() as u32)
        .into_par_iter()
        .evenly()
        .map(|f| patch(frame, &wires, uses[f as usize], f, target))
        .collect();
    let lattice = triangle::lattice(lattice.max(1));
    let is_bad = |f: &u32| {
        let flat = flat_normal(frame, *f);
        is_folded(&made[*f as usize].patch, &frame.normals[*f as usize], &flat, &lattice)
    };
    let numbers = |kind: Kind| -> Vec<u32> {
        made.iter().zip(0..).filter(|(made, _)| made.kind == kind).map(|(_, f)| f).collect()
    };
    let is_cubic = |wire: &Wire| matches!(wire.curve, Curve::Cubic(_));
    let outcome = Outcome {
        cubic_wires: wires.iter().zip(0..).filter(|(wire, _)| is_cubic(wire)).map(|(_, w)| w).collect(),
        cubic_patches: numbers(Kind::Cubic),
        relaxed_patches: numbers(Kind::Relaxed),
        normal_error: made.iter().map(|made| made.normal_error).fold(0.0, f64::max),
        folded: (0..made.len() as u32).filter(is_bad).collect(),
    };
    let inner = |wire: &Wire| {
        let [_, first, second, _] = wire.curve.cubic().bezier();
        [first, second]
    };
    let surface = RationalSurface::from_parts(RationalParts {
        frame: frame.clone(),
        wire_starts: wires.iter().map(|wire| wire.start).collect(),
        wires: wires.iter().map(inner).collect(),
        patches: made
            .into_iter()
            .map(|Made { patch, .. }| (patch.net[MIDDLE], patch.across, patch.middle))
            .collect(),
    })?;
    Ok((surface, outcome))
}

/// Position of the middle point in a cubic net.
const MIDDLE: usize = index::position([1, 1, 1]);
const CENTROID: [f64; 3] = [1.0 / 3.0; 3];

/// The curve of a wire, along it.
#[derive(Clone)]
enum Curve {
    Conic(Conic<f64>),
    Cubic(Cubic<f64>),
}

impl Curve {
    /// As a cubic in any case.
    fn cubic(&self) -> Cubic<f64> {
        match self {
            Self::Conic(Conic { a, b, c }) => Cubic { a: Vec3::zeros(), b: *a, c: *b, d: *c },
            Self::Cubic(cubic) => cubic.clone(),
        }
    }

    /// From its end to its start.
    fn reversed(&self) -> Self {
        match self {
            Self::Conic(Conic { a, b, c }) => Self::Conic(Conic { a: *a, b: -(2.0 * a + b), c: a + b + c }),
            Self::Cubic(Cubic { a, b, c, d }) => {
                Self::Cubic(Cubic { a: -a, b: 3.0 * a + b, c: -(3.0 * a + 2.0 * b + c), d: a + b + c + d })
            }
        }
    }
}

/// A wire, and the normals that all triangles along it share at its ends.
struct Wire {
    start: u32,
    normals: [Option<Vec3>; 2],
    curve: Curve,
}

/// Vertices at the ends of a wire, and the normals that all triangles along it share there.
type Shared = ([u32; 2], [Option<Vec3>; 2]);

/// Problems 1 to 3 for every wire.
fn wires(frame: &Frame, target: Option<&dyn Target>) -> Vec<Wire> {
    let mut found: Vec<Option<Shared>> = vec![None; frame.wire_count()];
    for seam in &frame.seams {
        for side in std::iter::once(seam.first).chain(seam.second) {
            let (ends, of_side) = (frame.ends(side), frame.end_normals(side));
            let (first, shared) = found[seam.wire as usize].get_or_insert((ends, of_side));
            let turned = ends[0] != first[0];
            for end in 0..2 {
                let here = of_side[if turned { 1 - end } else { end }];
                shared[end] = shared[end].filter(|n| here == Some(*n));
            }
        }
    }
    let made = |found: Option<Shared>| {
        let (ends, normals) = found.unwrap_or_default();
        let p = ends.map(|v| frame.positions[v as usize]);
        Wire { start: ends[0], normals, curve: curve(p, normals, target) }
    };
    found.into_par_iter().evenly().map(made).collect()
}

/// The conic of least energy; the cubic where there is none with a normal function.
fn curve(p: [Point3; 2], normals: [Option<Vec3>; 2], target: Option<&dyn Target>) -> Curve {
    let ends = [&p[0], &p[1]];
    match normals {
        [None, None] => Curve::Conic(Conic::straight(ends)),
        [Some(n), None] => Curve::Conic(Conic::with_one_normal(ends, &n, 0)),
        [None, Some(n)] => Curve::Conic(Conic::with_one_normal(ends, &n, 1)),
        [Some(n0), Some(n1)] => {
            let n = [&n0, &n1];
            let conic = Conic::with_two_normals(ends, n, &TOLERANCE).ok();
            match conic.filter(|conic| conic.normals(n, &TOLERANCE).is_ok()) {
                Some(conic) => Curve::Conic(conic),
                None => {
                    let guess = wire::wire(p, [WireEnd::Plane(n0), WireEnd::Plane(n1)]);
                    let middle = on_target(curve::point(&guess, 0.5), target);
                    Curve::Cubic(Cubic::through([&p[0], &middle, &p[1]], n, &TOLERANCE))
                }
            }
        }
    }
}

fn on_target(p: Point3, target: Option<&dyn Target>) -> Point3 {
    let Some(target) = target else { return p };
    let mut points: Points = std::iter::once(p).collect();
    target.project(&mut points);
    points.get(0)
}

/// The wire of each edge of each triangle.
fn wires_of_edges(frame: &Frame) -> Vec<[u32; 3]> {
    let mut uses = vec![[0; 3]; frame.faces.len()];
    for seam in &frame.seams {
        for (face, edge) in std::iter::once(seam.first).chain(seam.second) {
            uses[face as usize][usize::from(edge)] = seam.wire;
        }
    }
    uses
}

/// How a patch was made.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Conic,
    Relaxed,
    Cubic,
}

struct Made {
    patch: RationalPatch,
    kind: Kind,
    normal_error: f64,
}

/// The patch of a triangle.
fn patch(frame: &Frame, wires: &[Wire], uses: [u32; 3], f: u32, target: Option<&dyn Target>) -> Made {
    let edges = [0, 1, 2].map(|k| Edge::new(frame, wires, uses, f, k));
    if let [Curve::Conic(c0), Curve::Conic(c1), Curve::Conic(c2)] = edges.each_ref().map(|edge| &edge.curve) {
        // (6.1), (6.13)
        let net = conic::cover([c0, c1, c2]);
        let conditions = [0, 1, 2].map(|k| {
            let numerator = edges[k].numerator;
            conic::condition(&net, &ConicNormals { numerator, one_plus_w: 1.0 }, k)
        });
        let covered = conic::patch(&net, &[Vec3::zeros(); 3]).evaluate([CENTROID[0], CENTROID[1]]).point;
        // P = P2 + uvw P1, and uvw = 1/27 at the centroid.
        let middle = 27.0 * (on_target(covered, target) - covered);
        let unique = conic::vectors(&conditions, &middle);
        let kind = if unique.is_some() { Kind::Conic } else { Kind::Relaxed };
        let vectors = unique.unwrap_or_else(|| conic::vectors_relaxed(&conditions, &middle, SINGULAR));
        return Made { patch: conic::patch(&net, &vectors), kind, normal_error: 0.0 };
    }
    let curves = edges.each_ref().map(|edge| edge.curve.cubic());
    let normals = edges.each_ref().map(Edge::cubic_normals);
    let flat = RationalPatch::over_wires(&curves.each_ref().map(Cubic::bezier));
    let middle = on_target(flat.evaluate([CENTROID[0], CENTROID[1]]).point, target);
    let cover = cubic::cover(curves.each_ref(), CENTROID, &middle).unwrap_or(flat);
    let made = cubic::patch(&cover, normals.each_ref(), SINGULAR);
    Made { patch: made.patch, kind: Kind::Cubic, normal_error: made.normal_error }
}

/// An edge of a triangle, in its direction.
struct Edge {
    curve: Curve,
    /// Bernstein coefficients of the numerator of the normal function of a conic.
    numerator: [Vec3; 2],
}

impl Edge {
    fn new(frame: &Frame, wires: &[Wire], uses: [u32; 3], f: u32, k: usize) -> Self {
        let (curve, normals) = directed(frame, wires, uses, f, k);
        let numerator = match (&curve, normals) {
            // Lemma 5.2
            (Curve::Conic(conic), [Some(n0), Some(n1)]) => {
                conic.normals([&n0, &n1], &TOLERANCE).map_or([n0, n1], |of| of.numerator)
            }
            // Problem 2(ii)
            (Curve::Conic(conic), [Some(n), None]) => with_companion(conic, &n, 0),
            (Curve::Conic(conic), [None, Some(n)]) => with_companion(conic, &n, 1),
            // Problem 3(ii): the normals of the triangle itself, or those that its other edges have there.
            (Curve::Conic(_), [None, None]) => {
                [0, 1].map(|end| corner_normal(frame, wires, uses, f, (k + end) % 3, k))
            }
            (Curve::Cubic(_), normals) => normals.map(|n| n.unwrap_or_else(Vec3::zeros)),
        };
        Self { curve, numerator }
    }

    /// The normal function as a quadratic polynomial.
    fn cubic_normals(&self) -> CubicNormals<f64> {
        let [n0, n1] = &self.numerator;
        match &self.curve {
            Curve::Conic(_) => CubicNormals { e: Vec3::zeros(), f: n1 - n0, g: *n0 },
            Curve::Cubic(cubic) => cubic.normals_least_squares([n0, n1], SINGULAR),
        }
    }
}

/// Curve and shared normals of an edge, in its direction.
fn directed(frame: &Frame, wires: &[Wire], uses: [u32; 3], f: u32, k: usize) -> (Curve, [Option<Vec3>; 2]) {
    let Wire { start, normals: [n0, n1], curve } = &wires[uses[k] as usize];
    match frame.faces[f as usize][k] == *start {
        true => (curve.clone(), [*n0, *n1]),
        false => (curve.reversed(), [*n1, *n0]),
    }
}

/// Numerator of the normal function of a conic with one normal.
fn with_companion(conic: &Conic<f64>, n: &Vec3, end: usize) -> [Vec3; 2] {
    let other = conic.companion_normal(n, end);
    let ends = if end == 0 { [*n, other] } else { [other, *n] };
    conic.normals([&ends[0], &ends[1]], &TOLERANCE).map_or(ends, |of| of.numerator)
}

/// The normal of a triangle at a corner, for its edge `k` along which no normal is shared: its own, or the companion that its other
/// edge has there, or that of the flat triangle.
fn corner_normal(frame: &Frame, wires: &[Wire], uses: [u32; 3], f: u32, corner: usize, k: usize) -> Vec3 {
    let other = if k == corner { (corner + 2) % 3 } else { corner };
    let of_other = || {
        let (curve, normals) = directed(frame, wires, uses, f, other);
        match (curve, normals) {
            (Curve::Conic(conic), [Some(n), None]) if other != corner => Some(conic.companion_normal(&n, 0)),
            (Curve::Conic(conic), [None, Some(n)]) if other == corner => Some(conic.companion_normal(&n, 1)),
            _ => None,
        }
    };
    let found = frame.normals[f as usize][corner].or_else(of_other).filter(|n| *n != Vec3::zeros());
    found.unwrap_or_else(|| flat_normal(frame, f))
}

fn flat_normal(frame: &Frame, f: u32) -> Vec3 {
    let [a, b, c] = frame.corners(f);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}
