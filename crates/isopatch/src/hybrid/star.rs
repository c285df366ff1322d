//! K tetrahedra [a c p_s p_(s+1)] around the line from an apex a to a point c inside of the polygon, on one side or on both.
//!
//! The coefficients with two of a and c are those of functions affine in the third point, so that they fit around the axis by
//! themselves; all others are given by the data of the polygon. What the C1 conditions across [a c p_k] then lack for the
//! coefficients of (a, p, q) and (c, p, q) becomes a rational term: no condition on the data remains, for any number of corners.

use super::cells::{HybridFace, Jet};
use super::data::PolygonFrame;
use super::quadric::Quadric;
use super::sectors::{SectorBase, SectorSide, Sectors};
use super::tetra::barycentric;
use crate::geom::{Mat3, Point3, Vec3};
use crate::hull::Side;

/// The coefficients with two of a and c: functions of the third point.
#[derive(Clone, Copy)]
struct Axis<'a> {
    face: &'a HybridFace,
    side: Side,
    apex: Point3,
    /// What is added to the quadric, where there are cells on both sides.
    change: Option<Change>,
    /// What F(a, c, x) has beyond that per height of the apex, where there are none on the other side.
    rise: f64,
}

impl Axis<'_> {
    fn blossom(&self, x: &Point3, y: &Point3, z: &Point3) -> f64 {
        let change = self.change.as_ref().map_or(0.0, |change| change.blossom(x, y, z));
        self.face.quadric.blossom(x, y, z) + change
    }

    /// F(a, a, x).
    fn aa(&self, x: &Point3) -> f64 {
        match self.face.at_apex[self.side.index()] {
            Some(jet) => jet.towards(&self.apex, x),
            None => self.blossom(&self.apex, &self.apex, x),
        }
    }

    /// F(a, c, x).
    fn ac(&self, x: &Point3) -> f64 {
        let (c, n) = (&self.face.center, &self.face.normal);
        // Zero without a change, so that nothing is added to the quadric.
        let risen = if self.rise == 0.0 { 0.0 } else { self.rise * (x - c).dot(n) / (self.apex - c).dot(n) };
        self.blossom(&self.apex, c, x) + risen
    }

    /// F(c, c, x).
    fn cc(&self, x: &Point3) -> f64 {
        self.blossom(&self.face.center, &self.face.center, x)
    }
}

/// A cubic polynomial with given values and gradients at both apexes: along the axis it is the one of Hermite, across it is
/// linear, with a slope that is linear along the axis.
///
/// All coefficients with two points of the axis have to come from one polynomial if cells on both sides are to be C1 around the
/// axis and across the triangles [c p q] over polygons that are not plane. A quadric has not enough freedom for that.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// The inner apex, from which heights are measured, and the unit normal.
    bottom: Point3,
    normal: Vec3,
    /// From the inner to the outer apex.
    height: f64,
    /// Bernstein coefficients along the axis.
    along: [f64; 4],
    /// Slopes across, at the inner and the outer apex.
    across: [Vec3; 2],
}

impl Change {
    /// What the parameters at the apexes ask for beyond the quadric; none if they are all those of the quadric.
    fn new(face: &HybridFace, [u, v]: [&Point3; 2]) -> Option<Self> {
        if face.at_apex.iter().all(Option::is_none) {
            return None;
        }
        let beyond = |side: Side, at: &Point3| {
            let (value, gradient) = (face.quadric.value(at), face.quadric.gradient(at));
            let jet = face.at_apex[side.index()].unwrap_or(Jet { value, gradient });
            (jet.value - value, jet.gradient - gradient)
        };
        let (at_u, slope_u) = beyond(Side::Outer, u);
        let (at_v, slope_v) = beyond(Side::Inner, v);
        let (n, axis) = (face.normal, u - v);
        let flat = |slope: Vec3| slope - slope.dot(&n) * n;
        Some(Self {
            bottom: *v,
            normal: n,
            height: axis.dot(&n),
            along: [at_v, at_v + slope_v.dot(&axis) / 3.0, at_u - slope_u.dot(&axis) / 3.0, at_u],
            across: [flat(slope_v), flat(slope_u)],
        })
    }

    fn blossom(&self, x: &Point3, y: &Point3, z: &Point3) -> f64 {
        let points = [x, y, z];
        let heights = points.map(|p| (p - self.bottom).dot(&self.normal) / self.height);
        let mut along = self.along;
        for (step, t) in heights.iter().enumerate() {
            for i in 0..3 - step {
                along[i] += t * (along[i + 1] - along[i]);
            }
        }
        // The product of a linear function across and a linear slope is quadratic.
        let mut product = 0.0;
        for i in 0..3 {
            for j in (0..3).filter(|j| *j != i) {
                let slope = self.across[0] + heights[j] * (self.across[1] - self.across[0]);
                product += (points[i] - self.bottom).dot(&slope) / 6.0;
            }
        }
        along[0] + product
    }
}

/// The axes of both sides of a face, where it has apexes.
fn axes(face: &HybridFace) -> [Option<Axis<'_>>; 2] {
    let change = match &face.apexes {
        [Some(u), Some(v)] => Change::new(face, [u, v]),
        _ => None,
    };
    let both = face.apexes.iter().all(Option::is_some);
    Side::BOTH.map(|side| {
        let apex = face.apexes[side.index()]?;
        let (c, given) = (&face.center, face.at_apex[side.index()].filter(|_| !both));
        // F(a, c, ·) follows F(a, a, ·) to c.
        let rise = given.map_or(0.0, |jet| jet.towards(&apex, c) - face.quadric.blossom(&apex, &apex, c));
        Some(Axis { face, side, apex, change, rise })
    })
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

/// Equations that ask for no more than this part of what the others do are not heard, so that a polygon with many corners, whose
/// center hardly matters for its planes, does not make large numbers of small ones.
const LEAST_SHARE: f64 = 1e-4;

/// The quadric of a face with the linear function added that makes what the planes [a c p_k] lack of (c, p, q) least.
///
/// With it the coefficients around c are as exact as those of the edges. A quadric stays as it is. `trust` is the part of the linear
/// function that is added.
pub fn centered(frame: &PolygonFrame, face: &HybridFace, trust: f64) -> Quadric {
    let (c, n) = (&face.center, &face.normal);
    let first = n.cross(&Vec3::ith(n.iamin(), 1.0)).normalize();
    let second = n.cross(&first);
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for axis in axes(face).iter().flatten() {
        for k in 0..frame.count() {
            let (before, p) = (frame.before(k), &frame.p[k]);
            let [at_a, at_c, at_p, at_next] =
                barycentric([axis.apex, *c, *p, frame.p[frame.after(k)]], &frame.p[before]);
            let once = at_a * axis.ac(p) + at_c * axis.cc(p) + at_p * frame.at_corner(k, c);
            let lacking = frame.on_edge(before, c) - once - at_next * frame.on_edge(k, c);
            // A linear function's coefficient of (c, c, p) is its value a third of the way to p.
            let third = (p - c) / (3.0 * face.quadric.scale);
            let row = (at_a + at_c) / (1.0 + at_next * at_next).sqrt()
                * Vec3::new(1.0, third.dot(&first), third.dot(&second));
            matrix += row * row.transpose();
            right += lacking / (1.0 + at_next * at_next).sqrt() * row;
        }
    }
    matrix += LEAST_SHARE * Mat3::identity();
    let Some(found) = matrix.try_inverse().map(|inverse| trust * (inverse * right)) else {
        return face.quadric;
    };
    let slope = found.y * first + found.z * second;
    let from_center = (c - face.quadric.center) / face.quadric.scale;
    let mut quadric = face.quadric;
    quadric.coefficients[0] += found.x - slope.dot(&from_center);
    (0..3).for_each(|i| quadric.coefficients[1 + i] += slope[i]);
    quadric
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
