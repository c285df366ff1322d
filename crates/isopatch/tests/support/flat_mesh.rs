//! The flat alternative: a triangle mesh that takes as many bytes as the spline, with its vertices on the zero set.

use isopatch::bernstein::triangle;
use isopatch::field::Field;
use isopatch::geom::{Aabb, Point3};
use isopatch::inspect::closest_zero;
use isopatch::spline::TriangularSpline;
use isopatch::surface::{Domain, PatchForm, PatchId, Sample, Seam, Surface};
use isopatch::tessellate::{TessellateOptions, tessellate};

/// Intervals along a patch edge: 25 triangles on 12.5 vertices a patch take 600 bytes, with 24 a vertex and 12 a triangle.
const RESOLUTION: usize = 5;

/// A triangle mesh as a surface of degree 1, so that the same code measures both.
pub struct FlatMesh {
    nets: Vec<[Point3; 3]>,
    corners: Vec<[u32; 3]>,
    /// Size of a file with 64-bit coordinates and 32-bit vertex numbers.
    pub bytes: usize,
}

impl FlatMesh {
    /// The triangles of the tessellated spline, with their vertices moved to the zero set.
    pub fn of(spline: &TriangularSpline, field: &dyn Field) -> Self {
        let mesh = tessellate(spline, &TessellateOptions { resolution: RESOLUTION }).unwrap();
        let diagonal = spline.base.diagonal();
        let positions: Vec<Point3> =
            mesh.positions.iter().map(|p| closest_zero(field, *p, diagonal).unwrap()).collect();
        // Nets start at the corner with u = 1.
        let nets = mesh.triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect();
        let bytes = 24 * positions.len() + 12 * mesh.triangles.len();
        Self { nets, corners: mesh.triangles, bytes }
    }
}

impl Surface for FlatMesh {
    fn patch_count(&self) -> usize {
        self.nets.len()
    }

    fn domain(&self, _: PatchId) -> Domain {
        Domain::Triangle
    }

    fn sample(&self, patch: PatchId, uv: [f64; 2]) -> Sample {
        let t = triangle::evaluate(1, &self.nets[patch.index()], uv);
        Sample { point: t.point, normal: t.du.cross(&t.dv).normalize(), du: t.du, dv: t.dv }
    }

    fn form(&self, patch: PatchId) -> PatchForm<'_> {
        PatchForm::BezierTriangle { degree: 1, net: &self.nets[patch.index()] }
    }

    fn seams(&self) -> &[Seam] {
        &[]
    }

    fn corners(&self, patch: PatchId) -> [u32; 3] {
        self.corners[patch.index()]
    }

    fn bounds(&self, patch: PatchId) -> Aabb {
        Aabb::around(&self.nets[patch.index()])
    }
}
