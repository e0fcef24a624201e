//! Why a task stopped: what it says to the person, and its exit code.

use std::fmt;
use std::path::Path;

/// A task that could not succeed.
#[derive(Debug)]
pub struct Failure {
    /// One line (or a few) for the person.
    pub message: String,
    /// The exit code of the whole command.
    pub code: u8,
}

impl Failure {
    /// The command line or a mutation file is wrong: exit code 2.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 2 }
    }

    /// The task ran and did not succeed: exit code 1.
    pub fn task(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 1 }
    }

    /// A file or directory could not be read or written: exit code 4.
    pub fn file(path: &Path, error: &std::io::Error) -> Self {
        Self { message: format!("{}: {error}", path.display()), code: 4 }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}
