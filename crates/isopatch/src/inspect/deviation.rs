//! From the surface to the zero set of the field: distances and normal errors of fresh samples.

use super::foot;
use super::or_infinite;
use super::samples::{PatchSamples, SampleSet};
use crate::bernstein::triangle;
use crate::field::Field;
use crate::geom::{Points, Widest};
use crate::parallel::Evenly;
use crate::surface::{PatchId, Surface};
use rayon::prelude::*;
use std::ops::Range;

/// A patch whose normal is farther than this off the field's somewhere is counted as bad: 20°, in radians.
pub const NORMAL_ERROR_LIMIT: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Patches that are sampled together: enough points for the field's batch form, few enough to stay in cache.
const CHUNK: usize = 4;

/// What the samples of one patch show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchDeviation {
    /// Largest distance to the zero set, relative to the diagonal.
    pub max_distance: f64,
    /// Largest |f| / |∇f|, relative to the diagonal.
    pub max_first_order: f64,
    /// Largest angle between the patch normal and ∇f, both at the sample, in radians.
    pub max_normal_error: f64,
    /// Does the patch normal point against ∇f, or along the surface, somewhere?
    pub folded: bool,
}

/// Distance and normal error from the surface to the zero set of a field, measured on samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// Largest distance to the closest point of the zero set, relative to the diagonal; infinite if no such point
    /// was found for some sample.
    pub max_distance: f64,
    /// Area-weighted root mean square of that distance, relative to the diagonal.
    pub rms_distance: f64,
    /// Largest |f| / |∇f|, the first-order estimate of the distance, relative to the diagonal.
    pub max_first_order: f64,
    /// Area-weighted root mean square of |f| / |∇f|, relative to the diagonal.
    pub rms_first_order: f64,
    /// Largest angle between the patch normal and ∇f, both at the sample, in radians; π where one vanishes.
    pub max_normal_error: f64,
    /// Patch of the largest distance.
    pub worst_distance: Option<PatchId>,
    /// Patch of the largest normal error.
    pub worst_normal: Option<PatchId>,
    /// Number of patches with a normal error over [`NORMAL_ERROR_LIMIT`].
    pub over_limit: usize,
    /// Number of folded patches.
    pub folded: usize,
    /// Every patch on its own.
    pub patches: Vec<PatchDeviation>,
}

/// Area-weighted sums of squares of some samples.
#[derive(Clone, Copy, Default)]
struct Squares {
    area: f64,
    distance: f64,
    first_order: f64,
}

/// Samples every patch at the barycentric lattice with `lattice` intervals, its boundary included.
///
/// The field is negative inside, the patches are oriented outwards. The distance is that of the foot which the
/// gradient leads to: the closest point, if the sample is nearer to the zero set than its centre of curvature.
pub fn deviation(surface: &dyn Surface, field: &dyn Field, diagonal: f64, lattice: usize) -> Deviation {
    deviation_at(surface, field, diagonal, &triangle::lattice(lattice.max(1)))
}

/// The same at any barycentric parameters.
pub(super) fn deviation_at(
    surface: &dyn Surface,
    field: &dyn Field,
    diagonal: f64,
    parameters: &[[f64; 3]],
) -> Deviation {
    let set = SampleSet::new(surface, parameters);
    let patches: Vec<PatchId> = surface.patches().collect();
    let chunks: Vec<_> = patches
        .par_chunks(CHUNK)
        .evenly()
        .map(|chunk| measure(field, &set.sample(surface, chunk), set.count(), diagonal))
        .collect();
    let mut squares = Squares::default();
    for (_, s) in &chunks {
        squares.area += s.area;
        squares.distance += s.distance;
        squares.first_order += s.first_order;
    }
    summary(chunks.into_iter().flat_map(|(patches, _)| patches).collect(), &squares)
}

/// The same for some patches, each on its own.
pub fn deviation_of(
    surface: &dyn Surface,
    field: &dyn Field,
    diagonal: f64,
    lattice: usize,
    patches: &[PatchId],
) -> Vec<PatchDeviation> {
    let set = SampleSet::new(surface, &triangle::lattice(lattice.max(1)));
    let chunks: Vec<Vec<PatchDeviation>> = patches
        .par_chunks(CHUNK)
        .evenly()
        .map(|chunk| measure(field, &set.sample(surface, chunk), set.count(), diagonal).0)
        .collect();
    chunks.concat()
}

fn summary(patches: Vec<PatchDeviation>, squares: &Squares) -> Deviation {
    let (max_distance, worst_distance) = worst(&patches, |p| p.max_distance);
    let (max_normal_error, worst_normal) = worst(&patches, |p| p.max_normal_error);
    Deviation {
        max_distance,
        rms_distance: (squares.distance / squares.area).sqrt(),
        max_first_order: worst(&patches, |p| p.max_first_order).0,
        rms_first_order: (squares.first_order / squares.area).sqrt(),
        max_normal_error,
        worst_distance,
        worst_normal,
        over_limit: patches.iter().filter(|p| p.max_normal_error > NORMAL_ERROR_LIMIT).count(),
        folded: patches.iter().filter(|p| p.folded).count(),
        patches,
    }
}

/// The largest value and the first patch that has it.
fn worst(patches: &[PatchDeviation], value: impl Fn(&PatchDeviation) -> f64) -> (f64, Option<PatchId>) {
    patches.iter().enumerate().fold((0.0, None), |(max, id), (i, p)| {
        if value(p) > max { (value(p), Some(PatchId(i as u32))) } else { (max, id) }
    })
}

/// Deviations of the patches of one chunk, `count` samples each.
fn measure(
    field: &dyn Field,
    samples: &PatchSamples,
    count: usize,
    diagonal: f64,
) -> (Vec<PatchDeviation>, Squares) {
    let n = samples.points.len();
    let (mut f, mut gradient) = (vec![0.0; n], Points::zeros(n));
    field.gradients(samples.points.view(), &mut f, gradient.view_mut());
    let distances = foot::distances(field, &samples.points, &f, &gradient, diagonal);
    let mut squares = Squares::default();
    let patch = |range: Range<usize>| {
        let mut patch =
            PatchDeviation { max_distance: 0.0, max_first_order: 0.0, max_normal_error: 0.0, folded: false };
        let mut widest = Widest::default();
        for i in range {
            let (normal, g) = (samples.du.get(i).cross(&samples.dv.get(i)), gradient.get(i));
            let first_order = or_infinite(f[i].abs() / g.norm()) / diagonal;
            let distance = distances[i] / diagonal;
            patch.max_distance = patch.max_distance.max(distance);
            patch.max_first_order = patch.max_first_order.max(first_order);
            patch.folded |= !widest.add(normal, g);
            let area = normal.norm();
            squares.area += area;
            squares.distance += area * distance * distance;
            squares.first_order += area * first_order * first_order;
        }
        patch.max_normal_error = widest.angle();
        patch
    };
    let patches = (0..n / count).map(|i| i * count..(i + 1) * count).map(patch).collect();
    (patches, squares)
}
