//! An expression as a straight line of instructions over a few registers: what kernels run.

use super::graph::{Graph, Node, Operation, operands};
use super::operation::{Binary, Unary, choose};
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Real, Twice};

/// Registers of a tape; a power of two, so that a register's number needs no check.
const REGISTERS: usize = 32;

/// The number of a register.
type Register = u8;

/// What an instruction works out.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Action {
    Number(f64),
    Unary(Unary, Register),
    Binary(Binary, Register, Register),
    Choice(Register, Register, Register),
}

/// An action and where its result goes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Instruction {
    action: Action,
    to: Register,
}

/// A function of a few numbers.
///
/// Each instruction is done for many sets of variables at once, for any [`Real`]; the bits don't depend on how many.
#[derive(Debug, Clone, PartialEq)]
pub struct Tape {
    /// How many numbers; they stand in the first registers.
    variables: usize,
    instructions: Vec<Instruction>,
    output: Register,
}

impl Tape {
    /// The instructions for a node; nothing where they need more registers than there are.
    pub(super) fn new(variables: usize, graph: &Graph, output: Node) -> Option<Self> {
        let (graph, output) = graph.lowered(output);
        let mut writer = Writer::new(variables, &graph);
        for node in writer.order(output) {
            writer.write(node)?;
        }
        let output = writer.operand(output)?;
        Some(Self { variables, instructions: writer.instructions, output })
    }

    /// How many instructions there are.
    #[cfg(test)]
    pub(super) fn length(&self) -> usize {
        self.instructions.len()
    }

    /// The function's value; variables that aren't given are zero.
    #[inline(never)]
    pub fn value<R: Real>(&self, variables: &[R]) -> R {
        let mut registers = [R::splat(0.0); REGISTERS];
        for (register, &variable) in registers.iter_mut().zip(variables).take(self.variables) {
            *register = variable;
        }
        self.run(&mut registers)
    }

    /// The function's values for the first `streams` streams of a block; what becomes of the others means nothing.
    ///
    /// A call and not a part of its caller: interpreting is long code, and one copy for each set of instructions is enough.
    #[inline(never)]
    pub(crate) fn fill(&self, streams: usize, variables: &[BlockNumbers], values: &mut BlockNumbers) {
        InstructionSet::detect().run(Fill { tape: self, streams, variables, values });
    }

    #[inline(always)]
    fn run<R: Real>(&self, registers: &mut [R; REGISTERS]) -> R {
        for &Instruction { action, to } in &self.instructions {
            registers[place(to)] = match action {
                Action::Number(value) => R::splat(value),
                Action::Unary(function, x) => function.of(registers[place(x)]),
                Action::Binary(function, x, y) => function.of(registers[place(x)], registers[place(y)]),
                Action::Choice(condition, yes, no) => {
                    choose(registers[place(condition)], registers[place(yes)], registers[place(no)])
                }
            };
        }
        registers[place(self.output)]
    }
}

/// A tape run over a block.
pub(super) struct Fill<'a> {
    pub tape: &'a Tape,
    pub streams: usize,
    pub variables: &'a [BlockNumbers],
    pub values: &'a mut BlockNumbers,
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { tape, streams, variables, values } = self;
        // Registers are written before they are read: one set will do for the whole block.
        let mut registers = [Twice::<L>::splat(0.0); REGISTERS];
        let streams = streams.min(8);
        if streams == 1 {
            let mut registers = [L::splat(0.0); REGISTERS];
            for (register, variable) in registers.iter_mut().zip(variables).take(tape.variables) {
                *register = L::load(&variable[0]);
            }
            tape.run(&mut registers).store(&mut values[0]);
            return;
        }
        for from in (0..streams).step_by(2) {
            for (register, variable) in registers.iter_mut().zip(variables).take(tape.variables) {
                *register = Twice(L::load(&variable[from]), L::load(&variable[from + 1]));
            }
            let Twice(first, second) = tape.run(&mut registers);
            first.store(&mut values[from]);
            second.store(&mut values[from + 1]);
        }
    }
}

#[inline(always)]
fn place(register: Register) -> usize {
    usize::from(register) % REGISTERS
}

/// Gives out registers while instructions are written.
struct Writer<'a> {
    graph: &'a Graph,
    instructions: Vec<Instruction>,
    /// How often each node will still be needed.
    needs: Vec<usize>,
    register: Vec<Option<Register>>,
    occupied: [bool; REGISTERS],
}

impl<'a> Writer<'a> {
    fn new(variables: usize, graph: &'a Graph) -> Self {
        let mut needs = vec![0; graph.count()];
        for node in 0..graph.count() {
            operands(graph.operation(node)).into_iter().flatten().for_each(|operand| needs[operand] += 1);
        }
        let mut occupied = [false; REGISTERS];
        occupied[..variables].fill(true);
        Self { graph, instructions: Vec::new(), needs, register: vec![None; graph.count()], occupied }
    }

    /// The nodes that need an instruction, each after what it needs and as late as can be.
    fn order(&self, output: Node) -> Vec<Node> {
        let (mut order, mut done) = (Vec::new(), vec![false; self.graph.count()]);
        let mut stack = vec![(output, false)];
        while let Some((node, ready)) = stack.pop() {
            let operation = self.graph.operation(node);
            if done[node] || matches!(operation, Operation::Number(_) | Operation::Variable(_)) {
                continue;
            }
            if ready {
                done[node] = true;
                order.push(node);
            } else {
                stack.push((node, true));
                stack.extend(operands(operation).into_iter().rev().flatten().map(|operand| (operand, false)));
            }
        }
        order
    }

    fn write(&mut self, node: Node) -> Option<()> {
        let operation = self.graph.operation(node);
        let [x, y, z] = operands(operation);
        let mut at = [0; 3];
        for (at, operand) in at.iter_mut().zip([x, y, z]) {
            if let Some(operand) = operand {
                *at = self.operand(operand)?;
            }
        }
        for (operand, at) in [x, y, z].into_iter().zip(at) {
            if let Some(operand) = operand {
                self.release(operand, at);
            }
        }
        let action = match operation {
            Operation::Unary(function, _) => Action::Unary(function, at[0]),
            Operation::Binary(function, ..) => Action::Binary(function, at[0], at[1]),
            Operation::Choice(..) => Action::Choice(at[0], at[1], at[2]),
            // Neither numbers and variables nor, in a lowered graph, powers are written.
            Operation::Number(_) | Operation::Variable(_) | Operation::HalfPower(..) => return Some(()),
        };
        let to = self.occupy()?;
        self.register[node] = Some(to);
        self.instructions.push(Instruction { action, to });
        Some(())
    }

    /// Where a node's value stands; a number is put there for this one use.
    fn operand(&mut self, node: Node) -> Option<Register> {
        match self.graph.operation(node) {
            Operation::Variable(index) => Some(index),
            Operation::Number(bits) => {
                let to = self.occupy()?;
                self.instructions.push(Instruction { action: Action::Number(f64::from_bits(bits)), to });
                Some(to)
            }
            _ => self.register[node],
        }
    }

    fn occupy(&mut self) -> Option<Register> {
        let free = self.occupied.iter().position(|occupied| !occupied)?;
        self.occupied[free] = true;
        Some(free as Register)
    }

    fn release(&mut self, node: Node, at: Register) {
        self.needs[node] -= 1;
        let single_use = matches!(self.graph.operation(node), Operation::Number(_));
        let is_variable = matches!(self.graph.operation(node), Operation::Variable(_));
        if !is_variable && (single_use || self.needs[node] == 0) {
            self.occupied[usize::from(at)] = false;
        }
    }
}
