//! A triangulation of an algebraic surface that conforms to its singular points and curves.

mod sheets;
mod singular_mesh;

pub use sheets::{Sheet, sheets};
pub use singular_mesh::{EdgeTag, FeatureEdge, LowerPart, SingularMesh, VertexKind};
