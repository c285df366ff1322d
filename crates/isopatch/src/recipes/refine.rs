//! From the error of every patch to the edge lengths of the next base mesh.

use crate::base::{BaseMesh, edge_lengths};
use crate::inspect::PatchDeviation;

/// The error of a patch falls with this power of its edge length (between 4 and 6 were seen; PAPERS.md, deviations).
const ORDER: f64 = 5.0;
/// Edge lengths change by at most these factors in one round.
const CHANGE: [f64; 2] = [0.5, 1.6];
/// Faces that a patch becomes at least when it is divided together with its neighbours.
const DIVISION: f64 = 3.0;
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

/// Is the patch bad, or farther than `tolerance` from the zero set? So is one whose distance is not a number.
pub(super) fn misses(patch: &PatchDeviation, tolerance: f64) -> bool {
    is_bad(patch) || patch.max_distance > tolerance || patch.max_distance.is_nan()
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

/// Faces that are to be expected when every patch that is beyond `tolerance` has been divided.
pub(super) fn expected_faces(patches: &[PatchDeviation], tolerance: f64) -> f64 {
    let parts = |p: &PatchDeviation| {
        let parts = (p.max_distance / tolerance).max(1.0).powf(2.0 / ORDER);
        if is_bad(p) || parts > 1.0 { DIVISION * parts } else { 1.0 }
    };
    patches.iter().map(parts).sum()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{BaseOptions, from_mesh};
    use crate::field::{Constants, Formula};
    use crate::geom::Point3;

    fn octahedron() -> BaseMesh {
        let axes = [Point3::x(), Point3::y(), -Point3::x(), -Point3::y(), Point3::z(), -Point3::z()];
        let faces =
            [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5u32]];
        let sphere = Formula::parse("x^2+y^2+z^2-1", &Constants::new()).unwrap();
        from_mesh(&sphere, &axes, &faces, &BaseOptions::default()).unwrap().base
    }

    fn patches(errors: [f64; 8]) -> Vec<PatchDeviation> {
        let patch = |max_distance| PatchDeviation {
            max_distance,
            max_first_order: max_distance,
            max_normal_error: 0.0,
            folded: false,
        };
        errors.map(patch).to_vec()
    }

    #[test]
    fn equal_errors_ask_for_equal_lengths_and_the_count_that_the_order_predicts() {
        let wish = lengths_for_error(&octahedron(), &patches([3.2e-4; 8]), 1e-5);
        // Lengths shrink by 32^(1/5) = 2, so a face becomes four.
        assert!(wish.lengths.iter().all(|l| (l - 0.5 * 2f64.sqrt()).abs() < 1e-12), "{wish:?}");
        assert_eq!(wish.faces, 32);
    }

    #[test]
    fn a_vertex_of_one_bad_face_gets_short_edges() {
        let mut patches = patches([1e-5; 8]);
        patches[0].folded = true;
        let wish = lengths_for_error(&octahedron(), &patches, 1e-5);
        for (v, length) in wish.lengths.iter().enumerate() {
            let expected = if [0, 1, 4].contains(&v) { SHRINK } else { 1.0 } * 2f64.sqrt();
            assert!((length - expected).abs() < 1e-12, "vertex {v}: {length}");
        }
    }

    #[test]
    fn the_median_is_that_of_the_largest_distances() {
        assert_eq!(median_error(&patches([5.0, 1.0, 2.0, 8.0, 3.0, 4.0, 7.0, 6.0])), 5.0);
        assert_eq!(median_error(&[]), 0.0);
    }
}
