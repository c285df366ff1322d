//! Tong & Kim 2009: (3) for any degrees, Tables 1 and 2, the appendices A to D, and the situations of Fig. 8.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

use isopatch::base::{BaseMesh, FieldTarget};
use isopatch::bernstein::curve::{binomial, point};
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Mat3, Point3, Vec3};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::network::{CurveError, CurveOptions, CurveSolver, fit_quartics};
use isopatch::spline::condition::{DegreeError, Degrees, Obstacle};
use isopatch::spline::edge::EdgeSystem;
use isopatch::spline::vertex::{EndWeights, end_weights};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A sequence of numbers without order (splitmix64).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }
}

fn random() -> Random {
    Random(2009)
}

fn numbers(rng: &mut Random, count: usize) -> Vec<f64> {
    (0..count).map(|_| rng.between(-1.0, 1.0)).collect()
}

fn vector(rng: &mut Random) -> Vec3 {
    Vec3::from_fn(|_, _| rng.between(-1.0, 1.0))
}

/// (−1)^k.
fn sign(k: usize) -> f64 {
    if k.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Σ c_i B_i(t) of degree c.len() − 1.
fn bernstein(c: &[f64], t: f64) -> f64 {
    let n = c.len() - 1;
    c.iter()
        .enumerate()
        .map(|(i, c)| c * binomial(n, i) * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32))
        .sum()
}

/// Rows of Table 2: on the left (factor, number of λ, number of the points p and r), on the right (factor, number of μ, number of
/// the point that μ̄ multiplies).
type Terms = &'static [(f64, usize, usize)];
const TABLE_2: [(Terms, Terms); 8] = [
    (&[(1.0, 0, 0)], &[(1.0, 0, 0)]),
    (&[(6.0, 0, 1), (1.0, 1, 0)], &[(3.0, 0, 1), (4.0, 1, 0)]),
    (&[(15.0, 0, 2), (6.0, 1, 1)], &[(3.0, 0, 2), (12.0, 1, 1), (6.0, 2, 0)]),
    (&[(20.0, 0, 3), (15.0, 1, 2)], &[(1.0, 0, 3), (12.0, 1, 2), (18.0, 2, 1), (4.0, 3, 0)]),
    (&[(15.0, 0, 4), (20.0, 1, 3)], &[(4.0, 1, 3), (18.0, 2, 2), (12.0, 3, 1), (1.0, 4, 0)]),
    (&[(15.0, 1, 4), (6.0, 0, 5)], &[(6.0, 2, 3), (12.0, 3, 2), (3.0, 4, 1)]),
    (&[(6.0, 1, 5), (1.0, 0, 6)], &[(4.0, 3, 3), (3.0, 4, 2)]),
    (&[(1.0, 1, 6)], &[(1.0, 4, 3)]),
];

#[test]
fn the_rows_for_the_papers_degrees_are_those_of_table_2() {
    let mut rng = random();
    let (lambda, mu) = (numbers(&mut rng, 2), numbers(&mut rng, 5));
    for (k, (left, right)) in TABLE_2.iter().enumerate() {
        let row = Degrees::PAPER.row(k, &lambda, &mu).unwrap();
        let (mut p, mut r, mut q) = (vec![0.0; 7], vec![0.0; 7], vec![0.0; 5]);
        for (factor, i, j) in *left {
            p[*j] += factor * (1.0 - lambda[*i]);
            r[*j] += factor * lambda[*i];
        }
        for (factor, i, j) in *right {
            q[*j] += factor * (1.0 - mu[*i]);
            q[*j + 1] += factor * mu[*i];
        }
        let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
        assert!(close(&row.p, &p) && close(&row.r, &r) && close(&row.q, &q), "row {k}: {row:?}");
    }
    assert_eq!(Degrees::PAPER.row(8, &lambda, &mu), None);
    assert_eq!(Degrees::PAPER.row(0, &mu, &mu), None);
}

/// The rows are the coefficients of (1), whatever the degrees.
#[test]
fn rows_are_the_coefficients_of_the_condition() {
    let mut rng = random();
    for [r, s, m, n] in
        [[1, 4, 4, 7], [1, 2, 4, 5], [0, 2, 3, 5], [2, 4, 4, 6], [3, 5, 5, 7], [1, 1, 1, 1], [1, 4, 5, 8]]
    {
        let degrees = Degrees::new(r, s, m, n).unwrap();
        let (lambda, mu) = (numbers(&mut rng, r + 1), numbers(&mut rng, s + 1));
        let (p, l, q) = (numbers(&mut rng, n), numbers(&mut rng, n), numbers(&mut rng, m + 1));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let residual: Vec<f64> = (0..degrees.rows())
            .map(|k| {
                let row = degrees.row(k, &lambda, &mu).unwrap();
                dot(&row.p, &p) + dot(&row.r, &l) - dot(&row.q, &q)
            })
            .collect();
        for t in [0.0, 0.17, 0.5, 0.83, 1.0] {
            let (lambda, mu) = (bernstein(&lambda, t), bernstein(&mu, t));
            let direct = (1.0 - lambda) * bernstein(&p, t) + lambda * bernstein(&l, t)
                - (1.0 - mu) * bernstein(&q[..m], t)
                - mu * bernstein(&q[1..], t);
            let degree = degrees.rows() as i32 - 1;
            let power = |k: usize| t.powi(k as i32) * (1.0 - t).powi(degree - k as i32);
            let by_rows: f64 = residual.iter().enumerate().map(|(k, x)| x * power(k)).sum();
            assert!((direct - by_rows).abs() < 1e-12, "{degrees:?} at {t}: {direct} {by_rows}");
        }
    }
}

#[test]
fn of_the_degrees_in_table_1_seven_is_the_least_with_local_systems() {
    use Obstacle::{NoMuForEdge, SharedCurvePoint, SharedLambda, SharedMu};
    let obstacles = |r, s, m, n| Degrees::new(r, s, m, n).unwrap().obstacles();
    // Table 1.
    assert_eq!(obstacles(1, 2, 4, 5), [SharedMu]);
    assert_eq!(obstacles(1, 3, 4, 6), [NoMuForEdge]);
    assert_eq!(obstacles(1, 4, 4, 7), []);
    assert_eq!(obstacles(1, 2, 5, 6), [SharedMu]);
    assert_eq!(obstacles(1, 3, 5, 7), [NoMuForEdge]);
    assert_eq!(obstacles(1, 4, 5, 8), []);
    // 7.1: cubic curves. 7.3: n = 6 with λ of degree 2.
    assert_eq!(obstacles(1, 4, 3, 6), [SharedCurvePoint]);
    assert_eq!(obstacles(2, 4, 4, 6), [SharedLambda]);
    let local = |r, s, m, n| Degrees::new(r, s, m, n).is_ok_and(|d| d.obstacles().is_empty());
    let all = |r: usize, n: usize| (1..=n).filter(move |m| *m <= r + n).map(move |m| (r + n - m, m));
    for n in 1..7 {
        assert!(all(1, n).all(|(s, m)| !local(1, s, m, n)), "linear λ, n = {n}");
    }
    assert!(all(1, 7).filter(|(s, m)| local(1, *s, *m, 7)).eq([(4, 4)]));

    let paper = Degrees::PAPER;
    assert_eq!((paper.rows(), paper.edge_rows(), paper.edge_points()), (8, 2..6, 2..5));
    assert_eq!((paper.free_mu(), paper.free_points()), (1, 3));
    assert_eq!(
        Degrees::new(1, 4, 4, 6),
        Err(DegreeError::Unbalanced { lambda: 1, mu: 4, curve: 4, patch: 6 })
    );
    assert_eq!(Degrees::new(1, 0, 5, 4), Err(DegreeError::Curve { curve: 5, patch: 4 }));
}

/// What s = 3 lacks: where λ is constant, the sum of the rows with alternating signs has nothing but Dˢμ · Dᵐq on its right side. With
/// s = 3 that binds the coefficients of both ends to each other, with s = 4 there is μ2 to make it 0.
#[test]
fn constant_lambda_leaves_a_condition_on_mu() {
    let mut rng = random();
    for (s, m) in [(3, 4), (4, 4), (3, 5), (4, 5), (5, 4)] {
        let degrees = Degrees::new(1, s, m, s + m - 1).unwrap();
        let (lambda, mu) = ([0.4; 2], numbers(&mut rng, s + 1));
        let (mut left, mut right) = (vec![0.0; 2 * degrees.rows()], vec![0.0; m + 1]);
        for k in 0..degrees.rows() {
            let row = degrees.row(k, &lambda, &mu).unwrap();
            left.iter_mut().zip(row.p.iter().chain(&row.r)).for_each(|(sum, p)| *sum += sign(k) * p);
            right.iter_mut().zip(&row.q).for_each(|(sum, q)| *sum += sign(k) * q);
        }
        let alternating = |n: usize, c: &dyn Fn(usize) -> f64| -> f64 {
            (0..=n).map(|i| sign(n - i) * c(i) * binomial(n, i)).sum()
        };
        let top_of_mu = alternating(s, &|i| mu[i]);
        for (i, factor) in right.iter().enumerate() {
            let of_curve = sign(m - i) * binomial(m, i);
            let last = sign(degrees.rows() - 1);
            assert!((factor - last * top_of_mu * of_curve).abs() < 1e-11, "s = {s}, m = {m}: {right:?}");
        }
        assert!(left.iter().all(|factor| factor.abs() < 1e-11), "s = {s}, m = {m}: {left:?}");
    }
}

/// Appendix A: the normal curvature of a quartic curve at its start is 3 (q2 − q0)·N / (4 λ²).
#[test]
fn appendix_a_normal_curvature() {
    let mut rng = random();
    for _ in 0..50 {
        let n = vector(&mut rng).normalize();
        let along = vector(&mut rng).cross(&n).normalize();
        let length = rng.between(0.1, 2.0);
        let q0 = vector(&mut rng);
        let mut q = [q0, q0 + length * along, vector(&mut rng), vector(&mut rng), vector(&mut rng)];
        let formula = 3.0 * (q[2] - q[0]).dot(&n) / (4.0 * length * length);
        // κ n·N = c''·N / |c'|² for a tangent in the tangent plane, with derivatives from the control points …
        let (first, second) = (4.0 * (q[1] - q[0]), 12.0 * (q[2] - 2.0 * q[1] + q[0]));
        assert!((second.dot(&n) / first.norm_squared() - formula).abs() < 1e-12 * (1.0 + formula.abs()));
        // … and from points of the curve.
        let h = 1e-4;
        let [a, b, c] = [0.0, h, 2.0 * h].map(|t| point(&q, t));
        let second = (c - 2.0 * b + a) / (h * h);
        assert!((second.dot(&n) / first.norm_squared() - formula).abs() < 1e-2 * (1.0 + formula.abs()));
        // The other control points do not matter.
        q[3] = vector(&mut rng);
        assert_eq!(formula, 3.0 * (q[2] - q[0]).dot(&n) / (4.0 * length * length));
    }
}

/// A ring of curves with uneven angles and lengths in a tangent plane with normal z.
struct Ring {
    d: Vec<Vec3>,
    weights: Vec<EndWeights>,
}

const ELEVATION: f64 = 4.0 / 7.0;

impl Ring {
    fn new(n: usize, rng: &mut Random) -> Self {
        let angle = |i: usize, turn: f64| TAU * (i as f64 + turn) / n as f64;
        let d: Vec<Vec3> = (0..n)
            .map(|i| {
                let a = angle(i, rng.between(-0.2, 0.2));
                rng.between(0.2, 0.5) * Vec3::new(a.cos(), a.sin(), 0.0)
            })
            .collect();
        let weights =
            (0..n).map(|i| end_weights(&d[(i + n - 1) % n], &d[i], &d[(i + 1) % n], &Vec3::z())).collect();
        Self { d, weights }
    }

    fn count(&self) -> usize {
        self.d.len()
    }

    /// A of (17): row i has 6 λ̄0 and 6 λ0 at the corners before and after curve i.
    fn matrix(&self) -> DMatrix<f64> {
        let n = self.count();
        let mut a = DMatrix::zeros(n, n);
        for (i, w) in self.weights.iter().enumerate() {
            a[(i, (i + n - 1) % n)] += 6.0 * (1.0 - w.lambda);
            a[(i, i)] += 6.0 * w.lambda;
        }
        a
    }

    /// The normal part of the right side, 3 μ0 (q2 − o)·N, for curves with (q2 − o)·N of this many 4/3 dᵀ M d.
    fn normal_right(&self, curvature: &Mat3, share: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_fn(self.count(), |i, _| {
            let d = &self.d[i];
            3.0 * self.weights[i].mu * share(i) * 4.0 / 3.0 * d.dot(&(curvature * d))
        })
    }
}

/// Appendix B: the products of all λ0 and of all 1 − λ0 around a vertex are equal; and (B.1).
#[test]
fn appendix_b_products_of_lambda() {
    let mut rng = random();
    for n in 3..=12 {
        let ring = Ring::new(n, &mut rng);
        let product = |f: &dyn Fn(f64) -> f64| ring.weights.iter().map(|w| f(w.lambda)).product::<f64>();
        let (of, of_others) = (product(&|l| l), product(&|l| 1.0 - l));
        assert!((of - of_others).abs() < 1e-13 * of, "valence {n}: {of} {of_others}");
        for i in 0..n {
            let (w, c) = (ring.weights[i], |i: usize| ELEVATION * ring.d[i % n]);
            let residual = (1.0 - w.lambda) * c(i + n - 1) + w.lambda * c(i + 1) - w.mu * ring.d[i];
            assert!(residual.norm() < 1e-14);
        }
    }
}

/// The alternating sum of the vertex enclosure constraint.
fn enclosure(weights: &[EndWeights], right: &DVector<f64>) -> f64 {
    let n = weights.len();
    let term = |i: usize| {
        let before: f64 = weights[..i].iter().map(|w| w.lambda).product();
        let after: f64 = weights[i + 1..].iter().map(|w| 1.0 - w.lambda).product();
        sign(i) * before * after * right[i]
    };
    (0..n).map(term).sum()
}

/// Appendix C: A has rank n for odd valence and n − 1 for even, where the normal part is consistent exactly for curves with the
/// normal curvatures of one tensor; with μ1 free, the tangential part has full rank.
#[test]
fn appendix_c_enclosure_and_ranks() {
    let mut rng = random();
    for n in 3..=10 {
        let ring = Ring::new(n, &mut rng);
        let a = ring.matrix();
        assert_eq!(a.rank(1e-10), if n % 2 == 0 { n - 1 } else { n }, "valence {n}");

        let (xx, xy, yy) = (0.7, -0.4, -1.3);
        let curvature = Mat3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0);
        let right = ring.normal_right(&curvature, |_| 1.0);
        let c = |i: usize| ELEVATION * ring.d[i % n];
        let closed = DVector::from_fn(n, |i, _| 7.0 / 6.0 * c(i).dot(&(curvature * c(i + 1))));
        assert!((&a * closed - &right).amax() < 1e-14, "valence {n}");
        if n % 2 == 0 {
            let scale = right.amax();
            assert!(enclosure(&ring.weights, &right).abs() < 1e-14 * scale);
            let spoiled = ring.normal_right(&curvature, |i| if i == 0 { 1.1 } else { 1.0 });
            assert!(enclosure(&ring.weights, &spoiled).abs() > 1e-6 * scale, "valence {n}");
            let least = a.clone().svd(true, true).solve(&spoiled, 1e-10).unwrap();
            assert!((&a * least - &spoiled).amax() > 1e-6 * scale);
        }

        // [A 0 Q1; 0 A Q2] with −4 d_i in the columns of μ1.
        let mut tangential = DMatrix::zeros(2 * n, 3 * n);
        for axis in 0..2 {
            tangential.view_mut((axis * n, axis * n), (n, n)).copy_from(&a);
            (0..n).for_each(|i| tangential[(axis * n + i, 2 * n + i)] = -4.0 * ring.d[i][axis]);
        }
        assert_eq!(tangential.rank(1e-10), 2 * n);
    }
}

/// Appendix D: the edge system has rank 4, but 3 where λ0 = λ1; the minor of the proof is 67500 (1 − λ0)² (λ1 − λ0).
#[test]
fn appendix_d_rank_of_the_edge_system() {
    let mut rng = random();
    for _ in 0..20 {
        let [l0, l1]: [f64; 2] = std::array::from_fn(|_| rng.between(0.1, 0.9));
        let a = Degrees::PAPER.edge_matrix(&[l0, l1]).unwrap();
        assert_eq!((a.shape(), a.rank(1e-9)), ((4, 6), 4));
        let minor = a.select_columns([0, 2, 4, 5].iter()).determinant();
        let closed = 67500.0 * (1.0 - l0).powi(2) * (l1 - l0);
        assert!((minor.abs() - closed.abs()).abs() < 1e-8 * (1.0 + closed.abs()), "{minor} {closed}");
        let same = Degrees::PAPER.edge_matrix(&[l0, l0]).unwrap();
        assert_eq!(same.rank(1e-9), 3);
        let alternating = same.row(0) - same.row(1) + same.row(2) - same.row(3);
        assert!(alternating.amax() < 1e-12);
        // Linear λ of any degrees: as many rows as that, and one less for constant λ.
        for [s, m, n] in [[3, 4, 6], [4, 5, 8], [5, 4, 8], [5, 5, 9]] {
            let degrees = Degrees::new(1, s, m, n).unwrap();
            let rank = |l: &[f64]| degrees.edge_matrix(l).unwrap().rank(1e-9);
            let rows = degrees.edge_rows().len();
            assert_eq!((rank(&[l0, l1]), rank(&[l0, l0])), (rows, rows - 1));
        }
    }
}

/// The solution of the four robust rows solves all rows of (3), for λ0 = λ1 too: (22) is fulfilled by μ2 of (23).
#[test]
fn appendix_d_consistency_by_mu_2() {
    let mut rng = random();
    for difference in [0.3, 1e-3, 1e-9, 0.0] {
        let q: [Point3; 5] =
            std::array::from_fn(|i| Vec3::new(i as f64 / 4.0, 0.0, 0.0) + 0.1 * vector(&mut rng));
        let lambda = [0.4, 0.4 + difference];
        let mu = [0.4, 0.5, 0.6, 0.55];
        let mut system = EdgeSystem { q, p: [Vec3::zeros(); 7], r: [Vec3::zeros(); 7], lambda, mu, nu: 0.0 };
        let all = system.mu_coefficients();
        for m in 0..7 {
            system.p[m] = vector(&mut rng);
            system.r[m] = vector(&mut rng);
        }
        // Rows k = 0, 1, 6, 7 by the choice of r, as the vertex systems do.
        let solve_for = |system: &mut EdgeSystem, k: usize, j: usize| {
            let row = Degrees::PAPER.row(k, &lambda, &all).unwrap();
            let right: Vec3 = row.q.iter().zip(&q).map(|(a, q)| *a * q).sum();
            let p: Vec3 = row.p.iter().zip(&system.p).map(|(a, p)| *a * p).sum();
            let others: Vec3 = row
                .r
                .iter()
                .zip(&system.r)
                .enumerate()
                .filter(|(i, _)| *i != j)
                .map(|(_, (a, r))| *a * r)
                .sum();
            system.r[j] = (right - p - others) / row.r[j];
        };
        for (k, j) in [(0, 0), (1, 1), (7, 6), (6, 5)] {
            solve_for(&mut system, k, j);
        }
        let solution = system.solve().unwrap();
        let (mut p, mut r) = (system.p, system.r);
        p[2..5].copy_from_slice(&solution.p);
        r[2..5].copy_from_slice(&solution.r);
        for k in 0..8 {
            let row = Degrees::PAPER.row(k, &lambda, &all).unwrap();
            let sum = |factors: &[f64], points: &[Vec3]| -> Vec3 {
                factors.iter().zip(points).map(|(a, x)| *a * x).sum()
            };
            let residual = sum(&row.p, &p) + sum(&row.r, &r) - sum(&row.q, &q);
            assert!(residual.norm() < 1e-11, "difference {difference}, row {k}: {residual}");
        }
    }
}

/// A grid of triangles over the unit square, lifted to the surface z = h(x) with h(0) = h'(0) = h'(1) = 0, h(1) = 0.3 and these second
/// derivatives at 0 and 1.
fn step(bend: [f64; 2], intervals: usize) -> (Formula, BaseMesh) {
    const RISE: f64 = 0.3;
    // The quintic with these values and derivatives.
    let [a, b] = bend;
    let c = [
        0.5 * a,
        10.0 * RISE - 1.5 * a + 0.5 * b,
        -15.0 * RISE + 1.5 * a - b,
        6.0 * RISE - 0.5 * a + 0.5 * b,
    ];
    let height = |x: f64| (0..4).map(|i| c[i] * x.powi(i as i32 + 2)).sum::<f64>();
    let text = format!("z - ({})*x^2 - ({})*x^3 - ({})*x^4 - ({})*x^5", c[0], c[1], c[2], c[3]);
    let field = Formula::parse(&text, &Constants::new()).unwrap();
    let n = intervals as u32;
    let at = |i: u32| f64::from(i) / f64::from(n);
    let positions: Vec<Point3> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| (i, j)))
        .map(|(i, j)| Point3::new(at(i), at(j), height(at(i))))
        .collect();
    let number = |i: u32, j: u32| i * (n + 1) + j;
    let faces: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
    let base = BaseMesh::from_field(&field, mesh, positions);
    (field, base)
}

/// Fig. 8: edges between parallel tangent planes, one above the other, for which no quartic has the normal curvatures. They are found by
/// both solvers; the halves of such an edge have curves.
#[test]
fn the_situations_of_fig_8_are_found_and_subdivided() {
    let curves = |bend: [f64; 2], intervals: usize, solver: CurveSolver| {
        let (field, base) = step(bend, intervals);
        assert!(base.normals[0].dot(&Vec3::z()) > 1.0 - 1e-15);
        let target = FieldTarget::new(&field, base.diagonal());
        let options = CurveOptions { solver, ..CurveOptions::default() };
        fit_quartics(&base, &target, &options).map(|curves| curves.len())
    };
    for solver in [CurveSolver::Reduced, CurveSolver::Sqp] {
        // Both ends flat; one flat and the other bent away; both bent away from the other tangent plane.
        for bend in [[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [-1.0, 1.0]] {
            match curves(bend, 1, solver) {
                Err(CurveError::Infeasible { from, to, .. }) => {
                    assert!(from / 2 != to / 2, "across the step")
                }
                other => panic!("{bend:?}: {other:?}"),
            }
            assert_eq!(curves(bend, 2, solver), Ok(16), "{bend:?}");
        }
        // Bent towards it there is one.
        assert_eq!(curves([1.0, -1.0], 1, solver), Ok(5));
    }
}
