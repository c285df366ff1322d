//! Points over triangles, whatever their cells are.

use super::sector::SectorTable;
use crate::apatch::grid::{self, FaceTable, GridOut};
use crate::geom::{Point3, Points};
use crate::hybrid::face::{FaceCells, sector_of};
use crate::hybrid::function::HybridFunction;
use crate::mesh::FaceId;

/// Points over triangles, for those with cells of one kind and for those in sectors.
#[derive(Clone, Debug)]
pub struct TriangleTable {
    points: Vec<[f64; 3]>,
    whole: FaceTable,
    /// For the sectors around the centroid: which points are in each, and their table.
    parts: [(Vec<usize>, SectorTable); 3],
}

/// Barycentric coordinates of a center may be off those of the centroid by this for the table to hold; points over it move by
/// as much, in sizes of the triangle.
const CENTROID: f64 = 1e-13;

impl TriangleTable {
    /// For points with the given barycentric coordinates.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let at: Vec<(usize, [f64; 3])> = points.iter().map(|x| sector_of(*x, [1.0 / 3.0; 3])).collect();
        let parts = std::array::from_fn(|k| {
            let inside: Vec<usize> = (0..points.len()).filter(|i| at[*i].0 == k).collect();
            let table = SectorTable::new(&inside.iter().map(|i| at[*i].1).collect::<Vec<_>>());
            (inside, table)
        });
        Self { points: points.to_vec(), whole: FaceTable::new(points), parts }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over a face with three corners, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &HybridFunction, f: FaceId, out: &mut GridOut<'_>) {
        let complete = match &function.faces()[f.index()] {
            FaceCells::Triangle { function: cells, free } => {
                self.evaluate_whole(function, f, (cells, *free), out)
            }
            FaceCells::Sectors(sectors) => {
                let center = function.center_in_triangle(f, &sectors.center);
                let near = center.iter().all(|x| (x - 1.0 / 3.0).abs() <= CENTROID);
                if near { self.evaluate_parts(function, f, out) } else { self.clear(out) }
            }
            FaceCells::Flat(_) | FaceCells::Pyramid(_) => self.clear(out),
        };
        if !complete {
            out.complete(self.len(), |i| function.shoot_face(f, [self.points[i][0], self.points[i][1]]));
        }
    }

    fn evaluate_whole(
        &self,
        function: &HybridFunction,
        f: FaceId,
        (cells, free): (&crate::apatch::FaceFunction, [f64; 2]),
        out: &mut GridOut<'_>,
    ) -> bool {
        let Some(corners) = function.corners(f).first_chunk() else { return self.clear(out) };
        let face = &function.hull().faces[f.index()];
        let (class, corners, apexes) = (face.class, *corners, face.apexes);
        let cells = grid::FaceCells { class, corners, apexes, function: cells, free };
        self.whole.evaluate_cells(&cells, out)
    }

    fn evaluate_parts(&self, function: &HybridFunction, f: FaceId, out: &mut GridOut<'_>) -> bool {
        for (k, (inside, table)) in self.parts.iter().enumerate() {
            let (mut points, mut normals) = (Points::zeros(inside.len()), Points::zeros(inside.len()));
            let wanted = out.normals.is_some();
            let mut part = GridOut { points: points.view_mut(), normals: wanted.then(|| normals.view_mut()) };
            table.evaluate(function, f, k, &mut part);
            inside.iter().enumerate().for_each(|(n, i)| out.set(*i, points.get(n), normals.get(n)));
        }
        true
    }

    fn clear(&self, out: &mut GridOut<'_>) -> bool {
        let nan = Point3::repeat(f64::NAN);
        (0..self.len()).for_each(|i| out.set(i, nan, nan));
        false
    }
}
