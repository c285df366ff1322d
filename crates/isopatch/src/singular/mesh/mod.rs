//! A triangulation of an algebraic surface that conforms to its singular points and curves.
//!
//! The box is divided into the cells of an octree (`partition.rs`). All roots of f on the edges of cells are found, then how
//! the curve f = 0 joins them in the faces (`plane_curve.rs`), then each cell is filled (`assemble.rs`): by a cone from the
//! singular point or from the middle of the arc in it, otherwise by discs. What two cells have in common is computed once, so
//! the mesh is watertight by construction; bounds or the neighbourhood of a singularity say that it has the right topology.
//! Then the mesh is thinned out (`decimate.rs`).

mod arcs;
mod assemble;
mod decimate;
mod expanded;
mod flip;
mod grid;
mod mend;
mod normals;
mod partition;
mod plane_curve;
mod project;
mod quality;
mod ridge;
mod roots;
mod sheets;
mod singular_mesh;
mod split;
mod triangulate;

pub use expanded::triangulate_by_expansion;
pub use sheets::{Sheet, sheets};
pub use singular_mesh::{EdgeTag, FeatureEdge, LowerPart, SingularMesh, VertexKind};
pub use split::{SplitLimits, split_edges};
pub use triangulate::{MAX_DEGREE, TriangulateError, TriangulateOptions, Triangulated, triangulate};
