//! Places where a formula is not smooth enough for a smooth surface.

use crate::base::{BaseError, BaseMesh, ProjectOptions, project_points};
use crate::field::{DomainError, Formula, Kink};
use crate::geom::{Aabb, Point3, Points};
use crate::mesh::EdgeId;

/// Why a formula has no smooth surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Defect {
    /// The formula has a kink on the surface.
    #[error("the formula is not differentiable on its surface, near ({:.4}, {:.4}, {:.4}): {kink}", at.x, at.y, at.z)]
    Kink {
        /// A point of the surface beside the kink.
        at: Point3,
        /// Which function, and its column.
        kink: Kink,
    },
    /// The formula has no value beside the surface.
    #[error("the formula has no value at ({:.4}, {:.4}, {:.4}): {error}", at.x, at.y, at.z)]
    Domain {
        /// Where.
        at: Point3,
        /// Which operation, and its column.
        error: DomainError,
    },
}

/// Points along an edge at which a kink is looked for before the nearest one is closed in on.
const EDGE_SAMPLES: usize = 9;
/// Halvings of the stretch between two of these samples: its length in the end is below rounding of the tests.
const HALVINGS: usize = 40;
/// A point is on a kink if it is nearer than this share of the diagonal.
const ON_KINK: f64 = 1e-9;

/// A kink of the formula on the surface that a base mesh approximates, if an edge of the mesh crosses one.
///
/// A kink beside the surface does not count: points of the edges near one are projected onto the surface, and the kink
/// must come down to distance zero there.
pub fn find_defect(formula: &Formula, base: &BaseMesh) -> Option<Defect> {
    let diagonal = base.diagonal();
    base.mesh.edges().find_map(|e| kink_on_edge(formula, base, e, diagonal))
}

fn kink_on_edge(formula: &Formula, base: &BaseMesh, edge: EdgeId, diagonal: f64) -> Option<Defect> {
    let h = base.mesh.edge_half_edge(edge);
    let [a, b] = [base.mesh.origin(h), base.mesh.dest(h)].map(|v| base.positions[v.index()]);
    let length = (b - a).norm();
    // The first-order distance may be off by a factor on a coarse mesh.
    const REACH: f64 = 2.0;
    formula.kink_near(a, REACH * length)?;
    let probe = |t: f64| {
        let p = on_surface(formula, a + t * (b - a), diagonal);
        formula.kink_near(p, REACH * length).map_or((f64::INFINITY, p, None), |k| (k.distance, p, Some(k)))
    };
    let step = 1.0 / (EDGE_SAMPLES - 1) as f64;
    let nearest =
        (0..EDGE_SAMPLES).map(|i| i as f64 * step).min_by(|s, t| probe(*s).0.total_cmp(&probe(*t).0))?;
    let (mut low, mut high) = ((nearest - step).max(0.0), (nearest + step).min(1.0));
    for _ in 0..HALVINGS {
        let third = (high - low) / 3.0;
        if probe(low + third).0 < probe(high - third).0 {
            high -= third;
        } else {
            low += third;
        }
    }
    match probe(0.5 * (low + high)) {
        (distance, at, Some(kink)) if distance <= ON_KINK * diagonal => Some(Defect::Kink { at, kink }),
        _ => None,
    }
}

fn on_surface(formula: &Formula, p: Point3, diagonal: f64) -> Point3 {
    let mut points: Points = [p].into_iter().collect();
    project_points(formula, &mut points, diagonal, &ProjectOptions::default());
    points.get(0)
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
