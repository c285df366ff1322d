//! Points of a field's zero set, found without any surface: where it crosses the edges of a grid.

use crate::field::Field;
use crate::geom::{Aabb, Point3, Points};
use rayon::prelude::*;

/// Cells along one side of a brick; a brick is evaluated in one batch, and skipped if the field has no zero in it.
const BRICK: usize = 16;
/// Halvings of a grid edge: 2⁻⁴⁵ of an edge is rounding error of the coordinates.
const HALVINGS: usize = 45;
/// |f| after all halvings, relative to the edge's scale, for a zero. A root of power 1/4 falls to 4e-4, a jump or a
/// pole does not fall.
const ZERO: f64 = 1e-3;

/// A grid of cubes (nearly) over a box.
struct Grid {
    origin: Point3,
    cell: Point3,
    cells: [usize; 3],
}

impl Grid {
    fn new(region: &Aabb, cell: f64) -> Self {
        let cells = [0, 1, 2].map(|a| (region.size()[a] / cell).ceil().max(1.0) as usize);
        let cell = Point3::from_fn(|a, _| region.size()[a] / cells[a] as f64);
        Self { origin: region.min, cell, cells }
    }

    fn vertex(&self, at: [usize; 3]) -> Point3 {
        Point3::from_fn(|a, _| self.origin[a] + at[a] as f64 * self.cell[a])
    }
}

/// Where the zero set of `field` crosses the edges of a grid of about `cell`-sized cells over `region`, in grid order.
///
/// Sign changes at poles are not zeros and are left out. Parts of the zero set that are smaller than a cell, or
/// that the field touches without changing sign, may be missed. The region's sizes and `cell` are positive.
pub fn zeros(field: &dyn Field, region: &Aabb, cell: f64) -> Vec<Point3> {
    let grid = Grid::new(region, cell);
    let [nx, ny, nz] = grid.cells.map(|n| n.div_ceil(BRICK));
    let found: Vec<Vec<Point3>> = (0..nx * ny * nz)
        .into_par_iter()
        .map(|b| brick_zeros(field, &grid, [b % nx, b / nx % ny, b / (nx * ny)].map(|i| i * BRICK)))
        .collect();
    found.concat()
}

/// Zeros on the grid edges that start at a vertex of the brick whose first vertex is `first`.
fn brick_zeros(field: &dyn Field, grid: &Grid, first: [usize; 3]) -> Vec<Point3> {
    let last = [0, 1, 2].map(|a| (first[a] + BRICK).min(grid.cells[a]));
    let range = field.range(&Aabb::new(grid.vertex(first), grid.vertex(last)));
    if range.lo > 0.0 || range.hi < 0.0 {
        return Vec::new();
    }
    let [sx, sy, sz] = [0, 1, 2].map(|a| last[a] - first[a] + 1);
    let at = |n: usize| [n % sx, n / sx % sy, n / (sx * sy)];
    let vertex = |n: usize| grid.vertex([0, 1, 2].map(|a| first[a] + at(n)[a]));
    let points: Points = (0..sx * sy * sz).map(vertex).collect();
    let mut f = vec![0.0; points.len()];
    field.values(points.view(), &mut f);
    let mut brackets = Brackets::default();
    for n in 0..points.len() {
        let [i, j, k] = at(n);
        // Edges on the far sides belong to the next brick.
        if i + 1 < sx && j + 1 < sy && k + 1 < sz {
            for m in [n + 1, n + sx, n + sx * sy] {
                brackets.add([n, m].map(|i| (points.get(i), f[i])));
            }
        }
    }
    brackets.bisect(field)
}

/// Segments with a point where f < 0 and one where f ≥ 0.
#[derive(Default)]
struct Brackets {
    negative: Points,
    positive: Points,
    /// |f| at these two points.
    sizes: Vec<[f64; 2]>,
}

impl Brackets {
    /// Takes the segment if f changes sign on it.
    fn add(&mut self, [a, b]: [(Point3, f64); 2]) {
        let (negative, positive) = if a.1 < 0.0 { (a, b) } else { (b, a) };
        if negative.1 < 0.0 && positive.1 >= 0.0 {
            self.negative.push(negative.0);
            self.positive.push(positive.0);
            self.sizes.push([-negative.1, positive.1]);
        }
    }

    /// The zeros between, by bisection; not those where |f| does not fall, which are poles or jumps.
    fn bisect(mut self, field: &dyn Field) -> Vec<Point3> {
        let n = self.sizes.len();
        let (mut middle, mut f) = (Points::zeros(n), vec![0.0; n]);
        let mut scale = Vec::new();
        for _ in 0..HALVINGS {
            for i in 0..n {
                middle.set(i, 0.5 * (self.negative.get(i) + self.positive.get(i)));
            }
            field.values(middle.view(), &mut f);
            if scale.is_empty() {
                scale = self.sizes.iter().zip(&f).map(|([a, b], f)| median([*a, *b, f.abs()])).collect();
            }
            for i in 0..n {
                let side = if f[i] < 0.0 { &mut self.negative } else { &mut self.positive };
                side.set(i, middle.get(i));
            }
        }
        (0..n).filter(|i| f[*i].abs() <= ZERO * scale[*i]).map(|i| middle.get(i)).collect()
    }
}

/// The middle one: the size of f on an edge, from its ends and its midpoint, even if one of them is on a zero or pole.
fn median(mut values: [f64; 3]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[1]
}
