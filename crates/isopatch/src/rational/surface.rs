use super::build::WireOf;
use super::frame::Frame;
use super::patch::RationalPatch;
use super::weighted::{WeightedNet, weighted_net};
use crate::geom::{Aabb, Point3, Points, Vec3};
use crate::network::wire::Wire;
use crate::surface::{Domain, PatchForm, PatchId, Sample, Seam, Surface, Target};
use rayon::prelude::*;

/// Rational patches over the triangles of a [`Frame`].
///
/// Patches that meet share the wire between them, to the bit. Sheets that cross share the wires on their common curve, and vertices are
/// shared in any case; [`Surface::curve`] says so.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalSurface {
    positions: Vec<Point3>,
    corners: Vec<[u32; 3]>,
    wires: Vec<Wire>,
    /// Vertices at the ends of each wire.
    wire_ends: Vec<[u32; 2]>,
    patches: Vec<RationalPatch>,
    nets: Vec<WeightedNet>,
    seams: Vec<Seam>,
    curves: Vec<u32>,
}

impl RationalSurface {
    pub(super) fn new(frame: &Frame, wires: Vec<WireOf>, patches: Vec<RationalPatch>) -> Self {
        let mut wire_ends = vec![[0; 2]; wires.len()];
        for seam in &frame.seams {
            let mut ends = frame.ends(seam.first);
            if ends[0] != wires[seam.wire as usize].start {
                ends.reverse();
            }
            wire_ends[seam.wire as usize] = ends;
        }
        let seams = frame.seams.iter().map(|seam| {
            let (first, second, continuity) = frame.sides(seam);
            Seam { first, second, continuity }
        });
        Self::from_parts(
            frame.positions.clone(),
            frame.faces.clone(),
            wires.into_iter().map(|of| of.wire).collect(),
            wire_ends,
            patches,
            seams.collect(),
            frame.seams.iter().map(|seam| seam.wire).collect(),
        )
    }

    /// A surface from what [`Self`] tells of it. Wires and patches have to fit together.
    pub(crate) fn from_parts(
        positions: Vec<Point3>,
        corners: Vec<[u32; 3]>,
        wires: Vec<Wire>,
        wire_ends: Vec<[u32; 2]>,
        patches: Vec<RationalPatch>,
        seams: Vec<Seam>,
        curves: Vec<u32>,
    ) -> Self {
        let nets = patches.par_iter().map(weighted_net).collect();
        Self { positions, corners, wires, wire_ends, patches, nets, seams, curves }
    }

    /// Position of each vertex.
    pub fn positions(&self) -> &[Point3] {
        &self.positions
    }

    /// Bézier points of each wire.
    pub fn wires(&self) -> &[Wire] {
        &self.wires
    }

    /// Vertices at the start and the end of each wire.
    pub fn wire_ends(&self) -> &[[u32; 2]] {
        &self.wire_ends
    }

    /// A patch.
    pub fn patch(&self, patch: PatchId) -> &RationalPatch {
        &self.patches[patch.index()]
    }

    /// The patch in Bézier form with weights.
    pub fn weighted(&self, patch: PatchId) -> &WeightedNet {
        &self.nets[patch.index()]
    }

    /// Diagonal of the bounding box of the vertices.
    pub fn diagonal(&self) -> f64 {
        Aabb::around(&self.positions).diagonal()
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
            .map(|i| {
                let mut patch = self.patches[i].clone();
                let shift = feet.get(i) - centers[i];
                let [a, b, c] = self.corners[i].map(|v| self.positions[v as usize]);
                let size = (b - a).norm().max((c - b).norm()).max((a - c).norm());
                if shift.norm() <= limit * size {
                    patch.middle += shift;
                }
                patch
            })
            .collect();
        self.nets = moved.par_iter().map(weighted_net).collect();
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
        self.corners[patch.index()]
    }

    fn curve(&self, seam: usize) -> u32 {
        self.curves[seam]
    }

    fn bounds(&self, patch: PatchId) -> Aabb {
        let points = self.nets[patch.index()].points.iter().filter(|p| p.w > 0.0).map(|p| p.xyz() / p.w);
        points.fold(Aabb::EMPTY, |b, p| b.including(&p))
    }
}
