//! 3MF, for printing: a ZIP archive with the mesh as XML (3MF Core Specification 1.3).

use super::text::{push_float, push_integer, write_items};
use super::{Unit, WriteError, error};
use crate::tessellate::Tessellation;
use std::io::{self, Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter, result::ZipError};

/// How to write a 3MF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThreemfOptions {
    /// Length of a model unit; default millimetre.
    pub unit: Unit,
}

/// The parts of the archive besides the model: which types the others have, and which one is the model.
const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

/// Writes one object with the vertices and triangles of the mesh, in its order; a solid if the mesh is closed, else a surface. The
/// format has no normals.
pub fn write_3mf(
    mesh: &Tessellation,
    options: &ThreemfOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    if mesh.triangles.is_empty() {
        return Err(WriteError::Empty { format: "3MF" });
    }
    let archive = archive(mesh, options).map_err(|error| match error {
        ZipError::Io(error) => error,
        other => io::Error::other(other),
    })?;
    out.write_all(&archive)?;
    Ok(())
}

fn archive(mesh: &Tessellation, options: &ThreemfOptions) -> Result<Vec<u8>, ZipError> {
    // In memory, because the sizes of the parts stand before them.
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    // The same bytes at any time: entries are dated to the first day of the format. The model may have more than 4 GB of text.
    let entry = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default());
    zip.start_file("[Content_Types].xml", entry)?;
    zip.write_all(CONTENT_TYPES.as_bytes())?;
    zip.start_file("_rels/.rels", entry)?;
    zip.write_all(RELATIONSHIPS.as_bytes())?;
    zip.start_file("3D/3dmodel.model", entry.large_file(is_large(mesh)))?;
    write_model(mesh, options, &mut zip)?;
    Ok(zip.finish()?.into_inner())
}

/// Most bytes that a vertex or a triangle takes as text.
const LARGEST_ELEMENT: u64 = 120;

/// May the model have more than 4 GB of text? Some readers refuse the mark that it then needs, so it is not set without need.
fn is_large(mesh: &Tessellation) -> bool {
    (mesh.positions.len() + mesh.triangles.len()) as u64 * LARGEST_ELEMENT > u64::from(u32::MAX)
}

fn write_model(mesh: &Tessellation, options: &ThreemfOptions, out: &mut impl Write) -> io::Result<()> {
    let unit = match options.unit {
        Unit::Mm => "millimeter",
        Unit::Cm => "centimeter",
        Unit::M => "meter",
        Unit::In => "inch",
    };
    let kind = if is_closed(mesh) { "model" } else { "surface" };
    write!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model unit=\"{unit}\" xml:lang=\"en-US\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n\
         <metadata name=\"Application\">isopatch {}</metadata>\n\
         <resources>\n<object id=\"1\" type=\"{kind}\">\n<mesh>\n<vertices>\n",
        env!("CARGO_PKG_VERSION")
    )?;
    write_items(out, mesh.positions.len(), |v, text| {
        text.extend_from_slice(b"<vertex");
        for (name, x) in ["x", "y", "z"].into_iter().zip(mesh.positions[v].iter()) {
            text.push(b' ');
            text.extend_from_slice(name.as_bytes());
            text.extend_from_slice(b"=\"");
            push_float(text, *x);
            text.push(b'"');
        }
        text.extend_from_slice(b"/>\n");
    })?;
    out.write_all(b"</vertices>\n<triangles>\n")?;
    write_items(out, mesh.triangles.len(), |t, text| {
        text.extend_from_slice(b"<triangle");
        for (name, v) in ["v1", "v2", "v3"].into_iter().zip(mesh.triangles[t]) {
            text.push(b' ');
            text.extend_from_slice(name.as_bytes());
            text.extend_from_slice(b"=\"");
            push_integer(text, u64::from(v));
            text.push(b'"');
        }
        text.extend_from_slice(b"/>\n");
    })?;
    out.write_all(
        b"</triangles>\n</mesh>\n</object>\n</resources>\n<build>\n<item objectid=\"1\"/>\n</build>\n</model>\n",
    )
}

/// Is every edge between two triangles that go through it in opposite directions?
fn is_closed(mesh: &Tessellation) -> bool {
    let directed = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a)];
    let mut forward: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(directed).collect();
    let mut backward: Vec<(u32, u32)> = forward.iter().map(|(a, b)| (*b, *a)).collect();
    forward.sort_unstable();
    backward.sort_unstable();
    forward == backward && forward.windows(2).all(|pair| pair[0] != pair[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::{flat_triangle, sphere};
    use crate::tessellate::{TessellateOptions, tessellate};
    use std::io::Read;

    fn model(mesh: &Tessellation, unit: Unit) -> String {
        let mut bytes = Vec::new();
        write_3mf(mesh, &ThreemfOptions { unit }, &mut bytes).unwrap();
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        assert_eq!(archive.len(), 3);
        let mut text = String::new();
        archive.by_name("3D/3dmodel.model").unwrap().read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn a_flat_triangle_is_a_surface() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
        let text = model(&mesh, Unit::In);
        assert!(text.contains("unit=\"inch\"") && text.contains("<object id=\"1\" type=\"surface\">"));
        assert!(
            text.contains(
                "<vertex x=\"1.0\" y=\"0.0\" z=\"0.0\"/>\n<vertex x=\"0.0\" y=\"1.0\" z=\"0.0\"/>\n"
            )
        );
        assert!(text.contains("<triangles>\n<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>\n</triangles>"));
    }

    #[test]
    fn a_sphere_is_a_solid() {
        let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 3 }).unwrap();
        let text = model(&mesh, Unit::Mm);
        assert!(text.contains("unit=\"millimeter\"") && text.contains("type=\"model\""));
        assert_eq!(text.matches("<triangle v1").count(), 180);
        let mut inverted = mesh.clone();
        inverted.triangles[7].reverse();
        assert!(model(&inverted, Unit::Mm).contains("type=\"surface\""));
    }

    #[test]
    fn nothing_is_refused() {
        let mut mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
        mesh.triangles.clear();
        let error = write_3mf(&mesh, &ThreemfOptions::default(), &mut Vec::new()).unwrap_err();
        assert!(matches!(error, WriteError::Empty { format: "3MF" }));
    }
}
