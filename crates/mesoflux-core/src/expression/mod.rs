//! A small language for laws and fields that users type.
//!
//! `4*epsilon*((sigma/r)^12 - (sigma/r)^6)`: numbers, `+ - * / ^` as on paper (`-x^2` is −(x²), `a^b^c` is a^(b^c)), comparisons
//! `< <= > >=` that give 1 or 0, parentheses, variables, named numbers with `pi` among them, and the functions of [`FUNCTIONS`].
//! `if(condition, a, b)` is a where the condition isn't zero, `step(x)` is 1 for x ≥ 0.
//!
//! A text becomes a graph, its derivatives further nodes of it, and some nodes a [`Tape`] that kernels run, one instruction
//! after the other for many particles or pairs at once.

mod derivative;
mod error;
mod functions;
mod graph;
pub(crate) mod in_box;
mod operation;
mod parser;
mod tape;

pub use error::{ExpressionError, Place, Unknown};
pub use functions::{CONSTANTS, FUNCTIONS, NamedFunction};
pub use tape::Tape;

use graph::{Graph, Node};
use operation::Binary;
use std::collections::BTreeMap;

/// An expression in some variables, and what follows from it.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    variables: usize,
    graph: Graph,
    value: Node,
}

/// A function that follows from an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Function(Node);

impl Expression {
    /// Reads a text in which the variables may occur, and the constants beside [`CONSTANTS`] by their names.
    ///
    /// # Errors
    /// A text that is no expression, with the place; constants that are no numbers or have a name that is taken.
    pub fn parse(text: &str, variables: &[&str], constants: &BTreeMap<String, f64>) -> Result<Self, ExpressionError> {
        let mut graph = Graph::default();
        let value = parser::parse(text, variables, constants, &mut graph)?;
        Ok(Self { text: text.to_owned(), variables: variables.len(), graph, value })
    }

    /// The expression itself.
    pub fn value(&self) -> Function {
        Function(self.value)
    }

    /// A factor times the derivative of a function with respect to the variable of this index, piece by piece where it has
    /// kinks or jumps.
    pub fn derivative(&mut self, of: Function, variable: usize, factor: f64) -> Function {
        Function(derivative::derivative(&mut self.graph, of.0, variable as u8, factor))
    }

    /// The sum of two functions.
    pub fn sum(&mut self, a: Function, b: Function) -> Function {
        Function(self.graph.binary(Binary::Add, a.0, b.0))
    }

    /// Whether a function is zero everywhere for all that can be seen.
    pub fn is_zero(&self, function: Function) -> bool {
        self.graph.value(function.0) == Some(0.0)
    }

    /// The tape of a function of all variables.
    ///
    /// # Errors
    /// A function that needs too many intermediate results at the same time.
    pub fn tape(&self, function: Function) -> Result<Tape, ExpressionError> {
        let too_long = "needs more than 32 intermediate results at once: must be written with fewer nested parentheses";
        Tape::new(self.variables, &self.graph, function.0).ok_or_else(|| ExpressionError::whole(&self.text, too_long))
    }
}

#[cfg(test)]
mod tests;
