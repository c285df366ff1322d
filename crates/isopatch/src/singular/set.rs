//! What is found out about the singular set of a surface in a box.

use crate::geom::{Aabb, Point3, Vec3};

/// How sure an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Measured: f and ∇f vanish there within [`SingularSet::tau`].
    Numerical,
    /// Shown by bounds with outward rounding: there is exactly one such point in the radius.
    Certified,
    /// Shown by exact algebra.
    Exact,
}

/// What an isolated singular point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PointKind {
    /// The Hessian is indefinite and regular: the surface is a cone over two ovals there, an A₁ point.
    Node,
    /// The Hessian is definite: the point is a connected component of the real surface, of dimension 0.
    Isolated,
    /// The Hessian is singular.
    Degenerate,
}

/// A singular point with no other one near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularPoint {
    /// Where, in model units.
    pub at: Point3,
    /// What it is.
    pub kind: PointKind,
    /// How many times the ideal (f, ∇f) has the point as a root, where that is known: 1 for a node.
    pub multiplicity: Option<usize>,
    /// The exact point is within this distance of `at`, in model units; a bound if the status is not numerical, else an
    /// estimate.
    pub radius: f64,
    /// How sure it is that the point is on the surface and singular.
    pub status: Status,
}

/// What the surface is along a singular curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CurveKind {
    /// Two sheets that cross at an angle: the Hessian has rank 2 and eigenvalues of both signs.
    Crossing,
    /// One sheet that turns back on itself, as in y² = x³.
    Cuspidal,
    /// Sheets that touch, or anything else along which the Hessian has rank 1 or 0.
    Tangential,
    /// The curve is all there is of the real surface: the Hessian has rank 2 and is semidefinite.
    Stick,
}

/// A point of a singular curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSample {
    /// Where, in model units.
    pub at: Point3,
    /// Unit tangent of the curve, in the direction of the samples.
    pub tangent: Vec3,
}

/// An arc of the singular set between two special points, or a closed curve without any.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularCurve {
    /// What the surface is along it.
    pub kind: CurveKind,
    /// Does the last sample lead back to the first, with no special point on the way? The first is not repeated.
    pub closed: bool,
    /// How sure it is; exact for lines between exact points.
    pub status: Status,
    /// Points in order along the curve; those of the ends are first and last.
    pub samples: Vec<CurveSample>,
    /// The special points at the first and the last sample, as indices into [`SingularSet::special`]; both are none for
    /// a closed curve. A loop at a special point has the same one twice.
    pub ends: Option<[usize; 2]>,
}

/// What a point is where arcs of the singular set begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SpecialKind {
    /// A crossing becomes a stick, as at the origin of x² = y z².
    Pinch,
    /// Three or more arcs meet.
    Triple,
    /// The singular set itself has a cusp, or two arcs of different kinds meet otherwise than at a pinch point.
    Cusp,
    /// An arc ends, in the inside of the box.
    End,
    /// An arc meets the boundary of the box.
    Box,
}

/// A point of the singular set at which arcs begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecialPoint {
    /// Where, in model units.
    pub at: Point3,
    /// What it is.
    pub kind: SpecialKind,
    /// How sure it is.
    pub status: Status,
}

/// A part of the real surface of dimension less than 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LowerDimensional {
    /// Of dimension 0: an index into [`SingularSet::points`].
    Point(usize),
    /// Of dimension 1: an index into [`SingularSet::curves`].
    Curve(usize),
}

impl LowerDimensional {
    /// 0 or 1.
    pub fn dimension(self) -> usize {
        match self {
            Self::Point(_) => 0,
            Self::Curve(_) => 1,
        }
    }
}

/// The singular set of the real surface f = 0 in a closed box: isolated points, and a graph of arcs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SingularSet {
    /// Isolated singular points, in lexicographic order.
    pub points: Vec<SingularPoint>,
    /// Arcs between special points, and closed curves.
    pub curves: Vec<SingularCurve>,
    /// The special points, in lexicographic order.
    pub special: Vec<SpecialPoint>,
    /// Parts of the real surface with no sheet of it near them.
    pub lower_dimensional: Vec<LowerDimensional>,
    /// Boxes, in model units, in which it is not known whether there is more: bounds could not show that they hold no
    /// singular point, and Newton's method found none. Everywhere else bounds show it, but for boxes beside a listed arc or
    /// point: those that reach within a thousandth of the box of the arc or a hundredth of the point are not looked at again.
    /// They are a fiftieth of the box wide at most.
    pub undecided: Vec<Aabb>,
    /// Where the status is numerical, |f| is at most this, relative to the largest Bernstein coefficient of f in the box.
    pub tau: f64,
}

impl SingularSet {
    /// The whole set as polylines; points as lines of one point.
    pub fn lines(&self) -> Vec<Vec<Point3>> {
        let curve = |curve: &SingularCurve| {
            let first = curve.samples.first().filter(|_| curve.closed);
            curve.samples.iter().chain(first).map(|s| s.at).collect()
        };
        let inner = self.special.iter().filter(|s| s.kind != SpecialKind::Box).map(|s| s.at);
        let points = self.points.iter().map(|p| p.at).chain(inner);
        self.curves.iter().map(curve).chain(points.map(|p| vec![p])).collect()
    }

    /// Is the surface smooth in the box?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.curves.is_empty()
    }
}
