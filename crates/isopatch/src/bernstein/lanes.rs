//! Bézier triangles at many parameters, in vectors of the machine's width.
//!
//! The algorithm is that of [`triangle::evaluate`], with its results to the bit: products and sums are not contracted, lanes keep
//! apart, and so the width of the machine's vectors changes nothing.

use super::index;
use super::triangle::{self, BINOMIALS, MAX_DEGREE};
use crate::geom::{Point3, PointsMut};
use pulp::{Arch, Simd, WithSimd};

/// Parameters that are computed together: a vector of the widest machines.
const LANES: usize = 8;

/// One number for each of them.
type Lane = [f64; LANES];

/// Bernstein polynomials of degree n − 1 at the parameters of a lane; with [`MAX_DEGREE`] there are 45.
const MOST_WEIGHTS: usize = 45;

/// Room for the coordinates of a net: places are bytes, so that no index has to be checked.
const NET_ROOM: usize = u8::MAX as usize + 3;

/// Coordinates of a net, those of a point together.
type Net = [f64; NET_ROOM];

/// Positions and derivatives by u and v at the parameters of a vector, by coordinates.
struct Found<T> {
    point: [T; 3],
    du: [T; 3],
    dv: [T; 3],
}

/// Where results go, one entry a parameter.
pub struct TangentsMut<'a> {
    /// b(u, v, w).
    pub points: PointsMut<'a>,
    /// ∂b/∂u and ∂b/∂v with w = 1 − u − v.
    pub derivatives: Option<[PointsMut<'a>; 2]>,
    /// Unit vectors along ∂b/∂u × ∂b/∂v; NaN where that vanishes.
    pub normals: Option<PointsMut<'a>>,
}

/// Parameters that are the same for many patches of one degree, with the Bernstein polynomials there.
pub struct TriangleGrid {
    degree: usize,
    count: usize,
    raised: Vec<[u8; 3]>,
    blocks: Vec<Block>,
}

/// Parameters of a grid that are computed together.
struct Block {
    /// The first of them. The last block of a grid begins early enough to be full: stores of a whole lane are one instruction.
    at: usize,
    uvw: [Lane; 3],
    weights: Vec<Lane>,
}

/// A patch of degree n, ready for many parameters.
#[derive(Clone, Copy)]
struct Patch<'a> {
    n: usize,
    net: &'a Net,
    /// As [`raised`] gives them.
    raised: &'a [[u8; 3]],
}

/// Barycentric coordinates of up to [`LANES`] parameters, the last one repeated.
fn lanes_of(parameters: &[[f64; 3]]) -> [Lane; 3] {
    std::array::from_fn(|c| std::array::from_fn(|i| parameters[i.min(parameters.len() - 1)][c]))
}

/// For each index of degree n − 1, where the coordinates of a net of degree n stand for it raised by one in u, v and w; then zeros.
#[inline(always)]
fn raised(n: usize) -> [[u8; 3]; MOST_WEIGHTS] {
    let mut places = [[0; 3]; MOST_WEIGHTS];
    let mut p = 0;
    for row in 0..n {
        for _ in 0..=row {
            places[p] = [p, p + row + 1, p + row + 2].map(|at| 3 * at as u8);
            p += 1;
        }
    }
    places
}

/// Bernstein polynomials of degree n − 1.
#[inline(always)]
fn weights(n: usize, uvw: &[Lane; 3]) -> [Lane; MOST_WEIGHTS] {
    let mut powers = [[[1.0; LANES]; MAX_DEGREE]; 3];
    for c in 0..3 {
        for k in 1..MAX_DEGREE {
            for i in 0..LANES {
                powers[c][k][i] = uvw[c][i] * powers[c][k - 1][i];
            }
        }
    }
    let [of_u, of_v, of_w] = &powers;
    let mut weights = [[0.0; LANES]; MOST_WEIGHTS];
    let mut p = 0;
    for row in 0..n {
        for k in 0..=row {
            let count = BINOMIALS[n - 1][row] * BINOMIALS[row][k];
            let (a, b, c) = (&of_u[n - 1 - row], &of_v[row - k], &of_w[k]);
            for i in 0..LANES {
                weights[p][i] = count * a[i] * b[i] * c[i];
            }
            p += 1;
        }
    }
    weights
}

/// Copies the coordinates of a net of at most [`MAX_DEGREE`] to where they are read: an array that is returned is copied once more.
#[inline(always)]
fn put_net(net: &[Point3], out: &mut Net) {
    for (out, p) in out.chunks_exact_mut(3).zip(net) {
        (0..3).for_each(|axis| out[axis] = p[axis]);
    }
}

/// [`triangle::evaluate`] at the parameters of a vector, with all nine sums at once, as each has to wait for itself.
///
/// In loops: the closure of a `map` of vectors would not be compiled for the machine's width.
#[inline(always)]
fn evaluate<S: Simd>(
    simd: S,
    Patch { n, net, raised }: Patch<'_>,
    [u, v, w]: [S::f64s; 3],
    weights: impl Iterator<Item = S::f64s>,
) -> Found<S::f64s> {
    let mut b = [[simd.splat_f64s(0.0); 3]; 3];
    for (raised, weight) in raised.iter().zip(weights) {
        for corner in 0..3 {
            let at = raised[corner] as usize;
            for axis in 0..3 {
                let share = simd.mul_f64s(weight, simd.splat_f64s(net[at + axis]));
                b[axis][corner] = simd.add_f64s(b[axis][corner], share);
            }
        }
    }
    let (degree, zero) = (simd.splat_f64s(n as f64), [simd.splat_f64s(0.0); 3]);
    let mut found = Found { point: zero, du: zero, dv: zero };
    for axis in 0..3 {
        let [to_u, to_v, to_w] = b[axis];
        let beside = simd.add_f64s(simd.mul_f64s(u, to_u), simd.mul_f64s(v, to_v));
        found.point[axis] = simd.add_f64s(beside, simd.mul_f64s(w, to_w));
        found.du[axis] = simd.mul_f64s(degree, simd.sub_f64s(to_u, to_w));
        found.dv[axis] = simd.mul_f64s(degree, simd.sub_f64s(to_v, to_w));
    }
    found
}

/// Unit normals.
#[inline(always)]
fn normals<S: Simd>(simd: S, found: &Found<S::f64s>) -> [S::f64s; 3] {
    let product = |a, b| simd.mul_f64s(a, b);
    let ([ax, ay, az], [bx, by, bz]) = (found.du, found.dv);
    let x = simd.sub_f64s(product(ay, bz), product(az, by));
    let y = simd.sub_f64s(product(az, bx), product(ax, bz));
    let z = simd.sub_f64s(product(ax, by), product(ay, bx));
    let square = simd.add_f64s(simd.add_f64s(product(x, x), product(y, y)), product(z, z));
    // One division: it takes as long as ten products.
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), simd.sqrt_f64s(square));
    [product(x, inverse), product(y, inverse), product(z, inverse)]
}

/// Puts vectors in their places; the last ones of a grid below [`LANES`] parameters have none.
#[inline(always)]
fn put<S: Simd>(simd: S, out: &mut PointsMut<'_>, at: usize, vectors: [S::f64s; 3]) {
    for (out, vector) in [&mut out.x, &mut out.y, &mut out.z].into_iter().zip(vectors) {
        let out = out.get_mut(at..).unwrap_or_default();
        match S::as_mut_simd_f64s(out) {
            ([whole, ..], _) => *whole = vector,
            ([], part) => simd.partial_store_f64s(part, vector),
        }
    }
}

/// The vectors of a lane.
#[inline(always)]
fn part<S: Simd>(lane: &Lane, part: usize) -> S::f64s {
    S::as_simd_f64s(lane).0[part]
}

impl TriangleGrid {
    /// For patches of degree `degree`, at barycentric parameters.
    ///
    /// # Panics
    /// If the degree is 0 or larger than [`MAX_DEGREE`].
    pub fn new(degree: usize, parameters: &[[f64; 3]]) -> Self {
        assert!((1..=MAX_DEGREE).contains(&degree), "degree {degree}");
        let last = parameters.len().saturating_sub(LANES);
        let block = |start: usize| {
            let at = start.min(last);
            let uvw = lanes_of(&parameters[at..parameters.len().min(at + LANES)]);
            let weights = weights(degree, &uvw)[..index::count(degree - 1)].to_vec();
            Block { at, uvw, weights }
        };
        let blocks = (0..parameters.len()).step_by(LANES).map(block).collect();
        Self {
            degree,
            count: parameters.len(),
            raised: raised(degree)[..index::count(degree - 1)].to_vec(),
            blocks,
        }
    }

    /// The degree of the patches.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// All parameters of the patch with a net; the outputs are as long as the grid. No allocation.
    ///
    /// # Panics
    /// If an output is shorter.
    pub fn evaluate(&self, net: &[Point3], out: TangentsMut<'_>) {
        let [du, dv] = out.derivatives.as_ref().map_or([None; 2], |[du, dv]| [Some(du), Some(dv)]);
        for out in [Some(&out.points), du, dv, out.normals.as_ref()].into_iter().flatten() {
            let shortest = out.x.len().min(out.y.len()).min(out.z.len());
            assert!(shortest >= self.count, "room for {shortest} of {} results", self.count);
        }
        Arch::new().dispatch(GridRun { grid: self, net, out });
    }
}

struct GridRun<'a, 'b> {
    grid: &'a TriangleGrid,
    net: &'a [Point3],
    out: TangentsMut<'b>,
}

impl WithSimd for GridRun<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut net = [0.0; NET_ROOM];
        put_net(self.net, &mut net);
        let patch = Patch { n: self.grid.degree, net: &net, raised: &self.grid.raised };
        for Block { at, uvw, weights } in &self.grid.blocks {
            for p in 0..LANES / S::F64_LANES {
                let at = at + p * S::F64_LANES;
                let weights = weights.iter().map(|lane| part::<S>(lane, p));
                let found = evaluate(simd, patch, [0, 1, 2].map(|c| part::<S>(&uvw[c], p)), weights);
                put(simd, &mut self.out.points, at, found.point);
                if let Some([du, dv]) = &mut self.out.derivatives {
                    put(simd, du, at, found.du);
                    put(simd, dv, at, found.dv);
                }
                if let Some(out) = &mut self.out.normals {
                    put(simd, out, at, normals(simd, &found));
                }
            }
        }
    }
}

/// Points and derivatives of a Bézier triangle at any parameters (u, v); `each` is given their numbers, and the unit normals.
///
/// # Panics
/// As [`triangle::evaluate`].
pub fn evaluate_all(
    degree: usize,
    net: &[Point3],
    parameters: &[[f64; 2]],
    each: impl FnMut(usize, triangle::Tangents, Point3),
) {
    assert!((1..=MAX_DEGREE).contains(&degree) && net.len() == index::count(degree), "degree {degree}");
    Arch::new().dispatch(FreeRun { degree, net, parameters, each });
}

struct FreeRun<'a, F> {
    degree: usize,
    net: &'a [Point3],
    parameters: &'a [[f64; 2]],
    each: F,
}

impl<F: FnMut(usize, triangle::Tangents, Point3)> WithSimd for FreeRun<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let count = index::count(self.degree - 1);
        let places = raised(self.degree);
        let mut net = [0.0; NET_ROOM];
        put_net(self.net, &mut net);
        let patch = Patch { n: self.degree, net: &net, raised: &places[..count] };
        for (block, parameters) in self.parameters.chunks(LANES).enumerate() {
            let at = |i: usize| parameters[i.min(parameters.len() - 1)];
            let (u, v): (Lane, Lane) = (std::array::from_fn(|i| at(i)[0]), std::array::from_fn(|i| at(i)[1]));
            let uvw = [u, v, std::array::from_fn(|i| 1.0 - u[i] - v[i])];
            let weights = weights(self.degree, &uvw);
            // Points, derivatives by u and v, and normals.
            let mut all = [[[0.0; LANES]; 3]; 4];
            for p in 0..LANES / S::F64_LANES {
                let weights = weights[..count].iter().map(|lane| part::<S>(lane, p));
                let found = evaluate(simd, patch, [0, 1, 2].map(|c| part::<S>(&uvw[c], p)), weights);
                let vectors = [found.point, found.du, found.dv, normals(simd, &found)];
                for kind in 0..4 {
                    for c in 0..3 {
                        S::as_mut_simd_f64s(&mut all[kind][c]).0[p] = vectors[kind][c];
                    }
                }
            }
            for i in 0..parameters.len() {
                let of = |kind: usize| Point3::new(all[kind][0][i], all[kind][1][i], all[kind][2][i]);
                let [point, du, dv, normal] = [of(0), of(1), of(2), of(3)];
                (self.each)(block * LANES + i, triangle::Tangents { point, du, dv }, normal);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Points;

    fn net(n: usize) -> Vec<Point3> {
        let value = |s: f64| (s * 12.9898).sin() * 2.0;
        let point = |i: usize| Point3::new(value(i as f64), value(i as f64 + 0.3), value(i as f64 + 0.7));
        (0..index::count(n)).map(point).collect()
    }

    #[test]
    fn lanes_give_the_bits_of_single_points() {
        for n in 1..=MAX_DEGREE {
            let net = net(n);
            // 66 of them: the last lane is not full.
            let parameters: Vec<[f64; 2]> = triangle::lattice(10).iter().map(|[u, v, _]| [*u, *v]).collect();
            let mut seen = 0;
            evaluate_all(n, &net, &parameters, |i, t, normal| {
                assert_eq!(i, seen);
                seen += 1;
                assert_eq!(t, triangle::evaluate(n, &net, parameters[i]));
                let expected = t.du.cross(&t.dv).normalize();
                assert!((normal - expected).norm() < 1e-15);
            });
            assert_eq!(seen, parameters.len());
        }
    }

    #[test]
    fn a_grid_gives_the_same_as_free_parameters() {
        let n = 7;
        let parameters: Vec<[f64; 3]> =
            triangle::lattice(10).into_iter().map(|[u, v, _]| [u, v, 1.0 - u - v]).collect();
        let net = net(n);
        let grid = TriangleGrid::new(n, &parameters);
        let [mut points, mut du, mut dv, mut normals] = [(); 4].map(|()| Points::zeros(parameters.len()));
        grid.evaluate(
            &net,
            TangentsMut {
                points: points.view_mut(),
                derivatives: Some([du.view_mut(), dv.view_mut()]),
                normals: Some(normals.view_mut()),
            },
        );
        for (i, [u, v, _]) in parameters.iter().enumerate() {
            let t = triangle::evaluate(n, &net, [*u, *v]);
            assert_eq!([points.get(i), du.get(i), dv.get(i)], [t.point, t.du, t.dv]);
            assert!((normals.get(i) - t.du.cross(&t.dv).normalize()).norm() < 1e-15);
        }
    }

    #[test]
    #[should_panic(expected = "room for 2 of 3 results")]
    fn outputs_that_are_too_short_are_refused() {
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (mut points, mut normals) = (Points::zeros(3), Points::zeros(2));
        let normals = Some(normals.view_mut());
        let out = TangentsMut { points: points.view_mut(), derivatives: None, normals };
        TriangleGrid::new(7, &corners).evaluate(&net(7), out);
    }

    #[test]
    fn corners_are_exact() {
        let (net, corners) = (net(7), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mut points = Points::zeros(3);
        let out = TangentsMut { points: points.view_mut(), derivatives: None, normals: None };
        TriangleGrid::new(7, &corners).evaluate(&net, out);
        assert_eq!([0, 1, 2].map(|i| points.get(i)), [net[0], net[28], net[35]]);
    }
}
