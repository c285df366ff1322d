//! Patches that fold over.

use super::build::{BuildOptions, flat_normal, patches};
use super::frame::{Frame, FrameError};
use super::patch::RationalPatch;
use super::surface::RationalSurface;
use crate::bernstein::triangle;
use crate::geom::{Point3, Vec3};
use crate::surface::PatchId;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A patch whose normal comes closer to a right angle than this cosine on a coarse lattice is looked at on one with [`FINE`] intervals:
/// folds are small at first.
const STEEP: f64 = 0.3;
const FINE: usize = 60;

/// Is a patch folded? Then its normal somewhere on the lattice with `lattice` intervals, or on a fine one if it is steep there, is at a right
/// angle or more to the normals of its corners, blended by barycentric coordinates; a corner without a normal has that of the triangle.
pub fn is_folded(
    patch: &RationalPatch,
    normals: &[Option<Vec3>; 3],
    flat: &Vec3,
    lattice: &[[f64; 3]],
) -> bool {
    turns_beyond(patch, normals, flat, lattice, 0.0)
}

/// Is the cosine between these normals nowhere above `limit`?
fn turns_beyond(
    patch: &RationalPatch,
    normals: &[Option<Vec3>; 3],
    flat: &Vec3,
    lattice: &[[f64; 3]],
    limit: f64,
) -> bool {
    let [n0, n1, n2] = normals.map(|n| n.and_then(|n| n.try_normalize(0.0)).unwrap_or(*flat));
    let cosine = |l: &[f64; 3]| {
        let t = patch.evaluate([l[0], l[1]]);
        let (normal, wanted) = (t.du.cross(&t.dv), l[0] * n0 + l[1] * n1 + l[2] * n2);
        let is_tip = (0..3).any(|c| l[c] == 1.0 && patch.is_singular(c));
        if is_tip { 1.0 } else { normal.dot(&wanted) / (normal.norm() * wanted.norm()) }
    };
    // Not a number counts as folded.
    let all_above = |lattice: &[[f64; 3]], limit: f64| lattice.iter().all(|l| cosine(l) > limit);
    !all_above(lattice, STEEP) && !(all_above(lattice, limit) && all_above(&triangle::lattice(FINE), limit))
}

/// The same for a patch of a surface.
pub fn is_folded_over(surface: &RationalSurface, patch: PatchId, lattice: &[[f64; 3]]) -> bool {
    let frame = surface.frame();
    let flat = flat_normal(&frame.corners(patch.0));
    is_folded(surface.patch(patch), &frame.normals[patch.index()], &flat, lattice)
}

/// The triangles over which [`super::build`] would make patches that fold, or are close to it, in order.
pub fn folded_faces(frame: &Frame, lattice: usize) -> Result<Vec<u32>, FrameError> {
    let lattice = triangle::lattice(lattice.max(1));
    let made = patches(frame, &BuildOptions::default())?.patches;
    let folded = (0..frame.faces.len() as u32).into_par_iter().filter(|f| {
        let (patch, normals, corners) = (&made[*f as usize], &frame.normals[*f as usize], frame.corners(*f));
        let flat = flat_normal(&corners);
        turns_beyond(patch, normals, &flat, &lattice, CLOSE) || is_pinched(patch, &corners)
    });
    Ok(folded.collect())
}

/// Patches that come closer to a right angle than this cosine (1°) are close to a fold.
const CLOSE: f64 = 0.02;
/// Two wires that leave a corner with a smaller sine of their angle, in that of the triangle, leave it all but in one line: they have no plane.
const PINCHED: f64 = 0.02;

fn is_pinched(patch: &RationalPatch, corners: &[Point3; 3]) -> bool {
    let sine = |a: Vec3, b: Vec3| a.cross(&b).norm() / (a.norm() * b.norm());
    let at = |c: usize| {
        let (after, before) = (patch.wire(c), patch.wire((c + 2) % 3));
        let of_wires = sine(after[1] - after[0], before[2] - before[3]);
        of_wires < PINCHED * sine(corners[(c + 1) % 3] - corners[c], corners[(c + 2) % 3] - corners[c])
    };
    (0..3).any(|c| !patch.is_singular(c) && at(c))
}

/// Most rounds in which normals are given up.
const ROUNDS: usize = 6;

/// Takes normals away from vertices at which patches fold, until none does or no normal is left at those that do: of the two ends of an edge
/// whose normals are all but opposite both, else that which sees its triangle worst. Triangles that fold without any normal lose the tangent
/// planes along their edges as well. At vertices without a normal the patches meet in a point without a tangent
/// plane, as at a singular vertex; along edges they stay G1. Vertices at which a normal was taken, in order.
///
/// # Errors
/// [`FrameError`] for a frame that does not fit together.
pub fn relax_folds(
    frame: &mut Frame,
    options: &BuildOptions<'_>,
    lattice: usize,
) -> Result<Vec<u32>, FrameError> {
    let lattice = triangle::lattice(lattice.max(1));
    let mut relaxed = BTreeSet::new();
    for _ in 0..ROUNDS {
        let made = patches(frame, options)?.patches;
        let folded = |f: &u32| {
            let flat = flat_normal(&frame.corners(*f));
            is_folded(&made[*f as usize], &frame.normals[*f as usize], &flat, &lattice)
        };
        let folded: Vec<u32> = (0..frame.faces.len() as u32).into_par_iter().filter(folded).collect();
        if folded.is_empty() {
            break;
        }
        // Without a normal at any corner, only tangent planes along the edges can be the cause.
        let bare: BTreeSet<u32> =
            folded.iter().copied().filter(|f| frame.normals[*f as usize] == [None; 3]).collect();
        for seam in &mut frame.seams {
            let mut faces = std::iter::once(seam.first).chain(seam.second).map(|(face, _)| face);
            seam.smooth &= !faces.any(|f| bare.contains(&f));
        }
        let given_up: BTreeSet<u32> = folded.into_iter().flat_map(|f| vertices_to_relax(frame, f)).collect();
        for (face, normals) in frame.faces.iter().zip(&mut frame.normals) {
            (0..3).filter(|c| given_up.contains(&face[*c])).for_each(|c| normals[c] = None);
        }
        relaxed.extend(given_up);
    }
    Ok(relaxed.into_iter().collect())
}

/// Normals with a smaller product turn back on each other.
const TURNS_BACK: f64 = 0.0;

fn vertices_to_relax(frame: &Frame, face: u32) -> Vec<u32> {
    let (corners, normals) = (frame.faces[face as usize], frame.normals[face as usize]);
    let flat = flat_normal(&frame.corners(face));
    let unit = normals.map(|n| n.and_then(|n| n.try_normalize(0.0)));
    let turns_back = |c: usize| {
        let with = |d: usize| matches!((unit[c], unit[d]), (Some(n), Some(m)) if n.dot(&m) < TURNS_BACK);
        with((c + 1) % 3) || with((c + 2) % 3)
    };
    let back: Vec<u32> = (0..3).filter(|c| turns_back(*c)).map(|c| corners[c]).collect();
    if !back.is_empty() {
        return back;
    }
    let sees = |c: &usize| unit[*c].map_or(f64::INFINITY, |n| n.dot(&flat));
    let worst = (0..3).min_by(|a, b| sees(a).total_cmp(&sees(b))).filter(|c| unit[*c].is_some());
    worst.map(|c| corners[c]).into_iter().collect()
}
