//! How long the edges of the base mesh should be, from the curvature of the surface.

use super::connectivity::Connectivity;
use super::shape::{area_vector, unit_or_zero};
use crate::field::Field;
use crate::geom::{Mat3, Point3, Points, Vec3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Settings of the edge lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizingOptions {
    /// Longest allowed edge as a share of the radius of curvature, |k|max·L. Default 1.0: between 0.9 and 1.2 the spline
    /// has been seen to be off by 0.4° at most.
    pub turn: f64,
    /// Largest angle between a face and the normals at its corners that remeshing aims at, in degrees. Default 35: up to that
    /// no face of a spline has been seen to be off.
    pub lean: f64,
    /// Edge lengths stay within this factor of the mean one, up and down. Default 4.
    pub ratio: f64,
    /// Largest change of the edge length per unit of distance. Default 0.4.
    pub gradation: f64,
    /// Lengths are proportional to E^((s − 1)/6)·|k|max^(−s): how much curvature counts beside the estimated error E L⁶ of
    /// the boundary curves. Default 0.5: the error estimate alone doubles the spline's error on McMullen's surface, the
    /// curvature alone on the decocube.
    pub curvature_share: f64,
    /// Edges along the direction of least curvature may be this much longer than across it. Default 1.5: the spline's
    /// error halves on the chair and the decocube, and changes little where curvatures are alike; 2 and more gain little
    /// and give wide corners.
    pub anisotropy: f64,
    /// Longest allowed edge as a share of the diagonal, when the face count is free. Default 0.3: a sphere gets about
    /// 60 faces.
    pub longest: f64,
}

impl Default for SizingOptions {
    fn default() -> Self {
        Self {
            turn: 1.0,
            lean: 35.0,
            ratio: 4.0,
            gradation: 0.4,
            curvature_share: 0.5,
            anisotropy: 1.5,
            longest: 0.3,
        }
    }
}

/// Area of the equilateral triangle with edge 1.
pub(super) const UNIT_TRIANGLE: f64 = 0.433_012_701_892_219_3;

/// Edges, faces or vertices that one task looks at.
const TASK: usize = 64;

/// Sweeps over the edges, there and back, that spread short lengths; each sweep passes them on along the numbering, so a few are
/// enough.
const GRADATION_SWEEPS: usize = 12;

/// Lowers lengths until the ends of an edge differ by at most `gradation` times their distance.
pub(super) fn limit_gradation(edges: &[[usize; 2]], x: &[Point3], gradation: f64, size: &mut [f64]) {
    let step = |&[a, b]: &[usize; 2]| (a, b, gradation * (x[a] - x[b]).norm());
    let steps: Vec<(usize, usize, f64)> = edges.par_iter().evenly_by(TASK).map(step).collect();
    for sweep in 0..GRADATION_SWEEPS {
        let mut changed = false;
        let mut relax = |(a, b, step): &(usize, usize, f64)| {
            let most = size[*a].min(size[*b]) + step;
            if size[*a].max(size[*b]) > most {
                size[*a] = size[*a].min(most);
                size[*b] = size[*b].min(most);
                changed = true;
            }
        };
        match sweep % 2 {
            0 => steps.iter().for_each(&mut relax),
            _ => steps.iter().rev().for_each(&mut relax),
        }
        if !changed {
            break;
        }
    }
}

/// The faces of a mesh, each with its area.
pub(super) struct FaceAreas(Vec<([u32; 3], f64)>);

impl FaceAreas {
    pub(super) fn new(mesh: &Connectivity, x: &[Point3]) -> Self {
        let area = |f: [u32; 3]| (f, 0.5 * area_vector(f.map(|v| x[v as usize])).norm());
        Self(mesh.faces_in_parallel().evenly_by(TASK).map(area).collect())
    }

    /// Number of equilateral faces of these edge lengths that cover the mesh.
    pub(super) fn predicted_faces(&self, size: &[f64]) -> f64 {
        let count = |(f, area): &([u32; 3], f64)| {
            let length = f.iter().map(|v| size[*v as usize]).sum::<f64>() / 3.0;
            area / (UNIT_TRIANGLE * length * length)
        };
        self.0.iter().map(count).sum()
    }
}

/// Relative edge lengths that make the error of a boundary curve the same everywhere.
///
/// Stands in for the error of the spline: the curve of degree five that takes position, tangent (along the chord) and
/// normal curvature at both ends is off the surface by e ≈ E L⁶ in its middle, measured as |f|/|∇f|. Lengths are
/// proportional to E^(−1/6), with E averaged over the edges of a vertex and its neighbours.
pub(super) fn sizes_from_errors(
    field: &dyn Field,
    edges: &[[usize; 2]],
    x: &[Point3],
    normal: &[Vec3],
    tensor: &[Mat3],
) -> Vec<f64> {
    let rate_of = |(edges, rates): (&[[usize; 2]], &mut [f64])| {
        let middles: Points = edges.iter().map(|[a, b]| curve_middle(x, normal, tensor, *a, *b)).collect();
        let (mut f, mut gradient) = (vec![0.0; edges.len()], Points::zeros(edges.len()));
        field.gradients(middles.view(), &mut f, gradient.view_mut());
        let rate = |(i, [a, b]): (usize, &[usize; 2])| {
            f[i].abs() / gradient.get(i).norm() / (x[*a] - x[*b]).norm().powi(ORDER)
        };
        rates.iter_mut().zip(edges.iter().enumerate().map(rate)).for_each(|(of_edge, rate)| *of_edge = rate);
    };
    let mut rates = vec![0.0; edges.len()];
    edges.par_chunks(TASK).zip(rates.par_chunks_mut(TASK)).evenly().for_each(rate_of);
    let mut rate = vec![(0.0, 0.0); x.len()];
    for (e, [a, b]) in rates.into_iter().zip(edges) {
        if e.is_finite() {
            for v in [*a, *b] {
                rate[v].0 += e;
                rate[v].1 += 1.0;
            }
        }
    }
    let rate: Vec<f64> = rate.iter().map(|(sum, n)| sum / f64::max(*n, 1.0)).collect();
    let mut smooth = vec![(0.0, 0.0); x.len()];
    for [a, b] in edges {
        for (v, w) in [(*a, *b), (*b, *a)] {
            smooth[v].0 += rate[w];
            smooth[v].1 += 1.0;
        }
    }
    (0..x.len())
        .into_par_iter()
        .evenly_by(TASK)
        .map(|v| 0.5 * (rate[v] + smooth[v].0 / f64::max(smooth[v].1, 1.0)))
        .map(|e| e.max(f64::MIN_POSITIVE).powf(-1.0 / f64::from(ORDER)))
        .collect()
}

/// Metric at a vertex that makes edges across the direction of least curvature shorter, and along it longer; of
/// determinant one, so that the number of faces stays. Best for linear interpolation would be lengths in the ratio
/// (k₁/k₂)^(1/2); so far `options.anisotropy` allows.
pub(super) fn stretch(tensor: &Mat3, normal: &Vec3, options: &SizingOptions) -> Mat3 {
    let square = tensor * tensor;
    let half_trace = 0.5 * tensor.trace();
    let half_difference = (0.5 * tensor.norm_squared() - half_trace * half_trace).max(0.0).sqrt();
    let (most, least) = (half_trace.abs() + half_difference, (half_trace.abs() - half_difference).abs());
    let ratio = (most / least.max(f64::MIN_POSITIVE)).sqrt().min(options.anisotropy);
    let gap = most * most - least * least;
    if gap.is_nan() || gap <= 0.0 {
        return Mat3::identity();
    }
    // Eigenvalue r at the direction of largest curvature, 1/r at the other.
    let slope = (ratio - 1.0 / ratio) / gap;
    let tangential = Mat3::identity() - normal * normal.transpose();
    (1.0 / ratio - slope * least * least) * tangential + slope * square + normal * normal.transpose()
}

/// Order of the error of a boundary curve.
const ORDER: i32 = 6;

/// Middle of the quintic Hermite curve with velocities along the chord and accelerations k |v|² N at both ends.
fn curve_middle(x: &[Point3], normal: &[Vec3], tensor: &[Mat3], a: usize, b: usize) -> Point3 {
    let chord = x[b] - x[a];
    let end = |v: usize| {
        let n = &normal[v];
        let t = unit_or_zero(&(chord - n * n.dot(&chord)));
        // The arc is longer than the chord: by θ / sin θ if it leaves the chord at angle θ.
        let cosine = (t.dot(&chord) / chord.norm()).clamp(0.5, 1.0);
        let angle = cosine.acos();
        let stretch = if angle > 1e-4 { angle / angle.sin() } else { 1.0 };
        let velocity = chord.norm() * stretch * t;
        let acceleration = velocity.dot(&(tensor[v] * velocity)) * n;
        (velocity, acceleration)
    };
    let ((v0, a0), (v1, a1)) = (end(a), end(b));
    0.5 * (x[a] + x[b]) + (v0 - v1) * (5.0 / 32.0) + (a0 + a1) / 64.0
}

/// A face that leans too far shortens the edges by at most this factor: it may only be badly shaped.
const STRONGEST_CAP: f64 = 0.7;

/// Relative lengths from the estimated error, with |k|max having its share; see [`SizingOptions::curvature_share`].
pub(super) fn blend_with_curvature(
    lengths: Vec<f64>,
    curvature: &[f64],
    options: &SizingOptions,
) -> Vec<f64> {
    let share = options.curvature_share;
    lengths
        .par_iter()
        .zip(curvature)
        .evenly_by(TASK)
        .map(|(l, k)| l.powf(1.0 - share) * k.max(f64::MIN_POSITIVE).powf(-share))
        .collect()
}

/// Edge lengths at the vertices for about `faces` faces, proportional to `relative` where the limits allow.
///
/// `lean` holds the edge lengths for which faces would not lean too far from the surface normal.
pub(super) fn sizes_for_count(
    areas: &FaceAreas,
    edges: &[[usize; 2]],
    x: &[Point3],
    curvature: &[f64],
    relative: &[f64],
    lean: &[f64],
    faces: usize,
    options: &SizingOptions,
) -> Vec<f64> {
    let mean = (areas.predicted_faces(&vec![1.0; x.len()]) / faces as f64).sqrt();
    let reference = median(relative);
    let mut size: Vec<f64> =
        relative.iter().map(|l| mean * (l / reference).clamp(1.0 / options.ratio, options.ratio)).collect();
    limit_gradation(edges, x, options.gradation, &mut size);
    // Scaling all lengths changes the count, and the caps cut some: alternate a few times.
    const ROUNDS: usize = 3;
    for _ in 0..ROUNDS {
        let factor = (areas.predicted_faces(&size) / faces as f64).sqrt();
        for ((l, k), lean) in size.iter_mut().zip(curvature).zip(lean) {
            let length = *l * factor;
            *l = length.min(options.turn / k).min(lean.max(STRONGEST_CAP * length));
        }
    }
    let factor = (areas.predicted_faces(&size) / faces as f64).sqrt();
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
    limit_gradation(&mesh.edge_ends(), x, options.gradation, &mut size);
    let faces = FaceAreas::new(mesh, x).predicted_faces(&size).ceil() as usize;
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
