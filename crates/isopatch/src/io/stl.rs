//! Binary STL.

use super::text::write_items;
use super::{WriteError, error};
use crate::tessellate::Tessellation;
use std::io::Write;

/// Bytes before the number of triangles.
const HEADER: usize = 80;

/// Writes the triangles with their own normals. The format has single precision only and no way to say where its
/// origin is, so a small model far from the origin loses digits.
pub fn write_stl(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let count = mesh.triangles.len();
    let too_many = |_| WriteError::TooMany { format: "STL", what: "triangles", count };
    let count = u32::try_from(count).map_err(too_many)?;
    // The header must not start with "solid", which announces text.
    let mut header = [b' '; HEADER];
    let generator = concat!("binary STL by isopatch ", env!("CARGO_PKG_VERSION"));
    header[..generator.len()].copy_from_slice(generator.as_bytes());
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    write_items(out, mesh.triangles.len(), |t, bytes| {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        // The zero vector stands for a normal that readers have to find themselves.
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        for x in [normal, a, b, c].iter().flat_map(|v| v.iter()) {
            bytes.extend_from_slice(&(*x as f32).to_le_bytes());
        }
        bytes.extend_from_slice(&[0, 0]);
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::flat_triangle;
    use crate::tessellate::{TessellateOptions, tessellate};

    #[test]
    fn triangles_carry_their_normals() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 3 }).unwrap();
        let mut bytes = Vec::new();
        write_stl(&mesh, &mut bytes).unwrap();
        assert_eq!(bytes.len(), HEADER + 4 + 9 * 50);
        assert!(!bytes.starts_with(b"solid"));
        let single = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        for triangle in bytes[HEADER + 4..].chunks(50) {
            let normal: Vec<f32> = triangle[..12].chunks(4).map(single).collect();
            assert_eq!(normal, [0.0, 0.0, 1.0]);
        }
    }
}
