//! Singular points and curves as the walls at which an expansion ends.

use crate::geom::Point3;
use std::collections::BTreeSet;

/// Points at which the expansion may end, and the segments between them that it must not cross. A triangle ends in a
/// segment with a whole edge, so that the segment is an edge of the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walls {
    /// Isolated singular points and the points of polylines along singular curves; also points of the surface that have to be vertices.
    pub points: Vec<Point3>,
    /// Segments of the polylines, as pairs of points, lower number first.
    pub segments: BTreeSet<[u32; 2]>,
}

impl Walls {
    /// Adds a point and returns its number.
    pub fn add_point(&mut self, p: Point3) -> u32 {
        self.points.push(p);
        self.points.len() as u32 - 1
    }

    /// Adds a segment between two points.
    pub fn add_segment(&mut self, a: u32, b: u32) {
        if a != b {
            self.segments.insert([a.min(b), a.max(b)]);
        }
    }

    /// Adds an arc between two points that are there already, cut into segments of about the same length, at most `longest`,
    /// with corners on the arc. `samples` go from the first to the last point, ends included.
    pub fn add_arc(
        &mut self,
        [first, last]: [u32; 2],
        samples: &[Point3],
        longest: f64,
        least_segments: usize,
    ) {
        let steps: Vec<f64> = samples.windows(2).map(|w| (w[1] - w[0]).norm()).collect();
        let length: f64 = steps.iter().sum();
        let count = ((length / longest).ceil() as usize).max(least_segments).max(1);
        let mut before = first;
        let (mut travelled, mut at) = (0.0, 0);
        for n in 1..count {
            let wanted = length * n as f64 / count as f64;
            while at + 1 < steps.len() && travelled + steps[at] < wanted {
                travelled += steps[at];
                at += 1;
            }
            // The nearer one of two samples is on the curve; a point between them would not be.
            let nearer =
                if wanted - travelled > steps.get(at).copied().unwrap_or(0.0) / 2.0 { at + 1 } else { at };
            let point = self.add_point(samples[nearer.min(samples.len() - 1)]);
            self.add_segment(before, point);
            before = point;
        }
        self.add_segment(before, last);
    }

    /// Is there a segment between two points?
    pub fn has_segment(&self, a: u32, b: u32) -> bool {
        self.segments.contains(&[a.min(b), a.max(b)])
    }
}
