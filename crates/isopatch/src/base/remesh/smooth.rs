//! Vertices move within the surface, toward the centres of what is around them.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::{Remesher, TASK};
use crate::base::clip::BoxSides;
use crate::base::project::project_chunk;
use crate::base::shape::{area_vector, unit_or_zero};
use crate::geom::{Point3, Points, Vec3};
use crate::mesh::buckets::Buckets;

/// A vertex that moves farther than this times the wanted edge length has left its place: neighbours would have to follow.
const FARTHEST_MOVE: f64 = 1.0;

impl Remesher<'_> {
    /// Projects all vertices.
    pub fn put_on_surface(&mut self) {
        self.move_within_surface(|before, v| before.x[v]);
    }

    /// Moves all vertices to their targets, and from there onto the surface; one that does not arrive, or goes farther than its
    /// edges are long, stays where it is. Gives the positions and normals before.
    fn move_within_surface(
        &mut self,
        target: impl Fn(&Self, usize) -> Point3 + Sync,
    ) -> (Vec<Point3>, Vec<Vec3>) {
        let (x, normal) = self.moved(target);
        (std::mem::replace(&mut self.x, x), std::mem::replace(&mut self.normal, normal))
    }

    /// Positions and normals of the vertices once they have moved, see [`Self::move_within_surface`].
    fn moved(&self, target: impl Fn(&Self, usize) -> Point3 + Sync) -> (Vec<Point3>, Vec<Vec3>) {
        let n = self.x.len();
        let (mut x, mut normal) = (vec![Point3::zeros(); n], vec![Vec3::zeros(); n]);
        let moved = x.par_chunks_mut(TASK).zip(normal.par_chunks_mut(TASK));
        moved.enumerate().evenly().for_each(|(task, (x, normal))| {
            let first = task * TASK;
            (first..).zip(x.iter_mut()).for_each(|(v, x)| *x = target(self, v));
            self.project(first, x);
            let points: Points = x.iter().copied().collect();
            let (mut f, mut gradient) = (vec![0.0; x.len()], Points::zeros(x.len()));
            self.field.gradients(points.view(), &mut f, gradient.view_mut());
            // Without a gradient there is no normal; that is found out at the end.
            normal.iter_mut().enumerate().for_each(|(i, n)| *n = unit_or_zero(&gradient.get(i)));
        });
        (x, normal)
    }

    /// Projects new positions of the vertices from `first` on; those that are of no use become the old ones.
    fn project(&self, first: usize, x: &mut [Point3]) {
        let vertices = first..first + x.len();
        let before = &self.x[vertices.clone()];
        let sides = self.clip.as_ref().map_or(&[][..], |clip| &clip.sides[vertices.clone()]);
        let report = project_chunk(self.field, x, sides, self.diagonal, &self.options.projection);
        for i in report.failures {
            x[i] = before[i];
        }
        for (i, size) in self.size.iter().skip(first).take(x.len()).enumerate() {
            // Another sheet of the surface, not the one that the vertex belongs to.
            if (x[i] - before[i]).norm() > FARTHEST_MOVE * size {
                x[i] = before[i];
            }
        }
        if let Some(clip) = &self.clip {
            for ((x, sides), before) in x.iter_mut().zip(sides).zip(before) {
                if !clip.holds(x) {
                    *x = sides.snap(*before, &clip.bounds);
                }
            }
        }
    }

    pub fn smooth_repeatedly(&mut self) {
        let projected = || self.moved(|before, v| before.x[v]);
        let (on_surface, leaving) = rayon::join(projected, || self.mesh.leaving());
        (self.x, self.normal) = on_surface;
        for _ in 0..self.options.smoothing {
            self.smooth(&leaving);
        }
    }

    /// Every vertex moves toward the weighted centre of its faces within its tangent plane, or of its edges along the border, then
    /// onto the surface.
    fn smooth(&mut self, leaving: &Buckets) {
        let faces = self.mesh.faces_in_parallel().evenly_by(TASK);
        let moments: Vec<(Vec3, f64)> = faces.map(|face| self.moment(face)).collect();
        let (before, normal_before) = self.move_within_surface(|before, v| match before.sides(v as u32) {
            BoxSides::NONE => {
                let around = leaving.get(v).iter().map(|h| &moments[*h as usize / 3]);
                before.toward_centre(v, around)
            }
            sides => before.along_border(v, sides),
        });
        self.take_back_inversions(&before, &normal_before);
    }

    /// The weighted centre of a face, times its weight, and that weight: the area in units of the wanted length, so that relative
    /// sizes are evened out.
    fn moment(&self, face: [u32; 3]) -> (Vec3, f64) {
        let corners = self.corners(face);
        let size = face.iter().map(|v| self.size[*v as usize]).sum::<f64>() / 3.0;
        let weight = area_vector(corners).norm() / (size * size);
        (weight * ((corners[0] + corners[1] + corners[2]) / 3.0), weight)
    }

    fn toward_centre<'m>(&self, v: usize, moments: impl Iterator<Item = &'m (Vec3, f64)>) -> Point3 {
        let (mut sum, mut total) = (Vec3::zeros(), 0.0);
        for (moment, weight) in moments {
            sum += moment;
            total += weight;
        }
        let pull = sum / total.max(f64::MIN_POSITIVE) - self.x[v];
        let tangential = pull - self.normal[v] * self.normal[v].dot(&pull);
        self.x[v] + self.options.damping * tangential
    }

    /// Where a vertex of the border goes; those on an edge of the box stay.
    fn along_border(&self, v: usize, sides: BoxSides) -> Point3 {
        let here = self.x[v];
        let Some(ends) = self.mesh.boundary_neighbours(v as u32).filter(|_| sides.len() == 1) else {
            return here;
        };
        let mut sum = (Vec3::zeros(), 0.0);
        for end in ends.map(|v| v as usize) {
            let half = 0.5 * (self.x[end] - here);
            let weight = half.norm() / (self.size[end] + self.size[v]);
            sum = (sum.0 + weight * half, sum.1 + weight);
        }
        let along = unit_or_zero(&sides.across().cross(&self.normal[v]));
        let pull = sum.0 / sum.1.max(f64::MIN_POSITIVE);
        here + self.options.damping * along.dot(&pull) * along
    }

    /// Moves the corners of faces that look inward back to where they were.
    fn take_back_inversions(&mut self, before: &[Point3], normal_before: &[Vec3]) {
        let faces = self.mesh.faces_in_parallel().evenly_by(TASK);
        let inverted: Vec<[u32; 3]> = faces.filter(|face| self.facing_of(*face) <= 0.0).collect();
        for v in inverted.into_iter().flatten().map(|v| v as usize) {
            self.x[v] = before[v];
            self.normal[v] = normal_before[v];
        }
    }
}
