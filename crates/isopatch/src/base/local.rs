//! A base mesh under local changes, and parts of base meshes.

use super::base_mesh::BaseMesh;
use super::batch::Batch;
use super::build::{BaseOptions, base_of};
use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::failures::Failures;
use super::project::project_point;
use super::shape::{area_vector, unit_or_zero};
use super::validity::ValidityLimits;
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::mesh::{FaceId, VertexId};

/// Leans and turns over their limits by this factor are not hoped to get valid: on four surfaces of Tong & Kim 2009, of collapses whose
/// faces are so after one relaxation, two in a thousand would.
const HOPELESS: f64 = 1.3;
/// Corners of a slot without a face.
pub(super) const REMOVED: [u32; 3] = [u32::MAX; 3];

/// What is known of a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub x: Point3,
    pub normal: Vec3,
    pub tensor: Mat3,
    /// The sides of the box that it stays in.
    pub sides: BoxSides,
}

/// A base mesh whose faces have slots that stay theirs while other faces come and go.
///
/// A face has the same stamp as long as its corners are the same vertices at the same places.
pub struct Draft<'a> {
    pub(super) field: &'a dyn Field,
    pub(super) options: &'a BaseOptions,
    pub(super) diagonal: f64,
    limits: Cosines,
    /// Beyond these no change is hoped for.
    hopeless: Cosines,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) stamps: Vec<u64>,
    pub(super) last_stamp: u64,
    pub(super) vertices: Vec<Vertex>,
    pub(super) failures: Failures,
    /// The box that cuts the mesh.
    bounds: Option<Aabb>,
}

/// What a collapse did.
#[derive(Clone, Debug)]
pub struct Change {
    /// Slots with the corners and stamps that they had.
    pub(super) slots: Vec<(u32, [u32; 3], u64)>,
    /// The merged vertex as it was.
    pub(super) vertex: (u32, Vertex),
}

impl Change {
    /// Slots whose faces it changed or removed.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        self.slots.iter().map(|s| s.0)
    }
}

/// [`ValidityLimits`] with angles as cosines.
#[derive(Clone, Copy)]
struct Cosines {
    smallest_corner: f64,
    largest_corner: f64,
    facet_deviation: f64,
    curvature_length: f64,
}

impl From<&ValidityLimits> for Cosines {
    fn from(limits: &ValidityLimits) -> Self {
        let cosine = |degrees: f64| degrees.to_radians().cos();
        Self {
            smallest_corner: cosine(limits.smallest_corner),
            largest_corner: cosine(limits.largest_corner),
            facet_deviation: cosine(limits.facet_deviation),
            curvature_length: limits.curvature_length,
        }
    }
}

impl<'a> Draft<'a> {
    /// The faces of a base mesh, each in the slot of its number. Its diagonal is frozen.
    pub fn new(field: &'a dyn Field, base: &BaseMesh, options: &'a BaseOptions) -> Self {
        let faces: Vec<[u32; 3]> = base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| v.0)).collect();
        let sides = |v: usize| base.clip.as_ref().map_or(BoxSides::NONE, |c| c.sides[v]);
        let vertices: Vec<Vertex> = (0..base.positions.len())
            .map(|v| Vertex {
                x: base.positions[v],
                normal: base.normals[v],
                tensor: base.curvatures[v],
                sides: sides(v),
            })
            .collect();
        let last_stamp = faces.len() as u64;
        Self {
            field,
            options,
            diagonal: base.diagonal(),
            limits: Cosines::from(&options.limits),
            hopeless: Cosines::from(&ValidityLimits {
                facet_deviation: HOPELESS * options.limits.facet_deviation,
                curvature_length: HOPELESS * options.limits.curvature_length,
                ..options.limits
            }),
            stamps: (0..last_stamp).collect(),
            failures: Failures::new(vertices.len(), faces.len()),
            faces,
            last_stamp,
            vertices,
            bounds: base.clip.as_ref().map(|c| c.bounds),
        }
    }

    /// The slots with a face, in order: face i of [`Draft::base`] is in slot i of these.
    pub fn live(&self) -> Vec<u32> {
        (0..self.faces.len() as u32).filter(|s| self.faces[*s as usize] != REMOVED).collect()
    }

    /// Number of slots, with a face or not.
    pub fn slot_count(&self) -> usize {
        self.faces.len()
    }

    /// Stamps of the faces of [`Draft::base`].
    pub fn live_stamps(&self) -> Vec<u64> {
        self.live().into_iter().map(|s| self.stamps[s as usize]).collect()
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.faces.iter().filter(|f| **f != REMOVED).count()
    }

    /// The base mesh as it is now: faces in the order of their slots, and vertices in that of their numbers.
    pub fn base(&self) -> Result<BaseMesh, BaseError> {
        let live: Vec<[u32; 3]> = self.faces.iter().filter(|f| **f != REMOVED).copied().collect();
        let (faces, kept) = renumbered(self.vertices.len(), &live);
        let of = |v: &u32| &self.vertices[*v as usize];
        let sides = || kept.iter().map(|v| of(v).sides).collect();
        let base = base_of(
            &faces,
            kept.iter().map(|v| of(v).x).collect(),
            kept.iter().map(|v| of(v).normal).collect(),
            kept.iter().map(|v| of(v).tensor).collect(),
            self.bounds.map(|bounds| Clip { bounds, sides: sides() }),
        )?;
        Ok(BaseMesh { frozen_diagonal: Some(self.diagonal), ..base })
    }

    /// Begins changes that do not touch each other; none for a mesh that is no manifold.
    pub fn batch(&mut self) -> Option<Batch<'_, 'a>> {
        let slots = self.live();
        let faces: Vec<[u32; 3]> = slots.iter().map(|s| self.faces[*s as usize]).collect();
        let mesh = Connectivity::from_faces(self.vertices.len(), &faces)?;
        Some(Batch::new(self, mesh, slots))
    }

    /// Takes a change back, before any later change touches it.
    pub fn undo(&mut self, change: &Change) {
        self.failures.change(change.slots.iter().flat_map(|(_, corners, _)| *corners));
        for (slot, corners, stamp) in &change.slots {
            self.faces[*slot as usize] = *corners;
            self.stamps[*slot as usize] = *stamp;
        }
        self.vertices[change.vertex.0 as usize] = change.vertex.1;
    }

    pub(super) fn point(&self, v: u32) -> Point3 {
        self.vertices[v as usize].x
    }

    /// What is known of the corners of a face.
    pub(super) fn corners(&self, face: [u32; 3]) -> [&Vertex; 3] {
        face.map(|v| &self.vertices[v as usize])
    }

    /// Is the face within the limits of [`super::validity`], valences aside?
    pub(super) fn is_valid(&self, [a, b, c]: [&Vertex; 3]) -> bool {
        let limits = &self.limits;
        let area = area_vector([a.x, b.x, c.x]);
        let least = limits.facet_deviation * area.norm();
        let bends = |m: &Mat3, d: Vec3| (m * d).norm_squared() >= limits.curvature_length.powi(2);
        [(a, b, c), (b, c, a), (c, a, b)].into_iter().all(|(p, q, r)| {
            let (d, e) = (q.x - p.x, r.x - p.x);
            // Sine and cosine of the corner in the tangent plane, times the same length; with a sine above zero, the
            // angle is monotone in the cosine.
            let sine = area.dot(&p.normal);
            let cosine = d.dot(&e) - d.dot(&p.normal) * e.dot(&p.normal);
            let length = (sine * sine + cosine * cosine).sqrt();
            sine > 0.0
                && sine > least
                && cosine < limits.smallest_corner * length
                && cosine > limits.largest_corner * length
                && !bends(&p.tensor, d)
                && !bends(&p.tensor, e)
        })
    }

    /// Does the face lean, or bend, so far beyond its limits that moving its corners will hardly make it valid?
    pub(super) fn is_hopeless(&self, [a, b, c]: [&Vertex; 3]) -> bool {
        let area = area_vector([a.x, b.x, c.x]);
        let least = self.hopeless.facet_deviation * area.norm();
        let bends = |m: &Mat3, d: Vec3| (m * d).norm_squared() > self.hopeless.curvature_length.powi(2);
        [(a, b, c), (b, c, a), (c, a, b)].into_iter().any(|(p, q, r)| {
            area.dot(&p.normal) < least || bends(&p.tensor, q.x - p.x) || bends(&p.tensor, r.x - p.x)
        })
    }

    /// A vertex on the surface, near `x` and in its sides of the box, if there is one.
    pub(super) fn placed(&self, x: Point3, sides: BoxSides) -> Option<Vertex> {
        let projection = &self.options.remesh.projection;
        let x = project_point(self.field, x, sides, self.diagonal, projection)?;
        let jet = self.field.jet(x);
        let vertex = Vertex { x, normal: unit_or_zero(&jet.gradient), tensor: jet.curvature_tensor(), sides };
        let in_box = self.bounds.is_none_or(|bounds| Clip { bounds, sides: Vec::new() }.holds(&x));
        (in_box && vertex.tensor.sum().is_finite() && vertex.normal.norm() > 0.0).then_some(vertex)
    }
}

/// Faces with their vertices numbered without gaps, in the same order; and the former number of each.
fn renumbered(vertex_count: usize, faces: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut number = vec![u32::MAX; vertex_count];
    faces.iter().flatten().for_each(|v| number[*v as usize] = 0);
    let kept: Vec<u32> = (0..vertex_count as u32).filter(|v| number[*v as usize] == 0).collect();
    kept.iter().enumerate().for_each(|(new, old)| number[*old as usize] = new as u32);
    (faces.iter().map(|f| f.map(|v| number[v as usize])).collect(), kept)
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
    // All faces at such a vertex are taken; that may make others such.
    loop {
        let split: Vec<VertexId> = mesh.vertices().filter(|v| fans(base, *v, &wanted) > 1).collect();
        if split.is_empty() {
            break;
        }
        for v in split {
            mesh.ring(v).for_each(|h| wanted[mesh.face(h).index()] = true);
        }
    }
    let faces: Vec<usize> = (0..wanted.len()).filter(|f| wanted[*f]).collect();
    let corners: Vec<[u32; 3]> = faces.iter().map(|f| mesh.triangle(FaceId::from(*f)).map(|v| v.0)).collect();
    let (triangles, vertices) = renumbered(mesh.vertex_count(), &corners);
    let clip = base.clip.as_ref().map(|clip| Clip {
        bounds: clip.bounds,
        sides: vertices.iter().map(|v| clip.sides[*v as usize]).collect(),
    });
    let base = base_of(
        &triangles,
        vertices.iter().map(|v| base.positions[*v as usize]).collect(),
        vertices.iter().map(|v| base.normals[*v as usize]).collect(),
        vertices.iter().map(|v| base.curvatures[*v as usize]).collect(),
        clip,
    )?;
    Ok(Part { base, faces, vertices })
}

/// Number of connected fans that the wanted faces at a vertex form.
fn fans(base: &BaseMesh, v: VertexId, wanted: &[bool]) -> usize {
    let ring: Vec<bool> = base.mesh.ring(v).map(|h| wanted[base.mesh.face(h).index()]).collect();
    let wraps = !base.mesh.is_boundary_vertex(v);
    let before = |i: usize| match i {
        0 => wraps && ring[ring.len() - 1] && ring.iter().any(|w| !w),
        i => ring[i - 1],
    };
    (0..ring.len()).filter(|i| ring[*i] && !before(*i)).count()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;
    use crate::base::test_fields::{DODECA, cube, field};
    use crate::base::{build, validity};

    fn dodeca() -> (crate::field::Formula, BaseMesh, BaseOptions) {
        let field = field(DODECA);
        let options = BaseOptions { faces: Some(400), ..BaseOptions::default() };
        let base = build(&field, &cube(1.2), &options).unwrap().base;
        (field, base, options)
    }

    #[test]
    fn collapses_leave_a_valid_mesh_of_the_same_topology_and_can_be_taken_back() {
        let (field, base, options) = dodeca();
        let mut draft = Draft::new(&field, &base, &options);
        let mut batch = draft.batch().unwrap();
        let changes: Vec<Change> = batch.edges().into_iter().filter_map(|h| batch.collapse(h)).collect();
        assert!(changes.len() > 5);
        let coarser = draft.base().unwrap();
        assert_eq!(coarser.mesh.face_count(), 400 - 2 * changes.len());
        assert_eq!(coarser.mesh.euler_number(), base.mesh.euler_number());
        assert_eq!(validity(&coarser, &options.limits), []);
        assert_eq!(coarser.diagonal(), base.diagonal());

        changes.iter().for_each(|change| draft.undo(change));
        let again = draft.base().unwrap();
        assert_eq!((again.mesh, again.positions), (base.mesh, base.positions));
    }

    #[test]
    fn collapses_side_by_side_are_those_in_order_with_and_without_a_border() {
        let open = field("x^2+y^2+0.1sin(3z)-0.4");
        let options = BaseOptions { faces: Some(900), ..BaseOptions::default() };
        let tube = build(&open, &cube(1.0), &options).unwrap().base;
        let (closed, dodeca, _) = dodeca();
        for (field, base) in [(&open, &tube), (&closed, &dodeca)] {
            let collapsed = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut draft = Draft::new(field, base, &options);
                    let mut batch = draft.batch().unwrap();
                    let count = batch.collapse_in_order(&batch.edges()).len();
                    (count, draft.base().unwrap())
                })
            };
            let (count, one) = collapsed(1);
            assert!(count > 10 && one.mesh.is_closed() == base.mesh.is_closed(), "{count}");
            assert_eq!(one.mesh.euler_number(), base.mesh.euler_number());
            // What the stars took for valid is valid in the mesh.
            assert_eq!(validity(&one, &options.limits), []);
            for threads in [2, 3] {
                let (again, several) = collapsed(threads);
                assert_eq!(again, count);
                assert!(several.mesh == one.mesh && several.positions == one.positions, "{threads} threads");
            }
        }
    }

    #[test]
    fn what_failed_fails_again_until_something_changes_near_it() {
        let (field, base, options) = dodeca();
        let rounds = |trusted: bool| {
            let mut draft = Draft::new(&field, &base, &options);
            let (mut counts, mut skipped) = (Vec::new(), 0);
            for round in 0..30 {
                let mut batch = draft.batch().unwrap();
                let mut edges = batch.edges();
                let all = edges.len();
                edges.retain(|h| !trusted || !batch.fails_again(*h));
                skipped += all - edges.len();
                let changes: Vec<Change> = edges.into_iter().filter_map(|h| batch.collapse(h)).collect();
                counts.push(changes.len());
                match round {
                    1 => draft.undo(&changes[0]),
                    20 => {
                        let mut batch = draft.batch().unwrap();
                        assert!((0..20).any(|f| batch.split(batch.most_turned_side(f))));
                    }
                    _ => {}
                }
            }
            (counts, skipped, draft.base().unwrap())
        };
        let (all, trusted) = (rounds(false), rounds(true));
        assert!(all.0 == trusted.0 && all.2.mesh == trusted.2.mesh && all.2.positions == trusted.2.positions);
        assert!(all.0[..4].iter().sum::<usize>() > 20 && trusted.1 > 1_000, "{:?} {}", all.0, trusted.1);
    }

    #[test]
    fn splits_add_vertices_on_the_surface() {
        let (field, base, options) = dodeca();
        let mut draft = Draft::new(&field, &base, &options);
        let mut batch = draft.batch().unwrap();
        let splits = (0..400).filter(|f| batch.split(batch.most_turned_side(*f))).count();
        assert!(splits > 20);
        let finer = draft.base().unwrap();
        assert_eq!(finer.mesh.face_count(), 400 + 2 * splits);
        assert_eq!(finer.mesh.euler_number(), 2);
        assert_eq!(validity(&finer, &options.limits), []);
        assert!(finer.positions.iter().all(|p| field.value(*p).abs() < 1e-11));
    }

    #[test]
    fn a_part_keeps_the_order_of_the_whole() {
        let (_, base, _) = dodeca();
        let wanted: Vec<bool> = (0..400).map(|f| f % 7 == 0).collect();
        let part = part(&base, &wanted).unwrap();
        assert!(part.faces.is_sorted() && part.vertices.is_sorted());
        assert!((0..400).filter(|f| wanted[*f]).all(|f| part.faces.contains(&f)));
        for (i, v) in part.vertices.iter().enumerate() {
            assert_eq!(part.base.positions[i], base.positions[*v as usize]);
        }
    }
}
