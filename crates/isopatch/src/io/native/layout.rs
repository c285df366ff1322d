//! Numbers that writer and reader agree on.

use std::fmt;

/// First bytes of a file. Like PNG's, they show when a transfer changed line ends or cut the eighth bit.
pub const MAGIC: [u8; 8] = *b"\x89ISP\r\n\x1a\n";
/// Version whose change old readers cannot follow.
pub const MAJOR: u16 = 1;
/// Version whose change only adds: sections, which old readers skip or miss, and codes, which they refuse by name.
pub const MINOR: u16 = 5;
/// Bytes before the section table: magic, versions, number of sections.
pub const FIXED_HEADER: usize = 8 + 2 + 2 + 4;
/// Bytes of an entry of the section table: tag, checksum, offset, length.
pub const ENTRY: usize = 4 + 4 + 8 + 8;
/// Bytes of a checksum.
pub const CHECKSUM: usize = 4;

/// Degree of the patches.
pub const DEGREE: usize = 7;
/// Control points inside a patch.
pub const INTERIOR: usize = 15;
/// Bytes of a point.
pub const POINT: usize = 24;
/// Numbers of a vertex: position, normal, curvature tensor with its upper triangle only.
pub const VERTEX_NUMBERS: usize = 3 + 3 + 6;
/// The same with the whole tensor: up to version 1.4, and where one is not symmetric.
pub const OLD_VERTEX_NUMBERS: usize = 3 + 3 + 9;
/// The entries of a tensor that are stored.
pub const UPPER: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
/// Inner control points of a quartic, whose ends are vertices.
pub const CURVE_POINTS: usize = 3;
/// The same up to version 1.4, with the ends.
pub const OLD_CURVE_POINTS: usize = 5;
/// Bytes of the interior of a patch.
pub const PATCH: usize = INTERIOR * POINT;

/// Bytes of a box.
pub const BOX: usize = 2 * POINT;

/// Name of a section.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Tag(pub [u8; 4]);

pub const META: Tag = Tag(*b"META");
pub const FACES: Tag = Tag(*b"FACE");
pub const VERTICES: Tag = Tag(*b"NODE");
pub const EDGES: Tag = Tag(*b"EDGE");
pub const CURVES: Tag = Tag(*b"QRTC");
pub const INTERIORS: Tag = Tag(*b"INNR");
// What versions up to 1.4 have in place of vertices and curves.
pub const OLD_VERTICES: Tag = Tag(*b"VERT");
pub const OLD_CURVES: Tag = Tag(*b"CURV");
/// Only for a surface that a box cuts.
pub const CLIP: Tag = Tag(*b"CLIP");

// Sections of A-patches.
pub const POSITIONS: Tag = Tag(*b"APOS");
pub const GRADIENTS: Tag = Tag(*b"AGRD");
pub const CREASES: Tag = Tag(*b"ACRS");
pub const FACE_CLASSES: Tag = Tag(*b"AFCC");
pub const EDGE_CLASSES: Tag = Tag(*b"AECC");
pub const RAYS: Tag = Tag(*b"ARAY");
pub const BASES: Tag = Tag(*b"ABAS");
pub const FACE_CELLS: Tag = Tag(*b"AFCL");
pub const EDGE_CELLS: Tag = Tag(*b"AECL");
pub const FREE: Tag = Tag(*b"AFRE");
pub const NOTES: Tag = Tag(*b"ANOT");

// Sections of hybrid A-patches, besides positions, gradients and creases.
pub const POLYGONS: Tag = Tag(*b"HFAC");
pub const MIDDLES: Tag = Tag(*b"HMID");
pub const ELEMENTS: Tag = Tag(*b"HELM");
pub const LINES: Tag = Tag(*b"HLIN");

// Sections of rational patches.
pub const TRIANGLES: Tag = Tag(*b"RTRI");
pub const POINTS: Tag = Tag(*b"RPOS");
pub const NORMALS: Tag = Tag(*b"RNRM");
pub const WIRE_STARTS: Tag = Tag(*b"RWST");
pub const WIRES: Tag = Tag(*b"RWIR");
pub const SEAMS: Tag = Tag(*b"RSEA");
pub const CORRECTIONS: Tag = Tag(*b"RPAT");

/// Bytes of a seam: two triangles and a wire, then two edges, whether it is smooth, and one of padding.
pub const SEAM: usize = 3 * 4 + 4;
/// The number of a triangle that is not there.
pub const NO_FACE: u32 = u32::MAX;
/// Numbers of a patch: middle point of the cubic, twelve coefficients of corrections, M.
pub const CORRECTION_NUMBERS: usize = 3 + 36 + 3;

/// Every section that this version knows.
pub const KNOWN: [Tag; 31] = [
    META,
    FACES,
    VERTICES,
    EDGES,
    CURVES,
    OLD_VERTICES,
    OLD_CURVES,
    INTERIORS,
    CLIP,
    POSITIONS,
    GRADIENTS,
    CREASES,
    FACE_CLASSES,
    EDGE_CLASSES,
    RAYS,
    BASES,
    FACE_CELLS,
    EDGE_CELLS,
    FREE,
    NOTES,
    POLYGONS,
    MIDDLES,
    ELEMENTS,
    LINES,
    TRIANGLES,
    POINTS,
    NORMALS,
    WIRE_STARTS,
    WIRES,
    SEAMS,
    CORRECTIONS,
];

/// Numbers of a face: direction and heights of its rays.
pub const RAY_NUMBERS: usize = 3 + 2;
/// Numbers of a face: layer 0.
pub const BASE_NUMBERS: usize = 9;
/// Numbers of a cell over a face: apex, layer 1 at corners and edges, q.
pub const FACE_CELL_NUMBERS: usize = 3 + 3 + 3 + 3;
/// Numbers of a cell over an edge: μ, ν, angle, b, a, far.
pub const EDGE_CELL_NUMBERS: usize = 4 + 4 + 1 + 2 + 2 + 2;
/// Numbers of a face: default, bound and value of the free parameter, on both sides.
pub const FREE_NUMBERS: usize = 6;
/// Bytes of a face of polygons: class, element, apexes, values at them.
pub const ELEMENT_BYTES: usize = 4;
/// Numbers of such a face: centre, direction of the line, on each side apex, value and gradient, and the quadric: its
/// coefficients, centre and scale.
pub const LINE_NUMBERS: usize = 3 + 3 + 2 * (3 + 4) + 10 + 3 + 1;
/// Bytes of a note: what, why, two of padding, number of the element.
pub const NOTE: usize = 8;
/// The reason of a note without one.
pub const NO_REASON: u8 = 255;

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

impl fmt::Debug for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
