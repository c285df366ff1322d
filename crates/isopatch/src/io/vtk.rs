//! VTK unstructured grids (.vtu) of degree-7 triangles.

use super::net::{DEGREE, nets};
use super::{WriteError, text};
use crate::bernstein::index;
use crate::geom::Vec3;
use crate::surface::{PatchId, Surface};
use crate::tessellate::{SharedLattice, TessellateOptions, tessellate};
use std::io::{self, Write};

const NODES: usize = index::count(DEGREE);

/// What the points of a cell are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cells {
    /// Bézier control points: the patches exactly (VTK_BEZIER_TRIANGLE).
    #[default]
    Bezier,
    /// Points of the surface, with its normals (VTK_LAGRANGE_TRIANGLE): the same polynomials, and readers draw them
    /// much faster.
    Lagrange,
}

impl Cells {
    fn cell_type(self) -> u8 {
        match self {
            Self::Bezier => 76,
            Self::Lagrange => 69,
        }
    }
}

/// How to write a .vtu file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VtkOptions {
    /// What the points of a cell are. Default: Bézier control points.
    pub cells: Cells,
}

/// Writes one cell a patch. Cells share the points on common corners and seams; the corners come first, by their
/// numbers.
pub fn write_vtk(
    surface: &dyn Surface,
    options: &VtkOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let nets = nets(surface, "VTK")?;
    let lattice = SharedLattice::new(surface, DEGREE)?;
    let (points, normals) = match options.cells {
        Cells::Bezier => (lattice.gather(|patch, at| nets[patch.index()][at]), Vec::new()),
        Cells::Lagrange => {
            let mesh = tessellate(surface, &TessellateOptions { resolution: DEGREE })?;
            (mesh.positions, mesh.normals)
        }
    };
    let arrays = Arrays { lattice: &lattice, patches: surface.patch_count(), points, normals };
    write_header(out, &arrays)?;
    arrays.write_data(options.cells, out)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    Ok(())
}

/// The nodes of a triangle of degree n in VTK's order: three corners, the insides of the edges, then the triangle
/// of degree n − 3 inside in the same way.
fn node_order(n: usize) -> Vec<[usize; 3]> {
    if n == 0 {
        return vec![[0; 3]];
    }
    let mut nodes = vec![[n, 0, 0], [0, n, 0], [0, 0, n]];
    for edge in 0..3 {
        for m in 1..n {
            let mut node = [0; 3];
            node[edge] = n - m;
            node[(edge + 1) % 3] = m;
            nodes.push(node);
        }
    }
    if n >= 3 {
        nodes.extend(node_order(n - 3).into_iter().map(|ijk| ijk.map(|i| i + 1)));
    }
    nodes
}

struct Arrays<'a> {
    lattice: &'a SharedLattice,
    patches: usize,
    points: Vec<Vec3>,
    /// Per point, or empty.
    normals: Vec<Vec3>,
}

/// Bytes of a length in front of an appended array.
const LENGTH: usize = 8;

impl Arrays<'_> {
    /// Bytes of the arrays in their order in the file: degrees, normals, points, connectivity, offsets, types.
    fn sizes(&self) -> [usize; 6] {
        let vector = 3 * size_of::<f64>();
        let normals = self.normals.len() * vector;
        let connectivity = self.patches * NODES * size_of::<i64>();
        let offsets = self.patches * size_of::<i64>();
        [self.patches * vector, normals, self.points.len() * vector, connectivity, offsets, self.patches]
    }

    fn write_data(&self, cells: Cells, out: &mut impl Write) -> io::Result<()> {
        let sizes = self.sizes();
        let length = |out: &mut dyn Write, array: usize| out.write_all(&(sizes[array] as u64).to_le_bytes());
        let vectors = |out: &mut _, vectors: &[Vec3]| {
            text::write_items(out, vectors.len(), |i, bytes| {
                vectors[i].iter().for_each(|c| bytes.extend_from_slice(&c.to_le_bytes()));
            })
        };
        let degree = DEGREE as f64;
        length(out, 0)?;
        vectors(out, &vec![Vec3::new(degree, degree, 0.0); self.patches])?;
        if !self.normals.is_empty() {
            length(out, 1)?;
            vectors(out, &self.normals)?;
        }
        length(out, 2)?;
        vectors(out, &self.points)?;
        length(out, 3)?;
        let order = node_order(DEGREE);
        text::write_items(out, self.patches, |p, bytes| {
            for ijk in &order {
                let number = self.lattice.number(PatchId(p as u32), *ijk);
                bytes.extend_from_slice(&i64::from(number).to_le_bytes());
            }
        })?;
        length(out, 4)?;
        text::write_items(out, self.patches, |p, bytes| {
            bytes.extend_from_slice(&(((p + 1) * NODES) as i64).to_le_bytes());
        })?;
        length(out, 5)?;
        out.write_all(&vec![cells.cell_type(); self.patches])
    }
}

fn write_header(out: &mut impl Write, arrays: &Arrays<'_>) -> io::Result<()> {
    let mut offset = 0;
    let sizes = arrays.sizes();
    let mut array = |k: usize, kind: &str, name: &str, components: usize| {
        let element = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>\n"
        );
        offset += LENGTH + sizes[k];
        element
    };
    let degrees = array(0, "Float64", "HigherOrderDegrees", 3);
    let normals = match arrays.normals.is_empty() {
        true => String::new(),
        false => {
            format!("<PointData Normals=\"Normals\">\n{}</PointData>\n", array(1, "Float64", "Normals", 3))
        }
    };
    let points = array(2, "Float64", "Points", 3);
    let (connectivity, offsets, types) = (
        array(3, "Int64", "connectivity", 1),
        array(4, "Int64", "offsets", 1),
        array(5, "UInt8", "types", 1),
    );
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"2.2\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n\
         <CellData HigherOrderDegrees=\"HigherOrderDegrees\">\n{degrees}</CellData>\n\
         {normals}<Points>\n{points}</Points>\n<Cells>\n{connectivity}{offsets}{types}</Cells>\n\
         </Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
        arrays.points.len(),
        arrays.patches,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::{flat_triangle, sphere};

    #[test]
    fn nodes_are_each_named_once() {
        for n in 0..=9 {
            let mut order = node_order(n);
            assert_eq!(order.len(), index::count(n));
            order.sort_unstable();
            order.dedup();
            assert_eq!(order.len(), index::count(n));
        }
        assert_eq!(node_order(7)[21..24], [[5, 1, 1], [1, 5, 1], [1, 1, 5]]);
        assert_eq!(node_order(7)[33..], [[3, 2, 2], [2, 3, 2], [2, 2, 3]]);
    }

    #[test]
    fn points_on_seams_are_shared_and_the_sizes_add_up() {
        for cells in [Cells::Bezier, Cells::Lagrange] {
            for (surface, points) in [(sphere(), 12 + 30 * 6 + 20 * 15), (flat_triangle(), 36)] {
                let mut bytes = Vec::new();
                write_vtk(&surface, &VtkOptions { cells }, &mut bytes).unwrap();
                let text = String::from_utf8_lossy(&bytes);
                assert!(text.contains(&format!("NumberOfPoints=\"{points}\"")));
                let start = bytes.windows(6).position(|w| w == b"raw\">\n").unwrap() + 7;
                let end = bytes.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
                let vectors = if cells == Cells::Bezier { 1 } else { 2 };
                let patches = surface.nets.len();
                let arrays = 24 * vectors * points + patches * (24 + 36 * 8 + 8 + 1);
                assert_eq!(end - start, arrays + 8 * (4 + vectors));
            }
        }
    }
}
