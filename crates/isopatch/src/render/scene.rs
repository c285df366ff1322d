//! What a picture shows.

use super::{Color, ColorScale};
use crate::geom::Point3;
use crate::tessellate::Tessellation;

/// A surface with its paint, and what is drawn over it.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The surface.
    pub mesh: &'a Tessellation,
    /// How it is painted.
    pub paint: Paint,
    /// Lines and points in space.
    pub lines: Vec<LineSet>,
    /// Translucent triangles.
    pub veils: Vec<Veil>,
    /// A bar that explains colours.
    pub legend: Option<Legend>,
}

impl<'a> Scene<'a> {
    /// The surface alone.
    pub fn new(mesh: &'a Tessellation, paint: Paint) -> Self {
        Self { mesh, paint, lines: Vec::new(), veils: Vec::new(), legend: None }
    }

    /// All points that the picture has to hold.
    pub(super) fn extent(&self) -> Vec<Point3> {
        let used = self.mesh.triangles.iter().flatten().map(|v| self.mesh.positions[*v as usize]);
        let lines = self.lines.iter().flat_map(|set| set.segments.iter().flatten().copied());
        used.chain(lines).chain(self.veils.iter().flat_map(|veil| veil.corners)).collect()
    }
}

/// How a surface is painted.
#[derive(Clone, Debug)]
pub enum Paint {
    /// One colour outside, another one inside.
    Plain {
        /// Where the normals point.
        outside: Color,
        /// The back.
        inside: Color,
    },
    /// A colour for each patch.
    Patches(Vec<Color>),
    /// A number at each corner of each triangle, shown on a scale.
    Values {
        /// The numbers.
        corners: Vec<[f32; 3]>,
        /// The numbers at the ends of the scale.
        range: [f64; 2],
        /// The colours.
        scale: ColorScale,
    },
    /// Lines on which the normal is at the same angle to the direction from below to above, black and white in turn.
    Isophotes {
        /// Pairs of black and white over all angles.
        bands: f64,
    },
    /// Reflections of parallel strips around the model, far away.
    Reflection {
        /// Pairs of dark and bright strips on the full circle.
        bands: f64,
        /// What the surface is made of.
        metal: Metal,
    },
}

/// What reflects the strips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metal {
    /// Black and white.
    Chrome,
    /// Gold, as in figures 12 to 15 of Tong & Kim 2009.
    Gold,
}

/// Lines of one kind. A segment whose ends are the same is a point.
#[derive(Clone, Debug)]
pub struct LineSet {
    /// Both ends of each line.
    pub segments: Vec<[Point3; 2]>,
    /// Colour; lines have no shading.
    pub color: Color,
    /// Thickness in pixels of a picture 900 pixels high; it grows with the picture.
    pub width: f64,
    /// How much is seen through the surface, from 0, nothing, to 1.
    pub hidden: f32,
}

/// A translucent triangle.
#[derive(Clone, Copy, Debug)]
pub struct Veil {
    /// Its corners.
    pub corners: [Point3; 3],
    /// Colour.
    pub color: Color,
    /// How much of what is behind it is lost, from 0 to 1.
    pub opacity: f32,
}

/// A bar that explains colours.
#[derive(Clone, Debug)]
pub struct Legend {
    /// What the numbers are; letters of "Gaussian curvature" and "Mean curvature", others are left out.
    pub title: String,
    /// The numbers at the ends.
    pub range: [f64; 2],
    /// The colours.
    pub scale: ColorScale,
}
