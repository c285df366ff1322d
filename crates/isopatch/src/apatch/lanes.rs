//! Rays in lanes: loops of fixed length over plain numbers, which the compiler makes vector instructions of.
//!
//! There are only operations that IEEE 754 defines, one lane apart from the other, and products and sums are not contracted: the
//! width of the vectors is the machine's choice and does not change a bit.

use super::grid::GridOut;
use crate::geom::{Mat3, Point3};
use crate::hull::{Class, Side};
use pulp::{Arch, NullaryFnOnce};

/// Rays that are computed together: a vector of the widest machines.
pub const LANES: usize = 8;

/// Chunks of rays that go through each stage together. A root is a long chain of operations each of which waits for the one
/// before: the processor is busy only with roots of several vectors at once, and narrow vectors gain most.
const TOGETHER: usize = 4;

/// One number for each of [`LANES`] rays.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lane(pub [f64; LANES]);

/// The last step of [`root`] relative to the root, below which the root has all its digits: a step leaves the fourth power of
/// the error.
const SETTLED: f64 = 1e-4;

impl Lane {
    /// The numbers of a run of points, the last one repeated to fill the lane.
    pub fn new<T>(points: &[T], f: impl Fn(&T) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(&points[i.min(points.len() - 1)])))
    }
}

/// A row of a table times a patch's numbers, for ray i.
#[inline(always)]
pub fn dot<const N: usize>(a: &[f64; N], b: &[Lane; N], i: usize) -> f64 {
    let mut sum = a[0] * b[0].0[i];
    for n in 1..N {
        sum += a[n] * b[n].0[i];
    }
    sum
}

/// One or the other of two rows.
#[inline(always)]
pub fn pick<const N: usize>(first: bool, a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut picked = *b;
    for n in 0..N {
        picked[n] = if first { a[n] } else { b[n] };
    }
    picked
}

/// The root t of the cubic with the given layers, for the signs (−, ±, +, +), where there is one, or (0, +, +, +); NaN for other
/// signs, or if two steps were not enough.
///
/// The start in s = t/(1 − t) is the root of the first three terms, as in [`crate::bernstein::cubic::simple_root`]. A step of
/// Householder's method of order four costs one division, as one of Newton's does, and two of them do what takes four of
/// those; the division of the second is left for t itself.
#[inline(always)]
pub fn root(b: [f64; 4]) -> f64 {
    root_in::<1>(b)
}

/// The same with a step more, for cells whose layers are far apart.
#[inline(always)]
pub fn far_root(b: [f64; 4]) -> f64 {
    root_in::<2>(b)
}

/// With this many steps before the last one.
#[inline(always)]
fn root_in<const STEPS: usize>(b: [f64; 4]) -> f64 {
    let (c1, c2) = (3.0 * b[1], 3.0 * b[2]);
    let mut s = -2.0 * b[0] / (c1 + (c1 * c1 - 4.0 * (b[0] * c2)).sqrt());
    for _ in 0..STEPS {
        let (n, d) = step([b[0], c1, c2, b[3]], s);
        s -= n / d;
    }
    let (n, d) = step([b[0], c1, c2, b[3]], s);
    let top = s * d - n;
    let t = top / (top + d);
    let signs = (b[0] <= 0.0) & ((b[1] > 0.0) | (b[0] < 0.0)) & (b[2] >= 0.0) & (b[3] > 0.0);
    if signs & (n.abs() <= SETTLED * (s * d)) { t } else { f64::NAN }
}

/// Numerator and denominator of what Householder's method of order four takes from s, for the polynomial with coefficients c.
#[inline(always)]
fn step(c: [f64; 4], s: f64) -> (f64, f64) {
    let value = ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
    let slope = (3.0 * c[3] * s + 2.0 * c[2]) * s + c[1];
    // Half the second derivative; a sixth of the third is the last coefficient.
    let bend = 3.0 * c[3] * s + c[2];
    let g = slope * slope - value * bend;
    (value * g, slope * (g - value * bend) + value * value * c[3])
}

/// The value of a polynomial in r = 1 − t and t with the binomial factors 1, 2, 1 left out.
#[inline(always)]
pub fn quadratic(r: f64, t: f64, [a, b, c]: [f64; 3]) -> f64 {
    r * (r * a + 2.0 * (t * b)) + t * t * c
}

/// A matrix in rows times a vector.
#[inline(always)]
pub fn product(m: &[f64; 9], v: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = v;
    [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z]
}

/// What takes derivatives by the barycentric coordinates of a cell to gradients, for the function times the sign of the side.
pub fn to_gradient(side: Side, corners: &[Point3; 4]) -> [f64; 9] {
    let edges = [1, 2, 3].map(|c| (corners[c] - corners[0]).transpose());
    let inverse = Mat3::from_rows(&edges).try_inverse().unwrap_or_else(|| Mat3::repeat(f64::NAN));
    std::array::from_fn(|n| side.sign() * inverse[(n / 3, n % 3)])
}

/// A patch with all that its rays need.
///
/// Everything is inlined into loops over a lane: a call in them would keep the compiler from making vectors, and so would a
/// loop in them that is too large to be unrolled.
pub trait Rays {
    /// What a table holds for a lane of rays.
    type Chunk;
    /// What the rays of one side need.
    type Side;

    /// The class of the face or edge.
    fn class(&self) -> Class;

    /// The outer and the inner side, where there is a cell.
    fn sides(&self) -> &[Option<Self::Side>; 2];

    /// The first side where `first`, else the second one.
    fn pick(first: bool, a: &Self::Side, b: &Self::Side) -> Self::Side;

    /// Layer 0 of ray i, in the sign of the function.
    fn base(&self, chunk: &Self::Chunk, i: usize) -> f64;

    /// The layers of ray i with the given layer 0, in the sign of a side.
    fn layers(&self, side: &Self::Side, chunk: &Self::Chunk, base: f64, i: usize) -> [f64; 4];

    /// The root t for given layers.
    #[inline(always)]
    fn root(layers: [f64; 4]) -> f64 {
        root(layers)
    }

    /// The point at the parameter t of ray i.
    fn point(&self, side: &Self::Side, chunk: &Self::Chunk, t: f64, i: usize) -> [f64; 3];

    /// Gradient of the function, of any length, at the parameter t of ray i.
    fn gradient(&self, side: &Self::Side, chunk: &Self::Chunk, t: f64, i: usize) -> [f64; 3];
}

/// One number for each ray of a chunk.
type Row = [f64; LANES];

/// Where the rays of a chunk have the surface.
enum Place<'a, S> {
    /// All on one side.
    On(&'a S),
    /// Each on the first side if its layer 0 is not above zero, else on the second one.
    Either(&'a S, &'a S),
    /// There is no such side.
    Nowhere,
}

/// The layers of a chunk on the first side, or if `MIXED` of each ray on the side where it has the surface.
#[inline(always)]
fn layers<R: Rays, const MIXED: bool>(
    rays: &R,
    sides: [&R::Side; 2],
    chunk: &R::Chunk,
    base: &Row,
) -> [Row; 4] {
    // Local arrays: the compiler knows that nothing else points to them.
    let mut layers = [[0.0; LANES]; 4];
    for i in 0..LANES {
        let picked;
        let side = if MIXED {
            picked = R::pick(base[i] <= 0.0, sides[0], sides[1]);
            &picked
        } else {
            sides[0]
        };
        let b = rays.layers(side, chunk, base[i], i);
        layers[0][i] = b[0];
        layers[1][i] = b[1];
        layers[2][i] = b[2];
        layers[3][i] = b[3];
    }
    layers
}

/// Points of a chunk, at the parameters t on a side, and normals.
#[inline(always)]
fn points<R: Rays, const NORMALS: bool>(
    rays: &R,
    side: &R::Side,
    chunk: &R::Chunk,
    t: &Row,
) -> [[Row; 3]; 2] {
    let (mut points, mut normals) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for i in 0..LANES {
        let point = rays.point(side, chunk, t[i], i);
        points[0][i] = point[0];
        points[1][i] = point[1];
        points[2][i] = point[2];
        if NORMALS {
            let [x, y, z] = rays.gradient(side, chunk, t[i], i);
            let shrink = 1.0 / (x * x + y * y + z * z).sqrt();
            normals[0][i] = shrink * x;
            normals[1][i] = shrink * y;
            normals[2][i] = shrink * z;
        }
    }
    [points, normals]
}

/// Of each ray the numbers of the side where it has its surface.
#[inline(always)]
fn blend<const N: usize>(base: &Row, first: &[Row; N], second: &[Row; N]) -> [Row; N] {
    let mut blended = [[0.0; LANES]; N];
    for n in 0..N {
        for i in 0..LANES {
            blended[n][i] = if base[i] <= 0.0 { first[n][i] } else { second[n][i] };
        }
    }
    blended
}

// Functions and no closures: these are not always inlined.
impl<S> Place<'_, S> {
    /// The layers of a chunk.
    #[inline(always)]
    fn layers<R: Rays<Side = S>>(&self, rays: &R, chunk: &R::Chunk, base: &Row) -> [Row; 4] {
        match self {
            Place::On(side) => layers::<R, false>(rays, [side, side], chunk, base),
            Place::Either(first, second) => layers::<R, true>(rays, [first, second], chunk, base),
            Place::Nowhere => [[f64::NAN; LANES]; 4],
        }
    }

    /// Points of a chunk at the parameters t, and normals.
    #[inline(always)]
    fn points<R: Rays<Side = S>, const NORMALS: bool>(
        &self,
        rays: &R,
        chunk: &R::Chunk,
        base: &Row,
        t: &Row,
    ) -> [[Row; 3]; 2] {
        match self {
            Place::On(side) => points::<R, NORMALS>(rays, side, chunk, t),
            Place::Either(first, second) => {
                let [points, normals] = points::<R, NORMALS>(rays, first, chunk, t);
                let [others, other_normals] = self::points::<R, NORMALS>(rays, second, chunk, t);
                [blend(base, &points, &others), blend(base, &normals, &other_normals)]
            }
            Place::Nowhere => [[[f64::NAN; LANES]; 3]; 2],
        }
    }
}

/// Layer 0 of a chunk, and where its rays have the surface.
#[inline(always)]
fn start<'a, R: Rays>(rays: &'a R, chunk: &R::Chunk) -> (Row, Place<'a, R::Side>) {
    let mut base = [0.0; LANES];
    let (mut above, mut below) = (0u64, 0u64);
    for i in 0..LANES {
        base[i] = rays.base(chunk, i);
        above |= u64::from(base[i] > 0.0);
        below |= u64::from(base[i] < 0.0);
    }
    let [outer, inner] = rays.sides();
    let place = match (rays.class(), above > 0, below > 0, outer, inner) {
        (Class::Positive, _, _, Some(side), _)
        | (Class::Nonconvex, false, _, Some(side), _)
        | (Class::Negative, _, _, _, Some(side))
        | (Class::Nonconvex, true, false, _, Some(side)) => Place::On(side),
        // The surface goes through the base here.
        (Class::Nonconvex, true, true, Some(outer), Some(inner)) => Place::Either(outer, inner),
        _ => Place::Nowhere,
    };
    (base, place)
}

struct Run<'a, 'b, R: Rays> {
    rays: &'a R,
    chunks: &'a [R::Chunk],
    count: usize,
    out: &'a mut GridOut<'b>,
}

impl<R: Rays> Run<'_, '_, R> {
    #[inline(always)]
    fn all<const NORMALS: bool>(self) -> bool {
        let (rays, mut missing) = (self.rays, 0u64);
        for (n, chunks) in self.chunks.chunks(TOGETHER).enumerate() {
            let mut places = [const { Place::Nowhere }; TOGETHER];
            let mut bases = [[0.0; LANES]; TOGETHER];
            let mut layers = [[[0.0; LANES]; 4]; TOGETHER];
            let mut roots = [[0.0; LANES]; TOGETHER];
            for (c, chunk) in chunks.iter().enumerate() {
                let (base, place) = start(rays, chunk);
                layers[c] = place.layers(rays, chunk, &base);
                (bases[c], places[c]) = (base, place);
            }
            for (root, [b0, b1, b2, b3]) in roots.iter_mut().zip(&layers).take(chunks.len()) {
                let mut t = [0.0; LANES];
                for i in 0..LANES {
                    t[i] = R::root([b0[i], b1[i], b2[i], b3[i]]);
                    missing |= u64::from(t[i].is_nan());
                }
                *root = t;
            }
            for (c, chunk) in chunks.iter().enumerate() {
                let (base, t) = (bases[c], roots[c]);
                let [points, normals] = places[c].points::<R, NORMALS>(rays, chunk, &base, &t);
                let at = (n * TOGETHER + c) * LANES;
                self.out.put::<NORMALS>(at, LANES.min(self.count - at), &points, &normals);
            }
        }
        missing == 0
    }
}

impl<R: Rays> NullaryFnOnce for Run<'_, '_, R> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        if self.out.normals.is_some() { self.all::<true>() } else { self.all::<false>() }
    }
}

/// Which vectors rays are computed in. The results are the same, bit by bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vectors {
    /// The widest that the machine has.
    #[default]
    Widest,
    /// Those that every machine of the architecture has, as the library takes them where there are no wider ones it knows: two
    /// numbers (SSE2) on x86-64.
    Baseline,
}

/// Shoots `count` rays in lanes. Points that were not found are NaN; says whether there are none.
pub fn shoot<R: Rays>(
    vectors: Vectors,
    rays: &R,
    chunks: &[R::Chunk],
    count: usize,
    out: &mut GridOut<'_>,
) -> bool {
    let arch = match vectors {
        Vectors::Widest => Arch::new(),
        Vectors::Baseline => Arch::Scalar,
    };
    arch.dispatch(Run { rays, chunks, count, out })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bernstein::cubic;

    /// Layers over three orders of magnitude. Two steps are for layer 1 above zero; three do for most that are below, too.
    #[test]
    fn roots_have_all_digits_or_are_nan() {
        let size = |n: usize, k: usize| 10.0f64.powf(1.5 * ((n * 4 + k) as f64 * 12.9898).sin());
        for (below, root, least) in [(1.0, root as fn([f64; 4]) -> f64, 15_000), (-1.0, far_root, 5_000)] {
            let (mut found, mut worst) = (0, 0.0f64);
            for n in 0..20_000 {
                let b = [-size(n, 0), below * size(n, 1), size(n, 2), size(n, 3)];
                let t = root(b);
                if !t.is_nan() {
                    found += 1;
                    let exact = cubic::minimal_root(&b).unwrap();
                    worst = worst.max((t - exact).abs() / exact);
                }
            }
            assert!(worst < 3e-15, "{below}: {worst:e}");
            assert!(found > least, "{below}: {found}");
        }
    }

    #[test]
    fn other_signs_have_no_root() {
        assert_eq!(root([0.0, 1.0, 1.0, 1.0]), 0.0);
        // Two steps are too few here, three are not.
        let far = [-1.0, 0.1, 0.1, 1.0];
        assert!(root(far).is_nan() && (far_root(far) - cubic::simple_root(&far)).abs() < 1e-15);
        for b in [[1.0, 1.0, 1.0, 1.0], [0.0, -1.0, 1.0, 1.0], [-1.0, 1.0, -1.0, 1.0], [-1.0, 1.0, 1.0, -1.0]]
        {
            assert!(root(b).is_nan(), "{b:?}");
        }
        assert!(root([f64::NAN, 1.0, 1.0, 1.0]).is_nan());
        assert!(root([-1.0, 1.0, f64::NAN, 1.0]).is_nan());
    }
}
