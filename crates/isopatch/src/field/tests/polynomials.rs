//! Exact expansion.

use super::super::conformance::Sequence;
use super::super::{Exponents, Field};
use super::*;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;

fn ratio(n: i64, d: i64) -> BigRational {
    BigRational::new(BigInt::from(n), BigInt::from(d))
}

fn terms(text: &str) -> Vec<(Exponents, BigRational)> {
    let formula = formula(text);
    let polynomial = formula.polynomial().expect("a polynomial");
    polynomial.terms().map(|(e, c)| (e, c.clone())).collect()
}

#[test]
fn expansion_is_exact() {
    assert_eq!(terms("(x+y)^2 - x^2 - y^2"), [([1, 1, 0], ratio(2, 1))]);
    assert_eq!(terms("0.64x/3"), [([1, 0, 0], ratio(16, 75))]);
    assert_eq!(terms("0.1 + 0.2 - 0.3"), []);
    assert_eq!(terms("x - 0.95*25"), [([0, 0, 0], ratio(-95, 4)), ([1, 0, 0], ratio(1, 1))]);
    assert_eq!(terms("(x-x)^1000000000"), []);
    assert_eq!(terms("((x+1)-x)^30000 z"), [([0, 0, 1], ratio(1, 1))]);
    assert_eq!(terms("x*x*x^3*x"), [([6, 0, 0], ratio(1, 1))]);
    assert!(formula("x-x").polynomial().expect("zero").is_zero());
}

#[test]
fn degrees_and_sizes_of_the_surfaces() {
    for (text, degree, count) in
        [(SPHERE, 2, 4), (SEXTIC, 6, 7), (EIGHT, 8, 8), (PRODUCT, 6, 9), (CHAIR, 4, 0), (DECOCUBE, 12, 0)]
    {
        let formula = formula(text);
        let polynomial = formula.polynomial().expect("a polynomial");
        assert_eq!(polynomial.degree(), degree, "{text}");
        assert!(count == 0 || polynomial.terms().len() == count, "{text}: {}", polynomial.terms().len());
    }
}

#[test]
fn derivatives_are_the_exact_gradient() {
    let mut sequence = Sequence::new(11);
    let cell = crate::geom::Aabb::new(-crate::geom::Vec3::repeat(1.2), crate::geom::Vec3::repeat(1.2));
    for text in POLYNOMIALS {
        let formula = formula(text);
        let polynomial = formula.polynomial().expect("a polynomial");
        for _ in 0..20 {
            let p = sequence.point(&cell);
            let exact = [p.x, p.y, p.z].map(|v| BigRational::from_float(v).expect("finite"));
            let (_, gradient) = formula.gradient(p);
            for axis in 0..3 {
                let slope = polynomial.derivative(axis).value(&exact).to_f64().expect("finite");
                assert!((slope - gradient[axis]).abs() <= 1e-11 * (1.0 + slope.abs()), "{text} {slope}");
            }
        }
    }
}

#[test]
fn what_is_no_polynomial_or_too_large_is_left_alone() {
    for text in ["sin(x)", "1/x", "x^0.5", "pi*x", "abs(x)", "x/(y-y)", "x^-1", "max(x, y)"] {
        assert!(formula(text).polynomial().is_none(), "{text}");
    }
    for text in ["(x+y+z+1)^101", "x^1000000", "(1/3+x/7)^100*(y+z/11+1)^90", "((x+y+z+1)^33)^3", "2^30000x"]
    {
        assert!(formula(text).polynomial().is_none(), "{text}");
    }
    assert!(formula("(x+y+z)^20").polynomial().is_some());
}
