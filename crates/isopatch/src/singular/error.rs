//! Why the singular set can't be had.

/// Why the singular set of a surface can't be found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SingularError {
    /// The formula is no polynomial with rational coefficients and at most one square root.
    #[error(
        "singularities are found for polynomials only: whole powers, sums and products of x, y, z and numbers, with square roots of one kind"
    )]
    NotPolynomial,
    /// f is a number.
    #[error("the formula is constant: there is no surface")]
    Constant,
    /// The degree is too high for the time that it would take.
    #[error("the polynomial has degree {degree}; the limit is {limit}")]
    Degree {
        /// The total degree.
        degree: u32,
        /// The limit.
        limit: u32,
    },
    /// The box is empty, flat or not finite.
    #[error("the box must have a finite extent above zero in every direction")]
    Box,
    /// f has a repeated factor, and it can't be divided out.
    #[error("the polynomial has a factor that occurs more than once; give it without")]
    Repeated,
    /// The subdivision does not come to an end.
    #[error("more than {0} boxes are left: the singular set is too large or too degenerate for the box")]
    TooManyCells(usize),
    /// The search would take minutes.
    #[error(
        "the search for singularities was given up as too long: sheets touch to a high order, or the degree is high; try a smaller box"
    )]
    TooMuchWork,
}
