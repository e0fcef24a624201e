//! An expression as a graph: every different operation once, what is known beforehand worked out.

use super::operation::{Binary, Unary, choose};
use std::collections::HashMap;

/// The number of an operation in its graph; those it needs have smaller ones.
pub type Node = usize;

/// An operation, by what it needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation {
    /// A number, by its bits.
    Number(u64),
    /// A variable.
    Variable(u8),
    /// A function of one number.
    Unary(Unary, Node),
    /// A function of two numbers.
    Binary(Binary, Node, Node),
    /// x to a number of halves: by multiplication, of the root where the number is odd.
    HalfPower(Node, i32),
    /// The second where the first is not zero, else the third.
    Choice(Node, Node, Node),
}

/// Operations in the order in which they can be done.
///
/// Nothing is simplified that could change a bit of a value: numbers are worked out by the same functions that the tape
/// uses, and only what multiplies by 1, divides by 1 or subtracts 0 falls away.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    operations: Vec<Operation>,
    known: HashMap<Operation, Node>,
}

impl Graph {
    /// What stands at a node.
    pub fn operation(&self, node: Node) -> Operation {
        self.operations[node]
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.operations.len()
    }

    /// A number.
    pub fn number(&mut self, value: f64) -> Node {
        self.node(Operation::Number(value.to_bits()))
    }

    /// A variable.
    pub fn variable(&mut self, index: u8) -> Node {
        self.node(Operation::Variable(index))
    }

    /// The number that stands at a node.
    pub fn value(&self, node: Node) -> Option<f64> {
        match self.operations[node] {
            Operation::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// A function of one number.
    pub fn unary(&mut self, function: Unary, x: Node) -> Node {
        match (function, self.operations[x]) {
            (_, Operation::Number(bits)) => self.number(function.of(f64::from_bits(bits))),
            (Unary::Negate, Operation::Unary(Unary::Negate, inner)) => inner,
            _ => self.node(Operation::Unary(function, x)),
        }
    }

    /// A function of two numbers.
    pub fn binary(&mut self, function: Binary, x: Node, y: Node) -> Node {
        use Binary::{Add, Divide, Multiply, Power, Subtract};
        match (function, self.value(x), self.value(y)) {
            (Power, _, Some(exponent)) if (2.0 * exponent).fract() == 0.0 && exponent.abs() < 1e9 => {
                self.half_power(x, (2.0 * exponent) as i32)
            }
            (_, Some(x), Some(y)) => self.number(function.of(x, y)),
            (Multiply, Some(1.0), _) => y,
            (Multiply | Divide, _, Some(1.0)) => x,
            (Subtract, _, Some(zero)) if zero.to_bits() == 0 => x,
            (Add | Multiply, ..) => self.node(Operation::Binary(function, x.min(y), x.max(y))),
            _ => self.node(Operation::Binary(function, x, y)),
        }
    }

    /// x to a number of halves.
    pub fn half_power(&mut self, x: Node, halves: i32) -> Node {
        match (self.value(x), halves) {
            (_, 0) => self.number(1.0),
            (_, 2) => x,
            (Some(_), _) => self.multiplied_halves(x, halves),
            (None, _) => self.node(Operation::HalfPower(x, halves)),
        }
    }

    fn multiplied_halves(&mut self, x: Node, halves: i32) -> Node {
        if halves % 2 == 0 {
            return self.multiplied(x, halves / 2);
        }
        let root = self.unary(Unary::SquareRoot, x);
        self.multiplied(root, halves)
    }

    /// xⁿ in squarings and multiplications.
    fn multiplied(&mut self, x: Node, n: i32) -> Node {
        match n {
            ..0 => {
                let one = self.number(1.0);
                let inverse = self.multiplied(x, -n);
                self.binary(Binary::Divide, one, inverse)
            }
            0 => self.number(1.0),
            1 => x,
            _ if n % 2 == 0 => {
                let half = self.multiplied(x, n / 2);
                self.binary(Binary::Multiply, half, half)
            }
            _ => {
                let rest = self.multiplied(x, n - 1);
                self.binary(Binary::Multiply, rest, x)
            }
        }
    }

    /// `yes` where the condition is not zero, else `no`.
    pub fn choice(&mut self, condition: Node, yes: Node, no: Node) -> Node {
        match self.value(condition) {
            Some(condition) => {
                if choose(condition, 1.0, 0.0) == 1.0 {
                    yes
                } else {
                    no
                }
            }
            None if yes == no => yes,
            None => self.node(Operation::Choice(condition, yes, no)),
        }
    }

    /// The part of the graph that a node needs, powers turned into multiplications; and where the node is in it.
    pub fn lowered(&self, wanted: Node) -> (Self, Node) {
        let mut needed = vec![false; wanted + 1];
        needed[wanted] = true;
        for node in (0..needed.len()).rev() {
            if needed[node] {
                operands(self.operations[node]).into_iter().flatten().for_each(|operand| needed[operand] = true);
            }
        }
        let mut lowered = Self::default();
        let mut place = vec![0; needed.len()];
        for node in (0..needed.len()).filter(|&node| needed[node]) {
            place[node] = match self.operations[node] {
                Operation::Number(_) | Operation::Variable(_) => lowered.node(self.operations[node]),
                Operation::Unary(function, x) => lowered.unary(function, place[x]),
                Operation::Binary(function, x, y) => lowered.binary(function, place[x], place[y]),
                Operation::HalfPower(x, halves) => lowered.multiplied_halves(place[x], halves),
                Operation::Choice(condition, yes, no) => lowered.choice(place[condition], place[yes], place[no]),
            };
        }
        (lowered, place[wanted])
    }

    fn node(&mut self, operation: Operation) -> Node {
        let next = self.operations.len();
        let node = *self.known.entry(operation).or_insert(next);
        if node == next {
            self.operations.push(operation);
        }
        node
    }
}

/// What an operation needs.
pub fn operands(operation: Operation) -> [Option<Node>; 3] {
    match operation {
        Operation::Number(_) | Operation::Variable(_) => [None; 3],
        Operation::Unary(_, x) | Operation::HalfPower(x, _) => [Some(x), None, None],
        Operation::Binary(_, x, y) => [Some(x), Some(y), None],
        Operation::Choice(condition, yes, no) => [Some(condition), Some(yes), Some(no)],
    }
}
