//! A graph as straight-line code on registers, evaluated by kind of number, at a point or in blocks of points.

use super::graph::{Graph, Node, NodeId};
use super::number::{Constant, Number, Op};
use crate::geom::{Interval, PointsView};
use std::cell::RefCell;

/// Slots 0, 1, 2 hold x, y, z; constants follow, then registers.
const INPUTS: usize = 3;
/// Points in a block if all registers fit into `SCRATCH`: long enough to hide the cost of decoding.
const LARGEST_BLOCK: usize = 512;
/// Shortest block, whatever the number of registers.
const SMALLEST_BLOCK: usize = 16;
/// Floats in the registers of a block: 24 KiB, to stay in the first-level cache beside inputs and outputs.
const SCRATCH: usize = 3072;
/// Slots of the evaluations on the stack, by size of tape; larger tapes take their slots from the heap.
const SMALL_TAPE: usize = 32;
const MEDIUM_TAPE: usize = 128;

#[derive(Clone, Copy, Debug)]
struct Instruction {
    op: Op,
    out: u32,
    a: u32,
    b: u32,
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
        let last_use = last_uses(graph, outputs, &needed);
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
        let (mut code, mut registers, mut free) = (Vec::new(), 0, Vec::new());
        for id in (0..needed.len()).filter(|&id| needed[id]) {
            let Node::Apply(op, a, b) = graph.node(id as NodeId) else { continue };
            let out = free.pop().unwrap_or_else(|| {
                registers += 1;
                (first_register + registers - 1) as u32
            });
            slots[id] = out;
            code.push(Instruction { op, out, a: slots[a as usize], b: slots[b as usize] });
            for (k, operand) in [a, b].into_iter().enumerate() {
                let is_register = slots[operand as usize] as usize >= first_register;
                if is_register && last_use[operand as usize] == id && (k == 0 || a != b) {
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
        self.code.len()
    }

    fn slots(&self) -> usize {
        INPUTS + self.constants.len() + self.registers
    }

    /// The outputs at one point.
    #[inline]
    pub(super) fn evaluate<N: Number, const OUTPUTS: usize>(&self, inputs: [N; 3]) -> [N; OUTPUTS] {
        match self.slots() {
            ..=SMALL_TAPE => self.evaluate_in(inputs, &mut [N::ZERO; SMALL_TAPE]),
            ..=MEDIUM_TAPE => self.evaluate_in(inputs, &mut [N::ZERO; MEDIUM_TAPE]),
            n => self.evaluate_in(inputs, &mut vec![N::ZERO; n]),
        }
    }

    fn evaluate_in<N: Number, const OUTPUTS: usize>(&self, inputs: [N; 3], slots: &mut [N]) -> [N; OUTPUTS] {
        slots[..INPUTS].copy_from_slice(&inputs);
        for (slot, constant) in slots[INPUTS..].iter_mut().zip(&self.constants) {
            *slot = N::constant(constant);
        }
        for i in &self.code {
            slots[i.out as usize] = N::apply(i.op, slots[i.a as usize], slots[i.b as usize]);
        }
        std::array::from_fn(|k| slots[self.outputs[k] as usize])
    }

    /// The outputs at every point, one array per output.
    pub(super) fn evaluate_batch<const OUTPUTS: usize>(
        &self,
        points: PointsView<'_>,
        outputs: [&mut [f64]; OUTPUTS],
    ) {
        thread_local! {
            static REGISTERS: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
        }
        let block = (SCRATCH / self.registers.max(1)).clamp(SMALLEST_BLOCK, LARGEST_BLOCK);
        REGISTERS.with_borrow_mut(|registers| {
            if registers.len() < block * self.registers {
                registers.resize(block * self.registers, 0.0);
            }
            self.evaluate_blocks(points, outputs, block, registers);
        });
    }

    fn evaluate_blocks<const OUTPUTS: usize>(
        &self,
        points: PointsView<'_>,
        mut outputs: [&mut [f64]; OUTPUTS],
        block: usize,
        registers: &mut [f64],
    ) {
        for start in (0..points.len()).step_by(block) {
            let range = start..points.len().min(start + block);
            let length = range.len();
            let inputs = points.slice(range.clone());
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
    fn source<'a>(
        &self,
        slot: u32,
        inputs: PointsView<'a>,
        registers: &'a [f64],
        block: usize,
        length: usize,
    ) -> Source<'a> {
        match slot as usize {
            0 => Source::Many(inputs.x),
            1 => Source::Many(inputs.y),
            2 => Source::Many(inputs.z),
            k if k < INPUTS + self.constants.len() => Source::One(self.constants[k - INPUTS].value),
            k => {
                let start = (k - INPUTS - self.constants.len()) * block;
                Source::Many(&registers[start..start + length])
            }
        }
    }

    /// One instruction for a block of points.
    fn step(
        &self,
        i: Instruction,
        inputs: PointsView<'_>,
        registers: &mut [f64],
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
        apply_block(i.op, &mut out[..length], operand(i.a), operand(i.b));
    }
}

/// For every node, the last instruction that reads it; outputs are read after the end.
fn last_uses(graph: &Graph, outputs: &[NodeId], needed: &[bool]) -> Vec<usize> {
    let mut last_use = vec![0; needed.len()];
    for id in (0..needed.len()).filter(|&id| needed[id]) {
        if let Node::Apply(_, a, b) = graph.node(id as NodeId) {
            last_use[a as usize] = id;
            last_use[b as usize] = id;
        }
    }
    outputs.iter().for_each(|&id| last_use[id as usize] = usize::MAX);
    last_use
}

/// An operand for a block of points.
#[derive(Clone, Copy)]
enum Source<'a> {
    Many(&'a [f64]),
    One(f64),
}

/// `out` = op(a, b) for a block, by the same scalar code as at a single point; one loop per operation and kind of
/// operand, so that the compiler can use vector instructions.
fn apply_block(op: Op, out: &mut [f64], a: Source<'_>, b: Source<'_>) {
    macro_rules! loops {
        ($($op:pat => $same:expr),* $(,)?) => {
            match op { $($op => fill(out, a, b, |a, b| f64::apply($same, a, b)),)* }
        };
    }
    loops! {
        Op::Neg => Op::Neg, Op::Add => Op::Add, Op::Sub => Op::Sub, Op::Mul | Op::Power(_) => Op::Mul,
        Op::Div => Op::Div, Op::Square => Op::Square, Op::Sqrt => Op::Sqrt, Op::Abs => Op::Abs,
        Op::Exp => Op::Exp, Op::Log => Op::Log, Op::Sin => Op::Sin, Op::Cos => Op::Cos, Op::Tan => Op::Tan,
        Op::Asin => Op::Asin, Op::Acos => Op::Acos, Op::Atan => Op::Atan, Op::Sinh => Op::Sinh,
        Op::Cosh => Op::Cosh, Op::Tanh => Op::Tanh, Op::Pow => Op::Pow, Op::Min => Op::Min, Op::Max => Op::Max,
        Op::Sign => Op::Sign, Op::Less => Op::Less,
    }
}

#[inline(always)]
fn fill(out: &mut [f64], a: Source<'_>, b: Source<'_>, f: impl Fn(f64, f64) -> f64) {
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

/// The ranges of the coordinates of a cell.
pub(super) fn cell_inputs(cell: &crate::geom::Aabb) -> [Interval; 3] {
    [0, 1, 2].map(|axis| Interval::new(cell.min[axis], cell.max[axis]))
}
