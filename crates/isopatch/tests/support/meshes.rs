//! Triangle meshes with gradients: quadrics, tori, noise, and files.
#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::panic)] // Test data that is wrong has to stop the test.

use isopatch::geom::{Point3, Vec3};
use isopatch::hull::HermiteMesh;
use isopatch::mesh::{HalfEdgeMesh, normals};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The icosahedron with vertices on the unit sphere.
pub fn icosahedron() -> (Vec<Point3>, Vec<[u32; 3]>) {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut p = Vec::new();
    for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        p.extend([Point3::new(0.0, a, b), Point3::new(a, b, 0.0), Point3::new(b, 0.0, a)]);
    }
    let mut faces = Vec::new();
    for a in 0..12u32 {
        for b in 0..12 {
            for c in 0..12 {
                let [x, y, z] = [a, b, c].map(|v| p[v as usize]);
                let near = |x: Point3, y: Point3| ((x - y).norm() - 2.0).abs() < 1e-9;
                if a < b && a < c && near(x, y) && near(y, z) && near(z, x) && x.cross(&y).dot(&z) > 0.0 {
                    faces.push([a, b, c]);
                }
            }
        }
    }
    (p.into_iter().map(|p| p.normalize()).collect(), faces)
}

/// The icosahedron, every face split into four and its vertices put on the sphere, so many times.
pub fn icosphere(levels: usize) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let (mut p, mut faces) = icosahedron();
    for _ in 0..levels {
        let mut middle = std::collections::HashMap::new();
        let mut at = |a: u32, b: u32| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                p.push((p[a as usize] + p[b as usize]).normalize());
                p.len() as u32 - 1
            })
        };
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let [d, e, f] = [at(a, b), at(b, c), at(c, a)];
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        faces = finer;
    }
    (p, faces)
}

/// A rectangular grid of `nu` × `nv` points, cut into triangles with alternating diagonals; `periodic` in u, or in both.
pub fn grid(
    [nu, nv]: [usize; 2],
    periodic: [bool; 2],
    at: impl Fn(usize, usize) -> Point3,
) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let positions = (0..nu * nv).map(|n| at(n / nv, n % nv)).collect();
    let number = |i: usize, j: usize| ((i % nu) * nv + j % nv) as u32;
    let mut faces = Vec::new();
    for i in 0..nu - usize::from(!periodic[0]) {
        for j in 0..nv - usize::from(!periodic[1]) {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            faces.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    (positions, faces)
}

/// The mesh with its faces turned so that they agree with the gradients, if all or none do.
pub fn hermite(positions: Vec<Point3>, faces: &[[u32; 3]], gradients: &[Vec3]) -> HermiteMesh {
    let agrees = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| positions[v as usize]);
        (b - a).cross(&(c - a)).dot(&f.iter().map(|v| gradients[*v as usize]).sum::<Vec3>()) > 0.0
    };
    let turned: Vec<[u32; 3]> =
        if agrees(&faces[0]) { faces.to_vec() } else { faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect() };
    assert!(turned.iter().all(agrees), "faces and gradients disagree");
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &turned).unwrap();
    HermiteMesh::new(mesh, positions, gradients).unwrap()
}

/// A function x·Hx/2 + g·x + c by its diagonal Hessian.
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    pub h: Vec3,
    pub g: Vec3,
    pub c: f64,
}

impl Quadric {
    pub fn value(&self, p: &Point3) -> f64 {
        0.5 * p.component_mul(&self.h).dot(p) + self.g.dot(p) + self.c
    }

    pub fn gradient(&self, p: &Point3) -> Vec3 {
        p.component_mul(&self.h) + self.g
    }

    /// Distance to first order.
    pub fn distance(&self, p: &Point3) -> f64 {
        (self.value(p) / self.gradient(p).norm()).abs()
    }
}

/// Triangulations of quadrics with their gradients, by name.
pub fn quadrics() -> Vec<(&'static str, Quadric, HermiteMesh)> {
    let mut all = Vec::new();
    let mut add = |name, q: Quadric, (p, f): (Vec<Point3>, Vec<[u32; 3]>)| {
        let gradients: Vec<Vec3> = p.iter().map(|p| q.gradient(p)).collect();
        all.push((name, q, hermite(p, &f, &gradients)));
    };
    let quadric = |h: [f64; 3], g: [f64; 3], c: f64| Quadric { h: h.into(), g: g.into(), c };
    add("sphere", quadric([1.0; 3], [0.0; 3], -0.5), icosahedron());
    let axes = Vec3::new(2.0, 1.3, 0.7);
    let (p, f) = icosphere(1);
    let stretched = p.into_iter().map(|p| p.component_mul(&axes)).collect();
    add("ellipsoid", quadric(axes.map(|a| 1.0 / (a * a)).into(), [0.0; 3], -0.5), (stretched, f));
    let turn = |i: usize| TAU * i as f64 / 12.0;
    let around =
        |i: usize, radius: f64, z: f64| Point3::new(radius * turn(i).cos(), radius * turn(i).sin(), z);
    add(
        "hyperboloid of one sheet",
        quadric([1.0, 1.0, -1.0], [0.0; 3], -0.5),
        grid([12, 6], [true, false], |i, j| {
            let v = -1.0 + 0.4 * j as f64;
            around(i, v.cosh(), v.sinh())
        }),
    );
    add(
        "hyperboloid of two sheets",
        quadric([-1.0, -1.0, 1.0], [0.0; 3], -0.5),
        grid([5, 9], [false, false], |i, j| {
            let u = 0.3 + 0.3 * i as f64;
            around(j, u.sinh(), u.cosh())
        }),
    );
    add("cylinder", quadric([1.0, 1.0, 0.0], [0.0; 3], -0.5), {
        grid([12, 5], [true, false], |i, j| around(i, 1.0, 0.5 * j as f64))
    });
    add("cone", quadric([1.0, 1.0, -1.0], [0.0; 3], 0.0), {
        grid([12, 5], [true, false], |i, j| around(i, 0.5 + 0.375 * j as f64, 0.5 + 0.375 * j as f64))
    });
    let flat = |i: usize, j: usize, shift: [f64; 2]| {
        (-1.0 + 0.4 * i as f64 + shift[0], -1.0 + 0.4 * j as f64 + shift[1])
    };
    add("elliptic paraboloid", quadric([2.0, 1.2, 0.0], [0.0, 0.0, 1.0], 0.0), {
        grid([6, 6], [false, false], |i, j| {
            let (u, v) = flat(i, j, [0.0, 0.07]);
            Point3::new(u, v, -u * u - 0.6 * v * v)
        })
    });
    add("hyperbolic paraboloid", quadric([-2.0, 2.0, 0.0], [0.0, 0.0, 1.0], 0.0), {
        grid([6, 6], [false, false], |i, j| {
            let (u, v) = flat(i, j, [0.03, -0.07]);
            Point3::new(u, v, u * u - v * v)
        })
    });
    add("plane", quadric([0.0; 3], [0.0, 0.0, 1.0], 0.0), {
        grid([6, 6], [false, false], |i, j| {
            let (u, v) = flat(i, j, [0.03, -0.07]);
            Point3::new(u, v, 0.0)
        })
    });
    all
}

/// A repeatable number in [−1, 1] for every n.
pub fn noise(n: usize) -> f64 {
    let x = (n as f64 * 12.9898 + 4.1).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// Three of them.
pub fn noise3(n: usize) -> Vec3 {
    Vec3::new(noise(3 * n), noise(3 * n + 1), noise(3 * n + 2))
}

/// The icosahedron with moved vertices, and with gradients that are neither radial nor of unit length.
pub fn perturbed(position: f64, gradient: f64) -> HermiteMesh {
    let (p, faces) = icosahedron();
    let gradients: Vec<Vec3> = p.iter().enumerate().map(|(i, p)| p + gradient * noise3(i + 100)).collect();
    let moved: Vec<Point3> = p.iter().enumerate().map(|(i, p)| p + position * noise3(i)).collect();
    let mesh = HalfEdgeMesh::from_faces(moved.len(), &faces).unwrap();
    HermiteMesh::new(mesh, moved, &gradients).unwrap()
}

/// The torus with radii 1 and 0.4 as a grid, with its unit normals.
pub fn torus([nu, nv]: [usize; 2]) -> HermiteMesh {
    let at = |i: usize, j: usize| {
        let (u, v) = (TAU * i as f64 / nu as f64, TAU * j as f64 / nv as f64);
        let normal = Vec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin());
        (Point3::new(u.cos(), u.sin(), 0.0) + 0.4 * normal, normal)
    };
    let normals: Vec<Vec3> = (0..nu * nv).map(|n| at(n / nv, n % nv).1).collect();
    let (p, f) = grid([nu, nv], [true, true], |i, j| at(i, j).0);
    hermite(p, &f, &normals)
}

/// Distance to that torus.
pub fn torus_distance(p: &Point3) -> f64 {
    ((p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.4).abs()
}

/// A mesh of the test data with Loop normals; none if that is not there.
pub fn from_file(name: &str) -> Option<HermiteMesh> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("ISOPATCH_TEST_DATA").map_or(beside, PathBuf::from);
    read_off(&folder.join("meshes").join(name))
}

/// Triangles of an OFF file with Loop normals; none if that is not there. Vertices without faces are left out.
pub fn read_off(path: &Path) -> Option<HermiteMesh> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut words = text.lines().filter(|l| !l.starts_with('#')).flat_map(str::split_whitespace).skip(1);
    let mut next = || words.next().unwrap();
    let counts: [usize; 3] = std::array::from_fn(|_| next().parse().unwrap());
    let all: Vec<Point3> =
        (0..counts[0]).map(|_| Point3::from([(); 3].map(|()| next().parse::<f64>().unwrap()))).collect();
    let mut number = vec![u32::MAX; all.len()];
    let mut positions = Vec::new();
    let faces: Vec<[u32; 3]> = (0..counts[1])
        .map(|_| {
            assert_eq!(next(), "3");
            [(); 3].map(|()| {
                let v: usize = next().parse().unwrap();
                if number[v] == u32::MAX {
                    number[v] = positions.len() as u32;
                    positions.push(all[v]);
                }
                number[v]
            })
        })
        .collect();
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
    let normals = normals::loop_limit(&mesh, &positions);
    Some(HermiteMesh::new(mesh, positions, &normals).unwrap())
}
