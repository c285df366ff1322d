//! Well-shaped triangles: splits, collapses, flips and tangential smoothing on the surface, guided by edge lengths
//! (Botsch & Kobbelt, SGP 2004, with lengths from the curvature).

mod collapse;
mod flip;
mod smooth;

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::jets::of_jets;
use super::project::ProjectOptions;
use super::shape::{area_vector, facing, largest_curvature, unit_or_zero};
use super::sizing::{
    FaceAreas, SizingOptions, UNIT_TRIANGLE, blend_with_curvature, sizes_for_count, sizes_from_errors,
    stretch,
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

/// Meshes with fewer faces fit into the cache of a core, in any order.
const SORTED: usize = 8_192;

/// Edges, faces or vertices that one task looks at.
const TASK: usize = 64;

/// A mesh that is being changed, with what is known at its vertices.
pub(super) struct Remesher<'a> {
    pub field: &'a dyn Field,
    pub options: &'a RemeshOptions,
    pub diagonal: f64,
    pub mesh: Connectivity,
    pub x: Vec<Point3>,
    pub normal: Vec<Vec3>,
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
    let Some(mut work) = Remesher::new(field, mesh, lengths, diagonal, options) else {
        return Ok(mesh.clone());
    };
    work.put_on_surface();
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

impl<'a> Remesher<'a> {
    /// None if more than one boundary passes through a vertex.
    fn new(
        field: &'a dyn Field,
        mesh: &TriangleMesh,
        lengths: Option<&[f64]>,
        diagonal: f64,
        options: &'a RemeshOptions,
    ) -> Option<Self> {
        let count = mesh.positions.len();
        Some(Self {
            field,
            options,
            diagonal,
            mesh: Connectivity::from_faces(count, &mesh.faces)?,
            x: mesh.positions.clone(),
            normal: Vec::new(),
            // Any length will do, until lengths are chosen.
            size: vec![f64::INFINITY; count],
            metric: vec![Mat3::identity(); count],
            relative: lengths.map_or_else(|| vec![1.0; count], <[f64]>::to_vec),
            given_lengths: lengths.is_some(),
            clip: mesh.clip.clone(),
        })
    }
}

impl Remesher<'_> {
    pub fn update_sizes(&mut self, faces: usize) {
        // What one thread does alone goes beside what all of them share.
        let (tensor, edges) = rayon::join(|| self.curvature_tensors(), || self.mesh.edge_ends());
        let curvature: Vec<f64> = tensor.par_iter().evenly_by(TASK).map(largest_curvature).collect();
        let (relative, (caps, areas)) = rayon::join(
            || (!self.given_lengths).then(|| self.lengths_from_errors(&edges, &tensor, &curvature)),
            || (self.lean_caps(), FaceAreas::new(&self.mesh, &self.x)),
        );
        if let Some(relative) = relative {
            self.relative = relative;
        }
        let sizing = &self.options.sizing;
        let pairs = tensor.par_iter().zip(&self.normal).evenly_by(TASK);
        (self.size, self.metric) = rayon::join(
            || sizes_for_count(&areas, &edges, &self.x, &curvature, &self.relative, &caps, faces, sizing),
            || pairs.map(|(m, n)| stretch(m, n, sizing)).collect(),
        );
    }

    /// Curvature tensors at the vertices; without a gradient there is none, which is found out at the end.
    fn curvature_tensors(&self) -> Vec<Mat3> {
        let finite = |m: Mat3| if m.sum().is_finite() { m } else { Mat3::zeros() };
        of_jets(self.field, &self.x, |jet| finite(jet.curvature_tensor()))
    }

    /// Relative edge lengths at the vertices, from the surface.
    fn lengths_from_errors(&self, edges: &[[usize; 2]], tensor: &[Mat3], curvature: &[f64]) -> Vec<f64> {
        let errors = sizes_from_errors(self.field, edges, &self.x, &self.normal, tensor);
        blend_with_curvature(errors, curvature, &self.options.sizing)
    }

    /// Edge lengths at each vertex for which its faces would lean just as far from their normals as they may.
    fn lean_caps(&self) -> Vec<f64> {
        let longest = |f: [u32; 3]| {
            let lean = self.facing_of(f).clamp(-1.0, 1.0).acos();
            let length = (area_vector(self.corners(f)).norm() / (2.0 * UNIT_TRIANGLE)).sqrt();
            length * self.options.sizing.lean.to_radians() / lean
        };
        let mut cap = vec![f64::INFINITY; self.x.len()];
        let lengths: Vec<f64> = self.mesh.faces_in_parallel().evenly_by(TASK).map(longest).collect();
        for (f, longest) in self.mesh.faces().zip(lengths) {
            for v in f {
                cap[v as usize] = cap[v as usize].min(longest);
            }
        }
        cap
    }

    /// Renumbers vertices after splits and removals. What is known of the surface there, and the metric, are to be found anew.
    fn compact(&mut self) {
        let kept = if self.mesh.face_count() < SORTED { self.mesh.compact() } else { self.sorted() };
        let pick = |i: &u32| *i as usize;
        self.x = kept.iter().map(|i| self.x[pick(i)]).collect();
        self.size = kept.iter().map(|i| self.size[pick(i)]).collect();
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
        let all = self.mesh.edges();
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
        // A split gives other edges of its faces new numbers.
        while self.remove_some_bridges() {}
        self.put_on_surface();
    }

    /// One look at every edge for [`Remesher::remove_bridges`]; was one split?
    fn remove_some_bridges(&mut self) -> bool {
        let before = self.mesh.face_count();
        for h in self.mesh.edges() {
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
        self.mesh.face_count() > before
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
        self.put_on_surface();
        Ok(())
    }

    fn corners(&self, [a, b, c]: [u32; 3]) -> [Point3; 3] {
        [self.point(a), self.point(b), self.point(c)]
    }

    fn facing_of(&self, f: [u32; 3]) -> f64 {
        facing(self.corners(f), f.map(|v| &self.normal[v as usize]))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;
    use crate::base::test_fields::{CHAIR, cube, field};
    use crate::base::{SeedOptions, seed_mesh};
    use crate::geom::Aabb;

    /// Half a torus by six faces: every vertex is in the side that cuts it, so that every edge inside is a bridge, and the edges
    /// to flip one to are there already.
    #[test]
    fn bridges_that_cannot_be_flipped_are_split() {
        let torus = field("(sqrt(x^2+y^2)-2)^2+z^2-1");
        let bounds = Aabb::new([-3.5, -3.5, 0.0].into(), [3.5, 3.5, 1.5].into());
        let circle = |radius: f64, degrees: [f64; 3]| {
            degrees.map(|d| Point3::new(radius * d.to_radians().cos(), radius * d.to_radians().sin(), 0.0))
        };
        let positions = [circle(1.0, [60.0, 120.0, 240.0]), circle(3.0, [0.0, 120.0, 240.0])].concat();
        let sides = positions.iter().map(|p| BoxSides::of(p, &bounds)).collect();
        let faces = vec![[0, 3, 4], [3, 0, 2], [3, 2, 5], [2, 4, 5], [1, 4, 2], [0, 4, 1]];
        let mesh = TriangleMesh { positions, faces, clip: Some(Clip { bounds, sides }) };
        let options = RemeshOptions::default();
        let mut work = Remesher::new(&torus, &mesh, None, 7.0, &options).unwrap();
        work.put_on_surface();
        work.remove_bridges();
        assert!(work.mesh.face_count() > mesh.faces.len());
        let is_bridge = |h: &u32| {
            let [a, b] = [work.mesh.origin(*h), work.mesh.dest(*h)].map(|v| work.sides(v));
            !work.mesh.is_boundary(*h) && !a.common(b).is_empty()
        };
        assert!(!work.mesh.edges().iter().any(is_bridge));
        assert_eq!([work.size.len(), work.metric.len()], [work.x.len(); 2]);
    }

    /// What remeshing does to faces and positions of a mesh with too many of them, when it has sizes.
    fn after(text: &str, change: impl Fn(&mut Remesher<'_>)) -> (Vec<[u32; 3]>, Vec<Point3>) {
        let field = field(text);
        let seed = seed_mesh(&field, &cube(6.0), None, &SeedOptions::default()).unwrap();
        let options = RemeshOptions::default();
        let mut work = Remesher::new(&field, &seed.mesh, None, seed.diagonal, &options).unwrap();
        work.put_on_surface();
        work.remove_bridges();
        work.update_sizes(seed.mesh.faces.len() / 3);
        change(&mut work);
        assert!(work.mesh.face_count() > 0);
        (work.mesh.faces().collect(), work.x)
    }

    #[test]
    fn collapses_that_are_tried_beforehand_are_those_of_one_after_the_other() {
        for text in [CHAIR, "x^2+y^2-4"] {
            let together = after(text, |work| work.collapse_short());
            let in_turn = after(text, |work| {
                for (_, h) in work.edges_by_length(|l| l < collapse::SHORT) {
                    if work.mesh.is_half_edge(h) && work.relative_length(h) < collapse::SHORT {
                        work.try_collapse(h, LONG);
                    }
                }
            });
            let before = after(text, |_| {});
            assert!(4 * together.0.len() < 3 * before.0.len(), "many are collapsed");
            assert_eq!(together, in_turn);
        }
    }

    #[test]
    fn flips_that_are_tried_beforehand_are_those_of_one_after_the_other() {
        for text in [CHAIR, "x^2+y^2-4"] {
            let before = after(text, |_| {});
            let together = after(text, |work| assert!(work.flip_for_angle_once() > 0));
            let in_turn = after(text, |work| {
                for h in work.mesh.edges() {
                    if work.is_better_flipped(h) && work.can_flip(h) {
                        work.mesh.flip(h);
                    }
                }
            });
            assert_ne!(together, before);
            assert_eq!(together, in_turn);
        }
    }
}
