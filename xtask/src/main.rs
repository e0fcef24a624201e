//! The tasks of the workspace: what people and continuous integration type as `cargo xtask TASK`.

use std::env;
use std::process::ExitCode;

mod bench;
mod failure;
mod help;
mod mutate;
mod process;
mod table;
mod test;
mod workspace;

use failure::Failure;
use workspace::Workspace;

fn main() -> ExitCode {
    let arguments: Vec<String> =
        env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect();
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            ExitCode::from(failure.code)
        }
    }
}

/// Runs the task that the first argument names with the arguments after it.
fn dispatch(arguments: &[String]) -> Result<(), Failure> {
    let Some((task, rest)) = arguments.split_first() else {
        return Err(Failure::usage(format!("which task?\n\n{}", help::TEXT)));
    };
    if rest.iter().any(|argument| argument == "--help" || argument == "-h") {
        print!("{}", help::TEXT);
        return Ok(());
    }
    match task.as_str() {
        "test" => test::run(&Workspace::find()?, rest),
        "bench" => bench::run(&Workspace::find()?, rest),
        "mutate" => mutate::run(&Workspace::find()?, rest),
        "help" | "--help" | "-h" => {
            print!("{}", help::TEXT);
            Ok(())
        }
        unknown => Err(Failure::usage(help::unknown("task", unknown, &help::TASKS))),
    }
}
