//! Whole runs, from a formula or a mesh to a surface: one file per paper, which reads like the paper's outline.
//!
//! [`spline`] is Tong & Kim 2009, section 3.4, in rounds: a surface is made and checked, every patch has its error, and
//! the base mesh is remade with edge lengths that follow from these errors. The rounds are ours; PAPERS.md says why.
//!
//! [`paper_spline`] is the same paper to the letter, for comparison: what the printed choices do and break. [`paper_apatch`],
//! [`paper_hybrid`] and [`paper_rational`] are that for the other three papers.
//!
//! [`apatch`] is Xu, Huang & Bajaj 2001: a mesh in, a surface through its vertices out.
//! [`hybrid`] is Xu, Bajaj & Evans: the same for a mesh of polygons, which stay as they are.
//! [`mesh_spline`] is the spline through the vertices of a triangle mesh, with estimated normals and curvatures.
//!
//! [`singular`] triangulates an algebraic surface along its singular points and curves (Bajaj & Xu 1997, sections 3 and 4).
//!
//! [`algebraic`] is Bajaj & Xu 1997: rational patches over an algebraic surface with singularities; [`rational`] makes them through the
//! vertices of a mesh.
//!
//! [`find_defect`] names a place where a formula has a kink on its surface: no smooth surface could be made there. [`touching`] tells
//! formulas that never change their sign, which have no surface.

pub mod adapt;
pub mod algebraic;
pub mod apatch;
mod differentiable;
mod finish;
pub mod hybrid;
mod least;
pub mod mesh_spline;
pub mod paper_apatch;
pub mod paper_hybrid;
pub mod paper_rational;
pub mod paper_spline;
mod patchwork;
pub mod rational;
mod refine;
mod rounds;
pub mod singular;
pub mod singular_apatch;
pub mod spline;
mod touching;
mod triangulated;

pub use differentiable::{Defect, find_defect};
pub use touching::{Touching, touching};
pub use triangulated::TriangulationError;

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod open_tests;
