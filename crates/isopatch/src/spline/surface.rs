use crate::base::{BaseMesh, EdgeFeature};
use crate::bernstein::{index, lanes, triangle};
use crate::geom::{Aabb, Point3};
use crate::mesh::{EdgeId, FaceId};
use crate::surface::{Continuity, Domain, PatchForm, PatchId, Sample, Seam, SeamSide, Surface};

/// Degree of the patches.
pub const DEGREE: usize = 7;
/// Control points of a patch.
pub const NET: usize = index::count(DEGREE);

/// A spline of degree-7 Bézier triangles over a base mesh, one patch a face, G1 across every interior edge that is not sharp.
///
/// Control points on an edge are those of one quartic curve, elevated once, so both patches hold the same bits.
#[derive(Clone, Debug)]
pub struct TriangularSpline {
    /// What the spline interpolates: positions, normals and normal curvatures at the vertices.
    pub base: BaseMesh,
    /// Quartic boundary curve of each edge, from the origin of [`crate::mesh::HalfEdgeMesh::edge_half_edge`].
    pub curves: Vec<[Point3; 5]>,
    /// Control net of each patch, corner k over corner k of the face; order of [`crate::bernstein`].
    pub nets: Vec<[Point3; NET]>,
    seams: Vec<Seam>,
}

impl TriangularSpline {
    /// Puts the parts together. `curves` has one entry an edge and `nets` one a face of the base mesh.
    pub fn new(base: BaseMesh, curves: Vec<[Point3; 5]>, nets: Vec<[Point3; NET]>) -> Self {
        let seams = seams_of(&base);
        Self { base, curves, nets, seams }
    }
}

/// Every edge of a triangle mesh as a seam in the direction of its half edge.
fn seams_of(base: &BaseMesh) -> Vec<Seam> {
    let mesh = &base.mesh;
    let side = |h, reversed| SeamSide { patch: PatchId(mesh.face(h).0), edge: mesh.side(h) as u8, reversed };
    let continuity = |e: EdgeId| match base.features[e.index()] {
        EdgeFeature::Sharp => Continuity::G0,
        EdgeFeature::Smooth | EdgeFeature::Boundary => Continuity::G1,
    };
    mesh.edges()
        .map(|e| {
            let h = mesh.edge_half_edge(e);
            let second = mesh.twin(h).map(|g| side(g, true));
            Seam { first: side(h, false), second, continuity: continuity(e) }
        })
        .collect()
}

impl Surface for TriangularSpline {
    fn patch_count(&self) -> usize {
        self.nets.len()
    }

    fn domain(&self, _: PatchId) -> Domain {
        Domain::Triangle
    }

    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
        let t = triangle::evaluate(DEGREE, &self.nets[patch.index()], uv);
        Sample { point: t.point, normal: t.du.cross(&t.dv).normalize(), du: t.du, dv: t.dv }
    }

    fn sample_batch(&self, patch: PatchId, uv: &[[f64; 2]], out: &mut [Sample]) {
        lanes::evaluate_all(DEGREE, &self.nets[patch.index()], uv, |i, t, normal| {
            if let Some(out) = out.get_mut(i) {
                *out = Sample { point: t.point, normal, du: t.du, dv: t.dv };
            }
        });
    }

    fn form(&self, patch: PatchId) -> PatchForm<'_> {
        PatchForm::BezierTriangle { degree: DEGREE, net: &self.nets[patch.index()] }
    }

    fn seams(&self) -> &[Seam] {
        &self.seams
    }

    fn corners(&self, patch: PatchId) -> [u32; 3] {
        self.base.mesh.triangle(FaceId(patch.0)).map(|v| v.0)
    }

    fn bounds(&self, patch: PatchId) -> Aabb {
        Aabb::around(&self.nets[patch.index()])
    }
}
