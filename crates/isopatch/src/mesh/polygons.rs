use super::buckets::Buckets;
use super::repairs::Place;

/// Marks a half edge without a partner.
pub(super) const NONE: u32 = u32::MAX;

/// Faces of any number of corners, in one array. Corner h of the array is also half edge h: from that corner to the
/// next one of the same face.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    /// End of each face in `corners`; it starts where the one before ends.
    end: Vec<u32>,
    corners: Vec<u32>,
    /// The face of the input that each face comes from.
    source: Vec<u32>,
}

impl Polygons {
    /// No faces, with room for some.
    pub fn with_capacity(faces: usize, corners: usize) -> Self {
        Self {
            end: Vec::with_capacity(faces),
            corners: Vec::with_capacity(corners),
            source: Vec::with_capacity(faces),
        }
    }

    /// Appends a face.
    pub fn push(&mut self, source: u32, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.end.push(self.corners.len() as u32);
        self.source.push(source);
    }

    /// The same faces, with every vertex replaced.
    pub fn renumbered(mut self, by: &[u32]) -> Self {
        self.corners.iter_mut().for_each(|v| *v = by[*v as usize]);
        self
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.end.len()
    }

    /// All corners, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The corners of a face, as a range of half edges.
    pub fn range(&self, f: usize) -> std::ops::Range<usize> {
        let start = if f == 0 { 0 } else { self.end[f - 1] };
        start as usize..self.end[f] as usize
    }

    /// The vertices of a face.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corners[self.range(f)]
    }

    /// Where a face comes from.
    pub fn source(&self, f: usize) -> u32 {
        self.source[f]
    }

    /// The vertices and the source of every face.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u32])> {
        (0..self.len()).map(|f| (self.source[f], self.face(f)))
    }
}

/// The edges of polygons, with any number of faces each.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    /// Start vertex of each half edge.
    pub origin: Vec<u32>,
    /// End vertex of each half edge.
    pub dest: Vec<u32>,
    /// Face of each half edge.
    pub face: Vec<u32>,
    /// The half edge after it in its face.
    pub next: Vec<u32>,
    /// Half edges, those of one edge together.
    sorted: Vec<u32>,
    /// End of each edge in `sorted`.
    end: Vec<u32>,
}

impl Edges {
    /// Sorts the half edges by their ends: linear time where no vertex has very many.
    pub fn new(polygons: &Polygons) -> Self {
        let origin = polygons.corners().to_vec();
        let (mut face, mut next) = (Vec::with_capacity(origin.len()), Vec::with_capacity(origin.len()));
        for f in 0..polygons.len() {
            let range = polygons.range(f);
            face.resize(range.end, f as u32);
            next.extend(range.clone().map(|h| if h + 1 == range.end { range.start } else { h + 1 } as u32));
        }
        let dest: Vec<u32> = next.iter().map(|h| origin[*h as usize]).collect();
        let ends = || origin.iter().zip(&dest);
        let low: Vec<u32> = ends().map(|(a, b)| *a.min(b)).collect();
        let high: Vec<u32> = ends().map(|(a, b)| *a.max(b)).collect();
        // Half edges by their lower vertex, which has few of them; then these by the other one.
        let vertices = low.iter().max().map_or(0, |v| *v as usize + 1);
        let (mut sorted, ends_of) = Buckets::new(&low, vertices).into_parts();
        let mut end = Vec::with_capacity(low.len());
        let mut start = 0;
        for past in ends_of {
            let at_vertex = &mut sorted[start..past as usize];
            at_vertex.sort_unstable_by_key(|h| (high[*h as usize], *h));
            for group in at_vertex.chunk_by(|g, h| high[*g as usize] == high[*h as usize]) {
                start += group.len();
                end.push(start as u32);
            }
        }
        Self { origin, dest, face, next, sorted, end }
    }

    /// Number of half edges.
    pub fn half_edge_count(&self) -> usize {
        self.origin.len()
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.end.len()
    }

    /// The half edges of an edge, in ascending order.
    pub fn of(&self, edge: usize) -> &[u32] {
        let start = if edge == 0 { 0 } else { self.end[edge - 1] };
        &self.sorted[start as usize..self.end[edge] as usize]
    }

    /// The half edges of every edge, edges in the order of their ends.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|e| self.of(e))
    }

    /// The ends of a half edge, smaller number first.
    pub fn ends(&self, h: u32) -> [u32; 2] {
        let (a, b) = (self.origin[h as usize], self.dest[h as usize]);
        [a.min(b), a.max(b)]
    }

    /// Does the half edge run from the smaller vertex number to the larger?
    pub fn ascends(&self, h: u32) -> bool {
        self.origin[h as usize] < self.dest[h as usize]
    }

    /// The edge of a half edge, for messages.
    pub fn place(&self, h: u32) -> Place {
        let [a, b] = self.ends(h);
        Place::Edge(a, b)
    }
}

/// Sets of numbers that are joined step by step; a set is known by its smallest member.
#[derive(Clone, Debug)]
pub(super) struct Joined(Vec<u32>);

impl Joined {
    /// Every number below `count` alone.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The smallest member of a number's set.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    /// Makes one set of two.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
