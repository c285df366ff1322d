//! K tetrahedra [a c p_s p_(s+1)] around the line from an apex a to a point c inside of the polygon, on one side or on both.
//!
//! The coefficients with two of a and c are those of functions affine in the third point, so that they fit around the axis by
//! themselves; all others are given by the data of the polygon. What the C1 conditions across [a c p_k] then lack for the
//! coefficients of (a, p, q) and (c, p, q) becomes a rational term: no condition on the data remains, for any number of corners.

use super::cells::HybridFace;
use super::data::PolygonFrame;
use super::sectors::{SectorBase, SectorSide, Sectors};
use super::tetra::barycentric;
use crate::geom::Point3;
use crate::hull::Side;

/// An affine function of the height over c.
#[derive(Clone, Copy, Debug)]
struct Shift {
    /// Added everywhere.
    constant: f64,
    /// Added times the height over c along the axis, in heights of the apex.
    rise: f64,
}

/// The coefficients with two of a and c: functions of the third point.
#[derive(Clone, Copy)]
struct Axis<'a> {
    face: &'a HybridFace,
    side: Side,
    apex: Point3,
    /// What F(a, c, x) and F(c, c, x) have beyond the quadric.
    shifts: [Shift; 2],
}

impl Axis<'_> {
    /// Height of x over c, 1 at the apex.
    fn height(&self, x: &Point3) -> f64 {
        let (c, n) = (&self.face.center, &self.face.normal);
        (x - c).dot(n) / (self.apex - c).dot(n)
    }

    fn shifted(&self, n: usize, x: &Point3) -> f64 {
        let Shift { constant, rise } = self.shifts[n];
        if constant == 0.0 && rise == 0.0 { 0.0 } else { constant + rise * self.height(x) }
    }

    /// F(a, a, x).
    fn aa(&self, x: &Point3) -> f64 {
        match self.face.at_apex[self.side.index()] {
            Some(jet) => jet.towards(&self.apex, x),
            None => self.face.quadric.blossom(&self.apex, &self.apex, x),
        }
    }

    /// F(a, c, x).
    fn ac(&self, x: &Point3) -> f64 {
        self.face.quadric.blossom(&self.apex, &self.face.center, x) + self.shifted(0, x)
    }

    /// F(c, c, x).
    fn cc(&self, x: &Point3) -> f64 {
        let c = &self.face.center;
        self.face.quadric.blossom(c, c, x) + self.shifted(1, x)
    }
}

/// The axes of both sides of a face, where it has apexes.
///
/// Parameters F(a), ∇F(a) that are not those of the quadric change F(a, a, c) by Δ. F(a, c, ·) and F(c, c, ·) follow, so that
/// the function stays C1 around the axis and, with cells on both sides, across the triangles [c p q]: F(c, c, ·) by
/// ε = (κΔ_u − Δ_v/κ) / 2(1 + κ) per height of u, where κ is the height of v below c over that of u.
fn axes(face: &HybridFace) -> [Option<Axis<'_>>; 2] {
    let none = Shift { constant: 0.0, rise: 0.0 };
    let mut axes =
        Side::BOTH.map(|side| Some(Axis { face, side, apex: face.apexes[side.index()]?, shifts: [none; 2] }));
    let c = &face.center;
    let change = |axis: &Axis<'_>| match face.at_apex[axis.side.index()] {
        Some(jet) => jet.towards(&axis.apex, c) - face.quadric.blossom(&axis.apex, &axis.apex, c),
        None => 0.0,
    };
    match &mut axes {
        [Some(u), Some(v)] => {
            let (at_u, at_v, depth) = (change(u), change(v), -u.height(&v.apex));
            let bend = (depth * at_u - at_v / depth) / (2.0 * (1.0 + depth));
            u.shifts = [Shift { constant: bend, rise: at_u - bend }, Shift { constant: 0.0, rise: bend }];
            let below = -depth * bend;
            v.shifts = [Shift { constant: below, rise: at_v - below }, Shift { constant: 0.0, rise: below }];
        }
        [one, other] => {
            for axis in [one, other].into_iter().flatten() {
                axis.shifts[0].rise = change(axis);
            }
        }
    }
    axes
}

/// Corrections of the coefficients of (x, p_k, p_(k+1)) for C1 across the planes [a c p_k] and [a c p_(k+1)], of each sector.
///
/// `once` are the coefficients without them, `twice` those of (x, a, p_k), (x, c, p_k) and (x, p_k, p_k). What is lacking is
/// shared between the two sectors at a plane so that the sum of squares is least.
fn turns(weights: &[[f64; 4]], once: &[f64], twice: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let count = once.len();
    let mut turns = vec![[0.0; 2]; count];
    for k in 0..count {
        let before = if k == 0 { count - 1 } else { k - 1 };
        let [at_a, at_c, at_p, at_next] = weights[k];
        let [with_a, with_c, with_p] = twice[k];
        let lacking = once[before] - (at_a * with_a + at_c * with_c + at_p * with_p + at_next * once[k]);
        let share = lacking / (1.0 + at_next * at_next);
        turns[before][1] = -share;
        turns[k][0] = at_next * share;
    }
    turns
}

/// The function over a polygon with the given data.
pub fn sectors(frame: &PolygonFrame, face: &HybridFace) -> Sectors {
    let corners = 0..frame.count();
    let c = &face.center;
    let axes = axes(face);
    // p_(k−1) in [a, c, p_k, p_(k+1)].
    let weights = |axis: &Axis<'_>| -> Vec<[f64; 4]> {
        let around = |k: usize| [axis.apex, *c, frame.p[k], frame.p[frame.after(k)]];
        corners.clone().map(|k| barycentric(around(k), &frame.p[frame.before(k)])).collect()
    };
    let of_edges = |x: &Point3| -> Vec<f64> { corners.clone().map(|k| frame.on_edge(k, x)).collect() };
    // Both axes give the same base, as far as rounding lets them.
    let base = axes.iter().flatten().next().map_or_else(Vec::new, |axis| {
        let once = of_edges(c);
        let twice: Vec<[f64; 3]> = corners
            .clone()
            .map(|k| [axis.ac(&frame.p[k]), axis.cc(&frame.p[k]), frame.at_corner(k, c)])
            .collect();
        let turns = turns(&weights(axis), &once, &twice);
        let of_sector = |k: usize| {
            let next = frame.after(k);
            let [ppq, pqq] = frame.along(k);
            SectorBase {
                net: [
                    axis.cc(c),
                    twice[k][1],
                    twice[next][1],
                    twice[k][2],
                    once[k],
                    twice[next][2],
                    ppq,
                    pqq,
                ],
                turn: turns[k],
            }
        };
        corners.clone().map(of_sector).collect()
    });
    let both = axes.iter().all(Option::is_some);
    let sides = [0, 1].map(|n| {
        let axis = axes[n].as_ref()?;
        let (a, s) = (&axis.apex, axis.side.sign());
        let once = of_edges(a);
        let twice: Vec<[f64; 3]> = corners
            .clone()
            .map(|k| [axis.aa(&frame.p[k]), axis.ac(&frame.p[k]), frame.at_corner(k, a)])
            .collect();
        let turns = turns(&weights(axis), &once, &twice);
        let of_sector = |k: usize| {
            let next = frame.after(k);
            let layer1 = [axis.cc(a), twice[k][1], twice[next][1], twice[k][2], once[k], twice[next][2]];
            let layer2 = [axis.aa(c), twice[k][0], twice[next][0]];
            SectorSide {
                layer1: layer1.map(|f| s * f),
                turn: turns[k].map(|f| s * f),
                through: if both { base[k].turn.map(|f: f64| s * f) } else { [0.0; 2] },
                layer2: layer2.map(|f| s * f),
                layer3: s * axis.aa(a),
            }
        };
        Some(corners.clone().map(of_sector).collect())
    });
    Sectors { center: *c, base, sides }
}
