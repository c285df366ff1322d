//! Triangles and lines to samples of a tile, nearest first.
//!
//! Corners are rounded to 1/256 pixel, so that edge functions are integers, exact in `f64`: a sample on the common edge of two
//! triangles belongs to one of them. What a tile shows does not depend on other tiles.

use super::view::Pixel;

/// Samples of a pixel.
pub(super) const SAMPLES: usize = 16;
/// Where they are, in sixteenths of a pixel from its centre: one in every column and every row, so that edges in any direction
/// are smooth (the standard pattern of Direct3D 11).
const OFFSETS: [[f64; 2]; SAMPLES] = [
    [1.0, 1.0],
    [-1.0, -3.0],
    [-3.0, 2.0],
    [4.0, -1.0],
    [-5.0, -2.0],
    [2.0, 5.0],
    [5.0, 3.0],
    [3.0, -5.0],
    [-2.0, 6.0],
    [0.0, -7.0],
    [-4.0, -6.0],
    [-6.0, 4.0],
    [-8.0, 0.0],
    [7.0, -4.0],
    [6.0, 7.0],
    [-7.0, -8.0],
];
/// Steps to which corners are rounded, for each pixel.
const STEPS: f64 = 256.0;
/// Steps of a sixteenth of a pixel.
const SIXTEENTH: f64 = STEPS / 16.0;

/// Pixels along the side of a tile: its samples stay in the cache of a processor.
pub(super) const TILE: usize = 32;
/// No triangle and no line.
pub(super) const NOTHING: u32 = u32::MAX;

/// Where sample `s` of the pixel in column x and row y is, in pixels.
pub(super) fn sample_at(x: usize, y: usize, s: usize) -> [f64; 2] {
    let [dx, dy] = OFFSETS[s];
    [x as f64 + 0.5 + dx / 16.0, y as f64 + 0.5 + dy / 16.0]
}

/// A triangle in the picture: its edge functions E_k = a_k x + b_k y + c_k, k opposite of corner k, in steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    a: [f64; 3],
    b: [f64; 3],
    c: [f64; 3],
    /// Smallest value of E_k inside: 1 on an edge that belongs to the neighbour.
    least: [f64; 3],
    inverse_area: f64,
    /// Is it seen from its front?
    pub is_front: bool,
    near: [f64; 3],
    min: [f64; 2],
    max: [f64; 2],
}

impl Flat {
    /// The triangle of three points of the picture; none if it has no area or no place.
    pub fn new(corners: [Pixel; 3]) -> Option<Self> {
        if !corners.iter().all(|p| p.x.is_finite() && p.y.is_finite() && p.near.is_finite()) {
            return None;
        }
        let at = corners.map(|p| [(p.x * STEPS).round(), (p.y * STEPS).round()]);
        let (mut a, mut b, mut c) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let (from, to) = (at[(k + 1) % 3], at[(k + 2) % 3]);
            a[k] = from[1] - to[1];
            b[k] = to[0] - from[0];
            c[k] = -(a[k] * from[0] + b[k] * from[1]);
        }
        let area: f64 = a[0] * at[0][0] + b[0] * at[0][1] + c[0];
        if area == 0.0 {
            return None;
        }
        // y points down, so a front that is counter-clockwise has negative area.
        let is_front = area < 0.0;
        if is_front {
            (a, b, c) = (a.map(|x| -x), b.map(|x| -x), c.map(|x| -x));
        }
        let is_own = |k: usize| a[k] > 0.0 || a[k] == 0.0 && b[k] > 0.0;
        let bound = |c: usize, pick: fn(f64, f64) -> f64| pick(pick(at[0][c], at[1][c]), at[2][c]);
        Some(Self {
            a,
            b,
            c,
            least: std::array::from_fn(|k| if is_own(k) { 0.0 } else { 1.0 }),
            inverse_area: area.abs().recip(),
            is_front,
            near: corners.map(|p| p.near),
            min: std::array::from_fn(|c| bound(c, f64::min) / STEPS),
            max: std::array::from_fn(|c| bound(c, f64::max) / STEPS),
        })
    }

    /// Barycentric coordinates in space of a point of the picture, in pixels.
    pub fn weights(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let flat = |k: usize| (self.a[k] * x + self.b[k] * y) * STEPS + self.c[k];
        let w: [f64; 3] = std::array::from_fn(|k| flat(k) * self.near[k]);
        let sum = w[0] + w[1] + w[2];
        w.map(|w| w / sum)
    }

    /// Nearness at a point of the picture, in pixels.
    fn near_at(&self, [x, y]: [f64; 2]) -> f64 {
        let flat = |k: usize| (self.a[k] * x + self.b[k] * y) * STEPS + self.c[k];
        (flat(0) * self.near[0] + flat(1) * self.near[1] + flat(2) * self.near[2]) * self.inverse_area
    }

    /// The columns and rows of pixels of a part of the picture that the triangle may touch.
    fn pixels(&self, tile: &Span) -> Span {
        tile.clipped(self.min, self.max)
    }
}

/// A line in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub ends: [Pixel; 2],
    /// Half of its thickness, in pixels.
    pub radius: f64,
    /// Which [`LineSet`](super::LineSet) it belongs to.
    pub set: u32,
}

impl Stroke {
    /// Nearness of the stroke at a point of the picture; none beside it.
    fn near_at(&self, at: [f64; 2]) -> Option<f64> {
        let [a, b] = self.ends;
        let (t, square) = self.foot(at);
        (square <= self.radius * self.radius).then_some(a.near + t * (b.near - a.near))
    }

    /// Where on the stroke the point is nearest, from 0 to 1, and the square of its distance.
    fn foot(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let [a, b] = self.ends;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let (px, py) = (x - a.x, y - a.y);
        let length = dx * dx + dy * dy;
        let t = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
        let (ex, ey) = (px - t * dx, py - t * dy);
        (t, ex * ex + ey * ey)
    }

    /// Is the stroke beside the whole pixel?
    fn misses(&self, [x, y]: [usize; 2]) -> bool {
        // All samples of a pixel are nearer to its centre than its corners are.
        const TO_CORNER: f64 = std::f64::consts::FRAC_1_SQRT_2;
        self.foot([x as f64 + 0.5, y as f64 + 0.5]).1 > (self.radius + TO_CORNER).powi(2)
    }

    fn bounds(&self) -> [[f64; 2]; 2] {
        let [a, b] = self.ends;
        let r = self.radius;
        [[a.x.min(b.x) - r, a.y.min(b.y) - r], [a.x.max(b.x) + r, a.y.max(b.y) + r]]
    }
}

/// Columns and rows of pixels, the last ones excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub min: [usize; 2],
    pub max: [usize; 2],
}

impl Span {
    /// The pixels that a box touches.
    fn clipped(&self, min: [f64; 2], max: [f64; 2]) -> Self {
        // Casts of negative numbers give 0.
        Self {
            min: std::array::from_fn(|c| (min[c].floor() as usize).max(self.min[c])),
            max: std::array::from_fn(
                |c| if max[c] < 0.0 { 0 } else { (max[c] as usize + 1).min(self.max[c]) },
            ),
        }
    }
}

/// The triangles of a surface in the picture.
pub(super) struct Shapes<'a> {
    pub corners: &'a [Pixel],
    pub triangles: &'a [[u32; 3]],
}

impl Shapes<'_> {
    pub fn flat(&self, triangle: usize) -> Option<Flat> {
        Flat::new(self.triangles[triangle].map(|v| self.corners[v as usize]))
    }
}

/// Numbers of the shapes that touch each tile, ascending.
pub(super) struct Bins {
    start: Vec<usize>,
    shapes: Vec<u32>,
}

impl Bins {
    /// Sorts boxes into tiles, `across` in a row.
    pub fn new(
        [across, down]: [usize; 2],
        boxes: impl Iterator<Item = Option<[[f64; 2]; 2]>> + Clone,
    ) -> Self {
        let all = Span { min: [0, 0], max: [across, down] };
        let touched = |bounds: Option<[[f64; 2]; 2]>| {
            let [min, max] = bounds.map_or([[1.0; 2], [-1.0; 2]], |b| b.map(|p| p.map(|x| x / TILE as f64)));
            let span = all.clipped(min, max);
            (span.min[1]..span.max[1])
                .flat_map(move |y| (span.min[0]..span.max[0]).map(move |x| y * across + x))
        };
        let mut start = vec![0; across * down + 1];
        for tile in boxes.clone().flat_map(touched) {
            start[tile + 1] += 1;
        }
        for tile in 0..across * down {
            start[tile + 1] += start[tile];
        }
        let mut next = start.clone();
        let mut shapes = vec![0; start[across * down]];
        for (number, bounds) in boxes.enumerate() {
            for tile in touched(bounds) {
                shapes[next[tile]] = number as u32;
                next[tile] += 1;
            }
        }
        Self { start, shapes }
    }

    pub fn of(&self, tile: usize) -> &[u32] {
        &self.shapes[self.start[tile]..self.start[tile + 1]]
    }
}

/// The box of a triangle, if it has a place.
pub(super) fn box_of(corners: [Pixel; 3]) -> Option<[[f64; 2]; 2]> {
    let xs = corners.map(|p| p.x);
    let ys = corners.map(|p| p.y);
    let min = |v: [f64; 3]| v[0].min(v[1]).min(v[2]);
    let max = |v: [f64; 3]| v[0].max(v[1]).max(v[2]);
    // One pixel of room for the rounding of corners.
    xs.iter()
        .chain(&ys)
        .all(|x| x.is_finite())
        .then(|| [[min(xs) - 1.0, min(ys) - 1.0], [max(xs) + 1.0, max(ys) + 1.0]])
}

/// The box of a stroke, if it has a place.
pub(super) fn box_of_stroke(stroke: &Stroke) -> Option<[[f64; 2]; 2]> {
    let bounds = stroke.bounds();
    bounds.iter().flatten().all(|x| x.is_finite()).then_some(bounds)
}

/// The samples of a tile.
pub(super) struct Samples {
    pub span: Span,
    /// Nearness of what is seen; 0 of nothing.
    pub near: Vec<f32>,
    /// Number of the triangle, or of triangles plus that of the stroke, or [`NOTHING`].
    pub shape: Vec<u32>,
}

/// Strokes on a surface are nearer to the eye than it by this part, so that they are not buried between the corners of flat
/// triangles; a quarter of a percent of the distance is some percent of the radius of the model.
const LIFT: f64 = 1.0015;
/// Each set of strokes is nearer than the one before, so that points lie on their lines.
const LIFT_OF_NEXT: f64 = 1e-4;

impl Samples {
    pub fn new(span: Span) -> Self {
        let count = (span.max[0] - span.min[0]) * (span.max[1] - span.min[1]) * SAMPLES;
        Self { span, near: vec![0.0; count], shape: vec![NOTHING; count] }
    }

    /// Index of the first sample of a pixel.
    pub fn first(&self, x: usize, y: usize) -> usize {
        ((y - self.span.min[1]) * (self.span.max[0] - self.span.min[0]) + x - self.span.min[0]) * SAMPLES
    }

    /// Calls `hit` with the index and nearness of every sample in a triangle.
    pub fn in_triangle(&mut self, flat: &Flat, mut hit: impl FnMut(&mut Self, usize, f32)) {
        let span = flat.pixels(&self.span);
        let offset = |k: usize, s: usize| {
            SIXTEENTH * (flat.a[k] * OFFSETS[s][0] + flat.b[k] * OFFSETS[s][1]) - flat.least[k]
        };
        let offsets: [[f64; SAMPLES]; 3] = std::array::from_fn(|k| std::array::from_fn(|s| offset(k, s)));
        let slope = |of: &[f64; 3]| {
            flat.inverse_area * (of[0] * flat.near[0] + of[1] * flat.near[1] + of[2] * flat.near[2])
        };
        let (near_x, near_y) = (slope(&flat.a), slope(&flat.b));
        let nears: [f64; SAMPLES] =
            std::array::from_fn(|s| SIXTEENTH * (near_x * OFFSETS[s][0] + near_y * OFFSETS[s][1]));
        // How much an edge function changes within a pixel.
        let reach: [f64; 3] = std::array::from_fn(|k| 0.5 * STEPS * (flat.a[k].abs() + flat.b[k].abs()));
        for y in span.min[1]..span.max[1] {
            for x in span.min[0]..span.max[0] {
                let center = [x as f64 + 0.5, y as f64 + 0.5];
                let e: [f64; 3] = std::array::from_fn(|k| {
                    STEPS * (flat.a[k] * center[0] + flat.b[k] * center[1]) + flat.c[k]
                });
                if (0..3).any(|k| e[k] < -reach[k]) {
                    continue;
                }
                let (first, near) = (self.first(x, y), flat.near_at(center));
                for s in 0..SAMPLES {
                    if e[0] + offsets[0][s] >= 0.0
                        && e[1] + offsets[1][s] >= 0.0
                        && e[2] + offsets[2][s] >= 0.0
                    {
                        hit(self, first + s, (near + nears[s]) as f32);
                    }
                }
            }
        }
    }

    /// Calls `hit` with the index and nearness of every sample in a stroke.
    pub fn in_stroke(&mut self, stroke: &Stroke, mut hit: impl FnMut(&mut Self, usize, f32)) {
        let [min, max] = stroke.bounds();
        let span = self.span.clipped(min, max);
        let lift = LIFT + LIFT_OF_NEXT * f64::from(stroke.set);
        for y in span.min[1]..span.max[1] {
            for x in (span.min[0]..span.max[0]).filter(|x| !stroke.misses([*x, y])) {
                let first = self.first(x, y);
                for s in 0..SAMPLES {
                    if let Some(near) = stroke.near_at(sample_at(x, y, s)) {
                        hit(self, first + s, (lift * near) as f32);
                    }
                }
            }
        }
    }

    /// Keeps a shape where it is nearer than what was there.
    pub fn keep(&mut self, at: usize, near: f32, shape: u32) {
        if near > self.near[at] {
            (self.near[at], self.shape[at]) = (near, shape);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Span = Span { min: [0, 0], max: [TILE, TILE] };

    fn pixel(x: f64, y: f64) -> Pixel {
        Pixel { x, y, near: 0.2 }
    }

    #[test]
    fn triangles_with_a_common_edge_share_the_samples_among_them() {
        // A fan around a point on a sample, with edges through pixel centres and samples.
        let center = pixel(16.5 + 1.0 / 16.0, 16.5 + 1.0 / 16.0);
        let rim: Vec<Pixel> =
            [(3.5, 2.0), (16.5625, 1.0), (30.0, 3.0), (31.0, 16.5625), (29.0, 30.0), (2.0, 29.5)]
                .map(|(x, y)| pixel(x, y))
                .to_vec();
        let mut samples = Samples::new(ALL);
        let mut hits = vec![0; samples.near.len()];
        for k in 0..rim.len() {
            let flat = Flat::new([center, rim[k], rim[(k + 1) % rim.len()]]).unwrap();
            assert!(!flat.is_front, "clockwise when y points up");
            samples.in_triangle(&flat, |_, at, _| hits[at] += 1);
        }
        assert!(hits.iter().all(|n| *n <= 1));
        let covered = hits.iter().sum::<i32>() as f64 / SAMPLES as f64;
        let area: f64 = (0..rim.len())
            .map(|k| {
                let (a, b) = (rim[k], rim[(k + 1) % rim.len()]);
                0.5 * ((a.x - center.x) * (b.y - center.y) - (a.y - center.y) * (b.x - center.x))
            })
            .sum();
        assert!((covered - area.abs()).abs() < 0.01 * area.abs(), "{covered} {area}");
    }

    #[test]
    fn weights_give_back_the_corners() {
        let corners =
            [pixel(2.0, 3.0), Pixel { x: 20.0, y: 5.0, near: 0.25 }, Pixel { x: 9.0, y: 30.0, near: 0.1 }];
        let flat = Flat::new(corners).unwrap();
        for (k, p) in corners.iter().enumerate() {
            let w = flat.weights([p.x, p.y]);
            assert!((0..3).all(|i| (w[i] - f64::from(u8::from(i == k))).abs() < 1e-12));
            assert!((flat.near_at([p.x, p.y]) - p.near).abs() < 1e-12);
        }
        // The middle of an edge of the picture is nearer to the far end in space.
        let w = flat.weights([14.5, 17.5]);
        assert!(w[1] > 0.7 && (w.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{w:?}");
    }

    #[test]
    fn a_stroke_has_its_thickness() {
        let stroke = Stroke { ends: [pixel(4.0, 10.3), pixel(28.0, 10.3)], radius: 1.5, set: 0 };
        let mut samples = Samples::new(ALL);
        let mut hits = 0;
        samples.in_stroke(&stroke, |_, _, _| hits += 1);
        let area = 24.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5;
        assert!((hits as f64 / SAMPLES as f64 - area).abs() < 0.02 * area);
    }

    #[test]
    fn bins_hold_every_shape_that_touches_them() {
        let boxes = [Some([[-5.0, -5.0], [5.0, 5.0]]), None, Some([[30.0, 10.0], [33.0, 70.0]])];
        let bins = Bins::new([2, 3], boxes.into_iter());
        assert_eq!(
            (0..6).map(|t| bins.of(t).to_vec()).collect::<Vec<_>>(),
            [vec![0, 2], vec![2], vec![2], vec![2], vec![2], vec![2]]
        );
    }
}
