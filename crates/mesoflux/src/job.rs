//! Doing a plan: runs side by side on the cores, their states kept, their records merged.

use crate::plan::{Plan, PointPlan, Task};
use crate::progress::Progress;
use crate::route::{Record, RouteError, RouteRecorder, thermometer};
use crate::setup::simulation;
use crate::store::{RunState, Store, StoreError};
use mesoflux_core::domain::Workers;
use mesoflux_core::run::{Ending, Length, run};
use mesoflux_core::simulation::Simulation;
use mesoflux_core::system::{SimulationError, SnapshotError};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

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
    /// A state couldn't be written or read.
    #[error("{place}: {source}")]
    Store {
        /// Which run.
        place: String,
        /// Why.
        source: StoreError,
    },
    /// A state of another input.
    #[error("{place}: {source}")]
    Snapshot {
        /// Which run.
        place: String,
        /// Why.
        source: SnapshotError,
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
    /// Whether it came to its end.
    pub complete: bool,
    /// Steps done, equilibration included.
    pub steps: u64,
    /// A record for each measurement of the point that uses the run, by the measurement's place.
    pub records: Vec<(usize, Record)>,
    /// The kinetic temperature averaged over production.
    pub temperature: Option<f64>,
    /// What a reader must know of how it went.
    pub remarks: Vec<String>,
}

/// How a job is done.
#[derive(Debug)]
pub struct Conduct<'a> {
    /// Threads to use; the results don't depend on it.
    pub threads: usize,
    /// Where states are kept, if anywhere.
    pub store: Option<&'a Store>,
    /// Set from outside to stop everything after the present step.
    pub stop: &'a AtomicBool,
    /// When to stop by itself.
    pub deadline: Option<Instant>,
    /// Told of every step.
    pub progress: &'a Progress,
}

/// Below this many particles a simulation is cheapest on one thread.
const SMALL_SYSTEM: u64 = 4000;

/// Does all tasks of a plan, each from its kept state if it has one.
///
/// # Errors
/// The first failure; the other runs are stopped, their states kept.
pub fn perform(plan: &Plan, conduct: &Conduct) -> Result<Vec<Finished>, JobError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(conduct.threads).build()?;
    let tasks = plan.tasks();
    let largest = plan.points.iter().map(|point| point.input.particles()).max().unwrap_or(0);
    let failed = AtomicBool::new(false);
    let attempt = |task: &Task, workers: Workers| {
        let finished = perform_task(plan, *task, workers, conduct, &failed);
        failed.fetch_or(finished.is_err(), Ordering::Relaxed);
        finished
    };
    // Side by side when there are runs enough or each is too small to split; else one after the other, each on all threads.
    pool.install(|| {
        if tasks.len() >= conduct.threads || largest < SMALL_SYSTEM {
            let finished: Vec<_> = tasks.par_iter().with_max_len(1).map(|task| attempt(task, Workers::One)).collect();
            finished.into_iter().collect()
        } else {
            tasks.iter().map(|task| attempt(task, Workers::Pool)).collect()
        }
    })
}

fn perform_task(
    plan: &Plan,
    task: Task,
    workers: Workers,
    conduct: &Conduct,
    failed: &AtomicBool,
) -> Result<Finished, JobError> {
    let point = &plan.points[task.point];
    let input = &point.input;
    let place = place(point, task);
    let refused = |source: RouteError| JobError::Route { place: place.clone(), source };
    let unkept = |source: StoreError| JobError::Store { place: place.clone(), source };
    let mut simulation = simulation(point, task, workers, &place)?;
    let users: Vec<usize> =
        (0..point.measurements.len()).filter(|&k| point.measurements[k].runs.contains(&task.run)).collect();
    let mut recorders: Vec<Box<dyn RouteRecorder>> = Vec::new();
    for &user in &users {
        recorders.push(point.measurements[user].route.recorder(input).map_err(refused)?);
    }
    recorders.push(thermometer(input).map_err(refused)?);

    let mut files = conduct.store.map(|store| store.files(task));
    let mut remarks = Vec::new();
    if let (Some(store), Some(files)) = (conduct.store, &mut files)
        && let Some((state, damaged)) = store.read(files).map_err(unkept)?
    {
        remarks.extend(damaged.iter().map(|damaged| format!("{damaged}: went on from the state before it")));
        simulation.restore(state.simulation).map_err(|source| JobError::Snapshot { place: place.clone(), source })?;
        for (recorder, state) in recorders.iter_mut().zip(&state.recorders) {
            recorder.load(state).map_err(refused)?;
        }
        conduct.progress.skip(simulation.system.step);
    }
    let resumed_at = simulation.system.step;
    let length = Length {
        equilibration: input.steps(input.run.equilibration_time),
        production: input.steps(input.run.production_time),
    };
    let mut keep = |simulation: &Simulation, recorders: &[Box<dyn RouteRecorder>]| -> Result<(), JobError> {
        if let (Some(store), Some(files)) = (conduct.store, &mut files) {
            let recorders =
                recorders.iter().map(|recorder| recorder.save()).collect::<Result<_, _>>().map_err(refused)?;
            store.write(files, &RunState { simulation: simulation.snapshot(), recorders }).map_err(unkept)?;
        }
        Ok(())
    };
    let mut outcome = Ok(());
    let mut kept_at = Instant::now();
    let ending = run(&mut simulation, length, &mut recorders, |simulation, recorders| {
        conduct.progress.step(&simulation.system);
        if let Some(store) = conduct.store {
            let by_steps = store.cadence.steps.is_some_and(|steps| simulation.system.step % steps == 0);
            if by_steps || kept_at.elapsed() >= store.cadence.wall {
                outcome = keep(simulation, recorders);
                kept_at = Instant::now();
            }
        }
        let late = conduct.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        outcome.is_ok() && !late && !conduct.stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed)
    });
    outcome?;
    let ending = ending.map_err(|source| JobError::Simulation { place: place.clone(), source })?;
    let steps = simulation.system.step;
    if steps > resumed_at {
        keep(&simulation, &recorders)?;
    }
    let mut records =
        recorders.into_iter().map(RouteRecorder::finish).collect::<Result<Vec<_>, _>>().map_err(refused)?;
    let temperature = match records.pop() {
        Some(Record::Series(series)) => series.mean().map(|mean| mean[0]),
        _ => None,
    };
    let records = users.into_iter().zip(records).collect();
    Ok(Finished { task, complete: ending == Ending::Complete, steps, records, temperature, remarks })
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
