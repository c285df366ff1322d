//! Where the surface is: a box around it, from interval bounds alone.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::clip::BoxSide;
use super::error::BaseError;
use crate::field::Field;
use crate::geom::{Aabb, Point3, Points, Vec3};

/// Half the edge lengths of the cubes in which [`find_box`] looks, one after the other: 2³⁰ (a thousand kilometres in
/// millimetres), 2²⁰ and 2¹⁰.
///
/// Far out, interval bounds are slow to settle the sign of formulas in which a power of one coordinate competes with a
/// product of others; a smaller cube is then tried, and nothing is known about the outside of it.
pub const SEARCH_RADII: [f64; 3] = [(1u64 << 30) as f64, (1u64 << 20) as f64, (1u64 << 10) as f64];

/// Levels of the search: enough for a surface 2⁻⁴⁰ wide in a cube of 2³¹.
const MAX_LEVEL: usize = 75;

/// The search stops when the surface is this many cells wide: its box is then known to some percent.
const CELLS_ACROSS: f64 = 16.0;

/// It also waits until two levels leave this share of the box, and in [`find_box`] until the last one has so many times the
/// cells of the one before: far from the surface, bounds that are too wide keep cells that smaller ones lose. A surface in cells of half the
/// size has four times as many, a line that only seems to vanish has twice as many.
const STABLE: f64 = 0.7;
const GROWTH: f64 = 2.8;

/// Largest number of cells of one level of [`find_box`], for each of [`SEARCH_RADII`]. Beside a coordinate axis that the
/// surface nearly reaches far out, a level has some √radius cells.
const SEARCH_BUDGETS: [usize; 3] = [50_000, 250_000, 250_000];

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

/// A box that holds the whole surface f = 0, found by subdividing cubes of [`SEARCH_RADII`] around the origin.
///
/// Cells in which [`Field::range`] excludes zero are dropped, so nothing of the surface inside the cube is lost. Fails
/// with [`BaseError::Unbounded`] if the surface reaches the sides of every cube, or cannot be shown not to.
pub fn find_box(field: &dyn Field) -> Result<Aabb, BaseError> {
    let mut wide = None;
    for (radius, budget) in SEARCH_RADII.into_iter().zip(SEARCH_BUDGETS) {
        let r = Vec3::repeat(radius);
        let cube = Aabb::new(-r, r);
        let inside = |rest: &Aabb| (0..3).all(|a| rest.min[a] > cube.min[a] && rest.max[a] < cube.max[a]);
        let enclosure = subdivide(field, &cube, budget, GROWTH, inside)?;
        if enclosure.is_fine {
            wide = Some(enclosure.bounds);
        }
        if enclosure.is_fine && !enclosure.spent {
            break;
        }
    }
    let bounds = wide.ok_or(BaseError::Unbounded)?;
    let rest = bounds.grown(MARGIN * bounds.size().max());
    check_box(&rest)?;
    Ok(rest)
}

/// The part of a box that may hold the surface, by interval bounds; with a small margin, but inside the box.
///
/// Fails with [`BaseError::NoSurface`] if there is none.
pub fn tighten(field: &dyn Field, bounds: &Aabb) -> Result<Aabb, BaseError> {
    check_box(bounds)?;
    let rest = subdivide(field, bounds, TIGHTEN_BUDGET, 0.0, |_| true)?.bounds;
    let rest = rest.grown(MARGIN * rest.size().max());
    Ok(Aabb::new(rest.min.sup(&bounds.min), rest.max.inf(&bounds.max)))
}

/// A box around what may be the surface.
struct Enclosure {
    bounds: Aabb,
    /// Is it fine enough, and accepted by `may_stop`?
    is_fine: bool,
    /// Did the search end before it was stable?
    spent: bool,
}

/// Bounding box of the cells that may hold zeros of f, breadth first, until it is [`CELLS_ACROSS`] cells wide, passes
/// `may_stop` and is stable, the cells having become `growth` times as many, or until there are more than `budget` cells: then it is still an enclosure, if only a wide one.
fn subdivide(
    field: &dyn Field,
    root: &Aabb,
    budget: usize,
    growth: f64,
    may_stop: impl Fn(&Aabb) -> bool,
) -> Result<Enclosure, BaseError> {
    let mut cells = vec![*root];
    let mut size = root.size();
    let mut bounds = *root;
    let mut sizes = [f64::INFINITY; 2];
    for _ in 0..MAX_LEVEL {
        size *= 0.5;
        let before = cells.len() as f64;
        cells = cells
            .par_iter()
            .evenly()
            .flat_map_iter(|cell| octants(cell).into_iter().filter(|c| may_vanish(field, c)))
            .collect();
        if cells.is_empty() {
            let negative = field.value(root.center()) < 0.0;
            return Err(BaseError::NoSurface { negative, proven: true });
        }
        bounds = cells.iter().fold(Aabb::EMPTY, |b, c| b.union(c));
        let longest = bounds.size().max();
        let fine = size.max() * CELLS_ACROSS <= longest && may_stop(&bounds);
        let stable = longest > STABLE * sizes[0] && cells.len() as f64 >= growth * before;
        let spent = cells.len() > budget;
        if spent || (fine && stable) {
            return Ok(Enclosure { bounds, is_fine: fine, spent });
        }
        sizes = [sizes[1], longest];
    }
    Ok(Enclosure { bounds, is_fine: false, spent: true })
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
pub(super) fn may_vanish(field: &dyn Field, cell: &Aabb) -> bool {
    let range = field.range(cell);
    !(range.lo > 0.0 || range.hi < 0.0)
}

/// Samples along each side of the box when only the sign outside the solid is wanted.
const SIGN_SAMPLES: usize = 33;

/// Is f < 0 on the boundary of the box, so that the bounded solid is {f > 0} and the field is to be negated?
///
/// Decided from samples on the boundary of the part of the box that can hold the surface. False if there are both signs:
/// the box cuts the surface, which is then taken as it is.
pub fn outside_is_negative(field: &dyn Field, bounds: &Aabb) -> Result<bool, BaseError> {
    let region = tighten(field, bounds)?;
    let is_side = |i: usize| i == 0 || i == SIGN_SAMPLES - 1;
    let share = |i: usize| i as f64 / (SIGN_SAMPLES - 1) as f64;
    let place =
        |n: usize| [n % SIGN_SAMPLES, n / SIGN_SAMPLES % SIGN_SAMPLES, n / SIGN_SAMPLES / SIGN_SAMPLES];
    let points: Points = (0..SIGN_SAMPLES.pow(3))
        .map(place)
        .filter(|at| at.iter().any(|i| is_side(*i)))
        .map(|at| region.min + region.size().component_mul(&Vec3::from(at.map(share))))
        .collect();
    let mut values = vec![0.0; points.len()];
    field.values(points.view(), &mut values);
    let mut defined = values.iter().filter(|f| !f.is_nan()).peekable();
    Ok(defined.peek().is_some() && defined.all(|f| *f < 0.0))
}

/// The sides of the box that are sides of the region, too: there the box may cut the surface.
pub(super) fn clipped_sides(bounds: &Aabb, region: &Aabb) -> impl Iterator<Item = BoxSide> {
    let (bounds, region) = (*bounds, *region);
    BoxSide::all().filter(move |side| side.position(&bounds) == side.position(&region))
}

/// Which side of the box a point outside of it is beyond; none for a point inside.
pub(super) fn side_beyond(bounds: &Aabb, p: &Point3) -> Option<BoxSide> {
    (0..3).find_map(|axis| {
        let upper = p[axis] > bounds.max[axis];
        (upper || p[axis] < bounds.min[axis]).then_some(BoxSide { axis, upper })
    })
}
