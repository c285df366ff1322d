//! The closest point of a surface made of Bézier triangles.

use super::samples::{SampleSet, net};
use super::tree::PatchTree;
use crate::bernstein::triangle::{self, Tangents};
use crate::geom::{Point3, Points};
use crate::surface::{PatchId, Sample, Surface};

/// Intervals of the lattice whose nearest point starts the iteration in a patch.
const START_LATTICE: usize = 4;
/// Limits of the iteration; a patch that is close to its chord plane takes three or four steps.
const MAX_STEPS: usize = 30;
const MAX_TRIALS: usize = 8;
/// A step is taken if the squared distance falls by this part of what its slope promises; the exact minimum of a
/// parabola has a half.
const SUFFICIENT_DECREASE: f64 = 0.25;
/// The iteration in a patch ends when the parameters move by less than this: the distance is stationary there, so
/// its error is of the order of the square.
const PARAMETER_TOLERANCE: f64 = 1e-7;

/// A closest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The patch it is on.
    pub patch: PatchId,
    /// Its parameters.
    pub uv: [f64; 2],
    /// The point.
    pub point: Point3,
    /// Its distance to the query, in model units.
    pub distance: f64,
}

/// Search tree over the patches of a surface.
pub struct ClosestPatch<'a> {
    surface: &'a dyn Surface,
    tree: PatchTree,
    start_parameters: Vec<[f64; 2]>,
    /// Points at the start parameters, patch after patch.
    starts: Points,
}

impl<'a> ClosestPatch<'a> {
    /// Builds the tree. Patches with a control point that is not finite are left out.
    pub fn new(surface: &'a dyn Surface) -> Self {
        let lattice = triangle::lattice(START_LATTICE);
        let patches: Vec<PatchId> = surface.patches().collect();
        let starts = SampleSet::new(surface, &lattice).points(surface, &patches);
        let start_parameters = lattice.iter().map(|p| [p[0], p[1]]).collect();
        Self { surface, tree: PatchTree::new(surface), start_parameters, starts }
    }

    /// The closest point of the surface; none for a surface without patches or a point that is not finite.
    ///
    /// Begins in the patch with the nearest point of a coarse lattice and goes on to all patches that a lower bound
    /// of their distance does not rule out. In each patch the iteration starts from the lattice point: a patch that
    /// is strongly bent may have a closer point than the one found, so the result is never too small.
    pub fn nearest(&self, p: &Point3) -> Option<Nearest> {
        let mut first = None;
        self.tree.search(p, f64::INFINITY, |patch, limit| {
            let (start, distance) = self.start(patch, p);
            if distance < limit {
                first = Some((patch, start));
            }
            distance.min(limit)
        });
        let (patch, start) = first?;
        let mut best = self.nearest_in_patch(patch, start, p);
        self.tree.search(p, best.distance.powi(2), |other, limit| {
            if other == patch {
                return limit;
            }
            let candidate = self.nearest_in_patch(other, self.start(other, p).0, p);
            if candidate.distance < best.distance {
                best = candidate;
            }
            best.distance.powi(2)
        });
        Some(best)
    }

    /// The closest point of one patch.
    ///
    /// Gauss–Newton with the domain as constraint: the closest point of the flat triangle that the patch's
    /// linearisation at (u, v) makes of the domain gives the direction, a line search the length of the step.
    fn nearest_in_patch(&self, patch: PatchId, start: [f64; 2], p: &Point3) -> Nearest {
        let polynomial = net(self.surface, patch);
        let at = |uv: [f64; 2]| {
            let t = match polynomial {
                Some((degree, net)) => triangle::evaluate(degree, net, uv),
                None => {
                    let Sample { point, du, dv, .. } = self.surface.sample(patch, uv);
                    Tangents { point, du, dv }
                }
            };
            (t, Nearest { patch, uv, point: t.point, distance: (t.point - p).norm() })
        };
        let (mut tangents, mut best) = at(start);
        for _ in 0..MAX_STEPS {
            let [u, v] = best.uv;
            let corner = |x: f64, y: f64| tangents.point + (x - u) * tangents.du + (y - v) * tangents.dv;
            let [x, y] = closest_in_triangle([corner(1.0, 0.0), corner(0.0, 1.0), corner(0.0, 0.0)], p);
            let along = |s: f64| at([u + s * (x - u), v + s * (y - v)]);
            if (x - u).abs().max((y - v).abs()) < PARAMETER_TOLERANCE {
                let last = along(1.0).1;
                return if last.distance < best.distance { last } else { best };
            }
            let slope = 2.0 * (tangents.point - p).dot(&(corner(x, y) - tangents.point));
            let Some(next) = line_search(best.distance.powi(2), slope, along, |n| n.1.distance.powi(2))
            else {
                break;
            };
            (tangents, best) = next;
        }
        best
    }

    /// Parameters of the lattice point that is nearest to `p`, and its squared distance.
    fn start(&self, patch: PatchId, p: &Point3) -> ([f64; 2], f64) {
        let first = patch.index() * self.start_parameters.len();
        let mut best = ([1.0 / 3.0; 2], f64::INFINITY);
        for (i, uv) in self.start_parameters.iter().enumerate() {
            let distance = (self.starts.get(first + i) - p).norm_squared();
            if distance < best.1 {
                best = (*uv, distance);
            }
        }
        best
    }
}

/// A point at(s), 0 < s ≤ 1, where φ has fallen enough below φ(0) = `start`, of which `slope` is the derivative.
///
/// Tries s = 1, then the minimum of the parabola through what is known: where the surface bends towards the query
/// or away from it, the full step is too long by the factor 1 + distance · curvature.
fn line_search<T>(start: f64, slope: f64, at: impl Fn(f64) -> T, phi: impl Fn(&T) -> f64) -> Option<T> {
    let mut s = 1.0;
    for _ in 0..MAX_TRIALS {
        let next = at(s);
        let value = phi(&next);
        if value < start + SUFFICIENT_DECREASE * s * slope {
            return Some(next);
        }
        let minimum = -0.5 * slope * s * s / (value - start - slope * s);
        s = if minimum.is_nan() { 0.5 * s } else { minimum.clamp(0.1 * s, 0.5 * s) };
    }
    None
}

/// Coordinates (u, v) of the point of a triangle that is closest to `p`, u and v the weights of the first two
/// corners.
fn closest_in_triangle(corners: [Point3; 3], p: &Point3) -> [f64; 2] {
    let [a, b, c] = corners;
    let (e, f, d) = (a - c, b - c, p - c);
    let (ee, ef, ff, de, df) = (e.dot(&e), e.dot(&f), f.dot(&f), d.dot(&e), d.dot(&f));
    let determinant = ee * ff - ef * ef;
    let (u, v) = ((ff * de - ef * df) / determinant, (ee * df - ef * de) / determinant);
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return [u, v];
    }
    // Outside, or a triangle without area (NaN): the best of the three edges.
    let on_edge = |from: Point3, to: Point3| {
        let along = to - from;
        let t = (p - from).dot(&along) / along.norm_squared();
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        (t, (from + t * along - p).norm_squared())
    };
    let (ab, bc, ca) = (on_edge(a, b), on_edge(b, c), on_edge(c, a));
    let candidates = [([1.0 - ab.0, ab.0], ab.1), ([0.0, 1.0 - bc.0], bc.1), ([ca.0, 0.0], ca.1)];
    candidates.into_iter().fold(([0.0; 2], f64::INFINITY), |best, c| if c.1 < best.1 { c } else { best }).0
}
