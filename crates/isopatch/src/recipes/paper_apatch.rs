//! Xu, Huang & Bajaj 2001 as printed, to compare with [`super::apatch`].
//!
//! ```text
//! normals        of the file, or the limit of Loop's subdivision              §1
//! hull           apexes on the normals of the faces, at t_lm or above         §3.1
//!                edge tetrahedra, tests of edges and faces                    §3.2
//! layers 0, 1    from vertices and normals, Steps 1 to 4                      §4.2
//! layer 2        least squares, Step 5
//! layer 3        nearest to a linear function, Steps 6 and 8
//! edges          Steps 7, 9 and 10
//! ```
//!
//! Nothing is mended: no normal moves, no apex leans, no crease is made. Faces and edges that do not pass the paper's own tests are
//! among the repairs of the result ("surface not certain"), as are patches that turn over; a ray that meets no sheet is an error of
//! tessellation. Instead of Butterfly subdivision, which the paper then calls for, the list stands. Step 8 gives no quadric back
//! but the plane.

use super::apatch::{APatchError, APatchRecipe, FittedMesh, fit as fit_with};
use super::triangulated::word;
use crate::apatch::{APatchOptions, FreeRule, Layer2Rule};
use crate::base::Repair;
use crate::hull::{ApexRule, HullOptions, Margin};
use crate::inspect::{APatchInspectOptions, inspect_a_patches};
use crate::io::read::PolygonMesh;
use crate::mesh::Place;

/// How far apexes stay above t_lm, which the paper leaves open: the share of the distance from the centroid to the edges that its
/// pictures suggest.
const MARGIN: f64 = 0.05;

/// The paper's choice in every stage.
pub fn recipe() -> APatchRecipe {
    APatchRecipe {
        hull: HullOptions { rule: ApexRule::Paper, margin: Margin::Relative(MARGIN) },
        patches: APatchOptions {
            layer2: Layer2Rule::LeastSquares,
            rule: FreeRule::Linear,
            ..APatchOptions::default()
        },
        ..APatchRecipe::default()
    }
}

/// The surface of a mesh, with what is wrong with it among its repairs; `given` adds normals, lengths of gradients, creases and free
/// parameters to [`recipe`].
///
/// # Errors
/// As [`super::apatch::fit`].
pub fn fit(
    mesh: &PolygonMesh,
    given: &APatchRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedMesh, APatchError> {
    let paper = recipe();
    let patches = APatchOptions { free: given.patches.free.clone(), ..paper.patches };
    let recipe = APatchRecipe { hull: paper.hull, patches, ..given.clone() };
    let mut fitted = fit_with(mesh, &recipe, progress)?;
    fitted.repairs.extend(broken(&fitted));
    Ok(fitted)
}

/// Patches that are not what they should be, in their own numbers.
fn broken(fitted: &FittedMesh) -> Vec<Repair> {
    let found = inspect_a_patches(&fitted.surface, &APatchInspectOptions::QUICK);
    let places = |patches: &[crate::surface::PatchId]| -> Vec<Place> {
        patches.iter().map(|patch| Place::Face(patch.0)).collect()
    };
    let undefined =
        word("patches that are not defined somewhere", &places(&found.undefined), "a ray has no simple root");
    let folded = word("patches that turn over", &places(&found.folded), "nothing was done against it");
    undefined.into_iter().chain(folded).collect()
}
