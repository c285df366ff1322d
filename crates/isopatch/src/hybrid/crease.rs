//! Patches beside sharp edges.
//!
//! As [`apatch`](crate::apatch) does it over triangles: where the zero set over a face ends in another curve than that of the crease
//! ([`CreaseCurve`]), it is pulled there. Over a polygon that concerns the sector [c p q] of the edge alone: with the weight
//! w = (L_pq pq)² / ((L_pq pq)² + (L_cp cp)² + (L_cq cq)²), which is 1 on the edge and 0 on the two other sides, each with zero
//! gradient, the surface stays C1 across these and its tangent planes at the corners stay.

use super::data::HermitePolygons;
use super::face::FaceCells;
use super::function::HybridFunction;
use crate::apatch::{CreaseCounts, difference, rim_point, side_of, weighted};
use crate::bernstein::restrict::over_interval;
use crate::geom::{Aabb, Point3, Vec3};
use crate::hull::{Class, CreaseCurve};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};

impl HermitePolygons {
    /// The curve over a sharp edge, in the direction of its half edge; none for other edges.
    pub fn crease_curve(&self, e: EdgeId) -> Option<CreaseCurve> {
        let mesh = self.mesh();
        let h = mesh.edge_half_edge(e);
        let g = mesh.twin(h).filter(|_| self.is_crease(e))?;
        let ends = [[h, mesh.next(g)], [mesh.next(h), g]];
        let at = [h, g].map(|h| self.position(h));
        Some(CreaseCurve::new(at, ends.map(|corners| corners.map(|h| self.gradient(h)))))
    }

    /// Does the zero set over the face of a half edge end in the curve of a crease by itself?
    pub fn ends_in_crease(&self, h: HalfEdgeId) -> bool {
        let straight = |curve: CreaseCurve| curve.is_straight && self.edge_class(h) == Class::Zero;
        self.crease_curve(self.mesh().edge(h)).is_none_or(straight)
    }
}

/// A sector of a face whose edge is a crease that the zero set is pulled to.
pub(super) struct CreasedSector<'a> {
    function: &'a HybridFunction,
    face: FaceId,
    k: usize,
    curve: CreaseCurve,
    /// Does the curve run from q to p?
    reversed: bool,
    /// c, p, q.
    corners: [Point3; 3],
}

/// Where on a sector a point is corrected: by `weight` times the way from the rim to the curve.
pub(super) struct Pull {
    /// What is added to the point.
    pub by: Vec3,
    /// Derivatives of that by (c, p, q).
    pub d: [Vec3; 3],
    /// The point, if it is on the crease: the same from both of its sides.
    pub exact: Option<Point3>,
}

impl HybridFunction {
    /// Counts the creases.
    pub fn crease_counts(&self) -> CreaseCounts {
        let (data, mut counts) = (&self.hull().data, CreaseCounts::default());
        let mesh = data.mesh();
        for e in mesh.edges().filter(|e| data.is_crease(*e)) {
            let h = mesh.edge_half_edge(e);
            let exact = [Some(h), mesh.twin(h)].into_iter().flatten().all(|h| data.ends_in_crease(h));
            *if exact { &mut counts.straight } else { &mut counts.curved } += 1;
        }
        counts
    }

    /// The curve over an edge that is a crease to which faces are pulled.
    pub(super) fn pulls(&self, f: FaceId, k: usize) -> Option<CreasedSector<'_>> {
        if self.curves.is_empty() {
            return None;
        }
        let data = &self.hull().data;
        let mesh = data.mesh();
        let h = mesh.face_half_edges(f).nth(k)?;
        let e = mesh.edge(h);
        let curve = *self.curves.get(&e)?;
        let center = match &self.faces()[f.index()] {
            FaceCells::Sectors(sectors) => sectors.center,
            FaceCells::Flat(center) => *center,
            // Only faces that end in the crease by themselves have other cells.
            FaceCells::Triangle { .. } | FaceCells::Pyramid(_) => return None,
        };
        let corners = [center, data.position(h), data.position(mesh.next(h))];
        let reversed = mesh.edge_half_edge(e) != h;
        Some(CreasedSector { function: self, face: f, k, curve, reversed, corners })
    }
}

impl CreasedSector<'_> {
    /// Point of the curve and its derivative by z, where x and z are the weights of p and q.
    fn curve(&self, x: f64, z: f64) -> (Point3, Vec3) {
        if self.reversed {
            (self.curve.point(z, x), -self.curve.derivative(z, x))
        } else {
            (self.curve.point(x, z), self.curve.derivative(x, z))
        }
    }

    /// Where the zero set ends over the edge, and the derivative by z; None if there is no root.
    fn rim(&self, x: f64, z: f64) -> Option<(Point3, Vec3)> {
        let face = &self.function.hull().faces[self.face.index()];
        let [_, p, q] = self.corners;
        let FaceCells::Sectors(sectors) = &self.function.faces()[self.face.index()] else {
            return Some((x * p + z * q, q - p));
        };
        let cells = &self.function.faces()[self.face.index()];
        let [.., ppq, pqq] = sectors.base.get(self.k)?.net;
        let class = cells.class(face.class);
        let side = side_of(class, crate::apatch::Base::on_edge([ppq, pqq], x, z));
        let apex = face.apexes[side.index()]?;
        let rim = cells.flank(self.function.corners(self.face), &apex, side, self.k)?.rim;
        rim_point(&rim, class, side, [ppq, pqq], [p, q], &apex, [x, z])
    }

    /// What is added at the point of the sector with coordinates (c, p, q).
    pub fn at(&self, x: [f64; 3]) -> Option<Pull> {
        let [c, p, q] = x;
        let nothing = Pull { by: Vec3::zeros(), d: [Vec3::zeros(); 3], exact: None };
        if p == 0.0 || q == 0.0 {
            return Some(nothing);
        }
        let sum = p + q;
        let (r, s) = (p / sum, q / sum);
        let ((to, to_d), (from, from_d)) = (self.curve(r, s), self.rim(r, s)?);
        let (weight, gradient) = self.weight(x);
        let (delta, delta_d) = (to - from, weight * (to_d - from_d));
        let mut d = gradient.map(|slope| slope * delta);
        d[1] -= s / sum * delta_d;
        d[2] += r / sum * delta_d;
        Some(Pull { by: weight * delta, d, exact: (c == 0.0).then_some(to) })
    }

    /// w and its derivatives.
    fn weight(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let mut squares = [0.0; 3];
        let mut slopes = [[0.0; 3]; 3];
        for (n, [a, b]) in [[1, 2], [0, 1], [2, 0]].into_iter().enumerate() {
            let scaled = (self.corners[a] - self.corners[b]).norm_squared() * x[a] * x[b];
            squares[n] = scaled * x[a] * x[b];
            slopes[n][a] = 2.0 * scaled * x[b];
            slopes[n][b] = 2.0 * scaled * x[a];
        }
        let sum: f64 = squares.iter().sum();
        let weight = squares[0] / sum;
        let d =
            [0, 1, 2].map(|c| (slopes[0][c] - weight * (slopes[0][c] + slopes[1][c] + slopes[2][c])) / sum);
        (weight, d)
    }

    /// A box around what is added over the triangle with the given corners, from one around the zero set over a part of the edge.
    pub fn bounds(&self, corners: &[[f64; 3]; 3], over_edge: impl Fn([[f64; 3]; 3]) -> Aabb) -> Aabb {
        // The place on the edge is monotonic along lines; where it has no value, the weight is zero.
        let places = corners.iter().filter(|x| x[1] + x[2] > 0.0).map(|x| x[2] / (x[1] + x[2]));
        let [lo, hi] = places.fold([1.0f64, 0.0f64], |[lo, hi], s| [lo.min(s), hi.max(s)]);
        if lo > hi {
            return Aabb::around(&[Vec3::zeros()]);
        }
        let (lo, hi) = (lo.max(0.0), hi.min(1.0));
        let from = over_edge([lo, hi, hi].map(|s| [0.0, 1.0 - s, s]));
        let between = if self.reversed { [1.0 - hi, 1.0 - lo] } else { [lo, hi] };
        let to = Aabb::around(&over_interval(self.curve.net, between));
        weighted(&difference(&to, &from), self.weight_range(corners))
    }

    /// Bounds of the weight, from those of the coordinates.
    fn weight_range(&self, corners: &[[f64; 3]; 3]) -> [f64; 2] {
        let range = |c: usize| {
            let all = corners.map(|x| x[c].max(0.0));
            [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(0.0, f64::max)]
        };
        let x = [0, 1, 2].map(range);
        let square = |a: usize, b: usize, end: usize| {
            (self.corners[a] - self.corners[b]).norm_squared() * (x[a][end] * x[b][end]).powi(2)
        };
        let others = |end: usize| square(0, 1, end) + square(2, 0, end);
        let share = |own: f64, others: f64, none: f64| {
            if own + others > 0.0 { own / (own + others) } else { none }
        };
        [share(square(1, 2, 0), others(1), 0.0), share(square(1, 2, 1), others(0), 1.0)]
    }
}
