//! The functions and numbers that every expression knows, by their names.

use super::graph::{Graph, Node};
use super::operation::{Binary, Unary};

/// A function by its name.
#[derive(Debug)]
pub struct NamedFunction {
    /// What a user types.
    pub name: &'static str,
    /// How many arguments it takes.
    pub arguments: usize,
    /// Whether it takes more as well.
    pub or_more: bool,
    /// Its node, from those of its arguments, as many as it takes.
    pub(super) node: fn(&mut Graph, &[Node]) -> Node,
}

const fn takes(name: &'static str, arguments: usize, node: fn(&mut Graph, &[Node]) -> Node) -> NamedFunction {
    NamedFunction { name, arguments, or_more: false, node }
}

/// All functions.
pub static FUNCTIONS: [NamedFunction; 14] = [
    takes("abs", 1, |graph, x| graph.unary(Unary::Absolute, x[0])),
    takes("cos", 1, |graph, x| graph.unary(Unary::Cosine, x[0])),
    takes("exp", 1, |graph, x| graph.unary(Unary::Exponential, x[0])),
    takes("if", 3, |graph, x| graph.choice(x[0], x[1], x[2])),
    takes("ln", 1, |graph, x| graph.unary(Unary::Logarithm, x[0])),
    takes("log10", 1, |graph, x| {
        let (logarithm, ten) = (graph.unary(Unary::Logarithm, x[0]), graph.number(std::f64::consts::LN_10));
        graph.binary(Binary::Divide, logarithm, ten)
    }),
    NamedFunction { or_more: true, ..takes("max", 2, |graph, x| all(graph, Binary::Maximum, x)) },
    NamedFunction { or_more: true, ..takes("min", 2, |graph, x| all(graph, Binary::Minimum, x)) },
    takes("pow", 2, |graph, x| graph.binary(Binary::Power, x[0], x[1])),
    takes("sin", 1, |graph, x| graph.unary(Unary::Sine, x[0])),
    takes("sqrt", 1, |graph, x| graph.unary(Unary::SquareRoot, x[0])),
    takes("step", 1, |graph, x| {
        let zero = graph.number(0.0);
        let negative = graph.binary(Binary::Below, x[0], zero);
        not(graph, negative)
    }),
    takes("tan", 1, |graph, x| {
        let (sine, cosine) = (graph.unary(Unary::Sine, x[0]), graph.unary(Unary::Cosine, x[0]));
        graph.binary(Binary::Divide, sine, cosine)
    }),
    takes("tanh", 1, |graph, x| graph.unary(Unary::HyperbolicTangent, x[0])),
];

/// Numbers that every expression knows.
pub const CONSTANTS: [(&str, f64); 1] = [("pi", std::f64::consts::PI)];

/// A function of two numbers applied to many, one after the other.
fn all(graph: &mut Graph, function: Binary, x: &[Node]) -> Node {
    x[1..].iter().fold(x[0], |so_far, &next| graph.binary(function, so_far, next))
}

/// 1 for 0, 0 for 1.
pub fn not(graph: &mut Graph, condition: Node) -> Node {
    let one = graph.number(1.0);
    graph.binary(Binary::Subtract, one, condition)
}
