//! Makes surfaces on request, for the comparison with other programs: see `benches/peers`.
//!
//! It prints `ready`, then reads requests, one a line: name, formula, box (six numbers), tolerance and output file (or `-`),
//! with tabs between; it answers with the CPU seconds of parsing and fitting, the bytes of the control points and
//! corners, each stored once, the bytes of the native file, the number of patches, and the wall seconds of every stage; or with
//! `error` and why.
//! Its arguments are the effort, `quick` or `full`, and the number of threads.

use cpu_time::ProcessTime;
use isopatch::field::{Constants, Formula};
use isopatch::geom::{Aabb, Point3};
use isopatch::io::native::{Provenance, write_native};
use isopatch::recipes::spline::{Effort, Size, SplineRecipe, fit};
use isopatch::spline::TriangularSpline;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, BufRead, BufWriter, Write};
use std::time::Instant;

/// What is asked for in a line.
struct Request<'a> {
    formula: &'a str,
    bounds: Aabb,
    tolerance: f64,
    output: &'a str,
}

impl<'a> Request<'a> {
    fn read(line: &'a str) -> Result<Self, Box<dyn Error>> {
        let words: Vec<&str> = line.trim_end().split('\t').collect();
        let [_, formula, bounds, tolerance, output] = words[..] else {
            return Err("a request has five words".into());
        };
        let numbers: Vec<f64> = bounds.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        let [x0, x1, y0, y1, z0, z1] = numbers[..] else { return Err("a box has six numbers".into()) };
        let bounds = Aabb::new(Point3::new(x0, y0, z0), Point3::new(x1, y1, z1));
        Ok(Self { formula, bounds, tolerance: tolerance.parse()?, output })
    }
}

/// Bytes of the corners of faces as `u32`, and of the control points as `f64`: a point a vertex, three more an edge, 15
/// more a face.
fn least_bytes(surface: &TriangularSpline) -> usize {
    let mesh = &surface.base.mesh;
    let points = mesh.vertex_count() + 3 * mesh.edge_count() + 15 * mesh.face_count();
    24 * points + 12 * mesh.face_count()
}

/// The patches for the measuring program, as `benches/peers/measure/src/shape.rs` has them.
fn write_nets(surface: &TriangularSpline, path: &str) -> io::Result<()> {
    let mut out = BufWriter::new(std::fs::File::create(path)?);
    out.write_all(b"nets....")?;
    for count in [surface.nets.len(), surface.nets.first().map_or(0, |net| net.len())] {
        out.write_all(&(count as u64).to_le_bytes())?;
    }
    for x in surface.nets.iter().flatten().flat_map(|p| [p.x, p.y, p.z]) {
        out.write_all(&x.to_le_bytes())?;
    }
    out.flush()
}

fn answer(line: &str, effort: Effort) -> Result<String, Box<dyn Error>> {
    let request = Request::read(line)?;
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let formula = Formula::parse(request.formula, &Constants::new())?;
    let size = Size::Tolerance(request.tolerance);
    let recipe = SplineRecipe { bounds: Some(request.bounds), size, effort, ..SplineRecipe::default() };
    let starts: RefCell<Vec<(String, Instant)>> = RefCell::default();
    let fitted =
        fit(&formula, &recipe, &|stage| starts.borrow_mut().push((stage.to_string(), Instant::now())))?;
    let end = Instant::now();
    let (cpu, wall) = (cpu.elapsed().as_secs_f64(), (end - wall).as_secs_f64());
    if !fitted.reached {
        return Err("the tolerance was not reached".into());
    }
    let mut file = Vec::new();
    if request.output != "-" {
        write_nets(&fitted.surface, request.output)?;
        write_native(&fitted.surface, &Provenance::default(), &mut file)?;
    }
    let patches = fitted.surface.nets.len();
    let bytes = least_bytes(&fitted.surface);
    let file = file.len();
    let mut answer = format!("seconds={cpu}\twall={wall}\tbytes={bytes}\tfile={file}\telements={patches}");
    for (stage, seconds) in durations(&starts.into_inner(), end) {
        answer += &format!("\tstage {stage}={seconds}");
    }
    Ok(answer)
}

/// Seconds of each stage, those that ran more than once together; a stage ends where the next one starts.
fn durations(starts: &[(String, Instant)], end: Instant) -> BTreeMap<&str, f64> {
    let ends = starts.iter().skip(1).map(|(_, start)| *start).chain([end]);
    let mut seconds = BTreeMap::new();
    for ((stage, start), end) in starts.iter().zip(ends) {
        *seconds.entry(stage.as_str()).or_default() += (end - *start).as_secs_f64();
    }
    seconds
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let effort = match words.first().map(String::as_str) {
        Some("quick") => Effort::Quick,
        _ => Effort::Full,
    };
    let threads = words.get(1).map_or(Ok(1), |word| word.parse())?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global()?;
    let mut out = io::stdout().lock();
    writeln!(out, "ready")?;
    for line in io::stdin().lock().lines() {
        let text = answer(&line?, effort).unwrap_or_else(|error| format!("error={error}"));
        writeln!(out, "{text}")?;
        out.flush()?;
    }
    Ok(())
}
