//! A vertex into which an edge is merged, apart from the mesh: edges can be tried side by side.

use super::border::{Merge, collapse_bridges, larger};
use super::clip::BoxSides;
use super::connectivity::{Connectivity, least_to_lose_one};
use super::local::{Draft, Vertex};
use super::shape::{area_vector, largest_angle_cosine};
use crate::geom::{Point3, Vec3};

/// Times that a new or merged vertex moves to the middle of the faces around it.
pub(super) const RELAXATIONS: usize = 3;
/// Edges at a merged vertex that are flipped after each move.
const FLIPS: usize = 3;
/// Least gain in the cosine of the widest corner that is worth a flip; smaller ones may alternate for ever.
const FLIP_GAIN: f64 = 0.02;
/// Room for the vertices around an edge; mostly enough.
const RING: usize = 24;

/// Area-weighted centre of some faces at a vertex, which is their first corner, in its tangent plane.
pub(super) fn middle(vertex: &Vertex, faces: impl Iterator<Item = [Point3; 3]>) -> Option<Point3> {
    let (mut moment, mut total) = (Vec3::zeros(), 0.0);
    for [p, q, r] in faces {
        let area = area_vector([p, q, r]).norm();
        moment += area * ((p + q + r) / 3.0 - p);
        total += area;
    }
    let pull = moment / total;
    let tangential = pull - vertex.normal * vertex.normal.dot(&pull);
    tangential.sum().is_finite().then_some(vertex.x + tangential)
}

/// Is the widest corner of two faces much narrower with the other diagonal? The diagonal a → b has c to its left and d to its right.
pub(super) fn is_narrower_flipped([a, b, c, d]: [Point3; 4]) -> bool {
    let before = largest_angle_cosine([a, b, c]).min(largest_angle_cosine([b, a, d]));
    [[d, c, a], [c, d, b]].into_iter().all(|f| largest_angle_cosine(f) > before + FLIP_GAIN)
}

/// A neighbour of the vertex.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    number: u32,
    /// Faces that it has more, or less, than in the mesh.
    gain: i32,
}

/// The faces around a vertex into which an edge is merged.
pub(super) struct Star<'d, 'a> {
    draft: &'d Draft<'a>,
    mesh: &'d Connectivity,
    /// Its number, and what it is now.
    number: u32,
    vertex: Vertex,
    /// Counter-clockwise; face i lies between the neighbours i and i + 1.
    ring: Vec<Neighbour>,
    /// Is there a face between the last neighbour and the first?
    is_closed: bool,
    /// Edges between neighbours that flips have made.
    made: Vec<[u32; 2]>,
    /// Neighbours that are none any more, in the order of the flips.
    flipped: Vec<u32>,
}

/// What a star has become.
#[derive(Clone, Debug)]
pub(super) struct Merged {
    /// The vertex.
    pub vertex: Vertex,
    /// Ends of the edges at it that are to be flipped, in their order.
    pub flipped: Vec<u32>,
}

impl<'d, 'a> Star<'d, 'a> {
    /// The ends of an edge merged and the faces around relaxed; none if that is not possible, or a face is not valid in the end.
    pub fn relaxed(draft: &'d Draft<'a>, mesh: &'d Connectivity, h: u32) -> Option<Merged> {
        let sides = |v: u32| draft.vertices[v as usize].sides;
        if !mesh.can_collapse(h) || collapse_bridges(mesh, sides, h) {
            return None;
        }
        let mut star = Self::of(draft, mesh, h)?;
        star.relax().then_some(Merged { vertex: star.vertex, flipped: star.flipped })
    }

    fn of(draft: &'d Draft<'a>, mesh: &'d Connectivity, h: u32) -> Option<Self> {
        let ends = [mesh.origin(h), mesh.dest(h)];
        let [first, second] = ends.map(|v| &draft.vertices[v as usize]);
        let start = match Merge::of(first.sides, second.sides, mesh.is_boundary(h))? {
            Merge::Between => 0.5 * (first.x + second.x),
            Merge::AtFirst => first.x,
            Merge::AtSecond => second.x,
        };
        let vertex = draft.placed(start, larger([first.sides, second.sides]))?;
        let (ring, is_closed) = ring(mesh, h);
        if ring.is_empty() {
            return None;
        }
        let [number, _] = ends;
        Some(Self { draft, mesh, number, vertex, ring, is_closed, made: Vec::new(), flipped: Vec::new() })
    }

    fn data(&self, v: u32) -> &Vertex {
        if v == self.number { &self.vertex } else { &self.draft.vertices[v as usize] }
    }

    fn face_count(&self) -> usize {
        self.ring.len() - usize::from(!self.is_closed)
    }

    fn faces(&self) -> impl Iterator<Item = [&Vertex; 3]> + '_ {
        let corner = |i: usize| self.data(self.ring[i % self.ring.len()].number);
        (0..self.face_count()).map(move |i| [&self.vertex, corner(i), corner(i + 1)])
    }

    /// Moves and flips; are the faces valid in the end?
    fn relax(&mut self) -> bool {
        for done in 0..RELAXATIONS {
            if done > 0 && self.faces().any(|face| self.draft.is_hopeless(face)) {
                return false;
            }
            if self.vertex.sides.is_empty()
                && let Some(middle) = middle(&self.vertex, self.faces().map(|face| face.map(|v| v.x)))
                && let Some(moved) = self.draft.placed(middle, BoxSides::NONE)
            {
                self.vertex = moved;
            }
            for _ in 0..FLIPS {
                let Some(i) = (0..self.ring.len()).find(|i| self.is_better_flipped(*i)) else { break };
                self.flip(i);
            }
        }
        self.faces().all(|face| self.draft.is_valid(face))
    }

    /// Neighbours before and after one; none at an edge of the boundary.
    fn beside(&self, i: usize) -> Option<[usize; 2]> {
        let n = self.ring.len();
        let is_inside = self.is_closed || (i > 0 && i + 1 < n);
        is_inside.then(|| [(i + n - 1) % n, (i + 1) % n])
    }

    /// May the edge to a neighbour be flipped, and does that make the widest corner of its two faces narrower?
    fn is_better_flipped(&self, i: usize) -> bool {
        let Some(beside) = self.beside(i) else { return false };
        let [d, c] = beside.map(|i| self.ring[i].number);
        let (a, b) = (&self.vertex, self.data(self.ring[i].number));
        let [left, right] = [c, d].map(|v| self.data(v));
        is_narrower_flipped([a.x, b.x, left.x, right.x])
            && self.can_flip(i, [c, d])
            && left.sides.common(right.sides).is_empty()
            && [[right, left, a], [left, right, b]].into_iter().all(|face| self.draft.is_valid(face))
    }

    /// As [`Connectivity::can_flip`], in the mesh as it would be.
    fn can_flip(&self, i: usize, [c, d]: [u32; 2]) -> bool {
        let Neighbour { number, gain } = self.ring[i];
        let faces = self.mesh.ring(number).count() as i32 + gain;
        let is_new = |made: &[u32; 2]| *made != [c, d] && *made != [d, c];
        c != d
            && self.face_count() >= least_to_lose_one(!self.is_closed)
            && faces >= least_to_lose_one(self.mesh.is_boundary_vertex(number)) as i32
            && self.made.iter().all(is_new)
            && !self.mesh.are_neighbours(c, d)
    }

    /// Replaces the edge to a neighbour by that between the ones beside it. Faces are seen from the one before from then on.
    fn flip(&mut self, i: usize) {
        let Some([before, after]) = self.beside(i) else { return };
        self.ring[before].gain += 1;
        self.ring[after].gain += 1;
        self.made.push([before, after].map(|i| self.ring[i].number));
        self.flipped.push(self.ring[i].number);
        if self.is_closed {
            self.ring.rotate_left(before);
            self.ring.remove(1);
        } else {
            self.ring.remove(i);
        }
    }
}

/// The neighbours that the ends of an edge have together, counter-clockwise from the one left of it, or from boundary to boundary; and
/// whether they go all around.
fn ring(mesh: &Connectivity, h: u32) -> (Vec<Neighbour>, bool) {
    let ends = [mesh.origin(h), mesh.dest(h)];
    let apexes = [Some(mesh.apex(h)), mesh.twin(h).map(|g| mesh.apex(g))];
    // Sides of faces, opposite to an end; in a small room, looking through all is as good as a map.
    let mut links: Vec<[u32; 2]> = Vec::with_capacity(RING);
    let opposite = ends.into_iter().flat_map(|v| mesh.ring(v)).map(|e| [mesh.dest(e), mesh.apex(e)]);
    links.extend(opposite.filter(|link| !link.iter().any(|v| ends.contains(v))));
    let is_closed = !ends.iter().any(|v| mesh.is_boundary_vertex(*v));
    let is_first = |v: u32| !links.iter().any(|[_, to]| *to == v);
    let first = if is_closed { apexes[0] } else { links.iter().map(|link| link[0]).find(|v| is_first(*v)) };
    let following = |v: &u32| links.iter().find(|[from, _]| from == v).map(|[_, to]| *to);
    let mut ring = Vec::with_capacity(RING);
    let count = links.len() + usize::from(!is_closed);
    ring.extend(std::iter::successors(first, following).take(count).map(|number| Neighbour {
        number,
        // The faces at the edge are gone.
        gain: -i32::from(apexes.contains(&Some(number))),
    }));
    (ring, is_closed)
}
