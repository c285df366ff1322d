//! Many points of a patch at once: the factors of the coefficients are tabulated for fixed parameters, and points are
//! computed in vector lanes.

use super::base::{Base, Terms};
use super::build::APatchFunction;
use super::edge::Rim;
use super::lanes::{Found, LANES, Lane, Normals, all, lane, points, quadratic, roots, select, signs, splat};
use super::shoot::Shot;
use crate::geom::{PointsMut, Vec3};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// Where results go: slices of one length for points, and for normals if they are wanted.
#[derive(Debug)]
pub struct GridOut<'a> {
    /// Positions.
    pub points: PointsMut<'a>,
    /// Unit normals, outward.
    pub normals: Option<PointsMut<'a>>,
}

impl GridOut<'_> {
    #[inline(always)]
    fn put(&mut self, at: usize, used: usize, found: &Found) {
        let copy = |out: &mut PointsMut<'_>, from: &[Lane; 3]| {
            for (out, from) in [&mut *out.x, &mut *out.y, &mut *out.z].into_iter().zip(from) {
                let from = from.to_array();
                // A copy of fixed length is two instructions, one of any length a call.
                match out[at..].first_chunk_mut::<LANES>() {
                    Some(out) if used == LANES => *out = from,
                    _ => out[at..at + used].copy_from_slice(&from[..used]),
                }
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
        let patch = FacePatch::new(function, f, out.normals.is_some());
        for (n, chunk) in self.chunks.iter().enumerate() {
            let start = n * LANES;
            let used = LANES.min(self.len() - start);
            match patch.as_ref().and_then(|patch| patch.evaluate(chunk)) {
                Some(found) => out.put(start, used, &found),
                None => (start..start + used)
                    .for_each(|i| out.put_shot(i, function.shoot_face(f, self.points[i]))),
            }
        }
    }
}

impl FaceChunk {
    fn new(points: &[[f64; 3]]) -> Self {
        let of = |split: bool, f: &dyn Fn(&Terms) -> f64| lane(points, |x| f(&Base::terms(x, split)));
        let both = [false, true];
        Self {
            x: std::array::from_fn(|c| lane(points, |x| x[c])),
            base: both.map(|split| std::array::from_fn(|n| of(split, &|terms| terms.0[n]))),
            base_d: both.map(|split| {
                std::array::from_fn(|c| std::array::from_fn(|n| of(split, &|terms| terms.1[c][n])))
            }),
        }
    }
}

/// A sum of products.
#[inline(always)]
fn dot<const N: usize>(a: &[Lane; N], b: &[Lane; N]) -> Lane {
    let mut sum = a[0] * b[0];
    for n in 1..N {
        sum += a[n] * b[n];
    }
    sum
}

/// A face with all that its points need, in lanes.
struct FacePatch {
    corners: [[Lane; 3]; 3],
    split: usize,
    data: [Lane; 9],
    class: Class,
    sides: [Option<FacePatchSide>; 2],
}

struct FacePatchSide {
    sign: Lane,
    apex: [Lane; 3],
    corner: [Lane; 3],
    /// Twice the coefficients.
    edge: [Lane; 3],
    /// 2/3 q, and b/3: layer 2 is their sum.
    q: [Lane; 3],
    third: Lane,
    b: Lane,
    /// If they are wanted.
    normals: Option<Normals>,
}

impl FacePatch {
    /// None for a zero convex face.
    fn new(function: &APatchFunction, f: FaceId, normals: bool) -> Option<Self> {
        let (hull, face) = (function.hull(), &function.faces()[f.index()]);
        let class = hull.faces()[f.index()].class;
        if class == Class::Zero {
            return None;
        }
        let sides = Side::BOTH.map(|side| {
            let cell = face.sides[side.index()]?;
            let corners = function.face_cell(f, side)?;
            let b = function.free()[f.index()][side.index()];
            Some(FacePatchSide {
                sign: all(side.sign()),
                apex: splat(&corners[3]),
                corner: cell.layer1.corner.map(all),
                edge: cell.layer1.edge.map(|f| all(2.0 * f)),
                q: cell.q.map(|q| all(2.0 / 3.0 * q)),
                third: all(b / 3.0),
                b: all(b),
                normals: normals.then(|| Normals::new(side, &corners)),
            })
        });
        let corners = hull.data().corners(f).map(|p| splat(&p));
        let data = face.base.data().map(all);
        Some(Self { corners, split: usize::from(face.base.split), data, class, sides })
    }

    #[inline(always)]
    fn evaluate(&self, chunk: &FaceChunk) -> Option<Found> {
        let base = dot(&self.data, &chunk.base[self.split]);
        let (p, x) = (&self.corners, &chunk.x);
        let q = std::array::from_fn(|c| x[0] * p[0][c] + x[1] * p[1][c] + x[2] * p[2][c]);
        let on = |side: Side, base: Lane| self.on_side(self.sides[side.index()].as_ref()?, chunk, base, q);
        match (self.class, signs(base)) {
            (Class::Positive, _) | (Class::Nonconvex, (false, _)) => on(Side::Outer, base),
            (Class::Negative, _) | (Class::Nonconvex, (_, false)) => on(Side::Inner, base),
            // The surface goes through the face here: every point has its own side, and starts at zero on the other.
            _ => {
                let outer = on(Side::Outer, base.min(all(0.0)))?;
                Some(select(base, outer, on(Side::Inner, base.max(all(0.0)))?))
            }
        }
    }

    #[inline(always)]
    fn on_side(&self, side: &FacePatchSide, chunk: &FaceChunk, base: Lane, q: [Lane; 3]) -> Option<Found> {
        let [x, y, z] = chunk.x;
        let squares = [x * x, y * y, z * z];
        let products = [x * y, y * z, z * x];
        let b1 = dot(&side.corner, &squares) + dot(&side.edge, &products);
        let b2 = side.third + dot(&side.q, &chunk.x);
        let s = roots(&[side.sign * base, b1, b2, side.b])?;
        let (points, t) = points(q, side.apex, s);
        let normals = side.normals.as_ref().map(|normals| {
            let r = all(1.0) - t;
            let (u, v) = (&side.corner, &side.edge);
            let derivative = |c: usize| {
                let (next, previous) = ((c + 1) % 3, (c + 2) % 3);
                let d0 = side.sign * dot(&self.data, &chunk.base_d[self.split][c]);
                let d1 =
                    all(2.0) * u[c] * chunk.x[c] + v[c] * chunk.x[next] + v[previous] * chunk.x[previous];
                quadratic(r, t, [d0, all(1.5) * d1, all(3.0) * (side.third + side.q[c])])
            };
            let towards_apex = all(3.0) * quadratic(r, t, [b1, b2, side.b]);
            normals.of([derivative(0), derivative(1), derivative(2), towards_apex])
        });
        Some(Found { points, normals })
    }
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
        let chunk = |points: &[[f64; 3]]| std::array::from_fn(|c| lane(points, |x| x[c]));
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
        let sides = Side::BOTH.map(|side| EdgePatchSide::new(function, e, side, out.normals.is_some()));
        let class = function.hull().edges()[e.index()].class;
        for (n, chunk) in self.chunks.iter().enumerate() {
            let start = n * LANES;
            let used = LANES.min(self.len() - start);
            match evaluate_edge(&sides, class, chunk) {
                Some(found) => out.put(start, used, &found),
                None => (start..start + used).for_each(|i| {
                    let [x, z, y] = self.points[i];
                    out.put_shot(i, function.shoot_edge(e, [x, z], y));
                }),
            }
        }
    }
}

#[inline(always)]
fn evaluate_edge(sides: &[Option<EdgePatchSide>; 2], class: Class, chunk: &[Lane; 3]) -> Option<Found> {
    let [outer, inner] = [&sides[0], &sides[1]];
    // Layer 0, with the sign of the side.
    let base = |side: &EdgePatchSide| all(3.0) * (chunk[0] * chunk[1]) * side.along(side.e, chunk);
    match class {
        Class::Zero => None,
        Class::Positive => outer.as_ref().and_then(|side| side.evaluate(chunk, base(side))),
        Class::Negative => inner.as_ref().and_then(|side| side.evaluate(chunk, base(side))),
        Class::Nonconvex => {
            let (outer, inner) = (outer.as_ref()?, inner.as_ref()?);
            let base = base(outer);
            match signs(base) {
                (false, _) => outer.evaluate(chunk, base),
                (_, false) => inner.evaluate(chunk, -base),
                _ => {
                    let below = outer.evaluate(chunk, base.min(all(0.0)))?;
                    Some(select(base, below, inner.evaluate(chunk, (-base).min(all(0.0)))?))
                }
            }
        }
    }
}

/// A [`Rim`] in lanes: layer 1, its middle twice, and layer 2 at both ends.
struct RimLanes {
    layer1: [Lane; 3],
    layer2: [Lane; 2],
    b: Lane,
}

impl RimLanes {
    fn new(rim: &Rim) -> Self {
        let [f_i, f_ij, f_j] = rim.layer1;
        Self {
            layer1: [f_i, 2.0 * f_ij, f_j].map(all),
            layer2: [all(rim.layer2(1.0, 0.0)), all(rim.layer2(0.0, 1.0))],
            b: all(rim.b),
        }
    }

    #[inline(always)]
    fn layer1(&self, [x, z, _]: &[Lane; 3]) -> Lane {
        self.layer1[0] * (*x * *x) + self.layer1[2] * (*z * *z) + self.layer1[1] * (*x * *z)
    }

    /// Half the derivatives of layer 1 by x and z.
    #[inline(always)]
    fn layer1_d(&self, [x, z, _]: &[Lane; 3]) -> [Lane; 2] {
        let [f_i, f_2ij, f_j] = self.layer1;
        let half = all(0.5) * f_2ij;
        [f_i * *x + half * *z, half * *x + f_j * *z]
    }
}

/// The function of an edge cell in lanes.
struct EdgePatchSide {
    corners: [[Lane; 3]; 4],
    e: [Lane; 2],
    left: RimLanes,
    right: RimLanes,
    b: [Lane; 2],
    a: [Lane; 2],
    far: [Lane; 2],
    /// If they are wanted.
    normals: Option<Normals>,
}

impl EdgePatchSide {
    fn new(function: &APatchFunction, e: EdgeId, side: Side, normals: bool) -> Option<Self> {
        let corners = function.edge_cell(e, side)?;
        let edge = function.edge_function(e, side)?;
        Some(Self {
            e: edge.e.map(all),
            left: RimLanes::new(&edge.left),
            right: RimLanes::new(&edge.right),
            b: edge.b.map(all),
            a: edge.a.map(all),
            far: edge.far.map(all),
            normals: normals.then(|| Normals::new(side, &corners)),
            corners: corners.map(|p| splat(&p)),
        })
    }

    #[inline(always)]
    fn along(&self, c: [Lane; 2], [x, z, _]: &[Lane; 3]) -> Lane {
        c[0] * *x + c[1] * *z
    }

    #[inline(always)]
    fn evaluate(&self, chunk: &[Lane; 3], base: Lane) -> Option<Found> {
        let [x, z, y] = *chunk;
        let w = all(1.0) - y;
        let (left1, right1) = (self.left.layer1(chunk), self.right.layer1(chunk));
        let (left2, right2) = (self.along(self.left.layer2, chunk), self.along(self.right.layer2, chunk));
        let (b, a) = (self.along(self.b, chunk), self.along(self.a, chunk));
        let mean = y * b + w * a;
        let [f_1002, f_2001] = self.far;
        let layers = [
            base,
            y * left1 + w * right1,
            quadratic(w, y, [right2, mean, left2]),
            w * quadratic(w, y, [self.right.b, f_2001, f_1002])
                + y * quadratic(w, y, [f_2001, f_1002, self.left.b]),
        ];
        let s = roots(&layers)?;
        let [u_l, p_i, p_j, u_k] = &self.corners;
        let q = std::array::from_fn(|c| x * p_i[c] + z * p_j[c]);
        let top = std::array::from_fn(|c| y * u_k[c] + w * u_l[c]);
        let (points, t) = points(q, top, s);
        let normals = self.normals.as_ref().map(|normals| {
            let r = all(1.0) - t;
            let (left_d, right_d) = (self.left.layer1_d(chunk), self.right.layer1_d(chunk));
            let ends = [x, z];
            let along = [0, 1].map(|v: usize| {
                // The derivative of layer 0 by x is 3 z (2 e_0 x + e_1 z), by z it is 3 x (e_0 x + 2 e_1 z).
                let base_d = ends[1 - v] * (all(2.0) * self.e[v] * ends[v] + self.e[1 - v] * ends[1 - v]);
                let second = [self.right.layer2[v], y * self.b[v] + w * self.a[v], self.left.layer2[v]];
                let d = [base_d, y * left_d[v] + w * right_d[v], quadratic(w, y, second)];
                all(3.0) * quadratic(r, t, d)
            });
            let to_right = w * right2 + y * (mean + w * (a - mean));
            let to_left = y * left2 + w * (mean + y * (b - mean));
            let third_right = quadratic(w, y, [self.right.b, f_2001, f_1002]);
            let third_left = quadratic(w, y, [f_2001, f_1002, self.left.b]);
            let across = [[right1, to_right, third_right], [left1, to_left, third_left]]
                .map(|layers| all(3.0) * quadratic(r, t, layers));
            normals.of([across[0], along[0], along[1], across[1]])
        });
        Some(Found { points, normals })
    }
}
