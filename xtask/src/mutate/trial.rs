//! One mutation tried: the copy is broken, built, and the named tests are run.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::header::Mutation;
use crate::failure::Failure;
use crate::process::{self, Ending};

/// What came of one test under one mutation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The test noticed: the only good verdict.
    Red,
    /// The test passed although the code is broken.
    StillGreen,
    /// The test did not end within its time.
    Hangs,
    /// The patch does not fit the code any more, or changes nothing.
    DoesNotApply,
    /// The broken code does not compile.
    DoesNotCompile,
    /// The test ran with neither result, or did not run.
    DidNotRun,
    /// The code does not compile without the mutation, or there is no such package or target.
    DoesNotCompileUnmutated,
    /// The test does not exist.
    NoSuchTest,
    /// The name stands for several tests, in different executables.
    SeveralTests,
    /// The test fails without the mutation.
    RedUnmutated,
    /// The test does not end within its time without the mutation.
    HangsUnmutated,
    /// An earlier mutation stopped the task.
    NotTried,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Red => "red",
            Self::StillGreen => "STILL GREEN",
            Self::Hangs => "HANGS",
            Self::DoesNotApply => "does not apply",
            Self::DoesNotCompile => "does not compile",
            Self::DidNotRun => "did not run",
            Self::DoesNotCompileUnmutated => "does not compile unmutated",
            Self::NoSuchTest => "no such test",
            Self::SeveralTests => "several tests of that name: give a target",
            Self::RedUnmutated => "red unmutated",
            Self::HangsUnmutated => "hangs unmutated",
            Self::NotTried => "not tried",
        })
    }
}

/// What one test did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It passed.
    Green,
    /// It failed, or took its process down with it.
    Red,
    /// It did not end in time.
    Hangs,
    /// It was not found or nothing can be said.
    Unknown,
}

/// Runs cargo in the copy.
#[derive(Debug)]
pub struct Bench {
    /// The cargo to call.
    pub cargo: PathBuf,
    /// The directory of the copy.
    pub tree: PathBuf,
    /// Where the copy is built.
    pub target: PathBuf,
}

impl Bench {
    /// Whether the tests of the mutation's package and target compile.
    pub fn builds(&self, mutation: &Mutation, log: &Path) -> Result<bool, Failure> {
        Ok(run(self.cargo_test(mutation).arg("--no-run"), log, None)?.0.success())
    }

    /// The names of all tests of the mutation's package and target; `None` where they do not compile.
    pub fn list(&self, mutation: &Mutation, log: &Path) -> Result<Option<Vec<String>>, Failure> {
        if !self.builds(mutation, log)? {
            return Ok(None);
        }
        let (_, output) = run(self.cargo_test(mutation).args(["--", "--list"]), log, Some(mutation.timeout))?;
        Ok(Some(output.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_string).collect()))
    }

    /// Runs one test, whether marked as ignored or not.
    pub fn run_test(&self, mutation: &Mutation, test: &str, log: &Path) -> Result<Outcome, Failure> {
        let mut command = self.cargo_test(mutation);
        command.args(["--", "--include-ignored", "--exact", test]);
        let (ending, output) = run(&mut command, log, Some(mutation.timeout))?;
        Ok(judge(&ending, &output))
    }

    /// `cargo test` for the mutation's package and target.
    fn cargo_test(&self, mutation: &Mutation) -> Command {
        let mut command = Command::new(&self.cargo);
        command.current_dir(&self.tree);
        command.env("CARGO_TARGET_DIR", &self.target).env("CARGO_TERM_COLOR", "never");
        command.args(["test", "--package", &mutation.package]).args(&mutation.target);
        command
    }
}

/// Runs a command into the log; that it cannot be run at all ends the task.
pub fn run(command: &mut Command, log: &Path, limit: Option<Duration>) -> Result<(Ending, String), Failure> {
    process::run(command, log, limit)
        .map_err(|error| Failure::task(format!("could not run {}: {error}", command.get_program().display())))
}

/// What the test harness said about a single test.
fn judge(ending: &Ending, output: &str) -> Outcome {
    let Ending::Exited(status) = ending else {
        return Outcome::Hangs;
    };
    let count = |what: &str| -> usize { output.lines().filter_map(|line| count_of(line, what)).sum() };
    let began = output.lines().any(|line| line == "running 1 test");
    match (status.success(), count("passed"), count("failed")) {
        (true, 1, 0) => Outcome::Green,
        (false, 0, 1) => Outcome::Red,
        // Without a closing line the test has ended its own process: a stack overflow, an abort, an exit.
        (false, 0, 0) if began => Outcome::Red,
        _ => Outcome::Unknown,
    }
}

/// The number before the word in a closing line such as `test result: ok. 1 passed; 0 failed; …`.
fn count_of(line: &str, what: &str) -> Option<usize> {
    let counts = line.strip_prefix("test result: ")?.split_once(". ")?.1;
    counts.split("; ").find_map(|part| part.strip_suffix(what)?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_lines_are_counted() {
        let line = "test result: FAILED. 0 passed; 1 failed; 0 ignored; 0 measured; 7 filtered out; finished in 0.00s";
        assert_eq!(count_of(line, "passed"), Some(0));
        assert_eq!(count_of(line, "failed"), Some(1));
        assert_eq!(count_of("test a ... ok", "passed"), None);
    }

    #[cfg(unix)]
    #[test]
    fn a_test_is_red_only_when_it_ran() {
        use std::os::unix::process::ExitStatusExt;
        use std::process::ExitStatus;
        let passed = Ending::Exited(ExitStatus::from_raw(0));
        let failed = Ending::Exited(ExitStatus::from_raw(101 << 8));
        let closing =
            |passed, failed| format!("running 1 test\ntest result: x. {passed} passed; {failed} failed; 0 ignored");
        assert_eq!(judge(&passed, &closing(1, 0)), Outcome::Green);
        assert_eq!(judge(&failed, &closing(0, 1)), Outcome::Red);
        assert_eq!(judge(&failed, "running 1 test\nerror: test failed\n"), Outcome::Red);
        assert_eq!(judge(&failed, "error: could not compile\n"), Outcome::Unknown);
        assert_eq!(judge(&passed, &closing(0, 0)), Outcome::Unknown);
        assert_eq!(judge(&Ending::TimedOut, "running 1 test\n"), Outcome::Hangs);
    }
}
