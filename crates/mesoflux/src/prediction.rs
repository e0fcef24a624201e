//! What a job will cost: memory and time, from a small copy of its runs that really runs for a moment.

use crate::job::{JobError, Prepared, side_by_side, state_of};
use crate::plan::{Plan, PointPlan, Task};
use mesoflux_core::domain::Workers;
use mesoflux_core::run::{Length, run};
use mesoflux_core::simulation::Simulation;
use mesoflux_io::input::{Input, StartInput};
use peak_alloc::PeakAlloc;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Counts what the program has allocated, and the most that it had at a time.
#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Particles of the larger of the two copies whose memory is measured.
const MEMORY_SAMPLE: u64 = 20_000;
/// Particles of the copy whose time is measured: more than the caches hold.
const TIME_SAMPLE: u64 = 100_000;
/// How long each kind of run is timed.
const TIMED: Duration = Duration::from_millis(400);
/// Below this many particles at a time nobody runs out of memory.
const FEW_PARTICLES: u64 = 200_000;

/// The memory that the runs of a job need at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// Bytes.
    pub bytes: f64,
    /// The same for each particle of the runs that are in memory together.
    pub per_particle: f64,
    /// How many runs these are.
    pub runs: usize,
}

/// The time that a job takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Duty {
    /// Wall time in seconds.
    pub seconds: f64,
    /// Particle-steps each second, all threads together.
    pub rate: f64,
}

/// A job that needs more memory than there is.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the runs need about {} of memory at a time ({particles} particles in {runs} of them, about {per_particle:.0} bytes a \
     particle): must be below the {} that are free here{}",
    size(*needed),
    size(*free),
    if *runs > 1 { "; fewer --threads have fewer runs in memory" } else { "" }
)]
pub struct TooLarge {
    needed: f64,
    free: f64,
    particles: u64,
    runs: usize,
    per_particle: f64,
}

/// The memory that a plan's runs need at a time on so many threads.
///
/// A run's peak grows linearly with its particles; two small copies with a checkpoint each give the line.
///
/// # Errors
/// A copy that can't be set up.
pub fn memory(plan: &Plan, threads: usize) -> Result<Memory, JobError> {
    let runs = if side_by_side(plan, threads) { threads.min(plan.tasks().len()) } else { 1 };
    let mut largest: f64 = 0.0;
    let mut particles = 1.0;
    for (index, point) in plan.points.iter().enumerate() {
        // Points differ in numbers, not in kind: the largest decide.
        let count = point.input.particles();
        let known = plan.points[..index].iter().any(|before| before.input.particles() >= count);
        if known {
            continue;
        }
        for run in 0..point.runs.len() {
            let task = Task { point: index, run, replica: 0 };
            let bytes = peak(point, task, count)?;
            if bytes > largest {
                (largest, particles) = (bytes, count as f64);
            }
        }
    }
    Ok(Memory { bytes: largest * runs as f64, per_particle: largest / particles, runs })
}

/// The peak of one run, extrapolated from copies of at most `MEMORY_SAMPLE` particles.
fn peak(point: &PointPlan, task: Task, count: u64) -> Result<f64, JobError> {
    let measure = |most: u64| -> Result<(f64, f64), JobError> {
        let copy = shrunk(point, most);
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let mut prepared = Prepared::new(&copy, task, Workers::One)?;
        advance(&mut prepared, |step| step < 3)?;
        // A checkpoint needs the state twice more.
        let state = state_of(&prepared.simulation, &prepared.recorders);
        let encoded = state.map(|state| state.encode(&copy.input).map(|bytes| mesoflux_io::checkpoint::encode(&bytes)));
        drop(encoded);
        let peak = ALLOCATOR.peak_usage().saturating_sub(before) as f64;
        Ok((copy.input.particles() as f64, peak))
    };
    let (particles, large) = measure(MEMORY_SAMPLE)?;
    // What recorders will hold later, and again for every copy that a checkpoint makes of it.
    let later: u64 = point.users(task.run).map(|user| point.measurements[user].route.grows_to(&point.input)).sum();
    let held = 4.0 * later as f64;
    if particles >= count as f64 {
        return Ok(large + held);
    }
    let (fewer, small) = measure(MEMORY_SAMPLE / 2)?;
    let slope = ((large - small) / (particles - fewer)).max(0.0);
    Ok(large + slope * (count as f64 - particles) + held)
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
    let copy = shrunk(first, TIME_SAMPLE);
    // Particle-steps each second of one run, while all threads are busy.
    let mut rates = Vec::new();
    for kind in 0..first.runs.len() {
        // Routes at several strengths do the same work.
        let name = first.runs[kind].name();
        if let Some(&(_, rate)) = rates.iter().find(|&&(known, _)| known == name) {
            rates.push((name, rate));
            continue;
        }
        let workers = if side_by_side { Workers::One } else { Workers::Pool };
        let timed = |replica: u64| rate(&copy, Task { point: 0, run: kind, replica }, workers);
        let each: Vec<f64> =
            pool.install(|| (0..copies as u64).into_par_iter().map(timed).collect::<Result<_, _>>())?;
        rates.push((name, each.iter().sum::<f64>() / copies as f64));
    }
    let pairs = |point: &PointPlan| point.input.expected_pairs() / point.input.particles() as f64;
    let (mut total, mut longest, mut particle_steps) = (0.0, 0.0f64, 0.0);
    for task in plan.tasks() {
        let point = &plan.points[task.point];
        let work = point.input.particles() as f64 * point.steps() as f64;
        // Another point may have fewer routes than the first.
        let rate = rates.get(task.run).or(rates.first()).map_or(1.0, |&(_, rate)| rate);
        let seconds = work / rate * pairs(point) / pairs(first);
        total += seconds;
        longest = longest.max(seconds);
        particle_steps += work;
    }
    let seconds = (total / copies as f64).max(longest);
    Ok(Duty { seconds, rate: particle_steps / seconds })
}

/// Particle-steps each second of one run.
fn rate(copy: &PointPlan, task: Task, workers: Workers) -> Result<f64, JobError> {
    let mut prepared = Prepared::new(copy, task, workers)?;
    advance(&mut prepared, |step| step < 3)?;
    let start = Instant::now();
    let before = prepared.simulation.system.step;
    advance(&mut prepared, |step| step < before + 2 || start.elapsed() < TIMED)?;
    let steps = prepared.simulation.system.step - before;
    Ok(steps as f64 * copy.input.particles() as f64 / start.elapsed().as_secs_f64())
}

/// Production as long as `more(steps done)` holds.
fn advance(prepared: &mut Prepared, more: impl Fn(u64) -> bool) -> Result<(), JobError> {
    let length = Length { equilibration: 0, production: u64::MAX / 2 };
    let place = prepared.place.clone();
    run(&mut prepared.simulation, length, &mut prepared.recorders, |simulation: &Simulation, _| {
        more(simulation.system.step)
    })
    .map(|_| ())
    .map_err(|source| JobError::Simulation { place, source })
}

/// Whether the runs of a plan fit into the memory that is free.
///
/// # Errors
/// How much they need and how much there is.
pub fn check_memory(plan: &Plan, threads: usize) -> Result<Result<(), TooLarge>, JobError> {
    let particles = plan.points.iter().map(|point| point.input.particles()).max().unwrap_or(0);
    if particles * (threads as u64).min(plan.tasks().len() as u64) < FEW_PARTICLES {
        return Ok(Ok(()));
    }
    let (needed, free) = (memory(plan, threads)?, free_memory());
    if needed.bytes < free {
        return Ok(Ok(()));
    }
    let Memory { bytes, per_particle, runs } = needed;
    Ok(Err(TooLarge { needed: bytes, free, particles, runs, per_particle }))
}

/// Bytes that are free on this machine, or in the part of it that this program may use; infinite where nobody can tell.
pub fn free_memory() -> f64 {
    let Ok(mut system) = sysinfo::System::new() else { return f64::INFINITY };
    system.refresh_memory();
    let free = system.available_memory();
    system.cgroup_limits().map_or(free, |limits| limits.free_memory.min(free)) as f64
}

/// A number of bytes, "1.3 GB".
pub fn size(bytes: f64) -> String {
    let (unit, name) =
        [(1e12, "TB"), (1e9, "GB"), (1e6, "MB")].into_iter().find(|&(unit, _)| bytes >= unit).unwrap_or((1e3, "kB"));
    let number = bytes / unit;
    let decimals = usize::from(number < 9.95);
    format!("{number:.decimals$} {name}")
}

/// The point with at most about so many particles, at the same density and with the same laws.
fn shrunk(point: &PointPlan, most: u64) -> PointPlan {
    let count = point.input.particles();
    let mut input: Input = point.input.clone();
    if count <= most {
        return PointPlan::new(point.conditions.clone(), input);
    }
    let factor = most as f64 / count as f64;
    let side = (input.sides().iter().product::<f64>() * factor).cbrt();
    input.run.skin = Some(point.input.skin());
    input.system.sides = Some([side; 3]);
    input.system.density = None;
    input.system.start = StartInput::CubicLattice;
    input.system.loaded = None;
    // Even numbers, for forcings that come in pairs.
    let fewer = |count: u64| (2.0 * (0.5 * count as f64 * factor).round()).max(2.0) as u64;
    input.molecule.values_mut().for_each(|molecule| molecule.count = fewer(molecule.count));
    input.species.values_mut().for_each(|species| species.particles = species.particles.map(fewer));
    input.system.particles = None;
    if input.species.len() <= 1 {
        input.species.values_mut().for_each(|species| species.particles = None);
        input.system.particles = Some(most);
    }
    PointPlan::new(point.conditions.clone(), input)
}
