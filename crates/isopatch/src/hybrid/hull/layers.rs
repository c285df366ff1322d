//! What the cells over a polygon have in the two layers next to an apex, by the unknowns that are free there.
//!
//! Over a triangle and in a pyramid these are F(a) and ∇F(a), in a fan F(v) and ∇F(v), and in sectors the coefficients of the
//! quadric: with any of them the function is C1, so they may move until the layers have the right signs.

use super::affine::Affine;
use crate::geom::{Mat3, Point3, Vec3};
use crate::hull::Side;
use crate::hybrid::{Element, HybridFace, Jet, PolygonFrame, Quadric};
use nalgebra::DVector;

/// The coefficients of a face that its unknowns move.
pub(super) enum Layers<'a> {
    /// One cell over the whole polygon.
    Cell { frame: &'a PolygonFrame, side: Side, apex: Point3, jet: JetForms },
    /// Sectors around a line with one apex or two.
    Sectors { frame: &'a PolygonFrame, face: &'a HybridFace, quadric: QuadricForms },
    /// Tetrahedra around a line from v to u.
    Fan(Box<Fan<'a>>),
}

/// Value and gradient at a point, and the unknowns that move them: the value in units of `unit`, the gradient in units of
/// `unit` over `length`.
pub(super) struct JetForms {
    at: Point3,
    jet: Jet,
    unit: f64,
    length: f64,
}

impl JetForms {
    pub const UNKNOWNS: usize = 4;

    /// F(a, a, x).
    fn towards(&self, x: &Point3) -> Affine {
        let third = self.unit / (3.0 * self.length) * (x - self.at);
        Affine {
            value: self.jet.towards(&self.at, x),
            slope: DVector::from_vec(vec![self.unit, third.x, third.y, third.z]),
        }
    }

    /// Value and gradient for given unknowns.
    fn moved(&self, x: &DVector<f64>) -> Jet {
        let by = self.unit / self.length * Vec3::new(x[1], x[2], x[3]);
        Jet { value: self.jet.value + self.unit * x[0], gradient: self.jet.gradient + by }
    }
}

/// A quadric and the unknowns that move it: its curvature along the normal of the face, then all of its coefficients, which cost
/// more because they also change what it is at the corners.
pub(super) struct QuadricForms {
    quadric: Quadric,
    directions: Vec<Quadric>,
}

/// Moving any coefficient by as much as the curvature along the normal costs this many times as much.
const COST_OF_OTHERS: f64 = 5.0;

impl QuadricForms {
    fn new(quadric: Quadric, normal: &Vec3, unit: f64) -> Self {
        let zero = Quadric { coefficients: [0.0; 10], ..quadric };
        let n = normal;
        let along = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z];
        let mut squared = zero;
        squared.coefficients[4..].copy_from_slice(&along.map(|c| 2.0 * unit * c));
        let single = |j: usize| {
            let mut one = zero;
            one.coefficients[j] = unit / COST_OF_OTHERS;
            one
        };
        let directions = std::iter::once(squared).chain((0..10).map(single)).collect();
        Self { quadric, directions }
    }

    fn blossom(&self, x: &Point3, y: &Point3, z: &Point3) -> Affine {
        let slope = self.directions.iter().map(|d| d.blossom(x, y, z));
        Affine {
            value: self.quadric.blossom(x, y, z),
            slope: DVector::from_iterator(self.directions.len(), slope),
        }
    }

    fn moved(&self, x: &DVector<f64>) -> Quadric {
        let mut q = self.quadric;
        for (direction, by) in self.directions.iter().zip(x) {
            q.coefficients.iter_mut().zip(direction.coefficients).for_each(|(c, d)| *c += by * d);
        }
        q
    }
}

/// A fan: all of its coefficients as they follow from value and gradient at v (4.7)–(4.12).
pub(super) struct Fan<'a> {
    frame: &'a PolygonFrame,
    u: Point3,
    v: Point3,
    /// Where the axis meets the polygon: the weight of u.
    share: f64,
    jet: JetForms,
    t1110: Vec<Affine>,
    t2010: Vec<Affine>,
    t2100: Affine,
    t3000: Affine,
}

impl<'a> Fan<'a> {
    fn new(frame: &'a PolygonFrame, u: Point3, v: Point3, center: &Point3, jet: JetForms) -> Self {
        let n = frame.count();
        let fixed = |value: f64| Affine::constant(value, JetForms::UNKNOWNS);
        let (before, after) = (|k: usize| frame.before(k), |k: usize| frame.after(k));
        // u in [p_s, p_(s+1), p_(s−1), v].
        let u_in: Vec<[f64; 4]> =
            (0..n).map(|s| barycentric([frame.p[s], frame.p[after(s)], frame.p[before(s)], v], &u)).collect();
        let corner = |s: usize, w: &Point3| fixed(frame.at_corner(s, w));
        let edge = |s: usize, w: &Point3| fixed(frame.on_edge(s, w));
        let t1110: Vec<Affine> = (0..n)
            .map(|s| {
                let around = [&corner(s, &v), &edge(s, &v), &edge(before(s), &v), &jet.towards(&frame.p[s])];
                Affine::sum(u_in[s], around)
            })
            .collect();
        let t2010: Vec<Affine> = (0..n)
            .map(|s| Affine::sum(u_in[s], [&corner(s, &u), &edge(s, &u), &edge(before(s), &u), &t1110[s]]))
            .collect();
        let mean = |along: &[Affine], last: &Affine| {
            let each =
                (0..n).map(|s| Affine::sum(u_in[s], [&along[s], &along[after(s)], &along[before(s)], last]));
            let zero = fixed(0.0);
            (1.0 / n as f64) * &each.fold(zero, |sum, form| &sum + &form)
        };
        let t2100 = mean(&t1110, &jet.towards(&u));
        let t3000 = mean(&t2010, &t2100);
        let axis = u - v;
        let share = (center - v).dot(&axis) / axis.norm_squared();
        Self { frame, u, v, share, jet, t1110, t2010, t2100, t3000 }
    }
}

/// Barycentric coordinates; not finite in a flat tetrahedron.
pub(super) fn barycentric([a, b, c, d]: [Point3; 4], x: &Point3) -> [f64; 4] {
    let inverse = Mat3::from_columns(&[b - a, c - a, d - a]).try_inverse();
    let r = inverse.map_or(Vec3::repeat(f64::NAN), |inverse| inverse * (x - a));
    [1.0 - r.sum(), r.x, r.y, r.z]
}

impl<'a> Layers<'a> {
    /// The layers of a face, whose unknowns are in units of `unit`; none if it has no cells.
    pub fn new(frame: &'a PolygonFrame, face: &'a HybridFace, unit: f64) -> Option<Self> {
        let jet = |side: Side| {
            let at = face.apexes[side.index()]?;
            let length = frame.p.iter().map(|p| (p - at).norm()).fold(0.0, f64::max);
            Some(JetForms { at, jet: face.jet(side)?, unit, length })
        };
        Some(match face.element? {
            Element::Triangle | Element::Pyramid => {
                let side = Side::BOTH.into_iter().find(|side| face.apexes[side.index()].is_some())?;
                Self::Cell { frame, side, apex: face.apexes[side.index()]?, jet: jet(side)? }
            }
            Element::Sectors => {
                Self::Sectors { frame, face, quadric: QuadricForms::new(face.quadric, &face.normal, unit) }
            }
            Element::Fan => {
                let [u, v] = face.apexes;
                Self::Fan(Box::new(Fan::new(frame, u?, v?, &face.center, jet(Side::Inner)?)))
            }
        })
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        match self {
            Self::Cell { .. } | Self::Fan(_) => JetForms::UNKNOWNS,
            Self::Sectors { quadric, .. } => quadric.directions.len(),
        }
    }

    /// The face with other unknowns.
    pub fn moved(&self, face: &HybridFace, x: &DVector<f64>) -> HybridFace {
        let mut face = face.clone();
        match self {
            Self::Cell { side, jet, .. } => face.at_apex[side.index()] = Some(jet.moved(x)),
            Self::Fan(fan) => face.at_apex[Side::Inner.index()] = Some(fan.jet.moved(x)),
            Self::Sectors { quadric, .. } => face.quadric = quadric.moved(x),
        }
        face
    }

    /// The coefficients of layers 2 and 3 on a side: F(a, a, a), F(a, a, p_k), and F(a, a, c) where c is a corner of the cells.
    pub fn upper(&self, side: Side) -> Vec<Affine> {
        match self {
            Self::Cell { frame, apex, jet, .. } => {
                std::iter::once(apex).chain(&frame.p).map(|x| jet.towards(x)).collect()
            }
            Self::Sectors { frame, face, quadric } => {
                let Some(a) = face.apexes[side.index()] else { return Vec::new() };
                let ends = [a, face.center];
                ends.iter().chain(&frame.p).map(|x| quadric.blossom(&a, &a, x)).collect()
            }
            Self::Fan(fan) => {
                let Fan { frame, u, v, share, jet, t2010, t2100, t3000, .. } = &**fan;
                let (to_u, to_v) = (*share, 1.0 - share);
                if side == Side::Outer {
                    let middle = Affine::sum([to_u, to_v], [t3000, t2100]);
                    [t3000.clone(), middle].into_iter().chain(t2010.iter().cloned()).collect()
                } else {
                    let middle = to_u * u + to_v * v;
                    [v, &middle].into_iter().chain(&frame.p).map(|x| jet.towards(x)).collect()
                }
            }
        }
    }

    /// The coefficients of layer 1 on a side that the unknowns move, where the surface may go through the polygon.
    pub fn middle(&self, side: Side) -> Vec<Affine> {
        match self {
            Self::Cell { .. } => Vec::new(),
            Self::Sectors { frame, face, quadric } => {
                let Some(a) = face.apexes[side.index()] else { return Vec::new() };
                let c = face.center;
                std::iter::once(&c).chain(&frame.p).map(|x| quadric.blossom(&a, &c, x)).collect()
            }
            Self::Fan(fan) => {
                let (to_u, to_v) = (fan.share, 1.0 - fan.share);
                let jet = |x: &Point3| fan.jet.towards(x);
                let [uu, uv, vv] = match side {
                    Side::Outer => [fan.t3000.clone(), fan.t2100.clone(), jet(&fan.u)],
                    Side::Inner => [fan.t2100.clone(), jet(&fan.u), jet(&fan.v)],
                };
                let center = Affine::sum([to_u * to_u, 2.0 * to_u * to_v, to_v * to_v], [&uu, &uv, &vv]);
                let along = fan.t1110.iter().enumerate().map(|(k, t1110)| {
                    let other = match side {
                        Side::Outer => [fan.t2010[k].clone(), t1110.clone()],
                        Side::Inner => [t1110.clone(), fan.jet.towards(&fan.frame.p[k])],
                    };
                    Affine::sum([to_u, to_v], [&other[0], &other[1]])
                });
                std::iter::once(center).chain(along).collect()
            }
        }
    }

    /// The coefficients on the base of sectors that have one side only: they may not have the sign of that side.
    pub fn base(&self) -> Vec<Affine> {
        let Self::Sectors { frame, face, quadric } = self else { return Vec::new() };
        if face.apexes.iter().all(Option::is_some) {
            return Vec::new();
        }
        let c = face.center;
        let to = std::iter::once(&c).chain(&frame.p).map(|x| quadric.blossom(&c, &c, x));
        let over_edges = (0..frame.count()).map(|k| Affine::constant(frame.on_edge(k, &c), self.unknowns()));
        to.chain(over_edges).collect()
    }

    /// F(w, a, a), F(w, a, p_k) and F(w, a, p_(k+1)) of the function beyond edge k, continued C1 to a point w: what the cell over
    /// the edge takes from this face.
    pub fn beyond(&self, side: Side, k: usize, w: &Point3) -> Option<[Affine; 3]> {
        let unknowns = self.unknowns();
        let fixed = |value: f64| Affine::constant(value, unknowns);
        match self {
            Self::Cell { frame, apex, jet, .. } => {
                let next = frame.after(k);
                // The other neighbours of the ends, which over a triangle are the same.
                let at_end = |end: usize, beside: usize, beside_edge: usize| {
                    let weights = barycentric([*apex, frame.p[k], frame.p[next], frame.p[beside]], w);
                    let own = fixed(frame.at_corner(end, apex));
                    let edge = fixed(frame.on_edge(k, apex));
                    let ends = if end == k { [&own, &edge] } else { [&edge, &own] };
                    let beside = fixed(frame.on_edge(beside_edge, apex));
                    Affine::sum(weights, [&jet.towards(&frame.p[end]), ends[0], ends[1], &beside])
                };
                let (before, behind) = (frame.before(k), frame.after(next));
                Some([jet.towards(w), at_end(k, before, before), at_end(next, behind, next)])
            }
            Self::Sectors { frame, face, quadric } => {
                let a = face.apexes[side.index()]?;
                let next = frame.after(k);
                let weights = barycentric([a, frame.p[k], frame.p[next], face.center], w);
                let edge = fixed(frame.on_edge(k, &a));
                let at_end = |end: usize| {
                    let own = fixed(frame.at_corner(end, &a));
                    let ends = if end == k { [&own, &edge] } else { [&edge, &own] };
                    let forms = [
                        &quadric.blossom(&a, &a, &frame.p[end]),
                        ends[0],
                        ends[1],
                        &quadric.blossom(&a, &face.center, &frame.p[end]),
                    ];
                    Affine::sum(weights, forms)
                };
                Some([quadric.blossom(&a, &a, w), at_end(k), at_end(next)])
            }
            Self::Fan(fan) => {
                let Fan { frame, u, v, jet, t1110, t2010, t2100, t3000, .. } = &**fan;
                let next = frame.after(k);
                let [own, other] = if side == Side::Outer { [u, v] } else { [v, u] };
                let weights = barycentric([*own, frame.p[k], frame.p[next], *other], w);
                let upper = |end: usize| match side {
                    Side::Outer => t2010[end].clone(),
                    Side::Inner => jet.towards(&frame.p[end]),
                };
                let [top, across] = match side {
                    Side::Outer => [t3000.clone(), t2100.clone()],
                    Side::Inner => [jet.towards(v), jet.towards(u)],
                };
                let edge = fixed(frame.on_edge(k, own));
                let at_end = |end: usize| {
                    let corner = fixed(frame.at_corner(end, own));
                    let ends = if end == k { [&corner, &edge] } else { [&edge, &corner] };
                    Affine::sum(weights, [&upper(end), ends[0], ends[1], &t1110[end]])
                };
                let whole = Affine::sum(weights, [&top, &upper(k), &upper(next), &across]);
                Some([whole, at_end(k), at_end(next)])
            }
        }
    }
}
