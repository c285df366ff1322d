//! Subdivision: what is left of a box when all is ruled out that can be.

use super::SingularError;
use super::cell::{Cell, Critical, Stratum};
use super::cluster::{clusters, hull};
use super::unit::UnitPolynomial;
use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Most boxes of one size.
pub(super) const MOST_CELLS: usize = 200_000;

/// What is left of some boxes.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Boxes in which nothing could be shown.
    pub cells: Vec<Cell>,
    /// Boxes each of which holds exactly one critical point of f.
    pub found: Vec<Aabb>,
}

/// Divides boxes `levels` times and drops those that hold no point of the stratum. Critical points that can be told apart
/// are taken out.
///
/// It stops early when more than `most` boxes are left.
pub(super) fn refine(
    cells: Vec<Cell>,
    levels: usize,
    most: usize,
    stratum: Stratum,
) -> Result<Rest, SingularError> {
    let mut rest = Rest { cells, found: Vec::new() };
    for _ in 0..levels {
        if rest.cells.len() > most {
            break;
        }
        let outcomes: Vec<(Vec<Cell>, Vec<Aabb>)> =
            rest.cells.par_iter().evenly().map(|cell| parts(cell, stratum)).collect();
        rest.cells.clear();
        for (cells, found) in outcomes {
            rest.cells.extend(cells);
            rest.found.extend(found);
        }
        if rest.cells.len() > MOST_CELLS {
            return Err(SingularError::TooManyCells(MOST_CELLS));
        }
        if rest.cells.first().is_some_and(|cell| cell.work.is_spent()) {
            return Err(SingularError::TooMuchWork);
        }
    }
    Ok(rest)
}

fn parts(cell: &Cell, stratum: Stratum) -> (Vec<Cell>, Vec<Aabb>) {
    let mut found = Vec::new();
    let mut kept = Vec::new();
    for part in cell.split() {
        part.work.add(&part.net);
        if !part.may_hold(stratum) {
            continue;
        }
        match part.critical() {
            // At a critical point with regular Hessian no other stratum is.
            Critical::One(bounds) => found.push(bounds),
            Critical::None => {}
            Critical::Unknown if part.rises() => {}
            Critical::Unknown => kept.push(part),
        }
    }
    (kept, found)
}

/// What a set of boxes comes to when it is looked at closely.
#[derive(Debug, Default)]
pub(super) struct Located {
    /// Points of the stratum, alone in boxes of this size around them.
    pub points: Vec<(Point3, f64)>,
    /// Boxes each of which holds exactly one critical point, with regular Hessian.
    pub found: Vec<Aabb>,
    /// Does a curve of the stratum pass through the boxes?
    pub extended: bool,
}

/// Levels of one closer look.
const LEVELS: usize = 4;
/// Looks, each of which makes a box several times smaller.
const LOOKS: usize = 40;
/// Side of a box that is small enough, in unit coordinates.
const SMALL: f64 = 1e-14;
/// A hull that keeps more than this part of its size has not shrunk.
const SHRUNK: f64 = 0.6;
/// A hull below this size has shrunk many times before; if it shrinks no more, the terms that would tell are lost in the
/// rounding of others: z⁴ in z⁴ + x² at 10⁻⁴, when x is at 10⁻⁸ already.
const ROUNDED: f64 = 1e-3;
/// How often a hull may fail to shrink before it counts as part of a curve.
const PATIENCE: usize = 2;

/// Looks closer and closer at the points of a stratum in a box, with nets from the exact coefficients each time: points
/// shrink to points however degenerate they are, curves do not.
pub(super) fn locate(f: &UnitPolynomial, bounds: Aabb, stratum: Stratum) -> Result<Located, SingularError> {
    let mut result = Located::default();
    let mut open = vec![(bounds, 0, 0)];
    while let Some((bounds, looks, failures)) = open.pop() {
        let size = bounds.size().max();
        if size < SMALL || looks > LOOKS {
            result.points.push((bounds.center(), 0.5 * bounds.diagonal()));
            continue;
        }
        // Larger by a little, so that points on the border are inside, and not in proportion.
        let bounds =
            Aabb::new(bounds.min - 0.0713 * Point3::repeat(size), bounds.max + 0.0591 * Point3::repeat(size));
        let rest = refine(vec![Cell::precise(f, bounds)], LEVELS, MOST_CELLS, stratum)?;
        result.found.extend(rest.found);
        for members in clusters(&rest.cells) {
            let inner = hull(members.iter().map(|i| &rest.cells[*i]));
            let failures = if inner.size().max() > SHRUNK * size { failures + 1 } else { 0 };
            if failures >= PATIENCE && size > ROUNDED {
                result.extended = true;
            } else if failures >= PATIENCE {
                result.points.push((inner.center(), 0.5 * inner.diagonal()));
            } else {
                open.push((inner, looks + 1, failures));
            }
        }
        // Points that were told apart more than once, in boxes that overlap.
        if result.extended || open.len() > MOST_CELLS {
            result.extended = true;
            return Ok(result);
        }
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};

    #[test]
    fn pinch_points_of_the_steiner_surface_are_located() {
        let formula = Formula::parse("x^2y^2+y^2z^2+z^2x^2-4x y z", &Constants::new()).unwrap();
        let bounds = Aabb::new(Point3::new(-3.0, -3.0, -2.0), Point3::new(3.0, 3.0, 2.0));
        let f = UnitPolynomial::new(&formula.quadratic_polynomial().unwrap(), &bounds);
        for pinch in [Point3::new(0.5, 0.0, 0.0), Point3::new(0.0, -0.5, 0.0), Point3::new(0.0, 0.0, 0.5)] {
            // Not in proportion, as the hulls of a few boxes are, and its parts no better.
            let around = Aabb::new(
                pinch - Point3::new(0.0046, 0.00076, 0.0023),
                pinch + Point3::new(0.0046, 0.0021, 0.0031),
            );
            let mut cell = Cell::precise(&f, around);
            for level in 0..30 {
                let parts = cell.split();
                let Some(next) = parts.iter().find(|c| c.bounds.grown(1e-16).contains(&pinch)) else {
                    panic!("{pinch:?}: no part at level {level}")
                };
                assert!(next.may_hold(Stratum::Singular), "{pinch:?} not singular at level {level}");
                assert!(next.may_hold(Stratum::RankOne), "{pinch:?} not rank one at level {level}");
                assert_ne!(next.critical(), Critical::None, "{pinch:?} level {level}");
                cell = next.clone();
            }
            let located = locate(&f, around, Stratum::RankOne).unwrap();
            assert!(located.points.iter().any(|(p, _)| (p - pinch).norm() < 1e-12), "{pinch:?}: {located:?}");
        }
    }
}
