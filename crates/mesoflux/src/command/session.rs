//! Doing a job in a directory: runs with kept states, results, tables, figures, and the way to go on after a stop.

use crate::answer::{Circumstances, answer};
use crate::job::{Conduct, JobError, perform};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::report;
use crate::store::{Cadence, Store};
use clap::Args;
use mesoflux_io::directory::{DirectoryError, OutputDirectory};
use mesoflux_io::input::{InputError, InputFile};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The directory of the runs' states within a run's directory.
pub(super) const STATES: &str = "states";
/// The results.
pub(super) const RESULTS: &str = "results.json";
/// The input as it was run, settings included.
pub(super) const INPUT: &str = "input.toml";

/// Options of everything that runs.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Threads to use [default: one for each core]; the results don't depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    threads: Option<u64>,
    /// Stop with a checkpoint after this wall time, e.g. 90s, 30m, 23h50m
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    max_wall: Option<Duration>,
    /// Print neither progress nor results
    #[arg(long)]
    quiet: bool,
    /// Print the results as JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Everything that can go wrong, by exit code.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The input is wrong or can't be read.
    #[error("{0}")]
    Input(#[from] InputError),
    /// The job failed.
    #[error("error: {0}")]
    Job(#[from] JobError),
    /// A file can't be written.
    #[error("error: {0}")]
    Directory(#[from] DirectoryError),
    /// Standard output can't be written.
    #[error("error: standard output: {0}")]
    Output(std::io::Error),
    /// The results can't be written as JSON.
    #[error("error: results.json: {0}")]
    Json(#[from] serde_json::Error),
    /// No signal handler could be set.
    #[error("error: signals: {0}")]
    Signals(std::io::Error),
    /// What is asked for doesn't fit what is there.
    #[error("error: {0}")]
    Refused(String),
    /// Stopped before the end; everything done is kept.
    #[error("stopped; to go on: mesoflux resume {0}")]
    Stopped(String),
}

impl Failure {
    /// 2: the input or the command line is wrong; 3: the simulation failed; 4: a file could not be read or written;
    /// 130: stopped, with checkpoints.
    pub fn code(&self) -> u8 {
        match self {
            Self::Input(InputError::Wrong(_))
            | Self::Directory(DirectoryError::Exists(_))
            | Self::Refused(_)
            | Self::Job(JobError::Setup { .. } | JobError::Threads(_) | JobError::Snapshot { .. }) => 2,
            Self::Job(JobError::Simulation { .. } | JobError::Route { .. }) => 3,
            Self::Input(InputError::Read { .. })
            | Self::Job(JobError::Store { .. })
            | Self::Directory(DirectoryError::Io { .. })
            | Self::Output(_)
            | Self::Json(_)
            | Self::Signals(_) => 4,
            Self::Stopped(_) => 130,
        }
    }
}

/// Does the job of an input in a directory, from whatever states are there.
pub(super) fn perform_in(directory: &OutputDirectory, file: &InputFile, options: &Options) -> Result<(), Failure> {
    let start = Instant::now();
    let plan = Plan::new(file)?;
    let states = OutputDirectory::explicit(&directory.path().join(STATES), true)?;
    let cadence = Cadence {
        steps: file.input.run.checkpoint_interval,
        wall: Duration::from_secs_f64(file.input.run.checkpoint_wall_seconds),
    };
    let store = Store::new(states, cadence);
    let threads = match options.threads {
        Some(threads) => threads as usize,
        None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
    };
    let steps = plan.tasks().iter().map(|task| plan.points[task.point].steps()).sum();
    let progress = Progress::new(steps, options.quiet);
    let stop = stop_at_signals()?;
    let deadline = options.max_wall.map(|wall| start + wall);
    let conduct = Conduct { threads, store: Some(&store), stop: &stop, deadline, progress: &progress };
    let finished = perform(&plan, &conduct);
    progress.finish();
    let circumstances = Circumstances { threads, wall_seconds: start.elapsed().as_secs_f64() };
    let answer = answer(&file.input, &plan, &finished?, circumstances)?;
    for (name, contents) in &answer.files {
        directory.write(name, contents.as_bytes())?;
    }
    let json = serde_json::to_string_pretty(&answer.results)? + "\n";
    directory.write(RESULTS, json.as_bytes())?;
    let mut text = String::new();
    if options.json {
        text = json;
    } else if !options.quiet {
        let place = directory.path().join(RESULTS);
        let seconds = circumstances.wall_seconds;
        text = report::table(&answer.results);
        text += &format!("\n{seconds:.1} s on {threads} threads; results in {}\n", place.display());
    }
    std::io::stdout().lock().write_all(text.as_bytes()).map_err(Failure::Output)?;
    if answer.results.complete { Ok(()) } else { Err(Failure::Stopped(shell_word(directory.path()))) }
}

/// A flag that the first interrupt or termination sets; a second interrupt ends the program at once.
fn stop_at_signals() -> Result<Arc<AtomicBool>, Failure> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // Asked first, it ends the program if the flag is set already; only then is the flag set.
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop)).map_err(Failure::Signals)?;
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(Failure::Signals)?;
    }
    Ok(stop)
}

/// A path as a shell takes it.
fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = text.chars().all(|c| c.is_alphanumeric() || "/._-+=:@%".contains(c));
    if plain { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}
