//! The G1 spline of Tong & Kim 2009 from a formula: the paper's section 3.4, with the corrections of PAPERS.md.

use super::differentiable::{Defect, explain, find_defect};
use crate::base::{self, BaseError, BaseOptions, FieldTarget};
use crate::field::Formula;
use crate::geom::Aabb;
use crate::io::read::PolygonMesh;
use crate::network::{CurveError, CurveOptions, QuarticCurve, fit_quartics};
use crate::report::{Repair, Seconds, SplineReport};
use crate::spline::{self, SplineError, SplineOptions, TriangularSpline};

/// How many patches a surface gets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Size {
    /// As many as its curvature asks for.
    #[default]
    Automatic,
    /// This many.
    Faces(usize),
}

/// What the recipe is given besides the formula. The default is a good choice for every stage.
#[derive(Clone, Debug, Default)]
pub struct SplineRecipe {
    /// Where the surface is; found if the surface is bounded and none is given.
    pub bounds: Option<Aabb>,
    /// Number of patches.
    pub size: Size,
    /// Connectivity and approximate vertices of the base mesh; made from the surface if none is given. With a given
    /// mesh `size` has no say.
    pub given: Option<PolygonMesh>,
    /// Base mesh.
    pub base: BaseOptions,
    /// Boundary curves.
    pub curves: CurveOptions,
    /// Patches.
    pub spline: SplineOptions,
}

/// A finished surface.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The surface.
    pub surface: TriangularSpline,
    /// The formula, negated if that makes the solid {f < 0} bounded.
    pub formula: Formula,
    /// Was it negated?
    pub negated: bool,
    /// Where the surface was looked for.
    pub bounds: Aabb,
    /// Figures of the curve fits; `folded` and `faces_over_20deg` are those of the last check.
    pub figures: SplineReport,
    /// Departures from what was asked.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecipeError {
    /// No base mesh.
    #[error(transparent)]
    Base(#[from] BaseError),
    /// The formula is not smooth, or undefined, on the surface.
    #[error(transparent)]
    Defect(#[from] Defect),
    /// A boundary curve failed.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// A G1 system failed.
    #[error(transparent)]
    Spline(#[from] SplineError),
}

/// The spline surface of the zero set of `formula`; `progress` is told the name of each stage as it starts.
pub fn fit(formula: &Formula, recipe: &SplineRecipe, progress: &dyn Fn(&str)) -> Result<Fitted, RecipeError> {
    let mut seconds = Seconds::default();
    let mut stage = Stages { seconds: &mut seconds, progress };

    let bounds = stage.run("box", || recipe.bounds.map_or_else(|| base::find_box(formula), Ok))?;
    let negated = stage.run("box", || base::outside_is_negative(formula, &bounds))?;
    let formula = if negated { formula.negated() } else { formula.clone() };

    let blame = |error: BaseError| match explain(&formula, &bounds, &error) {
        Some(defect) => RecipeError::Defect(defect),
        None => RecipeError::Base(error),
    };
    let faces = match recipe.size {
        Size::Automatic => None,
        Size::Faces(n) => Some(n),
    };
    let options = BaseOptions { faces, ..recipe.base };
    let outcome = stage.run("base mesh", || match &recipe.given {
        Some(mesh) => base::from_mesh(&formula, &mesh.positions, &mesh.faces, &options),
        None => base::build(&formula, &bounds, &options),
    });
    let outcome = outcome.map_err(blame)?;
    if let Some(defect) = stage.run("base mesh", || find_defect(&formula, &outcome.base)) {
        return Err(defect.into());
    }

    let target = FieldTarget::new(&formula, outcome.base.diagonal());
    let curves = stage.run("curves", || fit_quartics(&outcome.base, &target, &recipe.curves))?;
    let surface = stage.run("patches", || spline::build(outcome.base, &curves, &target, &recipe.spline))?;

    let figures = figures(&curves);
    let repairs =
        outcome.repairs.into_iter().map(|r| Repair { what: r.what, place: r.place, why: r.why }).collect();
    Ok(Fitted { surface, negated, bounds, figures, repairs, seconds, formula: formula.clone() })
}

/// Runs stages, tells their names and sums up their times.
struct Stages<'a> {
    seconds: &'a mut Seconds,
    progress: &'a dyn Fn(&str),
}

impl Stages<'_> {
    fn run<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        (self.progress)(name);
        self.seconds.measure(name, work)
    }
}

fn figures(curves: &[QuarticCurve]) -> SplineReport {
    let steps: usize = curves.iter().map(|c| c.steps).sum();
    SplineReport {
        sqp_iterations_mean: steps as f64 / curves.len().max(1) as f64,
        curves_at_bound: curves.iter().filter(|c| c.at_bound).count(),
        ..SplineReport::default()
    }
}
