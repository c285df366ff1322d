//! The wire of an edge that always exists: a cubic with given tangent planes at its ends.
//!
//! The conic and cubic wires of Bajaj & Xu 1997 (section 5) need conditions that meshes do not keep (Lemma 5.2, Theorem 5.3);
//! they are in [`super::wire_conic`] and [`super::wire_cubic`]. This construction has none. Instead of a normal function it carries
//! the direction b(t) across the curve, and C′ × b is the normal, so that it never has a pole.

use crate::geom::{Point3, Vec3};

/// What a wire keeps at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WireEnd {
    /// Nothing: the end is singular, and the curve leaves it without curvature.
    Free,
    /// A tangent plane, by a normal of any length.
    Plane(Vec3),
    /// A tangent, of any length and either sign: where two sheets cross.
    Line(Vec3),
}

/// Bézier points of a wire.
pub type Wire = [Point3; 4];

/// Smallest cosine between chord and tangent that counts for the length of the tangent; with less, the wire would be more than
/// 1/0.6 times as long at its ends as its chord.
const LEAST_COSINE: f64 = 0.2;
/// Chords that are closer than this to a normal (as a sine) have no projection onto its plane worth using.
const NO_PROJECTION: f64 = 1e-9;

/// The cubic from p₀ to p₁.
///
/// Its tangent at an end is the chord d projected into the tangent plane, made 2|d|/(1 + cos φ) long, φ being the angle between
/// the two: the length that makes an arc of a circle of it up to the sixth power of its angle. A free end takes (3d − t)/2, which makes the
/// curvature there vanish; with two free ends the wire is the chord.
pub fn wire(p: [Point3; 2], ends: [WireEnd; 2]) -> Wire {
    let chord = p[1] - p[0];
    let [t0, t1] = match ends.map(|end| tangent(&chord, end)) {
        [Some(t0), Some(t1)] => [t0, t1],
        [Some(t0), None] => [t0, 0.5 * (3.0 * chord - t0)],
        [None, Some(t1)] => [0.5 * (3.0 * chord - t1), t1],
        [None, None] => [chord, chord],
    };
    [p[0], p[0] + t0 / 3.0, p[1] - t1 / 3.0, p[1]]
}

fn tangent(chord: &Vec3, end: WireEnd) -> Option<Vec3> {
    let along = match end {
        WireEnd::Free => return None,
        WireEnd::Plane(n) => {
            let projected = chord - n * (n.dot(chord) / n.norm_squared());
            // A chord along the normal: any direction in the plane is as good as another.
            let is_lost = projected.norm() <= NO_PROJECTION * chord.norm();
            if is_lost { any_orthogonal(&n) * chord.norm() * NO_PROJECTION } else { projected }
        }
        WireEnd::Line(t) => t * (t.dot(chord) / t.norm_squared()),
    };
    let (length, shadow) = (chord.norm(), along.norm());
    let direction = along.try_normalize(0.0)?;
    let cosine = (shadow / length).clamp(LEAST_COSINE, 1.0);
    Some(direction * (2.0 * length / (1.0 + cosine)))
}

/// A unit vector at a right angle to another: with the axis that is farthest from it.
fn any_orthogonal(n: &Vec3) -> Vec3 {
    let axis = Vec3::ith(n.iamin(), 1.0);
    n.cross(&axis).try_normalize(0.0).unwrap_or(axis)
}

/// C(½).
pub fn middle(wire: &Wire) -> Point3 {
    0.125 * (wire[0] + wire[3]) + 0.375 * (wire[1] + wire[2])
}

/// Derivative at the start (0) or the end (1).
pub fn end_tangent(wire: &Wire, end: usize) -> Vec3 {
    if end == 0 { 3.0 * (wire[1] - wire[0]) } else { 3.0 * (wire[3] - wire[2]) }
}

/// The same curve from its end to its start.
pub fn reversed(wire: &Wire) -> Wire {
    [wire[3], wire[2], wire[1], wire[0]]
}

/// Bernstein coefficients of b(t), of degree 2, to the left of the wire seen against its normals.
///
/// b is the unit vector n × C′ at an end with a normal, and linear between: n(t) = C′ × b then has the given normals at the ends
/// (up to length) and is at right angles to C′ everywhere. A singular end has the b of the other end, made orthogonal to C′;
/// with two of them, `between` stands in for the normal. It also decides where b₀ and b₁ turn by more than about 80°, which the
/// linear blend would not survive: then the middle coefficient is the direction across C′(1/2) for that normal.
///
/// A normal that is not orthogonal to C′ counts as none.
pub fn across(wire: &Wire, normals: [Option<Vec3>; 2], between: &Vec3) -> [Vec3; 3] {
    let tangents = [0, 1].map(|end| end_tangent(wire, end));
    let of_end = |end: usize| {
        normals[end]
            .filter(|n| is_orthogonal(n, &tangents[end]))
            .and_then(|n| n.cross(&tangents[end]).try_normalize(0.0))
    };
    let projected = |b: &Vec3, end: usize| {
        let c = tangents[end];
        (b - c * (b.dot(&c) / c.norm_squared())).try_normalize(LOST)
    };
    let stand_in = |c: &Vec3| between.cross(c).try_normalize(0.0).unwrap_or_else(|| any_orthogonal(c));
    let [b0, b1] = match [of_end(0), of_end(1)] {
        [Some(b0), Some(b1)] => [b0, b1],
        [Some(b0), None] => [b0, projected(&b0, 1).unwrap_or_else(|| stand_in(&tangents[1]))],
        [None, Some(b1)] => [projected(&b1, 0).unwrap_or_else(|| stand_in(&tangents[0])), b1],
        [None, None] => tangents.map(|c| stand_in(&c)),
    };
    if b0.dot(&b1) > LEAST_AGREEMENT {
        return [b0, 0.5 * (b0 + b1), b1];
    }
    let middle = 0.75 * (wire[3] + wire[2] - wire[1] - wire[0]);
    [b0, stand_in(&middle), b1]
}

/// Product of b₀ and b₁ under which a linear blend of them is not trusted (about 80°).
const LEAST_AGREEMENT: f64 = 0.17;
/// A projection that is shorter has no direction to speak of.
const LOST: f64 = 1e-6;
/// Largest cosine between a normal and a tangent that are taken for orthogonal: what rounding leaves, with a margin.
const ORTHOGONAL: f64 = 1e-9;

/// Is a tangent in the plane of a normal, to rounding?
pub fn is_orthogonal(normal: &Vec3, tangent: &Vec3) -> bool {
    normal.dot(tangent).abs() <= ORTHOGONAL * normal.norm() * tangent.norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_circle_has_the_known_tangents() {
        let w = wire([Vec3::x(), Vec3::y()], [Vec3::x(), Vec3::y()].map(WireEnd::Plane));
        // 4/3 tan(π/8), the usual control point of a quarter circle.
        assert!((w[1] - Vec3::new(1.0, 0.5522847498307935, 0.0)).norm() < 1e-15);
        assert!((w[2] - Vec3::new(0.5522847498307935, 1.0, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn free_ends_have_no_curvature_and_lines_are_kept() {
        let p = [Vec3::zeros(), Vec3::new(2.0, 1.0, 0.5)];
        let w = wire(p, [WireEnd::Free, WireEnd::Plane(Vec3::new(0.3, -0.2, 1.0))]);
        assert!((w[0] - 2.0 * w[1] + w[2]).norm() < 1e-15);
        let line = wire(p, [WireEnd::Free; 2]);
        assert!((line[1] - p[1] / 3.0).norm() < 1e-15);
        let crossing = wire(p, [WireEnd::Line(-Vec3::x()), WireEnd::Free]);
        assert!(crossing[1].x > 0.0 && crossing[1].y == 0.0 && crossing[1].z == 0.0);
    }

    #[test]
    fn a_chord_along_the_normal_still_has_a_wire() {
        let w = wire([Vec3::zeros(), Vec3::z()], [WireEnd::Plane(Vec3::z()), WireEnd::Free]);
        assert!(w.iter().all(|p| p.iter().all(|c| c.is_finite())));
        assert!(is_orthogonal(&Vec3::z(), &end_tangent(&w, 0)));
    }

    #[test]
    fn across_is_the_same_from_both_sides_up_to_sign() {
        let p = [Vec3::zeros(), Vec3::new(1.0, 0.2, 0.1)];
        let n = [Vec3::new(0.1, 0.2, 1.0), Vec3::new(-0.4, 0.1, 1.0)];
        let w = wire(p, n.map(WireEnd::Plane));
        let b = across(&w, n.map(Some), &Vec3::z());
        let back = across(&reversed(&w), [Some(n[1]), Some(n[0])], &Vec3::z());
        assert!((0..3).all(|i| (b[i] + back[2 - i]).norm() < 1e-15));
        let singular = across(&w, [Some(n[0]), None], &Vec3::z());
        assert!(is_orthogonal(&singular[2], &end_tangent(&w, 1)));
        let turned = across(&w, [Some(n[0]), Some(-n[1])], &Vec3::z());
        assert!(turned[1].dot(&b[1]) > 0.0 && turned[2].dot(&b[2]) < 0.0);
    }
}
