//! Which cell of the hull a point is in, and which side of the surface it is on.

use super::face::{FaceCells, Foot};
use super::function::HybridFunction;
use super::pyramid::PyramidCell;
use super::surface::HybridSurface;
use super::tetra::barycentric;
use crate::apatch::{root, side_of};
use crate::geom::{Aabb, BoxTree, Point3, Vec3};
use crate::hull::Side;
use crate::mesh::{EdgeId, FaceId};
use crate::surface::Volume;

/// A cell of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    /// Of a face, on a side; of a polygon in sectors, with the number of the sector.
    Face(FaceId, Side, usize),
    Edge(EdgeId, Side),
}

/// A triangle of the base mesh, with numbers for its corners that neighbours share.
#[derive(Clone, Copy, Debug)]
struct BaseTriangle {
    names: [u32; 3],
    corners: [Point3; 3],
}

/// Boxes around the cells of a hull, and around the base mesh in triangles.
#[derive(Debug)]
pub(super) struct CellTree {
    cells: Vec<Cell>,
    cell_boxes: BoxTree,
    triangles: Vec<BaseTriangle>,
    triangle_boxes: BoxTree,
    /// Corners of the bases of pyramids: ruled surfaces, where the triangles are two flat ones.
    ruled: Vec<[Point3; 4]>,
    ruled_boxes: BoxTree,
}

/// Coordinates down to this are inside a cell: neighbouring cells leave no gap between them.
const INSIDE: f64 = -1e-9;

/// Where a point is in a cell: the foot of its ray and the parameter on it, or barycentric coordinates in the cell of an edge.
#[derive(Clone, Copy, Debug)]
enum At {
    Ray(Foot, f64),
    Edge([f64; 4]),
}

impl CellTree {
    pub fn new(function: &HybridFunction) -> Self {
        let data = &function.hull().data;
        let mesh = data.mesh();
        let (mut cells, mut triangles, mut ruled) = (Vec::new(), Vec::new(), Vec::new());
        for f in mesh.faces() {
            let (cells_of_face, corners) = (&function.faces()[f.index()], function.corners(f));
            let sectors =
                if let FaceCells::Sectors(sectors) = cells_of_face { sectors.base.len() } else { 1 };
            for side in Side::BOTH.into_iter().filter(|side| cells_of_face.has(*side)) {
                cells.extend((0..sectors).map(|k| Cell::Face(f, side, k)));
            }
            let names: Vec<u32> = mesh.face_vertices(f).map(|v| v.0).collect();
            let mut add =
                |names: [u32; 3], corners: [Point3; 3]| triangles.push(BaseTriangle { names, corners });
            match (cells_of_face, corners.len()) {
                (FaceCells::Triangle { .. } | FaceCells::Pyramid(_), _) | (FaceCells::Flat(_), 3) => {
                    for k in 2..corners.len() {
                        add([names[0], names[k - 1], names[k]], [corners[0], corners[k - 1], corners[k]]);
                    }
                }
                (FaceCells::Sectors(_) | FaceCells::Flat(_), n) => {
                    let center = function.hull().faces[f.index()].center;
                    let own = mesh.vertex_count() as u32 + f.0;
                    for k in 0..n {
                        let next = if k + 1 == n { 0 } else { k + 1 };
                        add([own, names[k], names[next]], [center, corners[k], corners[next]]);
                    }
                }
            }
            if let (FaceCells::Pyramid(_), Some(quadrilateral)) = (cells_of_face, corners.first_chunk()) {
                ruled.push(*quadrilateral);
            }
        }
        cells.extend(mesh.edges().flat_map(|e| {
            let has_cell = move |side: &Side| function.edge_function(e, *side).is_some();
            Side::BOTH.into_iter().filter(has_cell).map(move |side| Cell::Edge(e, side))
        }));
        let boxes: Vec<Aabb> = cells.iter().map(|cell| Aabb::around(&cell.corners(function))).collect();
        let triangle_boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::around(&t.corners)).collect();
        let ruled_boxes: Vec<Aabb> = ruled.iter().map(|p: &[Point3; 4]| Aabb::around(p)).collect();
        Self {
            cells,
            cell_boxes: BoxTree::new(&boxes),
            triangles,
            triangle_boxes: BoxTree::new(&triangle_boxes),
            ruled,
            ruled_boxes: BoxTree::new(&ruled_boxes),
        }
    }

    /// The cell that holds the point, and where in it; where cells overlap, the one it is deepest in.
    fn locate(&self, function: &HybridFunction, p: &Point3) -> Option<(Cell, At)> {
        let mut best: Option<(f64, Cell, At)> = None;
        self.cell_boxes.visit(
            |b| b.contains(p),
            |n| {
                let cell = self.cells[n];
                let Some((depth, at)) = cell.holds(function, p) else { return };
                if depth >= INSIDE && best.as_ref().is_none_or(|(deepest, ..)| depth > *deepest) {
                    best = Some((depth, cell, at));
                }
            },
        );
        best.map(|(_, cell, at)| (cell, at))
    }

    /// How often the mesh winds around the point: crossings of a ray along +z, counted with sign.
    ///
    /// Triangles that share an edge agree on which of them a ray close to it crosses, so that none is missed or counted twice.
    fn winding(&self, p: &Point3) -> i64 {
        let mut sum = 0;
        self.triangle_boxes.visit(
            |b| b.min.x <= p.x && p.x <= b.max.x && b.min.y <= p.y && p.y <= b.max.y && b.max.z >= p.z,
            |n| {
                let BaseTriangle { names, corners } = self.triangles[n];
                let corners = corners.map(|q| q - p);
                let left = [0, 1, 2].map(|k: usize| {
                    let m = (k + 1) % 3;
                    let (a, b) = (corners[k], corners[m]);
                    // From the smaller to the larger number, whichever triangle asks.
                    if names[k] < names[m] {
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

    /// Is the point between the base of a pyramid and the two triangles that stand for it in [`Self::winding`]?
    ///
    /// In barycentric coordinates of [P_1 P_2 P_3 P_4] the base is x_1 x_3 = x_2 x_4, and the triangles meet in P_1 P_3.
    fn is_behind_ruled_base(&self, p: &Point3) -> bool {
        let mut odd = false;
        self.ruled_boxes.visit(
            |b| b.contains(p),
            |n| {
                let x = barycentric(self.ruled[n], p);
                let inside = x.iter().all(|x| *x > 0.0);
                odd ^= inside && x[0] * x[2] > x[1] * x[3];
            },
        );
        odd
    }
}

impl PyramidCell {
    /// (u, s, t) of a point: where the line from the apex through it meets the base.
    fn locate(&self, p: &Point3) -> Option<[f64; 3]> {
        let d = p - self.apex;
        let first = if d.x.abs() < d.y.abs().max(d.z.abs()) { Vec3::x() } else { Vec3::y() };
        let across = d.cross(&first);
        let [p1, p2, p3, p4] = self.corners;
        // Both of a + b s + c t + d s t vanish on the line.
        let form = |e: Vec3| {
            let constant = e.dot(&(p4 - self.apex));
            [constant, e.dot(&(p3 - p4)), e.dot(&(p2 - p4)), e.dot(&(p1 - p2 - p3 + p4))]
        };
        let ([a0, b0, c0, d0], [a1, b1, c1, d1]) = (form(across), form(d.cross(&across)));
        // Without t: (a1 + b1 s)(c0 + d0 s) = (a0 + b0 s)(c1 + d1 s).
        let constant = a1 * c0 - a0 * c1;
        let half = 0.5 * (a1 * d0 + b1 * c0 - a0 * d1 - b0 * c1);
        let square = b1 * d0 - b0 * d1;
        let root = (half * half - square * constant).max(0.0).sqrt();
        let w = -(half + root.copysign(half));
        let candidates = [constant / w, w / square];
        let at = |s: f64| {
            // The larger denominator has the digits.
            let (n, m) = (c0 + d0 * s, c1 + d1 * s);
            let t = if n.abs() > m.abs() { -(a0 + b0 * s) / n } else { -(a1 + b1 * s) / m };
            let towards = self.foot(s, t).0 - self.apex;
            [1.0 - d.norm_squared() / towards.dot(&d), s, t]
        };
        let found = candidates.into_iter().filter(|s| s.is_finite()).map(at);
        found.filter(|x| x.iter().all(|x| x.is_finite())).max_by(|a, b| depth(a).total_cmp(&depth(b)))
    }
}

/// How far (u, s, t) is from the nearest side of the pyramid.
fn depth([u, s, t]: &[f64; 3]) -> f64 {
    [*u, 1.0 - u, *s, 1.0 - s, *t, 1.0 - t].into_iter().fold(f64::INFINITY, f64::min)
}

impl Cell {
    fn corners(self, function: &HybridFunction) -> Vec<Point3> {
        match self {
            Self::Face(f, side, k) => {
                let (cells, mut corners) = (&function.faces()[f.index()], function.corners(f).to_vec());
                if let FaceCells::Sectors(sectors) = cells {
                    let next = if k + 1 == corners.len() { 0 } else { k + 1 };
                    corners = vec![sectors.center, corners[k], corners[next]];
                }
                corners.extend(function.hull().faces[f.index()].apexes[side.index()]);
                corners
            }
            Self::Edge(e, side) => function.edge_cell(e, side).map_or_else(Vec::new, |c| c.to_vec()),
        }
    }

    /// Where the point is in this cell, and how deep: negative if it is not.
    fn holds(self, function: &HybridFunction, p: &Point3) -> Option<(f64, At)> {
        if let Self::Face(f, ..) = self
            && let FaceCells::Pyramid(cell) = &function.faces()[f.index()]
        {
            let x = cell.locate(p)?;
            return Some((depth(&x), At::Ray(Foot::Pyramid([x[1], x[2]]), x[0])));
        }
        let corners: [Point3; 4] = self.corners(function).try_into().ok()?;
        let x = barycentric(corners, p);
        let depth = x.iter().copied().fold(f64::INFINITY, f64::min);
        if depth.is_nan() {
            return None;
        }
        let at = match self {
            Self::Edge(..) => At::Edge(x),
            Self::Face(f, _, k) => {
                // The corners of the base come first. At the apex any foot will do.
                let sum = x[0] + x[1] + x[2];
                let y = if sum > 0.0 { [x[0] / sum, x[1] / sum, x[2] / sum] } else { [1.0, 0.0, 0.0] };
                let in_sectors = matches!(function.faces()[f.index()], FaceCells::Sectors(_));
                At::Ray(if in_sectors { Foot::Sector(k, y) } else { Foot::Triangle(y) }, x[3])
            }
        };
        Some((depth, at))
    }

    /// Is the point behind the surface? By the parameter on its ray: the function has more zeros than the surface.
    fn is_inside(self, function: &HybridFunction, at: At) -> Option<bool> {
        let hull = function.hull();
        let (side, root, of_point) = match (self, at) {
            (Self::Face(f, side, _), At::Ray(foot, t)) => {
                let (on, root) = function.faces()[f.index()].root(hull.faces[f.index()].class, foot)?;
                (side, (on == side).then_some(root), t)
            }
            (Self::Edge(e, side), At::Edge(x)) => {
                let (along, across) = (x[1] + x[2], x[0] + x[3]);
                let class = hull.edges[e.index()].class;
                let edge = function.edge_function(e, side)?;
                let at = if along > 0.0 && across > 0.0 {
                    let layers = edge.layers(x[1] / along, x[2] / along, x[3] / across);
                    let on = side_of(class, side.sign() * layers[0]);
                    if on == side { Some(root(class, &layers)?) } else { None }
                } else {
                    Some(0.0)
                };
                (side, at, across)
            }
            _ => return None,
        };
        // On a side that the surface does not reach, the outer cell is all outside, the inner one all inside.
        let before = root.is_some_and(|t| of_point < t);
        Some(if side == Side::Outer { before } else { !before })
    }
}

impl Volume for HybridSurface {
    fn value(&self, p: Point3) -> Option<(f64, Vec3)> {
        match self.tree().locate(self.function(), &p)? {
            (Cell::Face(f, side, _), At::Ray(foot, t)) => self.function().in_face_cell(f, side, foot, t),
            (Cell::Edge(e, side), At::Edge(x)) => self.function().in_edge_cell(e, side, x),
            _ => None,
        }
    }

    /// In the hull by the function, outside of it by the base mesh.
    fn is_inside(&self, p: Point3) -> Option<bool> {
        if !self.function().hull().data.mesh().is_closed() {
            return None;
        }
        match self.tree().locate(self.function(), &p) {
            Some((cell, at)) => cell.is_inside(self.function(), at),
            None => Some((self.tree().winding(&p) != 0) ^ self.tree().is_behind_ruled_base(&p)),
        }
    }
}
