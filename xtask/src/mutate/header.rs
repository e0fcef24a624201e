//! The comment lines at the beginning of a mutation: what it breaks, and which tests must notice.

use std::path::Path;
use std::time::Duration;

use crate::help;

/// How long one test may run where the header does not say.
const DEFAULT_TIMEOUT: Duration = Duration::from_mins(5);

/// The keys that a header may have; only `test` and `note` more than once.
const KEYS: [&str; 6] = ["what", "test", "package", "target", "timeout", "note"];

/// What the header of one mutation says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mutation {
    /// The file's name without its ending.
    pub name: String,
    /// What is broken, in a sentence.
    pub what: String,
    /// The cargo package that holds the tests.
    pub package: String,
    /// The cargo arguments that select the test executables.
    pub target: Vec<String>,
    /// The full names of the tests which must turn red, without the package.
    pub tests: Vec<String>,
    /// How long each of the tests may run.
    pub timeout: Duration,
}

impl Mutation {
    /// Reads the header of the patch `name` from the text of its file. The error says the line and what is required.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let (mut what, mut package, mut target, mut timeout) = (None, None, None, None);
        let mut tests = Vec::new();
        let mut difference = false;
        for (place, line) in text.lines().enumerate() {
            if line.starts_with("--- ") || line.starts_with("diff --git ") {
                difference = true;
                break;
            }
            let fail = |message: String| format!("line {}: {message}", place + 1);
            let Some(comment) = line.strip_prefix('#') else {
                if line.trim().is_empty() {
                    continue;
                }
                return Err(fail("before the diff there must be only lines such as `# what: …`".into()));
            };
            let (key, value) = comment
                .split_once(':')
                .map(|(key, value)| (key.trim(), value.trim()))
                .ok_or_else(|| fail("must be `# KEY: VALUE`".into()))?;
            if value.is_empty() {
                return Err(fail(format!("`{key}` must have a value")));
            }
            let once = match key {
                "test" => {
                    tests.push(value.to_string());
                    continue;
                }
                "note" => continue,
                "what" => &mut what,
                "package" => &mut package,
                "target" => &mut target,
                "timeout" => &mut timeout,
                unknown => return Err(fail(help::unknown("key", unknown, &KEYS))),
            };
            if once.replace(value.to_string()).is_some() {
                return Err(fail(format!("`{key}` must be given once")));
            }
        }
        if !difference || !text.lines().any(|line| line.starts_with("@@ ")) {
            return Err("there must be a unified diff after the header".into());
        }
        let missing = |key: &str| format!("a line `# {key}: …` is required");
        let package = package.ok_or_else(|| missing("package"))?;
        if tests.is_empty() {
            return Err(missing("test"));
        }
        let prefix = format!("{package}::");
        let tests = tests.iter().map(|test| test.strip_prefix(&prefix).unwrap_or(test).to_string()).collect();
        Ok(Self {
            name: name.to_string(),
            what: what.ok_or_else(|| missing("what"))?,
            target: parse_target(target.as_deref().unwrap_or("--tests"))?,
            timeout: timeout.as_deref().map_or(Ok(DEFAULT_TIMEOUT), parse_timeout)?,
            package,
            tests,
        })
    }

    /// Reads the mutation in the file; errors begin with the file's name.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Self::parse(&name, &text).map_err(|error| format!("{name}.patch: {error}"))
    }
}

/// The cargo arguments of a target, one of those that hold tests which run by name.
fn parse_target(value: &str) -> Result<Vec<String>, String> {
    let words: Vec<&str> = value.split_whitespace().collect();
    match words[..] {
        ["--lib" | "--bins" | "--tests"] | ["--bin" | "--test", _] => {
            Ok(words.iter().map(ToString::to_string).collect())
        }
        _ => Err(format!("target = {value}: must be --lib, --bins, --tests, --bin NAME or --test NAME")),
    }
}

/// A time limit in seconds.
fn parse_timeout(value: &str) -> Result<Duration, String> {
    let seconds = value.parse().ok().filter(|seconds| *seconds > 0);
    seconds
        .map(Duration::from_secs)
        .ok_or_else(|| format!("timeout = {value}: must be a whole number of seconds above 0"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "# what: the sign is wrong\n# test: my-crate::norton::sign\n# package: my-crate\n";
    const DIFFERENCE: &str = "--- a/src/lib.rs\n+++ b/src/lib.rs\n@@ -1 +1 @@\n-a\n+b\n";

    fn parse(header: &str) -> Result<Mutation, String> {
        Mutation::parse("sign", &format!("{header}{DIFFERENCE}"))
    }

    #[test]
    fn a_short_header_gets_the_defaults() {
        let expected = Mutation {
            name: "sign".into(),
            what: "the sign is wrong".into(),
            package: "my-crate".into(),
            target: vec!["--tests".into()],
            tests: vec!["norton::sign".into()],
            timeout: Duration::from_mins(5),
        };
        assert_eq!(parse(HEADER), Ok(expected));
    }

    #[test]
    fn a_full_header_says_everything() {
        let full = format!("{HEADER}# test: other\n# target: --test flows\n# timeout: 7\n# note: see eq. 3: sign\n\n");
        let mutation = parse(&full).unwrap();
        assert_eq!(mutation.tests, ["norton::sign", "other"]);
        assert_eq!(mutation.target, ["--test", "flows"]);
        assert_eq!(mutation.timeout, Duration::from_secs(7));
    }

    #[test]
    fn comments_inside_the_difference_are_not_header() {
        let text = format!("{HEADER}{DIFFERENCE}# unknown: key\n");
        assert!(Mutation::parse("sign", &text).is_ok());
    }

    #[test]
    fn every_mistake_is_named() {
        let cases = [
            ("# what: w\n# package: p\n", "a line `# test: …` is required"),
            ("# what: w\n# test: t\n", "a line `# package: …` is required"),
            ("# test: t\n# package: p\n", "a line `# what: …` is required"),
            ("# what: w\n# tset: t\n", "line 2: no key `tset`; did you mean test?"),
            ("# what: w\n# what: v\n", "line 2: `what` must be given once"),
            ("# what:\n", "line 1: `what` must have a value"),
            ("# a remark\n", "line 1: must be `# KEY: VALUE`"),
            ("what: w\n", "line 1: before the diff there must be only lines such as `# what: …`"),
            (
                "# what: w\n# test: t\n# package: p\n# target: --doc\n",
                "target = --doc: must be --lib, --bins, --tests, --bin NAME or --test NAME",
            ),
            (
                "# what: w\n# test: t\n# package: p\n# timeout: 0\n",
                "timeout = 0: must be a whole number of seconds above 0",
            ),
        ];
        for (header, message) in cases {
            assert_eq!(parse(header), Err(message.to_string()), "{header}");
        }
        assert_eq!(Mutation::parse("sign", HEADER), Err("there must be a unified diff after the header".into()));
    }
}
