//! Which patches turn over, seen on a grid.

use super::build::APatchFunction;
use super::grid::{EdgeTable, FaceTable, GridOut};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points, Vec3};
use crate::mesh::{EdgeId, FaceId};
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

    fn on_face(&self, function: &APatchFunction, f: FaceId) -> Turn {
        let Some(face) = function.creased_face(f) else {
            let count = self.faces.len();
            let (mut points, mut normals) = (Points::zeros(count), Points::zeros(count));
            self.faces.evaluate(function, f, &mut out(&mut points, &mut normals));
            return Turn::of(function, &points, &normals, &self.face_triangles);
        };
        let (at, triangles) = &self.creased;
        let (mut points, mut normals) = (Points::zeros(at.len()), Points::zeros(at.len()));
        for (i, x) in at.iter().enumerate() {
            let nan = Vec3::repeat(f64::NAN);
            let (point, normal) = face.sample(*x).map_or((nan, nan), |s| (s.point, s.normal));
            points.set(i, point);
            normals.set(i, normal);
        }
        Turn::of(function, &points, &normals, triangles)
    }

    fn on_edge(&self, function: &APatchFunction, e: EdgeId) -> Turn {
        let (mut points, mut normals) = (Points::zeros(self.edges.len()), Points::zeros(self.edges.len()));
        self.edges.evaluate(function, e, &mut out(&mut points, &mut normals));
        Turn::of(function, &points, &normals, &self.edge_triangles)
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

fn out<'a>(points: &'a mut Points, normals: &'a mut Points) -> GridOut<'a> {
    GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) }
}

/// How much a patch turns between the points of a grid.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Does a triangle face away from the normals at its corners, or is there a point missing?
    folds: bool,
    /// Should it be looked at more closely?
    suspect: bool,
}

impl Turn {
    fn of(function: &APatchFunction, points: &Points, normals: &Points, triangles: &[[usize; 3]]) -> Self {
        let least = ROUNDED * function.hull().data().diagonal();
        let mut turn = Self { folds: false, suspect: false };
        for t in triangles {
            let [a, b, c]: [Point3; 3] = t.map(|i| points.get(i));
            let [n_a, n_b, n_c]: [Vec3; 3] = t.map(|i| normals.get(i));
            let area = (b - a).cross(&(c - a));
            let size = area.norm();
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            // Also where something is not a number.
            if size <= least * longest {
                continue;
            }
            let product = area.dot(&(n_a + n_b + n_c)) / (3.0 * size);
            let between = n_a.dot(&n_b).min(n_b.dot(&n_c)).min(n_c.dot(&n_a));
            turn.folds |= product.is_nan() || product <= 0.0;
            turn.suspect |= !(product > SUSPECT && between > SUSPECT);
        }
        turn
    }
}

/// The patches among these that turn over; every patch is looked at closely if `closely` is set.
pub(super) fn folded(function: &APatchFunction, among: &Patches, closely: bool) -> Patches {
    // Mostly nothing is suspect, and the tables of the fine grid take as long as many patches.
    let (coarse, fine) = (Grid::new(COARSE), LazyLock::new(|| Grid::new(FINE)));
    let hull = function.hull();
    let face = |f: &FaceId| {
        (closely || hull.is_delicate(*f) || coarse.on_face(function, *f).suspect)
            && fine.on_face(function, *f).folds
    };
    let edge = |e: &EdgeId| {
        (closely || hull.is_delicate_edge(*e) || coarse.on_edge(function, *e).suspect)
            && fine.on_edge(function, *e).folds
    };
    Patches {
        faces: among.faces.par_iter().copied().filter(face).collect(),
        edges: among.edges.par_iter().copied().filter(|e| has_patch(function, *e) && edge(e)).collect(),
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
