//! The commands, one file each, and what they share: failures with their exit codes, and doing a job in a directory.

mod check;
mod reproduce;
mod resume;
mod run;
mod session;

pub use session::Failure;

use clap::Subcommand;

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run what an input file describes and measure what it asks for
    Run(run::Arguments),
    /// Go on with an interrupted run, to the same bits as without the interruption
    Resume(resume::Arguments),
    /// Check an input file and print what would run, the memory and the time it takes; nothing is written
    Check(check::Arguments),
    /// Rerun a published study and compare it with what was claimed, number by number
    #[command(after_help = reproduce::catalog())]
    Reproduce(reproduce::Arguments),
}

impl Command {
    /// Does it.
    ///
    /// # Errors
    /// Whatever keeps it from being done; the message is for a person, the code for a script.
    pub fn execute(self) -> Result<(), Failure> {
        match self {
            Self::Run(arguments) => run::run(arguments),
            Self::Resume(arguments) => resume::resume(&arguments),
            Self::Check(arguments) => check::check(&arguments),
            Self::Reproduce(arguments) => reproduce::reproduce(&arguments),
        }
    }
}
