//! CPU seconds of every part of an inspection of the decocube, on one thread.
//!
//! `cargo bench -p isopatch --bench inspection` prints the best of five runs, and the time of a patch.

use cpu_time::ProcessTime;
use isopatch::gallery;
use isopatch::inspect::{InspectOptions, coverage, deviation, extent, interpolation, intersections, seams};
use isopatch::recipes::spline::{Size, SplineRecipe, fit};
use std::hint::black_box;

const RUNS: usize = 5;
/// Lattice on which the recipe checks patches between rounds.
const CHECK_LATTICE: usize = 12;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let decocube = gallery::surface("decocube").expect("it is in the gallery");
    let size = Size::Faces(decocube.faces);
    let recipe = SplineRecipe { bounds: decocube.bounds, size, ..SplineRecipe::default() };
    let formula = decocube.field().expect("a formula");
    let fitted = fit(&formula, &recipe, &|_| ()).expect("the decocube has a spline");
    let (surface, field) = (&fitted.surface, &fitted.formula);
    let (diagonal, area) = (surface.base.diagonal(), extent(surface).area);
    let options = InspectOptions::default();
    let (points, region) = (options.back_samples, Some(fitted.bounds));

    println!("decocube, {} patches, one thread: CPU time, best of {RUNS}", surface.nets.len());
    let time = |name: &str, run: &dyn Fn()| {
        let measure = |_| {
            let start = ProcessTime::now();
            run();
            start.elapsed().as_secs_f64()
        };
        let seconds = (0..RUNS).map(measure).fold(f64::INFINITY, f64::min);
        println!("{name:>32} {seconds:8.4} s {:8.2} µs a patch", 1e6 * seconds / surface.nets.len() as f64);
    };
    time("extent", &|| _ = black_box(extent(surface)));
    time("seams", &|| _ = black_box(seams(surface, diagonal, options.seam_samples)));
    time("interpolation", &|| _ = black_box(interpolation(&surface.base, surface, diagonal)));
    for lattice in [CHECK_LATTICE, options.lattice] {
        time(&format!("deviation, lattice {lattice}"), &|| {
            _ = black_box(deviation(surface, field, diagonal, lattice));
        });
    }
    time("coverage", &|| _ = black_box(coverage(surface, field, diagonal, area, points, region)));
    for resolution in [options.intersection_lattice, 8] {
        time(&format!("intersections, lattice {resolution}"), &|| {
            _ = black_box(intersections(surface, resolution));
        });
    }
}
