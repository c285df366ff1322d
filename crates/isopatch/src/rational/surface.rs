use super::build::{WireOf, edge_uses};
use super::frame::{Frame, FrameError};
use super::patch::{CENTER, RationalPatch};
use super::weighted::{WeightedNet, weighted_net};
use crate::bernstein::curve;
use crate::geom::{Aabb, Point3, Points, Vec3};
use crate::parallel::Evenly;
use crate::surface::{Domain, PatchForm, PatchId, Sample, Seam, Surface, Target};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Rational patches over the triangles of a [`Frame`].
///
/// Patches that meet share the wire between them, to the bit. Sheets that cross share the wires on their common curve, and vertices are
/// shared in any case; [`Surface::curve`] says so.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalSurface {
    frame: Frame,
    wires: Vec<WireOf>,
    patches: Vec<RationalPatch>,
    nets: Vec<WeightedNet>,
    seams: Vec<Seam>,
}

/// All that a [`RationalSurface`] is made of, for files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RationalParts {
    /// Triangles, normals, seams.
    pub frame: Frame,
    /// Vertex where each wire starts.
    pub wire_starts: Vec<u32>,
    /// The two inner Bézier points of each wire.
    pub wires: Vec<[Point3; 2]>,
    /// Middle point of the cubic, corrections, and M of each patch.
    pub patches: Vec<(Point3, [[Vec3; 4]; 3], Vec3)>,
}

impl RationalSurface {
    pub(super) fn new(frame: Frame, wires: Vec<WireOf>, patches: Vec<RationalPatch>) -> Self {
        let seams = frame.seams.iter().map(|seam| {
            let (first, second, continuity) = frame.sides(seam);
            Seam { first, second, continuity }
        });
        let nets = patches.par_iter().evenly().map(weighted_net).collect();
        Self { seams: seams.collect(), frame, wires, patches, nets }
    }

    /// The surface of its parts.
    ///
    /// # Errors
    /// [`FrameError`] if they do not fit together.
    pub fn from_parts(parts: RationalParts) -> Result<Self, FrameError> {
        let RationalParts { frame, wire_starts, wires, patches } = parts;
        frame.check()?;
        let count = frame.wire_count();
        for (given, wanted) in
            [(wire_starts.len(), count), (wires.len(), count), (patches.len(), frame.faces.len())]
        {
            if given != wanted {
                return Err(FrameError::Count { given, wanted });
            }
        }
        let mut whole: Vec<Option<WireOf>> = wires.iter().map(|_| None).collect();
        for seam in &frame.seams {
            let w = seam.wire as usize;
            let [a, b] = frame.ends(seam.first);
            let start = wire_starts[w];
            if start != a && start != b {
                return Err(FrameError::Seam { face: seam.first.0, edge: seam.first.1 });
            }
            let ends = [start, if start == a { b } else { a }].map(|v| frame.positions[v as usize]);
            whole[w] = Some(WireOf { start, wire: [ends[0], wires[w][0], wires[w][1], ends[1]] });
        }
        // Wires are numbered without gaps, so each has a seam.
        let wires: Vec<WireOf> = whole.into_iter().flatten().collect();
        let uses = edge_uses(&frame);
        let patch = |(f, (center, across, middle)): (usize, (Point3, [[Vec3; 4]; 3], Vec3))| {
            let mut patch = RationalPatch::over_wires(&uses[f].map(|of| of.wire(&frame, &wires)));
            patch.net[CENTER] = center;
            RationalPatch { across, middle, ..patch }
        };
        let patches = patches.into_iter().enumerate().map(patch).collect();
        Ok(Self::new(frame, wires, patches))
    }

    /// The parts, from which [`Self::from_parts`] makes the same surface to the bit.
    pub fn parts(&self) -> RationalParts {
        RationalParts {
            frame: self.frame.clone(),
            wire_starts: self.wires.iter().map(|of| of.start).collect(),
            wires: self.wires.iter().map(|of| [of.wire[1], of.wire[2]]).collect(),
            patches: self.patches.iter().map(|p| (p.net[CENTER], p.across, p.middle)).collect(),
        }
    }

    /// What the surface interpolates.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Position of each vertex.
    pub fn positions(&self) -> &[Point3] {
        &self.frame.positions
    }

    /// A patch.
    pub fn patch(&self, patch: PatchId) -> &RationalPatch {
        &self.patches[patch.index()]
    }

    /// The patch in Bézier form with weights.
    pub fn weighted(&self, patch: PatchId) -> &WeightedNet {
        &self.nets[patch.index()]
    }

    /// The curves on which more than two patches meet, as polylines of `intervals` pieces, and the vertices at which a patch has no
    /// tangent plane, as lines of one point.
    pub fn singular_lines(&self, intervals: usize) -> Vec<Vec<Point3>> {
        let mut uses = vec![0; self.wires.len()];
        for seam in &self.frame.seams {
            uses[seam.wire as usize] += 1 + usize::from(seam.second.is_some());
        }
        let crossing = self.wires.iter().zip(uses).filter(|(_, uses)| *uses > 2);
        let along = |of: &WireOf| {
            let share = |i: usize| i as f64 / intervals.max(1) as f64;
            (0..=intervals.max(1)).map(|i| curve::point(&of.wire, share(i))).collect()
        };
        let mut lines: Vec<Vec<Point3>> = crossing.map(|(of, _)| along(of)).collect();
        let corners = (0..self.patches.len()).flat_map(|p| [0, 1, 2].map(|c| (p, c)));
        let tips = corners.filter(|(p, c)| self.patches[*p].is_singular(*c));
        let tips: BTreeSet<u32> = tips.map(|(p, c)| self.frame.faces[p][c]).collect();
        lines.extend(tips.into_iter().map(|v| vec![self.frame.positions[v as usize]]));
        lines
    }

    /// Diagonal of the bounding box of the vertices.
    pub fn diagonal(&self) -> f64 {
        Aabb::around(&self.frame.positions).diagonal()
    }

    /// Moves the centroid of a patch by another vector than before, [`RationalPatch::middle`]. Borders and tangent planes there stay.
    pub fn set_middle(&mut self, patch: PatchId, middle: Vec3) {
        let changed = &mut self.patches[patch.index()];
        changed.middle = middle;
        self.nets[patch.index()] = weighted_net(changed);
    }

    /// Moves the centroid of every patch to a target, as far as that is near: by at most `limit` times the longest chord between corners.
    pub fn fit_middles(&mut self, target: &dyn Target, limit: f64) {
        const CENTROID: [f64; 2] = [1.0 / 3.0; 2];
        let centers: Vec<Point3> = self.patches.iter().map(|p| p.evaluate(CENTROID).point).collect();
        let mut feet: Points = centers.iter().copied().collect();
        target.project(&mut feet);
        let moved: Vec<RationalPatch> = (0..self.patches.len())
            .into_par_iter()
            .evenly()
            .map(|i| {
                let mut patch = self.patches[i].clone();
                let shift = feet.get(i) - centers[i];
                let [a, b, c] = self.frame.corners(i as u32);
                let size = (b - a).norm().max((c - b).norm()).max((a - c).norm());
                if shift.norm() <= limit * size {
                    patch.middle += shift;
                }
                patch
            })
            .collect();
        self.nets = moved.par_iter().evenly().map(weighted_net).collect();
        self.patches = moved;
    }
}

impl Surface for RationalSurface {
    fn patch_count(&self) -> usize {
        self.patches.len()
    }

    fn domain(&self, _: PatchId) -> Domain {
        Domain::Triangle
    }

    /// At a corner without a tangent plane the normal is NaN, and the derivatives are those of the polynomial part.
    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
        let of = &self.patches[patch.index()];
        let t = of.evaluate(uv);
        let corner = match uv {
            [1.0, 0.0] => Some(0),
            [0.0, 1.0] => Some(1),
            [0.0, 0.0] => Some(2),
            _ => None,
        };
        let normal = match corner {
            Some(c) if of.is_singular(c) => Vec3::repeat(f64::NAN),
            _ => t.du.cross(&t.dv).normalize(),
        };
        Sample { point: t.point, normal, du: t.du, dv: t.dv }
    }

    fn form(&self, patch: PatchId) -> PatchForm<'_> {
        let WeightedNet { degree, points } = &self.nets[patch.index()];
        PatchForm::RationalTriangle { degree: *degree, weighted: points }
    }

    fn seams(&self) -> &[Seam] {
        &self.seams
    }

    fn corners(&self, patch: PatchId) -> [u32; 3] {
        self.frame.faces[patch.index()]
    }

    fn curve(&self, seam: usize) -> u32 {
        self.frame.seams[seam].wire
    }

    fn bounds(&self, patch: PatchId) -> Aabb {
        let points = self.nets[patch.index()].points.iter().filter(|p| p.w > 0.0).map(|p| p.xyz() / p.w);
        points.fold(Aabb::EMPTY, |b, p| b.including(&p))
    }
}
