//! The functional form: a C1 function over a plane triangulation, each triangle split into three.
//!
//! Bajaj & Xu 1997 name it (abstract and section 1: "a functional patch by subdividing each triangular patch into three smaller
//! patches", "multivariate functional B-splines (B-patches)") and give no formulas. This is the macro element with that split, of
//! Clough & Tocher: cubic pieces from values and gradients at the vertices, with derivatives across the edges that are linear along
//! them. It serves where a part of a surface is the graph of a function over a plane. [`super::b_patch`] makes B-patches of it.

use super::b_patch::BPatch;
use crate::geom::Vec4;
use nalgebra::Vector2;

/// A point or a direction in the plane.
pub type Vec2 = Vector2<f64>;

/// Value and gradient of a function at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexValue {
    /// Where.
    pub at: Vec2,
    /// The value.
    pub value: f64,
    /// The gradient.
    pub gradient: Vec2,
}

/// The function over one triangle: three cubics, part k over corner k, corner k + 1 and the centroid.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionalPatch {
    /// The corners.
    pub corners: [Vec2; 3],
    /// Bézier coefficients of the parts in the order of [`crate::bernstein`].
    pub parts: [[f64; 10]; 3],
}

/// The patch over a triangle; none if it has no area. Patches of triangles that share an edge are C1 there.
pub fn functional_patch(vertices: &[VertexValue; 3]) -> Option<FunctionalPatch> {
    let corners = vertices.map(|v| v.at);
    let [a, b, c] = corners;
    let area = (b - a).perp(&(c - a));
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    let center = (a + b + c) / 3.0;
    let towards = |v: &VertexValue, to: &Vec2| v.value + v.gradient.dot(&(to - v.at)) / 3.0;
    let mut parts = [[0.0; 10]; 3];
    for (k, part) in parts.iter_mut().enumerate() {
        let (from, to) = (&vertices[k], &vertices[(k + 1) % 3]);
        // 300, 210, 201, 120, 111, 102, 030, 021, 012, 003
        part[0] = from.value;
        part[1] = towards(from, &to.at);
        part[2] = towards(from, &center);
        part[3] = towards(to, &from.at);
        part[6] = to.value;
        part[7] = towards(to, &center);
        part[4] = linear_across(part, &[from.at, to.at, center]);
    }
    let inner = parts.map(|part| part[4]);
    let spokes: [f64; 3] = std::array::from_fn(|k| (parts[k][2] + inner[k] + inner[(k + 2) % 3]) / 3.0);
    for (k, part) in parts.iter_mut().enumerate() {
        part[5] = spokes[k];
        part[8] = spokes[(k + 1) % 3];
        part[9] = spokes.iter().sum::<f64>() / 3.0;
    }
    Some(FunctionalPatch { corners, parts })
}

/// The middle coefficient with which the derivative at a right angle to the first edge is linear along it.
fn linear_across(part: &[f64; 10], [a, b, center]: &[Vec2; 3]) -> f64 {
    // The foot of the centroid on the edge: direction = centre − foot, with barycentric coordinates (s − 1, −s, 1).
    let edge = b - a;
    let s = (center - a).dot(&edge) / edge.norm_squared();
    let ends = [(s - 1.0) * part[0] - s * part[1] + part[2], (s - 1.0) * part[3] - s * part[6] + part[7]];
    0.5 * (ends[0] + ends[1]) - (s - 1.0) * part[1] + s * part[3]
}

impl FunctionalPatch {
    /// The value at barycentric coordinates in the whole triangle.
    pub fn value(&self, l: [f64; 3]) -> f64 {
        // The part whose opposite corner has the smallest coordinate; its own coordinates take that off.
        let opposite = (0..3).fold(0, |least, i| if l[i] < l[least] { i } else { least });
        let k = (opposite + 1) % 3;
        let low = l[opposite];
        let x = [l[k] - low, l[(k + 1) % 3] - low, 3.0 * low];
        crate::bernstein::triangle::basis(3, x).iter().zip(&self.parts[k]).map(|(b, c)| b * c).sum()
    }

    /// The graph of part k as a B-patch with all knots in its corners: points (x, y, value) with weight 1.
    pub fn b_patch(&self, k: usize) -> BPatch {
        let center = self.corners.iter().sum::<Vec2>() / 3.0;
        let corners = [self.corners[k], self.corners[(k + 1) % 3], center];
        let at = |ijk: [usize; 3]| -> Vec2 { (0..3).map(|c| ijk[c] as f64 / 3.0 * corners[c]).sum() };
        let points: Vec<Vec4> = crate::bernstein::index::indices(3)
            .zip(&self.parts[k])
            .map(|(ijk, value)| Vec4::new(at(ijk).x, at(ijk).y, *value, 1.0))
            .collect();
        BPatch::with_multiple_knots(3, &points)
    }
}
