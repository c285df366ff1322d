use super::clip::{AXIS_NAMES, BoxSide};
use crate::geom::Point3;

/// Why no base mesh could be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BaseError {
    /// A coordinate of the box is infinite or NaN.
    #[error("the box is not finite in {}", AXIS_NAMES[*.axis])]
    NonFiniteBox {
        /// The coordinate, 0, 1 or 2.
        axis: usize,
    },
    /// The box's largest coordinate is below the smallest.
    #[error("the box is reversed in {}: {min} > {max}", AXIS_NAMES[*.axis])]
    ReversedBox {
        /// The coordinate, 0, 1 or 2.
        axis: usize,
        /// What was given as the smallest.
        min: f64,
        /// What was given as the largest.
        max: f64,
    },
    /// The box has no thickness (or one that is lost in rounding).
    #[error("the box is flat in {}: from {min} to {max}", AXIS_NAMES[*.axis])]
    FlatBox {
        /// The coordinate, 0, 1 or 2.
        axis: usize,
        /// Smallest coordinate.
        min: f64,
        /// Largest coordinate.
        max: f64,
    },
    /// The field does not change sign.
    #[error(
        "no surface in the box: the field is {} everywhere{}",
        if *.negative { "negative" } else { "positive" },
        if *.proven { "" } else { " where it was sampled" }
    )]
    NoSurface {
        /// Is f < 0 (or else f ≥ 0)?
        negative: bool,
        /// By interval bounds over the whole box, not only by samples.
        proven: bool,
    },
    /// The field has the same value everywhere.
    #[error("the field is constant: {value}")]
    ConstantField {
        /// Its value.
        value: f64,
    },
    /// The field has no value where the surface, or the whole box, is.
    #[error("the field is undefined (not a number) {}, {:.0} % of the samples", place(.at), 100.0 * .share)]
    Undefined {
        /// Share of the samples that are not a number.
        share: f64,
        /// Such a sample beside the solid; none if all of them are.
        at: Option<Point3>,
    },
    /// The surface is cut by the box.
    #[error("the surface leaves the box through the side of {side}, near {}: a larger box is needed", show(.at))]
    SurfaceLeavesBox {
        /// The side.
        side: BoxSide,
        /// Roughly where.
        at: Point3,
    },
    /// The field vanishes on all of a side of the box.
    #[error("the surface contains the side of {side} of the box: move that side a little")]
    SurfaceInSide {
        /// The side.
        side: BoxSide,
    },
    /// Cells as small as can be, in which f and ∇f may vanish together.
    #[error(
        "the topology is not settled in {count} cells as small as {size:.3e}, such as near {}: a singular point, or parts \
         of the surface closer together than that",
        list(.at)
    )]
    UnresolvedCells {
        /// How many.
        count: usize,
        /// Centres of some of them.
        at: Vec<Point3>,
        /// Their longest edge.
        size: f64,
    },
    /// A part of the surface meets the box only at one of its corners.
    #[error("the surface touches the corner {} of the box: move a side of the box a little", show(.at))]
    TouchesCorner {
        /// The corner.
        at: Point3,
    },
    /// No box could be found that holds the whole surface.
    #[error("the surface is unbounded, or could not be shown to be bounded: give a box")]
    Unbounded,
    /// ∇f = 0 on the surface.
    #[error(
        "the surface is singular: the gradient vanishes at {}; --method rational takes a polynomial with such points, and of other formulas \
         another --level may have none",
        show(.at)
    )]
    Singular {
        /// Where.
        at: Point3,
    },
    /// A vertex could not be put on the surface.
    #[error("no point of the surface was found near {}: a pole, a jump or a kink of the field", show(.at))]
    NotOnSurface {
        /// Where the vertex was.
        at: Point3,
    },
    /// The topology is not certain, and still changed with the last refinement.
    #[error(
        "the surface has details too fine to be settled: Euler number {} or number of parts, and with finer cells ({cells}) {}",
        .euler[0], .euler[1]
    )]
    Unresolved {
        /// Number of cells of the finer mesh.
        cells: usize,
        /// Euler numbers of the last two meshes.
        euler: [i64; 2],
    },
    /// Fewer faces were asked for than the topology (or a valid surface) takes.
    #[error(
        "{asked} faces are too few for this surface: {least} worked, and a tolerance (--tol) may do with fewer"
    )]
    TooFewFaces {
        /// The number asked for.
        asked: usize,
        /// A number that worked, of those that were tried.
        least: usize,
    },
    /// No spline surface exists over this mesh: a corner is not convex in the tangent plane.
    #[error("the corner of a base face near {} is {degrees:.1} degrees wide, but must be between 0 and 180: more faces are needed", show(.at))]
    InvertedCorner {
        /// The vertex.
        at: Point3,
        /// Angle of the corner in the tangent plane.
        degrees: f64,
    },
    /// A face of a given base mesh is no triangle.
    #[error("face {face} of the base mesh has {corners} corners; all faces must be triangles")]
    NotATriangle {
        /// The face.
        face: usize,
        /// Its number of corners.
        corners: usize,
    },
    /// A vertex of a given base mesh is infinite or not a number.
    #[error("vertex {vertex} of the base mesh is not finite")]
    NonFiniteVertex {
        /// The vertex.
        vertex: usize,
    },
    /// A given base mesh has a boundary.
    #[error("the base mesh is open: only one face has the edge between vertices {from} and {to}")]
    OpenMesh {
        /// One end.
        from: u32,
        /// The other.
        to: u32,
    },
    /// Connectivity is broken.
    #[error("the base mesh is not a manifold: {0}")]
    Mesh(#[from] crate::mesh::MeshError),
}

/// Coordinates for a message, without the sign of a zero.
fn show(p: &Point3) -> String {
    let rounded = p.map(|x| (x * 1e6).round() / 1e6 + 0.0);
    format!("({:.6}, {:.6}, {:.6})", rounded.x, rounded.y, rounded.z)
}

fn list(points: &[Point3]) -> String {
    points.iter().map(show).collect::<Vec<_>>().join(", ")
}

fn place(at: &Option<Point3>) -> String {
    at.as_ref().map_or_else(|| "everywhere".to_string(), |p| format!("beside the surface near {}", show(p)))
}
