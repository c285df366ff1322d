use super::text::{WORD_BYTES, Words};
use super::{PolygonMesh, ReadError, check_room, vertex_index};

/// Reads an OFF file (Geomview's text format), with the prefixes ST, C and N for texture coordinates, colours
/// and normals.
///
/// Words may be spread over lines, but every vertex and every face starts a line: what follows on the line
/// after its coordinates, normal or indices (colours, texture coordinates) is passed over. The number of
/// edges may be missing.
///
/// # Errors
/// The content is refused: see [`ReadError`]. Binary OFF and the prefixes 4 and n (points of other dimensions)
/// are not supported.
pub fn read_off(bytes: &[u8]) -> Result<PolygonMesh, ReadError> {
    let mut words = Words::new(bytes);
    let has_normals = read_header(&mut words)?;
    let claimed_vertices = words.number("the number of vertices")?;
    let claimed_faces = words.number("the number of faces")?;
    words.skip_line();

    let vertex_words = if has_normals { 6 } else { 3 };
    let vertices = check_room("vertices", claimed_vertices, vertex_words * WORD_BYTES, words.bytes_left())?;
    // A face is at least the number of its corners; that there are three of them is checked at the end.
    let faces = check_room("faces", claimed_faces, WORD_BYTES, words.bytes_left())?;

    let mut mesh = PolygonMesh {
        positions: Vec::with_capacity(vertices),
        faces: Vec::with_capacity(faces),
        normals: has_normals.then(|| Vec::with_capacity(vertices)),
    };
    for _ in 0..vertices {
        mesh.positions.push(words.vector("a coordinate")?);
        if let Some(normals) = &mut mesh.normals {
            normals.push(words.vector("a coordinate of a normal")?);
        }
        words.skip_line();
    }
    for face in 0..faces {
        mesh.faces.push(read_face(&mut words, face, vertices)?);
        words.skip_line();
    }
    words.expect_end()?;
    mesh.checked()
}

/// Reads the keyword `[ST][C][N][4][n]OFF`; do normals follow the positions?
fn read_header(words: &mut Words) -> Result<bool, ReadError> {
    let expected = "the keyword OFF";
    let word = words.word(expected)?;
    let Some(start) = word.windows(3).position(|w| w == b"OFF") else {
        return Err(words.wrong(word, expected));
    };
    // Files of the ModelNet collection have the number of vertices glued to the keyword.
    words.step_back(word.len() - start - 3);

    let prefix = &word[..start];
    let prefix = prefix.strip_prefix(b"ST").unwrap_or(prefix);
    let prefix = prefix.strip_prefix(b"C").unwrap_or(prefix);
    let (has_normals, prefix) = match prefix.strip_prefix(b"N") {
        Some(rest) => (true, rest),
        None => (false, prefix),
    };
    match prefix {
        b"" => {}
        b"4" | b"n" | b"4n" => return Err(unsupported(words, "OFF with points of other than 3 dimensions")),
        _ => return Err(words.wrong(word, expected)),
    }
    let mut line = words.clone();
    if line.next_on_line() == Some(b"BINARY") {
        return Err(unsupported(words, "binary OFF"));
    }
    Ok(has_normals)
}

fn unsupported(words: &Words, what: &'static str) -> ReadError {
    ReadError::Unsupported { place: words.place(), what }
}

fn read_face(words: &mut Words, face: usize, vertices: usize) -> Result<Vec<u32>, ReadError> {
    let claimed = words.number("the number of corners of a face")?;
    let corners = check_room("corners of a face", claimed, WORD_BYTES, words.bytes_left())?;
    (0..corners).map(|_| vertex_index(face, words.number("a vertex index")?, vertices)).collect()
}
