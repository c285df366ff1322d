//! Values, derivatives, ranges and rounding bounds.

use super::super::conformance::{Sequence, check_field};
use super::super::{Constants, Field, Formula};
use super::*;
use crate::geom::{Aabb, Point3, Points, Vec3};
use num_bigint::BigInt;
use num_dual::{DualNum, hessian};
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

fn cube(half: f64) -> Aabb {
    Aabb::new(-Vec3::repeat(half), Vec3::repeat(half))
}

#[test]
fn surfaces_of_the_papers_conform() {
    for text in POLYNOMIALS {
        check_field(&formula(text), &cube(1.3));
    }
    check_field(&formula(CHAIR), &cube(6.0));
    check_field(&formula(GYROID), &cube(4.0));
    check_field(&formula(TORUS), &Aabb::new(Vec3::new(1.0, 0.5, -1.0), Vec3::new(5.0, 4.0, 1.0)));
}

#[test]
fn formulas_with_every_function_conform() {
    let positive = Aabb::new(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.6, 0.7, 0.9));
    for text in [
        "sqrt(x+y) + exp(x*z) - log(x+z)",
        "tan(x) + sin(3y) - cos(2z)",
        "asin(x) + acos(y) - atan(z/x)",
        "sinh(x) cosh(y) - tanh(z)",
        "x^2.5 + y^-1.5 + z^x",
        "x^-3 + (x+y)^7 - z^5/(x+y)",
        "abs(x - 2) + abs(x + y)^3",
        "min(x, y + 1, z + 2) * max(x - 1, y, z - 2)",
        "ln(pi*x) ** 2 + 2^x",
        "x",
        "3",
        "y/y - x/(2-2x)",
        "-x",
        "(x+y+z)^2 (x+y+z)^3",
    ] {
        check_field(&formula(text), &positive);
    }
}

#[test]
fn deep_and_wide_formulas_conform() {
    let nested = (0..200).fold("x".to_owned(), |inner, k| format!("sin({inner} + y*{k}/4000)"));
    let wide = (1..300).map(|k| format!("cos({k}x/300)*sin({k}y/300)*z")).collect::<Vec<_>>().join("+");
    let right = (1..150).rev().fold("z".to_owned(), |inner, k| format!("x/{k} + y*({inner})/150"));
    for text in [nested, wide, right] {
        check_field(&formula(&text), &cube(0.9));
    }
}

fn decocube<D: DualNum<Primitive = f64> + Copy>(x: D, y: D, z: D) -> D {
    let part = |x: D, y: D, z: D| (x.powi(2) + y.powi(2) - 0.64).powi(2) + (z.powi(2) - 1.0).powi(2);
    part(x, y, z) * part(y, z, x) * part(z, x, y) - 0.02
}

fn mixture<D: DualNum<Primitive = f64> + Copy>(x: D, y: D, z: D) -> D {
    (x * y).exp() * (z + 2.0).ln() + (x - z).sin().powi(3) / (y.cosh() + x.atan()) - (y + 3.0).sqrt().tanh()
        + (x * 0.3).asin() * (y * 0.2).acos()
        + (z + 2.0).powf(1.7) * x.tan()
        - y.sinh() * z.cos()
}

#[test]
fn derivatives_agree_with_dual_numbers() {
    let mut sequence = Sequence::new(7);
    let mixture_text = "exp(x y) log(z+2) + sin(x-z)^3/(cosh(y)+atan(x)) - tanh(sqrt(y+3)) + asin(0.3x) acos(0.2y) \
                        + (z+2)^1.7 tan(x) - sinh(y) cos(z)";
    for (text, is_mixture) in [(DECOCUBE, false), (mixture_text, true)] {
        let formula = formula(text);
        for _ in 0..50 {
            let p = sequence.point(&cube(1.2));
            let (value, gradient, second) = hessian(
                |v| if is_mixture { mixture(v[0], v[1], v[2]) } else { decocube(v[0], v[1], v[2]) },
                &nalgebra::SVector::<f64, 3>::new(p.x, p.y, p.z),
            );
            let jet = formula.jet(p);
            let scale = 1.0 + value.abs() + gradient.norm() + second.norm();
            assert!((jet.value - value).abs() <= 1e-13 * scale);
            assert!((jet.gradient - gradient).norm() <= 1e-13 * scale);
            assert!((jet.hessian - second).norm() <= 1e-13 * scale, "{} {second}", jet.hessian);
        }
    }
}

fn rational(x: f64) -> BigRational {
    BigRational::from_float(x).expect("finite")
}

#[test]
fn rounding_bounds_hold_against_exact_arithmetic_and_are_tight() {
    let mut sequence = Sequence::new(3);
    for text in POLYNOMIALS {
        let formula = formula(text);
        let polynomial = formula.polynomial().expect("a polynomial");
        for half in [1.0, 30.0, 1e6] {
            for _ in 0..60 {
                let p = sequence.point(&cube(half));
                let exact = polynomial.value(&[rational(p.x), rational(p.y), rational(p.z)]);
                let error = (rational(formula.value(p)) - &exact).abs().to_f64().expect("finite");
                let bound = formula.rounding_bound(p);
                assert!(error <= bound, "{text} at {p:?}: off by {error}, bound {bound}");
                // No more than a few hundred roundings of the largest quantities: of |f| with all signs positive.
                let size = (0..polynomial.terms().len()).zip(polynomial.float_terms()).fold(
                    0.0,
                    |sum, (_, (e, c))| {
                        sum + c.abs() * (0..3).map(|k| p[k].abs().powi(e[k] as i32)).product::<f64>()
                    },
                );
                assert!(bound <= 300.0 * f64::EPSILON * size, "{text}: {bound} against {size}");
                assert!(formula.range(&Aabb::new(p, p)).contains(exact.to_f64().expect("finite")));
            }
        }
    }
}

#[test]
fn rounding_bounds_cover_the_functions() {
    // f vanishes identically; what is computed is rounding alone.
    let mut sequence = Sequence::new(5);
    for text in [
        "sin(x)^2 + cos(x)^2 - 1",
        "exp(log(y+3)) - (y+3)",
        "sqrt((z+2)^2) - (z+2)",
        "tan(x) - sin(x)/cos(x)",
        "sinh(x)^2 + 1 - cosh(x)^2",
        "(y+3)^0.5 - sqrt(y+3)",
        "asin(x/2) + acos(x/2) - pi/2",
        "min(x/3, y) + max(x/3, y) - x/3 - y",
        "tanh(x) - sinh(x)/cosh(x)",
    ] {
        let formula = formula(text);
        for _ in 0..100 {
            let p = sequence.point(&cube(1.5));
            let (value, bound) = (formula.value(p), formula.rounding_bound(p));
            assert!(value.abs() <= bound, "{text} at {p:?}: {value} beyond {bound}");
            assert!(bound < 1e-13, "{text}: {bound}");
        }
    }
}

#[test]
fn rounding_bound_is_infinite_outside_the_domain() {
    let p = Point3::new(-1.0, 0.0, 0.0);
    for text in ["sqrt(x)", "1/y", "log(x)", "(1e300+z)^2", "x^0.5"] {
        assert_eq!(formula(text).rounding_bound(p), f64::INFINITY, "{text}");
    }
}

#[test]
fn squares_and_powers_have_tight_ranges() {
    let cell = cube(2.0);
    for (text, lo, hi) in [("x*x", 0.0, 4.0), ("x^4", 0.0, 16.0), ("x^3", -8.0, 8.0), ("x^2*x^2", 0.0, 16.0)]
    {
        let range = formula(text).range(&cell);
        assert!(
            range.lo <= lo && range.lo > lo - 1e-13 && range.hi >= hi && range.hi < hi + 1e-12,
            "{range:?}"
        );
    }
    let [_, _, odd] = formula("z^3").gradient_range(&cell).1;
    assert!(odd.lo >= -1e-300 && odd.hi < 12.0 + 1e-13, "{odd:?}");
}

#[test]
fn ranges_prove_absence() {
    let decocube = formula(DECOCUBE);
    let far = Aabb::new(Vec3::repeat(2.0), Vec3::repeat(2.1));
    assert!(decocube.range(&far).lo > 0.0);
    let outer = Aabb::new(Vec3::new(3.0, f64::NEG_INFINITY, f64::NEG_INFINITY), Vec3::repeat(f64::INFINITY));
    assert!(formula(SPHERE).range(&outer).lo > 7.9);
}

#[test]
fn common_subexpressions_are_computed_once() {
    let once = formula("(x+y)^2").operations();
    assert_eq!(formula("(x+y)*(x+y)").operations(), once);
    assert_eq!(formula("(x+y)^2 + 0*3").operations(), once);
    assert_eq!(formula("(y+x)^2*(2-1)").operations(), once);
    // The gradient is (2u, 2u, 0) with u = x + y.
    assert_eq!(once, (2, 3));
    let (values, gradients) = formula(DECOCUBE).operations();
    assert!(values <= 24 && gradients <= 50, "{values} {gradients}");
}

#[test]
fn constants_are_exact_decimals() {
    let mut constants = Constants::new();
    constants.set("a", 0.64).expect("a name");
    constants.assign("b_1 = 1e-3").expect("a name");
    let formula = Formula::parse("a*x + b_1", &constants).expect("a formula");
    let ratio = |n: i64, d: i64| BigRational::new(BigInt::from(n), BigInt::from(d));
    let polynomial = formula.polynomial().expect("linear");
    assert_eq!(polynomial.coefficient([1, 0, 0]), ratio(16, 25));
    assert_eq!(polynomial.coefficient([0, 0, 0]), ratio(1, 1000));
    assert_eq!(constants.get("a"), Some(0.64));
}

#[test]
fn levels_and_signs_make_new_formulas() {
    let p = Point3::new(0.3, -0.7, 0.2);
    let sphere = formula("x^2+y^2+z^2");
    let f = sphere.value(p);
    assert_eq!(sphere.minus(0.25).value(p), f - 0.25);
    assert_eq!(sphere.minus(-0.25).value(p), f + 0.25);
    assert_eq!(sphere.minus(0.1).negated().value(p), -(f - 0.1));
    assert_eq!(sphere.negated().negated().value(p), f);
    assert_eq!(sphere.minus(0.1).text(), "x^2+y^2+z^2");
    assert!(!sphere.minus(f64::NAN).value(p).is_finite());
    check_field(&sphere.minus(1.0).negated(), &cube(1.5));
}

#[test]
fn batches_of_a_formula_without_operations_are_filled() {
    let points: Points = (0..1000).map(|i| Vec3::new(f64::from(i), 2.0, 3.0)).collect();
    let mut f = vec![0.0; 1000];
    formula("x").values(points.view(), &mut f);
    assert_eq!(f, points.x);
    formula("2.5").values(points.view(), &mut f);
    assert_eq!(f, vec![2.5; 1000]);
}
