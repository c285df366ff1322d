//! What a smooth surface made of patches is, whatever method made it; traits and small value types only.

use crate::bernstein::restrict::over_triangle;
use crate::geom::{Aabb, Point3, Points, PointsMut, PointsView, Vec3, Vec4};

/// Number of a patch in its surface, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchId(pub u32);

impl PatchId {
    /// As an index into a per-patch array.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Parameter domain of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// (u, v) with u, v, 1 − u − v ≥ 0: barycentric coordinates of the first two corners.
    Triangle,
    /// (u, v) in the unit square.
    Square,
    /// A polygon with this many corners, as triangles between its edges and a point c inside of it: (k + u, v) with u and v in
    /// the unit interval is the point v c + (1 − v) ((1 − u) p_k + u p_(k+1)). All of v = 1 is c.
    Polygon(u8),
}

impl Domain {
    /// Parameters of a point of an edge, with the weights of its start and its end; see [`SeamSide::edge`].
    pub fn on_edge(self, edge: u8, [start, end]: [f64; 2]) -> [f64; 2] {
        match (self, edge) {
            (Self::Triangle, 0) => [start, end],
            (Self::Triangle, 1) => [0.0, start],
            (Self::Triangle, _) => [end, 0.0],
            (Self::Square, 0) => [end, 0.0],
            (Self::Square, 1) => [1.0, end],
            (Self::Square, 2) => [start, 1.0],
            (Self::Square, _) => [0.0, start],
            (Self::Polygon(_), k) => [f64::from(k) + end, 0.0],
        }
    }
}

/// A point of a patch with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position.
    pub point: Point3,
    /// Unit normal, out of the solid; NaN where the derivatives are parallel.
    pub normal: Vec3,
    /// Derivative by the first parameter.
    pub du: Vec3,
    /// Derivative by the second parameter.
    pub dv: Vec3,
}

/// How a patch is represented: what a writer needs to know.
#[derive(Clone, Copy, Debug)]
pub enum PatchForm<'a> {
    /// A polynomial Bézier triangle: its control net in the index order of [`crate::bernstein`].
    BezierTriangle {
        /// Polynomial degree.
        degree: usize,
        /// (degree + 1)(degree + 2)/2 control points.
        net: &'a [Point3],
    },
    /// A rational Bézier triangle: its weighted control points in the same order.
    RationalTriangle {
        /// Degree of numerator and denominator.
        degree: usize,
        /// (degree + 1)(degree + 2)/2 points (w x, w y, w z, w). All weights w are ≥ 0; where one is 0, so is the point, and such
        /// base points occur at the corners only: there the form is 0/0, and the patch goes on continuously.
        weighted: &'a [Vec4],
    },
    /// Zero set of a rational cubic in a cell of a hull: it can be sampled, but has no control points.
    APatch,
}

/// One side of a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeamSide {
    /// The patch.
    pub patch: PatchId,
    /// Which edge of it. Of a triangle, edge k runs from corner k to corner k + 1; of a square, edge 0 is v = 0 with u rising,
    /// edge 1 is u = 1 with v rising, edge 2 is v = 1 with u falling, edge 3 is u = 0 with v falling. Of a polygon, edge k is
    /// v = 0 with u rising from k to k + 1.
    pub edge: u8,
    /// Does the patch's edge run against the seam?
    pub reversed: bool,
}

/// How smoothly two patches meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continuity {
    /// Positions agree.
    G0,
    /// Positions and tangent planes agree.
    G1,
}

/// Where two patches meet, or a patch ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seam {
    /// The patch that gives the seam its direction.
    pub first: SeamSide,
    /// The other patch; none on a boundary.
    pub second: Option<SeamSide>,
    /// What holds across it.
    pub continuity: Continuity,
}

/// What a surface is fitted to.
pub trait Target: Send + Sync {
    /// Moves every point to a nearby point of the target; a point that finds none stays where its search ended.
    fn project(&self, points: &mut Points);

    /// Signed distance from the target to first order (f/|∇f|, positive outside) and unit normal at every point.
    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], normal: PointsMut<'_>);
}

/// A function whose zero set is a surface, and which knows the inside of it.
pub trait Volume: Send + Sync {
    /// Value and gradient of the function at a point; none where it is not defined. The function may vanish away from the
    /// surface as well, so its sign alone does not say what is inside.
    fn value(&self, p: Point3) -> Option<(f64, Vec3)>;

    /// Is the point inside the solid that the surface bounds? None if the surface is open.
    fn is_inside(&self, p: Point3) -> Option<bool>;
}

/// A smooth surface made of patches that can be sampled.
pub trait Surface: Send + Sync {
    /// Number of patches.
    fn patch_count(&self) -> usize;

    /// Parameter domain of a patch.
    fn domain(&self, patch: PatchId) -> Domain;

    /// Point, normal and derivatives at one parameter of a patch.
    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample;

    /// Samples at many parameters of one patch, into `out` (of the same length).
    fn sample_batch(&self, patch: PatchId, uv: &[[f64; 2]], out: &mut [Sample]) {
        for (out, uv) in out.iter_mut().zip(uv) {
            *out = self.sample(patch, *uv);
        }
    }

    /// The representation of a patch.
    fn form(&self, patch: PatchId) -> PatchForm<'_>;

    /// All seams and boundaries.
    fn seams(&self) -> &[Seam];

    /// Mesh vertices at the corners of a patch: patches that share a corner have the same number there. Of a square, those at
    /// (0, 0), (1, 0) and (1, 1); of a polygon, the first three.
    fn corners(&self, patch: PatchId) -> [u32; 3];

    /// Number of the curve under a seam. Seams on the same curve, as where sheets cross, have the same number; mostly each seam has a
    /// curve of its own.
    fn curve(&self, seam: usize) -> u32 {
        seam as u32
    }

    /// A box around a patch.
    fn bounds(&self, patch: PatchId) -> Aabb;

    /// A box around the part of a patch over a triangle of its parameter domain. Searches rely on it: it must hold every point
    /// of the part. The default is the box of the control net of the part, or of the patch where there is none.
    fn part_bounds(&self, patch: PatchId, triangle: [[f64; 2]; 3]) -> Aabb {
        match self.form(patch) {
            PatchForm::BezierTriangle { degree, net } => {
                let corners = triangle.map(|[u, v]| [u, v, 1.0 - u - v]);
                Aabb::around(&over_triangle(degree, net, &corners))
            }
            PatchForm::RationalTriangle { degree, weighted } => {
                let corners = triangle.map(|[u, v]| [u, v, 1.0 - u - v]);
                let part = over_triangle(degree, weighted, &corners);
                // Convex combinations of the control points, as no weight is negative.
                let points: Vec<Point3> = part.iter().filter(|p| p.w > 0.0).map(|p| p.xyz() / p.w).collect();
                Aabb::around(&points)
            }
            PatchForm::APatch => self.bounds(patch),
        }
    }

    /// The function behind the surface, if there is one.
    fn volume(&self) -> Option<&dyn Volume> {
        None
    }

    /// All patches.
    fn patches(&self) -> Box<dyn Iterator<Item = PatchId>> {
        Box::new((0..self.patch_count() as u32).map(PatchId))
    }
}
