//! Doing a plan: runs side by side on the cores, their states kept, their records merged.

use crate::plan::{Plan, PointPlan, Task};
use crate::progress::Progress;
use crate::route::{Record, RouteError, RouteRecorder, thermometer};
use crate::setup::simulation;
use crate::store::{Kept, LastKept, Store, StoreError};
use mesoflux_core::domain::Workers;
use mesoflux_core::run::{Length, run};
use mesoflux_core::simulation::Simulation;
use mesoflux_core::snapshot::SnapshotError;
use mesoflux_core::start::Overlap;
use mesoflux_core::system::SimulationError;
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
    /// Particles overlap at the start.
    #[error("{place}: {source}; with relax = true a start from a file moves overlapping particles apart")]
    Overlap {
        /// Which run.
        place: String,
        /// Which particles.
        source: Box<Overlap>,
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
    /// A recorder refused its state.
    #[error(
        "{place}: {file}: {source}; delete it to go on from the state before it, if there is one, or else to begin this run again"
    )]
    Recorder {
        /// Which run.
        place: String,
        /// The file that holds the state.
        file: String,
        /// Why.
        source: RouteError,
    },
    /// A state of another input.
    #[error(
        "{place}: {file}: {source}; delete it to go on from the state before it, if there is one, or else to begin this run again"
    )]
    Snapshot {
        /// Which run.
        place: String,
        /// The file that holds the state.
        file: String,
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
    /// How many of them earlier sessions did.
    pub steps_before: u64,
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
    let failed = AtomicBool::new(false);
    let attempt = |task: &Task, workers: Workers| {
        let finished = perform_task(plan, *task, workers, conduct, &failed);
        failed.fetch_or(finished.is_err(), Ordering::Relaxed);
        finished
    };
    pool.install(|| {
        if side_by_side(plan, conduct.threads) {
            let finished: Vec<_> = tasks.par_iter().with_max_len(1).map(|task| attempt(task, Workers::One)).collect();
            finished.into_iter().collect()
        } else {
            tasks.iter().map(|task| attempt(task, Workers::Pool)).collect()
        }
    })
}

/// Runs go side by side when there are enough of them or each is too small to split; else one after the other, each on all
/// threads.
pub(crate) fn side_by_side(plan: &Plan, threads: usize) -> bool {
    let largest = plan.points.iter().map(|point| point.input.particles()).max().unwrap_or(0);
    plan.tasks().len() >= threads || largest < SMALL_SYSTEM
}

/// What records a run: the measurements that use it, by their places, and a recorder for each; the thermometer last.
struct Recording {
    users: Vec<usize>,
    recorders: Vec<Box<dyn RouteRecorder>>,
}

impl Recording {
    fn new(point: &PointPlan, task: Task, place: &str) -> Result<Self, JobError> {
        let refused = |source: RouteError| JobError::Route { place: place.to_owned(), source };
        let users: Vec<usize> = point.users(task.run).collect();
        let route = |&user: &usize| point.measurements[user].route.recorder(&point.input);
        let mut recorders = users.iter().map(route).collect::<Result<Vec<_>, _>>().map_err(refused)?;
        recorders.push(thermometer(&point.input).map_err(refused)?);
        Ok(Self { users, recorders })
    }
}

/// A run at its start with its recorders, on its own.
pub(crate) struct Prepared {
    pub place: String,
    pub simulation: Simulation,
    pub recorders: Vec<Box<dyn RouteRecorder>>,
}

impl Prepared {
    pub(crate) fn new(point: &PointPlan, task: Task, workers: Workers) -> Result<Self, JobError> {
        let place = place(point, task);
        let recorders = Recording::new(point, task, &place)?.recorders;
        Ok(Self { simulation: simulation(point, task, workers, &place)?, recorders, place })
    }
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
    let length = Length {
        equilibration: input.steps(input.run.equilibration_time),
        production: input.steps(input.run.production_time),
    };
    let total = length.equilibration + length.production;
    let is_over = || {
        let late = conduct.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        late || conduct.stop.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed)
    };

    let mut files = conduct.store.map(|store| store.files(task));
    let kept = match (conduct.store, &mut files) {
        (Some(store), Some(files)) => store.read(files).map_err(unkept)?,
        _ => None,
    };
    let mut finished = Finished {
        task,
        complete: false,
        steps: 0,
        steps_before: 0,
        records: Vec::new(),
        temperature: None,
        remarks: Vec::new(),
    };
    if kept.is_none() && is_over() {
        return Ok(finished);
    }
    let Recording { users, mut recorders } = Recording::new(point, task, &place)?;
    let mut start = None;
    if let Some(Kept { state, path, remarks }) = kept {
        let unfit = |source| JobError::Recorder { place: place.clone(), file: path.display().to_string(), source };
        if state.recorders.len() != recorders.len() {
            return Err(unfit(RouteError::OtherState));
        }
        for (recorder, state) in recorders.iter_mut().zip(&state.recorders) {
            recorder.load(state).map_err(unfit)?;
        }
        finished.steps_before = state.simulation.system.step;
        finished.remarks = remarks;
        conduct.progress.skip(finished.steps_before);
        start = Some((state.simulation, path));
    }
    finished.steps = finished.steps_before;

    // A run that has come to its end already, or may not go on, needs no simulation for its records.
    if finished.steps < total && !is_over() {
        let mut simulation = simulation(point, task, workers, &place)?;
        if let Some((snapshot, path)) = start {
            simulation.restore(snapshot).map_err(|source| JobError::Snapshot {
                place: place.clone(),
                file: path.display().to_string(),
                source,
            })?;
        }
        let mut keep = |simulation: &Simulation, recorders: &[Box<dyn RouteRecorder>]| -> Result<LastKept, JobError> {
            let began = Instant::now();
            if let (Some(store), Some(files)) = (conduct.store, &mut files) {
                store.write(files, input, simulation, recorders).map_err(unkept)?;
            }
            Ok(LastKept::since(began, simulation.system.step))
        };
        let mut last = Ok(LastKept::none(finished.steps_before, input.particles()));
        let ending = run(&mut simulation, length, &mut recorders, |simulation, recorders| {
            conduct.progress.step(&simulation.system);
            if let (Some(store), Ok(kept)) = (conduct.store, &last)
                && store.cadence.is_due(simulation.system.step, kept)
            {
                last = keep(simulation, recorders);
            }
            last.is_ok() && !is_over()
        });
        let last = last?;
        ending.map_err(|source| JobError::Simulation { place: place.clone(), source })?;
        finished.steps = simulation.system.step;
        if finished.steps > last.step {
            keep(&simulation, &recorders)?;
        }
    }
    // A stop that came with the last step stopped nothing.
    finished.complete = finished.steps >= total;
    let mut records =
        recorders.into_iter().map(RouteRecorder::finish).collect::<Result<Vec<_>, _>>().map_err(refused)?;
    finished.temperature = match records.pop() {
        Some(Record::Series(series)) => series.mean().map(|mean| mean[0]),
        _ => None,
    };
    finished.records = users.into_iter().zip(records).collect();
    Ok(finished)
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
