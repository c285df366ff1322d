//! Xu, Huang & Bajaj 2001 as printed, to compare with [`super::apatch`].
//!
//! ```text
//! normals        of the file, or the limit of Loop's subdivision              §1
//! hull           apexes on the normals of the faces, at t_lm or above         §3.1
//!                where neighbours intersect, the Butterfly scheme divides
//!                the edge, and normals and tetrahedra are made again
//!                edge tetrahedra, tests of edges and faces                    §3.2
//! layers 0, 1    from vertices and normals, Steps 1 to 4                      §4.2
//! layer 2        least squares, Step 5
//! layer 3        nearest to a linear function, Steps 6 and 8
//! edges          Steps 7, 9 and 10
//! ```
//!
//! Nothing else is mended: no normal moves, no apex leans, no crease is made. Divisions may breed new faults instead of mending old
//! ones; the mesh with the fewest faulty faces is kept, after [`MOST_ROUNDS`] at the latest. Faces and edges that do not pass the
//! paper's own tests are among the repairs of the result ("surface not certain"), as are patches that turn over; a ray that meets no
//! sheet is an error of tessellation. Step 8 gives no quadric back but the plane.

use super::apatch::{APatchError, APatchRecipe, FittedMesh, NormalSource, fit as fit_with};
use super::triangulated::word;
use crate::apatch::{APatchOptions, Free, FreeRule, Layer2Rule};
use crate::base::Repair;
use crate::geom::Vec3;
use crate::hull::{ApexRule, HullOptions, Margin, Problem};
use crate::inspect::{APatchInspectOptions, inspect_a_patches};
use crate::io::read::PolygonMesh;
use crate::mesh::butterfly::{self, Divided};
use crate::mesh::{EdgeId, Place};

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
/// parameters to [`recipe`]. With free parameters for single faces no edge is divided.
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
    let first = fit_with(mesh, &recipe, progress)?;
    // Free parameters are for the faces as they are given.
    let may_divide = !matches!(recipe.patches.free, Free::PerFace(_));
    let mut fitted = if may_divide { divided(first, &recipe, progress) } else { first };
    fitted.repairs.extend(broken(&fitted));
    Ok(fitted)
}

/// Rounds of divisions at most, and the growth of the number of faces at which they end.
pub const MOST_ROUNDS: usize = 5;
const MOST_GROWTH: usize = 4;

/// The surface after the divisions that leave the fewest faulty faces, with a word about them: none if nothing is at fault.
fn divided(first: FittedMesh, recipe: &APatchRecipe, progress: &dyn Fn(&str)) -> FittedMesh {
    let faulty = |fitted: &FittedMesh| fitted.surface.function().hull().bad_faces().len();
    let (faces, faults) = (face_count(&first), faulty(&first));
    let (mut counts, mut best) = (vec![faults], None::<FittedMesh>);
    let mut finer = finer_mesh(&first);
    while let Some(mesh) =
        finer.filter(|m| m.faces.len() <= MOST_GROWTH * faces && counts.len() <= MOST_ROUNDS)
    {
        let Ok(next) = fit_with(&mesh, recipe, progress) else { break };
        counts.push(faulty(&next));
        finer = finer_mesh(&next);
        if faulty(&next) < best.as_ref().map_or(faults, faulty) {
            best = Some(next);
        }
    }
    if counts.len() == 1 {
        return first;
    }
    let told = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let (kept, which) = match best {
        Some(best) => (best, "elements of the repairs are those of the divided mesh"),
        None => (first, "nothing was gained, so the mesh stays as it is"),
    };
    let word = Repair {
        what: format!("Butterfly subdivision, {} faces instead of {faces}", face_count(&kept)),
        place: "where tetrahedra of neighbours intersect".into(),
        why: format!("the paper's repair; faulty faces in its rounds: {told}; {which}"),
    };
    FittedMesh { repairs: [vec![word], kept.repairs].concat(), ..kept }
}

fn face_count(fitted: &FittedMesh) -> usize {
    fitted.surface.function().hull().faces().len()
}

/// The mesh with those edges divided over which the tetrahedra of two faces intersect, or leave no room for those between them; none
/// if there are none. Normals are computed again; those of a file stay, and new vertices get Loop's.
fn finer_mesh(fitted: &FittedMesh) -> Option<PolygonMesh> {
    let hull = fitted.surface.function().hull();
    let (mesh, data) = (hull.data().mesh(), hull.data());
    let edge = |problem: &Problem| match problem {
        Problem::Edge { edge, .. } => Some(*edge),
        Problem::Vertex { .. } | Problem::Face { .. } => None,
    };
    let edges: Vec<EdgeId> = hull.problems().iter().filter_map(edge).collect();
    if edges.is_empty() {
        return None;
    }
    let Divided { positions, faces, .. } = butterfly::divide(mesh, data.positions(), &edges);
    let is_of_file = fitted.figures.normals.as_deref() == Some(NormalSource::File.name());
    let normals = is_of_file.then(|| {
        let given = |v| mesh.ring(v).next().map_or_else(Vec3::zeros, |h| data.gradient(h));
        let mut normals: Vec<Vec3> = mesh.vertices().map(given).collect();
        // No normal: the recipe computes one.
        normals.resize(positions.len(), Vec3::zeros());
        normals
    });
    Some(PolygonMesh { positions, faces: faces.iter().map(|f| f.to_vec()).collect(), normals })
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
