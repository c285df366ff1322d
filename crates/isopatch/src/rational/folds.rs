//! Patches that fold over.

use super::build::{BuildOptions, patches};
use super::frame::{Frame, FrameError};
use super::patch::RationalPatch;
use crate::bernstein::triangle;
use crate::geom::Vec3;
use rayon::prelude::*;

/// Is a patch folded? Then its normal somewhere on the lattice with `lattice` intervals is at a right angle or more to the normals of its
/// corners, blended by barycentric coordinates; a corner without a normal has that of the triangle.
pub fn is_folded(
    patch: &RationalPatch,
    normals: &[Option<Vec3>; 3],
    flat: &Vec3,
    lattice: &[[f64; 3]],
) -> bool {
    let [n0, n1, n2] = normals.map(|n| n.and_then(|n| n.try_normalize(0.0)).unwrap_or(*flat));
    lattice.iter().any(|l| {
        let t = patch.evaluate([l[0], l[1]]);
        let normal = t.du.cross(&t.dv);
        let is_tip = (0..3).any(|c| l[c] == 1.0 && patch.is_singular(c));
        // Not a number counts as folded.
        let faces_out = normal.dot(&(l[0] * n0 + l[1] * n1 + l[2] * n2)) > 0.0;
        !is_tip && !faces_out
    })
}

/// The triangles over which [`super::build`] would make folded patches, in order.
pub fn folded_faces(frame: &Frame, lattice: usize) -> Result<Vec<u32>, FrameError> {
    let lattice = triangle::lattice(lattice.max(1));
    let made = patches(frame, &BuildOptions::default())?.patches;
    let folded = (0..frame.faces.len() as u32).into_par_iter().filter(|f| {
        let [a, b, c] = frame.corners(*f);
        let flat = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        is_folded(&made[*f as usize], &frame.normals[*f as usize], &flat, &lattice)
    });
    Ok(folded.collect())
}
