//! CPU seconds of every stage from the decocube's formula to the bytes of the native file, on one thread.
//!
//! `cargo bench -p isopatch --bench decocube` prints medians of five runs and the share of each stage.

use cpu_time::ProcessTime;
use isopatch::gallery;
use isopatch::io::native::{Provenance, write_native};
use isopatch::recipes::spline::{Fitted, Size, SplineRecipe, fit};
use std::cell::RefCell;

const RUNS: usize = 5;

/// CPU seconds at which each stage began, by name.
type Marks = Vec<(String, ProcessTime)>;

fn run() -> (Fitted, Vec<(String, f64)>) {
    let marks: RefCell<Marks> = RefCell::default();
    let mark = |stage: &str| marks.borrow_mut().push((stage.to_string(), ProcessTime::now()));
    mark("parse");
    let decocube = gallery::surface("decocube").expect("it is in the gallery");
    let formula = decocube.field().expect("a formula");
    let size = Size::Faces(decocube.faces);
    let recipe = SplineRecipe { bounds: decocube.bounds, size, ..SplineRecipe::default() };
    let fitted = fit(&formula, &recipe, &mark).expect("the decocube has a spline");
    mark("native");
    let mut bytes = Vec::new();
    write_native(&fitted.surface, &Provenance::default(), &mut bytes).expect("memory takes all bytes");
    mark("end");
    let marks = marks.into_inner();
    let mut stages: Vec<(String, f64)> = Vec::new();
    for pair in marks.windows(2) {
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

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let runs: Vec<(Fitted, Vec<(String, f64)>)> = (0..RUNS).map(|_| run()).collect();
    let totals = runs.iter().map(|(_, stages)| stages.iter().map(|(_, s)| s).sum()).collect();
    let total = median(totals);
    println!("decocube, {} patches, one thread: CPU seconds, median of {RUNS}", runs[0].0.surface.nets.len());
    for (i, (name, _)) in runs[0].1.iter().enumerate() {
        let seconds = median(runs.iter().map(|(_, stages)| stages[i].1).collect());
        println!("{name:>12} {seconds:9.4} {:5.1} %", 100.0 * seconds / total);
    }
    println!("{:>12} {total:9.4}", "total");
}
