//! The function in the cells over one face, whatever they are made of.

use super::cells::{Element, HybridFace};
use super::data::PolygonFrame;
use super::fan::FanNet;
use super::flank::{Flank, Third, rim};
use super::pyramid::PyramidCell;
use super::sectors::Sectors;
use super::star;
use super::tetra::{barycentric, gradient};
use crate::apatch::{self, Base, FaceSide, root, side_of};
use crate::geom::{Point3, Vec3};
use crate::hull::{Class, Layer1, Side};

/// The function in the cells of a face.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceCells {
    /// No cells: the face is its own patch, triangles between its edges and the point c.
    Flat(Point3),
    /// A tetrahedron over a triangle (4.1). With the layers of the triangle method, but its layer 2 is free at all corners.
    Triangle {
        /// Off the parameters at the apex.
        function: apatch::FaceFunction,
        /// Values at the apexes, for the function times the sign of the side.
        free: [f64; 2],
    },
    /// A pyramid over a quadrilateral (4.2).
    Pyramid(Box<PyramidCell>),
    /// Tetrahedra around an axis, from a [`Element::Fan`] or a [`Element::Sectors`].
    Sectors(Sectors),
}

/// A point of the base of a face's cells, where a ray starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Foot {
    /// Barycentric coordinates in a triangle.
    Triangle([f64; 3]),
    /// (s, t) in the base of a pyramid.
    Pyramid([f64; 2]),
    /// The sector k, and barycentric coordinates in [c p_k p_(k+1)].
    Sector(usize, [f64; 3]),
}

impl FaceCells {
    /// The function over a polygon with the given data. A face without the apexes that its element needs stays flat.
    pub fn new(frame: &PolygonFrame, face: &HybridFace) -> Self {
        Self::with_element(frame, face).unwrap_or(Self::Flat(face.center))
    }

    fn with_element(frame: &PolygonFrame, face: &HybridFace) -> Option<Self> {
        let made = match face.element? {
            Element::Triangle if frame.count() == 3 => triangle(frame, face),
            Element::Pyramid if frame.count() == 4 => {
                let side = Side::BOTH.into_iter().find(|side| face.apexes[side.index()].is_some())?;
                let apex = face.apexes[side.index()]?;
                Self::Pyramid(Box::new(PyramidCell::new(frame, side, &apex, &face.jet(side)?)))
            }
            Element::Fan => {
                let [u, v] = face.apexes;
                let (u, v) = (u?, v?);
                let net = FanNet::new(frame, &u, &v, &face.jet(Side::Inner)?);
                Self::Sectors(net.split([&u, &v], face.center))
            }
            Element::Sectors if face.apexes.iter().any(Option::is_some) => {
                Self::Sectors(star::sectors(frame, face))
            }
            _ => return None,
        };
        Some(made)
    }

    /// How rays are chosen: where there are cells on both sides, by the sign of the function on the base.
    pub(super) fn class(&self, class: Class) -> Class {
        match self {
            Self::Sectors(sectors) if sectors.sides.iter().all(Option::is_some) => Class::Nonconvex,
            _ => class,
        }
    }

    /// Has it a cell on this side?
    pub fn has(&self, side: Side) -> bool {
        match self {
            Self::Flat(_) => false,
            Self::Triangle { function, .. } => function.sides[side.index()].is_some(),
            Self::Pyramid(cell) => cell.side == side,
            Self::Sectors(sectors) => sectors.sides[side.index()].is_some(),
        }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        let sides = Side::BOTH.into_iter().filter(|side| self.has(*side)).count();
        match self {
            Self::Sectors(sectors) => sides * sectors.base.len(),
            _ => sides,
        }
    }

    /// Layer 0 in the sign of the function.
    fn base(&self, foot: Foot) -> Option<f64> {
        match (self, foot) {
            (Self::Triangle { function, .. }, Foot::Triangle(x)) => Some(function.base.value(x).0),
            (Self::Pyramid(cell), Foot::Pyramid([s, t])) => Some(cell.side.sign() * cell.layer0(s, t).0),
            (Self::Sectors(sectors), Foot::Sector(k, x)) => Some(sectors.base.get(k)?.at(x)),
            _ => None,
        }
    }

    /// The layers of the ray from a foot to the apex on a side, for the function times the sign of the side.
    pub fn layers_on(&self, side: Side, foot: Foot) -> Option<[f64; 4]> {
        let with = |base: f64, [b1, b2, b3]: [f64; 3]| Some([side.sign() * base, b1, b2, b3]);
        match (self, foot) {
            (Self::Triangle { function, free }, Foot::Triangle(x)) => {
                let cell = function.sides[side.index()].as_ref()?;
                with(function.base.value(x).0, cell.layers(x, free[side.index()]))
            }
            (Self::Pyramid(cell), Foot::Pyramid([s, t])) => (cell.side == side).then(|| cell.layers(s, t)),
            (Self::Sectors(sectors), Foot::Sector(k, x)) => {
                let cell = sectors.sides[side.index()].as_ref()?.get(k)?;
                with(sectors.base.get(k)?.at(x), cell.layers(x))
            }
            _ => None,
        }
    }

    /// The layers on the side where the surface is, for a face of the given class.
    pub fn layers(&self, class: Class, foot: Foot) -> Option<(Side, [f64; 4])> {
        let side = side_of(self.class(class), self.base(foot)?);
        Some((side, self.layers_on(side, foot)?))
    }

    /// The parameter of the surface on the ray from a foot, and the side.
    pub fn root(&self, class: Class, foot: Foot) -> Option<(Side, f64)> {
        let (side, layers) = self.layers(class, foot)?;
        Some((side, root(self.class(class), &layers)?))
    }

    /// Value and gradient at the parameter t of the ray from a foot to the apex on a side.
    pub fn value(
        &self,
        corners: &[Point3],
        apex: &Point3,
        side: Side,
        foot: Foot,
        t: f64,
    ) -> Option<(f64, Vec3)> {
        let s = side.sign();
        let along = |x: [f64; 3]| x.map(|x| (1.0 - t) * x);
        let signed = |(value, d): (f64, [f64; 3])| (s * value, d.map(|d| s * d));
        let (value, gradient) = match (self, foot) {
            (Self::Triangle { function, free }, Foot::Triangle(x)) => {
                let cell = function.sides[side.index()].as_ref()?;
                let y = along(x);
                let base = signed(function.base.value(y));
                let (value, d) = cell.value(free[side.index()], base, [y[0], y[1], y[2], t]);
                (value, gradient(&[*corners.first()?, *corners.get(1)?, *corners.get(2)?, *apex], d))
            }
            (Self::Pyramid(cell), Foot::Pyramid([u, v])) if cell.side == side => cell.value([t, u, v]),
            (Self::Sectors(sectors), Foot::Sector(k, x)) => {
                let cell = sectors.sides[side.index()].as_ref()?.get(k)?;
                let y = along(x);
                let (value, d) = cell.value(signed(sectors.base.get(k)?.value(y)), [t, y[0], y[1], y[2]]);
                let next = if k + 1 == corners.len() { 0 } else { k + 1 };
                (value, gradient(&[*apex, sectors.center, *corners.get(k)?, *corners.get(next)?], d))
            }
            _ => return None,
        };
        Some((s * value, s * gradient))
    }

    /// What the cells give to the cell of edge k on a side, along the edge as the face has it.
    pub fn flank(&self, corners: &[Point3], apex: &Point3, side: Side, k: usize) -> Option<Flank> {
        let count = corners.len();
        let next = if k + 1 == count { 0 } else { k + 1 };
        let ends = [*corners.get(k)?, *corners.get(next)?];
        let (rim, third) = match self {
            Self::Flat(_) => return None,
            Self::Triangle { function, free } => {
                let given = function.sides[side.index()].as_ref()?.flank(k, false, free[side.index()]);
                let point = corners[(k + 2) % 3];
                let far = (given.rim.b + 2.0 * given.third_q) / 3.0;
                (given.rim, given.third.map(|mixed| Third { point, mixed, far }))
            }
            Self::Pyramid(cell) if cell.side == side => {
                let layer1 = [cell.once(k, k), cell.once(k, next), cell.once(next, next)];
                let third = [(k, (k + 3) % 4), (next, (k + 2) % 4)].map(|(end, w)| Third {
                    point: corners[w],
                    mixed: cell.once(end, w),
                    far: cell.twice(w),
                });
                (rim(layer1, [cell.twice(k), cell.twice(next)], cell.layer3), third)
            }
            Self::Pyramid(_) => return None,
            Self::Sectors(sectors) => {
                let cell = sectors.sides[side.index()].as_ref()?.get(k)?;
                let [_, cp, cq, pp, pq, qq] = cell.layer1;
                let [far, p, q] = cell.layer2;
                let third = [cp, cq].map(|mixed| Third { point: sectors.center, mixed, far });
                (rim([pp, pq, qq], [p, q], cell.layer3), third)
            }
        };
        Some(Flank { apex: *apex, ends, rim, third })
    }

    /// The point where a ray starts, and its derivatives by the coordinates of the foot.
    pub fn point(&self, corners: &[Point3], foot: Foot) -> Option<(Point3, [Vec3; 3])> {
        let zero = Vec3::zeros();
        match (self, foot) {
            (Self::Pyramid(cell), Foot::Pyramid([s, t])) => {
                let (point, [by_s, by_t]) = cell.foot(s, t);
                Some((point, [by_s, by_t, zero]))
            }
            (_, Foot::Triangle(x)) => {
                let p: &[Point3; 3] = corners.first_chunk()?;
                Some((x[0] * p[0] + x[1] * p[1] + x[2] * p[2], *p))
            }
            (Self::Sectors(Sectors { center, .. }) | Self::Flat(center), Foot::Sector(k, x)) => {
                let next = if k + 1 == corners.len() { 0 } else { k + 1 };
                let p = [*center, *corners.get(k)?, *corners.get(next)?];
                Some((x[0] * p[0] + x[1] * p[1] + x[2] * p[2], p))
            }
            _ => None,
        }
    }
}

/// Sub-algorithm 1.
fn triangle(frame: &PolygonFrame, face: &HybridFace) -> FaceCells {
    let mut e = [[0.0; 3]; 3];
    for k in 0..3 {
        let next = frame.after(k);
        [e[k][next], e[next][k]] = frame.along(k);
    }
    // t_0111 of each edge; the rational term (4.1) mixes them.
    let middle = std::array::from_fn(|k| frame.on_edge(k, &frame.p[(k + 2) % 3]));
    let mut free = [0.0; 2];
    let sides = Side::BOTH.map(|side| {
        let (apex, jet) = (face.apexes[side.index()]?, face.jet(side)?);
        let s = side.sign();
        let layer1 = Layer1 {
            corner: std::array::from_fn(|k| s * frame.at_corner(k, &apex)),
            edge: std::array::from_fn(|k| s * frame.on_edge(k, &apex)),
        };
        free[side.index()] = s * jet.value;
        let layer2: [f64; 3] = std::array::from_fn(|k| s * jet.towards(&apex, &frame.p[k]));
        Some(FaceSide { layer1, q: layer2.map(|f| 0.5 * (3.0 * f - s * jet.value)) })
    });
    FaceCells::Triangle {
        function: apatch::FaceFunction { base: Base { e, middle, split: false }, sides },
        free,
    }
}

/// The cell of a polygon's sectors that holds a point with barycentric coordinates x in a triangle, whose c has the coordinates
/// given; and the change of the coordinates there by those in the triangle is linear.
pub(super) fn sector_of(x: [f64; 3], center: [f64; 3]) -> (usize, [f64; 3]) {
    let third = (0..3).min_by(|a, b| (x[*a] / center[*a]).total_cmp(&(x[*b] / center[*b]))).unwrap_or(0);
    let weight = x[third] / center[third];
    let (p, q) = ((third + 1) % 3, (third + 2) % 3);
    (p, [weight, x[p] - weight * center[p], x[q] - weight * center[q]])
}

/// Barycentric coordinates of a point in a triangle that it lies in the plane of.
pub(super) fn in_triangle(corners: [Point3; 3], x: &Point3) -> [f64; 3] {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let [w, y, z, over] = barycentric([a, b, c, a + normal / normal.norm().sqrt()], x);
    // The fourth corner is over the first.
    [w + over, y, z]
}
