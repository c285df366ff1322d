//! End data for which there is a boundary curve, and end data for which there is none.

use super::{CurveError, CurveOptions, fit_quartics};
use crate::base::{BaseMesh, EdgeFeature};
use crate::geom::{Mat3, Point3, Points, PointsMut, PointsView, Vec3};
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
