//! Collapses and splits of a draft that do not touch each other.
//!
//! A change takes possession of the vertices of the faces that it touches: another one there has to wait for the next
//! batch. So each can be taken back alone.

use super::border::flip_bridges;
use super::clip::BoxSides;
use super::connectivity::Connectivity;
use super::local::{Change, Draft, REMOVED};
use super::star::{Merged, RELAXATIONS, Star, is_narrower_flipped, middle};
use crate::geom::Point3;
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Share of the way to the middle that a vertex goes beside a split: all of it, and neighbours would have to follow.
const DAMPING: f64 = 0.5;
/// What the length of an edge, as a share of the diagonal, counts beside its turn when a face is split: little, so that it
/// decides only on flat parts.
const LENGTH_SHARE: f64 = 0.1;

/// Room for the vertices, or faces, around an edge; mostly enough.
const REGION: usize = 24;

/// Collapses that are tried side by side, for each thread: few after one that could be made, as that rules out others; more and more
/// where all fail.
const TRIALS: [usize; 2] = [2, 32];

/// Changes of a [`Draft`] that do not touch each other.
pub struct Batch<'d, 'a> {
    draft: &'d mut Draft<'a>,
    mesh: Connectivity,
    /// The slot of each face of `mesh`.
    slots: Vec<u32>,
    /// Vertices of faces that a change has touched.
    claimed: Vec<bool>,
}

impl<'d, 'a> Batch<'d, 'a> {
    pub(super) fn new(draft: &'d mut Draft<'a>, mesh: Connectivity, slots: Vec<u32>) -> Self {
        let claimed = vec![false; draft.vertices.len()];
        Self { draft, mesh, slots, claimed }
    }

    /// One half edge of every edge; number 3i + k is side k of live face i.
    pub fn edges(&self) -> Vec<u32> {
        self.mesh.edges()
    }

    /// Ends of a half edge: numbers of vertices that stay theirs.
    pub fn ends(&self, h: u32) -> [u32; 2] {
        [self.mesh.origin(h), self.mesh.dest(h)]
    }

    /// Faces around the ends of a half edge, by their number among the live ones.
    pub fn faces_around(&self, h: u32) -> impl Iterator<Item = usize> + '_ {
        self.ends(h).into_iter().flat_map(|v| self.mesh.ring(v)).map(|e| e as usize / 3)
    }

    /// Is the half edge there, and has nothing near it changed?
    pub fn is_free(&self, h: u32) -> bool {
        self.mesh.is_half_edge(h)
            && self.ends(h).into_iter().all(|v| {
                !self.claimed[v as usize] && self.mesh.neighbours(v).all(|w| !self.claimed[w as usize])
            })
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

    /// Collapses edges, each in its turn as by [`Batch::collapse`]; the changes with the positions of their edges in the list.
    pub fn collapse_in_order(&mut self, edges: &[u32]) -> Vec<(usize, Change)> {
        let threads = rayon::current_num_threads();
        let [few, many] = if threads > 1 { TRIALS.map(|n| n * threads) } else { [1; 2] };
        let (mut changes, mut size) = (Vec::new(), few);
        let mut rest = 0..edges.len();
        while !rest.is_empty() {
            let free: Vec<usize> = rest.by_ref().filter(|i| self.is_free(edges[*i])).take(size).collect();
            // What is near an edge stays as it is, or the edge is not free any more: so a trial is right also after others have been made.
            let relaxed = |i: &usize| Star::relaxed(self.draft, &self.mesh, edges[*i]);
            let trials: Vec<Option<Merged>> = match free.len() {
                0 | 1 => free.iter().map(relaxed).collect(),
                _ => free.par_iter().evenly().map(relaxed).collect(),
            };
            let before = changes.len();
            for (i, merged) in free.into_iter().zip(trials) {
                if self.is_free(edges[i]) {
                    changes.extend(self.make(edges[i], merged).map(|change| (i, change)));
                }
            }
            size = if changes.len() > before { few } else { many.min(2 * size) };
        }
        changes
    }

    /// Merges the ends of an edge and relaxes the faces around; none, and no change, if a face would not be valid, or something
    /// near has changed.
    pub fn collapse(&mut self, h: u32) -> Option<Change> {
        self.collapse_in_order(&[h]).pop().map(|(_, change)| change)
    }

    /// Makes what a trial has found, or notes that it has failed.
    fn make(&mut self, h: u32, merged: Option<Merged>) -> Option<Change> {
        let Some(Merged { vertex, flipped }) = merged else {
            self.draft.failures.note(self.slots[h as usize / 3], h as usize % 3);
            return None;
        };
        let ends = self.ends(h);
        let region: Vec<u32> = ends.into_iter().flat_map(|v| self.mesh.neighbours(v)).chain(ends).collect();
        let touched = self.faces_at(&ends);
        let corners = self.mesh.corners_of(&touched);
        let [a, _] = ends;
        let old = std::mem::replace(&mut self.draft.vertices[a as usize], vertex);
        self.mesh.collapse(h);
        for end in flipped {
            let spoke = self.mesh.ring(a).find(|e| self.mesh.dest(*e) == end);
            spoke.into_iter().for_each(|e| self.mesh.flip(e));
        }
        let slots = self.write(&touched, &corners);
        region.iter().for_each(|v| self.claimed[*v as usize] = true);
        self.draft.failures.change(region);
        Some(Change { slots, vertex: (a, old) })
    }

    /// Could the edge not be collapsed when that was last tried, and has nothing near changed since?
    pub fn fails_again(&self, h: u32) -> bool {
        let region = self.ends(h).into_iter().flat_map(|v| self.mesh.neighbours(v).chain([v]));
        self.draft.failures.stands(self.slots[h as usize / 3], h as usize % 3, region)
    }

    fn sides(&self, v: u32) -> BoxSides {
        self.draft.vertices[v as usize].sides
    }

    /// Puts a vertex on the edge and relaxes what is around it; false if its faces have changed in this batch.
    pub fn split(&mut self, h: u32) -> bool {
        let [a, b] = self.ends(h);
        let mut corners = vec![a, b, self.mesh.apex(h)];
        corners.extend(self.mesh.twin(h).map(|g| self.mesh.apex(g)));
        if corners.iter().any(|v| self.claimed[*v as usize]) {
            return false;
        }
        let touched = self.faces_at(&corners);
        let before = self.mesh.corners_of(&touched);
        let [p, q] = [a, b].map(|v| self.draft.vertices[v as usize]);
        let sides = if self.mesh.is_boundary(h) { p.sides.common(q.sides) } else { BoxSides::NONE };
        let m = self.draft.vertices.len() as u32;
        let Some(middle) = self.draft.placed(0.5 * (p.x + q.x), sides) else { return false };
        self.draft.vertices.push(middle);
        let first_new = self.mesh.half_edge_bound() / 3;
        self.mesh.split(h);
        let new: Vec<u32> = (first_new..self.mesh.half_edge_bound() / 3).collect();
        for _ in &new {
            self.slots.push(self.draft.faces.len() as u32);
            self.draft.faces.push(REMOVED);
            self.draft.stamps.push(0);
        }
        for _ in 0..RELAXATIONS {
            self.flip_opposite(m, &touched, first_new);
            self.move_to_middle(m);
            corners.iter().for_each(|v| self.move_to_middle(*v));
        }
        self.write(&touched, &before);
        self.write(&new, &vec![REMOVED; new.len()]);
        self.claimed.push(true);
        self.draft.failures.change(before.into_iter().flatten().chain([m]));
        corners.iter().for_each(|v| self.claimed[*v as usize] = true);
        true
    }

    /// The faces at some vertices, ascending.
    fn faces_at(&self, vertices: &[u32]) -> Vec<u32> {
        let mut faces = Vec::with_capacity(REGION);
        faces.extend(vertices.iter().flat_map(|v| self.mesh.ring(*v)).map(|h| h / 3));
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    fn ring_is_valid(&self, v: u32) -> bool {
        self.mesh.ring(v).all(|h| self.draft.is_valid(self.draft.corners(self.mesh.corners(h))))
    }

    /// Moves a vertex inside part of the way to the middle of its faces, unless valid faces become invalid.
    fn move_to_middle(&mut self, v: u32) {
        let old = self.draft.vertices[v as usize];
        let Some(middle) = self.middle_of_ring(v).filter(|_| old.sides.is_empty()) else { return };
        let was_valid = self.ring_is_valid(v);
        let Some(moved) = self.draft.placed(old.x + DAMPING * (middle - old.x), old.sides) else { return };
        self.draft.vertices[v as usize] = moved;
        if was_valid && !self.ring_is_valid(v) {
            self.draft.vertices[v as usize] = old;
        }
    }

    fn middle_of_ring(&self, v: u32) -> Option<Point3> {
        let faces = self.mesh.ring(v).map(|h| self.mesh.corners(h).map(|v| self.draft.point(v)));
        middle(&self.draft.vertices[v as usize], faces)
    }

    /// May the edge be flipped, and does that make the widest corner of its two faces narrower?
    fn is_better_flipped(&self, h: u32) -> bool {
        let Some([c, d]) = self.mesh.apexes(h) else { return false };
        let [a, b] = self.ends(h);
        is_narrower_flipped([a, b, c, d].map(|v| self.draft.point(v)))
            && self.mesh.can_flip(h)
            && !flip_bridges(&self.mesh, |v| self.sides(v), h)
            && [[d, c, a], [c, d, b]].into_iter().all(|f| self.draft.is_valid(self.draft.corners(f)))
    }

    /// Flips edges opposite to a new vertex, if both their faces are among `touched` or new.
    fn flip_opposite(&mut self, v: u32, touched: &[u32], first_new: u32) {
        let may = |h: u32| touched.binary_search(&(h / 3)).is_ok() || h / 3 >= first_new;
        let spokes: Vec<u32> = self.mesh.ring(v).collect();
        for h in spokes.into_iter().map(|h| 3 * (h / 3) + (h + 1) % 3) {
            if may(h) && self.mesh.twin(h).is_some_and(may) && self.is_better_flipped(h) {
                self.mesh.flip(h);
            }
        }
    }

    /// Puts faces of the mesh into their slots, with new stamps; gives what was there.
    fn write(&mut self, faces: &[u32], before: &[[u32; 3]]) -> Vec<(u32, [u32; 3], u64)> {
        let mut old = Vec::with_capacity(faces.len());
        for (face, corners) in faces.iter().zip(before) {
            let slot = self.slots[*face as usize];
            let s = slot as usize;
            old.push((slot, *corners, self.draft.stamps[s]));
            self.draft.last_stamp += 1;
            self.draft.stamps[s] = self.draft.last_stamp;
            let h = 3 * face;
            self.draft.faces[s] = if self.mesh.is_half_edge(h) { self.mesh.corners(h) } else { REMOVED };
        }
        old
    }
}
