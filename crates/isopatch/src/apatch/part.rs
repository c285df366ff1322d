//! Boxes around parts of patches, by algebra: the layers over a part of the base are bounded by their Bernstein coefficients
//! there, and a smaller function reaches zero later on its ray.

use super::build::APatchFunction;
use super::{Base, EdgeFunction};
use crate::bernstein::restrict::{over_interval, over_triangle};
use crate::bernstein::{cubic, index};
use crate::geom::{Aabb, Interval, Point3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// Boxes are grown by this part of their cell, for the rounding of roots.
pub(crate) const MARGIN: f64 = 1e-10;

/// The range of some values.
pub(crate) fn hull_of<'a>(values: impl IntoIterator<Item = &'a f64>) -> Interval {
    let around = |range: Interval, x: &f64| Interval { lo: range.lo.min(*x), hi: range.hi.max(*x) };
    values.into_iter().fold(Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY }, around)
}

/// First and last place where a cubic with layers in the given ranges can become positive: the end of the ray where none does.
pub(crate) fn roots(layers: [Interval; 4]) -> [f64; 2] {
    let root = |layers: [f64; 4]| cubic::minimal_root(&layers).unwrap_or(1.0);
    [root(layers.map(|b| b.hi)), root(layers.map(|b| b.lo))]
}

/// The box around rays from the bases to the tops, between two parameters.
pub(crate) fn around_rays(bases: &[Point3], tops: &[Point3], between: [f64; 2]) -> Aabb {
    let ends = |t: f64| bases.iter().flat_map(move |q| tops.iter().map(move |w| q + t * (w - q)));
    between.into_iter().flat_map(ends).fold(Aabb::EMPTY, |b, p| b.including(&p))
}

/// Layer 0 where the surface is on this side: at most zero. None where it is on the other side everywhere.
pub(crate) fn on_side(class: Class, side: Side, base: Interval) -> Option<Interval> {
    let here = match class {
        Class::Zero => false,
        Class::Positive => side == Side::Outer,
        Class::Negative => side == Side::Inner,
        Class::Nonconvex => base.lo <= 0.0,
    };
    here.then_some(Interval { lo: base.lo.min(0.0), hi: base.hi.min(0.0) })
}

impl Base {
    /// A range that holds all values over the triangle with the given barycentric corners.
    pub(crate) fn range(&self, corners: &[[f64; 3]; 3]) -> Interval {
        if self.split { self.split_range(corners) } else { self.rational_range(corners) }
    }

    fn rational_range(&self, corners: &[[f64; 3]; 3]) -> Interval {
        let two_and_one = |ijk: [usize; 3]| {
            let at = |count: usize| ijk.iter().position(|i| *i == count);
            at(2).zip(at(1)).map_or(0.0, |(a, b)| self.e[a][b])
        };
        let net: Vec<f64> = index::indices(3).map(two_and_one).collect();
        // To that comes 6 x y z times a mean of the three middles.
        let product: Vec<f64> = index::indices(3).map(|ijk| f64::from(u8::from(ijk == [1; 3]))).collect();
        let [cubic, product] = [net, product].map(|net| hull_of(&over_triangle(3, &net, corners)));
        let middle = hull_of(&self.middle);
        let (least, most) = (product.lo.max(0.0), product.hi.max(0.0));
        Interval {
            lo: cubic.lo + (least * middle.lo).min(most * middle.lo),
            hi: cubic.hi + (least * middle.hi).max(most * middle.hi),
        }
    }

    /// Over a part that lies in several of the three cubics, the range of all of them.
    fn split_range(&self, corners: &[[f64; 3]; 3]) -> Interval {
        let (corner, inner, center) = self.split_net();
        let may_lie_in = |k: usize| {
            !(0..3).any(|j| {
                let below = |x: &[f64; 3]| (j < k && x[j] <= x[k]) || (j > k && x[j] < x[k]);
                corners.iter().all(below)
            })
        };
        let cubics = (0..3).filter(|k| may_lie_in(*k)).map(|k| {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            // Indices of corners a and b and of the centroid.
            let net: Vec<f64> = index::indices(3)
                .map(|ijk| match ijk {
                    [2, 1, 0] => self.e[a][b],
                    [1, 2, 0] => self.e[b][a],
                    [2, 0, 1] => corner[a],
                    [1, 1, 1] => self.middle[a],
                    [0, 2, 1] => corner[b],
                    [1, 0, 2] => inner[a],
                    [0, 1, 2] => inner[b],
                    [0, 0, 3] => center,
                    _ => 0.0,
                })
                .collect();
            hull_of(&over_triangle(3, &net, &corners.map(|x| [x[a] - x[k], x[b] - x[k], 3.0 * x[k]])))
        });
        cubics.fold(hull_of(&[]), |all, r| Interval { lo: all.lo.min(r.lo), hi: all.hi.max(r.hi) })
    }
}

impl EdgeFunction {
    /// Ranges of the layers where the weight of the end is in `along`, and that of the left apex in `across`.
    pub(crate) fn ranges(&self, along: [f64; 2], across: [f64; 2]) -> [Interval; 4] {
        let base = over_interval([0.0, self.e[0], self.e[1], 0.0], along);
        let [left1, right1] = [&self.left, &self.right].map(|rim| over_interval(rim.layer1, along));
        let layer1 = across.map(|y| [0, 1, 2].map(|i| y * left1[i] + (1.0 - y) * right1[i]));
        // Layer 2 is linear along the edge and cubic across it, raised from quadratic terms.
        let layer2 = along.map(|z| {
            let x = 1.0 - z;
            let [left, right] = [&self.left, &self.right].map(|rim| rim.layer2(x, z));
            let [b, a] = [self.b, self.a].map(|c| c[0] * x + c[1] * z);
            over_interval([right, (right + 2.0 * a) / 3.0, (left + 2.0 * b) / 3.0, left], across)
        });
        let [f_1002, f_2001] = self.far;
        let layer3 = over_interval([self.right.b, f_2001, f_1002, self.left.b], across);
        [hull_of(&base), hull_of(layer1.as_flattened()), hull_of(layer2.as_flattened()), hull_of(&layer3)]
    }
}

impl APatchFunction {
    /// A box around the patch over a face where the parameters are in a triangle; not for a convex face whose patch goes behind
    /// the face.
    pub(super) fn face_part_bounds(&self, f: FaceId, triangle: [[f64; 2]; 3]) -> Aabb {
        let corners = triangle.map(|[u, v]| [u, v, 1.0 - u - v]);
        let zero_set = self.zero_set_bounds(f, corners);
        self.creased_face(f).map_or(zero_set, |face| zero_set.plus(&face.corrections_over(&corners)))
    }

    /// A box around the zero set over the triangle of a face that has the given barycentric corners: the patch where no crease
    /// pulls at it.
    pub(super) fn zero_set_bounds(&self, f: FaceId, corners: [[f64; 3]; 3]) -> Aabb {
        let (hull, face) = (self.hull(), &self.faces()[f.index()]);
        let [p, q, r] = hull.data().corners(f);
        let on_face = corners.map(|x| x[0] * p + x[1] * q + x[2] * r);
        let class = hull.faces()[f.index()].class;
        let whole = Aabb::around(&[p, q, r]);
        if class == Class::Zero {
            return Aabb::around(&on_face).grown(MARGIN * whole.diagonal());
        }
        let base = face.base.range(&corners);
        let mut bounds = Aabb::EMPTY;
        for side in Side::BOTH {
            let of_side = if side == Side::Outer { base } else { Interval { lo: -base.hi, hi: -base.lo } };
            let (Some(cell), Some(apex), Some(b0)) = (
                &face.sides[side.index()],
                hull.faces()[f.index()].apexes[side.index()],
                on_side(class, side, of_side),
            ) else {
                continue;
            };
            let quadratic: Vec<f64> = index::indices(2)
                .map(|ijk| match ijk {
                    [1, 1, 0] => cell.layer1.edge[0],
                    [0, 1, 1] => cell.layer1.edge[1],
                    [1, 0, 1] => cell.layer1.edge[2],
                    [2, _, _] => cell.layer1.corner[0],
                    [_, 2, _] => cell.layer1.corner[1],
                    _ => cell.layer1.corner[2],
                })
                .collect();
            let b3 = self.free()[f.index()][side.index()];
            let layer2 = corners.map(|x| cell.layers(x, b3)[1]);
            let b1 = hull_of(&over_triangle(2, &quadratic, &corners));
            let between = roots([b0, b1, hull_of(&layer2), hull_of(&[b3])]);
            let margin = MARGIN * whole.including(&apex).diagonal();
            bounds = bounds.union(&around_rays(&on_face, &[apex], between).grown(margin));
        }
        bounds
    }

    /// A box around the patch over an edge where the parameters are in a triangle.
    pub(super) fn edge_part_bounds(&self, e: EdgeId, triangle: [[f64; 2]; 3]) -> Aabb {
        let class = self.hull().edges()[e.index()].class;
        let [along, across] = [0, 1].map(|c| hull_of(triangle.iter().map(|uv| &uv[c]))).map(|r| [r.lo, r.hi]);
        let mut bounds = Aabb::EMPTY;
        for side in Side::BOTH {
            let (Some(edge), Some([u_l, p_i, p_j, u_k])) =
                (self.edge_function(e, side), self.edge_cell(e, side))
            else {
                continue;
            };
            let mut layers = edge.ranges(along, across);
            let Some(b0) = on_side(class, side, layers[0]) else { continue };
            layers[0] = b0;
            let bases = along.map(|z| (1.0 - z) * p_i + z * p_j);
            let tops = across.map(|y| (1.0 - y) * u_l + y * u_k);
            let margin = MARGIN * Aabb::around(&[u_l, p_i, p_j, u_k]).diagonal();
            bounds = bounds.union(&around_rays(&bases, &tops, roots(layers)).grown(margin));
        }
        bounds
    }
}
