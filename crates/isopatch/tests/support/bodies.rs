//! Polyhedra with vertices on the unit sphere, and grids of quadrilaterals on other quadrics.
#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::panic)] // Test data that is wrong has to stop the test.

use isopatch::geom::{Mat3, Point3, Vec3};
use std::f64::consts::TAU;

/// A polygon mesh with a name.
pub struct Body {
    pub name: &'static str,
    pub positions: Vec<Point3>,
    pub faces: Vec<Vec<u32>>,
}

/// The faces of the convex hull of points in convex position, counter-clockwise seen from outside.
pub fn convex_faces(p: &[Point3]) -> Vec<Vec<u32>> {
    const ON_PLANE: f64 = 1e-9;
    let mut faces: Vec<Vec<u32>> = Vec::new();
    let count = p.len();
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let Some(normal) = (p[b] - p[a]).cross(&(p[c] - p[a])).try_normalize(1e-9) else { continue };
                let heights: Vec<f64> = p.iter().map(|q| (q - p[a]).dot(&normal)).collect();
                let above = heights.iter().any(|h| *h > ON_PLANE);
                let below = heights.iter().any(|h| *h < -ON_PLANE);
                if above && below {
                    continue;
                }
                let outward = if above { -normal } else { normal };
                let corners: Vec<u32> =
                    (0..count as u32).filter(|v| heights[*v as usize].abs() <= ON_PLANE).collect();
                // Each face is found once, by its first three corners.
                if [a, b, c].map(|v| v as u32) == corners[..3] {
                    faces.push(around(p, corners, &outward));
                }
            }
        }
    }
    faces
}

fn around(p: &[Point3], mut corners: Vec<u32>, normal: &Vec3) -> Vec<u32> {
    let at = |v: u32| p[v as usize];
    let center = corners.iter().map(|v| at(*v)).sum::<Vec3>() / corners.len() as f64;
    let first = (at(corners[0]) - center).normalize();
    let second = normal.cross(&first);
    let angle = |v: &u32| (at(*v) - center).dot(&second).atan2((at(*v) - center).dot(&first));
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    corners
}

/// All points with these coordinates up to signs, in the given orders of the coordinates.
fn signed(coordinates: [f64; 3], orders: &[[usize; 3]], keep: impl Fn(usize, usize) -> bool) -> Vec<Point3> {
    let mut points: Vec<Point3> = Vec::new();
    for (n, order) in orders.iter().enumerate() {
        for signs in 0..8usize {
            let sign = |k: usize| if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
            let moved = order.map(|k| coordinates[k]);
            let p = Point3::from([0, 1, 2].map(|k| sign(k) * moved[k]));
            if keep(n, signs.count_ones() as usize) && points.iter().all(|q| (q - p).norm() > 1e-9) {
                points.push(p);
            }
        }
    }
    points
}

const CYCLIC: [[usize; 3]; 3] = [[0, 1, 2], [2, 0, 1], [1, 2, 0]];
const ALL: [[usize; 3]; 6] = [[0, 1, 2], [2, 0, 1], [1, 2, 0], [0, 2, 1], [1, 0, 2], [2, 1, 0]];

fn ring(n: usize, z: f64, turn: f64) -> impl Iterator<Item = Point3> {
    (0..n).map(move |i| {
        let angle = TAU * (i as f64 + turn) / n as f64;
        Point3::new(angle.cos(), angle.sin(), z)
    })
}

/// Polyhedra of triangles, quadrilaterals, pentagons and larger polygons; all vertices have distance 1 from the origin.
pub fn bodies() -> Vec<Body> {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    // The real root of t³ = t² + t + 1.
    let t = 1.839_286_755_214_161;
    let any = |_: usize, _: usize| true;
    let points: Vec<(&'static str, Vec<Point3>)> = vec![
        ("cube", signed([1.0; 3], &CYCLIC[..1], any)),
        ("dodecahedron", {
            let mut p = signed([1.0; 3], &CYCLIC[..1], any);
            p.extend(signed([0.0, 1.0 / g, g], &CYCLIC, any));
            p
        }),
        ("cuboctahedron", signed([1.0, 1.0, 0.0], &CYCLIC, any)),
        ("icosidodecahedron", {
            let mut p = signed([0.0, 0.0, g], &CYCLIC, any);
            p.extend(signed([0.5, 0.5 * g, 0.5 * g * g], &CYCLIC, any));
            p
        }),
        ("rhombicuboctahedron", signed([1.0, 1.0, 1.0 + 2f64.sqrt()], &CYCLIC, any)),
        // Even orders with an even number of minus signs, odd ones with an odd number.
        ("snub cube", signed([1.0, 1.0 / t, t], &ALL, |order, minus| (order < 3) == (minus % 2 == 0))),
        ("triangular prism", ring(3, -0.7, 0.0).chain(ring(3, 0.7, 0.0)).collect()),
        ("pentagonal prism", ring(5, -0.6, 0.0).chain(ring(5, 0.6, 0.0)).collect()),
        ("heptagonal prism", ring(7, -0.5, 0.0).chain(ring(7, 0.5, 0.0)).collect()),
        ("pentagonal antiprism", ring(5, -0.5, 0.0).chain(ring(5, 0.5, 0.5)).collect()),
        ("square pyramid", ring(4, -0.3, 0.0).map(|p| p.normalize()).chain([Point3::z()]).collect()),
        ("pentagonal pyramid", ring(5, -0.3, 0.0).map(|p| p.normalize()).chain([Point3::z()]).collect()),
    ];
    let body = |(name, p): (&'static str, Vec<Point3>)| {
        let positions: Vec<Point3> = p.into_iter().map(|p| p.normalize()).collect();
        Body { name, faces: convex_faces(&positions), positions }
    };
    points.into_iter().map(body).collect()
}

/// A function x·Hx/2 + g·x + c.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic {
    pub h: Mat3,
    pub g: Vec3,
    pub c: f64,
}

impl Quadratic {
    pub fn value(&self, p: &Point3) -> f64 {
        0.5 * p.dot(&(self.h * p)) + self.g.dot(p) + self.c
    }

    pub fn gradient(&self, p: &Point3) -> Vec3 {
        self.h * p + self.g
    }

    /// Distance to first order.
    pub fn distance(&self, p: &Point3) -> f64 {
        (self.value(p) / self.gradient(p).norm()).abs()
    }

    fn diagonal(h: [f64; 3], g: [f64; 3], c: f64) -> Self {
        Self { h: Mat3::from_diagonal(&h.into()), g: g.into(), c }
    }
}

/// An open grid of quadrilaterals.
pub fn grid(name: &'static str, [nu, nv]: [u32; 2], closed: bool, at: impl Fn(f64, f64) -> Point3) -> Body {
    let columns = if closed { nu } else { nu + 1 };
    let positions = (0..columns * (nv + 1))
        .map(|n| at(f64::from(n % columns) / f64::from(nu), f64::from(n / columns) / f64::from(nv)))
        .collect();
    let number = |i: u32, j: u32| j * columns + i % columns;
    let faces = (0..nv).flat_map(|j| (0..nu).map(move |i| (i, j)));
    let quad =
        |(i, j): (u32, u32)| vec![number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
    Body { name, positions, faces: faces.map(quad).collect() }
}

/// Quadrics through polygon meshes: the function, negative inside or below, and the mesh.
pub fn quadrics() -> Vec<(Quadratic, Body)> {
    let mut all: Vec<(Quadratic, Body)> =
        bodies().into_iter().map(|body| (Quadratic::diagonal([1.0; 3], [0.0; 3], -0.5), body)).collect();
    let axes = Vec3::new(2.0, 1.3, 0.7);
    for body in bodies() {
        let positions = body.positions.iter().map(|p| p.component_mul(&axes)).collect();
        let h = axes.map(|a| 1.0 / (a * a));
        all.push((Quadratic::diagonal(h.into(), [0.0; 3], -0.5), Body { positions, ..body }));
    }
    let plane = |u: f64, v: f64| (2.0 * u - 1.0, 2.0 * v - 1.0);
    let over = |name, f: fn(f64, f64) -> f64| {
        grid(name, [4, 4], false, move |u, v| {
            let (x, y) = plane(u, v);
            Point3::new(x, y, f(x, y))
        })
    };
    let up = [0.0, 0.0, 1.0];
    all.push((
        Quadratic::diagonal([0.8, 1.2, 0.0], up, 0.0),
        over("elliptic paraboloid", |x, y| -0.4 * x * x - 0.6 * y * y),
    ));
    all.push((
        Quadratic::diagonal([-0.8, 1.0, 0.0], up, 0.0),
        over("hyperbolic paraboloid", |x, y| 0.4 * x * x - 0.5 * y * y),
    ));
    let twisted = Mat3::new(0.0, -0.6, 0.0, -0.6, 0.0, 0.0, 0.0, 0.0, 0.0);
    let saddle = Quadratic { h: twisted, g: up.into(), c: 0.0 };
    all.push((saddle, over("hyperbolic paraboloid along its lines", |x, y| 0.6 * x * y)));
    let waist = grid("hyperboloid", [8, 4], true, |u, v| {
        let (angle, z) = (TAU * u, 1.6 * v - 0.8);
        let r = (1.0 + z * z).sqrt();
        Point3::new(r * angle.cos(), r * angle.sin(), z)
    });
    all.push((Quadratic::diagonal([1.0, 1.0, -1.0], [0.0; 3], -0.5), waist));
    all
}
