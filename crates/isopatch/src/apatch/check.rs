//! Which patches turn over, seen on a grid.

use super::build::APatchFunction;
use super::grid::{EdgeTable, FaceTable, GridOut};
use super::lanes::LANES;
use crate::bernstein::{index, triangle};
use crate::geom::{Points, Vec3};
use crate::mesh::{EdgeId, FaceId};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Intervals of the grid on which a fold counts.
const FINE: usize = 20;

/// Intervals of the grid that says which patches are looked at on the fine one.
const COARSE: usize = 4;

/// The rows of the fine grid over an edge that are in the coarse one: more near its ends, where patches bend most.
const COARSE_ROWS: [usize; 9] = [0, 1, 2, 6, 10, 14, 18, 19, 20];

/// A patch is looked at closely if some triangle of the coarse grid has a normal, or normals at two corners, with a smaller
/// product.
const SUSPECT: f64 = 0.75;

/// Triangles with less area relative to the diagonal of the model and their longest side are lost in rounding.
const ROUNDED: f64 = 1e-13;

/// Patches to look at.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    pub faces: Vec<FaceId>,
    pub edges: Vec<EdgeId>,
}

/// A grid of points with its triangles.
struct Grid {
    /// For faces with creases, with more points near the corners.
    creased: (Vec<[f64; 3]>, Vec<[usize; 3]>),
    faces: FaceTable,
    edges: EdgeTable,
    face_triangles: Vec<[usize; 3]>,
    edge_triangles: Vec<[usize; 3]>,
}

impl Grid {
    fn new(n: usize) -> Self {
        let on_face = triangle::lattice(n);
        let weight = |i: usize| i as f64 / n as f64;
        let rows: Vec<usize> = if n < FINE { COARSE_ROWS.to_vec() } else { (0..=FINE).collect() };
        let along = |i: usize| i as f64 / FINE as f64;
        let on_edge: Vec<[f64; 3]> =
            rows.iter().flat_map(|i| (0..=n).map(move |j| [along(FINE - i), along(*i), weight(j)])).collect();
        let face_triangles: Vec<[usize; 3]> = lattice_triangles(n).map(|t| t.map(index::position)).collect();
        let at = |i: usize, j: usize| i * (n + 1) + j;
        let edge_triangles = (0..rows.len() - 1)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .flat_map(|(i, j)| {
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            })
            .collect();
        let mut creased = (on_face.clone(), face_triangles.clone());
        if n < FINE {
            (0..3).for_each(|corner| add_corner(&mut creased, corner));
        }
        Self {
            creased,
            faces: FaceTable::new(&on_face),
            edges: EdgeTable::new(&on_edge),
            face_triangles,
            edge_triangles,
        }
    }

    fn on_face(&self, function: &APatchFunction, f: FaceId, room: &mut Room) -> Turn {
        let Some(face) = function.creased_face(f) else {
            self.faces.evaluate(function, f, &mut room.of(self.faces.len()));
            return room.turn(function, &self.face_triangles);
        };
        let (at, triangles) = &self.creased;
        let mut out = room.of(at.len());
        for (i, x) in at.iter().enumerate() {
            let nan = Vec3::repeat(f64::NAN);
            let (point, normal) = face.sample(*x).map_or((nan, nan), |s| (s.point, s.normal));
            out.set(i, point, normal);
        }
        room.turn(function, triangles)
    }

    fn on_edge(&self, function: &APatchFunction, e: EdgeId, room: &mut Room) -> Turn {
        self.edges.evaluate(function, e, &mut room.of(self.edges.len()));
        room.turn(function, &self.edge_triangles)
    }
}

/// Memory for the points of a patch.
#[derive(Default)]
struct Room {
    points: Points,
    normals: Points,
}

impl Room {
    /// To be filled with so many points.
    fn of(&mut self, count: usize) -> GridOut<'_> {
        self.points.resize(count);
        self.normals.resize(count);
        GridOut { points: self.points.view_mut(), normals: Some(self.normals.view_mut()) }
    }

    /// How much these triangles turn.
    fn turn(&self, function: &APatchFunction, triangles: &[[usize; 3]]) -> Turn {
        let scale = function.hull().data().diagonal().recip();
        Arch::new().dispatch(Turning { points: &self.points, normals: &self.normals, triangles, scale })
    }
}

/// Rows of triangles of the fine grid at a corner that are looked at in any case.
const CORNER_ROWS: usize = 4;

/// Adds the triangles of the fine grid at a corner.
fn add_corner((points, triangles): &mut (Vec<[f64; 3]>, Vec<[usize; 3]>), corner: usize) {
    let first = points.len();
    let weight = |i: usize| i as f64 / FINE as f64;
    for [i, j, k] in index::indices(CORNER_ROWS) {
        let mut x = [0.0; 3];
        x[corner] = weight(FINE - CORNER_ROWS + i);
        (x[(corner + 1) % 3], x[(corner + 2) % 3]) = (weight(j), weight(k));
        points.push(x);
    }
    triangles.extend(lattice_triangles(CORNER_ROWS).map(|t| t.map(|ijk| first + index::position(ijk))));
}

/// The small triangles of a lattice, counter-clockwise.
fn lattice_triangles(n: usize) -> impl Iterator<Item = [[usize; 3]; 3]> {
    let upright = index::indices(n - 1).map(|[i, j, k]| [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]]);
    let inverted =
        index::indices(n - 2).map(|[i, j, k]| [[i, j + 1, k + 1], [i + 1, j, k + 1], [i + 1, j + 1, k]]);
    upright.chain(inverted)
}

/// How much a patch turns between the points of a grid.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Does a triangle face away from the normals at its corners, or is there a point missing?
    folds: bool,
    /// Should it be looked at more closely?
    suspect: bool,
}

/// The triangles of a grid with its points, to be looked at in lanes.
struct Turning<'a> {
    points: &'a Points,
    normals: &'a Points,
    triangles: &'a [[usize; 3]],
    /// Makes lengths relative to the diagonal of the model.
    scale: f64,
}

/// The corners of a lane of triangles by coordinates.
type Corners = [[[f64; LANES]; 3]; 3];

impl Turning<'_> {
    /// The triangles of a lane, the last one repeated to fill it.
    #[inline(always)]
    fn corners(of: &Points, triangles: &[[usize; 3]]) -> Corners {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for i in 0..LANES {
            let triangle = triangles[i.min(triangles.len() - 1)];
            for (corner, at) in corners.iter_mut().zip(triangle) {
                (corner[0][i], corner[1][i], corner[2][i]) = (of.x[at], of.y[at], of.z[at]);
            }
        }
        corners
    }
}

#[inline(always)]
fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl NullaryFnOnce for Turning<'_> {
    type Output = Turn;

    #[inline(always)]
    fn call(self) -> Turn {
        let (mut folds, mut suspect) = (0u64, 0u64);
        for triangles in self.triangles.chunks(LANES) {
            let p = Self::corners(self.points, triangles);
            let n = Self::corners(self.normals, triangles);
            for i in 0..LANES {
                let [a, b, c] = [0, 1, 2].map(|k| [p[k][0][i], p[k][1][i], p[k][2][i]]);
                let [n_a, n_b, n_c] = [0, 1, 2].map(|k| [n[k][0][i], n[k][1][i], n[k][2][i]]);
                let sides = [minus(b, a), minus(c, b), minus(c, a)];
                let [u, v, w] = sides.map(|side| side.map(|x| self.scale * x));
                let area = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
                // All in squares: no roots.
                let (size, longest) = (dot(area, area), dot(u, u).max(dot(v, v)).max(dot(w, w)));
                // Not where something is not a number: that counts.
                let is_lost = size <= ROUNDED * ROUNDED * longest;
                let mean = [0, 1, 2].map(|k| n_a[k] + n_b[k] + n_c[k]);
                let product = dot(area, mean);
                let least = 3.0 * SUSPECT;
                let is_ahead = product > 0.0;
                let is_steady = is_ahead
                    & (product * product > least * least * size)
                    & (dot(n_a, n_b) > SUSPECT)
                    & (dot(n_b, n_c) > SUSPECT)
                    & (dot(n_c, n_a) > SUSPECT);
                folds |= u64::from(!is_lost & !is_ahead);
                suspect |= u64::from(!is_lost & !is_steady);
            }
        }
        Turn { folds: folds > 0, suspect: suspect > 0 }
    }
}

/// The patches among these that turn over; every patch is looked at closely if `closely` is set.
pub(super) fn folded(function: &APatchFunction, among: &Patches, closely: bool) -> Patches {
    // Mostly nothing is suspect, and the tables of the fine grid take as long as many patches.
    let (coarse, fine) = (Grid::new(COARSE), LazyLock::new(|| Grid::new(FINE)));
    let hull = function.hull();
    let face = |room: &mut Room, f: &FaceId| {
        let suspect = closely || hull.is_delicate(*f) || coarse.on_face(function, *f, room).suspect;
        (suspect && fine.on_face(function, *f, room).folds).then_some(*f)
    };
    let edge = |room: &mut Room, e: &EdgeId| {
        let suspect = has_patch(function, *e)
            && (closely || hull.is_delicate_edge(*e) || coarse.on_edge(function, *e, room).suspect);
        (suspect && fine.on_edge(function, *e, room).folds).then_some(*e)
    };
    Patches {
        faces: among.faces.par_iter().map_init(Room::default, face).flatten_iter().collect(),
        edges: among.edges.par_iter().map_init(Room::default, edge).flatten_iter().collect(),
    }
}

impl Patches {
    /// All that can turn over: zero convex faces and straight edges can't, unless a crease pulls at them.
    pub fn all(function: &APatchFunction) -> Self {
        let mesh = function.hull().data().mesh();
        Self {
            faces: mesh.faces().collect(),
            edges: mesh.edges().filter(|e| has_patch(function, *e)).collect(),
        }
    }

    /// Those at the vertices of some faces.
    pub fn around(function: &APatchFunction, faces: &[FaceId]) -> Self {
        let mesh = function.hull().data().mesh();
        let vertices = faces.iter().flat_map(|f| mesh.triangle(*f));
        let mut near: Vec<FaceId> = vertices.flat_map(|v| mesh.ring(v)).map(|h| mesh.face(h)).collect();
        near.sort_unstable();
        near.dedup();
        let mut edges: Vec<EdgeId> = near
            .iter()
            .flat_map(|f| mesh.face_half_edges(*f))
            .map(|h| mesh.edge(h))
            .filter(|e| has_patch(function, *e))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        Self { faces: near, edges }
    }

    /// These and others; those that have no patch any more are left out when they are looked at.
    pub fn with(mut self, other: Self) -> Self {
        self.faces.extend(other.faces);
        self.edges.extend(other.edges);
        self.faces.sort_unstable();
        self.faces.dedup();
        self.edges.sort_unstable();
        self.edges.dedup();
        self
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.edges.is_empty()
    }
}

fn has_patch(function: &APatchFunction, e: EdgeId) -> bool {
    function.edges()[e.index()].iter().any(Option::is_some)
}
