//! Rational A-patches on the hull of a triangle mesh (Xu, Huang & Bajaj 2001): a C1 function whose zero set goes through
//! every vertex with the given normal.
//!
//! In each cell the function is a cubic Bernstein–Bézier form with a rational term. Along a ray from the base of the cell to
//! its apex (from [p_0 p_1 p_2] to u in a face cell, from [p_i p_j] to [u_k u_l] in an edge cell) it is a plain cubic in
//! the ray's parameter t, whose coefficients B_0 … B_3 are the *layers*: B_0 depends on the base alone, and the free
//! parameter of a face, its value at the apex, enters B_2 and B_3 alone. The surface is at the smallest root.
//!
//! ```text
//! base (e, g or h)          base.rs      layer 0: Clough–Tocher where a face has cells on both sides, else rational
//! face layers 1, 2          face.rs      from the gradients (layer 1), from a quadric (layer 2)
//! quadric                   quadric.rs   steps 5 and 8: constant least-squares matrices
//! edge cells                edge.rs      what makes the function C1 across both sides of the wedge
//! free parameters           free.rs      neighbour rule; build.rs: the bound above which every ray has one simple root
//! points                    shoot.rs     roots, points, normals, derivatives;  grid.rs  many at once
//! creases                   crease.rs    what pulls the patches on both sides of a sharp edge to one curve
//! ```
//!
//! [`build`] makes the [`APatchFunction`]; [`APatchFunction::with_free`] replaces the free parameters and nothing else.
//! [`APatchSurface`] is its zero set as patches, one over each face and one over each edge that is not straight.
//!
//! Everything of a side is stored for the function times the sign of the side, see [`hull`](crate::hull).

mod base;
mod build;
mod check;
mod crease;
mod edge;
mod face;
mod free;
pub mod grid;
pub mod lanes;
mod locate;
pub(crate) mod part;
mod quadric;
mod shoot;
mod surface;
mod value;

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;

pub use base::Base;
pub use build::{APatchFunction, APatchOptions, APatchParts, build};
pub use crease::{CreaseCounts, CreasedFace};
pub(crate) use crease::{difference, rim_point, weighted};
pub use edge::{EdgeFunction, EdgeSide, Flank, Rim};
pub use face::{FaceFunction, FaceSide};
pub use free::{Free, FreeRule};
pub use quadric::Layer2Rule;
pub use shoot::{Shot, root, side_of};
pub use surface::{APatchSurface, Over};
