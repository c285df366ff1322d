//! All points that the G1 conditions leave free, moved together until the patches are as near to the target as they can.
//!
//! The [edge systems](super::edge) take the points nearest to the fitted ones. These are not nearest to the surface: λ and
//! μ of (1) shift the first rows along the surface against the fit's parameters, and of the sixth order of the fit about
//! the fourth is left on an irregular mesh. But (1) leaves two vectors s, t free on every edge. Table 2 holds with the same
//! λ, μ and curve after
//!
//! ```text
//! p2 += λ0 s      r2 −= (1 − λ0) s        r3 += ρ,  p3 += ρ + ¾ (s + t)
//! p4 += λ1 t      r4 −= (1 − λ1) t        ρ = −⅜ [(2 − λ0 − λ1)(s + t) + (λ0 − λ1)(s − t)]
//! ```
//!
//! So a patch moves by nine vectors: two of each edge, and its three free points. A step is that of Gauss and Newton on
//! Σ (f/|∇f|)² + weight · |motion|² over samples of all patches: the free points are eliminated patch by patch, and what
//! remains couples an edge with the four others of its two patches, which a few conjugate gradients solve. The free points
//! are found afresh when the edges have moved: to keep what eliminated them would take as much memory as the surface.
//! Beside a boundary no condition binds the row; it moves by s at one end and t at the other.

use super::fit::{FREE, FREE_POINTS, combine, move_with_free_points};
use super::surface::{DEGREE, NET};
use crate::bernstein::{index, triangle};
use crate::geom::{Point3, Points};
use crate::mesh::{EdgeId, HalfEdgeId, HalfEdgeMesh};
use crate::parallel::Evenly;
use crate::surface::Target;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;
use std::sync::LazyLock;

type Net = [Point3; NET];

/// Vectors of an edge, and those by which a patch moves.
const OF_EDGE: usize = 2;
const MOVES: usize = 3 * OF_EDGE + FREE;
/// Unknowns of an edge, of the three edges of a patch, and of its free points.
const EDGE: usize = 3 * OF_EDGE;
const SIDES: usize = 3 * EDGE;
const INNER: usize = 3 * FREE;
/// Samples: the interior points of the lattice of this size.
const LATTICE: usize = 10;
const SAMPLES: usize = 36;
/// Patches whose samples are evaluated in one batch.
const BATCH: usize = 4;
/// Blocks of edges that one task inverts; patches that one task multiplies; edges that one task adds up.
const BLOCKS: usize = 16;
const PRODUCTS: usize = 48;
const EDGES: usize = 192;
/// Conjugate gradients of a step. More change the result less than a further step does.
const ITERATIONS: usize = 5;
/// Longest step of an edge's vectors, as a share of its length.
const TRUST: f64 = 0.05;

const CORNERS: [usize; 3] =
    [index::position([DEGREE, 0, 0]), index::position([0, DEGREE, 0]), index::position([0, 0, DEGREE])];

/// Bernstein polynomials at the samples: by sample, and by control point.
struct Table {
    by_sample: [[f64; NET]; SAMPLES],
    by_point: [[f64; SAMPLES]; NET],
}

static TABLE: LazyLock<Box<Table>> = LazyLock::new(|| {
    let basis = triangle::basis_matrix(DEGREE, &triangle::interior_lattice(LATTICE));
    Box::new(Table {
        by_sample: std::array::from_fn(|s| std::array::from_fn(|p| basis[(s, p)])),
        by_point: std::array::from_fn(|p| std::array::from_fn(|s| basis[(s, p)])),
    })
});

/// How points 2, 3, 4 of a row move with the two vectors of its edge.
type RowMoves = [[f64; OF_EDGE]; 3];

/// Moves of p and of r that keep (1).
fn row_moves([l0, l1]: [f64; 2]) -> [RowMoves; 2] {
    let rho = [-0.375 * (2.0 - 2.0 * l1), -0.375 * (2.0 - 2.0 * l0)];
    let p = [[l0, 0.0], rho.map(|r| r + 0.75), [0.0, l1]];
    let r = [[l0 - 1.0, 0.0], rho, [0.0, l1 - 1.0]];
    [p, r]
}

/// Moves of a row beside a boundary.
const BOUNDARY_MOVES: RowMoves = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];

/// The moves of one side of a patch.
struct Side {
    edge: usize,
    /// Points 2, 3, 4 of the row in the net, from the start of the edge's curve on.
    points: [usize; 3],
    moves: RowMoves,
}

/// The sides of all patches, and how their rows move.
struct Sides<'a> {
    mesh: &'a HalfEdgeMesh,
    lambda: &'a [[f64; 2]],
}

impl Sides<'_> {
    fn of(&self, f: usize) -> [Side; 3] {
        self.half_edges(f).map(|h| {
            let (mesh, e) = (self.mesh, self.mesh.edge(h));
            let left = mesh.edge_half_edge(e) == h;
            let place = |m| if left { m + 2 } else { DEGREE - 3 - m };
            let [p, r] = row_moves(self.lambda[e.index()]);
            Side {
                edge: e.index(),
                points: std::array::from_fn(|m| index::row(DEGREE, mesh.side(h), 1, place(m))),
                moves: match mesh.twin(h) {
                    None => BOUNDARY_MOVES,
                    Some(_) if left => r,
                    Some(_) => p,
                },
            }
        })
    }

    fn half_edges(&self, f: usize) -> [HalfEdgeId; 3] {
        let mut half_edges = self.mesh.face_half_edges(f.into());
        // A face of a triangle mesh has three; the default is never taken.
        [(); 3].map(|()| half_edges.next().unwrap_or(HalfEdgeId(0)))
    }

    /// The edges of a patch.
    fn edges(&self, f: usize) -> [usize; 3] {
        self.half_edges(f).map(|h| self.mesh.edge(h).index())
    }
}

/// The normal equations of a patch without its free points, for the vectors of its edges. In single precision, which
/// halves the memory and is far more than a damped step needs.
struct Local {
    /// Lower triangle by rows.
    matrix: [f32; SIDES * (SIDES + 1) / 2],
    right: [f32; SIDES],
}

/// One step over all patches; `lambda` holds λ(0) and λ(1) of every edge, and those that are `fixed` stay. Linear time; the
/// same result for every number of threads.
pub(super) fn relax(
    mesh: &HalfEdgeMesh,
    lambda: &[[f64; 2]],
    fixed: &[bool],
    nets: &mut [Net],
    target: &dyn Target,
    tangential_weight: f64,
) {
    let sides = Sides { mesh, lambda };
    let mut steps = edge_steps(fixed, &sides, &locals(nets, &sides, target, tangential_weight));
    for (f, net) in nets.iter().enumerate() {
        for (k, e) in sides.edges(f).into_iter().enumerate() {
            let most = TRUST * (net[CORNERS[(k + 1) % 3]] - net[CORNERS[k]]).norm();
            let length = steps[e].norm();
            if length > most {
                steps[e] *= most / length;
            }
        }
    }
    move_with_free_points(nets, target, tangential_weight, |f, net| {
        sides.of(f).iter().for_each(|side| move_row(net, side, &steps[side.edge]));
    });
}

fn locals(nets: &[Net], sides: &Sides<'_>, target: &dyn Target, weight: f64) -> Vec<Option<Local>> {
    // Filled in place: gathered from batches, they would for a moment be there twice.
    let mut locals: Vec<Option<Local>> = Vec::new();
    locals.resize_with(nets.len(), || None);
    locals.par_chunks_mut(BATCH).zip(nets.par_chunks(BATCH)).enumerate().evenly().for_each(
        |(batch, (locals, nets))| {
            let found = locals_of_batch(nets, batch * BATCH, sides, target, weight);
            locals.iter_mut().zip(found).for_each(|(local, found)| *local = found);
        },
    );
    locals
}

/// Those of some patches, the first of which has the number `start`.
fn locals_of_batch(
    nets: &[Net],
    start: usize,
    sides: &Sides<'_>,
    target: &dyn Target,
    weight: f64,
) -> Vec<Option<Local>> {
    let n = nets.len() * SAMPLES;
    let (mut points, mut normals, mut offsets) = (Points::zeros(n), Points::zeros(n), vec![0.0; n]);
    for (f, net) in nets.iter().enumerate() {
        let relative = net.map(|p| p - net[0]);
        for (s, row) in TABLE.by_sample.iter().enumerate() {
            points.set(f * SAMPLES + s, net[0] + combine(row, &relative));
        }
    }
    target.offsets(points.view(), &mut offsets, normals.view_mut());
    let of_patch = |f: usize| f * SAMPLES..(f + 1) * SAMPLES;
    (0..nets.len())
        .map(|f| {
            let normal = [&normals.x[of_patch(f)], &normals.y[of_patch(f)], &normals.z[of_patch(f)]];
            Local::new(&sides.of(start + f), &offsets[of_patch(f)], normal, weight)
        })
        .collect()
}

impl Local {
    /// From offsets and normals at the samples of a patch. None if the target gave no number there.
    fn new(sides: &[Side; 3], offset: &[f64], normal: [&[f64]; 3], weight: f64) -> Option<Self> {
        let by_point = &TABLE.by_point;
        // Weights of the moves at the samples.
        let mut w = [[0.0; SAMPLES]; MOVES];
        for (k, side) in sides.iter().enumerate() {
            for (point, moves) in side.points.iter().zip(&side.moves) {
                for j in 0..OF_EDGE {
                    (0..SAMPLES).for_each(|s| w[OF_EDGE * k + j][s] += moves[j] * by_point[*point][s]);
                }
            }
        }
        FREE_POINTS.iter().enumerate().for_each(|(i, p)| w[3 * OF_EDGE + i] = by_point[*p]);
        // N Nᵀ + weight · identity at the samples: xx, yy, zz, xy, xz, yz.
        const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
        let square: [[f64; SAMPLES]; 6] = PAIRS.map(|[a, b]| {
            let extra = if a == b { weight } else { 0.0 };
            std::array::from_fn(|s| normal[a][s] * normal[b][s] + extra)
        });
        let pull: [[f64; SAMPLES]; 3] = normal.map(|n| std::array::from_fn(|s| offset[s] * n[s]));

        let mut a = SMatrix::<f64, { SIDES + INNER }, { SIDES + INNER }>::zeros();
        let mut g = SVector::<f64, { SIDES + INNER }>::zeros();
        for i in 0..MOVES {
            (0..3).for_each(|c| g[3 * i + c] = dot(&w[i], &pull[c]));
            for j in 0..=i {
                let both: [f64; SAMPLES] = std::array::from_fn(|s| w[i][s] * w[j][s]);
                for ([p, q], square) in PAIRS.iter().zip(&square) {
                    let sum = dot(&both, square);
                    for (r, c) in [(3 * i + p, 3 * j + q), (3 * i + q, 3 * j + p)] {
                        a[(r, c)] = sum;
                        a[(c, r)] = sum;
                    }
                }
            }
        }
        Self::eliminate(&a, &g)
    }

    /// Takes the free points, the last unknowns, out of the equations.
    fn eliminate(
        a: &SMatrix<f64, { SIDES + INNER }, { SIDES + INNER }>,
        g: &SVector<f64, { SIDES + INNER }>,
    ) -> Option<Self> {
        let inner = a.fixed_view::<INNER, INNER>(SIDES, SIDES).into_owned().cholesky()?;
        let below = a.fixed_view::<INNER, SIDES>(SIDES, 0).into_owned();
        let coupling = inner.solve(&below);
        let step = inner.solve(&g.fixed_rows::<INNER>(SIDES).into_owned());
        let schur = a.fixed_view::<SIDES, SIDES>(0, 0) - below.transpose() * coupling;
        let right = g.fixed_rows::<SIDES>(0) - below.transpose() * step;
        if !schur.iter().chain(right.iter()).all(|x| x.is_finite()) {
            return None;
        }
        Some(Self {
            matrix: lower_triangle(|r, c| schur[(r, c)]),
            right: std::array::from_fn(|i| right[i] as f32),
        })
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        let (r, c) = (row.max(column), row.min(column));
        f64::from(self.matrix[r * (r + 1) / 2 + c])
    }
}

/// A symmetric matrix, given as its lower triangle by rows, times a vector.
fn times<const N: usize>(lower: &[f32], x: &SVector<f64, N>) -> SVector<f64, N> {
    let mut product = SVector::<f64, N>::zeros();
    let mut start = 0;
    for r in 0..N {
        let row = &lower[start..=start + r];
        start += r + 1;
        let mut sum = f64::from(row[r]) * x[r];
        for c in 0..r {
            let m = f64::from(row[c]);
            sum += m * x[c];
            product[c] += m * x[r];
        }
        product[r] += sum;
    }
    product
}

/// With four partial sums, which the compiler keeps side by side.
fn dot(a: &[f64; SAMPLES], b: &[f64; SAMPLES]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

type Step = SVector<f64, EDGE>;

fn of_edges(edges: [usize; 3], x: &[Step]) -> SVector<f64, SIDES> {
    SVector::from_fn(|i, _| x[edges[i / EDGE]][i % EDGE])
}

/// Steps of the edges: preconditioned conjugate gradients with the edges' own blocks as preconditioner.
fn edge_steps(fixed: &[bool], sides: &Sides<'_>, locals: &[Option<Local>]) -> Vec<Step> {
    // An edge beside a patch without numbers stays.
    let mut stays = fixed.to_vec();
    for (f, _) in locals.iter().enumerate().filter(|(_, local)| local.is_none()) {
        sides.edges(f).iter().for_each(|e| stays[*e] = true);
    }
    // Edges that stay have no residual, so that theirs does not matter.
    let block = |e: usize| InverseBlock::of(sides.mesh, e.into(), locals);
    let blocks: Vec<InverseBlock> = (0..stays.len()).into_par_iter().evenly_by(BLOCKS).map(block).collect();
    let precondition = |r: &[Step]| -> Vec<Step> {
        let all = r.par_iter().zip(&blocks).evenly_by(EDGES);
        all.map(|(r, block)| times(&block.lower, r)).collect()
    };
    // Sums of what patches have for each edge, in the order of its sides whatever the number of threads.
    let of_locals = |f: &(dyn Fn(usize, &Local) -> SVector<f64, SIDES> + Sync)| -> Vec<Step> {
        let one = |(i, local): (usize, &Option<Local>)| {
            local.as_ref().map_or_else(SVector::zeros, |local| f(i, local))
        };
        let parts: Vec<_> = locals.par_iter().enumerate().evenly_by(PRODUCTS).map(one).collect();
        let of_edge = |e: usize| {
            let of_side = |(f, k): (usize, usize)| parts[f].fixed_rows::<EDGE>(EDGE * k).into_owned();
            if stays[e] { Step::zeros() } else { sides_of(sides.mesh, e.into()).map(of_side).sum() }
        };
        (0..stays.len()).into_par_iter().evenly_by(EDGES).map(of_edge).collect()
    };
    let product = |a: &[Step], b: &[Step]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };

    let mut x = vec![Step::zeros(); stays.len()];
    let mut residual = of_locals(&|_, local| SVector::from_fn(|i, _| f64::from(local.right[i])));
    let mut direction = precondition(&residual);
    let mut energy = product(&residual, &direction);
    for _ in 0..ITERATIONS {
        if energy.is_nan() || energy <= 0.0 {
            break;
        }
        let image = of_locals(&|i, local| times(&local.matrix, &of_edges(sides.edges(i), &direction)));
        let length = energy / product(&direction, &image);
        for e in 0..stays.len() {
            x[e] += length * direction[e];
            residual[e] -= length * image[e];
        }
        let next = precondition(&residual);
        let next_energy = product(&residual, &next);
        let share = next_energy / energy;
        energy = next_energy;
        direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + share * *d);
    }
    x
}

/// The faces beside an edge, and which side of each it is.
fn sides_of(mesh: &HalfEdgeMesh, e: EdgeId) -> impl Iterator<Item = (usize, usize)> + '_ {
    let h = mesh.edge_half_edge(e);
    [Some(h), mesh.twin(h)].into_iter().flatten().map(|h| (mesh.face(h).index(), mesh.side(h)))
}

/// The inverse of an edge's block on the diagonal, in single precision as the patches' matrices; zero if it has none.
#[derive(Clone, Copy)]
struct InverseBlock {
    /// Lower triangle by rows.
    lower: [f32; EDGE * (EDGE + 1) / 2],
}

impl Default for InverseBlock {
    fn default() -> Self {
        Self { lower: [0.0; EDGE * (EDGE + 1) / 2] }
    }
}

impl InverseBlock {
    fn of(mesh: &HalfEdgeMesh, e: EdgeId, locals: &[Option<Local>]) -> Self {
        let mut block = SMatrix::<f64, EDGE, EDGE>::zeros();
        for (f, k) in sides_of(mesh, e) {
            if let Some(local) = &locals[f] {
                block += SMatrix::<f64, EDGE, EDGE>::from_fn(|r, c| local.at(EDGE * k + r, EDGE * k + c));
            }
        }
        let Some(inverse) = block.cholesky().map(|factors| factors.inverse()) else { return Self::default() };
        Self { lower: lower_triangle(|r, c| inverse[(r, c)]) }
    }
}

/// Entries of the lower triangle, by rows.
fn lower_triangle<const N: usize>(entry: impl Fn(usize, usize) -> f64) -> [f32; N] {
    let mut places = (0..).flat_map(|r| (0..=r).map(move |c| (r, c)));
    std::array::from_fn(|_| places.next().map_or(0.0, |(r, c)| entry(r, c) as f32))
}

fn move_row(net: &mut Net, side: &Side, step: &Step) {
    for (point, moves) in side.points.iter().zip(&side.moves) {
        for j in 0..OF_EDGE {
            net[*point] -= moves[j] * step.fixed_rows::<3>(3 * j);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::spline::edge::EdgeSystem;

    /// The edge system leaves rows alone that satisfy it.
    #[test]
    fn moved_rows_still_satisfy_the_edge_system() {
        let point = |i: usize| {
            let x = i as f64;
            Vec3::new(0.3 * x + (2.3 * x).sin(), (1.7 * x).cos(), 0.2 * (0.9 * x * x).sin())
        };
        let lambda = [0.37, 0.61];
        let mut system = EdgeSystem {
            q: std::array::from_fn(point),
            p: std::array::from_fn(|i| point(i + 10)),
            r: std::array::from_fn(|i| point(i + 20)),
            lambda,
            mu: [-0.2, 0.4, 0.7, 1.1],
            nu: 0.3,
        };
        let solved = system.solve().unwrap();
        let vectors = [point(40), point(41)];
        let moved = |row: [Point3; 3], moves: &RowMoves| -> [Point3; 3] {
            std::array::from_fn(|i| row[i] + moves[i][0] * vectors[0] + moves[i][1] * vectors[1])
        };
        let [p, r] = row_moves(lambda);
        let (p, r) = (moved(solved.p, &p), moved(solved.r, &r));
        system.p[2..5].copy_from_slice(&p);
        system.r[2..5].copy_from_slice(&r);
        let again = system.solve().unwrap();
        for i in 0..3 {
            assert!((again.p[i] - p[i]).norm() < 1e-13 && (again.r[i] - r[i]).norm() < 1e-13, "{i}");
            assert!((p[i] - solved.p[i]).norm() > 0.1, "the rows must have moved");
        }
    }

    #[test]
    fn packed_products_are_those_of_the_matrix() {
        let entry = |r: usize, c: usize| ((r * c + r + c) as f64).sin();
        let local = Local { matrix: lower_triangle(entry), right: [0.0; SIDES] };
        let x = SVector::<f64, SIDES>::from_fn(|i, _| (i as f64).cos());
        let full = SMatrix::<f64, SIDES, SIDES>::from_fn(entry);
        assert!((times(&local.matrix, &x) - full * x).amax() < 1e-5);
        assert!((0..SIDES).all(|i| (local.at(i, 3) - full[(i, 3)]).abs() < 1e-6));
    }
}
