//! Local subdivision by the Butterfly scheme (Dyn, Levin & Gregory 1990): some edges of a triangle mesh are divided at points of a
//! smooth surface through its vertices.

use super::half_edge::{EdgeId, HalfEdgeId, HalfEdgeMesh};
use crate::geom::Point3;

/// Weight of the four vertices across from the two triangles of an edge, with tension 1/16; those of the ends are ½, those of the
/// vertices opposite to the edge twice this.
const WING: f64 = 1.0 / 16.0;

/// A mesh with some edges divided.
#[derive(Clone, Debug, PartialEq)]
pub struct Divided {
    /// The vertices; the new ones come last, in the order of their edges.
    pub positions: Vec<Point3>,
    /// The triangles, those of one old triangle after each other.
    pub faces: Vec<[u32; 3]>,
    /// The old triangle of each.
    pub source: Vec<u32>,
}

/// Divides edges of a triangle mesh. An old triangle becomes as many as it has divided edges, and one more. Linear time.
pub fn divide(mesh: &HalfEdgeMesh, positions: &[Point3], edges: &[EdgeId]) -> Divided {
    let mut middle = vec![None; mesh.edge_count()];
    let mut divided = Divided { positions: positions.to_vec(), faces: Vec::new(), source: Vec::new() };
    for e in edges {
        if middle[e.index()].is_none() {
            middle[e.index()] = Some(divided.positions.len() as u32);
            divided.positions.push(point(mesh, positions, *e));
        }
    }
    for f in mesh.faces() {
        let corners = mesh.triangle(f).map(|v| v.0);
        let mut middles = [None; 3];
        mesh.face_half_edges(f).zip(&mut middles).for_each(|(h, m)| *m = middle[mesh.edge(h).index()]);
        for face in pieces(corners, middles) {
            divided.faces.push(face);
            divided.source.push(f.0);
        }
    }
    divided
}

/// The point of the scheme over an edge. On the border, and where a triangle beside it is missing, the missing vertices are those
/// that continue the mesh as a parallelogram does, so that planes stay planes.
fn point(mesh: &HalfEdgeMesh, positions: &[Point3], e: EdgeId) -> Point3 {
    let h = mesh.edge_half_edge(e);
    let at = |h: HalfEdgeId| positions[mesh.origin(h).index()];
    let [a, b] = [at(h), positions[mesh.dest(h).index()]];
    let middle = 0.5 * (a + b);
    // On one side of the edge: the opposite vertex, and the two across the other edges.
    let side = |h: HalfEdgeId| {
        let (next, previous) = (mesh.next(h), mesh.prev(h));
        let across = |h: HalfEdgeId| mesh.twin(h).map(|twin| at(mesh.prev(twin)));
        (at(previous), [across(next), across(previous)])
    };
    let [first, second] = [Some(h), mesh.twin(h)].map(|h| h.map(side));
    let (Some((c, c_wings)), Some((d, d_wings))) = (first, second) else { return middle };
    // A wing beyond an edge from the end p to the opposite vertex o, away from the end q, is p + o − q in a parallelogram.
    let wings =
        [(c_wings[0], b + c - a), (c_wings[1], a + c - b), (d_wings[0], a + d - b), (d_wings[1], b + d - a)];
    let sum: Point3 = wings.iter().map(|(wing, continued)| wing.unwrap_or(*continued)).sum();
    middle + 2.0 * WING * (c + d) - WING * sum
}

/// A triangle by its corners and the new vertices on its edges, the first of them from the first corner to the second.
fn pieces([a, b, c]: [u32; 3], middles: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    match middles {
        [None, None, None] => vec![[a, b, c]],
        [Some(m), None, None] => vec![[a, m, c], [m, b, c]],
        [Some(m), Some(n), None] => vec![[m, b, n], [a, m, n], [a, n, c]],
        [Some(m), Some(n), Some(o)] => vec![[m, n, o], [a, m, o], [b, n, m], [c, o, n]],
        // The same, beginning at another corner.
        [None, ..] | [Some(_), None, Some(_)] => pieces([b, c, a], [middles[1], middles[2], middles[0]]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of squares, each cut into two triangles.
    fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> (HalfEdgeMesh, Vec<Point3>) {
        let places = (0..=n).flat_map(|i| (0..=n).map(move |j| (f64::from(i), f64::from(j))));
        let positions: Vec<Point3> = places.map(|(x, y)| Point3::new(x, y, height(x, y))).collect();
        let at = |i: u32, j: u32| i * (n + 1) + j;
        let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let faces: Vec<[u32; 3]> = squares
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        (HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap(), positions)
    }

    /// The scheme reproduces polynomials of degree 3 on a regular mesh.
    #[test]
    fn points_over_a_regular_mesh_are_on_cubics() {
        let cubic = |x: f64, y: f64| {
            1.0 + x - 2.0 * y + 0.3 * x * y + 0.1 * (x * x * x - x * y * y) + 0.2 * y * y * y
        };
        let (mesh, positions) = grid(6, cubic);
        let inner = |e: &EdgeId| {
            let h = mesh.edge_half_edge(*e);
            [mesh.origin(h), mesh.dest(h)].iter().all(|v| {
                let p = positions[v.index()];
                [p.x, p.y].iter().all(|t| (2.0..=4.0).contains(t))
            })
        };
        let edges: Vec<EdgeId> = mesh.edges().filter(inner).collect();
        let divided = divide(&mesh, &positions, &edges);
        assert!(edges.len() > 8);
        for p in &divided.positions[positions.len()..] {
            assert!((p.z - cubic(p.x, p.y)).abs() < 1e-13, "{p:?}");
        }
    }

    #[test]
    fn planes_stay_planes_at_the_border_as_well() {
        let (mesh, positions) = grid(2, |x, y| 0.5 * x - y);
        let divided = divide(&mesh, &positions, &mesh.edges().collect::<Vec<_>>());
        assert!(divided.positions.iter().all(|p| (p.z - 0.5 * p.x + p.y).abs() < 1e-14));
    }

    #[test]
    fn a_triangle_with_k_divided_edges_becomes_k_more_and_the_mesh_stays_one() {
        let (mesh, positions) = grid(3, |x, y| x * y);
        let all: Vec<EdgeId> = mesh.edges().collect();
        for step in 1..5 {
            let edges: Vec<EdgeId> = all.iter().copied().step_by(step).collect();
            let divided = divide(&mesh, &positions, &edges);
            let halves: usize =
                edges.iter().map(|e| if mesh.twin(mesh.edge_half_edge(*e)).is_some() { 2 } else { 1 }).sum();
            assert_eq!(divided.faces.len(), mesh.face_count() + halves);
            assert_eq!(divided.source.len(), divided.faces.len());
            let finer = HalfEdgeMesh::from_faces(divided.positions.len(), &divided.faces).unwrap();
            assert_eq!(finer.euler_number(), mesh.euler_number());
            assert_eq!(finer.boundary_loop_count(), 1);
        }
    }
}
