//! What must hold for the spline over any valid base mesh, whatever its data.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

use isopatch::base::{BaseMesh, EdgeFeature};
use isopatch::geom::{Mat3, Point3, Points, PointsMut, PointsView, Vec3, angle_between};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::network::{CurveOptions, fit_quartics};
use isopatch::spline::{self, SplineOptions, TriangularSpline};
use isopatch::surface::{Seam, SeamSide, Surface, Target};
use proptest::prelude::*;
use std::collections::HashMap;

/// The unit sphere.
struct Sphere;

impl Target for Sphere {
    fn project(&self, points: &mut Points) {
        for i in 0..points.len() {
            points.set(i, points.get(i).normalize());
        }
    }

    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], normal: PointsMut<'_>) {
        for i in 0..points.len() {
            let p = points.get(i);
            let n = p.normalize();
            offset[i] = p.norm() - 1.0;
            (normal.x[i], normal.y[i], normal.z[i]) = (n.x, n.y, n.z);
        }
    }
}

/// An icosahedron whose faces are split into four `levels` times, on the unit sphere.
fn icosphere(levels: usize) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut positions: Vec<Point3> = (0..3)
        .flat_map(|axis| {
            [(-1.0, -g), (1.0, -g), (-1.0, g), (1.0, g)].map(|(a, b)| {
                let mut p = Point3::zeros();
                (p[axis], p[(axis + 1) % 3]) = (a, b);
                p.normalize()
            })
        })
        .collect();
    let near = |a: usize, b: usize| (positions[a] - positions[b]).norm() < 1.1;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in 0..12 {
            for c in 0..12 {
                let [p, q, r] = [a, b, c].map(|i| positions[i]);
                if a < b
                    && a < c
                    && b != c
                    && near(a, b)
                    && near(b, c)
                    && near(c, a)
                    && p.cross(&q).dot(&r) > 0.0
                {
                    faces.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (positions, faces)
}

fn spline_over(base: BaseMesh) -> TriangularSpline {
    let curves = fit_quartics(&base, &Sphere, &CurveOptions::default()).unwrap();
    spline::build(base, &curves, &Sphere, &SplineOptions::default()).unwrap()
}

fn sphere_base(positions: Vec<Point3>, faces: &[[u32; 3]]) -> BaseMesh {
    let mesh = HalfEdgeMesh::from_faces(positions.len(), faces).unwrap();
    let features = vec![EdgeFeature::Smooth; mesh.edge_count()];
    let curvatures = positions.iter().map(|p| p * p.transpose() - Mat3::identity()).collect();
    BaseMesh {
        normals: positions.clone(),
        curvatures,
        features,
        mesh,
        positions,
        clip: None,
        frozen_diagonal: None,
    }
}

/// The sample of one side of a seam at seam parameter t.
fn at(spline: &TriangularSpline, side: SeamSide, t: f64) -> isopatch::surface::Sample {
    let t = if side.reversed { 1.0 - t } else { t };
    let mut uvw = [0.0; 3];
    (uvw[side.edge as usize], uvw[(side.edge as usize + 1) % 3]) = (1.0 - t, t);
    spline.sample(side.patch, [uvw[0], uvw[1]])
}

/// Largest gap and largest angle between the normals across the interior seams.
fn seam_faults(spline: &TriangularSpline) -> (f64, f64) {
    let mut faults = (0f64, 0f64);
    for Seam { first, second, .. } in spline.seams() {
        let Some(second) = second else { continue };
        for s in 0..=20 {
            let t = s as f64 / 20.0;
            let (a, b) = (at(spline, *first, t), at(spline, *second, t));
            faults.0 = faults.0.max((a.point - b.point).norm());
            faults.1 = faults.1.max(angle_between(&a.normal, &b.normal));
        }
    }
    faults
}

/// Largest distance of sampled points from the sphere, over an icosphere.
fn sphere_error(levels: usize, curves: &CurveOptions, patches: &SplineOptions) -> f64 {
    let (positions, faces) = icosphere(levels);
    let base = sphere_base(positions, &faces);
    let curves = fit_quartics(&base, &Sphere, curves).unwrap();
    let spline = spline::build(base, &curves, &Sphere, patches).unwrap();
    let at = [[0.2, 0.3], [0.4, 0.4], [0.1, 0.8], [0.0, 0.5]];
    let samples = spline.patches().flat_map(|p| at.map(|uv| (p, uv)));
    samples.map(|(p, uv)| (spline.sample(p, uv).point.norm() - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn the_sphere_is_approached_with_high_order() {
    let curves = CurveOptions {
        damping: 0.0,
        largest_turn: 0.0,
        normal_distance_steps: 3,
        tangential_weight: 1e-3,
        ..CurveOptions::default()
    };
    let patches = SplineOptions { relaxation_steps: 0, normal_distance_steps: 2, ..SplineOptions::default() };
    // Order 6 for the boundary curves, 4 to 4.5 for the patches on irregular meshes. An independent program reached
    // 8.7e-8 with 1,280 faces.
    let errors = [1, 2, 3].map(|levels| sphere_error(levels, &curves, &patches));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 3.5, "order {order:.2} from {errors:?}");
    }
    assert!(errors[2] < 1.1e-7, "{errors:?}");
}

#[test]
fn turning_tangents_and_relaxation_bring_the_sphere_nearer() {
    let (curves, patches) = (CurveOptions::default(), SplineOptions::default());
    // They gain most on coarse meshes, so no order is asked for between them.
    let errors = [1, 2, 3].map(|levels| sphere_error(levels, &curves, &patches));
    assert!(errors[0] < 2e-6 && errors[1] < 1e-6 && errors[2] < 4e-8, "{errors:?}");
}

#[test]
fn vertices_normals_and_curvatures_are_interpolated() {
    let (positions, faces) = icosphere(1);
    let spline = spline_over(sphere_base(positions, &faces));
    for f in spline.base.mesh.faces() {
        for (k, v) in spline.base.mesh.triangle(f).iter().enumerate() {
            let uv = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]][k];
            let s = spline.sample(isopatch::surface::PatchId(f.0), uv);
            assert_eq!(s.point, spline.base.positions[v.index()]);
            assert!(angle_between(&s.normal, &spline.base.normals[v.index()]) < 1e-12);
        }
    }
    for (e, q) in spline.base.mesh.edges().zip(&spline.curves) {
        let h = spline.base.mesh.edge_half_edge(e);
        let (n0, n1) = (spline.base.mesh.origin(h), spline.base.mesh.dest(h));
        let curvature =
            |q0: Point3, q1: Point3, q2: Point3, n: Vec3| 0.75 * (q2 - q0).dot(&n) / (q1 - q0).norm_squared();
        let (a, b) = (spline.base.normals[n0.index()], spline.base.normals[n1.index()]);
        assert!((curvature(q[0], q[1], q[2], a) + 1.0).abs() < 1e-9);
        assert!((curvature(q[4], q[3], q[2], b) + 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_open_surface_is_smooth_inside_and_ends_in_its_boundary_curves() {
    let (positions, faces) = icosphere(1);
    let kept: Vec<[u32; 3]> = faces[..50].to_vec();
    let mut used: Vec<u32> = kept.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: &u32| used.binary_search(v).unwrap() as u32;
    let kept: Vec<[u32; 3]> = kept.iter().map(|f| [number(&f[0]), number(&f[1]), number(&f[2])]).collect();
    let positions = used.iter().map(|v| positions[*v as usize]).collect();
    let spline = spline_over(sphere_base(positions, &kept));
    assert!(!spline.base.mesh.is_closed());
    let (gap, jump) = seam_faults(&spline);
    assert!(gap < 1e-14 && jump < 1e-11, "gap {gap:e}, jump {jump:e}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// G1 is algebra: it holds for normals and curvature tensors that fit no surface.
    #[test]
    fn seams_are_g1_whatever_the_normals_and_curvatures(noise in prop::collection::vec(-1.0..1.0f64, 42 * 9)) {
        let (positions, faces) = icosphere(1);
        let mut base = sphere_base(positions, &faces);
        for (v, n) in noise.chunks(9).enumerate() {
            let tilt = 0.1 * Vec3::new(n[0], n[1], n[2]);
            base.positions[v] *= 1.0 + 0.05 * n[3];
            base.normals[v] = (base.normals[v] + tilt).normalize();
            let m = Mat3::new(n[4], n[5], n[6], n[5], n[7], n[8], n[6], n[8], n[4]);
            let p = Mat3::identity() - base.normals[v] * base.normals[v].transpose();
            base.curvatures[v] = p * (0.3 * m - Mat3::identity()) * p;
        }
        let (gap, jump) = seam_faults(&spline_over(base));
        prop_assert!(gap < 1e-14 && jump < 1e-11, "gap {gap:e}, jump {jump:e}");
    }
}
