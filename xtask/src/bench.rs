//! `cargo xtask bench`: builds the benchmark in release mode and calls it.

use std::process::Command;

use crate::failure::Failure;
use crate::workspace::Workspace;

/// Builds `mesoflux-bench` and hands it the arguments; it knows its options itself.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<(), Failure> {
    let build = ["build", "--release", "--package", "mesoflux-bench"];
    let failed = |error: std::io::Error| Failure::task(format!("could not start cargo: {error}"));
    let built = workspace.cargo().args(build).status().map_err(failed)?;
    if !built.success() {
        return Err(Failure::task(format!("the benchmark could not be built: cargo {}", build.join(" "))));
    }
    let program = workspace.target.join("release").join(format!("mesoflux-bench{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(&program);
    if !arguments.iter().any(|argument| argument.starts_with("--inputs")) {
        command.arg("--inputs").arg(workspace.root.join("benches"));
    }
    command.args(arguments);
    let status = command.status().map_err(|error| Failure::file(&program, &error))?;
    if status.success() {
        return Ok(());
    }
    let code = status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1);
    Err(Failure { message: format!("the benchmark stopped ({status})"), code })
}
