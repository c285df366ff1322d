//! Rational patches over the triangles of a mesh with normals: Bajaj & Xu 1997, section 6.
//!
//! ```text
//! corners with normals ──► wires ──► patches ──► RationalSurface
//!      Frame              network     [`patch`]       │
//!                                                     ├─► rational Bézier triangles  [`weighted`]
//!                                                     ├─► NURBS pieces, weights > 0  [`pieces`]
//!                                                     └─► triangular B-splines       [`b_patch`]
//! ```
//!
//! A patch is a cubic Bézier triangle over the wires of its face, and a rational correction (6.2) that turns the tangent planes along
//! each edge without moving it. [`conic`] and [`cubic`] have the constructions of the paper, which need conditions on the
//! normals, and a linear system each. The default is in [`across`]: no condition, no system, and exact also along edges that
//! end in a singular vertex, where the paper's patches have a kink.
//!
//! Edge k of a patch runs from its corner k to corner k + 1, as everywhere in this library. The paper's edge i, opposite vertex
//! i, is edge i + 1 here: its P_u, P_v, P_w are those of edges 1, 2, 0.

pub mod across;
pub mod b_patch;
mod build;
pub mod conic;
pub mod cubic;
mod folds;
mod form;
mod frame;
pub mod functional;
mod patch;
pub mod pieces;
mod sheets;
mod surface;
pub mod weighted;

pub use build::{BuildOptions, Built, build, build_with};
pub use folds::{Folds, folds, is_folded, is_folded_over, relax_folds};
pub use frame::{Frame, FrameError, FrameSeam};
pub use patch::RationalPatch;
pub use surface::{RationalParts, RationalSurface};
