//! Well-shaped triangles: splits, collapses, flips and tangential smoothing on the surface, guided by edge lengths
//! (Botsch & Kobbelt, SGP 2004, with lengths from the curvature).

mod flip;

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::border::{Merge, collapse_bridges, larger};
use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::project::{ProjectOptions, project_positions};
use super::shape::{area_vector, facing, largest_curvature, unit_or_zero};
use super::sizing::{
    SizingOptions, UNIT_TRIANGLE, blend_with_curvature, sizes_for_count, sizes_from_errors, stretch,
};
use super::triangle_mesh::TriangleMesh;
use crate::field::Field;
use crate::geom::{Mat3, Point3, Vec3, morton_order};

/// Settings of [`remesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshOptions {
    /// Rounds of splits, collapses, flips and smoothing. Default 7: more change the spline's error by less
    /// than chance does.
    pub rounds: usize,
    /// Further rounds of flips and smoothing once the face count is exact. Default 4.
    pub polish: usize,
    /// Smoothing steps in each round. Default 3.
    pub smoothing: usize,
    /// Share of the way to the centre of the neighbourhood that a smoothing step goes. Default 0.7.
    pub damping: f64,
    /// Edge lengths.
    pub sizing: SizingOptions,
    /// How vertices are put on the surface.
    pub projection: ProjectOptions,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            rounds: 7,
            polish: 4,
            smoothing: 3,
            damping: 0.7,
            sizing: SizingOptions::default(),
            projection: ProjectOptions::default(),
        }
    }
}

/// Edges longer than this times the wanted length are split: their halves are then nearer to it.
const LONG: f64 = 4.0 / 3.0;

/// Edges shorter than this times the wanted length are collapsed: the edges around are then nearer to it.
const SHORT: f64 = 4.0 / 5.0;

/// A collapse may not turn a face farther than this (cosine) from the normal at the merged vertex, and from those of
/// the face's other corners.
const COLLAPSE_FACING: [f64; 2] = [0.5, 0.3];

/// Twice the area of a face over the square of its longest edge: a collapse may not leave less (equilateral: 0.87).
const THINNEST: f64 = 0.12;

/// Meshes with fewer faces fit into the cache of a core, in any order.
const SORTED: usize = 8_192;

/// Edges, faces or vertices that one task looks at.
const TASK: usize = 64;

/// A vertex that smoothing and projection move farther than this times the wanted edge length has left its place:
/// neighbours would have to follow.
const FARTHEST_MOVE: f64 = 1.0;

/// A mesh that is being changed, with what is known at its vertices.
pub(super) struct Remesher<'a> {
    pub field: &'a dyn Field,
    pub options: &'a RemeshOptions,
    pub diagonal: f64,
    pub mesh: Connectivity,
    pub x: Vec<Point3>,
    pub normal: Vec<Vec3>,
    /// Largest curvature |k|max at each vertex.
    pub curvature: Vec<f64>,
    /// Curvature tensor at each vertex.
    pub tensor: Vec<Mat3>,
    /// Wanted edge length at each vertex.
    pub size: Vec<f64>,
    /// Metric of relative lengths at each vertex.
    pub metric: Vec<Mat3>,
    /// Wanted edge lengths relative to each other, at each vertex.
    pub relative: Vec<f64>,
    /// Are these given, and not to be estimated from the surface?
    pub given_lengths: bool,
    /// The box that cuts the surface, with the sides that the vertices lie in.
    pub clip: Option<Clip>,
}

/// Remeshes a mesh near the surface to exactly `faces` faces (an even number if it is closed) with all vertices on the
/// surface, and those of the border in the sides of the box that they were in.
///
/// The topology stays as it is. Fails if it does not allow so few faces.
pub fn remesh(
    field: &dyn Field,
    mesh: &TriangleMesh,
    faces: usize,
    diagonal: f64,
    options: &RemeshOptions,
) -> Result<TriangleMesh, BaseError> {
    remesh_to(field, mesh, None, faces, diagonal, options)
}

/// [`remesh`] to edge lengths in proportion to `lengths`, one a vertex of `mesh`, if they are given.
pub(super) fn remesh_to(
    field: &dyn Field,
    mesh: &TriangleMesh,
    lengths: Option<&[f64]>,
    faces: usize,
    diagonal: f64,
    options: &RemeshOptions,
) -> Result<TriangleMesh, BaseError> {
    let Some(connectivity) = Connectivity::from_faces(mesh.positions.len(), &mesh.faces) else {
        return Ok(mesh.clone());
    };
    let mut work = Remesher {
        field,
        options,
        diagonal,
        mesh: connectivity,
        x: mesh.positions.clone(),
        normal: Vec::new(),
        curvature: Vec::new(),
        tensor: Vec::new(),
        size: Vec::new(),
        metric: Vec::new(),
        relative: lengths.map_or_else(|| vec![1.0; mesh.positions.len()], <[f64]>::to_vec),
        given_lengths: lengths.is_some(),
        clip: mesh.clip.clone(),
    };
    work.put_on_surface(&mesh.positions.clone());
    work.remove_bridges();
    // Predicted and real counts differ by some percent, in a way that hardly changes from round to round.
    let mut bias = 1.0;
    for _ in 0..options.rounds {
        work.update_sizes((faces as f64 * bias) as usize);
        work.split_long();
        work.collapse_short();
        work.flip_for_valence();
        work.compact();
        work.smooth_repeatedly();
        bias *= (faces as f64 / work.mesh.face_count() as f64).clamp(0.8, 1.25).sqrt();
    }
    work.update_sizes(faces);
    work.reach_count(faces)?;
    for _ in 0..options.polish {
        work.update_sizes(faces);
        work.flip_for_angle();
        work.smooth_repeatedly();
    }
    work.flip_for_angle();
    work.compact();
    Ok(TriangleMesh { faces: work.mesh.faces().collect(), positions: work.x, clip: work.clip })
}

impl Remesher<'_> {
    /// Projects all vertices; one that does not arrive, or is farther than its edges are long, goes back to `fallback`.
    pub fn put_on_surface(&mut self, fallback: &[Point3]) {
        let sides = self.clip.as_ref().map_or(&[][..], |c| &c.sides);
        let report =
            project_positions(self.field, &mut self.x, sides, self.diagonal, &self.options.projection);
        for i in report.failures {
            self.x[i] = fallback[i];
        }
        for (i, size) in self.size.iter().enumerate() {
            // Another sheet of the surface, not the one that the vertex belongs to.
            if (self.x[i] - fallback[i]).norm() > FARTHEST_MOVE * size {
                self.x[i] = fallback[i];
            }
        }
        if let Some(clip) = &self.clip {
            for ((x, sides), fallback) in self.x.iter_mut().zip(&clip.sides).zip(fallback) {
                if !clip.holds(x) {
                    *x = sides.snap(*fallback, &clip.bounds);
                }
            }
        }
        self.update_normals();
    }

    fn update_normals(&mut self) {
        let field = self.field;
        // Without a gradient there is neither normal nor curvature; that is found out at the end.
        let finite = |m: Mat3| if m.sum().is_finite() { m } else { Mat3::zeros() };
        let known = |p: &Point3| {
            let jet = field.jet(*p);
            let tensor = finite(jet.curvature_tensor());
            (unit_or_zero(&jet.gradient), (tensor, largest_curvature(&tensor)))
        };
        (self.normal, (self.tensor, self.curvature)) = self.x.par_iter().evenly_by(TASK).map(known).unzip();
    }

    pub fn update_sizes(&mut self, faces: usize) {
        if !self.given_lengths {
            let errors = sizes_from_errors(self.field, &self.mesh, &self.x, &self.normal, &self.tensor);
            self.relative = blend_with_curvature(errors, &self.curvature, &self.options.sizing);
        }
        let caps = self.lean_caps();
        self.size = sizes_for_count(
            &self.mesh,
            &self.x,
            &self.curvature,
            &self.relative,
            &caps,
            faces,
            &self.options.sizing,
        );
        let pairs = self.tensor.par_iter().zip(&self.normal).evenly_by(TASK);
        self.metric = pairs.map(|(m, n)| stretch(m, n, &self.options.sizing)).collect();
    }

    /// Edge lengths at each vertex for which its faces would lean just as far from their normals as they may.
    fn lean_caps(&self) -> Vec<f64> {
        let longest = |f: [u32; 3]| {
            let lean = self.facing_of(f).clamp(-1.0, 1.0).acos();
            let length = (area_vector(self.corners(f)).norm() / (2.0 * UNIT_TRIANGLE)).sqrt();
            length * self.options.sizing.lean.to_radians() / lean
        };
        let mut cap = vec![f64::INFINITY; self.x.len()];
        for (f, longest) in self.of_faces(longest) {
            for v in f {
                cap[v as usize] = cap[v as usize].min(longest);
            }
        }
        cap
    }

    /// Something of each face, computed in parallel.
    fn of_faces<T: Send>(&self, compute: impl Fn([u32; 3]) -> T + Sync) -> Vec<([u32; 3], T)> {
        let faces: Vec<[u32; 3]> = self.mesh.faces().collect();
        faces.into_par_iter().evenly_by(TASK).map(|f| (f, compute(f))).collect()
    }

    /// Renumbers vertices after splits and removals.
    pub fn compact(&mut self) {
        let kept = if self.mesh.face_count() < SORTED { self.mesh.compact() } else { self.sorted() };
        let pick = |i: &u32| *i as usize;
        self.x = kept.iter().map(|i| self.x[pick(i)]).collect();
        self.normal = kept.iter().map(|i| self.normal[pick(i)]).collect();
        self.curvature = kept.iter().map(|i| self.curvature[pick(i)]).collect();
        self.tensor = kept.iter().map(|i| self.tensor[pick(i)]).collect();
        self.size = kept.iter().map(|i| self.size[pick(i)]).collect();
        self.metric = kept.iter().map(|i| self.metric[pick(i)]).collect();
        self.relative = kept.iter().map(|i| self.relative[pick(i)]).collect();
        if let Some(clip) = &mut self.clip {
            clip.sides = kept.iter().map(|i| clip.sides[pick(i)]).collect();
        }
    }

    /// Numbers vertices such that neighbours are near each other in memory: splits put new ones at the end.
    fn sorted(&mut self) -> Vec<u32> {
        let mut ranks = vec![0; self.x.len()];
        for (rank, v) in (0..).zip(morton_order(&self.x)) {
            ranks[v as usize] = rank;
        }
        self.mesh.sort_by(&ranks)
    }

    /// The sides of the box that a vertex lies in.
    fn sides(&self, v: u32) -> BoxSides {
        self.clip.as_ref().map_or(BoxSides::NONE, |c| c.sides[v as usize])
    }

    fn point(&self, v: u32) -> Point3 {
        self.x[v as usize]
    }

    /// Length of an edge beside the shorter wanted length of its ends.
    fn relative_length(&self, h: u32) -> f64 {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let d = self.point(a) - self.point(b);
        let g = 0.5 * (self.metric[a as usize] + self.metric[b as usize]);
        d.dot(&(g * d)).sqrt() / self.size[a as usize].min(self.size[b as usize])
    }

    /// Edges whose relative length passes the test, with that length; in a fixed order, shortest first.
    fn edges_by_length(&self, wanted: impl Fn(f64) -> bool + Sync) -> Vec<(f64, u32)> {
        let all: Vec<u32> = self.mesh.edges().collect();
        let lengths = all.into_par_iter().evenly_by(TASK).map(|h| (self.relative_length(h), h));
        // Lists of unknown length would grow on all threads, which wait for each other's memory.
        let mut edges: Vec<(f64, u32)> = lengths.collect();
        edges.retain(|(length, _)| wanted(*length));
        edges.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        edges
    }

    fn split_long(&mut self) {
        for (_, h) in self.edges_by_length(|l| l > LONG).into_iter().rev() {
            self.split(h);
        }
    }

    /// A new vertex in the middle of the edge.
    fn split(&mut self, h: u32) {
        let (a, b) = (self.mesh.origin(h) as usize, self.mesh.dest(h) as usize);
        let sides = self.sides(a as u32).common(self.sides(b as u32));
        if let Some(clip) = &mut self.clip {
            clip.sides.push(if self.mesh.is_boundary(h) { sides } else { BoxSides::NONE });
        }
        self.mesh.split(h);
        self.x.push(0.5 * (self.x[a] + self.x[b]));
        self.normal.push(unit_or_zero(&(self.normal[a] + self.normal[b])));
        self.curvature.push(0.5 * (self.curvature[a] + self.curvature[b]));
        self.tensor.push(0.5 * (self.tensor[a] + self.tensor[b]));
        self.size.push(0.5 * (self.size[a] + self.size[b]));
        self.metric.push(0.5 * (self.metric[a] + self.metric[b]));
        self.relative.push(0.5 * (self.relative[a] + self.relative[b]));
    }

    /// Edges inside that join two vertices of one side of the box are flipped, or else split, with the new vertex moved
    /// inside.
    fn remove_bridges(&mut self) {
        if self.clip.is_none() {
            return;
        }
        let edges: Vec<u32> = self.mesh.edges().collect();
        for h in edges {
            let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
            let Some([c, d]) = self.mesh.apexes(h) else { continue };
            if self.sides(a).common(self.sides(b)).is_empty() {
                continue;
            }
            if self.can_flip(h) {
                self.mesh.flip(h);
                continue;
            }
            self.split(h);
            let middle = 0.25 * [a, b, c, d].iter().map(|v| self.point(*v)).sum::<Point3>();
            if let Some(last) = self.x.last_mut() {
                *last = middle;
            }
        }
        let before = self.x.clone();
        self.put_on_surface(&before);
    }

    fn collapse_short(&mut self) {
        for (_, h) in self.edges_by_length(|l| l < SHORT) {
            if self.mesh.is_half_edge(h) && self.relative_length(h) < SHORT {
                self.try_collapse(h, LONG);
            }
        }
    }

    /// Merges the ends in their middle, or at the one that lies in more sides of the box, if no edge gets relatively longer than `longest` and no face turns or thins out.
    fn try_collapse(&mut self, h: u32, longest: f64) -> bool {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let (i, j) = (a as usize, b as usize);
        let (middle, n) = match Merge::of(self.sides(a), self.sides(b), self.mesh.is_boundary(h)) {
            Some(Merge::Between) => {
                (0.5 * (self.x[i] + self.x[j]), unit_or_zero(&(self.normal[i] + self.normal[j])))
            }
            Some(Merge::AtFirst) => (self.x[i], self.normal[i]),
            Some(Merge::AtSecond) => (self.x[j], self.normal[j]),
            None => return false,
        };
        let size = self.size[i].min(self.size[j]);
        let metric = 0.5 * (self.metric[i] + self.metric[j]);
        let fits = |e: u32| {
            let [_, v, w] = self.mesh.corners(e);
            let too_far = |u: u32| {
                let d = self.point(u) - middle;
                d.dot(&(metric * d)).sqrt() > longest * size && u != a && u != b
            };
            if too_far(v) || too_far(w) {
                return false;
            }
            v == a || v == b || w == a || w == b || self.is_good_face(middle, &n, v, w)
        };
        if !self.mesh.can_collapse(h) || !self.mesh.ring(a).all(fits) || !self.mesh.ring(b).all(fits) {
            return false;
        }
        if let Some(clip) = &mut self.clip {
            if collapse_bridges(&self.mesh, |v| clip.sides[v as usize], h) {
                return false;
            }
            clip.sides[i] = larger([clip.sides[i], clip.sides[j]]);
        }
        self.mesh.collapse(h);
        self.x[i] = middle;
        self.normal[i] = n;
        self.curvature[i] = self.curvature[i].max(self.curvature[j]);
        self.size[i] = 0.5 * (self.size[i] + self.size[j]);
        self.metric[i] = metric;
        self.relative[i] = 0.5 * (self.relative[i] + self.relative[j]);
        true
    }

    /// Is the triangle (p, v, w), with normal n at p, neither turned away from its normals nor thin?
    fn is_good_face(&self, p: Point3, n: &Vec3, v: u32, w: u32) -> bool {
        let (q, r) = (self.point(v), self.point(w));
        let area = area_vector([p, q, r]);
        let length = area.norm();
        let longest = (q - p).norm_squared().max((r - q).norm_squared()).max((p - r).norm_squared());
        length >= THINNEST * longest
            && area.dot(n) >= COLLAPSE_FACING[0] * length
            && [v, w].iter().all(|u| area.dot(&self.normal[*u as usize]) >= COLLAPSE_FACING[1] * length)
    }

    /// Collapses the relatively shortest or splits the relatively longest edges until the face count is right.
    pub fn reach_count(&mut self, faces: usize) -> Result<(), BaseError> {
        // Gentle first; then edges may grow, if that is the only way; then one face too few is better than one too many.
        for (longest, overshoot) in [(LONG, 0), (2.0, 0), (f64::INFINITY, 0), (f64::INFINITY, 1)] {
            while self.mesh.face_count() > faces {
                let before = self.mesh.face_count();
                for (_, h) in self.edges_by_length(|_| true) {
                    let surplus = self.mesh.face_count().saturating_sub(faces) + overshoot;
                    if surplus > overshoot && self.mesh.is_half_edge(h) && self.mesh.faces_at(h) <= surplus {
                        self.try_collapse(h, longest);
                    }
                }
                if self.mesh.face_count() == before {
                    break;
                }
            }
        }
        if self.mesh.face_count() > faces {
            return Err(BaseError::TooFewFaces { asked: faces, least: self.mesh.face_count() });
        }
        while self.mesh.face_count() < faces {
            let before = self.mesh.face_count();
            for (_, h) in self.edges_by_length(|_| true).into_iter().rev() {
                if self.mesh.faces_at(h) + self.mesh.face_count() <= faces {
                    self.split(h);
                }
            }
            if self.mesh.face_count() == before {
                break;
            }
        }
        self.compact();
        let before = self.x.clone();
        self.put_on_surface(&before);
        Ok(())
    }

    fn corners(&self, [a, b, c]: [u32; 3]) -> [Point3; 3] {
        [self.point(a), self.point(b), self.point(c)]
    }

    fn facing_of(&self, f: [u32; 3]) -> f64 {
        facing(self.corners(f), f.map(|v| &self.normal[v as usize]))
    }

    pub fn smooth_repeatedly(&mut self) {
        let before = self.x.clone();
        self.put_on_surface(&before);
        for _ in 0..self.options.smoothing {
            self.smooth();
        }
    }

    /// Every vertex moves toward the weighted centre of its faces within its tangent plane, then onto the surface.
    ///
    /// Weights are areas in units of the wanted length, so that they even out relative sizes.
    fn smooth(&mut self) {
        let moment = |f: [u32; 3]| {
            let corners = self.corners(f);
            let size = f.iter().map(|v| self.size[*v as usize]).sum::<f64>() / 3.0;
            let weight = area_vector(corners).norm() / (size * size);
            (weight * ((corners[0] + corners[1] + corners[2]) / 3.0), weight)
        };
        let mut sum = vec![(Vec3::zeros(), 0.0); self.x.len()];
        for (f, (moment, weight)) in self.of_faces(moment) {
            for v in f {
                let (moments, total) = &mut sum[v as usize];
                *moments += moment;
                *total += weight;
            }
        }
        let before = self.x.clone();
        let normal_before = self.normal.clone();
        for (i, (moment, total)) in sum.iter().enumerate() {
            let pull = moment / total.max(f64::MIN_POSITIVE) - before[i];
            let tangential = pull - self.normal[i] * self.normal[i].dot(&pull);
            self.x[i] += self.options.damping * tangential;
        }
        self.slide_along_border(&before);
        self.put_on_surface(&before);
        self.take_back_inversions(&before, &normal_before);
    }

    /// Vertices of the border move along it instead, toward the weighted centre of their two edges; those on an edge of
    /// the box stay.
    fn slide_along_border(&mut self, before: &[Point3]) {
        let Some(clip) = &self.clip else { return };
        for (i, sides) in clip.sides.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
            self.x[i] = before[i];
            let Some(ends) = self.mesh.boundary_neighbours(i as u32).filter(|_| sides.len() == 1) else {
                continue;
            };
            let mut sum = (Vec3::zeros(), 0.0);
            for end in ends.map(|v| v as usize) {
                let half = 0.5 * (before[end] - before[i]);
                let weight = half.norm() / (self.size[end] + self.size[i]);
                sum = (sum.0 + weight * half, sum.1 + weight);
            }
            let along = unit_or_zero(&sides.across().cross(&self.normal[i]));
            let pull = sum.0 / sum.1.max(f64::MIN_POSITIVE);
            self.x[i] += self.options.damping * along.dot(&pull) * along;
        }
    }

    /// Moves the corners of faces that look inward back to where they were.
    fn take_back_inversions(&mut self, before: &[Point3], normal_before: &[Vec3]) {
        let facing = self.of_faces(|f| self.facing_of(f));
        let inverted = facing.into_iter().filter(|(_, facing)| *facing <= 0.0);
        for v in inverted.flat_map(|(f, _)| f).map(|v| v as usize) {
            self.x[v] = before[v];
            self.normal[v] = normal_before[v];
        }
    }
}
