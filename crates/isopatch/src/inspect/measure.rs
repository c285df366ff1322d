//! Sizes of a surface: connectivity, box, area, volume.

use super::samples::SampleSet;
use crate::geom::{Aabb, Point3};
use crate::mesh::HalfEdgeMesh;
use crate::numeric::quadrature::triangle_gauss;
use crate::parallel::Evenly;
use crate::surface::{PatchId, Surface};
use rayon::prelude::*;

/// Points a direction of the Gauss rule. Eleven make it exact to degree 20, and b · (b_u × b_v) has degree 19 for
/// a patch of degree 7, so the volume is exact up to rounding.
const GAUSS_POINTS: usize = 11;
/// Patches that one task integrates.
const CHUNK: usize = 16;

/// Connectivity of a mesh in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of connected components.
    pub components: usize,
    /// Vertices − edges + faces.
    pub euler: i64,
    /// Total genus of the components, holes closed up.
    pub genus: i64,
    /// Number of boundary loops.
    pub boundary_loops: usize,
}

/// Counts the elements of a mesh.
pub fn topology(mesh: &HalfEdgeMesh) -> Topology {
    Topology {
        vertices: mesh.vertex_count(),
        edges: mesh.edge_count(),
        faces: mesh.face_count(),
        components: mesh.component_count(),
        euler: mesh.euler_number(),
        genus: mesh.genus(),
        boundary_loops: mesh.boundary_loop_count(),
    }
}

/// Area and enclosed volume of a surface, and the box around its patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Box around the control nets; a little larger than the surface.
    pub bounds: Aabb,
    /// Area, in squared model units.
    pub area: f64,
    /// Volume inside, in cubic model units: positive if the patches are oriented outwards. Of an open surface, that
    /// of the cone from the centre of the box.
    pub volume: f64,
}

/// Integrates over the patches: area ∫ |b_u × b_v|, and volume ⅓ ∫ b · (b_u × b_v) by the divergence theorem.
pub fn extent(surface: &dyn Surface) -> Extent {
    let bounds = surface.patches().fold(Aabb::EMPTY, |b, p| b.union(&surface.bounds(p)));
    let (parameters, weights): (Vec<_>, Vec<_>) = triangle_gauss(GAUSS_POINTS).into_iter().unzip();
    let set = SampleSet::new(surface, &parameters);
    let patches: Vec<PatchId> = surface.patches().collect();
    let parts: Vec<_> = patches
        .par_chunks(CHUNK)
        .evenly()
        .map(|c| integrate(surface, c, &set, &weights, bounds.center()))
        .collect();
    let (area, volume) = parts.into_iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Extent { bounds, area, volume }
}

/// Area and volume over some patches, seen from `center` to keep digits for a surface far from the origin.
fn integrate(
    surface: &dyn Surface,
    patches: &[PatchId],
    set: &SampleSet,
    weights: &[f64],
    center: Point3,
) -> (f64, f64) {
    /// Area of the parameter triangle, which the weights, of sum 1, leave out.
    const DOMAIN_AREA: f64 = 0.5;
    let samples = set.sample(surface, patches);
    let (mut area, mut volume) = (0.0, 0.0);
    for i in 0..samples.points.len() {
        let normal = samples.du.get(i).cross(&samples.dv.get(i));
        let weight = DOMAIN_AREA * weights[i % set.count()];
        area += weight * normal.norm();
        volume += weight * (samples.points.get(i) - center).dot(&normal) / 3.0;
    }
    (area, volume)
}
