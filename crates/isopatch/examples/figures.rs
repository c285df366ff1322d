//! Makes every figure and table of the four papers, and a page that shows them.
//!
//! `cargo run --release -p isopatch --example figures -- docs/figures [MESHES]` runs the programs `paper_00N_figures`, each of which
//! writes pictures and a table, and gathers them: one folder of pictures for each paper, and `README.md`. The head and the teapot of
//! the paper of 2001 need the folder MESHES with `cgal_head.off` and `npm_teapot.off`.

use isopatch::io::png::write_png;
use isopatch::render::Image;
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A paper: the program that makes its figures, and what they show.
struct Paper {
    number: &'static str,
    title: &'static str,
    /// Beginning of the names of the pictures of a figure, and its caption.
    figures: &'static [(&'static str, &'static str)],
    /// The figures that show no surface.
    others: &'static str,
    takes_meshes: bool,
}

const PAPERS: [Paper; 4] = [
    Paper {
        number: "004",
        title: "Tong & Kim 2009: high-order approximation of implicit surfaces",
        figures: &[
            (
                "fig3_",
                "Fig. 3: the unit sphere over 20 triangles. Base mesh, curves, control nets of the G⁰ and of the G¹ surface, their reflection lines (the G⁰ surface shows kinks at the seams), the G¹ surface.",
            ),
            (
                "fig9_",
                "Fig. 9: torus on a regular mesh of 400 triangles. Curves, control nets, reflection lines of the paper's recipe and of the default recipe.",
            ),
            (
                "fig10_",
                "Fig. 10: torus on an irregular mesh of 600 triangles. The decimated mesh of the paper's recipe has slivers; the default recipe remeshes.",
            ),
            ("fig11_", "Fig. 11: dodecahedron surface, 1,200 triangles."),
            (
                "fig12_",
                "Fig. 12: double torus, 1,800 triangles, in gold that reflects black and white strips.",
            ),
            ("fig13_", "Fig. 13: McMullen's surface, 2,000 triangles."),
            (
                "fig14_",
                "Fig. 14: chair, 4,000 triangles. What the paper's recipe breaks stands in the table.",
            ),
            ("fig15_", "Fig. 15: decocube, 5,000 triangles."),
        ],
        others: "Figs. 1, 2 and 4 to 8 are drawings; PAPERS.md says where the code has them.",
        takes_meshes: false,
    },
    Paper {
        number: "000",
        title: "Xu, Huang & Bajaj 2001: C¹ modeling with A-patches",
        figures: &[
            (
                "fig2_",
                "Fig. 2: a family of surfaces, from just above the bound of the free parameter (blue, outside) to a large one (orange, near the mesh).",
            ),
            (
                "fig3_",
                "Fig. 3: 1e-9 above the bound of a nonconvex join, where a second sheet almost touches.",
            ),
            ("fig6_", "Fig. 6: two convex faces: tetrahedra and patches."),
            ("fig7_", "Fig. 7: a convex and a nonconvex face."),
            ("fig9_", "Fig. 9: two nonconvex faces with an edge patch between them."),
            ("fig10_", "Fig. 10: a plane joins a nonconvex patch smoothly."),
            ("fig12_", "Fig. 12: the icosahedron."),
            (
                "fig13_",
                "Fig. 13: isophotes. The neighbour rule gives the sphere, to rounding; with Step 8 as printed the surface is off by 3e-2.",
            ),
            (
                "fig14_15_",
                "Figs. 14, 15: another head: the mesh, patches over faces (blue) and edges (orange), the surface.",
            ),
            ("fig16_17_", "Figs. 16, 17: another teapot, the same."),
        ],
        others: "Figs. 1, 4, 5, 8 and 11 are drawings; PAPERS.md says where the code has them.",
        takes_meshes: true,
    },
    Paper {
        number: "001",
        title: "Xu, Bajaj & Evans: C¹ modeling with hybrid multiple-sided A-patches",
        figures: &[
            ("fig1.", "Fig. 1.1: a mesh of triangles, quadrilaterals and pentagons; its hull; patches."),
            ("fig6.1", "Fig. 6.1: quadrilaterals alone."),
            ("fig6.2", "Fig. 6.2: triangles and pentagons."),
            ("fig6.3", "Fig. 6.3: triangles and quadrilaterals, with the hull."),
        ],
        others: "Figs. 2.1 to 4.2 are drawings; PAPERS.md says where the code has them.",
        takes_meshes: false,
    },
    Paper {
        number: "002",
        title: "Bajaj & Xu 1997: spline approximations of real algebraic surfaces",
        figures: &[
            ("fig4", "Fig. 4: circular cone: triangulation, patches, shaded."),
            ("fig5", "Fig. 5: Cartan's umbrella."),
            ("fig6", "Fig. 6: a portion of Steiner's surface."),
            ("fig7", "Fig. 7: a toroidal surface."),
        ],
        others: "Figs. 1 to 3 are drawings; PAPERS.md says where the code has them.",
        takes_meshes: false,
    },
];

const HEAD: &str = "# Figures and tables of the four papers

Made by `cargo run --release -p isopatch --example figures -- docs/figures MESHES`; do not edit. Numbers of the papers stand beside
ours in the tables. Seconds are those of the machine that made this page.
";

fn main() -> Outcome<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().ok_or("usage: figures OUT [MESHES]")?;
    let meshes = arguments.next();
    let start = Instant::now();
    let mut page = HEAD.to_owned();
    for paper in &PAPERS {
        let made = make(paper, meshes.as_deref())?;
        let pictures = gather(&made, &folder.join(paper.number))?;
        describe(paper, &pictures, &fs::read_to_string(made.join("table.txt"))?, &mut page)?;
    }
    fs::write(folder.join("README.md"), page)?;
    println!("{}: all figures and tables in {:.0} s", folder.display(), start.elapsed().as_secs_f64());
    Ok(())
}

/// Runs the program of a paper, in the profile of this one, and gives the folder of what it wrote.
fn make(paper: &Paper, meshes: Option<&Path>) -> Outcome<PathBuf> {
    let name = format!("paper_{}_figures", paper.number);
    let out = std::env::temp_dir().join(format!("isopatch-{}-{name}", std::process::id()));
    fs::create_dir_all(&out)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--quiet", "-p", "isopatch", "--example", &name]);
    if !cfg!(debug_assertions) {
        command.arg("--release");
    }
    command.arg("--").arg(&out);
    if paper.takes_meshes {
        command.args(meshes);
    }
    let start = Instant::now();
    // Its table is written to a file as well.
    if !command.stdout(std::process::Stdio::null()).status()?.success() {
        return Err(format!("{name} failed").into());
    }
    println!("{name}: {:.0} s", start.elapsed().as_secs_f64());
    Ok(out)
}

/// Wider pictures are shrunk to half of their size: the page shows them smaller still, and the folder stays small.
const WIDEST: usize = 480;

/// Copies a picture, at half of its size if it is large.
fn shrunk(from: &Path, to: &Path) -> Outcome<()> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(from)?)).read_info()?;
    let mut rgb = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut rgb)?;
    let (width, height) = (info.width as usize, info.height as usize);
    if width <= WIDEST || info.color_type != png::ColorType::Rgb {
        fs::copy(from, to)?;
        return Ok(());
    }
    let half = [width / 2, height / 2];
    let at = |x: usize, y: usize, c: usize| u32::from(rgb[3 * (y * width + x) + c]);
    let mean = |x: usize, y: usize, c: usize| {
        (at(2 * x, 2 * y, c)
            + at(2 * x + 1, 2 * y, c)
            + at(2 * x, 2 * y + 1, c)
            + at(2 * x + 1, 2 * y + 1, c))
            / 4
    };
    let pixels = (0..half[1]).flat_map(|y| (0..half[0]).map(move |x| (x, y)));
    let small = pixels.flat_map(|(x, y)| [0, 1, 2].map(|c| mean(x, y, c) as u8)).collect();
    let image = Image { width: half[0], height: half[1], rgb: small };
    Ok(write_png(&image, &mut BufWriter::new(File::create(to)?))?)
}

/// Moves the pictures into the gallery, and gives their names in order.
fn gather(made: &Path, into: &Path) -> Outcome<Vec<String>> {
    if into.is_dir() {
        fs::remove_dir_all(into)?;
    }
    fs::create_dir_all(into)?;
    let mut names = Vec::new();
    for entry in fs::read_dir(made)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if name.ends_with(".png") {
            shrunk(&path, &into.join(&name))?;
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// The part of the page for a paper.
fn describe(paper: &Paper, pictures: &[String], table: &str, page: &mut String) -> Outcome<()> {
    let Paper { number, title, figures, others, .. } = paper;
    writeln!(page, "\n## {title}\n")?;
    let mut shown = 0;
    for (beginning, caption) in *figures {
        let of_figure: Vec<&String> = pictures.iter().filter(|name| name.starts_with(beginning)).collect();
        let missing = if of_figure.is_empty() { " (Not made in this run.)" } else { "" };
        writeln!(page, "{caption}{missing}\n")?;
        for name in &of_figure {
            writeln!(
                page,
                "<img src=\"{number}/{name}\" width=\"240\" alt=\"{}\">",
                name.trim_end_matches(".png")
            )?;
        }
        if !of_figure.is_empty() {
            writeln!(page)?;
        }
        shown += of_figure.len();
    }
    if shown < pictures.len() {
        return Err(format!("paper {number}: {} pictures belong to no figure", pictures.len() - shown).into());
    }
    writeln!(page, "{others}\n\n```\n{}\n```", table.trim_end())?;
    Ok(())
}
