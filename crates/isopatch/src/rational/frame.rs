use crate::geom::{Point3, Vec3};
use crate::mesh::{HalfEdgeId, HalfEdgeMesh};
use crate::surface::{Continuity, PatchId, SeamSide};

/// What a rational surface interpolates: triangles with normals at their corners, and how they meet.
///
/// Vertices are points in space: sheets that cross, or touch in a point, have the vertices there in common. So the triangles need
/// be no manifold; where they meet smoothly the seams say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Position of each vertex.
    pub positions: Vec<Point3>,
    /// Vertices of each triangle, counter-clockwise seen from the side of its normals.
    pub faces: Vec<[u32; 3]>,
    /// Normal at each corner of each triangle, of any length; none where the vertex is singular and has none in this sheet.
    pub normals: Vec<[Option<Vec3>; 3]>,
    /// Each edge of each triangle is in one of them.
    pub seams: Vec<FrameSeam>,
}

/// Where two triangles meet, or one ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSeam {
    /// A triangle and its edge k, from corner k to k + 1.
    pub first: (u32, u8),
    /// The other; none on a boundary.
    pub second: Option<(u32, u8)>,
    /// Are the patches to have the same tangent planes there? Else they only meet.
    pub smooth: bool,
    /// Number of the wire; seams with the same number lie on one curve, as where sheets cross. From 0, without gaps.
    pub wire: u32,
}

/// Why there is no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// A position is infinite or not a number, or its triangle names a vertex that is not there.
    #[error("the position of vertex {vertex} is missing or not finite")]
    Position {
        /// The vertex.
        vertex: u32,
    },
    /// A triangle has two corners in one point.
    #[error("face {face} has an edge without length")]
    Edge {
        /// The triangle.
        face: u32,
    },
    /// A normal is zero, infinite or not a number.
    #[error("a normal of face {face} is zero or not finite")]
    Normal {
        /// The triangle.
        face: u32,
    },
    /// Another number of normals or patches than there are triangles, or of curves than there are wires.
    #[error("{given} are given where {wanted} are needed")]
    Count {
        /// How many are given.
        given: usize,
        /// How many there have to be.
        wanted: usize,
    },
    /// No seam has the wire of this number, though there are larger ones.
    #[error("no seam is on wire {wire}")]
    Wire {
        /// The wire.
        wire: u32,
    },
    /// An edge of a triangle is in no seam or in several, or a seam or wire does not fit its triangles.
    #[error("edge {edge} of face {face} is not in exactly one seam that fits it")]
    Seam {
        /// The triangle.
        face: u32,
        /// Its edge.
        edge: u8,
    },
}

impl Frame {
    /// A mesh of triangles with a normal at every corner, given at the origin of each half edge; zero for none. Across edges that
    /// are `sharp`, and those at whose ends the normals differ, the patches only meet.
    pub fn over_mesh(
        mesh: &HalfEdgeMesh,
        positions: &[Point3],
        corner_normals: &[Vec3],
        sharp: &[bool],
    ) -> Self {
        let normal = |h: HalfEdgeId| Some(corner_normals[h.index()]).filter(|n| *n != Vec3::zeros());
        let side = |h: HalfEdgeId| (mesh.face(h).0, mesh.side(h) as u8);
        let seams = mesh.edges().map(|e| {
            let h = mesh.edge_half_edge(e);
            let twin = mesh.twin(h);
            let agree =
                |g: HalfEdgeId| normal(h) == normal(mesh.next(g)) && normal(mesh.next(h)) == normal(g);
            let smooth = twin.is_some_and(|g| !sharp[e.index()] && agree(g));
            FrameSeam { first: side(h), second: twin.map(side), smooth, wire: e.0 }
        });
        Self {
            positions: positions.to_vec(),
            faces: mesh.faces().map(|f| mesh.triangle(f).map(|v| v.0)).collect(),
            normals: mesh.faces().map(|f| [0, 1, 2].map(|k| normal((3 * f.index() + k).into()))).collect(),
            seams: seams.collect(),
        }
    }

    /// Vertices at the start and the end of an edge of a triangle.
    pub fn ends(&self, (face, edge): (u32, u8)) -> [u32; 2] {
        let (face, k) = (self.faces[face as usize], usize::from(edge));
        [face[k], face[(k + 1) % 3]]
    }

    /// Normals there.
    pub fn end_normals(&self, (face, edge): (u32, u8)) -> [Option<Vec3>; 2] {
        let (normals, k) = (self.normals[face as usize], usize::from(edge));
        [normals[k], normals[(k + 1) % 3]]
    }

    /// Positions of the corners of a triangle.
    pub fn corners(&self, face: u32) -> [Point3; 3] {
        self.faces[face as usize].map(|v| self.positions[v as usize])
    }

    /// Number of wires.
    pub fn wire_count(&self) -> usize {
        self.seams.iter().map(|seam| seam.wire as usize + 1).max().unwrap_or(0)
    }

    /// Is everything there, and does it fit together?
    ///
    /// # Errors
    /// The first thing that does not.
    pub fn check(&self) -> Result<(), FrameError> {
        let wanted = self.faces.len();
        if self.normals.len() != wanted {
            return Err(FrameError::Count { given: self.normals.len(), wanted });
        }
        let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
        for (f, face) in self.faces.iter().enumerate() {
            let bad = face.iter().find(|v| !self.positions.get(**v as usize).is_some_and(finite));
            if let Some(vertex) = bad {
                return Err(FrameError::Position { vertex: *vertex });
            }
            let corners = face.map(|v| self.positions[v as usize]);
            if (0..3).any(|k| corners[k] == corners[(k + 1) % 3]) {
                return Err(FrameError::Edge { face: f as u32 });
            }
            let bad = |n: &Vec3| !finite(n) || n.norm_squared() == 0.0;
            if self.normals[f].iter().flatten().any(bad) {
                return Err(FrameError::Normal { face: f as u32 });
            }
        }
        self.check_seams()
    }

    fn check_seams(&self) -> Result<(), FrameError> {
        let mut used = vec![[false; 3]; self.faces.len()];
        let mut wires: Vec<Option<[u32; 2]>> = vec![None; self.seams.len()];
        for seam in &self.seams {
            for (face, edge) in std::iter::once(seam.first).chain(seam.second) {
                let fault = FrameError::Seam { face, edge };
                let place = used.get_mut(face as usize).and_then(|edges| edges.get_mut(usize::from(edge)));
                match place {
                    Some(free) if !*free => *free = true,
                    _ => return Err(fault),
                }
                let mut ends = self.ends((face, edge));
                ends.sort_unstable();
                let wire = wires.get_mut(seam.wire as usize).ok_or(fault)?;
                if *wire.get_or_insert(ends) != ends {
                    return Err(fault);
                }
            }
            if let Some(second) = seam.second.filter(|_| seam.smooth)
                && self.ends(second) == self.ends(seam.first)
            {
                // Both sides of a smooth seam have the same orientation.
                return Err(FrameError::Seam { face: second.0, edge: second.1 });
            }
        }
        let last = wires.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        if let Some(gap) = wires[..last].iter().position(Option::is_none) {
            return Err(FrameError::Wire { wire: gap as u32 });
        }
        let missing =
            used.iter().enumerate().find_map(|(f, edges)| Some((f, edges.iter().position(|u| !u)?)));
        match missing {
            Some((face, edge)) => Err(FrameError::Seam { face: face as u32, edge: edge as u8 }),
            None => Ok(()),
        }
    }

    /// Sides of a seam, as a surface has them: the first gives the direction.
    pub(super) fn sides(&self, seam: &FrameSeam) -> (SeamSide, Option<SeamSide>, Continuity) {
        let start = self.ends(seam.first)[0];
        let side = |(face, edge): (u32, u8)| SeamSide {
            patch: PatchId(face),
            edge,
            reversed: self.ends((face, edge))[0] != start,
        };
        let continuity = if seam.smooth { Continuity::G1 } else { Continuity::G0 };
        (side(seam.first), seam.second.map(side), continuity)
    }
}
