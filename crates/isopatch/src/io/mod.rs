//! Files: STEP, VTK, Gmsh, glTF, 3MF, OBJ, OFF, PLY, STL, PNG and the native format.
//!
//! Meshes are read by [`read`]. Every writer is a free function into an [`std::io::Write`]; [`atomic`] puts the bytes
//! under their final name.
//! STEP, VTK, Gmsh and the native format hold the patches exactly, PNG a [picture](crate::render), the others a [`crate::tessellate::Tessellation`].
//! The same input gives the same bytes, whatever the number of threads.

pub mod atomic;
mod error;
mod format;
pub mod gltf;
pub mod gmsh;
pub mod native;
mod net;
pub mod obj;
pub mod off;
pub mod ply;
pub mod png;
pub mod read;
pub mod step;
pub mod stl;
mod text;
mod thin;
pub mod threemf;
mod unit;
pub mod vtk;

pub use error::WriteError;
pub use format::{Format, UnknownFormat};
pub use thin::ThinParts;
pub use unit::{Unit, UnknownUnit};
