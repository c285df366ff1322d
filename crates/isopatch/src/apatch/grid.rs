//! Many points of a patch at once: the factors of the coefficients are tabulated for fixed parameters, and points are
//! computed in lanes that compilers turn into vector instructions.

use super::base::Base;
use super::build::APatchFunction;
use super::edge::{EdgeFunction, Rim};
use super::face::layer2;
use super::shoot::Shot;
use crate::bernstein::cubic;
use crate::geom::{Mat3, Point3, PointsMut, Vec3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// Points that are computed together.
const LANES: usize = 8;

/// One number for each of [`LANES`] points.
type Lane = [f64; LANES];

/// Steps of Newton's method in a lane.
const STEPS: usize = 4;

/// The last step relative to the root, below which the root has all its digits: errors are squared by a step.
const SETTLED: f64 = 3e-8;

#[inline(always)]
fn lane(f: impl FnMut(usize) -> f64) -> Lane {
    std::array::from_fn(f)
}

/// Roots s = t/(1 − t) of the cubics with the given layers. None unless all have the signs (−, +, +, +), or start at zero, and
/// have settled.
#[inline(always)]
fn roots(b: &[Lane; 4]) -> Option<Lane> {
    let mut s = lane(|i| cubic::start(&[b[0][i], b[1][i], b[2][i], b[3][i]]));
    let mut last = s;
    for _ in 0..STEPS {
        last = s;
        s = lane(|i| cubic::newton_step(&[b[0][i], b[1][i], b[2][i], b[3][i]], s[i]));
    }
    let mut good = true;
    for i in 0..LANES {
        good &= b[0][i] <= 0.0
            && b[1][i] > 0.0
            && b[2][i] >= 0.0
            && b[3][i] > 0.0
            && (last[i] - s[i]).abs() <= SETTLED * s[i];
    }
    good.then_some(s)
}

/// Where a lane of rays starts and ends, per coordinate.
struct Ends {
    base: [Lane; 3],
    top: [Lane; 3],
}

/// (q + s w)/(1 + s) as q + t (w − q), and t.
#[inline(always)]
fn points(ends: &Ends, s: &Lane) -> ([Lane; 3], Lane) {
    let t = lane(|i| s[i] / (1.0 + s[i]));
    let point = [0, 1, 2].map(|c| lane(|i| ends.base[c][i] + t[i] * (ends.top[c][i] - ends.base[c][i])));
    (point, t)
}

/// From derivatives by barycentric coordinates to unit normals.
struct Normals {
    inverse: Mat3,
    sign: f64,
}

impl Normals {
    fn new(side: Side, corners: &[Point3; 4]) -> Self {
        let edges = [1, 2, 3].map(|c| (corners[c] - corners[0]).transpose());
        let inverse = Mat3::from_rows(&edges).try_inverse();
        Self { inverse: inverse.unwrap_or_else(|| Mat3::repeat(f64::NAN)), sign: side.sign() }
    }

    #[inline(always)]
    fn of(&self, d: &[Lane; 4]) -> [Lane; 3] {
        let m = &self.inverse;
        let g = [0, 1, 2].map(|r| {
            lane(|i| {
                self.sign
                    * (m[(r, 0)] * (d[1][i] - d[0][i])
                        + m[(r, 1)] * (d[2][i] - d[0][i])
                        + m[(r, 2)] * (d[3][i] - d[0][i]))
            })
        });
        let length = lane(|i| (g[0][i] * g[0][i] + g[1][i] * g[1][i] + g[2][i] * g[2][i]).sqrt());
        g.map(|g| lane(|i| g[i] / length[i]))
    }
}

/// What a lane gives: points, and normals if they are wanted.
struct Found {
    points: [Lane; 3],
    normals: Option<[Lane; 3]>,
}

/// Where results go: slices of one length for points, and for normals if they are wanted.
#[derive(Debug)]
pub struct GridOut<'a> {
    /// Positions.
    pub points: PointsMut<'a>,
    /// Unit normals, outward.
    pub normals: Option<PointsMut<'a>>,
}

impl GridOut<'_> {
    fn put(&mut self, at: usize, used: usize, found: &Found) {
        let copy = |out: &mut PointsMut<'_>, from: &[Lane; 3]| {
            for (out, from) in [&mut *out.x, &mut *out.y, &mut *out.z].into_iter().zip(from) {
                out[at..at + used].copy_from_slice(&from[..used]);
            }
        };
        copy(&mut self.points, &found.points);
        if let (Some(out), Some(normals)) = (&mut self.normals, &found.normals) {
            copy(out, normals);
        }
    }

    /// One point that was found outside the lanes; NaN if there is none.
    fn put_shot(&mut self, at: usize, shot: Option<Shot>) {
        let set = |out: &mut PointsMut<'_>, v: Vec3| (out.x[at], out.y[at], out.z[at]) = (v.x, v.y, v.z);
        let nan = Vec3::repeat(f64::NAN);
        set(&mut self.points, shot.map_or(nan, |shot| shot.point));
        if let Some(out) = &mut self.normals {
            set(out, shot.map_or(nan, |shot| shot.gradient.normalize()));
        }
    }
}

/// Parameters of points over a face with the factors of its coefficients.
#[derive(Clone, Debug)]
pub struct FaceTable {
    points: Vec<[f64; 3]>,
    chunks: Vec<FaceChunk>,
}

/// Factors for a lane of points, rational and split: of the nine data of the base, and in its derivatives.
#[derive(Clone, Debug)]
struct FaceChunk {
    x: [Lane; 3],
    base: [[Lane; 9]; 2],
    base_d: [[[Lane; 9]; 3]; 2],
}

impl FaceTable {
    /// For points with the given barycentric coordinates.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let chunks = points.chunks(LANES).map(FaceChunk::new).collect();
        Self { points: points.to_vec(), chunks }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over a face, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &APatchFunction, f: FaceId, out: &mut GridOut<'_>) {
        let patch = FacePatch::new(function, f);
        for (n, chunk) in self.chunks.iter().enumerate() {
            let start = n * LANES;
            let used = LANES.min(self.len() - start);
            match patch.as_ref().and_then(|patch| patch.evaluate(chunk, out.normals.is_some())) {
                Some(found) => out.put(start, used, &found),
                None => (start..start + used)
                    .for_each(|i| out.put_shot(i, function.shoot_face(f, self.points[i]))),
            }
        }
    }
}

impl FaceChunk {
    fn new(points: &[[f64; 3]]) -> Self {
        let at = |i: usize| points[i.min(points.len() - 1)];
        let terms =
            [false, true].map(|split| std::array::from_fn::<_, LANES, _>(|i| Base::terms(at(i), split)));
        Self {
            x: [0, 1, 2].map(|c| lane(|i| at(i)[c])),
            base: [0, 1].map(|s: usize| std::array::from_fn(|n| lane(|i| terms[s][i].0[n]))),
            base_d: [0, 1].map(|s: usize| {
                [0, 1, 2].map(|c: usize| std::array::from_fn(|n| lane(|i| terms[s][i].1[c][n])))
            }),
        }
    }
}

/// A face with all that its points need, at hand.
struct FacePatch {
    corners: [Point3; 3],
    split: usize,
    data: [f64; 9],
    class: Class,
    sides: [Option<FacePatchSide>; 2],
}

struct FacePatchSide {
    sign: f64,
    apex: Point3,
    corner: [f64; 3],
    edge: [f64; 3],
    q: [f64; 3],
    b: f64,
    normals: Normals,
}

impl FacePatch {
    /// None for a zero convex face.
    fn new(function: &APatchFunction, f: FaceId) -> Option<Self> {
        let (hull, face) = (function.hull(), &function.faces()[f.index()]);
        let class = hull.faces()[f.index()].class;
        if class == Class::Zero {
            return None;
        }
        let sides = Side::BOTH.map(|side| {
            let cell = face.sides[side.index()]?;
            let corners = function.face_cell(f, side)?;
            Some(FacePatchSide {
                sign: side.sign(),
                apex: corners[3],
                corner: cell.layer1.corner,
                edge: cell.layer1.edge,
                q: cell.q,
                b: function.free()[f.index()][side.index()],
                normals: Normals::new(side, &corners),
            })
        });
        let split = usize::from(face.base.split);
        Some(Self { corners: hull.data().corners(f), split, data: face.base.data(), class, sides })
    }

    #[inline(always)]
    fn evaluate(&self, chunk: &FaceChunk, normals: bool) -> Option<Found> {
        let terms = &chunk.base[self.split];
        let base = lane(|i| (0..9).map(|n| self.data[n] * terms[n][i]).sum());
        let p = &self.corners;
        let x = &chunk.x;
        let q = [0, 1, 2].map(|c| lane(|i| x[0][i] * p[0][c] + x[1][i] * p[1][c] + x[2][i] * p[2][c]));
        let on = |side: &Option<FacePatchSide>, base: &Lane| {
            self.on_side(side.as_ref()?, chunk, base, &q, normals)
        };
        let above = base.iter().any(|f| *f > 0.0);
        let below = base.iter().any(|f| *f < 0.0);
        match self.class {
            Class::Positive => on(&self.sides[0], &base),
            Class::Negative => on(&self.sides[1], &base),
            _ if !above => on(&self.sides[0], &base),
            _ if !below => on(&self.sides[1], &base),
            // The surface goes through the face here: every point has its own side, and starts at zero on the other.
            _ => {
                let outer = on(&self.sides[0], &base.map(|f| f.min(0.0)))?;
                let inner = on(&self.sides[1], &base.map(|f| f.max(0.0)))?;
                Some(select(&base, outer, inner))
            }
        }
    }

    #[inline(always)]
    fn on_side(
        &self,
        side: &FacePatchSide,
        chunk: &FaceChunk,
        base: &Lane,
        q: &[Lane; 3],
        normals: bool,
    ) -> Option<Found> {
        let [x, y, z] = &chunk.x;
        let (u, v) = (&side.corner, &side.edge);
        let b0 = lane(|i| side.sign * base[i]);
        let b1 = lane(|i| {
            let corners = u[0] * x[i] * x[i] + u[1] * y[i] * y[i] + u[2] * z[i] * z[i];
            corners + 2.0 * (v[0] * x[i] * y[i] + v[1] * y[i] * z[i] + v[2] * z[i] * x[i])
        });
        let b2 = lane(|i| layer2(side.q[0] * x[i] + side.q[1] * y[i] + side.q[2] * z[i], side.b));
        let s = roots(&[b0, b1, b2, [side.b; LANES]])?;
        let top = [0, 1, 2].map(|c| [side.apex[c]; LANES]);
        let (points, t) = points(&Ends { base: *q, top }, &s);
        let normals = normals.then(|| {
            let r = lane(|i| 1.0 - t[i]);
            let derivative = |c: usize, own: &Lane, next: &Lane, previous: &Lane| {
                let terms = &chunk.base_d[self.split][c];
                let layer2_d = (side.b + 2.0 * side.q[c]) / 3.0;
                lane(|i| {
                    let d0: f64 = (0..9).map(|n| self.data[n] * terms[n][i]).sum();
                    let d1 = 2.0 * (u[c] * own[i] + v[c] * next[i] + v[(c + 2) % 3] * previous[i]);
                    side.sign * r[i] * r[i] * d0 + 3.0 * t[i] * (r[i] * d1 + t[i] * layer2_d)
                })
            };
            let towards_apex =
                lane(|i| 3.0 * (r[i] * r[i] * b1[i] + t[i] * (2.0 * r[i] * b2[i] + t[i] * side.b)));
            let d = [derivative(0, x, y, z), derivative(1, y, z, x), derivative(2, z, x, y), towards_apex];
            side.normals.of(&d)
        });
        Some(Found { points, normals })
    }
}

/// The outer result where the base is at most zero, the inner one elsewhere.
fn select(base: &Lane, outer: Found, inner: Found) -> Found {
    let pick = |a: [Lane; 3], b: [Lane; 3]| {
        [0, 1, 2].map(|c| lane(|i| if base[i] <= 0.0 { a[c][i] } else { b[c][i] }))
    };
    let normals = outer.normals.zip(inner.normals).map(|(a, b)| pick(a, b));
    Found { points: pick(outer.points, inner.points), normals }
}

/// Parameters of points over an edge: weights of its start and its end, and of the apex on the left.
#[derive(Clone, Debug)]
pub struct EdgeTable {
    points: Vec<[f64; 3]>,
    chunks: Vec<[Lane; 3]>,
}

impl EdgeTable {
    /// For points with the given weights (x, z, y): x + z = 1 along the edge, y at the apex of the left face.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let chunk = |points: &[[f64; 3]]| [0, 1, 2].map(|c| lane(|i| points[i.min(points.len() - 1)][c]));
        Self { points: points.to_vec(), chunks: points.chunks(LANES).map(chunk).collect() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over an edge that has a cell, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &APatchFunction, e: EdgeId, out: &mut GridOut<'_>) {
        let sides = Side::BOTH.map(|side| EdgePatchSide::new(function, e, side));
        let class = function.hull().edges()[e.index()].class;
        for (n, chunk) in self.chunks.iter().enumerate() {
            let start = n * LANES;
            let used = LANES.min(self.len() - start);
            match evaluate_edge(&sides, class, chunk, out.normals.is_some()) {
                Some(found) => out.put(start, used, &found),
                None => (start..start + used).for_each(|i| {
                    let [x, z, y] = self.points[i];
                    out.put_shot(i, function.shoot_edge(e, [x, z], y));
                }),
            }
        }
    }
}

struct EdgePatchSide {
    function: EdgeFunction,
    corners: [Point3; 4],
    normals: Normals,
}

fn evaluate_edge(
    sides: &[Option<EdgePatchSide>; 2],
    class: Class,
    chunk: &[Lane; 3],
    normals: bool,
) -> Option<Found> {
    let on = |side: Side| sides[side.index()].as_ref()?.evaluate(chunk, normals);
    match class {
        Class::Positive => on(Side::Outer),
        Class::Negative => on(Side::Inner),
        Class::Zero => None,
        Class::Nonconvex => {
            let [x, z, _] = chunk;
            let e = sides[0].as_ref()?.function.e;
            let base = lane(|i| Base::on_edge(e, x[i], z[i]));
            let above = base.iter().any(|f| *f > 0.0);
            match (above, base.iter().any(|f| *f <= 0.0)) {
                (false, _) => on(Side::Outer),
                (_, false) => on(Side::Inner),
                _ => Some(select(&base, on(Side::Outer)?, on(Side::Inner)?)),
            }
        }
    }
}

impl Rim {
    #[inline(always)]
    fn derivatives1(&self, x: f64, z: f64) -> [f64; 2] {
        let [f_i, f_ij, f_j] = self.layer1;
        [2.0 * (f_i * x + f_ij * z), 2.0 * (f_ij * x + f_j * z)]
    }
}

impl EdgePatchSide {
    fn new(function: &APatchFunction, e: EdgeId, side: Side) -> Option<Self> {
        let corners = function.edge_cell(e, side)?;
        let normals = Normals::new(side, &corners);
        Some(Self { function: function.edge_function(e, side)?, corners, normals })
    }

    #[inline(always)]
    fn evaluate(&self, [x, z, y]: &[Lane; 3], normals: bool) -> Option<Found> {
        let f = &self.function;
        let layers: [[f64; 4]; LANES] = std::array::from_fn(|i| f.layers(x[i], z[i], y[i]));
        // On the side that the surface does not reach here, rays start at zero.
        let b: [Lane; 4] =
            [0, 1, 2, 3].map(|n| lane(|i| if n == 0 { layers[i][0].min(0.0) } else { layers[i][n] }));
        if self.goes_behind(&layers) {
            return None;
        }
        let s = roots(&b)?;
        let [u_l, p_i, p_j, u_k] = &self.corners;
        let ends = Ends {
            base: [0, 1, 2].map(|c| lane(|i| x[i] * p_i[c] + z[i] * p_j[c])),
            top: [0, 1, 2].map(|c| lane(|i| y[i] * u_k[c] + (1.0 - y[i]) * u_l[c])),
        };
        let (points, t) = points(&ends, &s);
        let normals = normals.then(|| {
            let d: [[f64; 4]; LANES] = std::array::from_fn(|i| self.derivatives([x[i], z[i], y[i], t[i]]));
            self.normals.of(&[0, 1, 2, 3].map(|n| lane(|i| d[i][n])))
        });
        Some(Found { points, normals })
    }

    /// Is this a convex edge with points behind the base?
    fn goes_behind(&self, layers: &[[f64; 4]; LANES]) -> bool {
        let [e_0, e_1] = self.function.e;
        (e_0 > 0.0) == (e_1 > 0.0) && layers.iter().any(|b| b[0] > 0.0)
    }

    /// Derivatives by the barycentric coordinates of the cell at ray parameter t.
    #[inline(always)]
    fn derivatives(&self, [x, z, y, t]: [f64; 4]) -> [f64; 4] {
        let f = &self.function;
        let (r, w) = (1.0 - t, 1.0 - y);
        let [e_0, e_1] = f.e;
        let base = [3.0 * z * (2.0 * e_0 * x + e_1 * z), 3.0 * x * (e_0 * x + 2.0 * e_1 * z)];
        let (left1, right1) = (f.left.derivatives1(x, z), f.right.derivatives1(x, z));
        let along: [f64; 2] = std::array::from_fn(|v| {
            let second = y * y * layer2(f.left.q[v], f.left.b)
                + w * w * layer2(f.right.q[v], f.right.b)
                + 2.0 * y * w * (y * f.b[v] + w * f.a[v]);
            r * r * base[v] + 3.0 * t * (r * (y * left1[v] + w * right1[v]) + t * second)
        });
        let (b, a) = (f.b[0] * x + f.b[1] * z, f.a[0] * x + f.a[1] * z);
        let mean = w * a + y * b;
        let [f_1002, f_2001] = f.far;
        let first = [f.right.layer1(x, z), f.left.layer1(x, z)];
        let second = [f.right.layer2(x, z), f.left.layer2(x, z)];
        let to_right = second[0] * w + y * (mean + w * (a - mean));
        let to_left = second[1] * y + w * (mean + y * (b - mean));
        let third_right = w * w * f.right.b + y * y * f_1002 + 2.0 * w * y * f_2001;
        let third_left = y * y * f.left.b + 2.0 * y * w * f_1002 + w * w * f_2001;
        [
            3.0 * (r * r * first[0] + t * (2.0 * r * to_right + t * third_right)),
            along[0],
            along[1],
            3.0 * (r * r * first[1] + t * (2.0 * r * to_left + t * third_left)),
        ]
    }
}
