//! What every [`Field`] must satisfy, checked on samples.

use super::Field;
use crate::geom::{Aabb, Affine, Interval, Jets, Point3, Points, Vec3};

/// A fixed sequence of numbers in [0, 1), the same at every run: a linear congruential generator (Knuth, MMIX).
pub(crate) struct Sequence(u64);

impl Sequence {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of the box.
    pub(crate) fn point(&mut self, cell: &Aabb) -> Point3 {
        cell.min + cell.size().component_mul(&Vec3::new(self.next(), self.next(), self.next()))
    }
}

/// Relative tolerance of a first difference, whose step is the cube root of the rounding unit.
const DIFFERENCE_TOLERANCE: f64 = 1e-7;
const DIFFERENCE_STEP: f64 = 1e-5;

/// Everything that the [`Field`] trait promises, on samples of a box in which the field is smooth.
pub(crate) fn check_field(field: &dyn Field, cell: &Aabb) {
    let mut sequence = Sequence::new(1);
    let points: Points = (0..700).map(|_| sequence.point(cell)).collect();
    check_batches(field, &points);
    for i in 0..60 {
        check_derivatives(field, points.get(i));
    }
    for _ in 0..40 {
        let (a, b) = (sequence.point(cell), sequence.point(cell));
        let shrink = sequence.next().powi(3);
        let b = a + shrink * (b - a);
        check_ranges(field, &Aabb::around(&[a, b]), &mut sequence);
    }
    check_ranges(field, cell, &mut sequence);
    let mut corners = || (0..600).map(|_| sequence.point(cell)).collect::<Vec<_>>();
    let (starts, ends) = (corners(), corners());
    let cells: Vec<Aabb> = starts.iter().zip(&ends).map(|(a, b)| Aabb::around([a, b])).collect();
    check_batch_ranges(field, &cells);
    check_unbounded(field, &points);
}

fn check_batches(field: &dyn Field, points: &Points) {
    // Runs of several lengths, so that blocks of an implementation are full, partial and empty.
    for length in [0, 1, 17, 511, points.len()] {
        let view = points.view().slice(0..length);
        let (mut f, mut g) = (vec![f64::NAN; length], vec![f64::NAN; length]);
        let mut gradient = Points::zeros(length);
        field.values(view, &mut f);
        field.gradients(view, &mut g, gradient.view_mut());
        let mut jets = Jets::zeros(length);
        field.jets(view, &mut jets);
        for i in 0..length {
            let (value, at_point) = field.gradient(view.get(i));
            assert_eq!(f[i].to_bits(), field.value(view.get(i)).to_bits(), "value in a batch");
            assert_eq!(g[i].to_bits(), value.to_bits(), "value with gradient in a batch");
            assert_eq!(gradient.get(i).map(f64::to_bits), at_point.map(f64::to_bits), "gradient in a batch");
            let (jet, at_point) = (jets.get(i), field.jet(view.get(i)));
            assert_eq!(jet.value.to_bits(), at_point.value.to_bits(), "value of the jet in a batch");
            assert_eq!(jet.gradient.map(f64::to_bits), at_point.gradient.map(f64::to_bits), "in a batch");
            assert_eq!(jet.hessian.map(f64::to_bits), at_point.hessian.map(f64::to_bits), "in a batch");
        }
    }
}

/// Ranges in batches of several lengths are those of the cells, one by one.
fn check_batch_ranges(field: &dyn Field, cells: &[Aabb]) {
    for length in [0, 1, 17, cells.len()] {
        let mut ranges = vec![Interval::point(f64::NAN); length];
        field.ranges(&cells[..length], &mut ranges);
        for (range, cell) in ranges.iter().zip(cells) {
            let alone = field.range(cell);
            let bits = |i: &Interval| [i.lo.to_bits(), i.hi.to_bits()];
            assert_eq!(bits(range), bits(&alone), "{range:?} and {alone:?}");
        }
    }
}

fn check_derivatives(field: &dyn Field, p: Point3) {
    let jet = field.jet(p);
    let (value, gradient) = field.gradient(p);
    let scale = 1.0 + value.abs() + gradient.norm() + jet.hessian.norm();
    let close = |a: f64, b: f64, what: &str| {
        assert!((a - b).abs() <= DIFFERENCE_TOLERANCE * scale, "{what} at {p:?}: {a} against {b}");
    };
    close(value, field.value(p), "value of the gradient");
    close(jet.value, value, "value of the jet");
    assert_eq!(jet.hessian, jet.hessian.transpose());
    for axis in 0..3 {
        close(jet.gradient[axis], gradient[axis], "gradient of the jet");
        let step = Vec3::ith(axis, DIFFERENCE_STEP);
        let slope = (field.value(p + step) - field.value(p - step)) / (2.0 * DIFFERENCE_STEP);
        close(gradient[axis], slope, "gradient");
        let bend = (field.gradient(p + step).1 - field.gradient(p - step).1) / (2.0 * DIFFERENCE_STEP);
        for other in 0..3 {
            close(jet.hessian[(axis, other)], bend[other], "Hessian");
        }
    }
}

fn check_ranges(field: &dyn Field, cell: &Aabb, sequence: &mut Sequence) {
    let range = field.range(cell);
    let (with_gradient, slopes) = field.gradient_range(cell);
    let linear = field.linear_range(cell);
    let (linear_with_gradient, linear_slopes) = field.linear_gradient_range(cell);
    let corners = (0..8).map(|k| Point3::from_fn(|axis, _| [cell.min, cell.max][k >> axis & 1][axis]));
    let inside: Vec<Point3> = (0..30).map(|_| sequence.point(cell)).collect();
    for p in corners.chain(inside) {
        let (value, gradient) = field.gradient(p);
        assert!(range.contains(value), "{value} outside {range:?} at {p:?} of {cell:?}");
        assert!(with_gradient.contains(value));
        check_linear(&linear, cell, &p, value);
        check_linear(&linear_with_gradient, cell, &p, value);
        for axis in 0..3 {
            let slope = gradient[axis];
            assert!(slopes[axis].contains(slope), "{slope} outside {:?} at {p:?} of {cell:?}", slopes[axis]);
            check_linear(&linear_slopes[axis], cell, &p, slope);
        }
    }
}

fn check_linear(linear: &Affine, cell: &Aabb, p: &Point3, value: f64) {
    assert!(linear.range().contains(value), "{value} outside {linear:?} at {p:?} of {cell:?}");
    let share =
        (p - cell.center()).component_div(&(0.5 * cell.size())).map(|u| if u.is_finite() { u } else { 0.0 });
    let predicted = linear.center + (0..3).map(|i| linear.slope[i] * share[i]).sum::<f64>();
    // The position in the cell was rounded.
    let rounding = 1e-9 * linear.radius() + 4.0 * f64::EPSILON * linear.center.abs();
    assert!(
        (value - predicted).abs() <= linear.error + rounding,
        "{value} against {linear:?} at {p:?} of {cell:?}"
    );
}

/// All of space, and half of it, are cells like any other.
fn check_unbounded(field: &dyn Field, points: &Points) {
    let everywhere = Vec3::repeat(f64::INFINITY);
    let space = Aabb::new(-everywhere, everywhere);
    let half = Aabb::new(Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, points.z[0]), everywhere);
    for cell in [space, half] {
        let range = field.range(&cell);
        let (_, slopes) = field.gradient_range(&cell);
        for interval in slopes.into_iter().chain([range]) {
            assert!(interval.lo <= interval.hi, "{interval:?}");
        }
        for i in (0..points.len()).filter(|&i| cell.contains(&points.get(i))) {
            assert!(range.contains(field.value(points.get(i))));
        }
    }
}
