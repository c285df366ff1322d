use super::*;
use crate::apatch::{self, APatchOptions, APatchSurface};
use crate::geom::Vec3;
use crate::hull::test_meshes::{from_file, noise, noise3, perturbed, quadrics, torus, torus_distance};
use crate::hull::{self, HermiteMesh, HullOptions};
use crate::mesh::normals::{NormalRule, at_corners};
use crate::mesh::{HalfEdgeMesh, creases};
use crate::surface::{Continuity, Domain, PatchForm, Sample, Seam, SeamSide};
use crate::tessellate::{APatchResolution, tessellate_a_patches};

fn surface(data: HermiteMesh) -> APatchSurface {
    APatchSurface::new(apatch::build(hull::build(data, &HullOptions::default()), &APatchOptions::default()))
}

fn query(surface: &dyn Surface) -> SurfaceQuery<'_> {
    SurfaceQuery::new(surface, &QueryOptions::default())
}

/// The nearest point of a triangle.
fn nearest_in(t: &[Point3; 3], p: &Point3) -> Point3 {
    let [a, b, c] = *t;
    let n = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(a, b)| (b - a).cross(&(p - a)).dot(&n) >= 0.0);
    if inside {
        return p - (p - a).dot(&n) / n.norm_squared() * n;
    }
    let on_edge = |a: Point3, b: Point3| {
        let e: Vec3 = b - a;
        a + ((p - a).dot(&e) / e.norm_squared()).clamp(0.0, 1.0) * e
    };
    let candidates = [on_edge(a, b), on_edge(b, c), on_edge(c, a)];
    candidates.into_iter().min_by(|x, y| (x - p).norm().total_cmp(&(y - p).norm())).unwrap()
}

/// Where a line crosses a triangle.
fn crossing(t: &[Point3; 3], ray: &Ray) -> Option<f64> {
    let [e, f, d] = [t[1] - t[0], t[2] - t[0], ray.direction];
    let h = d.cross(&f);
    let k = 1.0 / e.dot(&h);
    let s = ray.origin - t[0];
    let (u, q) = (k * s.dot(&h), s.cross(&e));
    let v = k * d.dot(&q);
    let at = k * f.dot(&q);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at >= 0.0).then_some(at * d.norm())
}

fn triangles(surface: &APatchSurface, along: usize, across: usize) -> Vec<[Point3; 3]> {
    let mesh = tessellate_a_patches(surface, APatchResolution { along, across }).unwrap();
    mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize])).collect()
}

/// Flat triangles as patches.
struct Facets {
    nets: Vec<[Point3; 3]>,
    seams: Vec<Seam>,
}

impl Facets {
    fn new(points: &[Point3], faces: &[[u32; 3]]) -> Self {
        let nets = faces.iter().map(|f| f.map(|v| points[v as usize])).collect();
        let side = |n: usize, edge: usize, reversed| SeamSide {
            patch: PatchId(n as u32),
            edge: edge as u8,
            reversed,
        };
        let mut seams = Vec::new();
        for (n, f) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                let other = faces.iter().enumerate().find_map(|(m, g)| {
                    (0..3).find(|j| g[*j] == b && g[(j + 1) % 3] == a).map(|j| side(m, j, true))
                });
                if other.is_none() || a < b {
                    seams.push(Seam { first: side(n, k, false), second: other, continuity: Continuity::G0 });
                }
            }
        }
        Self { nets, seams }
    }

    /// The cube [−1, 1]³.
    fn cube() -> Self {
        let corners = Aabb::new(Point3::repeat(-1.0), Point3::repeat(1.0)).corners();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces: Vec<[u32; 3]> =
            quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Self::new(&corners, &faces)
    }
}

impl Surface for Facets {
    fn patch_count(&self) -> usize {
        self.nets.len()
    }
    fn domain(&self, _: PatchId) -> Domain {
        Domain::Triangle
    }
    fn sample(&self, patch: PatchId, [u, v]: [f64; 2]) -> Sample {
        let [a, b, c] = self.nets[patch.index()];
        let (du, dv) = (a - c, b - c);
        Sample { point: c + u * du + v * dv, normal: du.cross(&dv).normalize(), du, dv }
    }
    fn form(&self, patch: PatchId) -> PatchForm<'_> {
        PatchForm::BezierTriangle { degree: 1, net: &self.nets[patch.index()] }
    }
    fn seams(&self) -> &[Seam] {
        &self.seams
    }
    fn corners(&self, _: PatchId) -> [u32; 3] {
        [0, 1, 2]
    }
    fn bounds(&self, patch: PatchId) -> Aabb {
        Aabb::around(&self.nets[patch.index()])
    }
}

/// Boxes of parts hold their points, of whole patches and of small parts of them.
fn boxes_hold_points(surface: &APatchSurface) {
    let (mut size_of_parts, mut count) = (0.0, 0);
    for patch in surface.patches() {
        for splits in 0..4 {
            let mut open = domain::halves(surface.domain(patch));
            let turns = patch.index();
            for n in 0..splits {
                open = open.into_iter().flat_map(|t| [domain::quarters(t)[(turns + n) % 4]]).collect();
            }
            for t in open {
                let bounds = surface.part_bounds(patch, t);
                for x in crate::bernstein::triangle::lattice(5) {
                    let uv = [0, 1].map(|c| (0..3).map(|i| x[i] * t[i][c]).sum());
                    let point = surface.sample(patch, domain::clamped(surface.domain(patch), uv)).point;
                    assert!(bounds.contains(&point), "{patch:?} {t:?} {point:?} {bounds:?}");
                }
                if splits == 3 {
                    size_of_parts += bounds.diagonal() / surface.bounds(patch).diagonal();
                    count += 1;
                }
            }
        }
    }
    // Boxes that do not shrink with their parts would hold everything as well.
    assert!(size_of_parts < 0.3 * f64::from(count), "{size_of_parts} {count}");
}

/// On smooth and on wild surfaces.
#[test]
fn boxes_of_parts_hold_their_points() {
    for data in [perturbed(0.0, 0.3), perturbed(0.1, 0.6), torus([16, 10]), quadrics().swap_remove(8).2] {
        boxes_hold_points(&surface(data));
    }
}

#[test]
fn distances_to_a_sphere_are_exact() {
    let surface = surface(quadrics().swap_remove(0).2);
    let query = query(&surface);
    assert!(query.is_closed());
    for n in 0..400 {
        let p = 1.7 * noise3(n);
        let found = query.nearest(&p).unwrap();
        assert!((found.distance - (p.norm() - 1.0).abs()).abs() < 1e-13, "{p:?} {found:?}");
        // Near the center a foot is as uncertain as the direction.
        let off = (found.point - p.normalize()).norm();
        assert!(off < 1e-10 / p.norm().min(1.0), "{p:?} {off:e}");
        assert_eq!(surface.sample(found.patch, found.uv).point, found.point);
        assert_eq!(query.is_inside(&p), Some(p.norm() < 1.0));
    }
    let center = query.nearest(&Point3::zeros()).unwrap();
    assert!((center.distance - 1.0).abs() < 1e-14);
}

/// Points at vertices, on edges of the mesh and at hull faces are no special case.
#[test]
fn points_of_the_surface_are_their_own_nearest() {
    for data in [perturbed(0.1, 0.3), perturbed(0.1, 0.6), torus([16, 10])] {
        let positions = data.positions().to_vec();
        let surface = surface(data);
        let query = query(&surface);
        for p in positions {
            assert!(query.nearest(&p).unwrap().distance < 1e-14);
        }
        for patch in surface.patches().step_by(7) {
            for uv in [[0.0, 0.4], [0.3, 0.0], [0.2, 0.3], [0.5, 0.5], [1e-9, 0.5]] {
                let sample = surface.sample(patch, uv);
                let own = query.nearest(&sample.point).unwrap();
                assert!(own.distance < 1e-13, "{patch:?} {uv:?} {own:?}");
                for (step, inside) in [(1e-7, false), (-1e-7, true), (1e-3, false), (-1e-3, true)] {
                    let p = sample.point + step * sample.normal;
                    let found = query.nearest(&p).unwrap();
                    assert!((found.distance - step.abs()).abs() < 1e-11, "{patch:?} {uv:?} {step} {found:?}");
                    assert_eq!(query.is_inside(&p), Some(inside), "{patch:?} {uv:?} {step}");
                }
            }
        }
    }
}

#[test]
fn no_triangle_of_a_tessellation_is_nearer() {
    let surface = surface(torus([16, 10]));
    let query = query(&surface);
    let fine = triangles(&surface, 16, 6);
    for n in 0..150 {
        let p = noise3(n).component_mul(&Vec3::new(1.8, 1.8, 0.8));
        let found = query.nearest(&p).unwrap();
        let flat = fine.iter().map(|t| (nearest_in(t, &p) - p).norm()).fold(f64::INFINITY, f64::min);
        assert!((found.distance - flat).abs() < 5e-3, "{p:?} {found:?} {flat}");
        let truth = torus_distance(&p);
        assert!((found.distance - truth).abs() < 5e-3, "{p:?} {found:?} {truth}");
        // The foot is perpendicular.
        let normal = surface.sample(found.patch, found.uv).normal;
        let off = (p - found.point).cross(&normal).norm();
        assert!(off < 1e-9, "{p:?} {found:?} {off:e}");
    }
}

#[test]
fn rays_cross_a_sphere_twice() {
    let surface = surface(quadrics().swap_remove(0).2);
    let query = query(&surface);
    for n in 0..300 {
        let ray = Ray { origin: 2.0 * noise3(n) + Vec3::new(3.0, 0.0, 0.0), direction: noise3(n + 1000) };
        let d = ray.direction.normalize();
        let (b, c) = (ray.origin.dot(&d), ray.origin.norm_squared() - 1.0);
        let exact: Vec<f64> = if b * b > c && b < 0.0 {
            let root = (b * b - c).sqrt();
            [-b - root, -b + root].into_iter().filter(|t| *t >= 0.0).collect()
        } else {
            Vec::new()
        };
        let hits = query.hits(&ray);
        assert_eq!(hits.len(), exact.len(), "{n}");
        let tolerance = 1e-13 / (b * b - c).abs().sqrt().min(1.0);
        for (hit, t) in hits.iter().zip(&exact) {
            assert!((hit.distance - t).abs() < tolerance.max(1e-12), "{n}: {:e}", hit.distance - t);
            assert!((hit.normal - hit.point).norm() < 1e-9);
        }
        assert_eq!(query.first_hit(&ray).map(|h| h.distance), hits.first().map(|h| h.distance));
    }
}

/// Rays through vertices and along edges of the mesh, where many patches meet.
#[test]
fn rays_through_vertices_hit_once() {
    let (_, _, data) = quadrics().swap_remove(0);
    let positions = data.positions().to_vec();
    let surface = surface(data);
    let query = query(&surface);
    for (n, p) in positions.iter().enumerate() {
        for q in [positions[(n + 1) % positions.len()], 0.5 * (p + positions[(n + 1) % positions.len()])] {
            let origin = Point3::zeros();
            let hits = query.hits(&Ray { origin, direction: *p });
            assert_eq!(hits.len(), 1, "{n} {hits:?}");
            assert!((hits[0].point - p).norm() < 1e-12);
            let hits = query.hits(&Ray { origin: 3.0 * q, direction: -q });
            assert_eq!(hits.len(), 2, "{n} {hits:?}");
        }
    }
}

#[test]
fn a_torus_is_crossed_as_often_as_its_triangles() {
    let surface = surface(torus([16, 10]));
    let query = query(&surface);
    let fine = triangles(&surface, 12, 4);
    let mut counts = [0; 5];
    for n in 0..250 {
        let ray = Ray { origin: 0.8 * noise3(n), direction: noise3(n + 500) - 0.3 * noise3(n) };
        let hits = query.hits(&ray);
        let mut flat: Vec<f64> = fine.iter().filter_map(|t| crossing(t, &ray)).collect();
        flat.sort_by(f64::total_cmp);
        flat.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let d = ray.direction.normalize();
        // Nearly tangential rays may miss the triangles.
        if hits.iter().all(|h| h.normal.dot(&d).abs() > 0.15) {
            assert_eq!(hits.len(), flat.len(), "{n} {hits:?} {flat:?}");
            for (hit, t) in hits.iter().zip(&flat) {
                assert!((hit.distance - t).abs() < 2e-2);
                assert!(((hit.point - ray.origin) - hit.distance * d).norm() < 1e-12);
            }
        }
        counts[hits.len()] += 1;
    }
    // Across the hole and the tube.
    let through = query.hits(&Ray { origin: Point3::new(-3.0, 0.01, 0.02), direction: Vec3::x() });
    assert_eq!(through.len(), 4);
    assert!(query.hits(&Ray { origin: Point3::new(0.1, 0.1, -3.0), direction: Vec3::z() }).is_empty());
    assert!(counts[0] > 0 && counts[1] > 0 && counts[2] > 0 && counts[3] > 0, "{counts:?}");
}

#[test]
fn inside_of_a_torus() {
    let surface = surface(torus([24, 16]));
    let query = query(&surface);
    let points: Vec<Point3> = (0..600).map(|n| noise3(n).component_mul(&Vec3::new(1.6, 1.6, 0.6))).collect();
    let volume = surface.volume().unwrap();
    for (p, inside) in points.iter().zip(query.are_inside(&points)) {
        let distance = (p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.4;
        if distance.abs() > 1e-3 {
            assert_eq!(inside, Some(distance < 0.0), "{p:?}");
        }
        assert_eq!(inside, volume.is_inside(*p), "{p:?}");
    }
}

#[test]
fn a_cube_has_sharp_edges() {
    let cube = Facets::cube();
    let query = query(&cube);
    assert!(query.is_closed());
    for n in 0..500 {
        // Many lie straight over edges and corners, or on planes through them.
        let p = if n % 2 == 0 { 1.6 * noise3(n) } else { (2.0 * noise3(n)).map(|x| 0.5 * (2.0 * x).round()) };
        let outside = p.map(|x| (x.abs() - 1.0).max(0.0)).norm();
        let depth = 1.0 - p.amax();
        let distance = if depth > 0.0 { depth } else { outside };
        let found = query.nearest(&p).unwrap();
        assert!((found.distance - distance).abs() < 1e-14, "{p:?} {found:?}");
        if distance > 0.0 {
            assert_eq!(query.is_inside(&p), Some(depth > 0.0), "{p:?}");
        }
        let ray = Ray { origin: p, direction: noise3(n + 77) };
        let hits = query.hits(&ray).len();
        if depth > 0.0 {
            assert_eq!(hits, 1, "{p:?}");
        } else if distance > 0.0 {
            assert!(hits == 0 || hits == 2, "{p:?} {hits}");
        }
    }
    // Through a corner and along a diagonal of the faces.
    let origin = Point3::repeat(-2.0);
    assert_eq!(query.hits(&Ray { origin, direction: Vec3::repeat(1.0) }).len(), 2);
    let hits = query.hits(&Ray { origin: Point3::new(0.3, 0.3, 5.0), direction: -Vec3::z() });
    assert_eq!(hits.iter().map(|h| h.distance).collect::<Vec<_>>(), [4.0, 6.0]);
}

/// A cylinder of radius and height 1 with flat ends, in triangles. Its rims are creases, to which the faces on both sides are
/// pulled.
fn cylinder() -> APatchSurface {
    const N: u32 = 16;
    let around = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(N);
    let on_circle = |i: u32, z: f64| Point3::new(around(i).cos(), around(i).sin(), z);
    let mut positions: Vec<Point3> =
        [0.0, 0.5, 1.0].iter().flat_map(|z| (0..N).map(move |i| on_circle(i, *z))).collect();
    positions.extend([Point3::zeros(), Point3::z()]);
    let mut faces = Vec::new();
    for i in 0..N {
        let j = (i + 1) % N;
        faces.extend([0, N].iter().flat_map(|row| {
            let [a, b, c, d] = [row + i, row + j, row + N + j, row + N + i];
            [[a, b, c], [a, c, d]]
        }));
        faces.extend([[3 * N, j, i], [3 * N + 1, 2 * N + i, 2 * N + j]]);
    }
    let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
    let sharp = creases::by_angle(&mesh, &positions, 40f64.to_radians());
    let gradients = at_corners(&mesh, &positions, &sharp, NormalRule::LoopLimit);
    let surface = surface(HermiteMesh::with_creases(mesh, positions, gradients, sharp).unwrap());
    assert_eq!(surface.crease_counts().curved, 2 * N as usize);
    surface
}

/// Faces beside creases are not where the zero set is: boxes, nearest points, rays and insides right beside the rims.
#[test]
fn rims_of_a_cylinder_are_found() {
    let surface = cylinder();
    boxes_hold_points(&surface);
    let query = query(&surface);
    assert!(query.is_closed());
    let creases = surface.seams().iter().filter(|seam| seam.continuity == Continuity::G0);
    assert_eq!(creases.clone().count(), 32);
    for seam in creases.step_by(5) {
        let SeamSide { patch, edge, .. } = seam.first;
        for s in [0.0, 1e-6, 0.4] {
            let mut x = [0.0; 3];
            (x[edge as usize], x[(edge as usize + 1) % 3]) = (1.0 - s, s);
            let rim = surface.sample(patch, [x[0], x[1]]).point;
            assert!((rim.x.hypot(rim.y) - 1.0).abs() < 1e-5, "{rim:?}");
            assert!(query.nearest(&rim).unwrap().distance < 1e-13, "{rim:?}");
            let radial = Vec3::new(rim.x, rim.y, 0.0).normalize();
            let up = Vec3::z() * if rim.z > 0.5 { 1.0 } else { -1.0 };
            // Between the normals of the two sides the rim is nearest; the opposite direction leads into the solid.
            for step in [1e-2, 1e-4, 1e-6] {
                let out = step * (up + radial).normalize();
                let found = query.nearest(&(rim + out)).unwrap();
                assert!((found.point - rim).norm() < 0.2 * step, "{rim:?} {step} {found:?}");
                for (p, inside) in [(rim + out, false), (rim - out, true)] {
                    assert_eq!(query.is_inside(&p), Some(inside), "{rim:?} {step}");
                }
                // Along the ends, just below the rim, through both sides of the solid, and just above it.
                let origin = rim + 0.5 * radial;
                let [below, above] =
                    [-step, step].map(|h| Ray { origin: origin + h * up, direction: -radial });
                assert_eq!(query.hits(&below).len(), 2, "{rim:?} {step}");
                assert!(query.hits(&above).is_empty(), "{rim:?} {step}");
                // Along the side, just within the rim and just without.
                let origin = rim + 0.5 * up;
                let [within, without] =
                    [-step, step].map(|h| Ray { origin: origin + h * radial, direction: -up });
                assert!(!query.hits(&within).is_empty(), "{rim:?} {step}");
                assert!((query.first_hit(&within).unwrap().point.z - rim.z).abs() < 1e-14);
                if step > 5e-3 {
                    assert!(query.hits(&without).is_empty(), "{rim:?} {step}");
                }
            }
        }
    }
}

#[test]
fn splines_answer_as_well() {
    let spline = crate::golden::sphere();
    let query = query(&spline);
    for n in 0..60 {
        let p = 1.7 * noise3(n);
        // The spline is within 8.6e-5 of the diagonal 2.95 of the unit sphere.
        let found = query.nearest(&p).unwrap();
        assert!((found.distance - (p.norm() - 1.0).abs()).abs() < 2.6e-4);
        let normal = spline.sample(found.patch, found.uv).normal;
        assert!((p - found.point).cross(&normal).norm() < 1e-9);
        assert_eq!(query.is_inside(&p), Some(p.norm() < 1.0));
    }
    let open = crate::golden::flat_triangle();
    assert_eq!(SurfaceQuery::new(&open, &QueryOptions::default()).is_inside(&Point3::zeros()), None);
}

#[test]
fn numbers_that_are_not_finite_get_no_answer() {
    let cube = Facets::cube();
    let query = query(&cube);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let p = Point3::new(0.0, bad, 0.0);
        assert_eq!(query.nearest(&p), None);
        assert_eq!(query.is_inside(&p), None);
        assert!(query.hits(&Ray { origin: p, direction: Vec3::x() }).is_empty());
        assert!(query.hits(&Ray { origin: Point3::zeros(), direction: p }).is_empty());
    }
    assert_eq!(query.first_hit(&Ray { origin: Point3::zeros(), direction: Vec3::zeros() }), None);
    let nothing = Facets { nets: Vec::new(), seams: Vec::new() };
    let query = SurfaceQuery::new(&nothing, &QueryOptions::default());
    assert_eq!((query.nearest(&Point3::zeros()), query.is_inside(&Point3::zeros())), (None, None));
    let nan = Facets::new(&[Point3::zeros(), Vec3::x(), Vec3::repeat(f64::NAN)], &[[0, 1, 2]]);
    let query = SurfaceQuery::new(&nan, &QueryOptions::default());
    assert_eq!(query.nearest(&Point3::zeros()), None);
}

#[test]
fn answers_do_not_depend_on_the_tree() {
    let surface = surface(perturbed(0.1, 0.6));
    let [coarse, fine] = [0, 3].map(|splits| SurfaceQuery::new(&surface, &QueryOptions { splits }));
    for n in 0..100 {
        let p = 1.5 * noise3(n);
        let [a, b] = [&coarse, &fine].map(|q| q.nearest(&p).unwrap());
        assert!((a.distance - b.distance).abs() < 1e-12, "{p:?} {a:?} {b:?}");
        let ray = Ray { origin: p, direction: noise3(n + 300) };
        let [a, b] = [&coarse, &fine].map(|q| q.hits(&ray));
        assert_eq!(a.len(), b.len(), "{ray:?} {a:?} {b:?}");
        assert!(a.iter().zip(&b).all(|(a, b)| (a.distance - b.distance).abs() < 1e-11));
    }
}

#[test]
fn the_bunny_agrees_with_its_triangles() {
    let Some(data) = from_file("npm_bunny.off") else { return };
    let diagonal = data.diagonal();
    let (low, high) = data
        .positions()
        .iter()
        .fold((data.positions()[0], data.positions()[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let surface = surface(data);
    let query = query(&surface);
    let fine = triangles(&surface, 3, 1);
    for n in 0..20 {
        let p = 0.5 * (low + high) + 0.6 * (high - low).component_mul(&noise3(n));
        let found = query.nearest(&p).unwrap();
        let flat = fine.iter().map(|t| (nearest_in(t, &p) - p).norm()).fold(f64::INFINITY, f64::min);
        assert!((found.distance - flat).abs() < 2e-3 * diagonal, "{p:?} {found:?} {flat}");
        let ray = Ray { origin: p, direction: noise3(n + 50) + Vec3::repeat(0.01 * noise(n)) };
        let crossed = fine.iter().filter(|t| crossing(t, &ray).is_some()).count();
        let inside = query.is_inside(&p).unwrap();
        if found.distance > 2e-3 * diagonal {
            assert_eq!(inside, crossed % 2 == 1, "{p:?}");
            assert_eq!(query.hits(&ray).len() % 2 == 1, inside, "{p:?}");
        }
    }
}
