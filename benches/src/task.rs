//! One timing of mesoflux, asked for as a process of its own.

use crate::failure::Failure;
use crate::statistics::median;
use crate::work::Split;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// What drives the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// Nothing.
    None,
    /// A constant force of this magnitude on two colors.
    Nemd(f64),
    /// A constant flux of two colors.
    Norton(f64),
}

/// What a child process does.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Task {
    /// The input file.
    pub input: PathBuf,
    /// What is set in it, as with `--set`.
    pub settings: Vec<String>,
    /// What drives the fluid.
    pub drive: Drive,
    /// How many threads.
    pub threads: usize,
    /// What they share.
    pub split: Split,
    /// Steps before the timing.
    pub warm_up: u64,
    /// Steps of one timed stretch.
    pub steps: u64,
    /// How many stretches are timed one after the other.
    pub stretches: usize,
    /// Steps afterward, not timed, with temperature and pressure at every tenth.
    pub sampled: u64,
}

/// What it found.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outcome {
    /// How many particles moved, over all replicas.
    pub particles: u64,
    /// Steps of one stretch.
    pub steps: u64,
    /// How long each stretch took.
    pub seconds: Vec<f64>,
    /// The most memory that the process ever had, in bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// Kinetic temperature and pressure.
    pub samples: Vec<[f64; 2]>,
}

impl Outcome {
    /// Particle-steps per second; the median over the stretches.
    pub fn rate(&self) -> f64 {
        self.particles as f64 * self.steps as f64 / median(&self.seconds)
    }
}

impl Task {
    /// A timing of one stretch, with the system's own settings and nothing sampled.
    pub fn new(input: PathBuf, settings: Vec<String>, warm_up: u64) -> Self {
        Self {
            input,
            settings,
            drive: Drive::None,
            threads: 1,
            split: Split::Bricks,
            warm_up,
            steps: 1,
            stretches: 1,
            sampled: 0,
        }
    }

    /// The same task with another number of steps.
    pub fn with_steps(&self, steps: u64) -> Self {
        Self { steps, ..self.clone() }
    }

    /// Has a process of its own do it.
    pub fn perform(&self) -> Result<Outcome, Failure> {
        let failed = |reason: String| Failure::program("mesoflux", reason);
        let program = std::env::current_exe().map_err(|error| failed(error.to_string()))?;
        let json = serde_json::to_string(self).map_err(|error| failed(error.to_string()))?;
        let mut command = Command::new(program);
        command.arg("--child").arg(json).stdin(Stdio::null());
        let output = command.output().map_err(|error| failed(error.to_string()))?;
        if !output.status.success() {
            return Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| failed(error.to_string()))
    }
}

/// The number of steps that takes about so many seconds, from ever longer trials of `seconds_for(steps)`.
pub fn steps_for(
    seconds: f64,
    first: u64,
    mut seconds_for: impl FnMut(u64) -> Result<f64, Failure>,
) -> Result<u64, Failure> {
    let mut steps = first;
    loop {
        let taken = seconds_for(steps)?;
        // A tenth of the time wanted is long enough to foretell the whole.
        if taken > 0.1 * seconds {
            return Ok(((steps as f64 * seconds / taken).round() as u64).max(1));
        }
        steps *= if taken > 0.02 * seconds { 5 } else { 10 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_steps_is_found_from_any_first_guess() {
        for first in [1, 10, 1000, 100_000] {
            let steps = steps_for(4.0, first, |steps| Ok(steps as f64 * 1e-3)).unwrap();
            assert_eq!(steps, 4000, "from {first}");
        }
    }
}
