//! The steps from data to a hull, and from a finished hull to another.

use super::builder::{Builder, gradients};
use super::hermite::HermiteMesh;
use super::options::{ApexRule, HullOptions, RobustApexes};
use super::refine::{self, Refinement};
use super::repair;
use super::simplicial_hull::Hull;
use crate::mesh::{EdgeId, VertexId};

/// Builds the hull of a mesh: classes, apexes, edge cells, and a list of what does not fit.
///
/// Linear in the number of faces. The paper's rule follows §3.1; the robust rule then raises apexes, and looks for other
/// directions and, at the vertices concerned, other normals, for the faces where that fails.
pub fn build(data: HermiteMesh, options: &HullOptions) -> Hull {
    built(data, options, Refinement::default())
}

/// The same where something is known about what refinement leads to.
pub(super) fn built(data: HermiteMesh, options: &HullOptions, refinement: Refinement) -> Hull {
    let mut builder = Builder::new(data, options);
    builder.refinement = refinement;
    if let ApexRule::Robust(rule) = options.rule {
        builder.raise((0..builder.data.mesh().edge_count()).map(EdgeId::from).collect(), &rule);
        repair::repair(&mut builder, &rule);
        if rule.corners {
            repair::join_sides(&mut builder, &rule);
            refine::refine_or_cut(&mut builder, &rule);
        }
    }
    builder.finish()
}

/// Takes a finished hull to pieces, lets `change` alter it, and finishes it again.
pub(super) fn altered<T>(
    hull: Hull,
    change: impl FnOnce(&mut Builder<'_>, &RobustApexes) -> T,
) -> (Hull, Option<T>) {
    let ApexRule::Robust(rule) = hull.options.rule else { return (hull, None) };
    let options = hull.options;
    let given = gradients(&hull.data);
    let moved = hull.moved_normals;
    let mut builder = Builder::with_faces(hull.data, hull.faces, given, &options);
    builder.corners = hull.corners;
    builder.added_creases = hull.added_creases;
    builder.effort = hull.reliefs.effort;
    builder.reliefs = hull.reliefs;
    builder.refinement = hull.refinement;
    let result = change(&mut builder, &rule);
    let mut hull = builder.finish();
    hull.moved_normals.extend(moved);
    hull.moved_normals.sort_unstable();
    hull.moved_normals.dedup();
    let is_corner = |v: &VertexId| hull.corners.binary_search_by_key(v, |c| c.vertex).is_ok();
    let moved = hull.moved_normals.iter().copied().filter(|v| !is_corner(v)).collect();
    hull.moved_normals = moved;
    (hull, Some(result))
}
