//! Xu, Bajaj & Evans as printed, where that can work, to compare with [`super::hybrid`].
//!
//! ```text
//! hull           an apex over each face, edge tetrahedra                       §3
//! elements       tetrahedra over triangles, pyramids over quadrilaterals,
//!                fans of tetrahedra where they are not convex                  §4, Sub-algorithms 1 to 4
//! parameters     value and gradient at the apex nearest to a quadratic and
//!                a linear function; then the sufficient single-sheet
//!                conditions, everywhere                                        §4.3
//! ```
//!
//! Heights and directions of apexes are tried once, and normals stay. Other than printed: pentagons and larger polygons, for which the
//! paper's conditions have no solution in general, stand on sectors. If no valid surface comes of it, the mesh goes to
//! [`super::paper_apatch`] as triangles, and the repairs say why.

use super::apatch::{APatchError, APatchRecipe};
use super::hybrid::{Fitted, HybridRecipe, TriangleElement, fit as fit_with};
use super::paper_apatch;
use crate::hybrid::hull::{DefaultRule, HybridOptions, Sheets};
use crate::io::read::PolygonMesh;

/// The paper's choice in every stage.
pub fn recipe() -> HybridRecipe {
    HybridRecipe {
        triangles: paper_apatch::recipe(),
        triangle_element: TriangleElement::Hybrid,
        hull: HybridOptions {
            adaptive: false,
            rule: DefaultRule::Paper { linear: true },
            sheets: Sheets::Everywhere,
            fans: true,
            visibility: f64::NEG_INFINITY,
            ..HybridOptions::default()
        },
        ..HybridRecipe::default()
    }
}

/// The surface of a mesh. `given` adds normals, lengths of gradients, creases and free parameters to [`recipe`], and says what becomes
/// of polygons and over which triangles the cells of this paper stand; over others those of [`paper_apatch`] do.
///
/// # Errors
/// As [`super::hybrid::fit`].
pub fn fit(mesh: &PolygonMesh, given: &HybridRecipe, progress: &dyn Fn(&str)) -> Result<Fitted, APatchError> {
    let triangles_only = mesh.faces.iter().all(|face| face.len() == 3);
    if triangles_only && given.triangle_element == TriangleElement::Triangle {
        let fitted = paper_apatch::fit(mesh, &given.triangles, progress)?;
        return Ok(Fitted::Triangles(Box::new(fitted)));
    }
    let paper = recipe();
    let triangles = APatchRecipe {
        hull: paper.triangles.hull,
        patches: crate::apatch::APatchOptions {
            free: given.triangles.patches.free.clone(),
            ..paper.triangles.patches
        },
        ..given.triangles.clone()
    };
    let recipe = HybridRecipe { triangles, polygons: given.polygons, ..paper };
    fit_with(mesh, &recipe, progress)
}
