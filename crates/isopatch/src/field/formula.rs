//! A scalar function given by a formula.

use super::Field;
use super::constants::Constants;
use super::error::{FormulaError, FormulaErrorKind, Problem};
use super::exact::{Exact, parse_decimal};
use super::expression::{Expression, Operator, TermId};
use super::graph::{Graph, NodeId};
use super::lower::lower;
use super::number::Bounded;
use super::parse::parse;
use super::polynomial::Polynomial;
use super::quadratic::QuadraticPolynomial;
use super::tape::{Tape, cell_inputs};
use super::token::{Span, tokenize};
use crate::geom::{Aabb, Affine, Interval, Jet, Jets, Mat3, Point3, Points, PointsMut, PointsView, Vec3};
use std::fmt;
use std::sync::OnceLock;

/// A scalar function of x, y, z, parsed from a text such as `x^2 + y^2 = 4xyz + 1`.
///
/// The language: decimal numbers; `x`, `y`, `z`; `pi`; `+ - * /`; `^` or `**`, which group to the right and bind
/// more tightly than a sign, so that `-x^2` is −(x²); parentheses; products without a sign, as in `4xyz`,
/// `2(x+1)(y-1)` or `2sin(x)`, which bind like those with one; `sqrt abs exp log` (`ln` too) `sin cos tan asin
/// acos atan sinh cosh tanh` of one argument, `min` and `max` of two or more; named constants; at most one `=`,
/// where `a = b` is a − b. Also `· × −` and raised digits. A run of letters is split into the longest names that
/// are known: `4xyz` is 4·x·y·z.
///
/// A real power is defined for bases that are not negative; a whole power (also `x^(6/3)`) for all.
///
/// Evaluation runs a tape of floating-point operations in which common subexpressions are computed once;
/// derivatives are tapes of their own, made from the first by the chain rule when they are first wanted.
#[derive(Clone, Debug)]
pub struct Formula {
    text: String,
    pub(super) expression: Expression,
    pub(super) root: TermId,
    pub(super) graph: Graph,
    /// For every term of the expression, its node of the graph.
    pub(super) nodes: Vec<NodeId>,
    value: Tape,
    gradient: OnceLock<Tape>,
    jet: OnceLock<Tape>,
    polynomial: OnceLock<Option<Polynomial>>,
}

impl Formula {
    /// Most characters of a formula.
    pub const MAX_LENGTH: usize = 65_536;
    /// Most parentheses, including those of functions, that may be open at a place of a formula.
    pub const MAX_NESTING: usize = 1_000;

    /// The function that a text describes. Errors name the first culprit and its column.
    pub fn parse(text: &str, constants: &Constants) -> Result<Self, FormulaError> {
        let length = text.chars().count();
        if length > Self::MAX_LENGTH {
            let span = Span { column: Self::MAX_LENGTH + 1, length: 1 };
            let kind = FormulaErrorKind::TooLong { length, limit: Self::MAX_LENGTH };
            return Err(Problem::new(kind, span).in_text(text));
        }
        let parsed = tokenize(text, constants).and_then(|tokens| {
            if tokens.is_empty() {
                return Err(Problem::new(FormulaErrorKind::Empty, Span { column: 1, length: 1 }));
            }
            parse(&tokens, text, Self::MAX_NESTING)
        });
        let (expression, root) = parsed.map_err(|problem| problem.in_text(text))?;
        Ok(Self::new(text.to_owned(), expression, root))
    }

    fn new(text: String, expression: Expression, root: TermId) -> Self {
        let (graph, nodes) = lower(&expression, root);
        let value = Tape::new(&graph, &[nodes[root as usize]]);
        Self {
            text,
            expression,
            root,
            graph,
            nodes,
            value,
            gradient: OnceLock::new(),
            jet: OnceLock::new(),
            polynomial: OnceLock::new(),
        }
    }

    /// The text that was parsed; columns of messages refer to it. It does not show a later
    /// [`minus`](Self::minus) or [`negated`](Self::negated); the `Display` form does.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// f − c; c is taken as the shortest decimal that reads as this float. A level that is not finite gives a
    /// function that is finite nowhere.
    pub fn minus(&self, level: f64) -> Self {
        let mut expression = self.expression.clone();
        let span = expression.span(self.root);
        let size = parse_decimal(&format!("{:e}", level.abs())).unwrap_or(Exact::Rounded(level.abs()));
        let level = if level < 0.0 { size.negated() } else { size };
        let level = expression.constant(level, span);
        let root = expression.binary(Operator::Sub, self.root, level, span);
        Self::new(self.text.clone(), expression, root)
    }

    /// −f.
    pub fn negated(&self) -> Self {
        let mut expression = self.expression.clone();
        let span = expression.span(self.root);
        let root = expression.negate(self.root, span);
        Self::new(self.text.clone(), expression, root)
    }

    /// The function as a polynomial with exact coefficients; none if it is none, or beyond the limits of
    /// [`Polynomial`]. Found at the first call.
    pub fn polynomial(&self) -> Option<&Polynomial> {
        self.polynomial.get_or_init(|| Polynomial::of(&self.expression, self.root)).as_ref()
    }

    /// The function as a polynomial whose coefficients may hold one square root, as in `(1+sqrt(5))/2`; none if it is
    /// none, or beyond the limits of [`Polynomial`].
    pub fn quadratic_polynomial(&self) -> Option<QuadraticPolynomial> {
        match self.polynomial() {
            Some(rational) => Some(QuadraticPolynomial::plain(rational.clone())),
            None => QuadraticPolynomial::of(&self.expression, self.root),
        }
    }

    /// The value of a formula that is a polynomial without x, y and z.
    pub fn constant(&self) -> Option<f64> {
        let polynomial = self.polynomial()?;
        // Adding zero turns −0 into 0.
        (polynomial.degree() == 0).then(|| self.value(Point3::zeros()) + 0.0)
    }

    /// Operations of the tapes for f and for f with ∇f.
    #[cfg(test)]
    pub(super) fn operations(&self) -> (usize, usize) {
        (self.value.len(), self.gradient_tape().len())
    }

    pub(super) fn output(&self) -> NodeId {
        self.nodes[self.root as usize]
    }

    /// f and ∇f.
    fn gradient_tape(&self) -> &Tape {
        self.gradient.get_or_init(|| {
            let f = self.output();
            let mut graph = self.graph.clone();
            let [x, y, z] = graph.gradient(f);
            Tape::new(&graph, &[f, x, y, z])
        })
    }

    /// f, ∇f and the upper triangle of ∇²f, by rows.
    fn jet_tape(&self) -> &Tape {
        self.jet.get_or_init(|| {
            let f = self.output();
            let mut graph = self.graph.clone();
            let [x, y, z] = graph.gradient(f);
            let [xx, xy, xz] = graph.derivatives([x, y, z], 0);
            let [yy, yz] = graph.derivatives([y, z], 1);
            let [zz] = graph.derivatives([z], 2);
            Tape::new(&graph, &[f, x, y, z, xx, xy, xz, yy, yz, zz])
        })
    }
}

impl fmt::Display for Formula {
    /// The function with all parentheses, in the language that [`Formula::parse`] reads.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expression.write(self.root, out)
    }
}

impl Field for Formula {
    fn value(&self, p: Point3) -> f64 {
        let [f] = self.value.evaluate([p.x, p.y, p.z]);
        f
    }

    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        let [f, x, y, z] = self.gradient_tape().evaluate([p.x, p.y, p.z]);
        (f, Vec3::new(x, y, z))
    }

    fn jet(&self, p: Point3) -> Jet {
        let [f, x, y, z, xx, xy, xz, yy, yz, zz] = self.jet_tape().evaluate([p.x, p.y, p.z]);
        Jet { value: f, gradient: Vec3::new(x, y, z), hessian: Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) }
    }

    fn range(&self, cell: &Aabb) -> Interval {
        let [f] = self.value.evaluate(cell_inputs(cell));
        f
    }

    fn gradient_range(&self, cell: &Aabb) -> (Interval, [Interval; 3]) {
        let [f, x, y, z] = self.gradient_tape().evaluate(cell_inputs(cell));
        (f, [x, y, z])
    }

    fn linear_range(&self, cell: &Aabb) -> Affine {
        let [f] = self.value.evaluate([0, 1, 2].map(|axis| Affine::coordinate(cell, axis)));
        f
    }

    fn linear_gradient_range(&self, cell: &Aabb) -> (Affine, [Affine; 3]) {
        let [f, x, y, z] =
            self.gradient_tape().evaluate([0, 1, 2].map(|axis| Affine::coordinate(cell, axis)));
        (f, [x, y, z])
    }

    fn rounding_bound(&self, p: Point3) -> f64 {
        /// Covers the rounding of the bound itself: one part in 2⁵² a step, over far fewer than 2³² steps.
        const SAFETY: f64 = 1.0 + 1e-6;
        let [f]: [Bounded; 1] = self.value.evaluate([p.x, p.y, p.z].map(Bounded::exact));
        if f.value.is_finite() && f.error.is_finite() { SAFETY * f.error } else { f64::INFINITY }
    }

    fn values(&self, points: PointsView<'_>, f: &mut [f64]) {
        self.value.evaluate_batch([points.x, points.y, points.z], [f]);
    }

    fn gradients(&self, points: PointsView<'_>, f: &mut [f64], gradient: PointsMut<'_>) {
        let inputs = [points.x, points.y, points.z];
        self.gradient_tape().evaluate_batch(inputs, [f, gradient.x, gradient.y, gradient.z]);
    }

    fn jets(&self, points: PointsView<'_>, jets: &mut Jets) {
        let Jets { value, gradient: Points { x, y, z }, hessian: [xx, xy, xz, yy, yz, zz] } = jets;
        let inputs = [points.x, points.y, points.z];
        self.jet_tape().evaluate_batch(inputs, [value, x, y, z, xx, xy, xz, yy, yz, zz]);
    }

    fn ranges(&self, cells: &[Aabb], ranges: &mut [Interval]) {
        let coordinates =
            [0, 1, 2].map(|axis| cells.iter().map(|c| cell_inputs(c)[axis]).collect::<Vec<_>>());
        self.value.evaluate_batch(coordinates.each_ref().map(Vec::as_slice), [ranges]);
    }
}
