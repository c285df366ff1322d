//! Planted intersections: pairs of triangles, meshes and splines that go through themselves, or nearly.

use super::fixtures::*;
use crate::geom::{Point3, Vec3};
use crate::inspect::triangle_pair::{Corners, has_area, intersect};
use crate::inspect::{intersections, mesh_intersections};
use crate::spline::TriangularSpline;
use crate::surface::Surface;
use crate::tessellate::{TessellateOptions, tessellate};
use proptest::prelude::*;

fn triangle(corners: [[f64; 3]; 3]) -> Corners {
    corners.map(Point3::from)
}

/// Asked in both orders and from all corners on, which must not matter.
fn meet(a: &Corners, b: &Corners, numbers: [[u32; 3]; 2]) -> bool {
    let turn = |k: usize| [0, 1, 2].map(|i| (i + k) % 3);
    let both = |k: usize, l: usize| {
        let (k, l) = (turn(k), turn(l));
        let (a, b) = (k.map(|i| a[i]), l.map(|i| b[i]));
        let numbers = [k.map(|i| numbers[0][i]), l.map(|i| numbers[1][i])];
        let answers = [intersect(&a, &b, numbers), intersect(&b, &a, [numbers[1], numbers[0]])];
        assert_eq!(answers[0], answers[1]);
        answers[0]
    };
    let answers: Vec<bool> = (0..9).map(|n| both(n / 3, n % 3)).collect();
    assert!(answers.iter().all(|answer| *answer == answers[0]), "{a:?} {b:?}");
    answers[0]
}

const NOTHING_SHARED: [[u32; 3]; 2] = [[0, 1, 2], [3, 4, 5]];

#[test]
fn triangles_without_a_common_vertex() {
    let flat = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    let ulp = f64::MIN_POSITIVE;
    for (expected, corners, what) in [
        (true, [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 0.0]], "a side goes through"),
        (true, [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]], "a corner touches"),
        (false, [[1.0, 1.0, ulp], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]], "a corner does not quite touch"),
        (true, [[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0]], "corner on corner"),
        (true, [[-1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "side on side"),
        (false, [[-1.0, -ulp, 0.0], [5.0, -ulp, 0.0], [0.0, 0.0, 1.0]], "side beside side"),
        (true, [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]], "one inside the other"),
        (true, [[-9.0, -9.0, 0.0], [99.0, -9.0, 0.0], [-9.0, 99.0, 0.0]], "one around the other"),
        (true, [[2.0, 2.0, 0.0], [5.0, 2.0, 0.0], [2.0, 5.0, 0.0]], "a corner on a side, in the plane"),
        (false, [[3.0, 2.0, 0.0], [5.0, 2.0, 0.0], [3.0, 5.0, 0.0]], "beside, in the plane"),
        (false, [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]], "parallel"),
        (false, [[5.0, 5.0, -1.0], [5.0, 5.0, 1.0], [9.0, 9.0, 0.0]], "through the plane outside"),
    ] {
        assert_eq!(meet(&flat, &triangle(corners), NOTHING_SHARED), expected, "{what}");
    }
}

#[test]
fn triangles_with_common_vertices() {
    let flat = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    for (expected, b, c, what) in [
        (false, [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0], "away"),
        (false, [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], "away, in the plane"),
        (false, [2.0, 2.0, 1.0], [1.0, 3.0, 1.0], "over it"),
        (true, [2.0, 2.0, 1.0], [2.0, 2.0, -1.0], "through it"),
        (true, [5.0, 5.0, 1.0], [5.0, 5.0, -1.0], "through it, opposite side outside"),
        (true, [1.0, 2.0, 0.0], [-1.0, 2.0, 0.0], "upon it, in the plane"),
        (true, [9.0, 9.0, 0.0], [0.0, 0.0, 1.0], "a side along it"),
        (false, [-9.0, -9.0, 0.0], [0.0, 0.0, 1.0], "a side in the plane, away"),
    ] {
        let other = triangle([[0.0; 3], b, c]);
        assert_eq!(meet(&flat, &other, [[0, 1, 2], [0, 3, 4]]), expected, "{what}");
    }
    for (expected, p, what) in [
        (false, [4.0, 4.0, 0.0], "flat"),
        (false, [0.0, 0.0, 1e-300], "folded, but not quite"),
        (true, [0.0, 0.0, 0.0], "folded onto itself"),
        (true, [1.0, -3.0, 0.0], "folded, and beyond"),
    ] {
        let other = Corners::from([p.into(), flat[2], flat[1]]);
        assert_eq!(meet(&flat, &other, [[0, 1, 2], [3, 2, 1]]), expected, "{what}");
    }
    assert!(meet(&flat, &flat, [[0, 1, 2], [0, 1, 2]]), "the same twice");
}

type Corner = [i64; 3];

/// Do two triangles with small whole coordinates meet? No axis of the separating-axis theorem separates them.
fn oracle(a: &[Corner; 3], b: &[Corner; 3]) -> bool {
    let minus = |p: &Corner, q: &Corner| [0, 1, 2].map(|i| p[i] - q[i]);
    let cross = |p: &Corner, q: &Corner| {
        [0, 1, 2].map(|i| p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3])
    };
    let sides = |t: &[Corner; 3]| [0, 1, 2].map(|i| minus(&t[(i + 1) % 3], &t[i]));
    let (of_a, of_b) = (sides(a), sides(b));
    let normals = [cross(&of_a[0], &of_a[1]), cross(&of_b[0], &of_b[1])];
    let in_plane =
        [0, 1, 2].iter().flat_map(|i| [cross(&normals[0], &of_a[*i]), cross(&normals[1], &of_b[*i])]);
    let both = of_a.iter().flat_map(|e| of_b.iter().map(move |f| cross(e, f)));
    let separates = |axis: Corner| {
        let along = |p: &Corner| (0..3).map(|i| axis[i] * p[i]).sum::<i64>();
        let range = |t: &[Corner; 3]| {
            let t = t.map(|p| along(&p));
            (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]))
        };
        let (a, b) = (range(a), range(b));
        a.1 < b.0 || b.1 < a.0
    };
    !normals.into_iter().chain(in_plane).chain(both).any(separates)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Few different coordinates, so that touching, coplanar and collinear triangles are frequent.
    #[test]
    fn pairs_agree_with_the_separating_axis_theorem(
        a in proptest::array::uniform3(proptest::array::uniform3(0i64..4)),
        b in proptest::array::uniform3(proptest::array::uniform3(0i64..4)),
    ) {
        let [c, d] = [a, b].map(|t| t.map(|p| Point3::from(p.map(|x| x as f64))));
        if has_area(&c) && has_area(&d) {
            prop_assert_eq!(meet(&c, &d, NOTHING_SHARED), oracle(&a, &b));
        }
    }
}

#[test]
fn golden_splines_do_not_go_through_themselves() {
    for name in ["sphere_icosahedron_rec", "torus_12x6_rec", "ellipsoid_small_rec"] {
        let Some(golden) = golden(name) else { continue };
        for resolution in [1, 4, 7] {
            let found = intersections(&golden.spline, resolution).unwrap();
            assert_eq!(found.triangles, golden.spline.patch_count() * resolution * resolution);
            assert_eq!((found.count, found.first.len()), (0, 0), "{name}");
        }
    }
}

/// One patch pulled through the opposite side of the sphere, its boundary left where it is.
fn pulled_through() -> TriangularSpline {
    let mut spline = icosahedron();
    let depth = 20.0 * spline.base.normals[0];
    let inner = crate::bernstein::index::indices(7).filter(|ijk| !crate::bernstein::index::is_boundary(*ijk));
    for at in inner.map(crate::bernstein::index::position) {
        spline.nets[0][at] -= depth;
    }
    spline
}

#[test]
fn a_patch_pulled_through_the_others_is_found_where_it_is() {
    let found = intersections(&pulled_through(), 6).unwrap();
    assert!(found.count > 10 && found.first.len() == 10, "{found:?}");
    for place in &found.first {
        assert!(place.patches.iter().any(|p| p.0 == 0), "{place:?}");
        // On the sphere of radius 1, to within a triangle.
        assert!((place.at.norm() - 1.0).abs() < 0.2, "{place:?}");
    }
}

/// Two spheres in one mesh, `offset` apart.
fn two_spheres(offset: f64) -> (Vec<Point3>, Vec<[u32; 3]>) {
    let options = TessellateOptions { resolution: 5 };
    let mesh = tessellate(&icosahedron(), &options).unwrap();
    let count = mesh.positions.len() as u32;
    let moved = mesh.positions.iter().map(|p| p + offset * Vec3::new(0.6, 0.0, 0.8));
    let positions = mesh.positions.iter().copied().chain(moved).collect();
    let again = mesh.triangles.iter().map(|t| t.map(|v| v + count));
    (positions, mesh.triangles.iter().copied().chain(again).collect())
}

#[test]
fn the_tree_misses_no_pair() {
    let (positions, triangles) = two_spheres(0.7);
    let corners = |t: usize| triangles[t].map(|v| positions[v as usize]);
    let mut all = Vec::new();
    for a in 0..triangles.len() {
        for b in a + 1..triangles.len() {
            if intersect(&corners(a), &corners(b), [triangles[a], triangles[b]]) {
                all.push([a as u32, b as u32]);
            }
        }
    }
    let found = mesh_intersections(&positions, &triangles);
    assert!(found.count > 50);
    assert_eq!((found.count, &found.first[..]), (all.len(), &all[..10]));
    let (positions, triangles) = two_spheres(2.1);
    assert_eq!(mesh_intersections(&positions, &triangles).count, 0);
}

#[test]
fn the_answer_does_not_depend_on_place_and_size() {
    let (positions, triangles) = two_spheres(0.7);
    let expected = mesh_intersections(&positions, &triangles);
    // Powers of two and offsets that the coordinates survive.
    for scale in [2f64.powi(-200), 2f64.powi(200)] {
        let scaled: Vec<Point3> = positions.iter().map(|p| scale * p).collect();
        assert_eq!(mesh_intersections(&scaled, &triangles), expected);
    }
}

#[test]
fn unusable_triangles_are_left_out() {
    let mut positions: Vec<Point3> =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0], [0.5, 0.5, -1.0]]
            .map(Point3::from)
            .to_vec();
    let triangles = [[0, 1, 2], [3, 4, 0], [3, 4, 4], [3, 4, 9], [1, 1, 1]];
    let found = mesh_intersections(&positions, &triangles);
    assert_eq!((found.count, found.first), (1, vec![[0, 1]]));
    for bad in [f64::NAN, f64::INFINITY] {
        positions[3].x = bad;
        assert_eq!(mesh_intersections(&positions, &triangles).count, 0);
    }
    assert_eq!(mesh_intersections(&[], &[]).count, 0);
}
