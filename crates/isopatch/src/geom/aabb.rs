use super::{Interval, Point3};

/// An axis-aligned box, `min` ≤ `max` in every coordinate; a box of no points has `min` > `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Point3,
    /// Largest coordinates.
    pub max: Point3,
}

impl Aabb {
    /// The box of no points: joining anything to it gives that thing.
    pub const EMPTY: Self = Self {
        min: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The box between two corners, given as `min` and `max`.
    pub fn new(min: Point3, max: Point3) -> Self {
        Self { min, max }
    }

    /// The smallest box around the points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Point3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.including(p))
    }

    /// This box, grown to hold `p`.
    pub fn including(&self, p: &Point3) -> Self {
        Self { min: self.min.inf(p), max: self.max.sup(p) }
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Does the box hold no point?
    pub fn is_empty(&self) -> bool {
        (0..3).any(|i| self.min[i] > self.max[i])
    }

    /// The eight corners, x fastest.
    pub fn corners(&self) -> [Point3; 8] {
        let pick = |corner: usize, a: usize| if corner >> a & 1 == 0 { self.min[a] } else { self.max[a] };
        std::array::from_fn(|corner| Point3::from_fn(|a, _| pick(corner, a)))
    }

    /// The points in both; an empty box if there are none.
    pub fn common(&self, other: &Self) -> Self {
        Self { min: self.min.sup(&other.min), max: self.max.inf(&other.max) }
    }

    /// Is `p` in the closed box?
    pub fn contains(&self, p: &Point3) -> bool {
        (0..3).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }

    /// Have the closed boxes a point in common?
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }

    /// Edge lengths.
    pub fn size(&self) -> Point3 {
        self.max - self.min
    }

    /// Length of the space diagonal: the unit of every relative tolerance.
    pub fn diagonal(&self) -> f64 {
        self.size().norm()
    }

    /// Midpoint.
    pub fn center(&self) -> Point3 {
        0.5 * (self.min + self.max)
    }

    /// This box with `margin` (a length) added on every side.
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min.add_scalar(-margin), max: self.max.add_scalar(margin) }
    }

    /// The box of all sums of a point of this box and one of another.
    pub fn plus(&self, other: &Self) -> Self {
        Self { min: self.min + other.min, max: self.max + other.max }
    }

    /// Square of the distance from `p` to the nearest point of the box, 0 inside.
    pub fn distance_squared(&self, p: &Point3) -> f64 {
        let outside = |a: usize| (self.min[a] - p[a]).max(p[a] - self.max[a]).max(0.0);
        outside(0).powi(2) + outside(1).powi(2) + outside(2).powi(2)
    }

    /// The range of coordinate `axis` (0, 1 or 2).
    pub fn interval(&self, axis: usize) -> Interval {
        Interval { lo: self.min[axis], hi: self.max[axis] }
    }
}
