//! Many points of a patch at once, see [`apatch::grid`](crate::apatch::grid): factors of the coefficients are tabulated for fixed
//! parameters, and points are computed in vector lanes.

use super::face::{FaceCells, Foot, sector_of};
use super::function::HybridFunction;
use super::pyramid::{PyramidCell, inner_weights, middle_weights};
use super::sectors::{SectorBase, SectorSide, Sectors, Weights};
use crate::apatch::grid::{self, EdgeCells, EdgeTable, FaceTable, GridOut};
use crate::apatch::lanes::{self, Hit, LANES, Lane, Rays, dot, pick, product, quadratic, root, to_gradient};
use crate::geom::{Point3, Points};
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// Points over the sectors of a polygon, the same in each of them.
#[derive(Clone, Debug)]
pub struct SectorTable {
    points: Vec<[f64; 3]>,
    chunks: Vec<SectorChunk>,
}

/// Factors for a lane of points: of the eight coefficients and the two corrections of the base, and of the four corrections in
/// layer 1, each with derivatives by (c, p, q).
#[derive(Clone, Debug)]
struct SectorChunk {
    x: [Lane; 3],
    base: [Lane; 10],
    base_d: [[Lane; 10]; 3],
    turns: [Lane; 4],
    turns_d: [[Lane; 4]; 3],
}

impl SectorChunk {
    fn new(points: &[[f64; 3]]) -> Self {
        let lane = |f: &dyn Fn([f64; 3]) -> f64| Lane::new(points, f);
        let base = |n: usize| {
            let mut unit = SectorBase::default();
            if n < 8 {
                unit.net[n] = 1.0
            } else {
                unit.turn[n - 8] = 1.0
            }
            unit
        };
        let turn = |n: usize, x: [f64; 3]| {
            let weights = Weights::new(x);
            if n < 2 { weights.turn[n] } else { weights.through[n - 2] }
        };
        Self {
            x: std::array::from_fn(|c| lane(&|x| x[c])),
            base: std::array::from_fn(|n| lane(&|x| base(n).value(x).0)),
            base_d: std::array::from_fn(|c| std::array::from_fn(|n| lane(&|x| base(n).value(x).1[c]))),
            turns: std::array::from_fn(|n| lane(&|x| turn(n, x).0)),
            turns_d: std::array::from_fn(|c| std::array::from_fn(|n| lane(&|x| turn(n, x).1[c]))),
        }
    }
}

impl SectorTable {
    /// For points with the given weights of (c, p, q) in each sector.
    pub fn new(points: &[[f64; 3]]) -> Self {
        Self { points: points.to_vec(), chunks: points.chunks(LANES).map(SectorChunk::new).collect() }
    }

    /// Number of points in a sector.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over sector k of a face, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &HybridFunction, f: FaceId, k: usize, out: &mut GridOut<'_>) {
        let normals = out.normals.is_some();
        let sectors = match &function.faces()[f.index()] {
            FaceCells::Sectors(sectors) if function.pulls(f, k).is_none() => sectors,
            _ => return self.complete(function, f, k, out),
        };
        let patch = SectorPatch::new(function, f, sectors, k, normals);
        if !lanes::shoot(&patch, &self.chunks, self.len(), out) {
            out.complete(self.len(), |i| self.shoot(function, f, k, i));
        }
    }

    fn shoot(&self, function: &HybridFunction, f: FaceId, k: usize, i: usize) -> Option<crate::apatch::Shot> {
        function.shoot_from(f, Foot::Sector(k, self.points[i]), [[0.0; 3]; 2])
    }

    /// A face that is its own patch, or is pulled to a crease.
    fn complete(&self, function: &HybridFunction, f: FaceId, k: usize, out: &mut GridOut<'_>) {
        let nan = Point3::repeat(f64::NAN);
        for i in 0..self.len() {
            let (point, normal) =
                self.shoot(function, f, k, i).map_or((nan, nan), |s| (s.point, s.gradient.normalize()));
            out.set(i, point, normal);
        }
    }
}

/// Points over triangles, for those with cells of one kind and for those in sectors.
#[derive(Clone, Debug)]
pub struct TriangleTable {
    points: Vec<[f64; 3]>,
    whole: FaceTable,
    /// For the sectors around the centroid: which points are in each, and their table.
    parts: [(Vec<usize>, SectorTable); 3],
}

/// Barycentric coordinates of a center may be off those of the centroid by this for the table to hold; points over it move by
/// as much, in sizes of the triangle.
const CENTROID: f64 = 1e-13;

impl TriangleTable {
    /// For points with the given barycentric coordinates.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let at: Vec<(usize, [f64; 3])> = points.iter().map(|x| sector_of(*x, [1.0 / 3.0; 3])).collect();
        let parts = std::array::from_fn(|k| {
            let inside: Vec<usize> = (0..points.len()).filter(|i| at[*i].0 == k).collect();
            let table = SectorTable::new(&inside.iter().map(|i| at[*i].1).collect::<Vec<_>>());
            (inside, table)
        });
        Self { points: points.to_vec(), whole: FaceTable::new(points), parts }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over a face with three corners, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &HybridFunction, f: FaceId, out: &mut GridOut<'_>) {
        let complete = match &function.faces()[f.index()] {
            FaceCells::Triangle { function: cells, free } => {
                self.evaluate_whole(function, f, (cells, *free), out)
            }
            FaceCells::Sectors(sectors) => {
                let center = function.center_in_triangle(f, &sectors.center);
                let near = center.iter().all(|x| (x - 1.0 / 3.0).abs() <= CENTROID);
                if near { self.evaluate_parts(function, f, out) } else { self.clear(out) }
            }
            FaceCells::Flat(_) | FaceCells::Pyramid(_) => self.clear(out),
        };
        if !complete {
            out.complete(self.len(), |i| function.shoot_face(f, [self.points[i][0], self.points[i][1]]));
        }
    }

    fn evaluate_whole(
        &self,
        function: &HybridFunction,
        f: FaceId,
        (cells, free): (&crate::apatch::FaceFunction, [f64; 2]),
        out: &mut GridOut<'_>,
    ) -> bool {
        let Some(corners) = function.corners(f).first_chunk() else { return self.clear(out) };
        let face = &function.hull().faces[f.index()];
        let (class, corners, apexes) = (face.class, *corners, face.apexes);
        let cells = grid::FaceCells { class, corners, apexes, function: cells, free };
        self.whole.evaluate_cells(&cells, out)
    }

    fn evaluate_parts(&self, function: &HybridFunction, f: FaceId, out: &mut GridOut<'_>) -> bool {
        for (k, (inside, table)) in self.parts.iter().enumerate() {
            let (mut points, mut normals) = (Points::zeros(inside.len()), Points::zeros(inside.len()));
            let wanted = out.normals.is_some();
            let mut part = GridOut { points: points.view_mut(), normals: wanted.then(|| normals.view_mut()) };
            table.evaluate(function, f, k, &mut part);
            inside.iter().enumerate().for_each(|(n, i)| out.set(*i, points.get(n), normals.get(n)));
        }
        true
    }

    fn clear(&self, out: &mut GridOut<'_>) -> bool {
        let nan = Point3::repeat(f64::NAN);
        (0..self.len()).for_each(|i| out.set(i, nan, nan));
        false
    }
}

/// A sector with all that its points need.
struct SectorPatch {
    class: Class,
    /// c, p and q.
    corners: [[f64; 3]; 3],
    base: [f64; 10],
    sides: [Option<SectorRay>; 2],
}

/// What the rays of one side need.
struct SectorRay {
    sign: [f64; 1],
    apex: [f64; 3],
    /// Squares (cc, pp, qq), and twice the products (cp, pq, qc).
    squares: [f64; 3],
    products: [f64; 3],
    turns: [f64; 4],
    layer2: [f64; 3],
    layer3: [f64; 1],
    to_gradient: [f64; 9],
}

impl SectorRay {
    fn new(cell: &SectorSide, side: Side, corners: &[Point3; 3], apex: Point3, normals: bool) -> Self {
        let [cc, cp, cq, pp, pq, qq] = cell.layer1;
        let [c, p, q] = *corners;
        Self {
            sign: [side.sign()],
            apex: apex.into(),
            squares: [cc, pp, qq],
            products: [2.0 * cp, 2.0 * pq, 2.0 * cq],
            turns: [cell.turn[0], cell.turn[1], cell.through[0], cell.through[1]],
            layer2: cell.layer2,
            layer3: [cell.layer3],
            to_gradient: if normals { to_gradient(side, &[c, p, q, apex]) } else { [0.0; 9] },
        }
    }

    /// Layers 1 and 2.
    #[inline(always)]
    fn layers(&self, chunk: &SectorChunk, [x, y, z]: [f64; 3], i: usize) -> [f64; 2] {
        let (u, v, q) = (&self.squares, &self.products, &self.layer2);
        let polynomial = (u[0] * (x * x) + u[1] * (y * y) + u[2] * (z * z))
            + (v[0] * (x * y) + v[1] * (y * z) + v[2] * (z * x));
        [polynomial + dot(&self.turns, &chunk.turns, i), q[0] * x + q[1] * y + q[2] * z]
    }
}

impl SectorPatch {
    fn new(function: &HybridFunction, f: FaceId, sectors: &Sectors, k: usize, normals: bool) -> Self {
        let (face, all) = (&function.hull().faces[f.index()], function.corners(f));
        let corners = [sectors.center, all[k], all[if k + 1 == all.len() { 0 } else { k + 1 }]];
        let sides = Side::BOTH.map(|side| {
            let cell = sectors.sides[side.index()].as_ref()?.get(k)?;
            Some(SectorRay::new(cell, side, &corners, face.apexes[side.index()]?, normals))
        });
        let class = if sides.iter().all(Option::is_some) { Class::Nonconvex } else { face.class };
        let SectorBase { net, turn } = sectors.base[k];
        let base = std::array::from_fn(|n| if n < 8 { net[n] } else { turn[n - 8] });
        Self { class, corners: corners.map(Into::into), base, sides }
    }

    /// The derivative at the root t of ray i by coordinate C of the base.
    #[inline(always)]
    fn derivative<const C: usize>(
        &self,
        side: &SectorRay,
        chunk: &SectorChunk,
        at: [f64; 3],
        t: f64,
        i: usize,
    ) -> f64 {
        let (next, previous) = ((C + 1) % 3, (C + 2) % 3);
        let SectorRay { sign: [sign], squares, products, layer2, .. } = side;
        let d0 = sign * dot(&self.base, &chunk.base_d[C], i);
        let polynomial =
            2.0 * squares[C] * at[C] + products[C] * at[next] + products[previous] * at[previous];
        let d1 = polynomial + dot(&side.turns, &chunk.turns_d[C], i);
        quadratic(1.0 - t, t, [d0, 1.5 * d1, 3.0 * layer2[C]])
    }
}

impl Rays for SectorPatch {
    type Chunk = SectorChunk;
    type Side = SectorRay;

    fn class(&self) -> Class {
        self.class
    }

    fn sides(&self) -> &[Option<SectorRay>; 2] {
        &self.sides
    }

    #[inline(always)]
    fn pick(first: bool, a: &SectorRay, b: &SectorRay) -> SectorRay {
        SectorRay {
            sign: pick(first, &a.sign, &b.sign),
            apex: pick(first, &a.apex, &b.apex),
            squares: pick(first, &a.squares, &b.squares),
            products: pick(first, &a.products, &b.products),
            turns: pick(first, &a.turns, &b.turns),
            layer2: pick(first, &a.layer2, &b.layer2),
            layer3: pick(first, &a.layer3, &b.layer3),
            to_gradient: pick(first, &a.to_gradient, &b.to_gradient),
        }
    }

    #[inline(always)]
    fn base(&self, chunk: &SectorChunk, i: usize) -> f64 {
        dot(&self.base, &chunk.base, i)
    }

    #[inline(always)]
    fn shoot(&self, side: &SectorRay, chunk: &SectorChunk, base: f64, i: usize) -> Hit {
        let at = [chunk.x[0].0[i], chunk.x[1].0[i], chunk.x[2].0[i]];
        let [b1, b2] = side.layers(chunk, at, i);
        let t = root([side.sign[0] * base, b1, b2, side.layer3[0]]);
        let p = &self.corners;
        let mut point = [0.0; 3];
        for c in 0..3 {
            let on_face = at[0] * p[0][c] + at[1] * p[1][c] + at[2] * p[2][c];
            point[c] = on_face + t * (side.apex[c] - on_face);
        }
        Hit { point, t }
    }

    #[inline(always)]
    fn gradient(&self, side: &SectorRay, chunk: &SectorChunk, t: f64, i: usize) -> [f64; 3] {
        let at = [chunk.x[0].0[i], chunk.x[1].0[i], chunk.x[2].0[i]];
        let [b1, b2] = side.layers(chunk, at, i);
        let d = [
            self.derivative::<0>(side, chunk, at, t, i),
            self.derivative::<1>(side, chunk, at, t, i),
            self.derivative::<2>(side, chunk, at, t, i),
        ];
        let to_apex = 3.0 * quadratic(1.0 - t, t, [b1, b2, side.layer3[0]]);
        product(&side.to_gradient, [d[1] - d[0], d[2] - d[0], to_apex - d[0]])
    }
}

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
        let lane = |f: &dyn Fn([f64; 2]) -> f64| Lane::new(points, |[s, t, _]| f([s, t]));
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
            FaceCells::Pyramid(cell) => lanes::shoot(&PyramidPatch::new(cell), &self.chunks, self.len(), out),
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
    fn shoot(&self, side: &PyramidRay, chunk: &PyramidChunk, base: f64, i: usize) -> Hit {
        let (s, t) = (chunk.at[0].0[i], chunk.at[1].0[i]);
        let (b1, b2) = (dot(&side.first, &chunk.first, i), bilinear(side.layer2, s, t));
        let u = root([side.sign[0] * base, b1, b2, side.layer3[0]]);
        let [foot, ..] = self.foot(s, t);
        let mut point = [0.0; 3];
        for c in 0..3 {
            point[c] = foot[c] + u * (side.apex[c] - foot[c]);
        }
        Hit { point, t: u }
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

impl HybridFunction {
    /// Points of the patch over an edge that has cells, and normals, at the parameters of a table; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate_edge(&self, table: &EdgeTable, points: &[[f64; 3]], e: EdgeId, out: &mut GridOut<'_>) {
        let sides = Side::BOTH.map(|side| {
            let [u_l, _, _, u_k] = self.edge_cell(e, side)?;
            Some(([u_l, u_k], *self.edge_function(e, side)?))
        });
        let cells = EdgeCells { class: self.hull().edges[e.index()].class, ends: self.ends(e), sides };
        if !table.evaluate_cells(&cells, out) {
            out.complete(table.len(), |i| self.shoot_edge(e, [points[i][0], points[i][1]], points[i][2]));
        }
    }
}
