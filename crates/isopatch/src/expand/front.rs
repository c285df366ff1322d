//! The front of an expansion: triangles so far, the directed edges where they end, and where a next one fits.
//!
//! ```text
//!            c            The front edge a → b has triangles on its right and nothing yet on its left. A triangle a b c
//!           / \           takes it off the front; b → c and c → a leave it if the front has their opposites, else their
//!          /   \          opposites c → b and a → c join it. So fronts split and merge by themselves, and no edge gets
//!    ─── a ───► b ───     more than one triangle on a side.
//! ```

use super::plane::{Plane, crosses, distance_to_segment, shape};
use super::sheet::Sheet;
use super::walls::Walls;
use crate::geom::{Point3, Vec3, angle_between};
use std::collections::{BTreeMap, BTreeSet};

/// A vertex.
#[derive(Clone, Debug)]
pub(super) struct Vertex {
    pub at: Point3,
    /// Unit normal; none on walls, where there may be several.
    pub normal: Option<Vec3>,
    /// Sides of the box, one bit each.
    pub sides: u8,
}

/// An edge of the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrontEdge {
    /// The normal of the surface at the triangle on its right.
    pub normal: Vec3,
    /// The expansion point of that triangle.
    pub center: Point3,
}

/// A directed edge, by its vertices.
pub(super) type Directed = (u32, u32);

pub(super) struct Front<'a> {
    pub sheet: &'a Sheet<'a>,
    pub walls: &'a Walls,
    /// The points of the walls come first, with their numbers.
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    pub edges: BTreeMap<Directed, FrontEdge>,
    /// Vertices that must be met: where the surface goes through the edges of the box.
    anchors: Vec<u32>,
    /// Directed edges of triangles.
    used: BTreeSet<Directed>,
}

/// What a triangle must keep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    /// Least shape: 1 for an equilateral triangle, 0 for a flat one.
    pub shape: f64,
    /// Least distance of a new vertex from what is there, relative to the reach.
    pub clearance: f64,
    /// How far from the surface the middle of an edge or a triangle may be, relative to its length.
    pub bulge: f64,
    /// Least product of the normal of a triangle with those of its corners.
    pub facing: f64,
}

/// The usual demand.
pub(super) const GOOD: Demand = Demand { shape: 0.3, clearance: 0.45, bulge: 0.2, facing: 0.5 };
/// What is accepted where nothing better fits.
pub(super) const FAIR: Demand = Demand { shape: 0.1, clearance: 0.25, bulge: 0.2, facing: 0.35 };
/// What is accepted in the end, to close a gap.
pub(super) const POOR: Demand = Demand { shape: 0.005, clearance: 0.1, bulge: 0.3, facing: 0.1 };

/// Normals of one sheet nearby have at least this product.
const SAME_SHEET: f64 = 0.1;
/// How far from the P-plane something may be to count as the same sheet: a part of the reach, and a part of how far away
/// it is.
const THIN: f64 = 0.1;
const SLOPE: f64 = 0.6;
/// A new vertex this near to the border, in units of the reach, is put on it.
const BORDER: f64 = 0.3;
/// Points this near to each other, relative to the diagonal, are one.
const SAME_PLACE: f64 = 1e-9;
/// New vertices are at least this far from a wall, in lengths of its segments.
const FREE: f64 = 0.5;
/// Two edges at a vertex are at least at this angle, in radians.
const LEAST_ANGLE: f64 = 0.1;

impl<'a> Front<'a> {
    pub fn new(sheet: &'a Sheet<'a>, walls: &'a Walls) -> Self {
        let vertex = |p: &Point3| Vertex { at: *p, normal: None, sides: sheet.sides(p) };
        let mut vertices: Vec<Vertex> = walls.points.iter().map(vertex).collect();
        let first = vertices.len() as u32;
        let reach = SAME_PLACE * sheet.bounds.diagonal();
        let is_new = |p: &Point3| walls.points.iter().all(|w| (w - p).norm() > reach);
        vertices.extend(
            sheet
                .on_box_edges()
                .into_iter()
                .filter(is_new)
                .map(|p| Vertex { normal: sheet.normal(p), ..vertex(&p) }),
        );
        Self {
            sheet,
            walls,
            anchors: (first..vertices.len() as u32).collect(),
            vertices,
            triangles: Vec::new(),
            edges: BTreeMap::new(),
            used: BTreeSet::new(),
        }
    }

    pub fn at(&self, v: u32) -> Point3 {
        self.vertices[v as usize].at
    }

    pub fn length(&self, (a, b): Directed) -> f64 {
        (self.at(b) - self.at(a)).norm()
    }

    pub fn normal(&self, v: u32) -> Option<Vec3> {
        self.vertices[v as usize].normal
    }

    pub fn is_wall(&self, v: u32) -> bool {
        (v as usize) < self.walls.points.len()
    }

    /// The tangent plane at an edge of the front, with X along it and Y to its left.
    pub fn plane(&self, (a, b): Directed, edge: &FrontEdge) -> Plane {
        let middle = (self.at(a) + self.at(b)) / 2.0;
        let there = self.sheet.foot(middle).and_then(|p| self.sheet.normal(p));
        let normal = there.filter(|n| n.dot(&edge.normal) > SAME_SHEET).unwrap_or(edge.normal);
        Plane::new(middle, self.at(b) - self.at(a), normal)
    }

    /// Puts a triangle on an edge of the front, if one fits: to one of the `preferred` vertices, to a vertex near the
    /// `ideal` point, to the ideal point itself, or to any vertex within reach.
    pub fn attach(
        &mut self,
        edge: Directed,
        ideal: Option<Point3>,
        reach: f64,
        preferred: &[u32],
        demand: Demand,
    ) -> Option<u32> {
        let front = *self.edges.get(&edge)?;
        let plane = self.plane(edge, &front);
        let reach = reach.max(self.reach_of_walls(&plane.origin(), reach));
        let around = self.around(&plane, &front, reach);
        let (a, b) = edge;
        let target = ideal.unwrap_or(plane.origin());
        let mut near: Vec<u32> = around.points.iter().copied().filter(|c| *c != a && *c != b).collect();
        let from = |c: &u32| (self.at(*c) - target).norm();
        near.sort_by(|c, d| from(c).total_cmp(&from(d)).then(c.cmp(d)));
        let close = near.partition_point(|c| from(c) < demand.clearance * reach);
        let first = preferred.iter().chain(&near[..if ideal.is_some() { close } else { near.len() }]);
        let fits = |c: &&u32| self.fits(edge, **c, &plane, &front, &around, demand);
        if let Some(c) = first.copied().find(|c| fits(&c)) {
            self.add(edge, c, &front);
            return Some(c);
        }
        let fresh = ideal.and_then(|p| self.fresh(edge, p, reach, &plane, &front, &around, demand));
        if let Some(vertex) = fresh {
            self.vertices.push(vertex);
            let c = self.vertices.len() as u32 - 1;
            self.add(edge, c, &front);
            return Some(c);
        }
        let c = near[close.min(near.len())..].iter().find(fits).copied()?;
        self.add(edge, c, &front);
        Some(c)
    }

    /// The longest segment of a wall near a point, as far as triangles to it must reach.
    fn reach_of_walls(&self, p: &Point3, reach: f64) -> f64 {
        let lengths = self.walls.segments.iter().filter_map(|[a, b]| {
            let ends = [self.at(*a), self.at(*b)];
            let length = (ends[1] - ends[0]).norm();
            (distance_to_segment(p, &ends) < FREE * length + reach).then_some(length)
        });
        lengths.fold(0.0, f64::max)
    }

    /// Is a new vertex far enough from the walls for triangles of a good shape between?
    fn is_clear_of_walls(&self, p: &Point3, step: f64) -> bool {
        let segments = &self.walls.segments;
        segments.iter().all(|[a, b]| {
            let ends = [self.at(*a), self.at(*b)];
            distance_to_segment(p, &ends) > FREE * (ends[1] - ends[0]).norm()
        }) && self.walls.points.iter().all(|w| (w - p).norm() > FREE * step)
    }

    /// The same for the edge of a wall, where a new vertex may be as near to that as it must be.
    pub fn attach_beside_wall(
        &mut self,
        edge: Directed,
        ideal: Point3,
        length: f64,
        demand: Demand,
    ) -> Option<u32> {
        self.attach(edge, Some(ideal), length, &[], demand)
    }

    /// The third corners of the triangles on a segment of a wall.
    pub fn thirds(&self, a: u32, b: u32) -> Vec<u32> {
        let on_it = self.triangles.iter().filter(|t| t.contains(&a) && t.contains(&b));
        on_it.flat_map(|t| t.iter().copied().filter(|v| *v != a && *v != b)).collect()
    }

    /// A new vertex at the ideal point, where it is clear of everything there.
    fn fresh(
        &self,
        edge: Directed,
        p: Point3,
        reach: f64,
        plane: &Plane,
        front: &FrontEdge,
        around: &Around,
        demand: Demand,
    ) -> Option<Vertex> {
        let p = match self.sheet.is_outside(&p) {
            true => self.sheet.clip(&plane.origin(), &p, 0.0)?,
            false => self.sheet.clip(&plane.origin(), &p, BORDER * reach).unwrap_or(p),
        };
        let vertex = Vertex { at: p, normal: Some(self.sheet.normal(p)?), sides: self.sheet.sides(&p) };
        let q = plane.project(&p);
        let is_clear = self.is_clear_of_walls(&p, reach)
            && around.points.iter().filter(|c| **c != edge.0 && **c != edge.1).all(|c| {
                let there = plane.project(&self.at(*c));
                (there - q).norm() > demand.clearance * reach
            })
            && around.edges.iter().filter(|e| **e != edge).all(|(u, v)| {
                let ends = [*u, *v].map(|v| plane.project(&self.at(v)));
                distance_to_segment(&q, &ends) > 0.5 * demand.clearance * reach
            });
        (is_clear && self.fits_at(edge, None, &vertex, plane, front, around, demand)).then_some(vertex)
    }

    fn fits(
        &self,
        edge: Directed,
        c: u32,
        plane: &Plane,
        front: &FrontEdge,
        around: &Around,
        demand: Demand,
    ) -> bool {
        let (a, b) = edge;
        // Several sheets may end in a segment of a wall from the same side.
        let is_used =
            |u, v| self.used.contains(&(u, v)) && !(self.is_wall(u) && self.walls.has_segment(u, v));
        let is_free = |u, v| !is_used(u, v) && !self.is_shortcut(u, v);
        c != a
            && c != b
            && is_free(b, c)
            && is_free(c, a)
            && self.fits_at(edge, Some(c), &self.vertices[c as usize], plane, front, around, demand)
    }

    /// Does an edge between points of walls pass by a segment that would have to be there?
    fn is_shortcut(&self, u: u32, v: u32) -> bool {
        if !(self.is_wall(u) && self.is_wall(v)) || self.walls.has_segment(u, v) {
            return false;
        }
        let (p, q) = (self.at(u), self.at(v));
        let middle = (p + q) / 2.0;
        let length = (q - p).norm();
        self.walls
            .segments
            .iter()
            .any(|[a, b]| distance_to_segment(&middle, &[self.at(*a), self.at(*b)]) < SHORTCUT * length)
    }

    fn fits_at(
        &self,
        (a, b): Directed,
        number: Option<u32>,
        vertex: &Vertex,
        plane: &Plane,
        front: &FrontEdge,
        around: &Around,
        demand: Demand,
    ) -> bool {
        let corners = [self.at(a), self.at(b), vertex.at];
        let [p, q, r] = corners.map(|p| plane.project(&p));
        if r.y <= 0.0 || shape(&p, &q, &r) < demand.shape {
            return false;
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        let normals = [self.normal(a), self.normal(b), vertex.normal];
        if normals.iter().flatten().any(|n| n.dot(&normal) < demand.facing)
            || normal.dot(&front.normal) < SAME_SHEET
        {
            return false;
        }
        // The gradient vanishes on walls, and says nothing in the middle of their segments.
        let leaves = |end| !number.is_some_and(|c| self.is_wall(c) && self.walls.has_segment(end, c));
        if !self.is_on_sheet(&corners, &normal, [leaves(a), leaves(b)], demand.bulge) {
            return false;
        }
        let is_corner = |v: u32| v == a || v == b || Some(v) == number;
        // Nothing inside.
        let inside = |v: &u32| {
            let s = plane.project(&self.at(*v));
            [(p, q), (q, r), (r, p)]
                .iter()
                .all(|(u, v)| (v - u).xy().perp(&(s - u).xy()) > -1e-3 * (v - u).norm_squared())
        };
        if around.points.iter().any(|v| !is_corner(*v) && inside(v)) {
            return false;
        }
        // No edge through the new ones.
        let sides = [(a, p), (b, q)];
        // What leaves for another sheet is only narrow in the projection.
        let near = |v: u32| around.points.contains(&v);
        !around.edges.iter().any(|(u, v)| {
            let ends = [*u, *v].map(|v| plane.project(&self.at(v)));
            sides.iter().any(|(end, from)| {
                if Some(*u) == number || Some(*v) == number {
                    let other = if Some(*u) == number { (*v, ends[1]) } else { (*u, ends[0]) };
                    other.0 != a && other.0 != b && near(other.0) && is_narrow(&r, from, &other.1)
                } else if u == end || v == end {
                    let other = if u == end { (*v, ends[1]) } else { (*u, ends[0]) };
                    !is_corner(other.0) && near(other.0) && is_narrow(from, &r, &other.1)
                } else {
                    crosses(from, &r, &ends[0], &ends[1])
                }
            })
        })
    }

    /// Are the middles of the triangle and of those new edges that leave the walls near the surface, with its normals?
    fn is_on_sheet(&self, [a, b, c]: &[Point3; 3], normal: &Vec3, leave: [bool; 2], bulge: f64) -> bool {
        let probes = [((a + c) / 2.0, leave[0]), ((b + c) / 2.0, leave[1]), ((a + b + c) / 3.0, true)];
        let size = (c - a).norm().max((c - b).norm());
        probes.iter().filter(|(_, counts)| *counts).all(|(p, _)| {
            self.sheet.foot(*p).is_some_and(|foot| {
                let faces = self.sheet.normal(foot).is_none_or(|n| n.dot(normal) > SAME_SHEET);
                faces && (foot - p).norm() < bulge * size
            })
        })
    }

    /// The front and the walls near an edge.
    fn around(&self, plane: &Plane, front: &FrontEdge, reach: f64) -> Around {
        let near = |v: u32| {
            let p = plane.project(&self.at(v));
            let faces = self.normal(v).is_none_or(|n| n.dot(&front.normal) > SAME_SHEET);
            let away = p.xy().norm();
            faces && p.z.abs() < THIN * reach + SLOPE * away && away < FAR * reach
        };
        let edges: Vec<Directed> = self
            .edges
            .keys()
            .copied()
            .chain(self.walls.segments.iter().map(|[a, b]| (*a, *b)))
            .filter(|(a, b)| {
                let z = |v: u32| plane.project(&self.at(v)).z.abs();
                near(*a) && z(*b) < FAR * reach || near(*b) && z(*a) < FAR * reach
            })
            .collect();
        let mut points: BTreeSet<u32> =
            edges.iter().flat_map(|(a, b)| [*a, *b]).filter(|v| near(*v)).collect();
        points.extend(
            (0..self.walls.points.len() as u32).chain(self.anchors.iter().copied()).filter(|v| near(*v)),
        );
        Around { points, edges }
    }

    /// Adds a first triangle or one on an edge of the front.
    fn add(&mut self, (a, b): Directed, c: u32, front: &FrontEdge) {
        let center = front.center;
        self.add_triangle([a, b, c], center);
    }

    /// Adds a triangle, and lets the front pass over it.
    pub fn add_triangle(&mut self, triangle: [u32; 3], center: Point3) {
        let [a, b, c] = triangle.map(|v| self.at(v));
        let normal = (b - a).cross(&(c - a)).normalize();
        let own: Vec<Vec3> = triangle.iter().filter_map(|v| self.normal(*v)).collect();
        let mean = own.iter().sum::<Vec3>().try_normalize(0.0).unwrap_or(normal);
        self.triangles.push(triangle);
        for k in 0..3 {
            let (u, v) = (triangle[k], triangle[(k + 1) % 3]);
            self.used.insert((u, v));
            if self.edges.remove(&(u, v)).is_none() && !self.is_end((u, v), &normal) {
                self.edges.insert((v, u), FrontEdge { normal: mean, center });
            }
        }
    }

    /// Takes away the triangles at the vertices of the front, but those that end in a segment of a wall, so that the place can
    /// be triangulated anew.
    pub fn reopen(&mut self) {
        let open: BTreeSet<u32> = self.edges.keys().flat_map(|(a, b)| [*a, *b]).collect();
        let sides = |t: &[u32; 3]| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3]));
        let (walls, triangles) = (self.walls, std::mem::take(&mut self.triangles));
        let is_held = |t: &[u32; 3]| sides(t).iter().any(|(u, v)| walls.has_segment(*u, *v));
        let (gone, kept): (Vec<[u32; 3]>, Vec<[u32; 3]>) = triangles
            .into_iter()
            .partition(|t| t.iter().any(|v| open.contains(v) && !self.is_wall(*v)) && !is_held(t));
        self.triangles = kept;
        let before = std::mem::take(&mut self.edges);
        for t in &gone {
            sides(t).iter().for_each(|side| {
                self.used.remove(side);
            });
        }
        for t in &gone {
            let [a, b, c] = t.map(|v| self.at(v));
            let normal = (b - a).cross(&(c - a)).normalize();
            for (u, v) in sides(t) {
                if self.used.contains(&(v, u)) {
                    self.edges.insert((u, v), FrontEdge { normal, center: (a + b + c) / 3.0 });
                }
            }
        }
        // Edges of the front that were there stay if their triangles do.
        let stays = |(a, b): &Directed| self.used.contains(&(*b, *a));
        let kept: Vec<_> = before.into_iter().filter(|(e, _)| stays(e)).collect();
        self.edges.extend(kept);
    }

    /// Does the surface end at the edge u → v of a triangle: in a wall, or in a side of the box?
    fn is_end(&self, (u, v): Directed, normal: &Vec3) -> bool {
        if self.is_wall(u) && self.is_wall(v) && self.walls.has_segment(u, v) {
            return true;
        }
        if self.vertices[u as usize].sides & self.vertices[v as usize].sides == 0 {
            return false;
        }
        let along = self.at(v) - self.at(u);
        let outward = along.cross(normal);
        self.sheet.is_outside(&((self.at(u) + self.at(v)) / 2.0 + outward * 0.1))
    }
}

/// What is near an edge, on the same sheet.
struct Around {
    points: BTreeSet<u32>,
    edges: Vec<Directed>,
}

/// How far to look, in units of the reach.
const FAR: f64 = 2.5;
/// An edge passes by a wall if its middle is nearer to it than this part of its length.
const SHORTCUT: f64 = 0.1;

/// Is the angle at p between the rays to q and r too small?
fn is_narrow(p: &Vec3, q: &Vec3, r: &Vec3) -> bool {
    angle_between(&(q - p), &(r - p)) < LEAST_ANGLE
}
