//! Local changes of a base mesh: edges are collapsed or split where a patch may or must be smaller, and taken back where
//! that was not good.

use super::base_mesh::BaseMesh;
use super::build::{BaseOptions, base_of};
use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::project::project_positions;
use super::shape::{area_vector, largest_angle_cosine, unit_or_zero};
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::mesh::{FaceId, VertexId};

/// Corners of a slot without a face.
const REMOVED: [u32; 3] = [u32::MAX; 3];
/// Times that a new or merged vertex moves to the middle of the faces around it.
const RELAXATIONS: usize = 3;
/// Passes over the edges at it that are flipped if that makes the widest corner narrower.
const FLIP_PASSES: usize = 3;
/// Least gain in the cosine of the widest corner that is worth a flip; smaller ones may alternate for ever.
const FLIP_GAIN: f64 = 0.02;

/// What is known of a vertex.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    x: Point3,
    normal: Vec3,
    tensor: Mat3,
    /// Sides of the box that it lies in.
    sides: BoxSides,
}

/// What the length of an edge, as a share of the diagonal, counts beside its turn when a face is split.
const LENGTH_SHARE: f64 = 0.1;

/// The limits of a valid face, as cosines, and as |M d|.
#[derive(Clone, Copy)]
struct Limits {
    smallest_corner: f64,
    largest_corner: f64,
    deviation: f64,
    turn: f64,
}

/// A base mesh whose faces have slots that stay theirs while other faces come and go.
///
/// A face has the same stamp as long as its corners are the same vertices at the same places.
pub struct Draft<'a> {
    field: &'a dyn Field,
    options: &'a BaseOptions,
    diagonal: f64,
    limits: Limits,
    faces: Vec<[u32; 3]>,
    stamps: Vec<u64>,
    last_stamp: u64,
    vertices: Vec<Vertex>,
    /// The box, if it cuts the mesh.
    bounds: Option<Aabb>,
}

/// What a collapse did.
#[derive(Clone, Debug)]
pub struct Change {
    /// Slots with the corners and stamps that they had.
    slots: Vec<(u32, [u32; 3], u64)>,
    /// The merged vertex as it was.
    vertex: (u32, Vertex),
}

impl Change {
    /// Slots in which it left a face.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        self.slots.iter().map(|s| s.0)
    }
}

impl<'a> Draft<'a> {
    /// The faces of a base mesh, each in the slot of its number.
    pub fn new(field: &'a dyn Field, base: &BaseMesh, options: &'a BaseOptions) -> Self {
        let faces: Vec<[u32; 3]> = base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| v.0)).collect();
        let vertices = (0..base.positions.len())
            .map(|v| Vertex {
                x: base.positions[v],
                normal: base.normals[v],
                tensor: base.curvatures[v],
                sides: base.clip.as_ref().map_or(BoxSides::NONE, |clip| clip.sides[v]),
            })
            .collect();
        let last_stamp = faces.len() as u64;
        Self {
            field,
            options,
            diagonal: base.diagonal(),
            limits: Limits {
                smallest_corner: options.limits.smallest_corner.to_radians().cos(),
                largest_corner: options.limits.largest_corner.to_radians().cos(),
                deviation: options.limits.facet_deviation.to_radians().cos(),
                turn: options.limits.curvature_length,
            },
            stamps: (0..last_stamp).collect(),
            faces,
            last_stamp,
            vertices,
            bounds: base.clip.as_ref().map(|clip| clip.bounds),
        }
    }

    /// The slots with a face, in order: face i of [`Draft::base`] is in slot i of these.
    pub fn live(&self) -> Vec<u32> {
        (0..self.faces.len() as u32).filter(|s| self.faces[*s as usize] != REMOVED).collect()
    }

    /// Stamps of the faces of [`Draft::base`].
    pub fn live_stamps(&self) -> Vec<u64> {
        self.live().into_iter().map(|s| self.stamps[s as usize]).collect()
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.faces.iter().filter(|f| **f != REMOVED).count()
    }

    /// The base mesh as it is now: faces in the order of their slots.
    pub fn base(&self) -> Result<BaseMesh, BaseError> {
        let mut number = vec![u32::MAX; self.vertices.len()];
        let live: Vec<[u32; 3]> = self.faces.iter().filter(|f| **f != REMOVED).copied().collect();
        live.iter().flatten().for_each(|v| number[*v as usize] = 0);
        let kept: Vec<usize> = (0..number.len()).filter(|v| number[*v] == 0).collect();
        kept.iter().enumerate().for_each(|(new, old)| number[*old] = new as u32);
        let faces: Vec<[u32; 3]> = live.iter().map(|f| f.map(|v| number[v as usize])).collect();
        let of = |v: &usize| &self.vertices[*v];
        base_of(
            &faces,
            kept.iter().map(|v| of(v).x).collect(),
            kept.iter().map(|v| of(v).normal).collect(),
            kept.iter().map(|v| of(v).tensor).collect(),
            self.bounds.map(|bounds| Clip { bounds, sides: kept.iter().map(|v| of(v).sides).collect() }),
        )
    }

    /// Begins changes that do not touch each other.
    pub fn batch(&mut self) -> Option<Batch<'_, 'a>> {
        let slots = self.live();
        let faces: Vec<[u32; 3]> = slots.iter().map(|s| self.faces[*s as usize]).collect();
        let mesh = Connectivity::from_faces(self.vertices.len(), &faces)?;
        let claimed = vec![false; self.vertices.len()];
        Some(Batch { draft: self, mesh, slots, claimed })
    }

    /// Takes a change back; changes that touch it were taken back before.
    pub fn undo(&mut self, change: &Change) {
        for (slot, corners, stamp) in &change.slots {
            self.faces[*slot as usize] = *corners;
            self.stamps[*slot as usize] = *stamp;
        }
        self.vertices[change.vertex.0 as usize] = change.vertex.1;
    }

    fn point(&self, v: u32) -> Point3 {
        self.vertices[v as usize].x
    }

    /// Is the face within the limits of a valid base mesh?
    fn is_valid(&self, corners: [u32; 3]) -> bool {
        let Limits { smallest_corner, largest_corner, deviation, turn } = self.limits;
        let [a, b, c] = corners.map(|v| &self.vertices[v as usize]);
        let area = area_vector([a.x, b.x, c.x]);
        let least = deviation * area.norm();
        [(a, b, c), (b, c, a), (c, a, b)].into_iter().all(|(p, q, r)| {
            let (d, e) = (q.x - p.x, r.x - p.x);
            let (sine, cosine) = (area.dot(&p.normal), d.dot(&e) - d.dot(&p.normal) * e.dot(&p.normal));
            let length = (sine * sine + cosine * cosine).sqrt();
            sine >= least
                && sine > 0.0
                && cosine < smallest_corner * length
                && cosine > largest_corner * length
                && (p.tensor * d).norm_squared() < turn * turn
                && (p.tensor * e).norm_squared() < turn * turn
        })
    }

    /// Puts a vertex on the surface at `x`, or beside it; false if there is none.
    fn place(&mut self, v: u32, x: Point3) -> bool {
        let sides = self.vertices[v as usize].sides;
        let mut x = [self.bounds.map_or(x, |bounds| sides.snap(x, &bounds))];
        let projection = &self.options.remesh.projection;
        let report = project_positions(self.field, &mut x, &[sides], self.diagonal, projection);
        let jet = self.field.jet(x[0]);
        let (normal, tensor) = (unit_or_zero(&jet.gradient), jet.curvature_tensor());
        let vertex = Vertex { x: x[0], normal, tensor, sides };
        let good =
            report.failures.is_empty() && vertex.tensor.sum().is_finite() && vertex.normal.norm() > 0.0;
        if good {
            self.vertices[v as usize] = vertex;
        }
        good
    }
}

/// Changes of a [`Draft`] that do not touch each other, so that each can be taken back alone.
pub struct Batch<'d, 'a> {
    draft: &'d mut Draft<'a>,
    mesh: Connectivity,
    /// The slot of each face of `mesh`.
    slots: Vec<u32>,
    /// Vertices whose faces a change has touched.
    claimed: Vec<bool>,
}

impl Batch<'_, '_> {
    /// The edges, as half edges: number 3i + k is side k of live face i.
    pub fn edges(&self) -> Vec<u32> {
        self.mesh.edges().collect()
    }

    /// Ends of a half edge.
    pub fn ends(&self, h: u32) -> [u32; 2] {
        [self.mesh.origin(h), self.mesh.dest(h)]
    }

    /// The side of a live face along which the normal turns most; of sides alike, the longest.
    pub fn most_turned_side(&self, face: usize) -> u32 {
        let turn = |h: u32| {
            let [a, b] = self.ends(h).map(|v| &self.draft.vertices[v as usize]);
            let d = b.x - a.x;
            (a.tensor * d).norm() + (b.tensor * d).norm() + LENGTH_SHARE * d.norm() / self.draft.diagonal
        };
        let first = 3 * face as u32;
        let longer = |a: u32, b: u32| if turn(b) > turn(a) { b } else { a };
        longer(longer(first, first + 1), first + 2)
    }

    /// Faces around the ends of a half edge, by their number among the live ones.
    pub fn faces_around(&self, h: u32) -> impl Iterator<Item = usize> + '_ {
        self.ends(h).into_iter().flat_map(|v| self.mesh.ring(v)).map(|e| e as usize / 3)
    }

    /// Is the half edge there, and nothing near it changed?
    pub fn is_free(&self, h: u32) -> bool {
        self.mesh.is_half_edge(h) && self.around(&self.ends(h)).iter().all(|v| !self.claimed[*v as usize])
    }

    /// Vertices and their neighbours.
    fn around(&self, centers: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> = centers.to_vec();
        for v in centers {
            all.extend(self.mesh.ring(*v).map(|h| self.mesh.dest(h)));
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Merges the ends of an edge and relaxes the faces around; none, and no change, if a face would not be valid.
    pub fn collapse(&mut self, h: u32) -> Option<Change> {
        if !self.is_free(h) || !self.mesh.can_collapse(h) {
            return None;
        }
        let [a, b] = self.ends(h);
        // The border keeps its vertices.
        if [a, b].iter().any(|v| !self.draft.vertices[*v as usize].sides.is_empty()) {
            return None;
        }
        let region = self.around(&[a, b]);
        let old = self.draft.vertices[a as usize];
        let middle = 0.5 * (self.draft.point(a) + self.draft.point(b));
        let touched: Vec<u32> = {
            let mut faces: Vec<u32> = self.faces_around(h).map(|f| f as u32).collect();
            faces.sort_unstable();
            faces.dedup();
            faces
        };
        let before = self.mesh.clone_faces(&touched);
        let undo = self.mesh.snapshot(&touched, &region);
        self.mesh.collapse(h);
        let good = self.draft.place(a, middle) && self.relax(a);
        if !good {
            self.mesh.restore(&undo);
            self.draft.vertices[a as usize] = old;
            return None;
        }
        let slots = self.write(&touched, &before);
        region.iter().for_each(|v| self.claimed[*v as usize] = true);
        Some(Change { slots, vertex: (a, old) })
    }

    /// Flips and smoothing around a vertex; false if a face at it is not valid in the end.
    fn relax(&mut self, v: u32) -> bool {
        for _ in 0..RELAXATIONS {
            if let Some(target) = self.middle_of_ring(v) {
                self.draft.place(v, target);
            }
            self.flip_spokes(v);
        }
        self.mesh.ring(v).all(|h| self.draft.is_valid(self.mesh.corners(h)))
    }

    /// Area-weighted centre of the faces at a vertex, in its tangent plane.
    fn middle_of_ring(&self, v: u32) -> Option<Point3> {
        let (mut moment, mut total) = (Vec3::zeros(), 0.0);
        for h in self.mesh.ring(v) {
            let [p, q, r] = self.mesh.corners(h).map(|v| self.draft.point(v));
            let area = area_vector([p, q, r]).norm();
            moment += area * ((p + q + r) / 3.0 - p);
            total += area;
        }
        let vertex = &self.draft.vertices[v as usize];
        let pull = moment / total;
        let tangential = pull - vertex.normal * vertex.normal.dot(&pull);
        tangential.sum().is_finite().then_some(vertex.x + tangential)
    }

    /// Flips edges at a vertex where that makes the widest corner of their two faces narrower.
    fn flip_spokes(&mut self, v: u32) {
        for _ in 0..FLIP_PASSES {
            let spokes: Vec<u32> = self.mesh.ring(v).collect();
            let better = spokes.into_iter().find(|h| self.mesh.can_flip(*h) && self.is_better_flipped(*h));
            match better {
                Some(h) => self.mesh.flip(h),
                None => break,
            }
        }
    }

    fn is_better_flipped(&self, h: u32) -> bool {
        let Some([c, d]) = self.mesh.apexes(h) else { return false };
        let [a, b] = self.ends(h);
        let sides = |v: u32| self.draft.vertices[v as usize].sides;
        if !sides(c).common(sides(d)).is_empty() {
            return false;
        }
        let widest = |faces: [[u32; 3]; 2]| {
            faces
                .map(|f| largest_angle_cosine(f.map(|v| self.draft.point(v))))
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        };
        let after = [[d, c, a], [c, d, b]];
        widest(after) > widest([[a, b, c], [b, a, d]]) + FLIP_GAIN
            && after.into_iter().all(|f| self.draft.is_valid(f))
    }

    /// Puts the faces of the mesh into their slots; gives what was there.
    fn write(&mut self, touched: &[u32], before: &[[u32; 3]]) -> Vec<(u32, [u32; 3], u64)> {
        let mut old = Vec::with_capacity(touched.len());
        for (face, corners) in touched.iter().zip(before) {
            let slot = self.slots[*face as usize];
            let s = slot as usize;
            old.push((slot, *corners, self.draft.stamps[s]));
            self.draft.last_stamp += 1;
            self.draft.stamps[s] = self.draft.last_stamp;
            self.draft.faces[s] =
                if self.mesh.is_half_edge(3 * face) { self.mesh.corners(3 * face) } else { REMOVED };
        }
        old
    }

    /// Puts a vertex on the edge and relaxes what is around it; false if its faces have changed in this batch.
    pub fn split(&mut self, h: u32) -> bool {
        let [a, b] = self.ends(h);
        let corners: Vec<u32> = match self.mesh.apexes(h) {
            Some([c, d]) => vec![a, b, c, d],
            None => vec![a, b, self.mesh.apex(h)],
        };
        if corners.iter().any(|v| self.claimed[*v as usize]) {
            return false;
        }
        let mut touched: Vec<u32> = corners.iter().flat_map(|v| self.mesh.ring(*v)).map(|e| e / 3).collect();
        touched.sort_unstable();
        touched.dedup();
        let before = self.mesh.clone_faces(&touched);
        let middle = 0.5 * (self.draft.point(a) + self.draft.point(b));
        let new_faces = self.mesh.faces_at(h);
        let [first, second] = [a, b].map(|v| self.draft.vertices[v as usize]);
        let sides = if new_faces == 1 { first.sides.common(second.sides) } else { BoxSides::NONE };
        let m = self.mesh.split(h);
        self.draft.vertices.push(Vertex { sides, ..first });
        self.claimed.push(true);
        corners.iter().for_each(|v| self.claimed[*v as usize] = true);
        self.draft.place(m, middle);
        for _ in 0..new_faces {
            self.draft.faces.push(REMOVED);
            self.draft.stamps.push(0);
            self.slots.push(self.draft.faces.len() as u32 - 1);
        }
        // Edges at the new vertex and opposite to it.
        for _ in 0..RELAXATIONS {
            self.flip_around(m, &touched, new_faces as u32);
            for v in corners.iter().copied().chain([m]) {
                let old = self.draft.vertices[v as usize];
                if !old.sides.is_empty() {
                    continue;
                }
                let was_valid = self.ring_is_valid(v);
                if let Some(target) = self.middle_of_ring(v) {
                    let moved = self.draft.place(v, 0.5 * (target + old.x));
                    if !moved || (was_valid && !self.ring_is_valid(v)) {
                        self.draft.vertices[v as usize] = old;
                    }
                }
            }
        }
        self.write(&touched, &before);
        let bound = self.mesh.half_edge_bound() / 3;
        let new: Vec<u32> = (bound - new_faces as u32..bound).collect();
        self.write(&new, &vec![REMOVED; new_faces]);
        true
    }

    fn ring_is_valid(&self, v: u32) -> bool {
        self.mesh.ring(v).all(|h| self.draft.is_valid(self.mesh.corners(h)))
    }

    /// Flips the edges at a vertex and opposite to it, if their faces are among `touched` or new.
    fn flip_around(&mut self, v: u32, touched: &[u32], new_faces: u32) {
        let first_new = self.mesh.half_edge_bound() / 3 - new_faces;
        let may = |h: u32| touched.binary_search(&(h / 3)).is_ok() || h / 3 >= first_new;
        let spokes: Vec<u32> = self.mesh.ring(v).collect();
        let opposite: Vec<u32> = spokes.iter().map(|h| 3 * (h / 3) + (h + 1) % 3).collect();
        for h in opposite {
            let inside = self.mesh.is_half_edge(h) && may(h) && self.mesh.twin(h).is_some_and(may);
            if inside && self.mesh.can_flip(h) && self.is_better_flipped(h) {
                self.mesh.flip(h);
            }
        }
    }
}

/// Some faces of a base mesh as a mesh of its own.
pub struct Part {
    /// The mesh; faces and vertices are in the order of the whole.
    pub base: BaseMesh,
    /// Number of each face in the whole.
    pub faces: Vec<usize>,
    /// Number of each vertex in the whole.
    pub vertices: Vec<u32>,
}

/// The part of a base mesh with the `wanted` faces, and more where those at a vertex would form several fans.
pub fn part(base: &BaseMesh, wanted: &[bool]) -> Result<Part, BaseError> {
    let mesh = &base.mesh;
    let mut wanted = wanted.to_vec();
    // A vertex whose wanted faces form several fans gets all of them; that may spoil others.
    loop {
        let several = |v: &VertexId| {
            let ring: Vec<bool> = mesh.ring(*v).map(|h| wanted[mesh.face(h).index()]).collect();
            let n = ring.len();
            let wraps = !mesh.is_boundary_vertex(*v);
            let starts = (0..n)
                .filter(|i| ring[*i] && !(if *i > 0 { ring[i - 1] } else { wraps && ring[n - 1] }))
                .count();
            starts > 1
        };
        let bad: Vec<VertexId> = mesh.vertices().filter(several).collect();
        if bad.is_empty() {
            break;
        }
        for v in bad {
            mesh.ring(v).for_each(|h| wanted[mesh.face(h).index()] = true);
        }
    }
    let faces: Vec<usize> = (0..wanted.len()).filter(|f| wanted[*f]).collect();
    let corners = |f: &usize| mesh.triangle(FaceId::from(*f)).map(|v| v.0);
    let mut number = vec![u32::MAX; mesh.vertex_count()];
    faces.iter().flat_map(corners).for_each(|v| number[v as usize] = 0);
    let kept: Vec<u32> = (0..number.len() as u32).filter(|v| number[*v as usize] == 0).collect();
    kept.iter().enumerate().for_each(|(new, old)| number[*old as usize] = new as u32);
    let triangles: Vec<[u32; 3]> = faces.iter().map(|f| corners(f).map(|v| number[v as usize])).collect();
    let base = base_of(
        &triangles,
        kept.iter().map(|v| base.positions[*v as usize]).collect(),
        kept.iter().map(|v| base.normals[*v as usize]).collect(),
        kept.iter().map(|v| base.curvatures[*v as usize]).collect(),
        base.clip.as_ref().map(|clip| Clip {
            bounds: clip.bounds,
            sides: kept.iter().map(|v| clip.sides[*v as usize]).collect(),
        }),
    )?;
    Ok(Part { base, faces, vertices: kept })
}
