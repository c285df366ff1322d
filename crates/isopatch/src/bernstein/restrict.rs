//! The same polynomial over a part of its domain: its coefficients there bound it.

use super::index;
use std::array::from_fn;
use std::ops::{Add, Mul};

/// Coefficients of a form of degree `n` ≥ 0 over the triangle with the given corners, in barycentric coordinates, from those
/// over the whole triangle; both in net order. Every value of the form over that triangle is a convex combination of them.
///
/// Coefficient (i, j, k) is the polar form (blossom) with i times the first corner, j times the second, k times the third for
/// arguments: de Casteljau's algorithm with another corner in each step.
pub fn over_triangle<T>(n: usize, net: &[T], corners: &[[f64; 3]; 3]) -> Vec<T>
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    let mut steps = Vec::with_capacity(net.len());
    index::indices(n)
        .filter_map(|ijk| {
            steps.clear();
            steps.extend_from_slice(net);
            let arguments = (0..3).flat_map(|c| std::iter::repeat_n(&corners[c], ijk[c]));
            for (degree, [u, v, w]) in (0..n).rev().zip(arguments) {
                for (p, [_, j, k]) in index::indices(degree).enumerate() {
                    let row = j + k;
                    steps[p] = steps[p] * *u + steps[p + row + 1] * *v + steps[p + row + 2] * *w;
                }
            }
            steps.first().copied()
        })
        .collect()
}

/// Coefficients over [a, b] of a polynomial of degree N − 1, from those over [0, 1].
pub fn over_interval<T, const N: usize>(c: [T; N], [a, b]: [f64; 2]) -> [T; N]
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    from_fn(|i| {
        let mut steps = c;
        for step in 1..N {
            let t = if step <= i { b } else { a };
            for j in 0..N - step {
                steps[j] = steps[j] * (1.0 - t) + steps[j + 1] * t;
            }
        }
        steps[0]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bernstein::triangle;
    use crate::geom::Point3;

    #[test]
    fn parts_of_a_triangle_are_the_same_surface() {
        let at = |i: usize, k: f64| (i as f64 * 12.9898 + k).sin();
        let net: Vec<Point3> = (0..36).map(|i| Point3::new(at(i, 0.0), at(i, 1.0), at(i, 2.0))).collect();
        let corners = [[0.5, 0.3, 0.2], [0.1, 0.7, 0.2], [0.2, 0.0, 0.8]];
        let part = over_triangle(7, &net, &corners);
        for x in triangle::lattice(5) {
            let whole: [f64; 3] = from_fn(|c| (0..3).map(|a| x[a] * corners[a][c]).sum());
            let a = triangle::evaluate(7, &part, [x[0], x[1]]).point;
            let b = triangle::evaluate(7, &net, [whole[0], whole[1]]).point;
            assert!((a - b).norm() < 1e-13);
        }
    }

    #[test]
    fn parts_of_an_interval_are_the_same_polynomial() {
        let c = [1.0, -2.0, 0.5, 3.0];
        let part = over_interval(c, [0.2, 0.7]);
        let value = |c: &[f64; 4], t: f64| {
            crate::bernstein::curve::basis::<4>(t).iter().zip(c).map(|(b, c)| b * c).sum::<f64>()
        };
        for i in 0..=5 {
            let t = f64::from(i) / 5.0;
            assert!((value(&part, t) - value(&c, 0.2 + 0.5 * t)).abs() < 1e-15);
        }
    }
}
