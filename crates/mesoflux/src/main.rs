//! The command line of mesoflux.

use clap::Parser;
use mesoflux::command::Command;
use std::io::Write;
use std::process::ExitCode;

/// Transport coefficients of mesoscopic fluids, each with its uncertainty.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    match Arguments::parse().command.execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Where the terminal is closed, there is nobody to tell.
            let _ = writeln!(std::io::stderr(), "{failure}");
            ExitCode::from(failure.code())
        }
    }
}
