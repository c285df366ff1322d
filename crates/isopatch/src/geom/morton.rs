//! An order of points in which neighbours are near each other: along the Z-curve (Morton 1966).

use rayon::prelude::*;

use super::{Aabb, Point3};

/// Bits of each coordinate in a place along the curve.
const BITS: u32 = 21;

/// Place of a point along the Z-curve through a box: the bits of its coordinates in turns.
fn place(p: &Point3, bounds: &Aabb) -> u64 {
    let size = bounds.size();
    let steps = (1_u64 << BITS) as f64;
    let share = |axis: usize| (p[axis] - bounds.min[axis]) / size[axis].max(f64::MIN_POSITIVE);
    // A conversion from a float stays within the integers, whatever it is given.
    let coordinate = |axis: usize| ((steps * share(axis)) as u64).min((1 << BITS) - 1);
    (0..3).fold(0, |code, axis| code | spread(coordinate(axis)) << axis)
}

/// The lowest 21 bits with two zeros after each.
fn spread(bits: u64) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    STEPS.iter().fold(bits, |x, (shift, mask)| (x | x << shift) & mask)
}

/// Numbers of the points along the Z-curve through the box around all of them; equal places in the order of the numbers.
pub fn morton_order(points: &[Point3]) -> Vec<u32> {
    let bounds = Aabb::around(points);
    let mut places: Vec<(u64, u32)> =
        points.par_iter().enumerate().map(|(i, p)| (place(p, &bounds), i as u32)).collect();
    places.par_sort_unstable();
    places.into_iter().map(|(_, i)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_cube_come_axis_by_axis_and_octants_one_by_one() {
        let corner = |i: u32| Point3::from_fn(|axis, _| f64::from(i >> axis & 1));
        let corners: Vec<Point3> = (0..8).rev().map(corner).collect();
        assert_eq!(morton_order(&corners), [7, 6, 5, 4, 3, 2, 1, 0]);
        // All points of a cell come before the first one of the next cell.
        let n = 8;
        let grid: Vec<Point3> = (0..n * n * n)
            .map(|i| Point3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64))
            .collect();
        let octant =
            |i: &u32| (0..3).map(|axis| usize::from(grid[*i as usize][axis] > 3.5) << axis).sum::<usize>();
        let octants: Vec<usize> = morton_order(&grid).iter().map(octant).collect();
        assert!(octants.is_sorted());
        assert!(octants.chunks(64).enumerate().all(|(k, part)| part.iter().all(|o| *o == k)));
    }

    #[test]
    fn any_points_are_put_in_some_order() {
        let points =
            [Point3::repeat(f64::NAN), Point3::repeat(f64::INFINITY), Point3::zeros(), Point3::zeros()];
        let mut order = morton_order(&points);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3]);
        assert!(morton_order(&[]).is_empty());
        assert_eq!(morton_order(&[Point3::repeat(2.0); 3]), [0, 1, 2]);
    }
}
