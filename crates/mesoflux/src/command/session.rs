//! Doing a job in a directory: runs with kept states, results, tables, figures, and the way to go on after a stop.

use crate::answer::{Circumstances, answer};
use crate::job::{Conduct, JobError, perform};
use crate::plan::Plan;
use crate::prediction;
use crate::progress::Progress;
use crate::report;
use crate::store::{Cadence, Store, StoreError};
use crate::study::StudyError;
use clap::Args;
use mesoflux_io::directory::{DirectoryError, Lock, OutputDirectory};
use mesoflux_io::input::{Files, InputError, InputFile, Invalid};
use mesoflux_io::results::Results;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
    pub quiet: bool,
    /// Print the results as JSON on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
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
    /// A study is wrong or can't be read.
    #[error("{0}")]
    Study(#[from] StudyError),
    /// The file system failed under way; what was written before is whole.
    #[error("{failure}\nwhat was kept before is whole; once this is put right, go on with: {command}")]
    Resumable {
        /// What failed.
        failure: Box<Self>,
        /// How to go on.
        command: String,
    },
    /// Stopped before the end; everything done is kept.
    #[error("stopped; to go on: {0}")]
    Stopped(String),
}

impl Failure {
    /// 2: the input or the command line is wrong; 3: the simulation failed; 4: a file could not be read or written;
    /// 130: stopped, with checkpoints.
    pub fn code(&self) -> u8 {
        match self {
            Self::Input(InputError::Wrong(_))
            | Self::Study(StudyError::Wrong(_) | StudyError::Input(InputError::Wrong(_)))
            | Self::Directory(DirectoryError::Exists(_))
            | Self::Refused(_)
            | Self::Job(JobError::Setup { .. } | JobError::Overlap { .. } | JobError::Threads(_)) => 2,
            Self::Job(JobError::Simulation { .. } | JobError::Route { .. }) => 3,
            Self::Input(InputError::Read { .. })
            | Self::Study(StudyError::Read { .. } | StudyError::Input(InputError::Read { .. }))
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

    /// Adds the command to go on with, where the file system may be at fault for the moment only.
    pub(super) fn resumable(self, command: &str) -> Self {
        let temporary = matches!(
            self,
            Self::Directory(DirectoryError::Io { .. })
                | Self::Job(JobError::Store { source: StoreError::Directory(_), .. })
        );
        if temporary { Self::Resumable { failure: Box::new(self), command: command.to_owned() } } else { self }
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

/// What one process may use until it is told to stop, for one job or for several in turn.
#[derive(Debug)]
pub(super) struct Session {
    threads: usize,
    stop: Arc<AtomicBool>,
    deadline: Option<Instant>,
    quiet: bool,
}

impl Session {
    /// Begins now; from here on signals stop the session.
    pub(super) fn begin(options: &Options) -> Result<Self, Failure> {
        Ok(Self {
            threads: threads(options.threads),
            stop: stop_at_signals()?,
            deadline: options.max_wall.map(|wall| Instant::now() + wall),
            quiet: options.quiet,
        })
    }

    /// Whether nothing more may begin.
    pub(super) fn is_over(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

/// What a job has left in its directory.
pub(super) struct Done {
    /// The results.
    pub results: Results,
    json: String,
    advanced: bool,
}

/// Does the job of an input in a directory, from whatever states are there, and writes down what came out; nothing is printed.
pub(super) fn work_in(
    workplace: &Workplace,
    file: &InputFile,
    plan: &Plan,
    session: &Session,
) -> Result<Done, Failure> {
    let start = Instant::now();
    let directory = &workplace.directory;
    let cadence = Cadence {
        steps: file.input.run.checkpoint_interval,
        wall: Duration::from_secs_f64(file.input.run.checkpoint_wall_seconds),
    };
    let store = Store::new(workplace.states.clone(), cadence);
    let steps = plan.tasks().iter().map(|task| plan.points[task.point].steps()).sum();
    let progress = Progress::new(steps, session.quiet);
    let &Session { threads, deadline, .. } = session;
    let conduct = Conduct { threads, store: Some(&store), stop: &session.stop, deadline, progress: &progress };
    let finished = perform(plan, &conduct);
    progress.finish();
    let finished = finished?;
    let circumstances = Circumstances { threads, wall_seconds: start.elapsed().as_secs_f64() };
    let answer = answer(&file.input, plan, &finished, circumstances)?;
    let json = serde_json::to_string_pretty(&answer.results)? + "\n";
    for (name, contents) in &answer.files {
        directory.write(name, contents.as_bytes())?;
    }
    directory.write(RESULTS, json.as_bytes())?;
    let advanced = finished.iter().any(|run| run.steps > run.steps_before);
    Ok(Done { results: answer.results, json, advanced })
}

/// Does the job of an input in a directory and prints what came out.
pub(super) fn perform_in(
    workplace: &Workplace,
    file: &InputFile,
    plan: &Plan,
    options: &Options,
) -> Result<Outcome, Failure> {
    let resume = format!("mesoflux resume {}", shell_word(workplace.directory.path()));
    let session = Session::begin(options)?;
    let Done { results, json, advanced } =
        work_in(workplace, file, plan, &session).map_err(|failure| failure.resumable(&resume))?;
    let mut text = String::new();
    if options.json {
        text = json;
    } else if !options.quiet {
        let place = workplace.directory.path().join(RESULTS);
        text = report::table(&results);
        text += &format!(
            "\n{:.1} s on {} threads; results in {}\n",
            results.wall_seconds,
            results.threads,
            place.display()
        );
    }
    if options.json || options.quiet {
        // A damaged file never passes in silence.
        tell(report::remarks(&results).trim_end());
    }
    let printed = print(&text);
    if !results.complete {
        // Even where a closed terminal takes no results.
        return Err(Failure::Stopped(resume));
    }
    printed?;
    Ok(if advanced { Outcome::Advanced } else { Outcome::NothingToDo })
}

/// Writes to standard output.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    output.write_all(text.as_bytes()).and_then(|()| output.flush()).map_err(Failure::Output)
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
