use super::text::Words;
use super::{Element, Place, PolygonMesh, ReadError};
use crate::geom::Point3;
use std::collections::HashMap;

/// A binary file starts with 80 free bytes and the number of triangles.
const HEADER_BYTES: usize = 84;
/// Normal, three vertices (twelve `f32` in all) and two free bytes.
const TRIANGLE_BYTES: usize = 50;
/// The normal, which the vertices give better.
const NORMAL_BYTES: usize = 12;

/// Reads an STL file, binary or ASCII.
///
/// STL repeats its vertices in every triangle: vertices with the same three coordinates (0 and −0 are the same)
/// become one, numbered by first appearance. The normals of the triangles are passed over. Binary files are
/// told by their size, which follows from the number of triangles in the header, because some of them start
/// with the word `solid` as ASCII files do.
///
/// # Errors
/// The content is refused: see [`ReadError`]. A coordinate that is not finite is reported by its face.
pub fn read_stl(bytes: &[u8]) -> Result<PolygonMesh, ReadError> {
    if let Some((header, triangles)) = bytes.split_at_checked(HEADER_BYTES)
        && (has_size_of_binary(header, triangles) || !starts_with_solid(bytes))
    {
        return weld(read_binary(header, triangles)?);
    }
    weld(read_ascii(bytes)?)
}

fn claimed_triangles(header: &[u8]) -> u64 {
    header.last_chunk().map_or(0, |count| u64::from(u32::from_le_bytes(*count)))
}

fn has_size_of_binary(header: &[u8], triangles: &[u8]) -> bool {
    claimed_triangles(header) * TRIANGLE_BYTES as u64 == triangles.len() as u64
}

fn starts_with_solid(bytes: &[u8]) -> bool {
    Words::new(bytes).next_word().is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn read_binary(header: &[u8], triangles: &[u8]) -> Result<Vec<[Point3; 3]>, ReadError> {
    let claimed = claimed_triangles(header);
    let room = triangles.len() / TRIANGLE_BYTES;
    let count = usize::try_from(claimed).ok().filter(|&count| count <= room);
    let count = count.ok_or(ReadError::TooMany { what: "triangles", claimed, room })?;
    if count * TRIANGLE_BYTES < triangles.len() {
        return Err(ReadError::Trailing { place: Place::Byte(HEADER_BYTES + count * TRIANGLE_BYTES) });
    }
    let (triangles, _) = triangles.as_chunks::<TRIANGLE_BYTES>();
    Ok(triangles.iter().map(triangle).collect())
}

fn triangle(record: &[u8; TRIANGLE_BYTES]) -> [Point3; 3] {
    let (floats, _) = record[NORMAL_BYTES..].as_chunks::<4>();
    let coordinate = |i: usize| f64::from(f32::from_le_bytes(floats[i]));
    [0, 3, 6].map(|i| Point3::new(coordinate(i), coordinate(i + 1), coordinate(i + 2)))
}

/// Reads one solid after another.
fn read_ascii(bytes: &[u8]) -> Result<Vec<[Point3; 3]>, ReadError> {
    let mut words = Words::new(bytes);
    let mut triangles = Vec::new();
    keyword(&mut words, "solid")?;
    loop {
        words.skip_line(); // its name
        let expected = "facet or endsolid";
        loop {
            let word = words.word(expected)?;
            if word.eq_ignore_ascii_case(b"endsolid") {
                break;
            }
            if !word.eq_ignore_ascii_case(b"facet") {
                return Err(words.wrong(word, expected));
            }
            triangles.push(read_facet(&mut words)?);
        }
        words.skip_line(); // its name, again
        if words.clone().next_word().is_none() {
            return Ok(triangles);
        }
        keyword(&mut words, "solid")?;
    }
}

/// Reads a triangle from behind `facet` to `endfacet`.
fn read_facet(words: &mut Words) -> Result<[Point3; 3], ReadError> {
    keyword(words, "normal")?;
    for _ in 0..3 {
        words.word("a coordinate of a normal")?;
    }
    keyword(words, "outer")?;
    keyword(words, "loop")?;
    let mut corners = [Point3::zeros(); 3];
    for corner in &mut corners {
        keyword(words, "vertex")?;
        *corner = words.vector("a coordinate")?;
    }
    keyword(words, "endloop")?;
    keyword(words, "endfacet")?;
    Ok(corners)
}

fn keyword(words: &mut Words, expected: &'static str) -> Result<(), ReadError> {
    let word = words.word(expected)?;
    if word.eq_ignore_ascii_case(expected.as_bytes()) { Ok(()) } else { Err(words.wrong(word, expected)) }
}

/// Joins corners with the same coordinates into one vertex.
fn weld(triangles: Vec<[Point3; 3]>) -> Result<PolygonMesh, ReadError> {
    let mut positions = Vec::new();
    let mut vertex_at = HashMap::new();
    let mut faces = Vec::with_capacity(triangles.len());
    for (face, triangle) in triangles.iter().enumerate() {
        let mut corners = Vec::with_capacity(3);
        for point in triangle {
            if !point.iter().all(|x| x.is_finite()) {
                return Err(ReadError::NotFinite { element: Element::Face, index: face });
            }
            let point = point.add_scalar(0.0); // turns −0 into 0
            let next = u32::try_from(positions.len()).map_err(|_| too_many_vertices(triangles.len()))?;
            let vertex = *vertex_at.entry([point.x, point.y, point.z].map(f64::to_bits)).or_insert(next);
            if vertex == next {
                positions.push(point);
            }
            corners.push(vertex);
        }
        faces.push(corners);
    }
    PolygonMesh { positions, faces, normals: None }.checked()
}

fn too_many_vertices(triangles: usize) -> ReadError {
    ReadError::TooMany { what: "corners", claimed: 3 * triangles as u64, room: u32::MAX as usize }
}
