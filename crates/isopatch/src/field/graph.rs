//! A formula as operations on floats, each of them once, and the derivatives of such a graph.

use super::number::{Constant, Number, Op};
use crate::geom::Interval;
use std::collections::HashMap;

/// Number of a node in its graph; operands have smaller numbers than their results.
pub(super) type NodeId = u32;

/// A node of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// Number of a constant.
    Constant(u32),
    /// A coordinate: 0, 1, 2 for x, y, z.
    Input(u8),
    /// An operation; unary ones have twice the same operand.
    Apply(Op, NodeId, NodeId),
}

/// Operations in single-assignment form: common subexpressions are one node, constants are folded.
#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    constants: Vec<Constant>,
    numbers: HashMap<Node, NodeId>,
    constant_numbers: HashMap<[u64; 3], NodeId>,
}

/// Something that formulas can be written in: nodes of a graph, or plain numbers.
///
/// The rules of differentiation are written once, in [`partials`], and serve both.
pub(super) trait Algebra {
    type Value: Copy;

    fn number(&mut self, value: f64) -> Self::Value;

    fn apply(&mut self, op: Op, a: Self::Value, b: Self::Value) -> Self::Value;

    fn unary(&mut self, op: Op, a: Self::Value) -> Self::Value {
        self.apply(op, a, a)
    }
}

/// Arithmetic with plain numbers.
pub(super) struct Floats;

impl Algebra for Floats {
    type Value = f64;

    fn number(&mut self, value: f64) -> f64 {
        value
    }

    fn apply(&mut self, op: Op, a: f64, b: f64) -> f64 {
        f64::apply(op, a, b)
    }
}

/// The partial derivatives of y = op(a, b) by a and by b; none where it is zero wherever it exists.
pub(super) fn partials<A: Algebra>(
    algebra: &mut A,
    op: Op,
    a: A::Value,
    b: A::Value,
    y: A::Value,
) -> (Option<A::Value>, Option<A::Value>) {
    let one = algebra.number(1.0);
    let unary = match op {
        Op::Neg => algebra.number(-1.0),
        Op::Square => {
            let two = algebra.number(2.0);
            algebra.apply(Op::Mul, two, a)
        }
        Op::Sqrt => {
            let half = algebra.number(0.5);
            algebra.apply(Op::Div, half, y)
        }
        Op::Abs => algebra.unary(Op::Sign, a),
        Op::Exp => y,
        Op::Log => algebra.apply(Op::Div, one, a),
        Op::Sin => algebra.unary(Op::Cos, a),
        Op::Cos => {
            let sin = algebra.unary(Op::Sin, a);
            algebra.unary(Op::Neg, sin)
        }
        Op::Tan => {
            let square = algebra.unary(Op::Square, y);
            algebra.apply(Op::Add, one, square)
        }
        Op::Asin | Op::Acos => {
            let square = algebra.unary(Op::Square, a);
            let rest = algebra.apply(Op::Sub, one, square);
            let root = algebra.unary(Op::Sqrt, rest);
            let numerator = algebra.number(if op == Op::Asin { 1.0 } else { -1.0 });
            algebra.apply(Op::Div, numerator, root)
        }
        Op::Atan => {
            let square = algebra.unary(Op::Square, a);
            let sum = algebra.apply(Op::Add, one, square);
            algebra.apply(Op::Div, one, sum)
        }
        Op::Sinh => algebra.unary(Op::Cosh, a),
        Op::Cosh => algebra.unary(Op::Sinh, a),
        Op::Tanh => {
            let square = algebra.unary(Op::Square, y);
            algebra.apply(Op::Sub, one, square)
        }
        _ => return binary_partials(algebra, op, a, b, y),
    };
    (Some(unary), None)
}

fn binary_partials<A: Algebra>(
    algebra: &mut A,
    op: Op,
    a: A::Value,
    b: A::Value,
    y: A::Value,
) -> (Option<A::Value>, Option<A::Value>) {
    let one = algebra.number(1.0);
    match op {
        Op::Add => (Some(one), Some(one)),
        Op::Sub => (Some(one), Some(algebra.number(-1.0))),
        Op::Mul => (Some(b), Some(a)),
        Op::Div => {
            let ratio = algebra.apply(Op::Div, y, b);
            (Some(algebra.apply(Op::Div, one, b)), Some(algebra.unary(Op::Neg, ratio)))
        }
        // bⁿ is a function of b alone; the operand a = bⁿ⁻¹ is only there to save work.
        Op::Power(n) => {
            let n = algebra.number(f64::from(n));
            (None, Some(algebra.apply(Op::Mul, n, a)))
        }
        Op::Pow => {
            let less = algebra.apply(Op::Sub, b, one);
            let power = algebra.apply(Op::Pow, a, less);
            let log = algebra.unary(Op::Log, a);
            (Some(algebra.apply(Op::Mul, b, power)), Some(algebra.apply(Op::Mul, y, log)))
        }
        Op::Min | Op::Max => {
            let first =
                if op == Op::Min { algebra.apply(Op::Less, a, b) } else { algebra.apply(Op::Less, b, a) };
            (Some(first), Some(algebra.apply(Op::Sub, one, first)))
        }
        _ => (None, None),
    }
}

impl Algebra for Graph {
    type Value = NodeId;

    fn number(&mut self, value: f64) -> NodeId {
        self.constant(Constant::exact(value))
    }

    fn apply(&mut self, op: Op, a: NodeId, b: NodeId) -> NodeId {
        let (a, b) = if op.is_unary() { (a, a) } else { (a, b) };
        let (a, b) = if op.commutes() && b < a { (b, a) } else { (a, b) };
        if let Some(folded) = self.fold(op, a, b) {
            return folded;
        }
        if let Some(simpler) = self.neutral(op, a, b) {
            return simpler;
        }
        self.intern(Node::Apply(op, a, b))
    }
}

impl Graph {
    pub(super) fn node(&self, id: NodeId) -> Node {
        self.nodes[id as usize]
    }

    pub(super) fn constant_value(&self, id: NodeId) -> Option<&Constant> {
        match self.node(id) {
            Node::Constant(k) => Some(&self.constants[k as usize]),
            _ => None,
        }
    }

    fn is_number(&self, id: NodeId, value: f64) -> bool {
        self.constant_value(id).is_some_and(|c| c.enclosure == Interval::point(value))
    }

    fn intern(&mut self, node: Node) -> NodeId {
        let next = self.nodes.len() as NodeId;
        let id = *self.numbers.entry(node).or_insert(next);
        if id == next {
            self.nodes.push(node);
        }
        id
    }

    pub(super) fn input(&mut self, axis: u8) -> NodeId {
        self.intern(Node::Input(axis))
    }

    pub(super) fn constant(&mut self, constant: Constant) -> NodeId {
        let key = [constant.value, constant.enclosure.lo, constant.enclosure.hi].map(f64::to_bits);
        if let Some(&id) = self.constant_numbers.get(&key) {
            return id;
        }
        let id = self.intern(Node::Constant(self.constants.len() as u32));
        self.constants.push(constant);
        self.constant_numbers.insert(key, id);
        id
    }

    /// The constant op(a, b) if both are constants and it is finite.
    fn fold(&mut self, op: Op, a: NodeId, b: NodeId) -> Option<NodeId> {
        let (a, b) = (*self.constant_value(a)?, *self.constant_value(b)?);
        let value = f64::apply(op, a.value, b.value);
        let mut enclosure = Interval::apply(op, a.enclosure, b.enclosure);
        // Halves, doubles, whole numbers: an exact result stays exact.
        if is_exact(op, a.value, b.value, value) && a.enclosure.width() == 0.0 && b.enclosure.width() == 0.0 {
            enclosure = Interval::point(value);
        }
        (value.is_finite() && enclosure.width().is_finite())
            .then(|| self.constant(Constant { value, enclosure }))
    }

    /// 0 + a, a − 0, 1·a, a/1, −(−a).
    fn neutral(&self, op: Op, a: NodeId, b: NodeId) -> Option<NodeId> {
        match op {
            Op::Add if self.is_number(a, 0.0) => Some(b),
            Op::Add | Op::Sub if self.is_number(b, 0.0) => Some(a),
            Op::Mul if self.is_number(a, 1.0) => Some(b),
            Op::Mul | Op::Div if self.is_number(b, 1.0) => Some(a),
            Op::Neg => match self.node(a) {
                Node::Apply(Op::Neg, inner, _) => Some(inner),
                _ => None,
            },
            _ => None,
        }
    }

    /// a·b for derivatives, where 0·b = 0 and constant factors may be gathered in front.
    fn times(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if self.is_number(a, 0.0) || self.is_number(b, 0.0) {
            return self.number(0.0);
        }
        if self.constant_value(a).is_some() && self.constant_value(b).is_some() {
            return self.apply(Op::Mul, a, b);
        }
        let ((p, a), (q, b)) = (self.factors(a), self.factors(b));
        let factor = self.apply(Op::Mul, p, q);
        let rest = match (self.node(a), self.node(b)) {
            // a · 1/c
            (_, Node::Apply(Op::Div, one, c)) if self.is_number(one, 1.0) => self.apply(Op::Div, a, c),
            (Node::Apply(Op::Div, one, c), _) if self.is_number(one, 1.0) => self.apply(Op::Div, b, c),
            _ if a == b => self.unary(Op::Square, a),
            _ => self.apply(Op::Mul, a, b),
        };
        self.scaled(factor, rest)
    }

    /// a + b for derivatives: common constant factors in front, a + (−b) as a − b.
    fn plus(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if self.constant_value(a).is_some() || self.constant_value(b).is_some() {
            return self.apply(Op::Add, a, b);
        }
        let ((p, s), (q, t)) = (self.factors(a), self.factors(b));
        if p == q {
            let sum = self.apply(Op::Add, s, t);
            return self.scaled(p, sum);
        }
        let opposite = self.unary(Op::Neg, q);
        if p == opposite {
            let difference = self.apply(Op::Sub, s, t);
            return self.scaled(p, difference);
        }
        match (self.is_number(p, -1.0), self.is_number(q, -1.0)) {
            (_, true) => self.apply(Op::Sub, a, t),
            (true, _) => self.apply(Op::Sub, b, s),
            _ => self.apply(Op::Add, a, b),
        }
    }

    /// `factor` · `rest`, as −rest or rest where that does.
    fn scaled(&mut self, factor: NodeId, rest: NodeId) -> NodeId {
        if self.is_number(factor, -1.0) {
            self.unary(Op::Neg, rest)
        } else {
            self.apply(Op::Mul, factor, rest)
        }
    }

    /// The node as constant · rest.
    fn factors(&mut self, id: NodeId) -> (NodeId, NodeId) {
        let one = self.number(1.0);
        match self.node(id) {
            Node::Constant(_) => (id, one),
            Node::Apply(Op::Neg, rest, _) => (self.number(-1.0), rest),
            Node::Apply(Op::Mul, a, b) if self.constant_value(a).is_some() => (a, b),
            Node::Apply(Op::Mul, a, b) if self.constant_value(b).is_some() => (b, a),
            _ => (one, id),
        }
    }

    /// For every node up to `last`: does it depend on a coordinate?
    fn dependent(&self, last: NodeId) -> Vec<bool> {
        let mut dependent: Vec<bool> = Vec::with_capacity(last as usize + 1);
        for node in &self.nodes[..=last as usize] {
            dependent.push(match *node {
                Node::Constant(_) => false,
                Node::Input(_) => true,
                Node::Apply(_, a, b) => dependent[a as usize] || dependent[b as usize],
            });
        }
        dependent
    }

    /// The partial derivatives of node `f` by x, y and z: one sweep from f back to the coordinates.
    pub(super) fn gradient(&mut self, f: NodeId) -> [NodeId; 3] {
        let dependent = self.dependent(f);
        let mut adjoints: Vec<Option<NodeId>> = vec![None; f as usize + 1];
        let mut gradient = [self.number(0.0); 3];
        adjoints[f as usize] = Some(self.number(1.0));
        for id in (0..=f).rev() {
            let Some(adjoint) = adjoints[id as usize] else { continue };
            match self.node(id) {
                Node::Constant(_) => {}
                Node::Input(axis) => gradient[usize::from(axis)] = adjoint,
                Node::Apply(op, a, b) => {
                    let (by_a, by_b) = partials(self, op, a, b, id);
                    for (operand, partial) in [(a, by_a), (b, by_b)] {
                        let Some(partial) = partial.filter(|_| dependent[operand as usize]) else { continue };
                        let term = self.times(adjoint, partial);
                        let sum = match adjoints[operand as usize] {
                            Some(before) => self.plus(before, term),
                            None => term,
                        };
                        adjoints[operand as usize] = Some(sum);
                    }
                }
            }
        }
        gradient
    }

    /// The derivatives of several nodes by one coordinate: one sweep from the coordinates forward.
    pub(super) fn derivatives<const N: usize>(&mut self, nodes: [NodeId; N], axis: u8) -> [NodeId; N] {
        let last = nodes.iter().copied().max().unwrap_or(0);
        let needed = self.reachable(&nodes);
        let mut tangents: Vec<Option<NodeId>> = vec![None; last as usize + 1];
        for id in 0..=last {
            if !needed[id as usize] {
                continue;
            }
            tangents[id as usize] = match self.node(id) {
                Node::Input(input) if input == axis => Some(self.number(1.0)),
                Node::Constant(_) | Node::Input(_) => None,
                Node::Apply(op, a, b) => self.tangent(op, [a, b], id, &tangents),
            };
        }
        let zero = self.number(0.0);
        nodes.map(|id| tangents[id as usize].unwrap_or(zero))
    }

    fn tangent(
        &mut self,
        op: Op,
        operands: [NodeId; 2],
        y: NodeId,
        tangents: &[Option<NodeId>],
    ) -> Option<NodeId> {
        let [ta, tb] = operands.map(|o| tangents[o as usize]);
        if ta.is_none() && tb.is_none() {
            return None;
        }
        let (by_a, by_b) = partials(self, op, operands[0], operands[1], y);
        let terms = [(ta, by_a), (tb, by_b)].map(|(t, p)| Some(self.times(t?, p?)));
        match terms {
            [Some(s), Some(t)] => Some(self.plus(s, t)),
            [term, None] | [None, term] => term,
        }
    }

    /// For every node up to the last output: is it needed for an output?
    pub(super) fn reachable(&self, outputs: &[NodeId]) -> Vec<bool> {
        let last = outputs.iter().copied().max().unwrap_or(0) as usize;
        let mut needed = vec![false; last + 1];
        outputs.iter().for_each(|&id| needed[id as usize] = true);
        for id in (0..=last).rev() {
            if let (true, Node::Apply(_, a, b)) = (needed[id], self.nodes[id]) {
                needed[a as usize] = true;
                needed[b as usize] = true;
            }
        }
        needed
    }

    /// The value of every node up to `last` at a point.
    pub(super) fn values(&self, last: NodeId, point: [f64; 3]) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(last as usize + 1);
        for node in &self.nodes[..=last as usize] {
            values.push(match *node {
                Node::Constant(k) => self.constants[k as usize].value,
                Node::Input(axis) => point[usize::from(axis)],
                Node::Apply(op, a, b) => f64::apply(op, values[a as usize], values[b as usize]),
            });
        }
        values
    }
}

/// Far above the smallest product whose rounding error cannot underflow.
const TINY_PRODUCT: f64 = 1e-250;

/// Is the rounded result known to be the exact one?
fn is_exact(op: Op, a: f64, b: f64, value: f64) -> bool {
    match op {
        Op::Neg | Op::Abs | Op::Min | Op::Max | Op::Sign | Op::Less => true,
        // The rounding error of a product that is not tiny is a float, and is what a fused multiply-add leaves.
        Op::Mul => value.abs() > TINY_PRODUCT && a.mul_add(b, -value) == 0.0,
        Op::Add => value - a == b && value - b == a,
        Op::Sub => value + b == a && a - value == b,
        _ => false,
    }
}
