//! Gaussian and mean curvature of a tessellated surface, from its normals.

use crate::geom::{Mat3, Point3, Vec3};
use crate::parallel::Evenly;
use crate::surface::PatchId;
use crate::tessellate::Tessellation;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Which curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// Product of the principal curvatures.
    Gaussian,
    /// Mean of the principal curvatures, positive where the solid is convex.
    Mean,
}

/// Curvature at the corners of each triangle; NaN where no triangle around has an area.
///
/// In each triangle the change of the normal along its sides determines the second fundamental form (least squares,
/// Rusinkiewicz 2004); a corner has the mean over the triangles of its patch, weighted by their areas. Patches are not mixed, so
/// jumps across seams are seen. The error is first order in the size of the triangles.
pub fn curvature(mesh: &Tessellation, kind: Curvature) -> Vec<[f32; 3]> {
    let patches: Vec<&[PatchId]> = mesh.patches.chunk_by(|a, b| a == b).collect();
    let starts: Vec<usize> =
        patches.iter().scan(0, |start, patch| Some(std::mem::replace(start, *start + patch.len()))).collect();
    patches
        .par_iter()
        .evenly()
        .zip(&starts)
        .flat_map_iter(|(patch, start)| of_patch(mesh, *start, patch.len(), kind))
        .collect()
}

/// The same for the triangles of one patch.
fn of_patch(mesh: &Tessellation, start: usize, count: usize, kind: Curvature) -> Vec<[f32; 3]> {
    // Sum of area times curvature, and of area.
    let mut sums: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for t in start..start + count {
        let positions = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        let numbers = mesh.normal_numbers(t);
        let normals = numbers.map(|n| mesh.normals[n as usize]);
        if let Some((area, value)) = of_triangle(&positions, &normals, kind) {
            for n in numbers {
                let sum = sums.entry(n).or_default();
                *sum = (sum.0 + area * value, sum.1 + area);
            }
        }
    }
    let mean = |n: u32| sums.get(&n).map_or(f32::NAN, |(sum, area)| (sum / area) as f32);
    (start..start + count).map(|t| mesh.normal_numbers(t).map(mean)).collect()
}

/// Area and curvature of a triangle; none if it has no area.
fn of_triangle(p: &[Point3; 3], n: &[Vec3; 3], kind: Curvature) -> Option<(f64, f64)> {
    let twice = (p[1] - p[0]).cross(&(p[2] - p[0]));
    let area = 0.5 * twice.norm();
    let u = (p[1] - p[0]).try_normalize(0.0)?;
    let v = twice.try_normalize(0.0)?.cross(&u);
    // The form (a, b, c) with (a b; b c) · (side in u, v) = change of the normal in u, v, for three sides.
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for k in 0..3 {
        let (side, change) = (p[(k + 1) % 3] - p[k], n[(k + 1) % 3] - n[k]);
        let (x, y) = (side.dot(&u), side.dot(&v));
        let (s, t) = (change.dot(&u), change.dot(&v));
        matrix += Mat3::new(x * x, x * y, 0.0, x * y, x * x + y * y, x * y, 0.0, x * y, y * y);
        right += Vec3::new(x * s, y * s + x * t, y * t);
    }
    let form = matrix.try_inverse()? * right;
    let value = match kind {
        Curvature::Gaussian => form.x * form.z - form.y * form.y,
        Curvature::Mean => 0.5 * (form.x + form.z),
    };
    (value.is_finite() && area > 0.0).then_some((area, value))
}

/// Part of the area that the colours of a scale leave out at either end: vertices of a spline have peaks of curvature.
const LEFT_OUT: f64 = 0.02;
/// Numbers closer together than this part of the largest are shown as equal.
const EQUAL: f64 = 0.02;

/// A range that holds all but the extreme values, symmetric to zero if both signs matter; and are there both?
pub(super) fn robust_range(mesh: &Tessellation, corners: &[[f32; 3]]) -> ([f64; 2], bool) {
    let mut values: Vec<(f64, f64)> = Vec::with_capacity(3 * corners.len());
    for (t, corners) in mesh.triangles.iter().zip(corners) {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let area = (b - a).cross(&(c - a)).norm();
        values
            .extend(corners.iter().map(|x| (f64::from(*x), area)).filter(|(x, area)| (x * area).is_finite()));
    }
    values.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let all: f64 = values.iter().map(|(_, area)| area).sum();
    let at = |share: f64| {
        let mut sum = 0.0;
        let reached = |(_, area): &&(f64, f64)| {
            sum += area;
            sum >= share * all
        };
        values.iter().find(reached).or(values.last()).map_or(0.0, |(x, _)| *x)
    };
    let (low, high) = (at(LEFT_OUT), at(1.0 - LEFT_OUT));
    let largest = low.abs().max(high.abs());
    if largest == 0.0 {
        return ([-1.0, 1.0], true);
    }
    if low < -EQUAL * largest && high > EQUAL * largest {
        return ([-largest, largest], true);
    }
    if high - low < EQUAL * largest {
        let middle = 0.5 * (low + high);
        return ([middle - 0.5 * middle.abs(), middle + 0.5 * middle.abs()], false);
    }
    ([low, high], false)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid over the square [−1/2, 1/2]², lifted to z = h(x, y), with exact normals.
    fn graph(h: impl Fn(f64, f64) -> f64, gradient: impl Fn(f64, f64) -> [f64; 2]) -> Tessellation {
        const N: usize = 40;
        let coordinate = |i: usize| i as f64 / N as f64 - 0.5;
        let points: Vec<[f64; 2]> =
            (0..=N).flat_map(|i| (0..=N).map(move |j| [coordinate(i), coordinate(j)])).collect();
        let at = |i: usize, j: usize| (i * (N + 1) + j) as u32;
        let triangles: Vec<[u32; 3]> = (0..N * N)
            .flat_map(|c| {
                let (i, j) = (c / N, c % N);
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let normal = |[x, y]: [f64; 2]| {
            let [hx, hy] = gradient(x, y);
            Vec3::new(-hx, -hy, 1.0).normalize()
        };
        Tessellation {
            positions: points.iter().map(|[x, y]| Point3::new(*x, *y, h(*x, *y))).collect(),
            normals: points.iter().map(|p| normal(*p)).collect(),
            patches: vec![PatchId(0); triangles.len()],
            triangles,
            corner_normals: Vec::new(),
        }
    }

    #[test]
    fn a_sphere_and_a_saddle_have_their_curvatures() {
        let cap = graph(
            |x, y| (4.0 - x * x - y * y).sqrt(),
            |x, y| [-x / (4.0 - x * x - y * y).sqrt(), -y / (4.0 - x * x - y * y).sqrt()],
        );
        for (kind, expected) in [(Curvature::Gaussian, 0.25), (Curvature::Mean, 0.5)] {
            let found = curvature(&cap, kind);
            assert!(found.iter().flatten().all(|k| (f64::from(*k) - expected).abs() < 2e-3));
            let ([low, high], both) = robust_range(&cap, &found);
            assert!(!both && low < expected && expected < high);
        }
        let saddle = graph(|x, y| 0.5 * (x * x - y * y), |x, y| [x, -y]);
        let gaussian = curvature(&saddle, Curvature::Gaussian);
        for (t, corners) in saddle.triangles.iter().zip(&gaussian) {
            for (v, k) in t.iter().zip(corners) {
                let p = saddle.positions[*v as usize];
                let exact = -(1.0 + p.x * p.x + p.y * p.y).powi(-2);
                assert!((f64::from(*k) - exact).abs() < 0.03, "{k} {exact}");
            }
        }
    }

    #[test]
    fn ranges_leave_peaks_out() {
        let flat = graph(|_, _| 0.0, |_, _| [0.0, 0.0]);
        let mut corners = vec![[1.0, 2.0, 3.0]; flat.triangles.len()];
        corners[7] = [1e9, f32::NAN, -1e9];
        assert_eq!(robust_range(&flat, &corners), ([1.0, 3.0], false));
        corners.iter_mut().skip(50).for_each(|c| c[0] = -4.0);
        assert_eq!(robust_range(&flat, &corners), ([-4.0, 4.0], true));
        assert_eq!(robust_range(&flat, &[]), ([-1.0, 1.0], true));
        assert_eq!(robust_range(&flat, &[[0.0; 3]]), ([-1.0, 1.0], true));
    }

    #[test]
    fn many_small_triangles_do_not_widen_a_range() {
        let mut mesh = graph(|_, _| 0.0, |_, _| [0.0, 0.0]);
        let mut corners = vec![[1.0, 1.5, 2.0]; mesh.triangles.len()];
        let small = mesh.positions.len() as u32;
        mesh.positions.extend([Point3::zeros(), 1e-6 * Point3::x(), 1e-6 * Point3::y()]);
        mesh.triangles.extend(vec![[small, small + 1, small + 2]; corners.len()]);
        corners.resize(mesh.triangles.len(), [900.0; 3]);
        assert_eq!(robust_range(&mesh, &corners), ([1.0, 2.0], false));
    }
}
