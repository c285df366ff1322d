//! Tong & Kim 2009 as printed, where that can work: section 3.4, steps (i) to (v), each once.
//!
//! ```text
//! (i)   polygonisation, decimation by quadric errors, projection (4)      §4
//! (ii)  quartic boundary curves by Algorithm 5.1                          §5, (9)–(11)
//! (iii) patches fitted to the projected flat triangles                    §6.1, (12)
//! (iv)  vertex systems, then edge systems                                 §6.3, §6.4, (14)–(25)
//! (v)   the three inner points fitted again                               §6.5
//! ```
//!
//! It is kept to compare with: there are no rounds, no errors are evened out, and no tangent turns. What the choices break is
//! in the result: curves for which Algorithm 5.1 fails, patches that fold, normals that are far off. Other than printed are only
//! signs (PAPERS.md, misprints), the flips that a decimated mesh needs for (14) to have a solution, and (19), for
//! which a closed form stands that serves every valence.

use super::spline::{Fitted, RecipeError, figures};
use crate::base::{self, BaseError, BaseMethod, BaseOptions, FieldTarget};
use crate::field::Formula;
use crate::geom::Aabb;
use crate::inspect::{InspectOptions, deviation};
use crate::network::{CurveOptions, CurveSolver, fit_quartics};
use crate::report::Seconds;
use crate::spline::{Construction, SampledFrom, ShapeParameters};

/// Algorithm 5.1, with nothing after it.
pub fn curve_options() -> CurveOptions {
    CurveOptions {
        solver: CurveSolver::Sqp,
        normal_distance_steps: 0,
        largest_turn: 0.0,
        ..CurveOptions::default()
    }
}

/// The spline of `faces` patches over the zero set of a formula, in a box or wherever it is; `progress` is told the name
/// of each stage as it starts.
pub fn fit(
    formula: &Formula,
    bounds: Option<Aabb>,
    faces: Option<usize>,
    progress: &dyn Fn(&str),
) -> Result<Fitted, RecipeError> {
    if let Some(value) = formula.constant() {
        return Err(BaseError::ConstantField { value }.into());
    }
    let mut seconds = Seconds::default();
    progress("base mesh");
    let bounds = bounds.map_or_else(|| base::find_box(formula), Ok)?;
    let negated = base::outside_is_negative(formula, &bounds)?;
    let formula = if negated { formula.negated() } else { formula.clone() };
    // (i)
    let options = BaseOptions { faces, method: BaseMethod::Decimate, ..BaseOptions::default() };
    let seed = seconds
        .measure("polygonization", || base::seed_mesh(&formula, &bounds, options.faces, &options.seed))?;
    let made = seconds.measure("decimation", || base::base_from_seed(&formula, &seed, &options))?;
    let target = FieldTarget::new(&formula, made.base.diagonal());

    // (ii)
    progress("curves");
    let options = curve_options();
    let curves = seconds.measure("curves", || fit_quartics(&made.base, &target, &options))?;

    // (iii)
    progress("patches");
    let g0 = || Construction::new(made.base, &curves, &target, SampledFrom::Flat);
    let mut work = seconds.measure("G0 patches", g0);

    // (iv)
    let shape = ShapeParameters::default();
    seconds.measure("vertex systems", || work.solve_vertices(&shape))?;
    seconds.measure("edge systems", || work.solve_edges(&shape, &[]))?;

    // (v)
    seconds.measure("inner points", || work.refit_free_points());
    let surface = work.finish();

    let lattice = InspectOptions::default().lattice;
    let measured = deviation(&surface, &formula, surface.base.diagonal(), lattice);
    Ok(Fitted {
        figures: figures(&curves, &options, &measured.patches),
        surface,
        formula,
        negated,
        bounds,
        reached: true,
        certified_topology: made.certified,
        coverage: None,
        repairs: made.repairs,
        seconds,
    })
}
