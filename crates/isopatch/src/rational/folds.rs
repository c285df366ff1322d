//! Patches that fold over.

use super::build::{BuildOptions, flat_normal, patches};
use super::frame::{Frame, FrameError};
use super::patch::RationalPatch;
use super::surface::RationalSurface;
use crate::bernstein::triangle;
use crate::geom::{Point3, Vec3};
use crate::parallel::Evenly;
use crate::surface::PatchId;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A patch whose normal comes closer to a right angle than this cosine on a coarse lattice, or whose area is smaller than this part of that of
/// the triangle somewhere, is looked at on one with [`FINE`] intervals: folds are small at first.
const STEEP: f64 = 0.3;
const FINE: usize = 40;

/// Is a patch folded? Then its normal somewhere on the lattice with `lattice` intervals, or on a fine one if it is steep there, is at a right
/// angle or more to the normals of its corners, blended by barycentric coordinates; a corner without a normal has that of the triangle.
pub fn is_folded(
    patch: &RationalPatch,
    normals: &[Option<Vec3>; 3],
    flat: &Vec3,
    lattice: &[[f64; 3]],
) -> bool {
    let normals = all_normals(normals, flat);
    turns_beyond(patch, &normals, lattice, 0.0)
}

/// The same for a patch of a surface.
pub fn is_folded_over(surface: &RationalSurface, patch: PatchId, lattice: &[[f64; 3]]) -> bool {
    let frame = surface.frame();
    let flat = flat_normal(&frame.corners(patch.0));
    is_folded(surface.patch(patch), &frame.normals[patch.index()], &flat, lattice)
}

fn all_normals(normals: &[Option<Vec3>; 3], flat: &Vec3) -> [Vec3; 3] {
    normals.map(|n| n.and_then(|n| n.try_normalize(0.0)).unwrap_or(*flat))
}

/// Is the least cosine at or below `limit`?
fn turns_beyond(patch: &RationalPatch, normals: &[Vec3; 3], lattice: &[[f64; 3]], limit: f64) -> bool {
    let coarse = least(patch, normals, lattice);
    let is_steep = coarse.cosine.min(coarse.area) <= STEEP;
    coarse.cosine <= limit || is_steep && least(patch, normals, &triangle::lattice(FINE)).cosine <= limit
}

/// The least values on a lattice.
#[derive(Clone, Copy)]
struct Least {
    /// Of the cosine of the angle between the normal of a patch and the blended ones.
    cosine: f64,
    /// Of the element of area, in that of the triangle; negative where the patch faces the other way.
    area: f64,
}

fn least(patch: &RationalPatch, [n0, n1, n2]: &[Vec3; 3], lattice: &[[f64; 3]]) -> Least {
    let [a, b, c] = [0, 1, 2].map(|k| patch.wire(k)[0]);
    let of_triangle = (b - a).cross(&(c - a)).norm();
    let at = |l: &[f64; 3]| {
        let t = patch.evaluate([l[0], l[1]]);
        let (normal, wanted) = (t.du.cross(&t.dv), l[0] * n0 + l[1] * n1 + l[2] * n2);
        let (length, seen) = (normal.norm(), normal.dot(&wanted) / wanted.norm());
        let is_tip = (0..3).any(|c| l[c] == 1.0 && patch.is_singular(c));
        let found = Least { cosine: seen / length, area: seen.signum() * length / of_triangle };
        match found {
            _ if is_tip => Least { cosine: 1.0, area: 1.0 },
            // As bad as can be.
            _ if found.cosine.is_nan() => Least { cosine: -1.0, area: -1.0 },
            _ => found,
        }
    };
    let smaller = |x: Least, y: Least| Least { cosine: x.cosine.min(y.cosine), area: x.area.min(y.area) };
    lattice.iter().map(at).fold(Least { cosine: 1.0, area: 1.0 }, smaller)
}

/// What becomes of the patches that fold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Folds {
    /// Patches that do not fold with this middle, [`RationalPatch::middle`].
    pub middles: Vec<(PatchId, Vec3)>,
    /// Triangles whose patches fold with any that was tried, or have no tangent plane to speak of at a corner, in order.
    pub faces: Vec<u32>,
}

/// The patches of [`super::build`] that fold, or are close to it.
///
/// # Errors
/// [`FrameError`] for a frame that does not fit together.
pub fn folds(frame: &Frame, lattice: usize) -> Result<Folds, FrameError> {
    let lattice = triangle::lattice(lattice.max(1));
    let made = patches(frame, &BuildOptions::default())?.patches;
    let of_face = |f: u32| {
        let (patch, corners) = (&made[f as usize], frame.corners(f));
        let normals = all_normals(&frame.normals[f as usize], &flat_normal(&corners));
        if is_pinched(patch, &corners) {
            return Some((f, None));
        }
        let is_close = turns_beyond(patch, &normals, &lattice, CLOSE);
        is_close.then(|| (f, middle_without_fold(patch, &normals)))
    };
    let found: Vec<(u32, Option<Vec3>)> =
        (0..made.len() as u32).into_par_iter().evenly().filter_map(of_face).collect();
    let mut folds = Folds::default();
    for (f, middle) in found {
        match middle {
            Some(middle) => folds.middles.push((PatchId(f), middle)),
            None => folds.faces.push(f),
        }
    }
    Ok(folds)
}

/// Intervals of the lattice on which middles are compared.
const COMPARED: usize = 24;
/// First step of the search for a middle, in the longest edge, how often it is tried in all directions, and its farthest way.
const STEP: f64 = 0.1;
const TRIES: usize = 12;
const FARTHEST: f64 = 0.4;

/// A middle with which a patch does not come close to a fold: a search along the axes, in ever smaller steps. None if there is none, as where
/// the fold is at the border.
fn middle_without_fold(patch: &RationalPatch, normals: &[Vec3; 3]) -> Option<Vec3> {
    let lattice = triangle::lattice(COMPARED);
    let with = |middle: Vec3| RationalPatch { middle, ..patch.clone() };
    let on_border: Vec<[f64; 3]> = lattice.iter().copied().filter(|l| l.contains(&0.0)).collect();
    if least(patch, normals, &on_border).cosine <= CLOSE {
        return None;
    }
    let longest = (0..3).map(|k| patch.wire(k)).map(|w| (w[3] - w[0]).norm()).fold(0.0, f64::max);
    let mut step = STEP * longest;
    let mut best = (least(patch, normals, &lattice).cosine, patch.middle);
    for _ in 0..TRIES {
        let around = (0..3).flat_map(|axis| [step, -step].map(|step| best.1 + step * Vec3::ith(axis, 1.0)));
        let near = around.filter(|middle| (middle - patch.middle).norm() <= FARTHEST * longest);
        let tried = near.map(|middle| (least(&with(middle), normals, &lattice).cosine, middle));
        match tried.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|tried| tried.0 > best.0) {
            Some(better) => best = better,
            None => step *= 0.5,
        }
        if best.0 > CLOSE && !turns_beyond(&with(best.1), normals, &lattice, CLOSE) {
            return Some(best.1);
        }
    }
    None
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
        let folded: Vec<u32> =
            (0..frame.faces.len() as u32).into_par_iter().evenly().filter(folded).collect();
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::rational::FrameSeam;

    /// One triangle in the plane z = 0 with normals at its corners.
    fn frame(normals: [Vec3; 3]) -> Frame {
        let alone = |k: u8| FrameSeam { first: (0, k), second: None, smooth: false, wire: k.into() };
        Frame {
            positions: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            faces: vec![[0, 1, 2]],
            normals: vec![normals.map(Some)],
            seams: [0, 1, 2].map(alone).to_vec(),
        }
    }

    #[test]
    fn a_fold_between_the_points_of_a_lattice_is_seen() {
        let mut patch = patches(&frame([Vec3::z(); 3]), &BuildOptions::default()).unwrap().patches.remove(0);
        let normals = [Vec3::z(); 3];
        let [coarse, fine] = [8, FINE].map(triangle::lattice);
        // The centroid moves in the plane until the patch begins to fold.
        while least(&patch, &normals, &fine).cosine > 0.0 {
            patch.middle.x += 0.003;
        }
        assert!(least(&patch, &normals, &coarse).cosine > 0.0);
        assert!(is_folded(&patch, &[None; 3], &Vec3::z(), &coarse));
    }

    #[test]
    fn a_middle_takes_a_fold_out() {
        let normals = [Vec3::new(0.2, 0.1, 1.0), Vec3::new(-0.1, 0.3, 1.0), Vec3::new(0.0, -0.2, 1.0)];
        let mut patch = patches(&frame(normals), &BuildOptions::default()).unwrap().patches.remove(0);
        let lattice = triangle::lattice(8);
        assert!(!is_folded(&patch, &normals.map(Some), &Vec3::z(), &lattice));
        patch.middle = Vec3::new(0.3, 0.3, 0.0);
        assert!(is_folded(&patch, &normals.map(Some), &Vec3::z(), &lattice));
        let normals = normals.map(|n| n.normalize());
        patch.middle = middle_without_fold(&patch, &normals).unwrap();
        assert!(!turns_beyond(&patch, &normals, &lattice, CLOSE));
    }

    #[test]
    fn wires_that_leave_a_corner_in_one_line_are_a_fold() {
        // Both edges at the origin are seen along the same line by a normal in the plane of the triangle.
        let tilted = Vec3::new(1.0, -1.0, 1e-3);
        let folds = folds(&frame([tilted, Vec3::z(), Vec3::z()]), 8).unwrap();
        assert_eq!((folds.faces, folds.middles), (vec![0], vec![]));
    }
}
