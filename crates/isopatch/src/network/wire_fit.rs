//! Wires brought onto a surface: the lengths of their tangents are free, their directions are not.

use super::wire::{Wire, WireEnd};
use crate::geom::{Points, Vec3};
use crate::surface::Target;
use nalgebra::{SMatrix, SVector};

/// Parameters at which the distance from the surface counts.
const PARAMETERS: [f64; 3] = [0.25, 0.5, 0.75];
/// Gauss–Newton steps.
const STEPS: usize = 4;
/// Shortest and longest arm of the wire, in its chord: from an end to the next Bézier point. 1/3 makes a straight line of even speed.
const ARMS: [f64; 2] = [0.05, 0.8];
/// What a change of an arm by its own length counts for, in distances of one chord: it decides where distances do not.
const STIFFNESS: f64 = 0.02;
/// Unknowns: three for each arm.
const UNKNOWNS: usize = 6;

type Unknowns = SVector<f64, UNKNOWNS>;

/// The wire with arms for which it is closer to the target, by least squares; the wire itself if there are none.
///
/// Arms keep their directions; those of a free end turn as well, in the `plane` with this normal if there is one.
pub fn fitted(wire: &Wire, ends: &[WireEnd; 2], plane: Option<Vec3>, target: &dyn Target) -> Wire {
    let chord = (wire[3] - wire[0]).norm();
    let arms = [wire[1] - wire[0], wire[2] - wire[3]];
    let bases = [0, 1].map(|end| basis(&arms[end], ends[end], plane));
    let moved = |x: &Unknowns| {
        let shift = |end: usize| (0..3).map(|i| bases[end][i] * x[3 * end + i]).sum::<Vec3>();
        [wire[0], wire[1] + shift(0), wire[2] + shift(1), wire[3]]
    };
    let mut x = Unknowns::zeros();
    let Some(mut at) = Residuals::of(wire, target) else { return *wire };
    for _ in 0..STEPS {
        let mut matrix = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::identity() * (STIFFNESS * chord).powi(2);
        let mut right = -x * (STIFFNESS * chord).powi(2);
        for (i, t) in PARAMETERS.into_iter().enumerate() {
            let weights = [3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t)];
            let row = Unknowns::from_fn(|k, _| weights[k / 3] * at.normals[i].dot(&bases[k / 3][k % 3]));
            matrix += row * row.transpose();
            right -= row * at.offsets[i];
        }
        let Some(factor) = matrix.cholesky() else { break };
        let next = x + factor.solve(&right);
        let tried = moved(&next);
        let lengths = [(tried[1] - tried[0]).norm(), (tried[2] - tried[3]).norm()];
        let is_short = lengths.iter().all(|l| (ARMS[0] * chord..=ARMS[1] * chord).contains(l));
        let forwards = |end: usize| (tried[1 + end] - tried[3 * end]).dot(&arms[end]) > 0.0;
        match Residuals::of(&tried, target)
            .filter(|r| is_short && forwards(0) && forwards(1) && r.sum() < at.sum())
        {
            Some(better) => (x, at) = (next, better),
            None => break,
        }
    }
    moved(&x)
}

/// Directions in which an arm may change, each as long as it; zero where there are fewer than three.
fn basis(arm: &Vec3, end: WireEnd, plane: Option<Vec3>) -> [Vec3; 3] {
    match (end, plane.and_then(|n| n.try_normalize(0.0))) {
        (WireEnd::Free, None) => [0, 1, 2].map(|i| Vec3::ith(i, arm.norm())),
        (WireEnd::Free, Some(n)) => [*arm, n.cross(arm), Vec3::zeros()],
        _ => [*arm, Vec3::zeros(), Vec3::zeros()],
    }
}

/// Distances of a wire from a target, and the normals there.
struct Residuals {
    offsets: [f64; 3],
    normals: [Vec3; 3],
}

impl Residuals {
    /// None where the target has no distance.
    fn of(wire: &Wire, target: &dyn Target) -> Option<Self> {
        let points: Points = PARAMETERS.iter().map(|t| crate::bernstein::curve::point(wire, *t)).collect();
        let (mut offsets, mut normals) = ([0.0; 3], points.clone());
        target.offsets(points.view(), &mut offsets, normals.view_mut());
        let normals = [0, 1, 2].map(|i| normals.get(i));
        let finite = offsets.iter().all(|d| d.is_finite()) && normals.iter().flatten().all(|c| c.is_finite());
        finite.then_some(Self { offsets, normals })
    }

    fn sum(&self) -> f64 {
        self.offsets.iter().map(|d| d * d).sum()
    }
}
