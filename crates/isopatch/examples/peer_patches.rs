//! Evaluates and writes patches on request, for the comparison with other programs: see `benches/peers`.
//!
//! It prints `ready`, then reads requests, one a line, with tabs between the words, and answers each with a line of figures.
//! Seconds are CPU seconds on one thread.
//!
//! - `grid PATCHES N`, `anywhere PATCHES N`: points with normals on the lattice with N intervals of each patch of a torus, at
//!   parameters that are known before, or that may be any.
//! - `write PATCHES`: that torus as STEP into memory.
//! - `patches PATCHES`: that torus from its formula.
//! - `step FILE`: the spline through a mesh, as STEP into a file.

use cpu_time::ProcessTime;
use isopatch::bernstein::lanes::{TangentsMut, TriangleGrid};
use isopatch::bernstein::triangle;
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Point3, Points};
use isopatch::io::read::read_mesh;
use isopatch::io::step::{StepOptions, write_step};
use isopatch::recipes::mesh_spline::{self, MeshSplineRecipe};
use isopatch::recipes::spline::{Effort, Size, SplineRecipe, fit};
use isopatch::spline::{DEGREE, TriangularSpline};
use isopatch::surface::{PatchId, Sample, Surface};
use std::error::Error;
use std::io::{self, BufRead, BufWriter, Write};

type Answer = Result<String, Box<dyn Error>>;

/// As the command line buffers its files.
const BUFFER: usize = 1 << 16;

const TORUS: &str = "(sqrt(x^2+y^2)-5)^2+z^2-1";

fn torus(patches: usize) -> Result<TriangularSpline, Box<dyn Error>> {
    let formula = Formula::parse(TORUS, &Constants::new())?;
    let bounds = Some(Aabb::new(Point3::new(-6.5, -6.5, -1.5), Point3::new(6.5, 6.5, 1.5)));
    let size = Size::Faces(patches);
    let recipe = SplineRecipe { bounds, size, effort: Effort::Quick, ..SplineRecipe::default() };
    Ok(fit(&formula, &recipe, &|_| ())?.surface)
}

/// The second of two runs: the first touches all memory.
fn second_time(mut run: impl FnMut()) -> f64 {
    run();
    let start = ProcessTime::now();
    run();
    start.elapsed().as_secs_f64()
}

/// The torus of the last request, which most often is that of the next one.
#[derive(Default)]
struct Served {
    made: Option<(usize, TriangularSpline)>,
}

impl Served {
    fn torus(&mut self, patches: &str) -> Result<&TriangularSpline, Box<dyn Error>> {
        let patches = patches.parse()?;
        if self.made.as_ref().is_none_or(|(n, _)| *n != patches) {
            self.made = Some((patches, torus(patches)?));
        }
        self.made.as_ref().map(|(_, surface)| surface).ok_or_else(|| "no torus".into())
    }

    fn grid(&mut self, patches: &str, n: usize) -> Answer {
        let surface = self.torus(patches)?;
        let grid = TriangleGrid::new(DEGREE, &triangle::lattice(n));
        let count = grid.len() * surface.nets.len();
        let (mut points, mut normals) = (Points::zeros(count), Points::zeros(count));
        let seconds = second_time(|| {
            for (patch, net) in surface.nets.iter().enumerate() {
                let range = patch * grid.len()..(patch + 1) * grid.len();
                let normals = Some(normals.slice_mut(range.clone()));
                let points = points.slice_mut(range);
                grid.evaluate(net, TangentsMut { points, derivatives: None, normals });
            }
        });
        Ok(format!("seconds={seconds}\tpoints={count}"))
    }

    fn anywhere(&mut self, patches: &str, n: usize) -> Answer {
        let surface = self.torus(patches)?;
        let places: Vec<[f64; 2]> = triangle::lattice(n).iter().map(|[u, v, _]| [*u, *v]).collect();
        let zero = Point3::zeros();
        let nothing = Sample { point: zero, normal: zero, du: zero, dv: zero };
        let mut out = vec![nothing; places.len() * surface.nets.len()];
        let seconds = second_time(|| {
            for (patch, out) in out.chunks_exact_mut(places.len()).enumerate() {
                surface.sample_batch(PatchId(patch as u32), &places, out);
            }
        });
        Ok(format!("seconds={seconds}\tpoints={}", out.len()))
    }

    fn write(&mut self, patches: &str) -> Answer {
        let surface = self.torus(patches)?;
        let mut file = Vec::new();
        let mut result = Ok(());
        let seconds = second_time(|| {
            file.clear();
            result = write_step(surface, &StepOptions::default(), &mut file);
        });
        result?;
        Ok(format!("seconds={seconds}\tbytes={}", file.len()))
    }

    fn answer(&mut self, line: &str) -> Answer {
        match line.trim_end().split('\t').collect::<Vec<_>>()[..] {
            ["grid", patches, n] => self.grid(patches, n.parse()?),
            ["anywhere", patches, n] => self.anywhere(patches, n.parse()?),
            ["write", patches] => self.write(patches),
            ["patches", patches] => made(patches.parse()?),
            ["step", file] => step(file),
            _ => Err("no such request".into()),
        }
    }
}

fn made(patches: usize) -> Answer {
    let start = ProcessTime::now();
    let surface = torus(patches)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(format!("seconds={seconds}\tpatches={}", surface.nets.len()))
}

fn step(path: &str) -> Answer {
    let mesh = read_mesh(path.as_ref())?;
    let start = ProcessTime::now();
    let fitted = mesh_spline::fit(&mesh, &MeshSplineRecipe::default(), &|_| ())?;
    let fit = start.elapsed().as_secs_f64();
    let mut out = BufWriter::with_capacity(BUFFER, tempfile::tempfile()?);
    write_step(&fitted.surface, &StepOptions::default(), &mut out)?;
    let file = out.into_inner()?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes = file.metadata()?.len();
    Ok(format!("seconds={seconds}\tfit={fit}\twrite={}\tbytes={bytes}", seconds - fit))
}

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let mut served = Served::default();
    let mut out = io::stdout().lock();
    writeln!(out, "ready")?;
    for line in io::stdin().lock().lines() {
        let text = served.answer(&line?).unwrap_or_else(|error| format!("error={error}"));
        writeln!(out, "{text}")?;
        out.flush()?;
    }
    Ok(())
}
