//! Polygon meshes: connectivity that knows no coordinates, and the way to it from files as people have them.
//!
//! [`HalfEdgeMesh`] is the connectivity of an oriented manifold. [`check`] says what keeps faces from being one, and
//! [`prepare`] repairs what it can, with a list of what was done, or refuses by name.
//!
//! ```text
//!            b                 half edge h: a → b, face(h) on its left
//!           /|\                twin(h):     b → a, none on a boundary
//!    face  / | \               next(h), prev(h) stay in the face
//!    of h /  |  \ face of      ring of a: outgoing half edges, counter-clockwise,
//!        /   |h  \ twin(h)     each one is twin(prev(·)) of the one before
//!        \   |   /
//!         \  |  /
//!          \ | /
//!            a
//! ```
//!
//! The half edges of face f are consecutive and start at the face's first vertex, so in a triangle mesh
//! half edge 3f + k runs from corner k to corner k + 1.

pub(crate) mod buckets;
pub mod butterfly;
mod check;
pub mod creases;
mod degenerate;
mod fans;
pub mod gradient_lengths;
mod half_edge;
mod nesting;
pub mod normals;
mod orient;
mod pairing;
mod polygons;
mod prepare;
mod repairs;
mod triangulate;
mod walls;
mod weld;

#[cfg(test)]
mod prepare_tests;

pub use check::{Component, Hole, MeshCheck, check};
pub use half_edge::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, MeshError, VertexId};
pub use prepare::{MeshFault, PrepareOptions, Prepared, prepare};
pub use repairs::{MeshRepair, Place, RepairKind, place_names};
pub use triangulate::{MOST_CORNERS, TooManyCorners, Triangles, triangulate};
