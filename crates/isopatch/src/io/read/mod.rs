//! Readers of polygon meshes: OBJ, OFF, PLY (ASCII and binary) and STL (ASCII and binary).
//!
//! A reader checks what can be known without connectivity: every coordinate is finite, every face has three
//! corners or more, every index names a vertex. Faces stay polygons, in the order of the file; holes, flipped
//! faces, repeated corners and vertices without a face are left to later stages. Coordinates are exact:
//! decimal text becomes the nearest `f64`, and binary `f32` is widened.
//!
//! All of the parsing is done here. The published crates for OBJ and STL keep positions as `f32`, and the one
//! for PLY reserves memory for as many elements as an untrusted header announces.

mod error;
mod obj;
mod off;
mod ply;
mod stl;
mod text;

pub use error::{Element, Place, ReadError};
pub use obj::read_obj;
pub use off::read_off;
pub use ply::read_ply;
pub use stl::read_stl;

use crate::geom::{Point3, Vec3};
use std::path::Path;

/// The content of a mesh file: vertices, and polygons that name them.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonMesh {
    /// One position a vertex, in model units; all coordinates are finite.
    pub positions: Vec<Point3>,
    /// The corners of each face, three or more, as indices into `positions`.
    pub faces: Vec<Vec<u32>>,
    /// One normal a vertex, as long as the file has it (finite, perhaps not of unit length); none if the file
    /// has no vertex normals.
    pub normals: Option<Vec<Vec3>>,
}

/// Reads a mesh file; the ending of its name (.obj, .off, .ply, .stl, in any case) tells the format.
///
/// # Errors
/// The file can't be read, its ending is another, or its content is refused: see [`ReadError`].
pub fn read_mesh(path: &Path) -> Result<PolygonMesh, ReadError> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let read = match ending.to_str() {
        Some("obj") => read_obj,
        Some("off") => read_off,
        Some("ply") => read_ply,
        Some("stl") => read_stl,
        _ => return Err(ReadError::UnknownEnding { path: path.to_owned() }),
    };
    let bytes = std::fs::read(path).map_err(|source| ReadError::File { path: path.to_owned(), source })?;
    read(&bytes)
}

impl PolygonMesh {
    /// Passes the mesh on if its numbers are finite and it has faces, of three corners or more. (That indices
    /// are in range, the readers check where they still know them as the file has them.)
    fn checked(self) -> Result<Self, ReadError> {
        check_finite(Element::Vertex, &self.positions)?;
        check_finite(Element::Normal, self.normals.as_deref().unwrap_or_default())?;
        if self.faces.is_empty() {
            return Err(ReadError::NoFaces);
        }
        match self.faces.iter().position(|corners| corners.len() < 3) {
            Some(face) => Err(ReadError::TooFewCorners { face, corners: self.faces[face].len() }),
            None => Ok(self),
        }
    }
}

fn check_finite(element: Element, vectors: &[Vec3]) -> Result<(), ReadError> {
    match vectors.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
        Some(index) => Err(ReadError::NotFinite { element, index }),
        None => Ok(()),
    }
}

/// The claimed number of elements, if the rest of the file can hold them: called before anything is allocated.
///
/// `bytes_each` is the least that one element takes, with its separator; the last element of a text file may
/// go without, hence the one extra byte.
fn check_room(
    what: &'static str,
    claimed: u64,
    bytes_each: usize,
    bytes_left: usize,
) -> Result<usize, ReadError> {
    let room = (bytes_left + 1) / bytes_each.max(1);
    match usize::try_from(claimed) {
        Ok(count) if count <= room => Ok(count),
        _ => Err(ReadError::TooMany { what, claimed, room }),
    }
}

/// A corner of a face, in a format that counts vertices from 0.
fn vertex_index(face: usize, index: i64, vertices: usize) -> Result<u32, ReadError> {
    let in_range = usize::try_from(index).is_ok_and(|i| i < vertices);
    let vertex = u32::try_from(index).ok().filter(|_| in_range);
    vertex.ok_or(ReadError::NoSuchVertex { face, index, first: 0, vertices })
}
