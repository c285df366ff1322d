//! From polygons with gradients to the hull that a hybrid function lives in (paper §3, with the corrections of PAPERS.md).
//!
//! ```text
//! HermitePolygons ─► place ─────► settle ─────► fit ─────────► single_sheet ─► HybridHull
//!                    class,       wedges over   quadric near   one root on
//!                    cells, apex  edges         each face      every ray
//! ```

mod affine;
mod build;
mod fit;
mod layers;
mod middles;
mod options;
mod paper_fan;
mod paper_rule;
mod place;
mod raise;
mod settle;
mod shape;
mod single_sheet;
mod wedge;

pub use build::{BuiltHull, build};
pub use options::{DefaultRule, HybridOptions, Middles, Sheets};
pub use raise::raised;
pub use shape::has_room;
pub use single_sheet::{Certainty, certainties, enforce};

// Meshes to test with, shared with the integration tests, which name this crate from outside.
#[cfg(test)]
#[path = "../../../tests/support/bodies.rs"]
pub(crate) mod test_bodies;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
