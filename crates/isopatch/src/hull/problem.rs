use crate::mesh::{EdgeId, FaceId, VertexId};

/// What is wrong at an element of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reason {
    /// No vector has a positive product with the normals of all faces at a vertex, or the gradient given there has not.
    NoVisibleNormal,
    /// The cells of two neighbouring faces overlap.
    ApexOverlap,
    /// An edge cell is flat, or opens by more than half a turn.
    FlatEdgeCell,
    /// λ of the far apex, in the coordinates of a face cell, is −1/2 or less: the free parameter can't pull the surface
    /// over the edge towards the apexes, and nothing is certain there.
    SteepApex,
    /// No height of the apex gives the first layer the right signs.
    NoApex,
    /// The normals on the two sides of a crease lead it so far from its edge that a face beside it would fold.
    CreaseTurns,
    /// The patch turns over: small triangles of it face the wrong way.
    Folds,
}

impl Reason {
    /// All, in their order.
    pub const ALL: [Self; 7] = [
        Self::NoVisibleNormal,
        Self::ApexOverlap,
        Self::FlatEdgeCell,
        Self::SteepApex,
        Self::NoApex,
        Self::CreaseTurns,
        Self::Folds,
    ];

    /// One word for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoVisibleNormal => "no_visible_normal",
            Self::ApexOverlap => "apex_overlap",
            Self::FlatEdgeCell => "flat_edge_tet",
            Self::SteepApex => "mu4",
            Self::NoApex => "no_apex",
            Self::CreaseTurns => "crease_turns",
            Self::Folds => "folds",
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NoVisibleNormal => "its normal does not see all faces around it",
            Self::ApexOverlap => "the cells on its two sides overlap",
            Self::FlatEdgeCell => "its cell is flat or inverted",
            Self::SteepApex => "one of its apexes is too far from the other face",
            Self::NoApex => "no apex gives it the right signs",
            Self::Folds => "its patch turns over",
            Self::CreaseTurns => "its normals turn the crease into a face beside it",
        })
    }
}

/// An element of the mesh for which the hull is not valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// At a vertex.
    #[error("vertex {}: {reason}", vertex.0)]
    Vertex {
        /// The vertex.
        vertex: VertexId,
        /// What is wrong.
        reason: Reason,
    },
    /// At a face.
    #[error("face {}: {reason}", face.0)]
    Face {
        /// The face.
        face: FaceId,
        /// What is wrong.
        reason: Reason,
    },
    /// At an edge.
    #[error("edge {} between faces {} and {}: {reason}", edge.0, faces[0].0, faces[1].0)]
    Edge {
        /// The edge.
        edge: EdgeId,
        /// The faces that share it.
        faces: [FaceId; 2],
        /// What is wrong.
        reason: Reason,
    },
}

impl Problem {
    /// What is wrong.
    pub fn reason(&self) -> Reason {
        match self {
            Self::Vertex { reason, .. } | Self::Face { reason, .. } | Self::Edge { reason, .. } => *reason,
        }
    }
}
