//! Why a benchmark stopped, and the exit code that says so.

use std::path::{Path, PathBuf};

/// A benchmark that could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line asks for something that isn't there.
    #[error("{0}")]
    Usage(String),
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of results holds something else.
    #[error("{}: not a file of results ({source}); move it away and run the benchmark again", path.display())]
    Content {
        /// Which.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A program that was to be timed failed.
    #[error("{program} failed: {reason}")]
    Program {
        /// Which.
        program: String,
        /// What it said.
        reason: String,
    },
    /// The input of a work is refused, or its simulation fails.
    #[error("{0}")]
    Simulation(String),
    /// Two programs that should do the same work give different physics.
    #[error("{0}")]
    Disagreement(String),
}

impl Failure {
    /// A file that could not be read or written.
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.to_owned(), source }
    }

    /// A program that failed.
    pub fn program(program: impl Into<String>, reason: String) -> Self {
        Self::Program { program: program.into(), reason }
    }

    /// A simulation that failed.
    #[expect(clippy::needless_pass_by_value, reason = "errors are handed over by `map_err`")]
    pub fn simulation(reason: impl ToString) -> Self {
        Self::Simulation(reason.to_string())
    }

    /// The exit code, as for all tasks of the workspace.
    pub fn code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::File { .. } | Self::Content { .. } => 4,
            Self::Program { .. } | Self::Simulation(_) | Self::Disagreement(_) => 1,
        }
    }
}
