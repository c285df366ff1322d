//! OFF, the text format of Geomview.

use super::text::{push_float, push_integer, write_items};
use super::{WriteError, error};
use crate::tessellate::Tessellation;
use std::io::Write;

/// Writes positions and triangles, in the order of the mesh. There are no normals: few readers take them, and vertices on creases
/// would have to be there several times.
pub fn write_off(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    // Readers pass the number of edges over.
    write!(out, "OFF\n{} {} 0\n", mesh.positions.len(), mesh.triangles.len())?;
    write_items(out, mesh.positions.len(), |v, text| {
        for (c, x) in mesh.positions[v].iter().enumerate() {
            if c > 0 {
                text.push(b' ');
            }
            push_float(text, *x);
        }
        text.push(b'\n');
    })?;
    write_items(out, mesh.triangles.len(), |t, text| {
        text.push(b'3');
        for v in mesh.triangles[t] {
            text.push(b' ');
            push_integer(text, u64::from(v));
        }
        text.push(b'\n');
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::{flat_triangle, sphere};
    use crate::io::read::read_off;
    use crate::tessellate::{TessellateOptions, tessellate};

    #[test]
    fn a_flat_triangle_is_what_it_is() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
        let mut text = Vec::new();
        write_off(&mesh, &mut text).unwrap();
        let expected = "OFF\n3 1 0\n0.0 0.0 0.0\n1.0 0.0 0.0\n0.0 1.0 0.0\n3 0 1 2\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    #[test]
    fn our_reader_gets_every_bit_back() {
        let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 4 }).unwrap();
        let mut text = Vec::new();
        write_off(&mesh, &mut text).unwrap();
        let read = read_off(&text).unwrap();
        assert_eq!(read.positions, mesh.positions);
        assert!(read.faces.iter().zip(&mesh.triangles).all(|(face, t)| face == t));
        assert_eq!((read.faces.len(), read.normals), (mesh.triangles.len(), None));
    }
}
