//! Polyhedra with gradients, and a plain hull over them: apexes as the paper places them, the element that is asked for.

#![allow(clippy::unwrap_used)] // These are tests.

use super::meshes::{noise, noise3};
use isopatch::geom::{Mat3, Point3, Vec3};
use isopatch::hull::{Class, Side};
use isopatch::hybrid::{
    Element, HermitePolygons, HybridEdge, HybridFace, HybridFunction, HybridHull, Quadric,
};
use isopatch::mesh::{FaceId, HalfEdgeMesh};

/// A polyhedron: vertices and faces, counter-clockwise seen from outside.
pub type Polyhedron = (Vec<Point3>, Vec<Vec<u32>>);

/// The convex hull of a few points around the origin, coplanar faces joined.
pub fn convex(vertices: Vec<Point3>) -> Polyhedron {
    let n = vertices.len();
    let mut planes: Vec<(Vec3, f64)> = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let normal = (vertices[j] - vertices[i]).cross(&(vertices[k] - vertices[i]));
                if normal.norm() < 1e-9 {
                    continue;
                }
                let height = normal.normalize().dot(&vertices[i]);
                let (normal, height) = (normal.normalize() * height.signum(), height.abs());
                let known =
                    planes.iter().any(|(m, h)| (m - normal).norm() < 1e-6 && (h - height).abs() < 1e-6);
                if !known && vertices.iter().all(|p| normal.dot(p) < height + 1e-6) {
                    planes.push((normal, height));
                }
            }
        }
    }
    let face = |(normal, height): &(Vec3, f64)| {
        let mut corners: Vec<u32> =
            (0..n as u32).filter(|v| (normal.dot(&vertices[*v as usize]) - height).abs() < 1e-6).collect();
        let center: Point3 =
            corners.iter().map(|v| vertices[*v as usize]).sum::<Point3>() / corners.len() as f64;
        let first = (vertices[corners[0] as usize] - center).normalize();
        let angle = |v: &u32| {
            let d = vertices[*v as usize] - center;
            normal.cross(&first).dot(&d).atan2(first.dot(&d))
        };
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        corners
    };
    let faces = planes.iter().map(face).collect();
    (vertices, faces)
}

/// All changes of sign of a point, and cyclic permutations of the coordinates.
fn orbit(p: [f64; 3]) -> Vec<Point3> {
    let mut found: Vec<Point3> = Vec::new();
    for signs in 0..8 {
        let sign = |c: usize| if signs >> c & 1 == 1 { -1.0 } else { 1.0 };
        for turn in 0..3 {
            let q = Point3::new(p[turn], p[(turn + 1) % 3], p[(turn + 2) % 3]);
            let q = Point3::new(sign(0) * q.x, sign(1) * q.y, sign(2) * q.z);
            if found.iter().all(|known| (known - q).norm() > 1e-9) {
                found.push(q);
            }
        }
    }
    found
}

const GOLDEN: f64 = 1.618_033_988_749_895;

pub fn cube() -> Polyhedron {
    convex(orbit([1.0, 1.0, 1.0]))
}

pub fn cuboctahedron() -> Polyhedron {
    convex(orbit([1.0, 1.0, 0.0]))
}

pub fn dodecahedron() -> Polyhedron {
    let mut vertices = orbit([1.0, 1.0, 1.0]);
    vertices.extend(orbit([0.0, 1.0 / GOLDEN, GOLDEN]));
    convex(vertices)
}

pub fn icosidodecahedron() -> Polyhedron {
    let mut vertices = orbit([0.0, 0.0, GOLDEN]);
    vertices.extend(orbit([0.5, GOLDEN / 2.0, GOLDEN * GOLDEN / 2.0]));
    convex(vertices)
}

pub fn rhombicuboctahedron() -> Polyhedron {
    convex(orbit([1.0, 1.0, 1.0 + 2f64.sqrt()]))
}

fn ring(n: usize, turn: f64, z: f64) -> Vec<Point3> {
    let angle = |k: usize| std::f64::consts::TAU * (k as f64 + turn) / n as f64;
    (0..n).map(|k| Point3::new(angle(k).cos(), angle(k).sin(), z)).collect()
}

pub fn prism(n: usize) -> Polyhedron {
    convex([ring(n, 0.0, -0.6), ring(n, 0.0, 0.6)].concat())
}

pub fn antiprism(n: usize) -> Polyhedron {
    convex([ring(n, 0.0, -0.5), ring(n, 0.5, 0.5)].concat())
}

/// A pyramid over a square, with no vertex on the height of its base's centre.
pub fn square_pyramid() -> Polyhedron {
    let mut vertices = ring(4, 0.0, -0.5);
    vertices.push(Point3::new(0.0, 0.0, 1.0));
    convex(vertices)
}

pub fn polygons((vertices, faces): &Polyhedron, gradients: &[Vec3]) -> HermitePolygons {
    let mesh = HalfEdgeMesh::from_faces(vertices.len(), faces).unwrap();
    HermitePolygons::new(mesh, vertices.clone(), gradients).unwrap()
}

/// A quadratic function x·Ax − 1 of a diagonal matrix.
#[derive(Clone, Copy, Debug)]
pub struct Ellipsoid(pub Vec3);

impl Ellipsoid {
    pub fn quadric(&self) -> Quadric {
        let [a, b, c]: [f64; 3] = (2.0 * self.0).into();
        Quadric {
            coefficients: [-1.0, 0.0, 0.0, 0.0, a, b, c, 0.0, 0.0, 0.0],
            center: Vec3::zeros(),
            scale: 1.0,
        }
    }

    /// The polyhedron with its vertices moved to the ellipsoid along rays from the origin.
    pub fn project(&self, (vertices, faces): Polyhedron) -> Polyhedron {
        let onto = |p: Point3| p / p.component_mul(&p).dot(&self.0).sqrt();
        (vertices.into_iter().map(onto).collect(), faces)
    }

    /// Stretched from the unit sphere, so that flat faces stay flat.
    pub fn stretch(&self, (vertices, faces): Polyhedron) -> Polyhedron {
        let scale = self.0.map(|a| 1.0 / a.sqrt());
        (vertices.into_iter().map(|p| p.normalize().component_mul(&scale)).collect(), faces)
    }
}

/// A sphere through a polyhedron whose vertices and gradients are then disturbed: faces are neither flat nor convex everywhere.
pub fn disturbed(
    (vertices, faces): Polyhedron,
    position: f64,
    gradient: f64,
    seed: usize,
) -> HermitePolygons {
    let at = |n: usize, k: usize| noise3(97 * seed + 2 * n + k);
    let normals: Vec<Vec3> =
        vertices.iter().enumerate().map(|(n, p)| p.normalize() + gradient * at(n, 1)).collect();
    let moved: Vec<Point3> =
        vertices.iter().enumerate().map(|(n, p)| p.normalize() + position * at(n, 0)).collect();
    // Lengths differ as well.
    let gradients: Vec<Vec3> =
        normals.iter().enumerate().map(|(n, g)| g * (1.0 + 0.3 * noise(seed + 31 * n))).collect();
    polygons(&(moved, faces), &gradients)
}

/// Heights of apexes above and below the polygon, in its diameter, beyond what the tangent planes ask for.
const CLEARANCE: f64 = 0.15;

/// Class of a polygon.
fn class_of(edges: &[Class]) -> Class {
    let any = |class| edges.contains(&class);
    match (any(Class::Positive), any(Class::Negative), any(Class::Nonconvex)) {
        (false, false, false) => Class::Zero,
        (true, false, false) => Class::Positive,
        (false, true, false) => Class::Negative,
        _ => Class::Nonconvex,
    }
}

/// A line through both diagonals of a quadrilateral, perpendicular to both: a point of it between them, and its direction.
pub fn diagonal_axis(p: &[Point3]) -> (Point3, Vec3) {
    let (d, e) = (p[2] - p[0], p[3] - p[1]);
    let feet = Mat3::from_columns(&[d, -e, d.cross(&e)]).try_inverse().unwrap() * (p[1] - p[0]);
    (0.5 * (p[0] + feet.x * d + p[1] + feet.y * e), d.cross(&e).normalize())
}

/// The element of a face by its class and number of corners.
pub type Choice = fn(Class, usize) -> Element;

/// Triangles, pyramids, and sectors for all else.
pub fn sectors(class: Class, corners: usize) -> Element {
    match (class, corners) {
        (Class::Nonconvex, _) => Element::Sectors,
        (_, 3) => Element::Triangle,
        (_, 4) => Element::Pyramid,
        _ => Element::Sectors,
    }
}

/// Fans wherever they are C1.
pub fn fans(_: Class, corners: usize) -> Element {
    if corners <= 4 { Element::Fan } else { Element::Sectors }
}

/// Fans for nonconvex faces alone.
pub fn mixed(class: Class, corners: usize) -> Element {
    if class == Class::Nonconvex && corners <= 4 { Element::Fan } else { sectors(class, corners) }
}

/// A hull with apexes above all tangent planes and a quadric for each face.
pub fn hull(data: HermitePolygons, choice: Choice, quadric: impl Fn(FaceId) -> Quadric) -> HybridHull {
    let mesh = data.mesh();
    let edge_class = |e| data.edge_class(mesh.edge_half_edge(e));
    let faces: Vec<HybridFace> = mesh
        .faces()
        .map(|f| {
            let frame = data.frame(f);
            let classes: Vec<Class> = mesh.face_half_edges(f).map(|h| edge_class(mesh.edge(h))).collect();
            let class = class_of(&classes);
            let element = (class != Class::Zero).then(|| choice(class, frame.count()));
            let mean: Point3 = frame.p.iter().sum::<Point3>() / frame.count() as f64;
            let area: Vec3 = (0..frame.count())
                .map(|k| (frame.p[k] - mean).cross(&(frame.p[frame.after(k)] - mean)))
                .sum();
            let (center, normal) = match element {
                Some(Element::Fan) if frame.count() == 4 => diagonal_axis(&frame.p),
                _ => (mean, area.normalize()),
            };
            let diameter =
                frame.p.iter().flat_map(|p| frame.p.iter().map(move |q| (p - q).norm())).fold(0.0, f64::max);
            let (mut up, mut down) = (0.0f64, 0.0f64);
            for k in 0..frame.count() {
                let tangent = (frame.p[k] - center).dot(&frame.n[k]) / normal.dot(&frame.n[k]);
                let g = &frame.middle[k];
                let middle =
                    -(3.0 * frame.on_edge(k, &frame.p[k]) + g.dot(&(center - frame.p[k]))) / g.dot(&normal);
                (up, down) = (up.max(tangent).max(middle), down.min(tangent).min(middle));
            }
            let both = matches!(element, Some(Element::Fan)) || class == Class::Nonconvex;
            let has = |side: Side| element.is_some() && (both || class.reaches(side));
            let at = [
                center + (up + CLEARANCE * diameter) * normal,
                center + (down - CLEARANCE * diameter) * normal,
            ];
            HybridFace {
                class,
                element,
                center,
                normal,
                apexes: Side::BOTH.map(|side| has(side).then(|| at[side.index()])),
                at_apex: [None; 2],
                quadric: quadric(f),
            }
        })
        .collect();
    let edges = mesh
        .edges()
        .map(|e| {
            let beside = data.joint(e).map(|pair| pair.map(|h| &faces[mesh.face(h).index()].apexes));
            let cells = [0, 1].map(|s| beside.is_some_and(|b| b.iter().all(|apexes| apexes[s].is_some())));
            HybridEdge { class: edge_class(e), cells }
        })
        .collect();
    HybridHull { data, faces, edges }
}

/// Each face's own sphere-like quadric: its curvatures are as those of the unit sphere, its gradient is that of the face.
pub fn rounded(data: &HermitePolygons, f: FaceId) -> Quadric {
    let frame = data.frame(f);
    let center: Point3 = frame.p.iter().sum::<Point3>() / frame.count() as f64;
    let g: Vec3 = frame.n.iter().sum::<Vec3>() / frame.count() as f64;
    let curve = 0.9 + 0.3 * noise(f.index());
    Quadric { coefficients: [-0.2, g.x, g.y, g.z, curve, curve, curve, 0.1, -0.1, 0.05], center, scale: 1.0 }
}

/// A function with random data over a polyhedron.
pub fn random(
    polyhedron: Polyhedron,
    choice: Choice,
    [position, gradient]: [f64; 2],
    seed: usize,
) -> HybridFunction {
    let data = disturbed(polyhedron, position, gradient, seed);
    let quadrics: Vec<Quadric> = data.mesh().faces().map(|f| rounded(&data, f)).collect();
    HybridFunction::new(hull(data, choice, |f| quadrics[f.index()]))
}
