//! Patches as rational Bézier triangles with weights: the standard form (RBB) of Bajaj & Xu 1997.
//!
//! Numerator and denominator both vanish at the corners: the weights there are 0, and so are the weighted points (base points).
//! Elsewhere weights are positive. [`super::pieces`] has forms whose weights are all positive.

use super::form::Form;
use super::patch::{MIDDLE_SCALE, RationalPatch};
use crate::bernstein::index;
use crate::geom::{Vec3, Vec4};

/// A rational Bézier triangle: weighted control points (w x, w y, w z, w) in the order of [`crate::bernstein`].
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedNet {
    /// Degree of numerator and denominator.
    pub degree: usize,
    /// (degree + 1)(degree + 2)/2 points.
    pub points: Vec<Vec4>,
}

/// The patch in Bézier form: of degree 5 if all U_k are constant, as in the paper, else of degree 6 plus the number of poles. A
/// vertex without a tangent plane makes two poles, so the degree is 8 with one of them.
pub fn weighted_net(patch: &RationalPatch) -> WeightedNet {
    let zero = Vec3::zeros();
    let coordinate = |i: usize| Form::linear(std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let l = [0, 1, 2].map(coordinate);
    let product = l[0].times(&l[1], 0.0).times(&l[2], 0.0);
    let denominator = Form::new(2, vec![0.0, 0.5, 0.5, 0.0, 0.5, 0.0]);
    // The factors s_k = l_a + l_o/2 and t_k = l_b + l_o/2 under which an edge has a pole.
    let linear = |one: usize, half: usize| {
        let mut c = [0.0; 3];
        (c[one], c[half]) = (1.0, 0.5);
        Form::linear(c)
    };
    let s = [0, 1, 2].map(|k| linear(k, (k + 2) % 3));
    let t = [0, 1, 2].map(|k| linear((k + 1) % 3, (k + 2) % 3));
    let poles: Vec<(usize, usize)> =
        (0..3).flat_map(|k| [(k, 0), (k, 3)]).filter(|(k, i)| patch.across[*k][*i] != zero).collect();
    let factor = |(k, i): (usize, usize)| if i == 0 { &t[k] } else { &s[k] };
    let common = |left_out: Option<(usize, usize)>| {
        let kept = poles.iter().filter(|pole| Some(**pole) != left_out);
        kept.fold(Form::new(0, vec![1.0]), |form, pole| form.times(factor(*pole), 0.0))
    };
    let all = common(None);
    let is_constant = poles.is_empty() && patch.middle == zero && patch.across.iter().all(|c| c[1] == c[2]);

    let weight = denominator.times(&all, 0.0);
    let cubic = Form::new(3, patch.net.to_vec()).times(&weight, zero);
    let mut sum = Form::new(if is_constant { 2 } else { 3 + poles.len() }, Vec::new());
    sum.coefficients = vec![zero; index::count(sum.degree)];
    for k in 0..3 {
        let [_, c1, c2, _] = patch.across[k];
        let ends = l[k].times(&l[(k + 1) % 3], 0.0);
        if is_constant {
            let u = Form::new(0, vec![3.0 * c1]);
            sum = sum.plus(&u.times(&ends, zero));
            continue;
        }
        let blend = |form: &Form<f64>, c: Vec3| Form::new(0, vec![c]).times(form, zero);
        let linear = blend(&s[k], 3.0 * c1).plus(&blend(&t[k], 3.0 * c2));
        sum = sum.plus(&linear.times(&ends, zero).times(&all, zero));
        for pole in poles.iter().filter(|pole| pole.0 == k) {
            // c₀ s²/t or c₃ t²/s, over the common factors.
            let other = if pole.1 == 0 { &s[k] } else { &t[k] };
            let square = other.times(other, 0.0).times(&ends, 0.0).times(&common(Some(*pole)), 0.0);
            let term = blend(&square, patch.across[k][pole.1]);
            sum = sum.plus(&term);
        }
    }
    if !is_constant {
        let bubble = product.times(&all, 0.0);
        sum = sum.plus(&Form::new(0, vec![MIDDLE_SCALE * patch.middle]).times(&bubble, zero));
    }
    let correction = sum.times(&product, zero);
    let degree = correction.degree;
    let numerator = cubic.raised(degree - cubic.degree, zero).plus(&correction);
    let weight = weight.raised(degree - weight.degree, 0.0);
    let points = numerator.coefficients.iter().zip(&weight.coefficients);
    WeightedNet { degree, points: points.map(|(p, w)| Vec4::new(p.x, p.y, p.z, *w)).collect() }
}
