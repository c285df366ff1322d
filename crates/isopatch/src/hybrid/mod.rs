//! Hybrid A-patches: triangles, quadrilaterals and larger polygons as they are (Xu, Bajaj & Evans).
//!
//! The construction of [`apatch`](crate::apatch) with other cells over the faces. Each gives the cell of an edge the same thing,
//! a [`Flank`], so that any two can stand beside each other; and along a ray from the base of any cell to its apex the function
//! is a plain cubic, whose smallest root is on the surface.
//!
//! ```text
//! data.rs       what is interpolated: polygons with gradients, and the coefficients that these give
//! cells.rs      the hull: which element a face has, its apexes, and the free parameters there
//! quadric.rs    quadratic functions and their blossoms
//!
//! face.rs       the cells over a face, by element: triangles (4.1) with the layers of the triangle method,
//! pyramid.rs      pyramids (4.2),
//! fan.rs          tetrahedra [u v p q] around an axis (4.3),
//! star.rs         tetrahedra [a c p q] around an axis, C1 for any number of corners
//! sectors.rs    what the last two have in common: the function in [a c p q]
//! flank.rs      from there to the cells of edges (4.4)
//!
//! crease.rs     patches beside sharp edges
//! function.rs   the function;  shoot.rs points and derivatives;  part.rs bounds;  locate.rs inside and outside
//! hull/         the hull of a mesh: cells, apexes, free parameters;  sheets.rs rays that meet the surface never or twice
//! grid.rs       many points at once
//! surface.rs    its zero set as patches, one over each polygon and one over each edge
//! ```
//!
//! What is stored for a side is for the function times the sign of the side, see [`hull`](crate::hull).

mod cells;
mod crease;
mod data;
mod face;
mod fan;
mod flank;
mod function;
pub mod grid;
pub mod hull;
mod locate;
mod part;
mod pyramid;
mod quadric;
mod sectors;
mod sheets;
mod shoot;
mod star;
mod surface;
mod tetra;

pub use cells::{Element, HybridEdge, HybridFace, HybridHull, Jet};
pub use data::{HermitePolygons, PolygonFrame, middle_gradient};
pub use face::{FaceCells, Foot};
pub use fan::FanNet;
pub use flank::{Extension, Flank, Third};
pub use function::HybridFunction;
pub use pyramid::PyramidCell;
pub use quadric::Quadric;
pub use sectors::{SectorBase, SectorSide, Sectors, Weights};
pub use sheets::{broken_edges, broken_faces, mended};
pub use surface::HybridSurface;
