//! What a surface of rational patches is worth.

use super::deviation::deviation_at;
use super::{
    InspectOptions, Inspection, Interpolation, Topology, coverage, extent, intersections, or_infinite, seams,
    topology,
};
use crate::bernstein::triangle;
use crate::field::Field;
use crate::geom::Aabb;
use crate::geom::normal_jump;
use crate::mesh::HalfEdgeMesh;
use crate::parallel::Evenly;
use crate::rational::{Frame, RationalSurface, is_folded_over};
use crate::surface::{PatchId, Surface};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// All that [`inspect_rational`] measures.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalInspection {
    /// What is measured of every surface. Curvatures, which the method does not interpolate, are NaN. At singular vertices no normals
    /// are compared; with such, or crossings, deviations are those of samples inside the patches, and no self-intersections are looked for
    /// where sheets cross by nature.
    pub common: Inspection,
    /// Patches that fold over, in order: see [`crate::rational::is_folded`].
    pub folded: Vec<PatchId>,
    /// Curves on which other than one or two patches meet: where sheets cross.
    pub crossings: usize,
    /// Vertices at which a patch has no tangent plane.
    pub singular_vertices: usize,
}

/// Measures a surface of rational patches, against a field that is negative inside if there is one.
pub fn inspect_rational(
    surface: &RationalSurface,
    field: Option<&dyn Field>,
    options: &InspectOptions,
) -> RationalInspection {
    let frame = surface.frame();
    let diagonal = surface.diagonal();
    let extent = extent(surface);
    let lattice = Some(options.intersection_lattice).filter(|n| *n > 0);
    let back = field.filter(|_| options.back_samples > 0);
    let counts = curve_counts(frame);
    let crossings = counts.values().filter(|(uses, _)| *uses > 2).count();
    // Where ∇f vanishes, on singular curves and points, neither |f|/|∇f| nor the normal says anything: these are on borders.
    let is_regular = frame.normals.iter().flatten().all(Option::is_some) && crossings == 0;
    let inside = if is_regular { triangle::lattice } else { triangle::interior_lattice };
    let common = Inspection {
        diagonal,
        bounds: Aabb::around(&frame.positions),
        patches: surface.patch_count(),
        topology: topology_of(frame, &counts),
        extent,
        seams: seams(surface, diagonal, options.seam_samples),
        interpolation: interpolation(surface, diagonal),
        intersections: lattice.filter(|_| crossings == 0).and_then(|n| intersections(surface, n).ok()),
        deviation: field.map(|f| deviation_at(surface, f, diagonal, &inside(options.lattice.max(3)))),
        coverage: options.coverage.or_else(|| {
            coverage(surface, back?, diagonal, extent.area, options.back_samples, options.region)
        }),
    };
    let samples = triangle::lattice(options.lattice.max(1));
    let folds = |p: &PatchId| is_folded_over(surface, *p, &samples);
    let patches: Vec<PatchId> = surface.patches().collect();
    let mut tips: Vec<u32> = patches
        .iter()
        .flat_map(|p| (0..3).filter(|c| surface.patch(*p).is_singular(*c)).map(|c| surface.corners(*p)[c]))
        .collect();
    tips.sort_unstable();
    tips.dedup();
    RationalInspection {
        common,
        folded: patches.into_par_iter().evenly().filter(folds).collect(),
        crossings,
        singular_vertices: tips.len(),
    }
}

/// Corners of patches against the vertices and normals of the frame.
fn interpolation(surface: &RationalSurface, diagonal: f64) -> Interpolation {
    let frame = surface.frame();
    let mut found = Interpolation {
        max_curvature_error: f64::NAN,
        max_mixed_curvature_error: f64::NAN,
        ..Interpolation::default()
    };
    for patch in surface.patches() {
        for (c, uv) in [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]].into_iter().enumerate() {
            let sample = surface.sample(patch, uv);
            let vertex = frame.positions[frame.faces[patch.index()][c] as usize];
            let miss = or_infinite((sample.point - vertex).norm() / diagonal);
            found.max_position_error = found.max_position_error.max(miss);
            if let Some(normal) = frame.normals[patch.index()][c]
                && !surface.patch(patch).is_singular(c)
            {
                found.max_normal_error = found.max_normal_error.max(normal_jump(&sample.normal, &normal));
            }
        }
    }
    found
}

/// Patch edges on each curve, and its ends.
fn curve_counts(frame: &Frame) -> BTreeMap<u32, (usize, [u32; 2])> {
    let mut counts = BTreeMap::new();
    for seam in &frame.seams {
        let (uses, _) = counts.entry(seam.wire).or_insert((0, frame.ends(seam.first)));
        *uses += 1 + usize::from(seam.second.is_some());
    }
    counts
}

/// Connectivity: of the mesh if that is a manifold. Where sheets cross or touch there is no genus, 0 is given, and boundary loops are the
/// connected parts of the curves on which one patch ends.
fn topology_of(frame: &Frame, counts: &BTreeMap<u32, (usize, [u32; 2])>) -> Topology {
    if counts.values().all(|(uses, _)| *uses <= 2)
        && let Ok(mesh) = HalfEdgeMesh::from_faces(frame.positions.len(), &frame.faces)
    {
        return topology(&mesh);
    }
    let of_faces = frame.faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c]]);
    let (vertices, components) = parts(of_faces);
    let (_, boundary_loops) = parts(counts.values().filter(|(uses, _)| *uses == 1).map(|(_, ends)| *ends));
    Topology {
        vertices,
        edges: counts.len(),
        faces: frame.faces.len(),
        components,
        euler: vertices as i64 - counts.len() as i64 + frame.faces.len() as i64,
        genus: 0,
        boundary_loops,
    }
}

/// How many vertices some edges have, and how many connected parts they make.
fn parts(edges: impl Iterator<Item = [u32; 2]>) -> (usize, usize) {
    let mut parents: HashMap<u32, u32> = HashMap::new();
    let mut joined = 0;
    for ends in edges {
        let [a, b] = ends.map(|v| root(&mut parents, v));
        if a != b {
            parents.insert(a.max(b), a.min(b));
            joined += 1;
        }
    }
    (parents.len(), parents.len() - joined)
}

/// The smallest number that a vertex is joined to; halves the way there for the next time.
fn root(parents: &mut HashMap<u32, u32>, mut v: u32) -> u32 {
    loop {
        let parent = *parents.entry(v).or_insert(v);
        if parent == v {
            return v;
        }
        let above = *parents.entry(parent).or_insert(parent);
        parents.insert(v, above);
        v = above;
    }
}
