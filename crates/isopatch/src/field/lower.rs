//! From an expression to a graph of operations on floats.

use super::expression::{Expression, Operator, Term, TermId};
use super::graph::{Algebra, Graph, NodeId};
use super::number::{Constant, Op};
use super::token::Function;

/// The graph of a term, and for every term up to `root` the node that computes it (0 for terms that are no part
/// of `root`).
pub(super) fn lower(expression: &Expression, root: TermId) -> (Graph, Vec<NodeId>) {
    let mut graph = Graph::default();
    let parts = expression.parts(root);
    let mut nodes: Vec<NodeId> = vec![0; parts.len()];
    for id in (0..parts.len()).filter(|&id| parts[id]) {
        let node = |operand: TermId| nodes[operand as usize];
        nodes[id] = match expression.term(id as TermId) {
            Term::Constant(_) => {
                let constant = expression.constant_of(id as TermId).map(|c| c.constant());
                graph.constant(constant.unwrap_or(Constant::exact(f64::NAN)))
            }
            Term::Pi => graph.constant(Constant::rounded(std::f64::consts::PI)),
            Term::Variable(axis) => graph.input(axis),
            Term::Negate(a) => graph.unary(Op::Neg, node(a)),
            Term::Call(function, a) => graph.unary(operation(function), node(a)),
            Term::Power(a, n) => power(&mut graph, node(a), n),
            Term::Binary(operator, a, b) => {
                let op = match operator {
                    Operator::Add => Op::Add,
                    Operator::Sub => Op::Sub,
                    Operator::Mul => Op::Mul,
                    Operator::Div => Op::Div,
                    Operator::Pow => Op::Pow,
                    Operator::Min => Op::Min,
                    Operator::Max => Op::Max,
                };
                graph.apply(op, node(a), node(b))
            }
        };
    }
    (graph, nodes)
}

fn operation(function: Function) -> Op {
    match function {
        Function::Sqrt => Op::Sqrt,
        Function::Abs => Op::Abs,
        Function::Exp => Op::Exp,
        Function::Log => Op::Log,
        Function::Sin => Op::Sin,
        Function::Cos => Op::Cos,
        Function::Tan => Op::Tan,
        Function::Asin => Op::Asin,
        Function::Acos => Op::Acos,
        Function::Atan => Op::Atan,
        Function::Sinh => Op::Sinh,
        Function::Cosh => Op::Cosh,
        Function::Tanh => Op::Tanh,
        Function::Min => Op::Min,
        Function::Max => Op::Max,
    }
}

/// A whole power: squares for even exponents, which keeps intervals tight, and one more product for odd ones.
fn power(graph: &mut Graph, base: NodeId, exponent: i32) -> NodeId {
    let size = exponent.unsigned_abs();
    let digits = u32::BITS - size.leading_zeros();
    let mut result = base;
    for digit in (0..digits.saturating_sub(1)).rev() {
        result = graph.unary(Op::Square, result);
        let so_far = size >> digit;
        if so_far & 1 == 1 {
            result = graph.apply(Op::Power(so_far), result, base);
        }
    }
    if exponent > 0 {
        return result;
    }
    let one = graph.number(1.0);
    graph.apply(Op::Div, one, result)
}
