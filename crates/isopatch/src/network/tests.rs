//! End data for which there is a boundary curve, and end data for which there is none.

use super::{CurveError, CurveOptions, fit_quartics};
use crate::base::{BaseMesh, BoxSides, Clip, EdgeFeature};
use crate::bernstein::curve::point;
use crate::geom::{Aabb, Mat3, Point3, Points, PointsMut, PointsView, Vec3};
use crate::mesh::HalfEdgeMesh;
use crate::surface::Target;

/// Every point is on it.
struct Everywhere;

impl Target for Everywhere {
    fn project(&self, _: &mut Points) {}

    fn offsets(&self, _: PointsView<'_>, offset: &mut [f64], normal: PointsMut<'_>) {
        offset.fill(0.0);
        normal.x.fill(0.0);
        normal.y.fill(0.0);
        normal.z.fill(1.0);
    }
}

/// A triangle whose normals are all (0, 0, 1), with the same normal curvature in all directions of a corner.
fn triangle(corners: [Point3; 3], curvatures: [f64; 3]) -> BaseMesh {
    BaseMesh {
        mesh: HalfEdgeMesh::from_faces(3, &[[0, 1, 2]]).unwrap(),
        positions: corners.to_vec(),
        normals: vec![Vec3::z(); 3],
        curvatures: curvatures.map(|k| k * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, 0.0))).to_vec(),
        features: vec![EdgeFeature::Boundary; 3],
        clip: None,
        frozen_diagonal: None,
    }
}

fn error_of(base: &BaseMesh) -> Option<CurveError> {
    fit_quartics(base, &Everywhere, &CurveOptions::default()).err()
}

/// Tong & Kim 2009, Fig. 8: with parallel normals (9b) is 4/3 (λ² k0 − μ² k1) = step between the tangent planes.
#[test]
fn a_step_between_parallel_tangent_planes_needs_the_right_curvatures() {
    let with_step = |step: f64, k: [f64; 3]| {
        error_of(&triangle([Point3::zeros(), Point3::new(1.0, 0.0, step), Point3::new(0.0, 1.0, step)], k))
    };
    let infeasible = Some(CurveError::Infeasible { edge: 0, from: 0, to: 1 });
    assert_eq!(with_step(0.0, [0.0; 3]), None);
    assert_eq!(with_step(0.2, [0.0; 3]), infeasible);
    assert_eq!(with_step(0.2, [1.0, -1.0, -1.0]), None);
    assert_eq!(with_step(0.2, [-1.0, 1.0, 1.0]), infeasible);
}

#[test]
fn a_chord_along_a_normal_has_no_tangent() {
    let upright = triangle([Point3::zeros(), Point3::z(), Point3::x()], [0.0; 3]);
    assert_eq!(error_of(&upright), Some(CurveError::NoTangent { edge: 0, from: 0, to: 1 }));
    let point = triangle([Point3::zeros(), Point3::zeros(), Point3::x()], [0.0; 3]);
    assert_eq!(error_of(&point), Some(CurveError::NoTangent { edge: 0, from: 0, to: 1 }));
}

/// A triangle with an edge in the side x = 1 of the unit cube, over the paraboloid z = k (x² + y²)/2 at its corners.
fn in_side(curvature: f64, sides: [BoxSides; 3]) -> BaseMesh {
    let at = |x: f64, y: f64| Point3::new(x, y, 0.5 * curvature * (x * x + y * y));
    let positions = vec![at(1.0, -0.4), at(1.0, 0.5), at(0.2, 0.1)];
    let upward: Vec<Vec3> =
        positions.iter().map(|p| Vec3::new(-curvature * p.x, -curvature * p.y, 1.0)).collect();
    let tensor = |g: &Vec3| {
        let across = Mat3::identity() - g * g.transpose() / g.norm_squared();
        across * Mat3::from_diagonal(&Vec3::new(curvature, curvature, 0.0)) * across / g.norm()
    };
    BaseMesh {
        curvatures: upward.iter().map(tensor).collect(),
        normals: upward.iter().map(|g| g.normalize()).collect(),
        clip: Some(Clip { bounds: Aabb::new(Vec3::repeat(-1.0), Vec3::repeat(1.0)), sides: sides.to_vec() }),
        frozen_diagonal: None,
        mesh: HalfEdgeMesh::from_faces(3, &[[0, 1, 2]]).unwrap(),
        features: vec![EdgeFeature::Boundary; 3],
        positions,
    }
}

/// The paraboloid, by its distance along the normal only.
struct Paraboloid(f64);

impl Target for Paraboloid {
    fn project(&self, _: &mut Points) {}

    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], normal: PointsMut<'_>) {
        for i in 0..offset.len() {
            let p = Point3::new(points.x[i], points.y[i], points.z[i]);
            let g = Vec3::new(-self.0 * p.x, -self.0 * p.y, 1.0);
            offset[i] = (p.z - 0.5 * self.0 * (p.x * p.x + p.y * p.y)) / g.norm();
            let n = g.normalize();
            (normal.x[i], normal.y[i], normal.z[i]) = (n.x, n.y, n.z);
        }
    }
}

#[test]
fn a_curve_in_a_side_of_the_box_is_the_plane_section() {
    let x = BoxSides::of(&Vec3::new(1.0, 0.0, 0.0), &Aabb::new(Vec3::repeat(-1.0), Vec3::repeat(1.0)));
    let base = in_side(0.8, [x, x, BoxSides::NONE]);
    let curve = fit_quartics(&base, &Paraboloid(0.8), &CurveOptions::default()).unwrap()[0];
    assert!(curve.q.iter().all(|q| q.x == 1.0), "{:?}", curve.q);
    for t in [0.1, 0.3, 0.5, 0.9] {
        let p = point(&curve.q, t);
        assert!((p.z - 0.4 * (1.0 + p.y * p.y)).abs() < 2e-5, "{p:?}");
    }
}

#[test]
fn an_edge_along_an_edge_of_the_box_is_refused() {
    let bounds = Aabb::new(Vec3::repeat(-1.0), Vec3::repeat(1.0));
    let edge = BoxSides::of(&Vec3::new(1.0, 1.0, 0.0), &bounds);
    let error = error_of(&in_side(0.8, [edge, edge, BoxSides::NONE]));
    assert_eq!(error, Some(CurveError::AlongBoxEdge { edge: 0, from: 0, to: 1 }));
}
