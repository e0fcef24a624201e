//! The command line of mesoflux.

use clap::Parser;
use mesoflux::command::Command;
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
            eprintln!("{failure}");
            ExitCode::from(failure.code())
        }
    }
}
