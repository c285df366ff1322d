//! Where the surface is: a box around it, from interval bounds alone.

use rayon::prelude::*;

use super::error::{BaseError, BoxSide};
use super::polygonize::{Grid, boundary_sign, sample};
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};

/// Half the edge length of the cube in which [`find_box`] looks: 2³⁰, a thousand kilometres in millimetres.
pub const SEARCH_RADIUS: f64 = (1u64 << 30) as f64;

/// Levels after which a surface that still reaches the sides of the search cube counts as unbounded. Interval bounds of
/// a polynomial settle its sign far away once cells are small beside their distance: here by a factor of 64.
const UNBOUNDED_LEVEL: usize = 7;

/// Levels of the search: enough for a surface 2⁻³⁰ wide in a cube of 2³¹.
const MAX_LEVEL: usize = 70;

/// The search stops when the surface is this many cells wide: its box is then known to some percent.
const CELLS_ACROSS: f64 = 32.0;

/// Largest number of cells of one level of [`find_box`].
const SEARCH_BUDGET: usize = 400_000;

/// Largest number of cells of one level of [`tighten`]: a millisecond or so.
const TIGHTEN_BUDGET: usize = 16_000;

/// What is added around a box found by interval bounds, as a share of its longest side.
const MARGIN: f64 = 0.05;

/// A box with finite, positive lengths?
pub fn check_box(bounds: &Aabb) -> Result<(), BaseError> {
    for axis in 0..3 {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        if !(min.is_finite() && max.is_finite() && (max - min).is_finite()) {
            return Err(BaseError::NonFiniteBox { axis });
        }
        if min > max {
            return Err(BaseError::ReversedBox { axis, min, max });
        }
        // Thinner than this, neighbouring grid nodes could not be told apart.
        let resolution = 1e4 * f64::EPSILON * min.abs().max(max.abs());
        if max - min <= resolution {
            return Err(BaseError::FlatBox { axis, min, max });
        }
    }
    Ok(())
}

/// A box that holds the whole surface f = 0, found by subdividing a cube of [`SEARCH_RADIUS`] around the origin.
///
/// Cells in which [`Field::range`] excludes zero are dropped, so nothing of the surface inside the cube is lost. Fails
/// with [`BaseError::Unbounded`] if the surface seems to reach the sides of the cube.
pub fn find_box(field: &dyn Field) -> Result<Aabb, BaseError> {
    let r = Vec3::repeat(SEARCH_RADIUS);
    let cube = Aabb::new(-r, r);
    let found = subdivide(field, &cube, SEARCH_BUDGET, |level, rest| {
        level < UNBOUNDED_LEVEL || (0..3).all(|a| rest.min[a] > cube.min[a] && rest.max[a] < cube.max[a])
    })?;
    let rest = found.ok_or(BaseError::Unbounded)?;
    let rest = rest.grown(MARGIN * rest.size().max());
    check_box(&rest)?;
    Ok(rest)
}

/// The part of a box that may hold the surface, by interval bounds; with a small margin, but inside the box.
///
/// Fails with [`BaseError::NoSurface`] if there is none.
pub fn tighten(field: &dyn Field, bounds: &Aabb) -> Result<Aabb, BaseError> {
    check_box(bounds)?;
    let rest = subdivide(field, bounds, TIGHTEN_BUDGET, |_, _| true)?.unwrap_or(*bounds);
    let rest = rest.grown(MARGIN * rest.size().max());
    Ok(Aabb::new(rest.min.sup(&bounds.min), rest.max.inf(&bounds.max)))
}

/// Bounding box of the cells that may hold zeros of f, breadth first, until it is [`CELLS_ACROSS`] cells wide, or there
/// are more than `budget` cells; none as soon as `go_on(level, box)` says no.
fn subdivide(
    field: &dyn Field,
    root: &Aabb,
    budget: usize,
    go_on: impl Fn(usize, &Aabb) -> bool,
) -> Result<Option<Aabb>, BaseError> {
    let mut cells = vec![*root];
    let mut size = root.size();
    let mut rest = *root;
    for level in 1..=MAX_LEVEL {
        size *= 0.5;
        cells = cells
            .par_iter()
            .flat_map_iter(|cell| octants(cell).into_iter().filter(|c| may_vanish(field, c)))
            .collect();
        if cells.is_empty() {
            let negative = field.value(root.center()) < 0.0;
            return Err(BaseError::NoSurface { negative, proven: true });
        }
        rest = cells.iter().fold(Aabb::EMPTY, |b, c| b.union(c));
        if !go_on(level, &rest) {
            return Ok(None);
        }
        if size.max() * CELLS_ACROSS <= rest.size().max() {
            break;
        }
        if cells.len() > budget {
            // What is left is still an enclosure, if only a wide one.
            return Ok(go_on(usize::MAX, &rest).then_some(rest));
        }
    }
    Ok(Some(rest))
}

fn octants(cell: &Aabb) -> [Aabb; 8] {
    let middle = cell.center();
    std::array::from_fn(|c| {
        let upper = |axis: usize| c >> axis & 1 == 1;
        let min = Point3::from_fn(|a, _| if upper(a) { middle[a] } else { cell.min[a] });
        let max = Point3::from_fn(|a, _| if upper(a) { cell.max[a] } else { middle[a] });
        Aabb::new(min, max)
    })
}

/// Can interval bounds not exclude a zero? An enclosure that is not a number excludes nothing.
fn may_vanish(field: &dyn Field, cell: &Aabb) -> bool {
    let range = field.range(cell);
    !(range.lo > 0.0 || range.hi < 0.0)
}

/// Cells along the longest side of the box when only the sign outside the solid is wanted.
const SIGN_CELLS: usize = 32;

/// Is f < 0 on the boundary of the box, so that the bounded solid is {f > 0} and the field is to be negated?
///
/// Decided from samples on the boundary of the part of the box that can hold the surface.
pub fn outside_is_negative(field: &dyn Field, bounds: &Aabb) -> Result<bool, BaseError> {
    let region = tighten(field, bounds)?;
    boundary_sign(&sample(field, &Grid::covering(&region, SIGN_CELLS)))
}

/// Which side of the box a point outside of it is beyond; none for a point inside.
pub(super) fn side_beyond(bounds: &Aabb, p: &Point3) -> Option<BoxSide> {
    (0..3).find_map(|axis| {
        let upper = p[axis] > bounds.max[axis];
        (upper || p[axis] < bounds.min[axis]).then_some(BoxSide { axis, upper })
    })
}
