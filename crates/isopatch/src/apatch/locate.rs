//! Which cell of the hull a point is in, and which side of the mesh it is on.

use super::build::APatchFunction;
use super::shoot::{root, side_of};
use super::surface::APatchSurface;
use crate::geom::{Aabb, BoxTree, Mat3, Point3, Vec3};
use crate::hull::Side;
use crate::mesh::{EdgeId, FaceId};
use crate::surface::Volume;

/// A cell of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    Face(FaceId, Side),
    Edge(EdgeId, Side),
}

/// Boxes around the cells of a hull, and around the faces of its mesh.
#[derive(Debug)]
pub(super) struct CellTree {
    cells: Vec<Cell>,
    cell_boxes: BoxTree,
    face_boxes: BoxTree,
}

/// Barycentric coordinates down to this are inside a cell: neighbouring cells leave no gap between them.
const INSIDE: f64 = -1e-9;

impl CellTree {
    pub fn new(function: &APatchFunction) -> Self {
        let data = function.hull().data();
        let mesh = data.mesh();
        let of_faces = mesh.faces().flat_map(|f| Side::BOTH.map(|s| Cell::Face(f, s)));
        let of_edges = mesh.edges().flat_map(|e| Side::BOTH.map(|s| Cell::Edge(e, s)));
        let (cells, boxes): (Vec<Cell>, Vec<Aabb>) = of_faces
            .chain(of_edges)
            .filter_map(|cell| Some((cell, Aabb::around(&cell.corners(function)?))))
            .unzip();
        let faces: Vec<Aabb> = mesh.faces().map(|f| Aabb::around(&data.corners(f))).collect();
        Self { cells, cell_boxes: BoxTree::new(&boxes), face_boxes: BoxTree::new(&faces) }
    }

    /// The cell that holds the point, and its barycentric coordinates there; where cells overlap, the one it is deepest in.
    fn locate(&self, function: &APatchFunction, p: &Point3) -> Option<(Cell, [f64; 4])> {
        let mut best: Option<(f64, Cell, [f64; 4])> = None;
        self.cell_boxes.visit(
            |b| b.contains(p),
            |n| {
                let cell = self.cells[n];
                let Some(x) = cell.corners(function).and_then(|corners| barycentric(&corners, p)) else {
                    return;
                };
                let depth = x.iter().copied().fold(f64::INFINITY, f64::min);
                if depth >= INSIDE && best.is_none_or(|(deepest, ..)| depth > deepest) {
                    best = Some((depth, cell, x));
                }
            },
        );
        best.map(|(_, cell, x)| (cell, x))
    }

    /// How often the mesh winds around the point: crossings of a ray along +z, counted with sign.
    ///
    /// Faces that share an edge agree on which of them a ray close to it crosses, so that none is missed or counted twice.
    fn winding(&self, function: &APatchFunction, p: &Point3) -> i64 {
        let data = function.hull().data();
        let mut sum = 0;
        self.face_boxes.visit(
            |b| b.min.x <= p.x && p.x <= b.max.x && b.min.y <= p.y && p.y <= b.max.y && b.max.z >= p.z,
            |n| {
                let f = FaceId::from(n);
                let vertices = data.mesh().triangle(f).map(|v| v.0);
                let corners = data.corners(f).map(|q| q - p);
                let left = [0, 1, 2].map(|k: usize| {
                    let m = (k + 1) % 3;
                    let (a, b) = (corners[k], corners[m]);
                    // From the smaller to the larger vertex number, whichever face asks.
                    if vertices[k] < vertices[m] {
                        a.x * b.y - a.y * b.x >= 0.0
                    } else {
                        b.x * a.y - b.y * a.x < 0.0
                    }
                });
                if left[0] != left[1] || left[1] != left[2] {
                    return;
                }
                let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
                // Height of the plane over the point, times the third coordinate of the normal.
                if (normal.dot(&corners[0]) > 0.0) == (normal.z > 0.0) {
                    sum += if left[0] { 1 } else { -1 };
                }
            },
        );
        sum
    }
}

impl Cell {
    fn corners(self, function: &APatchFunction) -> Option<[Point3; 4]> {
        match self {
            Self::Face(f, side) => function.face_cell(f, side),
            Self::Edge(e, side) => function.edge_cell(e, side),
        }
    }

    /// Is the point with coordinates x in this cell behind the surface? By the parameter on its ray (docs/theory/apatch.md): the function
    /// has more zeros than the surface.
    fn is_inside(self, function: &APatchFunction, x: [f64; 4]) -> Option<bool> {
        let hull = function.hull();
        let (side, at, of_point) = match self {
            Self::Face(f, side) => {
                let sum = x[0] + x[1] + x[2];
                let class = hull.faces()[f.index()].class;
                let at = if sum > 0.0 {
                    let y = [x[0] / sum, x[1] / sum, x[2] / sum];
                    let (on, layers) = function.face_layers(f, y)?;
                    (on == side).then_some(root(class, &layers)?)
                } else {
                    // The apex itself.
                    Some(0.0)
                };
                (side, at, x[3])
            }
            Self::Edge(e, side) => {
                let (along, across) = (x[1] + x[2], x[0] + x[3]);
                let class = hull.edges()[e.index()].class;
                let edge = function.edge_function(e, side)?;
                let at = if along > 0.0 && across > 0.0 {
                    let layers = edge.layers(x[1] / along, x[2] / along, x[3] / across);
                    let on = side_of(class, side.sign() * layers[0]);
                    (on == side).then_some(root(class, &layers)?)
                } else {
                    Some(0.0)
                };
                (side, at, across)
            }
        };
        // On a side that the surface does not reach, the outer cell is all outside, the inner one all inside.
        let before = at.is_some_and(|t| of_point < t);
        Some(if side == Side::Outer { before } else { !before })
    }
}

fn barycentric(corners: &[Point3; 4], p: &Point3) -> Option<[f64; 4]> {
    let [a, b, c, d] = corners;
    let r = Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse()? * (p - a);
    Some([1.0 - r.sum(), r.x, r.y, r.z])
}

impl Volume for APatchSurface {
    fn value(&self, p: Point3) -> Option<(f64, Vec3)> {
        match self.tree().locate(self.function(), &p)? {
            (Cell::Face(f, side), x) => self.function().in_face_cell(f, side, x),
            (Cell::Edge(e, side), x) => self.function().in_edge_cell(e, side, x),
        }
    }

    /// In the hull by the function, outside of it by the base mesh.
    fn is_inside(&self, p: Point3) -> Option<bool> {
        if !self.function().hull().data().mesh().is_closed() {
            return None;
        }
        match self.tree().locate(self.function(), &p) {
            Some((cell, x)) => cell.is_inside(self.function(), x),
            None => Some(self.tree().winding(self.function(), &p) != 0),
        }
    }
}
