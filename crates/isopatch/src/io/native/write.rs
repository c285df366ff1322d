use super::Provenance;
use super::layout::*;
use crate::base::{Clip, EdgeFeature};
use crate::bernstein::{curve, index};
use crate::geom::{Mat3, Point3};
use crate::io::WriteError;
use crate::mesh::{EdgeId, HalfEdgeId, HalfEdgeMesh};
use crate::spline::TriangularSpline;
use std::io::Write;

/// Writes a spline so that [`super::read_native`] gives it back bit for bit.
///
/// # Errors
/// [`WriteError::Border`] if the border of a patch is not, bit for bit, the elevated quartic of its edge from vertex to vertex,
/// and [`WriteError::NotFinite`].
pub fn write_native(
    spline: &TriangularSpline,
    provenance: &Provenance,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    check(spline)?;
    let mut sections = vec![
        Section::new(META, || meta(provenance)),
        Section::new(FACES, || Ok(faces(&spline.base.mesh))),
        vertices(spline),
        Section::new(EDGES, || Ok(spline.base.features.iter().map(|f| feature_code(*f)).collect())),
        Section::new(CURVES, || Ok(points(spline.curves.iter().flat_map(|curve| &curve[1..4])))),
        Section::new(INTERIORS, || Ok(interiors(spline))),
    ];
    sections.extend(spline.base.clip.as_ref().map(|clip| Section::new(CLIP, || Ok(clip_bytes(clip)))));
    write_sections(&sections, out)
}

/// A section and what makes its bytes. They are made twice, once for the table and once for the file, so that never more than
/// one section is in memory.
pub(super) struct Section<'a> {
    tag: Tag,
    bytes: Box<dyn Fn() -> Result<Vec<u8>, WriteError> + 'a>,
}

impl<'a> Section<'a> {
    pub fn new(tag: Tag, bytes: impl Fn() -> Result<Vec<u8>, WriteError> + 'a) -> Self {
        Self { tag, bytes: Box::new(bytes) }
    }
}

/// Writes the frame: header, section table, sections.
pub(super) fn write_sections(sections: &[Section<'_>], out: &mut impl Write) -> Result<(), WriteError> {
    let mut header = Vec::new();
    header.extend_from_slice(&MAGIC);
    header.extend_from_slice(&MAJOR.to_le_bytes());
    header.extend_from_slice(&MINOR.to_le_bytes());
    header.extend_from_slice(&(sections.len() as u32).to_le_bytes());
    let mut offset = (FIXED_HEADER + sections.len() * ENTRY + CHECKSUM) as u64;
    for section in sections {
        let bytes = (section.bytes)()?;
        header.extend_from_slice(&section.tag.0);
        header.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
        header.extend_from_slice(&offset.to_le_bytes());
        header.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        offset += bytes.len() as u64;
    }
    let checksum = crc32fast::hash(&header);
    header.extend_from_slice(&checksum.to_le_bytes());
    out.write_all(&header)?;
    for section in sections {
        out.write_all(&(section.bytes)()?)?;
    }
    Ok(())
}

fn feature_code(feature: EdgeFeature) -> u8 {
    match feature {
        EdgeFeature::Smooth => 0,
        EdgeFeature::Boundary => 1,
        EdgeFeature::Sharp => 2,
    }
}

pub(super) fn meta(provenance: &Provenance) -> Result<Vec<u8>, WriteError> {
    let mut bytes = Vec::new();
    for text in [&provenance.generator, &provenance.options, &provenance.source, provenance.unit.symbol()] {
        let count = text.len();
        let too_many = |_| WriteError::TooMany { format: "a native file", what: "bytes of text", count };
        bytes.extend_from_slice(&u32::try_from(count).map_err(too_many)?.to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
    }
    bytes.extend_from_slice(&provenance.diagonal.to_le_bytes());
    Ok(bytes)
}

pub(super) fn faces(mesh: &HalfEdgeMesh) -> Vec<u8> {
    let counts = [mesh.vertex_count() as u32, mesh.face_count() as u32];
    let corners = mesh.faces().flat_map(|f| mesh.triangle(f).map(|v| v.0));
    counts.into_iter().chain(corners).flat_map(u32::to_le_bytes).collect()
}

/// Half of the tensors where they are symmetric to the bit, as those that isopatch makes are.
fn vertices(spline: &TriangularSpline) -> Section<'_> {
    let base = &spline.base;
    let mirrored = |m: &Mat3| UPPER.iter().all(|(i, j)| m[(*i, *j)].to_bits() == m[(*j, *i)].to_bits());
    let of_all = |numbers: &dyn Fn(&Mat3) -> Vec<f64>| {
        let mut bytes = Vec::with_capacity(base.positions.len() * OLD_VERTEX_NUMBERS * 8);
        for ((p, n), m) in base.positions.iter().zip(&base.normals).zip(&base.curvatures) {
            bytes.extend(p.iter().chain(n.iter()).chain(&numbers(m)).flat_map(|x| x.to_le_bytes()));
        }
        Ok(bytes)
    };
    match base.curvatures.iter().all(mirrored) {
        true => Section::new(VERTICES, move || of_all(&|m| UPPER.map(|(i, j)| m[(i, j)]).to_vec())),
        // Row after row; the transpose's columns are the rows.
        false => Section::new(OLD_VERTICES, move || of_all(&|m| m.transpose().iter().copied().collect())),
    }
}

fn clip_bytes(clip: &Clip) -> Vec<u8> {
    let mut bytes = points([clip.bounds.min, clip.bounds.max].iter());
    bytes.extend(clip.sides.iter().map(|s| s.bits()));
    bytes
}

fn interiors(spline: &TriangularSpline) -> Vec<u8> {
    let inside: Vec<usize> =
        index::indices(DEGREE).filter(|ijk| !index::is_boundary(*ijk)).map(index::position).collect();
    points(spline.nets.iter().flat_map(|net| inside.iter().map(|c| &net[*c])))
}

pub(super) fn points<'a>(points: impl Iterator<Item = &'a Point3>) -> Vec<u8> {
    points.flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes).collect()
}

fn check(spline: &TriangularSpline) -> Result<(), WriteError> {
    let finite = |p: &Point3| p.iter().all(|c| c.is_finite());
    let base = &spline.base;
    for v in 0..base.positions.len() {
        let curved = base.curvatures[v].iter().all(|c| c.is_finite());
        if !finite(&base.positions[v]) || !finite(&base.normals[v]) || !curved {
            return Err(WriteError::NotFinite { what: "vertex", index: v });
        }
    }
    if let Some(index) = spline.nets.iter().position(|net| !net.iter().all(finite)) {
        return Err(WriteError::NotFinite { what: "patch", index });
    }
    base.mesh.edges().try_for_each(|e| check_border(spline, e))
}

/// Do the patches beside an edge have the bits of its elevated quartic there?
fn check_border(spline: &TriangularSpline, e: EdgeId) -> Result<(), WriteError> {
    let mesh = &spline.base.mesh;
    let border: [Point3; DEGREE + 1] = curve::elevate(&spline.curves[e.index()]);
    let same = |h: HalfEdgeId, m: usize, expected: &Point3| {
        let found = &spline.nets[mesh.face(h).index()][index::row(DEGREE, mesh.side(h), 0, m)];
        (0..3).all(|c| found[c].to_bits() == expected[c].to_bits())
    };
    let h = mesh.edge_half_edge(e);
    let ends = [mesh.origin(h), mesh.dest(h)].map(|v| &spline.base.positions[v.index()]);
    let fault = |h: HalfEdgeId| Err(WriteError::Border { patch: mesh.face(h).0, edge: e.0 });
    if !same(h, 0, ends[0]) || !same(h, DEGREE, ends[1]) {
        return fault(h);
    }
    for (m, expected) in border.iter().enumerate() {
        if !same(h, m, expected) {
            return fault(h);
        }
        match mesh.twin(h) {
            Some(g) if !same(g, DEGREE - m, expected) => return fault(g),
            _ => {}
        }
    }
    Ok(())
}
