//! Points in pyramids.

use crate::apatch::grid::GridOut;
use crate::apatch::lanes::{self, LANES, Lane, Rays, Vectors, dot, far_root, pick, quadratic};
use crate::geom::Point3;
use crate::hull::{Class, Side};
use crate::hybrid::face::{FaceCells, Foot};
use crate::hybrid::function::HybridFunction;
use crate::hybrid::pyramid::{PyramidCell, inner_weights, middle_weights};
use crate::mesh::FaceId;

/// Points over the bases of pyramids.
#[derive(Clone, Debug)]
pub struct PyramidTable {
    points: Vec<[f64; 2]>,
    chunks: Vec<PyramidChunk>,
}

/// Factors for a lane of points: of the eight coefficients on the border of the base and the eight rational ones inside, of the eight on
/// the border of layer 1 and the four rational ones inside, each with derivatives by s and t.
#[derive(Clone, Debug)]
struct PyramidChunk {
    at: [Lane; 2],
    base: [Lane; 16],
    base_d: [[Lane; 16]; 2],
    first: [Lane; 12],
    first_d: [[Lane; 12]; 2],
}

/// Border coefficients of the base that are not zero, and of layer 1.
const BASE_BORDER: [[usize; 2]; 8] = [[0, 1], [0, 2], [1, 0], [2, 0], [3, 1], [3, 2], [1, 3], [2, 3]];
const FIRST_BORDER: [[usize; 2]; 8] = [[0, 0], [0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1], [2, 2]];

/// Value and derivatives at (s, t).
type Form = (f64, [f64; 2]);

/// A product of Bernstein polynomials of degree n.
fn tensor(n: usize, [j, k]: [usize; 2], [s, t]: [f64; 2]) -> Form {
    let choose = |i: usize| if i == 0 || i == n { 1.0 } else { n as f64 };
    let power = |x: f64, i: usize| x.powi(i as i32);
    let value = |i: usize, x: f64| choose(i) * power(x, i) * power(1.0 - x, n - i);
    let slope = |i: usize, x: f64| {
        let rising = if i > 0 { i as f64 * power(x, i - 1) * power(1.0 - x, n - i) } else { 0.0 };
        let falling = if i < n { (n - i) as f64 * power(x, i) * power(1.0 - x, n - i - 1) } else { 0.0 };
        choose(i) * (rising - falling)
    };
    (value(j, s) * value(k, t), [slope(j, s) * value(k, t), value(j, s) * slope(k, t)])
}

impl PyramidChunk {
    fn new(points: &[[f64; 3]]) -> Self {
        let lane = |f: &dyn Fn([f64; 2]) -> f64| Lane::new(points, |&[s, t, _]| f([s, t]));
        let base = |n: usize, [s, t]: [f64; 2]| -> Form {
            if n < 8 { tensor(3, BASE_BORDER[n], [s, t]) } else { inner_weights(s, t)[(n - 8) / 2][n % 2] }
        };
        let first = |n: usize, [s, t]: [f64; 2]| -> Form {
            if n < 8 { tensor(2, FIRST_BORDER[n], [s, t]) } else { middle_weights(s, t)[n - 8] }
        };
        Self {
            at: std::array::from_fn(|c| lane(&|x| x[c])),
            base: std::array::from_fn(|n| lane(&|x| base(n, x).0)),
            base_d: std::array::from_fn(|c| std::array::from_fn(|n| lane(&|x| base(n, x).1[c]))),
            first: std::array::from_fn(|n| lane(&|x| first(n, x).0)),
            first_d: std::array::from_fn(|c| std::array::from_fn(|n| lane(&|x| first(n, x).1[c]))),
        }
    }
}

impl PyramidTable {
    /// For points with the given (s, t).
    pub fn new(points: &[[f64; 2]]) -> Self {
        let padded: Vec<[f64; 3]> = points.iter().map(|[s, t]| [*s, *t, 0.0]).collect();
        Self { points: points.to_vec(), chunks: padded.chunks(LANES).map(PyramidChunk::new).collect() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over a face with a pyramid, and normals; NaN where a ray has no root, or without a pyramid.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &HybridFunction, f: FaceId, out: &mut GridOut<'_>) {
        let nan = Point3::repeat(f64::NAN);
        let complete = match &function.faces()[f.index()] {
            FaceCells::Pyramid(cell) => {
                lanes::shoot(Vectors::Widest, &PyramidPatch::new(cell), &self.chunks, self.len(), out)
            }
            _ => {
                (0..self.len()).for_each(|i| out.set(i, nan, nan));
                true
            }
        };
        if !complete {
            out.complete(self.len(), |i| {
                function.shoot_from(f, Foot::Pyramid(self.points[i]), [[0.0; 3]; 2])
            });
        }
    }
}

/// A pyramid with all that its points need.
struct PyramidPatch {
    class: Class,
    /// p_1 … p_4 of (2.6).
    corners: [[f64; 3]; 4],
    sign: f64,
    base: [f64; 16],
    sides: [Option<PyramidRay>; 2],
}

/// What its rays need.
struct PyramidRay {
    sign: [f64; 1],
    apex: [f64; 3],
    base: [f64; 16],
    first: [f64; 12],
    /// At (0, 0), (0, 1), (1, 0) and (1, 1).
    layer2: [f64; 4],
    layer3: [f64; 1],
}

impl PyramidPatch {
    fn new(cell: &PyramidCell) -> Self {
        let base = std::array::from_fn(|n| match n.checked_sub(8) {
            None => cell.base[BASE_BORDER[n][0]][BASE_BORDER[n][1]],
            Some(n) => cell.inner[n / 2][n % 2],
        });
        let first = std::array::from_fn(|n| match n.checked_sub(8) {
            None => cell.layer1[FIRST_BORDER[n][0]][FIRST_BORDER[n][1]],
            Some(n) => cell.middle[n],
        });
        let [[b00, b01], [b10, b11]] = cell.layer2;
        let ray = PyramidRay {
            sign: [cell.side.sign()],
            apex: cell.apex.into(),
            base,
            first,
            layer2: [b00, b01, b10, b11],
            layer3: [cell.layer3],
        };
        let (class, sides) = match cell.side {
            Side::Outer => (Class::Positive, [Some(ray), None]),
            Side::Inner => (Class::Negative, [None, Some(ray)]),
        };
        Self { class, corners: cell.corners.map(Into::into), sign: cell.side.sign(), base, sides }
    }

    /// The point of the base, and its derivatives by s and t.
    #[inline(always)]
    fn foot(&self, s: f64, t: f64) -> [[f64; 3]; 3] {
        let (r, q, p) = (1.0 - s, 1.0 - t, &self.corners);
        let mut found = [[0.0; 3]; 3];
        for c in 0..3 {
            let (upper, lower) = (s * p[0][c] + r * p[1][c], s * p[2][c] + r * p[3][c]);
            found[0][c] = t * upper + q * lower;
            found[1][c] = t * (p[0][c] - p[1][c]) + q * (p[2][c] - p[3][c]);
            found[2][c] = upper - lower;
        }
        found
    }
}

#[inline(always)]
fn bilinear([b00, b01, b10, b11]: [f64; 4], s: f64, t: f64) -> f64 {
    (1.0 - s) * ((1.0 - t) * b00 + t * b01) + s * ((1.0 - t) * b10 + t * b11)
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Rays for PyramidPatch {
    type Chunk = PyramidChunk;
    type Side = PyramidRay;

    fn class(&self) -> Class {
        self.class
    }

    fn sides(&self) -> &[Option<PyramidRay>; 2] {
        &self.sides
    }

    #[inline(always)]
    fn pick(first: bool, a: &PyramidRay, b: &PyramidRay) -> PyramidRay {
        PyramidRay {
            sign: pick(first, &a.sign, &b.sign),
            apex: pick(first, &a.apex, &b.apex),
            base: pick(first, &a.base, &b.base),
            first: pick(first, &a.first, &b.first),
            layer2: pick(first, &a.layer2, &b.layer2),
            layer3: pick(first, &a.layer3, &b.layer3),
        }
    }

    #[inline(always)]
    fn base(&self, chunk: &PyramidChunk, i: usize) -> f64 {
        self.sign * dot(&self.base, &chunk.base, i)
    }

    #[inline(always)]
    fn layers(&self, side: &PyramidRay, chunk: &PyramidChunk, base: f64, i: usize) -> [f64; 4] {
        let (s, t) = (chunk.at[0].0[i], chunk.at[1].0[i]);
        let (b1, b2) = (dot(&side.first, &chunk.first, i), bilinear(side.layer2, s, t));
        [side.sign[0] * base, b1, b2, side.layer3[0]]
    }

    #[inline(always)]
    fn root(layers: [f64; 4]) -> f64 {
        far_root(layers)
    }

    #[inline(always)]
    fn point(&self, side: &PyramidRay, chunk: &PyramidChunk, u: f64, i: usize) -> [f64; 3] {
        let [foot, ..] = self.foot(chunk.at[0].0[i], chunk.at[1].0[i]);
        let mut point = [0.0; 3];
        for c in 0..3 {
            point[c] = foot[c] + u * (side.apex[c] - foot[c]);
        }
        point
    }

    #[inline(always)]
    fn gradient(&self, side: &PyramidRay, chunk: &PyramidChunk, u: f64, i: usize) -> [f64; 3] {
        let (s, t) = (chunk.at[0].0[i], chunk.at[1].0[i]);
        let r = 1.0 - u;
        let [b00, b01, b10, b11] = side.layer2;
        let (b0, b1) = (dot(&side.base, &chunk.base, i), dot(&side.first, &chunk.first, i));
        let b2 = bilinear(side.layer2, s, t);
        let along = 3.0 * quadratic(r, u, [b1 - b0, b2 - b1, side.layer3[0] - b2]);
        // By s and t with the factor 1 − u taken out, as in `PyramidCell::value`.
        let second = [(1.0 - t) * (b10 - b00) + t * (b11 - b01), (1.0 - s) * (b01 - b00) + s * (b11 - b10)];
        let by_s = quadratic(
            r,
            u,
            [
                dot(&side.base, &chunk.base_d[0], i),
                1.5 * dot(&side.first, &chunk.first_d[0], i),
                3.0 * second[0],
            ],
        );
        let by_t = quadratic(
            r,
            u,
            [
                dot(&side.base, &chunk.base_d[1], i),
                1.5 * dot(&side.first, &chunk.first_d[1], i),
                3.0 * second[1],
            ],
        );
        let [foot, x_s, x_t] = self.foot(s, t);
        let up = [side.apex[0] - foot[0], side.apex[1] - foot[1], side.apex[2] - foot[2]];
        let (a, b, c) = (cross(x_s, x_t), cross(x_t, up), cross(up, x_s));
        let volume = side.sign[0] / (up[0] * a[0] + up[1] * a[1] + up[2] * a[2]);
        [
            volume * (along * a[0] + by_s * b[0] + by_t * c[0]),
            volume * (along * a[1] + by_s * b[1] + by_t * c[1]),
            volume * (along * a[2] + by_s * b[2] + by_t * c[2]),
        ]
    }
}
