//! Least processor times, and what they come to.

use cpu_time::ProcessTime;
use std::hint::black_box;

const RUNS: usize = 7;

/// Least processor time of several runs.
pub fn seconds<T>(mut run: impl FnMut() -> T) -> f64 {
    let once = |_| {
        let start = ProcessTime::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(once).fold(f64::INFINITY, f64::min)
}

/// Prints points a second, and what they take in memory if all are kept.
pub fn rate(name: &str, points: usize, seconds: f64, bytes_a_point: usize) {
    let (per_second, bytes) = (points as f64 / seconds, (points * bytes_a_point) as f64);
    println!(
        "{name:>36} {:8.1} million points a second, {:6.2} GB/s",
        per_second / 1e6,
        bytes / seconds / 1e9
    );
}
