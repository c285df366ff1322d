//! Wavefront OBJ.

use super::text::{push_float, push_integer, write_items};
use super::{ThinParts, WriteError, error};
use crate::geom::Vec3;
use crate::tessellate::Tessellation;
use std::io::Write;

/// Writes positions, normals and triangles, in the order of the mesh, and each patch's triangles as a group.
pub fn write_obj(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    write_obj_with(mesh, &ThinParts::default(), out)
}

/// The same, and thin parts as elements of their own: `p` for points, `l` for curves.
pub fn write_obj_with(mesh: &Tessellation, thin: &ThinParts, out: &mut impl Write) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let vectors = |keyword: &'static [u8], vectors: &[Vec3], out: &mut _| {
        write_items(out, vectors.len(), |v, text| {
            text.extend_from_slice(keyword);
            for c in vectors[v].iter() {
                text.push(b' ');
                push_float(text, *c);
            }
            text.push(b'\n');
        })
    };
    vectors(b"v", &mesh.positions, out)?;
    vectors(b"v", &thin.positions(), out)?;
    vectors(b"vn", &mesh.normals, out)?;
    write_items(out, mesh.triangles.len(), |t, text| {
        let patch = mesh.patches[t];
        if t == 0 || mesh.patches[t - 1] != patch {
            text.extend_from_slice(b"g patch");
            push_integer(text, u64::from(patch.0));
            text.push(b'\n');
        }
        text.push(b'f');
        for (v, n) in mesh.triangles[t].into_iter().zip(mesh.normal_numbers(t)) {
            // Numbers start at 1.
            text.push(b' ');
            push_integer(text, u64::from(v) + 1);
            text.extend_from_slice(b"//");
            push_integer(text, u64::from(n) + 1);
        }
        text.push(b'\n');
    })?;
    if thin.is_empty() {
        return Ok(());
    }
    let first = mesh.positions.len();
    writeln!(out, "g thin")?;
    (1..=thin.points.len()).try_for_each(|k| writeln!(out, "p {}", first + k))?;
    for curve in thin.numbered_curves(first) {
        write!(out, "l")?;
        curve.into_iter().try_for_each(|v| write!(out, " {}", v + 1))?;
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::flat_triangle;
    use crate::tessellate::{TessellateOptions, tessellate};

    #[test]
    fn a_flat_triangle_is_what_it_is() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
        let mut text = Vec::new();
        write_obj(&mesh, &mut text).unwrap();
        let expected = "v 0.0 0.0 0.0\nv 1.0 0.0 0.0\nv 0.0 1.0 0.0\n\
                        vn 0.0 0.0 1.0\nvn 0.0 0.0 1.0\nvn 0.0 0.0 1.0\ng patch0\nf 1//1 2//2 3//3\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
