//! Derivatives by dual numbers: beside every value v, from the first to the last, its derivative v' — as a further expression.

use super::graph::{Graph, Node, Operation};
use super::operation::{Binary, Unary};

/// The second part of a dual number: a factor times a node, or the factor alone.
///
/// Numbers are kept apart from nodes so that they gather in one factor; most derivatives are zero or a number.
#[derive(Debug, Clone, Copy)]
struct Part {
    factor: f64,
    node: Option<Node>,
}

impl Part {
    const ZERO: Self = Self { factor: 0.0, node: None };
    const ONE: Self = Self { factor: 1.0, node: None };

    fn is_zero(self) -> bool {
        self.node.is_none() && self.factor == 0.0
    }

    fn scaled(self, factor: f64) -> Self {
        Self { factor: factor * self.factor, node: self.node }
    }

    /// The part times what stands at a node.
    fn times(self, graph: &mut Graph, factor: Node) -> Self {
        match (graph.value(factor), self.node) {
            _ if self.is_zero() => Self::ZERO,
            (Some(number), _) => self.scaled(number),
            (None, None) => Self { node: Some(factor), ..self },
            (None, Some(node)) => Self { node: Some(graph.binary(Binary::Multiply, node, factor)), ..self },
        }
    }

    /// The part over what stands at a node.
    fn over(self, graph: &mut Graph, divisor: Node) -> Self {
        match self.node {
            _ if self.is_zero() => Self::ZERO,
            None => {
                let number = graph.number(self.factor);
                Self { factor: 1.0, node: Some(graph.binary(Binary::Divide, number, divisor)) }
            }
            Some(node) => Self { node: Some(graph.binary(Binary::Divide, node, divisor)), ..self },
        }
    }

    fn plus(self, graph: &mut Graph, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return if self.is_zero() { other } else { self };
        }
        match (self.node, other.node) {
            (mine, theirs) if mine == theirs => Self { factor: self.factor + other.factor, node: mine },
            (Some(mine), Some(theirs)) if self.factor.abs() == other.factor.abs() => {
                let function = if self.factor == other.factor { Binary::Add } else { Binary::Subtract };
                Self { factor: self.factor, node: Some(graph.binary(function, mine, theirs)) }
            }
            _ => {
                let (mine, theirs) = (self.whole(graph), other.whole(graph));
                Self { factor: 1.0, node: Some(graph.binary(Binary::Add, mine, theirs)) }
            }
        }
    }

    /// The part as one node.
    fn whole(self, graph: &mut Graph) -> Node {
        let factor = graph.number(self.factor);
        match self.node {
            None => factor,
            Some(node) if self.factor == -1.0 => graph.unary(Unary::Negate, node),
            Some(node) => graph.binary(Binary::Multiply, factor, node),
        }
    }

    /// One part or another.
    fn choice(graph: &mut Graph, condition: Node, yes: Self, no: Self) -> Self {
        if yes.is_zero() && no.is_zero() {
            return Self::ZERO;
        }
        let (yes, no) = (yes.whole(graph), no.whole(graph));
        Self { factor: 1.0, node: Some(graph.choice(condition, yes, no)) }
    }
}

/// A factor times the derivative of a node with respect to a variable.
///
/// Where a function has a kink or a jump, the derivative is that of one of its sides; the jump's own is left out.
pub fn derivative(graph: &mut Graph, of: Node, variable: u8, factor: f64) -> Node {
    let mut parts: Vec<Part> = Vec::with_capacity(of + 1);
    for node in 0..=of {
        let part = match graph.operation(node) {
            Operation::Number(_) => Part::ZERO,
            Operation::Variable(index) => {
                if index == variable {
                    Part::ONE
                } else {
                    Part::ZERO
                }
            }
            Operation::Unary(function, x) => unary(graph, function, node, x, parts[x]),
            Operation::Binary(function, x, y) => binary(graph, function, node, [x, y], [parts[x], parts[y]]),
            // n xⁿ⁻¹ x'
            Operation::HalfPower(x, halves) => {
                let below = graph.half_power(x, halves - 2);
                parts[x].scaled(0.5 * f64::from(halves)).times(graph, below)
            }
            Operation::Choice(condition, yes, no) => Part::choice(graph, condition, parts[yes], parts[no]),
        };
        parts.push(part);
    }
    parts[of].scaled(factor).whole(graph)
}

/// f'(x) x', the value f(x) being at `node`.
fn unary(graph: &mut Graph, function: Unary, node: Node, x: Node, part: Part) -> Part {
    if part.is_zero() {
        return part;
    }
    match function {
        Unary::Negate => part.scaled(-1.0),
        Unary::Absolute => {
            let zero = graph.number(0.0);
            let negative = graph.binary(Binary::Below, x, zero);
            Part::choice(graph, negative, part.scaled(-1.0), part)
        }
        Unary::SquareRoot => part.scaled(0.5).over(graph, node),
        Unary::Exponential => part.times(graph, node),
        Unary::Logarithm => part.over(graph, x),
        Unary::Sine => {
            let cosine = graph.unary(Unary::Cosine, x);
            part.times(graph, cosine)
        }
        Unary::Cosine => {
            let sine = graph.unary(Unary::Sine, x);
            part.scaled(-1.0).times(graph, sine)
        }
        Unary::HyperbolicTangent => {
            let (one, square) = (graph.number(1.0), graph.half_power(node, 4));
            let rest = graph.binary(Binary::Subtract, one, square);
            part.times(graph, rest)
        }
    }
}

/// ∂f/∂x x' + ∂f/∂y y', the value f(x, y) being at `node`.
fn binary(graph: &mut Graph, function: Binary, node: Node, [x, y]: [Node; 2], [dx, dy]: [Part; 2]) -> Part {
    if dx.is_zero() && dy.is_zero() {
        return Part::ZERO;
    }
    match function {
        Binary::Add => dx.plus(graph, dy),
        Binary::Subtract => dx.plus(graph, dy.scaled(-1.0)),
        Binary::Multiply => {
            let (first, second) = (dx.times(graph, y), dy.times(graph, x));
            first.plus(graph, second)
        }
        // (x' − f y')/y
        Binary::Divide => {
            if let Some(number) = graph.value(y) {
                return dx.scaled(1.0 / number);
            }
            let rest = dy.scaled(-1.0).times(graph, node);
            dx.plus(graph, rest).over(graph, y)
        }
        // y xʸ⁻¹ x' + f ln x y'
        Binary::Power => {
            let one = graph.number(1.0);
            let exponent = graph.binary(Binary::Subtract, y, one);
            let below = graph.binary(Binary::Power, x, exponent);
            let first = dx.times(graph, y).times(graph, below);
            let logarithm = graph.unary(Unary::Logarithm, x);
            let second = dy.times(graph, node).times(graph, logarithm);
            first.plus(graph, second)
        }
        Binary::Minimum => {
            let other = graph.binary(Binary::Below, y, x);
            Part::choice(graph, other, dy, dx)
        }
        Binary::Maximum => {
            let other = graph.binary(Binary::Below, x, y);
            Part::choice(graph, other, dy, dx)
        }
        Binary::Below => Part::ZERO,
    }
}
