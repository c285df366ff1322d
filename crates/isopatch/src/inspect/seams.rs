//! How well patches meet: positions and normals along every seam, from the two control nets.

use super::or_infinite;
use super::samples::net;
use crate::bernstein::index;
use crate::geom::{Point3, Vec3, Widest};
use crate::parallel::Evenly;
use crate::surface::{Continuity, Sample, SeamSide, Surface};
use rayon::prelude::*;

/// Gaps and normal jumps of all seams.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seams {
    /// Number of seams between two patches.
    pub interior: usize,
    /// Number of patch edges where the surface ends.
    pub boundary: usize,
    /// Largest distance between the two boundary curves at equal parameters, relative to the diagonal.
    pub max_gap: f64,
    /// Index into [`Surface::seams`] of the largest gap; none if every gap is zero.
    pub worst_gap: Option<usize>,
    /// Largest angle between the two normals on a seam that claims G1, in radians; π where a normal vanishes.
    pub max_normal_jump: f64,
    /// Index into [`Surface::seams`] of the largest normal jump; none if there is none.
    pub worst_normal_jump: Option<usize>,
}

/// Measures every seam at `samples` ≥ 2 uniform parameters, both ends among them.
///
/// Everything is computed from differences of control points, so that a jump of 1e-15 rad shows as such wherever
/// the surface stands.
pub fn seams(surface: &dyn Surface, diagonal: f64, samples: usize) -> Seams {
    let intervals = samples.max(2) - 1;
    let parameters = (0..=intervals).map(|i| i as f64 / intervals as f64);
    let tables: Tables = std::array::from_fn(|n| parameters.clone().map(|t| (t, bernstein(n, t))).collect());
    let measured: Vec<_> = surface
        .seams()
        .par_iter()
        .evenly()
        .map(|seam| {
            let second = seam.second?;
            let (gap, jump) = measure(surface, seam.first, second, &tables)
                .unwrap_or_else(|| measure_samples(surface, seam.first, second, intervals));
            Some((gap, if seam.continuity == Continuity::G1 { jump } else { 0.0 }))
        })
        .collect();
    Seams::gathered(measured, diagonal)
}

impl Seams {
    /// The figures of all seams from the gap (a length) and the normal jump of each, none for a boundary.
    pub(super) fn gathered(measured: Vec<Option<(f64, f64)>>, diagonal: f64) -> Self {
        let mut result =
            Self { boundary: measured.iter().filter(|m| m.is_none()).count(), ..Self::default() };
        for (i, (gap, jump)) in measured.into_iter().enumerate().filter_map(|(i, m)| Some((i, m?))) {
            result.interior += 1;
            if gap / diagonal > result.max_gap {
                (result.max_gap, result.worst_gap) = (gap / diagonal, Some(i));
            }
            if jump > result.max_normal_jump {
                (result.max_normal_jump, result.worst_normal_jump) = (jump, Some(i));
            }
        }
        result
    }
}

/// Bernstein polynomials of every degree that occurs, at the parameters of the samples.
type Tables = [Vec<(f64, [f64; MAX_ROW])>; MAX_ROW];

/// Largest gap (a length) and largest normal jump (an angle) of one seam; none if a side is no polynomial.
fn measure(surface: &dyn Surface, first: SeamSide, second: SeamSide, tables: &Tables) -> Option<(f64, f64)> {
    let (a, b) = (Rows::new(surface, first)?, Rows::new(surface, second)?);
    let (mut gap, mut widest) = (0.0, Widest::default());
    for ((t, of_a), (_, of_b)) in tables[a.degree - 1].iter().zip(&tables[b.degree - 1]) {
        // From a common point: the difference of equal points is exactly zero wherever they are.
        let offset = a.offset(*t, of_a, &a.edge[0]) - b.offset(*t, of_b, &a.edge[0]);
        gap = f64::max(gap, or_infinite(offset.norm()));
        widest.add(a.normal(of_a), b.normal(of_b));
    }
    Some((gap, widest.angle()))
}

/// The same from samples. A corner in which one of the patches has no normal is left out: a vertex of a cone has none.
fn measure_samples(surface: &dyn Surface, first: SeamSide, second: SeamSide, intervals: usize) -> (f64, f64) {
    let at = |side: SeamSide, i: usize| surface.sample(side.patch, on_edge(side, i, intervals));
    let (mut gap, mut widest) = (0.0, Widest::default());
    for i in 0..=intervals {
        let (a, b) = (at(first, i), at(second, i));
        gap = f64::max(gap, or_infinite((a.point - b.point).norm()));
        let is_end = i == 0 || i == intervals;
        if !(is_end && (has_no_normal(&a) || has_no_normal(&b))) {
            widest.add(a.normal, b.normal);
        }
    }
    (gap, widest.angle())
}

fn has_no_normal(sample: &Sample) -> bool {
    !sample.normal.iter().all(|c| c.is_finite())
}

/// Parameters of point i of `intervals` along a seam, in the triangle on one of its sides.
fn on_edge(side: SeamSide, i: usize, intervals: usize) -> [f64; 2] {
    let i = if side.reversed { intervals - i } else { i };
    let (t, rest) = (i as f64 / intervals as f64, (intervals - i) as f64 / intervals as f64);
    match side.edge {
        0 => [rest, t],
        1 => [0.0, rest],
        _ => [t, 0.0],
    }
}

/// Control points of a row; degree 9 is the largest that [`crate::bernstein::triangle`] evaluates.
const MAX_ROW: usize = crate::bernstein::triangle::MAX_DEGREE + 1;

/// The boundary row of a patch and the row next to it, in the direction of the seam.
struct Rows {
    degree: usize,
    reversed: bool,
    edge: [Point3; MAX_ROW],
    inner: [Point3; MAX_ROW],
}

impl Rows {
    fn new(surface: &dyn Surface, side: SeamSide) -> Option<Self> {
        let (degree, net) = net(surface, side.patch)?;
        let row = |depth: usize| {
            std::array::from_fn(|m| match degree - depth {
                last if m > last => Point3::zeros(),
                last => {
                    net[index::row(degree, side.edge.into(), depth, if side.reversed { last - m } else { m })]
                }
            })
        };
        Some(Self { degree, reversed: side.reversed, edge: row(0), inner: row(1) })
    }

    /// Point of the boundary curve at t less `origin`; `basis` of degree n − 1, the last step of de Casteljau's
    /// algorithm makes it n.
    fn offset(&self, t: f64, basis: &[f64; MAX_ROW], origin: &Point3) -> Vec3 {
        let term =
            |m: usize| basis[m] * ((1.0 - t) * (self.edge[m] - origin) + t * (self.edge[m + 1] - origin));
        (0..self.degree).map(term).sum()
    }

    /// A positive multiple of the outward normal: tangent of the edge × derivative into the patch.
    fn normal(&self, basis: &[f64; MAX_ROW]) -> Vec3 {
        let (mut along, mut across) = (Vec3::zeros(), Vec3::zeros());
        for m in 0..self.degree {
            along += basis[m] * (self.edge[m + 1] - self.edge[m]);
            // Any start on the edge will do, because a multiple of `along` drops out of the product.
            across += basis[m] * (self.inner[m] - self.edge[m]);
        }
        if self.reversed { across.cross(&along) } else { along.cross(&across) }
    }
}

/// Bernstein polynomials of degree `n` at t.
fn bernstein(n: usize, t: f64) -> [f64; MAX_ROW] {
    let mut b = [0.0; MAX_ROW];
    b[0] = 1.0;
    for degree in 1..=n {
        b[degree] = t * b[degree - 1];
        for i in (1..degree).rev() {
            b[i] = (1.0 - t) * b[i] + t * b[i - 1];
        }
        b[0] *= 1.0 - t;
    }
    b
}
