//! Doing a job in a directory: runs with kept states, results, tables, figures, and the way to go on after a stop.

use crate::answer::{Circumstances, answer};
use crate::job::{Conduct, JobError, perform};
use crate::plan::Plan;
use crate::prediction;
use crate::progress::Progress;
use crate::report;
use crate::store::{Cadence, Store, StoreError};
use clap::Args;
use mesoflux_io::directory::{DirectoryError, Lock, OutputDirectory};
use mesoflux_io::input::{Files, InputError, InputFile, Invalid};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The directory of the runs' states within a run's directory.
pub(super) const STATES: &str = "states";
/// The results.
pub(super) const RESULTS: &str = "results.json";
/// The input as it was run, settings included; once more among the states, where it tells which input they belong to.
pub(super) const INPUT: &str = "input.toml";
/// The directory of the files that the input starts from.
pub(super) const START: &str = "start";
/// Held by the process that works in the directory; among the states.
const LOCK: &str = "lock";

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
    /// A directory that holds no run.
    #[error("error: {directory}: {reason}")]
    NoRun {
        /// The directory.
        directory: String,
        /// What it lacks.
        reason: String,
    },
    /// The file system failed under way; what was written before is whole.
    #[error(
        "{failure}\nwhat was kept before is whole; once this is put right, go on with: mesoflux resume {directory}"
    )]
    Resumable {
        /// What failed.
        failure: Box<Self>,
        /// Where.
        directory: String,
    },
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
            | Self::Job(JobError::Setup { .. } | JobError::Overlap { .. } | JobError::Threads(_)) => 2,
            Self::Job(JobError::Simulation { .. } | JobError::Route { .. }) => 3,
            Self::Input(InputError::Read { .. })
            | Self::Job(JobError::Store { .. } | JobError::Snapshot { .. } | JobError::Recorder { .. })
            | Self::Directory(DirectoryError::Io { .. } | DirectoryError::InUse { .. })
            | Self::NoRun { .. }
            | Self::Output(_)
            | Self::Json(_)
            | Self::Signals(_) => 4,
            Self::Resumable { failure, .. } => failure.code(),
            Self::Stopped(_) => 130,
        }
    }

    /// Adds the way to go on, where the file system may be at fault for the moment only.
    fn in_directory(self, directory: &OutputDirectory) -> Self {
        let temporary = matches!(
            self,
            Self::Directory(DirectoryError::Io { .. })
                | Self::Job(JobError::Store { source: StoreError::Directory(_), .. })
        );
        if temporary {
            Self::Resumable { failure: Box::new(self), directory: shell_word(directory.path()) }
        } else {
            self
        }
    }
}

/// A run's directory while this process works in it, and nobody else.
#[derive(Debug)]
pub(super) struct Workplace {
    directory: OutputDirectory,
    states: OutputDirectory,
    _lock: Lock,
}

impl Workplace {
    /// Takes possession of a directory and removes what a killed process left half-written.
    ///
    /// The states' directory, with the lock in it, comes first of all: it marks a run's directory.
    pub(super) fn open(directory: OutputDirectory) -> Result<Self, Failure> {
        let states = OutputDirectory::explicit(&directory.path().join(STATES), true)?;
        let lock = states.lock(LOCK).map_err(|error| match error {
            DirectoryError::InUse { holder, .. } => {
                DirectoryError::InUse { path: directory.path().display().to_string(), holder }
            }
            other => other,
        })?;
        if let Some(warning) = &lock.warning {
            tell(&format!("warning: {warning}"));
        }
        directory.remove_unfinished()?;
        states.remove_unfinished()?;
        Ok(Self { directory, states, _lock: lock })
    }

    /// Removes what an earlier run left here, which must not be taken for the next one's.
    pub(super) fn clear(&self) -> Result<(), Failure> {
        self.remove_results()?;
        self.directory.remove(START)?;
        Ok(self.states.remove_all_but(LOCK)?)
    }

    /// Removes the results, which no longer hold.
    pub(super) fn remove_results(&self) -> Result<(), Failure> {
        Ok(self.directory.remove(RESULTS)?)
    }

    /// Keeps copies of the files that the input starts from.
    pub(super) fn keep_files(&self, files: &[(String, Vec<u8>)]) -> Result<(), Failure> {
        if !files.is_empty() {
            let kept = OutputDirectory::explicit(&self.directory.path().join(START), true)?;
            for (name, contents) in files {
                kept.write(name, contents)?;
            }
        }
        Ok(())
    }

    /// Writes down the input that the directory belongs to.
    pub(super) fn write_input(&self, file: &InputFile) -> Result<(), Failure> {
        // In this order: killed in between, a longer run is taken for an extension, which it is.
        self.directory.write(INPUT, file.text().as_bytes())?;
        Ok(self.states.write(INPUT, file.text().as_bytes())?)
    }
}

/// What a session came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Steps were done.
    Advanced,
    /// All runs had come to their ends before.
    NothingToDo,
}

/// Does the job of an input in a directory, from whatever states are there.
pub(super) fn perform_in(
    workplace: &Workplace,
    file: &InputFile,
    plan: &Plan,
    options: &Options,
) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let directory = &workplace.directory;
    let cadence = Cadence {
        steps: file.input.run.checkpoint_interval,
        wall: Duration::from_secs_f64(file.input.run.checkpoint_wall_seconds),
    };
    let store = Store::new(workplace.states.clone(), cadence);
    let threads = threads(options.threads);
    let steps = plan.tasks().iter().map(|task| plan.points[task.point].steps()).sum();
    let progress = Progress::new(steps, options.quiet);
    let stop = stop_at_signals()?;
    let deadline = options.max_wall.map(|wall| start + wall);
    let conduct = Conduct { threads, store: Some(&store), stop: &stop, deadline, progress: &progress };
    let finished = perform(plan, &conduct);
    progress.finish();
    let finished = finished.map_err(|error| Failure::from(error).in_directory(directory))?;
    let circumstances = Circumstances { threads, wall_seconds: start.elapsed().as_secs_f64() };
    let answer = answer(&file.input, plan, &finished, circumstances)?;
    let json = serde_json::to_string_pretty(&answer.results)? + "\n";
    let write = || -> Result<(), DirectoryError> {
        for (name, contents) in &answer.files {
            directory.write(name, contents.as_bytes())?;
        }
        directory.write(RESULTS, json.as_bytes())
    };
    write().map_err(|error| Failure::from(error).in_directory(directory))?;
    let mut text = String::new();
    if options.json {
        text = json;
    } else if !options.quiet {
        let place = directory.path().join(RESULTS);
        let seconds = circumstances.wall_seconds;
        text = report::table(&answer.results);
        text += &format!("\n{seconds:.1} s on {threads} threads; results in {}\n", place.display());
    }
    if options.json || options.quiet {
        // A damaged file never passes in silence.
        tell(report::remarks(&answer.results).trim_end());
    }
    let mut output = std::io::stdout().lock();
    let printed = output.write_all(text.as_bytes()).and_then(|()| output.flush()).map_err(Failure::Output);
    if !answer.results.complete {
        // Even where a closed terminal takes no results.
        return Err(Failure::Stopped(shell_word(directory.path())));
    }
    printed?;
    let advanced = finished.iter().any(|run| run.steps > run.steps_before);
    Ok(if advanced { Outcome::Advanced } else { Outcome::NothingToDo })
}

/// How many threads to use where the command line says so many, or none.
pub(super) fn threads(asked: Option<u64>) -> usize {
    match asked {
        Some(threads) => threads as usize,
        None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
    }
}

/// The plan of an input, whose runs fit into the memory that is free.
pub(super) fn planned(file: &InputFile, options: &Options) -> Result<Plan, Failure> {
    let plan = Plan::new(file)?;
    prediction::check_memory(&plan, threads(options.threads))?.map_err(|large| {
        let particles = if file.input.system.particles.is_some() { "system.particles" } else { "system" };
        file.fault(&Invalid::new(particles, "", large))
    })?;
    Ok(plan)
}

/// The contents of the files that an input starts from, under the names by which a run keeps them.
pub(super) fn named_files(file: &InputFile) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let read = |(name, place): (String, PathBuf)| match std::fs::read(&place) {
        Ok(contents) => Ok((Files::kept_name(&name), contents)),
        Err(source) => Err(Failure::Input(InputError::Read { name, source })),
    };
    file.named_files()?.into_iter().map(read).collect()
}

impl Options {
    /// Says something on standard error beside the results, unless silence is asked for.
    pub(super) fn remark(&self, text: &str) {
        if !self.quiet {
            tell(text);
        }
    }
}

/// A line on standard error, if it can still be written; nothing for an empty text.
fn tell(text: &str) {
    if !text.is_empty() {
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

/// A flag that the first interrupt, termination or hang-up sets; a second interrupt ends the program at once.
fn stop_at_signals() -> Result<Arc<AtomicBool>, Failure> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    #[cfg(unix)]
    let signals = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
    #[cfg(not(unix))]
    let signals = [SIGINT, SIGTERM];
    let stop = Arc::new(AtomicBool::new(false));
    for signal in signals.into_iter().filter(|&signal| !is_ignored(signal)) {
        // Only Ctrl-C is repeated by a person who has lost patience: a closed terminal may well hang up twice, a batch system
        // terminate twice. Asked first, this ends the program if the flag is set already; only then is the flag set.
        if signal == SIGINT {
            signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))
                .map_err(Failure::Signals)?;
        }
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(Failure::Signals)?;
    }
    Ok(stop)
}

/// Whether the parent has this signal ignored, as `nohup` does: then it stays so. Known on Linux only.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

/// A path as a shell takes it.
pub(super) fn shell_word(path: &Path) -> String {
    let mut text = path.display().to_string();
    if text.starts_with('-') {
        text.insert_str(0, "./");
    }
    let plain = text.chars().all(|c| c.is_alphanumeric() || "/._-+=:@%".contains(c));
    if plain { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}
