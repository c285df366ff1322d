use super::layout::*;
use super::read_a_patches::a_patches;
use super::read_hybrid::hybrid;
use super::read_rational::rational;
use super::{NativeModel, NativeSurface, Provenance};
use crate::base::{BaseMesh, BoxSides, Clip, EdgeFeature};
use crate::bernstein::{curve, index};
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::hull::HermiteError;
use crate::io::UnknownUnit;
use crate::mesh::{EdgeId, HalfEdgeMesh, MeshError};
use crate::rational::FrameError;
use crate::spline::TriangularSpline;
use std::io::Read;

/// Why a native file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum NativeError {
    /// The input fails.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The first bytes are not those of a native file.
    #[error("not an isopatch file")]
    Magic,
    /// A version that this program does not know.
    #[error("format version {major}.{minor}; this program reads version {MAJOR}")]
    Version {
        /// Major version.
        major: u16,
        /// Minor version.
        minor: u16,
    },
    /// The file ends too early.
    #[error("the file ends within {0}")]
    Truncated(&'static str),
    /// The bytes are not those that were written.
    #[error("the checksum of {0} is wrong")]
    Checksum(String),
    /// A section that must be there is not.
    #[error("section {0} is missing")]
    Missing(String),
    /// A section is there twice.
    #[error("section {0} is there twice")]
    Repeated(String),
    /// A section reaches beyond the end of the file.
    #[error("section {0} reaches beyond the end of the file")]
    Bounds(String),
    /// A section has not the length that the number of its elements asks for.
    #[error("section {section} has {found} bytes instead of {expected}")]
    Length {
        /// The section.
        section: String,
        /// Its length.
        found: u64,
        /// The length it should have.
        expected: u64,
    },
    /// A text is not UTF-8.
    #[error("the {0} is not UTF-8 text")]
    Text(&'static str),
    /// The unit is not known.
    #[error(transparent)]
    Unit(#[from] UnknownUnit),
    /// The faces do not form a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An edge has a feature that is not known, or says boundary where it is none.
    #[error("edge {edge} has the feature {code}, which it cannot have")]
    Feature {
        /// The edge.
        edge: usize,
        /// The code of the feature.
        code: u8,
    },
    /// A vertex does not lie in the sides of the box that are listed for it.
    #[error("vertex {vertex} does not lie in its sides of the box")]
    Clip {
        /// The vertex.
        vertex: usize,
    },
    /// The mesh has no positions or gradients that can be interpolated.
    #[error(transparent)]
    Data(#[from] HermiteError),
    /// The triangles, wires and patches do not fit together.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A code, or the number of an element, that does not exist.
    #[error("entry {index} of section {section} is {code}, which does not exist")]
    Code {
        /// The section.
        section: String,
        /// Position of the entry.
        index: usize,
        /// What it says.
        code: u32,
    },
    /// A number is infinite or not a number.
    #[error("number {index} of section {section} is not finite")]
    NotFinite {
        /// The section.
        section: String,
        /// Position of the number.
        index: usize,
    },
}

/// Reads a native file: the whole of it, so that every claimed size can be compared with what is there before
/// memory is set aside for it.
pub fn read_native(input: &mut impl Read) -> Result<NativeModel, NativeError> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let sections = Sections::parse(&bytes)?;
    let provenance = provenance(sections.get(META)?)?;
    if sections.find(POLYGONS).is_some() {
        let surface = NativeSurface::Hybrid(Box::new(hybrid(&sections)?));
        return Ok(NativeModel { surface, provenance });
    }
    if sections.find(TRIANGLES).is_some() {
        let surface = NativeSurface::Rational(Box::new(rational(&sections)?));
        return Ok(NativeModel { surface, provenance });
    }
    let mesh = mesh(sections.get(FACES)?)?;
    if sections.find(POSITIONS).is_some() {
        let surface = NativeSurface::APatches(Box::new(a_patches(&sections, mesh)?));
        return Ok(NativeModel { surface, provenance });
    }
    let features = features(&mesh, sections.sized(EDGES, mesh.edge_count(), 1)?)?;
    let (positions, normals, curvatures) = vertices(&sections, mesh.vertex_count())?;
    let curves = curves(&sections, &mesh, &positions)?;
    let interiors = sections.numbers(INTERIORS, mesh.face_count(), PATCH)?;
    let nets = nets(&mesh, &curves, &interiors);
    let base = BaseMesh {
        mesh,
        clip: sections.find(CLIP).map(|section| clip(section, &positions)).transpose()?,
        positions,
        normals,
        curvatures,
        features,
        frozen_diagonal: Some(provenance.diagonal).filter(|d| d.is_finite() && *d > 0.0),
    };
    let surface = NativeSurface::Spline(Box::new(TriangularSpline::new(base, curves, nets)));
    Ok(NativeModel { surface, provenance })
}

/// Positions, normals and curvature tensors.
type Vertices = (Vec<Point3>, Vec<Vec3>, Vec<Mat3>);

fn vertices(sections: &Sections<'_>, count: usize) -> Result<Vertices, NativeError> {
    let (tag, length) = match sections.find(OLD_VERTICES) {
        Some(_) => (OLD_VERTICES, OLD_VERTEX_NUMBERS),
        None => (VERTICES, VERTEX_NUMBERS),
    };
    let numbers = sections.numbers(tag, count, 8 * length)?;
    let vertex = |n: &[f64]| {
        let [position, normal] = points(n);
        let tensor = match tag {
            OLD_VERTICES => Mat3::from_row_slice(&n[6..]),
            _ => {
                let mut tensor = Mat3::zeros();
                for ((i, j), x) in UPPER.into_iter().zip(&n[6..]) {
                    (tensor[(i, j)], tensor[(j, i)]) = (*x, *x);
                }
                tensor
            }
        };
        (position, (normal, tensor))
    };
    let (positions, (normals, tensors)): (_, (Vec<_>, Vec<_>)) =
        numbers.chunks_exact(length).map(vertex).unzip();
    Ok((positions, normals, tensors))
}

/// The quartics over the edges.
fn curves(
    sections: &Sections<'_>,
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
) -> Result<Vec<[Point3; 5]>, NativeError> {
    if sections.find(OLD_CURVES).is_some() {
        let numbers = sections.numbers(OLD_CURVES, mesh.edge_count(), OLD_CURVE_POINTS * POINT)?;
        return Ok(numbers.chunks_exact(3 * OLD_CURVE_POINTS).map(points).collect());
    }
    let numbers = sections.numbers(CURVES, mesh.edge_count(), CURVE_POINTS * POINT)?;
    let curve = |(e, n): (EdgeId, &[f64])| {
        let h = mesh.edge_half_edge(e);
        let [q0, q4] = [mesh.origin(h), mesh.dest(h)].map(|v| positions[v.index()]);
        let [q1, q2, q3] = points(n);
        [q0, q1, q2, q3, q4]
    };
    Ok(mesh.edges().zip(numbers.chunks_exact(3 * CURVE_POINTS)).map(curve).collect())
}

/// The sections of a file whose header is sound.
pub(super) struct Sections<'a> {
    entries: Vec<(Tag, &'a [u8])>,
}

impl<'a> Sections<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, NativeError> {
        let mut header = Cursor { rest: bytes, what: "the header" };
        // A shorter file that starts in the right way is a native file cut off.
        if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
            return Err(NativeError::Magic);
        }
        header.take(MAGIC.len())?;
        let (major, minor) = (u16::from_le_bytes(header.array()?), u16::from_le_bytes(header.array()?));
        if major != MAJOR {
            return Err(NativeError::Version { major, minor });
        }
        let count = u32::from_le_bytes(header.array()?) as usize;
        let size = count.checked_mul(ENTRY).ok_or(NativeError::Truncated("the section table"))?;
        header.what = "the section table";
        let table = header.take(size)?;
        let checksum = u32::from_le_bytes(header.array()?);
        if crc32fast::hash(&bytes[..FIXED_HEADER + size]) != checksum {
            return Err(NativeError::Checksum("the header".to_owned()));
        }
        let mut sections = Self { entries: Vec::new() };
        for entry in table.chunks_exact(ENTRY) {
            sections.add(bytes, entry)?;
        }
        Ok(sections)
    }

    /// Adds the section of a table entry if this version knows it.
    fn add(&mut self, bytes: &'a [u8], entry: &[u8]) -> Result<(), NativeError> {
        let mut entry = Cursor { rest: entry, what: "the section table" };
        let tag = Tag(entry.array()?);
        let checksum = u32::from_le_bytes(entry.array()?);
        let (offset, length) = (u64::from_le_bytes(entry.array()?), u64::from_le_bytes(entry.array()?));
        if !KNOWN.contains(&tag) {
            return Ok(());
        }
        if self.entries.iter().any(|(t, _)| *t == tag) {
            return Err(NativeError::Repeated(tag.to_string()));
        }
        let range =
            usize::try_from(offset).ok().zip(offset.checked_add(length).and_then(|e| e.try_into().ok()));
        let section = range.and_then(|(start, end): (usize, usize)| bytes.get(start..end));
        let section = section.ok_or_else(|| NativeError::Bounds(tag.to_string()))?;
        if crc32fast::hash(section) != checksum {
            return Err(NativeError::Checksum(format!("section {tag}")));
        }
        self.entries.push((tag, section));
        Ok(())
    }

    pub fn get(&self, tag: Tag) -> Result<&'a [u8], NativeError> {
        self.find(tag).ok_or_else(|| NativeError::Missing(tag.to_string()))
    }

    pub fn find(&self, tag: Tag) -> Option<&'a [u8]> {
        self.entries.iter().find(|(t, _)| *t == tag).map(|(_, section)| *section)
    }

    /// A section of `count` elements of `size` bytes.
    pub fn sized(&self, tag: Tag, count: usize, size: usize) -> Result<&'a [u8], NativeError> {
        let section = self.get(tag)?;
        check_length(tag, section, count as u64 * size as u64)?;
        Ok(section)
    }

    /// The finite numbers of such a section.
    pub fn numbers(&self, tag: Tag, count: usize, size: usize) -> Result<Vec<f64>, NativeError> {
        let (chunks, _) = self.sized(tag, count, size)?.as_chunks();
        let numbers: Vec<f64> = chunks.iter().map(|c| f64::from_le_bytes(*c)).collect();
        match numbers.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(NativeError::NotFinite { section: tag.to_string(), index }),
            None => Ok(numbers),
        }
    }
}

pub(super) fn check_length(tag: Tag, section: &[u8], expected: u64) -> Result<(), NativeError> {
    let found = section.len() as u64;
    if found == expected {
        return Ok(());
    }
    Err(NativeError::Length { section: tag.to_string(), found, expected })
}

/// Bytes that are taken from the front.
struct Cursor<'a> {
    rest: &'a [u8],
    what: &'static str,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], NativeError> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(NativeError::Truncated(self.what))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], NativeError> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or(NativeError::Truncated(self.what))?;
        self.rest = rest;
        Ok(*taken)
    }

    fn text(&mut self, what: &'static str) -> Result<String, NativeError> {
        self.what = what;
        let count = u32::from_le_bytes(self.array()?) as usize;
        let bytes = self.take(count)?;
        String::from_utf8(bytes.to_vec()).map_err(|_| NativeError::Text(what))
    }
}

fn provenance(section: &[u8]) -> Result<Provenance, NativeError> {
    let mut bytes = Cursor { rest: section, what: "section META" };
    let generator = bytes.text("name of the generator")?;
    let (options, source) = (bytes.text("text of the options")?, bytes.text("text of the source")?);
    let unit = bytes.text("name of the unit")?.parse()?;
    bytes.what = "diagonal";
    let diagonal = f64::from_le_bytes(bytes.array()?);
    check_length(META, section, (section.len() - bytes.rest.len()) as u64)?;
    Ok(Provenance { generator, options, source, unit, diagonal })
}

fn mesh(section: &[u8]) -> Result<HalfEdgeMesh, NativeError> {
    let mut bytes = Cursor { rest: section, what: "section FACE" };
    let vertices = u32::from_le_bytes(bytes.array()?) as usize;
    let faces = u64::from(u32::from_le_bytes(bytes.array()?));
    // The two counts, and three numbers a face, of four bytes each.
    check_length(FACES, section, 8 + 12 * faces)?;
    let (numbers, _) = bytes.rest.as_chunks();
    let numbers: Vec<u32> = numbers.iter().map(|n| u32::from_le_bytes(*n)).collect();
    let (faces, _) = numbers.as_chunks::<3>();
    // Every vertex belongs to a face, so a larger count is wrong; it must not set memory aside.
    if vertices > numbers.len() {
        return Err(MeshError::IsolatedVertex { vertex: vertices as u32 - 1 }.into());
    }
    Ok(HalfEdgeMesh::from_faces(vertices, faces)?)
}

fn features(mesh: &HalfEdgeMesh, codes: &[u8]) -> Result<Vec<EdgeFeature>, NativeError> {
    let feature = |e: EdgeId| {
        let code = codes[e.index()];
        match (code, mesh.twin(mesh.edge_half_edge(e))) {
            (0, Some(_)) => Ok(EdgeFeature::Smooth),
            (1, None) => Ok(EdgeFeature::Boundary),
            (2, Some(_)) => Ok(EdgeFeature::Sharp),
            _ => Err(NativeError::Feature { edge: e.index(), code }),
        }
    };
    mesh.edges().map(feature).collect()
}

/// The box, and a byte for the sides of each vertex.
fn clip(section: &[u8], positions: &[Point3]) -> Result<Clip, NativeError> {
    check_length(CLIP, section, (BOX + positions.len()) as u64)?;
    let (numbers, codes) = section.split_at(BOX);
    let numbers: Vec<f64> = numbers.as_chunks().0.iter().map(|c| f64::from_le_bytes(*c)).collect();
    if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
        return Err(NativeError::NotFinite { section: CLIP.to_string(), index });
    }
    let [min, max] = points(&numbers);
    let bounds = Aabb::new(min, max);
    let sides = codes.iter().zip(positions).enumerate().map(|(vertex, (code, p))| {
        BoxSides::from_bits(*code)
            .filter(|sides| BoxSides::of(p, &bounds).contains_all(*sides))
            .ok_or(NativeError::Clip { vertex })
    });
    Ok(Clip { bounds, sides: sides.collect::<Result<_, _>>()? })
}

fn points<const N: usize>(numbers: &[f64]) -> [Point3; N] {
    std::array::from_fn(|i| Point3::new(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]))
}

/// The control nets: borders elevated from the quartics, as they were before writing, and interiors as stored.
fn nets(
    mesh: &HalfEdgeMesh,
    curves: &[[Point3; 5]],
    interiors: &[f64],
) -> Vec<[Point3; index::count(DEGREE)]> {
    let mut nets = vec![[Point3::zeros(); index::count(DEGREE)]; mesh.face_count()];
    for e in mesh.edges() {
        let border: [Point3; DEGREE + 1] = curve::elevate(&curves[e.index()]);
        let h = mesh.edge_half_edge(e);
        for (m, p) in border.iter().enumerate() {
            nets[mesh.face(h).index()][index::row(DEGREE, mesh.side(h), 0, m)] = *p;
            if let Some(g) = mesh.twin(h) {
                nets[mesh.face(g).index()][index::row(DEGREE, mesh.side(g), 0, DEGREE - m)] = *p;
            }
        }
    }
    let inside: Vec<usize> =
        index::indices(DEGREE).filter(|ijk| !index::is_boundary(*ijk)).map(index::position).collect();
    for (net, numbers) in nets.iter_mut().zip(interiors.chunks_exact(3 * INTERIOR)) {
        let stored: [Point3; INTERIOR] = points(numbers);
        inside.iter().zip(stored).for_each(|(c, p)| net[*c] = p);
    }
    nets
}
