//! Patches over conic wires: Bajaj & Xu 1997, section 6, "covering conic wire frames".
//!
//! Everything here is exact in exact numbers. Wires and normal functions are those of [`crate::network::wire_conic`], one for each edge of the
//! triangle, along the edge.

use super::patch::RationalPatch;
use crate::bernstein::curve;
use crate::geom::{Mat3, Point3, Vec3};
use crate::network::number::{Number, Vector, off, scaled, solve, whole};
use crate::network::wire_conic::{Conic, ConicNormals};
use crate::network::wire_cubic::least_squares;

/// The quadratic triangle over three wires, (6.1): its net in the order of [`crate::bernstein`]. The wires have one point in common at
/// each corner.
pub fn cover<T: Number>(wires: [&Conic<T>; 3]) -> [Vector<T>; 6] {
    let [[a, ab, _], [b, bc, _], [c, ca, _]] = wires.map(Conic::bezier);
    [a, ab, ca, b, bc, c]
}

/// What the conditions (6.13) on the vector of one edge say: it is `particular` plus any multiple of `free`.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeCondition<T: Number> {
    /// The constant in (6.13): the product of the vector with the numerator of the normal function, everywhere.
    pub constant: T,
    /// The shortest vector with these products.
    pub particular: Vector<T>,
    /// n₀ × n₁ at the ends of the edge; zero where these are parallel.
    pub free: Vector<T>,
}

/// The conditions on the vector U_k of edge k, from the net of [`cover`].
///
/// R·n = a₀ t(1 − t) for the derivative R across the edge and the numerator n of the normal function, and U_k·n = −a₀. With the
/// numerator, not n itself: 1 + w stays in the second equation.
pub fn condition<T: Number>(net: &[Vector<T>; 6], normals: &ConicNormals<T>, k: usize) -> EdgeCondition<T> {
    use crate::bernstein::index::row;
    let two = whole::<T>(2);
    let across = |m: usize| scaled(&(&net[row(2, k, 1, m)] - &net[row(2, k, 0, m + 1)]), &two);
    let [m0, m1] = &normals.numerator;
    let constant = -(across(0).dot(m1) + across(1).dot(m0));
    let e = off(m1, m0);
    let free = m0.cross(m1);
    let ratio = constant.clone() / m0.dot(m0);
    let missing = constant.clone() - ratio.clone() * m0.dot(m1);
    let reach = m1.dot(&e);
    let aside = if free.dot(&free).is_zero() || reach.is_zero() { T::zero() } else { missing / reach };
    EdgeCondition { constant, particular: scaled(m0, &ratio) + scaled(&e, &aside), free }
}

/// The vectors U₀, U₁, U₂ with which P₁ is `middle` at the centroid: the only ones (Lemma 6.1). None if the normals at the corners are
/// dependent.
///
/// The 9 × 9 system of the paper in the unknowns x_k, U_k = particular_k + x_k free_k: the last three rows, Σ U_k = 3 p, are all
/// that is left.
pub fn vectors<T: Number>(conditions: &[EdgeCondition<T>; 3], middle: &Vector<T>) -> Option<[Vector<T>; 3]> {
    let known: Vector<T> = conditions.iter().fold(Vector::zeros(), |sum, c| sum + &c.particular);
    let wanted = scaled(middle, &whole(3)) - known;
    // Rows of the transpose: x solves Σ x_k free_k = wanted.
    let [f0, f1, f2] = conditions.each_ref().map(|c| &c.free);
    let rows = [0, 1, 2].map(|i| Vector::new(f0[i].clone(), f1[i].clone(), f2[i].clone()));
    let x = solve(&rows, &[wanted[0].clone(), wanted[1].clone(), wanted[2].clone()])?;
    Some([0, 1, 2].map(|k| &conditions[k].particular + scaled(&conditions[k].free, &x[k])))
}

/// The same for normals at the corners that are dependent, but independent in pairs: P₁ is as close to `middle` at the centroid as it can
/// be (the note after Lemma 6.1). Singular values below `tolerance` times the largest count as 0.
pub fn vectors_relaxed(conditions: &[EdgeCondition<f64>; 3], middle: &Vec3, tolerance: f64) -> [Vec3; 3] {
    let known: Vec3 = conditions.iter().map(|c| c.particular).sum();
    let free = Mat3::from_columns(&[conditions[0].free, conditions[1].free, conditions[2].free]);
    let x = least_squares(&free, &(3.0 * middle - known), tolerance);
    [0, 1, 2].map(|k| conditions[k].particular + x[k] * conditions[k].free)
}

/// The patch of a quadratic net and the vectors of its edges.
pub fn patch(net: &[Point3; 6], vectors: &[Vec3; 3]) -> RationalPatch {
    let [a, ab, ca, b, bc, c] = *net;
    let wires = [[a, ab, b], [b, bc, c], [c, ca, a]].map(|wire| curve::elevate::<3, 4>(&wire));
    // t(1 − t) U has the coefficients 0, U/3, U/3, 0.
    let across = vectors.map(|u| [Vec3::zeros(), u / 3.0, u / 3.0, Vec3::zeros()]);
    RationalPatch { across, ..RationalPatch::over_wires(&wires) }
}
