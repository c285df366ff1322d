//! Value and gradient of the function in a given cell.

use super::build::APatchFunction;
use super::shoot::gradient;
use crate::geom::{Point3, Vec3};
use crate::hull::Side;
use crate::mesh::{EdgeId, FaceId};

impl APatchFunction {
    /// Corners of the cell of a face on a side: those of the face, then the apex.
    pub fn face_cell(&self, f: FaceId, side: Side) -> Option<[Point3; 4]> {
        let [a, b, c] = self.hull().data().corners(f);
        Some([a, b, c, self.hull().faces()[f.index()].apexes[side.index()]?])
    }

    /// Corners of the cell of an edge on a side: the apex of the right face, start and end, the apex of the left face.
    pub fn edge_cell(&self, e: EdgeId, side: Side) -> Option<[Point3; 4]> {
        let (mesh, positions) = (self.hull().data().mesh(), self.hull().data().positions());
        self.hull().edges()[e.index()].cells[side.index()]?;
        let [u_k, u_l] = self.hull().edge_apexes(e, side)?;
        let h = mesh.edge_half_edge(e);
        Some([u_l, positions[mesh.origin(h).index()], positions[mesh.dest(h).index()], u_k])
    }

    /// Value and gradient of the function at barycentric coordinates of the cell of a face; none if it has none on that side.
    pub fn in_face_cell(&self, f: FaceId, side: Side, x: [f64; 4]) -> Option<(f64, Vec3)> {
        let (corners, s) = (self.face_cell(f, side)?, side.sign());
        let face = &self.faces()[f.index()];
        let (base, base_d) = face.base.value([x[0], x[1], x[2]]);
        let b = self.free()[f.index()][side.index()];
        let (value, d) = face.sides[side.index()]?.value(b, (s * base, base_d.map(|d| s * d)), x);
        Some((s * value, s * gradient(&corners, d)))
    }

    /// Value and gradient of the function at barycentric coordinates of the cell of an edge; none if it has none on that side.
    pub fn in_edge_cell(&self, e: EdgeId, side: Side, x: [f64; 4]) -> Option<(f64, Vec3)> {
        let corners = self.edge_cell(e, side)?;
        let (value, d) = self.edge_function(e, side)?.value(x);
        Some((side.sign() * value, side.sign() * gradient(&corners, d)))
    }
}
