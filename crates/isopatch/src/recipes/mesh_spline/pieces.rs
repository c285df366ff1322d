//! The spline over the pieces into which sharp edges cut a mesh, and the pieces joined.

use super::cut::{Cut, cut};
use super::rim::Rims;
use super::sharpen::Sharpness;
use super::visible::{see_better, see_faces};
use crate::base::{BaseMesh, EdgeFeature, compatible_curvatures};
use crate::bernstein::{curve, index};
use crate::geom::Point3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeMesh, MeshError, VertexId};
use crate::network::{CurveError, CurveOptions, QuarticCurve, interpolate_edges};
use crate::report::Seconds;
use crate::spline::{self, DEGREE, NET, SplineError, TriangularSpline, normal_deviations};
use std::f64::consts::PI;

/// Lattice on which patches are looked at for folds: 66 samples each.
const LATTICE: usize = 10;
/// Angle between the normals of a patch and the blended normals of its corners from which on it counts as folded: at 90° it is,
/// and between samples it may turn a little further.
const FOLDED: f64 = 80.0 * PI / 180.0;
/// Factor of the weight of the edges of a bad patch, and the largest weight.
const STIFFER: f64 = 10.0;
const STIFFEST: f64 = 1e3;
/// Share of the way to the most visible direction that the normals of a bad patch go in a round.
const TURN: f64 = 0.5;

/// Makes surfaces over the pieces of one mesh.
pub struct Maker<'a> {
    /// The mesh, and its positions.
    pub whole: &'a HalfEdgeMesh,
    pub positions: &'a [Point3],
    pub curves: &'a CurveOptions,
    /// Most times that normals and curvature tensors are changed because patches fold.
    pub rounds: usize,
}

/// What became of the pieces; vertices, edges and faces are those of the whole.
pub struct Attempt {
    /// The surface with the fewest folds; none if a curve or a G1 system had no solution in any round.
    pub made: Option<Made>,
    /// Edges that had no curve or G1 system in the last round.
    pub failed: Vec<EdgeId>,
    /// Vertices whose normals were moved to see the faces around them.
    pub moved: Vec<VertexId>,
}

/// A surface over the pieces.
pub struct Made {
    pieces: TriangularSpline,
    cut: Cut,
    /// Largest angle between the normal of each patch and the blended normals of its corners, in radians.
    pub deviations: Vec<f64>,
    /// Folded patches.
    pub folded: Vec<FaceId>,
}

impl Maker<'_> {
    /// The surface with the given sharp edges.
    ///
    /// In rounds: curvature tensors, curves, patches, check. Where patches fold, their vertices' normals turn towards what sees their
    /// faces best, and the tensors heed their curves more.
    pub fn attempt(&self, sharpness: &Sharpness, seconds: &mut Seconds) -> Result<Attempt, MeshError> {
        let cut = cut(self.whole, self.positions, &sharpness.edges)?;
        let rims = Rims::new(self.whole, &cut, self.positions, &sharpness.corners);
        let mut base = seconds.measure("normals and curvatures", || {
            BaseMesh::estimated(cut.mesh.clone(), cut.positions.clone())
        });
        let mut moved = see_faces(&base.mesh, &base.positions, &mut base.normals);
        let mut stiffness = vec![1.0; base.mesh.edge_count()];
        let (mut best, mut failed) = (None, Vec::new());
        for _ in 0..=self.rounds {
            for v in cut.mesh.vertices() {
                base.normals[v.index()] = rims.across(&cut, v, &base.normals[v.index()]);
            }
            base.curvatures =
                seconds.measure("normals and curvatures", || compatible_curvatures(&base, &stiffness));
            let made = seconds.measure("patches", || self.patches(&base, &cut, &rims));
            let surface = match made {
                Ok(surface) => surface,
                Err(edges) => {
                    edges.iter().for_each(|e| stiffness[e.index()] *= STIFFER);
                    failed = edges;
                    continue;
                }
            };
            failed.clear();
            let deviations = seconds.measure("check", || normal_deviations(&surface, LATTICE));
            let is_folded = |f: &FaceId| deviations[f.index()] > FOLDED;
            let folded: Vec<FaceId> = cut.mesh.faces().filter(is_folded).collect();
            for h in folded.iter().flat_map(|f| cut.mesh.face_half_edges(*f)) {
                let weight = &mut stiffness[cut.mesh.edge(h).index()];
                *weight = (STIFFER * *weight).min(STIFFEST);
            }
            let mut corners: Vec<VertexId> = folded.iter().flat_map(|f| cut.mesh.triangle(*f)).collect();
            corners.sort_unstable();
            corners.dedup();
            if best.as_ref().is_none_or(|(_, _, fewest): &(_, _, Vec<FaceId>)| folded.len() < fewest.len()) {
                best = Some((surface, deviations, folded));
            }
            if corners.is_empty() {
                break;
            }
            see_better(&base.mesh, &base.positions, &mut base.normals, &corners, TURN);
            moved.extend(corners);
        }
        // Half edges of the pieces and of the whole have the same numbers.
        let failed = failed.into_iter().map(|e| self.whole.edge(cut.mesh.edge_half_edge(e))).collect();
        let mut moved: Vec<VertexId> = moved.into_iter().map(|v| cut.source[v.index()]).collect();
        moved.sort_unstable();
        moved.dedup();
        let made = best.map(|(pieces, deviations, folded)| Made { pieces, cut, deviations, folded });
        Ok(Attempt { made, failed, moved })
    }

    /// Curves and patches; or the edges of the pieces that have no curve, or at whose ends a G1 system has no solution.
    fn patches(&self, base: &BaseMesh, cut: &Cut, rims: &Rims) -> Result<TriangularSpline, Vec<EdgeId>> {
        let mesh = &cut.mesh;
        let is_inner = |e: &EdgeId| mesh.twin(mesh.edge_half_edge(*e)).is_some();
        let inner: Vec<EdgeId> = mesh.edges().filter(is_inner).collect();
        let fits: Vec<Result<QuarticCurve, CurveError>> = interpolate_edges(base, &inner, self.curves);
        let failed: Vec<EdgeId> =
            inner.iter().zip(&fits).filter(|(_, fit)| fit.is_err()).map(|(e, _)| *e).collect();
        if !failed.is_empty() {
            return Err(failed);
        }
        let mut fits = fits.into_iter().flatten();
        let over_rim = |e: EdgeId| {
            let h = mesh.edge_half_edge(e);
            // Once for both sides.
            let first = self.whole.edge_half_edge(self.whole.edge(h));
            let mut curve = rims.curve(self.whole, self.positions, first);
            if first != h {
                curve.q.reverse();
            }
            curve
        };
        let curve = |e: EdgeId| if is_inner(&e) { fits.next() } else { Some(over_rim(e)) };
        let curves: Vec<QuarticCurve> = mesh.edges().filter_map(curve).collect();
        spline::fill(base.clone(), &curves).map_err(|error| match error {
            SplineError::SingularVertex { vertex } => {
                mesh.ring(VertexId(vertex)).map(|h| mesh.edge(h)).collect()
            }
            SplineError::SingularEdge { edge, .. } => vec![EdgeId(edge)],
        })
    }
}

impl Made {
    /// The pieces joined along their rims. The normal and the curvature tensor of a vertex on a rim are those of one of
    /// the pieces there.
    pub fn joined(self, whole: &HalfEdgeMesh, positions: &[Point3]) -> TriangularSpline {
        let Self { mut pieces, cut, .. } = self;
        let mut copy = vec![0; whole.vertex_count()];
        cut.source.iter().enumerate().rev().for_each(|(of_piece, v)| copy[v.index()] = of_piece);
        let normals = copy.iter().map(|v| pieces.base.normals[*v]).collect();
        let curvatures = copy.iter().map(|v| pieces.base.curvatures[*v]).collect();
        let mut base = BaseMesh::from_parts(whole.clone(), positions.to_vec(), normals, curvatures);
        let mut curves = Vec::with_capacity(whole.edge_count());
        for e in whole.edges() {
            let h = whole.edge_half_edge(e);
            let of_piece = cut.mesh.edge(h);
            let mut q = pieces.curves[of_piece.index()];
            if cut.mesh.edge_half_edge(of_piece) != h {
                q.reverse();
            }
            curves.push(q);
            if cut.mesh.twin(h).is_none() && whole.twin(h).is_some() {
                base.features[e.index()] = EdgeFeature::Sharp;
                give_both_sides(whole, e, &q, &mut pieces.nets);
            }
        }
        TriangularSpline::new(base, curves, pieces.nets)
    }
}

/// Puts the curve over an edge, elevated once, into the patches on both sides: the same bits.
fn give_both_sides(whole: &HalfEdgeMesh, e: EdgeId, q: &[Point3; 5], nets: &mut [[Point3; NET]]) {
    let row: [Point3; DEGREE + 1] = curve::elevate(q);
    let first = whole.edge_half_edge(e);
    for h in [Some(first), whole.twin(first)].into_iter().flatten() {
        for (m, p) in row.iter().enumerate() {
            let m = if h == first { m } else { DEGREE - m };
            nets[whole.face(h).index()][index::row(DEGREE, whole.side(h), 0, m)] = *p;
        }
    }
}
