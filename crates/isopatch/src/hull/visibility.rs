use crate::geom::Vec3;

/// The unit vector with the largest smallest product with the given unit normals, and that product.
///
/// It is the centre of the smallest cap around the normals, which two or three of them determine: all pairs and triples
/// are tried, O(n⁴) for n of them. None if there are no normals or they cancel in every pair and triple.
pub fn most_visible_direction(normals: &[Vec3]) -> Option<(Vec3, f64)> {
    let least = |d: &Vec3| normals.iter().map(|n| n.dot(d)).fold(f64::INFINITY, f64::min);
    let mut best: Option<(Vec3, f64)> = None;
    let mut consider = |candidate: Vec3| {
        if let Some(d) = candidate.try_normalize(CANCELLED) {
            let product = least(&d);
            if best.is_none_or(|(_, most)| product > most) {
                best = Some((d, product));
            }
        }
    };
    for (i, a) in normals.iter().enumerate() {
        consider(*a);
        for (j, b) in normals.iter().enumerate().take(i) {
            consider(a + b);
            for c in &normals[..j] {
                // Equally far from all three.
                let axis = (a - c).cross(&(b - c));
                consider(axis);
                consider(-axis);
            }
        }
    }
    best
}

/// Shorter sums of unit vectors have no direction left.
const CANCELLED: f64 = 1e-12;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_of_a_cube_is_seen_along_its_diagonal() {
        let (d, product) = most_visible_direction(&[Vec3::x(), Vec3::y(), Vec3::z(), Vec3::z()]).unwrap();
        assert!((d - Vec3::new(1.0, 1.0, 1.0).normalize()).norm() < 1e-15);
        assert!((product - 1.0 / 3f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn opposite_normals_are_seen_from_nowhere() {
        let (_, product) = most_visible_direction(&[Vec3::x(), -Vec3::x(), Vec3::y()]).unwrap();
        assert!(product <= 1e-15);
        assert_eq!(most_visible_direction(&[]), None);
    }
}
