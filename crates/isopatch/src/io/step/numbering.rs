use crate::io::net::DEGREE;
use crate::surface::{PatchId, Surface};
use crate::tessellate::{EdgeUse, SharedLattice, SharingError};

/// Numbers of the entities (the # of ISO 10303-21), so that patches can refer to each other's entities while they
/// are formatted independently.
///
/// Corners come first, then seams, then patches; each kind has a fixed number of entities:
///
/// ```text
/// corner  0 CARTESIAN_POINT   1 VERTEX_POINT
/// seam    0 midpoint   1…6, 7…12 points inside the halves   13 VERTEX_POINT   14, 15 curves   16, 17 EDGE_CURVEs
/// patch   0 centroid   1…18 points inside the spokes   19…126 points inside the quads   127 VERTEX_POINT
///         128…130 spoke curves   131…133 EDGE_CURVEs
///         then for each quad: surface, 4 ORIENTED_EDGEs, EDGE_LOOP, FACE_OUTER_BOUND, ADVANCED_FACE
/// ```
pub struct Numbering {
    lattice: SharedLattice,
    seam_start: u64,
    patch_start: u64,
    end: u64,
}

const CORNER: u64 = 2;
const SEAM: u64 = 18;
const PATCH: u64 = 158;
const QUAD: u64 = 134;
const ENTITIES_PER_QUAD: u64 = 8;
/// Control points strictly inside a curve.
const INNER: u64 = DEGREE as u64 - 1;

impl Numbering {
    pub fn new(surface: &dyn Surface) -> Result<Self, SharingError> {
        let lattice = SharedLattice::new(surface, DEGREE)?;
        // Entity numbers start at 1.
        let seam_start = 1 + CORNER * lattice.corner_count() as u64;
        let patch_start = seam_start + SEAM * surface.seams().len() as u64;
        let end = patch_start + PATCH * surface.patch_count() as u64;
        Ok(Self { lattice, seam_start, patch_start, end })
    }

    pub fn lattice(&self) -> &SharedLattice {
        &self.lattice
    }

    /// The first number that is free after all patches.
    pub fn end(&self) -> u64 {
        self.end
    }

    pub fn corner_point(&self, corner: u32) -> u64 {
        1 + CORNER * u64::from(corner)
    }

    pub fn corner_vertex(&self, corner: u32) -> u64 {
        self.corner_point(corner) + 1
    }

    /// The midpoint of a seam, the first of its entities.
    pub fn seam(&self, seam: u32) -> u64 {
        self.seam_start + SEAM * u64::from(seam)
    }

    /// Control point m, 0 < m < 7, of a half of a seam.
    pub fn seam_inner(&self, seam: u32, half: usize, m: usize) -> u64 {
        self.seam(seam) + 1 + INNER * half as u64 + (m as u64 - 1)
    }

    pub fn seam_vertex(&self, seam: u32) -> u64 {
        self.seam(seam) + 13
    }

    pub fn seam_curve(&self, seam: u32, half: usize) -> u64 {
        self.seam(seam) + 14 + half as u64
    }

    pub fn seam_edge(&self, seam: u32, half: usize) -> u64 {
        self.seam(seam) + 16 + half as u64
    }

    /// The centroid of a patch, the first of its entities.
    pub fn patch(&self, patch: PatchId) -> u64 {
        self.patch_start + PATCH * u64::from(patch.0)
    }

    pub fn centroid_vertex(&self, patch: PatchId) -> u64 {
        self.patch(patch) + 127
    }

    pub fn spoke_curve(&self, patch: PatchId, spoke: usize) -> u64 {
        self.patch(patch) + 128 + spoke as u64
    }

    pub fn spoke_edge(&self, patch: PatchId, spoke: usize) -> u64 {
        self.patch(patch) + 131 + spoke as u64
    }

    /// The surface of a quad, the first of its entities.
    pub fn quad(&self, patch: PatchId, quad: usize) -> u64 {
        self.patch(patch) + QUAD + ENTITIES_PER_QUAD * quad as u64
    }

    pub fn face(&self, patch: PatchId, quad: usize) -> u64 {
        self.quad(patch, quad) + ENTITIES_PER_QUAD - 1
    }

    /// Control point m of a spoke, which runs from the midpoint of the edge to the centroid.
    pub fn spoke_point(&self, patch: PatchId, spoke: usize, m: usize) -> u64 {
        match m {
            0 => self.seam(self.lattice.edges(patch)[spoke].seam),
            DEGREE => self.patch(patch),
            _ => self.patch(patch) + 1 + INNER * spoke as u64 + (m as u64 - 1),
        }
    }

    /// Control point m of a half of a patch's edge, in the direction of the patch.
    pub fn edge_point(&self, patch: PatchId, edge: usize, half: usize, m: usize) -> u64 {
        let EdgeUse { seam, reversed } = self.lattice.edges(patch)[edge];
        let corners = self.lattice.corners(patch);
        match (half, m) {
            (0, 0) => self.corner_point(corners[edge]),
            (1, DEGREE) => self.corner_point(corners[(edge + 1) % 3]),
            (0, DEGREE) | (_, 0) => self.seam(seam),
            _ if reversed => self.seam_inner(seam, 1 - half, DEGREE - m),
            _ => self.seam_inner(seam, half, m),
        }
    }

    /// Control point (i, j) of a quad, drawn in [`crate::bernstein::quads`].
    pub fn quad_point(&self, patch: PatchId, quad: usize, i: usize, j: usize) -> u64 {
        let previous = (quad + 2) % 3;
        match (i, j) {
            (_, 0) => self.edge_point(patch, quad, 0, i),
            (0, _) => self.edge_point(patch, previous, 1, DEGREE - j),
            (DEGREE, _) => self.spoke_point(patch, quad, j),
            (_, DEGREE) => self.spoke_point(patch, previous, i),
            _ => self.quad_inner(patch, quad, i, j),
        }
    }

    /// Control point (i, j) inside a quad, 0 < i, j < 7.
    pub fn quad_inner(&self, patch: PatchId, quad: usize, i: usize, j: usize) -> u64 {
        self.patch(patch) + 19 + INNER * INNER * quad as u64 + INNER * (i as u64 - 1) + (j as u64 - 1)
    }

    /// The EDGE_CURVE of a half of a patch's edge, and whether the two have the same direction.
    pub fn half_edge(&self, patch: PatchId, edge: usize, half: usize) -> (u64, bool) {
        let EdgeUse { seam, reversed } = self.lattice.edges(patch)[edge];
        (self.seam_edge(seam, if reversed { 1 - half } else { half }), !reversed)
    }

    /// The border of a quad, counter-clockwise in its parameters from (0, 0).
    pub fn quad_loop(&self, patch: PatchId, quad: usize) -> [(u64, bool); 4] {
        let previous = (quad + 2) % 3;
        [
            self.half_edge(patch, quad, 0),
            (self.spoke_edge(patch, quad), true),
            (self.spoke_edge(patch, previous), false),
            self.half_edge(patch, previous, 1),
        ]
    }
}
