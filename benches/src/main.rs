//! Benchmarks of mesoflux: against LAMMPS on the same work, kernel by kernel, over sizes, and between its own routes.
//!
//! `cargo xtask bench` builds this in release mode and calls it. Each timing is a process of its own: the program calls itself.

mod agreement;
mod child;
mod comparison;
mod failure;
mod kernels;
mod lammps;
mod machine;
mod options;
mod ours;
mod report;
mod scale;
mod session;
mod setup;
mod statistics;
mod store;
// The same tables as those of the other tasks, which has to stay free of dependencies.
#[path = "../../xtask/src/table.rs"]
mod table;
mod task;
mod work;

use clap::Parser;
use options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    let options = Options::parse();
    let result = match &options.child {
        Some(task) => child::perform(task),
        None => session::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("bench: {failure}");
            ExitCode::from(failure.code())
        }
    }
}
