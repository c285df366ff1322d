//! Many points of a patch at once: the factors of the coefficients are tabulated for fixed parameters, and points are
//! computed in vector lanes.

mod edge;
mod face;

pub use edge::{EdgeCells, EdgeTable};
pub use face::{FaceCells, FaceTable};

use super::lanes::{LANES, Lane};
use super::shoot::Shot;
use crate::geom::{PointsMut, Vec3};

/// Where results go: slices of one length for points, and for normals if they are wanted.
#[derive(Debug)]
pub struct GridOut<'a> {
    /// Positions.
    pub points: PointsMut<'a>,
    /// Unit normals, outward.
    pub normals: Option<PointsMut<'a>>,
}

#[inline(always)]
fn copy(out: &mut PointsMut<'_>, at: usize, used: usize, from: &[Lane; 3]) {
    for (out, from) in [&mut *out.x, &mut *out.y, &mut *out.z].into_iter().zip(from) {
        // A copy of fixed length is an instruction, one of any length a call.
        match out[at..].first_chunk_mut::<LANES>() {
            Some(out) if used == LANES => *out = from.0,
            _ => out[at..at + used].copy_from_slice(&from.0[..used]),
        }
    }
}

impl GridOut<'_> {
    /// The first `used` of a lane.
    #[inline(always)]
    pub(super) fn put<const NORMALS: bool>(
        &mut self,
        at: usize,
        used: usize,
        points: &[Lane; 3],
        normals: &[Lane; 3],
    ) {
        copy(&mut self.points, at, used, points);
        if NORMALS && let Some(out) = &mut self.normals {
            copy(out, at, used, normals);
        }
    }

    /// One point and its normal.
    pub fn set(&mut self, at: usize, point: Vec3, normal: Vec3) {
        let set = |out: &mut PointsMut<'_>, v: Vec3| (out.x[at], out.y[at], out.z[at]) = (v.x, v.y, v.z);
        set(&mut self.points, point);
        if let Some(out) = &mut self.normals {
            set(out, normal);
        }
    }

    /// Asks for the points among the first `count` that the lanes have left NaN; they stay so if there is none.
    pub fn complete(&mut self, count: usize, shoot: impl Fn(usize) -> Option<Shot>) {
        let missing = |x: &[f64], at: usize| (at..count).find(|i| x[*i].is_nan());
        let mut next = missing(self.points.x, 0);
        while let Some(at) = next {
            let nan = Vec3::repeat(f64::NAN);
            let (point, normal) = shoot(at).map_or((nan, nan), |s| (s.point, s.gradient.normalize()));
            self.set(at, point, normal);
            next = missing(self.points.x, at + 1);
        }
    }
}
