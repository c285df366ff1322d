//! Measures a result against its true surface: `peer-measure SURFACE DIAGONAL FILE` prints a JSON object.

use peer_fields::newton::foot;
use peer_fields::samples;
use peer_fields::shape::Shape;
use peer_fields::surface::Surface;
use std::process::ExitCode;

/// Larger results are sampled on elements that are evenly spread.
const MOST_SAMPLES: usize = 6_000_000;
/// Normals are counted in bins of this many degrees, for the quantile.
const BIN: f64 = 0.01;
const QUANTILE: f64 = 0.99;

/// Angles of normals to ∇f.
struct Angles {
    bins: Vec<usize>,
    /// With normals as they are, and turned.
    largest: [f64; 2],
    /// Samples whose normal points in and out.
    sides: [usize; 2],
    without: usize,
}

impl Angles {
    fn new() -> Self {
        Self { bins: vec![0; (90.0 / BIN) as usize + 1], largest: [0.0; 2], sides: [0; 2], without: 0 }
    }

    fn add(&mut self, normal: Option<[f64; 3]>, truth: [f64; 3]) {
        let Some(n) = normal else {
            self.without += 1;
            return;
        };
        let cosine: f64 = (0..3).map(|i| n[i] * truth[i]).sum();
        // The chord is exact for small angles, where the arc cosine is not.
        let angle = |sign: f64| {
            let chord: f64 = (0..3).map(|i| (sign * n[i] - truth[i]).powi(2)).sum::<f64>().sqrt();
            2.0 * (0.5 * chord).min(1.0).asin().to_degrees()
        };
        self.sides[usize::from(cosine > 0.0)] += 1;
        self.largest = [self.largest[0].max(angle(1.0)), self.largest[1].max(angle(-1.0))];
        self.bins[(angle(cosine.signum()) / BIN) as usize] += 1;
    }

    /// The largest angle, when the result is oriented as most of its normals want.
    fn largest(&self) -> f64 {
        self.largest[usize::from(self.sides[0] > self.sides[1])]
    }

    fn quantile(&self) -> f64 {
        let wanted = (QUANTILE * self.bins.iter().sum::<usize>() as f64) as usize;
        let mut seen = 0;
        let bin = self.bins.iter().position(|count| {
            seen += count;
            seen > wanted
        });
        bin.unwrap_or(0) as f64 * BIN
    }
}

fn measure(surface: Surface, diagonal: f64, shape: &Shape) -> String {
    let stride = (samples::count(shape) * shape.len()).div_ceil(MOST_SAMPLES).max(1);
    let (mut largest, mut squares, mut count) = (0.0f64, 0.0, 0usize);
    let mut angles = Angles::new();
    samples::visit(shape, diagonal, stride, |sample| {
        let foot = foot(surface, sample.point, diagonal);
        let distance = foot.distance / diagonal;
        largest = if distance.is_nan() { f64::INFINITY } else { largest.max(distance) };
        squares += distance * distance;
        count += 1;
        angles.add(sample.normal, foot.normal);
    });
    let root_mean_square = (squares / count as f64).sqrt();
    format!(
        "{{\"error\": {largest:e}, \"rms\": {root_mean_square:e}, \"normal\": {:.4}, \"normal_p99\": {:.2}, \
         \"without_normal\": {}, \"samples\": {count}, \"elements\": {}, \"euler\": {}}}",
        angles.largest(),
        angles.quantile(),
        angles.without,
        shape.len(),
        shape.euler_number(),
    )
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [name, diagonal, file] = words.as_slice() else {
        eprintln!("usage: peer-measure SURFACE DIAGONAL FILE");
        return ExitCode::FAILURE;
    };
    let (Some(surface), Ok(diagonal)) = (Surface::named(name), diagonal.parse::<f64>()) else {
        eprintln!("no such surface, or no number: {name}, {diagonal}");
        return ExitCode::FAILURE;
    };
    match Shape::read(file) {
        Ok(shape) if !shape.is_empty() => {
            println!("{}", measure(surface, diagonal, &shape));
            ExitCode::SUCCESS
        }
        Ok(_) => {
            eprintln!("{file} is empty");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{file}: {error}");
            ExitCode::FAILURE
        }
    }
}
