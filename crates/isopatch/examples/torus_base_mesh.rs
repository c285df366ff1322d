//! Prints `models/torus-20x10.off`: the regular base mesh of the torus (Tong & Kim 2009, figure 9).
//!
//! Its vertices are a grid in the angles of the torus of radii 5 and 1, 20 around the axis and 10 around the tube;
//! every cell of the grid is cut in two along the same diagonal: 400 faces.

use std::f64::consts::TAU;

/// Vertices around the axis and around the tube.
const AROUND: (usize, usize) = (20, 10);
/// Radii of the axis circle and of the tube.
const RADII: (f64, f64) = (5.0, 1.0);

fn main() {
    let (m, n) = AROUND;
    println!("OFF");
    println!("# torus, radii {} and {}, on a regular {m} x {n} grid", RADII.0, RADII.1);
    println!("{} {} 0", m * n, 2 * m * n);
    for i in 0..m {
        for j in 0..n {
            let [x, y, z] = vertex(TAU * i as f64 / m as f64, TAU * j as f64 / n as f64);
            println!("{x} {y} {z}");
        }
    }
    let number = |i: usize, j: usize| (i % m) * n + j % n;
    for i in 0..m {
        for j in 0..n {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            println!("3 {a} {b} {c}");
            println!("3 {a} {c} {d}");
        }
    }
}

/// The point at angle `u` around the axis and `w` around the tube.
fn vertex(u: f64, w: f64) -> [f64; 3] {
    let (axis, tube) = RADII;
    let r = axis + tube * w.cos();
    [r * u.cos(), r * u.sin(), tube * w.sin()]
}
