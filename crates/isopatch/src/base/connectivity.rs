//! Connectivity that changes: closed triangle meshes under splits, collapses and flips.

/// Marks what no longer exists.
const NONE: u32 = u32::MAX;

/// A closed oriented triangle mesh that can be changed in constant time.
///
/// Half edge 3f + k runs from corner k to corner k + 1 of face f, as in [`crate::mesh::HalfEdgeMesh`].
/// Removed faces and vertices leave holes in the numbering until [`Connectivity::compact`].
#[derive(Clone, Debug)]
pub(super) struct Connectivity {
    origin: Vec<u32>,
    twin: Vec<u32>,
    /// An outgoing half edge of each vertex; `NONE` if removed.
    outgoing: Vec<u32>,
    face_count: usize,
}

/// A part of a [`Connectivity`] as it was.
#[derive(Clone, Debug)]
pub(super) struct Snapshot {
    half_edges: Vec<(u32, u32, u32)>,
    vertices: Vec<(u32, u32)>,
    face_count: usize,
}

fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Connectivity {
    /// Connectivity of a closed manifold; none if an edge has no partner in the opposite direction.
    pub fn from_faces(vertex_count: usize, faces: &[[u32; 3]]) -> Option<Self> {
        let origin: Vec<u32> = faces.iter().flatten().copied().collect();
        let mut start = vec![0u32; vertex_count + 1];
        for v in &origin {
            start[*v as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut leaving = vec![0u32; origin.len()];
        for (h, v) in origin.iter().enumerate() {
            leaving[fill[*v as usize] as usize] = h as u32;
            fill[*v as usize] += 1;
        }
        let mut twin = vec![NONE; origin.len()];
        for h in 0..origin.len() as u32 {
            let (a, b) = (origin[h as usize], origin[next(h) as usize]);
            let of_b = &leaving[start[b as usize] as usize..start[b as usize + 1] as usize];
            twin[h as usize] = *of_b.iter().find(|g| origin[next(**g) as usize] == a)?;
        }
        let outgoing = (0..vertex_count)
            .map(|v| if start[v] < start[v + 1] { leaving[start[v] as usize] } else { NONE })
            .collect();
        Some(Self { origin, twin, outgoing, face_count: faces.len() })
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

    pub fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize]
    }

    /// Corners of the face of a half edge, from its origin on.
    pub fn corners(&self, h: u32) -> [u32; 3] {
        [self.origin(h), self.dest(h), self.apex(h)]
    }

    /// Faces that exist.
    pub fn faces(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.origin.chunks_exact(3).filter(|f| f[0] != NONE).map(|f| [f[0], f[1], f[2]])
    }

    /// One half edge of every edge that exists.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.half_edge_bound()).filter(|h| self.is_half_edge(*h) && *h < self.twin(*h))
    }

    /// Vertices that exist.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.outgoing.len() as u32).filter(|v| self.is_vertex(*v))
    }

    /// Outgoing half edges of a vertex, counter-clockwise.
    pub fn ring(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing[v as usize];
        std::iter::successors(Some(first), move |h| {
            Some(self.twin(prev(*h))).filter(|following| *following != first)
        })
    }

    pub fn valence(&self, v: u32) -> usize {
        self.ring(v).count()
    }

    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        self.ring(a).any(|h| self.dest(h) == b)
    }

    fn link(&mut self, h: u32, g: u32) {
        self.twin[h as usize] = g;
        self.twin[g as usize] = h;
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

    /// May the edge be replaced by the one between the two apexes?
    pub fn can_flip(&self, h: u32) -> bool {
        let (c, d) = (self.apex(h), self.apex(self.twin(h)));
        let spare = |v| self.ring(v).take(4).count() == 4;
        c != d && spare(self.origin(h)) && spare(self.dest(h)) && !self.are_neighbours(c, d)
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
        let g = self.twin(h);
        let ([a, b, c], d) = (self.corners(h), self.apex(g));
        let [bc, ca, ad, db] = [next(h), prev(h), next(g), prev(g)].map(|e| self.twin(e));
        self.set_face(h, [d, c, a], [g, ca, ad]);
        self.set_face(g, [c, d, b], [h, db, bc]);
    }

    /// Puts a new vertex on the edge; returns it. Two faces more.
    pub fn split(&mut self, h: u32) -> u32 {
        let g = self.twin(h);
        let ([a, b, c], d) = (self.corners(h), self.apex(g));
        let m = self.outgoing.len() as u32;
        let (p, q) = (self.half_edge_bound(), self.half_edge_bound() + 3);
        self.outgoing.push(p);
        self.origin.resize(self.origin.len() + 6, NONE);
        self.twin.resize(self.twin.len() + 6, NONE);
        let [bc, ca, ad, db] = [next(h), prev(h), next(g), prev(g)].map(|e| self.twin(e));
        // (a, b, c) → (a, m, c), (m, b, c) and (b, a, d) → (b, m, d), (m, a, d).
        self.set_face(h, [a, m, c], [q, prev(p), ca]);
        self.set_face(p, [m, b, c], [g, bc, next(h)]);
        self.set_face(g, [b, m, d], [p, prev(q), db]);
        self.set_face(q, [m, a, d], [h, ad, next(g)]);
        self.face_count += 2;
        m
    }

    /// Would merging the ends keep the surface a manifold of the same topology (the link condition)?
    pub fn can_collapse(&self, h: u32) -> bool {
        let (a, b) = (self.origin(h), self.dest(h));
        let (c, d) = (self.apex(h), self.apex(self.twin(h)));
        let common = self.ring(a).filter(|e| self.are_neighbours(self.dest(*e), b)).count();
        let spare = |v| self.ring(v).take(4).count() == 4;
        // Valence 3 must remain at the merged vertex and at the two apexes.
        common == 2 && c != d && spare(c) && spare(d) && self.valence(a) + self.valence(b) >= 7
    }

    /// Merges b into a along the half edge a → b. Two faces less. [`Connectivity::can_collapse`] must hold.
    pub fn collapse(&mut self, h: u32) {
        let g = self.twin(h);
        let ([a, b, c], d) = (self.corners(h), self.apex(g));
        let [bc, ca, ad, db] = [next(h), prev(h), next(g), prev(g)].map(|e| self.twin(e));
        let of_b: Vec<u32> = self.ring(b).collect();
        for e in of_b {
            self.origin[e as usize] = a;
        }
        self.link(bc, ca);
        self.link(ad, db);
        self.outgoing[a as usize] = ca; // was a → c
        self.outgoing[c as usize] = bc; // was c → b
        self.outgoing[d as usize] = ad; // was d → a
        self.outgoing[b as usize] = NONE;
        for e in [h, g] {
            for dead in [e, next(e), prev(e)] {
                self.origin[dead as usize] = NONE;
            }
        }
        self.face_count -= 2;
    }

    /// Corners of some faces.
    pub fn clone_faces(&self, faces: &[u32]) -> Vec<[u32; 3]> {
        faces.iter().map(|f| self.corners(3 * f)).collect()
    }

    /// Everything about some faces, the half edges across their sides, and some vertices.
    pub fn snapshot(&self, faces: &[u32], vertices: &[u32]) -> Snapshot {
        let own = faces.iter().flat_map(|f| 3 * f..3 * f + 3);
        let mut half_edges: Vec<u32> = own.flat_map(|h| [h, self.twin(h)]).collect();
        half_edges.sort_unstable();
        half_edges.dedup();
        Snapshot {
            half_edges: half_edges.into_iter().map(|h| (h, self.origin(h), self.twin(h))).collect(),
            vertices: vertices.iter().map(|v| (*v, self.outgoing[*v as usize])).collect(),
            face_count: self.face_count,
        }
    }

    /// Undoes collapses and flips that changed nothing but what the snapshot has.
    pub fn restore(&mut self, snapshot: &Snapshot) {
        for (h, origin, twin) in &snapshot.half_edges {
            self.origin[*h as usize] = *origin;
            self.twin[*h as usize] = *twin;
        }
        for (v, outgoing) in &snapshot.vertices {
            self.outgoing[*v as usize] = *outgoing;
        }
        self.face_count = snapshot.face_count;
    }

    /// Closes the holes in the numbering; returns the old number of every new vertex.
    pub fn compact(&mut self) -> Vec<u32> {
        let kept: Vec<u32> = self.vertices().collect();
        let mut new_vertex = vec![NONE; self.outgoing.len()];
        for (new, old) in kept.iter().enumerate() {
            new_vertex[*old as usize] = new as u32;
        }
        let mut new_face = vec![NONE; self.origin.len() / 3];
        let mut count = 0;
        for f in 0..new_face.len() {
            if self.origin[3 * f] != NONE {
                new_face[f] = count;
                count += 1;
            }
        }
        let renumber = |h: u32| 3 * new_face[h as usize / 3] + h % 3;
        let live = |h: &usize| self.origin[*h] != NONE;
        let origin =
            (0..self.origin.len()).filter(live).map(|h| new_vertex[self.origin[h] as usize]).collect();
        let twin = (0..self.origin.len()).filter(live).map(|h| renumber(self.twin[h])).collect();
        let outgoing = kept.iter().map(|v| renumber(self.outgoing[*v as usize])).collect();
        *self = Self { origin, twin, outgoing, face_count: self.face_count };
        kept
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
                assert_eq!(mesh.twin(mesh.twin(h)), h);
                assert_eq!(
                    (mesh.origin(h), mesh.dest(h)),
                    (mesh.dest(mesh.twin(h)), mesh.origin(mesh.twin(h)))
                );
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
        let edge = mesh.edges().find(|h| mesh.can_flip(*h)).unwrap();
        let ends = (mesh.apex(edge), mesh.apex(mesh.twin(edge)));
        mesh.flip(edge);
        assert!(mesh.are_neighbours(ends.0, ends.1));
        check(&mut mesh);
        let edge = mesh.edges().find(|h| mesh.can_collapse(*h)).unwrap();
        mesh.collapse(edge);
        assert_eq!(mesh.face_count(), 8);
        check(&mut mesh);
    }

    #[test]
    fn a_tetrahedron_can_neither_collapse_nor_flip() {
        let mesh = Connectivity::from_faces(4, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        assert!(mesh.edges().all(|h| !mesh.can_collapse(h) && !mesh.can_flip(h)));
    }

    #[test]
    fn an_open_mesh_is_refused() {
        assert!(Connectivity::from_faces(3, &[[0, 1, 2]]).is_none());
    }
}
