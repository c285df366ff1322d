//! Patches that fold over.

use super::surface::{DEGREE, TriangularSpline};
use crate::bernstein::lanes::{TangentsMut, TriangleGrid};
use crate::bernstein::triangle;
use crate::geom::{Points, Vec3, angle_between};
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
            let deviation = |(i, uvw): (usize, &[f64; 3])| {
                let blended: Vec3 = (0..3).map(|c| uvw[c] * n[c]).sum();
                let normal = du.get(i).cross(&dv.get(i));
                let usable = normal.norm_squared() > 0.0 && normal.norm_squared().is_finite();
                if usable { angle_between(&normal, &blended) } else { PI }
            };
            samples.iter().enumerate().map(deviation).fold(0.0, f64::max)
        })
        .collect()
}
