//! The box that cuts a surface, and which of its sides a vertex lies in.

use std::fmt;

use crate::geom::{Aabb, Point3, Vec3};

/// A side of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxSide {
    /// Which coordinate is constant on it: 0, 1 or 2.
    pub axis: usize,
    /// Is it the side of the largest coordinate?
    pub upper: bool,
}

pub(super) const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

impl BoxSide {
    /// All sides: smallest and largest x, y, z.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..3).flat_map(|axis| [false, true].map(|upper| Self { axis, upper }))
    }

    /// The coordinate that is constant on it.
    pub fn position(self, bounds: &Aabb) -> f64 {
        if self.upper { bounds.max[self.axis] } else { bounds.min[self.axis] }
    }
}

impl fmt::Display for BoxSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", if self.upper { "largest" } else { "smallest" }, AXIS_NAMES[self.axis])
    }
}

/// A set of sides of a box: none inside, one on a side, two on an edge, three at a corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct BoxSides(u8);

impl BoxSides {
    /// No side: inside the box.
    pub const NONE: Self = Self(0);

    fn bit(side: BoxSide) -> u8 {
        1 << (2 * side.axis + usize::from(side.upper))
    }

    /// The sides whose coordinate the point has exactly.
    pub fn of(p: &Point3, bounds: &Aabb) -> Self {
        BoxSide::all().filter(|s| p[s.axis] == s.position(bounds)).collect()
    }

    /// One bit a side, in the order of [`BoxSide::all`].
    pub fn bits(self) -> u8 {
        self.0
    }

    /// The sides with these bits; none if there are more bits than sides.
    pub fn from_bits(bits: u8) -> Option<Self> {
        (bits >> 6 == 0).then_some(Self(bits))
    }

    /// The sides in it.
    pub fn iter(self) -> impl Iterator<Item = BoxSide> {
        BoxSide::all().filter(move |s| self.0 & Self::bit(*s) != 0)
    }

    /// How many.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Inside the box?
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Is the side one of them?
    pub fn contains(self, side: BoxSide) -> bool {
        self.0 & Self::bit(side) != 0
    }

    /// Are all sides of the other set in this one?
    pub fn contains_all(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Sides that both have: those of an edge, from those of its ends.
    pub fn common(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The sum of the unit vectors across them.
    pub fn across(self) -> Vec3 {
        let mut across = Vec3::zeros();
        self.iter().for_each(|s| across[s.axis] += if s.upper { 1.0 } else { -1.0 });
        across
    }

    /// The part of a vector that is parallel to all of them.
    pub fn within(self, mut v: Vec3) -> Vec3 {
        self.iter().for_each(|s| v[s.axis] = 0.0);
        v
    }

    /// Which coordinates are fixed.
    pub fn fixed_axes(self) -> [bool; 3] {
        std::array::from_fn(|axis| self.0 >> (2 * axis) & 3 != 0)
    }

    /// The point with the coordinates of the sides.
    pub fn snap(self, mut p: Point3, bounds: &Aabb) -> Point3 {
        self.iter().for_each(|s| p[s.axis] = s.position(bounds));
        p
    }
}

impl FromIterator<BoxSide> for BoxSides {
    fn from_iter<I: IntoIterator<Item = BoxSide>>(sides: I) -> Self {
        Self(sides.into_iter().fold(0, |bits, side| bits | Self::bit(side)))
    }
}

/// How a box cuts a mesh: every boundary vertex lies exactly in the sides listed for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// The box.
    pub bounds: Aabb,
    /// For each vertex, the sides it lies in; none for a vertex inside.
    pub sides: Vec<BoxSides>,
}

/// A point may be outside the box by this share of its diagonal, as where the surface touches a side of the box.
const ROUNDING: f64 = 1e-12;

impl Clip {
    /// Is the point in the box, but for rounding?
    pub(super) fn holds(&self, p: &Point3) -> bool {
        self.bounds.grown(ROUNDING * self.bounds.diagonal()).contains(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_is_common_to_three_sides_and_an_edge_to_two() {
        let bounds = Aabb::new(Point3::new(-1.0, -2.0, -3.0), Point3::new(1.0, 2.0, 3.0));
        let corner = BoxSides::of(&Point3::new(1.0, -2.0, 3.0), &bounds);
        let edge = BoxSides::of(&Point3::new(1.0, -2.0, 0.5), &bounds);
        assert_eq!((corner.len(), edge.len()), (3, 2));
        assert_eq!(corner.common(edge), edge);
        assert!(corner.contains_all(edge) && !edge.contains_all(corner));
        assert_eq!(edge.fixed_axes(), [true, true, false]);
        assert_eq!(edge.snap(Point3::new(0.9, -1.9, 0.5), &bounds), Point3::new(1.0, -2.0, 0.5));
        assert!(BoxSides::of(&Point3::zeros(), &bounds).is_empty());
    }
}
