//! What the making of a hull over polygons can be told.

/// Where the free parameters at the apexes come from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DefaultRule {
    /// From a quadric fitted in two stages: to the corners of the face, then, in the one direction that these leave open, to
    /// the corners around it. Exact for quadrics.
    #[default]
    TwoStage,
    /// The paper's, over triangles, in pyramids and in fans: the polynomial part of the function comes near to a quadratic, and
    /// with `linear` to a linear one as well, but for fans. On planar polygons this does not give quadrics back. Sectors, which
    /// the paper does not have, keep the rule above.
    Paper {
        /// The added equations, which the paper asks for over triangles.
        linear: bool,
    },
}

/// The gradient in the middle of an edge, across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Middles {
    /// From all corners of the polygons beside the edge, exact to the third order; and sectors around a center that suits them.
    /// Errors of the surface then fall with the fourth power of the edge length. Quadrics are kept.
    #[default]
    Fitted,
    /// The mean of those at its ends, as in the paper: errors fall with the third power.
    Mean,
}

/// Where free parameters are moved so that every ray meets the surface once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sheets {
    /// Wherever the sufficient conditions do not hold, but for faces whose data are those of a quadric: these stay exact as long as
    /// every ray over them is seen to meet the surface once.
    #[default]
    OffQuadrics,
    /// Wherever the sufficient conditions do not hold.
    Everywhere,
    /// Nowhere.
    Nowhere,
}

/// Options of [`build`](super::build).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridOptions {
    /// How far apexes are above the tangent planes of the corners, as a part of the diameter of the polygon; default 0.15.
    pub height: f64,
    /// Other heights and directions of apexes where cells do not fit; default true.
    pub adaptive: bool,
    /// The gradients in the middle of edges.
    pub middles: Middles,
    /// Where the free parameters come from.
    pub rule: DefaultRule,
    /// Where the free parameters are moved, as little as possible, so that every ray meets the surface once.
    pub sheets: Sheets,
    /// The paper's fan of tetrahedra over nonconvex triangles and quadrilaterals, which costs half as many cells; default
    /// false: sectors, which are sound for any gradients.
    pub fans: bool,
    /// Normals that face a polygon with a smaller product than this give way to the most visible direction; default 0.05.
    pub visibility: f64,
}

impl Default for HybridOptions {
    fn default() -> Self {
        Self {
            height: 0.15,
            adaptive: true,
            middles: Middles::Fitted,
            rule: DefaultRule::TwoStage,
            sheets: Sheets::OffQuadrics,
            fans: false,
            visibility: 0.05,
        }
    }
}
