//! Thinning out a conforming mesh: edges are collapsed to one of their ends, the cheapest by quadric error first (Garland &
//! Heckbert, Surface simplification using quadric error metrics, 1997), as long as all triangles stay near the surface.
//!
//! Vertices stay on the surface, because none moves. Singular points stay; vertices of arcs go along their arc, those of the
//! border along their side of the box. The link condition keeps the topology.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap, HashMap};

use super::flip::flip;
use super::mend::mend;
use super::quality::Judge;
use super::singular_mesh::{SingularMesh, VertexKind};
use crate::base::BoxSides;
use crate::field::Field;
use crate::geom::{Mat3, Point3, Vec3};

/// What a thinned-out mesh keeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest distance to the surface, a length.
    pub(super) tolerance: f64,
    /// Least |∇f| in this distance.
    pub(super) floor: f64,
    /// So few triangles are enough.
    pub(super) enough: usize,
}

/// Cosine of the largest angle between a triangle and the surface at its corners.
const LEAST_COSINE: f64 = 0.5;
/// The shape of a triangle, 1 where it is regular, below which it must not become worse.
const LEAST_SHAPE: f64 = 0.08;
/// Weight of the planes that hold borders and arcs in place, for that of a triangle of the same size.
const HOLD: f64 = 10.0;
/// Edges that are shorter than this share of the tolerance are too short to matter.
const SHORT: f64 = 0.15;
/// A pass that collapses fewer than one in this many vertices is the last.
const WORTH_ANOTHER: usize = 100;

/// Thins the mesh out; normals are not kept.
pub(super) fn decimate(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) {
    loop {
        let mut state = State::new(field, mesh, limits);
        let collapsed = state.run();
        let vertices = mesh.positions.len();
        *mesh = state.finish(mesh);
        flip(field, mesh, limits);
        let mut state = State::new(field, mesh, limits);
        let mended = state.mend();
        if mended > 0 {
            *mesh = state.finish(mesh);
        }
        if collapsed * WORTH_ANOTHER <= vertices {
            mend(field, mesh, limits);
            return;
        }
    }
}

/// x ↦ xᵀAx + 2b·x + c.
#[derive(Clone, Copy)]
struct Quadric {
    a: Mat3,
    b: Vec3,
    c: f64,
}

impl Quadric {
    const ZERO: Self = Self {
        a: Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        b: Vec3::new(0.0, 0.0, 0.0),
        c: 0.0,
    };

    fn plane(normal: Vec3, through: Point3, weight: f64) -> Self {
        let d = -normal.dot(&through);
        Self { a: normal * normal.transpose() * weight, b: normal * (d * weight), c: d * d * weight }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn at(&self, x: Point3) -> f64 {
        (x.dot(&(self.a * x)) + 2.0 * self.b.dot(&x) + self.c).max(0.0)
    }
}

/// A collapse of `from` to `to`, as it was when the two had these versions.
struct Candidate {
    cost: f64,
    from: u32,
    to: u32,
    versions: [u32; 2],
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap gives the largest first.
        let by_cost = other.cost.total_cmp(&self.cost);
        by_cost.then_with(|| (other.from, other.to).cmp(&(self.from, self.to)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// How bad triangles may be: as bad as [`Worst::LIMIT`], or as the worst of those that they replace.
#[derive(Clone, Copy)]
struct Worst {
    shape: f64,
    cosine: f64,
}

impl Worst {
    const LIMIT: Self = Self { shape: LEAST_SHAPE, cosine: LEAST_COSINE };

    /// For edges that are too short to matter: half as good, and up to a right angle.
    fn loosened(self) -> Self {
        Self { shape: 0.5 * self.shape, cosine: self.cosine.min(0.0) }
    }

    fn or(self, judge: &Judge<'_>, corners: [u32; 3]) -> Self {
        Self { shape: self.shape.min(judge.shape(corners)), cosine: self.cosine.min(judge.cosine(corners)) }
    }
}

pub(super) struct State<'a> {
    judge: Judge<'a>,
    positions: &'a [Point3],
    kinds: &'a [VertexKind],
    sides: &'a [BoxSides],
    triangles: Vec<Option<[u32; 3]>>,
    around: Vec<Vec<u32>>,
    /// Neighbours along singular arcs.
    along: Vec<BTreeSet<u32>>,
    quadrics: Vec<Quadric>,
    versions: Vec<u32>,
}

impl<'a> State<'a> {
    pub(super) fn new(field: &'a dyn Field, mesh: &'a SingularMesh, limits: Limits) -> Self {
        let count = mesh.positions.len();
        let mut around = vec![Vec::new(); count];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|v| around[*v as usize].push(t as u32));
        }
        let mut along = vec![BTreeSet::new(); count];
        for [a, b] in &mesh.singular_edges {
            along[*a as usize].insert(*b);
            along[*b as usize].insert(*a);
        }
        let mut state = Self {
            judge: Judge::new(field, &mesh.positions, &mesh.vertices, limits),
            positions: &mesh.positions,
            kinds: &mesh.vertices,
            sides: &mesh.sides,
            triangles: mesh.triangles.iter().copied().map(Some).collect(),
            around,
            along,
            quadrics: vec![Quadric::ZERO; count],
            versions: vec![0; count],
        };
        state.set_quadrics(mesh);
        state
    }

    fn set_quadrics(&mut self, mesh: &SingularMesh) {
        for t in &mesh.triangles {
            let [p, q, r] = t.map(|v| self.positions[v as usize]);
            let area = (q - p).cross(&(r - p));
            let Some(normal) = area.try_normalize(0.0) else { continue };
            let plane = Quadric::plane(normal, p, 0.5 * area.norm());
            t.iter().for_each(|v| self.quadrics[*v as usize] = self.quadrics[*v as usize].plus(&plane));
        }
        let edges = mesh.edges();
        let borders = edges.iter().filter(|(_, t)| t.len() == 1).map(|(ends, _)| ends);
        for ends in borders.chain(&mesh.singular_edges) {
            let [p, q] = ends.map(|v| self.positions[v as usize]);
            let Some(tangent) = (q - p).try_normalize(0.0) else { continue };
            let first = tangent.cross(&Vec3::ith(tangent.iamin(), 1.0)).normalize();
            for normal in [first, tangent.cross(&first)] {
                let plane = Quadric::plane(normal, p, HOLD * (q - p).norm_squared());
                ends.iter()
                    .for_each(|v| self.quadrics[*v as usize] = self.quadrics[*v as usize].plus(&plane));
            }
        }
    }

    fn run(&mut self) -> usize {
        let mut heap = BinaryHeap::new();
        for v in 0..self.positions.len() as u32 {
            for w in self.neighbours(v) {
                heap.push(self.candidate(v, w));
            }
        }
        let mut collapsed = 0;
        let mut count = self.triangles.len();
        while count > self.judge.limits().enough
            && let Some(Candidate { from, to, versions, .. }) = heap.pop()
        {
            if versions != [from, to].map(|v| self.versions[v as usize]) {
                continue;
            }
            if self.keeps_topology(from, to) && self.stays_near(from, to) {
                count -= self.collapse(from, to);
                collapsed += 1;
                for w in self.neighbours(to) {
                    heap.push(self.candidate(to, w));
                    heap.push(self.candidate(w, to));
                }
            }
        }
        collapsed
    }

    /// Collapses edges of triangles that turn over, where none does afterwards, whatever their shapes; how many.
    fn mend(&mut self) -> usize {
        let mut mended = 0;
        for t in 0..self.triangles.len() {
            let Some(corners) = self.triangles[t] else { continue };
            if self.judge.cosine(corners) > 0.0 {
                continue;
            }
            let mut best: Option<(f64, u32, u32)> = None;
            for from in corners {
                for to in self.neighbours(from) {
                    let worst = if self.keeps_topology(from, to) { self.worst_after(from, to) } else { -1.0 };
                    if worst > best.map_or(0.0, |b| b.0) {
                        best = Some((worst, from, to));
                    }
                }
            }
            if let Some((_, from, to)) = best {
                self.collapse(from, to);
                mended += 1;
            }
        }
        mended
    }

    /// The least cosine of an angle between triangles and surface after a collapse; −1 if one is too far away.
    fn worst_after(&self, from: u32, to: u32) -> f64 {
        let changed = self.corners_around(from).filter(|c| !c.contains(&to));
        let moved = changed.map(|c| c.map(|v| if v == from { to } else { v }));
        let mut worst: f64 = 1.0;
        for c in moved {
            worst = worst.min(if self.judge.is_near(c) { self.judge.cosine(c) } else { -1.0 });
        }
        worst
    }

    fn candidate(&self, from: u32, to: u32) -> Candidate {
        let (f, t) = (from as usize, to as usize);
        let length = (self.positions[f] - self.positions[t]).norm_squared();
        /// Among equals, short edges first.
        const TIE: f64 = 1e-9;
        let cost = self.quadrics[f].plus(&self.quadrics[t]).at(self.positions[t]) + TIE * length * length;
        Candidate { cost, from, to, versions: [self.versions[f], self.versions[t]] }
    }

    pub(super) fn corners_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.around[v as usize].iter().filter_map(|t| self.triangles[*t as usize])
    }

    pub(super) fn neighbours(&self, v: u32) -> BTreeSet<u32> {
        self.corners_around(v).flatten().filter(|w| *w != v).collect()
    }

    /// Neighbours along the border.
    fn border(&self, v: u32) -> BTreeSet<u32> {
        let mut count: HashMap<u32, usize> = HashMap::new();
        for w in self.corners_around(v).flatten().filter(|w| *w != v) {
            *count.entry(w).or_default() += 1;
        }
        count.into_iter().filter(|(_, n)| *n == 1).map(|(w, _)| w).collect()
    }

    /// Vertices that both ends of an edge are joined to without a triangle between the three.
    pub(super) fn beside(&self, a: u32, b: u32) -> Vec<u32> {
        let around: BTreeSet<u32> = self.corners_around(a).filter(|c| c.contains(&b)).flatten().collect();
        let (mine, theirs) = (self.neighbours(a), self.neighbours(b));
        mine.intersection(&theirs).filter(|w| !around.contains(w)).copied().collect()
    }

    pub(super) fn keeps_topology(&self, from: u32, to: u32) -> bool {
        let (f, t) = (from as usize, to as usize);
        let border = self.border(from);
        match self.kinds[f] {
            VertexKind::Special(_) | VertexKind::Isolated(_) => return false,
            VertexKind::OnCurve(_) => {
                let goes_on = self.along[f].contains(&to) && border.is_empty();
                let is_loop = self.along[f].intersection(&self.along[t]).next().is_some();
                if !goes_on || is_loop || self.along[f].len() != 2 {
                    return false;
                }
            }
            VertexKind::Regular => {}
        }
        if !border.is_empty() {
            let stays = self.sides[t].contains_all(self.sides[f]) && border.contains(&to);
            let is_loop = border.intersection(&self.border(to)).next().is_some();
            if !stays || is_loop || border.len() != 2 {
                return false;
            }
        }
        // The link condition.
        let (mine, theirs) = (self.neighbours(from), self.neighbours(to));
        let opposite: BTreeSet<u32> = self
            .corners_around(from)
            .filter(|c| c.contains(&to))
            .flatten()
            .filter(|w| *w != from && *w != to)
            .collect();
        let same = mine.intersection(&theirs).count() == opposite.len();
        let existing: BTreeSet<[u32; 2]> = self.corners_around(to).map(|c| rest(c, to)).collect();
        let doubles = |c: [u32; 3]| !c.contains(&to) && existing.contains(&rest(c, from));
        same && !self.corners_around(from).any(doubles)
    }

    fn stays_near(&self, from: u32, to: u32) -> bool {
        let mut limits = self.corners_around(from).fold(Worst::LIMIT, |limits, c| limits.or(&self.judge, c));
        let tolerance = self.judge.limits().tolerance;
        let length = (self.positions[from as usize] - self.positions[to as usize]).norm();
        // Triangles come farther from the surface by no more than a vertex moves. Without this, vertices would stay that are closer
        // together than anything that the mesh shows.
        let is_short = length <= SHORT * tolerance;
        let enough = (1.0 - SHORT) * tolerance + if is_short { length } else { 0.0 };
        if is_short {
            limits = limits.loosened();
        }
        let changed = self.corners_around(from).filter(|c| !c.contains(&to));
        let mut moved = changed.map(|c| c.map(|v| if v == from { to } else { v }));
        moved.all(|c| {
            self.judge.shape(c) >= limits.shape
                && self.judge.cosine(c) >= limits.cosine
                && self.judge.distance(c, enough) <= enough
        })
    }

    /// Moves `from` into `to`; how many triangles vanish.
    pub(super) fn collapse(&mut self, from: u32, to: u32) -> usize {
        let (f, t) = (from as usize, to as usize);
        let mut vanished = 0;
        for n in std::mem::take(&mut self.around[f]) {
            let Some(corners) = self.triangles[n as usize] else { continue };
            if corners.contains(&to) {
                self.triangles[n as usize] = None;
                vanished += 1;
            } else {
                self.triangles[n as usize] = Some(corners.map(|v| if v == from { to } else { v }));
                self.around[t].push(n);
            }
        }
        let triangles = &self.triangles;
        self.around[t].retain(|n| triangles[*n as usize].is_some());
        self.quadrics[t] = self.quadrics[t].plus(&self.quadrics[f]);
        for w in std::mem::take(&mut self.along[f]) {
            self.along[w as usize].remove(&from);
            if w != to {
                self.along[w as usize].insert(to);
                self.along[t].insert(w);
            }
        }
        self.versions[f] += 1;
        self.versions[t] += 1;
        vanished
    }

    /// The mesh that is left, without the vertices that nothing uses.
    pub(super) fn finish(&self, mesh: &SingularMesh) -> SingularMesh {
        let mut number = vec![None; self.positions.len()];
        self.triangles.iter().flatten().flatten().for_each(|v| number[*v as usize] = Some(0u32));
        let kept: Vec<usize> = (0..number.len()).filter(|v| number[*v].is_some()).collect();
        kept.iter().enumerate().for_each(|(n, v)| number[*v] = Some(n as u32));
        let new = |v: u32| number[v as usize].unwrap_or_default();
        let mut singular_edges: Vec<[u32; 2]> = (0..self.along.len() as u32)
            .flat_map(|v| self.along[v as usize].iter().filter(move |w| v < **w).map(move |w| [v, *w]))
            .map(|ends| ends.map(new))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        singular_edges.sort_unstable();
        SingularMesh {
            positions: kept.iter().map(|v| mesh.positions[*v]).collect(),
            vertices: kept.iter().map(|v| mesh.vertices[*v]).collect(),
            sides: kept.iter().map(|v| mesh.sides[*v]).collect(),
            triangles: self.triangles.iter().flatten().map(|t| t.map(new)).collect(),
            normals: Vec::new(),
            singular_edges,
            lower: mesh.lower.clone(),
        }
    }
}

/// The two corners that are not `v`, in order.
fn rest(corners: [u32; 3], v: u32) -> [u32; 2] {
    let mut rest = [0; 2];
    let others = corners.into_iter().filter(|w| *w != v);
    rest.iter_mut().zip(others).for_each(|(r, w)| *r = w);
    [rest[0].min(rest[1]), rest[0].max(rest[1])]
}
