//! From a formula to a surface within a tolerance: CPU seconds of every stage on one thread, patches, bytes, errors.
//!
//! `cargo bench -p isopatch --bench surfaces` prints the six surfaces of Tong & Kim 2009 for three tolerances and both
//! efforts; names of surfaces, tolerances and `quick` or `full` after `--` select. Times are medians of five runs in one
//! process; the formula is parsed in them.

use cpu_time::ProcessTime;
use isopatch::gallery;
use isopatch::inspect::{InspectOptions, inspect};
use isopatch::io::native::{Provenance, write_native};
use isopatch::recipes::spline::{Effort, Fitted, Size, SplineRecipe, fit};
use std::cell::RefCell;

const SURFACES: [&str; 6] = ["torus", "dodeca", "dtorus", "mcmullen", "chair", "decocube"];
const TOLERANCES: [f64; 3] = [1e-3, 1e-4, 1e-5];
const RUNS: usize = 5;

/// CPU seconds of the stages, in the order in which they first ran.
type Stages = Vec<(String, f64)>;

fn run(name: &str, tolerance: f64, effort: Effort) -> (Fitted, Stages) {
    let marks: RefCell<Vec<(String, ProcessTime)>> = RefCell::default();
    let mark = |stage: &str| marks.borrow_mut().push((stage.to_string(), ProcessTime::now()));
    mark("parse");
    let surface = gallery::surface(name).expect("it is in the gallery");
    let formula = surface.field().expect("a formula");
    let size = Size::Tolerance(tolerance);
    let recipe = SplineRecipe { bounds: surface.bounds, size, effort, ..SplineRecipe::default() };
    let fitted = fit(&formula, &recipe, &mark).expect("it has a spline");
    mark("end");
    let mut stages = Stages::new();
    for pair in marks.into_inner().windows(2) {
        let seconds = pair[1].1.duration_since(pair[0].1).as_secs_f64();
        match stages.iter_mut().find(|(name, _)| *name == pair[0].0) {
            Some((_, sum)) => *sum += seconds,
            None => stages.push((pair[0].0.clone(), seconds)),
        }
    }
    (fitted, stages)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn row(name: &str, tolerance: f64, effort: Effort) -> f64 {
    let runs: Vec<(Fitted, Stages)> = (0..RUNS).map(|_| run(name, tolerance, effort)).collect();
    let total = median(runs.iter().map(|(_, stages)| stages.iter().map(|(_, s)| s).sum()).collect());
    let fitted = &runs[0].0;
    let options = InspectOptions { region: Some(fitted.bounds), ..InspectOptions::default() };
    let measured = inspect(&fitted.surface, &fitted.surface.base, Some(&fitted.formula), &options);
    let there = measured.deviation.expect("there is a formula");
    let back = measured.coverage.map_or(f64::INFINITY, |c| c.max_distance);
    let mut bytes = Vec::new();
    write_native(&fitted.surface, &Provenance::default(), &mut bytes).expect("memory takes all bytes");
    print!(
        "{name:>9} {tolerance:.0e} {effort:>6} {total:8.4} s {:6} patches {:8} bytes, error {:.1e}, normals {:6.3}°:",
        fitted.surface.nets.len(),
        bytes.len(),
        there.max_distance.max(back),
        there.max_normal_error.to_degrees(),
        effort = format!("{effort:?}"),
    );
    for (i, (stage, _)) in runs[0].1.iter().enumerate() {
        print!(" {stage} {:.4}", median(runs.iter().map(|(_, stages)| stages[i].1).collect()));
    }
    println!();
    total
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let is_asked = |name: &str| words.iter().any(|w| w == name);
    let names: Vec<&str> = SURFACES.into_iter().filter(|name| is_asked(name)).collect();
    let names = if names.is_empty() { SURFACES.to_vec() } else { names };
    let tolerances: Vec<f64> = words.iter().filter_map(|w| w.parse().ok()).collect();
    let tolerances = if tolerances.is_empty() { TOLERANCES.to_vec() } else { tolerances };
    for (effort, word, other) in [(Effort::Quick, "quick", "full"), (Effort::Full, "full", "quick")] {
        if is_asked(other) && !is_asked(word) {
            continue;
        }
        for tolerance in &tolerances {
            let logs: f64 = names.iter().map(|name| row(name, *tolerance, effort).ln()).sum();
            println!("geometric mean {:.4} s", (logs / names.len() as f64).exp());
        }
    }
}
