//! Surfaces through corners of the box that cuts them: a period of a gyroid passes through all eight.
//!
//! ```text
//!      C───A─────── edge of the box       The polygons end on the edges beside C, where signs change: at A, or at A and B
//!      │  ╱                               with a piece of border between them in the side that both edges bound. All of it
//!      B ╱   f < 0                        is C itself, so it is merged into one vertex, which lies in three sides.
//!      │╱
//! ```

use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::project::{ProjectOptions, project_positions};
use super::triangle_mesh::TriangleMesh;
use crate::field::Field;
use crate::geom::{Aabb, Point3};

/// A surface that is nearer to a corner than this share of the diagonal passes through it: far below any tolerance, and
/// above what the rounding of π in a box does to a periodic formula.
const REACH: f64 = 1e-10;

/// Vertices between A and B, at most: the cells at a corner are not larger than their neighbours.
const LONGEST: usize = 32;

/// Merges the vertices that belong to a corner of the box through which the surface passes.
pub(super) fn gather_at_corners(field: &dyn Field, mesh: TriangleMesh) -> Result<TriangleMesh, BaseError> {
    let Some(clip) = &mesh.clip else { return Ok(mesh) };
    let bounds = clip.bounds;
    let reach = REACH * Aabb::around(&mesh.positions).diagonal();
    let passes = |corner: &Point3| {
        let (f, gradient) = field.gradient(*corner);
        f.abs() <= reach * gradient.norm()
    };
    let passed: Vec<Point3> = bounds.corners().into_iter().filter(passes).collect();
    if passed.is_empty() {
        return Ok(mesh);
    }
    let Some(connectivity) = Connectivity::from_faces(mesh.positions.len(), &mesh.faces) else {
        return Ok(mesh);
    };
    let mut work =
        Gathering { connectivity, sides: clip.sides.clone(), positions: mesh.positions.clone(), bounds };
    for corner in passed {
        let here = work.vertices_of(field, &corner, reach);
        work.gather(&here, corner).ok_or(BaseError::TouchesCorner { at: corner })?;
    }
    Ok(work.finish())
}

struct Gathering {
    connectivity: Connectivity,
    sides: Vec<BoxSides>,
    positions: Vec<Point3>,
    bounds: Aabb,
}

impl Gathering {
    /// The vertices on edges of the box that would be put on the corner.
    fn vertices_of(&self, field: &dyn Field, corner: &Point3, reach: f64) -> Vec<u32> {
        let sides = BoxSides::of(corner, &self.bounds);
        let on_its_edges =
            |v: &u32| self.sides[*v as usize].len() == 2 && sides.contains_all(self.sides[*v as usize]);
        let candidates: Vec<u32> = self.connectivity.vertices().filter(on_its_edges).collect();
        let at = |v: &u32| self.positions[*v as usize];
        let mut positions: Vec<Point3> = candidates.iter().map(at).collect();
        let its_sides: Vec<BoxSides> = candidates.iter().map(|v| self.sides[*v as usize]).collect();
        let diagonal = self.bounds.diagonal();
        project_positions(field, &mut positions, &its_sides, diagonal, &ProjectOptions::default());
        let arrived = |p: &Point3| (p - corner).norm() <= 2.0 * reach;
        candidates.into_iter().zip(&positions).filter(|(_, p)| arrived(p)).map(|(v, _)| v).collect()
    }

    /// Makes one vertex of them; none if the border between them cannot be closed up.
    fn gather(&mut self, here: &[u32], corner: Point3) -> Option<()> {
        let kept = match here {
            [] => return Some(()),
            [a] => *a,
            [a, b] => self.join(*a, *b)?,
            // The surface only touches the box there.
            _ => return None,
        };
        self.sides[kept as usize] = BoxSides::of(&corner, &self.bounds);
        self.positions[kept as usize] = corner;
        Some(())
    }

    /// Merges all vertices of the border between two into one.
    fn join(&mut self, a: u32, b: u32) -> Option<u32> {
        let (start, steps) = match self.steps_along_border(a, b) {
            Some(steps) => (a, steps),
            None => (b, self.steps_along_border(b, a)?),
        };
        for _ in 0..steps {
            let h = self.connectivity.boundary_from(start).filter(|h| self.connectivity.can_collapse(*h))?;
            self.connectivity.collapse(h);
        }
        Some(start)
    }

    /// The number of edges of the border from one vertex on to another, if they all lie in a common side.
    fn steps_along_border(&self, from: u32, to: u32) -> Option<usize> {
        let side = self.sides[from as usize].common(self.sides[to as usize]);
        let onward = |v: &u32| self.connectivity.boundary_neighbours(*v).map(|[_, next]| next);
        let steps = std::iter::successors(Some(from), onward)
            .take(LONGEST)
            .take_while(|v| self.sides[*v as usize].contains_all(side))
            .position(|v| v == to)?;
        (steps > 0).then_some(steps)
    }

    fn finish(mut self) -> TriangleMesh {
        let kept = self.connectivity.compact();
        let sides = kept.iter().map(|v| self.sides[*v as usize]).collect();
        TriangleMesh {
            positions: kept.iter().map(|v| self.positions[*v as usize]).collect(),
            faces: self.connectivity.faces().collect(),
            clip: Some(Clip { bounds: self.bounds, sides }),
        }
    }
}
