//! A base mesh made finer where its surface is not good enough.

use super::base_mesh::BaseMesh;
use super::build::{BaseOptions, BaseOutcome, finish, require_convex_corners};
use super::error::BaseError;
use super::remesh::{RemeshOptions, remesh_to};
use super::triangle_mesh::TriangleMesh;
use super::validity::validity;
use crate::field::Field;

/// Rounds of remeshing: lengths change little, so fewer than from scratch are enough.
const ROUNDS: usize = 3;

/// Mean length of the edges at each vertex.
pub fn edge_lengths(base: &BaseMesh) -> Vec<f64> {
    let mesh = &base.mesh;
    mesh.vertices()
        .map(|v| {
            let lengths = mesh
                .ring(v)
                .map(|h| (base.positions[mesh.dest(h).index()] - base.positions[v.index()]).norm());
            let (sum, count) = lengths.fold((0.0, 0), |(sum, n), l| (sum + l, n + 1));
            sum / f64::from(count)
        })
        .collect()
}

/// Remeshes a base mesh to `faces` faces (an even number if it is closed) whose edge lengths are in proportion to `lengths`, one a vertex,
/// where the limits of [`super::SizingOptions`] allow.
pub fn refine(
    field: &dyn Field,
    base: &BaseMesh,
    lengths: &[f64],
    faces: usize,
    options: &BaseOptions,
) -> Result<BaseOutcome, BaseError> {
    let triangles = base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| v.0)).collect();
    let mesh = TriangleMesh { positions: base.positions.clone(), faces: triangles, clip: base.clip.clone() };
    let rounds = RemeshOptions { rounds: ROUNDS, ..options.remesh };
    let fine = remesh_to(field, &mesh, Some(lengths), faces, base.diagonal(), &rounds)?;
    let base = finish(field, fine, &options.remesh.projection)?;
    let violations = validity(&base, &options.limits);
    require_convex_corners(&violations)?;
    Ok(BaseOutcome { base, repairs: Vec::new(), violations })
}
