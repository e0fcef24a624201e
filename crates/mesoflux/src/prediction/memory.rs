//! How much memory the runs of a job need at a time, and how much there is.

use super::{fill, shrunk, steps};
use crate::job::{JobError, Prepared, side_by_side};
use crate::plan::{Plan, PointPlan, Task};
use crate::store::write_state;
use mesoflux_core::domain::Workers;
use peak_alloc::PeakAlloc;
use std::time::Duration;

/// Counts what the program has allocated, and the most that it had at a time.
#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Particles of the larger of the two copies whose memory is measured.
const SAMPLE: u64 = 20_000;
/// Steps of a copy, by which its lists have been built again and again and have the room that they need.
const STEPS: u64 = 60;
/// Bytes that the program takes beside its runs, most of them its own code: 7.8e6 as released, 10.2e6 as tests build it.
const PROGRAM: f64 = 9.0e6;
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
            // Routes at several strengths hold the same.
            let name = point.runs[run].name();
            if point.runs[..run].iter().any(|before| before.name() == name) {
                continue;
            }
            let task = Task { point: index, run, replica: 0 };
            let bytes = peak(point, task, count)?;
            if bytes > largest {
                (largest, particles) = (bytes, count as f64);
            }
        }
    }
    Ok(Memory { bytes: PROGRAM + largest * runs as f64, per_particle: largest / particles, runs })
}

/// The peak of one run, extrapolated from copies of at most `SAMPLE` particles.
fn peak(point: &PointPlan, task: Task, count: u64) -> Result<f64, JobError> {
    let measure = |most: u64| -> Result<(f64, f64), JobError> {
        let copy = shrunk(point, most);
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let mut prepared = Prepared::new(&copy, task, Workers::One)?;
        steps(&mut prepared, STEPS)?;
        fill(&mut prepared, Duration::MAX);
        let Prepared { simulation, recorders, place } = &prepared;
        write_state(&mut std::io::sink(), &copy.input, simulation, recorders)
            .map_err(|error| JobError::Setup { place: place.clone(), reason: error.to_string() })?;
        let peak = ALLOCATOR.peak_usage().saturating_sub(before) as f64;
        Ok((copy.input.particles() as f64, peak))
    };
    let (particles, large) = measure(SAMPLE)?;
    if particles >= count as f64 {
        return Ok(large);
    }
    let (fewer, small) = measure(SAMPLE / 2)?;
    let slope = ((large - small) / (particles - fewer)).max(0.0);
    Ok(large + slope * (count as f64 - particles))
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
