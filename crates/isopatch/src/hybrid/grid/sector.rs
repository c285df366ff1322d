//! Points in the sectors of a polygon.

use crate::apatch::grid::GridOut;
use crate::apatch::lanes::{
    self, LANES, Lane, Rays, Vectors, dot, far_root, pick, product, quadratic, to_gradient,
};
use crate::geom::Point3;
use crate::hull::{Class, Side};
use crate::hybrid::face::{FaceCells, Foot};
use crate::hybrid::function::HybridFunction;
use crate::hybrid::sectors::{SectorBase, SectorSide, Sectors, Weights};
use crate::mesh::FaceId;

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
        let lane = |f: &dyn Fn([f64; 3]) -> f64| Lane::new(points, |x| f(*x));
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

    /// Barycentric coordinates of point i.
    #[inline(always)]
    fn at(&self, i: usize) -> [f64; 3] {
        [self.x[0].0[i], self.x[1].0[i], self.x[2].0[i]]
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
        if !lanes::shoot(Vectors::Widest, &patch, &self.chunks, self.len(), out) {
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
    fn layers(&self, side: &SectorRay, chunk: &SectorChunk, base: f64, i: usize) -> [f64; 4] {
        let [b1, b2] = side.layers(chunk, chunk.at(i), i);
        [side.sign[0] * base, b1, b2, side.layer3[0]]
    }

    #[inline(always)]
    fn root(layers: [f64; 4]) -> f64 {
        far_root(layers)
    }

    #[inline(always)]
    fn point(&self, side: &SectorRay, chunk: &SectorChunk, t: f64, i: usize) -> [f64; 3] {
        let (at, p) = (chunk.at(i), &self.corners);
        let mut point = [0.0; 3];
        for c in 0..3 {
            let on_face = at[0] * p[0][c] + at[1] * p[1][c] + at[2] * p[2][c];
            point[c] = on_face + t * (side.apex[c] - on_face);
        }
        point
    }

    #[inline(always)]
    fn gradient(&self, side: &SectorRay, chunk: &SectorChunk, t: f64, i: usize) -> [f64; 3] {
        let at = chunk.at(i);
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
