//! K tetrahedra [u v p_s p_(s+1)] around an axis (Sub-algorithm 3).

use super::cells::Jet;
use super::data::PolygonFrame;
use super::sectors::{SectorBase, SectorSide, Sectors};
use super::tetra::{barycentric, fraction};
use crate::bernstein::tetrahedron;
use crate::geom::Point3;
use crate::hull::Side;

/// The coefficients of the cubics (4.3) on [u v p_s p_(s+1)], named by how often u and v occur and by what else does.
///
/// Those that belong to the plane [u v p_s] are C1 there by (4.8)–(4.12). The same t_2100 and t_3000 should come out for every
/// s: with three corners they do, with four if the axis meets both diagonals; else the mean is taken and the function is C1 only
/// if [`FanNet::defects`] vanish.
#[derive(Clone, Debug, PartialEq)]
pub struct FanNet {
    /// t_3000, t_2100, t_1200, t_0300 on the axis.
    pub axis: [f64; 4],
    /// t_2010, t_1110, t_0210 at each corner.
    pub twice: Vec<[f64; 3]>,
    /// t_1020, t_0120 at each corner.
    pub corner: Vec<[f64; 2]>,
    /// t_1011, t_0111 at each edge.
    pub edge: Vec<[f64; 2]>,
    /// t_0021, t_0012 at each edge.
    pub base: Vec<[f64; 2]>,
    /// t_2100 and t_3000 as they come out at each corner.
    pub of_corner: Vec<[f64; 2]>,
}

impl FanNet {
    /// From the data of the polygon and F(v), ∇F(v). All coefficients are affine in these.
    pub fn new(frame: &PolygonFrame, u: &Point3, v: &Point3, at_v: &Jet) -> Self {
        let corners = 0..frame.count();
        let (p, before) = (&frame.p, |s: usize| frame.before(s));
        let corner: Vec<[f64; 2]> = corners.clone().map(|s| [u, v].map(|a| frame.at_corner(s, a))).collect();
        let edge: Vec<[f64; 2]> = corners.clone().map(|s| [u, v].map(|a| frame.on_edge(s, a))).collect();
        let base: Vec<[f64; 2]> = corners.clone().map(|s| frame.along(s)).collect();
        let t0210: Vec<f64> = corners.clone().map(|s| at_v.towards(v, &p[s])).collect();
        let t1200 = at_v.towards(v, u);
        // u = α_1 p_s + α_2 p_(s+1) + α_3 p_(s−1) + α_4 v.
        let alpha: Vec<[f64; 4]> =
            corners.clone().map(|s| barycentric([p[s], p[frame.after(s)], p[before(s)], *v], u)).collect();
        // α times values at (p_s, p_(s+1), p_(s−1), v).
        let across = |s: usize, values: [f64; 4]| -> f64 { (0..4).map(|i| alpha[s][i] * values[i]).sum() };
        // (4.8) and (4.11), whose third term belongs to s − 1.
        let around = |s: usize, which: usize, last: f64| {
            across(s, [corner[s][which], edge[s][which], edge[before(s)][which], last])
        };
        let t1110: Vec<f64> = corners.clone().map(|s| around(s, 1, t0210[s])).collect();
        let t2010: Vec<f64> = corners.clone().map(|s| around(s, 0, t1110[s])).collect();
        // (4.9) and (4.12).
        let of_corner: Vec<[f64; 2]> = corners
            .clone()
            .map(|s| {
                let three = |t: &[f64], last: f64| across(s, [t[s], t[frame.after(s)], t[before(s)], last]);
                let t2100 = three(&t1110, t1200);
                [t2100, three(&t2010, t2100)]
            })
            .collect();
        let mean = |n: usize| of_corner.iter().map(|t| t[n]).sum::<f64>() / frame.count() as f64;
        Self {
            axis: [mean(1), mean(0), t1200, at_v.value],
            twice: corners.map(|s| [t2010[s], t1110[s], t0210[s]]).collect(),
            corner,
            edge,
            base,
            of_corner,
        }
    }

    /// By how much t_2100 and then t_3000 of each corner differ from those of the next (4.10), (4.13), s = 1 … K − 3: 2K − 6
    /// numbers that have to vanish.
    pub fn defects(&self) -> Vec<f64> {
        let pairs = self.of_corner.len().saturating_sub(3);
        [0, 1]
            .into_iter()
            .flat_map(|n| (0..pairs).map(move |s| self.of_corner[s][n] - self.of_corner[s + 1][n]))
            .collect()
    }

    /// The net of the cubic on [u v p_s p_(s+1)], in the order of [`tetrahedron`].
    pub fn sector(&self, s: usize) -> [f64; 20] {
        let next = if s + 1 == self.corner.len() { 0 } else { s + 1 };
        let mut net = [0.0; 20];
        for (slot, [i, j, k, l]) in net.iter_mut().zip(tetrahedron::indices(3)) {
            let at = if l > 0 { next } else { s };
            *slot = match (k + l, k.min(l)) {
                (0, _) => self.axis[j],
                (1, _) => self.twice[at][j],
                (2, 0) => self.corner[at][j],
                (2, _) => self.edge[s][j],
                _ if k == 2 => self.base[s][0],
                _ if l == 2 => self.base[s][1],
                _ => 0.0,
            };
            debug_assert_eq!(i + j + k + l, 3);
        }
        net
    }

    /// The layers along the ray from the point of [u v p_s p_(s+1)] with barycentric coordinates β to u (5.2), or to v (5.3).
    pub fn ray(&self, s: usize, beta: [f64; 4], side: Side) -> [f64; 4] {
        let net = self.sector(s);
        let top = side.index();
        let factorial = |n: usize| [1.0, 1.0, 2.0, 6.0][n];
        std::array::from_fn(|degree| {
            // Σ over the indices that hold `degree` of the apex, of the coefficient times a polynomial of degree 3 − `degree`.
            let term = |(t, index): (&f64, [usize; 4])| {
                let mut rest = index;
                if rest[top] < degree {
                    return 0.0;
                }
                rest[top] -= degree;
                let power = |c: usize| beta[c].powi(rest[c] as i32) / factorial(rest[c]);
                t * factorial(3 - degree) * (0..4).map(power).product::<f64>()
            };
            net.iter().zip(tetrahedron::indices(3)).map(term).sum()
        })
    }

    /// The same function in cells on both sides of the triangles [c p_s p_(s+1)], for c on the axis.
    pub fn split(&self, [u, v]: [&Point3; 2], center: Point3) -> Sectors {
        let weight = fraction(v, u, &center);
        let rest = 1.0 - weight;
        // From a row of coefficients with u, …, v to that with u or v, and c in place of one of them.
        let lower = |row: &[f64]| -> Vec<f64> {
            row.windows(2).map(|pair| weight * pair[0] + rest * pair[1]).collect()
        };
        let axis = lower(&self.axis);
        let axis2 = lower(&axis);
        let at_corner: Vec<(Vec<f64>, f64)> = self
            .twice
            .iter()
            .map(|row| {
                let once = lower(row);
                let twice = lower(&once)[0];
                (once, twice)
            })
            .collect();
        let once = |row: &[f64; 2]| weight * row[0] + rest * row[1];
        let count = self.corner.len();
        let pairs = (0..count).map(|s| (s, if s + 1 == count { 0 } else { s + 1 }));
        let base = pairs
            .clone()
            .map(|(p, q)| SectorBase {
                net: [
                    lower(&axis2)[0],
                    at_corner[p].1,
                    at_corner[q].1,
                    once(&self.corner[p]),
                    once(&self.edge[p]),
                    once(&self.corner[q]),
                    self.base[p][0],
                    self.base[p][1],
                ],
                turn: [0.0; 2],
            })
            .collect();
        let sides = Side::BOTH.map(|side| {
            // The end of a row of coefficients on this side.
            let (a, s) = (side.index(), side.sign());
            let end = |row: &[f64]| if a == 0 { row[0] } else { row[row.len() - 1] };
            let of_sector = |(p, q): (usize, usize)| SectorSide {
                layer1: [
                    end(&axis2),
                    end(&at_corner[p].0),
                    end(&at_corner[q].0),
                    self.corner[p][a],
                    self.edge[p][a],
                    self.corner[q][a],
                ]
                .map(|t| s * t),
                layer2: [end(&axis), end(&self.twice[p]), end(&self.twice[q])].map(|t| s * t),
                layer3: s * end(&self.axis),
                ..SectorSide::default()
            };
            Some(pairs.clone().map(of_sector).collect())
        });
        Sectors { center, base, sides }
    }
}
