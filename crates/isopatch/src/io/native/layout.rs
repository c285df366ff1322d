//! Numbers that writer and reader agree on.

use std::fmt;

/// First bytes of a file. Like PNG's, they show when a transfer changed line ends or cut the eighth bit.
pub const MAGIC: [u8; 8] = *b"\x89ISP\r\n\x1a\n";
/// Version whose change old readers cannot follow.
pub const MAJOR: u16 = 1;
/// Version whose change only adds sections.
pub const MINOR: u16 = 1;
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
/// Bytes of a vertex: position, normal, curvature tensor.
pub const VERTEX: usize = (3 + 3 + 9) * 8;
/// Bytes of a quartic.
pub const CURVE: usize = 5 * POINT;
/// Bytes of the interior of a patch.
pub const PATCH: usize = INTERIOR * POINT;

/// Bytes of a box.
pub const BOX: usize = 2 * POINT;

/// Name of a section.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Tag(pub [u8; 4]);

pub const META: Tag = Tag(*b"META");
pub const FACES: Tag = Tag(*b"FACE");
pub const VERTICES: Tag = Tag(*b"VERT");
pub const EDGES: Tag = Tag(*b"EDGE");
pub const CURVES: Tag = Tag(*b"CURV");
pub const INTERIORS: Tag = Tag(*b"INNR");
/// Only for a surface that a box cuts.
pub const CLIP: Tag = Tag(*b"CLIP");

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
