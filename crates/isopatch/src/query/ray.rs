use super::domain::{self, Uv};
use super::{Part, SurfaceQuery};
use crate::geom::{Aabb, Point3, Vec3};
use crate::surface::{PatchId, Sample};

/// How often a part is quartered before its root is looked for whatever its shape.
const MAX_DEPTH: usize = 7;
/// A part can have one root only if, seen along the ray, no normal at its corners and its middle is steeper than this …
const STEEPEST: f64 = 0.15;
/// … and none makes a larger angle with another one (cosine).
const WIDEST: f64 = 0.6;
/// Steps of Newton's method for a root.
const MAX_STEPS: usize = 60;
/// The last step of Newton's method, in parameters: the next one would be its square.
const SETTLED: f64 = 1e-9;
/// Part of the way to the border that a step goes which would cross it: on the border itself a side that has shrunk to a point
/// leaves no way back.
const TO_BORDER: f64 = 0.9;
/// A root outside of a part by this much of its height counts: neighbours leave no gap between them.
const SLACK: f64 = 1e-8;
/// Hits in the same sense closer than this part of the diagonal are one: two sheets have a hit in the other sense between them.
const SAME: f64 = 1e-9;
/// Boxes are grown by this part of the diagonal for rays along their sides.
const BOX_ROUNDING: f64 = 1e-13;

/// A half line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Point3,
    /// Where it goes, of any length but zero.
    pub direction: Vec3,
}

/// Where a ray goes through a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The patch.
    pub patch: PatchId,
    /// Its parameters.
    pub uv: [f64; 2],
    /// The point of the surface.
    pub point: Point3,
    /// Its unit normal, out of the solid.
    pub normal: Vec3,
    /// Distance from the origin of the ray, in model units.
    pub distance: f64,
}

/// A ray with unit direction, and two unit vectors across it.
struct Line {
    origin: Point3,
    direction: Vec3,
    across: [Vec3; 2],
    /// 1/direction.
    inverse: Vec3,
}

impl Ray {
    fn line(&self) -> Option<Line> {
        let direction = self.direction.try_normalize(0.0)?;
        if !(self.origin.sum().is_finite() && direction.sum().is_finite()) {
            return None;
        }
        let other = Vec3::ith(direction.iamin(), 1.0);
        let first = direction.cross(&other).normalize();
        let across = [first, direction.cross(&first)];
        Some(Line { origin: self.origin, direction, across, inverse: direction.map(|d| 1.0 / d) })
    }
}

impl Line {
    /// Distance at which the line enters a box, 0 from inside; infinite if it misses it.
    fn entry(&self, b: &Aabb, margin: f64) -> f64 {
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for a in 0..3 {
            let [lo, hi] = [b.min[a] - margin, b.max[a] + margin].map(|x| x - self.origin[a]);
            if self.direction[a] == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return f64::INFINITY;
                }
                continue;
            }
            let (s, t) = (lo * self.inverse[a], hi * self.inverse[a]);
            (near, far) = (near.max(s.min(t)), far.min(s.max(t)));
        }
        if near <= far { near } else { f64::INFINITY }
    }

    /// Coordinates across the line.
    fn across(&self, v: &Vec3) -> [f64; 2] {
        [self.across[0].dot(v), self.across[1].dot(v)]
    }
}

impl SurfaceQuery<'_> {
    /// All points where a ray goes through the surface, nearest first; where patches meet, one of them is named. Empty for a ray
    /// that is not finite or has no direction.
    ///
    /// Parts whose box the ray misses are ruled out for certain. The others are quartered until the surface in them is a graph
    /// over the plane across the ray, so that it has one root at most, or seven times. Whether it is a graph is judged by the
    /// normals at the corners and the middle of the part, which is no proof: two crossings close together, in a part that is
    /// folded between these four points, can be missed. Points where a ray only touches the surface, or nearly, may be there,
    /// once or twice, or not.
    pub fn hits(&self, ray: &Ray) -> Vec<RayHit> {
        let Some(line) = ray.line() else { return Vec::new() };
        let mut found = Vec::new();
        let margin = BOX_ROUNDING * self.bounds.diagonal();
        self.tree.search(
            |b| line.entry(b, margin),
            f64::INFINITY,
            |n, limit| {
                self.hits_of_part(self.parts[n], &line, &mut found);
                limit
            },
        );
        self.merged(&line, found)
    }

    /// The first of [`hits`](Self::hits).
    pub fn first_hit(&self, ray: &Ray) -> Option<RayHit> {
        let line = ray.line()?;
        let mut best: Option<RayHit> = None;
        let mut found = Vec::new();
        let margin = BOX_ROUNDING * self.bounds.diagonal();
        self.tree.search(
            |b| line.entry(b, margin),
            f64::INFINITY,
            |n, mut limit| {
                found.clear();
                self.hits_of_part(self.parts[n], &line, &mut found);
                for hit in &found {
                    if hit.distance < limit {
                        (best, limit) = (Some(*hit), hit.distance);
                    }
                }
                limit
            },
        );
        best
    }

    /// In order, and each once: parts that share a point have both found it.
    fn merged(&self, line: &Line, mut found: Vec<RayHit>) -> Vec<RayHit> {
        found.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.patch.cmp(&b.patch)));
        let near = SAME * self.bounds.diagonal();
        let mut merged: Vec<RayHit> = Vec::with_capacity(found.len());
        for hit in found {
            let enters = |hit: &RayHit| hit.normal.dot(&line.direction) < 0.0;
            let same = |other: &&RayHit| enters(other) == enters(&hit);
            let before = merged.iter().rev().take_while(|other| hit.distance - other.distance <= near);
            if before.clone().find(same).is_none() {
                merged.push(hit);
            }
        }
        merged
    }

    fn hits_of_part(&self, part: Part, line: &Line, found: &mut Vec<RayHit>) {
        let margin = BOX_ROUNDING * self.bounds.diagonal();
        let mut open = vec![(part.triangle, 0)];
        while let Some((triangle, depth)) = open.pop() {
            let missed = || self.surface.part_bounds(part.patch, triangle);
            if depth > 0 && line.entry(&missed(), margin) == f64::INFINITY {
                continue;
            }
            let corners = triangle.map(|uv| self.surface.sample(part.patch, uv));
            let middle = [0, 1].map(|c| (triangle[0][c] + triangle[1][c] + triangle[2][c]) / 3.0);
            let at_middle = self.surface.sample(part.patch, middle);
            let is_graph = is_graph(line, &corners, &at_middle);
            if is_graph || depth == MAX_DEPTH {
                match self.root(part.patch, middle, line) {
                    Root::At(hit) => {
                        if domain::contains(&triangle, hit.uv, SLACK) && hit.distance >= 0.0 {
                            found.push(hit);
                        }
                        continue;
                    }
                    // A graph over the plane across the ray has no root here if the way to it leaves the patch.
                    Root::Outside if is_graph => continue,
                    Root::Outside | Root::Lost => {}
                }
            }
            if depth < MAX_DEPTH {
                open.extend(domain::quarters(triangle).map(|part| (part, depth + 1)));
            }
        }
    }

    /// Newton's method for the point of a patch on a line, from the parameters `uv`.
    fn root(&self, patch: PatchId, mut uv: Uv, line: &Line) -> Root {
        let domain = self.surface.domain(patch);
        for _ in 0..MAX_STEPS {
            let at = self.surface.sample(patch, uv);
            let (off, du, dv) =
                (line.across(&(at.point - line.origin)), line.across(&at.du), line.across(&at.dv));
            let determinant = du[0] * dv[1] - du[1] * dv[0];
            let step = [
                (dv[0] * off[1] - dv[1] * off[0]) / determinant,
                (du[1] * off[0] - du[0] * off[1]) / determinant,
            ];
            let size = step[0].abs().max(step[1].abs());
            if !size.is_finite() {
                return Root::Lost;
            }
            let wanted = [uv[0] + step[0], uv[1] + step[1]];
            let clamped = domain::clamped(domain, wanted);
            // A step out of the domain slides along its border.
            let s = if clamped == wanted || size <= SETTLED { 1.0 } else { TO_BORDER };
            let next = [0, 1].map(|c| uv[c] + s * (clamped[c] - uv[c]));
            if size <= SETTLED {
                let at = self.surface.sample(patch, next);
                let distance = (at.point - line.origin).dot(&line.direction);
                return Root::At(RayHit { patch, uv: next, point: at.point, normal: at.normal, distance });
            }
            if (next[0] - uv[0]).abs().max((next[1] - uv[1]).abs()) <= SETTLED {
                return Root::Outside;
            }
            uv = next;
        }
        Root::Lost
    }
}

/// What Newton's method came to.
enum Root {
    At(RayHit),
    /// The border of the patch, with the root beyond it.
    Outside,
    Lost,
}

/// Is a part a graph over the plane across the line, as far as four of its normals show?
fn is_graph(line: &Line, corners: &[Sample; 3], middle: &Sample) -> bool {
    let normals = [corners[0].normal, corners[1].normal, corners[2].normal, middle.normal];
    let sense = normals[3].dot(&line.direction).signum();
    normals.iter().all(|n| sense * n.dot(&line.direction) > STEEPEST && n.dot(&normals[3]) > WIDEST)
}
