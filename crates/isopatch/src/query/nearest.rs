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
/// Steps below this are in the reach of quadratic convergence, where the fall is lost in rounding: of the squared distance, relative
/// to it, and of the points, relative to their coordinates.
const TRUSTED: f64 = 1e-5;
const FALL_ROUNDING: f64 = 1e-14;
const POINT_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// What makes the matrix of the model definite, each coordinate relative to the square of its own derivative: beside a side of a
/// patch that has shrunk to a point, one derivative is as small as the distance to it.
const REGULAR: f64 = 1e-10;
/// A derivative whose square is below this part of that of the other is zero: the point is closer to a side that has shrunk to a
/// point than rounding.
const VANISHING: f64 = 1e-30;
/// Directions that are tried from a side that has shrunk to a point, less one: some ten degrees apart in a half plane.
const TURNS: u32 = 16;

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
        let mut may_turn = true;
        for _ in 0..MAX_STEPS {
            let model = self.model(patch, uv, &at, p);
            let step = model.lowest(domain, uv);
            let size = step[0].abs().max(step[1].abs());
            let next =
                if size > PARAMETER_ROUNDING { self.fall(patch, uv, &model, step, squared, p) } else { None };
            if let Some(next) = next {
                (uv, at, squared) = next;
                if size <= DIFFERENCE.powi(2) {
                    break;
                }
            } else if let Some(turned) = self.turn(patch, uv, &at, p).filter(|_| may_turn) {
                (uv, at) = turned;
                may_turn = false;
            } else {
                break;
            }
        }
        Some(Nearest { patch, uv, point: at.point, distance: squared.sqrt() })
    }

    /// Where the squared distance has fallen, a step or some part of it away.
    fn fall(
        &self,
        patch: PatchId,
        uv: Uv,
        model: &Quadratic,
        step: [f64; 2],
        squared: f64,
        p: &Point3,
    ) -> Option<(Uv, Sample, f64)> {
        let domain = self.surface.domain(patch);
        let slope = 2.0 * (model.g[0] * step[0] + model.g[1] * step[1]);
        let trusted = step[0].abs().max(step[1].abs()) < TRUSTED;
        let distance = squared.sqrt();
        let of_points = POINT_ROUNDING * distance * (p.norm() + distance);
        let rounding = if trusted { FALL_ROUNDING * squared + of_points } else { 0.0 };
        (0..MAX_TRIALS).find_map(|halvings| {
            let s = 0.5f64.powi(halvings as i32);
            let next = domain::clamped(domain, [uv[0] + s * step[0], uv[1] + s * step[1]]);
            let sample = self.surface.sample(patch, next);
            let value = (sample.point - p).norm_squared();
            let allowed = squared + SUFFICIENT_DECREASE * s * slope + rounding;
            (value <= allowed).then_some((next, sample, value))
        })
    }

    /// On a side that has shrunk to a point, the parameters of the same point from which the distance falls most; none elsewhere.
    ///
    /// All of the side is one point, where the distance has no slope along the side, but the direction in which the patch is
    /// left depends on the place.
    fn turn(&self, patch: PatchId, uv: Uv, at: &Sample, p: &Point3) -> Option<(Uv, Sample)> {
        let squares = [at.du.norm_squared(), at.dv.norm_squared()];
        let fixed = (0..2).find(|c| squares[1 - c] <= VANISHING * squares[*c])?;
        let domain = self.surface.domain(patch);
        let polygon = domain::corners(domain);
        let along = (0..=TURNS).map(|n| {
            let mut next = uv;
            next[1 - fixed] = f64::from(n) / f64::from(TURNS) * domain::extent(domain)[1 - fixed];
            domain::clamped(domain, next)
        });
        let candidates = along.filter(|next| next[fixed] == uv[fixed]).map(|next| {
            let sample = self.surface.sample(patch, next);
            let d = if fixed == 0 { sample.du } else { sample.dv };
            let slope = (sample.point - p).dot(&d) / d.norm();
            let may_go = |sense: f64| {
                let mut beyond = next;
                beyond[fixed] += sense * DIFFERENCE;
                domain::contains(&polygon, beyond, 0.0)
            };
            let fall = if may_go(-slope.signum()) { slope.abs() } else { 0.0 };
            (fall, next, sample)
        });
        let falling = candidates.filter(|candidate| candidate.0 > 0.0);
        falling.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, next, sample)| (next, sample))
    }

    /// Half the squared distance from `p` to second order, made convex where it is not.
    fn model(&self, patch: PatchId, [u, v]: Uv, at: &Sample, p: &Point3) -> Quadratic {
        let (r, du, dv) = (at.point - p, at.du, at.dv);
        let first = [du.norm_squared(), du.dot(&dv), dv.norm_squared()];
        let g = [r.dot(&du), r.dot(&dv)];
        // Differences are taken into the domain.
        let polygon = domain::corners(self.surface.domain(patch));
        let inward = |next: Uv| if domain::contains(&polygon, next, 0.0) { DIFFERENCE } else { -DIFFERENCE };
        let (hu, hv) = (inward([u + DIFFERENCE, v]), inward([u, v + DIFFERENCE]));
        let (along_u, along_v) =
            (self.surface.sample(patch, [u + hu, v]), self.surface.sample(patch, [u, v + hv]));
        let second = |a: Vec3, b: Vec3, h: f64| r.dot(&(a - b)) / h;
        let h = [
            first[0] + second(along_u.du, du, hu),
            first[1] + second(along_v.du, du, hv),
            first[2] + second(along_v.dv, dv, hv),
        ];
        let definite = h[0] > REGULAR * first[0]
            && h[2] > REGULAR * first[2]
            && h[0] * h[2] - h[1] * h[1] > REGULAR * first[0] * first[2];
        if definite {
            return Quadratic { g, h };
        }
        let least = VANISHING * (first[0] + first[2]);
        let [first_u, first_v] = [first[0], first[2]].map(|square| (1.0 + REGULAR) * square.max(least));
        Quadratic { g, h: [first_u, first[1], first_v] }
    }
}
