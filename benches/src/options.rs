//! The command line.

use crate::failure::Failure;
use crate::lammps::Run;
use crate::task::Task;
use crate::work::{Scheme, WORKS, Work};
use clap::Parser;
use std::path::PathBuf;

/// Fewer rounds than this tell too little to be written down.
pub const LEAST_ROUNDS: usize = 5;

/// Benchmarks: mesoflux against LAMMPS on the same work, kernels, sizes, and our routes against each other.
///
/// With none of --work, --scale, --kernels and --ours, all of them run in turn.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask bench", max_term_width = 100)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that a person may give")]
pub struct Options {
    /// How often everything is timed in turn; results of fewer than five rounds are shown, not written
    #[arg(long, default_value_t = LEAST_ROUNDS, value_parser = at_least_one)]
    pub rounds: usize,
    /// How long one timing takes
    #[arg(long, default_value_t = 4.0, value_parser = positive)]
    pub seconds: f64,
    /// The LAMMPS executable, or "none"; if left out, MESOFLUX_LAMMPS, or else `lmp` on the path
    #[arg(long, value_name = "PATH")]
    pub lammps: Option<String>,
    /// Against LAMMPS, these works only: groot-warren, ideal-16, ideal-32, lj-dpd
    #[arg(long, num_args = 1.., value_name = "NAME")]
    pub work: Vec<String>,
    /// The Groot–Warren fluid from 10³ to 10⁷ particles
    #[arg(long)]
    pub scale: bool,
    /// Nanoseconds and cycles a pair of every kernel, and the shares of the phases of a step
    #[arg(long)]
    pub kernels: bool,
    /// ABOBA against velocity Verlet, Norton dynamics against NEMD, two threads against one
    #[arg(long)]
    pub ours: bool,
    /// Tiny systems: a check of the benchmark itself, whose results mean nothing
    #[arg(long)]
    pub small: bool,
    /// Where the inputs of the works are
    #[arg(long, value_name = "DIRECTORY", default_value = "benches")]
    pub inputs: PathBuf,
    /// Where results are written; beside the inputs if left out
    #[arg(long, value_name = "DIRECTORY")]
    pub output: Option<PathBuf>,
    /// One timing, as this program asks itself for it
    #[arg(long, hide = true, value_name = "JSON")]
    pub child: Option<String>,
}

impl Options {
    /// Whether no part is named, so that all are wanted.
    fn everything(&self) -> bool {
        self.work.is_empty() && !self.scale && !self.kernels && !self.ours
    }

    /// The works to compare.
    pub fn works(&self) -> Result<Vec<&'static Work>, Failure> {
        if self.everything() {
            return Ok(WORKS.iter().collect());
        }
        let find = |name: &String| {
            let names = || WORKS.iter().map(|work| work.name).collect::<Vec<_>>().join(", ");
            let found = WORKS.iter().find(|work| work.name == name);
            found.ok_or_else(|| Failure::Usage(format!("no work `{name}`; there are: {}", names())))
        };
        self.work.iter().map(find).collect()
    }

    /// Whether a part with its own option is wanted.
    pub fn wants(&self, part: bool) -> bool {
        part || self.everything()
    }

    /// LAMMPS as the command line or the environment names it.
    pub fn lammps(&self) -> Option<String> {
        self.lammps.clone().or_else(|| std::env::var("MESOFLUX_LAMMPS").ok().filter(|path| !path.is_empty()))
    }

    /// Our task for a work on one thread.
    pub fn task(&self, work: &Work, scheme: Scheme) -> Task {
        let mut settings = vec![scheme.setting()];
        if self.small {
            settings.push(format!("system.particles={}", work.small));
        }
        Task::new(self.inputs.join(format!("{}.toml", work.name)), settings, self.warm_up(work.warm_up))
    }

    /// The numbers of threads to try: two only where two can run at once, for a number worth reading.
    pub fn threads(&self) -> &'static [usize] {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        if self.small || cores > 1 { &[1, 2] } else { &[1] }
    }

    /// Steps of warm-up; those of a tiny system are a few.
    pub fn warm_up(&self, steps: u64) -> u64 {
        if self.small { steps.min(20) } else { steps }
    }

    /// Steps of the first trial; of a tiny system, as few as can be.
    pub fn first_steps(&self, work: &Work) -> u64 {
        if self.small { 1 } else { work.first_steps }
    }

    /// LAMMPS' run for a work on so many threads.
    pub fn lammps_run(&self, work: &Work, threads: usize) -> Run {
        Run {
            input: self.inputs.join("lammps").join(work.lammps_input),
            variables: if self.small { work.lammps_small } else { work.lammps_variables },
            threads,
            steps: 0,
            sampled: 0,
        }
    }

    /// The directory of the results; `None` if they are not to be written.
    pub fn written(&self) -> Option<PathBuf> {
        let enough = if self.small { self.output.is_some() } else { self.rounds >= LEAST_ROUNDS };
        enough.then(|| self.output.clone().unwrap_or_else(|| self.inputs.clone()))
    }
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&rounds| rounds > 0).ok_or_else(|| "must be a number of rounds, at least 1".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|&seconds: &f64| seconds > 0.0 && seconds.is_finite());
    seconds.ok_or_else(|| "must be a number of seconds above 0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_results_that_mean_something_are_written_without_being_asked_for() {
        let written = |arguments: &[&str]| {
            let arguments = ["bench"].iter().chain(arguments);
            Options::try_parse_from(arguments).unwrap().written()
        };
        assert_eq!(written(&[]), Some(PathBuf::from("benches")));
        assert_eq!(written(&["--rounds", "7", "--output", "there"]), Some(PathBuf::from("there")));
        assert_eq!(written(&["--rounds", "4", "--output", "there"]), None);
        assert_eq!(written(&["--small"]), None);
        assert_eq!(written(&["--small", "--rounds", "1", "--output", "there"]), Some(PathBuf::from("there")));
    }
}
