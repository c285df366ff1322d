//! Rational patches over a conforming mesh that is made finer where they need it.
//!
//! A mesh whose flat triangles are close to the surface is finer than patches need in some places and coarser in others: a patch is
//! bad where its wires turn much, whatever the distance of the triangle. So patches are measured, and edges of bad ones divided.

use super::algebraic::over_singular_mesh;
use crate::bernstein::triangle;
use crate::field::Formula;
use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use crate::rational::{Built, FrameError, is_folded_over};
use crate::singular::mesh::{SingularMesh, SplitLimits, Triangulated, split_edges};
use crate::surface::{PatchId, Surface, Target};
use rayon::prelude::*;

/// When a mesh is fine enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptGoal {
    /// Largest |f| / |∇f| on a patch, a length.
    pub distance: f64,
    /// Most triangles.
    pub triangles: usize,
    /// Distance that flat triangles may have after edges are flipped, a length.
    pub flat: f64,
}

/// Rounds in which edges are divided.
const ROUNDS: usize = 24;
/// Intervals of the lattice on which patches are measured.
const LATTICE: usize = 10;
/// With a number of triangles as the goal, patches whose distance is above this share of the largest are divided.
const SHARE_OF_WORST: f64 = 0.5;
/// Weight of the length of an edge beside the height of its wire over the chord, for which of three is divided.
const LENGTH_WEIGHT: f64 = 0.05;

/// Patches over the mesh, divided where they are farther from the surface than the goal or fold; the mesh becomes that of the result.
///
/// # Errors
/// [`FrameError`] for a mesh that does not fit together.
pub fn adapt(
    formula: &Formula,
    bounds: &Aabb,
    found: &mut Triangulated,
    target: &dyn Target,
    goal: &AdaptGoal,
) -> Result<Built, FrameError> {
    let floor = found.gradient_floor;
    let made_over = |mesh: SingularMesh| -> Result<Made, FrameError> {
        let built = over_singular_mesh(&mesh, Some(target))?;
        let patches = measure(formula, &built, floor);
        Ok(Made { mesh, built, patches })
    };
    let mut made = made_over(found.mesh.clone())?;
    let mut best = made.clone();
    for _ in 0..ROUNDS {
        let edges = edges_to_divide(&made, goal);
        // An edge has two triangles, most often, and each becomes two.
        let limits = SplitLimits {
            edges: goal.triangles.saturating_sub(made.mesh.triangles.len()) / 2,
            tolerance: goal.flat,
            floor,
        };
        let mut mesh = made.mesh;
        if split_edges(formula, bounds, &mut mesh, &edges, &limits) == 0 {
            break;
        }
        made = made_over(mesh)?;
        if made.quality().is_better(&best.quality()) {
            best = made.clone();
        }
    }
    found.mesh = best.mesh;
    Ok(best.built)
}

/// Patches over a mesh.
#[derive(Clone)]
struct Made {
    mesh: SingularMesh,
    built: Built,
    patches: Vec<Measured>,
}

impl Made {
    fn quality(&self) -> Quality {
        Quality {
            folded: self.patches.iter().filter(|p| p.folded).count(),
            distance: self.patches.iter().map(|p| p.distance).fold(0.0, f64::max),
        }
    }
}

/// What is measured on a patch.
#[derive(Clone, Copy)]
struct Measured {
    distance: f64,
    folded: bool,
}

/// How good a surface is: fewer folds count first.
#[derive(Clone, Copy, Debug)]
struct Quality {
    folded: usize,
    distance: f64,
}

impl Quality {
    fn is_better(&self, other: &Self) -> bool {
        (self.folded, self.distance) < (other.folded, other.distance)
    }
}

fn measure(formula: &Formula, built: &Built, floor: f64) -> Vec<Measured> {
    use crate::field::Field;
    let lattice = triangle::lattice(LATTICE);
    let of = |patch: PatchId| {
        let at = |l: &[f64; 3]| {
            let (f, gradient) = formula.gradient(built.surface.sample(patch, [l[0], l[1]]).point);
            f.abs() / gradient.norm().max(floor)
        };
        Measured {
            distance: lattice.iter().map(at).fold(0.0, f64::max),
            folded: is_folded_over(&built.surface, patch, &lattice),
        }
    };
    (0..built.surface.patch_count() as u32).into_par_iter().evenly().map(|p| of(PatchId(p))).collect()
}

/// The edges of every patch that is not good enough: the worst patch first, and of each first that edge whose wire is highest over its chord.
/// Each with the middle of its wire.
fn edges_to_divide(made: &Made, goal: &AdaptGoal) -> Vec<([u32; 2], Point3)> {
    let Made { built, patches, .. } = made;
    let worst = made.quality().distance;
    let allowed = if goal.distance > 0.0 { goal.distance } else { SHARE_OF_WORST * worst };
    let badness = |p: &Measured| if p.folded { f64::INFINITY } else { p.distance };
    let mut bad: Vec<(usize, f64)> = patches.iter().map(badness).enumerate().collect();
    bad.retain(|(_, badness)| *badness > allowed);
    bad.sort_by(|a, b| b.1.total_cmp(&a.1));
    // What is smaller than the flat triangles show does not become better by more of it.
    let position = |v: u32| built.surface.positions()[v as usize];
    let is_long = |([a, b], _): &([u32; 2], Point3)| (position(*a) - position(*b)).norm() > goal.flat;
    bad.into_iter().flat_map(|(patch, _)| edges_of(built, PatchId(patch as u32))).filter(is_long).collect()
}

fn edges_of(built: &Built, patch: PatchId) -> [([u32; 2], Point3); 3] {
    let corners = built.surface.corners(patch);
    let mut edges = [0, 1, 2].map(|k: usize| {
        let [p0, p1, p2, p3] = built.surface.patch(patch).wire(k);
        let chord = (p3 - p0).normalize();
        let height = |p: Point3| (p - p0).cross(&chord).norm();
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let score = height(p1) + height(p2) + LENGTH_WEIGHT * (p3 - p0).norm();
        (score, ([a.min(b), a.max(b)], 0.125 * (p0 + p3) + 0.375 * (p1 + p2)))
    });
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    edges.map(|(_, edge)| edge)
}
