//! Points of a field's zero set, found without any surface: where it crosses the edges of a grid.

use crate::field::Field;
use crate::geom::{Aabb, Point3, Points};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Cells along one side of a brick; a brick is evaluated in one batch, and skipped if the field has no zero in it.
const BRICK: usize = 16;
/// Steps of false position, after which smooth fields are at their zeros; then halvings of what is left.
const SECANTS: usize = 12;
/// Halvings of a grid edge, at most: 2⁻⁴⁵ of an edge is rounding error of the coordinates.
const HALVINGS: usize = 45;
/// A step below this share of the edge is the last.
const LAST_STEP: f64 = 1.0 / (1u64 << HALVINGS) as f64;
/// |f| after the last step, relative to the edge's scale, for a zero. A root of power 1/4 falls to 4e-4, a jump or a
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
        .evenly()
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
    let mut points = Points::with_capacity(sx * sy * sz);
    for (k, j) in (0..sz).flat_map(|k| (0..sy).map(move |j| (k, j))) {
        (0..sx).for_each(|i| points.push(grid.vertex([first[0] + i, first[1] + j, first[2] + k])));
    }
    let mut f = vec![0.0; points.len()];
    field.values(points.view(), &mut f);
    let mut brackets = Brackets::default();
    // Edges on the far sides belong to the next brick.
    for (k, j) in (0..sz - 1).flat_map(|k| (0..sy - 1).map(move |j| (k, j))) {
        let row = sx * (j + sy * k);
        for n in row..row + sx - 1 {
            for m in [n + 1, n + sx, n + sx * sy].into_iter().filter(|m| (f[n] < 0.0) != (f[*m] < 0.0)) {
                brackets.add([n, m].map(|i| (points.get(i), f[i])));
            }
        }
    }
    brackets.close_in(field)
}

/// Segments from a point where f < 0 to one where f ≥ 0.
#[derive(Default)]
struct Brackets {
    negative: Points,
    positive: Points,
    /// f at these two points.
    ends: Vec<[f64; 2]>,
}

impl Brackets {
    /// Takes the segment if f changes sign on it.
    fn add(&mut self, [a, b]: [(Point3, f64); 2]) {
        let (negative, positive) = if a.1 < 0.0 { (a, b) } else { (b, a) };
        if negative.1 < 0.0 && positive.1 >= 0.0 {
            self.negative.push(negative.0);
            self.positive.push(positive.0);
            self.ends.push([negative.1, positive.1]);
        }
    }

    /// The point at a share of the way.
    fn at(&self, i: usize, share: f64) -> Point3 {
        self.negative.get(i) + share * (self.positive.get(i) - self.negative.get(i))
    }

    /// The zeros between; not those where |f| does not fall, which are poles or jumps.
    fn close_in(self, field: &dyn Field) -> Vec<Point3> {
        let mut roots: Vec<Bracket> = self.ends.iter().map(|f| Bracket::new(*f)).collect();
        let mut open: Vec<usize> = (0..roots.len()).collect();
        let (mut points, mut f) = (Points::with_capacity(roots.len()), Vec::with_capacity(roots.len()));
        for round in 0..SECANTS + HALVINGS {
            if open.is_empty() {
                break;
            }
            open.iter().for_each(|i| roots[*i].step(round));
            points.clear();
            open.iter().for_each(|i| points.push(self.at(*i, roots[*i].t)));
            f.resize(open.len(), 0.0);
            field.values(points.view(), &mut f);
            let mut values = f.iter();
            open.retain(|i| values.next().is_some_and(|f| roots[*i].narrow(*f, round)));
        }
        let found = |i: &usize| roots[*i].f.abs() <= ZERO * roots[*i].scale;
        (0..roots.len()).filter(found).map(|i| self.at(i, roots[i].t)).collect()
    }
}

/// A zero between two shares of a segment: by Illinois's false position, then by bisection.
struct Bracket {
    ends: [f64; 2],
    /// f at the ends, halved where an end has stayed.
    weights: [f64; 2],
    /// Where f was evaluated last, and what it was.
    t: f64,
    f: f64,
    last_step: f64,
    /// The size of f on the segment: the middle one of its ends and the first point between, even if one of them is on a zero
    /// or a pole.
    scale: f64,
}

impl Bracket {
    fn new(f: [f64; 2]) -> Self {
        Self { ends: [0.0, 1.0], weights: f, t: 0.0, f: f[0], last_step: 1.0, scale: 0.0 }
    }

    /// Moves t on. The first step goes to the middle, which tells the scale.
    fn step(&mut self, round: usize) {
        let ([a, b], [fa, fb]) = (self.ends, self.weights);
        let secant = a + (b - a) * (fa / (fa - fb));
        let inside = round > 0 && round < SECANTS && secant > a && secant < b;
        let t = if inside { secant } else { 0.5 * (a + b) };
        (self.last_step, self.t) = ((t - self.t).abs(), t);
    }

    /// Takes f at t; is there a way to go?
    fn narrow(&mut self, f: f64, round: usize) -> bool {
        if round == 0 {
            self.scale = median([-self.weights[0], self.weights[1], f.abs()]);
        }
        let side = usize::from(f >= 0.0);
        // An end that stays twice loses half its weight, so the next point falls on its side.
        if (self.f >= 0.0) == (f >= 0.0) {
            self.weights[1 - side] *= 0.5;
        }
        (self.ends[side], self.weights[side], self.f) = (self.t, f, f);
        f != 0.0 && self.last_step > LAST_STEP && self.ends[1] - self.ends[0] > LAST_STEP
    }
}

fn median(mut values: [f64; 3]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[1]
}
