//! Which patches turn over, seen on a grid.

use super::build::APatchFunction;
use super::grid::{EdgeTable, FaceTable, GridOut};
use super::lanes::LANES;
use crate::bernstein::{index, triangle};
use crate::geom::{Points, Vec3};
use crate::mesh::{EdgeId, FaceId};
use crate::parallel::Evenly;
use pulp::{Arch, Simd, WithSimd};
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
    creased: (Vec<[f64; 3]>, Vec<TriangleLane>),
    faces: FaceTable,
    edges: EdgeTable,
    face_triangles: Vec<TriangleLane>,
    edge_triangles: Vec<TriangleLane>,
}

impl Grid {
    fn new(n: usize) -> Self {
        let on_face = triangle::lattice(n);
        let weight = |i: usize| i as f64 / n as f64;
        let rows: Vec<usize> = if n < FINE { COARSE_ROWS.to_vec() } else { (0..=FINE).collect() };
        let along = |i: usize| i as f64 / FINE as f64;
        // Along the edge first: the rows of the coarse grid have as many triangles of each kind as a lane.
        let on_edge: Vec<[f64; 3]> =
            (0..=n).flat_map(|j| rows.iter().map(move |i| [along(FINE - i), along(*i), weight(j)])).collect();
        let face_triangles: Vec<[usize; 3]> = lattice_triangles(n).map(|t| t.map(index::position)).collect();
        let at = |i: usize, j: usize| j * rows.len() + i;
        let lower = |i, j| [at(i, j), at(i + 1, j), at(i + 1, j + 1)];
        let upper = |i, j| [at(i, j), at(i + 1, j + 1), at(i, j + 1)];
        let intervals = rows.len() - 1;
        let row =
            |j| (0..intervals).map(move |i| lower(i, j)).chain((0..intervals).map(move |i| upper(i, j)));
        let edge_triangles: Vec<[usize; 3]> = (0..n).flat_map(row).collect();
        let mut creased = (on_face.clone(), face_triangles.clone());
        if n < FINE {
            (0..3).for_each(|corner| add_corner(&mut creased, corner));
        }
        Self {
            creased: (creased.0, TriangleLane::all(&creased.1)),
            faces: FaceTable::new(&on_face),
            edges: EdgeTable::new(&on_edge),
            face_triangles: TriangleLane::all(&face_triangles),
            edge_triangles: TriangleLane::all(&edge_triangles),
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
    fn turn(&self, function: &APatchFunction, triangles: &[TriangleLane]) -> Turn {
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
    triangles: &'a [TriangleLane],
    /// Makes lengths relative to the diagonal of the model.
    scale: f64,
}

/// Triangles that are looked at together.
struct TriangleLane {
    /// The points at each corner; the last triangle is repeated to fill the lane.
    corners: [[usize; LANES]; 3],
    /// Do the points at each corner follow one another? They are read at once then.
    is_run: bool,
}

impl TriangleLane {
    fn new(triangles: &[[usize; 3]]) -> Self {
        let at = |i: usize| triangles[i.min(triangles.len() - 1)];
        let corners = std::array::from_fn(|k| std::array::from_fn(|i| at(i)[k]));
        let is_run =
            corners.iter().all(|points: &[usize; LANES]| points.windows(2).all(|w| w[1] == w[0] + 1));
        Self { corners, is_run }
    }

    fn all(triangles: &[[usize; 3]]) -> Vec<Self> {
        triangles.chunks(LANES).map(Self::new).collect()
    }

    /// A vector at each corner, by coordinates.
    #[inline(always)]
    fn read(&self, vectors: &Points, found: &mut [[[f64; LANES]; 3]; 3]) {
        for (found, points) in found.iter_mut().zip(&self.corners) {
            for (found, from) in found.iter_mut().zip([&vectors.x, &vectors.y, &vectors.z]) {
                if self.is_run {
                    found.copy_from_slice(&from[points[0]..points[0] + LANES]);
                } else {
                    (0..LANES).for_each(|i| found[i] = from[points[i]]);
                }
            }
        }
    }
}

/// Vectors by coordinates, in lanes. Their functions have no closures: operations on lanes would be calls in them.
type Vectors<S> = [<S as Simd>::f64s; 3];

#[inline(always)]
fn minus<S: Simd>(simd: S, [a, b, c]: Vectors<S>, [x, y, z]: Vectors<S>) -> Vectors<S> {
    [simd.sub_f64s(a, x), simd.sub_f64s(b, y), simd.sub_f64s(c, z)]
}

#[inline(always)]
fn plus<S: Simd>(simd: S, [a, b, c]: Vectors<S>, [x, y, z]: Vectors<S>) -> Vectors<S> {
    [simd.add_f64s(a, x), simd.add_f64s(b, y), simd.add_f64s(c, z)]
}

#[inline(always)]
fn scaled<S: Simd>(simd: S, [a, b, c]: Vectors<S>, scale: S::f64s) -> Vectors<S> {
    [simd.mul_f64s(a, scale), simd.mul_f64s(b, scale), simd.mul_f64s(c, scale)]
}

#[inline(always)]
fn dot<S: Simd>(simd: S, [a, b, c]: Vectors<S>, [x, y, z]: Vectors<S>) -> S::f64s {
    simd.add_f64s(simd.add_f64s(simd.mul_f64s(a, x), simd.mul_f64s(b, y)), simd.mul_f64s(c, z))
}

#[inline(always)]
fn cross<S: Simd>(simd: S, [a, b, c]: Vectors<S>, [x, y, z]: Vectors<S>) -> Vectors<S> {
    [
        simd.sub_f64s(simd.mul_f64s(b, z), simd.mul_f64s(c, y)),
        simd.sub_f64s(simd.mul_f64s(c, x), simd.mul_f64s(a, z)),
        simd.sub_f64s(simd.mul_f64s(a, y), simd.mul_f64s(b, x)),
    ]
}

/// A part of some lanes.
#[inline(always)]
fn part_of<S: Simd>([x, y, z]: &[[f64; LANES]; 3], part: usize) -> Vectors<S> {
    [S::as_simd_f64s(x).0[part], S::as_simd_f64s(y).0[part], S::as_simd_f64s(z).0[part]]
}

impl WithSimd for Turning<'_> {
    type Output = Turn;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Turn {
        let scale = simd.splat_f64s(self.scale);
        // All in squares: no roots.
        let [rounded, steady] = [ROUNDED, 3.0 * SUSPECT].map(|x| x * x);
        let mut turn = Turn { folds: false, suspect: false };
        let [mut points, mut normals] = [[[[0.0; LANES]; 3]; 3]; 2];
        for triangles in self.triangles {
            triangles.read(self.points, &mut points);
            triangles.read(self.normals, &mut normals);
            let [mut size, mut longest, mut product] = [[0.0; LANES]; 3];
            let mut between = [[0.0; LANES]; 3];
            for part in 0..LANES / S::F64_LANES {
                let (a, b) = (part_of::<S>(&points[0], part), part_of::<S>(&points[1], part));
                let c = part_of::<S>(&points[2], part);
                let (n_a, n_b) = (part_of::<S>(&normals[0], part), part_of::<S>(&normals[1], part));
                let n_c = part_of::<S>(&normals[2], part);
                let u = scaled(simd, minus(simd, b, a), scale);
                let v = scaled(simd, minus(simd, c, b), scale);
                let w = scaled(simd, minus(simd, c, a), scale);
                let area = cross(simd, u, w);
                let sum = plus(simd, plus(simd, n_a, n_b), n_c);
                let most = simd.max_f64s(simd.max_f64s(dot(simd, u, u), dot(simd, v, v)), dot(simd, w, w));
                S::as_mut_simd_f64s(&mut size).0[part] = dot(simd, area, area);
                S::as_mut_simd_f64s(&mut longest).0[part] = most;
                S::as_mut_simd_f64s(&mut product).0[part] = dot(simd, area, sum);
                S::as_mut_simd_f64s(&mut between[0]).0[part] = dot(simd, n_a, n_b);
                S::as_mut_simd_f64s(&mut between[1]).0[part] = dot(simd, n_b, n_c);
                S::as_mut_simd_f64s(&mut between[2]).0[part] = dot(simd, n_c, n_a);
            }
            for i in 0..LANES {
                // Not where something is not a number: that counts.
                let is_lost = size[i] <= rounded * longest[i];
                let is_ahead = product[i] > 0.0;
                let is_steady = is_ahead
                    & (product[i] * product[i] > steady * size[i])
                    & between.iter().all(|lane| lane[i] > SUSPECT);
                turn.folds |= !is_lost & !is_ahead;
                turn.suspect |= !is_lost & !is_steady;
            }
        }
        turn
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
        faces: among.faces.par_iter().evenly().map_init(Room::default, face).flatten_iter().collect(),
        edges: among.edges.par_iter().evenly().map_init(Room::default, edge).flatten_iter().collect(),
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
