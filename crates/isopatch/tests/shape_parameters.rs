//! Shape parameters of the spline change its shape, and nothing that it interpolates.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

use isopatch::base::{self, BaseMesh, BaseOptions, FieldTarget};
use isopatch::field::{Constants, Formula};
use isopatch::geom::Vec3;
use isopatch::inspect::{InspectOptions, inspect};
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId};
use isopatch::network::{CurveOptions, QuarticCurve, fit_quartics};
use isopatch::spline::{
    ShapeError, ShapeParameters, SplineError, SplineOptions, TriangularSpline, build, build_shaped,
};

struct Model {
    field: Formula,
    base: BaseMesh,
    curves: Vec<QuarticCurve>,
}

impl Model {
    fn new() -> Self {
        let field = Formula::parse("x^2 + 2 y^2 + z^2 + x z/2 - 1", &Constants::new()).unwrap();
        let bounds = base::find_box(&field).unwrap();
        let options = BaseOptions { faces: Some(60), ..BaseOptions::default() };
        let base = base::build(&field, &bounds, &options).unwrap().base;
        let target = FieldTarget::new(&field, base.diagonal());
        let curves = fit_quartics(&base, &target, &CurveOptions::default()).unwrap();
        Self { field, base, curves }
    }

    fn shaped(&self, shape: &ShapeParameters) -> Result<TriangularSpline, ShapeError> {
        let target = FieldTarget::new(&self.field, self.base.diagonal());
        build_shaped(self.base.clone(), &self.curves, &target, &SplineOptions::default(), shape)
    }

    fn plain(&self) -> TriangularSpline {
        let target = FieldTarget::new(&self.field, self.base.diagonal());
        build(self.base.clone(), &self.curves, &target, &SplineOptions::default()).unwrap()
    }

    fn half_edges_of(&self, odd: bool) -> Vec<HalfEdgeId> {
        let has = |v: &VertexId| self.base.mesh.ring(*v).count() % 2 == usize::from(odd);
        let v = self.base.mesh.vertices().find(has).unwrap();
        self.base.mesh.ring(v).collect()
    }
}

fn same(a: &TriangularSpline, b: &TriangularSpline) -> usize {
    a.nets.iter().zip(&b.nets).filter(|(a, b)| a == b).count()
}

#[test]
fn the_spline_stays_g1_with_other_parameters() {
    let model = Model::new();
    let plain = model.plain();
    assert_eq!(same(&plain, &model.shaped(&ShapeParameters::default()).unwrap()), 60);

    let ring = model.half_edges_of(true);
    let shapes = [
        ShapeParameters { mu1: vec![(ring[0], 0.9)], ..Default::default() },
        ShapeParameters { mu1: ring.iter().map(|h| (*h, 0.55)).collect(), ..Default::default() },
        ShapeParameters { nu: vec![(EdgeId(7), 0.5), (EdgeId(30), -1.0)], ..Default::default() },
        ShapeParameters { inner: vec![(FaceId(3), [0.05 * Vec3::z(); 3])], ..Default::default() },
    ];
    for shape in shapes {
        let shaped = model.shaped(&shape).unwrap();
        assert!(same(&plain, &shaped) < 60, "{shape:?} changes nothing");
        assert_eq!(shaped.curves, plain.curves);
        let options =
            InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
        let found = inspect(&shaped, &shaped.base, None, &options);
        assert_eq!(found.seams.max_gap, 0.0);
        assert!(found.seams.max_normal_jump < 1e-11, "{shape:?}: {:e}", found.seams.max_normal_jump);
        assert!(
            found.interpolation.max_normal_error < 1e-12 && found.interpolation.max_curvature_error < 1e-9
        );
    }
}

/// Only the three inner points of one patch move.
#[test]
fn inner_points_move_by_what_is_wanted() {
    let model = Model::new();
    let (plain, by) = (model.plain(), Vec3::new(0.01, -0.02, 0.03));
    let shape = ShapeParameters { inner: vec![(FaceId(3), [by; 3])], ..Default::default() };
    let shaped = model.shaped(&shape).unwrap();
    assert_eq!(same(&plain, &shaped), 59);
    let moved = plain.nets[3].iter().zip(&shaped.nets[3]).filter(|(a, b)| a != b);
    let moves: Vec<Vec3> = moved.map(|(a, b)| b - a).collect();
    assert_eq!(moves.len(), 3);
    assert!(moves.iter().all(|m| (m - by).norm() < 1e-15));
}

#[test]
fn values_that_can_t_be_had_are_errors() {
    let model = Model::new();
    // Around a vertex of even valence the rows with given μ1 bind each other.
    let ring = model.half_edges_of(false);
    let mu1 = ring.iter().enumerate().map(|(i, h)| (*h, 0.5 + 0.1 * (i % 2) as f64)).collect();
    let shape = ShapeParameters { mu1, ..Default::default() };
    let vertex = model.base.mesh.origin(ring[0]).0;
    assert_eq!(model.shaped(&shape).err(), Some(ShapeError::Spline(SplineError::SingularVertex { vertex })));
    for shape in [
        ShapeParameters { nu: vec![(EdgeId(0), f64::NAN)], ..Default::default() },
        ShapeParameters { nu: vec![(EdgeId(9999), 0.0)], ..Default::default() },
        ShapeParameters { inner: vec![(FaceId(60), [Vec3::zeros(); 3])], ..Default::default() },
    ] {
        assert_eq!(model.shaped(&shape).err(), Some(ShapeError::Value));
    }
}
