//! Places where a formula is not smooth enough for a smooth surface.

use crate::base::BaseError;
use crate::field::{DomainError, Field, Formula, Kink};
use crate::geom::{Aabb, Point3, Vec3};

/// Why a formula has no smooth surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Defect {
    /// The formula has a kink on the surface.
    #[error("the formula is not differentiable on its surface, near {}: {kink}", show(at))]
    Kink {
        /// A point of the surface beside the kink.
        at: Point3,
        /// Which function, and its column.
        kink: Kink,
    },
    /// The formula has no value beside the surface.
    #[error("the formula has no value at {}: {error}", show(at))]
    Domain {
        /// Where.
        at: Point3,
        /// Which operation, and its column.
        error: DomainError,
    },
}

/// Coordinates for a message, without the sign of a zero.
fn show(p: &Point3) -> String {
    let rounded = p.map(|x| (x * 1e4).round() / 1e4 + 0.0);
    format!("({:.4}, {:.4}, {:.4})", rounded.x, rounded.y, rounded.z)
}

/// A kink is looked for on edges that start within this many of their lengths of one: the first-order distance may be off by a factor
/// on a coarse mesh.
const REACH: f64 = 2.0;
/// Points along an edge at which a kink is looked for before the nearest one is closed in on.
const EDGE_SAMPLES: usize = 9;
/// Thirds by which the stretch between two of these samples is shortened: (2/3)⁸⁰ is below rounding.
const THIRDS: usize = 80;
/// A point is on a kink, and on the surface, if it is nearer than this share of the diagonal.
const ON_KINK: f64 = 1e-9;
/// Distance on both sides of a kink, as a share of the diagonal, at which the two gradients are taken.
const BOTH_SIDES: f64 = 1e-7;
/// Steps along a kink to the surface; Newton's method takes four or five from an edge of the mesh.
const SLIDES: usize = 20;

/// A kink of the formula on the surface that a mesh approximates, if one of its edges, given by their ends, crosses one.
///
/// A kink beside the surface does not count: from where an edge crosses the kink, a point slides along the kink, and must
/// reach the surface within about the length of the edge.
pub fn find_defect(
    formula: &Formula,
    positions: &[Point3],
    edges: impl IntoIterator<Item = [usize; 2]>,
) -> Option<Defect> {
    if !formula.may_kink() {
        return None;
    }
    let diagonal = Aabb::around(positions).diagonal();
    // A vertex is the start of several edges.
    let mut distances: Vec<Option<f64>> = vec![None; positions.len()];
    edges.into_iter().find_map(|[v, w]| {
        let (a, b) = (positions[v], positions[w]);
        let distance = *distances[v].get_or_insert_with(|| kink_distance(formula, a));
        (distance <= REACH * (b - a).norm()).then(|| kink_on_edge(formula, [a, b], diagonal))?
    })
}

fn kink_on_edge(formula: &Formula, [a, b]: [Point3; 2], diagonal: f64) -> Option<Defect> {
    let length = (b - a).norm();
    let distance = |t: f64| kink_distance(formula, a + t * (b - a));
    let step = 1.0 / (EDGE_SAMPLES - 1) as f64;
    let samples = (0..EDGE_SAMPLES).map(|i| i as f64 * step);
    let nearest = samples.min_by(|s, t| distance(*s).total_cmp(&distance(*t)))?;
    if distance(nearest) > REACH * step * length {
        return None;
    }
    let (mut low, mut high) = ((nearest - step).max(0.0), (nearest + step).min(1.0));
    for _ in 0..THIRDS {
        let third = (high - low) / 3.0;
        if distance(low + third) < distance(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    let crossing = a + 0.5 * (low + high) * (b - a);
    if kink_distance(formula, crossing) > ON_KINK * diagonal {
        return None;
    }
    let at = slide_to_surface(formula, crossing, (b - a) / length, diagonal)?;
    let kink = formula.kink_near(at, ON_KINK * diagonal)?;
    ((at - crossing).norm() <= REACH * length).then_some(Defect::Kink { at, kink })
}

fn kink_distance(formula: &Formula, p: Point3) -> f64 {
    formula.kink_near(p, f64::INFINITY).map_or(f64::INFINITY, |kink| kink.distance)
}

/// From a point on a kink, which `across` crosses, along the kink to f = 0.
///
/// The gradients on both sides differ by a normal of the kink; their mean without its part along that normal is the slope
/// of f along the kink. None if f has no slope there, or no such point is found.
fn slide_to_surface(formula: &Formula, start: Point3, across: Vec3, diagonal: f64) -> Option<Point3> {
    let (mut p, mut across) = (start, across);
    for _ in 0..SLIDES {
        let beside = BOTH_SIDES * diagonal * across;
        let [ahead, behind] = [p + beside, p - beside].map(|q| formula.gradient(q).1);
        let normal = (ahead - behind).try_normalize(0.0)?;
        let mean = 0.5 * (ahead + behind);
        let slope = mean - mean.dot(&normal) * normal;
        let step = formula.value(p) / slope.norm_squared() * slope;
        if !step.iter().all(|x| x.is_finite()) || step.norm() > diagonal {
            return None;
        }
        p = back_to_kink(formula, p - step, &normal);
        across = normal;
        if step.norm() <= ON_KINK * diagonal {
            return Some(p);
        }
    }
    None
}

/// The point moved onto a curved kink along its normal.
fn back_to_kink(formula: &Formula, mut p: Point3, normal: &Vec3) -> Point3 {
    // The distance is of first order: every move squares what is left of it.
    const MOVES: usize = 4;
    for _ in 0..MOVES {
        let off = kink_distance(formula, p);
        let [q, r] = [p + off * normal, p - off * normal];
        let (at_q, at_r) = (kink_distance(formula, q), kink_distance(formula, r));
        match at_q.min(at_r) < off {
            true => p = if at_q < at_r { q } else { r },
            false => break,
        }
    }
    p
}

/// What the formula has to say about a failure of the base mesh: an undefined value or a kink near its place.
pub(super) fn explain(formula: &Formula, bounds: &Aabb, error: &BaseError) -> Option<Defect> {
    match error {
        BaseError::Undefined { at, .. } => {
            let at = at.unwrap_or_else(|| bounds.center());
            formula.domain_error(at).map(|error| Defect::Domain { at, error })
        }
        BaseError::NotOnSurface { at }
        | BaseError::Singular { at }
        | BaseError::InvertedCorner { at, .. } => {
            if let Some(error) = formula.domain_error(*at) {
                return Some(Defect::Domain { at: *at, error });
            }
            // A vertex that cannot come to rest beside a kink stops within a share of the smallest feature.
            const BESIDE: f64 = 1e-3;
            let kink = formula.kink_near(*at, BESIDE * bounds.diagonal())?;
            Some(Defect::Kink { at: *at, kink })
        }
        _ => None,
    }
}
