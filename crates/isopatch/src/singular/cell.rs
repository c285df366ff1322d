//! Boxes of the subdivision and what can be ruled out in them.

use super::unit::{UnitPolynomial, Work};
use crate::bernstein::tensor::TensorNet;
use crate::geom::{Aabb, Interval, Mat3};

/// Where a box is divided: not in the middle, because singular points like to lie at halves and quarters; a short binary
/// fraction, so that 1 − t is exact.
pub(super) const SPLIT: f64 = 499.0 / 1024.0;

/// A box with the net of f on it.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// In unit coordinates, to rounding; neighbours agree in the bits.
    pub bounds: Aabb,
    /// f with parameters from 0 to 1. Derivatives are by these parameters too: that scales rows and columns by positive
    /// numbers, which changes no zero.
    pub net: TensorNet,
    /// The derivatives as nets of their own, right to their own rounding; else they are taken from the net.
    gradient: Option<[TensorNet; 3]>,
    /// Of the polynomial.
    pub work: Work,
}

/// Which points are looked for: each is a part of the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stratum {
    /// f = 0 and ∇f = 0.
    Singular,
    /// And the Hessian has rank at most 1.
    RankOne,
    /// And the equations of the stratum above, the 2×2 minors of the Hessian with ∇f, have a Jacobian of rank at most 1.
    Irregular,
    /// And ∇²f = 0, where third derivatives leave one direction at most.
    Flat,
}

/// What is known about the critical points of f in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Critical {
    /// None is in the box.
    None,
    /// Exactly one is in the box, and it is in this part of it.
    One(Aabb),
    /// Nothing is known.
    Unknown,
}

impl Cell {
    /// The box with the net from the exact coefficients.
    pub fn new(f: &UnitPolynomial, bounds: Aabb) -> Self {
        Self { bounds, net: f.net(&bounds), gradient: None, work: f.work.clone() }
    }

    /// The box with nets of f and its derivatives from the exact coefficients. Each is right to its own rounding, which
    /// matters where f is small and its derivatives differ in size.
    pub fn precise(f: &UnitPolynomial, bounds: Aabb) -> Self {
        let gradient = Some([0, 1, 2].map(|a| f.derivative_net(a, &bounds)));
        Self { bounds, net: f.net(&bounds), gradient, work: f.work.clone() }
    }

    /// The nets of the derivatives, each up to a positive factor.
    fn gradient(&self) -> [TensorNet; 3] {
        self.gradient.clone().unwrap_or_else(|| [0, 1, 2].map(|a| self.net.derivative(a)))
    }

    /// The eight parts in which f may be zero.
    pub fn split(&self) -> Vec<Self> {
        let mut parts = vec![self.clone()];
        for axis in 0..3 {
            parts = parts
                .iter()
                .flat_map(|part| part.halves(axis))
                .filter(|p| p.net.range().contains(0.0))
                .collect();
        }
        parts
    }

    fn halves(&self, axis: usize) -> [Self; 2] {
        let [left, right] = self.net.split(axis, SPLIT);
        let (mut lower, mut upper) = (self.bounds, self.bounds);
        let middle = self.bounds.min[axis] + SPLIT * (self.bounds.max[axis] - self.bounds.min[axis]);
        lower.max[axis] = middle;
        upper.min[axis] = middle;
        let [left_gradient, right_gradient] = match &self.gradient {
            Some(nets) => {
                let parts = nets.each_ref().map(|g| g.split(axis, SPLIT));
                [(0, SPLIT), (1, 1.0 - SPLIT)].map(|(side, width)| {
                    let mut nets = parts.each_ref().map(|part| part[side].clone());
                    // By the parameter of the part.
                    nets[axis] = nets[axis].clone().scaled(width);
                    Some(nets)
                })
            }
            None => [None, None],
        };
        [
            Self { bounds: lower, net: left, gradient: left_gradient, work: self.work.clone() },
            Self { bounds: upper, net: right, gradient: right_gradient, work: self.work.clone() },
        ]
    }

    /// Might a point of the stratum be in the box?
    pub fn may_hold(&self, stratum: Stratum) -> bool {
        let gradient = self.gradient();
        if !self.net.range().contains(0.0) || !may_vanish(&gradient) {
            return false;
        }
        if stratum == Stratum::Singular {
            return true;
        }
        let second = symmetric(|a, b| gradient[a].derivative(b));
        let h = symmetric(|a, b| second[pair(a, b)].range());
        if !minors_may_vanish(&[0, 1, 2].map(|a| [0, 1, 2].map(|b| h[pair(a, b)]))) {
            return false;
        }
        if stratum == Stratum::RankOne {
            return true;
        }
        let third = |ab: usize| [0, 1, 2].map(|c| second[ab].derivative(c).range());
        let thirds: [[Interval; 3]; 6] = std::array::from_fn(third);
        if stratum == Stratum::Irregular {
            let mut rows: Vec<[Interval; 3]> = (0..3).map(|a| [0, 1, 2].map(|b| h[pair(a, b)])).collect();
            rows.extend(minor_gradients(&h, &thirds));
            return minors_may_vanish(&rows);
        }
        h.iter().all(|entry| entry.contains(0.0)) && minors_may_vanish(&thirds)
    }

    /// Has the derivative in an eigendirection of the mean Hessian a sign in the box? Then no critical point is there. Where
    /// sheets almost touch, the derivatives by the coordinates do not tell, because one direction drowns the others.
    pub fn rises(&self) -> bool {
        let gradient = self.gradient();
        let second = symmetric(|a, b| mean(&gradient[a].derivative(b)));
        let hessian = Mat3::from_fn(|a, b| second[pair(a, b)]);
        if !hessian.iter().all(|v| v.is_finite()) {
            return false;
        }
        let directions = hessian.symmetric_eigen().eigenvectors;
        let nets = [0, 1, 2].map(|a| at_degrees(&gradient[a], self.net.degrees));
        directions.column_iter().any(|d| !combination(&nets, [d.x, d.y, d.z]).contains(0.0))
    }

    /// Krawczyk's test for ∇f = 0: K(X) = m − Y ∇f(m) + (I − Y ∇²f(X))(X − m), with Y near the inverse of the Hessian.
    /// K(X) inside X: exactly one critical point; K(X) beside X: none.
    pub fn critical(&self) -> Critical {
        let gradient = self.gradient();
        let hessian = symmetric(|a, b| gradient[a].derivative(b).range());
        let entry = |a: usize, b: usize| hessian[pair(a, b)];
        let middle = Mat3::from_fn(|a, b| 0.5 * (entry(a, b).lo + entry(a, b).hi));
        let Some(y) = middle.try_inverse().filter(|y| y.iter().all(|v| v.is_finite())) else {
            return Critical::Unknown;
        };
        let at_middle = gradient.each_ref().map(|g| {
            let value = g.value([0.5; 3]);
            // The evaluation is a few steps like those of a split.
            let error =
                g.error + 4.0 * f64::EPSILON * (g.degrees.iter().sum::<usize>() + 1) as f64 * g.magnitude();
            Interval::new(value - error, value + error)
        });
        let half = Interval::new(-0.5, 0.5);
        let (mut inside, mut beside) = (true, false);
        let mut enclosure = Aabb::EMPTY;
        for i in 0..3 {
            let mut image = Interval::point(0.0);
            for j in 0..3 {
                image = image - Interval::point(y[(i, j)]) * at_middle[j];
                let product = (0..3)
                    .fold(Interval::point(0.0), |sum, k| sum + Interval::point(y[(i, k)]) * entry(k, j));
                image = image + (Interval::point(f64::from(u8::from(i == j))) - product) * half;
            }
            inside &= image.lo > -0.5 && image.hi < 0.5;
            beside |= image.lo > 0.5 || image.hi < -0.5;
            // The map to the box rounds twice.
            let size = self.bounds.max[i] - self.bounds.min[i];
            let slack = 2.0 * f64::EPSILON * (self.bounds.min[i].abs() + size);
            enclosure.min[i] = self.bounds.min[i] + (0.5 + image.lo) * size - slack;
            enclosure.max[i] = self.bounds.min[i] + (0.5 + image.hi) * size + slack;
        }
        if inside {
            Critical::One(enclosure)
        } else if beside {
            Critical::None
        } else {
            Critical::Unknown
        }
    }
}

fn mean(net: &TensorNet) -> f64 {
    net.coefficients.iter().sum::<f64>() / net.coefficients.len() as f64
}

/// A derivative with the degrees of the function.
fn at_degrees(net: &TensorNet, degrees: [usize; 3]) -> TensorNet {
    let mut net = net.clone();
    for axis in 0..3 {
        while net.degrees[axis] < degrees[axis] {
            net = net.elevated(axis);
        }
    }
    net
}

/// The range of Σ w_a g_a, for nets of the same degrees and weights of at most 1.
fn combination(nets: &[TensorNet; 3], weights: [f64; 3]) -> Interval {
    let [g, h, k] = nets.each_ref().map(|net| &net.coefficients);
    let sums = (0..g.len()).map(|i| weights[0] * g[i] + weights[1] * h[i] + weights[2] * k[i]).collect();
    // Three products and two sums.
    let error = nets.iter().map(|net| net.error + 4.0 * f64::EPSILON * net.magnitude()).sum();
    TensorNet::new(nets[0].degrees, sums, error).range()
}

/// Might all three vanish at one point? No if one has a sign, or if their combination with their means has.
fn may_vanish(gradient: &[TensorNet; 3]) -> bool {
    let ranges = gradient.each_ref().map(TensorNet::range);
    if ranges.iter().any(|r| !r.contains(0.0)) {
        return false;
    }
    let means = gradient.each_ref().map(|g| g.coefficients.iter().sum::<f64>() / g.coefficients.len() as f64);
    let sum = (0..3).fold(Interval::point(0.0), |sum, a| sum + Interval::point(means[a]) * ranges[a]);
    sum.contains(0.0)
}

/// The place of entry (a, b) of a symmetric matrix among six.
const fn pair(a: usize, b: usize) -> usize {
    let (a, b) = if a < b { (a, b) } else { (b, a) };
    [0, 2, 3][a] + b
}

/// The six entries (0,0), (0,1), (0,2), (1,1), (1,2), (2,2).
fn symmetric<T>(entry: impl Fn(usize, usize) -> T) -> [T; 6] {
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(a, b)| entry(a, b))
}

/// Might all 2×2 minors of the rows vanish?
fn minors_may_vanish(rows: &[[Interval; 3]]) -> bool {
    (0..rows.len()).all(|i| {
        (i + 1..rows.len()).all(|j| {
            [(0, 1), (0, 2), (1, 2)]
                .iter()
                .all(|&(a, b)| (rows[i][a] * rows[j][b] - rows[i][b] * rows[j][a]).contains(0.0))
        })
    })
}

/// The 2×2 minors of a symmetric matrix: rows (a, b), columns (c, d).
pub(super) const MINORS: [[usize; 4]; 6] =
    [[0, 1, 0, 1], [0, 1, 0, 2], [0, 1, 1, 2], [0, 2, 0, 2], [0, 2, 1, 2], [1, 2, 1, 2]];

/// The gradients of the minors of the Hessian: ∂(h_ac h_bd − h_ad h_bc).
fn minor_gradients(h: &[Interval; 6], third: &[[Interval; 3]; 6]) -> [[Interval; 3]; 6] {
    MINORS.map(|[a, b, c, d]| {
        let (ac, bd, ad, bc) = (pair(a, c), pair(b, d), pair(a, d), pair(b, c));
        [0, 1, 2].map(|k| {
            third[ac][k] * h[bd] + h[ac] * third[bd][k] - third[ad][k] * h[bc] - h[ad] * third[bc][k]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};
    use crate::geom::Point3;

    #[test]
    fn a_slope_is_seen_beside_a_steep_valley() {
        // Along the valley of (3x + 4y)² + (4x − 3y)³ + z² the slope is 10⁻⁴ of what it is across; the derivatives by x and
        // y have no sign. At the edge of the cusp nothing is ruled out.
        let text = "(3x+4y)^2+(4x-3y)^3+z^2";
        let formula = Formula::parse(text, &Constants::new()).unwrap();
        let bounds = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0));
        let f = UnitPolynomial::new(&formula.quadratic_polynomial().unwrap(), &bounds);
        let around = |p: Point3| Cell::precise(&f, Aabb::new(p, p).grown(1e-3));
        let beside = around(Point3::new(4e-3, -3e-3, 0.0));
        assert!(may_vanish(&beside.gradient()) && beside.rises());
        let at = around(Point3::zeros());
        assert!(!at.rises());
    }

    #[test]
    fn nets_of_derivatives_are_derivatives_of_nets() {
        let formula = Formula::parse("x^2y^2+y^2z^2+z^2x^2-4x y z", &Constants::new()).unwrap();
        let bounds = Aabb::new(Point3::new(-3.0, -3.0, -2.0), Point3::new(3.0, 3.0, 2.0));
        let f = UnitPolynomial::new(&formula.quadratic_polynomial().unwrap(), &bounds);
        let cell = Aabb::new(Point3::new(0.49, -0.002, -0.003), Point3::new(0.51, 0.001, 0.005));
        let precise = Cell::precise(&f, cell).gradient();
        let plain = Cell::new(&f, cell).gradient();
        let scale = precise[0].magnitude() / plain[0].magnitude();
        for axis in 0..3 {
            for (a, b) in precise[axis].coefficients.iter().zip(&plain[axis].coefficients) {
                assert!((a - scale * b).abs() < 1e-9 * precise[axis].magnitude(), "axis {axis}: {a} {b}");
            }
        }
        assert!(Cell::new(&f, cell).may_hold(Stratum::RankOne));
        assert!(Cell::precise(&f, cell).may_hold(Stratum::RankOne));
        assert_eq!(Cell::precise(&f, cell).critical(), Critical::Unknown);
        let held = Cell::precise(&f, cell)
            .split()
            .iter()
            .filter(|c| c.may_hold(Stratum::RankOne) && c.critical() != Critical::None)
            .count();
        assert!(held > 0);
    }
}
