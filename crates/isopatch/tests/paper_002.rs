//! Bajaj & Xu 1997, sections 5 and 6, on the surfaces of its section 6.3, with meshes of exactly the sizes of the paper: 190, 280, 400 (the
//! paper's 370) and 540 triangles, vertices on the surface, and edges along its singular curves.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

use isopatch::bernstein::triangle;
use isopatch::geom::{Point3, Points, PointsMut, PointsView, Vec3};
use isopatch::network::wire_conic::Conic;
use isopatch::network::wire_cubic::Cubic;
use isopatch::rational::b_patch::BPatch;
use isopatch::rational::functional::{Vec2, VertexValue, functional_patch};
use isopatch::rational::pieces::{TRIANGLES, pieces};
use isopatch::rational::weighted::{WeightedNet, weighted_net};
use isopatch::rational::{BuildOptions, Frame, FrameSeam, RationalSurface, build, build_with, conic, cubic};
use isopatch::surface::{Continuity, PatchId, SeamSide, Surface, Target};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

/// A surface of section 6.3, or a smooth one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Cone,
    Whitney,
    Steiner,
    Toroidal,
    Sphere,
    Torus,
}

impl Shape {
    /// With the number of triangles, and the largest distance that an independent program found for this construction: 1.3e-3, 9.8e-3,
    /// 2.3e-2 and 1.8e-2, rounded to two digits.
    const PAPER: [(Self, usize, f64); 4] = [
        (Self::Cone, 190, 1.35e-3),
        (Self::Whitney, 280, 9.85e-3),
        (Self::Steiner, 400, 2.35e-2),
        (Self::Toroidal, 540, 1.85e-2),
    ];

    fn value(self, p: &Point3) -> f64 {
        let (x, y, z) = (p.x, p.y, p.z);
        match self {
            Self::Cone => x * x + y * y - z * z,
            Self::Whitney => x * x - y * z * z,
            Self::Steiner => x * x * y * y + y * y * z * z + z * z * x * x - 4.0 * x * y * z,
            Self::Toroidal => {
                (y * y + z * z - x * x + 0.5 * x.powi(3) - 4.0).powi(2) - 16.0 * x * x + 8.0 * x.powi(3)
            }
            Self::Sphere => p.norm_squared() - 1.0,
            Self::Torus => (p.norm_squared() + 3.0).powi(2) - 16.0 * (x * x + y * y),
        }
    }

    fn gradient(self, p: &Point3) -> Vec3 {
        let (x, y, z) = (p.x, p.y, p.z);
        match self {
            Self::Cone => 2.0 * Vec3::new(x, y, -z),
            Self::Whitney => Vec3::new(2.0 * x, -z * z, -2.0 * y * z),
            Self::Steiner => Vec3::new(
                2.0 * x * (y * y + z * z) - 4.0 * y * z,
                2.0 * y * (x * x + z * z) - 4.0 * x * z,
                2.0 * z * (x * x + y * y) - 4.0 * x * y,
            ),
            Self::Toroidal => {
                let q = y * y + z * z - x * x + 0.5 * x.powi(3) - 4.0;
                let by_x = 2.0 * q * (1.5 * x * x - 2.0 * x) - 32.0 * x + 24.0 * x * x;
                Vec3::new(by_x, 4.0 * q * y, 4.0 * q * z)
            }
            Self::Sphere => 2.0 * p,
            Self::Torus => 4.0 * (p.norm_squared() + 3.0) * p - 32.0 * Vec3::new(x, y, 0.0),
        }
    }

    /// The distance in which that check measures.
    fn distance(self, p: &Point3) -> f64 {
        self.value(p).abs() / self.gradient(p).norm().max(0.01)
    }
}

impl Target for Shape {
    fn project(&self, points: &mut Points) {
        for i in 0..points.len() {
            let mut p = points.get(i);
            for _ in 0..20 {
                let g = self.gradient(&p);
                p -= g * (self.value(&p) / g.norm_squared().max(1e-6));
            }
            points.set(i, p);
        }
    }

    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], mut normal: PointsMut<'_>) {
        for i in 0..offset.len() {
            let p = points.get(i);
            let g = self.gradient(&p);
            offset[i] = self.value(&p) / g.norm();
            let [x, y, z] = g.normalize().into();
            (normal.reborrow().x[i], normal.reborrow().y[i], normal.reborrow().z[i]) = (x, y, z);
        }
    }
}

/// Points with equal coordinates (to 1e-8) joined; triangles without area left out.
fn weld(points: Vec<Point3>, faces: Vec<[usize; 3]>) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let (mut numbers, mut positions) = (HashMap::new(), Vec::new());
    let number: Vec<u32> = points
        .into_iter()
        .map(|p| {
            let key = <[f64; 3]>::from(p).map(|c| (c / 1e-8).round() as i64);
            *numbers.entry(key).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        })
        .collect();
    let distinct = |f: &[u32; 3]| f[0] != f[1] && f[1] != f[2] && f[2] != f[0];
    (positions, faces.into_iter().map(|f| f.map(|v| number[v])).filter(distinct).collect())
}

fn linspace(from: f64, to: f64, intervals: usize) -> Vec<f64> {
    (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect()
}

/// A grid of parameters, its cells cut along alternating diagonals.
fn grid(at: impl Fn(f64, f64) -> Point3, us: &[f64], vs: &[f64]) -> (Vec<Point3>, Vec<[usize; 3]>) {
    let points = us.iter().flat_map(|u| vs.iter().map(|v| at(*u, *v)).collect::<Vec<_>>()).collect();
    let (rows, columns) = (us.len(), vs.len());
    let mut faces = Vec::new();
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let a = i * columns + j;
            let (b, c, d) = (a + columns, a + columns + 1, a + 1);
            faces.extend(if (i + j) % 2 == 1 { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
        }
    }
    (points, faces)
}

/// The structured mesh of a shape, `scale` times as fine as that of the paper's size.
fn mesh(shape: Shape, scale: usize) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let turn = |n: usize| linspace(0.0, 2.0 * PI, n * scale);
    let (points, faces) = match shape {
        Shape::Cone => {
            let (mut points, mut faces) = (Vec::new(), Vec::new());
            for side in [1.0, -1.0] {
                let at = |r: f64, t: f64| Vec3::new(r * t.cos(), r * t.sin(), side * r);
                let (p, f) = grid(at, &linspace(0.0, 2.0, 3 * scale), &turn(19));
                let first = points.len();
                points.extend(p);
                faces.extend(f.into_iter().map(|f| f.map(|v| v + first)));
            }
            (points, faces)
        }
        Shape::Whitney => {
            let at = |u: f64, v: f64| {
                let v = v * f64::min(2.0, 3.0 / u.abs().max(1e-9));
                Vec3::new(u * v, u * u, v)
            };
            let reach = 3.0f64.sqrt();
            grid(at, &linspace(-reach, reach, 10 * scale), &linspace(-1.0, 1.0, 14 * scale))
        }
        Shape::Steiner => steiner(10 * scale),
        Shape::Toroidal => {
            let reach = 1.6f64.sqrt();
            let mut ms = linspace(-reach, -1.0, 2 * scale);
            ms.extend(linspace(-1.0, 1.0, 11 * scale).into_iter().skip(1));
            ms.extend(linspace(1.0, reach, 2 * scale).into_iter().skip(1));
            let at = |m: f64, t: f64| {
                let (x, r) = (2.0 * (1.0 - m * m), 2.0 + 2.0 * m * (1.0 - m * m));
                Vec3::new(x, r * t.cos(), r * t.sin())
            };
            grid(at, &ms, &turn(18))
        }
        Shape::Sphere => {
            let at = |a: f64, b: f64| Vec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos());
            grid(at, &linspace(0.0, PI, 7 * scale), &turn(10))
        }
        Shape::Torus => {
            let at = |a: f64, b: f64| {
                let r = 2.0 + a.cos();
                Vec3::new(r * b.cos(), r * b.sin(), a.sin())
            };
            grid(at, &turn(12), &turn(18))
        }
    };
    weld(points, faces)
}

fn steiner(n: usize) -> (Vec<Point3>, Vec<[usize; 3]>) {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for signs in [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
        let mut number = HashMap::new();
        for i in 0..=n {
            for j in 0..=n - i {
                let q = Vec3::new(i as f64, j as f64, (n - i - j) as f64) / n as f64;
                let [a, b, c] = q.map(|x| (0.5 * PI * x).sin()).normalize().into();
                number.insert((i, j), points.len());
                points.push(4.0 * Vec3::new(signs[0] * b * c, signs[1] * c * a, signs[2] * a * b));
            }
        }
        for i in 0..n {
            for j in 0..n - i {
                let at = |i, j| number[&(i, j)];
                faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (points, faces)
}

/// Gradients below this are those of singular vertices.
const SINGULAR: f64 = 1e-7;

/// The frame of a mesh: normals from the gradient, none at singular vertices; smooth across edges of two triangles that are not along
/// the singular set.
fn frame(shape: Shape, positions: Vec<Point3>, faces: Vec<[u32; 3]>) -> Frame {
    let gradients: Vec<Option<Vec3>> =
        positions.iter().map(|p| Some(shape.gradient(p)).filter(|g| g.norm() > SINGULAR)).collect();
    let faces: Vec<[u32; 3]> = faces.into_iter().map(|f| oriented(f, &positions, &gradients)).collect();
    let mut edges: BTreeMap<[u32; 2], Vec<(u32, u8)>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let mut ends = [face[k], face[(k + 1) % 3]];
            ends.sort_unstable();
            edges.entry(ends).or_default().push((f as u32, k as u8));
        }
    }
    let mut seams = Vec::new();
    for (wire, (ends, sides)) in edges.into_iter().enumerate() {
        let is_singular = ends.iter().all(|v| gradients[*v as usize].is_none());
        let wire = wire as u32;
        match sides[..] {
            [first, second] if !is_singular => {
                seams.push(FrameSeam { first, second: Some(second), smooth: true, wire });
            }
            _ => {
                let alone = |side: &(u32, u8)| FrameSeam { first: *side, second: None, smooth: false, wire };
                seams.extend(sides.iter().map(alone));
            }
        }
    }
    let normals = faces.iter().map(|face| face.map(|v| gradients[v as usize])).collect();
    Frame { positions, faces, normals, seams }
}

/// The triangle turned so that its normal points along the gradients at its corners.
fn oriented(f: [u32; 3], positions: &[Point3], gradients: &[Option<Vec3>]) -> [u32; 3] {
    let [a, b, c] = f.map(|v| positions[v as usize]);
    let towards: Vec3 = f.iter().filter_map(|v| gradients[*v as usize]).map(|g| g.normalize()).sum();
    if (b - a).cross(&(c - a)).dot(&towards) < 0.0 { [f[0], f[2], f[1]] } else { f }
}

fn made(shape: Shape, scale: usize) -> (Frame, RationalSurface) {
    let (positions, faces) = mesh(shape, scale);
    let frame = frame(shape, positions, faces);
    let built = build(&frame).unwrap();
    assert_eq!(built.lost_normals, []);
    (frame, built.surface)
}

/// The same with the limit normals of the sheets at singular vertices, where they have some; with or without wires and middles that are
/// fitted to the surface.
fn with_limits(shape: Shape, scale: usize, fit: bool) -> RationalSurface {
    let (frame, _) = made(shape, scale);
    let is_singular: Vec<bool> =
        frame.positions.iter().map(|p| shape.gradient(p).norm() <= SINGULAR).collect();
    let normals: Vec<[Vec3; 3]> = frame
        .faces
        .iter()
        .map(|face| {
            let p = face.map(|v| frame.positions[v as usize]);
            [0, 1, 2].map(|c| match is_singular[face[c] as usize] {
                false => shape.gradient(&p[c]),
                true => limit(shape, &p, c),
            })
        })
        .collect();
    let on_curve = |seam: &&FrameSeam| frame.ends(seam.first).iter().all(|v| is_singular[*v as usize]);
    let mut singular: Vec<[u32; 2]> =
        frame.seams.iter().filter(on_curve).map(|s| frame.ends(s.first)).collect();
    singular.iter_mut().for_each(|ends| ends.sort_unstable());
    singular.sort_unstable();
    singular.dedup();
    let frame = Frame::over_sheets(frame.positions, frame.faces, &normals, &singular, &is_singular);
    let options = BuildOptions { target: fit.then_some(&shape as &dyn Target), ..BuildOptions::default() };
    let mut surface = build_with(&frame, &options).unwrap().surface;
    if fit {
        surface.fit_middles(&shape, 0.05);
    }
    surface
}

/// The normal of the sheet of a triangle close to its corner c, extrapolated to it.
fn limit(shape: Shape, p: &[Point3; 3], c: usize) -> Vec3 {
    let flat = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
    let middle = (p[0] + p[1] + p[2]) / 3.0;
    let at = |share: f64| {
        let mut q = p[c] + (middle - p[c]) * share;
        for _ in 0..12 {
            q -= flat * (shape.value(&q) / shape.gradient(&q).dot(&flat));
        }
        let n = shape.gradient(&q).normalize();
        if n.dot(&flat) < 0.0 { -n } else { n }
    };
    (2.0 * at(0.02) - at(0.04)).normalize()
}

/// Largest distance of lattice points of all patches.
fn distance(shape: Shape, surface: &RationalSurface) -> f64 {
    let lattice = triangle::lattice(12);
    let of_patch = |p: PatchId| {
        let at = lattice.iter().map(|l| shape.distance(&surface.sample(p, [l[0], l[1]]).point));
        at.fold(0.0, f64::max)
    };
    surface.patches().map(of_patch).fold(0.0, f64::max)
}

/// Parameters on a side of a seam at `t` of it, `inside` away from it.
fn beside(side: SeamSide, t: f64, inside: f64) -> [f64; 2] {
    let t = if side.reversed { 1.0 - t } else { t };
    let k = usize::from(side.edge);
    let mut l = [0.0; 3];
    l[(k + 2) % 3] = inside;
    l[k] = (1.0 - t) * (1.0 - inside);
    l[(k + 1) % 3] = t * (1.0 - inside);
    [l[0], l[1]]
}

/// Largest angle between the normals on both sides of the smooth seams, at the distance `inside` from them.
fn jump(surface: &RationalSurface, inside: f64) -> f64 {
    let mut widest = 0.0f64;
    for seam in surface.seams().iter().filter(|seam| seam.continuity == Continuity::G1) {
        let Some(second) = seam.second else { continue };
        for i in 1..16 {
            let t = f64::from(i) / 16.0;
            let [n, m] =
                [seam.first, second].map(|side| surface.sample(side.patch, beside(side, t, inside)).normal);
            widest = widest.max(n.cross(&m).norm().atan2(n.dot(&m)));
        }
    }
    widest
}

/// The sizes of the paper, the distances, tangent planes across every smooth edge, also those with a singular end, and no gaps.
#[test]
fn the_four_surfaces_of_section_6_3() {
    for (shape, patches, limit) in Shape::PAPER {
        let (frame, surface) = made(shape, 1);
        assert_eq!(surface.patch_count(), patches);
        assert!(frame.normals.iter().flatten().any(Option::is_none));
        let distance = distance(shape, &surface);
        let jumps = [0.0, 1e-4, 1e-5, 1e-6].map(|inside| jump(&surface, inside));
        println!("{shape:?}: distance {distance:.2e}, jumps {jumps:?}");
        // On a finer lattice than that of the other program, the toroidal surface has 2.0e-2.
        assert!(distance <= 1.08 * limit, "{shape:?}: {distance}");
        assert!(jumps[0] <= 2e-11, "{shape:?}: {jumps:?}");
        // Measured beside the edge, the angle falls with the distance, on all edges.
        assert!(jumps[1] > 8.0 * jumps[2] && jumps[2] > 8.0 * jumps[3], "{shape:?}: {jumps:?}");
        assert!(jumps[1] < 0.25f64.to_radians() || shape != Shape::Cone);
        for seam in surface.seams() {
            let Some(second) = seam.second else { continue };
            for i in 0..=16 {
                let t = f64::from(i) / 16.0;
                let [a, b] =
                    [seam.first, second].map(|side| surface.sample(side.patch, beside(side, t, 0.0)).point);
                assert_eq!(a, b, "{shape:?}");
            }
        }
    }
}

/// Sheets along a singular curve share its wires: all of them give the same bits there.
#[test]
fn sheets_share_the_wires_on_singular_curves() {
    let (_, surface) = made(Shape::Toroidal, 1);
    let mut on_curve: HashMap<u32, Vec<SeamSide>> = HashMap::new();
    for (s, seam) in surface.seams().iter().enumerate() {
        on_curve.entry(surface.curve(s)).or_default().push(seam.first);
    }
    let crossing: Vec<_> = on_curve.values().filter(|sides| sides.len() > 1).collect();
    assert_eq!(crossing.len(), 18);
    for sides in crossing {
        assert_eq!(sides.len(), 4);
        for i in 0..=16 {
            let t = f64::from(i) / 16.0;
            let start = |side: &SeamSide| surface.corners(side.patch)[usize::from(side.edge)];
            let at = |side: &SeamSide| {
                let reversed = start(side) != start(&sides[0]);
                surface.sample(side.patch, beside(SeamSide { reversed, ..*side }, t, 0.0)).point
            };
            assert!(sides.iter().all(|side| at(side) == at(&sides[0])));
        }
    }
}

/// Limit normals along singular curves leave poles only at points: the surfaces are closer then, and as smooth. Wires and middles that
/// are fitted make them closer still.
#[test]
fn limit_normals_and_fitted_wires() {
    for (shape, _, limit) in Shape::PAPER {
        let [plain, fitted] = [false, true].map(|fit| with_limits(shape, 1, fit));
        let distances = [&plain, &fitted].map(|surface| distance(shape, surface));
        let jumps = [0.0, 1e-5, 1e-6].map(|inside| jump(&fitted, inside));
        println!(
            "{shape:?}: {:.2e}, fitted {:.2e}, of {limit:.1e}; jumps {jumps:?}",
            distances[0], distances[1]
        );
        assert!(distances[0] <= limit && distances[1] <= distances[0]);
        assert!(jumps[0] <= 2e-11 && jumps[1] > 8.0 * jumps[2], "{shape:?}");
    }
}

/// On a regular torus halving the edges divides the error by 2^3.5 or more.
#[test]
fn order_of_convergence_on_a_torus() {
    let errors = [1, 2].map(|scale| distance(Shape::Torus, &made(Shape::Torus, scale).1));
    let order = (errors[0] / errors[1]).log2();
    println!("torus: {errors:?}, order {order:.2}");
    assert!(errors[0] < 2.1e-3 && order >= 3.5, "{errors:?}: {order}");
}

/// M moves the centroid by M, and nothing on the border: neither points nor tangent planes.
#[test]
fn the_middle_moves_and_keeps_tangent_planes() {
    let (_, mut surface) = made(Shape::Sphere, 1);
    let center = |s: &RationalSurface| s.sample(PatchId(20), [1.0 / 3.0; 2]).point;
    let (before, middle) = (center(&surface), Vec3::new(0.03, -0.02, 0.05));
    surface.set_middle(PatchId(20), middle);
    assert!((center(&surface) - before - middle).norm() < 1e-15);
    assert!(jump(&surface, 0.0) < 2e-11);
    assert!(jump(&surface, 1e-3) > 8.0 * jump(&surface, 1e-4));
}

/// Wires and middles moved to the surface make it closer, and nothing is lost across edges.
#[test]
fn fitted_wires_and_middles() {
    for scale in [1, 2] {
        let (frame, plain) = made(Shape::Torus, scale);
        let options = BuildOptions { target: Some(&Shape::Torus), ..BuildOptions::default() };
        let mut fitted = build_with(&frame, &options).unwrap().surface;
        let wires = distance(Shape::Torus, &fitted);
        fitted.fit_middles(&Shape::Torus, 0.05);
        let [before, after] = [&plain, &fitted].map(|surface| distance(Shape::Torus, surface));
        println!("torus: {before:.2e}, wires {wires:.2e}, middles {after:.2e}");
        assert!(after <= 0.6 * before && jump(&fitted, 0.0) <= 2e-11);
    }
}

/// Derivatives against differences, in patches with and without poles.
#[test]
fn derivatives_agree_with_differences() {
    let h = 1e-6;
    for shape in [Shape::Cone, Shape::Whitney, Shape::Steiner] {
        let (_, mut surface) = made(shape, 1);
        surface.set_middle(PatchId(3), Vec3::new(0.01, 0.02, 0.03));
        for patch in surface.patches().step_by(7).chain([PatchId(3)]) {
            let at = |u: f64, v: f64| surface.patch(patch).evaluate([u, v]);
            for (u, v) in [(0.3, 0.3), (0.9, 0.04), (0.05, 0.91), (0.02, 0.03), (0.5, 0.01)] {
                let t = at(u, v);
                let du = (at(u + h, v).point - at(u - h, v).point) / (2.0 * h);
                let dv = (at(u, v + h).point - at(u, v - h).point) / (2.0 * h);
                assert!(
                    (du - t.du).norm() < 1e-7 && (dv - t.dv).norm() < 1e-7,
                    "{shape:?} {patch:?} {u} {v}"
                );
            }
        }
    }
}

/// The form with weights, the NURBS pieces and the triangular B-spline are the patch; weights of pieces are positive. Degree 6 without
/// poles, 8 with one vertex without a tangent plane.
#[test]
fn all_forms_of_a_patch_are_the_same_surface() {
    for (shape, _, _) in Shape::PAPER {
        let (_, mut surface) = made(shape, 1);
        surface.set_middle(PatchId(5), Vec3::new(0.01, 0.0, -0.02));
        let mut degrees = BTreeMap::new();
        for patch in surface.patches().step_by(3) {
            let WeightedNet { degree, points } = surface.weighted(patch);
            *degrees.entry(*degree).or_insert(0) += 1;
            assert!(points.iter().all(|p| p.w >= 0.0));
            let corners = surface.corners(patch).map(|v| surface.positions()[v as usize]);
            let b_spline = BPatch::with_multiple_knots(*degree, points);
            for (piece, triangle) in pieces(*degree, points).iter().zip(&TRIANGLES) {
                let least = piece.points.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
                assert!(least > 0.0, "{shape:?} {patch:?}: {least}");
                for i in 0..=5 {
                    for j in 0..=5 {
                        let (s, tau) = (f64::from(i) / 5.0, f64::from(j) / 5.0);
                        let l: [f64; 3] = std::array::from_fn(|c| {
                            let [a, b, to] = [triangle[0][c], triangle[1][c], triangle[2][c]];
                            (1.0 - s) * a + s * ((1.0 - tau) * b + tau * to)
                        });
                        let expected = surface.sample(patch, [l[0], l[1]]).point;
                        let scale = corners.iter().map(|p| p.norm()).fold(1.0, f64::max);
                        assert!(
                            (piece.evaluate(s, tau) - expected).norm() < 1e-13 * scale,
                            "{shape:?} {patch:?}"
                        );
                        if l.iter().filter(|x| **x > 0.0).count() > 1 {
                            assert!((b_spline.evaluate([l[0], l[1]]) - expected).norm() < 1e-13 * scale);
                        }
                    }
                }
            }
        }
        println!("{shape:?}: {degrees:?}");
        assert!(degrees[&6] > 0 && degrees[&8] > 0);
    }
}

/// B-patches with knots of their own are the same surface too.
#[test]
fn b_patches_with_spread_knots() {
    let (_, surface) = made(Shape::Torus, 1);
    let patch = PatchId(11);
    let WeightedNet { degree, points } = surface.weighted(patch);
    let knots = [0usize, 1, 2].map(|c| {
        let knot = |i: usize| {
            let mut x = [0.02 * i as f64, -0.013 * i as f64, 0.007 * i as f64];
            x.rotate_left(c);
            x[c] += 1.0 - x.iter().sum::<f64>();
            x
        };
        (0..*degree).map(knot).collect::<Vec<_>>()
    });
    let b_patch = BPatch::new(*degree, points, knots).unwrap();
    for l in triangle::interior_lattice(7) {
        let expected = surface.sample(patch, [l[0], l[1]]).point;
        assert!((b_patch.evaluate([l[0], l[1]]) - expected).norm() < 1e-11);
    }
    let on_a_line = [0, 1, 2].map(|_| vec![[1.0 / 3.0; 3]; *degree]);
    assert!(BPatch::new(*degree, points, on_a_line).is_err());
    assert!(BPatch::new(*degree, points, [vec![], vec![], vec![]]).is_err());
}

/// The functional form: quadratics are reproduced (cubics would need second derivatives), neighbours are C1, and the B-patches of the
/// parts are the graph.
#[test]
fn functional_patches_are_c1() {
    let f = |p: Vec2| (p.x * 1.3).sin() + p.y * p.y * p.x;
    let gradient = |p: Vec2| Vec2::new(1.3 * (p.x * 1.3).cos() + p.y * p.y, 2.0 * p.x * p.y);
    let vertex = |x: f64, y: f64| {
        let at = Vec2::new(x, y);
        VertexValue { at, value: f(at), gradient: gradient(at) }
    };
    let [a, b, c, d] = [vertex(0.0, 0.0), vertex(1.0, 0.2), vertex(0.3, 0.9), vertex(1.2, 1.1)];
    let (left, right) = (functional_patch(&[a, b, c]).unwrap(), functional_patch(&[b, d, c]).unwrap());
    let value = |patch: &isopatch::rational::functional::FunctionalPatch, p: Vec2| {
        let [x, y, z] = patch.corners;
        let area = (y - x).perp(&(z - x));
        patch.value([
            (y - p).perp(&(z - p)) / area,
            (z - p).perp(&(x - p)) / area,
            (x - p).perp(&(y - p)) / area,
        ])
    };
    let h = 1e-5;
    for i in 0..=8 {
        let p = b.at + (c.at - b.at) * (f64::from(i) / 8.0);
        assert!((value(&left, p) - value(&right, p)).abs() < 1e-14);
        let across = Vec2::new(0.7, 0.7) * h;
        let slopes = [
            (value(&left, p) - value(&left, p - across)) / h,
            (value(&right, p + across) - value(&right, p)) / h,
        ];
        assert!((slopes[0] - slopes[1]).abs() < 1e-4, "{slopes:?}");
    }
    // Between the parts as well.
    let center = left.corners.iter().sum::<Vec2>() / 3.0;
    for corner in left.corners {
        let p = corner + (center - corner) * 0.6;
        let across = Vec2::new(corner.y - center.y, center.x - corner.x).normalize() * h;
        let slopes = [value(&left, p) - value(&left, p - across), value(&left, p + across) - value(&left, p)];
        assert!((slopes[0] - slopes[1]).abs() < 1e-4 * h);
    }
    let graph = left.b_patch(1).evaluate([0.2, 0.5]);
    assert!((value(&left, Vec2::new(graph.x, graph.y)) - graph.z).abs() < 1e-14);
    assert!(functional_patch(&[a, b, a]).is_none());
}

/// The schemes of the paper on the same meshes: conic wires and patches are G1 on every edge of the sphere to rounding; cubic ones, by least
/// squares, about.
#[test]
fn the_schemes_of_the_paper_on_a_sphere() {
    let (positions, faces) = mesh(Shape::Sphere, 1);
    let (mut conic_error, mut cubic_error, mut conic_distance) = (0.0f64, 0.0f64, 0.0f64);
    for face in faces {
        let face = oriented(face, &positions, &positions.iter().map(|p| Some(*p)).collect::<Vec<_>>());
        let p = face.map(|v| positions[v as usize]);
        let wires = [0, 1, 2].map(|k| {
            let end = (k + 1) % 3;
            Conic::with_two_normals([&p[k], &p[end]], [&p[k], &p[end]], &1e-9).unwrap()
        });
        let net = conic::cover(wires.each_ref());
        let functions = [0, 1, 2].map(|k| wires[k].normals([&p[k], &p[(k + 1) % 3]], &1e-9).unwrap());
        let conditions = [0, 1, 2].map(|k| conic::condition(&net, &functions[k], k));
        let Some(vectors) = conic::vectors(&conditions, &Vec3::zeros()) else { panic!("dependent normals") };
        let patch = conic::patch(&net, &vectors);
        assert_eq!(weighted_net(&patch).degree, 5);
        for k in 0..3 {
            for i in 0..=8 {
                let t = f64::from(i) / 8.0;
                let mut l = [0.0; 3];
                (l[k], l[(k + 1) % 3]) = (1.0 - t, t);
                let s = patch.evaluate([l[0], l[1]]);
                let n = (1.0 - t) * functions[k].numerator[0] + t * functions[k].numerator[1];
                let tangent = s.du.cross(&s.dv);
                conic_error = conic_error.max(tangent.cross(&n).norm().atan2(tangent.dot(&n)));
            }
        }
        for l in triangle::lattice(12) {
            conic_distance = conic_distance.max(Shape::Sphere.distance(&patch.evaluate([l[0], l[1]]).point));
        }
        let wires = [0, 1, 2].map(|k| {
            let end = (k + 1) % 3;
            let middle = (p[k] + p[end]).normalize();
            Cubic::through([&p[k], &middle, &p[end]], [&p[k], &p[end]], &1e-9)
        });
        let normals = [0, 1, 2].map(|k| wires[k].normals_least_squares([&p[k], &p[(k + 1) % 3]], 1e-10));
        let center = p.iter().sum::<Vec3>().normalize();
        let cover = cubic::cover(wires.each_ref(), [1.0 / 3.0; 3], &center).unwrap();
        assert!((cover.evaluate([1.0 / 3.0; 2]).point - center).norm() < 1e-14);
        assert!(cubic::cover(wires.each_ref(), [0.5, 0.5, 0.0], &center).is_none());
        let patch = cubic::patch(&cover, normals.each_ref(), 1e-10);
        cubic_error = cubic_error.max(patch.normal_error);
    }
    println!(
        "conic: {conic_error:.1e} rad, distance {conic_distance:.2e}; cubic: {:.3} deg",
        cubic_error.to_degrees()
    );
    assert!(conic_error < 1e-12 && conic_distance < 3e-3);
    assert!(cubic_error > 1e-6 && cubic_error < 0.05f64.to_radians());
}
