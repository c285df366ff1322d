//! Fewer faces: quadric-error edge collapse (Garland & Heckbert, SIGGRAPH 1997).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::border::{Merge, collapse_bridges, larger};
use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::triangle_mesh::TriangleMesh;
use crate::geom::{Mat3, Point3, Vec3};

/// The quadratic function xᵀ A x − 2 bᵀ x + c: weighted sum of squared distances to planes and points.
#[derive(Clone, Copy)]
struct Quadric {
    a: Mat3,
    b: Vec3,
    c: f64,
}

impl Quadric {
    /// weight · ((x − p)·n)² + weight · pull · |x − p|².
    fn plane(p: &Point3, n: &Vec3, weight: f64, pull: f64) -> Self {
        let a = weight * (n * n.transpose() + pull * Mat3::identity());
        let b = a * p;
        Self { a, b, c: p.dot(&b) }
    }

    fn zero() -> Self {
        Self { a: Mat3::zeros(), b: Vec3::zeros(), c: 0.0 }
    }

    fn add(&mut self, other: &Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
    }

    fn at(&self, x: &Point3) -> f64 {
        x.dot(&(self.a * x - 2.0 * self.b)) + self.c
    }

    /// A⁻¹ b, by the columns' cross products (A is symmetric).
    fn minimum(&self) -> Option<Point3> {
        let [p, q, r] = [0, 1, 2].map(|i| self.a.column(i).into_owned());
        let qr = q.cross(&r);
        let x = Vec3::new(qr.dot(&self.b), r.cross(&p).dot(&self.b), p.cross(&q).dot(&self.b)) / p.dot(&qr);
        x.iter().all(|c| c.is_finite()).then_some(x)
    }

    /// The minimum with one coordinate given.
    fn minimum_within(&self, axis: usize, value: f64) -> Option<Point3> {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let (a, b) = (&self.a, self.b - self.a.column(axis) * value);
        let determinant = a[(i, i)] * a[(j, j)] - a[(i, j)] * a[(j, i)];
        let mut x = Point3::repeat(value);
        x[i] = (b[i] * a[(j, j)] - b[j] * a[(i, j)]) / determinant;
        x[j] = (b[j] * a[(i, i)] - b[i] * a[(j, i)]) / determinant;
        x.iter().all(|c| c.is_finite()).then_some(x)
    }
}

/// Weight of the distance to the centroid of a face beside that to its plane. It makes the minimum unique on flat parts
/// and keeps triangles from becoming needles there; 1e-3 changes the position by a thousandth where planes differ.
const PULL: f64 = 1e-3;

/// How far a face may turn from the field's normals at its corners, as a cosine: about 78°, then anything below 90°
/// when nothing else is left.
const TURN_LIMITS: [f64; 2] = [0.2, 1e-3];

/// Faces for each face wanted that are left to be collapsed in the order of their errors.
const CHOICE: usize = 6;
/// Of meshes with more faces, edges are merged first, in any order, that are shorter than this share of another edge of
/// their faces: a mesh from tetrahedra has many of them, and their order costs more than the collapses.
const SHORT: f64 = 0.6;
/// Sweeps over all edges that do so.
const SWEEPS: usize = 4;

/// Edges, or faces, that one task looks at.
const TASK: usize = 256;

/// A possible collapse; costs are compared as bits, which orders nonnegative numbers.
type Candidate = Reverse<(u64, u32, u32, u32)>;

struct Decimation {
    mesh: Connectivity,
    /// The sides of a box that the vertices lie in; none of a closed mesh.
    sides: Vec<BoxSides>,
    positions: Vec<Point3>,
    normals: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    /// Number of changes around a vertex; candidates of older versions are out of date.
    version: Vec<u32>,
    heap: BinaryHeap<Candidate>,
}

/// Collapses edges in the order of their quadric error until at most `faces` faces are left.
///
/// `normals` are the field's unit normals at the vertices; no face may turn away from those of its corners. The topology
/// stays as it is; if it does not allow so few faces, the error names the count where collapsing stopped. Vertices stay
/// in the sides of the box that cuts the mesh. A closed mesh gets `faces` faces exactly, an open one perhaps one less.
pub fn decimate(mesh: &TriangleMesh, normals: &[Vec3], faces: usize) -> Result<TriangleMesh, BaseError> {
    let Some(connectivity) = Connectivity::from_faces(mesh.positions.len(), &mesh.faces) else {
        return Ok(mesh.clone());
    };
    // Quadrics lose digits far from the origin.
    let center = mesh.positions.first().copied().unwrap_or_default();
    let positions: Vec<Point3> = mesh.positions.iter().map(|p| p - center).collect();
    let mut work = Decimation {
        quadrics: quadrics(&positions, &mesh.faces),
        version: vec![0; positions.len()],
        normals: normals.to_vec(),
        heap: BinaryHeap::new(),
        mesh: connectivity,
        sides: mesh.clip.as_ref().map_or_else(|| vec![BoxSides::NONE; positions.len()], |c| c.sides.clone()),
        positions,
    };
    work.merge_short_edges(faces.saturating_mul(CHOICE));
    for limit in TURN_LIMITS {
        work.run(faces, limit);
    }
    if work.mesh.face_count() > faces {
        return Err(BaseError::TooFewFaces { asked: faces, least: work.mesh.face_count() });
    }
    let kept = work.mesh.compact();
    let mut positions: Vec<Point3> = kept.iter().map(|v| work.positions[*v as usize] + center).collect();
    let clip = mesh.clip.as_ref().map(|clip| {
        let sides: Vec<BoxSides> = kept.iter().map(|v| work.sides[*v as usize]).collect();
        positions.iter_mut().zip(&sides).for_each(|(p, s)| *p = s.snap(*p, &clip.bounds));
        Clip { bounds: clip.bounds, sides }
    });
    Ok(TriangleMesh { positions, faces: work.mesh.faces().collect(), clip })
}

fn quadrics(positions: &[Point3], faces: &[[u32; 3]]) -> Vec<Quadric> {
    let of_face = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let n = (b - a).cross(&(c - a));
        let area = n.norm();
        (area > 0.0).then(|| Quadric::plane(&((a + b + c) / 3.0), &(n / area), area, PULL))
    };
    let of_faces: Vec<Option<Quadric>> = faces.par_iter().with_min_len(TASK).map(of_face).collect();
    let mut quadrics = vec![Quadric::zero(); positions.len()];
    for (face, q) in faces.iter().zip(&of_faces) {
        if let Some(q) = q {
            face.iter().for_each(|v| quadrics[*v as usize].add(q));
        }
    }
    quadrics
}

impl Decimation {
    fn run(&mut self, faces: usize, turn_limit: f64) {
        let edges: Vec<u32> = self.mesh.edges().collect();
        let candidates: Vec<Option<Candidate>> =
            edges.par_iter().with_min_len(TASK).map(|h| self.candidate(*h)).collect();
        self.heap = candidates.into_iter().flatten().collect();
        while self.mesh.face_count() > faces {
            let Some(Reverse((_, a, b, version))) = self.heap.pop() else { break };
            if self.is_current(a, b, version) {
                self.try_collapse(a, b, turn_limit);
            }
        }
    }

    /// Merges short edges in the order of their numbers until at most `faces` faces are left, or there are no more.
    fn merge_short_edges(&mut self, faces: usize) {
        for _ in 0..SWEEPS {
            let before = self.mesh.face_count();
            for h in 0..self.mesh.half_edge_bound() {
                if self.mesh.face_count() <= faces {
                    return;
                }
                if self.mesh.is_half_edge(h) && self.is_short(h) {
                    self.collapse(h, TURN_LIMITS[0]);
                }
            }
            if self.mesh.face_count() == before {
                return;
            }
        }
    }

    /// Is an edge much shorter than another of the face to its left?
    fn is_short(&self, h: u32) -> bool {
        let [a, b, c] = self.mesh.corners(h).map(|v| self.positions[v as usize]);
        let longest = (c - a).norm_squared().max((c - b).norm_squared());
        (b - a).norm_squared() < SHORT * SHORT * longest
    }

    fn is_current(&self, a: u32, b: u32, version: u32) -> bool {
        self.mesh.is_vertex(a)
            && self.mesh.is_vertex(b)
            && self.version[a as usize] + self.version[b as usize] == version
    }

    /// Error and place of the merged vertex; none if it would leave a side of the box.
    fn joint(&self, a: u32, b: u32, is_boundary: bool) -> Option<(Quadric, Point3)> {
        let (a, b) = (a as usize, b as usize);
        let mut q = self.quadrics[a];
        q.add(&self.quadrics[b]);
        let x = match Merge::of(self.sides[a], self.sides[b], is_boundary)? {
            Merge::Between => {
                let middle = 0.5 * (self.positions[a] + self.positions[b]);
                let axis = self.sides[a].iter().next().map(|s| s.axis);
                axis.map_or_else(|| q.minimum(), |axis| q.minimum_within(axis, middle[axis]))
                    .unwrap_or(middle)
            }
            Merge::AtFirst => self.positions[a],
            Merge::AtSecond => self.positions[b],
        };
        Some((q, x))
    }

    fn candidate(&self, h: u32) -> Option<Candidate> {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let (a, b) = (a.min(b), a.max(b));
        let (q, x) = self.joint(a, b, self.mesh.is_boundary(h))?;
        let cost = q.at(&x).max(0.0).to_bits();
        Some(Reverse((cost, a, b, self.version[a as usize] + self.version[b as usize])))
    }

    fn try_collapse(&mut self, a: u32, b: u32, turn_limit: f64) {
        let between = |a, b| self.mesh.ring(a).find(|h| self.mesh.dest(*h) == b);
        let Some(h) = between(a, b).or_else(|| between(b, a)) else { return };
        let merged = self.mesh.origin(h);
        if self.collapse(h, turn_limit) {
            let candidates = self.mesh.ring(merged).filter_map(|h| self.candidate(h));
            self.heap.extend(candidates.collect::<Vec<_>>());
        }
    }

    /// Merges the end of a half edge into its origin, if that is allowed.
    fn collapse(&mut self, h: u32, turn_limit: f64) -> bool {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let Some((q, x)) = self.joint(a, b, self.mesh.is_boundary(h)) else { return false };
        let n = (self.normals[a as usize] + self.normals[b as usize]).normalize();
        if !self.mesh.can_collapse(h)
            || !self.looks_outward(h, &x, &n, turn_limit)
            || collapse_bridges(&self.mesh, |v| self.sides[v as usize], h)
        {
            return false;
        }
        self.mesh.collapse(h);
        self.sides[a as usize] = larger([a, b].map(|v| self.sides[v as usize]));
        self.positions[a as usize] = x;
        self.normals[a as usize] = n;
        self.quadrics[a as usize] = q;
        self.version[a as usize] += 1;
        true
    }

    /// Do all faces that survive the collapse to `x` look to the side of their corners' normals?
    fn looks_outward(&self, h: u32, x: &Point3, n: &Vec3, limit: f64) -> bool {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let looks_out = |e: u32| {
            let [_, v, w] = self.mesh.corners(e);
            if [v, w].iter().any(|u| *u == a || *u == b) {
                return true;
            }
            let area = (self.positions[v as usize] - x).cross(&(self.positions[w as usize] - x));
            let least = limit * area.norm();
            area.norm_squared() > 0.0
                && [n, &self.normals[v as usize], &self.normals[w as usize]]
                    .iter()
                    .all(|m| area.dot(m) > least)
        };
        self.mesh.ring(a).all(looks_out) && self.mesh.ring(b).all(looks_out)
    }
}
