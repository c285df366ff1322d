//! Collapses and splits of a draft that do not touch each other.
//!
//! A change takes possession of the vertices of the faces that it touches: another one there has to wait for the next
//! batch. So each can be taken back alone.

use super::border::{Merge, collapse_bridges, flip_bridges, larger};
use super::clip::BoxSides;
use super::connectivity::Connectivity;
use super::local::{Change, Draft, REMOVED, Vertex};
use super::shape::{area_vector, largest_angle_cosine};
use crate::geom::{Point3, Vec3};

/// Times that a new or merged vertex moves to the middle of the faces around it.
const RELAXATIONS: usize = 3;
/// Edges at a merged vertex that are flipped after each move.
const FLIPS: usize = 3;
/// Least gain in the cosine of the widest corner that is worth a flip; smaller ones may alternate for ever.
const FLIP_GAIN: f64 = 0.02;
/// Share of the way to the middle that a vertex goes beside a split: all of it, and neighbours would have to follow.
const DAMPING: f64 = 0.5;
/// What the length of an edge, as a share of the diagonal, counts beside its turn when a face is split: little, so that it
/// decides only on flat parts.
const LENGTH_SHARE: f64 = 0.1;

/// Room for the vertices, or faces, around an edge; mostly enough.
const REGION: usize = 24;

/// What a collapse finds.
struct Site {
    /// The first one stays.
    ends: [u32; 2],
    /// That one as it is.
    old: Vertex,
    /// The vertices of the faces that are touched.
    region: Vec<u32>,
    /// The faces at the ends, and their corners.
    touched: Vec<u32>,
    corners: Vec<[u32; 3]>,
}

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
        self.mesh.edges().collect()
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

    /// Merges the ends of an edge and relaxes the faces around; none, and no change, if a face would not be valid, or something
    /// near has changed.
    pub fn collapse(&mut self, h: u32) -> Option<Change> {
        if !self.is_free(h) {
            return None;
        }
        let change = self.site(h).and_then(|site| {
            let undo = self.mesh.snapshot(&site.touched, &site.region);
            let is_valid = self.merge(h, &site);
            if !is_valid {
                self.mesh.restore(&undo);
                self.draft.vertices[site.ends[0] as usize] = site.old;
            }
            is_valid.then(|| self.keep(&site))
        });
        if change.is_none() {
            self.draft.failures.note(self.slots[h as usize / 3], h as usize % 3);
        }
        change
    }

    /// Could the edge not be collapsed when that was last tried, and has nothing near changed since?
    pub fn fails_again(&self, h: u32) -> bool {
        let region = self.ends(h).into_iter().flat_map(|v| self.mesh.neighbours(v).chain([v]));
        self.draft.failures.stands(self.slots[h as usize / 3], h as usize % 3, region)
    }

    /// Where an edge would be collapsed; none if that is not possible at all.
    fn site(&self, h: u32) -> Option<Site> {
        if !self.mesh.can_collapse(h) || collapse_bridges(&self.mesh, |v| self.sides(v), h) {
            return None;
        }
        let ends = self.ends(h);
        let mut region = Vec::with_capacity(REGION);
        region.extend(ends.into_iter().flat_map(|v| self.mesh.neighbours(v)).chain(ends));
        let touched = self.faces_at(&ends);
        let corners = self.mesh.corners_of(&touched);
        Some(Site { ends, old: self.draft.vertices[ends[0] as usize], region, touched, corners })
    }

    /// Merges the ends and relaxes; false if a face is not valid in the end. The mesh is changed in any case.
    fn merge(&mut self, h: u32, site: &Site) -> bool {
        let [a, b] = site.ends;
        let [first, second] = [a, b].map(|v| self.draft.vertices[v as usize]);
        let start = match Merge::of(first.sides, second.sides, self.mesh.is_boundary(h)) {
            Some(Merge::Between) => 0.5 * (first.x + second.x),
            Some(Merge::AtFirst) => first.x,
            Some(Merge::AtSecond) => second.x,
            None => return false,
        };
        self.mesh.collapse(h);
        self.draft.place(a, start, larger([first.sides, second.sides])) && self.relax(a)
    }

    /// Takes possession of what a collapse has changed.
    fn keep(&mut self, site: &Site) -> Change {
        let slots = self.write(&site.touched, &site.corners);
        site.region.iter().for_each(|v| self.claimed[*v as usize] = true);
        self.draft.failures.change(site.region.iter().copied());
        Change { slots, vertex: (site.ends[0], site.old) }
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
        self.draft.vertices.push(Vertex { sides, ..p });
        if !self.draft.place(m, 0.5 * (p.x + q.x), sides) {
            self.draft.vertices.pop();
            return false;
        }
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

    /// Moves and flips around a merged vertex; are the faces at it valid in the end?
    fn relax(&mut self, v: u32) -> bool {
        let sides = self.sides(v);
        for done in 0..RELAXATIONS {
            if done > 0 && self.mesh.ring(v).any(|h| self.draft.is_hopeless(self.mesh.corners(h))) {
                return false;
            }
            if sides.is_empty()
                && let Some(middle) = self.middle_of_ring(v)
            {
                self.draft.place(v, middle, sides);
            }
            for _ in 0..FLIPS {
                let Some(h) = self.mesh.ring(v).find(|h| self.is_better_flipped(*h)) else { break };
                self.mesh.flip(h);
            }
        }
        self.ring_is_valid(v)
    }

    fn ring_is_valid(&self, v: u32) -> bool {
        self.mesh.ring(v).all(|h| self.draft.is_valid(self.mesh.corners(h)))
    }

    /// Moves a vertex inside part of the way to the middle of its faces, unless valid faces become invalid.
    fn move_to_middle(&mut self, v: u32) {
        let old = self.draft.vertices[v as usize];
        let Some(middle) = self.middle_of_ring(v).filter(|_| old.sides.is_empty()) else { return };
        let was_valid = self.ring_is_valid(v);
        self.draft.place(v, old.x + DAMPING * (middle - old.x), old.sides);
        if was_valid && !self.ring_is_valid(v) {
            self.draft.vertices[v as usize] = old;
        }
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

    /// May the edge be flipped, and does that make the widest corner of its two faces narrower?
    fn is_better_flipped(&self, h: u32) -> bool {
        let Some([c, d]) = self.mesh.apexes(h) else { return false };
        let [a, b] = self.ends(h);
        let widest = |f: [u32; 3]| largest_angle_cosine(f.map(|v| self.draft.point(v)));
        let before = widest([a, b, c]).min(widest([b, a, d]));
        let after = [[d, c, a], [c, d, b]];
        after.into_iter().all(|f| widest(f) > before + FLIP_GAIN)
            && self.mesh.can_flip(h)
            && !flip_bridges(&self.mesh, |v| self.sides(v), h)
            && after.into_iter().all(|f| self.draft.is_valid(f))
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
