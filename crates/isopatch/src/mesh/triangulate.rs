//! Polygons as triangles with the same corners.

use super::FaceId;
use crate::geom::{Point3, Vec3};

/// A face that can't be cut into triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("face {face} has {corners} corners; polygons are cut into triangles up to {MOST_CORNERS}")]
pub struct TooManyCorners {
    /// The face.
    pub face: u32,
    /// Its corners.
    pub corners: usize,
}

/// Polygons with more corners are refused: the time grows with the cube of their number.
pub const MOST_CORNERS: usize = 256;

/// Triangles, and the face that each comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Triangles {
    /// The triangles, in the order of the faces.
    pub faces: Vec<[u32; 3]>,
    /// The face of each.
    pub source: Vec<FaceId>,
}

/// Cuts every face into triangles, corner by corner: always the one with the shortest diagonal that lies inside the
/// polygon, seen along its mean normal. A quadrilateral is cut along its shorter diagonal if it is convex.
///
/// # Errors
/// A face has more than [`MOST_CORNERS`] corners.
pub fn triangulate<F: AsRef<[u32]>>(positions: &[Point3], faces: &[F]) -> Result<Triangles, TooManyCorners> {
    let mut made =
        Triangles { faces: Vec::with_capacity(faces.len()), source: Vec::with_capacity(faces.len()) };
    for (f, corners) in faces.iter().enumerate() {
        let corners = corners.as_ref();
        if corners.len() > MOST_CORNERS {
            return Err(TooManyCorners { face: f as u32, corners: corners.len() });
        }
        cut_ears(positions, corners, &mut made.faces);
        made.source.resize(made.faces.len(), f.into());
    }
    Ok(made)
}

fn cut_ears(positions: &[Point3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let mut rest = corners.to_vec();
    if rest.len() > 3 {
        let at = |v: u32| positions[v as usize];
        // Newell's normal, relative to a corner so that no digits are lost far from the origin.
        let normal: Vec3 = (0..rest.len())
            .map(|i| (at(rest[i]) - at(rest[0])).cross(&(at(rest[(i + 1) % rest.len()]) - at(rest[0]))))
            .sum();
        while rest.len() > 3 {
            let ear = best_ear(positions, &rest, &normal);
            triangles.push(around(&rest, ear));
            rest.remove(ear);
        }
    }
    triangles.extend(<[u32; 3]>::try_from(rest));
}

/// Corner i with its neighbours, counter-clockwise.
fn around(corners: &[u32], i: usize) -> [u32; 3] {
    let n = corners.len();
    [corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]]
}

/// The corner whose triangle lies inside and has the shortest diagonal; of a polygon without such a corner, which crosses
/// itself, that with the shortest diagonal.
fn best_ear(positions: &[Point3], corners: &[u32], normal: &Vec3) -> usize {
    let at = |v: u32| positions[v as usize];
    let left_of = |a: u32, b: u32, c: u32| (at(b) - at(a)).cross(&(at(c) - at(a))).dot(normal);
    let is_inside = |[a, b, c]: [u32; 3]| {
        let holds = |p: u32| left_of(a, b, p) >= 0.0 && left_of(b, c, p) >= 0.0 && left_of(c, a, p) >= 0.0;
        let other = |p: &&u32| ![a, b, c].contains(*p);
        left_of(a, b, c) > 0.0 && !corners.iter().filter(other).any(|p| holds(*p))
    };
    let rank = |i: &usize| {
        let ear = around(corners, *i);
        (!is_inside(ear), (at(ear[0]) - at(ear[2])).norm_squared())
    };
    let order = |a: &(bool, f64), b: &(bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    (0..corners.len()).min_by(|a, b| order(&rank(a), &rank(b))).unwrap_or(0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn area(positions: &[Point3], triangles: &[[u32; 3]]) -> f64 {
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            0.5 * (b - a).cross(&(c - a)).z
        };
        assert!(triangles.iter().all(|t| of(t) > 0.0), "{triangles:?}");
        triangles.iter().map(of).sum()
    }

    fn flat(points: &[[f64; 2]]) -> Vec<Point3> {
        points.iter().map(|[x, y]| Point3::new(1e6 + x, y - 1e6, 5.0)).collect()
    }

    #[test]
    fn polygons_keep_their_area_and_their_corners() {
        let kite = flat(&[[0.0, 0.0], [3.0, -1.0], [4.0, 0.0], [3.0, 1.0]]);
        let cut = triangulate(&kite, &[[0, 1, 2, 3]]).unwrap();
        assert!((area(&kite, &cut.faces) - 4.0).abs() < 1e-9);
        assert!(cut.faces.iter().all(|t| t.contains(&1) && t.contains(&3)), "{:?}", cut.faces);
        // The diagonal from the notch is the only one inside.
        let arrow = flat(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]]);
        let cut = triangulate(&arrow, &[[0, 1, 2, 3]]).unwrap();
        assert!((area(&arrow, &cut.faces) - 1.5).abs() < 1e-9);
        // A comb of seven corners, beside a triangle.
        let comb =
            flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [3.0, 1.0], [2.0, 3.0], [1.0, 1.0], [0.0, 3.0]]);
        let faces: [&[u32]; 2] = [&[0, 1, 2], &[0, 1, 2, 3, 4, 5, 6]];
        let cut = triangulate(&comb, &faces).unwrap();
        assert_eq!(cut.faces.len(), 6);
        assert_eq!(cut.source, [0, 1, 1, 1, 1, 1].map(FaceId));
        assert!((area(&comb, &cut.faces[1..]) - 8.0).abs() < 1e-9);
    }

    #[test]
    fn polygons_that_cross_themselves_or_are_flat_end() {
        let line = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.5, 0.0]]);
        assert_eq!(triangulate(&line, &[[0, 1, 2, 3, 4]]).unwrap().faces.len(), 3);
        let many: Vec<u32> = (0..300).collect();
        let positions = vec![Point3::zeros(); 300];
        assert_eq!(triangulate(&positions, &[many]), Err(TooManyCorners { face: 0, corners: 300 }));
    }
}
