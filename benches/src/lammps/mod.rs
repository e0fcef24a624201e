//! LAMMPS: where it is, the ways to run it on so many threads, and one run of it.

mod log;

use crate::failure::Failure;
use crate::work::Split;
use log::Log;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// An installation of LAMMPS.
#[derive(Debug)]
pub struct Lammps {
    program: PathBuf,
    /// The libraries of its environment, beside its directory.
    library: Option<PathBuf>,
    /// MPI's launcher beside it.
    launcher: Option<PathBuf>,
    /// What it calls itself.
    pub version: String,
}

/// A way to run it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// One process, no package.
    Plain,
    /// A rank of MPI on each core.
    Ranks,
    /// The OpenMP package with all threads.
    OpenMp,
    /// A process of one thread for each replica; all of their steps count.
    Replicas,
}

impl Variant {
    /// Its name in the results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Ranks => "mpi",
            Self::OpenMp => "omp",
            Self::Replicas => "replicas",
        }
    }
}

/// What to run.
#[derive(Debug, Clone)]
pub struct Run {
    /// The input.
    pub input: PathBuf,
    /// Its variables.
    pub variables: &'static [(&'static str, &'static str)],
    /// How many threads, ranks or replicas.
    pub threads: usize,
    /// Steps that are timed.
    pub steps: u64,
    /// Steps along which temperature and pressure are printed.
    pub sampled: u64,
}

/// What came out.
#[derive(Debug)]
pub struct Timing {
    /// Particle-steps per second.
    pub rate: f64,
    /// Particles of one system.
    pub particles: u64,
    /// Temperature and pressure.
    pub samples: Vec<[f64; 2]>,
}

impl Lammps {
    /// The installation that the command line names, or the one on the path; `None` where there is none.
    pub fn find(wanted: Option<&str>) -> Result<Option<Self>, Failure> {
        let path = match wanted {
            Some("none") => return Ok(None),
            Some(given) if given.contains('/') => Some(PathBuf::from(given)),
            given => on_path(given.unwrap_or("lmp")),
        };
        let Some(program) = path else {
            return match wanted {
                Some(given) => Err(Failure::Usage(format!("--lammps {given}: no such program on the path"))),
                None => Ok(None),
            };
        };
        let beside = |name: &str| Some(program.parent()?.join(name)).filter(|path| path.exists());
        let (library, launcher) = (beside("../lib"), beside("mpiexec").or_else(|| on_path("mpiexec")));
        let mut lammps = Self { library, launcher, version: String::new(), program };
        let mut command = lammps.command(&lammps.program);
        let output = command.arg("-h").output().map_err(|error| lammps.failed(error.to_string()))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let version = text.lines().find_map(|line| line.split_once("Simulator - "));
        lammps.version = match version {
            Some((_, version)) => version.trim().to_owned(),
            None => return Err(lammps.failed(String::from_utf8_lossy(&output.stderr).trim().to_owned())),
        };
        Ok(Some(lammps))
    }

    /// The ways worth trying for so many threads.
    pub fn variants(&self, threads: usize, split: Split) -> Vec<Variant> {
        if threads == 1 {
            return vec![Variant::Plain, Variant::OpenMp];
        }
        let ranks = self.launcher.as_ref().map(|_| Variant::Ranks);
        let replicas = (split == Split::Replicas).then_some(Variant::Replicas);
        ranks.into_iter().chain([Variant::OpenMp]).chain(replicas).collect()
    }

    /// One run.
    pub fn run(&self, variant: Variant, run: &Run) -> Result<Timing, Failure> {
        let processes = if variant == Variant::Replicas { run.threads } else { 1 };
        let start = |_| self.start(variant, run);
        let children = (0..processes).map(start).collect::<Result<Vec<_>, _>>()?;
        let logs = children.into_iter().map(|child| self.log_of(child)).collect::<Result<Vec<_>, _>>()?;
        let rate = logs.iter().map(Log::rate).sum();
        let first = logs.into_iter().next();
        first
            .map(|log| Timing { rate, particles: log.particles, samples: log.samples })
            .ok_or_else(|| self.failed("no process was started".to_owned()))
    }

    fn start(&self, variant: Variant, run: &Run) -> Result<Child, Failure> {
        let threads = run.threads.to_string();
        let mut command = match (variant, &self.launcher) {
            (Variant::Ranks, Some(launcher)) => {
                let mut command = self.command(launcher);
                command.args(["-n", &threads]).arg(&self.program);
                command
            }
            _ => self.command(&self.program),
        };
        command.arg("-in").arg(&run.input).args(["-log", "none", "-nocite"]);
        let numbers = [("steps", run.steps.to_string()), ("samples", run.sampled.to_string())];
        for (name, value) in run.variables.iter().map(|(name, value)| (*name, *value)) {
            command.args(["-var", name, value]);
        }
        for (name, value) in &numbers {
            command.args(["-var", name, value]);
        }
        if variant == Variant::OpenMp {
            command.args(["-sf", "omp", "-pk", "omp", &threads]).env("OMP_NUM_THREADS", &threads);
        } else {
            command.env("OMP_NUM_THREADS", "1");
        }
        command.spawn().map_err(|error| self.failed(error.to_string()))
    }

    fn log_of(&self, child: Child) -> Result<Log, Failure> {
        let output = child.wait_with_output().map_err(|error| self.failed(error.to_string()))?;
        let text = String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            let error = text.lines().find(|line| line.contains("ERROR")).unwrap_or("no reason given");
            let reason = format!("{error}\n{}", String::from_utf8_lossy(&output.stderr).trim());
            return Err(self.failed(reason.trim().to_owned()));
        }
        Log::parse(&text).ok_or_else(|| self.failed("the log has no second loop time".to_owned()))
    }

    /// A command in LAMMPS' environment.
    fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        if let Some(library) = &self.library {
            let inherited = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
            let paths = std::iter::once(library.clone()).chain(std::env::split_paths(&inherited));
            if let Ok(joined) = std::env::join_paths(paths) {
                command.env("LD_LIBRARY_PATH", joined);
            }
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn failed(&self, reason: String) -> Failure {
        Failure::program(format!("LAMMPS ({})", self.program.display()), reason)
    }
}

/// A program of this name on the path.
fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|directory| directory.join(name)).find(|program| program.is_file())
}
