//! Smooth surfaces made of few patches, from a formula or through the vertices of a mesh.
//!
//! A formula f(x, y, z) = 0 goes in; a closed surface of degree-7 Bézier triangles comes out that is tangent-plane
//! continuous (G1), interpolates positions, normals and normal curvatures at the vertices of a coarse mesh, and can be
//! written exactly as a STEP solid. The method is that of Tong & Kim (2009). A mesh becomes rational A-patches (Xu, Huang &
//! Bajaj 2001) or the same spline. PAPERS.md says where each formula of the papers is, and which are misprinted.
//!
//! # In short
//!
//! [`recipes`] has whole runs. This one makes the unit sphere of 80 patches, measures it, and writes a solid:
//!
//! ```
//! use isopatch::field::{Constants, Formula};
//! use isopatch::inspect::{InspectOptions, inspect};
//! use isopatch::io::step::{StepOptions, write_step};
//! use isopatch::recipes::spline::{Size, SplineRecipe, fit};
//!
//! let formula = Formula::parse("x^2 + y^2 + z^2 = 1", &Constants::new())?;
//! let recipe = SplineRecipe { size: Size::Faces(80), ..SplineRecipe::default() };
//! let fitted = fit(&formula, &recipe, &|_stage| ())?;
//! let (surface, base) = (&fitted.surface, &fitted.surface.base);
//!
//! // Lengths are relative to the diagonal of the base mesh, angles in radians.
//! let found = inspect(surface, base, Some(&fitted.formula), &InspectOptions::default());
//! assert!(found.deviation.is_some_and(|there| there.max_distance < 1e-3));
//! assert!(found.coverage.is_some_and(|back| back.max_distance < 1e-3));
//! assert_eq!(found.seams.max_gap, 0.0);
//! assert!(found.seams.max_normal_jump < 1e-9);
//!
//! let mut file = Vec::new();
//! write_step(surface, &StepOptions::default(), &mut file)?;
//! assert!(file.starts_with(b"ISO-10303-21;"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The way through
//!
//! ```text
//!                    BaseMesh  curves    Surface ┌─► tessellate ─► io ─► files
//! formula ─► field ─► base ─► network ─► spline ─┴─► inspect ─► report
//!                      ▲                               │
//!                      └─── rounds: shorter edges ─────┘
//! ```
//!
//! Each stage is a free function: immutable values and an options struct in, a new value or a typed error out.
//!
//! 1. **A field.** [`field::Field`] is a scalar function with gradient, Hessian and interval bounds. Its zero set is the
//!    surface, f < 0 is inside, and ∇f points out.
//! 2. **A base mesh.** [`base::build`] looks for the surface in a box, polygonises it, thins the mesh out to the wanted
//!    number of faces, makes the triangles well shaped and puts the vertices on the surface. The result is a
//!    [`base::BaseMesh`]: connectivity ([`mesh::HalfEdgeMesh`]), positions, normals, curvature tensors. Splines start
//!    from it. [`base::validity`] says whether a mesh from elsewhere is fit for that.
//! 3. **Boundary curves.** [`network::fit_quartics`] puts one quartic curve over each edge, with the tangent and the
//!    normal curvature of the surface at both ends.
//! 4. **Patches.** [`spline::build`] fills each face from its three curves, fits the interior to the surface, and then
//!    moves as little as it can for neighbours to be G1: at each vertex ([`spline::vertex`]), then along each edge
//!    ([`spline::edge`]). What it fits to is a [`surface::Target`].
//! 5. **A surface.** The result is a [`spline::TriangularSpline`], which implements [`surface::Surface`]: patches to
//!    sample and the seams between them. Everything after this point works for any surface.
//! 6. **What it is worth.** [`inspect`] measures gaps, normal jumps, distances both ways and topology on the finished
//!    surface; it takes nothing over from a solver. [`report`] puts the figures into one JSON object.
//! 7. **Rounds.** [`recipes::spline::fit`] goes through steps 2 to 6, remakes the base mesh ([`base::refine`]) with edges
//!    that are shorter where patches are worse, and keeps the best surface.
//! 8. **Files.** [`io`] writes the patches exactly (STEP, VTK, Gmsh, native), or the triangles of [`tessellate`] (GLB, 3MF, OBJ,
//!    OFF, PLY, STL); [`render`] draws pictures. [`io::read`] reads polygon meshes, whose connectivity a base mesh can take over ([`base::from_mesh`]).
//!
//! # Meshes
//!
//! [`recipes::apatch::fit`] repairs a mesh from [`io::read`], gives it normals, builds a [`hull`] of tetrahedra around it and a
//! function in the hull ([`apatch`]), whose zero set is the surface. [`recipes::mesh_spline::fit`] makes a spline over the mesh,
//! for STEP. [`inspect::inspect_a_patches`] measures A-patches. [`query`] finds the nearest point, the hits of a ray, and what is
//! inside, on surfaces of both kinds.
//!
//! Meshes of polygons become patches over polygons ([`hybrid`], [`recipes::hybrid`]); [`rational`] has rational patches over any
//! triangles with normals.
//!
//! # Singular surfaces
//!
//! [`singular`] finds the singular points and curves of a polynomial surface, and triangulates along them; [`expand`] grows
//! triangles from seeds. [`recipes::singular`] and [`recipes::algebraic`] are the whole runs.
//!
//! [`gallery`] has surfaces with a name. Below all this lie [`geom`] (points, boxes, intervals, jets), [`numeric`]
//! (quadrature) and [`bernstein`], which owns the order of control points and draws it.
//!
//! # Conventions
//!
//! Everything is `f64` in model units. Tolerances are options, with lengths relative to the diagonal of the bounding box
//! of the base mesh's vertices. Nothing depends on the number of threads, and no input makes a function panic.

pub mod apatch;
pub mod base;
pub mod bernstein;
pub mod expand;
pub mod field;
pub mod gallery;
pub mod geom;
pub mod hull;
pub mod hybrid;
pub mod inspect;
pub mod io;
pub mod mesh;
pub mod network;
pub mod numeric;
mod parallel;
pub mod query;
pub mod rational;
pub mod recipes;
pub mod render;
pub mod report;
pub mod singular;
pub mod spline;
pub mod surface;
pub mod tessellate;

// Test surfaces, shared with the integration tests, which name this crate from outside.
#[cfg(test)]
extern crate self as isopatch;
#[cfg(test)]
#[path = "../tests/support/golden.rs"]
#[allow(dead_code, reason = "some of them serve the integration tests alone")]
mod golden;
