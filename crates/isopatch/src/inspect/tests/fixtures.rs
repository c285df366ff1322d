//! Golden splines and hand-written fields.

use crate::base::{BaseMesh, EdgeFeature};
use crate::field::Field;
use crate::geom::{Aabb, Interval, Jet, Mat3, Point3, Vec3};
use crate::mesh::HalfEdgeMesh;
use crate::spline::TriangularSpline;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Control points of a patch of degree 7.
pub const NET: usize = crate::bernstein::index::count(7);

/// A golden file and the spline in it.
pub struct Golden {
    pub json: Value,
    pub spline: TriangularSpline,
}

impl Golden {
    fn new(json: Value) -> Self {
        let faces: Vec<[u32; 3]> = serde_json::from_value(json["faces"].clone()).unwrap();
        let positions = points(&json["vertices"]);
        let mesh = HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap();
        let tensors: Vec<[[f64; 3]; 3]> = serde_json::from_value(json["curvature_tensor_M"].clone()).unwrap();
        let base = BaseMesh {
            features: vec![EdgeFeature::Smooth; mesh.edge_count()],
            clip: None,
            frozen_diagonal: None,
            normals: points(&json["normals"]),
            curvatures: tensors.iter().map(|m| Mat3::from_fn(|r, c| m[r][c])).collect(),
            positions,
            mesh,
        };
        let curves = json["edges"]["q"].as_array().unwrap().iter().map(|q| points(q).try_into().unwrap());
        let spline = TriangularSpline::new(base, curves.collect(), nets(&json["control_nets"]));
        Self { json, spline }
    }

    /// The same spline with other control nets of the file.
    pub fn with_nets(&self, key: &str) -> TriangularSpline {
        TriangularSpline::new(self.spline.base.clone(), self.spline.curves.clone(), nets(&self.json[key]))
    }
}

fn points(json: &Value) -> Vec<Point3> {
    let rows: Vec<[f64; 3]> = serde_json::from_value(json.clone()).unwrap();
    rows.into_iter().map(Point3::from).collect()
}

fn nets(json: &Value) -> Vec<[Point3; NET]> {
    json.as_array().unwrap().iter().map(|net| points(net).try_into().unwrap()).collect()
}

/// A golden file; none if it is neither in the repository nor under ISOPATCH_TEST_DATA.
pub fn golden(name: &str) -> Option<Golden> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.json"));
    let shared = std::env::var_os("ISOPATCH_TEST_DATA")
        .map(|dir| PathBuf::from(dir).join(format!("golden/spline/{name}.json")));
    let text = std::fs::read_to_string(here).ok().or_else(|| std::fs::read_to_string(shared?).ok())?;
    Some(Golden::new(serde_json::from_str(&text).unwrap()))
}

/// The golden unit sphere of 20 patches, which the repository has.
pub fn icosahedron() -> TriangularSpline {
    golden("sphere_icosahedron_rec").unwrap().spline
}

impl TriangularSpline {
    /// The spline with every point moved.
    fn mapped(mut self, map: impl Fn(&Point3) -> Point3) -> Self {
        let nets = self.nets.iter_mut().flatten().chain(self.curves.iter_mut().flatten());
        nets.chain(&mut self.base.positions).for_each(|p| *p = map(p));
        self
    }

    /// Moved by a vector.
    pub fn translated(self, offset: Vec3) -> Self {
        self.mapped(|p| p + offset)
    }

    /// Scaled about the origin.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.base.curvatures.iter_mut().for_each(|m| *m /= factor);
        self.mapped(|p| factor * p)
    }
}

const EVERYTHING: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

/// The parts of [`Field`] that these fields know nothing about.
macro_rules! unknown_ranges {
    () => {
        fn value(&self, p: Point3) -> f64 {
            self.gradient(p).0
        }
        fn range(&self, _: &Aabb) -> Interval {
            EVERYTHING
        }
        fn gradient_range(&self, _: &Aabb) -> (Interval, [Interval; 3]) {
            (EVERYTHING, [EVERYTHING; 3])
        }
        fn rounding_bound(&self, _: Point3) -> f64 {
            1e-14
        }
    };
}

/// |x − c|² − r².
#[derive(Clone, Copy)]
pub struct Sphere {
    pub center: Point3,
    pub radius: f64,
}

impl Sphere {
    pub fn at(x: f64, radius: f64) -> Self {
        Self { center: Point3::new(x, 0.0, 0.0), radius }
    }
}

impl Field for Sphere {
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let d = p - self.center;
        (d.norm_squared() - self.radius * self.radius, 2.0 * d)
    }
    fn jet(&self, p: Point3) -> Jet {
        let (value, gradient) = self.gradient(p);
        Jet { value, gradient, hessian: 2.0 * Mat3::identity() }
    }
    unknown_ranges!();
}

/// x²/a² + y²/b² + z²/c² − 1.
pub struct Ellipsoid(pub [f64; 3]);

impl Field for Ellipsoid {
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let g = Vec3::from_fn(|i, _| 2.0 * p[i] / (self.0[i] * self.0[i]));
        (0.5 * g.dot(&p) - 1.0, g)
    }
    fn jet(&self, p: Point3) -> Jet {
        let (value, gradient) = self.gradient(p);
        Jet {
            value,
            gradient,
            hessian: Mat3::from_diagonal(&Vec3::from_fn(|i, _| 2.0 / (self.0[i] * self.0[i]))),
        }
    }
    unknown_ranges!();
}

/// (√(x² + y²) − R)² + z² − r².
pub struct Torus {
    pub major: f64,
    pub minor: f64,
}

impl Field for Torus {
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let rho = p.x.hypot(p.y);
        let s = 2.0 * (rho - self.major);
        (
            0.25 * s * s + p.z * p.z - self.minor * self.minor,
            Vec3::new(s * p.x / rho, s * p.y / rho, 2.0 * p.z),
        )
    }
    fn jet(&self, p: Point3) -> Jet {
        let (value, gradient) = self.gradient(p);
        let rho = p.x.hypot(p.y);
        let radial = Vec3::new(p.x / rho, p.y / rho, 0.0);
        let around = Vec3::new(-radial.y, radial.x, 0.0);
        let hessian = 2.0 * radial * radial.transpose()
            + 2.0 * (rho - self.major) / rho * around * around.transpose()
            + 2.0 * Vec3::z() * Vec3::z().transpose();
        Jet { value, gradient, hessian }
    }
    unknown_ranges!();
}

/// The smaller of two fields.
pub struct Union(pub Sphere, pub Sphere);

impl Field for Union {
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let (a, b) = (self.0.gradient(p), self.1.gradient(p));
        if a.0 < b.0 { a } else { b }
    }
    fn jet(&self, p: Point3) -> Jet {
        let (a, b) = (self.0.jet(p), self.1.jet(p));
        if a.value < b.value { a } else { b }
    }
    unknown_ranges!();
}

/// 1/x: changes sign without a zero.
pub struct Pole;

impl Field for Pole {
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        (1.0 / p.x, Vec3::new(-1.0 / (p.x * p.x), 0.0, 0.0))
    }
    fn jet(&self, p: Point3) -> Jet {
        let (value, gradient) = self.gradient(p);
        Jet { value, gradient, hessian: Mat3::zeros() }
    }
    unknown_ranges!();
}

/// Not a number anywhere.
pub struct Nowhere;

impl Field for Nowhere {
    fn gradient(&self, _: Point3) -> (f64, Vec3) {
        (f64::NAN, Vec3::repeat(f64::NAN))
    }
    fn jet(&self, p: Point3) -> Jet {
        let (value, gradient) = self.gradient(p);
        Jet { value, gradient, hessian: Mat3::repeat(f64::NAN) }
    }
    unknown_ranges!();
}

/// A sphere with a range, that counts evaluations.
pub struct Counted {
    pub field: Sphere,
    count: AtomicUsize,
}

impl Counted {
    pub fn new(field: Sphere) -> Self {
        Self { field, count: AtomicUsize::new(0) }
    }

    pub fn evaluations(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }
}

impl Field for Counted {
    fn value(&self, p: Point3) -> f64 {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.field.value(p)
    }
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        self.field.gradient(p)
    }
    fn jet(&self, p: Point3) -> Jet {
        self.field.jet(p)
    }
    fn range(&self, cell: &Aabb) -> Interval {
        let (c, r) = (self.field.center, self.field.radius);
        let nearest = Point3::from_fn(|a, _| c[a].clamp(cell.min[a], cell.max[a]));
        let farthest = (cell.min - c).abs().sup(&(cell.max - c).abs());
        Interval { lo: (nearest - c).norm_squared() - r * r, hi: farthest.norm_squared() - r * r }
    }
    fn gradient_range(&self, _: &Aabb) -> (Interval, [Interval; 3]) {
        (EVERYTHING, [EVERYTHING; 3])
    }
    fn rounding_bound(&self, p: Point3) -> f64 {
        self.field.rounding_bound(p)
    }
}

/// The surface with a hole.
pub fn without_last_patch(spline: &TriangularSpline) -> TriangularSpline {
    let last = spline.nets.len() - 1;
    let faces: Vec<_> =
        spline.base.mesh.faces().take(last).map(|f| spline.base.mesh.triangle(f).map(|v| v.0)).collect();
    let mesh = HalfEdgeMesh::from_faces(spline.base.positions.len(), &faces).unwrap();
    // Taking away the last face leaves the numbers of all edges, because its edges have smaller half edges elsewhere.
    assert_eq!(mesh.edge_count(), spline.curves.len());
    let base = BaseMesh { mesh, ..spline.base.clone() };
    TriangularSpline::new(base, spline.curves.clone(), spline.nets[..last].to_vec())
}
