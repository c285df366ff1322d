//! Bernstein–Bézier algebra: index orders, evaluation, elevation, energies and conversions.
//!
//! Every net of a triangle of degree n lists its coefficients b_ijk, i + j + k = n, by descending i, then
//! descending j. Corner 0 is b_n00, corner 1 is b_0n0, corner 2 is b_00n. For degree 3:
//!
//! ```text
//!                   0                    300
//!                  / \
//!                 1   2               210   201
//!                / \ / \
//!               3   4   5           120  111  102
//!              / \ / \ / \
//!             6   7   8   9       030  021  012  003
//! ```
//!
//! Edge k runs from corner k to corner k + 1 (mod 3), counter-clockwise. [`index`] owns this order.

pub mod cubic;
pub mod curve;
pub mod energy;
pub mod index;
pub mod lanes;
pub mod pyramid;
pub mod quads;
pub mod restrict;
pub mod tensor;
pub mod tetrahedron;
pub mod triangle;
