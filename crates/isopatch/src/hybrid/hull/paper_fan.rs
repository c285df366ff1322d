//! The paper's default rule for fans (4.14): value and gradient at v such that the K cubics come nearest to quadratics that agree
//! where they meet, coefficient by coefficient, in the least-squares solution of smallest size.

use crate::geom::Vec3;
use crate::hybrid::{FanNet, HybridFace, Jet, PolygonFrame};
use nalgebra::{DMatrix, DVector};

/// Value and gradient at v.
const AT_APEX: usize = 4;

/// Singular values below this, relative to 1, are zero.
const SINGULAR: f64 = 1e-9;

/// F(v), ∇F(v) of a fan; none without both apexes.
pub(super) fn at_apex(frame: &PolygonFrame, face: &HybridFace) -> Option<Jet> {
    let [u, v] = face.apexes;
    let (u, v) = (u?, v?);
    let length = frame.p.iter().map(|p| (p - v).norm()).fold(0.0, f64::max);
    let jet = |x: &[f64]| Jet { value: length * x[0], gradient: Vec3::new(x[1], x[2], x[3]) };
    // All coefficients are affine in the parameters.
    let at = |x: &[f64]| coefficients(&FanNet::new(frame, &u, &v, &jet(x)));
    let fixed = at(&[0.0; AT_APEX]);
    let quadratic = raised(frame);
    let mut matrix = DMatrix::zeros(fixed.len(), 3 + 4 * frame.count() + AT_APEX);
    for (row, pairs) in quadratic.iter().enumerate() {
        pairs.iter().for_each(|pair| matrix[(row, AT_APEX + pair)] += length / 3.0);
    }
    for n in 0..AT_APEX {
        let mut one = [0.0; AT_APEX];
        one[n] = 1.0;
        at(&one).iter().zip(&fixed).enumerate().for_each(|(row, (t, t0))| matrix[(row, n)] = t0 - t);
    }
    let x = matrix.svd(true, true).solve(&DVector::from_vec(fixed), SINGULAR).ok()?;
    Some(jet(&x.as_slice()[..AT_APEX]))
}

/// The 10 K + 4 coefficients of the cubics: those on the axis, then for each corner and its edge those with it.
fn coefficients(net: &FanNet) -> Vec<f64> {
    let of_corner = |s: usize| {
        let ([uup, uvp, vvp], [upp, vpp]) = (net.twice[s], net.corner[s]);
        let ([upq, vpq], [ppq, pqq]) = (net.edge[s], net.base[s]);
        [uup, uvp, vvp, upp, vpp, 0.0, upq, vpq, ppq, pqq]
    };
    net.axis.into_iter().chain((0..net.corner.len()).flat_map(of_corner)).collect()
}

/// Of which three coefficients of the quadratics each of those is the mean, when these are raised to degree 3. Theirs are numbered:
/// uu, uv, vv, and for each corner up, vp, pp, pq.
fn raised(frame: &PolygonFrame) -> Vec<[usize; 3]> {
    let [uu, uv, vv] = [0, 1, 2];
    let mut all = vec![[uu; 3], [uu, uv, uv], [uv, uv, vv], [vv; 3]];
    for s in 0..frame.count() {
        let [up, vp, pp, pq] = [0, 1, 2, 3].map(|n| 3 + 4 * s + n);
        let [uq, vq, qq] = [0, 1, 2].map(|n| 3 + 4 * frame.after(s) + n);
        all.extend([
            [uu, up, up],
            [uv, up, vp],
            [vv, vp, vp],
            [up, up, pp],
            [vp, vp, pp],
            [pp; 3],
            [up, uq, pq],
            [vp, vq, pq],
            [pp, pq, pq],
            [pq, pq, qq],
        ]);
    }
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::geom::Point3;
    use crate::hull::Class;
    use crate::hybrid::{Element, Quadric};

    /// Over a quadrilateral that is not plane the equations determine everything, and quadrics come back.
    #[test]
    fn quadrics_over_bent_quadrilaterals_are_found() {
        let quadric = Quadric {
            coefficients: [0.1, 0.2, -0.1, 0.9, 0.3, -0.25, 0.2, 0.15, -0.1, 0.05],
            center: Point3::zeros(),
            scale: 1.0,
        };
        // The corners are on the quadric.
        let corners = [[1.0, 0.1], [0.1, 1.1], [-0.9, 0.2], [-0.1, -1.0]].map(|[x, y]| {
            let mut p = Point3::new(x, y, 0.0);
            for _ in 0..30 {
                p.z -= quadric.value(&p) / quadric.gradient(&p).z;
            }
            assert!(quadric.value(&p).abs() < 1e-15);
            p
        });
        let n: Vec<Vec3> = corners.iter().map(|p| quadric.gradient(p)).collect();
        let next = |k: usize| (k + 1) % 4;
        let middle = (0..4)
            .map(|k| crate::hybrid::middle_gradient([&corners[k], &corners[next(k)]], [&n[k], &n[next(k)]]))
            .collect();
        let frame = PolygonFrame { p: corners.to_vec(), n, middle, forward: vec![true; 4] };
        let (center, normal) = super::super::shape::diagonal_axis(&corners).unwrap();
        let apexes = [1.0, -1.0].map(|height| Some(center + height * normal));
        let face = HybridFace {
            class: Class::Nonconvex,
            element: Some(Element::Fan),
            center,
            normal,
            apexes,
            at_apex: [None; 2],
            quadric: Quadric::ZERO,
        };
        let found = at_apex(&frame, &face).unwrap();
        let v = apexes[1].unwrap();
        assert!((found.value - quadric.value(&v)).abs() < 1e-12, "{found:?}");
        assert!((found.gradient - quadric.gradient(&v)).norm() < 1e-12, "{found:?}");
    }
}
