use super::text::Words;
use super::{Element, PolygonMesh, ReadError, check_finite};
use crate::geom::Vec3;

/// Reads the polygons of a Wavefront OBJ file: the lines `v`, `vn` and `f`. Everything else (groups, materials,
/// texture coordinates, lines, curves) is passed over, as are a vertex's weight and colour.
///
/// OBJ gives normals to corners, not to vertices. The mesh has normals if every corner has one and all corners
/// at a vertex have the same; a vertex without a face then gets the zero vector. Where a vertex has several
/// normals, along a crease, the mesh has none.
///
/// # Errors
/// The content is refused: see [`ReadError`]. Indices are reported as the file has them: from 1, or negative.
pub fn read_obj(bytes: &[u8]) -> Result<PolygonMesh, ReadError> {
    let mut words = Words::new(bytes);
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut faces = Vec::new();
    while let Some(keyword) = words.next_word() {
        let counts = Counts { vertices: positions.len(), normals: normals.len() };
        match keyword {
            b"v" => positions.push(vector_on_line(&mut words, "a coordinate")?),
            b"vn" => normals.push(vector_on_line(&mut words, "a coordinate of a normal")?),
            b"f" => faces.push(read_face(&mut words, faces.len(), counts)?),
            _ => {}
        }
        // Not `skip_line`, so that a joined line is passed over whole.
        while words.next_on_line().is_some() {}
    }
    check_range(&faces, Counts { vertices: positions.len(), normals: normals.len() })?;
    check_finite(Element::Normal, &normals)?;
    PolygonMesh {
        normals: vertex_normals(&faces, positions.len(), &normals),
        faces: faces.iter().map(|corners| corners.iter().map(|c| c.vertex).collect()).collect(),
        positions,
    }
    .checked()
}

/// One item of an `f` line; indices from 0.
struct Corner {
    vertex: u32,
    normal: Option<u32>,
}

/// Positions and normals read so far: what negative indices count back from.
#[derive(Clone, Copy)]
struct Counts {
    vertices: usize,
    normals: usize,
}

impl Counts {
    fn no_vertex(self, face: usize, index: i64) -> ReadError {
        ReadError::NoSuchVertex { face, index, first: 1, vertices: self.vertices }
    }

    fn no_normal(self, face: usize, index: i64) -> ReadError {
        ReadError::NoSuchNormal { face, index, normals: self.normals }
    }
}

fn vector_on_line(words: &mut Words, expected: &'static str) -> Result<Vec3, ReadError> {
    Ok(Vec3::new(
        words.number_on_line(expected)?,
        words.number_on_line(expected)?,
        words.number_on_line(expected)?,
    ))
}

/// Reads the items `v`, `v/vt`, `v//vn` or `v/vt/vn` up to the end of the line. Some writers leave slashes
/// with nothing behind them.
fn read_face(words: &mut Words, face: usize, counts: Counts) -> Result<Vec<Corner>, ReadError> {
    let expected = "a corner of a face such as 1, 1/2, 1//3 or 1/2/3";
    let mut corners = Vec::new();
    while let Some(word) = words.next_on_line() {
        let mut parts = word.split(|&b| b == b'/');
        let mut index = || match parts.next() {
            None | Some(b"") => Ok(None),
            Some(part) => words.parse(part, expected).map(Some),
        };
        let (vertex, _texture, normal): (Option<i64>, Option<i64>, Option<i64>) =
            (index()?, index()?, index()?);
        let Some(vertex) = vertex.filter(|_| parts.next().is_none()) else {
            return Err(words.wrong(word, expected));
        };
        corners.push(Corner {
            vertex: from_zero(vertex, counts.vertices).ok_or(counts.no_vertex(face, vertex))?,
            normal: normal
                .map(|n| from_zero(n, counts.normals).ok_or(counts.no_normal(face, n)))
                .transpose()?,
        });
    }
    Ok(corners)
}

/// An OBJ index (1 the first element, −1 the latest of `count`) counted from 0. A positive one may name an
/// element that is still to come.
fn from_zero(index: i64, count: usize) -> Option<u32> {
    let before = if index > 0 { -1 } else { i64::try_from(count).ok()? };
    // Zero names nothing; it would otherwise become the element to come.
    if index == 0 { None } else { u32::try_from(index.checked_add(before)?).ok() }
}

/// Checks the indices that named elements still to come.
fn check_range(faces: &[Vec<Corner>], counts: Counts) -> Result<(), ReadError> {
    for (face, corners) in faces.iter().enumerate() {
        for corner in corners {
            if corner.vertex as usize >= counts.vertices {
                return Err(counts.no_vertex(face, i64::from(corner.vertex) + 1));
            }
            if let Some(n) = corner.normal.filter(|&n| n as usize >= counts.normals) {
                return Err(counts.no_normal(face, i64::from(n) + 1));
            }
        }
    }
    Ok(())
}

/// The normal of each vertex, unless one is missing or a vertex has several. Normals are compared by value:
/// some writers repeat them for every corner.
fn vertex_normals(faces: &[Vec<Corner>], vertices: usize, normals: &[Vec3]) -> Option<Vec<Vec3>> {
    if normals.is_empty() {
        return None;
    }
    let mut of_vertex = vec![None; vertices];
    for corner in faces.iter().flatten() {
        let normal = normals[corner.normal? as usize];
        if *of_vertex[corner.vertex as usize].get_or_insert(normal) != normal {
            return None;
        }
    }
    Some(of_vertex.into_iter().map(Option::unwrap_or_default).collect())
}
