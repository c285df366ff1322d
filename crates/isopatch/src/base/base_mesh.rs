use super::clip::{BoxSides, Clip};
use super::jets::of_jets;
use crate::field::Field;
use crate::geom::{Aabb, Mat3, Point3, Vec3};
use crate::mesh::{EdgeId, HalfEdgeMesh, VertexId};

/// What an edge of a base mesh means for the surface over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeFeature {
    /// The surface is smooth across it.
    Smooth,
    /// The surfaces on both sides meet there with different normals.
    Sharp,
    /// The surface ends there.
    Boundary,
}

/// The input of every surface construction: connectivity with positions, normals, curvature and features.
///
/// Faces are counter-clockwise seen from the outward normal.
#[derive(Clone, Debug)]
pub struct BaseMesh {
    /// Connectivity; all faces are triangles.
    pub mesh: HalfEdgeMesh,
    /// Position of each vertex, on the surface.
    pub positions: Vec<Point3>,
    /// Outward unit normal of each vertex.
    pub normals: Vec<Vec3>,
    /// Curvature tensor M of each vertex, see [`crate::geom::Jet::curvature_tensor`].
    pub curvatures: Vec<Mat3>,
    /// Meaning of each edge.
    pub features: Vec<EdgeFeature>,
    /// How a box cuts it; none if it is closed, or its boundary is not that of a box.
    pub clip: Option<Clip>,
    /// Unit of relative lengths, if it was frozen before the mesh was refined.
    pub frozen_diagonal: Option<f64>,
}

impl BaseMesh {
    /// Takes normals and curvature tensors from the field at the given positions, which are on its surface.
    pub fn from_field(field: &dyn Field, mesh: HalfEdgeMesh, positions: Vec<Point3>) -> Self {
        let known = of_jets(field, &positions, |jet| (jet.gradient.normalize(), jet.curvature_tensor()));
        let (normals, curvatures) = known.into_iter().unzip();
        Self::from_parts(mesh, positions, normals, curvatures)
    }

    /// The sides of the box in which a boundary edge lies: those of both its ends. None of an edge inside.
    pub fn sides_of(&self, edge: EdgeId) -> BoxSides {
        let h = self.mesh.edge_half_edge(edge);
        match (&self.clip, self.mesh.twin(h)) {
            (Some(clip), None) => {
                clip.sides[self.mesh.origin(h).index()].common(clip.sides[self.mesh.dest(h).index()])
            }
            _ => BoxSides::NONE,
        }
    }

    /// The direction in the tangent plane in which the curve over an edge leaves one of its ends, of any length: that of
    /// the chord for an edge inside, that of the section of the surface for an edge in a side of the box.
    pub fn direction(&self, edge: EdgeId, end: VertexId) -> Vec3 {
        let h = self.mesh.edge_half_edge(edge);
        let (from, to) = (self.mesh.origin(h), self.mesh.dest(h));
        let other = if end == from { to } else { from };
        let chord = self.positions[other.index()] - self.positions[end.index()];
        let n = self.normals[end.index()];
        let sides = self.sides_of(edge);
        if sides.is_empty() {
            return chord - chord.dot(&n) * n;
        }
        let along = n.cross(&sides.across());
        chord.dot(&along) * along
    }

    /// Bounding box of the vertices.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(&self.positions)
    }

    /// The unit of relative lengths: the frozen diagonal, or else that of the bounding box of the vertices.
    pub fn diagonal(&self) -> f64 {
        self.frozen_diagonal.unwrap_or_else(|| self.bounds().diagonal())
    }
}
