//! The function over a polygon that is split at a point c into triangles [c p q], one for each edge: cells [a c p q].

use crate::geom::Point3;

/// What multiplies the rational data of a sector, with derivatives by (c, p, q).
///
/// With D = c²p² + c²q² + p²q², the weights α = c²p²/D and β = c²q²/D tell the planes [a c p] and [a c q] apart: each is 1 on
/// its own plane and 0 on the other, and they vanish to second order on the outer face [a p q]. γ = p²q²/D = 1 − α − β.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// 2pqα and 2pqβ: in layer 1, and with the factor 3c in layer 0.
    pub turn: [(f64, [f64; 3]); 2],
    /// 4pqαγ and 4pqβγ: in layer 1 where there are cells on both sides, which makes the function C1 across [c p q].
    pub through: [(f64, [f64; 3]); 2],
}

impl Weights {
    /// At weights (c, p, q) of the base.
    #[inline(always)]
    pub fn new([c, p, q]: [f64; 3]) -> Self {
        let (cp, cq, pq) = (c * p, c * q, p * q);
        let squares = [cp * cp, cq * cq, pq * pq];
        let sum = squares[0] + squares[1] + squares[2];
        let zero = (0.0, [0.0; 3]);
        // At the corners all terms vanish.
        if sum == 0.0 {
            return Self { turn: [zero; 2], through: [zero; 2] };
        }
        let slopes = [
            [2.0 * cp * p, 2.0 * cp * c, 0.0],
            [2.0 * cq * q, 0.0, 2.0 * cq * c],
            [0.0, 2.0 * pq * q, 2.0 * pq * p],
        ];
        let of_sum: [f64; 3] = std::array::from_fn(|i| slopes[0][i] + slopes[1][i] + slopes[2][i]);
        let part = |n: usize| -> (f64, [f64; 3]) {
            let share = squares[n] / sum;
            (share, std::array::from_fn(|i| (slopes[n][i] - share * of_sum[i]) / sum))
        };
        let product = [0.0, q, p];
        let (gamma, gamma_d) = part(2);
        let turn = [0, 1].map(|n| {
            let (share, d) = part(n);
            (2.0 * pq * share, std::array::from_fn(|i| 2.0 * (product[i] * share + pq * d[i])))
        });
        let through = turn.map(|(value, d)| {
            (2.0 * value * gamma, std::array::from_fn(|i| 2.0 * (d[i] * gamma + value * gamma_d[i])))
        });
        Self { turn, through }
    }
}

/// The values of [`Weights`] alone.
fn weight_values([c, p, q]: [f64; 3]) -> [[f64; 2]; 2] {
    let (cp, cq, pq) = (c * p, c * q, p * q);
    let squares = [cp * cp, cq * cq, pq * pq];
    let sum = squares[0] + squares[1] + squares[2];
    if sum == 0.0 {
        return [[0.0; 2]; 2];
    }
    let turn = [0, 1].map(|n| 2.0 * pq * (squares[n] / sum));
    [turn, turn.map(|value| 2.0 * value * (squares[2] / sum))]
}

/// A function of (c, p, q) with its derivatives.
type Form = (f64, [f64; 3]);

fn add(sum: &mut Form, factor: f64, term: &Form) {
    sum.0 += factor * term.0;
    for i in 0..3 {
        sum.1[i] += factor * term.1[i];
    }
}

/// The value of a quadratic form by its net: (cc, cp, cq, pp, pq, qq).
fn quadratic_value([cc, cp, cq, pp, pq, qq]: [f64; 6], [c, p, q]: [f64; 3]) -> f64 {
    (cc * (c * c) + pp * (p * p) + qq * (q * q)) + 2.0 * (cp * (c * p) + pq * (p * q) + cq * (q * c))
}

/// A quadratic form with its derivatives.
fn quadratic(net: &[f64; 6], [c, p, q]: [f64; 3]) -> Form {
    let [cc, cp, cq, pp, pq, qq] = *net;
    let half = [cc * c + cp * p + cq * q, cp * c + pp * p + pq * q, cq * c + pq * p + qq * q];
    (half[0] * c + half[1] * p + half[2] * q, half.map(|h| 2.0 * h))
}

/// The function on the triangle [c p q], layer 0 of the cells on both of its sides, in the sign of the function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectorBase {
    /// Coefficients of ccc, ccp, ccq, cpp, cpq, cqq, ppq, pqq; those of ppp and qqq are zero.
    pub net: [f64; 8],
    /// Corrections of the coefficient of (c, p, q) on the planes [a c p] and [a c q].
    pub turn: [f64; 2],
}

impl SectorBase {
    /// Value and derivatives by (c, p, q), as of a form of degree 3.
    pub fn value(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let [c, p, q] = x;
        let [ccc, ccp, ccq, cpp, cpq, cqq, ppq, pqq] = self.net;
        // One third of the derivatives of the cubic.
        let by_c = quadratic_value([ccc, ccp, ccq, cpp, cpq, cqq], x);
        let by_p = quadratic_value([ccp, cpp, cpq, 0.0, ppq, pqq], x);
        let by_q = quadratic_value([ccq, cpq, cqq, ppq, pqq, 0.0], x);
        let mut form = (c * by_c + p * by_p + q * by_q, [by_c, by_p, by_q].map(|d| 3.0 * d));
        if self.turn != [0.0; 2] {
            let mut turned = (0.0, [0.0; 3]);
            for (d, weight) in self.turn.iter().zip(&Weights::new(x).turn) {
                add(&mut turned, *d, weight);
            }
            add(&mut form, 3.0 * c, &turned);
            form.1[0] += 3.0 * turned.0;
        }
        form
    }

    /// The value alone.
    pub fn at(&self, x: [f64; 3]) -> f64 {
        let [c, p, q] = x;
        let [ccc, ccp, ccq, cpp, cpq, cqq, ppq, pqq] = self.net;
        let off_edge = quadratic_value([ccc, 1.5 * ccp, 1.5 * ccq, 3.0 * cpp, 3.0 * cpq, 3.0 * cqq], x);
        let turned = if self.turn == [0.0; 2] {
            0.0
        } else {
            let [turn, _] = weight_values(x);
            self.turn[0] * turn[0] + self.turn[1] * turn[1]
        };
        crate::apatch::Base::on_edge([ppq, pqq], p, q) + c * (off_edge + 3.0 * turned)
    }
}

/// The function in the cell [a c p q] off its base, for the function times the sign of the side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectorSide {
    /// Layer 1: a with cc, cp, cq, pp, pq, qq.
    pub layer1: [f64; 6],
    /// Corrections of the coefficient of (a, p, q) on the planes [a c p] and [a c q].
    pub turn: [f64; 2],
    /// The corrections of the base, where there is a cell on the other side too; else zero.
    pub through: [f64; 2],
    /// Layer 2: aa with c, p, q.
    pub layer2: [f64; 3],
    /// Layer 3: the value at a.
    pub layer3: f64,
}

impl SectorSide {
    /// Layer 1 with its derivatives by (c, p, q), as of a form of degree 2.
    pub fn layer1(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let mut form = quadratic(&self.layer1, x);
        if self.turn != [0.0; 2] || self.through != [0.0; 2] {
            let weights = Weights::new(x);
            for n in 0..2 {
                add(&mut form, self.turn[n], &weights.turn[n]);
                add(&mut form, self.through[n], &weights.through[n]);
            }
        }
        form
    }

    /// Layers 1, 2 and 3 over a point of the base.
    pub fn layers(&self, x: [f64; 3]) -> [f64; 3] {
        let [c, p, q] = self.layer2;
        let [turn, through] = weight_values(x);
        let turned = self.turn[0] * turn[0] + self.turn[1] * turn[1];
        let passed = self.through[0] * through[0] + self.through[1] * through[1];
        let first = quadratic_value(self.layer1, x) + (turned + passed);
        [first, c * x[0] + p * x[1] + q * x[2], self.layer3]
    }

    /// Value and derivatives by the barycentric coordinates of (a, c, p, q), given those of the base for this side.
    pub fn value(&self, (base, base_d): (f64, [f64; 3]), [a, c, p, q]: [f64; 4]) -> (f64, [f64; 4]) {
        let (first, first_d) = self.layer1([c, p, q]);
        let second = self.layer2[0] * c + self.layer2[1] * p + self.layer2[2] * q;
        let value = base + a * (3.0 * first + a * (3.0 * second + a * self.layer3));
        let by_a = 3.0 * (first + a * (2.0 * second + a * self.layer3));
        let other = |i: usize| base_d[i] + 3.0 * a * (first_d[i] + a * self.layer2[i]);
        (value, [by_a, other(0), other(1), other(2)])
    }
}

/// The function in the cells over a polygon that is split at c. Sector k has the corners p_k and p_(k+1).
#[derive(Clone, Debug, PartialEq)]
pub struct Sectors {
    /// c.
    pub center: Point3,
    /// On the triangles [c p_k p_(k+1)].
    pub base: Vec<SectorBase>,
    /// In the cells of each side that has an apex.
    pub sides: [Option<Vec<SectorSide>>; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: usize) -> f64 {
        (12.9898 * seed as f64 + 0.7).sin()
    }

    #[test]
    fn derivatives_are_those_of_the_value() {
        let base = SectorBase { net: std::array::from_fn(noise), turn: [0.4, -0.3] };
        let side = SectorSide {
            layer1: std::array::from_fn(|i| noise(i + 10)),
            turn: [0.7, -0.2],
            through: [0.4, -0.3],
            layer2: [0.1, 0.5, -0.4],
            layer3: 0.9,
        };
        let value = |x: [f64; 4]| side.value(base.value([x[1], x[2], x[3]]), x);
        let h = 1e-6;
        for n in 0..20 {
            let x: [f64; 4] = std::array::from_fn(|c| 0.5 + 0.45 * noise(4 * n + c));
            let d = value(x).1;
            for c in 0..4 {
                let moved = |step: f64| {
                    let mut moved = x;
                    moved[c] += step;
                    value(moved).0
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                assert!((slope - d[c]).abs() < 1e-8, "{n} {c}: {slope} {}", d[c]);
            }
            let foot = [x[1], x[2], x[3]];
            assert!((base.at(foot) - base.value(foot).0).abs() < 1e-14);
            assert!((side.layers(foot)[0] - side.layer1(foot).0).abs() < 1e-14);
        }
    }

    #[test]
    fn rational_terms_vanish_with_their_derivatives_on_the_outer_face() {
        let weights = Weights::new([0.0, 0.3, 0.7]);
        for (value, d) in weights.turn.iter().chain(&weights.through) {
            assert_eq!((*value, *d), (0.0, [0.0; 3]));
        }
        // Near a corner they are defined, and small.
        for x in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1e-9, 1.0, 1e-9]] {
            assert!(
                Weights::new(x)
                    .turn
                    .iter()
                    .all(|(value, d)| value.abs() < 1e-8 && d.iter().all(|d| d.is_finite()))
            );
        }
    }
}
