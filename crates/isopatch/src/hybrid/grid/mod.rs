//! Many points of a patch at once, see [`apatch::grid`](crate::apatch::grid): factors of the coefficients are tabulated for fixed
//! parameters, and points are computed in vector lanes.

mod pyramid;
mod sector;
mod triangle;

pub use pyramid::PyramidTable;
pub use sector::SectorTable;
pub use triangle::TriangleTable;

use super::function::HybridFunction;
use crate::apatch::grid::{EdgeCells, EdgeTable, GridOut};
use crate::hull::Side;
use crate::mesh::EdgeId;

impl HybridFunction {
    /// Points of the patch over an edge that has cells, and normals, at the parameters of a table; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate_edge(&self, table: &EdgeTable, points: &[[f64; 3]], e: EdgeId, out: &mut GridOut<'_>) {
        let sides = Side::BOTH.map(|side| {
            let [u_l, _, _, u_k] = self.edge_cell(e, side)?;
            Some(([u_l, u_k], *self.edge_function(e, side)?))
        });
        let cells = EdgeCells { class: self.hull().edges[e.index()].class, ends: self.ends(e), sides };
        if !table.evaluate_cells(&cells, out) {
            out.complete(table.len(), |i| self.shoot_edge(e, [points[i][0], points[i][1]], points[i][2]));
        }
    }
}
