//! Samples of curves in a side of the box that cuts the surface.

use super::ends::{Ends, TRUST};
use super::quartic::SAMPLES;
use crate::geom::Points;
use crate::surface::Target;

/// Newton steps of samples within a side of the box, at most: from points projected in space, three or four are usual.
const SECTION_STEPS: usize = 8;

/// Puts the samples of curves in a side of the box onto the section of the target by it, from where they are.
///
/// A step is limited to [`TRUST`] chords: where the surface is almost parallel to the side, the section may be far.
pub(super) fn project_within_sides(target: &dyn Target, ends: &[Ends], points: &mut Points) {
    let samples: Vec<(usize, usize, &Ends)> = ends
        .iter()
        .enumerate()
        .filter_map(|(i, e)| e.across.map(|axis| (i, axis, e)))
        .flat_map(|(i, axis, e)| (0..SAMPLES).map(move |j| (i * SAMPLES + j, axis, e)))
        .collect();
    let mut section: Points = samples
        .iter()
        .map(|(i, axis, e)| {
            let mut p = points.get(*i);
            p[*axis] = e.q0[*axis];
            p
        })
        .collect();
    let mut offset = vec![0.0; samples.len()];
    let mut normal = Points::zeros(samples.len());
    for _ in 0..SECTION_STEPS {
        target.offsets(section.view(), &mut offset, normal.view_mut());
        for (i, (_, axis, e)) in samples.iter().enumerate() {
            let mut n = normal.get(i);
            n[*axis] = 0.0;
            let step = -offset[i] / n.norm_squared() * n;
            let length = step.norm();
            if length.is_finite() {
                section.set(i, section.get(i) + step * (TRUST * e.length / length).min(1.0));
            }
        }
    }
    for (i, (place, _, _)) in samples.iter().enumerate() {
        points.set(*place, section.get(i));
    }
}
