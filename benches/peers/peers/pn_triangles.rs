//! PN triangles (Vlachos et al. 2001), written for this comparison, as a process that answers requests `grid RESOLUTION`:
//! points with normals on the lattice of every face of a torus, by a table of the basis. They are smooth to the eye only.

use cpu_time::ProcessTime;
use std::f64::consts::TAU;
use std::io::{self, BufRead, Write};

type V = [f64; 3];

const AROUND: usize = 200;
const ACROSS: usize = 100;

fn combine<const N: usize>(weights: &[f64; N], points: &[V; N]) -> V {
    std::array::from_fn(|i| (0..N).map(|k| weights[k] * points[k][i]).sum())
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: V) -> V {
    let s = 1.0 / dot(a, a).sqrt();
    a.map(|x| s * x)
}

/// Control points b300, b030, b003, b210, b120, b021, b012, b102, b201, b111, and control normals n200, n020, n002, n110,
/// n011, n101.
struct Patch {
    points: [V; 10],
    normals: [V; 6],
}

impl Patch {
    fn new(p: [V; 3], n: [V; 3]) -> Self {
        // A third along the edge, moved into the tangent plane of its start.
        let third = |i: usize, j: usize| -> V {
            let w: f64 = (0..3).map(|c| (p[j][c] - p[i][c]) * n[i][c]).sum();
            std::array::from_fn(|c| (2.0 * p[i][c] + p[j][c] - w * n[i][c]) / 3.0)
        };
        let edges = [third(0, 1), third(1, 0), third(1, 2), third(2, 1), third(2, 0), third(0, 2)];
        let middle: V = std::array::from_fn(|c| {
            let e = edges.iter().map(|q| q[c]).sum::<f64>() / 6.0;
            e + (e - (p[0][c] + p[1][c] + p[2][c]) / 3.0) / 2.0
        });
        // The sum of the normals, reflected in the plane across the edge.
        let between = |i: usize, j: usize| -> V {
            let d: V = std::array::from_fn(|c| p[j][c] - p[i][c]);
            let sum: V = std::array::from_fn(|c| n[i][c] + n[j][c]);
            let v = 2.0 * dot(d, sum) / dot(d, d);
            unit(std::array::from_fn(|c| sum[c] - v * d[c]))
        };
        let [e0, e1, e2, e3, e4, e5] = edges;
        Self {
            points: [p[0], p[1], p[2], e0, e1, e2, e3, e4, e5, middle],
            normals: [n[0], n[1], n[2], between(0, 1), between(1, 2), between(2, 0)],
        }
    }
}

fn torus() -> Vec<Patch> {
    let vertex = |i: usize, j: usize| -> (V, V) {
        let (a, b) = (TAU * i as f64 / AROUND as f64, TAU * j as f64 / ACROSS as f64);
        let normal = [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()];
        let r = 1.0 + 0.4 * b.cos();
        ([r * a.cos(), r * a.sin(), 0.4 * b.sin()], normal)
    };
    let patch = |corners: [(usize, usize); 3]| {
        let all = corners.map(|(i, j)| vertex(i, j));
        Patch::new(all.map(|v| v.0), all.map(|v| v.1))
    };
    let of_square = |i: usize, j: usize| {
        [patch([(i, j), (i + 1, j), (i + 1, j + 1)]), patch([(i, j), (i + 1, j + 1), (i, j + 1)])]
    };
    (0..AROUND).flat_map(|i| (0..ACROSS).flat_map(move |j| of_square(i, j))).collect()
}

/// Weights of points and normals on a lattice.
fn table(n: usize) -> Vec<([f64; 10], [f64; 6])> {
    let part = |i: usize| i as f64 / n as f64;
    let at = |u: f64, v: f64, w: f64| {
        let points = [
            u * u * u,
            v * v * v,
            w * w * w,
            3.0 * u * u * v,
            3.0 * u * v * v,
            3.0 * v * v * w,
            3.0 * v * w * w,
            3.0 * w * w * u,
            3.0 * w * u * u,
            6.0 * u * v * w,
        ];
        (points, [u * u, v * v, w * w, u * v, v * w, w * u])
    };
    (0..=n).flat_map(|i| (0..=n - i).map(move |j| at(part(i), part(j), part(n - i - j)))).collect()
}

fn run(patches: &[Patch], table: &[([f64; 10], [f64; 6])], out: &mut [(V, V)]) {
    for (patch, out) in patches.iter().zip(out.chunks_exact_mut(table.len())) {
        for ((points, normals), (point, normal)) in table.iter().zip(out) {
            *point = combine(points, &patch.points);
            *normal = unit(combine(normals, &patch.normals));
        }
    }
}

fn main() -> io::Result<()> {
    let patches = torus();
    let mut out = io::stdout().lock();
    writeln!(out, "ready")?;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let Some(n) = line.split('\t').nth(1).and_then(|word| word.parse().ok()) else {
            writeln!(out, "error=no resolution")?;
            continue;
        };
        let table = table(n);
        let mut values = vec![([0.0; 3], [0.0; 3]); patches.len() * table.len()];
        // Once to touch all memory, then once on the clock.
        run(&patches, &table, &mut values);
        let start = ProcessTime::now();
        run(&patches, &table, &mut values);
        let seconds = start.elapsed().as_secs_f64();
        writeln!(out, "seconds={seconds}\tpoints={}", std::hint::black_box(&values).len())?;
        out.flush()?;
    }
    Ok(())
}
