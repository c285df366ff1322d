//! The free control points of a patch, fitted to the target: constant matrices, made once.

use super::build::SampledFrom;
use super::surface::{DEGREE, NET};
use crate::bernstein::{energy, index, triangle};
use crate::geom::{Point3, Points, Vec3};
use crate::parallel::Evenly;
use crate::surface::Target;
use nalgebra::{DMatrix, SMatrix, SVector};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Control points inside a patch, and on its boundary.
pub const INTERIOR: usize = 15;
const BOUNDARY: usize = NET - INTERIOR;
/// Samples of the fit: the interior points of the lattice of this size.
const FIT_LATTICE: usize = 8;
const FIT_SAMPLES: usize = 21;
/// Samples of the distance along the normal: the interior points of the lattice of this size.
const NORMAL_LATTICE: usize = 10;
const NORMAL_SAMPLES: usize = 36;
/// Control points that no G1 condition binds.
pub(super) const FREE: usize = 3;
/// Patches whose samples are evaluated in one batch.
const BATCH: usize = 4;

type Net = [Point3; NET];
/// Projected samples of a patch, relative to its first corner.
pub type Footprints = [Point3; FIT_SAMPLES];

/// The three free control points b_322, b_232, b_223.
pub(super) const FREE_POINTS: [usize; FREE] =
    [index::position([3, 2, 2]), index::position([2, 3, 2]), index::position([2, 2, 3])];

struct Tables {
    boundary: [usize; BOUNDARY],
    interior: [usize; INTERIOR],
    /// Boundary points → samples of the filled patch, and of the flat triangle.
    fill_samples: [[f64; BOUNDARY]; FIT_SAMPLES],
    flat_samples: [[f64; BOUNDARY]; FIT_SAMPLES],
    /// Boundary points → samples of the patch with interior points zero.
    boundary_samples: [[f64; BOUNDARY]; FIT_SAMPLES],
    /// Samples → interior points of least squares.
    interior_fit: [[f64; FIT_SAMPLES]; INTERIOR],
    /// Net with free points zero → samples.
    bound_samples: [[f64; NET]; FIT_SAMPLES],
    /// Samples → free points of least squares.
    free_fit: [[f64; FIT_SAMPLES]; FREE],
    /// Basis at the samples of the normal distance.
    normal_basis: [[f64; NET]; NORMAL_SAMPLES],
    /// Σ B_a B_b over these samples, for the free points.
    free_gram: [[f64; FREE]; FREE],
}

static TABLES: LazyLock<Box<Tables>> = LazyLock::new(|| Box::new(Tables::new()));

impl Tables {
    fn new() -> Self {
        let (boundary, interior): (Vec<_>, Vec<_>) =
            index::indices(DEGREE).partition(|i| index::is_boundary(*i));
        let positions = |ijk: &[[usize; 3]]| ijk.iter().copied().map(index::position).collect::<Vec<_>>();
        let (boundary, interior) = (positions(&boundary), positions(&interior));
        let basis = triangle::basis_matrix(DEGREE, &triangle::interior_lattice(FIT_LATTICE));
        let on_boundary = basis.select_columns(&boundary);
        let inside = basis.select_columns(&interior);
        let filled = &on_boundary + &inside * energy::thin_plate_fill(DEGREE);
        let free = basis.select_columns(&FREE_POINTS);
        let mut bound = basis.clone();
        FREE_POINTS.iter().for_each(|c| bound.column_mut(*c).fill(0.0));
        let normal = triangle::basis_matrix(DEGREE, &triangle::interior_lattice(NORMAL_LATTICE));
        let normal_free = normal.select_columns(&FREE_POINTS);
        Self {
            boundary: std::array::from_fn(|i| boundary[i]),
            interior: std::array::from_fn(|i| interior[i]),
            fill_samples: fixed(&filled),
            flat_samples: flat_samples(&boundary),
            boundary_samples: fixed(&on_boundary),
            interior_fit: fixed(&least_squares(&inside)),
            bound_samples: fixed(&bound),
            free_fit: fixed(&least_squares(&free)),
            normal_basis: fixed(&normal),
            free_gram: fixed(&(normal_free.transpose() * &normal_free)),
        }
    }
}

/// Boundary points → points of the flat triangle at the samples: a corner counts by its barycentric coordinate.
fn flat_samples(boundary: &[usize]) -> [[f64; BOUNDARY]; FIT_SAMPLES] {
    let corners = [[DEGREE, 0, 0], [0, DEGREE, 0], [0, 0, DEGREE]].map(index::position);
    let samples = triangle::interior_lattice(FIT_LATTICE);
    std::array::from_fn(|s| {
        std::array::from_fn(|b| (0..3).filter(|c| corners[*c] == boundary[b]).map(|c| samples[s][c]).sum())
    })
}

/// (AᵀA)⁻¹Aᵀ. The sample lattices determine the points in question, so the Gram matrix is regular.
fn least_squares(a: &DMatrix<f64>) -> DMatrix<f64> {
    let gram = a.transpose() * a;
    gram.lu().solve(&a.transpose()).unwrap_or_else(|| DMatrix::zeros(a.ncols(), a.nrows()))
}

fn fixed<const R: usize, const C: usize>(m: &DMatrix<f64>) -> [[f64; C]; R] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
}

pub(super) fn combine<const N: usize>(row: &[f64; N], points: &[Point3; N]) -> Point3 {
    let mut sum = [0.0; 3];
    for (w, p) in row.iter().zip(points) {
        (0..3).for_each(|c| sum[c] += w * p[c]);
    }
    Vec3::from(sum)
}

/// Gives every net, whose boundary points are set, the interior points that fit the target: the boundary is filled
/// with least thin-plate energy, the filled patch (or the flat triangle) is sampled, the samples are projected onto the
/// target, and the interior points fit the projected samples by least squares.
///
/// Projecting the filled patch instead of the flat triangle is what the paper (section 6.1, eq. (12)) does not do;
/// it lowers the error on coarse meshes, five times for one of them (PAPERS.md, deviations).
pub fn fill_and_fit(nets: &mut [Net], target: &dyn Target, from: SampledFrom) -> Vec<Footprints> {
    let tables = &**TABLES;
    let sampled = match from {
        SampledFrom::Filled => &tables.fill_samples,
        SampledFrom::Flat => &tables.flat_samples,
    };
    // Filled in place: gathered from batches, they would for a moment be there twice.
    let mut footprints = vec![[Point3::zeros(); FIT_SAMPLES]; nets.len()];
    nets.par_chunks_mut(BATCH).zip(footprints.par_chunks_mut(BATCH)).evenly().for_each(
        |(nets, footprints)| {
            let origins: Vec<Point3> = nets.iter().map(|net| net[0]).collect();
            let boundaries: Vec<[Vec3; BOUNDARY]> =
                nets.iter().map(|net| std::array::from_fn(|i| net[tables.boundary[i]] - net[0])).collect();
            let mut points: Points = boundaries
                .iter()
                .zip(&origins)
                .flat_map(|(b, o)| sampled.each_ref().map(|row| o + combine(row, b)))
                .collect();
            target.project(&mut points);
            for (f, (net, feet)) in nets.iter_mut().zip(footprints).enumerate() {
                *feet = std::array::from_fn(|s| points.get(f * FIT_SAMPLES + s) - origins[f]);
                let rest: Footprints =
                    std::array::from_fn(|s| feet[s] - combine(&tables.boundary_samples[s], &boundaries[f]));
                for (row, i) in tables.interior_fit.iter().zip(tables.interior) {
                    net[i] = origins[f] + combine(row, &rest);
                }
            }
        },
    );
    footprints
}

/// Refits the three free points of every net to its projected samples, the other points staying as they are.
pub fn refit_free_points(nets: &mut [Net], footprints: &[Footprints]) {
    let tables = &**TABLES;
    nets.par_iter_mut().zip(footprints).evenly_by(BATCH).for_each(|(net, feet)| {
        let origin = net[0];
        let offsets = net.map(|p| p - origin);
        let rest: Footprints = std::array::from_fn(|s| feet[s] - combine(&tables.bound_samples[s], &offsets));
        for (row, i) in tables.free_fit.iter().zip(FREE_POINTS) {
            net[i] = origin + combine(row, &rest);
        }
    });
}

/// Gauss–Newton steps on Σ (f/|∇f|)² + `tangential_weight` · |motion|² over the three free points of every net.
pub fn reduce_normal_distance(nets: &mut [Net], target: &dyn Target, steps: usize, tangential_weight: f64) {
    for _ in 0..steps {
        move_with_free_points(nets, target, tangential_weight, |_, _| ());
    }
}

/// Moves other points of every net by `move_points(number, net)`, and its three free points by a Gauss–Newton step on
/// Σ (f/|∇f|)² + `tangential_weight` · |motion|², both linear from the net as it was.
pub(super) fn move_with_free_points(
    nets: &mut [Net],
    target: &dyn Target,
    tangential_weight: f64,
    move_points: impl Fn(usize, &mut Net) + Sync,
) {
    nets.par_chunks_mut(BATCH).enumerate().evenly().for_each(|(batch, nets)| {
        let n = nets.len() * NORMAL_SAMPLES;
        let (mut points, mut normals, mut offsets) = (Points::zeros(n), Points::zeros(n), vec![0.0; n]);
        for (f, net) in nets.iter().enumerate() {
            let place = |(s, p): (usize, Point3)| points.set(f * NORMAL_SAMPLES + s, p);
            normal_samples(net).enumerate().for_each(place);
        }
        target.offsets(points.view(), &mut offsets, normals.view_mut());
        for (f, net) in nets.iter_mut().enumerate() {
            move_points(batch * BATCH + f, net);
            let moved = *net;
            let samples = normal_samples(&moved).zip(f * NORMAL_SAMPLES..).map(|(p, at)| NormalSample {
                offset: offsets[at],
                normal: normals.get(at),
                motion: p - points.get(at),
            });
            free_point_step(net, samples, tangential_weight);
        }
    });
}

fn normal_samples(net: &Net) -> impl Iterator<Item = Point3> {
    let (origin, relative) = (net[0], net.map(|p| p - net[0]));
    TABLES.normal_basis.iter().map(move |row| origin + combine(row, &relative))
}

/// Distance and normal where a sample was, and how far it has moved since.
struct NormalSample {
    offset: f64,
    normal: Vec3,
    motion: Vec3,
}

/// One Gauss–Newton step. Where the system is singular or the target gave no number, the net stays.
fn free_point_step(net: &mut Net, samples: impl Iterator<Item = NormalSample>, tangential_weight: f64) {
    let tables = &**TABLES;
    let mut a = SMatrix::<f64, 9, 9>::zeros();
    let mut gradient = SVector::<f64, 9>::zeros();
    for (basis, NormalSample { offset, normal: n, motion }) in tables.normal_basis.iter().zip(samples) {
        let row = SVector::<f64, 9>::from_fn(|i, _| basis[FREE_POINTS[i / 3]] * n[i % 3]);
        let pull = (offset + n.dot(&motion)) * n + tangential_weight * motion;
        a.ger(1.0, &row, &row, 1.0);
        for (p, i) in FREE_POINTS.iter().enumerate() {
            (0..3).for_each(|c| gradient[3 * p + c] += basis[*i] * pull[c]);
        }
    }
    for p in 0..FREE {
        for q in 0..FREE {
            (0..3).for_each(|c| a[(3 * p + c, 3 * q + c)] += tangential_weight * tables.free_gram[p][q]);
        }
    }
    let Some(step) = a.cholesky().map(|factor| factor.solve(&gradient)) else { return };
    if step.iter().all(|x| x.is_finite()) {
        for (p, i) in FREE_POINTS.iter().enumerate() {
            net[*i] -= Vec3::new(step[3 * p], step[3 * p + 1], step[3 * p + 2]);
        }
    }
}
