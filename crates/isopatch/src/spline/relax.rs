//! All points that the G1 conditions leave free, moved together until the patches are as near to the target as they can.
//!
//! The edge systems take the points nearest to the fitted ones, and that is not the nearest to the surface: the weights
//! λ and μ of (1) shift the first rows along the surface, and only O(h⁴) of the fit's O(h⁶) is left on an irregular mesh.
//! What a shift leaves free is known in closed form: all first rows that satisfy (1) with the same λ, μ and q are
//!
//! ```text
//! p2 + λ̄0... 
//! ```

use super::fit::{FREE, FREE_POINTS, combine};
use super::surface::{DEGREE, NET};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points, Vec3};
use crate::mesh::{FaceId, HalfEdgeMesh};
use crate::surface::Target;
use nalgebra::{Cholesky, SMatrix, SVector};
use rayon::prelude::*;
use std::sync::LazyLock;

type Net = [Point3; NET];

/// Vectors by which the rows of an edge may move.
const EDGE: usize = 2;
/// Vectors by which a patch may move: those of its edges, then its free points.
const MOVES: usize = 3 * EDGE + FREE;
const EDGE_UNKNOWNS: usize = 3 * EDGE;
const SIDES_UNKNOWNS: usize = 3 * EDGE_UNKNOWNS;
const FREE_UNKNOWNS: usize = 3 * FREE;
const UNKNOWNS: usize = 3 * MOVES;

const LATTICE: usize = 10;
const SAMPLES: usize = 36;
const BATCH: usize = 32;

struct Table {
    basis: [[f64; NET]; SAMPLES],
}

static TABLE: LazyLock<Box<Table>> = LazyLock::new(|| {
    let basis = triangle::basis_matrix(DEGREE, &triangle::interior_lattice(LATTICE));
    Box::new(Table { basis: std::array::from_fn(|r| std::array::from_fn(|c| basis[(r, c)])) })
});

/// How the three points of the row of a side move with the two vectors of its edge: weights by point and vector.
pub(super) type RowMoves = [[f64; EDGE]; 3];

/// Moves of (p2, p3, p4) and of (r2, r3, r4) that keep all rows of Table 2.
pub(super) fn row_moves([l0, l1]: [f64; 2]) -> [RowMoves; 2] {
    let (m0, m1) = (1.0 - l0, 1.0 - l1);
    let r3 = [-0.375 * (m0 + m1 + l0 - l1), -0.375 * (m0 + m1 - l0 + l1)];
    let p3 = r3.map(|r| r + 0.75);
    [[[l0, 0.0], p3, [0.0, l1]], [[-m0, 0.0], r3, [0.0, -m1]]]
}

struct Local {
    /// Schur complement of the free points, and its right side.
    s: SMatrix<f64, SIDES_UNKNOWNS, SIDES_UNKNOWNS>,
    g: SVector<f64, SIDES_UNKNOWNS>,
    free: Cholesky<f64, nalgebra::Const<FREE_UNKNOWNS>>,
    coupling: SMatrix<f64, FREE_UNKNOWNS, SIDES_UNKNOWNS>,
    free_gradient: SVector<f64, FREE_UNKNOWNS>,
}

/// Positions and weights of the moves of one patch.
struct Moves {
    /// For each side: the three net positions and their weights; zero for a boundary side.
    sides: [([usize; 3], RowMoves); 3],
}

/// One step.
pub(super) fn relax(
    mesh: &HalfEdgeMesh,
    lambda: &[[f64; 2]],
    nets: &mut [Net],
    target: &dyn Target,
    tangential_weight: f64,
    iterations: usize,
) {
    let table = &**TABLE;
    let moves: Vec<Moves> = mesh.faces().map(|f| moves_of(mesh, f, lambda)).collect();
    let locals: Vec<Vec<Option<Local>>> = nets
        .par_chunks(BATCH)
        .zip(moves.par_chunks(BATCH))
        .map(|(nets, moves)| {
            let n = nets.len() * SAMPLES;
            let (mut points, mut normals, mut offsets) = (Points::zeros(n), Points::zeros(n), vec![0.0; n]);
            for (f, net) in nets.iter().enumerate() {
                let relative = net.map(|p| p - net[0]);
                for (s, row) in table.basis.iter().enumerate() {
                    points.set(f * SAMPLES + s, net[0] + combine(row, &relative));
                }
            }
            target.offsets(points.view(), &mut offsets, normals.view_mut());
            moves
                .iter()
                .enumerate()
                .map(|(f, moves)| {
                    let first = f * SAMPLES;
                    local(moves, |s| (offsets[first + s], normals.get(first + s)), tangential_weight)
                })
                .collect()
        })
        .collect();
    let locals: Vec<Option<Local>> = locals.into_iter().flatten().collect();
    if locals.iter().any(Option::is_none) {
        return;
    }
    let locals: Vec<Local> = locals.into_iter().flatten().collect();
    let x = solve(mesh, &locals, iterations);
    nets.par_iter_mut().enumerate().with_min_len(BATCH).for_each(|(f, net)| {
        let edges: Vec<usize> =
            mesh.face_half_edges(FaceId::from(f)).map(|h| mesh.edge(h).index()).collect();
        let local = &locals[f];
        let sides = SVector::<f64, SIDES_UNKNOWNS>::from_fn(|i, _| x[edges[i / EDGE_UNKNOWNS]][i % EDGE_UNKNOWNS]);
        let free = local.free.solve(&(local.free_gradient - local.coupling * sides));
        for (k, (positions, weights)) in moves[f].sides.iter().enumerate() {
            for (p, w) in positions.iter().zip(weights) {
                for j in 0..EDGE {
                    for c in 0..3 {
                        net[*p][c] -= w[j] * sides[EDGE_UNKNOWNS * k + 3 * j + c];
                    }
                }
            }
        }
        for (p, i) in FREE_POINTS.iter().enumerate() {
            net[*i] -= Vec3::new(free[3 * p], free[3 * p + 1], free[3 * p + 2]);
        }
    });
}

fn moves_of(mesh: &HalfEdgeMesh, f: FaceId, lambda: &[[f64; 2]]) -> Moves {
    let mut sides = [([0; 3], [[0.0; EDGE]; 3]); 3];
    for (side, h) in mesh.face_half_edges(f).enumerate() {
        let e = mesh.edge(h);
        if mesh.twin(h).is_none() {
            continue;
        }
        let [p, r] = row_moves(lambda[e.index()]);
        let left = mesh.edge_half_edge(e) == h;
        let positions = std::array::from_fn(|m| {
            index::row(DEGREE, side, 1, if left { m + 2 } else { DEGREE - 1 - (m + 2) })
        });
        sides[side] = (positions, if left { r } else { p });
    }
    Moves { sides }
}

fn local(moves: &Moves, sample: impl Fn(usize) -> (f64, Vec3), tangential_weight: f64) -> Option<Local> {
    let mut a = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut gradient = SVector::<f64, UNKNOWNS>::zeros();
    let mut gram = [[0.0; MOVES]; MOVES];
    for (s, basis) in TABLE.basis.iter().enumerate() {
        let (offset, n) = sample(s);
        let mut w = [0.0; MOVES];
        for (k, (positions, weights)) in moves.sides.iter().enumerate() {
            for (p, v) in positions.iter().zip(weights) {
                for j in 0..EDGE {
                    w[EDGE * k + j] += basis[*p] * v[j];
                }
            }
        }
        for (p, i) in FREE_POINTS.iter().enumerate() {
            w[3 * EDGE + p] = basis[*i];
        }
        let row = SVector::<f64, UNKNOWNS>::from_fn(|i, _| w[i / 3] * n[i % 3]);
        a.ger(1.0, &row, &row, 1.0);
        gradient.axpy(offset, &row, 1.0);
        for i in 0..MOVES {
            for j in 0..MOVES {
                gram[i][j] += w[i] * w[j];
            }
        }
    }
    for i in 0..MOVES {
        for j in 0..MOVES {
            (0..3).for_each(|c| a[(3 * i + c, 3 * j + c)] += tangential_weight * gram[i][j]);
        }
    }
    let free = a.fixed_view::<FREE_UNKNOWNS, FREE_UNKNOWNS>(SIDES_UNKNOWNS, SIDES_UNKNOWNS).into_owned();
    let free = free.cholesky()?;
    let coupling = a.fixed_view::<FREE_UNKNOWNS, SIDES_UNKNOWNS>(SIDES_UNKNOWNS, 0).into_owned();
    let free_gradient = gradient.fixed_rows::<FREE_UNKNOWNS>(SIDES_UNKNOWNS).into_owned();
    let solved = free.solve(&coupling);
    let s = a.fixed_view::<SIDES_UNKNOWNS, SIDES_UNKNOWNS>(0, 0) - coupling.transpose() * solved;
    let g = gradient.fixed_rows::<SIDES_UNKNOWNS>(0) - solved.transpose() * free_gradient;
    Some(Local { s, g, free, coupling, free_gradient })
}

type Block = SVector<f64, EDGE_UNKNOWNS>;

/// Conjugate gradients with the diagonal blocks as preconditioner.
fn solve(mesh: &HalfEdgeMesh, locals: &[Local], iterations: usize) -> Vec<Block> {
    // Where the two faces of an edge keep it.
    let sides: Vec<Vec<(usize, usize)>> = mesh
        .edges()
        .map(|e| {
            let h = mesh.edge_half_edge(e);
            let mut both = vec![(mesh.face(h).index(), mesh.side(h))];
            both.extend(mesh.twin(h).map(|g| (mesh.face(g).index(), mesh.side(g))));
            both
        })
        .collect();
    let edges_of: Vec<[usize; 3]> = mesh
        .faces()
        .map(|f| {
            let mut it = mesh.face_half_edges(f).map(|h| mesh.edge(h).index());
            std::array::from_fn(|_| it.next().unwrap_or(0))
        })
        .collect();
    let inner: Vec<bool> = sides.iter().map(|s| s.len() == 2).collect();
    let n = sides.len();
    let preconditioner: Vec<Option<_>> = sides
        .iter()
        .map(|s| {
            if s.len() < 2 {
                return None;
            }
            let sum: SMatrix<f64, EDGE_UNKNOWNS, EDGE_UNKNOWNS> = s
                .iter()
                .map(|(f, k)| {
                    locals[*f]
                        .s
                        .fixed_view::<EDGE_UNKNOWNS, EDGE_UNKNOWNS>(EDGE_UNKNOWNS * k, EDGE_UNKNOWNS * k)
                        .into_owned()
                })
                .sum();
            sum.cholesky()
        })
        .collect();
    let apply = |x: &[Block]| -> Vec<Block> {
        let products: Vec<SVector<f64, SIDES_UNKNOWNS>> = locals
            .iter()
            .zip(&edges_of)
            .map(|(l, e)| {
                l.s * SVector::<f64, SIDES_UNKNOWNS>::from_fn(|i, _| {
                    x[e[i / EDGE_UNKNOWNS]][i % EDGE_UNKNOWNS]
                })
            })
            .collect();
        (0..n)
            .map(|e| {
                if !inner[e] {
                    return Block::zeros();
                }
                sides[e]
                    .iter()
                    .map(|(f, k)| products[*f].fixed_rows::<EDGE_UNKNOWNS>(EDGE_UNKNOWNS * k).into_owned())
                    .sum()
            })
            .collect()
    };
    let precondition = |r: &[Block]| -> Vec<Block> {
        r.iter()
            .zip(&preconditioner)
            .map(|(r, p)| p.as_ref().map_or_else(Block::zeros, |p| p.solve(r)))
            .collect()
    };
    let dot = |a: &[Block], b: &[Block]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };
    let mut x = vec![Block::zeros(); n];
    let mut r: Vec<Block> = (0..n)
        .map(|e| {
            if !inner[e] {
                return Block::zeros();
            }
            sides[e]
                .iter()
                .map(|(f, k)| locals[*f].g.fixed_rows::<EDGE_UNKNOWNS>(EDGE_UNKNOWNS * k).into_owned())
                .sum()
        })
        .collect();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for _ in 0..iterations {
        if !(rz > 0.0) {
            break;
        }
        let ap = apply(&p);
        let alpha = rz / dot(&p, &ap);
        for e in 0..n {
            x[e] += alpha * p[e];
            r[e] -= alpha * ap[e];
        }
        z = precondition(&r);
        let next = dot(&r, &z);
        let beta = next / rz;
        rz = next;
        for e in 0..n {
            p[e] = z[e] + beta * p[e];
        }
    }
    x
}
