use std::ops::Range;

/// Marks a missing half edge: the twin on a boundary, the half edge of an isolated vertex.
const NONE: u32 = u32::MAX;

macro_rules! typed_id {
    ($name:ident, $what:literal) => {
        #[doc = concat!("Number of ", $what, " in its mesh, from 0.")]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// As an index into a per-element array.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<usize> for $name {
            fn from(index: usize) -> Self {
                Self(index as u32)
            }
        }
    };
}

typed_id!(VertexId, "a vertex");
typed_id!(EdgeId, "an undirected edge");
typed_id!(HalfEdgeId, "a half edge");
typed_id!(FaceId, "a face");

/// Why faces do not form an oriented 2-manifold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A face has fewer than three corners, or the same vertex twice.
    #[error("face {face} is degenerate")]
    DegenerateFace {
        /// The face.
        face: u32,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are only {count} vertices")]
    NoSuchVertex {
        /// The face.
        face: u32,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: u32,
    },
    /// Two faces run along an edge in the same direction: three faces meet there, or orientations disagree.
    #[error(
        "edge {from} → {to} belongs to faces {first} and {second} in the same direction (non-manifold or inconsistently oriented)"
    )]
    NonManifoldEdge {
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
        /// One face.
        first: u32,
        /// The other.
        second: u32,
    },
    /// The faces around a vertex form more than one fan.
    #[error("the faces around vertex {vertex} form more than one fan (non-manifold)")]
    NonManifoldVertex {
        /// The vertex.
        vertex: u32,
    },
    /// A vertex without faces.
    #[error("vertex {vertex} belongs to no face")]
    IsolatedVertex {
        /// The vertex.
        vertex: u32,
    },
}

/// A half edge among those with the same smaller end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct DirectedEdge {
    larger_end: u32,
    half_edge: HalfEdgeId,
    /// Does it run from the smaller end to the larger one?
    ascends: bool,
}

/// The first two half edges of one edge that run in the same direction, the later one as early as possible.
fn clash_of(edge: &[DirectedEdge]) -> Option<[HalfEdgeId; 2]> {
    let mut seen = [None; 2];
    edge.iter()
        .find_map(|h| seen[usize::from(h.ascends)].replace(h.half_edge).map(|earlier| [earlier, h.half_edge]))
}

/// An oriented 2-manifold mesh of polygons, with or without boundary, as half edges in arrays.
///
/// Immutable: algorithms that change connectivity return new face lists.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfEdgeMesh {
    /// First half edge of each face, and the total count at the end.
    face_start: Vec<u32>,
    origin: Vec<u32>,
    twin: Vec<u32>,
    face: Vec<u32>,
    edge: Vec<u32>,
    /// The half edge with the smaller number, of each edge.
    edge_half_edge: Vec<u32>,
    /// An outgoing half edge of each vertex; the clockwise-most one at a boundary, so that the ring starts there.
    vertex_half_edge: Vec<u32>,
}

impl HalfEdgeMesh {
    /// Builds the connectivity of `faces`, each a counter-clockwise list of vertex numbers below `vertex_count`.
    ///
    /// Linear time. Every vertex must belong to a face; every edge to one or two faces, in opposite directions;
    /// the faces around a vertex must form one fan.
    pub fn from_faces<F: AsRef<[u32]>>(vertex_count: usize, faces: &[F]) -> Result<Self, MeshError> {
        let mut face_start = Vec::with_capacity(faces.len() + 1);
        let (mut origin, mut face_of) = (Vec::new(), Vec::new());
        face_start.push(0);
        let mut last_face = vec![NONE; vertex_count];
        for (f, corners) in faces.iter().enumerate() {
            let (face, corners) = (f as u32, corners.as_ref());
            if corners.len() < 3 {
                return Err(MeshError::DegenerateFace { face });
            }
            for &vertex in corners {
                let Some(last) = last_face.get_mut(vertex as usize) else {
                    return Err(MeshError::NoSuchVertex { face, vertex, count: vertex_count as u32 });
                };
                if std::mem::replace(last, face) == face {
                    return Err(MeshError::DegenerateFace { face });
                }
            }
            origin.extend_from_slice(corners);
            face_of.resize(origin.len(), face);
            face_start.push(origin.len() as u32);
        }
        let mut mesh = Self {
            twin: vec![NONE; origin.len()],
            edge: vec![NONE; origin.len()],
            edge_half_edge: Vec::with_capacity(origin.len() / 2),
            vertex_half_edge: vec![NONE; vertex_count],
            face_start,
            origin,
            face: face_of,
        };
        mesh.pair_twins()?;
        mesh.number_edges();
        mesh.choose_vertex_half_edges()?;
        Ok(mesh)
    }

    /// Finds the opposite half edges: those of one edge come together when half edges are put into the bucket of their
    /// smaller end, and each bucket is sorted by the larger one.
    fn pair_twins(&mut self) -> Result<(), MeshError> {
        let (start, buckets) = self.by_smaller_end();
        let mut clash: Option<[HalfEdgeId; 2]> = None;
        for bucket in start.windows(2).map(|ends| ends[0] as usize..ends[1] as usize) {
            for edge in buckets[bucket].chunk_by(|a, b| a.larger_end == b.larger_end) {
                match *edge {
                    [a, b] if a.ascends != b.ascends => {
                        self.twin[a.half_edge.index()] = b.half_edge.0;
                        self.twin[b.half_edge.index()] = a.half_edge.0;
                    }
                    [_] => {}
                    _ => clash = clash.into_iter().chain(clash_of(edge)).min_by_key(|pair| pair[1]),
                }
            }
        }
        let Some([first, second]) = clash else { return Ok(()) };
        Err(MeshError::NonManifoldEdge {
            from: self.origin(second).0,
            to: self.dest(second).0,
            first: self.face(first).0,
            second: self.face(second).0,
        })
    }

    /// The half edges by their smaller end, then by their larger one, then by their own number; and where those of each
    /// vertex start. A counting sort, and short sorts of what meets at a vertex.
    fn by_smaller_end(&self) -> (Vec<u32>, Vec<DirectedEdge>) {
        let ends = |h: HalfEdgeId| (self.origin(h).0, self.dest(h).0);
        let mut start = vec![0u32; self.vertex_count() + 1];
        for (a, b) in self.half_edges().map(ends) {
            start[a.min(b) as usize + 1] += 1;
        }
        for v in 0..self.vertex_count() {
            start[v + 1] += start[v];
        }
        let mut free = start.clone();
        let mut buckets = vec![DirectedEdge::default(); self.half_edge_count()];
        for half_edge in self.half_edges() {
            let (a, b) = ends(half_edge);
            let place = &mut free[a.min(b) as usize];
            buckets[*place as usize] = DirectedEdge { larger_end: a.max(b), half_edge, ascends: a < b };
            *place += 1;
        }
        for ends in start.windows(2) {
            buckets[ends[0] as usize..ends[1] as usize].sort_unstable();
        }
        (start, buckets)
    }

    fn number_edges(&mut self) {
        for h in 0..self.origin.len() {
            if self.edge[h] == NONE {
                let e = self.edge_half_edge.len() as u32;
                self.edge[h] = e;
                if self.twin[h] != NONE {
                    self.edge[self.twin[h] as usize] = e;
                }
                self.edge_half_edge.push(h as u32);
            }
        }
    }

    fn choose_vertex_half_edges(&mut self) -> Result<(), MeshError> {
        let mut outgoing = vec![0u32; self.vertex_count()];
        for h in self.half_edges() {
            let v = self.origin(h).index();
            outgoing[v] += 1;
            if self.vertex_half_edge[v] == NONE || self.twin[h.index()] == NONE {
                self.vertex_half_edge[v] = h.0;
            }
        }
        for v in 0..self.vertex_count() {
            let vertex = v as u32;
            if outgoing[v] == 0 {
                return Err(MeshError::IsolatedVertex { vertex });
            }
            if self.ring(VertexId(vertex)).count() != outgoing[v] as usize {
                return Err(MeshError::NonManifoldVertex { vertex });
            }
        }
        Ok(())
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertex_half_edge.len()
    }

    /// Number of undirected edges.
    pub fn edge_count(&self) -> usize {
        self.edge_half_edge.len()
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.face_start.len() - 1
    }

    /// Number of half edges: the sum of the face degrees.
    pub fn half_edge_count(&self) -> usize {
        self.origin.len()
    }

    /// All vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + use<> {
        (0..self.vertex_count() as u32).map(VertexId)
    }

    /// All edges.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + use<> {
        (0..self.edge_count() as u32).map(EdgeId)
    }

    /// All faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.face_count() as u32).map(FaceId)
    }

    /// All half edges.
    pub fn half_edges(&self) -> impl ExactSizeIterator<Item = HalfEdgeId> + use<> {
        (0..self.half_edge_count() as u32).map(HalfEdgeId)
    }

    fn face_range(&self, f: FaceId) -> Range<u32> {
        self.face_start[f.index()]..self.face_start[f.index() + 1]
    }

    /// The half edges of a face, counter-clockwise from its first corner.
    pub fn face_half_edges(&self, f: FaceId) -> impl ExactSizeIterator<Item = HalfEdgeId> + use<> {
        let Range { start, end } = self.face_range(f);
        (start as usize..end as usize).map(HalfEdgeId::from)
    }

    /// The corners of a face, counter-clockwise.
    pub fn face_vertices(&self, f: FaceId) -> impl ExactSizeIterator<Item = VertexId> + '_ {
        self.face_half_edges(f).map(|h| self.origin(h))
    }

    /// The three corners of a triangle. For a larger polygon, its first three.
    pub fn triangle(&self, f: FaceId) -> [VertexId; 3] {
        let first = self.face_start[f.index()] as usize;
        [0, 1, 2].map(|k| VertexId(self.origin[first + k]))
    }

    /// Does every face have three corners?
    pub fn is_triangle_mesh(&self) -> bool {
        self.faces().all(|f| self.face_range(f).len() == 3)
    }

    /// Where a half edge starts.
    pub fn origin(&self, h: HalfEdgeId) -> VertexId {
        VertexId(self.origin[h.index()])
    }

    /// Where a half edge ends.
    pub fn dest(&self, h: HalfEdgeId) -> VertexId {
        self.origin(self.next(h))
    }

    /// The face on the left of a half edge.
    pub fn face(&self, h: HalfEdgeId) -> FaceId {
        FaceId(self.face[h.index()])
    }

    /// Which side of its face the half edge is, from 0.
    pub fn side(&self, h: HalfEdgeId) -> usize {
        (h.0 - self.face_start[self.face[h.index()] as usize]) as usize
    }

    /// The next half edge of the face.
    pub fn next(&self, h: HalfEdgeId) -> HalfEdgeId {
        let Range { start, end } = self.face_range(self.face(h));
        HalfEdgeId(if h.0 + 1 == end { start } else { h.0 + 1 })
    }

    /// The previous half edge of the face.
    pub fn prev(&self, h: HalfEdgeId) -> HalfEdgeId {
        let Range { start, end } = self.face_range(self.face(h));
        HalfEdgeId(if h.0 == start { end - 1 } else { h.0 - 1 })
    }

    /// The opposite half edge; none on a boundary.
    pub fn twin(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        let g = self.twin[h.index()];
        (g != NONE).then_some(HalfEdgeId(g))
    }

    /// The undirected edge of a half edge.
    pub fn edge(&self, h: HalfEdgeId) -> EdgeId {
        EdgeId(self.edge[h.index()])
    }

    /// The half edge that gives an edge its direction.
    pub fn edge_half_edge(&self, e: EdgeId) -> HalfEdgeId {
        HalfEdgeId(self.edge_half_edge[e.index()])
    }

    /// The next outgoing half edge of the same vertex, counter-clockwise; none past a boundary.
    pub fn ring_next(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        self.twin(self.prev(h))
    }

    /// The previous outgoing half edge of the same vertex, counter-clockwise; none past a boundary.
    pub fn ring_prev(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        self.twin(h).map(|g| self.next(g))
    }

    /// The outgoing half edges of a vertex, counter-clockwise; from boundary to boundary if it has one.
    pub fn ring(&self, v: VertexId) -> impl Iterator<Item = HalfEdgeId> + '_ {
        let first = HalfEdgeId(self.vertex_half_edge[v.index()]);
        std::iter::successors(Some(first), move |h| self.ring_next(*h).filter(|n| *n != first))
    }

    /// Number of edges at a vertex.
    pub fn valence(&self, v: VertexId) -> usize {
        self.ring(v).count() + usize::from(self.is_boundary_vertex(v))
    }

    /// Is the vertex on a boundary?
    pub fn is_boundary_vertex(&self, v: VertexId) -> bool {
        self.twin[self.vertex_half_edge[v.index()] as usize] == NONE
    }

    /// No boundary anywhere?
    pub fn is_closed(&self) -> bool {
        !self.twin.contains(&NONE)
    }

    /// Vertices − edges + faces.
    pub fn euler_number(&self) -> i64 {
        self.vertex_count() as i64 - self.edge_count() as i64 + self.face_count() as i64
    }

    /// The component number of every face (from 0, in order of their first faces), and how many there are.
    pub fn face_components(&self) -> (Vec<u32>, usize) {
        let mut component = vec![NONE; self.face_count()];
        let (mut count, mut stack) = (0, Vec::new());
        for seed in self.faces() {
            if component[seed.index()] != NONE {
                continue;
            }
            component[seed.index()] = count;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for g in self.face_half_edges(f).filter_map(|h| self.twin(h)) {
                    let neighbour = self.face(g);
                    if component[neighbour.index()] == NONE {
                        component[neighbour.index()] = count;
                        stack.push(neighbour);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }

    /// Number of connected components.
    pub fn component_count(&self) -> usize {
        self.face_components().1
    }

    /// Number of boundary loops.
    pub fn boundary_loop_count(&self) -> usize {
        let mut seen = vec![false; self.half_edge_count()];
        let mut count = 0;
        for start in self.half_edges().filter(|h| self.twin(*h).is_none()) {
            if seen[start.index()] {
                continue;
            }
            count += 1;
            let mut h = start;
            while !seen[h.index()] {
                seen[h.index()] = true;
                h = self.next(h);
                while let Some(g) = self.twin(h) {
                    h = self.next(g);
                }
            }
        }
        count
    }

    /// Total genus of the closed-up components: Σ (2 − χ − boundary loops) / 2.
    pub fn genus(&self) -> i64 {
        (2 * self.component_count() as i64 - self.euler_number() - self.boundary_loop_count() as i64) / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_a_closed_sphere() {
        let mesh = HalfEdgeMesh::from_faces(4, &TETRAHEDRON).unwrap();
        assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (4, 6, 4));
        assert_eq!((mesh.euler_number(), mesh.genus(), mesh.component_count()), (2, 0, 1));
        assert!(mesh.is_closed() && mesh.is_triangle_mesh());
        assert!(mesh.vertices().all(|v| mesh.valence(v) == 3));
    }

    #[test]
    fn half_edges_of_mixed_polygons_agree_with_each_other() {
        // A square pyramid: one quad, four triangles.
        let faces: [&[u32]; 5] = [&[3, 2, 1, 0], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
        let mesh = HalfEdgeMesh::from_faces(5, &faces).unwrap();
        for h in mesh.half_edges() {
            let g = mesh.twin(h).unwrap();
            assert_eq!(mesh.twin(g), Some(h));
            assert_eq!((mesh.origin(h), mesh.dest(h)), (mesh.dest(g), mesh.origin(g)));
            assert_eq!(mesh.prev(mesh.next(h)), h);
            assert_eq!(mesh.ring_prev(mesh.ring_next(h).unwrap()), Some(h));
            assert_eq!(mesh.edge(h), mesh.edge(g));
        }
        assert_eq!(mesh.valence(VertexId(4)), 4);
        assert_eq!(mesh.euler_number(), 2);
    }

    #[test]
    fn rings_of_an_open_mesh_run_from_boundary_to_boundary() {
        let mesh = HalfEdgeMesh::from_faces(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]).unwrap();
        let ring: Vec<u32> = mesh.ring(VertexId(0)).map(|h| mesh.dest(h).0).collect();
        assert_eq!(ring, [1, 2, 3]);
        assert_eq!(mesh.valence(VertexId(0)), 4);
        assert_eq!((mesh.euler_number(), mesh.boundary_loop_count(), mesh.genus()), (1, 1, 0));
    }

    #[test]
    fn faults_are_named() {
        let build = |faces: &[[u32; 3]], n| HalfEdgeMesh::from_faces(n, faces).unwrap_err();
        assert_eq!(build(&[[0, 1, 1]], 2), MeshError::DegenerateFace { face: 0 });
        assert_eq!(build(&[[0, 1, 7]], 3), MeshError::NoSuchVertex { face: 0, vertex: 7, count: 3 });
        assert_eq!(
            build(&[[0, 1, 2], [0, 1, 3]], 4),
            MeshError::NonManifoldEdge { from: 0, to: 1, first: 0, second: 1 }
        );
        let bow_tie = [[0, 1, 2], [0, 3, 4]];
        assert_eq!(build(&bow_tie, 5), MeshError::NonManifoldVertex { vertex: 0 });
        assert_eq!(build(&[[0, 1, 2]], 4), MeshError::IsolatedVertex { vertex: 3 });
        // Of two edges with too many faces, the one whose second face comes first.
        let two = [[4, 5, 6], [0, 1, 2], [5, 4, 7], [1, 0, 3], [0, 1, 3], [4, 5, 8]];
        assert_eq!(build(&two, 9), MeshError::NonManifoldEdge { from: 0, to: 1, first: 1, second: 4 });
    }
}
