//! VTK unstructured grids (.vtu): of degree-7 triangles, of rational quadrilaterals, or of flat triangles.

use super::net::{DEGREE, nets};
use super::{ThinParts, WriteError, error, text};
use crate::bernstein::index;
use crate::geom::Vec3;
use crate::rational::pieces::{Piece, pieces};
use crate::surface::{PatchForm, PatchId, Surface};
use crate::tessellate::{SharedLattice, TessellateOptions, Tessellation, tessellate};
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
    if surface.patches().any(|p| matches!(surface.form(p), PatchForm::RationalTriangle { .. })) {
        return write_rational(surface, options, out);
    }
    let nets = nets(surface, "VTK")?;
    let lattice = SharedLattice::new(surface, DEGREE)?;
    let (points, normals) = match options.cells {
        Cells::Bezier => (lattice.gather(|patch, at| nets[patch.index()][at]), Vec::new()),
        Cells::Lagrange => {
            let mesh = tessellate(surface, &TessellateOptions { resolution: DEGREE })?;
            (mesh.positions, mesh.normals)
        }
    };
    let order = node_order(DEGREE);
    let grid = Grid {
        points: &points,
        normals: &normals,
        weights: &[],
        cells: surface.patch_count(),
        end: &|cell| (cell + 1) * NODES,
        cell_type: &|_| options.cells.cell_type(),
        degrees: Some(&|_| [DEGREE, DEGREE]),
        patches: &[],
        node: &|cell, n| lattice.number(PatchId(cell as u32), order[n]),
    };
    grid.write(out)
}

/// VTK_BEZIER_QUADRILATERAL.
const BEZIER_QUADRILATERAL: u8 = 77;

/// Writes the four pieces of each rational triangle ([`pieces`]) as rational Bézier quadrilaterals, exactly, with the number of the patch of
/// each. Triangles would have weights of 0, which VTK divides by. Cells do not share points, because weights belong to points.
fn write_rational(
    surface: &dyn Surface,
    options: &VtkOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let format = "VTK";
    if options.cells == Cells::Lagrange {
        return Err(WriteError::NoNet { format: "VTK with Lagrange cells", patch: 0 });
    }
    let mut cells: Vec<Piece> = Vec::new();
    for patch in surface.patches() {
        let PatchForm::RationalTriangle { degree, weighted } = surface.form(patch) else {
            return Err(WriteError::NoNet { format, patch: patch.0 });
        };
        if !weighted.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Err(WriteError::NotFinite { what: "patch", index: patch.index() });
        }
        cells.extend(pieces(degree, weighted));
    }
    let (mut points, mut weights, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for piece in &cells {
        for [i, j] in quadrilateral_order(piece.degrees) {
            let p = piece.point(i, j);
            points.push(p.xyz() / p.w);
            weights.push(p.w);
        }
        ends.push(points.len());
    }
    let start = |cell: usize| if cell == 0 { 0 } else { ends[cell - 1] };
    let patches: Vec<PatchId> = surface.patches().flat_map(|p| [p; 4]).collect();
    let grid = Grid {
        points: &points,
        normals: &[],
        weights: &weights,
        cells: cells.len(),
        end: &|cell| ends[cell],
        cell_type: &|_| BEZIER_QUADRILATERAL,
        degrees: Some(&|cell| cells[cell].degrees),
        patches: &patches,
        node: &|cell, n| (start(cell) + n) as u32,
    };
    grid.write(out)
}

/// The control points (i, j) of a quadrilateral of degree m × n in VTK's order: four corners counter-clockwise, the insides of the
/// edges, each with rising i or j, then the rest, i first.
fn quadrilateral_order([m, n]: [usize; 2]) -> Vec<[usize; 2]> {
    let mut order = vec![[0, 0], [m, 0], [m, n], [0, n]];
    order.extend((1..m).map(|i| [i, 0]));
    order.extend((1..n).map(|j| [m, j]));
    order.extend((1..m).map(|i| [i, n]));
    order.extend((1..n).map(|j| [0, j]));
    order.extend((1..n).flat_map(|j| (1..m).map(move |i| [i, j])));
    order
}

/// VTK_TRIANGLE.
const LINEAR_TRIANGLE: u8 = 5;
const SINGLE_VERTEX: u8 = 1;
const LINE: u8 = 3;

/// Writes flat triangles with the normals of the surface at their corners, and the number of the patch of each. A vertex on a
/// crease is there once for each of its normals.
pub fn write_vtk_mesh(mesh: &Tessellation, out: &mut impl Write) -> Result<(), WriteError> {
    write_vtk_mesh_with(mesh, &ThinParts::default(), out)
}

/// The same, and thin parts as cells of their own after the triangles: vertices, then lines. Their normals are 0; their
/// patch numbers go on from those of the triangles.
pub fn write_vtk_mesh_with(
    mesh: &Tessellation,
    thin: &ThinParts,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    error::check_finite(mesh)?;
    let mesh = &*mesh.with_split_creases();
    let (first, triangles) = (mesh.positions.len(), mesh.triangles.len());
    let (points, segments) = (thin.points.len(), thin.segments(first));
    let positions: Vec<Vec3> = mesh.positions.iter().copied().chain(thin.positions()).collect();
    let normals: Vec<Vec3> = mesh.normals.iter().copied().chain(thin.normals()).collect();
    let next = mesh.patches.iter().map(|p| p.0 + 1).max().unwrap_or(0);
    let cells = triangles + points + segments.len();
    let more = (triangles..cells).map(|cell| PatchId(next + (cell - triangles) as u32));
    let patches: Vec<PatchId> = mesh.patches.iter().copied().chain(more).collect();
    let grid = Grid {
        points: &positions,
        normals: &normals,
        weights: &[],
        cells,
        end: &|cell| {
            let before = 3 * triangles.min(cell + 1);
            let single = (cell + 1).saturating_sub(triangles).min(points);
            before + single + 2 * (cell + 1).saturating_sub(triangles + points)
        },
        cell_type: &|cell| match cell {
            _ if cell < triangles => LINEAR_TRIANGLE,
            _ if cell < triangles + points => SINGLE_VERTEX,
            _ => LINE,
        },
        degrees: None,
        patches: &patches,
        node: &|cell, n| match cell {
            _ if cell < triangles => mesh.triangles[cell][n],
            _ if cell < triangles + points => (first + cell - triangles) as u32,
            _ => segments[cell - triangles - points][n],
        },
    };
    grid.write(out)
}

/// The nodes of a triangle of degree n in VTK's order: three corners, the insides of the edges, then the triangle
/// of degree n − 3 inside in the same way.
pub(super) fn node_order(n: usize) -> Vec<[usize; 3]> {
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

/// An unstructured grid of cells of one kind.
struct Grid<'a> {
    points: &'a [Vec3],
    /// Per point, or empty.
    normals: &'a [Vec3],
    /// Of rational cells, per point, or empty.
    weights: &'a [f64],
    cells: usize,
    /// Nodes of all cells up to one, and with it.
    end: &'a (dyn Fn(usize) -> usize + Sync),
    cell_type: &'a (dyn Fn(usize) -> u8 + Sync),
    /// Of higher-order cells.
    degrees: Option<&'a (dyn Fn(usize) -> [usize; 2] + Sync)>,
    /// Patch of each cell, or empty.
    patches: &'a [PatchId],
    /// Point of a node of a cell.
    node: &'a (dyn Fn(usize, usize) -> u32 + Sync),
}

/// Bytes of a length in front of an appended array.
const LENGTH: usize = 8;

type WriteArray<'a, W> = Box<dyn Fn(&mut W) -> io::Result<()> + 'a>;

/// A data array: how it is described in the header, its bytes, and what writes them.
struct Array<'a, W> {
    element: Element,
    kind: &'static str,
    name: &'static str,
    components: usize,
    bytes: usize,
    write: WriteArray<'a, W>,
}

/// Where an array belongs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Element {
    CellData,
    PointData,
    Points,
    Cells,
}

impl Element {
    const ALL: [Self; 4] = [Self::CellData, Self::PointData, Self::Points, Self::Cells];

    fn name(self) -> &'static str {
        match self {
            Self::CellData => "CellData",
            Self::PointData => "PointData",
            Self::Points => "Points",
            Self::Cells => "Cells",
        }
    }

    /// What the element says of its arrays besides.
    fn attributes(self, names: &[&str]) -> String {
        let says = |attribute: &str, name| {
            if names.contains(&name) { format!(" {attribute}=\"{name}\"") } else { String::new() }
        };
        match self {
            Self::CellData => says("HigherOrderDegrees", "HigherOrderDegrees") + &says("Scalars", "patch"),
            Self::PointData => says("Normals", "Normals") + &says("RationalWeights", "RationalWeights"),
            Self::Points | Self::Cells => String::new(),
        }
    }
}

impl Grid<'_> {
    fn write<W: Write>(&self, out: &mut W) -> Result<(), WriteError> {
        let arrays = self.arrays();
        write!(
            out,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"UnstructuredGrid\" version=\"2.2\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n{}\
             </Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
            self.points.len(),
            self.cells,
            described(&arrays),
        )?;
        for array in &arrays {
            out.write_all(&(array.bytes as u64).to_le_bytes())?;
            (array.write)(out)?;
        }
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
        Ok(())
    }

    fn arrays<W: Write>(&self) -> Vec<Array<'_, W>> {
        let (cells, end) = (self.cells, self.end);
        let nodes = if cells == 0 { 0 } else { end(cells - 1) };
        let mut arrays = Vec::new();
        let mut add = |element, kind, name, components, bytes, write| {
            arrays.push(Array { element, kind, name, components, bytes, write });
        };
        let vector = 3 * size_of::<f64>();
        if let Some(degrees) = self.degrees {
            let of_cell = move |cell: usize| {
                let [m, n] = degrees(cell).map(|n| n as f64);
                Vec3::new(m, n, 0.0)
            };
            let write = move |out: &mut W| write_vectors(out, cells, of_cell);
            add(Element::CellData, "Float64", "HigherOrderDegrees", 3, cells * vector, Box::new(write) as _);
        }
        if !self.patches.is_empty() {
            let write = move |out: &mut W| {
                let number = |c: usize, bytes: &mut Vec<u8>| bytes.extend(self.patches[c].0.to_le_bytes());
                text::write_items(out, cells, number)
            };
            add(Element::CellData, "UInt32", "patch", 1, cells * size_of::<u32>(), Box::new(write));
        }
        if !self.weights.is_empty() {
            let write = |out: &mut W| {
                text::write_items(out, self.weights.len(), |i, bytes| {
                    bytes.extend(self.weights[i].to_le_bytes())
                })
            };
            let bytes = size_of_val(self.weights);
            add(Element::PointData, "Float64", "RationalWeights", 1, bytes, Box::new(write));
        }
        for (element, name, vectors) in
            [(Element::PointData, "Normals", self.normals), (Element::Points, "Points", self.points)]
        {
            if element == Element::Points || !vectors.is_empty() {
                let write = |out: &mut W| write_vectors(out, vectors.len(), |i| vectors[i]);
                add(element, "Float64", name, 3, vectors.len() * vector, Box::new(write));
            }
        }
        let word = size_of::<i64>();
        let connectivity = move |out: &mut W| {
            text::write_items(out, cells, |c, bytes| {
                let count = if c == 0 { end(0) } else { end(c) - end(c - 1) };
                (0..count).for_each(|n| bytes.extend(i64::from((self.node)(c, n)).to_le_bytes()));
            })
        };
        add(Element::Cells, "Int64", "connectivity", 1, nodes * word, Box::new(connectivity));
        let offsets = move |out: &mut W| {
            text::write_items(out, cells, |c, bytes| bytes.extend((end(c) as i64).to_le_bytes()))
        };
        add(Element::Cells, "Int64", "offsets", 1, cells * word, Box::new(offsets));
        let types =
            move |out: &mut W| out.write_all(&(0..cells).map(|c| (self.cell_type)(c)).collect::<Vec<u8>>());
        add(Element::Cells, "UInt8", "types", 1, cells, Box::new(types));
        arrays
    }
}

fn write_vectors(
    out: &mut impl Write,
    count: usize,
    vector: impl Fn(usize) -> Vec3 + Sync,
) -> io::Result<()> {
    text::write_items(out, count, |i, bytes| {
        vector(i).iter().for_each(|c| bytes.extend_from_slice(&c.to_le_bytes()));
    })
}

/// The elements of the header for arrays that are appended one after the other.
fn described<W>(arrays: &[Array<'_, W>]) -> String {
    let mut text = String::new();
    for element in Element::ALL {
        let mut offset = 0;
        let (mut lines, mut names) = (String::new(), Vec::new());
        for array in arrays {
            if array.element == element {
                let Array { kind, name, components, .. } = array;
                lines += &format!(
                    "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                     format=\"appended\" offset=\"{offset}\"/>\n"
                );
                names.push(*name);
            }
            offset += LENGTH + array.bytes;
        }
        if !lines.is_empty() {
            let (name, attributes) = (element.name(), element.attributes(&names));
            text += &format!("<{name}{attributes}>\n{lines}</{name}>\n");
        }
    }
    text
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

    #[test]
    fn flat_triangles_carry_normals_and_patches() {
        let mesh = tessellate(&sphere(), &TessellateOptions { resolution: 2 }).unwrap();
        let mut bytes = Vec::new();
        write_vtk_mesh(&mesh, &mut bytes).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("NumberOfPoints=\"42\" NumberOfCells=\"80\""));
        assert!(
            text.contains("<CellData Scalars=\"patch\">") && text.contains("<PointData Normals=\"Normals\">")
        );
        let start = bytes.windows(6).position(|w| w == b"raw\">\n").unwrap() + 7;
        let end = bytes.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
        assert_eq!(end - start, 6 * 8 + 80 * 4 + 2 * 42 * 24 + 80 * (3 * 8 + 8 + 1));
    }
}
