use super::{Ray, RayHit, SurfaceQuery};
use crate::geom::{Point3, Vec3};

/// Directions that are asked one after the other until an answer leaves no doubt; none is parallel to a plane that meshes
/// often have.
const DIRECTIONS: [[f64; 3]; 7] = [
    [0.2357, 0.4714, 0.8499],
    [-0.6135, 0.1931, 0.7657],
    [0.5477, -0.7303, 0.4083],
    [-0.3849, -0.4967, -0.7779],
    [0.8729, 0.2182, -0.4364],
    [-0.1543, 0.9258, -0.3450],
    [0.7053, -0.3188, -0.6332],
];
/// Hits that are steeper than this (cosine) are doubtful: the ray may only touch the surface.
const STEEP: f64 = 1e-3;
/// Below this part of the diagonal, the nearest point of the surface is asked first …
const NEAR: f64 = 1e-4;
/// … and its normal decides if the point lies along it (cosine), which it does not next to sharp edges.
const ALONG: f64 = 0.999;

impl SurfaceQuery<'_> {
    /// Is the point inside the closed surface? None if it is not finite, or if the surface is open and its volume does not know.
    ///
    /// The normal at the nearest point decides for points close to smooth parts of the surface. Elsewhere, a ray from the point leaves the solid first if the point is inside, and enters it first if not. In the list of all its
    /// hits, entering and leaving take turns, and the last one leaves: if it is not so, or a hit is nearly tangential, another
    /// ray is asked. If all rays are doubtful, the normal at the nearest point decides.
    pub fn is_inside(&self, p: &Point3) -> Option<bool> {
        if !p.sum().is_finite() {
            return None;
        }
        if !self.closed {
            return self.surface.volume().and_then(|volume| volume.is_inside(*p));
        }
        if !self.bounds.contains(p) {
            return Some(false);
        }
        if let Some(nearest) = self.nearest_within(p, NEAR * self.bounds.diagonal()) {
            let normal = self.surface.sample(nearest.patch, nearest.uv).normal;
            let height = (p - nearest.point).dot(&normal);
            if height.abs() > ALONG * nearest.distance {
                return Some(height < 0.0);
            }
        }
        let by_ray = DIRECTIONS.iter().find_map(|direction| {
            let ray = Ray { origin: *p, direction: Vec3::from(*direction) };
            verdict(&self.hits(&ray), &ray.direction.normalize())
        });
        by_ray.or_else(|| {
            let nearest = self.nearest(p)?;
            let normal = self.surface.sample(nearest.patch, nearest.uv).normal;
            Some((p - nearest.point).dot(&normal) < 0.0)
        })
    }
}

/// What the hits of a ray say about its origin; none if they are doubtful.
fn verdict(hits: &[RayHit], direction: &Vec3) -> Option<bool> {
    let cosines = || hits.iter().map(|hit| hit.normal.dot(direction));
    let turns = cosines().zip(cosines().skip(1)).all(|(a, b)| (a > 0.0) != (b > 0.0));
    let steep = cosines().any(|cosine| cosine.is_nan() || cosine.abs() <= STEEP);
    let leaves_last = hits.last().is_none_or(|hit| hit.normal.dot(direction) > 0.0);
    (turns && !steep && leaves_last).then(|| hits.first().is_some_and(|hit| hit.normal.dot(direction) > 0.0))
}
