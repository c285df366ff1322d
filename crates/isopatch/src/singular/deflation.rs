//! Systems of equations that are regular along singular curves where ∇f = 0 alone is not.
//!
//! Where the Hessian has rank 2, ∇f = 0 has a Jacobian of rank 2 and the curve is a regular solution. Where it has less,
//! equations are added that the curve satisfies as well: the 2×2 minors of the Hessian, its entries, or the minors of the
//! Jacobian of the system before (deflation by determinants: Leykin, Verschelde & Zhao; Hauenstein & Wampler).

use super::cell::MINORS;
use super::taylor::{Taylor, sum, unit};
use super::unit::UnitPolynomial;
use crate::geom::{Point3, Vec3};
use nalgebra::{DMatrix, Matrix3};

/// Which equations hold along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum System {
    /// ∇f = 0.
    Gradient,
    /// And the 2×2 minors of ∇²f: regular along cusps.
    RankOne,
    /// And the entries of ∇²f: regular along triple curves.
    Flat,
    /// `RankOne` and the 2×2 minors of its Jacobian: regular where two sheets touch along the curve.
    Touching,
}

impl System {
    /// From the fewest equations to the most.
    pub const ALL: [Self; 4] = [Self::Gradient, Self::RankOne, Self::Flat, Self::Touching];
}

/// 1, x, y, z, xx, xy, xz, yy, yz, zz.
const MONOMIALS: [[usize; 3]; 10] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [1, 1, 0],
    [1, 0, 1],
    [0, 2, 0],
    [0, 1, 1],
    [0, 0, 2],
];

/// A power series around a point, up to the second order, in the order of [`MONOMIALS`].
#[derive(Clone, Copy, Debug)]
struct Series([f64; 10]);

impl Series {
    /// Of a derivative of f.
    fn of(taylor: &Taylor, by: [usize; 3]) -> Self {
        let halved = |e: [usize; 3]| if e.contains(&2) { 0.5 } else { 1.0 };
        Self(MONOMIALS.map(|e| {
            if by.iter().sum::<usize>() + e.iter().sum::<usize>() > super::taylor::ORDER {
                0.0
            } else {
                halved(e) * taylor.derivative(sum(by, e))
            }
        }))
    }

    fn times(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let second = |i: usize, j: usize, k: usize| {
            let cross = if i == j { a[i] * b[i] } else { a[i] * b[j] + a[j] * b[i] };
            a[0] * b[k] + b[0] * a[k] + cross
        };
        let first = |i: usize| a[0] * b[i] + b[0] * a[i];
        Self([
            a[0] * b[0],
            first(1),
            first(2),
            first(3),
            second(1, 1, 4),
            second(1, 2, 5),
            second(1, 3, 6),
            second(2, 2, 7),
            second(2, 3, 8),
            second(3, 3, 9),
        ])
    }

    fn minus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }

    fn scaled(&self, factor: f64) -> Self {
        Self(self.0.map(|c| factor * c))
    }

    fn gradient(&self) -> Vec3 {
        Vec3::new(self.0[1], self.0[2], self.0[3])
    }

    /// The derivative by a coordinate, right up to the first order.
    fn derivative(&self, axis: usize) -> Self {
        let s = &self.0;
        let [c, x, y, z] = match axis {
            0 => [s[1], 2.0 * s[4], s[5], s[6]],
            1 => [s[2], s[5], 2.0 * s[7], s[8]],
            _ => [s[3], s[6], s[8], 2.0 * s[9]],
        };
        Self([c, x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }
}

/// The values of the equations and their gradients, at a point.
struct Equations {
    values: Vec<f64>,
    rows: Vec<Vec3>,
}

impl Equations {
    fn of(system: System, taylor: &Taylor) -> Self {
        let mut series: Vec<Series> = (0..3).map(|a| Series::of(taylor, unit(a))).collect();
        let hessian = taylor.hessian();
        let size = hessian.norm().max(f64::MIN_POSITIVE);
        let entry = |a: usize, b: usize| Series::of(taylor, sum(unit(a), unit(b)));
        match system {
            System::Gradient => {}
            System::Flat => {
                series.extend([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(a, b)| entry(a, b)));
            }
            System::RankOne | System::Touching => series.extend(MINORS.map(|[a, b, c, d]| {
                entry(a, c).times(&entry(b, d)).minus(&entry(a, d).times(&entry(b, c))).scaled(1.0 / size)
            })),
        }
        if system == System::Touching {
            let jacobian: Vec<[Series; 3]> = series.iter().map(|s| [0, 1, 2].map(|a| s.derivative(a))).collect();
            let size = jacobian.iter().flatten().map(|s| s.0[0] * s.0[0]).sum::<f64>().sqrt();
            for (i, row) in jacobian.iter().enumerate() {
                for other in &jacobian[..i] {
                    series.extend([(0, 1), (0, 2), (1, 2)].map(|(a, b)| {
                        let minor = row[a].times(&other[b]).minus(&row[b].times(&other[a]));
                        minor.scaled(1.0 / size.max(f64::MIN_POSITIVE))
                    }));
                }
            }
        }
        Self { values: series.iter().map(|s| s.0[0]).collect(), rows: series.iter().map(Series::gradient).collect() }
    }

    /// The Gauss–Newton step in the directions of the `rank` largest singular values, these values over the largest,
    /// and the direction of the smallest.
    fn step(&self, rank: usize) -> Option<(Vec3, [f64; 3], Vec3)> {
        let jacobian = DMatrix::from_fn(self.rows.len(), 3, |i, j| self.rows[i][j]);
        if jacobian.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let qr = jacobian.qr();
        let mut right = nalgebra::DVector::from_column_slice(&self.values);
        qr.q_tr_mul(&mut right);
        let triangle = qr.r();
        let r = Matrix3::from_fn(|i, j| triangle[(i, j)]);
        let svd = r.svd(true, true);
        let (u, v) = (svd.u?, svd.v_t?);
        let right = Vec3::new(right[0], right[1], right[2]);
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|a, b| svd.singular_values[*b].total_cmp(&svd.singular_values[*a]));
        let sigma = order.map(|i| svd.singular_values[i]);
        if sigma[0] == 0.0 {
            return None;
        }
        let step = order[..rank].iter().zip(sigma).fold(Vec3::zeros(), |step, (&i, sigma_i)| {
            if sigma_i <= SINGULAR * sigma[0] { step } else { step - v.row(i).transpose() * (u.column(i).dot(&right) / sigma_i) }
        });
        Some((step, sigma.map(|s| s / sigma[0]), v.row(order[2]).transpose()))
    }
}

/// Singular values below this part of the largest are rounding.
const SINGULAR: f64 = 1e-13;
/// Steps of an iteration: it converges quadratically where it is of use.
const STEPS: usize = 25;
/// A step this short, in unit coordinates, is rounding.
const CONVERGED: f64 = 4e-15;

/// A solution of a system.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Where, in unit coordinates.
    pub at: Point3,
    /// The direction in which the equations change least: the tangent of a curve.
    pub tangent: Vec3,
    /// The singular values of the Jacobian over the largest, which is 1.
    pub sigma: [f64; 3],
    /// The length of the last step.
    pub step: f64,
}

/// The solution of a system near a point, by Gauss–Newton steps in the `rank` directions that change it most; none if
/// they lead farther away than `reach` or do not come to rest.
pub(super) fn solve(f: &UnitPolynomial, system: System, start: Point3, rank: usize, reach: f64) -> Option<Foot> {
    let mut at = start;
    let mut last = f64::INFINITY;
    let mut foot = None;
    for _ in 0..STEPS {
        let (step, sigma, tangent) = Equations::of(system, &f.taylor(at)).step(rank)?;
        let length = step.norm();
        if length >= last && last < RESTING {
            break;
        }
        at += step;
        if (at - start).norm() > reach {
            return None;
        }
        foot = Some(Foot { at, tangent, sigma, step: length });
        last = length;
        if length < CONVERGED {
            break;
        }
    }
    foot.filter(|foot| foot.step < RESTING)
}

/// Steps shorter than this that grow again are rounding.
const RESTING: f64 = 1e-10;
