//! Parts of a surface that are thinner than triangles.

use crate::geom::{Point3, Vec3};

/// Isolated points and curves without sheets, which some formats can hold beside triangles: .glb, .obj, .ply and .vtu.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThinParts {
    /// Isolated points.
    pub points: Vec<Point3>,
    /// Curves, by points in order along them.
    pub curves: Vec<Vec<Point3>>,
}

impl ThinParts {
    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.curves.is_empty()
    }

    /// All positions, in the order in which files number them: isolated points, then curve after curve.
    pub(super) fn positions(&self) -> Vec<Point3> {
        self.points.iter().chain(self.curves.iter().flatten()).copied().collect()
    }

    /// The vertex numbers of each curve, where those of the parts begin with `first`.
    pub(super) fn numbered_curves(&self, first: usize) -> Vec<std::ops::Range<u32>> {
        let mut next = (first + self.points.len()) as u32;
        let mut numbers = Vec::with_capacity(self.curves.len());
        for curve in &self.curves {
            numbers.push(next..next + curve.len() as u32);
            next += curve.len() as u32;
        }
        numbers
    }

    /// The segments of all curves.
    pub(super) fn segments(&self, first: usize) -> Vec<[u32; 2]> {
        let curves = self.numbered_curves(first);
        curves.into_iter().flat_map(|c| (c.start..c.end.saturating_sub(1)).map(|v| [v, v + 1])).collect()
    }

    /// Normals for formats in which every vertex has one: none is right.
    pub(super) fn normals(&self) -> Vec<Vec3> {
        vec![Vec3::zeros(); self.positions().len()]
    }
}
