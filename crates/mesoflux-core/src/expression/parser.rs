//! From a text to a graph.

use super::error::{ExpressionError, Place, Unknown};
use super::functions::{CONSTANTS, FUNCTIONS, not};
use super::graph::{Graph, Node};
use super::operation::{Binary, Unary};
use std::collections::BTreeMap;
use std::ops::Range;

/// So deep may parentheses, powers and signs be nested in each other.
const DEEPEST: usize = 100;

/// Reads a text into a graph; see [`super::Expression::parse`].
pub fn parse(
    text: &str,
    variables: &[&str],
    constants: &BTreeMap<String, f64>,
    graph: &mut Graph,
) -> Result<Node, ExpressionError> {
    for (name, value) in constants {
        let fault = |requirement: &str| ExpressionError::new(text, Place::Parameter(name.clone()), requirement);
        let is_taken = variables.contains(&name.as_str())
            || FUNCTIONS.iter().any(|function| function.name == name)
            || CONSTANTS.iter().any(|(constant, _)| constant == name);
        if !name.starts_with(begins_name) || !name.chars().all(continues_name) {
            return Err(fault("must be named by letters, digits and underscores, a letter first"));
        }
        if is_taken {
            return Err(ExpressionError::taken_name(text, name));
        }
        if !value.is_finite() {
            return Err(fault("must be a finite number"));
        }
    }
    let mut parser = Parser { text, at: 0, depth: 0, variables, constants, graph };
    let node = parser.comparison()?;
    match parser.peek() {
        None => Ok(node),
        Some(_) => Err(parser.unexpected()),
    }
}

fn begins_name(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

fn continues_name(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    variables: &'a [&'a str],
    constants: &'a BTreeMap<String, f64>,
    graph: &'a mut Graph,
}

type Parsed = Result<Node, ExpressionError>;

impl Parser<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Goes beyond a symbol if it comes next.
    fn take(&mut self, symbol: &str) -> bool {
        self.peek();
        let found = self.text[self.at..].starts_with(symbol);
        self.at += if found { symbol.len() } else { 0 };
        found
    }

    fn fault(&self, range: Range<usize>, requirement: impl Into<String>) -> ExpressionError {
        ExpressionError::new(self.text, Place::Text(range), requirement)
    }

    /// What stands here has no meaning here.
    fn unexpected(&mut self) -> ExpressionError {
        let Some(found) = self.peek() else {
            return self.fault(self.at..self.at, "a value must follow, the expression ends here");
        };
        let range = self.at..self.at + found.len_utf8();
        match found {
            ')' => self.fault(range, "this parenthesis closes none that is open"),
            ',' => self.fault(range, "a comma only separates the arguments of a function"),
            '=' | '!' => self.fault(range, format!("unexpected `{found}`: comparisons are <, <=, > and >=")),
            '&' | '|' => self
                .fault(range, format!("unexpected `{found}`"))
                .helped("conditions are 1 or 0: both is a product, either is max"),
            _ if found.is_ascii_digit() || begins_name(found) || found == '(' => {
                self.fault(range, "an operator must come before this").helped("a product needs its sign, 2*r")
            }
            _ => self.fault(range, format!("unexpected `{found}`")),
        }
    }

    /// `inner`, one level deeper.
    fn nested(&mut self, inner: impl FnOnce(&mut Self) -> Parsed) -> Parsed {
        if self.depth == DEEPEST {
            return Err(self.fault(self.at..self.at, format!("must not be nested deeper than {DEEPEST} levels")));
        }
        self.depth += 1;
        let node = inner(self)?;
        self.depth -= 1;
        Ok(node)
    }

    fn comparison(&mut self) -> Parsed {
        let left = self.sum()?;
        let Some(symbol) = ["<=", ">=", "<", ">"].into_iter().find(|symbol| self.take(symbol)) else {
            return Ok(left);
        };
        let right = self.sum()?;
        if let Some(next @ ('<' | '>')) = self.peek() {
            let requirement = "comparisons must not follow one another";
            return Err(self.fault(self.at..self.at + next.len_utf8(), requirement));
        }
        let (low, high) = if symbol.starts_with('<') { (left, right) } else { (right, left) };
        if symbol.ends_with('=') {
            let above = self.graph.binary(Binary::Below, high, low);
            return Ok(not(self.graph, above));
        }
        Ok(self.graph.binary(Binary::Below, low, high))
    }

    fn sum(&mut self) -> Parsed {
        let mut sum = self.product()?;
        loop {
            let function = match self.peek() {
                Some('+') => Binary::Add,
                Some('-') => Binary::Subtract,
                _ => return Ok(sum),
            };
            self.at += 1;
            let term = self.product()?;
            sum = self.graph.binary(function, sum, term);
        }
    }

    fn product(&mut self) -> Parsed {
        let mut product = self.signed()?;
        loop {
            let function = match self.peek() {
                Some('*') if self.text[self.at..].starts_with("**") => {
                    return Err(self.fault(self.at..self.at + 2, "a power is written with ^"));
                }
                Some('*') => Binary::Multiply,
                Some('/') => Binary::Divide,
                _ => return Ok(product),
            };
            self.at += 1;
            let factor = self.signed()?;
            product = self.graph.binary(function, product, factor);
        }
    }

    fn signed(&mut self) -> Parsed {
        if self.take("-") {
            let node = self.nested(Self::signed)?;
            return Ok(self.graph.unary(Unary::Negate, node));
        }
        if self.take("+") { self.nested(Self::signed) } else { self.power() }
    }

    fn power(&mut self) -> Parsed {
        let base = self.primary()?;
        if !self.take("^") {
            return Ok(base);
        }
        let exponent = self.nested(Self::signed)?;
        Ok(self.graph.binary(Binary::Power, base, exponent))
    }

    fn primary(&mut self) -> Parsed {
        match self.peek() {
            Some('(') => {
                let open = self.at;
                self.at += 1;
                let inner = self.nested(Self::comparison)?;
                self.close(open)?;
                Ok(inner)
            }
            Some(digit) if digit.is_ascii_digit() || digit == '.' => self.number(),
            Some(letter) if begins_name(letter) => self.name(),
            Some(sign @ ('*' | '/' | '^' | '<' | '>' | ')' | ',')) => {
                Err(self.fault(self.at..self.at + 1, format!("a value must come before `{sign}`")))
            }
            _ => Err(self.unexpected()),
        }
    }

    /// The parenthesis that closes the one opened at a place.
    fn close(&mut self, open: usize) -> Result<(), ExpressionError> {
        if self.take(")") {
            return Ok(());
        }
        match self.peek() {
            None => Err(self.fault(open..open + 1, "this parenthesis must be closed")),
            Some(_) => Err(self.unexpected()),
        }
    }

    fn number(&mut self) -> Parsed {
        let rest = &self.text[self.at..];
        let digits = |from: usize| from + rest[from..].bytes().take_while(u8::is_ascii_digit).count();
        let mut end = digits(0);
        if rest[end..].starts_with('.') {
            end = digits(end + 1);
        }
        if rest[end..].starts_with(['e', 'E']) {
            let sign = usize::from(rest[end + 1..].starts_with(['+', '-']));
            let exponent = digits(end + 1 + sign);
            end = if exponent > end + 1 + sign { exponent } else { end };
        }
        let range = self.at..self.at + end;
        self.at += end;
        match rest[..end].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(self.graph.number(value)),
            _ => Err(self.fault(range, "must be a number that double precision can hold")),
        }
    }

    fn name(&mut self) -> Parsed {
        let rest = &self.text[self.at..];
        let name = &rest[..rest.find(|character| !continues_name(character)).unwrap_or(rest.len())];
        let range = self.at..self.at + name.len();
        self.at = range.end;
        if self.peek() == Some('(') {
            return self.call(name, range);
        }
        if let Some(index) = self.variables.iter().position(|variable| *variable == name) {
            return Ok(self.graph.variable(index as u8));
        }
        let constant = CONSTANTS.iter().find(|(constant, _)| *constant == name).map(|&(_, value)| value);
        if let Some(value) = constant.or_else(|| self.constants.get(name).copied()) {
            return Ok(self.graph.number(value));
        }
        if FUNCTIONS.iter().any(|function| function.name == name) {
            return Err(self.fault(range, format!("`{name}` is a function: its arguments must follow, {name}(…)")));
        }
        let variables = self.variables.iter().copied();
        let known = variables.chain(self.constants.keys().map(String::as_str)).chain(CONSTANTS.map(|(name, _)| name));
        Err(self.unknown(name, range, known.map(str::to_owned).collect()))
    }

    fn unknown(&self, name: &str, range: Range<usize>, known: Vec<String>) -> ExpressionError {
        let quoted: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
        let mut error = self.fault(range, format!("unknown name, must be one of {}", quoted.join(", ")));
        error.unknown = Some(Box::new(Unknown { name: name.to_owned(), known }));
        error
    }

    fn call(&mut self, name: &str, range: Range<usize>) -> Parsed {
        let Some(function) = FUNCTIONS.iter().find(|function| function.name == name) else {
            let known = FUNCTIONS.iter().map(|function| function.name.to_owned()).collect();
            let mut error = self.unknown(name, range, known);
            error.help = (name == "log").then(|| "the natural logarithm is ln, that to base ten log10".to_owned());
            return Err(error);
        };
        let open = self.at;
        self.at += 1;
        let mut arguments = Vec::new();
        if self.peek() != Some(')') {
            arguments.push(self.nested(Self::comparison)?);
            while self.take(",") {
                arguments.push(self.nested(Self::comparison)?);
            }
        }
        self.close(open)?;
        let (count, given) = (function.arguments, arguments.len());
        if given < count || (given > count && !function.or_more) {
            let (least, plural) = (if function.or_more { "at least " } else { "" }, if count == 1 { "" } else { "s" });
            let requirement = format!("`{name}` takes {least}{count} argument{plural}, not {given}");
            return Err(self.fault(range.start..self.at, requirement));
        }
        Ok((function.node)(self.graph, &arguments))
    }
}
