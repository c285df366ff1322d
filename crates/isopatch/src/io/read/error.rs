use std::fmt;
use std::path::PathBuf;

/// Why a mesh file can't be read. Elements are counted from 0, lines from 1.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system refused the file.
    #[error("can't read {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// The name does not tell a format that can be read.
    #[error("can't tell the mesh format of {}: its name must end in .obj, .off, .ply or .stl", path.display())]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// Something else stands where the format wants a certain thing.
    #[error("{place}: expected {expected}, found {found}")]
    Syntax {
        /// Where.
        place: Place,
        /// What the format wants there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// The file ends too early.
    #[error("{place}: the file ends where {expected} was expected")]
    Truncated {
        /// Where it ends.
        place: Place,
        /// What was still to come.
        expected: &'static str,
    },
    /// More data follows than the header announces.
    #[error("{place}: unexpected data after the last element that the header announces")]
    Trailing {
        /// Where it starts.
        place: Place,
    },
    /// The header announces more elements than the file can hold.
    #[error("the file claims {claimed} {what}, but has room for at most {room}")]
    TooMany {
        /// Elements of this kind, in the plural.
        what: &'static str,
        /// The number in the file.
        claimed: u64,
        /// The most that the remaining bytes can hold.
        room: usize,
    },
    /// A variant of the format that is not read.
    #[error("{place}: {what} is not supported")]
    Unsupported {
        /// Where it is asked for.
        place: Place,
        /// The feature.
        what: &'static str,
    },
    /// A PLY header lacks a property that makes up a mesh.
    #[error("the header has no property {property} in an element {element}")]
    MissingProperty {
        /// Name of the element.
        element: &'static str,
        /// Name of the property.
        property: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("{element} {index} has a coordinate that is not a finite number")]
    NotFinite {
        /// Vertex or normal; face in STL, where vertices have no numbers.
        element: Element,
        /// Its number, from 0.
        index: usize,
    },
    /// A face has less than three corners.
    #[error("face {face} has {corners} corners; it needs 3 or more")]
    TooFewCorners {
        /// The face, from 0.
        face: usize,
        /// The number of its corners.
        corners: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are {vertices} vertices, counted from {first}")]
    NoSuchVertex {
        /// The face, from 0.
        face: usize,
        /// The index as it stands in the file.
        index: i64,
        /// The index of the first vertex in this format: 1 in OBJ, otherwise 0.
        first: i64,
        /// The number of vertices; for a relative OBJ index, of those so far.
        vertices: usize,
    },
    /// A face of an OBJ file names a normal that does not exist.
    #[error("face {face} names normal {index}, but there are {normals} normals, counted from 1")]
    NoSuchNormal {
        /// The face, from 0.
        face: usize,
        /// The index as it stands in the file.
        index: i64,
        /// The number of normals; for a relative index, of those so far.
        normals: usize,
    },
    /// There is nothing but vertices.
    #[error("the file holds no face")]
    NoFaces,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(usize),
    /// An offset in a binary part, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// The kind of element that an error names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A vertex.
    Vertex,
    /// A normal.
    Normal,
    /// A face.
    Face,
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vertex => "vertex",
            Self::Normal => "normal",
            Self::Face => "face",
        })
    }
}
