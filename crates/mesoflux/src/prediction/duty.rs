//! How long a job takes.
//!
//! A kind of run is timed by a copy of it: its setup; its steps, over whole lives of neighbor lists, because building one costs as
//! much as several steps; and every recorder's samples, which come at its own cadence and only in production.

use super::{EVERY_CADENCE, fill, shrunk};
use crate::job::{JobError, Prepared, side_by_side};
use crate::plan::{Plan, PointPlan, Task};
use mesoflux_core::domain::Workers;
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::system::SimulationError;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Particles of the copy whose time is measured: more than the caches hold.
const SAMPLE: u64 = 100_000;
/// How long each part of a kind of run is timed, if whole lists allow.
const TIMED: Duration = Duration::from_millis(400);
/// How long it is timed at most.
const LONGEST: Duration = Duration::from_secs(3);
/// Steps before the clock starts, in which a start comes near to a fluid.
const WARM: u64 = 30;

/// The time that a job takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Duty {
    /// Wall time in seconds.
    pub seconds: f64,
    /// Particle-steps each second, all threads together.
    pub rate: f64,
}

/// What a kind of run takes in seconds, for each particle of it, while all threads are busy.
#[derive(Debug, Clone, Copy, Default)]
struct Cost {
    setup: f64,
    step: f64,
    /// Sampling, for each step of production.
    samples: f64,
}

impl Cost {
    fn map(self, change: impl Fn(f64) -> f64) -> Self {
        Self { setup: change(self.setup), step: change(self.step), samples: change(self.samples) }
    }
}

/// The time of a plan on so many threads, measured with copies of the runs of its first point.
///
/// # Errors
/// A copy that can't be set up.
pub fn duty(plan: &Plan, threads: usize) -> Result<Duty, JobError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let side_by_side = side_by_side(plan, threads);
    let copies = if side_by_side { threads.min(plan.tasks().len()) } else { 1 };
    let first = &plan.points[0];
    let copy = shrunk(first, SAMPLE);
    let mut costs: Vec<(&str, Cost)> = Vec::new();
    for kind in 0..first.runs.len() {
        // Routes at several strengths do the same work.
        let name = first.runs[kind].name();
        if let Some(&known) = costs.iter().find(|&&(known, _)| known == name) {
            costs.push(known);
            continue;
        }
        let workers = if side_by_side { Workers::One } else { Workers::Pool };
        let timed = |replica: usize| cost(&copy, Task { point: 0, run: kind, replica: replica as u64 }, workers);
        let each: Vec<Cost> =
            pool.install(|| (0..copies).into_par_iter().with_max_len(1).map(timed).collect::<Result<_, _>>())?;
        let mean = |part: fn(&Cost) -> f64| each.iter().map(part).sum::<f64>() / copies as f64;
        costs.push((name, Cost { setup: mean(|c| c.setup), step: mean(|c| c.step), samples: mean(|c| c.samples) }));
    }
    let pairs = |point: &PointPlan| point.input.expected_pairs() / point.input.particles() as f64;
    // Each run goes to the thread that is free first.
    let mut busy = vec![0.0f64; copies];
    let mut particle_steps = 0.0;
    for task in plan.tasks() {
        let point = &plan.points[task.point];
        let particles = point.input.particles() as f64;
        // Another point may have fewer routes than the first.
        let cost = costs.get(task.run).or(costs.first()).map_or_else(Cost::default, |&(_, cost)| cost);
        let Cost { setup, step, samples } = cost.map(|seconds| seconds * particles * pairs(point) / pairs(first));
        let production = point.input.steps(point.input.run.production_time) as f64;
        if let Some(free) = busy.iter_mut().min_by(|a, b| a.total_cmp(b)) {
            *free += setup + step * point.steps() as f64 + samples * production;
        }
        particle_steps += particles * point.steps() as f64;
    }
    let seconds = busy.into_iter().fold(0.0, f64::max);
    Ok(Duty { seconds, rate: particle_steps / seconds })
}

/// Times one run.
fn cost(copy: &PointPlan, task: Task, workers: Workers) -> Result<Cost, JobError> {
    let start = Instant::now();
    let mut prepared = Prepared::new(copy, task, workers)?;
    let setup = start.elapsed().as_secs_f64();
    let timed = seconds_a_step(&mut prepared).and_then(|step| Ok((step, seconds_of_samples(&mut prepared)?)));
    let (step, samples) = timed.map_err(|source| JobError::Simulation { place: prepared.place.clone(), source })?;
    Ok(Cost { setup, step, samples }.map(|seconds| seconds / copy.input.particles() as f64))
}

/// Seconds a step without any sampling, from the build of one neighbor list to that of another.
fn seconds_a_step(prepared: &mut Prepared) -> Result<f64, SimulationError> {
    let simulation = &mut prepared.simulation;
    let begin = Instant::now();
    while simulation.system.step < WARM || begin.elapsed() < TIMED / 4 {
        simulation.step()?;
    }
    let mut layout = simulation.system.layout();
    let begin = Instant::now();
    while simulation.system.layout() == layout && begin.elapsed() < LONGEST {
        simulation.step()?;
    }
    layout = simulation.system.layout();
    let (begin, first) = (Instant::now(), simulation.system.step);
    let mut whole = None;
    loop {
        simulation.step()?;
        let elapsed = begin.elapsed();
        let mean = elapsed.as_secs_f64() / (simulation.system.step - first) as f64;
        if simulation.system.layout() != layout {
            layout = simulation.system.layout();
            whole = Some(mean);
        }
        if elapsed >= LONGEST || elapsed >= TIMED && whole == Some(mean) {
            return Ok(whole.unwrap_or(mean));
        }
    }
}

/// Seconds that all recorders' samples take, for each step.
fn seconds_of_samples(prepared: &mut Prepared) -> Result<f64, SimulationError> {
    fill(prepared, TIMED);
    let Prepared { simulation, recorders, .. } = prepared;
    let mut total = 0.0;
    for recorder in recorders {
        let (begin, mut spent, mut samples) = (Instant::now(), Duration::ZERO, 0);
        while samples < 3 || begin.elapsed() < TIMED / 4 {
            let driven = simulation.step()?;
            let sample = Instant::now();
            recorder.observe(&mut Moment { simulation, step: EVERY_CADENCE, driven });
            spent += sample.elapsed();
            samples += 1;
        }
        total += spent.as_secs_f64() / f64::from(samples) / recorder.interval() as f64;
    }
    Ok(total)
}
