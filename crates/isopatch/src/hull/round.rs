//! Rounding: a mesh with more faces around vertices that hardly see theirs, in which they see them well.
//!
//! ```text
//!        v                    v                 A vertex in the rim of a fold sees the faces on both of its sides under an angle
//!       /|               m_0─────m_2            near zero, and so does every point on its edges: to cut faces in their planes
//!      / |      ──►      /│     │\              does not help. Here the new vertices leave the mesh: they go around the vertex
//!     /  |              / │     │ \             in one turn and then move until it, they and all that they are connected with
//!   w_0  w_2          w_0 ┘     └ w_2           see their faces well.
//! ```
//!
//! The vertices that there were stay where they are, so that the surface interpolates them all the same.

use super::build::built;
use super::hermite::HermiteMesh;
use super::options::{ApexRule, RobustApexes};
use super::refine::{self, HARDLY_SEEN, Refined, Refinement, Way};
use super::repair;
use super::simplicial_hull::Hull;
use super::visibility::most_visible_direction;
use crate::geom::{Point3, Vec3};
use crate::mesh::{HalfEdgeId, HalfEdgeMesh, VertexId, normals};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Least product of a normal with those of the faces around it that new vertices move for, and the one below which a vertex beside
/// them is rounded as well.
const WELL_SEEN: f64 = 0.6;
const STILL_HARDLY_SEEN: f64 = 0.5 * WELL_SEEN;

/// Distances of new vertices from the normal of their vertex at the beginning, relative to those from the vertex. From each they end
/// in another minimum, and not over every one a hull without corners was found.
const STARTS: [f64; 3] = [0.2, 0.1, 0.3];

/// Steps of new vertices, relative to the shortest edge there: at first and at last, and the most rounds of them.
const FIRST_STEP: f64 = 0.25;
const LAST_STEP: f64 = 1e-3;
const ROUNDS: usize = 100;

/// Turns of the edges around a normal above which they go around it more than once, and hide each other.
const ONE_TURN: f64 = 1.5;

impl Hull {
    /// Hulls of the given mesh rounded at vertices that became corners although a direction sees the faces around them, see
    /// [`Hull::rounded_vertices`]: some to choose from, or none if there are no such vertices or that is not wanted.
    ///
    /// A corner that is seen well is one because of its neighbours, and is left as it is.
    pub fn rounded(&self) -> impl Iterator<Item = Self> + '_ {
        let is_wanted = matches!(self.options.rule, ApexRule::Robust(RobustApexes { rounding: true, .. }));
        let given = self.refinement.given.as_ref().filter(|_| is_wanted);
        given.into_iter().flat_map(move |given| {
            let vertices = self.hardly_seen_corners(given);
            STARTS.into_iter().filter_map(move |start| self.rounded_from(given, vertices.clone(), start))
        })
    }

    fn hardly_seen_corners(&self, given: &HermiteMesh) -> Vec<VertexId> {
        let is_old = |v: &VertexId| v.index() < given.positions().len();
        let corners = self.corners.iter().map(|corner| corner.vertex).filter(is_old);
        let is_hardly_seen = |v: &VertexId| {
            let product = repair::best_visibility(given, *v);
            product > 0.0 && product < HARDLY_SEEN && is_smooth(given, *v)
        };
        corners.filter(is_hardly_seen).collect()
    }

    fn rounded_from(
        &self,
        given: &Arc<HermiteMesh>,
        mut vertices: Vec<VertexId>,
        start: f64,
    ) -> Option<Self> {
        let mut rounding = Rounding::around(given, &vertices, start)?;
        let more = rounding.hardly_seen();
        if !more.is_empty() {
            vertices.extend(more.into_iter().filter(|v| is_smooth(given, *v)));
            vertices.sort_unstable();
            vertices.dedup();
            rounding = Rounding::around(given, &vertices, start)?;
        }
        let (farthest, count) = (rounding.farthest(), given.positions().len());
        let Refined { data, face_source, vertex_source, .. } = rounding.finish()?;
        let given = Some(Arc::clone(given));
        let mut refinement = Refinement { given, rounded: vertices, farthest, ..Refinement::default() };
        refinement.extend(&[], &face_source, &vertex_source, count);
        Some(built(data, &self.options, refinement))
    }
}

/// Is a vertex inside the mesh, and on no crease?
fn is_smooth(data: &HermiteMesh, v: VertexId) -> bool {
    let mesh = data.mesh();
    !mesh.is_boundary_vertex(v) && !mesh.ring(v).any(|h| data.is_crease(mesh.edge(h)))
}

/// The direction that sees the faces around a vertex best, and the least product with their normals; −1 where they go around that
/// direction more than once: then some hide others.
fn best_product(mesh: &HalfEdgeMesh, positions: &[Point3], v: VertexId) -> (Vec3, f64) {
    let around: Vec<Vec3> = mesh.ring(v).map(|h| normals::of_face(mesh, positions, mesh.face(h))).collect();
    let (n, product) = most_visible_direction(&around).unwrap_or((Vec3::z(), -1.0));
    let turned = |h: HalfEdgeId| {
        let ends = [mesh.dest(h), mesh.origin(mesh.prev(h))];
        let [a, b] = ends.map(|w| positions[w.index()] - positions[v.index()]);
        let (along_a, along_b) = (n.dot(&a), n.dot(&b));
        n.dot(&a.cross(&b)).atan2(a.dot(&b) - along_a * along_b)
    };
    let turns = mesh.ring(v).map(turned).sum::<f64>() / TAU;
    (n, if turns > ONE_TURN { -1.0 } else { product })
}

/// A mesh with corners of faces cut off, whose new vertices move.
struct Rounding<'a> {
    given: &'a HermiteMesh,
    flat: Refined,
    positions: Vec<Point3>,
}

impl<'a> Rounding<'a> {
    /// None without vertices, or where cutting leaves faces without area.
    fn around(given: &'a HermiteMesh, vertices: &[VertexId], start: f64) -> Option<Self> {
        if vertices.is_empty() {
            return None;
        }
        let flat = refine::cut_corners(given, vertices, Way::AtPart)?;
        let positions = flat.data.positions().to_vec();
        let mut rounding = Self { given, flat, positions };
        vertices.iter().for_each(|v| rounding.spread(*v, start));
        rounding.descend();
        Some(rounding)
    }

    fn new_vertices(&self) -> impl Iterator<Item = VertexId> + use<> {
        (self.given.positions().len()..self.positions.len()).map(VertexId::from)
    }

    /// Puts the new vertices around a vertex evenly around its best seen direction, in one turn, as high as they are.
    fn spread(&mut self, v: VertexId, start: f64) {
        let mesh = self.flat.data.mesh();
        let (n, _) = best_product(mesh, &self.positions, v);
        let at = self.positions[v.index()];
        let ring: Vec<usize> = mesh.ring(v).map(|h| mesh.dest(h).index()).collect();
        let edges: Vec<Vec3> = ring.iter().map(|w| self.positions[*w] - at).collect();
        let Some(x) = edges.first().and_then(|e| (e - n.dot(e) * n).try_normalize(0.0)) else { return };
        let y = n.cross(&x);
        let even = |k: usize| TAU * k as f64 / ring.len() as f64;
        // The rotation that leaves the edges closest to where they are.
        let off = edges.iter().enumerate().map(|(k, e)| y.dot(e).atan2(x.dot(e)) - even(k));
        let (sin, cos) = off.map(f64::sin_cos).fold((0.0, 0.0), |sum, (s, c)| (sum.0 + s, sum.1 + c));
        let rotation = f64::atan2(sin, cos);
        for (k, (w, e)) in ring.iter().zip(&edges).enumerate() {
            let (sin, cos) = (rotation + even(k)).sin_cos();
            self.positions[*w] = at + n.dot(e) * n + start * e.norm() * (cos * x + sin * y);
        }
    }

    /// What a vertex lacks to be seen well.
    fn lack(&self, v: VertexId) -> f64 {
        (WELL_SEEN - best_product(self.flat.data.mesh(), &self.positions, v).1).max(0.0).powi(2)
    }

    /// The vertices of the faces around a vertex.
    fn near(&self, v: VertexId) -> Vec<VertexId> {
        let mesh = self.flat.data.mesh();
        let mut near: Vec<VertexId> = mesh.ring(v).flat_map(|h| mesh.triangle(mesh.face(h))).collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Moves new vertices, one after the other, along their best seen direction and across it while that makes the squares of what is
    /// lacking around them less.
    fn descend(&mut self) {
        let mut step = FIRST_STEP;
        for _ in 0..ROUNDS {
            let moved = self.new_vertices().filter(|v| self.improve(*v, step)).count();
            if moved == 0 {
                step *= 0.5;
            }
            if step < LAST_STEP {
                break;
            }
        }
    }

    fn improve(&mut self, v: VertexId, step: f64) -> bool {
        let (mesh, near) = (self.flat.data.mesh(), self.near(v));
        let edges: Vec<Vec3> =
            mesh.ring(v).map(|h| self.positions[mesh.dest(h).index()] - self.positions[v.index()]).collect();
        let size = step * edges.iter().map(Vec3::norm).fold(f64::INFINITY, f64::min);
        let (n, _) = best_product(mesh, &self.positions, v);
        let Some(x) = edges.first().and_then(|e| n.cross(e).try_normalize(0.0)) else { return false };
        let y = n.cross(&x);
        let lack = |rounding: &Self| near.iter().map(|w| rounding.lack(*w)).sum::<f64>();
        let mut least = lack(self);
        let mut better = false;
        for direction in [n, -n, x, -x, y, -y] {
            let before = self.positions[v.index()];
            self.positions[v.index()] += size * direction;
            let now = lack(self);
            if now < least {
                least = now;
                better = true;
            } else {
                self.positions[v.index()] = before;
            }
        }
        better
    }

    /// Vertices of the given mesh beside new ones that still hardly see their faces.
    fn hardly_seen(&self) -> Vec<VertexId> {
        let mut near: Vec<VertexId> = self.new_vertices().flat_map(|v| self.near(v)).collect();
        near.sort_unstable();
        near.dedup();
        let product = |v: &VertexId| best_product(self.flat.data.mesh(), &self.positions, *v).1;
        let is_given = |v: &VertexId| v.index() < self.given.positions().len();
        near.retain(|v| is_given(v) && product(v) < STILL_HARDLY_SEEN);
        near
    }

    /// Largest distance of a new vertex from the edge that it was on, or from its place if it was on none, which is at least that from
    /// the mesh.
    fn farthest(&self) -> f64 {
        let at = |v: VertexId| self.given.positions()[v.index()];
        let distance = |(v, [a, b]): (VertexId, &[VertexId; 2])| {
            let p = self.positions[v.index()];
            if a == b {
                return (p - self.flat.data.positions()[v.index()]).norm();
            }
            let edge = at(*b) - at(*a);
            let along = ((p - at(*a)).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            (p - at(*a) - along * edge).norm()
        };
        self.new_vertices().zip(&self.flat.vertex_source).map(distance).fold(0.0, f64::max)
    }

    /// The mesh with the vertices where they are, and at new ones the normals that see their faces best.
    fn finish(self) -> Option<Refined> {
        let (flat, mesh) = (&self.flat.data, self.flat.data.mesh());
        let mut gradients: Vec<Vec3> = mesh.half_edges().map(|h| flat.gradient(h)).collect();
        for v in self.new_vertices() {
            let (n, _) = best_product(mesh, &self.positions, v);
            let corners: Vec<usize> = mesh.ring(v).map(HalfEdgeId::index).collect();
            let length = corners.iter().map(|h| gradients[*h].norm()).sum::<f64>() / corners.len() as f64;
            corners.iter().for_each(|h| gradients[*h] = length * n);
        }
        let sharp = mesh.edges().map(|e| flat.is_crease(e)).collect();
        let data = HermiteMesh::with_creases(mesh.clone(), self.positions, gradients, sharp).ok()?;
        Some(Refined { data, ..self.flat })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn hermite(positions: Vec<Point3>, faces: &[[u32; 3]]) -> HermiteMesh {
        let mesh = HalfEdgeMesh::from_faces(positions.len(), faces).unwrap();
        let gradients: Vec<Vec3> = positions.iter().map(|p| p + 1e-3 * Vec3::z()).collect();
        HermiteMesh::new(mesh, positions, &gradients).unwrap()
    }

    #[test]
    fn tips_of_a_flat_tetrahedron_see_their_faces_once_rounded() {
        let p =
            [[-1.0, 0.02, 0.0], [1.0, 0.02, 0.0], [0.0, -0.02, 1.0], [0.0, -0.02, -1.0]].map(Point3::from);
        let data = hermite(p.to_vec(), &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        let vertices: Vec<VertexId> = data.mesh().vertices().collect();
        let before = |v: &VertexId| best_product(data.mesh(), &p, *v).1;
        assert!(vertices.iter().all(|v| before(v) > 0.0 && before(v) < HARDLY_SEEN));
        let rounding = Rounding::around(&data, &vertices, STARTS[0]).unwrap();
        assert!(rounding.hardly_seen().is_empty());
        let (farthest, shortest_edge) = (rounding.farthest(), 2f64.sqrt());
        assert!(farthest > 0.01 && farthest < shortest_edge, "{farthest}");
        let Refined { data, .. } = rounding.finish().unwrap();
        assert_eq!(data.positions()[..4], p);
        for v in data.mesh().vertices() {
            let (_, product) = best_product(data.mesh(), data.positions(), v);
            assert!(product > STILL_HARDLY_SEEN, "{v:?}: {product}");
        }
    }

    /// From above, a cone over a pentagram shows all its faces, one behind the other.
    #[test]
    fn faces_that_go_around_twice_hide_each_other() {
        let rim = |k: u32, turns: f64| {
            let (sin, cos) = (TAU * turns * f64::from(k) / 5.0).sin_cos();
            Point3::new(cos, sin, -0.5)
        };
        let faces = [0, 1, 2, 3, 4].map(|k| [5, k, (k + 1) % 5]);
        for (turns, is_seen) in [(1.0, true), (2.0, false)] {
            let p: Vec<Point3> = (0..5).map(|k| rim(k, turns)).chain([Point3::zeros()]).collect();
            let data = hermite(p, &faces);
            let product = |v| best_product(data.mesh(), data.positions(), v).1;
            assert!(repair::best_visibility(&data, VertexId(5)) > 0.5);
            assert_eq!(product(VertexId(5)) > 0.5, is_seen);
        }
    }
}
