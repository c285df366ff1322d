//! The decocube's formula in batches of 1,024 points: nanoseconds a point, against the same function written in Rust.
//!
//! `cargo bench -p isopatch --bench field` prints the best of a hundred runs. Both sides are compiled for the same
//! processor.

use isopatch::field::Field;
use isopatch::gallery;
use isopatch::geom::{Aabb, Interval, Jets, Point3, Points};
use std::hint::black_box;
use std::time::Instant;

const BATCH: usize = 1024;
const RUNS: usize = 100;
/// Batches between two looks at the clock.
const REPEATS: usize = 50;
/// Edge of the cells whose ranges are asked for.
const CELL: f64 = 0.05;

const C: f64 = 0.8 * 0.8;

/// The three factors u² + v², and 1 less one coordinate squared, with the sums of squares that they are made of.
#[inline(always)]
fn compiled_value(x: f64, y: f64, z: f64) -> f64 {
    let (x, y, z) = (x * x, y * y, z * z);
    let term = |a: f64, b: f64, c: f64| {
        let (s, t) = (a + b - C, c - 1.0);
        s * s + t * t
    };
    term(x, y, z) * term(y, z, x) * term(z, x, y) - 0.02
}

/// f and ∇f by the product rule.
#[inline(always)]
fn compiled_gradient(x: f64, y: f64, z: f64) -> [f64; 4] {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (s, t, u) = (xx + yy - C, yy + zz - C, zz + xx - C);
    let (a, b, c) = (zz - 1.0, xx - 1.0, yy - 1.0);
    let (p, q, r) = (s * s + a * a, t * t + b * b, u * u + c * c);
    let (qr, pr, pq) = (q * r, p * r, p * q);
    // Half the derivatives by the squares.
    let dx = s * qr + b * pr + u * pq;
    let dy = s * qr + t * pr + c * pq;
    let dz = a * qr + t * pr + u * pq;
    [p * qr - 0.02, 4.0 * x * dx, 4.0 * y * dy, 4.0 * z * dz]
}

/// ∇²f by the product rule for f = pqr − 0.02: xx, xy, xz, yy, yz, zz after f and ∇f.
#[inline(always)]
fn compiled_jet(x: f64, y: f64, z: f64) -> [f64; 10] {
    // One factor with its derivatives: d is the coordinate that stands alone.
    let factor = |a: f64, b: f64, d: f64| {
        let (s, t) = (a * a + b * b - C, d * d - 1.0);
        let slopes = [4.0 * a * s, 4.0 * b * s, 4.0 * d * t];
        (
            s * s + t * t,
            slopes,
            [4.0 * s + 8.0 * a * a, 8.0 * a * b, 4.0 * s + 8.0 * b * b, 4.0 * t + 8.0 * d * d],
        )
    };
    let (p, [px, py, pz], [pxx, pxy, pyy, pzz]) = factor(x, y, z);
    let (q, [qy, qz, qx], [qyy, qyz, qzz, qxx]) = factor(y, z, x);
    let (r, [rz, rx, ry], [rzz, rzx, rxx, ryy]) = factor(z, x, y);
    let (qr, pr, pq) = (q * r, p * r, p * q);
    let mixed = |[pi, qi, ri]: [f64; 3], [pj, qj, rj]: [f64; 3]| {
        (pi * qj + pj * qi) * r + (pi * rj + pj * ri) * q + (qi * rj + qj * ri) * p
    };
    let (i, j, k) = ([px, qx, rx], [py, qy, ry], [pz, qz, rz]);
    [
        p * qr - 0.02,
        px * qr + qx * pr + rx * pq,
        py * qr + qy * pr + ry * pq,
        pz * qr + qz * pr + rz * pq,
        pxx * qr + qxx * pr + rxx * pq + mixed(i, i),
        pxy * qr + mixed(i, j),
        rzx * pq + mixed(i, k),
        pyy * qr + qyy * pr + ryy * pq + mixed(j, j),
        qyz * pr + mixed(j, k),
        pzz * qr + qzz * pr + rzz * pq + mixed(k, k),
    ]
}

/// The same with intervals.
fn compiled_range(cell: &Aabb) -> Interval {
    let [x, y, z] = [0, 1, 2].map(|axis| cell.interval(axis).square());
    let (c, one) = (Interval::point(C), Interval::point(1.0));
    let term = |a: Interval, b: Interval, d: Interval| (a + b - c).square() + (d - one).square();
    term(x, y, z) * term(y, z, x) * term(z, x, y) - Interval::point(0.02)
}

/// Best time of a point, in nanoseconds.
fn nanoseconds(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        (0..REPEATS).for_each(|_| run());
        start.elapsed().as_secs_f64()
    };
    1e9 * (0..RUNS).map(once).fold(f64::INFINITY, f64::min) / (REPEATS * BATCH) as f64
}

fn row(name: &str, formula: f64, compiled: f64) {
    println!("{name:>10} {formula:8.2} {compiled:8.2} {:8.2}", compiled / formula);
}

fn main() {
    let field = gallery::surface("decocube").expect("it is in the gallery").field().expect("a formula");
    let at = |i: usize| Point3::from_fn(|axis, _| ((axis + 1) * i) as f64 / 777.0 % 2.0 - 1.0);
    let points: Points = (0..BATCH).map(at).collect();
    let cells: Vec<Aabb> = (0..BATCH).map(|i| Aabb::new(at(i), at(i).add_scalar(CELL))).collect();
    let (mut f, mut g, mut jets) = (vec![0.0; BATCH], Points::zeros(BATCH), Jets::zeros(BATCH));
    for i in 0..BATCH {
        let (p, close) = (points.get(i), |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + b.abs()));
        let compiled = compiled_gradient(p.x, p.y, p.z);
        let (value, gradient) = field.gradient(p);
        assert!(close(compiled[0], value) && close(compiled_value(p.x, p.y, p.z), value));
        assert!((0..3).all(|axis| close(compiled[axis + 1], gradient[axis])));
        let (compiled, hessian) = (compiled_jet(p.x, p.y, p.z), field.jet(p).hessian);
        let places = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        assert!((0..6).all(|k| close(compiled[4 + k], hessian[places[k]])));
    }

    println!("{:>10} {:>8} {:>8} {:>8}", "ns a point", "formula", "Rust", "ratio");
    let formula = nanoseconds(|| field.values(black_box(points.view()), &mut f));
    let compiled = nanoseconds(|| {
        let p = black_box(points.view());
        for (f, ((x, y), z)) in f.iter_mut().zip(p.x.iter().zip(p.y).zip(p.z)) {
            *f = compiled_value(*x, *y, *z);
        }
    });
    row("f", formula, compiled);
    let formula = nanoseconds(|| field.gradients(black_box(points.view()), &mut f, g.view_mut()));
    let compiled = nanoseconds(|| {
        let p = black_box(points.view());
        let out = f.iter_mut().zip(g.x.iter_mut().zip(&mut g.y).zip(&mut g.z));
        for ((f, ((gx, gy), gz)), ((x, y), z)) in out.zip(p.x.iter().zip(p.y).zip(p.z)) {
            [*f, *gx, *gy, *gz] = compiled_gradient(*x, *y, *z);
        }
    });
    row("f, grad f", formula, compiled);
    let formula = nanoseconds(|| field.jets(black_box(points.view()), &mut jets));
    let compiled = nanoseconds(|| {
        let p = black_box(points.view());
        let Jets { value, gradient, hessian: [xx, xy, xz, yy, yz, zz] } = &mut jets;
        // Arrays of one length, so that no index is checked in the loop.
        let [x, y, z] = [p.x, p.y, p.z].map(|a| &a[..BATCH]);
        let [f, gx, gy, gz, xx, xy, xz, yy, yz, zz] =
            [value, &mut gradient.x, &mut gradient.y, &mut gradient.z, xx, xy, xz, yy, yz, zz]
                .map(|a| &mut a[..BATCH]);
        for i in 0..BATCH {
            [f[i], gx[i], gy[i], gz[i], xx[i], xy[i], xz[i], yy[i], yz[i], zz[i]] =
                compiled_jet(x[i], y[i], z[i]);
        }
    });
    row("jet", formula, compiled);
    let mut ranges = vec![Interval::point(0.0); BATCH];
    let formula = nanoseconds(|| field.ranges(black_box(&cells), &mut ranges));
    let compiled =
        nanoseconds(|| ranges.iter_mut().zip(&cells).for_each(|(r, c)| *r = compiled_range(black_box(c))));
    row("range", formula, compiled);
}
