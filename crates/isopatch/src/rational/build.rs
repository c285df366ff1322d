//! From a frame to a surface.

use super::across::correction;
use super::frame::{Frame, FrameError, FrameSeam};
use super::patch::RationalPatch;
use super::surface::RationalSurface;
use crate::geom::{Point3, Vec3};
use crate::network::wire::{Wire, WireEnd, across, end_tangent, is_orthogonal, reversed, wire};
use crate::network::wire_fit::fitted;
use crate::parallel::Evenly;
use crate::surface::Target;
use rayon::prelude::*;

/// A surface, and what the construction says about it.
#[derive(Clone, Debug)]
pub struct Built {
    /// The surface: patch i over triangle i.
    pub surface: RationalSurface,
    /// Corners (triangle, corner) that have a normal which the patch can't take: on a wire there meet three or more tangent
    /// planes that have no line in common. The patch has no tangent plane there, as at a corner without a normal.
    pub lost_normals: Vec<(u32, u8)>,
}

/// The G1 surface over a frame: wires with [`wire`], patches with [`correction`].
///
/// Linear time. Seams that are smooth are G1 to rounding, apart from vertices without a normal; all seams are without a gap.
///
/// # Errors
/// [`FrameError`] for a frame that does not fit together.
pub fn build(frame: &Frame) -> Result<Built, FrameError> {
    build_with(frame, &BuildOptions::default())
}

/// What [`build_with`] is given besides the frame.
#[derive(Clone, Copy, Default)]
pub struct BuildOptions<'a> {
    /// For each wire by its number: the normal of a plane that it lies in with both ends, such as a side of a box that cuts the surface; no
    /// entry for none. Default: no planes.
    pub planes: &'a [Option<Vec3>],
    /// What wires come close to, by the lengths of their tangents. None for wires that depend on the frame alone, the default.
    pub target: Option<&'a dyn Target>,
}

/// The same with options.
pub fn build_with(frame: &Frame, options: &BuildOptions<'_>) -> Result<Built, FrameError> {
    let Patches { wires, patches, lost_normals } = patches(frame, options)?;
    Ok(Built { surface: RationalSurface::new(frame.clone(), wires, patches), lost_normals })
}

/// The patches alone, and what they are made over.
pub(super) struct Patches {
    wires: Vec<WireOf>,
    pub patches: Vec<RationalPatch>,
    lost_normals: Vec<(u32, u8)>,
}

pub(super) fn patches(frame: &Frame, options: &BuildOptions<'_>) -> Result<Patches, FrameError> {
    frame.check()?;
    let wires = wires(frame, options);
    let uses = edge_uses(frame);
    let regular = regular_corners(frame, &wires, &uses);
    let flat: Vec<Vec3> = (0..frame.faces.len() as u32).map(|f| flat_normal(&frame.corners(f))).collect();
    let across: Vec<Across> =
        frame.seams.par_iter().evenly().map(|seam| seam_across(frame, seam, &wires, &flat)).collect();
    let patches: Vec<RationalPatch> = (0..frame.faces.len())
        .into_par_iter()
        .evenly()
        .map(|f| {
            let wires = uses[f].map(|of| of.wire(frame, &wires));
            let mut patch = RationalPatch::over_wires(&wires);
            let cover = patch.clone();
            for (k, of) in uses[f].iter().enumerate() {
                let seam = &frame.seams[of.seam];
                let regular = [regular[f][k], regular[f][(k + 1) % 3]];
                // Along a seam that is not smooth nothing is asked; where it can be had at no cost, the patch follows its normals.
                if seam.smooth || regular == [true, true] {
                    let b = across[of.seam].of_side(of.is_second);
                    patch.across[k] = correction(&cover, k, &b, regular);
                }
            }
            patch
        })
        .collect();
    let corners = (0..frame.faces.len() as u32).flat_map(|f| [0, 1, 2].map(|c| (f, c)));
    let is_lost = |(f, c): &(u32, u8)| {
        let (f, c) = (*f as usize, usize::from(*c));
        frame.normals[f][c].is_some() && !regular[f][c]
    };
    let lost_normals = corners.filter(is_lost).collect();
    Ok(Patches { wires, patches, lost_normals })
}

/// The seam of an edge of a triangle.
#[derive(Clone, Copy)]
pub(super) struct EdgeUse {
    seam: usize,
    is_second: bool,
    side: (u32, u8),
}

impl EdgeUse {
    /// The wire in the direction of the edge.
    pub fn wire(&self, frame: &Frame, wires: &[WireOf]) -> Wire {
        let WireOf { start, wire } = &wires[frame.seams[self.seam].wire as usize];
        if frame.ends(self.side)[0] == *start { *wire } else { reversed(wire) }
    }
}

/// A wire and the vertex where it starts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WireOf {
    pub start: u32,
    pub wire: Wire,
}

pub(super) fn edge_uses(frame: &Frame) -> Vec<[EdgeUse; 3]> {
    let none = EdgeUse { seam: 0, is_second: false, side: (0, 0) };
    let mut uses = vec![[none; 3]; frame.faces.len()];
    for (s, seam) in frame.seams.iter().enumerate() {
        for (is_second, side) in [(false, Some(seam.first)), (true, seam.second)] {
            if let Some((face, edge)) = side {
                uses[face as usize][usize::from(edge)] = EdgeUse { seam: s, is_second, side: (face, edge) };
            }
        }
    }
    uses
}

/// The ends of a wire, and the normals that the triangles along it have there.
type Gathered = ([u32; 2], [Vec<Vec3>; 2]);

/// The wires, each from all normals that the triangles along it have at its ends.
fn wires(frame: &Frame, options: &BuildOptions<'_>) -> Vec<WireOf> {
    let count = frame.wire_count();
    let mut normals: Vec<Option<Gathered>> = vec![None; count];
    for seam in &frame.seams {
        for side in std::iter::once(seam.first).chain(seam.second) {
            let (ends, of_side) = (frame.ends(side), frame.end_normals(side));
            let (start, gathered) =
                normals[seam.wire as usize].get_or_insert_with(|| (ends, Default::default()));
            for end in 0..2 {
                let place = usize::from(ends[end] != start[0]);
                gathered[place].extend(of_side[end]);
            }
        }
    }
    for (plane, gathered) in options.planes.iter().zip(&mut normals) {
        if let (Some(plane), Some((_, gathered))) = (plane, gathered) {
            // The wire leaves along the line in which the plane meets the tangent plane; a free end stays free.
            gathered.iter_mut().filter(|n| !n.is_empty()).for_each(|n| n.push(*plane));
        }
    }
    let made = |gathered: Option<Gathered>| {
        let ([start, end], normals) = gathered.unwrap_or_default();
        let p = [start, end].map(|v| frame.positions.get(v as usize).copied().unwrap_or_default());
        let chord = p[1] - p[0];
        let ends = normals.map(|n| wire_end(&n, &chord));
        (WireOf { start, wire: wire(p, ends) }, ends)
    };
    let mut made: Vec<(WireOf, [WireEnd; 2])> = normals.into_par_iter().evenly().map(made).collect();
    if let Some(target) = options.target {
        // Where more than two triangles meet, sheets cross: what is closer to one of them is farther from the others. A wire
        // without any tangent plane stays straight.
        let mut sides = vec![0; count];
        for seam in &frame.seams {
            sides[seam.wire as usize] += 1 + usize::from(seam.second.is_some());
        }
        made.par_iter_mut()
            .evenly()
            .enumerate()
            .filter(|(w, (_, ends))| sides[*w] <= 2 && *ends != [WireEnd::Free; 2])
            .for_each(|(w, (of, ends))| {
                of.wire = fitted(&of.wire, ends, options.planes.get(w).copied().flatten(), target);
            });
    }
    made.into_iter().map(|(of, _)| of).collect()
}

/// Normals with a smaller sine between them are the same.
const SAME: f64 = 1e-6;
/// A line that is so far off the chord (its cosine) is no tangent for the wire.
const ASKANCE: f64 = 0.25;

/// What a wire keeps at an end where the triangles along it have these normals.
fn wire_end(normals: &[Vec3], chord: &Vec3) -> WireEnd {
    let Some(first) = normals.first() else { return WireEnd::Free };
    let sine = |n: &Vec3| first.cross(n).norm() / (first.norm() * n.norm());
    let widest = normals.iter().max_by(|a, b| sine(a).total_cmp(&sine(b))).filter(|n| sine(n) > SAME);
    let Some(other) = widest else { return WireEnd::Plane(*first) };
    let line = first.cross(other).normalize();
    let is_common = normals.iter().all(|n| is_orthogonal(n, &line));
    if is_common && line.dot(chord).abs() > ASKANCE * chord.norm() {
        WireEnd::Line(line)
    } else {
        WireEnd::Free
    }
}

/// Corners at which the patch has the tangent plane that its normal asks for: both wires are in it.
fn regular_corners(frame: &Frame, wires: &[WireOf], uses: &[[EdgeUse; 3]]) -> Vec<[bool; 3]> {
    let is_regular = |f: usize, c: usize| {
        let after = end_tangent(&uses[f][c].wire(frame, wires), 0);
        let before = end_tangent(&uses[f][(c + 2) % 3].wire(frame, wires), 1);
        frame.normals[f][c].is_some_and(|n| is_orthogonal(&n, &after) && is_orthogonal(&n, &before))
    };
    (0..frame.faces.len()).into_par_iter().evenly().map(|f| [0, 1, 2].map(|c| is_regular(f, c))).collect()
}

pub(super) fn flat_normal([a, b, c]: &[Point3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

/// The directions across a seam, for both of its sides, each in the direction of its edge and into its patch.
struct Across([[Vec3; 3]; 2]);

impl Across {
    fn of_side(&self, is_second: bool) -> [Vec3; 3] {
        self.0[usize::from(is_second)]
    }
}

fn seam_across(frame: &Frame, seam: &FrameSeam, wires: &[WireOf], flat: &[Vec3]) -> Across {
    let of = |side: (u32, u8), between: &Vec3| {
        let use_of_side = EdgeUse { seam: 0, is_second: false, side };
        let WireOf { start, wire } = &wires[seam.wire as usize];
        let along = if frame.ends(use_of_side.side)[0] == *start { *wire } else { reversed(wire) };
        across(&along, frame.end_normals(side), between)
    };
    let flat_of = |(face, _): (u32, u8)| flat[face as usize];
    match seam.second {
        Some(second) if seam.smooth => {
            let b = of(seam.first, &(flat_of(seam.first) + flat_of(second)));
            Across([b, [-b[2], -b[1], -b[0]]])
        }
        Some(second) => Across([of(seam.first, &flat_of(seam.first)), of(second, &flat_of(second))]),
        None => {
            let b = of(seam.first, &flat_of(seam.first));
            Across([b, b])
        }
    }
}
