//! A first, fine triangle mesh of a closed surface: marching cubes on a regular grid.

use rayon::prelude::*;

use super::clip::BoxSide;
use super::cube_cases::{CubeCase, FIRST_CENTER, cube_cases, edge_start};
use super::error::BaseError;
use super::triangle_mesh::TriangleMesh;
use crate::field::Field;
use crate::geom::{Aabb, Point3, Points, Vec3};

/// A regular grid of cubic cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Smallest corner.
    pub origin: Point3,
    /// Edge length of a cell.
    pub step: f64,
    /// Number of cells along each axis.
    pub cells: [usize; 3],
}

impl Grid {
    /// Cubic cells that cover the box and share its centre, `cells` of them along its longest side.
    ///
    /// The other sides are rounded up to whole cells, so the grid may stick out of the box by half a cell there.
    pub fn covering(bounds: &Aabb, cells: usize) -> Self {
        let size = bounds.size();
        let step = size.max() / cells as f64;
        // Less than a millionth of a cell is rounding, not a reason for one more cell.
        const ROUNDING: f64 = 1e-6;
        let cells = [0, 1, 2].map(|i| ((size[i] / step - ROUNDING).ceil() as usize).max(1));
        let extent = Vec3::from_fn(|i, _| cells[i] as f64 * step);
        Self { origin: bounds.center() - 0.5 * extent, step, cells }
    }

    fn nodes(&self, axis: usize) -> usize {
        self.cells[axis] + 1
    }

    fn node(&self, i: usize, j: usize, k: usize) -> Point3 {
        self.origin + self.step * Vec3::new(i as f64, j as f64, k as f64)
    }
}

/// Field values at the nodes of a grid, x fastest.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Where the samples are.
    pub grid: Grid,
    /// Value at node (i, j, k), at (k·(ny + 1) + j)·(nx + 1) + i.
    pub values: Vec<f64>,
}

impl Samples {
    fn index(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.grid.nodes(1) + j) * self.grid.nodes(0) + i
    }

    fn node_of(&self, index: usize) -> [usize; 3] {
        let (nx, ny) = (self.grid.nodes(0), self.grid.nodes(1));
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    fn position_of(&self, index: usize) -> Point3 {
        let [i, j, k] = self.node_of(index);
        self.grid.node(i, j, k)
    }
}

/// Evaluates the field at all nodes of the grid.
pub fn sample(field: &dyn Field, grid: &Grid) -> Samples {
    let (nx, ny, nz) = (grid.nodes(0), grid.nodes(1), grid.nodes(2));
    let mut values = vec![0.0; nx * ny * nz];
    values.par_chunks_mut(nx * ny).enumerate().for_each(|(k, layer)| {
        let mut points = Points::zeros(nx * ny);
        for j in 0..ny {
            for i in 0..nx {
                points.set(j * nx + i, grid.node(i, j, k));
            }
        }
        field.values(points.view(), layer);
    });
    Samples { grid: *grid, values }
}

/// Looks for reasons why the samples do not enclose a closed surface.
///
/// Returns whether the field is negative all over the boundary of the grid, so that it is to be negated for the
/// solid to be bounded.
pub fn check_samples(samples: &Samples) -> Result<bool, BaseError> {
    let values = &samples.values;
    let undefined = values.iter().filter(|f| f.is_nan()).count();
    if undefined == values.len() {
        return Err(BaseError::Undefined { share: 1.0, at: None });
    }
    let finite = || values.iter().filter(|f| !f.is_nan());
    let first = finite().next().copied().unwrap_or(0.0);
    if finite().all(|f| *f == first) {
        return Err(BaseError::ConstantField { value: first });
    }
    let negative = finite().filter(|f| **f < 0.0).count();
    if negative == 0 || negative == values.len() - undefined {
        return Err(BaseError::NoSurface { negative: negative > 0, proven: false });
    }
    boundary_sign(samples)
}

/// Sign of the samples on the boundary of the grid: true where negative.
pub(super) fn boundary_sign(samples: &Samples) -> Result<bool, BaseError> {
    let last = samples.grid.cells;
    let mut outside = None;
    for (index, f) in samples.values.iter().enumerate().filter(|(_, f)| !f.is_nan()) {
        let node = samples.node_of(index);
        let Some(axis) = (0..3).find(|a| node[*a] == 0 || node[*a] == last[*a]) else { continue };
        let negative = *f < 0.0;
        if *outside.get_or_insert(negative) != negative {
            let side = BoxSide { axis, upper: node[axis] != 0 };
            return Err(BaseError::SurfaceLeavesBox { side, at: samples.position_of(index) });
        }
    }
    Ok(outside.unwrap_or(false))
}

/// No vertex on this grid edge.
const NONE: u32 = u32::MAX;

/// Vertices whose grid edges start in one layer of nodes.
struct LayerVertices {
    positions: Vec<Point3>,
    /// Number (within the layer) of the vertex on the edge along axis a from node (i, j), at 3·(j·nx + i) + a.
    on_edge: Vec<u32>,
}

/// Triangles of one layer of cells; vertex numbers are final except those of loop centres, counted from `NONE` down.
#[derive(Default)]
struct LayerFaces {
    centers: Vec<Point3>,
    faces: Vec<[Corner; 3]>,
}

#[derive(Clone, Copy)]
enum Corner {
    Edge(u32),
    Center(u32),
}

/// The zero set of the samples as a closed, oriented 2-manifold: marching cubes with all cases resolved
/// so that neighbouring cells agree and no edge gets more than two faces.
///
/// f < 0 counts as inside, everything else (zero and NaN too) as outside. Vertices are where the linear
/// interpolation along a grid edge vanishes, but not within [`END_GAP`] of its ends; they are near the surface, not on
/// it. The boundary of the grid must be of one sign, see [`check_samples`]; a cell with both a negative and an
/// undefined corner is refused.
pub fn polygonize(samples: &Samples) -> Result<TriangleMesh, BaseError> {
    let cases = cube_cases();
    let layers = samples.grid.cells[2];
    let vertices: Vec<LayerVertices> =
        (0..=layers).into_par_iter().map(|k| layer_vertices(samples, k)).collect();
    let mut first = Vec::with_capacity(layers + 1);
    let mut mesh = TriangleMesh::default();
    for layer in &vertices {
        first.push(mesh.positions.len() as u32);
        mesh.positions.extend_from_slice(&layer.positions);
    }
    let layer_faces: Vec<Result<LayerFaces, BaseError>> = (0..layers)
        .into_par_iter()
        .map(|k| cell_faces(samples, &cases, k, [&vertices[k], &vertices[k + 1]], [first[k], first[k + 1]]))
        .collect();
    for layer in layer_faces {
        let layer = layer?;
        let first_center = mesh.positions.len() as u32;
        mesh.positions.extend_from_slice(&layer.centers);
        mesh.faces.extend(layer.faces.iter().map(|f| {
            f.map(|c| match c {
                Corner::Edge(v) => v,
                Corner::Center(i) => first_center + i,
            })
        }));
    }
    Ok(mesh)
}

/// Share of a grid edge at both of its ends where no vertex is put: it keeps triangles from collapsing when the
/// surface passes (nearly) through a node. Projection moves the vertices onto the surface anyway.
pub const END_GAP: f64 = 0.1;

/// Where f vanishes on an edge between values of different sign, as a share of its length.
fn crossing(f0: f64, f1: f64) -> f64 {
    let t = f0 / (f0 - f1);
    if t.is_finite() { t.clamp(END_GAP, 1.0 - END_GAP) } else { 0.5 }
}

fn layer_vertices(samples: &Samples, k: usize) -> LayerVertices {
    let grid = &samples.grid;
    let (nx, ny, nz) = (grid.nodes(0), grid.nodes(1), grid.nodes(2));
    let stride = [1, nx, nx * ny];
    let mut layer = LayerVertices { positions: Vec::new(), on_edge: vec![NONE; 3 * nx * ny] };
    for j in 0..ny {
        for i in 0..nx {
            let start = samples.index(i, j, k);
            let f0 = samples.values[start];
            let has_edge = [i + 1 < nx, j + 1 < ny, k + 1 < nz];
            for axis in 0..3 {
                if !has_edge[axis] {
                    continue;
                }
                let f1 = samples.values[start + stride[axis]];
                if (f0 < 0.0) == (f1 < 0.0) {
                    continue;
                }
                let mut p = grid.node(i, j, k);
                p[axis] += crossing(f0, f1) * grid.step;
                layer.on_edge[3 * (j * nx + i) + axis] = layer.positions.len() as u32;
                layer.positions.push(p);
            }
        }
    }
    layer
}

fn cell_faces(
    samples: &Samples,
    cases: &[CubeCase],
    k: usize,
    vertices: [&LayerVertices; 2],
    first: [u32; 2],
) -> Result<LayerFaces, BaseError> {
    let (nx, ny) = (samples.grid.nodes(0), samples.grid.nodes(1));
    let corner_offset: [usize; 8] = std::array::from_fn(|c| (c & 1) + (c >> 1 & 1) * nx + (c >> 2) * nx * ny);
    let mut out = LayerFaces::default();
    for j in 0..samples.grid.cells[1] {
        for i in 0..samples.grid.cells[0] {
            let start = samples.index(i, j, k);
            let corner = |c: usize| samples.values[start + corner_offset[c]];
            let inside = (0..8).fold(0, |bits, c| bits | usize::from(corner(c) < 0.0) << c);
            let case = &cases[inside];
            if case.triangles.is_empty() {
                continue;
            }
            if (0..8).any(|c| corner(c).is_nan()) {
                let undefined = samples.values.iter().filter(|f| f.is_nan()).count();
                let share = undefined as f64 / samples.values.len() as f64;
                return Err(BaseError::Undefined { share, at: Some(samples.grid.node(i, j, k)) });
            }
            let on_edge = |edge: u8| {
                let (axis, from) = (edge as usize / 4, edge_start(edge as usize));
                let node = (j + (from >> 1 & 1)) * nx + i + (from & 1);
                let layer = from >> 2;
                (layer, vertices[layer].on_edge[3 * node + axis])
            };
            let first_center = out.centers.len() as u32;
            for polygon in &case.centers {
                let sum: Point3 = polygon
                    .iter()
                    .map(|e| {
                        let (layer, v) = on_edge(*e);
                        vertices[layer].positions[v as usize]
                    })
                    .sum();
                out.centers.push(sum / polygon.len() as f64);
            }
            out.faces.extend(case.triangles.iter().map(|t| {
                t.map(|e| {
                    if e >= FIRST_CENTER {
                        return Corner::Center(first_center + u32::from(e - FIRST_CENTER));
                    }
                    let (layer, v) = on_edge(e);
                    Corner::Edge(first[layer] + v)
                })
            }));
        }
    }
    Ok(out)
}
