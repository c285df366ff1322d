// The PLY header says which elements follow, in which order, and of which properties each is made:
//
// ```text
// ply
// format binary_little_endian 1.0            or ascii, or binary_big_endian
// element vertex 8
// property double x                          one value
// …
// element face 6
// property list uchar int vertex_indices     a length (uchar), then as many values (int)
// end_header
// ```

use super::text::{WORD_BYTES, Words};
use super::{Place, PolygonMesh, ReadError, check_room, vertex_index};
use crate::geom::Vec3;

/// Reads a PLY file, ASCII or binary of either byte order: `x`, `y`, `z` and, if all are there, `nx`, `ny`,
/// `nz` of the element `vertex`, and the list `vertex_indices` (or `vertex_index`) of the element `face`. Other
/// elements and properties are passed over.
///
/// # Errors
/// The content is refused: see [`ReadError`]. Triangle strips are not supported.
pub fn read_ply(bytes: &[u8]) -> Result<PolygonMesh, ReadError> {
    let (elements, mut body) = read_header(bytes)?;
    let vertices = elements.iter().find(|e| e.name == b"vertex").map_or(0, |e| e.count);
    let mut mesh = PolygonMesh { positions: Vec::new(), faces: Vec::new(), normals: None };
    for element in &elements {
        match element.name {
            b"vertex" => (mesh.positions, mesh.normals) = read_vertices(&mut body, element)?,
            b"face" => mesh.faces = read_faces(&mut body, element, vertices)?,
            _ => (0..element.count).try_for_each(|_| body.row(element, |_, _| Ok(())))?,
        }
    }
    body.expect_end()?;
    mesh.checked()
}

fn read_vertices(body: &mut Body, element: &Element) -> Result<(Vec<Vec3>, Option<Vec<Vec3>>), ReadError> {
    let column = |property| element.column(property, |p| p.list_length.is_none());
    let required =
        |property| column(property).ok_or(ReadError::MissingProperty { element: "vertex", property });
    let [x, y, z] = [required("x")?, required("y")?, required("z")?];
    let normal = (column("nx"), column("ny"), column("nz"));

    let mut positions = Vec::with_capacity(element.count);
    let mut normals = Vec::new();
    let mut values = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        body.row(element, |column, value| {
            values[column] = value;
            Ok(())
        })?;
        positions.push(Vec3::new(values[x], values[y], values[z]));
        if let (Some(nx), Some(ny), Some(nz)) = normal {
            normals.push(Vec3::new(values[nx], values[ny], values[nz]));
        }
    }
    let has_normals = matches!(normal, (Some(_), Some(_), Some(_)));
    Ok((positions, has_normals.then_some(normals)))
}

fn read_faces(body: &mut Body, element: &Element, vertices: usize) -> Result<Vec<Vec<u32>>, ReadError> {
    let column = |property| element.column(property, |p| p.list_length.is_some() && !p.kind.is_float());
    let indices = column("vertex_indices")
        .or_else(|| column("vertex_index"))
        .ok_or(ReadError::MissingProperty { element: "face", property: "list … vertex_indices" })?;
    let mut faces = Vec::with_capacity(element.count);
    for face in 0..element.count {
        let mut corners = Vec::new();
        body.row(element, |column, value| {
            if column == indices {
                corners.push(vertex_index(face, value as i64, vertices)?);
            }
            Ok(())
        })?;
        faces.push(corners);
    }
    Ok(faces)
}

/// What the header says about one kind of element.
struct Element<'a> {
    name: &'a [u8],
    count: usize,
    properties: Vec<Property<'a>>,
}

struct Property<'a> {
    name: &'a [u8],
    /// The kind of its value; of a list, of each.
    kind: Kind,
    /// In a list, the kind of its length.
    list_length: Option<Kind>,
}

#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

impl Element<'_> {
    fn column(&self, name: &str, accept: impl Fn(&Property) -> bool) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name.as_bytes() && accept(p))
    }

    /// The least bytes that one such element takes: all lists empty.
    fn least_bytes(&self, body: &Body) -> usize {
        let bytes = |p: &Property| match body {
            Body::Text(_) => WORD_BYTES,
            Body::Binary(_) => p.list_length.unwrap_or(p.kind).bytes(),
        };
        self.properties.iter().map(bytes).sum()
    }
}

fn read_header(bytes: &[u8]) -> Result<(Vec<Element<'_>>, Body<'_>), ReadError> {
    let mut words = Words::new(bytes);
    let mut claims: Vec<(Element, u64)> = Vec::new();
    let mut format = None;
    expect(&mut words, b"ply", "the keyword ply")?;
    loop {
        words.skip_line();
        let keyword = words.word("end_header")?;
        match keyword {
            b"format" => format = Some(read_format(&mut words)?),
            b"comment" | b"obj_info" => {}
            b"element" => claims.push(read_element(&mut words, &claims)?),
            b"property" => match claims.last_mut() {
                Some((element, _)) => element.properties.push(read_property(&mut words)?),
                None => return Err(words.wrong(keyword, "an element before its properties")),
            },
            b"end_header" => break,
            _ => return Err(words.wrong(keyword, "format, comment, element, property or end_header")),
        }
    }
    let Some(format) = format else {
        return Err(words.wrong(b"end_header", "a line with the format before it"));
    };
    words.skip_line();
    let body = match format {
        Format::Ascii => Body::Text(words),
        Format::Binary { big_endian } => Body::Binary(Binary { bytes, at: words.offset(), big_endian }),
    };
    let mut elements = Vec::with_capacity(claims.len());
    for (mut element, claimed) in claims {
        element.count = check_room("elements", claimed, element.least_bytes(&body), body.bytes_left())?;
        elements.push(element);
    }
    Ok((elements, body))
}

fn expect(words: &mut Words, keyword: &[u8], expected: &'static str) -> Result<(), ReadError> {
    let word = words.word(expected)?;
    if word == keyword { Ok(()) } else { Err(words.wrong(word, expected)) }
}

enum Format {
    Ascii,
    Binary { big_endian: bool },
}

fn read_format(words: &mut Words) -> Result<Format, ReadError> {
    let expected = "ascii, binary_little_endian or binary_big_endian";
    let word = words.word(expected)?;
    match word {
        b"ascii" => Ok(Format::Ascii),
        b"binary_little_endian" => Ok(Format::Binary { big_endian: false }),
        b"binary_big_endian" => Ok(Format::Binary { big_endian: true }),
        _ => Err(words.wrong(word, expected)),
    }
}

/// Reads the name and the claimed number of an element, which is checked once the whole header is known.
fn read_element<'a>(
    words: &mut Words<'a>,
    before: &[(Element, u64)],
) -> Result<(Element<'a>, u64), ReadError> {
    let name = words.word("the name of an element")?;
    if name == b"tristrips" {
        return Err(ReadError::Unsupported { place: words.place(), what: "an element tristrips" });
    }
    if before.iter().any(|(element, _)| element.name == name) {
        return Err(words.wrong(name, "another name than that of an earlier element"));
    }
    let claimed = words.number_on_line("the number of elements")?;
    Ok((Element { name, count: 0, properties: Vec::new() }, claimed))
}

fn read_property<'a>(words: &mut Words<'a>) -> Result<Property<'a>, ReadError> {
    let word = words.word("the type of a property")?;
    let (list_length, kind) = match word {
        b"list" => (Some(read_kind(words)?), read_kind(words)?),
        _ => (None, parse_kind(words, word)?),
    };
    if list_length.is_some_and(Kind::is_float) {
        return Err(words.wrong(word, "a list with an integer length"));
    }
    Ok(Property { name: words.word("the name of a property")?, kind, list_length })
}

fn read_kind(words: &mut Words) -> Result<Kind, ReadError> {
    let word = words.word("a type")?;
    parse_kind(words, word)
}

fn parse_kind(words: &Words, word: &[u8]) -> Result<Kind, ReadError> {
    Ok(match word {
        b"char" | b"int8" => Kind::I8,
        b"uchar" | b"uint8" => Kind::U8,
        b"short" | b"int16" => Kind::I16,
        b"ushort" | b"uint16" => Kind::U16,
        b"int" | b"int32" => Kind::I32,
        b"uint" | b"uint32" => Kind::U32,
        b"float" | b"float32" => Kind::F32,
        b"double" | b"float64" => Kind::F64,
        _ => return Err(words.wrong(word, "a type such as uchar, int, float or double")),
    })
}

/// What follows the header: a stream of values.
enum Body<'a> {
    Text(Words<'a>),
    Binary(Binary<'a>),
}

impl Body<'_> {
    /// Reads one element and hands each value, list items too, to `visit` with the number of its property.
    fn row(
        &mut self,
        element: &Element,
        mut visit: impl FnMut(usize, f64) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        for (column, property) in element.properties.iter().enumerate() {
            let length = property.list_length.map_or(Ok(1), |kind| self.list_length(kind, property.kind))?;
            for _ in 0..length {
                visit(column, self.value(property.kind)?)?;
            }
        }
        Ok(())
    }

    fn list_length(&mut self, kind: Kind, item: Kind) -> Result<usize, ReadError> {
        let length = self.value(kind)?;
        let least_bytes = match self {
            Self::Text(_) => WORD_BYTES,
            Self::Binary(_) => item.bytes(),
        };
        let claimed = u64::try_from(length as i64).map_err(|_| ReadError::Syntax {
            place: self.place(),
            expected: "the length of a list",
            found: length.to_string(),
        })?;
        check_room("values of a list", claimed, least_bytes, self.bytes_left())
    }

    /// The next value; every kind fits into `f64`. Text is read as `f64` also where the header says float: the
    /// digits are there.
    fn value(&mut self, kind: Kind) -> Result<f64, ReadError> {
        match self {
            Self::Text(words) if kind.is_float() => words.number("a number"),
            Self::Text(words) => words.number::<i64>("an integer").map(|i| i as f64),
            Self::Binary(binary) => binary.value(kind),
        }
    }

    fn bytes_left(&self) -> usize {
        match self {
            Self::Text(words) => words.bytes_left(),
            Self::Binary(binary) => binary.bytes.len() - binary.at,
        }
    }

    fn place(&self) -> Place {
        match self {
            Self::Text(words) => words.place(),
            Self::Binary(binary) => Place::Byte(binary.at),
        }
    }

    fn expect_end(&mut self) -> Result<(), ReadError> {
        match self {
            Self::Text(words) => words.expect_end(),
            Self::Binary(binary) if binary.at == binary.bytes.len() => Ok(()),
            Self::Binary(_) => Err(ReadError::Trailing { place: self.place() }),
        }
    }
}

/// A binary body: the bytes of the file from `at` on.
struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl Binary<'_> {
    fn value(&mut self, kind: Kind) -> Result<f64, ReadError> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take()?).into(),
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            Kind::I16 => i16::from_le_bytes(self.take()?).into(),
            Kind::U16 => u16::from_le_bytes(self.take()?).into(),
            Kind::I32 => i32::from_le_bytes(self.take()?).into(),
            Kind::U32 => u32::from_le_bytes(self.take()?).into(),
            Kind::F32 => f32::from_le_bytes(self.take()?).into(),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// The next N bytes, the least significant first.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let truncated = ReadError::Truncated { place: Place::Byte(self.at), expected: "a value" };
        let mut value: [u8; N] = *self.bytes[self.at..].first_chunk().ok_or(truncated)?;
        self.at += N;
        if self.big_endian {
            value.reverse();
        }
        Ok(value)
    }
}
