//! The cells of the hull of a polygon mesh: what the hull decides, and the function is built on.

use super::data::HermitePolygons;
use super::quadric::Quadric;
use crate::geom::{Point3, Vec3};
use crate::hull::{Class, Side};

/// What the cells over a face are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// A tetrahedron [u p_1 p_2 p_3] over a convex triangle (4.1).
    Triangle,
    /// A pyramid [u p_1 p_2 p_3 p_4] over a convex quadrilateral (4.2).
    Pyramid,
    /// K tetrahedra [u v p_s p_(s+1)] over any polygon (4.3). They are C1 for three corners, and for four if `center` and
    /// `normal` are those of a line through both diagonals. With more corners, only
    /// for gradients that happen to fit (4.10), (4.13).
    Fan,
    /// K tetrahedra [a c p_s p_(s+1)] on each side that has an apex a, with rational terms of their own: on one side of a
    /// convex polygon, on both of a nonconvex one. For any number of corners.
    Sectors,
}

/// Value and gradient of the function at an apex: the free parameters of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// F(a), in the sign of the function.
    pub value: f64,
    /// ∇F(a).
    pub gradient: Vec3,
}

/// A face of the hull.
#[derive(Clone, Debug, PartialEq)]
pub struct HybridFace {
    /// How the surface bends over it. A positive face has an outer apex, a negative one an inner apex, a nonconvex one both.
    pub class: Class,
    /// What its cells are made of; none for a face that is its own patch: zero convex, or left flat.
    pub element: Option<Element>,
    /// The point c of the line with its apexes.
    pub center: Point3,
    /// Unit direction of that line, to the outer side.
    pub normal: Vec3,
    /// The apexes: u on the outer side, v on the inner side. On the line through `center` along `normal`.
    pub apexes: [Option<Point3>; 2],
    /// Free parameters at the apexes; where none are given they are those of `quadric`. A fan has them at v alone.
    pub at_apex: [Option<Jet>; 2],
    /// The quadric that the function is close to.
    pub quadric: Quadric,
}

/// An edge of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HybridEdge {
    /// How the surface bends over it; seen from the left face if it is a crease.
    pub class: Class,
    /// Has it a cell [u_l u_r p_i p_j] on the outer and the inner side? Only where both faces have an apex; not at a boundary or a
    /// crease.
    pub cells: [bool; 2],
}

/// The hull of a polygon mesh.
#[derive(Clone, Debug)]
pub struct HybridHull {
    /// What is interpolated.
    pub data: HermitePolygons,
    /// The faces, in the order of the mesh.
    pub faces: Vec<HybridFace>,
    /// The edges, in the order of the mesh; the left face of an edge is that of its half edge.
    pub edges: Vec<HybridEdge>,
}

impl HybridFace {
    /// Value and gradient at the apex on a side: those given, or those of the quadric. None without an apex.
    pub fn jet(&self, side: Side) -> Option<Jet> {
        let apex = self.apexes[side.index()]?;
        let of_quadric = || Jet { value: self.quadric.value(&apex), gradient: self.quadric.gradient(&apex) };
        Some(self.at_apex[side.index()].unwrap_or_else(of_quadric))
    }
}

impl Jet {
    /// The coefficient F(a, a, x): value at x of the function whose graph is a third of the way along the tangent plane.
    pub fn towards(&self, apex: &Point3, x: &Point3) -> f64 {
        self.value + (x - apex).dot(&self.gradient) / 3.0
    }
}
