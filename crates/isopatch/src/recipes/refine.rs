//! From the error of every patch to the edge lengths of the next base mesh.

use crate::base::{BaseMesh, edge_lengths};
use crate::inspect::PatchDeviation;

/// The error of a patch falls with this power of its edge length (between 4 and 6 were seen; PAPERS.md, deviations).
const ORDER: f64 = 5.0;
/// Edge lengths change by at most these factors in one round.
const CHANGE: [f64; 2] = [0.5, 1.6];
/// Factor for the edges of a patch that folds, or whose normal is far off.
const SHRINK: f64 = 0.6;

/// What the next base mesh is to look like.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wish {
    /// Wanted edge length at each vertex of the present mesh.
    pub lengths: Vec<f64>,
    /// Number of faces that these lengths come to.
    pub faces: usize,
    /// Why the mesh is remade, if that is a repair.
    pub reason: Option<&'static str>,
}

/// Is the patch unusable, or its normal farther off than [`crate::inspect::NORMAL_ERROR_LIMIT`]?
pub(super) fn is_bad(patch: &PatchDeviation) -> bool {
    patch.folded || patch.max_normal_error > crate::inspect::NORMAL_ERROR_LIMIT
}

/// Edge lengths for which every patch would have the error `goal` (relative to the diagonal).
pub(super) fn lengths_for_error(base: &BaseMesh, patches: &[PatchDeviation], goal: f64) -> Wish {
    wish(base, |face| {
        let patch = &patches[face];
        if is_bad(patch) {
            return SHRINK;
        }
        (goal / patch.max_distance).powf(1.0 / ORDER).clamp(CHANGE[0], CHANGE[1])
    })
}

/// Present lengths, shorter at the given vertices.
pub(super) fn shorter_at(base: &BaseMesh, vertices: &[u32]) -> Wish {
    wish(base, |face| {
        let touched = base.mesh.triangle(face.into()).iter().any(|v| vertices.contains(&v.0));
        if touched { SHRINK } else { 1.0 }
    })
}

/// Lengths from a factor for each face: at a vertex, the geometric mean of those of its faces, but no more than that of a
/// face that is to shrink. A face whose edges shrink by s becomes 1/s² faces.
fn wish(base: &BaseMesh, factor: impl Fn(usize) -> f64) -> Wish {
    let factors: Vec<f64> = (0..base.mesh.face_count()).map(factor).collect();
    let mut lengths = edge_lengths(base);
    for (v, length) in base.mesh.vertices().zip(&mut lengths) {
        let around = || base.mesh.ring(v).map(|h| factors[base.mesh.face(h).index()]);
        let count = around().count() as f64;
        let mean = (around().map(f64::ln).sum::<f64>() / count).exp();
        let shrinking = around().filter(|f| *f < 1.0).fold(f64::INFINITY, f64::min);
        *length *= mean.min(shrinking);
    }
    let faces = factors.iter().map(|s| 1.0 / (s * s)).sum::<f64>().round() as usize;
    Wish { lengths, faces: faces + faces % 2, reason: None }
}

/// The error that half of the patches exceed.
pub(super) fn median_error(patches: &[PatchDeviation]) -> f64 {
    let mut errors: Vec<f64> = patches.iter().map(|p| p.max_distance).collect();
    let middle = errors.len() / 2;
    if errors.is_empty() {
        return 0.0;
    }
    *errors.select_nth_unstable_by(middle, f64::total_cmp).1
}
