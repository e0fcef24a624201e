//! `mesoflux run INPUT.toml`.

use super::session::{Failure, INPUT, Options, STATES, Workplace, named_files, perform_in, planned};
use clap::Args;
use mesoflux_io::directory::OutputDirectory;
use mesoflux_io::input::{InputFile, Setting};
use std::path::PathBuf;

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The input file
    #[arg(value_name = "INPUT.toml")]
    input: PathBuf,
    /// Directory for the results [default: a new one named after the input]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the run in the directory of --out
    #[arg(long, requires = "out")]
    force: bool,
    /// Seed of all noise, in place of run.seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Set a key of the input, e.g. --set pair.all.friction.linear.coefficient=40.5; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    settings: Vec<Setting>,
    #[command(flatten)]
    options: Options,
}

pub(super) fn run(arguments: Arguments) -> Result<(), Failure> {
    let mut settings = arguments.settings;
    settings.extend(arguments.seed.map(|seed| Setting { path: "run.seed".into(), value: seed.to_string() }));
    let file = InputFile::read(&arguments.input, &settings)?;
    let plan = planned(&file, &arguments.options)?;
    // Before anything of an earlier run is removed: it may be what this one starts from.
    let start = named_files(&file)?;
    let workplace = match &arguments.out {
        Some(wanted) => {
            // Only a run's own directory, or an empty one, may be written into: --force is no license to mix with other things.
            let foreign = wanted.exists() && ![INPUT, STATES].iter().any(|name| wanted.join(name).exists());
            if arguments.force && foreign && std::fs::read_dir(wanted).is_ok_and(|mut entries| entries.next().is_some())
            {
                let place = wanted.display();
                return Err(Failure::Refused(format!(
                    "--out {place}: holds something that is no run of mesoflux; must be new, empty, or a run's directory"
                )));
            }
            let workplace = Workplace::open(OutputDirectory::explicit(wanted, arguments.force)?)?;
            workplace.clear()?;
            workplace
        }
        None => Workplace::open(OutputDirectory::named_after(&arguments.input)?)?,
    };
    workplace.keep_files(&start)?;
    workplace.write_input(&file)?;
    perform_in(&workplace, &file, &plan, &arguments.options)?;
    Ok(())
}
