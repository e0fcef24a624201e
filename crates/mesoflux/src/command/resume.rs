//! `mesoflux resume DIR`.

use super::session::{Failure, INPUT, Options, Outcome, START, STATES, Workplace, perform_in, planned, shell_word};
use clap::Args;
use mesoflux_io::directory::OutputDirectory;
use mesoflux_io::input::{Files, Input, InputFile, Setting};
use std::path::{Path, PathBuf};

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
    let directory = &arguments.directory;
    check_is_run(directory)?;
    let workplace = Workplace::open(OutputDirectory::explicit(directory, true)?)?;
    let asked = directory.join(INPUT);
    let recorded = directory.join(STATES).join(INPUT);
    let read = |path: &Path, settings: &[Setting]| {
        InputFile::read_with(path, settings, Files::kept_in(&directory.join(START)))
    };
    // Killed before it was written down among the states, the input has no states yet.
    let recorded = read(if recorded.exists() { &recorded } else { &asked }, &[])?;
    let mut settings = arguments.settings.clone();
    let mut file = read(&asked, &settings)?;
    let longer = file.input.run.production_time > recorded.input.run.production_time;
    if longer {
        settings.extend(lags_as_begun(&recorded.input, &file.input));
        file = read(&asked, &settings)?;
    }
    check_extension(&recorded, &file)?;
    let plan = planned(&file, &arguments.options)?;
    if longer {
        workplace.remove_results()?;
    }
    if file.text() != recorded.text() || !settings.is_empty() {
        workplace.write_input(&file)?;
    }
    if perform_in(&workplace, &file, &plan, &arguments.options)? == Outcome::NothingToDo {
        let directory = shell_word(directory);
        let time = file.input.run.production_time;
        arguments.options.remark(&format!(
            "the run in {directory} was complete already; to make it longer than {time}: mesoflux resume {directory} --set run.production_time=TIME"
        ));
    }
    Ok(())
}

/// A directory that `run` has made and that came to its input.
fn check_is_run(directory: &Path) -> Result<(), Failure> {
    let lacks = |reason: String| Failure::NoRun { directory: directory.display().to_string(), reason };
    if !directory.exists() {
        return Err(lacks("does not exist; must be the directory of a run".to_owned()));
    }
    for name in [INPUT, STATES] {
        if !directory.join(name).exists() {
            return Err(lacks(format!("holds no {name}; must be the directory of a run")));
        }
    }
    Ok(())
}

/// Lags that follow from the production time where none is given: an extended run keeps those it began with, and its input says so.
fn lags_as_begun(before: &Input, asked: &Input) -> Vec<Setting> {
    let lag = |(name, measure): (&String, &mesoflux_io::input::MeasureInput)| {
        let begun = measure.quantity.default_routes(&measure.routes).msd?;
        let now = asked.measure.get(name)?;
        let now = now.quantity.default_routes(&now.routes).msd?;
        (begun.longest_lag.is_none() && now.longest_lag.is_none()).then(|| Setting {
            path: format!("measure.{name}.routes.msd.longest_lag"),
            value: format!("{:?}", begun.longest_lag(before.run.production_time)),
        })
    };
    before.measure.iter().filter_map(lag).collect()
}

/// A run may become longer; anything else would make its states those of another run.
fn check_extension(recorded: &InputFile, asked: &InputFile) -> Result<(), Failure> {
    let (before, after) = (&recorded.input, &asked.input);
    let (old, new) = (before.run.production_time, after.run.production_time);
    let swept = asked.sweep.points.iter().any(|point| point.values.contains_key("run.production_time"));
    if new != old && swept {
        return Err(Failure::Refused(
            "run.production_time: is swept, and only one for all points can become longer; start a new run".to_owned(),
        ));
    }
    if new < old {
        return Err(Failure::Refused(format!("run.production_time = {new}: must be at least {old}, as the run began")));
    }
    let (mut before, mut after) = (before.clone(), after.clone());
    for input in [&mut before, &mut after] {
        input.run.production_time = new;
        input.run.checkpoint_interval = None;
        input.run.checkpoint_wall_seconds = 1.0;
    }
    // Made explicit above, a lag that followed from the shorter time is no change.
    for (name, measure) in &mut after.measure {
        let begun = before.measure.get(name).map(|begun| begun.quantity.default_routes(&begun.routes));
        if let (Some(msd), Some(begun)) = (&mut measure.routes.msd, begun.and_then(|routes| routes.msd))
            && begun.longest_lag.is_none()
            && msd.longest_lag == Some(begun.longest_lag(old))
        {
            msd.longest_lag = None;
        }
        measure.routes = measure.quantity.default_routes(&measure.routes);
    }
    for measure in before.measure.values_mut() {
        measure.routes = measure.quantity.default_routes(&measure.routes);
    }
    if before == after {
        return Ok(());
    }
    let changed = difference(&before, &after).unwrap_or_else(|| "the input is not what it was".to_owned());
    Err(Failure::Refused(format!(
        "{changed} when the run began: only run.production_time may grow and the checkpoints' cadence change; start a new run for anything else"
    )))
}

/// The first key in which two inputs differ, with its values.
fn difference(before: &Input, after: &Input) -> Option<String> {
    fn first(path: &str, a: Option<&toml::Value>, b: Option<&toml::Value>) -> Option<String> {
        if let (Some(toml::Value::Table(a)), Some(toml::Value::Table(b))) = (a, b) {
            return a.keys().chain(b.keys()).find_map(|key| {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                first(&path, a.get(key), b.get(key))
            });
        }
        let shown = |value: Option<&toml::Value>| value.map_or("absent".to_owned(), ToString::to_string);
        (a != b).then(|| format!("{path} = {}: was {}", shown(b), shown(a)))
    }
    let table = |input| toml::Value::try_from(input).ok();
    first("", Some(&table(before)?), Some(&table(after)?))
}
