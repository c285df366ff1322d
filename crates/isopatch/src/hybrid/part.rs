//! Boxes around parts of patches, by algebra: the layers over a part of the base are bounded by their Bernstein coefficients
//! there, and a smaller function reaches zero later on its ray.

use super::face::{FaceCells, Foot};
use super::function::HybridFunction;
use super::pyramid::PyramidCell;
use super::sectors::{SectorBase, SectorSide, Sectors};
use crate::apatch::part::{MARGIN, around_rays, hull_of, on_side, roots};
use crate::bernstein::restrict::{over_interval, over_triangle};
use crate::bernstein::{cubic, index};
use crate::geom::{Aabb, Interval, Point3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// A range that holds 0 and the products of a range of positive numbers with each of the values.
fn between_zero_and(values: [f64; 2], factor: Interval) -> Interval {
    let most = factor.hi.max(0.0);
    let products = values.map(|v| v * most);
    Interval { lo: products[0].min(products[1]).min(0.0), hi: products[0].max(products[1]).max(0.0) }
}

fn sum(a: Interval, b: Interval) -> Interval {
    Interval { lo: a.lo + b.lo, hi: a.hi + b.hi }
}

fn signed(side: Side, range: Interval) -> Interval {
    if side == Side::Outer { range } else { Interval { lo: -range.hi, hi: -range.lo } }
}

/// The factor of the middle coefficient of a net alone.
fn of_middle(n: usize, middle: [usize; 3], corners: &[[f64; 3]; 3]) -> Interval {
    let net: Vec<f64> = index::indices(n).map(|ijk| f64::from(u8::from(ijk == middle))).collect();
    hull_of(&over_triangle(n, &net, corners))
}

impl SectorBase {
    /// A range of the values over the triangle with the given coordinates (c, p, q).
    fn range(&self, corners: &[[f64; 3]; 3]) -> Interval {
        let [ccc, ccp, ccq, cpp, cpq, cqq, ppq, pqq] = self.net;
        let cubic = over_triangle(3, &[ccc, ccp, ccq, cpp, cpq, cqq, 0.0, ppq, pqq, 0.0], corners);
        // The weights of the corrections are not negative, and their sum is at most one.
        sum(hull_of(&cubic), between_zero_and(self.turn, of_middle(3, [1, 1, 1], corners)))
    }
}

impl SectorSide {
    /// Ranges of layers 1, 2 and 3.
    fn ranges(&self, corners: &[[f64; 3]; 3]) -> [Interval; 3] {
        let quadratic = hull_of(&over_triangle(2, &self.layer1, corners));
        let factor = of_middle(2, [0, 1, 1], corners);
        // 2γ(α + β) is at most a half.
        let corrections =
            sum(between_zero_and(self.turn, factor), between_zero_and(self.through.map(|d| 0.5 * d), factor));
        let layer2 = hull_of(&over_triangle(1, &self.layer2, corners));
        [sum(quadratic, corrections), layer2, hull_of(&[self.layer3])]
    }
}

/// The coefficients of a tensor product over a rectangle.
fn over_rectangle<const M: usize>(net: &[[f64; M]; M], s: [f64; 2], t: [f64; 2]) -> Interval {
    let rows = net.map(|row| over_interval(row, t));
    let columns: [[f64; M]; M] =
        std::array::from_fn(|k| over_interval(std::array::from_fn(|j| rows[j][k]), s));
    hull_of(columns.as_flattened())
}

impl PyramidCell {
    fn ranges(&self, s: [f64; 2], t: [f64; 2]) -> [Interval; 4] {
        // Rational coefficients are between their values, and basis functions are not negative.
        let with = |pick: fn(f64, f64) -> f64| {
            let (mut base, mut layer1) = (self.base, self.layer1);
            for (values, [j, k]) in self.inner.iter().zip([[2, 2], [1, 2], [2, 1], [1, 1]]) {
                base[j][k] = pick(values[0], values[1]);
            }
            layer1[1][1] = self.middle.into_iter().reduce(pick).unwrap_or(0.0);
            [over_rectangle(&base, s, t), over_rectangle(&layer1, s, t)]
        };
        let ([low0, low1], [high0, high1]) = (with(f64::min), with(f64::max));
        let layer2 = over_rectangle(&self.layer2, s, t);
        [
            Interval { lo: low0.lo, hi: high0.hi },
            Interval { lo: low1.lo, hi: high1.hi },
            layer2,
            hull_of(&[self.layer3]),
        ]
    }
}

/// The first and the last parameter of a root on rays with layers in the given ranges, on the side of a face with cells there
/// alone: before the base too, where layer 0 can be positive.
fn roots_with_dip(mut layers: [Interval; 4]) -> [f64; 2] {
    let mut first = 0.0;
    if layers[0].hi > 0.0 {
        let [b0, b1, b2, b3] = layers;
        let b0 = Interval::new(b0.lo.max(0.0), b0.hi);
        let three = Interval::point(3.0);
        // The cubic in −t, see `cubic::root_behind`.
        let (m1, m2) = (three * (b0 - b1), three * ((b2 - b1) + (b0 - b1)));
        let m3 = (b0 - b3) + three * (b2 - b1);
        let third = Interval::point(1.0 / 3.0);
        let mirrored = [b0, b0 + third * m1, b0 + third * (m1 + m1 + m2), b0 + m1 + m2 + m3];
        first = -cubic::minimal_root(&mirrored.map(|b| -b.hi)).unwrap_or(1.0);
    }
    let can_be_inside = layers[0].lo <= 0.0;
    layers[0] = Interval { lo: layers[0].lo.min(0.0), hi: layers[0].hi.min(0.0) };
    let [low, high] = roots(layers);
    [if first < 0.0 { first } else { low }, if can_be_inside { high } else { 0.0 }]
}

/// A part of the base of a face's cells.
enum Part {
    /// In the triangle, or in the sector k.
    Triangle(usize, [[f64; 3]; 3]),
    /// A rectangle of the base of a pyramid.
    Rectangle([f64; 2], [f64; 2]),
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
}

impl HybridFunction {
    /// The triangle of the parameter domain of a patch over a face, as parts in single sectors that cover it.
    fn parts(&self, f: FaceId, triangle: [[f64; 2]; 3]) -> Vec<Part> {
        let corners = self.corners(f);
        let feet = triangle.map(|uv| self.foot(f, uv).0);
        match (&self.faces()[f.index()], feet) {
            (FaceCells::Pyramid(_), [Foot::Pyramid(a), Foot::Pyramid(b), Foot::Pyramid(c)]) => {
                let of = |i: usize| range([a[i], b[i], c[i]].into_iter());
                vec![Part::Rectangle(of(0), of(1))]
            }
            (_, [Foot::Triangle(a), Foot::Triangle(b), Foot::Triangle(c)]) => {
                vec![Part::Triangle(0, [a, b, c])]
            }
            (FaceCells::Sectors(Sectors { center, .. }) | FaceCells::Flat(center), _)
                if corners.len() == 3 =>
            {
                let center = self.center_in_triangle(f, center);
                let barycentric = triangle.map(|[u, v]| [u, v, 1.0 - u - v]);
                clipped_to_sectors(barycentric, center)
            }
            _ => {
                let [low, high] = range(triangle.iter().map(|uv| uv[0]));
                let last = corners.len().saturating_sub(1);
                let [from, to] =
                    [low.floor() as usize, (high.ceil() as usize).saturating_sub(1)].map(|k| k.min(last));
                let [near, far] = range(triangle.iter().map(|uv| uv[1]));
                (from..=to.max(from))
                    .flat_map(|k| {
                        let w = [low, high].map(|u| (u - k as f64).clamp(0.0, 1.0));
                        let at = |w: f64, v: f64| [v, (1.0 - v) * (1.0 - w), (1.0 - v) * w];
                        let [a, b, c, d] = [at(w[0], near), at(w[0], far), at(w[1], far), at(w[1], near)];
                        [Part::Triangle(k, [a, b, c]), Part::Triangle(k, [a, c, d])]
                    })
                    .collect()
            }
        }
    }

    /// A box around the patch over a face where the parameters are in a triangle.
    pub fn face_part_bounds(&self, f: FaceId, triangle: [[f64; 2]; 3]) -> Aabb {
        let parts = self.parts(f, triangle);
        parts.iter().fold(Aabb::EMPTY, |bounds, part| bounds.union(&self.pulled_bounds_of(f, part)))
    }

    fn pulled_bounds_of(&self, f: FaceId, part: &Part) -> Aabb {
        let zero_set = self.bounds_of(f, part);
        let Part::Triangle(k, x) = part else { return zero_set };
        let Some(sector) = self.pulls(f, *k) else { return zero_set };
        zero_set.plus(&sector.bounds(x, |on_edge| self.bounds_of(f, &Part::Triangle(*k, on_edge))))
    }

    fn bounds_of(&self, f: FaceId, part: &Part) -> Aabb {
        let (cells, face, corners) =
            (&self.faces()[f.index()], &self.hull().faces[f.index()], self.corners(f));
        let feet: Vec<Foot> = match (part, cells) {
            (Part::Rectangle(s, t), _) => {
                s.iter().flat_map(|s| t.iter().map(|t| Foot::Pyramid([*s, *t]))).collect()
            }
            (Part::Triangle(_, x), FaceCells::Triangle { .. }) => x.map(Foot::Triangle).to_vec(),
            (Part::Triangle(k, x), _) => x.map(|x| Foot::Sector(*k, x)).to_vec(),
        };
        let points: Vec<Point3> =
            feet.iter().filter_map(|foot| Some(cells.point(corners, *foot)?.0)).collect();
        let size = Aabb::around(corners).diagonal();
        let mut bounds = Aabb::EMPTY;
        if let FaceCells::Flat(_) = cells {
            return Aabb::around(&points).grown(MARGIN * size);
        }
        for side in Side::BOTH {
            let (Some(apex), Some(mut layers)) = (face.apexes[side.index()], ranges(cells, side, part))
            else {
                continue;
            };
            let between = if Side::BOTH.into_iter().all(|side| cells.has(side)) {
                let Some(base) = on_side(Class::Nonconvex, side, layers[0]) else { continue };
                layers[0] = base;
                roots(layers)
            } else {
                roots_with_dip(layers)
            };
            bounds = bounds.union(
                &around_rays(&points, &[apex], between).grown(MARGIN * (size + (apex - face.center).norm())),
            );
        }
        bounds
    }

    /// A box around the patch over an edge where the parameters are in a triangle.
    pub fn edge_part_bounds(&self, e: EdgeId, triangle: [[f64; 2]; 3]) -> Aabb {
        let class = self.hull().edges[e.index()].class;
        let [along, across] = [0, 1].map(|c| range(triangle.iter().map(|uv| uv[c])));
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

/// Ranges of the layers on a side over a part; none without a cell there.
fn ranges(cells: &FaceCells, side: Side, part: &Part) -> Option<[Interval; 4]> {
    match (cells, part) {
        (FaceCells::Triangle { function, free }, Part::Triangle(_, x)) => {
            let cell = function.sides[side.index()].as_ref()?;
            let b3 = free[side.index()];
            let [c, e] = [cell.layer1.corner, cell.layer1.edge];
            let layer1 = over_triangle(2, &[c[0], e[0], e[2], c[1], e[1], c[2]], x);
            let layer2 = x.map(|x| cell.layers(x, b3)[1]);
            Some([signed(side, function.base.range(x)), hull_of(&layer1), hull_of(&layer2), hull_of(&[b3])])
        }
        (FaceCells::Pyramid(cell), Part::Rectangle(s, t)) => (cell.side == side).then(|| cell.ranges(*s, *t)),
        (FaceCells::Sectors(sectors), Part::Triangle(k, x)) => {
            let cell = sectors.sides[side.index()].as_ref()?.get(*k)?;
            let [b1, b2, b3] = cell.ranges(x);
            Some([signed(side, sectors.base.get(*k)?.range(x)), b1, b2, b3])
        }
        _ => None,
    }
}

/// The parts of a triangle, by barycentric coordinates, in the three sectors around a center, as triangles.
fn clipped_to_sectors(corners: [[f64; 3]; 3], center: [f64; 3]) -> Vec<Part> {
    let scaled = corners.map(|x| [0, 1, 2].map(|c| x[c] / center[c]));
    let mut parts = Vec::new();
    for third in 0..3 {
        // The sector is where the coordinate of the third corner is smallest.
        let mut polygon: Vec<[f64; 3]> = scaled.to_vec();
        for other in [(third + 1) % 3, (third + 2) % 3] {
            polygon = clipped(&polygon, |x| x[other] - x[third]);
        }
        let (p, q) = ((third + 1) % 3, (third + 2) % 3);
        let in_sector = |x: &[f64; 3]| {
            [x[third], (x[p] - x[third]).max(0.0) * center[p], (x[q] - x[third]).max(0.0) * center[q]]
        };
        let inside: Vec<[f64; 3]> = polygon.iter().map(in_sector).collect();
        parts.extend((2..inside.len()).map(|i| Part::Triangle(p, [inside[0], inside[i - 1], inside[i]])));
    }
    parts
}

/// The part of a polygon where a linear function is not negative.
fn clipped(polygon: &[[f64; 3]], height: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (height(a), height(b));
        if at_a >= 0.0 {
            kept.push(*a);
        }
        if (at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0) {
            let t = at_a / (at_a - at_b);
            kept.push(std::array::from_fn(|c| a[c] + t * (b[c] - a[c])));
        }
    }
    kept
}
