//! Cubics Σ b_i B_i³(t) on [0, 1] that start below zero, and where they first reach it.
//!
//! A ray from the base of a hull cell to its apex meets the function of the cell in such a cubic, and the surface is at
//! its smallest root. Roots are found in s = t/(1 − t), where the cubic is
//!
//! ```text
//! P(s) = b_0 + 3 b_1 s + 3 b_2 s² + b_3 s³.
//! ```

/// Most steps of Newton's method in [`simple_root`]. Four are enough wherever the cubic term does not rule; where it
/// does, a step takes away a third until the root is near.
const NEWTON_STEPS: usize = 100;

/// Steps of the guarded Newton's method in [`minimal_root`]; halving alone needs as many to reach the rounding of f64.
const GUARDED_STEPS: usize = 80;

/// Σ b_i B_i³(t).
pub fn value(b: &[f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    s * s * s * b[0] + 3.0 * t * s * (s * b[1] + t * b[2]) + t * t * t * b[3]
}

/// The derivative of [`value`] by t.
pub fn derivative(b: &[f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    3.0 * (s * s * (b[1] - b[0]) + 2.0 * s * t * (b[2] - b[1]) + t * t * (b[3] - b[2]))
}

/// Are the signs (−, ∗, +, +)? Then there is one root in (0, 1), it is simple, and [`simple_root`] finds it.
pub fn has_simple_root(b: &[f64; 4]) -> bool {
    b[0] < 0.0 && b[2] >= 0.0 && b[3] >= 0.0 && (b[1] > 0.0 || b[2] > 0.0)
}

/// The root of a cubic for which [`has_simple_root`] and `b[1]` > 0.
///
/// The root of the first three terms of P is an upper bound, and P is convex, so that Newton's method falls onto the root
/// without passing it: the first step that does not fall has arrived.
pub fn simple_root(b: &[f64; 4]) -> f64 {
    let mut s = start(b);
    for _ in 0..NEWTON_STEPS {
        let next = newton_step(b, s);
        if next >= s || next.is_nan() {
            break;
        }
        s = next;
    }
    s / (1.0 + s)
}

/// Root of the first three terms of P, for `b[1]` > 0 and `b[2]` ≥ 0.
fn start(b: &[f64; 4]) -> f64 {
    -2.0 * b[0] / (3.0 * b[1] + (9.0 * b[1] * b[1] - 12.0 * b[0] * b[2]).sqrt())
}

/// A step of Newton's method for P.
fn newton_step(b: &[f64; 4], s: f64) -> f64 {
    let value = ((b[3] * s + 3.0 * b[2]) * s + 3.0 * b[1]) * s + b[0];
    let slope = 3.0 * ((b[3] * s + 2.0 * b[2]) * s + b[1]);
    s - value / slope
}

/// The smallest t in [0, 1] with a value ≥ 0, for any signs; 0 if `b[0]` ≥ 0, none if the cubic stays negative.
pub fn minimal_root(b: &[f64; 4]) -> Option<f64> {
    if b[0] >= 0.0 {
        return Some(0.0);
    }
    if b[1] > 0.0 && has_simple_root(b) {
        return Some(simple_root(b));
    }
    let turns = turning_points(b);
    let ends = [0.0, turns[0], turns[1], 1.0];
    let crossed = (0..3).find(|i| value(b, ends[i + 1]) >= 0.0)?;
    Some(guarded_newton(b, ends[crossed], ends[crossed + 1]))
}

/// The largest t ≤ 0 with a value ≤ 0, down to −1, for `b[0]` > 0: the surface behind the base of a cell.
pub fn root_behind(b: &[f64; 4]) -> Option<f64> {
    // The same cubic in −t, in Bernstein form again.
    let [a0, a1, a2, a3] = monomials(b);
    let (m1, m2, m3) = (-a1, a2, -a3);
    let mirrored = [a0, a0 + m1 / 3.0, a0 + (2.0 * m1 + m2) / 3.0, a0 + m1 + m2 + m3];
    minimal_root(&mirrored.map(|c| -c)).map(|t| -t)
}

/// Coefficients of 1, t, t², t³.
pub fn monomials(b: &[f64; 4]) -> [f64; 4] {
    [b[0], 3.0 * (b[1] - b[0]), 3.0 * (b[2] - 2.0 * b[1] + b[0]), b[3] - b[0] + 3.0 * (b[1] - b[2])]
}

/// Where the derivative vanishes, clamped to [0, 1] and in order; 1 where it does not.
fn turning_points(b: &[f64; 4]) -> [f64; 2] {
    let (c, d, e) = (b[1] - b[0], b[2] - b[1], b[3] - b[2]);
    let (a, h) = (c - 2.0 * d + e, d - c);
    let discriminant = h * h - a * c;
    if discriminant < 0.0 {
        return [1.0, 1.0];
    }
    let w = -(h + discriminant.sqrt().copysign(h));
    let clamped = |t: f64| if t.is_finite() { t.clamp(0.0, 1.0) } else { 1.0 };
    let (r, q) = (clamped(w / a), clamped(c / w));
    [r.min(q), r.max(q)]
}

/// The root between `low`, where the value is negative, and `high`, where it is not; the cubic is monotone there.
fn guarded_newton(b: &[f64; 4], mut low: f64, mut high: f64) -> f64 {
    let mut t = 0.5 * (low + high);
    for _ in 0..GUARDED_STEPS {
        let f = value(b, t);
        if f < 0.0 {
            low = t;
        } else {
            high = t;
        }
        let newton = t - f / derivative(b, t);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == t || high - low <= f64::EPSILON * high {
            break;
        }
        t = next;
    }
    t
}

/// The smallest b such that Σ b_i B_i³ + b′ t² has a simple smallest root in [0, 1] that moves continuously, for every
/// b′ > b; with the t where it is attained. −∞ if b_0 ≥ 0, where the root is 0 whatever b′.
///
/// Lemma 2.3 in closed form. In s = (1 − t)/t the bound is the smallest value of
/// g₃ = −(b_0 s³ + 3 b_1 s² + 3 b_2 s + b_3)/(1 + s) over s ≥ max(0, −b_1/b_0); the paper's first bound is never less.
/// Where g₃ has no turning point there, the sharp bound is its value −b_3 at s = 0, which the lemma misses.
pub fn sharp_bound(b: &[f64; 4]) -> (f64, f64) {
    let (value, s, _) = bound_candidates(b);
    (value, 1.0 / (1.0 + s))
}

/// The bound of Lemma 2.3 as the paper has it: [`sharp_bound`] where that is inside, else the value of g₃ at
/// max(0, −b_1/b_0).
pub fn lemma_bound(b: &[f64; 4]) -> f64 {
    bound_candidates(b).2
}

/// Sharp bound, the s where it is attained, bound of the lemma.
fn bound_candidates(b: &[f64; 4]) -> (f64, f64, f64) {
    let [b0, b1, b2, b3] = *b;
    if b0 >= 0.0 {
        return (f64::NEG_INFINITY, 0.0, f64::NEG_INFINITY);
    }
    let g3 = |s: f64| -(((b0 * s + 3.0 * b1) * s + 3.0 * b2) * s + b3) / (1.0 + s);
    // Turning points of g₃ are roots of h, which is concave right of `start`.
    let h = |s: f64| ((2.0 * b0 * s + 3.0 * (b0 + b1)) * s + 6.0 * b1) * s + 3.0 * b2 - b3;
    let slope = |s: f64| 6.0 * (s + 1.0) * (b0 * s + b1);
    let start = (-b1 / b0).max(0.0);
    if h(start) <= 0.0 {
        return (-b3, 0.0, g3(start));
    }
    let mut s = start + 1.0;
    while h(s) > 0.0 && s.is_finite() {
        s = 2.0 * s + 1.0;
    }
    for _ in 0..GUARDED_STEPS {
        let next = s - h(s) / slope(s);
        if !(next >= start && next < s) {
            break;
        }
        s = next;
    }
    (g3(s), s, g3(s))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn power() -> impl Strategy<Value = f64> {
        (-4.0..1.0f64).prop_map(|e| 10f64.powf(e))
    }

    proptest! {
        #[test]
        fn simple_roots_are_exact_to_rounding(t in 1e-6..0.999999f64, b1 in power(), b2 in power(), b3 in power()) {
            // Plant the root t by the choice of b_0, in s = t/(1 − t), and solve.
            let s = t / (1.0 - t);
            let b0 = -((b3 * s + 3.0 * b2) * s + 3.0 * b1) * s;
            let b = [b0, b1, b2, b3];
            prop_assert!(has_simple_root(&b));
            let found = simple_root(&b);
            prop_assert!((found - t).abs() <= 3e-15 * t, "{found} for {t}");
            prop_assert!((minimal_root(&b).unwrap() - t).abs() <= 3e-15 * t);
        }

        #[test]
        fn minimal_roots_come_first(b0 in -1.0..-1e-3f64, b in prop::array::uniform3(-2.0..2.0f64)) {
            let b = [b0, b[0], b[1], b[2]];
            let scan = (0..=20_000).map(|i| i as f64 / 20_000.0).find(|t| value(&b, *t) >= 0.0);
            match (minimal_root(&b), scan) {
                (Some(t), Some(first)) => {
                    prop_assert!(t <= first + 1e-12 && t > first - 1.0 / 10_000.0, "{t} {first}");
                    prop_assert!(value(&b, t).abs() < 1e-13);
                }
                // A bump narrower than the scan.
                (Some(t), None) => prop_assert!(value(&b, t).abs() < 1e-13),
                (None, found) => prop_assert!(found.is_none()),
            }
        }

        #[test]
        fn roots_behind_the_base_are_roots(b in prop::array::uniform4(0.1..2.0f64)) {
            if let Some(t) = root_behind(&b) {
                prop_assert!((-1.0..0.0).contains(&t));
                prop_assert!(value(&b, t).abs() < 1e-12);
            }
        }

        #[test]
        fn above_the_sharp_bound_roots_are_simple(
            b0 in power(), b in prop::array::uniform3(-3.0..3.0f64), above in 1e-3..2.0f64,
        ) {
            let b = [-b0, b[0], b[1], b[2]];
            let (sharp, at) = sharp_bound(&b);
            prop_assert!((0.0..=1.0).contains(&at));
            // The lemma's bound is never below the sharp one.
            prop_assert!(lemma_bound(&b) >= sharp - 1e-12 * (1.0 + sharp.abs()));
            // t² is the cubic with Bernstein coefficients 0, 0, 1/3, 1.
            let lift = sharp + above * (1.0 + sharp.abs());
            let lifted = [b[0], b[1], b[2] + lift / 3.0, b[3] + lift];
            let t = minimal_root(&lifted);
            prop_assert!(t.is_some());
            prop_assert!(derivative(&lifted, t.unwrap()) > 0.0);
        }
    }

    /// Real roots of a cubic with leading coefficient a₃ ≠ 0 by Cardan's formulas (4.18)–(4.20), the paper's way.
    fn cardan([a0, a1, a2, a3]: [f64; 4]) -> Vec<f64> {
        let shift = a2 / (3.0 * a3);
        let p = a1 / (3.0 * a3) - shift * shift;
        let q = shift * shift * shift - shift * a1 / (2.0 * a3) + a0 / (2.0 * a3);
        let discriminant = q * q + p * p * p;
        if discriminant >= 0.0 {
            let r = discriminant.sqrt();
            return vec![(-q + r).cbrt() + (-q - r).cbrt() - shift];
        }
        let angle = (-q / (-p).powf(1.5)).clamp(-1.0, 1.0).acos();
        let turn = std::f64::consts::TAU / 3.0;
        (0..3).map(|k| 2.0 * (-p).sqrt() * (angle / 3.0 + f64::from(k) * turn).cos() - shift).collect()
    }

    proptest! {
        /// Cardan's formulas lose digits, and all of them where the leading coefficient is small.
        #[test]
        fn minimal_roots_are_the_first_of_cardan_s(b in prop::array::uniform3(-2.0..2.0f64)) {
            let b = [-1.0, b[0], b[1], b[2]];
            let a = monomials(&b);
            prop_assume!(a[3].abs() > 0.1);
            let roots = cardan(a);
            // The formula finds which root it is; Newton's method on the monomials gives it the digits that it lost.
            let value = |t: f64| ((a[3] * t + a[2]) * t + a[1]) * t + a[0];
            let slope_at = |t: f64| (3.0 * a[3] * t + 2.0 * a[2]) * t + a[1];
            let polished = |t: f64| (0..2).fold(t, |t, _| t - value(t) / slope_at(t));
            let first = roots.into_iter().filter(|t| (0.0..=1.0).contains(t)).reduce(f64::min).map(polished);
            if let (Some(ours), Some(first)) = (minimal_root(&b), first) {
                // A root is as certain as the value is, divided by the slope.
                let slope = derivative(&b, ours).abs();
                prop_assume!(slope > 1e-2);
                prop_assert!((ours - first).abs() < 1e-11 / slope, "{ours} {first}");
            }
        }
    }

    /// Lemma 2.3 by search over s: min over max(g₂, g₃), and over g₃ where b_0 s + b_1 ≤ 0.
    #[test]
    fn the_second_bound_of_the_lemma_is_the_smaller_one() {
        for [b0, b1, b2] in [[-1.0, 0.5, -0.3], [-0.2, 2.0, -3.0], [-3.0, -0.4, 1.0], [-0.05, 0.7, 0.2]] {
            let (mut first, mut second) = (f64::INFINITY, f64::INFINITY);
            for i in 0..400_000 {
                let s = 1e-4 * f64::from(i);
                let g2 = -3.0 * (b0 * s * s + 2.0 * b1 * s + b2);
                let g3 = -((b0 * s + 3.0 * b1) * s + 3.0 * b2) * s / (1.0 + s);
                first = first.min(g2.max(g3));
                if b0 * s + b1 <= 0.0 {
                    second = second.min(g3);
                }
            }
            assert!(second <= first + 1e-4 * (1.0 + first.abs()), "{second} {first}");
            let closed = lemma_bound(&[b0, b1, b2, 0.0]);
            assert!((closed - second).abs() < 1e-4 * (1.0 + second.abs()), "{closed} {second}");
        }
    }

    #[test]
    fn a_start_at_or_above_zero_is_the_root() {
        assert_eq!(minimal_root(&[0.0, 1.0, 1.0, 1.0]), Some(0.0));
        assert_eq!(minimal_root(&[-1.0, -1.0, -1.0, -1.0]), None);
        assert!((minimal_root(&[-1.0, -1.0, -1.0, 0.0]).unwrap() - 1.0).abs() < 1e-15);
    }
}
