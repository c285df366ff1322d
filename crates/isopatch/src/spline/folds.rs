//! Patches that fold over.

use super::surface::{DEGREE, TriangularSpline};
use crate::bernstein::lanes::{TangentsMut, TriangleGrid};
use crate::bernstein::triangle;
use crate::geom::{Points, Vec3, Widest};
use crate::mesh::FaceId;
use crate::parallel::Evenly;
use rayon::prelude::*;

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
        .evenly()
        .map_init(room, |[points, du, dv], (f, net)| {
            let n = base.mesh.triangle(FaceId::from(f)).map(|v| base.normals[v.index()]);
            let offsets = net.map(|p| p - net[0]);
            let derivatives = Some([du.view_mut(), dv.view_mut()]);
            grid.evaluate(&offsets, TangentsMut { points: points.view_mut(), derivatives, normals: None });
            let mut widest = Widest::default();
            for (i, uvw) in samples.iter().enumerate() {
                let blended: Vec3 = (0..3).map(|c| uvw[c] * n[c]).sum();
                widest.add(du.get(i).cross(&dv.get(i)), blended);
            }
            widest.angle()
        })
        .collect()
}
