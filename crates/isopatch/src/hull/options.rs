//! What the making of a hull can be told.

use super::face::FaceFrame;
use std::f64::consts::PI;

/// How far apexes stay above the tangent planes of their faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Margin {
    /// Times the smallest distance from the centroid of the face to its edges.
    Relative(f64),
    /// A length in model units, as in the paper's figures.
    Absolute(f64),
}

impl Margin {
    pub(super) fn of(self, face: &FaceFrame) -> f64 {
        match self {
            Self::Relative(factor) => factor * face.inner_radius,
            Self::Absolute(length) => length,
        }
    }
}

/// Where apexes go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApexRule {
    /// On the normal of the face, at the height of the paper's §3.1. Gradients are left as they are.
    Paper,
    /// On the mean of the vertex normals, as low as layer 1 allows, and higher or elsewhere where that does not fit.
    Robust(RobustApexes),
}

/// What the robust rule tries. The defaults are those that were good on fifteen scanned and modelled meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustApexes {
    /// A vertex normal whose product with the unit normal of a face around it is less gives way to the most visible
    /// direction; default 0.15.
    pub visibility: f64,
    /// The mean of the vertex normals whose product with the unit normal of the face is less gives way to that; default
    /// 0.3.
    pub facing: f64,
    /// Apexes are raised while μ_4 or ν_1 of an edge cell is less; default −0.45, above the −1/2 where the cell fails.
    pub reach: f64,
    /// Apexes are raised while an edge cell opens wider than this many radians; default 0.97 π.
    pub widest: f64,
    /// What a height is multiplied by; default 1.3.
    pub raise: f64,
    /// Most times it is; default 12.
    pub raises: usize,
    /// Rounds of other directions and normals for what is still wrong, each linear in the number of such faces; default 3.
    pub repairs: usize,
    /// Make creases and corners where nothing else helps, until no problem remains; default true.
    pub corners: bool,
    /// Put new vertices off the mesh around vertices that became corners because they hardly see the faces around them, see
    /// [`Hull::rounded`](super::Hull::rounded); default true.
    pub rounding: bool,
}

impl Default for RobustApexes {
    fn default() -> Self {
        Self {
            visibility: 0.15,
            facing: 0.3,
            reach: -0.45,
            widest: 0.97 * PI,
            raise: 1.3,
            raises: 12,
            repairs: 3,
            corners: true,
            rounding: true,
        }
    }
}

/// Options of [`build`](super::build).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullOptions {
    /// Where apexes go; default robust.
    pub rule: ApexRule,
    /// How far they stay above tangent planes; default 0.05 of the distance from the centroid to the edges.
    pub margin: Margin,
}

impl Default for HullOptions {
    fn default() -> Self {
        Self { rule: ApexRule::Robust(RobustApexes::default()), margin: Margin::Relative(0.05) }
    }
}

impl HullOptions {
    /// The same, but every face stays in one of the mesh.
    pub fn without_rounding(mut self) -> Self {
        if let ApexRule::Robust(rule) = &mut self.rule {
            rule.rounding = false;
        }
        self
    }
}
