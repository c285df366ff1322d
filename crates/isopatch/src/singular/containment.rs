//! Does a curve lie in the singular set as a whole?

use super::recognize::is_singular_at;
use crate::field::QuadraticPolynomial;
use num_bigint::BigInt;
use num_rational::BigRational;

/// Is the line through two different points singular on f = 0, exactly?
///
/// An irreducible curve of degree m that is not part of a surface of degree n meets it in at most mn points (Bézout), so
/// mn + 1 points decide (Bajaj & Xu 1997, section 3). For a line, m = 1; the derivatives have smaller degrees.
pub(super) fn contains_line(f: &QuadraticPolynomial, a: &[BigRational; 3], b: &[BigRational; 3]) -> bool {
    let point = |k: u32| {
        let t = BigRational::from(BigInt::from(k));
        [0, 1, 2].map(|axis| &a[axis] + &t * (&b[axis] - &a[axis]))
    };
    a != b && (0..=f.degree()).all(|k| is_singular_at(f, &point(k)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Constants, Formula};

    #[test]
    fn lines_are_told_from_curves_that_touch_them() {
        let polynomial =
            |text| Formula::parse(text, &Constants::new()).unwrap().quadratic_polynomial().unwrap();
        let point = |p: [i32; 3]| p.map(|n| BigRational::from(BigInt::from(n)));
        let (origin, up) = (point([0, 0, 0]), point([0, 1, 0]));
        assert!(contains_line(&polynomial("x^2-y z^2"), &origin, &up));
        assert!(!contains_line(&polynomial("x^2-y z^2"), &origin, &point([0, 0, 1])));
        assert!(!contains_line(&polynomial("x^2-y z^2"), &origin, &origin));
        // Singular at y = 0, 1, 2 on the line, and nowhere else on it.
        assert!(!contains_line(&polynomial("x^2+z^2+y^2(y-1)^2(y-2)^2"), &origin, &up));
    }
}
