//! Patches over a base mesh, and what is built again when the mesh changes in places.
//!
//! Before it relaxes, a net depends on the faces around the three corners of its face, and on nothing else: their curves,
//! their fits, and the G1 systems at these corners. So a patch stays if none of these faces has changed. The others are
//! built over a part of the mesh that has one more ring of faces, in the order of the whole. Edges whose ends have no
//! changed face keep their rows, those beside the patches that stay among them; the other edges relax between these.
//! A curve depends on its ends alone, so it stays with any face beside it.

use crate::base::{BaseError, BaseMesh, FieldTarget, part};
use crate::bernstein::index;
use crate::field::Field;
use crate::geom::Point3;
use crate::inspect::{PatchDeviation, deviation_of};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh};
use crate::network::{CurveError, CurveOptions, QuarticCurve, fit_edges};
use crate::parallel::Evenly;
use crate::spline::edge::EdgeSolution;
use crate::spline::{self, SplineError, SplineOptions, TriangularSpline};
use crate::surface::PatchId;
use rayon::prelude::*;

/// Share of the faces from which on everything is built again: the part would have nearly all of them.
const WHOLE: f64 = 0.6;
/// Nets, or curves, that one task copies.
const COPIES: usize = 256;

/// Lattice on which all patches are measured: 66 samples each.
const COARSE_LATTICE: usize = 10;
/// Normal errors over this are measured on the fine lattice as well: a fold between coarse samples shows beside it.
const NORMAL_FINE: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Lattice on which patches are measured whose errors are near the tolerance. It is that of
/// [`crate::inspect::InspectOptions`]: a tolerance that is kept here is kept there.
const FINE_LATTICE: usize = 21;

/// How patches are made and measured.
pub(super) struct Workshop<'a> {
    pub field: &'a dyn Field,
    pub curves: &'a CurveOptions,
    pub spline: SplineOptions,
    /// Unit of lengths.
    pub diagonal: f64,
    /// Errors over this, relative to the diagonal, are measured again on a finer lattice.
    pub fine_above: f64,
}

/// Curves, nets and errors over a base mesh.
#[derive(Clone, Debug)]
pub(super) struct Patchwork {
    pub surface: TriangularSpline,
    pub curves: Vec<QuarticCurve>,
    pub patches: Vec<PatchDeviation>,
    /// Two faces with one stamp have the same corners at the same places.
    stamps: Vec<u64>,
}

/// Why patches could not be made; vertices and edges are those of the whole mesh.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MakeError {
    Base(BaseError),
    Curve(CurveError),
    Spline(SplineError),
}

impl Workshop<'_> {
    /// Builds and measures everything.
    pub fn build(&self, base: BaseMesh, stamps: Vec<u64>) -> Result<Patchwork, MakeError> {
        let all: Vec<usize> = (0..base.mesh.face_count()).collect();
        let (surface, curves, patches) = self.make(base, &all, &Kept::default())?;
        Ok(Patchwork { surface, curves, patches, stamps })
    }

    /// The same with `more` steps of relaxation than it was built with, measured again.
    pub fn relaxed(&self, made: Patchwork, more: usize) -> Patchwork {
        let target = FieldTarget::new(self.field, self.diagonal);
        let surface = spline::relaxed(made.surface, &target, more, &self.spline);
        let ids: Vec<PatchId> = surface.base.mesh.faces().map(|f| PatchId(f.0)).collect();
        let patches = self.measure(&surface, &ids);
        Patchwork { surface, patches, ..made }
    }

    /// Builds and measures what is not in `former`; also gives the number of patches that were built.
    pub fn rebuild(
        &self,
        base: BaseMesh,
        stamps: Vec<u64>,
        former: &Patchwork,
    ) -> Result<(Patchwork, usize), MakeError> {
        // Stamps count changes, so there are not many more of them than faces.
        let bound = former.stamps.iter().max().map_or(0, |last| *last as usize + 1);
        let mut place = vec![None; bound];
        former.stamps.iter().enumerate().for_each(|(i, s)| place[*s as usize] = Some(i));
        let old: Vec<Option<usize>> = stamps.iter().map(|s| place.get(*s as usize).copied()?).collect();
        // A curve that runs the other way differs in its last bits.
        let turned = |f: usize, o: usize| directions(&base, f) != directions(&former.surface.base, o);
        let is_changed = |(f, o): (usize, &Option<usize>)| o.is_none_or(|o| turned(f, o));
        let changed: Vec<bool> = old.iter().enumerate().map(is_changed).collect();
        let fresh = around(&base, &changed);
        // With the faces across, the curves opposite to the corners of fresh faces are no boundary curves.
        let support = beside(&base, &around(&base, &fresh));
        let count = support.iter().filter(|s| **s).count();
        if count as f64 > WHOLE * fresh.len() as f64 {
            let all: Vec<usize> = (0..fresh.len()).collect();
            let kept = Kept { curves: former_curves(&base.mesh, |f| old[f], former), rows: Vec::new() };
            let (surface, curves, patches) = self.make(base, &all, &kept)?;
            return Ok((Patchwork { surface, curves, patches, stamps }, count));
        }
        let part = part(&base, &support).map_err(MakeError::Base)?;
        let measured: Vec<usize> = (0..part.faces.len()).filter(|i| fresh[part.faces[*i]]).collect();
        let old_of_part = |f: usize| old[part.faces[f]];
        let kept = Kept {
            curves: former_curves(&part.base.mesh, old_of_part, former),
            rows: former_rows(&part.base.mesh, |f| changed[part.faces[f]], old_of_part, former),
        };
        let made =
            self.make(part.base, &measured, &kept).map_err(|error| error.renumbered(&part.vertices))?;
        let (part_surface, part_curves, part_patches) = made;

        let mut in_part = vec![usize::MAX; fresh.len()];
        part.faces.iter().enumerate().for_each(|(i, f)| in_part[*f] = i);
        let mut in_measured = vec![usize::MAX; fresh.len()];
        measured.iter().enumerate().for_each(|(i, m)| in_measured[part.faces[*m]] = i);
        let (nets, patches) = (0..fresh.len())
            .into_par_iter()
            .evenly_by(COPIES)
            .map(|f| match old[f] {
                Some(o) if !fresh[f] => (former.surface.nets[o], former.patches[o]),
                _ => (part_surface.nets[in_part[f]], part_patches[in_measured[f]]),
            })
            .unzip();
        let curves: Vec<QuarticCurve> = (0..base.mesh.edge_count())
            .into_par_iter()
            .evenly_by(COPIES)
            .map(|e| {
                let h = base.mesh.edge_half_edge(e.into());
                let (f, side) = (base.mesh.face(h).index(), base.mesh.side(h));
                let beside = [Some(h), base.mesh.twin(h)].into_iter().flatten();
                let is_fresh = beside.map(|h| base.mesh.face(h).index()).any(|f| fresh[f]);
                match old[f] {
                    Some(o) if !is_fresh => former.curves[edge_at(&former.surface.base, o, side)],
                    _ => part_curves[edge_at(&part_surface.base, in_part[f], side)],
                }
            })
            .collect();
        let surface = TriangularSpline::new(base, curves.iter().map(|c| c.q).collect(), nets);
        Ok((Patchwork { surface, curves, patches, stamps }, count))
    }

    /// Everything over a mesh; only the given faces are measured.
    fn make(
        &self,
        base: BaseMesh,
        measured: &[usize],
        kept: &Kept,
    ) -> Result<(TriangularSpline, Vec<QuarticCurve>, Vec<PatchDeviation>), MakeError> {
        let target = FieldTarget::new(self.field, self.diagonal);
        let curve = |e: EdgeId| kept.curves.get(e.index()).copied().flatten();
        let fresh: Vec<EdgeId> = base.mesh.edges().filter(|e| curve(*e).is_none()).collect();
        let fits = fit_edges(&base, &fresh, &target, self.curves).map_err(MakeError::Curve)?;
        let mut fits = fits.into_iter();
        let curves: Vec<QuarticCurve> =
            base.mesh.edges().filter_map(|e| curve(e).or_else(|| fits.next())).collect();
        let surface =
            spline::rebuild(base, &curves, &target, &self.spline, &kept.rows).map_err(MakeError::Spline)?;
        let ids: Vec<PatchId> = measured.iter().map(|f| PatchId(*f as u32)).collect();
        let patches = self.measure(&surface, &ids);
        Ok((surface, curves, patches))
    }

    /// Errors of some patches: coarsely, and finely where they are near what is not allowed.
    fn measure(&self, surface: &TriangularSpline, ids: &[PatchId]) -> Vec<PatchDeviation> {
        let on_lattice =
            |lattice, ids: &[PatchId]| deviation_of(surface, self.field, self.diagonal, lattice, ids);
        let is_near =
            |p: &PatchDeviation| p.max_distance > self.fine_above || p.max_normal_error > NORMAL_FINE;
        let mut patches = on_lattice(COARSE_LATTICE, ids);
        let near: Vec<usize> = (0..ids.len()).filter(|i| is_near(&patches[*i])).collect();
        let near_ids: Vec<PatchId> = near.iter().map(|i| ids[*i]).collect();
        for (i, fine) in near.iter().zip(on_lattice(FINE_LATTICE, &near_ids)) {
            patches[*i] = fine;
        }
        patches
    }
}

/// What edges keep: curves, and the rows beside them. An entry for every edge, or none at all.
#[derive(Default)]
struct Kept {
    curves: Vec<Option<QuarticCurve>>,
    rows: Vec<Option<EdgeSolution>>,
}

/// The former curves of the edges beside faces that were there before; `old` gives the former number of a face.
fn former_curves(
    mesh: &HalfEdgeMesh,
    old: impl Fn(usize) -> Option<usize>,
    former: &Patchwork,
) -> Vec<Option<QuarticCurve>> {
    let base = &former.surface.base;
    let of_side = |h: HalfEdgeId, along: bool| {
        let face = old(mesh.face(h).index())?;
        let former_h = base.mesh.face_half_edges(face.into()).nth(mesh.side(h))?;
        let e = base.mesh.edge(former_h);
        let mut curve = former.curves[e.index()];
        // The former edge may have been numbered from its other side.
        if (base.mesh.edge_half_edge(e) == former_h) != along {
            curve.q.reverse();
        }
        Some(curve)
    };
    let of_edge = |e| {
        let h = mesh.edge_half_edge(e);
        of_side(h, true).or_else(|| of_side(mesh.twin(h)?, false))
    };
    mesh.edges().map(of_edge).collect()
}

/// The former rows of those edges that keep them: no face at their ends has changed.
fn former_rows(
    mesh: &HalfEdgeMesh,
    changed: impl Fn(usize) -> bool,
    old: impl Fn(usize) -> Option<usize>,
    former: &Patchwork,
) -> Vec<Option<EdgeSolution>> {
    let mut touched = vec![false; mesh.vertex_count()];
    for f in mesh.faces().filter(|f| changed(f.index())) {
        mesh.triangle(f).iter().for_each(|v| touched[v.index()] = true);
    }
    let row = |h: HalfEdgeId, points: [usize; 3]| -> Option<[Point3; 3]> {
        let net = &former.surface.nets[old(mesh.face(h).index())?];
        Some(points.map(|m| net[index::row(spline::DEGREE, mesh.side(h), 1, m)]))
    };
    let of_edge = |e| {
        let h = mesh.edge_half_edge(e);
        if [mesh.origin(h), mesh.dest(h)].iter().any(|v| touched[v.index()]) {
            return None;
        }
        // The twin runs against the edge.
        Some(EdgeSolution { r: row(h, [2, 3, 4])?, p: row(mesh.twin(h)?, [4, 3, 2])? })
    };
    mesh.edges().map(of_edge).collect()
}

/// The edge on a side of a face.
fn edge_at(base: &BaseMesh, face: usize, side: usize) -> usize {
    let h: HalfEdgeId = base.mesh.face_half_edges(FaceId::from(face)).nth(side).unwrap_or(HalfEdgeId(0));
    base.mesh.edge(h).index()
}

/// Which of the curves of a face run along it?
fn directions(base: &BaseMesh, face: usize) -> [bool; 3] {
    let mut along = [false; 3];
    for (side, h) in base.mesh.face_half_edges(FaceId::from(face)).enumerate() {
        along[side] = base.mesh.edge_half_edge(base.mesh.edge(h)) == h;
    }
    along
}

/// All faces that share an edge with the given ones, and these.
fn beside(base: &BaseMesh, faces: &[bool]) -> Vec<bool> {
    let mesh = &base.mesh;
    let is_in = |h: HalfEdgeId| faces[mesh.face(h).index()];
    mesh.faces()
        .map(|f| faces[f.index()] || mesh.face_half_edges(f).any(|h| mesh.twin(h).is_some_and(is_in)))
        .collect()
}

/// All faces that share a vertex with the given ones.
fn around(base: &BaseMesh, faces: &[bool]) -> Vec<bool> {
    let mut vertex = vec![false; base.mesh.vertex_count()];
    for f in base.mesh.faces().filter(|f| faces[f.index()]) {
        base.mesh.triangle(f).iter().for_each(|v| vertex[v.index()] = true);
    }
    base.mesh.faces().map(|f| base.mesh.triangle(f).iter().any(|v| vertex[v.index()])).collect()
}

impl MakeError {
    /// With the numbers of the whole mesh for those of a part. Edges keep the number that they have in the part.
    fn renumbered(mut self, vertices: &[u32]) -> Self {
        match &mut self {
            Self::Curve(
                CurveError::Infeasible { from, to, .. }
                | CurveError::NoTangent { from, to, .. }
                | CurveError::AlongBoxEdge { from, to, .. },
            )
            | Self::Spline(SplineError::SingularEdge { from, to, .. }) => {
                (*from, *to) = (vertices[*from as usize], vertices[*to as usize]);
            }
            Self::Spline(SplineError::SingularVertex { vertex }) => *vertex = vertices[*vertex as usize],
            Self::Base(_) => {}
        }
        self
    }

    /// The vertices in question.
    pub fn vertices(&self) -> Vec<u32> {
        match self {
            Self::Curve(
                CurveError::Infeasible { from, to, .. }
                | CurveError::NoTangent { from, to, .. }
                | CurveError::AlongBoxEdge { from, to, .. },
            )
            | Self::Spline(SplineError::SingularEdge { from, to, .. }) => vec![*from, *to],
            Self::Spline(SplineError::SingularVertex { vertex }) => vec![*vertex],
            Self::Base(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;
    use crate::base::{BaseOptions, Draft, build};
    use crate::field::{Constants, Formula};
    use crate::geom::{Aabb, Point3};

    fn torus() -> (Formula, BaseMesh, BaseOptions) {
        let formula = Formula::parse("(x^2+y^2+z^2+24)^2-100(x^2+y^2)", &Constants::new()).unwrap();
        let bounds = Aabb::new(Point3::new(-6.4, -6.4, -1.4), Point3::new(6.4, 6.4, 1.4));
        let options = BaseOptions { faces: Some(1_000), ..BaseOptions::default() };
        let base = build(&formula, &bounds, &options).unwrap().base;
        (formula, base, options)
    }

    #[test]
    fn a_local_rebuild_equals_a_full_one_to_the_bit() {
        let (formula, base, options) = torus();
        let curves = CurveOptions::default();
        let spline = SplineOptions { relaxation_steps: 0, ..SplineOptions::default() };
        let diagonal = base.diagonal();
        let workshop =
            Workshop { field: &formula, curves: &curves, spline, diagonal, fine_above: f64::INFINITY };
        let mut draft = Draft::new(&formula, &base, &options);
        let before = workshop.build(draft.base().unwrap(), draft.live_stamps()).unwrap();

        let mut batch = draft.batch().unwrap();
        let edges = batch.edges();
        assert!(batch.split(edges[100]));
        let collapsed: Vec<_> = edges[600..].iter().step_by(97).filter_map(|h| batch.collapse(*h)).collect();
        assert!(!collapsed.is_empty());
        draft.undo(&collapsed[0]);

        let (base, stamps) = (draft.base().unwrap(), draft.live_stamps());
        let (local, built) = workshop.rebuild(base.clone(), stamps.clone(), &before).unwrap();
        let full = workshop.build(base, stamps).unwrap();
        assert!(built < full.patches.len(), "{built} of {} patches", full.patches.len());
        // Not assert_eq, which would print all of them.
        assert!(local.surface.nets == full.surface.nets);
        assert!(local.curves == full.curves);
        assert!(local.patches == full.patches);
    }
}
