//! The numbers in which the wires and patches of Bajaj & Xu 1997 are computed: `f64`, or rational numbers, in which everything they
//! claim can be checked without an error.

use nalgebra::{Scalar, Vector3};
use num_traits::{NumAssign, Signed};

/// A field with an order: `f64`, `BigRational`.
pub trait Number: Scalar + NumAssign + Signed + PartialOrd {}

impl<T: Scalar + NumAssign + Signed + PartialOrd> Number for T {}

/// A vector of three numbers.
pub type Vector<T> = Vector3<T>;

/// A small whole number.
pub fn whole<T: Number>(n: u32) -> T {
    (0..n).fold(T::zero(), |sum, _| sum + T::one())
}

/// s v.
pub fn scaled<T: Number>(v: &Vector<T>, s: &T) -> Vector<T> {
    v.map(|x| x * s.clone())
}

/// v without its part along n.
pub fn off<T: Number>(v: &Vector<T>, n: &Vector<T>) -> Vector<T> {
    v - scaled(n, &(n.dot(v) / n.dot(n)))
}

/// Is |a × b| ≤ `tolerance` |a| |b|?
pub fn are_parallel<T: Number>(a: &Vector<T>, b: &Vector<T>, tolerance: &T) -> bool {
    let c = a.cross(b);
    c.dot(&c) <= tolerance.clone() * tolerance.clone() * a.dot(a) * b.dot(b)
}

/// Is |a · b| ≤ `tolerance` |a| |b|?
pub fn are_orthogonal<T: Number>(a: &Vector<T>, b: &Vector<T>, tolerance: &T) -> bool {
    let c = a.dot(b);
    c.clone() * c <= tolerance.clone() * tolerance.clone() * a.dot(a) * b.dot(b)
}

/// det[a, b, c].
pub fn determinant<T: Number>(a: &Vector<T>, b: &Vector<T>, c: &Vector<T>) -> T {
    a.cross(b).dot(c)
}

/// x with aᵢ · x = sᵢ; none if the rows are dependent.
pub fn solve<T: Number>(rows: &[Vector<T>; 3], s: &[T; 3]) -> Option<Vector<T>> {
    let [a, b, c] = rows;
    let det = determinant(a, b, c);
    if det.is_zero() {
        return None;
    }
    let sum = scaled(&b.cross(c), &s[0]) + scaled(&c.cross(a), &s[1]) + scaled(&a.cross(b), &s[2]);
    Some(sum.map(|x| x / det.clone()))
}
