//! Fewer faces: quadric-error edge collapse (Garland & Heckbert, SIGGRAPH 1997).
//!
//! Of a large mesh, most edges are collapsed in blocks side by side ([`blocks`]); the last are collapsed in the order of the
//! errors of all ([`collapse`]).

mod blocks;
mod collapse;
mod quadric;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

use crate::parallel::Evenly;
use rayon::prelude::*;

use self::blocks::Draft;
use self::collapse::{Collapses, Vertex};
use self::quadric::Quadric;
use super::clip::{BoxSides, Clip};
use super::connectivity::Connectivity;
use super::error::BaseError;
use super::triangle_mesh::TriangleMesh;
use crate::geom::{Point3, Vec3};

/// Weight of the distance to the centroid of a face beside that to its plane. It makes the minimum unique on flat parts
/// and keeps triangles from becoming needles there; 1e-3 changes the position by a thousandth where planes differ.
const PULL: f64 = 1e-3;

/// How far a face may turn from the field's normals at its corners, as a cosine: about 78°, then anything below 90°
/// when nothing else is left.
const TURN_LIMITS: [f64; 2] = [0.2, 1e-3];

/// Meshes with fewer faces are decimated in one piece, which takes some milliseconds.
const SMALL: usize = 16_384;

/// Faces for each face wanted that are left to be collapsed in the order of their errors. Of meshes with more faces, short
/// edges are merged first: a mesh from tetrahedra has many of them, and their order costs more than the collapses.
const CHOICE: usize = 6;
/// A pass over the short edges leaves one of so many faces, or more: those along its seams are for the next one.
const MERGED: usize = 4;
/// Passes over the short edges of blocks.
const MERGES: usize = 3;

/// Faces for each face wanted that are left when no more edges are collapsed in blocks.
const LAST: f64 = 1.1;
/// Passes over the edges of blocks in the order of their errors.
const PASSES: usize = 2;
/// A pass is worth while if there are so many times more faces than wanted.
const WORTH_WHILE: f64 = 1.1;

/// Edges, or faces, that one task looks at.
const TASK: usize = 256;

/// Collapses edges in the order of their quadric error until at most `faces` faces are left; of a large mesh, in this order
/// within blocks at first.
///
/// `normals` are the field's unit normals at the vertices; no face may turn away from those of its corners. The topology
/// stays as it is; if it does not allow so few faces, the error names the count where collapsing stopped. Vertices stay
/// in the sides of the box that cuts the mesh. A closed mesh gets `faces` faces exactly, an open one perhaps one less. The
/// result does not depend on the number of threads.
pub fn decimate(mesh: &TriangleMesh, normals: &[Vec3], faces: usize) -> Result<TriangleMesh, BaseError> {
    Decimation::new(mesh, normals).to(faces)
}

/// A mesh with the quadrics of its vertices, before the first collapse: the same for any number of faces.
pub(super) struct Decimation<'a> {
    mesh: &'a TriangleMesh,
    center: Point3,
    draft: Draft,
}

impl<'a> Decimation<'a> {
    pub fn new(mesh: &'a TriangleMesh, normals: &[Vec3]) -> Self {
        // Quadrics lose digits far from the origin.
        let center = mesh.positions.first().copied().unwrap_or_default();
        Self { mesh, center, draft: Draft::new(vertices(mesh, normals, &center), mesh.faces.clone()) }
    }

    /// The mesh with at most `faces` faces, see [`decimate`].
    pub fn to(self, faces: usize) -> Result<TriangleMesh, BaseError> {
        let Self { mesh, center, mut draft } = self;
        thin_out(&mut draft, faces);
        let Draft { mut vertices, faces: left, .. } = draft;
        let Some(connectivity) = Connectivity::from_faces(vertices.len(), &left) else {
            return Ok(mesh.clone());
        };
        vertices.par_iter_mut().evenly_by(TASK).for_each(|vertex| vertex.is_locked = false);
        let mut connectivity = finish(connectivity, &mut vertices, faces)?;
        let kept = connectivity.compact();
        let of_kept = |v: &u32| &vertices[*v as usize];
        let mut positions: Vec<Point3> = kept.iter().map(|v| of_kept(v).position + center).collect();
        let clip = mesh.clip.as_ref().map(|clip| {
            let sides: Vec<BoxSides> = kept.iter().map(|v| of_kept(v).sides).collect();
            positions.iter_mut().zip(&sides).for_each(|(p, s)| *p = s.snap(*p, &clip.bounds));
            Clip { bounds: clip.bounds, sides }
        });
        Ok(TriangleMesh { positions, faces: connectivity.faces().collect(), clip })
    }
}

/// Collapses in blocks, as long as there are several, down to a little more than `faces` faces.
fn thin_out(draft: &mut Draft, faces: usize) {
    if draft.faces.len() < SMALL {
        return;
    }
    let is_far = |draft: &Draft, least: usize| {
        draft.has_blocks() && draft.faces.len() as f64 > WORTH_WHILE * least as f64
    };
    let choice = faces.saturating_mul(CHOICE);
    for _ in 0..MERGES {
        if is_far(draft, choice) {
            draft.merge_short_edges(choice.max(draft.faces.len() / MERGED));
        }
    }
    let last = (LAST * faces as f64) as usize;
    for passes_left in (1..=PASSES).rev() {
        if is_far(draft, last) {
            // Each pass takes the same share of the faces.
            let share = (last as f64 / draft.faces.len() as f64).powf(1.0 / passes_left as f64);
            draft.collapse_cheapest((share * draft.faces.len() as f64) as usize);
        }
    }
}

/// Collapses edges of the whole mesh in the order of their errors.
fn finish(mesh: Connectivity, vertices: &mut [Vertex], faces: usize) -> Result<Connectivity, BaseError> {
    let mut work = Collapses::new(mesh, vertices, TURN_LIMITS[0]);
    work.merge_short_edges(faces.saturating_mul(CHOICE));
    for limit in TURN_LIMITS {
        if work.mesh.face_count() > faces {
            work.turn_limit = limit;
            work.fill(TASK);
            work.run(faces, u64::MAX);
        }
    }
    match work.mesh.face_count() {
        least if least > faces => Err(BaseError::TooFewFaces { asked: faces, least }),
        _ => Ok(work.mesh),
    }
}

/// Vertices around a centre, with the quadrics of their faces.
fn vertices(mesh: &TriangleMesh, normals: &[Vec3], center: &Point3) -> Vec<Vertex> {
    let vertex = |(v, (position, normal)): (usize, (&Point3, &Vec3))| Vertex {
        position: position - center,
        normal: *normal,
        quadric: Quadric::ZERO,
        sides: mesh.clip.as_ref().map_or(BoxSides::NONE, |clip| clip.sides[v]),
        is_locked: false,
    };
    let given = mesh.positions.par_iter().zip(normals).enumerate();
    let mut vertices: Vec<Vertex> = given.evenly_by(TASK).map(vertex).collect();
    let of_face = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| vertices[v as usize].position);
        let n = (b - a).cross(&(c - a));
        let area = n.norm();
        (area > 0.0).then(|| Quadric::plane(&((a + b + c) / 3.0), &(n / area), area, PULL))
    };
    let of_faces: Vec<Option<Quadric>> = mesh.faces.par_iter().evenly_by(TASK).map(of_face).collect();
    for (face, quadric) in mesh.faces.iter().zip(&of_faces) {
        let Some(quadric) = quadric else { continue };
        for v in face {
            let vertex = &mut vertices[*v as usize];
            vertex.quadric = vertex.quadric.plus(quadric);
        }
    }
    vertices
}
