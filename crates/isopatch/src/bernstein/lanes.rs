//! Bézier triangles at many parameters: loops of fixed length over plain numbers, which the compiler makes vector instructions of.
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

/// Room for the coordinates of a net; a power of two, so that no index has to be checked.
const NET_ROOM: usize = 64;

/// Positions, derivatives by u and v, and unit normals; each by coordinates.
struct Found {
    point: [Lane; 3],
    du: [Lane; 3],
    dv: [Lane; 3],
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
    net: &'a [[f64; NET_ROOM]; 3],
    /// As [`raised`] gives them.
    raised: &'a [[u8; 3]],
}

/// Barycentric coordinates of up to [`LANES`] parameters, the last one repeated.
fn lanes_of(parameters: &[[f64; 3]]) -> [Lane; 3] {
    std::array::from_fn(|c| std::array::from_fn(|i| parameters[i.min(parameters.len() - 1)][c]))
}

/// For each index of degree n − 1, where it stands in a net of degree n when raised by one in u, v and w.
fn raised(n: usize) -> Vec<[u8; 3]> {
    let of = |ijk: [usize; 3]| {
        std::array::from_fn(|c| {
            let mut ijk = ijk;
            ijk[c] += 1;
            index::position(ijk) as u8
        })
    };
    index::indices(n - 1).map(of).collect()
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

/// Coordinates of a net, axis by axis.
#[inline(always)]
fn by_axis(net: &[Point3]) -> [[f64; NET_ROOM]; 3] {
    let mut axes = [[0.0; NET_ROOM]; 3];
    for (i, p) in net.iter().enumerate() {
        (0..3).for_each(|axis| axes[axis][i % NET_ROOM] = p[axis]);
    }
    axes
}

/// [`triangle::evaluate`] in lanes.
#[inline(always)]
fn evaluate<S: Simd>(simd: S, patch: Patch<'_>, uvw: &[Lane; 3], weights: &[Lane]) -> Found {
    match S::F64_LANES {
        1 => evaluate_narrow(patch, uvw, weights),
        _ => evaluate_wide(simd, patch, uvw, weights),
    }
}

/// With all nine sums of a vector at once, as each has to wait for itself.
#[inline(always)]
fn evaluate_wide<S: Simd>(simd: S, patch: Patch<'_>, uvw: &[Lane; 3], weights: &[Lane]) -> Found {
    let Patch { n, net, raised } = patch;
    let zero = [[0.0; LANES]; 3];
    let mut found = Found { point: zero, du: zero, dv: zero };
    let degree = simd.splat_f64s(n as f64);
    for part in 0..LANES / S::F64_LANES {
        let mut b = [[simd.splat_f64s(0.0); 3]; 3];
        for (raised, weight) in raised.iter().zip(weights) {
            let weight = S::as_simd_f64s(weight).0[part];
            for corner in 0..3 {
                let at = raised[corner] as usize % NET_ROOM;
                for axis in 0..3 {
                    let share = simd.mul_f64s(weight, simd.splat_f64s(net[axis][at]));
                    b[axis][corner] = simd.add_f64s(b[axis][corner], share);
                }
            }
        }
        let [u, v, w] = [0, 1, 2].map(|c| S::as_simd_f64s(&uvw[c]).0[part]);
        for axis in 0..3 {
            let [to_u, to_v, to_w] = b[axis];
            let beside = simd.add_f64s(simd.mul_f64s(u, to_u), simd.mul_f64s(v, to_v));
            let put = |lane: &mut Lane, x: S::f64s| S::as_mut_simd_f64s(lane).0[part] = x;
            put(&mut found.point[axis], simd.add_f64s(beside, simd.mul_f64s(w, to_w)));
            put(&mut found.du[axis], simd.mul_f64s(degree, simd.sub_f64s(to_u, to_w)));
            put(&mut found.dv[axis], simd.mul_f64s(degree, simd.sub_f64s(to_v, to_w)));
        }
    }
    found
}

/// In loops that the compiler makes narrow vectors of, for machines without wide ones.
#[inline(always)]
fn evaluate_narrow(patch: Patch<'_>, [u, v, w]: &[Lane; 3], weights: &[Lane]) -> Found {
    let Patch { n, net, raised } = patch;
    let zero = [[0.0; LANES]; 3];
    let mut found = Found { point: zero, du: zero, dv: zero };
    let degree = n as f64;
    for axis in 0..3 {
        let mut b = zero;
        for (raised, weight) in raised.iter().zip(weights) {
            for corner in 0..3 {
                let x = net[axis][raised[corner] as usize % NET_ROOM];
                for i in 0..LANES {
                    b[corner][i] += weight[i] * x;
                }
            }
        }
        for i in 0..LANES {
            found.point[axis][i] = u[i] * b[0][i] + v[i] * b[1][i] + w[i] * b[2][i];
            found.du[axis][i] = degree * (b[0][i] - b[2][i]);
            found.dv[axis][i] = degree * (b[1][i] - b[2][i]);
        }
    }
    found
}

/// Unit normals.
#[inline(always)]
fn normals(found: &Found) -> [Lane; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (&found.du, &found.dv);
    let mut n = [[0.0; LANES]; 3];
    for i in 0..LANES {
        let x = ay[i] * bz[i] - az[i] * by[i];
        let y = az[i] * bx[i] - ax[i] * bz[i];
        let z = ax[i] * by[i] - ay[i] * bx[i];
        // One division: it takes as long as ten products.
        let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
        (n[0][i], n[1][i], n[2][i]) = (x * inverse, y * inverse, z * inverse);
    }
    n
}

/// Puts the first of the lanes in their places.
#[inline(always)]
fn put(out: &mut PointsMut<'_>, at: usize, lanes: &[Lane; 3]) {
    for (out, lane) in [&mut out.x, &mut out.y, &mut out.z].into_iter().zip(lanes) {
        let out = &mut out[at..];
        // A copy of fixed length is an instruction, one of any length a call.
        match out.first_chunk_mut::<LANES>() {
            Some(out) => *out = *lane,
            None => out.iter_mut().zip(lane).for_each(|(out, x)| *out = *x),
        }
    }
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
        Self { degree, count: parameters.len(), raised: raised(degree), blocks }
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
    pub fn evaluate(&self, net: &[Point3], out: TangentsMut<'_>) {
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
        let net = by_axis(self.net);
        let patch = Patch { n: self.grid.degree, net: &net, raised: &self.grid.raised };
        for Block { at, uvw, weights } in &self.grid.blocks {
            let found = evaluate(simd, patch, uvw, weights);
            let at = *at;
            put(&mut self.out.points, at, &found.point);
            if let Some([du, dv]) = &mut self.out.derivatives {
                put(du, at, &found.du);
                put(dv, at, &found.dv);
            }
            if let Some(out) = &mut self.out.normals {
                put(out, at, &normals(&found));
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
        let net = by_axis(self.net);
        let mut raised = [[0; 3]; MOST_WEIGHTS];
        let mut count = 0;
        // As in `raised`, without a table on the heap.
        for row in 0..self.degree {
            for _ in 0..=row {
                raised[count] = [count, count + row + 1, count + row + 2].map(|p| p as u8);
                count += 1;
            }
        }
        let patch = Patch { n: self.degree, net: &net, raised: &raised[..count] };
        for (block, parameters) in self.parameters.chunks(LANES).enumerate() {
            let at = |i: usize| parameters[i.min(parameters.len() - 1)];
            let (u, v): (Lane, Lane) = (std::array::from_fn(|i| at(i)[0]), std::array::from_fn(|i| at(i)[1]));
            let uvw = [u, v, std::array::from_fn(|i| 1.0 - u[i] - v[i])];
            let found = evaluate(simd, patch, &uvw, &weights(self.degree, &uvw)[..count]);
            let normals = normals(&found);
            for i in 0..parameters.len() {
                let of = |lanes: &[Lane; 3]| Point3::new(lanes[0][i], lanes[1][i], lanes[2][i]);
                let tangents =
                    triangle::Tangents { point: of(&found.point), du: of(&found.du), dv: of(&found.dv) };
                (self.each)(block * LANES + i, tangents, of(&normals));
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
    fn corners_are_exact() {
        let (net, corners) = (net(7), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mut points = Points::zeros(3);
        let out = TangentsMut { points: points.view_mut(), derivatives: None, normals: None };
        TriangleGrid::new(7, &corners).evaluate(&net, out);
        assert_eq!([0, 1, 2].map(|i| points.get(i)), [net[0], net[28], net[35]]);
    }
}
