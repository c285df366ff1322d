use crate::geom::{Vec3, are_finite};
use crate::tessellate::{SharingError, TessellateError, Tessellation};

/// Why a surface or mesh cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The output refuses the bytes.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The patches do not say what they share.
    #[error(transparent)]
    Sharing(#[from] SharingError),
    /// The surface cannot be sampled.
    #[error(transparent)]
    Tessellate(#[from] TessellateError),
    /// The format cannot hold patches of this degree.
    #[error("patch {patch} has degree {degree}; {format} is written for degree 7 only")]
    Degree {
        /// The format.
        format: &'static str,
        /// The patch.
        patch: u32,
        /// Its degree.
        degree: usize,
    },
    /// The format holds Bézier patches, and this is none.
    #[error("patch {patch} has no control points; {format} needs them")]
    NoNet {
        /// The format.
        format: &'static str,
        /// The patch.
        patch: u32,
    },
    /// There are no patches, and the format has no empty shape.
    #[error("{format} cannot hold a surface without patches")]
    Empty {
        /// The format.
        format: &'static str,
    },
    /// The uncertainty is not a positive length.
    #[error("the uncertainty {0} is not a positive length")]
    Uncertainty(f64),
    /// A coordinate is infinite or not a number.
    #[error("{what} {index} has a coordinate that is not finite")]
    NotFinite {
        /// "patch" or "vertex".
        what: &'static str,
        /// Its number.
        index: usize,
    },
    /// A coefficient of an A-patch is infinite or not a number.
    #[error("number {index} of section {section} is not finite")]
    Coefficient {
        /// The section of the native format.
        section: String,
        /// Position of the number there.
        index: usize,
    },
    /// A closed component faces inward and nothing encloses it.
    #[error("the component of patch {patch} faces inward and lies in no other: its solid would be unbounded")]
    InsideOut {
        /// The component's first patch.
        patch: u32,
    },
    /// The format counts in 32 bits.
    #[error("{format} cannot hold {count} {what}")]
    TooMany {
        /// The format.
        format: &'static str,
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// The native format stores a patch border as the quartic of its edge.
    #[error("the border of patch {patch} is not the elevated quartic of edge {edge}, from vertex to vertex")]
    Border {
        /// The patch.
        patch: u32,
        /// The edge of the base mesh.
        edge: u32,
    },
}

/// Are all positions and normals of a mesh finite?
pub(super) fn check_finite(mesh: &Tessellation) -> Result<(), WriteError> {
    let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
    if are_finite(&mesh.positions) && are_finite(&mesh.normals) {
        return Ok(());
    }
    let bad = mesh.positions.iter().zip(&mesh.normals).position(|(p, n)| !finite(p) || !finite(n));
    if let Some(index) = bad {
        return Err(WriteError::NotFinite { what: "vertex", index });
    }
    let bad = mesh.normals.iter().position(|n| !finite(n));
    bad.map_or(Ok(()), |index| Err(WriteError::NotFinite { what: "normal", index }))
}
