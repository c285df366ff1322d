//! A graph as straight-line code on registers, evaluated by kind of number, for one input or in blocks.

use super::graph::{Graph, Node, NodeId};
use super::number::{Constant, Number, Op};
use crate::geom::Interval;
use std::cell::RefCell;

/// Slots 0, 1, 2 hold x, y, z; constants follow, then registers.
const INPUTS: usize = 3;
/// Inputs in a block if all registers fit into `SCRATCH`: long enough to hide the cost of decoding.
const LARGEST_BLOCK: usize = 512;
/// Shortest block, whatever the number of registers.
const SMALLEST_BLOCK: usize = 16;
/// Bytes in the registers of a block. Measured: shorter blocks lose more to decoding than longer ones to the
/// first-level cache, because an instruction touches only a few registers.
const SCRATCH: usize = 48 << 10;
/// Slots of the evaluations on the stack, by size of tape; larger tapes take their slots from the heap.
const SMALL_TAPE: usize = 32;
const MEDIUM_TAPE: usize = 128;

/// What is done at once with the result of an operation that nothing else reads: saves a write and a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Second {
    Nothing,
    /// result + c
    Add,
    /// result − c
    Sub,
    /// c − result
    From,
    /// result · c
    Mul,
    /// result²
    Square,
}

/// out = second(op(a, b), c). Operands are numbers of nodes at first, slots in the end.
#[derive(Clone, Copy, Debug)]
struct Instruction {
    op: Op,
    second: Second,
    out: u32,
    a: u32,
    b: u32,
    c: u32,
}

/// Straight-line code with several outputs. An instruction never writes to a slot that it reads.
#[derive(Clone, Debug)]
pub(super) struct Tape {
    constants: Vec<Constant>,
    code: Vec<Instruction>,
    registers: usize,
    outputs: Vec<u32>,
}

impl Tape {
    /// Code for the given nodes of a graph; registers are reused once their value is no longer needed.
    pub(super) fn new(graph: &Graph, outputs: &[NodeId]) -> Self {
        let needed = graph.reachable(outputs);
        let mut constants = Vec::new();
        let mut slots = vec![0_u32; needed.len()];
        for id in (0..needed.len()).filter(|&id| needed[id]) {
            match (graph.node(id as NodeId), graph.constant_value(id as NodeId)) {
                (_, Some(constant)) => {
                    slots[id] = (INPUTS + constants.len()) as u32;
                    constants.push(*constant);
                }
                (Node::Input(axis), _) => slots[id] = u32::from(axis),
                _ => {}
            }
        }
        let first_register = INPUTS + constants.len();
        let mut code = fused(graph, outputs, &needed);
        let last_use = last_uses(&code, outputs, needed.len());
        let (mut registers, mut free) = (0, Vec::new());
        for i in &mut code {
            let id = i.out;
            let mut operands = [i.a, i.b, i.c];
            let out = free.pop().unwrap_or_else(|| {
                registers += 1;
                (first_register + registers - 1) as u32
            });
            slots[id as usize] = out;
            let at = operands.map(|operand| slots[operand as usize]);
            *i = Instruction { out, a: at[0], b: at[1], c: at[2], ..*i };
            operands.sort_unstable();
            for (k, &operand) in operands.iter().enumerate() {
                let is_register = slots[operand as usize] as usize >= first_register;
                let is_repeated = k > 0 && operands[k - 1] == operand;
                if is_register && !is_repeated && last_use[operand as usize] == id {
                    free.push(slots[operand as usize]);
                }
            }
        }
        let outputs = outputs.iter().map(|&id| slots[id as usize]).collect();
        Self { constants, code, registers, outputs }
    }

    /// Number of operations.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.code.iter().map(|i| if i.second == Second::Nothing { 1 } else { 2 }).sum()
    }

    fn slots(&self) -> usize {
        INPUTS + self.constants.len() + self.registers
    }

    /// The outputs at one point.
    #[inline]
    pub(super) fn evaluate<N: Number, const OUTPUTS: usize>(&self, inputs: [N; 3]) -> [N; OUTPUTS] {
        match self.slots() {
            n if n <= SMALL_TAPE => self.evaluate_in(inputs, &mut [N::ZERO; SMALL_TAPE]),
            n if n <= MEDIUM_TAPE => self.evaluate_in(inputs, &mut [N::ZERO; MEDIUM_TAPE]),
            n => self.evaluate_in(inputs, &mut vec![N::ZERO; n]),
        }
    }

    fn evaluate_in<N: Number, const OUTPUTS: usize>(&self, inputs: [N; 3], slots: &mut [N]) -> [N; OUTPUTS] {
        slots[..INPUTS].copy_from_slice(&inputs);
        for (slot, constant) in slots[INPUTS..].iter_mut().zip(&self.constants) {
            *slot = N::constant(constant);
        }
        for i in &self.code {
            let first = N::apply(i.op, slots[i.a as usize], slots[i.b as usize]);
            slots[i.out as usize] = i.second.apply(first, slots[i.c as usize]);
        }
        std::array::from_fn(|k| slots[self.outputs[k] as usize])
    }

    /// The outputs for many inputs, one array per coordinate and per output.
    pub(super) fn evaluate_batch<N: Registers, const OUTPUTS: usize>(
        &self,
        inputs: [&[N]; 3],
        outputs: [&mut [N]; OUTPUTS],
    ) {
        let block = SCRATCH / (self.registers.max(1) * size_of::<N>());
        let block = block.clamp(SMALLEST_BLOCK, LARGEST_BLOCK);
        N::with_registers(|registers| {
            if registers.len() < block * self.registers {
                registers.resize(block * self.registers, N::ZERO);
            }
            self.evaluate_blocks(inputs, outputs, block, registers);
        });
    }

    fn evaluate_blocks<N: Number, const OUTPUTS: usize>(
        &self,
        inputs: [&[N]; 3],
        mut outputs: [&mut [N]; OUTPUTS],
        block: usize,
        registers: &mut [N],
    ) {
        let count = inputs[0].len();
        for start in (0..count).step_by(block) {
            let range = start..count.min(start + block);
            let length = range.len();
            let inputs = inputs.map(|coordinate| &coordinate[range.clone()]);
            for &instruction in &self.code {
                self.step(instruction, inputs, registers, block, length);
            }
            for (values, &slot) in outputs.iter_mut().zip(&self.outputs) {
                let values = &mut values[range.clone()];
                match self.source(slot, inputs, registers, block, length) {
                    Source::Many(source) => values.copy_from_slice(source),
                    Source::One(constant) => values.fill(constant),
                }
            }
        }
    }

    /// Where the operand in a slot is found; `registers` starts at the first register.
    fn source<'a, N: Number>(
        &self,
        slot: u32,
        inputs: [&'a [N]; 3],
        registers: &'a [N],
        block: usize,
        length: usize,
    ) -> Source<'a, N> {
        match slot as usize {
            k if k < INPUTS => Source::Many(inputs[k]),
            k if k < INPUTS + self.constants.len() => Source::One(N::constant(&self.constants[k - INPUTS])),
            k => {
                let start = (k - INPUTS - self.constants.len()) * block;
                Source::Many(&registers[start..start + length])
            }
        }
    }

    /// One instruction for a block.
    fn step<N: Number>(
        &self,
        i: Instruction,
        inputs: [&[N]; 3],
        registers: &mut [N],
        block: usize,
        length: usize,
    ) {
        let first_register = INPUTS + self.constants.len();
        let start = (i.out as usize - first_register) * block;
        let (before, rest) = registers.split_at_mut(start);
        let (out, after) = rest.split_at_mut(block);
        let operand = |slot: u32| {
            if slot > i.out {
                let skipped = i.out as usize + 1 - first_register;
                let slot = slot as usize - skipped;
                self.source(slot as u32, inputs, after, block, length)
            } else {
                self.source(slot, inputs, before, block, length)
            }
        };
        apply_block(i, &mut out[..length], operand(i.a), operand(i.b), operand(i.c));
    }
}

/// A kind of number with registers that each thread keeps from one batch to the next.
pub(super) trait Registers: Number {
    fn with_registers(evaluate: impl FnOnce(&mut Vec<Self>));
}

/// Implements [`Registers`] for a number.
macro_rules! registers {
    ($number:ty) => {
        impl Registers for $number {
            fn with_registers(evaluate: impl FnOnce(&mut Vec<Self>)) {
                thread_local! {
                    static REGISTERS: RefCell<Vec<$number>> = const { RefCell::new(Vec::new()) };
                }
                REGISTERS.with_borrow_mut(evaluate);
            }
        }
    };
}

registers!(f64);
registers!(Interval);

impl Second {
    #[inline(always)]
    fn apply<N: Number>(self, result: N, c: N) -> N {
        match self {
            Self::Nothing => result,
            Self::Add => N::apply(Op::Add, result, c),
            Self::Sub => N::apply(Op::Sub, result, c),
            Self::From => N::apply(Op::Sub, c, result),
            Self::Mul => N::apply(Op::Mul, result, c),
            Self::Square => N::apply(Op::Square, result, result),
        }
    }
}

/// The needed operations in order, each with the operation that alone reads its result, where there is one and
/// both are sums, differences, products or squares. Operands are numbers of nodes.
fn fused(graph: &Graph, outputs: &[NodeId], needed: &[bool]) -> Vec<Instruction> {
    let mut readers = vec![0_u32; needed.len()];
    outputs.iter().for_each(|&id| readers[id as usize] += 1);
    let operations = || {
        (0..needed.len() as NodeId).filter(|&id| needed[id as usize]).filter_map(|id| match graph.node(id) {
            Node::Apply(op, a, b) => Some((id, op, a, b)),
            _ => None,
        })
    };
    for (_, op, a, b) in operations() {
        readers[a as usize] += 1;
        readers[b as usize] += u32::from(!op.is_unary());
    }
    // Is the result of this node formed within its reader, or does it hold a second operation already?
    let mut taken = vec![false; needed.len()];
    let mut pairs = vec![None; needed.len()];
    for (id, op, a, b) in operations() {
        let is_free = |operand: NodeId, taken: &[bool]| {
            let is_simple = matches!(graph.node(operand), Node::Apply(op, ..) if is_simple(op));
            is_simple && readers[operand as usize] == 1 && !taken[operand as usize]
        };
        let inner = match second(op) {
            Some(kind) if is_free(a, &taken) => Some((a, kind, b)),
            Some(kind) if !op.is_unary() && is_free(b, &taken) => {
                Some((b, if kind == Second::Sub { Second::From } else { kind }, a))
            }
            _ => None,
        };
        if let Some((operand, kind, other)) = inner {
            taken[operand as usize] = true;
            taken[id as usize] = true;
            pairs[id as usize] = Some((operand, kind, if kind == Second::Square { operand } else { other }));
        }
    }
    let is_inside = |id: NodeId| taken[id as usize] && pairs[id as usize].is_none();
    operations()
        .filter(|(id, ..)| !is_inside(*id))
        .map(|(id, op, a, b)| match pairs[id as usize] {
            Some((inner, second, c)) => match graph.node(inner) {
                Node::Apply(op, a, b) => {
                    let c = if second == Second::Square { a } else { c };
                    Instruction { op, second, out: id, a, b, c }
                }
                _ => Instruction { op, second: Second::Nothing, out: id, a, b, c: a },
            },
            None => Instruction { op, second: Second::Nothing, out: id, a, b, c: a },
        })
        .collect()
}

fn is_simple(op: Op) -> bool {
    matches!(op, Op::Add | Op::Sub | Op::Mul | Op::Square)
}

fn second(op: Op) -> Option<Second> {
    match op {
        Op::Add => Some(Second::Add),
        Op::Sub => Some(Second::Sub),
        Op::Mul => Some(Second::Mul),
        Op::Square => Some(Second::Square),
        _ => None,
    }
}

/// For every node, the last instruction that reads it; outputs are read after the end.
fn last_uses(code: &[Instruction], outputs: &[NodeId], nodes: usize) -> Vec<NodeId> {
    let mut last_use = vec![0; nodes];
    for i in code {
        [i.a, i.b, i.c].into_iter().for_each(|operand| last_use[operand as usize] = i.out);
    }
    outputs.iter().for_each(|&id| last_use[id as usize] = NodeId::MAX);
    last_use
}

/// An operand for a block.
#[derive(Clone, Copy)]
enum Source<'a, N> {
    Many(&'a [N]),
    One(N),
}

/// One instruction for a block, by the same scalar code as at a single point; a loop for every operation, pair of
/// operations and kind of operand, so that the compiler can use vector instructions.
fn apply_block<N: Number>(
    i: Instruction,
    out: &mut [N],
    a: Source<'_, N>,
    b: Source<'_, N>,
    c: Source<'_, N>,
) {
    macro_rules! single {
        ($($op:ident),*) => {
            match i.op {
                $(Op::$op => fill(out, a, b, |a, b| N::apply(Op::$op, a, b)),)*
                Op::Power(n) => fill(out, a, b, |a, b| N::apply(Op::Power(n), a, b)),
            }
        };
    }
    macro_rules! pairs {
        ($($op:ident),*) => {
            match i.op {
                $(Op::$op => match i.second {
                    Second::Add => fill_pair(out, a, b, c, |a, b, c| Second::Add.apply(N::apply(Op::$op, a, b), c)),
                    Second::Sub => fill_pair(out, a, b, c, |a, b, c| Second::Sub.apply(N::apply(Op::$op, a, b), c)),
                    Second::From => fill_pair(out, a, b, c, |a, b, c| Second::From.apply(N::apply(Op::$op, a, b), c)),
                    Second::Mul => fill_pair(out, a, b, c, |a, b, c| Second::Mul.apply(N::apply(Op::$op, a, b), c)),
                    Second::Square => fill(out, a, b, |a, b| Second::Square.apply(N::apply(Op::$op, a, b), a)),
                    Second::Nothing => {}
                },)*
                // Other operations are never the first of a pair.
                _ => {}
            }
        };
    }
    if i.second != Second::Nothing {
        pairs!(Add, Sub, Mul, Square);
        return;
    }
    single!(
        Neg, Add, Sub, Mul, Div, Square, Sqrt, Abs, Exp, Log, Sin, Cos, Tan, Asin, Acos, Atan, Sinh, Cosh,
        Tanh, Pow, Min, Max, Sign, Less
    );
}

#[inline(always)]
fn fill<N: Number>(out: &mut [N], a: Source<'_, N>, b: Source<'_, N>, f: impl Fn(N, N) -> N) {
    match (a, b) {
        (Source::Many(a), Source::Many(b)) => {
            for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
                *out = f(a, b);
            }
        }
        (Source::Many(a), Source::One(b)) => {
            for (out, &a) in out.iter_mut().zip(a) {
                *out = f(a, b);
            }
        }
        (Source::One(a), Source::Many(b)) => {
            for (out, &b) in out.iter_mut().zip(b) {
                *out = f(a, b);
            }
        }
        (Source::One(a), Source::One(b)) => out.fill(f(a, b)),
    }
}

#[inline(always)]
fn fill_pair<N: Number>(
    out: &mut [N],
    a: Source<'_, N>,
    b: Source<'_, N>,
    c: Source<'_, N>,
    f: impl Fn(N, N, N) -> N,
) {
    match (a, b) {
        (Source::Many(a), Source::Many(b)) => match c {
            Source::Many(c) => {
                for (((out, &a), &b), &c) in out.iter_mut().zip(a).zip(b).zip(c) {
                    *out = f(a, b, c);
                }
            }
            Source::One(c) => {
                for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
                    *out = f(a, b, c);
                }
            }
        },
        (Source::One(a), b) => fill(out, b, c, |b, c| f(a, b, c)),
        (a, Source::One(b)) => fill(out, a, c, |a, c| f(a, b, c)),
    }
}

/// The ranges of the coordinates of a cell.
pub(super) fn cell_inputs(cell: &crate::geom::Aabb) -> [Interval; 3] {
    [0, 1, 2].map(|axis| Interval::new(cell.min[axis], cell.max[axis]))
}
