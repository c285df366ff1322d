//! Gmsh meshes (.msh 4.1, text): of degree-7 triangles, or of flat ones.

use super::net::{DEGREE, nets};
use super::text::{push_float, push_integer, write_items};
use super::vtk::node_order;
use super::{WriteError, error};
use crate::geom::{Aabb, Point3};
use crate::surface::{PatchId, Surface};
use crate::tessellate::{SharedLattice, TessellateOptions, Tessellation, tessellate};
use std::io::Write;

/// Gmsh's numbers of element types: 36-node and 3-node triangles.
const DEGREE_7_TRIANGLE: u8 = 43;
const FLAT_TRIANGLE: u8 = 2;

/// Writes one element a patch, exactly: its nodes are 36 points of the patch. Elements share those on common corners and seams;
/// the corners come first, by their numbers. Tags are numbers plus one.
pub fn write_gmsh(surface: &dyn Surface, out: &mut impl Write) -> Result<(), WriteError> {
    nets(surface, "Gmsh")?;
    let lattice = SharedLattice::new(surface, DEGREE)?;
    // The nodes of Gmsh's elements of degree n are the points of the lattice with n intervals.
    let mesh = tessellate(surface, &TessellateOptions { resolution: DEGREE })?;
    let order = node_order(DEGREE);
    let elements = Elements {
        points: &mesh.positions,
        kind: DEGREE_7_TRIANGLE,
        count: surface.patch_count(),
        nodes: order.len(),
        node: &|element, n| lattice.number(PatchId(element as u32), order[n]),
    };
    elements.write(out)
}

/// Writes flat triangles, in the order of the mesh. The format has no normals.
pub fn write_gmsh_mesh(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let elements = Elements {
        points: &mesh.positions,
        kind: FLAT_TRIANGLE,
        count: mesh.triangles.len(),
        nodes: 3,
        node: &|element, n| mesh.triangles[element][n],
    };
    elements.write(out)
}

/// Elements of one kind on one surface.
struct Elements<'a> {
    points: &'a [Point3],
    kind: u8,
    count: usize,
    /// Nodes of an element.
    nodes: usize,
    /// Point of a node of an element.
    node: &'a (dyn Fn(usize, usize) -> u32 + Sync),
}

impl Elements<'_> {
    fn write(&self, out: &mut impl Write) -> Result<(), WriteError> {
        if self.count == 0 {
            return Err(WriteError::Empty { format: "Gmsh" });
        }
        // Version, text, bytes of a number.
        out.write_all(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")?;
        self.write_entities(out)?;
        self.write_nodes(out)?;
        self.write_elements(out)
    }

    /// No points, no curves, one surface (tag, box, no physical groups, no curves around it), no volumes.
    fn write_entities(&self, out: &mut impl Write) -> Result<(), WriteError> {
        let bounds = Aabb::around(self.points);
        let mut text = b"$Entities\n0 0 1 0\n1".to_vec();
        for x in bounds.min.iter().chain(bounds.max.iter()) {
            text.push(b' ');
            push_float(&mut text, *x);
        }
        text.extend_from_slice(b" 0 0\n$EndEntities\n");
        Ok(out.write_all(&text)?)
    }

    /// All nodes in one block: of dimension 2, on surface 1, without parameters; first the tags, then the points.
    fn write_nodes(&self, out: &mut impl Write) -> Result<(), WriteError> {
        let count = self.points.len();
        write!(out, "$Nodes\n1 {count} 1 {count}\n2 1 0 {count}\n")?;
        write_items(out, count, |i, text| {
            push_integer(text, i as u64 + 1);
            text.push(b'\n');
        })?;
        write_items(out, count, |i, text| {
            for (c, x) in self.points[i].iter().enumerate() {
                if c > 0 {
                    text.push(b' ');
                }
                push_float(text, *x);
            }
            text.push(b'\n');
        })?;
        Ok(out.write_all(b"$EndNodes\n")?)
    }

    fn write_elements(&self, out: &mut impl Write) -> Result<(), WriteError> {
        let count = self.count;
        write!(out, "$Elements\n1 {count} 1 {count}\n2 1 {} {count}\n", self.kind)?;
        write_items(out, count, |e, text| {
            push_integer(text, e as u64 + 1);
            for n in 0..self.nodes {
                text.push(b' ');
                push_integer(text, u64::from((self.node)(e, n)) + 1);
            }
            text.push(b'\n');
        })?;
        Ok(out.write_all(b"$EndElements\n")?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::{flat_triangle, sphere};

    #[test]
    fn a_flat_triangle_is_what_it_is() {
        let mesh = tessellate(&flat_triangle(), &TessellateOptions { resolution: 1 }).unwrap();
        let mut text = Vec::new();
        write_gmsh_mesh(&mesh, &mut text).unwrap();
        let expected = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
                        $Entities\n0 0 1 0\n1 0.0 0.0 0.0 1.0 1.0 0.0 0 0\n$EndEntities\n\
                        $Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0.0 0.0 0.0\n1.0 0.0 0.0\n0.0 1.0 0.0\n$EndNodes\n\
                        $Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    #[test]
    fn elements_share_the_nodes_on_seams() {
        let mut text = Vec::new();
        write_gmsh(&sphere(), &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("$Nodes\n1 492 1 492\n") && text.contains("$Elements\n1 20 1 20\n2 1 43 20\n"));
        let elements = text.lines().skip_while(|line| *line != "2 1 43 20").skip(1).take(20);
        assert!(elements.into_iter().all(|line| line.split(' ').count() == 37));
    }
}
