//! `mesoflux resume DIR`.

use super::session::{Failure, INPUT, Options, perform_in};
use clap::Args;
use mesoflux_io::directory::OutputDirectory;
use mesoflux_io::input::{Input, InputFile, Setting};
use std::path::PathBuf;

/// Arguments of `resume`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The directory of the run
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Make the run longer: --set run.production_time=TIME; nothing else may change
    #[arg(long = "set", value_name = "PATH=VALUE")]
    settings: Vec<Setting>,
    #[command(flatten)]
    options: Options,
}

pub(super) fn resume(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.directory.join(INPUT);
    let before = InputFile::read(&path, &[])?;
    let file = InputFile::read(&path, &arguments.settings)?;
    check_extension(&before.input, &file.input)?;
    let directory = OutputDirectory::explicit(&arguments.directory, true)?;
    if !arguments.settings.is_empty() {
        directory.write(INPUT, file.text().as_bytes())?;
    }
    perform_in(&directory, &file, &arguments.options)
}

/// A run may become longer; anything else would make its states those of another run.
fn check_extension(before: &Input, after: &Input) -> Result<(), Failure> {
    let (old, new) = (before.run.production_time, after.run.production_time);
    if new < old {
        return Err(Failure::Refused(format!("run.production_time = {new}: must be at least {old}, as the run began")));
    }
    let mut same = after.clone();
    same.run.production_time = old;
    same.run.checkpoint_interval = before.run.checkpoint_interval;
    same.run.checkpoint_wall_seconds = before.run.checkpoint_wall_seconds;
    if same == *before {
        return Ok(());
    }
    let changed = difference(before, &same).unwrap_or_else(|| "the input".to_owned());
    Err(Failure::Refused(format!(
        "{changed} differs from the run's own input: only run.production_time and the checkpoints' cadence may change; start a new run for anything else"
    )))
}

/// The path of the first key in which two inputs differ.
fn difference(before: &Input, after: &Input) -> Option<String> {
    fn first(prefix: &str, a: &toml::Value, b: &toml::Value) -> Option<String> {
        match (a, b) {
            (toml::Value::Table(a), toml::Value::Table(b)) => a.keys().chain(b.keys()).find_map(|key| {
                let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                match (a.get(key), b.get(key)) {
                    (Some(a), Some(b)) => first(&path, a, b),
                    _ => Some(path),
                }
            }),
            _ => (a != b).then(|| prefix.to_owned()),
        }
    }
    first("", &toml::Value::try_from(before).ok()?, &toml::Value::try_from(after).ok()?)
}
