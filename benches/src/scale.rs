//! The Groot–Warren fluid from a thousand to ten million particles: time and memory a particle.

use crate::failure::Failure;
use crate::machine::{Machine, available_memory};
use crate::options::Options;
use crate::statistics::Spread;
use crate::task::{Task, steps_for};
use crate::work::{Scheme, WORKS};
use serde::{Deserialize, Serialize};

/// Steps before the timing: the random start has forgotten itself, and the largest system is not kept waiting.
const WARM_UP: u64 = 50;
/// Steps of a timed stretch, so that each holds its share of lists built.
const FEWEST_STEPS: u64 = 16;
/// The sizes whose costs a particle are compared.
const COMPARED: (u64, u64) = (100_000, 10_000_000);

/// `scale.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scale {
    /// The integrator.
    pub integrator: String,
    /// The machine in one line.
    pub machine: String,
    /// When.
    pub date: String,
    /// Size by size, for each number of threads.
    pub sizes: Vec<Size>,
}

/// One size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Size {
    /// Threads.
    pub threads: usize,
    /// N.
    pub particles: u64,
    /// Steps of each timed stretch.
    pub steps: u64,
    /// Over the stretches.
    pub nanoseconds_per_particle_step: Spread,
    /// The most memory the process ever had, in bytes.
    pub peak_memory: Option<u64>,
}

impl Size {
    /// Memory over the number of particles.
    pub fn bytes_per_particle(&self) -> Option<f64> {
        Some(self.peak_memory? as f64 / self.particles as f64)
    }
}

impl Scale {
    /// The time a particle-step takes with ten million particles over that with a hundred thousand.
    pub fn ratio(&self, threads: usize) -> Option<f64> {
        let of = |particles: u64| {
            let size = self.sizes.iter().find(|size| (size.threads, size.particles) == (threads, particles))?;
            Some(size.nanoseconds_per_particle_step.median)
        };
        Some(of(COMPARED.1)? / of(COMPARED.0)?)
    }
}

/// Times every size on one thread and on two.
pub fn measure(options: &Options, machine: &Machine) -> Result<Scale, Failure> {
    let decades = if options.small { 2..=3 } else { 3..=7 };
    let mut sizes: Vec<Size> = Vec::new();
    for &threads in options.threads() {
        let mut last: Option<Size> = None;
        for decade in decades.clone() {
            let particles = 10u64.pow(decade);
            let needed = last.as_ref().and_then(Size::bytes_per_particle).map(|bytes| bytes * particles as f64);
            if let (Some(needed), Some(available)) = (needed, available_memory())
                && needed > 0.9 * available as f64
            {
                eprintln!("scale: {particles} particles left out: about {:.1} GB needed", needed * 1e-9);
                break;
            }
            let size = one_size(options, threads, particles, last.as_ref())?;
            let time = size.nanoseconds_per_particle_step.median;
            eprintln!("scale: {particles} particles, threads {threads}: {time:.1} ns a particle-step");
            sizes.push(size.clone());
            last = Some(size);
        }
    }
    let integrator = Scheme::VelocityVerlet.name().to_owned();
    Ok(Scale { integrator, machine: machine.in_one_line(), date: machine.date.clone(), sizes })
}

fn one_size(options: &Options, threads: usize, particles: u64, last: Option<&Size>) -> Result<Size, Failure> {
    let mut task = options.task(&WORKS[0], Scheme::VelocityVerlet);
    task.settings.retain(|setting| !setting.starts_with("system."));
    task.settings.push(format!("system.particles={particles}"));
    let task = Task { threads, warm_up: options.warm_up(WARM_UP), ..task };
    let steps = match last {
        // What the next smaller system took foretells this one: no trial, which would cost a warm-up.
        Some(last) => {
            let step = last.nanoseconds_per_particle_step.median * 1e-9 * particles as f64;
            (options.seconds / step).round() as u64
        }
        None => steps_for(options.seconds, FEWEST_STEPS, |steps| Ok(task.with_steps(steps).perform()?.seconds[0]))?,
    };
    let steps = steps.max(FEWEST_STEPS);
    let outcome = Task { stretches: options.rounds, ..task.with_steps(steps) }.perform()?;
    let per_particle_step = 1e9 / (particles as f64 * steps as f64);
    let times: Vec<f64> = outcome.seconds.iter().map(|seconds| seconds * per_particle_step).collect();
    let nanoseconds_per_particle_step = Spread::of(&times);
    Ok(Size { threads, particles, steps, nanoseconds_per_particle_step, peak_memory: outcome.peak_memory })
}
