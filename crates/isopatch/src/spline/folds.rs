//! Patches that fold over.

use super::surface::{DEGREE, TriangularSpline};
use crate::bernstein::lanes::{TangentsMut, TriangleGrid};
use crate::bernstein::triangle;
use crate::geom::{Points, Vec3};
use crate::mesh::FaceId;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Largest angle between the normal of each patch and those of its corners, blended by barycentric coordinates: over samples
/// on the barycentric lattice with `lattice` intervals, in radians. π where a normal vanishes or is not a number.
///
/// A patch for which it is π/2 or more is folded.
pub fn normal_deviations(spline: &TriangularSpline, lattice: usize) -> Vec<f64> {
    let samples = triangle::lattice(lattice.max(1));
    let grid = TriangleGrid::new(DEGREE, &samples);
    let base = &spline.base;
    let room = || [(); 3].map(|()| Points::zeros(grid.len()));
    spline
        .nets
        .par_iter()
        .enumerate()
        .with_min_len(8)
        .map_init(room, |[points, du, dv], (f, net)| {
            let n = base.mesh.triangle(FaceId::from(f)).map(|v| base.normals[v.index()]);
            let offsets = net.map(|p| p - net[0]);
            let derivatives = Some([du.view_mut(), dv.view_mut()]);
            grid.evaluate(&offsets, TangentsMut { points: points.view_mut(), derivatives, normals: None });
            let mut widest = Widest::default();
            for (i, uvw) in samples.iter().enumerate() {
                let blended: Vec3 = (0..3).map(|c| uvw[c] * n[c]).sum();
                let normal = du.get(i).cross(&dv.get(i));
                if !(normal.norm_squared() > 0.0 && normal.norm_squared().is_finite()) {
                    return PI;
                }
                widest.see(normal.cross(&blended).norm(), normal.dot(&blended));
            }
            widest.angle()
        })
        .collect()
}

/// The largest of some angles between 0 and π that are given by multiples of their sines and cosines: one arctangent does for all.
struct Widest {
    /// As given, and of length 1, lest products vanish.
    sine: f64,
    cosine: f64,
    unit: [f64; 2],
}

impl Default for Widest {
    fn default() -> Self {
        Self { sine: 0.0, cosine: 1.0, unit: [0.0, 1.0] }
    }
}

impl Widest {
    fn see(&mut self, sine: f64, cosine: f64) {
        // The sine of the difference; it does not tell π from 0.
        let is_straight = sine == 0.0 && cosine < 0.0;
        if is_straight || sine * self.unit[1] - cosine * self.unit[0] > 0.0 {
            let length = sine.hypot(cosine);
            *self = Self { sine, cosine, unit: [sine / length, cosine / length] };
        }
    }

    fn angle(&self) -> f64 {
        self.sine.atan2(self.cosine)
    }
}
