//! Puts apexes over a face.

use super::class::{Class, Side};
use super::face::FaceFrame;
use super::options::{ApexRule, HullOptions};
use super::repair;
use super::shear;
use super::simplicial_hull::HullFace;
use crate::geom::{Point3, Vec3};

/// How often apexes are raised so that a patch does not turn over; where that takes more, it makes the shape worse.
pub(super) const RAISES_FOR_FOLDS: usize = 5;

/// Mean direction of the gradients of a face for the robust rule, its normal for the paper's.
pub(super) fn default_direction(frame: &FaceFrame, options: &HullOptions) -> Vec3 {
    match options.rule {
        ApexRule::Paper => frame.normal,
        ApexRule::Robust(rule) => repair::facing(repair::mean_normal(frame), frame, rule.facing),
    }
}

/// A face with its apexes on the line in `direction`.
pub(super) fn placed(frame: &FaceFrame, direction: Vec3, options: &HullOptions) -> HullFace {
    let class = Class::of_face([0, 1, 2].map(|k| frame.edge_class(k)));
    let margin = options.margin.of(frame);
    let heights = Side::BOTH.map(|side| match options.rule {
        ApexRule::Paper => frame.paper_height(side, &direction, margin),
        ApexRule::Robust(_) if !class.reaches(side) => 0.0,
        // Without a valid height, one that does not spoil the neighbours more than needed; the face is reported.
        ApexRule::Robust(_) => frame.lowest_height(side, &direction, margin).unwrap_or(frame.inner_radius),
    });
    let mut face = HullFace { class, direction, heights, apexes: [None; 2] };
    face.apexes = apexes(frame, &face);
    if let ApexRule::Robust(rule) = options.rule {
        let low = face;
        for _ in 0..=RAISES_FOR_FOLDS {
            if !shear::corners_fold(frame, &face) {
                return face;
            }
            face.heights = face.heights.map(|height| rule.raise * height);
            face.apexes = apexes(frame, &face);
        }
        return low;
    }
    face
}

/// Bisections for the lowest height where many are tried.
const ROUGH: usize = 10;

/// A face with its apexes on the line in `direction`, at multiples of the heights of the robust rule.
pub(super) fn placed_at(
    frame: &FaceFrame,
    direction: Vec3,
    factors: [f64; 2],
    options: &HullOptions,
) -> HullFace {
    let class = Class::of_face([0, 1, 2].map(|k| frame.edge_class(k)));
    let margin = options.margin.of(frame);
    let heights = Side::BOTH.map(|side| {
        if !class.reaches(side) {
            return 0.0;
        }
        let lowest = frame.low_height(side, &direction, margin, ROUGH).unwrap_or(frame.inner_radius);
        factors[side.index()] * lowest
    });
    let mut face = HullFace { class, direction, heights, apexes: [None; 2] };
    face.apexes = apexes(frame, &face);
    face
}

pub(super) fn apexes(frame: &FaceFrame, face: &HullFace) -> [Option<Point3>; 2] {
    Side::BOTH.map(|side| {
        let height = face.heights[side.index()];
        face.class.reaches(side).then(|| frame.apex(side, &face.direction, height))
    })
}
