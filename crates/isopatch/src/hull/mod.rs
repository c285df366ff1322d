//! The simplicial hull of a triangle mesh: the cells in which an A-patch function lives (Xu, Huang & Bajaj 2001, §3).
//!
//! ```text
//!            u_k ───────── u_l          face cell      [p_0 p_1 p_2 u]: on the outer side of a face (apex u), on the
//!            /\ \         / /\                         inner side (apex v), or both
//!           /  \ \  edge / /  \         edge cell      [u_l p_i p_j u_k]: between the cells of two faces k and l that
//!          / face\ \cell/ / face\                      share an edge, on either side
//!         /   k   \ \  / /   l   \      zero convex    a face that is its own patch has no cell, an edge that is
//!        p_k ───── p_i=p_j ────── p_l                  its own curve none either
//! ```
//!
//! [`HermiteMesh`] is the input: a mesh with positions and gradients. [`build`] classifies its edges and faces, puts an
//! apex on each side of a face that needs one, checks the edges, and names what does not fit. A face is a
//! triangle here; what an edge cell takes from the cells on its two sides is an apex and coefficients over the edge
//! alone, so that other cells can stand there as well.
//!
//! Edge k of a face runs from its corner k to corner k + 1, as in [`mesh`](crate::mesh). Both sides of the mesh are
//! treated alike: on the [`Side::Inner`] everything is computed for −F, so that the function is wanted negative at the base
//! and positive at the apex on either side.

mod build;
mod builder;
mod check;
mod class;
mod corner;
mod crease;
mod edge;
mod face;
mod hermite;
mod options;
mod place;
mod problem;
mod refine;
mod relax;
mod relief;
mod repair;
mod round;
mod shear;
mod simplicial_hull;
pub mod tetrahedron;
mod visibility;

// Meshes to test with, shared with the integration tests, which name this crate from outside.
#[cfg(test)]
#[path = "../../tests/support/meshes.rs"]
pub(crate) mod test_meshes;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;

pub use build::build;
pub use class::{Class, Side, bend};
pub use crease::CreaseCurve;
pub use edge::{EdgeCell, EdgeFrame};
pub use face::{FaceFrame, Layer1, alpha, mid_edge};
pub use hermite::{HermiteError, HermiteMesh};
pub use options::{ApexRule, HullOptions, Margin, RobustApexes};
pub use problem::{Problem, Reason};
pub use simplicial_hull::{AddedCrease, Corner, Hull, HullEdge, HullFace, HullParts};
pub use visibility::most_visible_direction;
