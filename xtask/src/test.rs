//! `cargo xtask test`: everything that must hold before a change is good, in one command.

use std::borrow::Cow;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::help;
use crate::table;
use crate::workspace::Workspace;

/// One cargo command that must succeed.
struct Step {
    /// Its name in the header and in the summary.
    name: &'static str,
    /// An environment variable that it needs.
    environment: Option<(&'static str, Cow<'static, str>)>,
    /// The arguments after `cargo`.
    arguments: &'static [&'static str],
}

const FORMATTING: Step = Step { name: "formatting", environment: None, arguments: &["fmt", "--all", "--", "--check"] };
const LINTS: Step = Step {
    name: "lints",
    environment: None,
    arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
};
const DOCUMENTATION: Step = Step {
    name: "documentation",
    environment: Some(("RUSTDOCFLAGS", Cow::Borrowed("-D warnings"))),
    arguments: &["doc", "--workspace", "--no-deps"],
};
/// Unit, integration and documentation tests in the `test` profile, which is optimized: one build serves them all.
const TESTS: Step = Step { name: "tests", environment: None, arguments: &["test", "--workspace"] };
const UNIT_TESTS: Step =
    Step { name: "unit tests", environment: None, arguments: &["test", "--workspace", "--lib", "--bins"] };

const EVERYTHING: &[Step] = &[FORMATTING, LINTS, DOCUMENTATION, TESTS];
const QUICK: &[Step] = &[FORMATTING, LINTS, UNIT_TESTS];

/// The physics tests with many seeds in place of one: their z-scores must look like normal deviates.
fn over_seeds_step(count: &str) -> Step {
    Step {
        name: "physics over seeds",
        environment: Some(("MESOFLUX_SEEDS", Cow::Owned(count.to_string()))),
        arguments: &["test", "--package", "mesoflux-core", "--tests"],
    }
}

impl Step {
    /// The command as a person would type it.
    fn as_typed(&self) -> String {
        let environment = self.environment.as_ref();
        let environment = environment.map_or_else(String::new, |(name, value)| format!("{name}=\"{value}\" "));
        format!("{environment}cargo {}", self.arguments.join(" "))
    }

    /// Runs the step; its output goes straight through.
    fn run(&self, workspace: &Workspace) -> Result<ExitStatus, Failure> {
        let mut command = workspace.cargo();
        command.args(self.arguments).envs(self.environment.iter().map(|(name, value)| (name, value.as_ref())));
        command.status().map_err(|error| Failure::task(format!("could not start `{}`: {error}", self.as_typed())))
    }
}

/// Runs the steps in order and stops at the first that fails. Everything of our own goes to standard error,
/// so that standard output is that of the tests alone.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<(), Failure> {
    let over_seeds;
    let steps = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => EVERYTHING,
        ["--quick"] => QUICK,
        ["--seeds", count] if count.parse::<u32>().is_ok_and(|count| count > 1) => {
            over_seeds = [over_seeds_step(count)];
            &over_seeds
        }
        ["--seeds", ..] => return Err(Failure::usage("`--seeds` takes how many seeds to try, at least 2".to_string())),
        [other, ..] => {
            return Err(Failure::usage(help::unknown("option of `test`", other, &["--quick", "--seeds"])));
        }
    };
    install_components(workspace)?;
    let mut times = Vec::new();
    for step in steps {
        eprintln!("\n==> {}: {}", step.name, step.as_typed());
        let begin = Instant::now();
        let status = step.run(workspace)?;
        times.push(begin.elapsed());
        if !status.success() {
            eprint!("\n{}", summary(steps, &times, false));
            let message = format!("{} failed ({status}); rerun only that: {}", step.name, step.as_typed());
            return Err(Failure { message, code: exit_code(status) });
        }
        eprintln!("==> {} passed in {:.1} s", step.name, times[times.len() - 1].as_secs_f64());
    }
    eprint!("\n{}", summary(steps, &times, true));
    Ok(())
}

/// A table of the steps; the last one that ran has failed unless all passed.
fn summary(steps: &[Step], times: &[Duration], passed: bool) -> String {
    let row = |(place, step): (usize, &Step)| {
        let result = match times.len().cmp(&(place + 1)) {
            std::cmp::Ordering::Less => "not run",
            std::cmp::Ordering::Equal if !passed => "FAILED",
            _ => "passed",
        };
        let seconds = times.get(place).map_or_else(String::new, |time| format!("{:.1}", time.as_secs_f64()));
        vec![step.name.to_string(), result.to_string(), seconds]
    };
    let mut rows: Vec<Vec<String>> = steps.iter().enumerate().map(row).collect();
    let total: Duration = times.iter().sum();
    let verdict = if passed { "passed" } else { "FAILED" };
    rows.push(vec!["all".into(), verdict.into(), format!("{:.1}", total.as_secs_f64())]);
    table::markdown(&["step", "result", "seconds"], &rows)
}

/// The exit code to hand on; a step that a signal ended counts as failed with 128 and the signal's number.
fn exit_code(status: ExitStatus) -> u8 {
    #[cfg(unix)]
    let signal = std::os::unix::process::ExitStatusExt::signal(&status).map(|signal| 128 + signal);
    #[cfg(not(unix))]
    let signal = None;
    status.code().or(signal).and_then(|code| u8::try_from(code).ok()).unwrap_or(1)
}

/// Installs the formatter and the linter where the toolchain came without them.
fn install_components(workspace: &Workspace) -> Result<(), Failure> {
    for (subcommand, component) in [("fmt", "rustfmt"), ("clippy", "clippy")] {
        if answers(workspace.cargo().args([subcommand, "--version"])) {
            continue;
        }
        eprintln!("==> `cargo {subcommand}` is missing: rustup component add {component}");
        let installed = Command::new("rustup").args(["component", "add", component]).stdin(Stdio::null()).status();
        let reason = match installed {
            Ok(status) if status.success() && answers(workspace.cargo().args([subcommand, "--version"])) => continue,
            Ok(status) => format!("`rustup component add {component}` did not help ({status})"),
            Err(error) => format!("rustup could not be started ({error})"),
        };
        return Err(Failure::task(format!(
            "`cargo {subcommand}` is missing and {reason}; install {component} for this Rust toolchain \
             the way the toolchain itself was installed, then run this again"
        )));
    }
    Ok(())
}

/// Whether the command can be run at all.
fn answers(command: &mut Command) -> bool {
    command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_tells_passed_from_failed_from_not_run() {
        let times = [Duration::from_millis(1500), Duration::from_millis(500)];
        let text = summary(QUICK, &times, false);
        let results: Vec<&str> =
            text.lines().skip(2).filter_map(|line| line.split('|').nth(2)).map(str::trim).collect();
        assert_eq!(results, ["passed", "FAILED", "not run", "FAILED"]);
        assert!(text.lines().last().is_some_and(|line| line.contains("2.0")));
        assert!(!summary(QUICK, &times, true).contains("FAILED"));
    }

    #[test]
    fn a_step_prints_as_it_would_be_typed() {
        assert_eq!(DOCUMENTATION.as_typed(), "RUSTDOCFLAGS=\"-D warnings\" cargo doc --workspace --no-deps");
        assert_eq!(LINTS.as_typed(), "cargo clippy --workspace --all-targets -- -D warnings");
    }
}
