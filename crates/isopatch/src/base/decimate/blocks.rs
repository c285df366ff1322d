//! Collapses in blocks of the mesh, side by side.
//!
//! Planes cut the mesh into blocks of equally many vertices. A block has the faces between its own vertices; all others lie
//! along the seams, and their corners stay as they are: what one block changes is not seen from another. The next pass has
//! its seams elsewhere. Blocks depend on the mesh only, not on the number of threads, and their heaps fit into the cache.
//!
//! ```text
//!    ─○──○──●───●──○──○─      ○ may be merged within its block
//!      ╲╱ ╲╱ ╲ ╱ ╲╱ ╲╱        ● at a seam, locked
//!    ─○──○──●───●──○──○─
//!       one  seam another
//! ```

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::collapse::{Collapses, Vertex};
use super::{TASK, TURN_LIMITS};
use crate::base::connectivity::Connectivity;

/// Vertices of a block: with all that belongs to them some 500 kB, which stay in the cache of a core.
const BLOCK: usize = 2048;

/// The number of a vertex that is no longer in use.
const NONE: u32 = u32::MAX;

/// Limits of the costs in a pass, one after the other.
const LIMITS: usize = 8;
/// One of so many candidates is looked at when a limit is chosen.
const SAMPLED: usize = 4;
/// A pass may end with so many collapses left to do, as a share of the faces.
const NEAR: f64 = 0.02;

/// A mesh while it loses faces.
pub(super) struct Draft {
    /// Those in use, and others.
    pub vertices: Vec<Vertex>,
    pub faces: Vec<[u32; 3]>,
    passes: usize,
}

/// A vertex in use, and roughly where it is.
#[derive(Clone, Copy)]
struct Place {
    at: [f32; 3],
    vertex: u32,
}

/// The faces of a mesh by blocks of its vertices.
struct Division {
    /// Faces of each block, with numbers from its first vertex on.
    inside: Vec<Vec<[u32; 3]>>,
    /// Faces between blocks.
    seams: Vec<[u32; 3]>,
}

impl Draft {
    pub fn new(vertices: Vec<Vertex>, faces: Vec<[u32; 3]>) -> Self {
        Self { vertices, faces, passes: 0 }
    }

    /// Are there more than two blocks that can work side by side?
    pub fn has_blocks(&self) -> bool {
        // A vertex for two faces.
        self.faces.len() > 4 * BLOCK
    }

    /// Merges short edges until about `faces` faces are left.
    pub fn merge_short_edges(&mut self, faces: usize) {
        let share = faces as f64 / self.faces.len() as f64;
        self.pass(|blocks, _| {
            blocks.par_iter_mut().evenly().for_each(|block| {
                let faces = share * block.mesh.face_count() as f64;
                block.merge_short_edges(faces as usize);
            });
        });
    }

    /// Collapses edges in each block in the order of their costs, up to a limit common to all, until about `faces` faces
    /// are left.
    pub fn collapse_cheapest(&mut self, faces: usize) {
        self.pass(|blocks, seams| {
            blocks.par_iter_mut().evenly().for_each(|block| block.fill(usize::MAX));
            for _ in 0..LIMITS {
                let count = seams + blocks.iter().map(|block| block.mesh.face_count()).sum::<usize>();
                let collapses = count.saturating_sub(faces) / 2;
                if collapses as f64 <= NEAR * faces as f64 || !collapse_some(blocks, collapses) {
                    return;
                }
            }
        });
    }

    /// Lets blocks work side by side; `work` also learns the number of faces between them.
    pub fn pass(&mut self, work: impl FnOnce(&mut [Collapses<'_>], usize)) {
        self.arrange();
        let Division { inside, seams } = self.divide();
        self.vertices.par_iter_mut().for_each(|vertex| vertex.is_locked = false);
        seams.iter().flatten().for_each(|v| self.vertices[*v as usize].is_locked = true);
        let parts = self.vertices.par_chunks_mut(BLOCK).zip(&inside);
        let mut blocks: Vec<Collapses<'_>> = parts.map(|(vertices, faces)| block(vertices, faces)).collect();
        work(&mut blocks, seams.len());
        let faces_of = |(i, block): (usize, &Collapses<'_>)| {
            let first = (i * BLOCK) as u32;
            block.mesh.faces().map(|face| face.map(|v| first + v)).collect::<Vec<_>>()
        };
        let inside: Vec<Vec<[u32; 3]>> = blocks.par_iter().enumerate().evenly().map(faces_of).collect();
        self.faces = inside.into_iter().flatten().chain(seams).collect();
        self.passes += 1;
    }

    /// Numbers the vertices in use so that every `BLOCK` of them are a block.
    fn arrange(&mut self) {
        let mut number = vec![NONE; self.vertices.len()];
        self.faces.iter().flatten().for_each(|v| number[*v as usize] = 0);
        let place = |(v, vertex): (usize, &Vertex)| Place {
            at: [0, 1, 2].map(|i| vertex.position[i] as f32),
            vertex: v as u32,
        };
        let in_use = self.vertices.par_iter().enumerate().filter(|(v, _)| number[*v] != NONE);
        let mut places: Vec<Place> = in_use.map(place).collect();
        // Halves, or a third and two: the first planes of two passes are apart.
        cut(&mut places, 2 + self.passes % 2);
        for (new, place) in places.iter().enumerate() {
            number[place.vertex as usize] = new as u32;
        }
        self.vertices = places.par_iter().map(|place| self.vertices[place.vertex as usize].clone()).collect();
        let faces = self.faces.par_iter_mut().evenly_by(TASK);
        faces.for_each(|face| *face = face.map(|v| number[v as usize]));
    }

    fn divide(&self) -> Division {
        let count = self.vertices.len().div_ceil(BLOCK);
        let mut inside = vec![Vec::with_capacity(2 * BLOCK); count];
        let mut seams = Vec::new();
        for face in &self.faces {
            let [first, second, third] = face.map(|v| v as usize / BLOCK);
            if first == second && first == third {
                inside[first].push(face.map(|v| v % BLOCK as u32));
            } else {
                seams.push(*face);
            }
        }
        Division { inside, seams }
    }
}

/// A block ready for collapses. A vertex with more than one ring in it is at a seam, or where a mesh is no manifold.
fn block<'a>(vertices: &'a mut [Vertex], faces: &[[u32; 3]]) -> Collapses<'a> {
    let (mesh, pinched) = Connectivity::of_part(vertices.len(), faces);
    pinched.iter().for_each(|v| vertices[*v as usize].is_locked = true);
    Collapses::new(mesh, vertices, TURN_LIMITS[0])
}

/// Sorts places into blocks by planes across the longest side of their box; the first has one of so many `parts` of them on
/// its lower side.
fn cut(places: &mut [Place], parts: usize) {
    let blocks = places.len().div_ceil(BLOCK);
    if blocks < 2 {
        return;
    }
    let extent = |axis: usize| {
        let of_axis = places.iter().map(|place| place.at[axis]);
        let (low, high) =
            of_axis.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let extents = [0, 1, 2].map(extent);
    let axis = (1..3).fold(0, |longest, axis| if extents[axis] > extents[longest] { axis } else { longest });
    let middle = blocks.div_ceil(parts) * BLOCK;
    places.select_nth_unstable_by(middle, |p, q| {
        p.at[axis].total_cmp(&q.at[axis]).then(p.vertex.cmp(&q.vertex))
    });
    let (lower, upper) = places.split_at_mut(middle);
    rayon::join(|| cut(lower, 2), || cut(upper, 2));
}

/// Makes at most so many collapses, the cheapest of all blocks; false if there are no candidates.
fn collapse_some(blocks: &mut [Collapses<'_>], collapses: usize) -> bool {
    let sample = |block: &Collapses<'_>| block.costs().step_by(SAMPLED).collect();
    let sampled: Vec<Vec<u64>> = blocks.par_iter().evenly().map(sample).collect();
    let mut costs: Vec<u64> = sampled.iter().flatten().copied().collect();
    let Some(last) = costs.len().checked_sub(1) else { return false };
    let limit = *costs.select_nth_unstable(last.min(collapses / SAMPLED)).1;
    // Of the candidates up to the limit most become dear, or are gone, when another one is collapsed.
    let up_to_limit = |costs: &Vec<u64>| costs.iter().filter(|cost| **cost <= limit).count();
    let all: usize = sampled.iter().map(up_to_limit).sum();
    blocks.par_iter_mut().zip(&sampled).evenly().for_each(|(block, costs)| {
        let share = collapses * up_to_limit(costs) / all;
        let faces = block.mesh.face_count().saturating_sub(2 * share);
        block.run(faces, limit);
    });
    true
}
