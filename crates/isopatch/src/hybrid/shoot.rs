//! Points of the surface: the smallest root on a ray, and what follows from it.

use super::crease::Pull;
use super::face::{FaceCells, Foot, in_triangle, sector_of};
use super::function::HybridFunction;
use crate::apatch::{Base, Shot, root, side_of};
use crate::geom::{Point3, Vec3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};
use crate::surface::Domain;

/// A ray that moves with the parameters (u, v).
struct Ray {
    foot: Point3,
    top: Point3,
    /// Derivatives of the foot and of the top by u and v.
    moves: [[Vec3; 2]; 2],
}

impl Ray {
    fn shot(&self, side: Side, t: f64, gradient: Vec3) -> Shot {
        let along = self.top - self.foot;
        let slope = gradient.dot(&along);
        // The point stays on the surface while the ray moves.
        let [du, dv] = [0, 1].map(|i| {
            let moved = (1.0 - t) * self.moves[0][i] + t * self.moves[1][i];
            moved - gradient.dot(&moved) / slope * along
        });
        Shot { side, t, point: self.foot + t * along, gradient, du, dv }
    }
}

/// From the center of a sector to the start and to the end of its edge.
const ACROSS: [[f64; 3]; 2] = [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];

/// A point with what a crease adds to it.
fn pulled(pull: &Pull, moves: [[f64; 3]; 2], shoot: impl Fn([[f64; 3]; 2]) -> Option<Shot>) -> Option<Shot> {
    let plain = shoot(moves)?;
    if pull.d == [Vec3::zeros(); 3] {
        return Some(plain);
    }
    let along = |d: [f64; 3]| d[0] * pull.d[0] + d[1] * pull.d[1] + d[2] * pull.d[2];
    let across = shoot(ACROSS)?;
    let normal = (across.du + along(ACROSS[0])).cross(&(across.dv + along(ACROSS[1])));
    Some(Shot {
        point: pull.exact.unwrap_or(plain.point + pull.by),
        gradient: plain.gradient.norm() * normal.normalize(),
        du: plain.du + along(moves[0]),
        dv: plain.dv + along(moves[1]),
        ..plain
    })
}

impl HybridFunction {
    /// The domain of the patch over a face: a triangle, the square of a pyramid, or a polygon in sectors.
    pub fn face_domain(&self, f: FaceId) -> Domain {
        match (&self.faces()[f.index()], self.corners(f).len()) {
            (FaceCells::Pyramid(_), _) => Domain::Square,
            (_, 3) => Domain::Triangle,
            // Seams number their edges by bytes as well.
            (_, n) => Domain::Polygon(u8::try_from(n).unwrap_or(u8::MAX)),
        }
    }

    /// The foot of the ray at parameters of the patch over a face, and the derivatives of its coordinates.
    pub fn foot(&self, f: FaceId, [u, v]: [f64; 2]) -> (Foot, [[f64; 3]; 2]) {
        let corners = self.corners(f);
        match (&self.faces()[f.index()], corners.first_chunk()) {
            // The first corner has s = t = 1, the second one s = 0.
            (FaceCells::Pyramid(_), _) => {
                (Foot::Pyramid([1.0 - u, 1.0 - v]), [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
            }
            (cells, Some(triangle)) if corners.len() == 3 => {
                let (x, d) = ([u, v, 1.0 - u - v], [[1.0, 0.0, -1.0], [0.0, 1.0, -1.0]]);
                let center = match cells {
                    FaceCells::Sectors(sectors) => &sectors.center,
                    FaceCells::Flat(center) => center,
                    FaceCells::Triangle { .. } | FaceCells::Pyramid(_) => return (Foot::Triangle(x), d),
                };
                let center = in_triangle(*triangle, center);
                let (k, in_sector) = sector_of(x, center);
                let (q, third) = ((k + 1) % 3, (k + 2) % 3);
                let moved = d.map(|d| {
                    let weight = d[third] / center[third];
                    [weight, d[k] - weight * center[k], d[q] - weight * center[q]]
                });
                (Foot::Sector(k, in_sector), moved)
            }
            _ => {
                let k = u.floor().clamp(0.0, corners.len() as f64 - 1.0);
                let w = u - k;
                let r = 1.0 - v;
                (Foot::Sector(k as usize, [v, r * (1.0 - w), r * w]), [[0.0, -r, r], [1.0, w - 1.0, -w]])
            }
        }
    }

    /// Barycentric coordinates of c in a face with three corners.
    pub(super) fn center_in_triangle(&self, f: FaceId, center: &Point3) -> [f64; 3] {
        self.corners(f).first_chunk().map_or([f64::NAN; 3], |corners| in_triangle(*corners, center))
    }

    /// The layers over a point of a face on the side where the surface is: that side, and B_0 … B_3. None for a flat face.
    pub fn face_layers(&self, f: FaceId, uv: [f64; 2]) -> Option<(Side, [f64; 4])> {
        self.faces()[f.index()].layers(self.hull().faces[f.index()].class, self.foot(f, uv).0)
    }

    /// The point of the patch over a face, at parameters of its domain. None if the ray has no root.
    pub fn shoot_face(&self, f: FaceId, uv: [f64; 2]) -> Option<Shot> {
        let (foot, moves) = self.foot(f, uv);
        self.shoot_from(f, foot, moves)
    }

    /// The point of the patch over a face on the ray from a foot; du and dv are by what moves the coordinates of the foot as given.
    pub fn shoot_from(&self, f: FaceId, foot: Foot, moves: [[f64; 3]; 2]) -> Option<Shot> {
        if let Foot::Sector(k, x) = foot
            && let Some(sector) = self.pulls(f, k)
        {
            return pulled(&sector.at(x)?, moves, |moves| self.shoot_plain(f, foot, moves));
        }
        self.shoot_plain(f, foot, moves)
    }

    /// The zero set, before creases pull at it.
    fn shoot_plain(&self, f: FaceId, foot: Foot, moves: [[f64; 3]; 2]) -> Option<Shot> {
        let (cells, face, corners) =
            (&self.faces()[f.index()], &self.hull().faces[f.index()], self.corners(f));
        let (point, by_foot) = cells.point(corners, foot)?;
        let [du, dv] = moves.map(|d| d[0] * by_foot[0] + d[1] * by_foot[1] + d[2] * by_foot[2]);
        if let FaceCells::Flat(_) = cells {
            let gradient = self.flat_normal(f, foot);
            return Some(Shot { side: Side::Outer, t: 0.0, point, gradient, du, dv });
        }
        let (side, t) = cells.root(face.class, foot)?;
        let apex = face.apexes[side.index()].as_ref()?;
        let (_, gradient) = cells.value(corners, apex, side, foot, t)?;
        let ray = Ray { foot: point, top: *apex, moves: [[du, dv], [Vec3::zeros(); 2]] };
        Some(ray.shot(side, t, gradient))
    }

    /// Unit normal of a face that is its own patch.
    fn flat_normal(&self, f: FaceId, foot: Foot) -> Vec3 {
        let (corners, face) = (self.corners(f), &self.hull().faces[f.index()]);
        let of = |a: &Vec3, b: &Vec3, c: &Vec3| (b - a).cross(&(c - a)).try_normalize(0.0);
        let found = match foot {
            Foot::Sector(k, _) => {
                let next = if k + 1 == corners.len() { 0 } else { k + 1 };
                of(&face.center, &corners[k], &corners[next])
            }
            Foot::Triangle(_) | Foot::Pyramid(_) => of(&corners[0], &corners[1], &corners[2]),
        };
        found.unwrap_or(face.normal)
    }

    /// Does a patch stand over the edge? Not over one that is straight, a crease or a boundary.
    pub fn has_edge_patch(&self, e: EdgeId) -> bool {
        let cells = Side::BOTH.into_iter().any(|side| self.edge_function(e, side).is_some());
        cells && self.hull().edges[e.index()].class != Class::Zero
    }

    /// The point of the patch over an edge: x is the weight of its start, z = 1 − x that of its end, y that of the left apex.
    /// du is along the edge, dv from the right face to the left one. None without an edge cell or a root.
    pub fn shoot_edge(&self, e: EdgeId, [x, z]: [f64; 2], y: f64) -> Option<Shot> {
        let class = self.hull().edges[e.index()].class;
        let side = side_of(class, Base::on_edge(self.on_edge(e), x, z));
        let function = self.edge_function(e, side)?;
        let t = root(class, &function.layers(x, z, y))?;
        let [u_l, p_i, p_j, u_k] = self.edge_cell(e, side)?;
        let at = [t * (1.0 - y), (1.0 - t) * x, (1.0 - t) * z, t * y];
        let (_, gradient) = self.in_edge_cell(e, side, at)?;
        let ray = Ray {
            foot: x * p_i + z * p_j,
            top: (1.0 - y) * u_l + y * u_k,
            moves: [[p_j - p_i, Vec3::zeros()], [Vec3::zeros(), u_k - u_l]],
        };
        Some(ray.shot(side, t, gradient))
    }
}
