use super::GridOut;
use crate::apatch::base::{Base, Terms};
use crate::apatch::build::APatchFunction;
use crate::apatch::face::FaceFunction;
use crate::apatch::lanes::{self, LANES, Lane, Rays, Vectors, dot, pick, product, quadratic, to_gradient};
use crate::geom::Point3;
use crate::hull::{Class, Side};
use crate::mesh::FaceId;

/// Parameters of points over a face with the factors of its coefficients.
#[derive(Clone, Debug)]
pub struct FaceTable {
    points: Vec<[f64; 3]>,
    vectors: Vectors,
    /// For rational and for split faces.
    chunks: [Vec<FaceChunk>; 2],
}

/// The cells of a face with the function in them.
#[derive(Clone, Copy, Debug)]
pub struct FaceCells<'a> {
    /// How the surface bends over the face; not zero convex.
    pub class: Class,
    /// Its corners.
    pub corners: [Point3; 3],
    /// The outer and the inner apex.
    pub apexes: [Option<Point3>; 2],
    /// The function.
    pub function: &'a FaceFunction,
    /// Its values at the apexes.
    pub free: [f64; 2],
}

/// Factors for a lane of points: of the nine data of the base, and in its derivatives.
#[derive(Clone, Debug)]
struct FaceChunk {
    x: [Lane; 3],
    base: [Lane; 9],
    base_d: [[Lane; 9]; 3],
}

impl FaceTable {
    /// For points with the given barycentric coordinates.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let chunks = [false, true]
            .map(|split| points.chunks(LANES).map(|points| FaceChunk::new(points, split)).collect());
        Self { points: points.to_vec(), vectors: Vectors::default(), chunks }
    }

    /// To be computed in the given vectors; the widest are the default.
    pub fn with_vectors(self, vectors: Vectors) -> Self {
        Self { vectors, ..self }
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
        if function.hull().faces()[f.index()].class == Class::Zero {
            return self.evaluate_flat(function, f, out);
        }
        if !self.evaluate_cells(&FaceCells::of(function, f), out) {
            out.complete(self.len(), |i| function.shoot_face(f, self.points[i]));
        }
    }

    /// The same over a face that is given by its cells. Points that take more than the lanes do are left NaN; says whether there
    /// are none.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate_cells(&self, cells: &FaceCells<'_>, out: &mut GridOut<'_>) -> bool {
        let patch = FacePatch::new(cells, out.normals.is_some());
        lanes::shoot(
            self.vectors,
            &patch,
            &self.chunks[usize::from(cells.function.base.split)],
            self.len(),
            out,
        )
    }

    /// A zero convex face is its own patch.
    fn evaluate_flat(&self, function: &APatchFunction, f: FaceId, out: &mut GridOut<'_>) {
        let p = function.hull().data().corners(f);
        let normal = function.hull().face_frame(f).normal.normalize();
        for (i, x) in self.points.iter().enumerate() {
            out.set(i, x[0] * p[0] + x[1] * p[1] + x[2] * p[2], normal);
        }
    }
}

impl FaceChunk {
    fn new(points: &[[f64; 3]], split: bool) -> Self {
        let terms: Vec<Terms> = points.iter().map(|x| Base::terms(*x, split)).collect();
        Self {
            x: std::array::from_fn(|c| Lane::new(points, |x| x[c])),
            base: std::array::from_fn(|n| Lane::new(&terms, |(value, _)| value[n])),
            base_d: std::array::from_fn(|c| std::array::from_fn(|n| Lane::new(&terms, |(_, d)| d[c][n]))),
        }
    }

    /// Barycentric coordinates of point i.
    #[inline(always)]
    fn at(&self, i: usize) -> [f64; 3] {
        [self.x[0].0[i], self.x[1].0[i], self.x[2].0[i]]
    }
}

/// A face with all that its points need.
struct FacePatch {
    corners: [[f64; 3]; 3],
    data: [f64; 9],
    class: Class,
    sides: [Option<FaceRay>; 2],
}

/// What the rays of one side need.
struct FaceRay {
    sign: [f64; 1],
    apex: [f64; 3],
    corner: [f64; 3],
    /// Twice the coefficients.
    edge: [f64; 3],
    /// 2/3 q, and b/3: layer 2 is their sum.
    q: [f64; 3],
    /// b/3 and b.
    b: [f64; 2],
    to_gradient: [f64; 12],
}

impl<'a> FaceCells<'a> {
    fn of(function: &'a APatchFunction, f: FaceId) -> Self {
        let face = &function.hull().faces()[f.index()];
        Self {
            class: face.class,
            corners: function.hull().data().corners(f),
            apexes: face.apexes,
            function: &function.faces()[f.index()],
            free: function.free()[f.index()],
        }
    }
}

impl FacePatch {
    fn new(cells: &FaceCells<'_>, normals: bool) -> Self {
        let FaceCells { class, corners, apexes, function: face, free } = *cells;
        let of_side = |side: Side| {
            let cell = face.sides[side.index()].as_ref()?;
            let apex = apexes[side.index()]?;
            let b = free[side.index()];
            let [p, q, r] = corners;
            Some(FaceRay {
                sign: [side.sign()],
                apex: apex.into(),
                corner: cell.layer1.corner,
                edge: cell.layer1.edge.map(|f| 2.0 * f),
                q: cell.q.map(|q| 2.0 / 3.0 * q),
                b: [b / 3.0, b],
                to_gradient: if normals { to_gradient(side, &[p, q, r, apex]) } else { [0.0; 12] },
            })
        };
        // Each made where it is to stand: a map over the sides would move them.
        let sides = [of_side(Side::Outer), of_side(Side::Inner)];
        Self { corners: corners.map(Into::into), data: face.base.data(), class, sides }
    }
}

impl FaceRay {
    /// Layers 1 and 2 over a point of the face.
    #[inline(always)]
    fn layers(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let (u, v, q) = (&self.corner, &self.edge, &self.q);
        let b1 = (u[0] * (x * x) + u[1] * (y * y) + u[2] * (z * z))
            + (v[0] * (x * y) + v[1] * (y * z) + v[2] * (z * x));
        [b1, self.b[0] + (q[0] * x + q[1] * y + q[2] * z)]
    }
}

impl FacePatch {
    /// The derivative at the root t of ray i by coordinate C of the base.
    ///
    /// A function with a constant, because a loop of this size would not be unrolled, and so not become vectors.
    #[inline(always)]
    fn derivative<const C: usize>(
        &self,
        side: &FaceRay,
        chunk: &FaceChunk,
        at: [f64; 3],
        t: f64,
        i: usize,
    ) -> f64 {
        let (next, previous) = ((C + 1) % 3, (C + 2) % 3);
        let FaceRay { sign: [sign], corner: u, edge: v, q, b: [third, _], .. } = side;
        let d0 = sign * dot(&self.data, &chunk.base_d[C], i);
        let d1 = 2.0 * u[C] * at[C] + v[C] * at[next] + v[previous] * at[previous];
        quadratic(1.0 - t, t, [d0, 1.5 * d1, 3.0 * (third + q[C])])
    }
}

impl Rays for FacePatch {
    type Chunk = FaceChunk;
    type Side = FaceRay;

    fn class(&self) -> Class {
        self.class
    }

    fn sides(&self) -> &[Option<FaceRay>; 2] {
        &self.sides
    }

    #[inline(always)]
    fn pick(first: bool, a: &FaceRay, b: &FaceRay) -> FaceRay {
        FaceRay {
            sign: pick(first, &a.sign, &b.sign),
            apex: pick(first, &a.apex, &b.apex),
            corner: pick(first, &a.corner, &b.corner),
            edge: pick(first, &a.edge, &b.edge),
            q: pick(first, &a.q, &b.q),
            b: pick(first, &a.b, &b.b),
            to_gradient: pick(first, &a.to_gradient, &b.to_gradient),
        }
    }

    #[inline(always)]
    fn base(&self, chunk: &FaceChunk, i: usize) -> f64 {
        dot(&self.data, &chunk.base, i)
    }

    #[inline(always)]
    fn layers(&self, side: &FaceRay, chunk: &FaceChunk, base: f64, i: usize) -> [f64; 4] {
        let [b1, b2] = side.layers(chunk.at(i));
        [side.sign[0] * base, b1, b2, side.b[1]]
    }

    #[inline(always)]
    fn point(&self, side: &FaceRay, chunk: &FaceChunk, t: f64, i: usize) -> [f64; 3] {
        let ([x, y, z], p) = (chunk.at(i), &self.corners);
        let mut point = [0.0; 3];
        for c in 0..3 {
            let on_face = x * p[0][c] + y * p[1][c] + z * p[2][c];
            point[c] = on_face + t * (side.apex[c] - on_face);
        }
        point
    }

    #[inline(always)]
    fn gradient(&self, side: &FaceRay, chunk: &FaceChunk, t: f64, i: usize) -> [f64; 3] {
        let at = chunk.at(i);
        let [b1, b2] = side.layers(at);
        let d = [
            self.derivative::<0>(side, chunk, at, t, i),
            self.derivative::<1>(side, chunk, at, t, i),
            self.derivative::<2>(side, chunk, at, t, i),
        ];
        let to_apex = 3.0 * quadratic(1.0 - t, t, [b1, b2, side.b[1]]);
        product(&side.to_gradient, [d[0], d[1], d[2], to_apex])
    }
}
