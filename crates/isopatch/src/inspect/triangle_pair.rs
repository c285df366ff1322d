//! Do two triangles of a mesh intersect, other than in the vertices that they share? Decided exactly.
//!
//! Only signs of determinants are asked for, and `robust` gets them right: there is no tolerance, and the answer does
//! not depend on where the mesh stands or how it is turned.

use crate::geom::Point3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Corners of a triangle.
pub(super) type Corners = [Point3; 3];

/// The side of a plane or line that a point is on: 1, −1, or 0 on it.
type Side = i8;

/// Do the closed triangles `a` and `b` have a point in common that is not in what they share by number?
///
/// `numbers` are those of the corners. Both triangles have an area: without one, use [`has_area`], all points of a
/// triangle are on its sides, which are those of its neighbours.
pub(super) fn intersect(a: &Corners, b: &Corners, numbers: [[u32; 3]; 2]) -> bool {
    let shared: [Option<usize>; 3] =
        std::array::from_fn(|i| numbers[1].iter().position(|n| *n == numbers[0][i]));
    let own = |i: &usize| shared[*i].is_none();
    match shared.iter().flatten().count() {
        0 => apart(a, b),
        // If they meet outside the common corner, then also on the way from it to there, up to where that leaves one
        // of the triangles: through the side that is opposite.
        1 => {
            let (i, j) = first_shared(&shared);
            at_corner(turned(a, i), turned(b, j))
        }
        2 => {
            let i = (0..3).find(own).unwrap_or(0);
            let j = (0..3).find(|j| !numbers[0].contains(&numbers[1][*j])).unwrap_or(0);
            folded(turned(a, i), &b[j])
        }
        _ => true,
    }
}

/// Has the triangle an area?
pub(super) fn has_area(t: &Corners) -> bool {
    t.iter().flatten().all(|x| x.is_finite()) && dropped_axis(t).is_some()
}

/// The first common corner, as its place in both triangles.
fn first_shared(shared: &[Option<usize>; 3]) -> (usize, usize) {
    shared.iter().enumerate().find_map(|(i, j)| Some((i, (*j)?))).unwrap_or((0, 0))
}

/// The same triangle, from corner `first` on.
fn turned(t: &Corners, first: usize) -> Corners {
    std::array::from_fn(|i| t[(first + i) % 3])
}

/// Triangles without a common corner meet where a side of one meets the other.
fn apart(a: &Corners, b: &Corners) -> bool {
    let sides = b.map(|p| side_of_plane(a, &p));
    if on_one_side(&sides) {
        return false;
    }
    let others = a.map(|p| side_of_plane(b, &p));
    if on_one_side(&others) {
        return false;
    }
    let meets = |t: &Corners, s: &Corners, of: &[Side; 3]| {
        (0..3).any(|i| segment_meets(t, [&s[i], &s[(i + 1) % 3]], [of[i], of[(i + 1) % 3]]))
    };
    meets(a, b, &sides) || meets(b, a, &others)
}

/// Triangles with a common corner, their first: does the side opposite to it meet the other triangle?
fn at_corner(a: Corners, b: Corners) -> bool {
    let sides = [side_of_plane(&a, &b[1]), side_of_plane(&a, &b[2])];
    if on_one_side(&sides) {
        return false;
    }
    let others = [side_of_plane(&b, &a[1]), side_of_plane(&b, &a[2])];
    if on_one_side(&others) {
        return false;
    }
    segment_meets(&a, [&b[1], &b[2]], sides) || segment_meets(&b, [&a[1], &a[2]], others)
}

/// Triangles with a common side lie on each other if they are in one plane and on the same side of it; `a` starts with
/// its own corner, and `p` is that of the other.
fn folded(a: Corners, p: &Point3) -> bool {
    side_of_plane(&a, p) == 0
        && dropped_axis(&a).is_some_and(|axis| {
            let side = |q: &Point3| side_of_line(axis, &a[1], &a[2], q);
            side(p) == side(&a[0])
        })
}

/// All strictly on the same side?
fn on_one_side(sides: &[Side]) -> bool {
    sides[0] != 0 && sides.iter().all(|s| *s == sides[0])
}

/// Does a segment meet a closed triangle? `sides` are those of its ends, seen from the triangle's plane.
fn segment_meets(t: &Corners, [p, q]: [&Point3; 2], sides: [Side; 2]) -> bool {
    match sides {
        [0, 0] => segment_meets_in_plane(t, p, q),
        [s, e] if s == e => false,
        // The line goes through the plane in one point of the segment: is it on the same side of the triangle's sides?
        _ => same_sign([0, 1, 2].map(|i| side_of_plane(&[*p, *q, t[i]], &t[(i + 1) % 3]))),
    }
}

/// The same for a segment in the triangle's plane, which is looked at along an axis.
fn segment_meets_in_plane(t: &Corners, p: &Point3, q: &Point3) -> bool {
    let Some(axis) = dropped_axis(t) else { return false };
    let inside = |x: &Point3| same_sign([0, 1, 2].map(|i| side_of_line(axis, &t[i], &t[(i + 1) % 3], x)));
    let separates = |a: &Point3, b: &Point3, c: &Point3, d: &Point3| {
        side_of_line(axis, a, b, c) * side_of_line(axis, a, b, d) <= 0
    };
    // With both ends outside, the segment meets two sides, and at least one of them not along its own line.
    let crosses = |i: usize| {
        let (a, b) = (&t[i], &t[(i + 1) % 3]);
        separates(a, b, p, q) && separates(p, q, a, b) && !collinear(axis, [a, b], [p, q])
    };
    inside(p) || inside(q) || (0..3).any(crosses)
}

/// Are both points of the second segment on the line of the first?
fn collinear(axis: usize, [a, b]: [&Point3; 2], other: [&Point3; 2]) -> bool {
    other.iter().all(|p| side_of_line(axis, a, b, p) == 0)
}

/// No two of opposite sign?
fn same_sign(sides: [Side; 3]) -> bool {
    !(sides.contains(&1) && sides.contains(&-1))
}

/// An axis along which the triangle is seen with an area; none if it has none.
fn dropped_axis(t: &Corners) -> Option<usize> {
    (0..3).find(|axis| side_of_line(*axis, &t[0], &t[1], &t[2]) != 0)
}

fn side_of_plane(t: &Corners, p: &Point3) -> Side {
    let [a, b, c, d] = [&t[0], &t[1], &t[2], p].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    sign(orient3d(a, b, c, d))
}

/// The side of the line from `a` to `b` that `p` is on, seen along an axis.
fn side_of_line(axis: usize, a: &Point3, b: &Point3, p: &Point3) -> Side {
    let [a, b, p] = [a, b, p].map(|p| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] });
    sign(orient2d(a, b, p))
}

fn sign(x: f64) -> Side {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}
