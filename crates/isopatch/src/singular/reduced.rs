use super::SingularError;
use super::square_free::square_free;
use crate::field::{Constants, Formula};

/// The formula of the polynomial with every factor once, which has the same zeros; none if no factor is repeated.
pub fn without_repeated_factors(formula: &Formula) -> Result<Option<Formula>, SingularError> {
    let polynomial = formula.quadratic_polynomial().ok_or(SingularError::NotPolynomial)?;
    let reduced = square_free(&polynomial)?;
    if reduced.degree() == polynomial.degree() {
        return Ok(None);
    }
    let terms = reduced.rational.terms().map(|([i, j, k], c)| format!("({c})*x^{i}*y^{j}*z^{k}"));
    let text = terms.collect::<Vec<_>>().join("+");
    Formula::parse(&text, &Constants::new()).map(Some).map_err(|_| SingularError::Repeated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::geom::Point3;

    #[test]
    fn a_double_sphere_is_a_sphere() {
        let formula = |text| Formula::parse(text, &Constants::new()).unwrap();
        let reduced = without_repeated_factors(&formula("(x^2+y^2+z^2-1/4)^2")).unwrap().unwrap();
        assert!(reduced.value(Point3::zeros()) * reduced.value(Point3::x()) < 0.0);
        assert!(without_repeated_factors(&formula("x^2+y^2-z^2")).unwrap().is_none());
    }
}
