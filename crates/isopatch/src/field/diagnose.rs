//! Where a formula is not differentiable or not defined, and which of its parts is to blame.

use super::expression::{Operator, Term, TermId, operands};
use super::formula::Formula;
use super::graph::{Floats, Node, partials};
use super::token::{Function, Span};
use crate::geom::{Point3, Vec3};
use std::fmt;

/// A place where a formula is not differentiable.
#[derive(Clone, Debug, PartialEq)]
pub struct Kink {
    /// The function to blame, by name.
    pub function: &'static str,
    /// Where it stands in the text.
    pub span: Span,
    /// First-order distance from the point to the place, a length.
    pub distance: f64,
}

impl fmt::Display for Kink {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.function {
            "min" | "max" => "both branches are equal",
            "power" => "its base is zero",
            _ => "its argument is zero",
        };
        write!(out, "{} at column {}: {reason}; {}", self.function, self.span.column, self.smooth())
    }
}

impl Kink {
    /// What has no kink, in the words of a formula.
    fn smooth(&self) -> &'static str {
        match self.function {
            "max" => "smooth is (a + b + sqrt((a - b)^2 + e^2))/2 in place of max(a, b), with a small e",
            "min" => "smooth is (a + b - sqrt((a - b)^2 + e^2))/2 in place of min(a, b), with a small e",
            "abs" => "smooth is sqrt(a^2 + e^2) in place of abs(a), with a small e",
            "sqrt" => "smooth is the equation squared, or sqrt(a + e^2) in place of sqrt(a), with a small e",
            _ => "smooth is (a^2 + e^2)^(p/2) in place of a^p, with a small e",
        }
    }
}

/// Why a formula has no finite value at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DomainErrorKind {
    /// The point itself has a coordinate that is not finite.
    #[error("the coordinate is not finite")]
    Coordinate,
    /// Square root of a negative number.
    #[error("square root of a negative number")]
    NegativeRoot,
    /// Logarithm of zero or a negative number.
    #[error("logarithm of a number that is not positive")]
    Logarithm,
    /// Division by zero, also by a negative power of zero.
    #[error("division by zero")]
    DivisionByZero,
    /// Arc sine or arc cosine of a number beyond −1 or 1.
    #[error("argument outside -1 to 1")]
    ArcArgument,
    /// Real power of a negative number.
    #[error("a power that is not whole, of a negative number")]
    NegativeBase,
    /// The result is too large for a float.
    #[error("the result is too large")]
    Overflow,
}

/// The first operation of a formula that has no finite value at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {}: {kind}", span.column)]
pub struct DomainError {
    /// What is wrong.
    pub kind: DomainErrorKind,
    /// The operator or function, in the text.
    pub span: Span,
}

/// A change of ∇f across a kink below this part of |∇f| is no kink: abs(x)^2 is smooth.
const SMALLEST_JUMP: f64 = 1e-6;

/// Values and derivatives of all nodes of a graph at a point.
struct Sweep {
    values: Vec<f64>,
    gradients: Vec<Vec3>,
    /// ∂f/∂node.
    adjoints: Vec<f64>,
}

impl Formula {
    /// The nearest place within `tolerance` (a length; first-order distance) of `p` where f is not differentiable:
    /// abs of zero, equal branches of min or max, root or power below 1 of zero. Parts that don't count for f
    /// there, such as the branch of a max that is not taken, are passed over.
    pub fn kink_near(&self, p: Point3, tolerance: f64) -> Option<Kink> {
        let kinks: Vec<TermId> = self.parts().filter(|id| self.can_kink(*id)).collect();
        if kinks.is_empty() {
            return None;
        }
        let sweep = self.sweep(p);
        kinks
            .into_iter()
            .filter_map(|id| self.kink(id, &sweep))
            .filter(|kink| kink.distance <= tolerance)
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Does the formula have a part, such as abs or max, that may not be differentiable somewhere?
    pub fn may_kink(&self) -> bool {
        self.parts().any(|id| self.can_kink(id))
    }

    /// Which operation, if any, first fails at `p`, so that f is NaN or infinite there.
    pub fn domain_error(&self, p: Point3) -> Option<DomainError> {
        let values = self.graph.values(self.output(), [p.x, p.y, p.z]);
        if values[self.output() as usize].is_finite() {
            return None;
        }
        let value = |id: TermId| values[self.nodes[id as usize] as usize];
        self.parts().find_map(|id| {
            let term = self.expression.term(id);
            let sound = operands(term).into_iter().flatten().all(|operand| value(operand).is_finite());
            (sound && !value(id).is_finite())
                .then(|| DomainError { kind: failure(term, value), span: self.expression.span(id) })
        })
    }

    fn parts(&self) -> impl Iterator<Item = TermId> {
        let parts = self.expression.parts(self.root);
        (0..parts.len()).filter(move |&id| parts[id]).map(|id| id as TermId)
    }

    fn can_kink(&self, id: TermId) -> bool {
        match self.expression.term(id) {
            Term::Call(Function::Sqrt | Function::Abs, _)
            | Term::Binary(Operator::Min | Operator::Max, ..) => true,
            Term::Binary(Operator::Pow, _, exponent) => {
                let exponent = self.graph.constant_value(self.nodes[exponent as usize]);
                exponent.is_some_and(|c| 0.0 < c.value && c.value < 1.0)
            }
            _ => false,
        }
    }

    /// The kink of a term, with its distance, unless it is too weak to show in f.
    fn kink(&self, id: TermId, sweep: &Sweep) -> Option<Kink> {
        let at = |id: TermId| self.nodes[id as usize] as usize;
        // The kink is where `u` is zero; the gradient of the term changes by `jump` times that of u across it.
        let (function, u, gradient, jump) = match self.expression.term(id) {
            Term::Binary(operator @ (Operator::Min | Operator::Max), a, b) => {
                let name = if operator == Operator::Min { "min" } else { "max" };
                let (a, b) = (at(a), at(b));
                (name, sweep.values[a] - sweep.values[b], sweep.gradients[a] - sweep.gradients[b], 1.0)
            }
            Term::Call(Function::Abs, a) => ("abs", sweep.values[at(a)], sweep.gradients[at(a)], 2.0),
            Term::Call(Function::Sqrt, a) => {
                ("sqrt", sweep.values[at(a)], sweep.gradients[at(a)], 1.0 / sweep.values[at(id)])
            }
            Term::Binary(Operator::Pow, a, b) => {
                let slope = sweep.values[at(b)] * sweep.values[at(id)] / sweep.values[at(a)];
                ("power", sweep.values[at(a)], sweep.gradients[at(a)], 2.0 * slope)
            }
            _ => return None,
        };
        let distance = if u == 0.0 { 0.0 } else { u.abs() / gradient.norm() };
        let adjoint = sweep.adjoints[at(id)];
        let visible = (adjoint * jump * gradient.norm()).abs();
        let whole = sweep.gradients[self.output() as usize].norm();
        // Nothing is known where the comparison meets NaN, at the kink of a root itself: then it counts.
        let is_weak = adjoint == 0.0 || visible <= SMALLEST_JUMP * whole || visible == 0.0;
        (!is_weak).then(|| Kink { function, span: self.expression.span(id), distance })
    }

    fn sweep(&self, p: Point3) -> Sweep {
        let output = self.output();
        let values = self.graph.values(output, [p.x, p.y, p.z]);
        let mut gradients: Vec<Vec3> = Vec::with_capacity(values.len());
        for id in 0..values.len() {
            gradients.push(match self.graph.node(id as u32) {
                Node::Constant(_) => Vec3::zeros(),
                Node::Input(axis) => Vec3::ith(usize::from(axis), 1.0),
                Node::Apply(op, a, b) => {
                    let (a, b) = (a as usize, b as usize);
                    let (by_a, by_b) = partials(&mut Floats, op, values[a], values[b], values[id]);
                    chain(by_a, gradients[a]) + chain(by_b, gradients[b])
                }
            });
        }
        let mut adjoints = vec![0.0; values.len()];
        adjoints[output as usize] = 1.0;
        for id in (0..values.len()).rev().filter(|&id| id <= output as usize) {
            if let (Node::Apply(op, a, b), true) = (self.graph.node(id as u32), adjoints[id] != 0.0) {
                let (a, b) = (a as usize, b as usize);
                let (by_a, by_b) = partials(&mut Floats, op, values[a], values[b], values[id]);
                adjoints[a] += by_a.map_or(0.0, |d| adjoints[id] * d);
                adjoints[b] += by_b.map_or(0.0, |d| adjoints[id] * d);
            }
        }
        Sweep { values, gradients, adjoints }
    }
}

/// A term of the chain rule; a constant operand contributes nothing, even where the outer derivative is infinite.
fn chain(outer: Option<f64>, inner: Vec3) -> Vec3 {
    match outer {
        Some(outer) if inner != Vec3::zeros() => outer * inner,
        _ => Vec3::zeros(),
    }
}

/// Why a term has no finite value though its operands have.
fn failure(term: Term, value: impl Fn(TermId) -> f64) -> DomainErrorKind {
    match term {
        Term::Variable(_) => DomainErrorKind::Coordinate,
        Term::Call(Function::Sqrt, _) => DomainErrorKind::NegativeRoot,
        Term::Call(Function::Log, _) => DomainErrorKind::Logarithm,
        Term::Call(Function::Asin | Function::Acos, _) => DomainErrorKind::ArcArgument,
        Term::Binary(Operator::Div, _, b) if value(b) == 0.0 => DomainErrorKind::DivisionByZero,
        Term::Power(a, n) if n < 0 && value(a) == 0.0 => DomainErrorKind::DivisionByZero,
        Term::Binary(Operator::Pow, a, _) if value(a) < 0.0 => DomainErrorKind::NegativeBase,
        Term::Binary(Operator::Pow, a, _) if value(a) == 0.0 => DomainErrorKind::DivisionByZero,
        _ => DomainErrorKind::Overflow,
    }
}
