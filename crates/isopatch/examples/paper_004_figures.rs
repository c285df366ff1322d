//! Makes the tables and figures of Tong & Kim 2009: Tables 1 to 3 as text, Figs. 3 and 9 to 15 as pictures.
//!
//! `cargo run --release --example paper_004_figures -- OUT` writes PNG files and `table.txt` into the folder OUT. Surfaces are those of
//! `--recipe paper`; those of the default recipe stand beside them. Figs. 1, 2 and 4 to 8 show no surface.

use isopatch::base::{self, BaseOptions, BaseOutcome, FieldTarget};
use isopatch::bernstein::curve;
use isopatch::field::{Constants, Field, Formula};
use isopatch::gallery;
use isopatch::geom::{Aabb, Point3, Vec3};
use isopatch::inspect::{InspectOptions, deviation, inspect};
use isopatch::io::png::write_png;
use isopatch::io::read::{PolygonMesh, read_mesh};
use isopatch::network::{QuarticCurve, fit_quartics};
use isopatch::recipes::paper_spline::{self, curve_options};
use isopatch::recipes::spline::{Size, SplineRecipe, fit};
use isopatch::render::{Color, LineSet, Paint, RenderOptions, Scene, Style, Subject, draw, scene};
use isopatch::report::{Seconds, peak_memory_bytes};
use isopatch::spline::condition::Degrees;
use isopatch::spline::{Construction, SampledFrom, ShapeParameters, TriangularSpline};
use isopatch::surface::Surface;
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A line of Table 3: iterations, seconds (polygonization, decimation, network, G0, vertex and edge systems, all) and kilobytes.
struct Printed {
    iterations: f64,
    seconds: [f64; 7],
    memory: u32,
}

/// A model of section 8.
struct Model {
    figure: u32,
    /// Name in the gallery.
    surface: &'static str,
    /// File of a given base mesh, in the folder `models`.
    given: Option<&'static str>,
    printed: Printed,
}

const MODELS: [Model; 7] = [
    Model {
        figure: 9,
        surface: "torus",
        given: Some("torus-20x10.off"),
        printed: Printed {
            iterations: 2.40,
            seconds: [0.0, 0.0, 0.22, 1.33, 0.05, 0.11, 1.71],
            memory: 25_320,
        },
    },
    Model {
        figure: 10,
        surface: "torus",
        given: None,
        printed: Printed {
            iterations: 2.47,
            seconds: [0.11, 0.52, 0.33, 1.97, 0.06, 0.16, 3.15],
            memory: 26_760,
        },
    },
    Model {
        figure: 11,
        surface: "dodeca",
        given: None,
        printed: Printed {
            iterations: 2.32,
            seconds: [0.14, 0.83, 0.56, 3.85, 0.14, 0.33, 5.85],
            memory: 30_092,
        },
    },
    Model {
        figure: 12,
        surface: "dtorus",
        given: None,
        printed: Printed {
            iterations: 2.23,
            seconds: [0.20, 1.06, 0.83, 5.70, 0.24, 0.47, 8.50],
            memory: 33_152,
        },
    },
    Model {
        figure: 13,
        surface: "mcmullen",
        given: None,
        printed: Printed {
            iterations: 2.20,
            seconds: [0.27, 1.65, 0.92, 6.35, 0.25, 0.53, 9.97],
            memory: 34_968,
        },
    },
    Model {
        figure: 14,
        surface: "chair",
        given: None,
        printed: Printed {
            iterations: 2.32,
            seconds: [0.55, 2.91, 3.17, 14.80, 0.50, 1.06, 22.99],
            memory: 37_080,
        },
    },
    Model {
        figure: 15,
        surface: "decocube",
        given: None,
        printed: Printed {
            iterations: 2.40,
            seconds: [0.71, 3.52, 7.70, 23.99, 0.61, 1.36, 37.89],
            memory: 39_804,
        },
    },
];

/// The stages of Table 3 by their names in the report of the recipe.
const STAGES: [&str; 6] =
    ["polygonization", "decimation", "curves", "G0 patches", "vertex systems", "edge systems"];

/// Lines of Table 1, with those around them that section 7 speaks of: r, s, m, n.
const TABLE_1: [[usize; 4]; 9] = [
    [1, 2, 4, 5],
    [1, 3, 4, 6],
    [1, 4, 4, 7],
    [1, 5, 4, 8],
    [1, 2, 5, 6],
    [1, 3, 5, 7],
    [1, 4, 5, 8],
    [1, 4, 3, 6],
    [2, 4, 4, 6],
];

/// Width and height of the pictures.
const SIZE: [usize; 2] = [320, 240];
/// One colour behind them, which takes fewer bytes than two.
const BACKGROUND: u32 = 0xf4f6f8;
/// Intervals along the edges of patches, in pictures of many patches and of few.
const FINE: usize = 6;
const FINER: usize = 24;
/// Pieces of a boundary curve in pictures.
const PIECES: usize = 24;
/// Colours of lines, and of a surface behind them.
const INK: u32 = 0x2c3640;
const PALE: u32 = 0xeef1f5;
/// Thickness of the boundary curves, as in [`LineSet`].
const NETWORK_WIDTH: f64 = 2.4;
/// Formula and number of faces of Fig. 3.
const SPHERE: (&str, usize) = ("x^2+y^2+z^2-1", 20);

fn main() -> Outcome<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: paper_004_figures OUT")?);
    fs::create_dir_all(&folder)?;
    let mut text = String::new();
    table_1(&mut text)?;
    table_2(&mut text)?;
    // As in the paper, one processor; and before there are pictures in memory.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let made = || MODELS.iter().map(Made::new).collect::<Outcome<Vec<Made>>>().map_err(|e| e.to_string());
    let made = one.install(made)?;
    table_3(&made, &mut text)?;
    let figures = Figures { folder };
    figures.sphere()?;
    for (model, made) in MODELS.iter().zip(&made) {
        figures.model(model, made, &mut text)?;
    }
    fs::write(figures.folder.join("table.txt"), &text)?;
    print!("{text}");
    Ok(())
}

/// The degrees of Table 1 with what keeps their systems from being local.
fn table_1(text: &mut String) -> Outcome<()> {
    writeln!(text, "Table 1: degrees r of λ, s of μ, m of curves, n of patches")?;
    writeln!(
        text,
        " r  s  m  n   rows of an edge, points, free μ; free points   in the way of local systems"
    )?;
    for [r, s, m, n] in TABLE_1 {
        let degrees = Degrees::new(r, s, m, n)?;
        let obstacles = degrees.obstacles();
        let why = if obstacles.is_empty() { "nothing".to_owned() } else { format!("{obstacles:?}") };
        writeln!(
            text,
            " {r}  {s}  {m}  {n}   {:15}{:8}{:8}{:13}   {why}",
            degrees.edge_rows().len(),
            2 * degrees.edge_points().len(),
            degrees.free_mu(),
            degrees.free_points(),
        )?;
    }
    Ok(())
}

/// Table 2 from the general rows: the factor of each pair of points is found with one coefficient of λ or μ at a time.
fn table_2(text: &mut String) -> Outcome<()> {
    let degrees = Degrees::PAPER;
    writeln!(text, "\nTable 2: the rows of (3); λ̄ = 1 − λ, μ̄ = 1 − μ")?;
    let unit = |count: usize, i: usize| (0..count).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
    for k in 0..degrees.rows() {
        let mut sides = [Vec::new(), Vec::new()];
        for i in 0..2 {
            let row = degrees.row(k, &unit(2, i), &[0.0; 5]).ok_or("no row")?;
            let factors = row.r.iter().enumerate().filter(|(_, factor)| **factor != 0.0);
            sides[0].extend(factors.map(|(j, factor)| format!("{factor}(λ̄{i} p{j} + λ{i} r{j})")));
        }
        for i in 0..5 {
            let (with, without) =
                (degrees.row(k, &[0.0; 2], &unit(5, i)), degrees.row(k, &[0.0; 2], &[0.0; 5]));
            let (with, without) = (with.ok_or("no row")?, without.ok_or("no row")?);
            // μ̄ goes to q_j, μ to q_(j + 1).
            for j in 0..4 {
                let factor = without.q[j] - with.q[j];
                if factor > 0.0 {
                    sides[1].push(format!("{factor}(μ̄{i} q{j} + μ{i} q{})", j + 1));
                }
            }
        }
        writeln!(text, "k = {k}:  {}  =  {}", sides[0].join(" + "), sides[1].join(" + "))?;
    }
    Ok(())
}

/// A model as made by the paper's recipe, with its line of Table 3.
struct Made {
    field: Formula,
    bounds: Option<Aabb>,
    surface: TriangularSpline,
    iterations: f64,
    unconverged: usize,
    seconds: [f64; 7],
    memory: u64,
}

impl Made {
    fn new(model: &Model) -> Outcome<Self> {
        reset_peak_memory();
        let entry = gallery::surface(model.surface).ok_or("no such surface")?;
        let field = entry.field()?;
        let mut clock = Seconds::default();
        let (surface, iterations, unconverged) = match model.given {
            Some(file) => {
                let made = given_base(&field, file)?;
                let (curves, surface) = over(made, &field, &mut clock)?;
                let mean = curves.iter().map(|c| c.steps).sum::<usize>() as f64 / curves.len() as f64;
                (surface, mean, curves.iter().filter(|c| c.sqp_failed).count())
            }
            None => {
                let fitted = paper_spline::fit(&field, entry.bounds, Some(entry.faces), &|_| ())?;
                clock.append(&fitted.seconds);
                (fitted.surface, fitted.figures.sqp_iterations_mean, fitted.figures.sqp_unconverged)
            }
        };
        let total = clock.total();
        let of = |stage: &str| {
            clock.stages().iter().filter(|(name, _)| name == stage).fold(0.0, |sum, (_, s)| sum + s)
        };
        let [a, b, c, d, e, f] = STAGES.map(of);
        let memory = peak_memory_bytes().unwrap_or(0);
        let seconds = [a, b, c, d, e, f, total];
        Ok(Self { field, bounds: entry.bounds, surface, iterations, unconverged, seconds, memory })
    }
}

/// Where the system lets a process do so, its largest memory is that of one model, not of all before.
fn reset_peak_memory() {
    // Without it, numbers grow from line to line, which the table says.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

fn given_base(field: &Formula, file: &str) -> Outcome<BaseOutcome> {
    let grid = given_mesh(file)?;
    Ok(base::from_mesh(field, &grid.positions, &grid.faces, &BaseOptions::default())?)
}

/// Steps (ii) to (v) over a base mesh.
fn over(
    made: BaseOutcome,
    field: &Formula,
    clock: &mut Seconds,
) -> Outcome<(Vec<QuarticCurve>, TriangularSpline)> {
    let target = FieldTarget::new(field, made.base.diagonal());
    let curves = clock.measure("curves", || fit_quartics(&made.base, &target, &curve_options()))?;
    let shape = ShapeParameters::default();
    let g0 = || Construction::new(made.base, &curves, &target, SampledFrom::Flat);
    let mut work = clock.measure("G0 patches", g0);
    clock.measure("vertex systems", || work.solve_vertices(&shape))?;
    clock.measure("edge systems", || work.solve_edges(&shape, &[]))?;
    work.refit_free_points();
    Ok((curves, work.finish()))
}

fn table_3(made: &[Made], text: &mut String) -> Outcome<()> {
    writeln!(
        text,
        "\nTable 3: seconds and memory; printed numbers (Pentium IV, 3.6 GHz) in the second line of each model"
    )?;
    writeln!(
        text,
        "Fig.  polygon.  decim.  faces  network  iterations  G0       vertices  edges   memory    total"
    )?;
    for (model, made) in MODELS.iter().zip(made) {
        let faces = made.surface.patch_count();
        let mut line = |figure: &str, s: &[f64; 7], iterations: f64, kilobytes: u64| {
            writeln!(
                text,
                "{figure:4}  {:8.3}  {:6.3}  {faces:5}  {:7.3}  {iterations:10.2}  {:7.3}  {:8.4}  {:6.4}  {kilobytes:6} K  {:6.3}",
                s[0], s[1], s[2], s[3], s[4], s[5], s[6]
            )
        };
        line(&model.figure.to_string(), &made.seconds, made.iterations, made.memory / 1024)?;
        let printed = &model.printed;
        line("", &printed.seconds, printed.iterations, printed.memory.into())?;
    }
    writeln!(
        text,
        "\nWhat the paper's recipe breaks, beside the default recipe (distances relative to the diagonal)"
    )?;
    Ok(())
}

/// Where the pictures go.
struct Figures {
    folder: PathBuf,
}

impl Figures {
    /// Fig. 3, the unit sphere: base mesh, network, G0 and G1 surfaces with nets and with reflection lines, G1 surface.
    fn sphere(&self) -> Outcome<()> {
        let (formula, faces) = SPHERE;
        let field = Formula::parse(formula, &Constants::new())?;
        let bounds = base::find_box(&field)?;
        let options = BaseOptions { faces: Some(faces), ..BaseOptions::default() };
        let made = base::build(&field, &bounds, &options)?;
        let target = FieldTarget::new(&field, made.base.diagonal());
        let curves = fit_quartics(&made.base, &target, &curve_options())?;
        let g0 = Construction::new(made.base.clone(), &curves, &target, SampledFrom::Flat).finish();
        let (_, g1) = over(made, &field, &mut Seconds::default())?;

        let flat = base_mesh(&g1);
        self.draw("fig3_a_base_mesh", &scene(&flat, &Subject::default(), Style::Mesh)?)?;
        let ball = fine(&g1, FINER)?;
        let pale = Color::srgb(PALE);
        let mut network = Scene::new(&ball, Paint::Plain { outside: pale, inside: pale });
        network.lines.push(network_of(&g1));
        self.draw("fig3_b_network", &network)?;
        for (name, surface) in [("c_g0", &g0), ("d_g1", &g1)] {
            self.style(&format!("fig3_{name}_b_net"), surface, Style::Net, FINER)?;
        }
        for (name, surface) in [("e_g0", &g0), ("f_g1", &g1)] {
            self.style(&format!("fig3_{name}_reflection"), surface, Style::Reflection, FINER)?;
        }
        self.style("fig3_g_g1", &g1, Style::Shaded, FINER)
    }

    /// Network; nets and reflection lines (Figs. 9 to 11) or gold (12 to 15); and the surface of the default recipe.
    fn model(&self, model: &Model, made: &Made, text: &mut String) -> Outcome<()> {
        let name = format!("fig{}_{}", model.figure, model.surface);
        let surface = &made.surface;
        self.style(&format!("{name}_a_network"), surface, Style::Mesh, FINE)?;
        let style = if model.figure < 12 { Style::Reflection } else { Style::Gold };
        if model.figure < 12 {
            self.style(&format!("{name}_b_net"), surface, Style::Net, FINE)?;
        }
        self.style(&format!("{name}_c_paper"), surface, style, 2 * FINE)?;

        let entry = gallery::surface(model.surface).ok_or("no such surface")?;
        let given = model.given.map(given_mesh).transpose()?;
        let recipe = SplineRecipe {
            bounds: entry.bounds,
            size: Size::Faces(entry.faces),
            given,
            ..Default::default()
        };
        let ours = fit(&made.field, &recipe, &|_| ())?;
        self.style(&format!("{name}_d_default"), &ours.surface, style, 2 * FINE)?;
        for (recipe, surface) in [("paper", surface), ("default", &ours.surface)] {
            self.describe(model, recipe, surface, made, text)?;
        }
        Ok(())
    }

    fn describe(
        &self,
        model: &Model,
        recipe: &str,
        surface: &TriangularSpline,
        made: &Made,
        text: &mut String,
    ) -> Outcome<()> {
        let options = InspectOptions {
            region: made.bounds,
            back_samples: 0,
            intersection_lattice: 0,
            ..InspectOptions::default()
        };
        let found = inspect(surface, &surface.base, None::<&dyn Field>, &options);
        let measured = deviation(surface, &made.field, surface.base.diagonal(), options.lattice);
        let folded = measured.folded;
        let unconverged = if recipe == "paper" { made.unconverged } else { 0 };
        writeln!(
            text,
            "Fig. {:2} {:8} {recipe:7}: largest distance {:.1e}, root mean square {:.1e}, normals {:6.2}°, seams {:.0e} rad, {folded} patches fold, {unconverged} curves unconverged",
            model.figure,
            model.surface,
            measured.max_first_order,
            measured.rms_first_order,
            measured.max_normal_error.to_degrees(),
            found.seams.max_normal_jump,
        )?;
        Ok(())
    }

    fn style(&self, name: &str, surface: &TriangularSpline, style: Style, resolution: usize) -> Outcome<()> {
        let mesh = fine(surface, resolution)?;
        let subject = Subject { surface: Some(surface), ..Subject::default() };
        self.draw(name, &scene(&mesh, &subject, style)?)
    }

    fn draw(&self, name: &str, scene: &Scene<'_>) -> Outcome<()> {
        let background = [Color::srgb(BACKGROUND); 2];
        let image = draw(scene, &RenderOptions { size: SIZE, background, ..RenderOptions::default() })?;
        write_png(&image, &mut BufWriter::new(File::create(self.folder.join(format!("{name}.png")))?))?;
        Ok(())
    }
}

/// The boundary curves.
fn network_of(surface: &TriangularSpline) -> LineSet {
    let at = |i: usize| i as f64 / PIECES as f64;
    let pieces = |q: &[Point3; 5]| {
        let q = *q;
        (0..PIECES).map(move |i| [curve::point(&q, at(i)), curve::point(&q, at(i + 1))])
    };
    let segments = surface.curves.iter().flat_map(pieces).collect();
    LineSet { segments, color: Color::srgb(INK), width: NETWORK_WIDTH, hidden: 0.2 }
}

/// The base mesh as flat triangles, each with its own normal.
fn base_mesh(surface: &TriangularSpline) -> Tessellation {
    let base = &surface.base;
    let corners: Vec<[Point3; 3]> =
        base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| base.positions[v.index()])).collect();
    let normal = |[a, b, c]: &[Point3; 3]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::z);
    Tessellation {
        positions: corners.iter().flatten().copied().collect(),
        normals: corners.iter().flat_map(|t| [normal(t); 3]).collect(),
        triangles: (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        corner_normals: Vec::new(),
        patches: surface.patches().collect(),
    }
}

fn given_mesh(file: &str) -> Outcome<PolygonMesh> {
    Ok(read_mesh(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(file))?)
}

fn fine(surface: &TriangularSpline, resolution: usize) -> Outcome<Tessellation> {
    Ok(tessellate(surface, &TessellateOptions { resolution })?)
}
