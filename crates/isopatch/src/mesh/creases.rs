//! Sharp edges, and the sectors into which they cut the faces around a vertex.
//!
//! Edges are tagged by a list with one entry an edge. Boundary edges are never tagged: they cut anyway.

use super::normals::of_faces;
use super::{HalfEdgeId, HalfEdgeMesh, VertexId};
use crate::geom::{Point3, Vec3, angle_between};

/// Tags every edge whose faces have normals that differ by more than `angle` radians.
///
/// At an edge of a face without area nothing is tagged.
pub fn by_angle(mesh: &HalfEdgeMesh, positions: &[Point3], angle: f64) -> Vec<bool> {
    let normals = of_faces(mesh, positions);
    mesh.edges()
        .map(|e| {
            let h = mesh.edge_half_edge(e);
            let Some(g) = mesh.twin(h) else { return false };
            let [n, m] = [h, g].map(|h| normals[mesh.face(h).index()]);
            angle_between(&n, &m) > angle
        })
        .collect()
}

/// Tags every edge at one of whose ends the normals of its two faces differ by more than `tolerance` radians.
///
/// One normal a corner, as files have them: at the origin of each half edge. A normal that is zero or not finite differs from
/// none.
pub fn by_corner_normals(mesh: &HalfEdgeMesh, normals: &[Vec3], tolerance: f64) -> Vec<bool> {
    let differ =
        |a: HalfEdgeId, b: HalfEdgeId| angle_between(&normals[a.index()], &normals[b.index()]) > tolerance;
    mesh.edges()
        .map(|e| {
            let h = mesh.edge_half_edge(e);
            mesh.twin(h).is_some_and(|g| differ(h, mesh.next(g)) || differ(mesh.next(h), g))
        })
        .collect()
}

/// The corners around a vertex, as its outgoing half edges, in runs that no sharp edge cuts; counter-clockwise.
///
/// A single sharp edge ends at an inner vertex without cutting anything off: then there is one sector, the whole
/// [ring](HalfEdgeMesh::ring).
pub fn sectors(mesh: &HalfEdgeMesh, sharp: &[bool], v: VertexId) -> Vec<Vec<HalfEdgeId>> {
    let mut ring: Vec<HalfEdgeId> = mesh.ring(v).collect();
    let cuts = |h: &HalfEdgeId| sharp[mesh.edge(*h).index()];
    if !mesh.is_boundary_vertex(v) {
        if ring.iter().filter(|h| cuts(h)).count() <= 1 {
            return vec![ring];
        }
        let first = ring.iter().position(cuts).unwrap_or(0);
        ring.rotate_left(first);
    }
    let mut sectors: Vec<Vec<HalfEdgeId>> = Vec::new();
    for h in ring {
        match sectors.last_mut() {
            Some(sector) if !cuts(&h) => sector.push(h),
            _ => sectors.push(vec![h]),
        }
    }
    sectors
}

/// Gives every corner the mean of the unit normals of its sector.
///
/// Zero where the sector has no finite normals, or where they cancel.
pub fn sector_means(mesh: &HalfEdgeMesh, sharp: &[bool], normals: &[Vec3]) -> Vec<Vec3> {
    let mut means = vec![Vec3::zeros(); mesh.half_edge_count()];
    for v in mesh.vertices() {
        for sector in sectors(mesh, sharp, v) {
            let finite = |n: &Vec3| n.iter().all(|c| c.is_finite());
            let units = sector.iter().map(|h| normals[h.index()]).filter(finite);
            let sum: Vec3 = units.filter_map(|n| n.try_normalize(0.0)).sum();
            let mean = sum.try_normalize(CANCELLED).unwrap_or_else(Vec3::zeros);
            sector.iter().for_each(|h| means[h.index()] = mean);
        }
    }
    means
}

/// Shorter sums of unit vectors have no direction left.
const CANCELLED: f64 = 1e-12;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::normals::{NormalRule, at_corners};
    use std::f64::consts::FRAC_PI_4;

    /// The unit cube; each side cut in two.
    fn cube() -> (HalfEdgeMesh, Vec<Point3>) {
        let p = (0..8u32).map(|n| Point3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2)));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> =
            quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        (HalfEdgeMesh::from_faces(8, &faces).unwrap(), p.collect())
    }

    #[test]
    fn a_cube_has_twelve_sharp_edges_and_three_normals_a_corner() {
        let (mesh, p) = cube();
        let sharp = by_angle(&mesh, &p, FRAC_PI_4);
        assert_eq!(sharp.iter().filter(|s| **s).count(), 12);
        for rule in [NormalRule::LoopLimit, NormalRule::AngleWeighted, NormalRule::AreaWeighted] {
            let normals = at_corners(&mesh, &p, &sharp, rule);
            for v in mesh.vertices() {
                let sectors = sectors(&mesh, &sharp, v);
                assert_eq!(sectors.len(), 3);
                for sector in sectors {
                    for h in sector {
                        let side = crate::mesh::normals::of_face(&mesh, &p, mesh.face(h));
                        assert!((normals[h.index()] - side).norm() < 1e-15, "{rule:?}");
                    }
                }
            }
            assert_eq!(by_corner_normals(&mesh, &normals, 0.1), sharp);
            assert_eq!(sector_means(&mesh, &sharp, &normals), normals);
        }
    }

    #[test]
    fn one_sharp_edge_cuts_nothing_off() {
        let (mesh, p) = cube();
        let mut sharp = vec![false; mesh.edge_count()];
        let normals = |sharp: &[bool]| at_corners(&mesh, &p, sharp, NormalRule::LoopLimit);
        let smooth = normals(&sharp);
        sharp[0] = true;
        assert_eq!(normals(&sharp), smooth);
        let of_vertices = crate::mesh::normals::loop_limit(&mesh, &p);
        assert!(mesh.half_edges().all(|h| smooth[h.index()] == of_vertices[mesh.origin(h).index()]));
    }
}
