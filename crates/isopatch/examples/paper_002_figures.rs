//! Draws Figs. 4 to 7 of Bajaj & Xu 1997: the four surfaces of its section 6.3, in its boxes, and a table of their numbers.
//!
//! `cargo run --release --example paper_002_figures -- OUT` writes into the folder OUT, for each figure, its three panels as pictures: the
//! triangulation (`_a_triangulation.png`), the patches (`_b_patches.png`) and the shaded surface (`_c_shaded.png`); and `table.txt`.

use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Vec3};
use isopatch::inspect::{InspectOptions, inspect_rational};
use isopatch::io::png::write_png;
use isopatch::recipes::algebraic::{AlgebraicRecipe, FittedAlgebraic, fit};
use isopatch::recipes::spline::Size;
use isopatch::render::{RenderOptions, Style, Subject, draw, of_polygons, scene};
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
}

/// The toroidal box begins at −1.2, as in the paper.
const FIGURES: [Figure; 4] = [
    Figure {
        name: "fig4_cone",
        formula: "x^2 + y^2 - z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 190,
    },
    Figure {
        name: "fig5_cartan_umbrella",
        formula: "x^2 - y*z^2",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 280,
    },
    Figure {
        name: "fig6_steiner",
        formula: "x^2*y^2 + y^2*z^2 + x^2*z^2 - 4*x*y*z",
        bounds: [[-3.0, -3.0, -2.0], [3.0, 3.0, 2.0]],
        patches: 370,
    },
    Figure {
        name: "fig7_toroidal",
        formula: "(y^2 + z^2 - x^2 + 0.5*x^3 - 4)^2 - 16*x^2 + 8*x^3",
        bounds: [[-1.2, -4.0, -4.0], [4.0, 4.0, 4.0]],
        patches: 540,
    },
];

/// Intervals along the edges of patches in panels b and c.
const RESOLUTION: usize = 12;
/// Width and height of a panel.
const SIZE: [usize; 2] = [600, 450];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: paper_002_figures OUT")?);
    fs::create_dir_all(&folder)?;
    let mut table = String::from(
        "surface, patches, of the paper, distance, normal jump (rad), folded, edges on singular curves\n",
    );
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
        size: Size::Faces(figure.patches),
        ..AlgebraicRecipe::default()
    };
    let FittedAlgebraic { surface, mesh, .. } = fit(&formula, &recipe, &|_| ())?;
    let panel = |name: &str, shown: &Tessellation, style: Style| {
        picture(shown, style, &folder.join(format!("{}_{name}.png", figure.name)))
    };
    panel("a_triangulation", &of_polygons(&mesh.positions, &mesh.triangles, None), Style::Mesh)?;
    let fine = tessellate(&surface, &TessellateOptions { resolution: RESOLUTION })?;
    panel("b_patches", &fine, Style::Patches)?;
    panel("c_shaded", &fine, Style::Shaded)?;
    let options = InspectOptions { back_samples: 0, intersection_lattice: 0, ..InspectOptions::default() };
    let found = inspect_rational(&surface, Some(&formula), &options);
    let distance =
        found.common.deviation.as_ref().map_or(f64::NAN, |d| d.max_first_order * found.common.diagonal);
    writeln!(
        table,
        "{}, {}, {}, {distance:.2e}, {:.1e}, {}, {}",
        figure.name,
        found.common.patches,
        figure.patches,
        found.common.seams.max_normal_jump,
        found.folded.len(),
        mesh.singular_edges.len(),
    )?;
    Ok(())
}

fn picture(shown: &Tessellation, style: Style, path: &Path) -> Result<(), Box<dyn Error>> {
    let image = draw(
        &scene(shown, &Subject::default(), style)?,
        &RenderOptions { size: SIZE, ..RenderOptions::default() },
    )?;
    Ok(write_png(&image, &mut BufWriter::new(File::create(path)?))?)
}
