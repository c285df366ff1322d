//! Patches beside sharp edges.
//!
//! The zero set of the function over a face ends, over an edge without a cell, in a curve c in the plane of the edge and the apex;
//! over the two sides of a crease these are two curves. Both faces are pulled to the one curve C of the crease
//! ([`CreaseCurve`]):
//!
//! X̃(x) = X(x) + Σ w_k(x) (C_k(s_k) − c_k(s_k)),  s_k = x_b / (x_a + x_b),  w_k = D_k / (D_0 + D_1 + D_2),  D_k = (L_k x_a x_b)²,
//!
//! summed over the creases k = ab of the face; L_k are the lengths of its edges. The weight w_k is 1 on edge k and 0 on the others,
//! with zero gradient on all three, so that positions and tangent planes at the other edges stay as they are. C and c both start
//! in the tangent plane of the corner, and that plane stays the limit: near corner a, with x = L_k x_b and y = L_m x_m, the
//! correction is (C′ − c′) x³/(x² + y²)/L_k up to terms of order 2. Where C and c coincide nothing changes.

use super::base::Base;
use super::build::APatchFunction;
use super::edge::Rim;
use super::shoot::{root, side_of};
use crate::bernstein::restrict::over_interval;
use crate::geom::{Aabb, Point3, Vec3};
use crate::hull::{Class, CreaseCurve, Side};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};
use crate::surface::Sample;

/// How many creases there are, by what is needed for the faces to meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CreaseCounts {
    /// Both faces end in the edge itself.
    pub straight: usize,
    /// The faces are pulled to a curve.
    pub curved: usize,
}

/// The patch over a face with a sharp edge.
#[derive(Clone, Copy, Debug)]
pub struct CreasedFace<'a> {
    function: &'a APatchFunction,
    face: FaceId,
    corners: [Point3; 3],
    /// L_k squared.
    lengths: [f64; 3],
    rims: [Option<CreasedRim<'a>>; 3],
}

/// An edge k = ab of a face that is a crease.
#[derive(Clone, Copy, Debug)]
struct CreasedRim<'a> {
    function: &'a APatchFunction,
    h: HalfEdgeId,
    curve: CreaseCurve,
    /// Does the curve run from b to a?
    reversed: bool,
    /// Does the zero set over the face end in the curve by itself?
    exact: bool,
}

impl APatchFunction {
    /// The patch over a face that has sharp edges; none for other faces.
    pub fn creased_face(&self, face: FaceId) -> Option<CreasedFace<'_>> {
        let (data, mesh) = (self.hull().data(), self.hull().data().mesh());
        let half_edge = |k: usize| HalfEdgeId(3 * face.0 + k as u32);
        if !(0..3).any(|k| data.is_crease(mesh.edge(half_edge(k)))) {
            return None;
        }
        let corners = data.corners(face);
        let lengths = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).norm_squared());
        let rims = [0, 1, 2].map(|k| CreasedRim::new(self, half_edge(k)));
        Some(CreasedFace { function: self, face, corners, lengths, rims })
    }

    /// The curve over a sharp edge, and whether both faces end in it by themselves.
    fn crease_is_exact(&self, e: EdgeId) -> Option<bool> {
        let pair = self.hull().data().pair(e)?;
        let [left, right] = pair.map(|h| CreasedRim::new(self, h).map(|rim| rim.exact));
        Some(left? && right?)
    }

    /// Counts the creases.
    pub fn crease_counts(&self) -> CreaseCounts {
        let mut counts = CreaseCounts::default();
        for exact in self.hull().data().mesh().edges().filter_map(|e| self.crease_is_exact(e)) {
            *if exact { &mut counts.straight } else { &mut counts.curved } += 1;
        }
        counts
    }
}

impl<'a> CreasedRim<'a> {
    fn new(function: &'a APatchFunction, h: HalfEdgeId) -> Option<Self> {
        let mesh = function.hull().data().mesh();
        let e = mesh.edge(h);
        let curve = function.hull().data().crease_curve(e)?;
        let [a, b] = Self::ends(function, h);
        let exact = curve.is_straight
            && function.faces()[mesh.face(h).index()].base.e[a][b] == 0.0
            && function.faces()[mesh.face(h).index()].base.e[b][a] == 0.0;
        Some(Self { function, h, curve, reversed: mesh.edge_half_edge(e) != h, exact })
    }

    fn ends(function: &APatchFunction, h: HalfEdgeId) -> [usize; 2] {
        let a = function.hull().data().mesh().side(h);
        [a, (a + 1) % 3]
    }

    /// Point of the curve and its derivative by z, where x and z are the weights of a and b.
    fn curve(&self, x: f64, z: f64) -> (Point3, Vec3) {
        if self.reversed {
            (self.curve.point(z, x), -self.curve.derivative(z, x))
        } else {
            (self.curve.point(x, z), self.curve.derivative(x, z))
        }
    }

    /// A box around the curve between two weights of b.
    fn curve_bounds(&self, [lo, hi]: [f64; 2]) -> Aabb {
        if self.curve.is_straight {
            return Aabb::around(&[self.curve(1.0 - lo, lo).0, self.curve(1.0 - hi, hi).0]);
        }
        let between = if self.reversed { [1.0 - hi, 1.0 - lo] } else { [lo, hi] };
        Aabb::around(&over_interval(self.curve.net, between))
    }

    /// Where the zero set ends over the edge, and the derivative by z; None if there is no root.
    fn rim(&self, x: f64, z: f64) -> Option<(Point3, Vec3)> {
        let (function, hull) = (self.function, self.function.hull());
        let f = hull.data().mesh().face(self.h);
        let [a, b] = Self::ends(function, self.h);
        let corners = hull.data().corners(f);
        let (q, edge) = (x * corners[a] + z * corners[b], corners[b] - corners[a]);
        let face = &function.faces()[f.index()];
        let e = [face.base.e[a][b], face.base.e[b][a]];
        let class = hull.faces()[f.index()].class;
        if class == Class::Zero {
            return Some((q, edge));
        }
        let value = Base::on_edge(e, x, z);
        let side = side_of(class, value);
        let cell = face.sides[side.index()].as_ref()?;
        let apex = hull.faces()[f.index()].apexes[side.index()]?;
        let rim = cell.flank(a, false, function.free()[f.index()][side.index()]).rim;
        rim_point(&rim, class, side, e, [corners[a], corners[b]], &apex, [x, z])
    }
}

/// Where the zero set over an edge from a to b ends, and the derivative by z; None if there is no root.
///
/// `rim` and the apex are those of a cell beside the edge, and e the coefficients on the edge; x and z are the weights of a and b.
pub(crate) fn rim_point(
    rim: &Rim,
    class: Class,
    side: Side,
    e: [f64; 2],
    [a, b]: [Point3; 2],
    apex: &Point3,
    [x, z]: [f64; 2],
) -> Option<(Point3, Vec3)> {
    let (q, edge) = (x * a + z * b, b - a);
    let layers = [side.sign() * Base::on_edge(e, x, z), rim.layer1(x, z), rim.layer2(x, z), rim.b];
    let t = root(class, &layers)?;
    // The layers' derivatives by z, with x = 1 − z.
    let [f_i, f_ij, f_j] = rim.layer1;
    let moved = [
        side.sign() * 3.0 * ((x - z) * (e[0] * x + e[1] * z) + x * z * (e[1] - e[0])),
        2.0 * ((f_ij - f_i) * x + (f_j - f_ij) * z),
        2.0 / 3.0 * (rim.q[1] - rim.q[0]),
        0.0,
    ];
    let r = 1.0 - t;
    let d_z = cubic_form(moved, r, t);
    let d_t = 3.0
        * (r * r * (layers[1] - layers[0])
            + 2.0 * r * t * (layers[2] - layers[1])
            + t * t * (layers[3] - layers[2]));
    let along = apex - q;
    Some((q + t * along, r * edge - d_z / d_t * along))
}

/// The box of a point of one box less one of another.
pub(crate) fn difference(to: &Aabb, from: &Aabb) -> Aabb {
    Aabb { min: to.min - from.max, max: to.max - from.min }
}

/// The box of the points of a box times a weight between two weights ≥ 0.
pub(crate) fn weighted(b: &Aabb, [least, most]: [f64; 2]) -> Aabb {
    Aabb::around(&[least * b.min, most * b.min, least * b.max, most * b.max])
}

fn cubic_form(b: [f64; 4], r: f64, t: f64) -> f64 {
    r * r * r * b[0] + 3.0 * r * t * (r * b[1] + t * b[2]) + t * t * t * b[3]
}

impl CreasedFace<'_> {
    /// Point, unit normal, and derivatives by the first two of the barycentric coordinates x. None if a ray has no root.
    ///
    /// On a crease the point is the same bits from both sides. At a corner the normal is that of its gradient, which is the limit.
    pub fn sample(&self, x: [f64; 3]) -> Option<Sample> {
        let shot = self.function.shoot_face(self.face, x)?;
        let plain = Sample { point: shot.point, normal: shot.gradient.normalize(), du: shot.du, dv: shot.dv };
        let on = |k: usize| x[(k + 2) % 3] == 0.0;
        let crosses = |k: &usize| self.rims[*k].as_ref().is_some_and(|rim| !rim.exact);
        let corner = x.iter().filter(|x| **x == 0.0).count() > 1;
        let at_edge = (0..3).find(|k| on(*k));
        // Only its own weight is not zero on an edge.
        let unchanged = at_edge.map_or_else(|| !(0..3).any(|k| crosses(&k)), |k| !crosses(&k));
        if corner || unchanged {
            return Some(plain);
        }
        let (weights, gradients) = self.weights(x);
        let (mut point, mut d) = (shot.point, [Vec3::zeros(); 3]);
        for k in (0..3).filter(crosses).filter(|k| at_edge.is_none_or(|edge| edge == *k)) {
            let rim = self.rims[k].as_ref()?;
            let (a, b) = (k, (k + 1) % 3);
            let sum = x[a] + x[b];
            let (r, s) = (x[a] / sum, x[b] / sum);
            let ((to, to_d), (from, from_d)) = (rim.curve(r, s), rim.rim(r, s)?);
            let (delta, delta_d) = (to - from, weights[k] * (to_d - from_d));
            point += weights[k] * delta;
            (0..3).for_each(|c| d[c] += gradients[k][c] * delta);
            d[a] -= s / sum * delta_d;
            d[b] += r / sum * delta_d;
            if on(k) {
                point = rim.curve(x[a], x[b]).0;
            }
        }
        let (du, dv) = (shot.du + d[0] - d[2], shot.dv + d[1] - d[2]);
        Some(Sample { point, normal: du.cross(&dv).normalize(), du, dv })
    }

    /// The three weights and their derivatives by the coordinates.
    fn weights(&self, x: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let mut squares = [0.0; 3];
        let mut squares_d = [[0.0; 3]; 3];
        for k in 0..3 {
            let (a, b) = (k, (k + 1) % 3);
            let scaled = self.lengths[k] * x[a] * x[b];
            squares[k] = scaled * x[a] * x[b];
            squares_d[k][a] = 2.0 * scaled * x[b];
            squares_d[k][b] = 2.0 * scaled * x[a];
        }
        let sum: f64 = squares.iter().sum();
        let sum_d = [0, 1, 2].map(|c| squares_d[0][c] + squares_d[1][c] + squares_d[2][c]);
        let weights = squares.map(|square| square / sum);
        let gradient = |k: usize| [0, 1, 2].map(|c| (squares_d[k][c] - weights[k] * sum_d[c]) / sum);
        (weights, [0, 1, 2].map(gradient))
    }

    /// A box around what the creases add to any point of the patch: around zero.
    pub(super) fn corrections(&self) -> Aabb {
        let hull = self.function.hull();
        let apexes = hull.faces()[self.face.index()].apexes;
        let mut bounds = Aabb::around(&[Vec3::zeros()]);
        for (k, rim) in self.rims.iter().enumerate().filter_map(|(k, rim)| Some((k, rim.as_ref()?))) {
            if rim.exact {
                continue;
            }
            let ends = [self.corners[k], self.corners[(k + 1) % 3]];
            let from = apexes.iter().flatten().fold(Aabb::around(&ends), |b, apex| b.including(apex));
            let to = Aabb::around(&rim.curve.net);
            bounds = bounds.plus(&weighted(&difference(&to, &from), [0.0, 1.0]));
        }
        bounds
    }

    /// A box around what the creases add to the points over the triangle with the given barycentric corners.
    ///
    /// For each crease, bounds of w_k times the box of C_k less the box of c_k, both over the range of s_k.
    pub(super) fn corrections_over(&self, corners: &[[f64; 3]; 3]) -> Aabb {
        let weights = self.weight_ranges(corners);
        let mut bounds = Aabb::around(&[Vec3::zeros()]);
        for (k, rim) in self.rims.iter().enumerate().filter_map(|(k, rim)| Some((k, rim.as_ref()?))) {
            // s_k is monotonic along lines, so that its bounds are at the corners; where it has no value, the weight is zero.
            let (a, b) = (k, (k + 1) % 3);
            let places = corners.iter().filter(|x| x[a] + x[b] > 0.0).map(|x| x[b] / (x[a] + x[b]));
            let [lo, hi] = places.fold([1.0f64, 0.0f64], |[lo, hi], s| [lo.min(s), hi.max(s)]);
            if rim.exact || lo > hi {
                continue;
            }
            let (lo, hi) = (lo.max(0.0), hi.min(1.0));
            let on_edge = [lo, hi, hi].map(|s| {
                let mut x = [0.0; 3];
                (x[a], x[b]) = (1.0 - s, s);
                x
            });
            let from = self.function.zero_set_bounds(self.face, on_edge);
            bounds = bounds.plus(&weighted(&difference(&rim.curve_bounds([lo, hi]), &from), weights[k]));
        }
        bounds
    }

    /// Bounds of the weights over the triangle with the given barycentric corners, from the bounds of the coordinates.
    fn weight_ranges(&self, corners: &[[f64; 3]; 3]) -> [[f64; 2]; 3] {
        let coordinate = |c: usize| {
            let all = corners.map(|x| x[c].max(0.0));
            [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(0.0, f64::max)]
        };
        let x = [0, 1, 2].map(coordinate);
        let squares = [0, 1, 2].map(|k| {
            let b = (k + 1) % 3;
            [0, 1].map(|end| self.lengths[k] * (x[k][end] * x[b][end]).powi(2))
        });
        [0, 1, 2].map(|k| {
            let others = [0, 1].map(|end| squares[(k + 1) % 3][end] + squares[(k + 2) % 3][end]);
            let share = |own: f64, others: f64, none: f64| {
                if own + others > 0.0 { own / (own + others) } else { none }
            };
            [share(squares[k][0], others[1], 0.0), share(squares[k][1], others[0], 1.0)]
        })
    }
}
