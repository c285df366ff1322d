//! Triangles over points, before they become a base mesh.

use std::collections::HashSet;

use super::clip::Clip;
use crate::geom::{Point3, Vec3};

/// Triangles over points; faces are counter-clockwise seen from outside (f > 0).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub positions: Vec<Point3>,
    /// Corners of each face.
    pub faces: Vec<[u32; 3]>,
    /// How a box cuts it; none if it is closed.
    pub clip: Option<Clip>,
}

impl TriangleMesh {
    /// Vertices − edges + faces of a manifold mesh without isolated vertices.
    pub fn euler_number(&self) -> i64 {
        let boundary = self.boundary_edge_count() as i64;
        let edges = (3 * self.faces.len() as i64 + boundary) / 2;
        self.positions.len() as i64 - edges + self.faces.len() as i64
    }

    /// Number of edges with a face on one side only.
    pub fn boundary_edge_count(&self) -> usize {
        if self.clip.is_none() {
            return 0;
        }
        let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
        let edges: HashSet<[u32; 2]> = self.faces.iter().flat_map(sides).collect();
        edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a])).count()
    }

    /// Number of connected components.
    pub fn component_count(&self) -> usize {
        let mut parent: Vec<u32> = (0..self.positions.len() as u32).collect();
        let mut count = parent.len();
        for [a, b, c] in &self.faces {
            for other in [b, c] {
                let (r, s) = (root(&mut parent, *a), root(&mut parent, *other));
                if r != s {
                    parent[r.max(s) as usize] = r.min(s);
                    count -= 1;
                }
            }
        }
        count
    }

    /// Twice the area of a face times its normal.
    pub fn area_vector(&self, face: [u32; 3]) -> Vec3 {
        let [a, b, c] = face.map(|v| self.positions[v as usize]);
        (b - a).cross(&(c - a))
    }
}

/// Representative of a union-find set, with path halving.
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}
