//! Points of the surface: the smallest root on a ray, and what follows from it.

use super::build::APatchFunction;
use crate::bernstein::cubic;
use crate::geom::{Point3, Vec3};
use crate::hull::tetrahedron::EdgeBasis;
use crate::hull::{Class, Side};
use crate::mesh::{EdgeId, FaceId};

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// The side of the mesh.
    pub side: Side,
    /// Parameter of the ray, 0 at the base and 1 at the apex; negative behind the base of a face.
    pub t: f64,
    /// The point.
    pub point: Point3,
    /// Gradient of the function there, not of unit length.
    pub gradient: Vec3,
    /// Derivative of the point by the first parameter of the patch.
    pub du: Vec3,
    /// Derivative by the second.
    pub dv: Vec3,
}

/// A cell with a ray in it that moves with the parameters (u, v): from `base` to `top`, in barycentric coordinates.
struct Ray {
    corners: [Point3; 4],
    base: [f64; 4],
    top: [f64; 4],
    /// Derivatives of base and top by u and v.
    moves: [[[f64; 4]; 2]; 2],
}

fn combine(weights: [f64; 4], points: &[Point3; 4]) -> Vec3 {
    weights[0] * points[0] + weights[1] * points[1] + weights[2] * points[2] + weights[3] * points[3]
}

fn mix(t: f64, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|c| (1.0 - t) * a[c] + t * b[c])
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|c| a[c] * b[c]).sum()
}

/// Gradient of a function in a tetrahedron by its derivatives by the barycentric coordinates.
pub(super) fn gradient(corners: &[Point3; 4], d: [f64; 4]) -> Vec3 {
    EdgeBasis::new(corners).gradient(d)
}

impl Ray {
    /// The shot at parameter t, where the function (times `sign`) has the derivatives that `partials` gives.
    fn shot(&self, side: Side, t: f64, partials: impl Fn([f64; 4]) -> [f64; 4]) -> Shot {
        let d = partials(mix(t, self.base, self.top));
        let along: [f64; 4] = std::array::from_fn(|c| self.top[c] - self.base[c]);
        let slope = dot(d, along);
        // The point stays on the surface while the ray moves: the derivative of the function along the way is zero.
        let derivative = |[base, top]: [[f64; 4]; 2]| {
            let moved = mix(t, base, top);
            let dt = -dot(d, moved) / slope;
            combine(std::array::from_fn(|c| moved[c] + dt * along[c]), &self.corners)
        };
        let (q, w) = (combine(self.base, &self.corners), combine(self.top, &self.corners));
        let [du, dv] = self.moves.map(derivative);
        let gradient = side.sign() * gradient(&self.corners, d);
        Shot { side, t, point: q + t * (w - q), gradient, du, dv }
    }
}

/// The side on which the surface is, where the function has the value `f` at the base.
pub fn side_of(class: Class, f: f64) -> Side {
    match class {
        Class::Negative => Side::Inner,
        Class::Nonconvex if f > 0.0 => Side::Inner,
        _ => Side::Outer,
    }
}

/// The root on a ray. Behind the base where a convex patch dips there; a nonconvex one has its other side for that.
pub fn root(class: Class, layers: &[f64; 4]) -> Option<f64> {
    if layers[0] > 0.0 && class != Class::Nonconvex {
        return cubic::root_behind(layers);
    }
    cubic::minimal_root(layers)
}

impl APatchFunction {
    /// The layers over the point x of a face on the side where the surface is: that side, and B_0 … B_3. None for a zero convex
    /// face.
    pub fn face_layers(&self, f: FaceId, x: [f64; 3]) -> Option<(Side, [f64; 4])> {
        let (class, face) = (self.hull().faces()[f.index()].class, &self.faces()[f.index()]);
        let (value, _) = face.base.value(x);
        let side = side_of(class, value);
        let [b1, b2, b3] = face.sides[side.index()].as_ref()?.layers(x, self.free()[f.index()][side.index()]);
        Some((side, [side.sign() * value, b1, b2, b3]))
    }

    /// The point of the patch over a face with barycentric coordinates x; du and dv are by the first two of them. None if the
    /// ray has no root.
    pub fn shoot_face(&self, f: FaceId, x: [f64; 3]) -> Option<Shot> {
        let hull = self.hull();
        let corners = hull.data().corners(f);
        let face = &self.faces()[f.index()];
        let Some((side, layers)) = self.face_layers(f, x) else {
            let flat = hull.face_frame(f);
            let point = x[0] * corners[0] + x[1] * corners[1] + x[2] * corners[2];
            let [du, dv] = [0, 1].map(|c| corners[c] - corners[2]);
            return Some(Shot { side: Side::Outer, t: 0.0, point, gradient: flat.normal, du, dv });
        };
        let t = root(hull.faces()[f.index()].class, &layers)?;
        let cell = face.sides[side.index()].as_ref()?;
        let b = self.free()[f.index()][side.index()];
        let ray = Ray {
            corners: [corners[0], corners[1], corners[2], hull.faces()[f.index()].apexes[side.index()]?],
            base: [x[0], x[1], x[2], 0.0],
            top: [0.0, 0.0, 0.0, 1.0],
            moves: [[[1.0, 0.0, -1.0, 0.0], [0.0; 4]], [[0.0, 1.0, -1.0, 0.0], [0.0; 4]]],
        };
        let s = side.sign();
        Some(ray.shot(side, t, |y| {
            let (value, d) = face.base.value([y[0], y[1], y[2]]);
            cell.value(b, (s * value, d.map(|d| s * d)), y).1
        }))
    }

    /// The point of the patch over an edge: x is the weight of its start, z = 1 − x that of its end, y that of the left apex.
    /// du is along the edge, dv from the right face to the left one. None without an edge cell or a root.
    pub fn shoot_edge(&self, e: EdgeId, [x, z]: [f64; 2], y: f64) -> Option<Shot> {
        let (hull, mesh) = (self.hull(), self.hull().data().mesh());
        let class = hull.edges()[e.index()].class;
        let h = mesh.edge_half_edge(e);
        let (base, k) = (&self.faces()[mesh.face(h).index()].base, mesh.side(h));
        let on_edge = [base.e[k][(k + 1) % 3], base.e[(k + 1) % 3][k]];
        let side = side_of(class, super::Base::on_edge(on_edge, x, z));
        let function = self.edge_function(e, side)?;
        let t = root(class, &function.layers(x, z, y))?;
        let [u_k, u_l] = hull.edge_apexes(e, side)?;
        let [p_i, p_j] = [mesh.origin(h), mesh.dest(h)].map(|v| hull.data().positions()[v.index()]);
        let ray = Ray {
            corners: [u_l, p_i, p_j, u_k],
            base: [0.0, x, z, 0.0],
            top: [1.0 - y, 0.0, 0.0, y],
            moves: [[[0.0, -1.0, 1.0, 0.0], [0.0; 4]], [[0.0; 4], [-1.0, 0.0, 0.0, 1.0]]],
        };
        Some(ray.shot(side, t, |b| function.value(b).1))
    }
}
