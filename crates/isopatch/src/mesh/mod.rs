//! Connectivity of polygon meshes; it knows no coordinates.
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

mod half_edge;
pub mod normals;

pub use half_edge::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, MeshError, VertexId};
