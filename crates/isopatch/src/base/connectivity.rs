//! Connectivity that changes: triangle meshes under splits, collapses and flips.

use crate::mesh::buckets::Buckets;
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Half edges that one task looks at.
const TASK: usize = 2048;

/// Marks what no longer exists, and the twin of a half edge on the boundary.
const NONE: u32 = u32::MAX;

/// An oriented triangle mesh, closed or with a boundary, that can be changed in constant time.
///
/// Half edge 3f + k runs from corner k to corner k + 1 of face f, as in [`crate::mesh::HalfEdgeMesh`].
/// Removed faces and vertices leave holes in the numbering until [`Connectivity::compact`].
#[derive(Clone, Debug)]
pub(super) struct Connectivity {
    origin: Vec<u32>,
    twin: Vec<u32>,
    /// An outgoing half edge of each vertex, the clockwise-most one at a boundary; `NONE` if removed.
    outgoing: Vec<u32>,
    face_count: usize,
    is_open: bool,
}

/// Faces of a vertex that can lose one.
pub(super) fn least_to_lose_one(is_on_boundary: bool) -> usize {
    if is_on_boundary { 2 } else { 4 }
}

fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Connectivity {
    /// Connectivity of a manifold; none if more than one boundary passes through a vertex.
    pub fn from_faces(vertex_count: usize, faces: &[[u32; 3]]) -> Option<Self> {
        let (mesh, pinched) = Self::of_part(vertex_count, faces);
        pinched.is_empty().then_some(mesh)
    }

    /// Connectivity of some faces of a manifold, and the vertices through which more than one boundary passes: of each of
    /// these, one ring is known.
    pub fn of_part(vertex_count: usize, faces: &[[u32; 3]]) -> (Self, Vec<u32>) {
        let origin: Vec<u32> = faces.iter().flatten().copied().collect();
        let leaving = Buckets::new(&origin, vertex_count);
        let twin_of = |h: u32| {
            let (a, b) = (origin[h as usize], origin[next(h) as usize]);
            let mut of_b = leaving.get(b as usize).iter().copied();
            of_b.find(|g| origin[next(*g) as usize] == a).unwrap_or(NONE)
        };
        let half_edges = (0..origin.len() as u32).into_par_iter().evenly_by(TASK);
        let twin: Vec<u32> = half_edges.map(twin_of).collect();
        let mut outgoing: Vec<u32> =
            (0..vertex_count).map(|v| leaving.get(v).first().copied().unwrap_or(NONE)).collect();
        let mut on_boundary = vec![false; vertex_count];
        let mut pinched = Vec::new();
        for h in (0..origin.len()).filter(|h| twin[*h] == NONE) {
            let v = origin[h];
            if std::mem::replace(&mut on_boundary[v as usize], true) {
                pinched.push(v);
            }
            outgoing[v as usize] = h as u32;
        }
        let is_open = on_boundary.contains(&true);
        (Self { origin, twin, outgoing, face_count: faces.len(), is_open }, pinched)
    }

    /// Number of faces that exist.
    pub fn face_count(&self) -> usize {
        self.face_count
    }

    /// Number of vertex numbers in use, removed ones included.
    pub fn vertex_bound(&self) -> usize {
        self.outgoing.len()
    }

    /// Number of half edge numbers in use, removed ones included.
    pub fn half_edge_bound(&self) -> u32 {
        self.origin.len() as u32
    }

    pub fn is_vertex(&self, v: u32) -> bool {
        self.outgoing[v as usize] != NONE
    }

    pub fn is_half_edge(&self, h: u32) -> bool {
        self.origin[h as usize] != NONE
    }

    pub fn origin(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }

    pub fn dest(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }

    /// The corner of the half edge's face that is not on it.
    pub fn apex(&self, h: u32) -> u32 {
        self.origin[prev(h) as usize]
    }

    /// The opposite half edge; none on the boundary.
    pub fn twin(&self, h: u32) -> Option<u32> {
        let g = self.twin[h as usize];
        (g != NONE).then_some(g)
    }

    /// Is there a face on one side only?
    pub fn is_boundary(&self, h: u32) -> bool {
        self.twin[h as usize] == NONE
    }

    pub fn is_boundary_vertex(&self, v: u32) -> bool {
        self.is_boundary(self.outgoing[v as usize])
    }

    /// Corners of the face of a half edge, from its origin on.
    pub fn corners(&self, h: u32) -> [u32; 3] {
        [self.origin(h), self.dest(h), self.apex(h)]
    }

    /// Faces that exist.
    pub fn faces(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.origin.chunks_exact(3).filter(|f| f[0] != NONE).map(|f| [f[0], f[1], f[2]])
    }

    /// All faces, by their numbers; none may have been removed since [`Connectivity::compact`].
    pub fn faces_in_parallel(&self) -> impl IndexedParallelIterator<Item = [u32; 3]> + '_ {
        self.origin.par_chunks_exact(3).map(|f| [f[0], f[1], f[2]])
    }

    /// One half edge of every edge that exists.
    pub fn edges(&self) -> Vec<u32> {
        // Of two half edges one is left, in no order that the branches of a filter could be foretold from.
        let mut edges = vec![0; self.twin.len() + 1];
        let mut count = 0;
        for h in 0..self.half_edge_bound() {
            edges[count] = h;
            count += usize::from(self.is_edge(h));
        }
        edges.truncate(count);
        edges
    }

    /// The ends of all edges, in the same order.
    pub fn edge_ends(&self) -> Vec<[usize; 2]> {
        self.edges().into_iter().map(|h| [self.origin(h), self.dest(h)].map(|v| v as usize)).collect()
    }

    /// Is it the half edge that stands for its edge in [`Connectivity::edges`]?
    pub fn is_edge(&self, h: u32) -> bool {
        self.is_half_edge(h) & (h < self.twin[h as usize])
    }

    /// Vertices that exist.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.outgoing.len() as u32).filter(|v| self.is_vertex(*v))
    }

    /// Half edges by the vertex that they leave.
    pub fn leaving(&self) -> Buckets {
        Buckets::new(&self.origin, self.outgoing.len())
    }

    /// Outgoing half edges of a vertex, one a face, counter-clockwise; from boundary to boundary if it has one.
    pub fn ring(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing[v as usize];
        std::iter::successors(Some(first), move |h| {
            self.twin(prev(*h)).filter(|following| *following != first)
        })
    }

    /// The ends of all edges at a vertex, counter-clockwise.
    pub fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let past_ring = || self.ring(v).last().map(|h| self.apex(h));
        let last = if self.is_boundary_vertex(v) { past_ring() } else { None };
        self.ring(v).map(|h| self.dest(h)).chain(last)
    }

    /// The neighbours of a vertex along the boundary: where it comes from and where it goes on.
    pub fn boundary_neighbours(&self, v: u32) -> Option<[u32; 2]> {
        if !self.is_boundary_vertex(v) {
            return None;
        }
        let last = self.ring(v).last()?;
        Some([self.apex(last), self.dest(self.outgoing[v as usize])])
    }

    /// The half edge of the boundary that leaves a vertex.
    pub fn boundary_from(&self, v: u32) -> Option<u32> {
        Some(self.outgoing[v as usize]).filter(|h| self.is_boundary(*h))
    }

    /// Number of edges at a vertex.
    pub fn valence(&self, v: u32) -> usize {
        self.neighbours(v).count()
    }

    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        self.neighbours(a).any(|v| v == b)
    }

    fn link(&mut self, h: u32, g: u32) {
        for (from, to) in [(h, g), (g, h)] {
            if from != NONE {
                self.twin[from as usize] = to;
            }
        }
    }

    /// Makes the rings of vertices start at the boundary where they have one.
    fn start_rings(&mut self, vertices: &[u32]) {
        if !self.is_open {
            return;
        }
        for v in vertices {
            let first = self.outgoing[*v as usize];
            let clockwise = |h: &u32| self.twin(*h).map(next).filter(|g| *g != first);
            let last = std::iter::successors(Some(first), clockwise).last();
            if let Some(last) = last.filter(|h| self.is_boundary(*h)) {
                self.outgoing[*v as usize] = last;
            }
        }
    }

    /// Can the vertex lose one of its faces? Inside, valence 3 must remain; on the boundary, a face.
    fn can_lose_face(&self, v: u32) -> bool {
        let least = least_to_lose_one(self.is_boundary_vertex(v));
        self.ring(v).take(least).count() == least
    }

    fn set_face(&mut self, h: u32, corners: [u32; 3], twins: [u32; 3]) {
        let mut g = h;
        for (corner, twin) in corners.into_iter().zip(twins) {
            self.origin[g as usize] = corner;
            self.outgoing[corner as usize] = g;
            self.link(g, twin);
            g = next(g);
        }
    }

    /// The corners opposite to an edge inside, left and right; none on the boundary.
    pub fn apexes(&self, h: u32) -> Option<[u32; 2]> {
        self.twin(h).map(|g| [self.apex(h), self.apex(g)])
    }

    /// May the edge be replaced by the one between the two apexes? Never on the boundary.
    pub fn can_flip(&self, h: u32) -> bool {
        let Some([c, d]) = self.apexes(h) else { return false };
        c != d
            && self.can_lose_face(self.origin(h))
            && self.can_lose_face(self.dest(h))
            && !self.are_neighbours(c, d)
    }

    /// Replaces the edge a → b between the apexes c (left) and d (right) by the edge d → c.
    ///
    /// ```text
    ///       c                c
    ///     / | \            /   \
    ///    a  |h  b  (rotated)  a --- b
    /// ```
    /// Faces (a, b, c) and (b, a, d) become (d, c, a) and (c, d, b). [`Connectivity::can_flip`] must hold.
    pub fn flip(&mut self, h: u32) {
        let g = self.twin[h as usize];
        let ([a, b, c], d) = (self.corners(h), self.apex(g));
        let [bc, ca, ad, db] = [next(h), prev(h), next(g), prev(g)].map(|e| self.twin[e as usize]);
        self.set_face(h, [d, c, a], [g, ca, ad]);
        self.set_face(g, [c, d, b], [h, db, bc]);
        self.start_rings(&[a, b, c, d]);
    }

    /// Number of faces that a split of the edge adds and its collapse removes.
    pub fn faces_at(&self, h: u32) -> usize {
        if self.is_boundary(h) { 1 } else { 2 }
    }

    /// Puts a new vertex on the edge; returns it. Two faces more, one on the boundary.
    pub fn split(&mut self, h: u32) -> u32 {
        let Some(g) = self.twin(h) else { return self.split_boundary(h) };
        let ([a, b, c], d) = (self.corners(h), self.apex(g));
        let m = self.outgoing.len() as u32;
        let (p, q) = (self.half_edge_bound(), self.half_edge_bound() + 3);
        self.outgoing.push(p);
        self.origin.resize(self.origin.len() + 6, NONE);
        self.twin.resize(self.twin.len() + 6, NONE);
        let [bc, ca, ad, db] = [next(h), prev(h), next(g), prev(g)].map(|e| self.twin[e as usize]);
        // (a, b, c) → (a, m, c), (m, b, c) and (b, a, d) → (b, m, d), (m, a, d).
        self.set_face(h, [a, m, c], [q, prev(p), ca]);
        self.set_face(p, [m, b, c], [g, bc, next(h)]);
        self.set_face(g, [b, m, d], [p, prev(q), db]);
        self.set_face(q, [m, a, d], [h, ad, next(g)]);
        self.face_count += 2;
        self.start_rings(&[a, b, c, d]);
        m
    }

    /// (a, b, c) → (a, m, c), (m, b, c).
    fn split_boundary(&mut self, h: u32) -> u32 {
        let [a, b, c] = self.corners(h);
        let m = self.outgoing.len() as u32;
        let p = self.half_edge_bound();
        self.outgoing.push(p);
        self.origin.resize(self.origin.len() + 3, NONE);
        self.twin.resize(self.twin.len() + 3, NONE);
        let [bc, ca] = [next(h), prev(h)].map(|e| self.twin[e as usize]);
        self.set_face(h, [a, m, c], [NONE, prev(p), ca]);
        self.set_face(p, [m, b, c], [NONE, bc, next(h)]);
        self.face_count += 1;
        self.start_rings(&[a, b, c, m]);
        m
    }

    /// Would merging the ends keep the surface a manifold of the same topology (the link condition)?
    pub fn can_collapse(&self, h: u32) -> bool {
        let (a, b, c) = (self.origin(h), self.dest(h), self.apex(h));
        let Some(g) = self.twin(h) else {
            return self.can_lose_face(c) && self.common_neighbours(a, b) == 1;
        };
        let on_boundary = [a, b].map(|v| self.is_boundary_vertex(v));
        let d = self.apex(g);
        // An edge inside from boundary to boundary would pinch the surface; valence 3 must remain at the merged vertex.
        let keeps_ends = match on_boundary {
            [true, true] => false,
            [false, false] => self.valence(a) + self.valence(b) >= 7,
            _ => true,
        };
        let keeps_faces = c != d && self.can_lose_face(c) && self.can_lose_face(d);
        keeps_ends && keeps_faces && self.common_neighbours(a, b) == 2
    }

    fn common_neighbours(&self, a: u32, b: u32) -> usize {
        self.neighbours(a).filter(|v| self.are_neighbours(b, *v)).count()
    }

    /// Merges b into a along the half edge a → b. Two faces less, one on the boundary. [`Connectivity::can_collapse`]
    /// must hold.
    pub fn collapse(&mut self, h: u32) {
        let (g, [a, b, c]) = (self.twin(h), self.corners(h));
        let first = self.outgoing[b as usize];
        let mut of_b = Some(first);
        while let Some(e) = of_b {
            self.origin[e as usize] = a;
            of_b = self.twin(prev(e)).filter(|e| *e != first);
        }
        self.outgoing[b as usize] = NONE;
        // c → b, a → c; and if there is a right face, d → a, b → d.
        let [bc, ca] = [next(h), prev(h)].map(|e| self.twin[e as usize]);
        self.close_face(h, [bc, ca]);
        let d = g.map_or(c, |g| self.apex(g));
        if let Some(g) = g {
            let [ad, db] = [next(g), prev(g)].map(|e| self.twin[e as usize]);
            self.close_face(g, [ad, db]);
        }
        self.outgoing[a as usize] = if ca != NONE { ca } else { next(bc) };
        self.start_rings(&[a, c, d]);
    }

    /// Removes a face whose first edge has shrunk to a point, and joins what was beyond its two others: the half edges to
    /// and from that point.
    fn close_face(&mut self, h: u32, [to, from]: [u32; 2]) {
        let apex = self.apex(h);
        self.link(to, from);
        self.outgoing[apex as usize] = if to != NONE { to } else { next(from) };
        for dead in [h, next(h), prev(h)] {
            self.origin[dead as usize] = NONE;
        }
        self.face_count -= 1;
    }

    /// Corners of some faces.
    pub fn corners_of(&self, faces: &[u32]) -> Vec<[u32; 3]> {
        faces.iter().map(|f| self.corners(3 * f)).collect()
    }

    /// Closes the holes in the numbering; returns the old number of every new vertex.
    pub fn compact(&mut self) -> Vec<u32> {
        let kept: Vec<u32> = self.vertices().collect();
        let faces: Vec<u32> = self.live_faces().collect();
        self.renumber(&kept, &faces);
        kept
    }

    /// Numbers the vertices in use in the order of `ranks`, one for every number, and the faces in the order of their first
    /// vertices; returns the old number of every new vertex.
    pub fn sort_by(&mut self, ranks: &[u32]) -> Vec<u32> {
        let mut vertices: Vec<u32> = self.vertices().collect();
        vertices.par_sort_unstable_by_key(|v| ranks[*v as usize]);
        let first = |f: &u32| (0..3).map(|i| ranks[self.origin[3 * *f as usize + i] as usize]).min();
        let mut faces: Vec<u32> = self.live_faces().collect();
        faces.par_sort_by_key(first);
        self.renumber(&vertices, &faces);
        vertices
    }

    fn live_faces(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.origin.len() as u32 / 3).filter(|f| self.origin[3 * *f as usize] != NONE)
    }

    /// Takes over the vertices and faces with these numbers, in this order: all that are in use.
    fn renumber(&mut self, vertices: &[u32], faces: &[u32]) {
        let inverse = |kept: &[u32], bound: usize| {
            let mut new = vec![NONE; bound];
            kept.iter().enumerate().for_each(|(k, old)| new[*old as usize] = k as u32);
            new
        };
        let new_vertex = inverse(vertices, self.outgoing.len());
        let new_face = inverse(faces, self.origin.len() / 3);
        let half_edge = |h: u32| 3 * new_face[h as usize / 3] + h % 3;
        let half_edges = || faces.iter().flat_map(|f| 3 * f..3 * f + 3);
        let origin = half_edges().map(|h| new_vertex[self.origin[h as usize] as usize]).collect();
        let twin = half_edges().map(|h| self.twin(h).map_or(NONE, half_edge)).collect();
        let outgoing = vertices.iter().map(|v| half_edge(self.outgoing[*v as usize])).collect();
        *self = Self { origin, twin, outgoing, face_count: self.face_count, is_open: self.is_open };
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::HalfEdgeMesh;

    const OCTAHEDRON: [[u32; 3]; 8] =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

    fn check(mesh: &mut Connectivity) {
        for h in 0..mesh.half_edge_bound() {
            if mesh.is_half_edge(h) {
                let g = mesh.twin(h).unwrap();
                assert_eq!(mesh.twin(g), Some(h));
                assert_eq!((mesh.origin(h), mesh.dest(h)), (mesh.dest(g), mesh.origin(g)));
            }
        }
        for v in mesh.vertices() {
            assert!(mesh.ring(v).all(|h| mesh.origin(h) == v));
        }
        let vertices = mesh.compact().len();
        let faces: Vec<[u32; 3]> = mesh.faces().collect();
        assert_eq!(faces.len(), mesh.face_count());
        let half_edges = HalfEdgeMesh::from_faces(vertices, &faces).unwrap();
        assert!(half_edges.is_closed());
        assert_eq!(half_edges.euler_number(), 2);
    }

    #[test]
    fn every_operation_leaves_a_closed_sphere() {
        let mut mesh = Connectivity::from_faces(6, &OCTAHEDRON).unwrap();
        let m = mesh.split(0);
        assert_eq!((mesh.face_count(), mesh.valence(m)), (10, 4));
        check(&mut mesh);
        let edge = mesh.edges().into_iter().find(|h| mesh.can_flip(*h)).unwrap();
        let [c, d] = mesh.apexes(edge).unwrap();
        mesh.flip(edge);
        assert!(mesh.are_neighbours(c, d));
        check(&mut mesh);
        let edge = mesh.edges().into_iter().find(|h| mesh.can_collapse(*h)).unwrap();
        mesh.collapse(edge);
        assert_eq!(mesh.face_count(), 8);
        check(&mut mesh);
    }

    #[test]
    fn a_tetrahedron_can_neither_collapse_nor_flip() {
        let mesh = Connectivity::from_faces(4, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        assert!(mesh.edges().into_iter().all(|h| !mesh.can_collapse(h) && !mesh.can_flip(h)));
    }

    /// A hexagon of six triangles around vertex 6.
    fn hexagon() -> Connectivity {
        let faces: Vec<[u32; 3]> = (0..6).map(|i| [i, (i + 1) % 6, 6]).collect();
        Connectivity::from_faces(7, &faces).unwrap()
    }

    fn edge_between(mesh: &Connectivity, a: u32, b: u32) -> u32 {
        mesh.edges()
            .into_iter()
            .find(|h| [[a, b], [b, a]].contains(&[mesh.origin(*h), mesh.dest(*h)]))
            .unwrap()
    }

    /// Twins, rings, and a disk.
    fn check_disk(mesh: &Connectivity) {
        let mut copy = mesh.clone();
        for h in (0..mesh.half_edge_bound()).filter(|h| mesh.is_half_edge(*h)) {
            assert!(mesh.twin(h).is_none_or(|g| mesh.twin(g) == Some(h)));
        }
        for v in mesh.vertices() {
            assert!(mesh.ring(v).all(|h| mesh.origin(h) == v));
            assert_eq!(mesh.ring(v).count(), mesh.faces().filter(|f| f.contains(&v)).count());
        }
        let vertices = copy.compact().len();
        let faces: Vec<[u32; 3]> = copy.faces().collect();
        assert_eq!(faces.len(), mesh.face_count());
        let half_edges = HalfEdgeMesh::from_faces(vertices, &faces).unwrap();
        assert_eq!((half_edges.euler_number(), half_edges.boundary_loop_count()), (1, 1));
        for v in copy.vertices() {
            let same = half_edges.is_boundary_vertex(crate::mesh::VertexId(v));
            assert_eq!(
                (copy.is_boundary_vertex(v), copy.valence(v)),
                (same, half_edges.valence(crate::mesh::VertexId(v)))
            );
        }
    }

    #[test]
    fn rings_run_from_boundary_to_boundary() {
        let mesh = hexagon();
        assert_eq!(mesh.neighbours(0).collect::<Vec<_>>(), [1, 6, 5]);
        assert_eq!(mesh.boundary_neighbours(0), Some([5, 1]));
        assert_eq!((mesh.valence(0), mesh.valence(6), mesh.boundary_neighbours(6)), (3, 6, None));
        check_disk(&mesh);
    }

    #[test]
    fn a_split_on_the_boundary_adds_a_face_and_a_collapse_removes_one() {
        let mut mesh = hexagon();
        let m = mesh.split(edge_between(&mesh, 2, 3));
        assert_eq!((mesh.face_count(), mesh.valence(m)), (7, 3));
        check_disk(&mesh);
        let edge = edge_between(&mesh, 4, 5);
        assert!(mesh.can_collapse(edge) && !mesh.can_flip(edge));
        mesh.collapse(edge);
        assert_eq!(mesh.face_count(), 6);
        check_disk(&mesh);
    }

    #[test]
    fn edges_inside_split_flip_and_collapse_beside_the_boundary() {
        let mut mesh = hexagon();
        mesh.split(edge_between(&mesh, 6, 1));
        check_disk(&mesh);
        let edge = edge_between(&mesh, 6, 3);
        assert!(mesh.can_flip(edge));
        mesh.flip(edge);
        assert!(mesh.are_neighbours(2, 4));
        check_disk(&mesh);
        let across = edge_between(&mesh, 2, 4);
        assert!(!mesh.can_collapse(across), "an edge from boundary to boundary would pinch the disk");
        let edge = edge_between(&mesh, 6, 5);
        assert!(mesh.can_collapse(edge));
        mesh.collapse(edge);
        check_disk(&mesh);
    }

    #[test]
    fn sorting_renumbers_the_same_triangles_after_changes() {
        let mut mesh = Connectivity::from_faces(6, &OCTAHEDRON).unwrap();
        mesh.split(0);
        let edge = mesh.edges().into_iter().find(|h| mesh.can_collapse(*h)).unwrap();
        mesh.collapse(edge);
        let turned = |f: [u32; 3]| {
            let least = (0..3).min_by_key(|i| f[*i]).unwrap_or(0);
            [0, 1, 2].map(|i| f[(least + i) % 3])
        };
        let mut before: Vec<[u32; 3]> = mesh.faces().map(turned).collect();
        // The last vertex becomes the first one.
        let ranks: Vec<u32> = (0..mesh.vertex_bound() as u32).rev().collect();
        let old = mesh.sort_by(&ranks);
        assert!(old.is_sorted_by(|a, b| a > b));
        assert_eq!(old.len(), 6);
        let firsts: Vec<u32> = mesh.faces().map(|f| f.into_iter().min().unwrap()).collect();
        assert!(firsts.is_sorted());
        let mut after: Vec<[u32; 3]> = mesh.faces().map(|f| turned(f.map(|v| old[v as usize]))).collect();
        before.sort_unstable();
        after.sort_unstable();
        assert_eq!(before, after);
        check(&mut mesh);
    }

    #[test]
    fn a_single_triangle_can_only_be_split() {
        let mut mesh = Connectivity::from_faces(3, &[[0, 1, 2]]).unwrap();
        assert!(mesh.edges().into_iter().all(|h| !mesh.can_collapse(h) && !mesh.can_flip(h)));
        mesh.split(0);
        check_disk(&mesh);
    }

    #[test]
    fn two_boundaries_through_a_vertex_are_refused() {
        let faces = [[0, 1, 2], [0, 3, 4]];
        assert!(Connectivity::from_faces(5, &faces).is_none());
        let (mesh, pinched) = Connectivity::of_part(5, &faces);
        assert_eq!((mesh.face_count(), pinched), (2, vec![0]));
    }
}
