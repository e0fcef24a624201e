//! Meaning, messages, derivatives and bits of expressions.

use super::tape::Fill;
use super::*;
use crate::lanes::{BlockNumbers, InstructionSet};
use proptest::prelude::*;

fn named(parameters: &[(&str, f64)]) -> BTreeMap<String, f64> {
    parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect()
}

fn parse(text: &str) -> Result<Expression, ExpressionError> {
    Expression::parse(text, &["x", "y"], &named(&[("a", 3.0), ("sigma", 0.5)]))
}

fn value(text: &str) -> f64 {
    let expression = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    expression.tape(expression.value()).unwrap().value(&[2.0, 7.0])
}

#[test]
fn operators_bind_as_on_paper() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("2 - 3 - 4", -5.0),
        ("12/3/2", 2.0),
        ("-x^2", -4.0),
        ("(-x)^2", 4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("--x", 2.0),
        ("-x*-y", 14.0),
        ("+x", 2.0),
        ("x*y^2/2", 49.0),
        ("1.5e1 + .5 + 2.", 17.5),
        ("x < y", 1.0),
        ("x > y", 0.0),
        ("x + 5 <= y", 1.0),
        ("x >= y - 4", 0.0),
        ("2*(x < y) + 1", 3.0),
        ("if(x < y, a, sigma)", 3.0),
        ("if(0, a, sigma)", 0.5),
        ("step(0) + step(x) + step(-x)", 2.0),
        ("min(y, x, 5) + max(y, x)", 9.0),
        ("abs(x - y)", 5.0),
        ("pow(x, 10)", 1024.0),
        ("x^0", 1.0),
        ("y^-2", 1.0 / 49.0),
        ("tanh(0) + sin(0) + tan(0) + ln(1) + log10(1)", 0.0),
        ("  a\n * x\t", 6.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
    for (text, expected) in [
        ("cos(pi)", -1.0),
        ("exp(1)", std::f64::consts::E),
        ("sqrt(x)", 2f64.sqrt()),
        ("log10(1000)", 3.0),
        ("y^0.5 + y^-1.5", 7f64.sqrt() + 7f64.powf(-1.5)),
        ("x^0.3", 2f64.powf(0.3)),
        ("a^x", 9.0),
        ("tan(x)", 2f64.tan()),
    ] {
        assert!((value(text) - expected).abs() < 1e-14 * expected.abs(), "{text}: {}", value(text));
    }
}

#[test]
fn faults_are_shown_where_they_are() {
    for (text, expected) in [
        ("", "character 1: a value must follow, the expression ends here\n\n^"),
        ("1 +", "character 4: a value must follow, the expression ends here\n1 +\n   ^"),
        ("4*(1 - x", "character 3: this parenthesis must be closed\n4*(1 - x\n  ^"),
        ("sin(x", "character 4: this parenthesis must be closed\nsin(x\n   ^"),
        ("(x))", "character 4: this parenthesis closes none that is open\n(x))\n   ^"),
        ("2x", "character 2: an operator must come before this\n2x\n ^"),
        ("x 2", "character 3: an operator must come before this\nx 2\n  ^"),
        ("2 (x)", "character 3: an operator must come before this\n2 (x)\n  ^"),
        ("σ*(q + 1)", "character 1: unknown name, must be one of `x`, `y`, `a`, `sigma`, `pi`\nσ*(q + 1)\n^"),
        (
            "a*sine(x)",
            "character 3: unknown name, must be one of `abs`, `cos`, `exp`, `if`, `ln`, `log10`, `max`, `min`, `pow`, \
             `sin`, `sqrt`, `step`, `tan`, `tanh`\na*sine(x)\n  ^^^^",
        ),
        ("sin + 1", "character 1: `sin` is a function: its arguments must follow, sin(…)\nsin + 1\n^^^"),
        ("1 + pow(x)", "character 5: `pow` takes 2 arguments, not 1\n1 + pow(x)\n    ^^^^^^"),
        ("exp()", "character 1: `exp` takes 1 argument, not 0\nexp()\n^^^^^"),
        ("max(x)", "character 1: `max` takes at least 2 arguments, not 1\nmax(x)\n^^^^^^"),
        ("x ** 2", "character 3: a power is written with ^\nx ** 2\n  ^^"),
        ("x == y", "character 3: unexpected `=`: comparisons are <, <=, > and >=\nx == y\n  ^"),
        ("0 < x < y", "character 7: comparisons must not follow one another\n0 < x < y\n      ^"),
        ("x && y", "character 3: unexpected `&`\nx && y\n  ^"),
        ("x, y", "character 2: a comma only separates the arguments of a function\nx, y\n ^"),
        ("2*/x", "character 3: a value must come before `/`\n2*/x\n  ^"),
        ("sin(x,)", "character 7: a value must come before `)`\nsin(x,)\n      ^"),
        ("1e999", "character 1: must be a number that double precision can hold\n1e999\n^^^^^"),
        ("1 + .", "character 5: must be a number that double precision can hold\n1 + .\n    ^"),
        ("x # y", "character 3: unexpected `#`\nx # y\n  ^"),
    ] {
        assert_eq!(parse(text).unwrap_err().to_string(), expected, "{text}");
    }
    assert_eq!(parse("log(x)").unwrap_err().help.unwrap(), "the natural logarithm is ln, that to base ten log10");
    let Unknown { name, known } = *parse("sgima*x").unwrap_err().unknown.unwrap();
    assert_eq!((name.as_str(), known.contains(&"sigma".to_owned())), ("sgima", true));
    for deep in ["(".repeat(5000), "-".repeat(5000), "2^".repeat(5000), "sin(".repeat(5000)] {
        let error = parse(&deep).unwrap_err().to_string();
        assert!(error.contains("must not be nested deeper than 100 levels"), "{error}");
    }
}

#[test]
fn parameters_have_names_of_their_own_and_are_numbers() {
    let refused =
        |name: &str, number: f64| Expression::parse("x", &["x"], &named(&[(name, number)])).unwrap_err().to_string();
    assert_eq!(refused("2a", 1.0), "parameter 2a: must be named by letters, digits and underscores, a letter first");
    assert_eq!(refused("", 1.0), "parameter : must be named by letters, digits and underscores, a letter first");
    for taken in ["x", "sin", "pi"] {
        let expected = format!("parameter {taken}: must have another name: this one has a meaning already");
        assert_eq!(refused(taken, 1.0), expected);
    }
    assert_eq!(refused("a", f64::NAN), "parameter a: must be a finite number");
}

#[test]
fn long_expressions_take_few_registers() {
    let sum = (1..500).map(|k| format!("exp(-(x - {k})^2)*cos(y/{k})")).collect::<Vec<_>>().join(" + ");
    let mut expression = parse(&sum).unwrap();
    let slope = expression.derivative(expression.value(), 0, 1.0);
    assert!(expression.tape(expression.value()).is_ok() && expression.tape(slope).is_ok());
    // Each level keeps its sine until the cosine of all that is inside is known.
    let nested = |levels: usize| (0..levels).fold("x".to_owned(), |inner, k| format!("sin(x + {k}) - cos({inner})"));
    let shallow = parse(&nested(20)).unwrap();
    assert!(shallow.tape(shallow.value()).is_ok());
    let deep = parse(&nested(50)).unwrap();
    let error = deep.tape(deep.value()).unwrap_err().to_string();
    assert!(error.starts_with("needs more than 32 intermediate results at once"), "{error}");
}

#[test]
fn equal_parts_are_worked_out_once_and_numbers_beforehand() {
    let count = |text: &str| {
        let expression = parse(text).unwrap();
        expression.tape(expression.value()).unwrap().length()
    };
    assert_eq!(count("exp(x) + exp(x)"), 2);
    assert_eq!(count("exp(x*y)*exp(y*x)"), 3);
    assert_eq!(count("(2*3 + a)*x"), 2, "a number and a product");
    assert_eq!(count("x^12 - x^6"), 5, "x², x³, x⁶, x¹², difference");
    // Groot and Warren's force: 1 and 1 − r, a and a (1 − r).
    let mut soft = Expression::parse("a/2*(1 - r)^2", &["r"], &named(&[("a", 25.0)])).unwrap();
    let force = soft.derivative(soft.value(), 0, -1.0);
    assert_eq!(soft.tape(force).unwrap().length(), 4);
}

/// An expression as a tree.
#[derive(Debug, Clone)]
enum Tree {
    Number(f64),
    Variable(usize),
    Call(&'static str, Vec<Tree>),
    Operator(char, Box<Tree>, Box<Tree>),
    Power(Box<Tree>, i32),
    Negative(Box<Tree>),
}

impl Tree {
    /// As one would type it, in parentheses only where they are needed.
    fn print(&self) -> String {
        let within =
            |tree: &Tree, level: u8| if tree.level() < level { format!("({})", tree.print()) } else { tree.print() };
        match self {
            Self::Number(value) => format!("{value:?}"),
            Self::Variable(index) => ["x", "y"][*index].to_owned(),
            Self::Call(name, arguments) => {
                format!("{name}({})", arguments.iter().map(Self::print).collect::<Vec<_>>().join(", "))
            }
            Self::Operator(symbol, a, b) => {
                format!("{} {symbol} {}", within(a, self.level()), within(b, self.level() + 1))
            }
            Self::Power(base, n) => format!("{}^{n}", within(base, 5)),
            Self::Negative(inner) => format!("-{}", within(inner, 3)),
        }
    }

    fn level(&self) -> u8 {
        match self {
            Self::Operator('+' | '-', ..) => 1,
            Self::Operator(..) => 2,
            Self::Negative(_) => 3,
            Self::Power(..) => 4,
            _ => 5,
        }
    }

    /// Its value by the same elementary functions, without graph or tape.
    fn value(&self, at: [f64; 2]) -> f64 {
        use operation::{Unary, choose};
        let value = |tree: &Tree| tree.value(at);
        match self {
            Self::Number(number) => *number,
            Self::Variable(index) => at[*index],
            Self::Operator('+', a, b) => value(a) + value(b),
            Self::Operator('-', a, b) => value(a) - value(b),
            Self::Operator('*', a, b) => value(a) * value(b),
            Self::Operator(_, a, b) => value(a) / value(b),
            Self::Power(base, n) => power(value(base), *n),
            Self::Negative(inner) => -value(inner),
            Self::Call(name, arguments) => {
                let x: Vec<f64> = arguments.iter().map(value).collect();
                match *name {
                    "sin" => Unary::Sine.of(x[0]),
                    "cos" => Unary::Cosine.of(x[0]),
                    "exp" => Unary::Exponential.of(x[0]),
                    "tanh" => Unary::HyperbolicTangent.of(x[0]),
                    "sqrt" => Unary::SquareRoot.of(x[0]),
                    "ln" => Unary::Logarithm.of(x[0]),
                    "abs" => x[0].abs(),
                    "step" => f64::from(u8::from(!(x[0] < 0.0))),
                    "min" => {
                        if x[1] < x[0] {
                            x[1]
                        } else {
                            x[0]
                        }
                    }
                    "max" => {
                        if x[0] < x[1] {
                            x[1]
                        } else {
                            x[0]
                        }
                    }
                    _ => choose(x[0], x[1], x[2]),
                }
            }
        }
    }
}

fn power(x: f64, n: i32) -> f64 {
    match n {
        ..0 => 1.0 / power(x, -n),
        0 => 1.0,
        1 => x,
        _ if n % 2 == 0 => power(x, n / 2) * power(x, n / 2),
        _ => power(x, n - 1) * x,
    }
}

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        prop_oneof![Just(0.0), Just(1.0), Just(2.0), 0.1..10.0].prop_map(Tree::Number),
        (0..2usize).prop_map(Tree::Variable),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let one = prop::sample::select(vec!["sin", "cos", "exp", "tanh", "sqrt", "ln", "abs", "step"]);
        let two = prop::sample::select(vec!["min", "max"]);
        prop_oneof![
            4 => (prop::sample::select(vec!['+', '-', '*', '/']), inner.clone(), inner.clone())
                .prop_map(|(symbol, a, b)| Tree::Operator(symbol, Box::new(a), Box::new(b))),
            2 => (one, inner.clone()).prop_map(|(name, x)| Tree::Call(name, vec![x])),
            1 => (two, inner.clone(), inner.clone()).prop_map(|(name, x, y)| Tree::Call(name, vec![x, y])),
            1 => (inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(c, x, y)| Tree::Call("if", vec![c, x, y])),
            1 => (inner.clone(), -5..13i32).prop_map(|(x, n)| Tree::Power(Box::new(x), n)),
            1 => inner.prop_map(|x| Tree::Negative(Box::new(x))),
        ]
    })
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_is_printed_is_read_and_valued_alike(tree in tree(), x in -3.0..3.0, y in -3.0..3.0) {
        let text = tree.print();
        let expression = parse(&text).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let Ok(tape) = expression.tape(expression.value()) else { return Ok(()) };
        let (found, expected) = (tape.value(&[x, y]), tree.value([x, y]));
        prop_assert!(same(found, expected), "{} at {x}, {y}: {found} for {expected}", text);
    }

    #[test]
    fn every_set_of_instructions_gives_the_bits_of_single_numbers(tree in tree(), seed in 0.0..1.0f64) {
        let mut expression = parse(&tree.print()).unwrap();
        let slope = expression.derivative(expression.value(), 0, -1.0);
        let Ok(tape) = expression.tape(slope) else { return Ok(()) };
        let mut variables = [BlockNumbers::default(); 2];
        for s in 0..8 {
            for k in 0..8 {
                variables[0][s][k] = 3.0 * (seed + 0.37 * (8 * s + k) as f64).sin();
                variables[1][s][k] = 3.0 * (seed - 0.53 * (8 * s + k) as f64).cos();
            }
        }
        for set in InstructionSet::available() {
            let mut values = BlockNumbers::default();
            set.run(Fill { tape: &tape, streams: 8, variables: &variables, values: &mut values });
            for s in 0..8 {
                for k in 0..8 {
                    let expected = tape.value(&[variables[0][s][k], variables[1][s][k]]);
                    prop_assert!(same(values[s][k], expected), "{set:?}: {} for {expected}", values[s][k]);
                }
            }
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[-+*/^(),.<>=a-z0-9 σ]{0,40}") {
        let _ = parse(&text);
    }
}

#[test]
fn derivatives_are_those_of_finite_differences() {
    for text in [
        "x*y + x/y - y/x + 3 - x",
        "x^5 - x^-3 + x^0.5 + x^-2.5",
        "x^1.3 + x^y + 2^x + y^(x*y)",
        "sin(x*y) + cos(x)^2 + tan(x/2) + tanh(x - y)",
        "exp(-x^2/y) + ln(x + y) + log10(x) + sqrt(x + y^2)",
        "abs(x - 5) + abs(x)*y + min(x, y, 9) + max(x, y)*x",
        "if(x < y, x^3, y^3) + step(x - 0.5)*x^2 + (x < y)*x*y + (x >= y)*sin(x)",
        "-(x*y)^2/(-x - y)",
        "a",
    ] {
        let mut expression = parse(text).unwrap();
        let value = expression.value();
        for variable in 0..2 {
            let first = expression.derivative(value, variable, 1.0);
            let second = expression.derivative(first, 1 - variable, -0.5);
            let tapes = [value, first, second].map(|function| expression.tape(function).unwrap());
            for k in 0..50 {
                let at = [0.7 + 0.031 * f64::from(k), 2.3 - 0.029 * f64::from(k)];
                // Central differences of sixth order.
                let slope = |output: usize, axis: usize| {
                    let h = 1e-3;
                    let shifted = |steps: f64| {
                        let mut at = at;
                        at[axis] += steps * h;
                        tapes[output].value(&at)
                    };
                    let difference = |steps: f64| shifted(steps) - shifted(-steps);
                    (45.0 * difference(1.0) - 9.0 * difference(2.0) + difference(3.0)) / (60.0 * h)
                };
                // At the kink itself there is no derivative.
                if (at[0] - at[1]).abs() < 4e-3 {
                    continue;
                }
                let [found, mixed] = [tapes[1].value(&at), tapes[2].value(&at)];
                let (expected, size) = (slope(0, variable), 1.0 + found.abs());
                assert!((found - expected).abs() < 1e-9 * size, "{text} at {at:?}: {found} for {expected}");
                let (expected, size) = (-0.5 * slope(1, 1 - variable), 1.0 + mixed.abs());
                assert!((mixed - expected).abs() < 1e-9 * size, "{text} at {at:?}: mixed {mixed} for {expected}");
            }
        }
    }
}
