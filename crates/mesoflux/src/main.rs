//! The command line of mesoflux.

use clap::{Args, Parser, Subcommand};
use mesoflux::answer::{Circumstances, answer};
use mesoflux::job::{JobError, perform};
use mesoflux::plan::Plan;
use mesoflux::progress::Progress;
use mesoflux::report;
use mesoflux_io::directory::{DirectoryError, OutputDirectory};
use mesoflux_io::input::{InputError, InputFile, Setting};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Transport coefficients of mesoscopic fluids, each with its uncertainty.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run what an input file describes and measure what it asks for
    Run(RunArguments),
}

#[derive(Debug, Args)]
struct RunArguments {
    /// The input file
    #[arg(value_name = "INPUT.toml")]
    input: PathBuf,
    /// Directory for the results [default: a new one named after the input]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write into the directory of --out even if it exists
    #[arg(long, requires = "out")]
    force: bool,
    /// Threads to use [default: one for each core]; the results don't depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    threads: Option<u64>,
    /// Seed of all noise, in place of run.seed
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Set a key of the input, e.g. --set pair.all.friction.linear.coefficient=40.5; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    settings: Vec<Setting>,
    /// Print neither progress nor results
    #[arg(long)]
    quiet: bool,
    /// Print the results as JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Everything that can go wrong, by exit code.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("{0}")]
    Input(#[from] InputError),
    #[error("error: {0}")]
    Job(#[from] JobError),
    #[error("error: {0}")]
    Directory(#[from] DirectoryError),
    #[error("error: standard output: {0}")]
    Output(#[from] std::io::Error),
    #[error("error: results.json: {0}")]
    Json(#[from] serde_json::Error),
}

impl Failure {
    /// 2: the input or the command line is wrong; 3: the simulation failed; 4: a file could not be read or written.
    fn code(&self) -> u8 {
        match self {
            Self::Input(InputError::Wrong(_)) | Self::Directory(DirectoryError::Exists(_)) => 2,
            Self::Job(JobError::Setup { .. } | JobError::Threads(_)) => 2,
            Self::Job(JobError::Simulation { .. } | JobError::Route { .. }) => 3,
            Self::Input(InputError::Read { .. }) | Self::Directory(DirectoryError::Io { .. }) => 4,
            Self::Output(_) | Self::Json(_) => 4,
        }
    }
}

fn main() -> ExitCode {
    let Command::Run(arguments) = Arguments::parse().command;
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::from(failure.code())
        }
    }
}

fn run(arguments: RunArguments) -> Result<(), Failure> {
    let mut settings = arguments.settings;
    settings.extend(arguments.seed.map(|seed| Setting { path: "run.seed".into(), value: seed.to_string() }));
    let file = InputFile::read(&arguments.input, &settings)?;
    let plan = Plan::new(&file)?;
    let directory = match &arguments.out {
        Some(wanted) => OutputDirectory::explicit(wanted, arguments.force)?,
        None => OutputDirectory::named_after(&arguments.input)?,
    };
    let threads = match arguments.threads {
        Some(threads) => threads as usize,
        None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
    };
    let steps = plan.tasks().iter().map(|task| plan.points[task.point].steps()).sum();
    let progress = Progress::new(steps, arguments.quiet);
    let start = Instant::now();
    let finished = perform(&plan, threads, &progress);
    progress.finish();
    let circumstances = Circumstances { threads, wall_seconds: start.elapsed().as_secs_f64() };
    let answer = answer(&file.input, &plan, &finished?, circumstances)?;
    for (name, contents) in &answer.files {
        directory.write(name, contents.as_bytes())?;
    }
    let json = serde_json::to_string_pretty(&answer.results)? + "\n";
    directory.write("results.json", json.as_bytes())?;
    let mut output = std::io::stdout().lock();
    if arguments.json {
        std::io::Write::write_all(&mut output, json.as_bytes())?;
    } else if !arguments.quiet {
        let table = report::table(&answer.results);
        let seconds = circumstances.wall_seconds;
        std::io::Write::write_all(&mut output, table.as_bytes())?;
        let place = directory.path().join("results.json");
        std::io::Write::write_fmt(
            &mut output,
            format_args!("\n{seconds:.1} s on {threads} threads; results in {}\n", place.display()),
        )?;
    }
    Ok(())
}
