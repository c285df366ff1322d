//! Binary PLY.

use super::text::write_items;
use super::{ThinParts, WriteError, error};
use crate::tessellate::Tessellation;
use std::io::Write;

/// Writes positions and normals as doubles, and triangles with the number of their patch, in the order of the mesh. A vertex on a
/// crease is there once for each of its normals.
pub fn write_ply(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    write_ply_with(mesh, &ThinParts::default(), out)
}

/// The same, and thin parts: isolated points as vertices without a face, curves as elements `edge`; their normals are 0.
pub fn write_ply_with(mesh: &Tessellation, thin: &ThinParts, out: &mut impl Write) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let mesh = mesh.with_split_creases();
    let segments = thin.segments(mesh.positions.len());
    let positions: Vec<_> = mesh.positions.iter().copied().chain(thin.positions()).collect();
    let normals: Vec<_> = mesh.normals.iter().copied().chain(thin.normals()).collect();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment isopatch {}\nelement vertex {}\n",
        env!("CARGO_PKG_VERSION"),
        positions.len()
    )?;
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(out, "property double {name}")?;
    }
    let faces = mesh.triangles.len();
    write!(out, "element face {faces}\nproperty list uchar uint vertex_indices\nproperty uint patch\n")?;
    if !segments.is_empty() {
        write!(out, "element edge {}\nproperty uint vertex1\nproperty uint vertex2\n", segments.len())?;
    }
    writeln!(out, "end_header")?;
    write_items(out, positions.len(), |v, bytes| {
        for c in positions[v].iter().chain(normals[v].iter()) {
            bytes.extend_from_slice(&c.to_le_bytes());
        }
    })?;
    write_items(out, faces, |t, bytes| {
        bytes.push(3);
        for number in mesh.triangles[t].iter().chain([&mesh.patches[t].0]) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
    })?;
    write_items(out, segments.len(), |s, bytes| {
        segments[s].iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::sphere;
    use crate::tessellate::{TessellateOptions, tessellate};

    #[test]
    fn doubles_are_kept() {
        let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 2 }).unwrap();
        let mut bytes = Vec::new();
        write_ply(&mesh, &mut bytes).unwrap();
        let start = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        assert_eq!(bytes.len() - start, mesh.positions.len() * 48 + mesh.triangles.len() * 17);
        for (v, p) in mesh.positions.iter().enumerate() {
            for c in 0..3 {
                let at = start + 48 * v + 8 * c;
                assert_eq!(f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()), p[c]);
            }
        }
    }
}
