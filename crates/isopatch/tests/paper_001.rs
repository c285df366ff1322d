//! The statements of Xu, Bajaj & Evans, C1 Modeling with Hybrid Multiple-sided A-patches, as far as they are true.
//!
//! Theorem 2.1 and Corollary 2.1 are tested where their formulas are, in `bernstein::pyramid`.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::bernstein::{cubic, tetrahedron};
use isopatch::geom::{Mat3, Point3, Vec3, angle_between};
use isopatch::hull::{Class, Side};
use isopatch::hybrid::{FaceCells, FanNet, Foot, HybridFunction, HybridSurface, Jet};
use isopatch::mesh::{EdgeId, FaceId};
use isopatch::surface::{PatchId, Surface};
use nalgebra::DMatrix;
use support::meshes::{noise, noise3};
use support::polyhedra::{self, Choice, Ellipsoid, Polyhedron};

fn barycentric([a, b, c, d]: [Point3; 4], x: &Point3) -> [f64; 4] {
    let r = Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse().unwrap() * (x - a);
    [1.0 - r.sum(), r.x, r.y, r.z]
}

fn rank(m: &DMatrix<f64>) -> usize {
    m.clone().svd(false, false).singular_values.iter().filter(|s| **s > 1e-9).count()
}

/// Points q_1 … q_k around the line from p_2 to p_3.
fn around(k: usize) -> (Vec<Point3>, [Point3; 2]) {
    let angle = |i: usize| std::f64::consts::TAU * (i as f64 + 0.2 * noise(i)) / k as f64;
    let q = |i: usize| {
        Point3::new(angle(i).cos(), angle(i).sin(), 0.3 * noise(i + 50)) * (1.0 + 0.2 * noise(i + 9))
    };
    ((0..k).map(q).collect(), [Point3::new(0.1, 0.0, -1.0), Point3::new(0.0, 0.1, 1.0)])
}

/// Rows of (2.13) or (2.14), one for each q_i of `which`: coefficients of the unknowns x_1 … x_k.
fn conditions(q: &[Point3], [p2, p3]: [Point3; 2], which: std::ops::Range<usize>) -> DMatrix<f64> {
    let k = q.len();
    let mut rows = DMatrix::zeros(which.len(), k);
    for (row, i) in which.enumerate() {
        let (before, after) = ((i + k - 1) % k, (i + 1) % k);
        let a = barycentric([q[before], q[after], p2, p3], &q[i]);
        rows[(row, i)] -= 1.0;
        rows[(row, before)] += a[0];
        rows[(row, after)] += a[1];
    }
    rows
}

/// Theorem 2.2: k − 2 of the k conditions around a closed edge are independent, and any two neighbouring ones can be left out.
/// Corollary 2.2: around an open one, the k − 2 inner conditions are independent.
#[test]
fn conditions_around_an_edge_have_two_too_many() {
    for k in 3..8 {
        let (q, p) = around(k);
        let all = conditions(&q, p, 0..k);
        assert_eq!(rank(&all), k - 2, "closed, {k}");
        for left_out in 0..k {
            let kept: Vec<_> = (0..k).filter(|i| *i != left_out && *i != (left_out + 1) % k).collect();
            assert_eq!(rank(&all.select_rows(&kept)), k - 2, "closed, {k}, without {left_out}");
        }
        // Any two unknowns whose points span space with the edge may be chosen: the others follow.
        let others: Vec<_> = (2..k).collect();
        assert_eq!(rank(&all.select_columns(&others)), k - 2);
        // A fan that does not close: half of twice as many points.
        let (q, p) = around(2 * k);
        let open = conditions(&q[..k], p, 1..k - 1);
        assert_eq!(rank(&open), k - 2, "open, {k}");
    }
}

/// Dimension of the cubics on [q_i q_(i+1) p_2 p_3] that are C1 across [q_i p_2 p_3]: unknowns less independent conditions.
fn dimension(q: &[Point3], [p2, p3]: [Point3; 2]) -> usize {
    let k = q.len();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for i in 0..k {
        let (before, after) = ((i + k - 1) % k, (i + 1) % k);
        // The net on sector `before` has q_i second, that on sector i has it first; q_(i+1) in the former's coordinates.
        let a = barycentric([q[before], q[i], p2, p3], &q[after]);
        let at = |sector: usize, ijkl: [usize; 4]| 20 * sector + tetrahedron::position(ijkl);
        for [n, l, m, _] in tetrahedron::indices(3).filter(|c| c[3] == 0) {
            // C0: q_i^n p_2^l p_3^m.
            let mut row = vec![0.0; 20 * k];
            row[at(before, [0, n, l, m])] += 1.0;
            row[at(i, [n, 0, l, m])] -= 1.0;
            rows.push(row);
        }
        for [n, l, m, _] in tetrahedron::indices(2).filter(|c| c[3] == 0) {
            // C1: q_(i+1) q_i^n p_2^l p_3^m.
            let mut row = vec![0.0; 20 * k];
            row[at(i, [n, 1, l, m])] -= 1.0;
            for (c, weight) in a.iter().enumerate() {
                let mut ijkl = [0, n, l, m];
                ijkl[c] += 1;
                row[at(before, ijkl)] += weight;
            }
            rows.push(row);
        }
    }
    let matrix = DMatrix::from_fn(rows.len(), 20 * k, |r, c| rows[r][c]);
    20 * k - rank(&matrix)
}

/// Theorem 2.3.
#[test]
fn cubics_around_an_edge_have_the_dimension_of_the_theorem() {
    for k in 3..7 {
        let (q, p) = around(k);
        assert_eq!(dimension(&q, p), 4 * k + 10);
    }
    // Four tetrahedra between two planes.
    let (x, y) = (Vec3::x(), Vec3::y());
    let crossed = [x, 1.3 * y, -0.8 * x, -1.1 * y];
    assert_eq!(dimension(&crossed, [-Vec3::z(), Vec3::z()]), 4 * 4 + 12);
}

/// What the paper concludes from Theorem 2.3 is not so: over a plane polygon F(v) and ∇F(v) do not occur in (4.10), (4.13), which are
/// conditions on the given gradients. With four corners and an axis through both diagonals nothing remains of them.
#[test]
fn fans_of_five_are_not_unisolvent_and_fans_of_four_need_their_diagonals() {
    let jet = |n: usize| Jet { value: noise(n), gradient: noise3(n + 7) };
    let defects = |f: &HybridFunction, face: usize, jet: Jet| {
        let hull = f.hull();
        let [u, v] = hull.faces[face].apexes.map(Option::unwrap);
        FanNet::new(&hull.data.frame(face.into()), &u, &v, &jet).defects()
    };
    let fan: Choice = |_, _| isopatch::hybrid::Element::Fan;
    let flat = polyhedra::random(polyhedra::dodecahedron(), fan, [0.0, 0.1], 3);
    for face in 0..12 {
        let (a, b) = (defects(&flat, face, jet(face)), defects(&flat, face, jet(face + 40)));
        assert_eq!(a.len(), 2 * 5 - 6);
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-10), "{a:?} {b:?}");
        assert!(a.iter().any(|d| d.abs() > 1e-3));
    }
    let quadrilaterals = polyhedra::random(polyhedra::cube(), fan, [0.2, 0.3], 5);
    for face in 0..6 {
        assert!(defects(&quadrilaterals, face, jet(face)).iter().all(|d| d.abs() < 1e-11));
    }
}

/// The foot in a face at a point of its edge k, with the weights of its start and its end.
fn on_edge(cells: &FaceCells, k: usize, [p, q]: [f64; 2]) -> Foot {
    match cells {
        FaceCells::Triangle { .. } => {
            let mut x = [0.0; 3];
            (x[k], x[(k + 1) % 3]) = (p, q);
            Foot::Triangle(x)
        }
        FaceCells::Pyramid(_) => {
            let corners = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]];
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            Foot::Pyramid([p * a[0] + q * b[0], p * a[1] + q * b[1]])
        }
        _ => Foot::Sector(k, [0.0, p, q]),
    }
}

/// Largest jumps of value and gradient across all faces between cells, relative to the largest gradient.
fn jumps(f: &HybridFunction) -> f64 {
    let hull = f.hull();
    let mesh = hull.data.mesh();
    let size = mesh.half_edges().map(|h| hull.data.gradient(h).norm()).fold(0.0, f64::max);
    let mut worst = 0.0f64;
    let mut compare = |a: (f64, Vec3), b: (f64, Vec3)| {
        worst = worst.max((a.0 - b.0).abs() / size).max((a.1 - b.1).norm() / size);
    };
    let at = |n: usize| 0.5 + 0.5 * noise(n);
    for e in mesh.edges() {
        for side in Side::BOTH {
            if f.edge_function(e, side).is_none() {
                continue;
            }
            for (n, h) in hull.data.joint(e).unwrap().into_iter().enumerate() {
                let face = mesh.face(h);
                for sample in 0..6 {
                    let (x, t) = (at(7 * e.index() + sample), 0.98 * at(sample + 100));
                    let ends = if n == 0 { [1.0 - x, x] } else { [x, 1.0 - x] };
                    let foot = on_edge(&f.faces()[face.index()], mesh.side(h), ends);
                    let in_face = f.in_face_cell(face, side, foot, t).unwrap();
                    let (left, right) = if n == 0 { (t, 0.0) } else { (0.0, t) };
                    let cell = [right, (1.0 - t) * (1.0 - x), (1.0 - t) * x, left];
                    compare(in_face, f.in_edge_cell(e, side, cell).unwrap());
                }
            }
        }
    }
    for face in mesh.faces() {
        let FaceCells::Sectors(sectors) = &f.faces()[face.index()] else { continue };
        let count = sectors.base.len();
        for k in 0..count {
            for sample in 0..6 {
                let (x, t) = (at(11 * k + sample), 0.98 * at(sample + 100));
                let before = (k + count - 1) % count;
                for side in Side::BOTH.into_iter().filter(|side| f.faces()[face.index()].has(*side)) {
                    let a = f.in_face_cell(face, side, Foot::Sector(k, [1.0 - x, x, 0.0]), t).unwrap();
                    let b = f.in_face_cell(face, side, Foot::Sector(before, [1.0 - x, 0.0, x]), t).unwrap();
                    compare(a, b);
                }
                if sectors.sides.iter().all(Option::is_some) {
                    let rest = (1.0 - x) * at(sample + 31);
                    let foot = Foot::Sector(k, [x, rest, 1.0 - x - rest]);
                    let [a, b] = Side::BOTH.map(|side| f.in_face_cell(face, side, foot, 0.0).unwrap());
                    compare(a, b);
                }
            }
        }
    }
    worst
}

fn bodies() -> Vec<(&'static str, Polyhedron)> {
    vec![
        ("cube", polyhedra::cube()),
        ("cuboctahedron", polyhedra::cuboctahedron()),
        ("dodecahedron", polyhedra::dodecahedron()),
        ("icosidodecahedron", polyhedra::icosidodecahedron()),
        ("rhombicuboctahedron", polyhedra::rhombicuboctahedron()),
        ("triangular prism", polyhedra::prism(3)),
        ("pentagonal prism", polyhedra::prism(5)),
        ("heptagonal prism", polyhedra::prism(7)),
        ("pentagonal antiprism", polyhedra::antiprism(5)),
        ("square pyramid", polyhedra::square_pyramid()),
    ]
}

/// Theorem 4.2: the function is C1 over the hull, whatever elements meet, over faces that are neither flat nor convex.
#[test]
fn the_function_is_continuous_with_its_gradient() {
    for (name, body) in bodies() {
        for (choice, bound) in
            [(polyhedra::sectors as Choice, 1e-11), (polyhedra::fans, 1e-10), (polyhedra::mixed, 1e-10)]
        {
            for seed in 0..3 {
                let f = polyhedra::random(body.clone(), choice, [0.05, 0.15 * seed as f64], seed);
                let worst = jumps(&f);
                assert!(worst < bound, "{name} {seed}: {worst:e}");
            }
        }
    }
}

/// With other values and gradients at the apexes too, of any size.
#[test]
fn free_parameters_keep_the_function_smooth() {
    for choice in [polyhedra::sectors as Choice, polyhedra::fans] {
        let f = polyhedra::random(polyhedra::icosidodecahedron(), choice, [0.05, 0.3], 2);
        let faces: Vec<FaceId> = f.hull().data.mesh().faces().collect();
        let mut jets = Vec::new();
        for face in faces {
            for side in Side::BOTH {
                if let Some(jet) = f.hull().faces[face.index()].jet(side) {
                    let n = 2 * face.index() + side.index();
                    let value = jet.value + 0.5 * noise(n);
                    jets.push((face, side, Jet { value, gradient: jet.gradient + 0.5 * noise3(n) }));
                }
            }
        }
        let all = f.clone().with_jets(&jets);
        assert!(jumps(&all) < 1e-10, "{:e}", jumps(&all));
        // Only what is at a changed face is computed again, and it is what a new function would have.
        let one = f.clone().with_jets(&jets[..1]);
        let anew = HybridFunction::new(one.hull().clone());
        for e in f.hull().data.mesh().edges() {
            for side in Side::BOTH {
                assert_eq!(one.edge_function(e, side), anew.edge_function(e, side));
            }
        }
        assert_eq!(one.faces(), anew.faces());
        assert_ne!(one.faces()[0], f.faces()[0]);
    }
}

/// The function has a gradient at the apex of a pyramid, but no second derivatives.
#[test]
fn pyramids_are_c1_at_their_apex_and_not_c2() {
    let f = polyhedra::random(polyhedra::cube(), |_, _| isopatch::hybrid::Element::Pyramid, [0.05, 0.1], 1);
    let face = FaceId(0);
    let side = Side::BOTH.into_iter().find(|side| f.faces()[0].has(*side)).unwrap();
    let apex = f.hull().faces[0].jet(side).unwrap().gradient;
    let gradient =
        |s: f64, t: f64, h: f64| f.in_face_cell(face, side, Foot::Pyramid([s, t]), 1.0 - h).unwrap().1;
    // Gradients close to the apex differ from that at it like the distance.
    let spread = |h: f64| {
        (0..9)
            .map(|n| (gradient(f64::from(n % 3) / 2.0, f64::from(n / 3) / 2.0, h) - apex).norm())
            .fold(0.0, f64::max)
    };
    assert!(spread(1e-3) < 1e-2 && spread(1e-6) < 1e-5);
    assert!((spread(1e-3) / spread(1e-4) - 10.0).abs() < 0.1);
    // But not like one linear function of the way: the middle of the base is not the mean of its corners.
    let slope = |s: f64, t: f64| (gradient(s, t, 1e-4) - apex) / 1e-4;
    let corners: Vec3 =
        [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].iter().map(|[s, t]| slope(*s, *t)).sum();
    assert!((slope(0.5, 0.5) - 0.25 * corners).norm() > 1e-2);
}

/// (5.1), (5.2) and (5.3): rays in a fan, from any point of it; the paper's evaluations A, B (5.4) and C differ in where they start.
#[test]
fn rays_of_fans_start_anywhere() {
    let fan: Choice = |_, _| isopatch::hybrid::Element::Fan;
    for (count, body) in
        [(3, polyhedra::antiprism(3)), (4, polyhedra::cube()), (5, polyhedra::dodecahedron())]
    {
        let f = polyhedra::random(body, fan, [0.05, 0.1], 4);
        let (hull, face) = (f.hull(), FaceId(0));
        let [u, v] = hull.faces[0].apexes.map(Option::unwrap);
        let frame = hull.data.frame(face);
        assert_eq!(frame.count(), count);
        let net = FanNet::new(&frame, &u, &v, &hull.faces[0].jet(Side::Inner).unwrap());
        let sectors = net.split([&u, &v], hull.faces[0].center);
        let p = &frame.p;
        for n in 0..30 {
            let (x, y) = (0.5 + 0.5 * noise(n), 0.5 + 0.5 * noise(n + 100));
            let q = match count {
                3 => x * p[0] + (1.0 - x) * (y * p[1] + (1.0 - y) * p[2]),
                4 => y * (x * p[0] + (1.0 - x) * p[1]) + (1.0 - y) * (x * p[3] + (1.0 - x) * p[2]),
                _ => x * hull.faces[0].center + (1.0 - x) * (y * p[0] + (1.0 - y) * p[1]),
            };
            // The tetrahedron [u v p_s p_(s+1)] that it is in.
            let inside = (0..count).map(|s| (s, barycentric([u, v, p[s], p[frame.after(s)]], &q)));
            let (s, beta) = inside.max_by(|a, b| a.1[2].min(a.1[3]).total_cmp(&b.1[2].min(b.1[3]))).unwrap();
            for (side, apex) in [(Side::Outer, u), (Side::Inner, v)] {
                let layers = net.ray(s, beta, side);
                for t in [0.0, 0.3, 0.8, 1.0] {
                    let point = q + t * (apex - q);
                    // The same function in the cells that are split at c: on the side of c where the point is.
                    let in_cell = Side::BOTH.into_iter().find_map(|side| {
                        let a = [u, v][side.index()];
                        let x = barycentric([a, sectors.center, p[s], p[frame.after(s)]], &point);
                        (x[0] > -1e-9).then(|| {
                            let s_ = side.sign();
                            let (base, d) = sectors.base[s].value([x[1], x[2], x[3]]);
                            let cell = &sectors.sides[side.index()].as_ref().unwrap()[s];
                            s_ * cell.value((s_ * base, d.map(|d| s_ * d)), x).0
                        })
                    });
                    let along = cubic::value(&layers, t);
                    assert!((along - in_cell.unwrap()).abs() < 1e-11, "{count} {n} {t}");
                }
            }
        }
    }
}

fn quadric_surface(body: Polyhedron, ellipsoid: Ellipsoid, choice: Choice) -> HybridSurface {
    let gradients: Vec<Vec3> = body.0.iter().map(|p| 2.0 * ellipsoid.0.component_mul(p)).collect();
    let data = polyhedra::polygons(&body, &gradients);
    HybridSurface::new(HybridFunction::new(polyhedra::hull(data, choice, |_| ellipsoid.quadric())))
}

/// Samples of all patches.
fn samples(surface: &HybridSurface) -> impl Iterator<Item = (PatchId, isopatch::surface::Sample)> + '_ {
    surface.patches().flat_map(move |patch| {
        (0..12).map(move |n| {
            let width = if let isopatch::surface::Domain::Polygon(n) = surface.domain(patch) {
                f64::from(n)
            } else {
                1.0
            };
            let (u, v) = (0.5 + 0.499 * noise(n), 0.5 + 0.499 * noise(n + 40));
            let v =
                if surface.domain(patch) == isopatch::surface::Domain::Triangle { (1.0 - u) * v } else { v };
            (patch, surface.sample(patch, [width * u, v]))
        })
    })
}

/// Data of a quadric give the quadric back, over every kind of face.
#[test]
fn quadrics_are_recovered() {
    let spheres = Ellipsoid(Vec3::new(1.0, 1.0, 1.0));
    let ellipsoid = Ellipsoid(Vec3::new(0.4, 0.9, 1.7));
    for (name, body) in bodies() {
        for choice in [polyhedra::sectors as Choice, polyhedra::fans, polyhedra::mixed] {
            let cases = [
                (spheres, spheres.project(body.clone())),
                (ellipsoid, ellipsoid.stretch(body.clone())),
                (ellipsoid, ellipsoid.project(body.clone())),
            ];
            for (quadric, body) in cases {
                let surface = quadric_surface(body, quadric, choice);
                for (patch, sample) in samples(&surface) {
                    let value = sample.point.component_mul(&sample.point).dot(&quadric.0) - 1.0;
                    let gradient = 2.0 * quadric.0.component_mul(&sample.point);
                    assert!(value.abs() / gradient.norm() < 1e-12, "{name} {patch:?}: {value:e}");
                    assert!(angle_between(&sample.normal, &gradient) < 1e-11, "{name} {patch:?}");
                }
            }
        }
    }
}

/// The surface goes through the vertices with the given normals, and its patches meet without gap or bend.
#[test]
fn patches_meet_in_their_seams_and_vertices() {
    for (name, body) in bodies() {
        for choice in [polyhedra::sectors as Choice, polyhedra::mixed] {
            let surface = HybridSurface::new(polyhedra::random(body.clone(), choice, [0.03, 0.1], 1));
            let (mut gap, mut jump, mut missing) = (0.0f64, 0.0f64, 0);
            for seam in surface.seams() {
                let second = seam.second.unwrap();
                for i in 0..=8 {
                    let at = |side: isopatch::surface::SeamSide| {
                        let x = f64::from(if side.reversed { 8 - i } else { i }) / 8.0;
                        surface
                            .sample(side.patch, surface.domain(side.patch).on_edge(side.edge, [1.0 - x, x]))
                    };
                    let (a, b) = (at(seam.first), at(second));
                    if a.point.x.is_nan() || b.point.x.is_nan() {
                        missing += 1;
                        continue;
                    }
                    gap = gap.max((a.point - b.point).norm());
                    jump = jump.max(angle_between(&a.normal, &b.normal));
                }
            }
            assert!(gap < 1e-13 && jump < 1e-12 && missing == 0, "{name}: {gap:e} {jump:e} {missing}");
            let data = &surface.function().hull().data;
            for f in data.mesh().faces() {
                for h in data.mesh().face_half_edges(f) {
                    let patch = PatchId(f.0);
                    let uv = surface.domain(patch).on_edge(data.mesh().side(h) as u8, [1.0, 0.0]);
                    let sample = surface.sample(patch, uv);
                    assert!((sample.point - data.position(h)).norm() < 1e-15, "{name} {f:?}");
                    assert!(angle_between(&sample.normal, &data.gradient(h)) < 1e-12, "{name} {f:?}");
                }
            }
        }
    }
}

/// Derivatives by the parameters are those of the points.
#[test]
fn derivatives_are_those_of_the_points() {
    let surface = HybridSurface::new(polyhedra::random(
        polyhedra::icosidodecahedron(),
        polyhedra::sectors,
        [0.03, 0.1],
        1,
    ));
    let h = 1e-6;
    for patch in surface.patches() {
        let at = |u: f64, v: f64| surface.sample(patch, [u, v]);
        let (u, v) = (0.31, 0.42);
        let sample = at(u, v);
        let du = (at(u + h, v).point - at(u - h, v).point) / (2.0 * h);
        let dv = (at(u, v + h).point - at(u, v - h).point) / (2.0 * h);
        assert!((du - sample.du).norm() < 1e-8 && (dv - sample.dv).norm() < 1e-8, "{patch:?}");
        assert!(sample.normal.dot(&sample.du).abs() < 1e-12 && sample.normal.dot(&sample.dv).abs() < 1e-12);
        assert!(sample.du.cross(&sample.dv).dot(&sample.normal) > 0.0, "{patch:?}");
    }
}

/// Boxes of parts hold what they are boxes of.
#[test]
fn boxes_hold_their_parts() {
    for choice in [polyhedra::sectors as Choice, polyhedra::mixed] {
        for body in [polyhedra::cuboctahedron(), polyhedra::icosidodecahedron(), polyhedra::cube()] {
            let surface = HybridSurface::new(polyhedra::random(body, choice, [0.03, 0.3], 6));
            for patch in surface.patches() {
                for n in 0..6 {
                    let width = if let isopatch::surface::Domain::Polygon(n) = surface.domain(patch) {
                        f64::from(n)
                    } else {
                        1.0
                    };
                    let corner = |c: usize| {
                        let (u, v) = (0.5 + 0.5 * noise(n + 9 * c), 0.5 + 0.5 * noise(n + 50 + 9 * c));
                        let triangle = surface.domain(patch) == isopatch::surface::Domain::Triangle;
                        [width * u, if triangle { (1.0 - u) * v } else { v }]
                    };
                    let triangle = [corner(0), corner(1), corner(2)];
                    let bounds = surface.part_bounds(patch, triangle);
                    for m in 0..10 {
                        let (x, y) = (0.5 + 0.5 * noise(m), 0.5 + 0.5 * noise(m + 20));
                        let w = [x, (1.0 - x) * y, (1.0 - x) * (1.0 - y)];
                        let uv = [0, 1].map(|i| (0..3).map(|c| w[c] * triangle[c][i]).sum());
                        let point = surface.sample(patch, uv).point;
                        assert!(
                            point.x.is_nan() || bounds.contains(&point),
                            "{patch:?} {uv:?} {point:?} {bounds:?}"
                        );
                    }
                }
            }
        }
    }
}

/// Points of the surface moved along their normals are inside and outside, and the function has the sign of that near it.
#[test]
fn points_know_their_side() {
    for body in [polyhedra::cube(), polyhedra::icosidodecahedron(), polyhedra::prism(7)] {
        let surface = HybridSurface::new(polyhedra::random(body, polyhedra::sectors, [0.03, 0.05], 1));
        let volume = surface.volume().unwrap();
        for (patch, sample) in samples(&surface) {
            for step in [1e-6, 1e-2] {
                assert_eq!(volume.is_inside(sample.point - step * sample.normal), Some(true), "{patch:?}");
                assert_eq!(volume.is_inside(sample.point + step * sample.normal), Some(false), "{patch:?}");
            }
            let (value, gradient) = volume.value(sample.point).unwrap();
            assert!(value.abs() < 1e-9 * gradient.norm() && angle_between(&gradient, &sample.normal) < 1e-7);
        }
        assert_eq!(volume.is_inside(Point3::zeros()), Some(true));
        assert_eq!(volume.is_inside(Point3::new(0.1, 3.0, 0.2)), Some(false));
    }
}

/// Open boundaries have no cells beyond them, and zero convex faces are their own patch; both meet their neighbours.
#[test]
fn plane_faces_and_open_boundaries_join_their_neighbours() {
    // A square with flat data between four that bend down, open around.
    let mut vertices: Vec<Point3> = Vec::new();
    for j in 0..4 {
        for i in 0..4 {
            let at = |k: i32| f64::from(k) - 1.5;
            let bend = |k: i32| if k == 0 || k == 3 { -0.2 } else { 0.0 };
            vertices.push(Point3::new(at(i), at(j), bend(i) + bend(j)));
        }
    }
    let faces: Vec<Vec<u32>> =
        (0..9).map(|n| 4 * (n / 3) + n % 3).map(|v| vec![v, v + 1, v + 5, v + 4]).collect();
    let normal = |p: &Point3| {
        let lean = |x: f64| if x.abs() > 1.0 { 0.4 * x.signum() } else { 0.0 };
        Vec3::new(lean(p.x), lean(p.y), 1.0)
    };
    let gradients: Vec<Vec3> = vertices.iter().map(normal).collect();
    let data = polyhedra::polygons(&(vertices, faces), &gradients);
    let quadrics: Vec<_> = data.mesh().faces().map(|f| polyhedra::rounded(&data, f)).collect();
    let function = HybridFunction::new(polyhedra::hull(data, polyhedra::sectors, |f| quadrics[f.index()]));
    assert_eq!(function.hull().faces[4].class, Class::Zero);
    let surface = HybridSurface::new(function);
    assert_eq!(surface.flat_count(), 1);
    let mesh = surface.function().hull().data.mesh();
    let edges: Vec<EdgeId> = mesh.face_half_edges(FaceId(4)).map(|h| mesh.edge(h)).collect();
    assert!(surface.square_edges().iter().all(|e| !edges.contains(e)));
    for seam in surface.seams().iter().filter(|seam| seam.second.is_some()) {
        for i in 0..=4 {
            let at = |side: isopatch::surface::SeamSide| {
                let x = f64::from(if side.reversed { 4 - i } else { i }) / 4.0;
                surface.sample(side.patch, surface.domain(side.patch).on_edge(side.edge, [1.0 - x, x]))
            };
            let (a, b) = (at(seam.first), at(seam.second.unwrap()));
            assert!((a.point - b.point).norm() < 1e-14, "{seam:?}");
            assert!(angle_between(&a.normal, &b.normal) < 1e-12, "{seam:?} {i}");
        }
    }
    assert_eq!(surface.volume().unwrap().is_inside(Point3::zeros()), None);
}
