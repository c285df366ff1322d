//! Chooses the cells over a polygon, and puts apexes over it.

use super::options::HybridOptions;
use super::shape::{Shape, diagonal_axis};
use crate::geom::{Point3, Vec3};
use crate::hull::{Class, Reason, Side};
use crate::hybrid::{Element, HermitePolygons, PolygonFrame};
use crate::mesh::FaceId;

/// What stands over a polygon, in the making.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub class: Class,
    pub element: Option<Element>,
    pub center: Point3,
    /// Unit direction of the line with the apexes.
    pub direction: Vec3,
    /// Heights over the centre of the outer and the inner apex.
    pub heights: [f64; 2],
    /// Largest distance between two corners.
    pub diameter: f64,
    /// Mean normal.
    pub normal: Vec3,
    /// What is wrong with it.
    pub fault: Option<Reason>,
}

impl Placed {
    /// A polygon that is its own patch.
    pub fn flat(frame: &PolygonFrame, class: Class, fault: Option<Reason>) -> Self {
        let count = frame.count() as f64;
        let center = frame.p[0] + frame.p.iter().map(|p| p - frame.p[0]).sum::<Vec3>() / count;
        let normal = frame.n.iter().sum::<Vec3>().try_normalize(0.0).unwrap_or_else(Vec3::z);
        let (direction, heights, diameter, element) = (normal, [0.0; 2], 0.0, None);
        Self { class, element, center, direction, heights, diameter, normal, fault }
    }

    pub fn reaches(&self, side: Side) -> bool {
        self.element.is_some() && self.class.reaches(side)
    }

    pub fn apexes(&self) -> [Option<Point3>; 2] {
        Side::BOTH.map(|side| {
            let height = self.heights[side.index()];
            self.reaches(side).then(|| self.center + side.sign() * height * self.direction)
        })
    }

    /// Puts the apexes on another line and above the tangent planes by a part of the diameter, on each side.
    pub fn raised(&self, frame: &PolygonFrame, direction: Vec3, above: [f64; 2]) -> Option<Self> {
        let mut heights = [0.0; 2];
        for side in Side::BOTH.into_iter().filter(|side| self.reaches(*side)) {
            let least = least_height(frame, &self.center, &direction, side)?;
            heights[side.index()] = least + above[side.index()] * self.diameter;
        }
        Some(Self { direction, heights, ..self.clone() })
    }
}

/// How a face with edges of these classes bends.
fn class_of(frame: &PolygonFrame, data: &HermitePolygons, f: FaceId) -> Class {
    let classes: Vec<Class> = data.mesh().face_half_edges(f).map(|h| data.edge_class(h)).collect();
    let of = |class| classes.contains(&class);
    debug_assert_eq!(classes.len(), frame.count());
    match (of(Class::Positive), of(Class::Negative), of(Class::Nonconvex)) {
        (false, false, false) => Class::Zero,
        (true, false, false) => Class::Positive,
        (false, true, false) => Class::Negative,
        _ => Class::Nonconvex,
    }
}

/// Chooses what stands over a polygon, with apexes on its mean normal.
pub(super) fn placed(data: &HermitePolygons, f: FaceId, options: &HybridOptions) -> Placed {
    let frame = data.frame(f);
    let class = class_of(&frame, data, f);
    let Some(shape) = Shape::new(&frame.p) else {
        return Placed::flat(&frame, class, Some(Reason::NoApex));
    };
    // Only the sectors of a polygon can be pulled to a crease.
    let pulled = data.mesh().face_half_edges(f).any(|h| !data.ends_in_crease(h));
    let (element, class) = match (class, frame.count()) {
        (Class::Zero, _) if shape.planar => (None, class),
        (Class::Positive | Class::Negative, 3) if triangle_bends(&frame, class) => {
            (Some(if pulled { Element::Sectors } else { Element::Triangle }), class)
        }
        (Class::Positive | Class::Negative, 4) if pyramid_bends(&frame, &shape, class) => {
            (Some(if pulled { Element::Sectors } else { Element::Pyramid }), class)
        }
        (Class::Positive | Class::Negative, 3 | 4) => (Some(Element::Sectors), Class::Nonconvex),
        (Class::Zero, _) => (Some(Element::Sectors), Class::Nonconvex),
        _ => (Some(Element::Sectors), class),
    };
    let mut base = Placed {
        class,
        element,
        center: shape.center,
        direction: shape.normal,
        heights: [0.0; 2],
        diameter: shape.diameter,
        normal: shape.normal,
        fault: None,
    };
    if options.fans && class == Class::Nonconvex && element.is_some() {
        use_fan(&mut base, &frame);
    }
    let above = [options.height; 2];
    let mean = mean_normal(&frame);
    // A fan keeps its axis: only with that it is C1.
    let directions = [base.direction, mean];
    let choices = if base.element == Some(Element::Fan) { &directions[..1] } else { &directions };
    let raised = choices.iter().find_map(|direction| base.raised(&frame, *direction, above));
    raised.unwrap_or_else(|| {
        let heights = [options.height * base.diameter; 2];
        Placed { heights, fault: Some(Reason::NoVisibleNormal), ..base }
    })
}

fn use_fan(base: &mut Placed, frame: &PolygonFrame) {
    match *frame.p {
        [_, _, _] => base.element = Some(Element::Fan),
        [a, b, c, d] => {
            if let Some((center, direction)) = diagonal_axis(&[a, b, c, d]) {
                *base = Placed { element: Some(Element::Fan), center, direction, ..base.clone() };
            }
        }
        _ => {}
    }
}

/// Mean direction of the gradients at the corners.
pub(super) fn mean_normal(frame: &PolygonFrame) -> Vec3 {
    let units = frame.n.iter().filter_map(|n| n.try_normalize(0.0));
    units.sum::<Vec3>().try_normalize(0.0).unwrap_or_else(Vec3::z)
}

/// A direction has to rise over the tangent plane of every corner with this sine at least.
const LEAST_RISE: f64 = 0.05;

/// Height of an apex at which it is on or above all tangent planes, and all F(p_k, p_(k+1), apex) are positive or zero (t_l and
/// t_lm of the paper); none if the direction does not rise over a tangent plane.
fn least_height(frame: &PolygonFrame, center: &Point3, direction: &Vec3, side: Side) -> Option<f64> {
    let mut least = 0.0f64;
    for k in 0..frame.count() {
        let rise = direction.dot(&frame.n[k]);
        if rise <= LEAST_RISE * frame.n[k].norm() {
            return None;
        }
        least = least.max(side.sign() * (frame.p[k] - center).dot(&frame.n[k]) / rise);
        let [at_center, above] = [*center, center + direction].map(|w| frame.on_edge(k, &w));
        let rise = above - at_center;
        // Where the coefficient over an edge does not rise, layers 2 and 3 have to do.
        if rise > LEAST_RISE * frame.n[k].norm() / 3.0 {
            least = least.max(-side.sign() * at_center / rise);
        }
    }
    Some(least)
}

/// Is the function at most 0 (times the sign of the side) on a triangle whose edges bend one way?
fn triangle_bends(frame: &PolygonFrame, class: Class) -> bool {
    let sign = if class == Class::Positive { 1.0 } else { -1.0 };
    (0..3).all(|k| sign * frame.on_edge(k, &frame.p[(k + 2) % 3]) <= 0.0)
}

/// Is the function at most 0 (times the sign of the side) on the bilinear quadrilateral, and is that convex seen along its normal?
///
/// The values are the rational coefficients "number 3" of (4.2), from the twists at the corners and over the edges.
fn pyramid_bends(frame: &PolygonFrame, shape: &Shape, class: Class) -> bool {
    let sign = if class == Class::Positive { 1.0 } else { -1.0 };
    let convex = (0..4).all(|k| {
        let (before, after) = (frame.before(k), frame.after(k));
        let turn = (frame.p[k] - frame.p[before]).cross(&(frame.p[after] - frame.p[k]));
        turn.dot(&shape.normal) > LEAST_TURN * shape.diameter * shape.diameter
    });
    let twist = |k: usize| {
        let (a, b) = (k, frame.after(k));
        let (beside_a, beside_b) =
            (frame.p[frame.before(a)] - frame.p[a], frame.p[frame.after(b)] - frame.p[b]);
        let g = frame.middle[k];
        let near_a =
            frame.at_corner(a, &frame.p[b]) + (frame.n[a].dot(&beside_b) + 2.0 * g.dot(&beside_a)) / 9.0;
        let near_b =
            frame.at_corner(b, &frame.p[a]) + (2.0 * g.dot(&beside_b) + frame.n[b].dot(&beside_a)) / 9.0;
        [near_a, near_b]
    };
    convex && (0..4).flat_map(twist).all(|value| sign * value <= 0.0)
}

/// Sides of a convex quadrilateral turn by more than this: the doubled area at a corner relative to the squared diameter.
const LEAST_TURN: f64 = 1e-3;
