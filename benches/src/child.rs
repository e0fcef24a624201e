//! What a child process does: warm up, time a stretch of steps (or several), sample temperature and pressure.

use crate::failure::Failure;
use crate::setup;
use crate::task::{Outcome, Task};
use crate::work::Split;
use mesoflux_core::domain::Workers;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::simulation::Simulation;
use rayon::prelude::*;
use std::time::Instant;

/// Steps between two samples, as in LAMMPS' inputs.
pub const SAMPLE_INTERVAL: u64 = 10;

/// Does a task given as JSON and prints its outcome as JSON.
pub fn perform(json: &str) -> Result<(), Failure> {
    let task: Task = serde_json::from_str(json).map_err(|error| Failure::Usage(format!("--child: {error}")))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(task.threads).build().map_err(Failure::simulation)?;
    let outcome = pool.install(|| outcome(&task))?;
    println!("{}", serde_json::to_string(&outcome).map_err(Failure::simulation)?);
    Ok(())
}

/// Does a task on the present pool of threads.
fn outcome(task: &Task) -> Result<Outcome, Failure> {
    let input = setup::read(&task.input, &task.settings)?;
    let (replicas, workers) = match task.split {
        Split::Replicas => (task.threads as u64, Workers::One),
        Split::Bricks => (1, if task.threads == 1 { Workers::One } else { Workers::Pool }),
    };
    let start = |replica| setup::simulation(&input, task.drive, replica, workers);
    let mut simulations = (0..replicas).map(start).collect::<Result<Vec<_>, _>>()?;
    advance(&mut simulations, task.warm_up)?;
    let mut seconds = Vec::with_capacity(task.stretches);
    for _ in 0..task.stretches {
        let begin = Instant::now();
        advance(&mut simulations, task.steps)?;
        seconds.push(begin.elapsed().as_secs_f64());
    }
    let particles = simulations.iter().map(|simulation| simulation.system.particles.count() as u64).sum();
    // Sampling may need memory that the steps did not.
    let peak_memory = peak_memory();
    let mut samples = Vec::new();
    for _ in 0..task.sampled / SAMPLE_INTERVAL {
        advance(&mut simulations[..1], SAMPLE_INTERVAL)?;
        let state = Thermodynamics::of(&mut simulations[0].system);
        samples.push([state.kinetic_temperature, state.pressure]);
    }
    Ok(Outcome { particles, steps: task.steps, seconds, peak_memory, samples })
}

/// Moves all replicas on, side by side where there are several.
fn advance(simulations: &mut [Simulation], steps: u64) -> Result<(), Failure> {
    let advance = |simulation: &mut Simulation| -> Result<(), Failure> {
        (0..steps).try_for_each(|_| simulation.step().map(|_| ()).map_err(Failure::simulation))
    };
    match simulations {
        [only] => advance(only),
        several => several.par_iter_mut().try_for_each(advance),
    }
}

/// The most memory that this process ever had, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}
