use super::domain::{self, Quadratic, Uv};
use super::{Part, SurfaceQuery};
use crate::geom::{Point3, Vec3};
use crate::surface::{PatchId, Sample};

/// Steps of the iteration in a patch; quadratic convergence takes three to six from the middle of a part.
const MAX_STEPS: usize = 40;
/// Trials of a step's length.
const MAX_TRIALS: usize = 12;
/// Parameter steps below this are rounding.
const PARAMETER_ROUNDING: f64 = 1e-14;
/// Parameter step of the differences that give second derivatives: they only steer the iteration, and each step then
/// divides the error by about this much.
const DIFFERENCE: f64 = 1e-6;
/// A step is taken if the squared distance falls by this part of what its slope promises; a parabola has a half.
const SUFFICIENT_DECREASE: f64 = 0.1;
/// Steps below this are in the reach of quadratic convergence, where the fall is lost in the rounding of the squared distance,
/// relative to it as given here.
const TRUSTED: f64 = 1e-5;
const FALL_ROUNDING: f64 = 1e-14;
/// What makes the matrix of a degenerate point definite, relative to its trace.
const REGULAR: f64 = 1e-10;

/// A nearest point of a surface.
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

impl SurfaceQuery<'_> {
    /// The nearest point of the surface; none for a surface without patches or a point that is not finite. Of several with the
    /// same distance, any.
    ///
    /// Every part of the surface that has a point nearer than the result is searched, by Newton's method from its middle. So
    /// only a part that is bent so much that the squared distance has several minima on it could hide a nearer point.
    pub fn nearest(&self, p: &Point3) -> Option<Nearest> {
        self.nearest_within(p, f64::INFINITY)
    }

    /// The nearest point of the surface if it is nearer than `limit`.
    pub fn nearest_within(&self, p: &Point3, limit: f64) -> Option<Nearest> {
        if !p.sum().is_finite() {
            return None;
        }
        let mut best: Option<Nearest> = None;
        self.tree.search(
            |b| b.distance_squared(p),
            limit * limit,
            |n, limit| match self.foot(&self.parts[n], p) {
                Some(foot) if foot.distance * foot.distance < limit => {
                    best = Some(foot);
                    foot.distance * foot.distance
                }
                _ => limit,
            },
        );
        best
    }

    /// The point of the patch of a part to which the squared distance falls from the middle of the part.
    fn foot(&self, part: &Part, p: &Point3) -> Option<Nearest> {
        let (surface, patch) = (self.surface, part.patch);
        let domain = surface.domain(patch);
        let [a, b, c] = part.triangle;
        let mut uv = [0, 1].map(|i| (a[i] + b[i] + c[i]) / 3.0);
        let mut at = surface.sample(patch, uv);
        let mut squared = (at.point - p).norm_squared();
        if squared.is_nan() {
            return None;
        }
        for _ in 0..MAX_STEPS {
            let model = self.model(patch, uv, &at, p);
            let step = model.lowest(domain, uv);
            let size = step[0].abs().max(step[1].abs());
            if size.is_nan() || size <= PARAMETER_ROUNDING {
                break;
            }
            let slope = 2.0 * (model.g[0] * step[0] + model.g[1] * step[1]);
            let shorter = (0..MAX_TRIALS).find_map(|halvings| {
                let s = 0.5f64.powi(halvings as i32);
                let next = domain::clamped(domain, [uv[0] + s * step[0], uv[1] + s * step[1]]);
                let sample = surface.sample(patch, next);
                let value = (sample.point - p).norm_squared();
                let rounding = if size < TRUSTED { FALL_ROUNDING * squared } else { 0.0 };
                let allowed = squared + SUFFICIENT_DECREASE * s * slope + rounding;
                (value <= allowed).then_some((next, sample, value))
            });
            let Some(next) = shorter else { break };
            let settled = size <= DIFFERENCE.powi(2);
            (uv, at, squared) = next;
            if settled {
                break;
            }
        }
        Some(Nearest { patch, uv, point: at.point, distance: squared.sqrt() })
    }

    /// Half the squared distance from `p` to second order, made convex where it is not.
    fn model(&self, patch: PatchId, [u, v]: Uv, at: &Sample, p: &Point3) -> Quadratic {
        let (r, du, dv) = (at.point - p, at.du, at.dv);
        let first = [du.norm_squared(), du.dot(&dv), dv.norm_squared()];
        let g = [r.dot(&du), r.dot(&dv)];
        // Differences are taken into the domain.
        let polygon = domain::corners(self.surface.domain(patch));
        let inward = |next: Uv| if domain::contains(polygon, next, 0.0) { DIFFERENCE } else { -DIFFERENCE };
        let (hu, hv) = (inward([u + DIFFERENCE, v]), inward([u, v + DIFFERENCE]));
        let (along_u, along_v) =
            (self.surface.sample(patch, [u + hu, v]), self.surface.sample(patch, [u, v + hv]));
        let second = |a: Vec3, b: Vec3, h: f64| r.dot(&(a - b)) / h;
        let h = [
            first[0] + second(along_u.du, du, hu),
            first[1] + second(along_v.du, du, hv),
            first[2] + second(along_v.dv, dv, hv),
        ];
        let trace = first[0] + first[2];
        let definite = h[0] > REGULAR * trace && h[0] * h[2] - h[1] * h[1] > REGULAR * trace * trace;
        let extra = REGULAR * trace;
        Quadratic { g, h: if definite { h } else { [first[0] + extra, first[1], first[2] + extra] } }
    }
}
