//! Makes the four surfaces of Bajaj & Xu 1997, section 6.3, in its boxes, and a table of their numbers.
//!
//! `cargo run --release --example paper_002_figures -- OUT` writes into the folder OUT, for each of Figs. 4 to 7: the triangulation
//! (`_triangulation.ply`, panel a), the patches with the number of the patch of each small triangle (`_patches.vtu`, panel b), the surface
//! with its normals (`_shaded.glb`, panel c), a STEP file, and `table.txt`.

use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Vec3};
use isopatch::inspect::{InspectOptions, inspect_rational};
use isopatch::io::gltf::{GlbOptions, write_glb};
use isopatch::io::ply::write_ply;
use isopatch::io::step::{StepOptions, write_step};
use isopatch::io::vtk::write_vtk_mesh;
use isopatch::recipes::algebraic::{AlgebraicRecipe, FittedAlgebraic, fit};
use isopatch::singular::mesh::{SingularMesh, TriangulateOptions};
use isopatch::surface::PatchId;
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A surface of the paper.
struct Figure {
    name: &'static str,
    formula: &'static str,
    /// Smallest and largest coordinates of the box.
    bounds: [[f64; 3]; 2],
    /// Number of patches in the paper.
    patches: usize,
    /// Distance of the flat triangles, relative to the diagonal of the box, that makes about as many here.
    tolerance: f64,
}

/// The toroidal box begins at −1.2, as in the paper.
const FIGURES: [Figure; 4] = [
    Figure {
        name: "fig4_cone",
        formula: "x^2 + y^2 - z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 190,
        tolerance: 5e-3,
    },
    Figure {
        name: "fig5_cartan_umbrella",
        formula: "x^2 - y*z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 280,
        tolerance: 5e-3,
    },
    Figure {
        name: "fig6_steiner",
        formula: "x^2*y^2 + y^2*z^2 + x^2*z^2 - 4*x*y*z",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 370,
        tolerance: 5e-3,
    },
    Figure {
        name: "fig7_toroidal",
        formula: "(y^2 + z^2 - x^2 + 0.5*x^3 - 4)^2 - 16*x^2 + 8*x^3",
        bounds: [[-1.2, -4.0, -4.0], [4.0, 4.0, 4.0]],
        patches: 540,
        tolerance: 5e-3,
    },
];

/// Intervals along the edges of patches in panels b and c.
const RESOLUTION: usize = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: paper_002_figures OUT")?);
    fs::create_dir_all(&folder)?;
    let mut table =
        String::from("surface, patches, of the paper, distance, normal jump (rad), sheets share curves\n");
    for figure in &FIGURES {
        make(figure, &folder, &mut table)?;
    }
    fs::write(folder.join("table.txt"), &table)?;
    print!("{table}");
    Ok(())
}

fn make(figure: &Figure, folder: &Path, table: &mut String) -> Result<(), Box<dyn Error>> {
    let formula = Formula::parse(figure.formula, &Constants::new())?;
    let [min, max] = figure.bounds.map(Vec3::from);
    let recipe = AlgebraicRecipe {
        bounds: Some(Aabb::new(min, max)),
        mesh: TriangulateOptions { tolerance: figure.tolerance, ..TriangulateOptions::default() },
        ..AlgebraicRecipe::default()
    };
    let FittedAlgebraic { surface, mesh, .. } = fit(&formula, &recipe, &|_| ())?;
    let file = |ending: &str| -> std::io::Result<BufWriter<File>> {
        Ok(BufWriter::new(File::create(folder.join(format!("{}{ending}", figure.name)))?))
    };
    write_ply(&flat(&mesh), &mut file("_triangulation.ply")?)?;
    let fine = tessellate(&surface, &TessellateOptions { resolution: RESOLUTION })?;
    write_vtk_mesh(&fine, &mut file("_patches.vtu")?)?;
    write_glb(&fine, &GlbOptions::default(), &mut file("_shaded.glb")?)?;
    write_step(&surface, &StepOptions::default(), &mut file(".step")?)?;
    let options = InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect_rational(&surface, Some(&formula), &options);
    let distance =
        found.common.deviation.as_ref().map_or(f64::NAN, |d| d.max_first_order * found.common.diagonal);
    writeln!(
        table,
        "{}, {}, {}, {distance:.2e}, {:.1e}, {}",
        figure.name,
        found.common.patches,
        figure.patches,
        found.common.seams.max_normal_jump,
        mesh.singular_edges.len(),
    )?;
    Ok(())
}

/// The mesh itself, each triangle with its own normal.
fn flat(mesh: &SingularMesh) -> Tessellation {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::z)
    };
    Tessellation {
        positions: mesh.triangles.iter().flat_map(corners).collect(),
        normals: mesh.triangles.iter().flat_map(|t| [normal(t); 3]).collect(),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        corner_normals: Vec::new(),
        patches: (0..mesh.triangles.len() as u32).map(PatchId).collect(),
    }
}
