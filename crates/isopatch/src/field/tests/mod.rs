//! Tests of formulas, by subject.

mod diagnosis;
mod evaluation;
mod language;
mod polynomials;

use super::{Constants, Formula};

/// The surfaces of the papers and of the examples.
pub(super) const SPHERE: &str = "x^2+y^2+z^2-1";
pub(super) const TORUS: &str = "(sqrt(x^2+y^2)-5)^2+z^2-1";
pub(super) const SEXTIC: &str = "x^6+y^6+z^6+20(x^4y^2+y^4z^2+z^4x^2)-1";
pub(super) const EIGHT: &str = "x^8-2x^6+x^4+2x^4y^2-2x^2y^2+y^4+z^2-0.04";
pub(super) const PRODUCT: &str = "(x^2+1)(y^2+1)(z^2+1)+8xyz-2";
pub(super) const CHAIR: &str = "(x^2+y^2+z^2-0.95*25)^2-0.8((z-5)^2-2x^2)((z+5)^2-2y^2)";
pub(super) const DECOCUBE: &str = "((x^2+y^2-0.64)^2+(z^2-1)^2)((y^2+z^2-0.64)^2+(x^2-1)^2)\
                                   ((z^2+x^2-0.64)^2+(y^2-1)^2)-0.02";
pub(super) const GYROID: &str = "sin(x)cos(y)+sin(y)cos(z)+sin(z)cos(x)";

pub(super) const POLYNOMIALS: [&str; 6] = [SPHERE, SEXTIC, EIGHT, PRODUCT, CHAIR, DECOCUBE];

pub(super) fn formula(text: &str) -> Formula {
    Formula::parse(text, &Constants::new()).map_err(|error| error.to_string()).expect("a formula")
}
