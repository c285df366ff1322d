//! Fields with a known answer, for tests: a formula over any kind of number.

use std::ops::{Add, Mul, Sub};

use crate::field::Field;
use crate::geom::{Aabb, Interval, Jet, Mat3, Point3, Vec3};

/// A kind of number that a formula can be evaluated with.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn of(c: f64) -> Self;
    fn squared(self) -> Self;
}

impl Number for f64 {
    fn of(c: f64) -> Self {
        c
    }
    fn squared(self) -> Self {
        self * self
    }
}

/// Value and first derivatives.
#[derive(Clone, Copy)]
pub struct Dual(f64, Vec3);

impl Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.0 * o.1 + o.0 * self.1)
    }
}
impl Number for Dual {
    fn of(c: f64) -> Self {
        Self(c, Vec3::zeros())
    }
    fn squared(self) -> Self {
        self * self
    }
}

/// Value, first and second derivatives.
#[derive(Clone, Copy)]
pub struct Dual2(f64, Vec3, Mat3);

impl Add for Dual2 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1, self.2 + o.2)
    }
}
impl Sub for Dual2 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1, self.2 - o.2)
    }
}
impl Mul for Dual2 {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let cross = self.1 * o.1.transpose();
        Self(
            self.0 * o.0,
            self.0 * o.1 + o.0 * self.1,
            self.0 * o.2 + o.0 * self.2 + cross + cross.transpose(),
        )
    }
}
impl Number for Dual2 {
    fn of(c: f64) -> Self {
        Self(c, Vec3::zeros(), Mat3::zeros())
    }
    fn squared(self) -> Self {
        self * self
    }
}

/// An interval, rounded outward.
#[derive(Clone, Copy)]
pub struct Range(f64, f64);

impl Range {
    fn outward(lo: f64, hi: f64) -> Self {
        Self(lo.next_down(), hi.next_up())
    }
}
impl Add for Range {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::outward(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for Range {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::outward(self.0 - o.1, self.1 - o.0)
    }
}
impl Mul for Range {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        if [self.0, self.1, o.0, o.1].iter().any(|c| c.is_nan()) {
            return Self(f64::NEG_INFINITY, f64::INFINITY);
        }
        let p = [self.0 * o.0, self.0 * o.1, self.1 * o.0, self.1 * o.1];
        Self::outward(
            p.into_iter().fold(f64::INFINITY, f64::min),
            p.into_iter().fold(-f64::INFINITY, f64::max),
        )
    }
}
impl Number for Range {
    fn of(c: f64) -> Self {
        Self(c, c)
    }
    fn squared(self) -> Self {
        let (a, b) = (self.0 * self.0, self.1 * self.1);
        let lo = if self.0 <= 0.0 && self.1 >= 0.0 { 0.0 } else { a.min(b).next_down() };
        Self(lo, a.max(b).next_up())
    }
}

/// A formula that can be evaluated with any kind of number.
pub trait Formula: Send + Sync {
    fn eval<T: Number>(&self, x: T, y: T, z: T) -> T;

    /// Sum of the absolute values of the largest terms, for the rounding bound.
    fn magnitude(&self, p: Point3) -> f64 {
        let r = Range(-1.0, 1.0);
        let s = |c: f64| Range::of(c.abs()) * r;
        let total = self.eval(s(p.x), s(p.y), s(p.z));
        total.0.abs().max(total.1.abs())
    }
}

/// A formula as a field.
pub struct Analytic<F>(pub F);

impl<F: Formula> Field for Analytic<F> {
    fn value(&self, p: Point3) -> f64 {
        self.0.eval(p.x, p.y, p.z)
    }
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let d = self.0.eval(Dual(p.x, Vec3::x()), Dual(p.y, Vec3::y()), Dual(p.z, Vec3::z()));
        (d.0, d.1)
    }
    fn jet(&self, p: Point3) -> Jet {
        let d = |c, n| Dual2(c, n, Mat3::zeros());
        let d = self.0.eval(d(p.x, Vec3::x()), d(p.y, Vec3::y()), d(p.z, Vec3::z()));
        Jet { value: d.0, gradient: d.1, hessian: d.2 }
    }
    fn range(&self, cell: &Aabb) -> Interval {
        let side = |i: usize| Range(cell.min[i], cell.max[i]);
        let r = self.0.eval(side(0), side(1), side(2));
        Interval { lo: r.0, hi: r.1 }
    }
    fn gradient_range(&self, _: &Aabb) -> (Interval, [Interval; 3]) {
        let all = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
        (all, [all; 3])
    }
    fn rounding_bound(&self, p: Point3) -> f64 {
        // Some twenty operations, each on terms no larger than the magnitude.
        20.0 * f64::EPSILON * self.0.magnitude(p)
    }
}

macro_rules! formula {
    ($name:ident, |$x:ident, $y:ident, $z:ident| $body:expr) => {
        pub struct $name;
        impl Formula for $name {
            fn eval<T: Number>(&self, $x: T, $y: T, $z: T) -> T {
                $body
            }
        }
    };
}

fn sq<T: Number>(a: T) -> T {
    a.squared()
}

fn c<T: Number>(value: f64) -> T {
    T::of(value)
}

formula!(Torus, |x, y, z| sq(sq(x) + sq(y) + sq(z) + c(24.0)) - c::<T>(100.0) * (sq(x) + sq(y)));
formula!(Dodeca, |x, y, z| {
    let (a, b, d) = (sq(x), sq(y), sq(z));
    a * sq(a) + b * sq(b) + d * sq(d) + c::<T>(20.0) * (sq(a) * b + sq(b) * d + sq(d) * a) - c(1.0)
});
formula!(DoubleTorus, |x, y, z| sq(sq(x) * (sq(x) - c(1.0)) + sq(y)) + sq(z) - c(0.04));
formula!(McMullen, |x, y, z| (sq(x) + c(1.0)) * (sq(y) + c(1.0)) * (sq(z) + c(1.0))
    + c::<T>(8.0) * x * y * z
    - c(2.0));
formula!(Chair, |x, y, z| sq(sq(x) + sq(y) + sq(z) - c(23.75))
    - c::<T>(0.8) * (sq(z - c(5.0)) - c::<T>(2.0) * sq(x)) * (sq(z + c(5.0)) - c::<T>(2.0) * sq(y)));
formula!(Decocube, |x, y, z| {
    let one = c::<T>(1.0);
    let ring = |a: T, b: T, d: T| sq(sq(a) + sq(b) - c(0.64)) + sq(sq(d) - one);
    ring(x, y, z) * ring(y, z, x) * ring(z, x, y) - c(0.02)
});
formula!(NestedSpheres, |x, y, z| {
    let r = sq(x) + sq(y) + sq(z);
    (r - c(1.0)) * (r - c(2.0))
});
formula!(TwoSpheres, |x, y, z| {
    let r = sq(x) + sq(y);
    (r + sq(z) - c(1.0)) * (r + sq(z - c(3.0)) - c(1.0))
});
formula!(TouchingSpheres, |x, y, z| {
    let r = sq(x) + sq(y);
    (r + sq(z) - c(1.0)) * (r + sq(z - c(2.0)) - c(1.0))
});
formula!(Lemniscate, |x, y, z| sq(x) + sq(y) - sq(z) * (c::<T>(1.0) - sq(z)));
formula!(Plane, |x, y, z| x + c::<T>(0.5) * y - c::<T>(0.25) * z);
formula!(Cylinder, |x, y, z| sq(x) + sq(y) - c(1.0) + c::<T>(0.0) * z);
formula!(NoZero, |x, y, z| sq(x) + sq(y) + sq(z) + c(1.0));
formula!(Constant, |x, y, z| c::<T>(0.0) * (x + y + z));
formula!(Nan, |x, y, z| c::<T>(f64::NAN) * (x + y + z));

/// Sphere of any radius around any centre, with the sign that is asked for.
pub struct Sphere {
    pub center: Point3,
    pub radius: f64,
    pub sign: f64,
}

impl Formula for Sphere {
    fn eval<T: Number>(&self, x: T, y: T, z: T) -> T {
        let r = sq(x - c(self.center.x)) + sq(y - c(self.center.y)) + sq(z - c(self.center.z));
        c::<T>(self.sign) * (r - c(self.radius * self.radius))
    }
}

/// 1/f of another field: its sign changes at poles.
pub struct Reciprocal<F>(pub F);

impl<F: Field> Field for Reciprocal<F> {
    fn value(&self, p: Point3) -> f64 {
        1.0 / self.0.value(p)
    }
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let jet = self.jet(p);
        (jet.value, jet.gradient)
    }
    fn jet(&self, p: Point3) -> Jet {
        let Jet { value: f, gradient: g, hessian: h } = self.0.jet(p);
        let hessian = (2.0 * g * g.transpose() / f - h) / (f * f);
        Jet { value: 1.0 / f, gradient: -g / (f * f), hessian }
    }
    fn range(&self, _: &Aabb) -> Interval {
        Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY }
    }
    fn gradient_range(&self, cell: &Aabb) -> (Interval, [Interval; 3]) {
        (self.range(cell), [self.range(cell); 3])
    }
    fn rounding_bound(&self, _: Point3) -> f64 {
        0.0
    }
}

pub fn cube(half: f64) -> Aabb {
    Aabb::new(Vec3::repeat(-half), Vec3::repeat(half))
}

/// Name, field, box, faces, Euler number.
pub type Example = (&'static str, Box<dyn Field>, Aabb, usize, i64);

/// The six surfaces of Tong & Kim 2009, table 3.
pub fn paper_surfaces() -> Vec<Example> {
    let flat = Aabb::new(Vec3::new(-6.4, -6.4, -1.4), Vec3::new(6.4, 6.4, 1.4));
    let double = Aabb::new(Vec3::new(-1.3, -0.9, -0.4), Vec3::new(1.3, 0.9, 0.4));
    vec![
        ("torus", Box::new(Analytic(Torus)), flat, 600, 0),
        ("dodeca", Box::new(Analytic(Dodeca)), cube(1.2), 1200, 2),
        ("double torus", Box::new(Analytic(DoubleTorus)), double, 1800, -2),
        ("McMullen", Box::new(Analytic(McMullen)), cube(2.2), 2000, 2),
        ("chair", Box::new(Analytic(Chair)), cube(8.0), 4000, -4),
        ("decocube", Box::new(Analytic(Decocube)), cube(1.5), 5000, -24),
    ]
}
