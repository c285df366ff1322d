//! How long the edges of the base mesh should be, from the curvature of the surface.

use super::connectivity::Connectivity;
use crate::geom::Point3;

/// Settings of the edge lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizingOptions {
    /// Longest allowed edge as a share of the radius of curvature, |k|max·L. Default 1.0: between 0.9 and 1.2 the spline
    /// has been seen to be off by 0.4° at most.
    pub turn: f64,
    /// Edge lengths stay within this factor of the mean one, up and down. Default 4.
    pub ratio: f64,
    /// Largest change of the edge length per unit of distance. Default 0.4.
    pub gradation: f64,
    /// Longest allowed edge as a share of the diagonal, when the face count is free. Default 0.3: a sphere gets about
    /// 60 faces.
    pub longest: f64,
}

impl Default for SizingOptions {
    fn default() -> Self {
        Self { turn: 1.0, ratio: 4.0, gradation: 0.4, longest: 0.3 }
    }
}

/// Area of the equilateral triangle with edge 1.
const UNIT_TRIANGLE: f64 = 0.433_012_701_892_219_3;

/// Sweeps over the edges that spread short lengths; each sweep passes them on along the numbering, so a few are enough.
const GRADATION_SWEEPS: usize = 12;

/// Lowers lengths until neighbours differ by at most `gradation` times their distance.
pub(super) fn limit_gradation(mesh: &Connectivity, x: &[Point3], gradation: f64, size: &mut [f64]) {
    for _ in 0..GRADATION_SWEEPS {
        let mut changed = false;
        for h in mesh.edges() {
            let (a, b) = (mesh.origin(h) as usize, mesh.dest(h) as usize);
            let step = gradation * (x[a] - x[b]).norm();
            if size[a] > size[b] + step {
                size[a] = size[b] + step;
                changed = true;
            } else if size[b] > size[a] + step {
                size[b] = size[a] + step;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
}

/// Number of equilateral faces of these edge lengths that cover the mesh.
pub(super) fn predicted_faces(mesh: &Connectivity, x: &[Point3], size: &[f64]) -> f64 {
    mesh.faces()
        .map(|f| {
            let area = 0.5 * super::shape::area_vector(f.map(|v| x[v as usize])).norm();
            let length = f.iter().map(|v| size[*v as usize]).sum::<f64>() / 3.0;
            area / (UNIT_TRIANGLE * length * length)
        })
        .sum()
}

/// Edge lengths at the vertices for about `faces` faces: shorter where the curvature is large.
pub(super) fn sizes_for_count(
    mesh: &Connectivity,
    x: &[Point3],
    curvature: &[f64],
    faces: usize,
    options: &SizingOptions,
) -> Vec<f64> {
    let uniform = vec![1.0; x.len()];
    let mean = (predicted_faces(mesh, x, &uniform) / faces as f64).sqrt();
    let reference = median(curvature);
    let mut size: Vec<f64> = curvature
        .iter()
        .map(|k| mean * (reference / k.max(f64::MIN_POSITIVE)).clamp(1.0 / options.ratio, options.ratio))
        .collect();
    limit_gradation(mesh, x, options.gradation, &mut size);
    // Scaling all lengths changes the count, and the cap |k|max·L ≤ turn cuts some: alternate a few times.
    const ROUNDS: usize = 3;
    for _ in 0..ROUNDS {
        let factor = (predicted_faces(mesh, x, &size) / faces as f64).sqrt();
        for (l, k) in size.iter_mut().zip(curvature) {
            *l = (*l * factor).min(options.turn / k);
        }
    }
    let factor = (predicted_faces(mesh, x, &size) / faces as f64).sqrt();
    size.iter_mut().for_each(|l| *l *= factor);
    size
}

/// Number of faces that the curvature asks for.
pub(super) fn automatic_count(
    mesh: &Connectivity,
    x: &[Point3],
    curvature: &[f64],
    diagonal: f64,
    options: &SizingOptions,
) -> usize {
    let mut size: Vec<f64> =
        curvature.iter().map(|k| (options.turn / k).min(options.longest * diagonal)).collect();
    limit_gradation(mesh, x, options.gradation, &mut size);
    let faces = predicted_faces(mesh, x, &size).ceil() as usize;
    faces + faces % 2
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        return 0.0;
    }
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}
