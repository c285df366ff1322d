//! Patches from their boundary curves and the data at the vertices alone, with no surface to fit them to.
//!
//! ```text
//! boundary rows ──► twist points ──► inner rows ──► free points
//!    curves        least variation   least variation   least variation
//!                  of order 3, then  of order 5, then  of order 5
//!                  vertex systems    edge systems
//! ```
//!
//! Whatever the G1 systems do not bind makes ∫ |∇ᵏ b|² small. The order says what is reproduced: with only the boundary
//! known, order 2 would flatten a quadratic patch, order 3 reproduces it, and order 4 leaves the cubic that vanishes on
//! the boundary undetermined. With the twist points known too, order 5 reproduces quartics.

use super::build::{SplineError, end_weights, nets_with_boundary, solve_edges, solve_vertices};
use super::fit::FREE_POINTS;
use super::surface::{DEGREE, NET, TriangularSpline};
use crate::base::BaseMesh;
use crate::bernstein::{energy, index};
use crate::geom::{Point3, Vec3};
use crate::network::QuarticCurve;
use crate::parallel::Evenly;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::sync::LazyLock;

type Net = [Point3; NET];

/// Order of the variation that is made small from the boundary alone, and once the twist points are known.
const FROM_BOUNDARY: usize = 3;
const FROM_TWISTS: usize = 5;
/// Patches that one task fills.
const BATCH: usize = 8;

/// Control points as linear combinations of the others.
struct Filler {
    free: Vec<usize>,
    others: Vec<usize>,
    /// (others) × (free).
    shares: Vec<Vec<f64>>,
}

impl Filler {
    fn new(energy: &DMatrix<f64>, is_free: impl Fn([usize; 3]) -> bool) -> Self {
        let matrix = energy::least(energy, DEGREE, &is_free);
        let (free, others): (Vec<_>, Vec<_>) = index::indices(DEGREE).partition(|ijk| is_free(*ijk));
        let places = |indices: Vec<[usize; 3]>| indices.into_iter().map(index::position).collect();
        let shares = matrix.column_iter().map(|column| column.iter().copied().collect()).collect();
        Self { free: places(free), others: places(others), shares }
    }

    fn fill(&self, nets: &mut [Net]) {
        nets.par_iter_mut().evenly_by(BATCH).for_each(|net| {
            let origin = net[0];
            // All free points grow side by side: one sum after the other would wait for each addition.
            let mut sums = [Vec3::zeros(); NET];
            for (shares, place) in self.shares.iter().zip(&self.others) {
                let offset = net[*place] - origin;
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += *share * offset);
            }
            self.free.iter().zip(sums).for_each(|(place, sum)| net[*place] = origin + sum);
        });
    }
}

struct Fillers {
    inside: Filler,
    inside_twists: Filler,
    free_points: Filler,
}

static FILLERS: LazyLock<Fillers> = LazyLock::new(|| {
    let is_twist = |ijk: [usize; 3]| ijk.contains(&(DEGREE - 2)) && !index::is_boundary(ijk);
    let [from_boundary, from_twists] =
        [FROM_BOUNDARY, FROM_TWISTS].map(|order| energy::variation(DEGREE, order));
    Fillers {
        inside: Filler::new(&from_boundary, |ijk| !index::is_boundary(ijk)),
        inside_twists: Filler::new(&from_twists, |ijk| !index::is_boundary(ijk) && !is_twist(ijk)),
        free_points: Filler::new(&from_twists, |ijk| FREE_POINTS.contains(&index::position(ijk))),
    }
});

/// Builds the G1 spline over `base` with the given boundary curves (one an edge), as smooth inside as they and the
/// curvature tensors at the vertices let it be.
///
/// Linear time; parallel, with the same result for every number of threads.
pub fn fill(base: BaseMesh, curves: &[QuarticCurve]) -> Result<TriangularSpline, SplineError> {
    let curves: Vec<[Point3; 5]> = curves.iter().map(|c| c.q).collect();
    let fillers = &*FILLERS;
    let mut nets = nets_with_boundary(&base.mesh, &curves);
    let weights = end_weights(&base, &curves);
    fillers.inside.fill(&mut nets);
    let mu1 = solve_vertices(&base, &curves, &weights, &[], &mut nets)?;
    fillers.inside_twists.fill(&mut nets);
    solve_edges(&base.mesh, &curves, &weights, &mu1, &[], &[], &mut nets)?;
    fillers.free_points.fill(&mut nets);
    Ok(TriangularSpline::new(base, curves, nets))
}
