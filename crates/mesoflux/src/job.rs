//! Doing a plan: simulations built, run side by side on the cores, their records merged and turned into estimates.

use crate::plan::{Plan, PointPlan, Task};
use crate::progress::Progress;
use crate::route::{Record, RouteError, RouteRecorder, RunKind};
use mesoflux_analysis::Blocking;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::run::{Ending, Length, Moment, Recorder, run};
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{deal_species, draw_momenta, positions, relax_overlaps};
use mesoflux_core::state::Particles;
use mesoflux_core::system::{SimulationError, System};
use mesoflux_io::input::Input;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A job that failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// A simulation failed numerically.
    #[error("{place}: {source}")]
    Simulation {
        /// Which run.
        place: String,
        /// How it failed.
        source: SimulationError,
    },
    /// A simulation can't be set up; the input should have been refused.
    #[error("{place}: {reason}")]
    Setup {
        /// Which run.
        place: String,
        /// Why.
        reason: String,
    },
    /// An estimator refused its data.
    #[error("{place}: {source}")]
    Route {
        /// Which run or measurement.
        place: String,
        /// Why.
        source: RouteError,
    },
    /// The threads couldn't be started.
    #[error("--threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// What one replica of one run left.
#[derive(Debug, Clone)]
pub struct Finished {
    /// Which.
    pub task: Task,
    /// A record for each measurement of the point that uses the run, by the measurement's place.
    pub records: Vec<(usize, Record)>,
    /// The kinetic temperature averaged over production.
    pub temperature: Option<f64>,
}

/// Below this many particles a simulation is cheapest on one thread.
const SMALL_SYSTEM: u64 = 4000;

/// Does all tasks of a plan on `threads` threads; the results don't depend on how many.
///
/// # Errors
/// The first failure; the other runs are stopped.
pub fn perform(plan: &Plan, threads: usize, progress: &Progress) -> Result<Vec<Finished>, JobError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let tasks = plan.tasks();
    let largest = plan.points.iter().map(|point| point.input.particles()).max().unwrap_or(0);
    let stop = AtomicBool::new(false);
    let attempt = |task: &Task, workers: Workers| {
        let finished = perform_task(plan, *task, workers, &stop, progress);
        if finished.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        finished
    };
    // Side by side when there are runs enough or each is too small to split; else one after the other, each on all threads.
    let finished: Vec<_> = pool.install(|| {
        if tasks.len() >= threads || largest < SMALL_SYSTEM {
            tasks.par_iter().with_max_len(1).map(|task| attempt(task, Workers::One)).collect()
        } else {
            tasks.iter().map(|task| attempt(task, Workers::Pool)).collect()
        }
    });
    // A run that was stopped because another failed is no failure of its own: report the real one.
    let mut complete = Vec::new();
    for outcome in finished {
        complete.extend(outcome?);
    }
    Ok(complete)
}

fn perform_task(
    plan: &Plan,
    task: Task,
    workers: Workers,
    stop: &AtomicBool,
    progress: &Progress,
) -> Result<Option<Finished>, JobError> {
    let point = &plan.points[task.point];
    let input = &point.input;
    let place = place(point, task);
    let refused = |source: RouteError| JobError::Route { place: place.clone(), source };
    let mut simulation = simulation(point, task, workers, &place)?;
    let mut thermometer = Thermometer::new(input.run.sample_interval).map_err(refused)?;
    let mut recorders: Vec<(usize, Box<dyn RouteRecorder>)> = Vec::new();
    for (index, measurement) in point.measurements.iter().enumerate() {
        if measurement.runs.contains(&task.run) {
            recorders.push((index, measurement.route.recorder(input).map_err(refused)?));
        }
    }
    let length = Length {
        equilibration: input.steps(input.run.equilibration_time),
        production: input.steps(input.run.production_time),
    };
    let ending = {
        let borrowed =
            recorders.iter_mut().map(|(_, recorder)| Box::new(Borrowed(recorder.as_mut())) as Box<dyn Recorder>);
        let mut all: Vec<Box<dyn Recorder>> = borrowed.collect();
        all.push(Box::new(&mut thermometer));
        run(&mut simulation, length, &mut all, |simulation| {
            progress.step(&simulation.system);
            !stop.load(Ordering::Relaxed)
        })
        .map_err(|source| JobError::Simulation { place: place.clone(), source })?
    };
    if ending == Ending::Stopped {
        return Ok(None);
    }
    let records =
        recorders.into_iter().map(|(index, recorder)| Ok((index, recorder.finish()?))).collect::<Result<_, _>>();
    Ok(Some(Finished { task, records: records.map_err(refused)?, temperature: thermometer.mean() }))
}

/// Which run this is, for messages.
fn place(point: &PointPlan, task: Task) -> String {
    let kind = &point.runs[task.run];
    let conditions = point
        .conditions
        .iter()
        .chain(&kind.point())
        .map(|(key, value)| format!(", {key} = {value}"))
        .collect::<String>();
    format!("{} run{conditions}, replica {}", kind.name(), task.replica)
}

/// The simulation of one task at its start.
fn simulation(point: &PointPlan, task: Task, workers: Workers, place: &str) -> Result<Simulation, JobError> {
    let input = &point.input;
    let kind = &point.runs[task.run];
    let [route, forcing, strength] = kind.identity();
    let noise = NoiseKey::new(&[input.run.seed, task.point as u64, route, forcing, strength, task.replica]);
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let system = start(input, noise, workers, place)?;
    let driving: Option<Box<dyn Driving>> = match *kind {
        RunKind::Equilibrium => None,
        RunKind::Nemd { forcing, magnitude } => {
            let forcing = forcing.forcing(system.particles.count()).map_err(|error| refused(error.to_string()))?;
            Some(Box::new(ConstantForce::new(forcing, magnitude)))
        }
        RunKind::Norton { forcing, flux } => {
            let forcing = forcing.forcing(system.particles.count()).map_err(|error| refused(error.to_string()))?;
            Some(Box::new(ConstantFlux::new(forcing, flux)))
        }
    };
    let integrator = input.integrator().map_err(|error| refused(error.to_string()))?;
    Simulation::new(system, integrator, driving, noise, input.dynamics.time_step)
        .map_err(|error| refused(error.to_string()))
}

/// The system of an input: particles placed, overlaps relaxed, momenta drawn.
fn start(input: &Input, noise: NoiseKey, workers: Workers, place: &str) -> Result<System, JobError> {
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let region = input.region().map_err(|error| refused(error.to_string()))?;
    let species = deal_species(&input.species_counts(), noise);
    let positions = positions(input.system.start, species.len(), &region, noise);
    let particles = Particles::at_rest(positions, species, &input.masses());
    let mut system = System::new(particles, region, input.interactions(), input.skin(), workers)
        .map_err(|error| refused(error.to_string()))?;
    if input.system.start == mesoflux_core::start::Start::Random {
        relax_overlaps(&mut system, input.dynamics.temperature)
            .map_err(|source| JobError::Simulation { place: format!("{place}, relaxing the start"), source })?;
    }
    draw_momenta(&mut system.particles, input.dynamics.temperature, noise);
    Ok(system)
}

/// Merges the replicas of each run and lets every route estimate; `None` for a route whose runs aren't all there.
///
/// # Errors
/// Records that an estimator refuses.
pub fn merged_records(
    plan: &Plan,
    finished: &[Finished],
    point: usize,
    measurement: usize,
) -> Result<Option<Vec<Record>>, RouteError> {
    let mut records = Vec::new();
    for &run in &plan.points[point].measurements[measurement].runs {
        let mut merged: Option<Record> = None;
        // Replicas are merged in their order, so that the sum has the same bits whichever finished first.
        for task in finished.iter().filter(|finished| finished.task.point == point && finished.task.run == run) {
            for (_, record) in task.records.iter().filter(|(index, _)| *index == measurement) {
                match &mut merged {
                    None => merged = Some(record.clone()),
                    Some(merged) => merged.merge(record)?,
                }
            }
        }
        match merged {
            Some(record) => records.push(record),
            None => return Ok(None),
        }
    }
    Ok(Some(records))
}

/// A recorder lent to the driver.
struct Borrowed<'a>(&'a mut dyn RouteRecorder);

impl Recorder for Borrowed<'_> {
    fn observe(&mut self, moment: &mut Moment) {
        self.0.observe(moment);
    }
}

/// Follows the kinetic temperature of every run.
struct Thermometer {
    interval: u64,
    series: Blocking,
}

impl Thermometer {
    fn new(interval: u64) -> Result<Self, RouteError> {
        Ok(Self { interval, series: Blocking::new(1)? })
    }

    fn mean(&self) -> Option<f64> {
        self.series.mean().map(|mean| mean[0]).filter(|mean| mean.is_finite())
    }
}

impl Recorder for &mut Thermometer {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step % self.interval == 0 {
            // A temperature that is no number shows elsewhere; here it is only left out.
            let _ = self.series.record(&[moment.simulation.system.kinetic_temperature()]);
        }
    }
}
